//! `printable`: the pose that a person would choose, priced in grams and minutes.
//!
//! The price of a pose, minutes ([`Process::price`]):
//!
//! ```text
//! part        walls and infill at the process's speeds; changes of layer by the height
//! supports    true columns from the bed or from the part, weighed by their density
//! filament    a minute a gram
//! scar        breaking supports off and smoothing what they touched
//! steps       sum A |d.n| of what does not lie flat, by the layer height
//! risk        the odds that the print comes loose, times all that is then lost: by the angle by which the part may be tipped on the
//!             footprint of its first layer (alone, and held by its supports), and by what lies on the bed
//! ```
//!
//! The last three weigh what has no market price; their rates are named constants (`process.rs`, `price.rs`). What is proved: no pose
//! costs less than the part itself at the least height ([`Recommendation::at_least_min`]); supports, steps and risk are taken as
//! nothing there, so the bound is loose. That the recommended pose is the best is not proved: it is the best of those looked at.

mod candidates;
mod coarse;
mod footing;
mod price;
mod process;
mod resting;
mod search;
mod supports;

pub use footing::FirstLayer;
pub(super) use footing::share_below;
pub use price::{Priced, STANDS_DEG};
pub use process::{Laid, Process};
pub use search::{PoseRole, Recommendation, Runner, recommend};
pub use supports::Supports;

use super::{Facets, Objective, Proof};
use crate::geom::Vec3;

/// Columns along the part's diagonal for a first look, and for the figures that are told.
const ROUGH: f64 = 80.0;
const FINE: f64 = 500.0;

/// The price as an objective for any search: supports by columns of an eightieth of the part's diagonal.
#[derive(Clone, Copy, Debug, Default)]
pub struct Printable {
    /// How it would be printed.
    pub process: Process,
}

/// The price's name.
pub const PRINTABLE: &str = "printable";

impl Objective for Printable {
    fn name(&self) -> &str {
        PRINTABLE
    }

    fn value(&self, facets: &Facets, up: &Vec3) -> f64 {
        self.process.roughly(facets, up).price_min
    }

    fn gradient(&self, _: &Facets, _: &Vec3) -> Option<Vec3> {
        None
    }

    fn needs_closed(&self) -> bool {
        true
    }

    /// An evaluation takes a millisecond and more.
    fn proof(&self) -> Proof {
        Proof::ROUGH
    }

    fn unproved(&self, _: &Facets) -> Option<String> {
        Some("supports, steps and risk have no bound in this version".to_owned())
    }
}

/// The directions in which the part lies on its own planes: it rests there, or the plane is one of its largest faces, laid down or
/// turned up.
pub(super) fn planes(facets: &Facets) -> Vec<Vec3> {
    let mut all = resting::flats(facets, FACES);
    resting::resting(facets, facets.mass()).into_iter().for_each(|up| resting::push(&mut all, up));
    all
}

/// Flat faces that are laid down and turned up.
const FACES: usize = 16;

/// The width of `count` columns along the part's diagonal, mm; a part without size has columns of 1 mm.
fn columns(facets: &Facets, count: f64) -> f64 {
    let diagonal = 2.0 * facets.reach();
    if diagonal > 0.0 { diagonal / count } else { 1.0 }
}
