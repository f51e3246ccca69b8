//! Good build directions of one part: objectives on the sphere, and searches over them.
//!
//! A direction `d` is the unit vector that points up while printing, in the frame of the part's mesh. An
//! [`Objective`] says how bad `d` is, a [`Search`] finds its minima; [`directions`] gathers what a planner should try:
//! the minima, the facets' normals and the directions at right angles to two of them, where such functions have their
//! kinks.
//!
//! The direction along which a brick is lowest:
//!
//! ```
//! use trunnion::geom::{Bounds, Vec3};
//! use trunnion::mesh::TriangleMesh;
//! use trunnion::orient::{Facets, ObjectiveSettings, method, minima, objective};
//!
//! // A brick of 10 x 20 x 30 mm, in the frame of its mesh.
//! let brick: TriangleMesh = TriangleMesh::cuboid(&Bounds { min: Vec3::zeros(), max: Vec3::new(10.0, 20.0, 30.0) });
//! let facets = Facets::of(&brick);
//!
//! let height = objective("height", &ObjectiveSettings::default())?;
//! let search = method("certified", height.as_ref(), None, 1).ok_or("no such search")?;
//! let found = minima(&facets, height.as_ref(), search.as_ref(), None);
//! // It is lowest lying on its largest side: X points up or down, and it is 10 mm high. No direction is better, proved.
//! let best = &found.minima[0];
//! assert!((best.value - 10.0).abs() < 1e-3 && best.up.x.abs() > 0.9999);
//! assert!(found.lower_bound.is_some_and(|bound| best.value - bound < 0.1));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # What of the documents' numbers cannot be reproduced, and why
//!
//! - de Castro (2020), table 4.2.1: two of the printed minima are in another frame than the file's, (-x, z, y) for one part, (x,
//!   -z, y) for another, and some take the lowest point over each facet's first corner only. Here: the file's frame, all
//!   corners. The bunny's stops on a kink 0.1 % above the minimum. The 32 starts have a slip
//!   ([`Starts::GridCentres`]). The minima of equation 3.1.2 come from a grid of 4 degrees by their angles (the text says 1), with the sign of beta reversed.
//! - Puri (2019): the text lacks the division by ten that its code has ([`TanhOverhang`]). Its cut cylinder, 0.12232 at (-2.618,
//!   0), is 0.12323 at 150 degrees sharp by the paper's own formula in double precision as well: the minimum is a kink where
//!   the cut lies flat, 0.00006 degrees beside, since the file's corners are in single precision, and f rises by 0.0009
//!   over that angle. The three decimals of -2.618 alone are worth 0.006.
//! - Boogers (2024): its program pairs weights with the wrong facets, and its optimum is not global ([`Supported`]).
//! - Ramos et al. (2021), section 6.1: values and numbers of minima depend on parts that are not published; the directions agree.
//!
//! This room must not know machines or sequences.

mod bound;
mod certified;
mod column;
mod dips;
mod direct;
mod directions;
mod enough;
mod evolution;
mod facets;
mod gradient;
mod grid;
mod hyperbolic;
mod methods;
mod mmls;
mod multistart;
mod names;
mod nelder_mead;
mod normals;
mod objective;
mod printable;
mod sight;
mod sphere;
#[cfg(test)]
mod tests;
mod ties;
mod trial;
mod volumes;
mod weighted;

pub use bound::{Cap, Local, Minorant, lower};
pub use certified::Certified;
pub use column::{BOUNDED_FACETS, SupportVolumeColumn, support_columns};
pub use dips::{laid, overhang_area, turned};
pub use direct::Direct;
pub use directions::{Direction, directions};
pub use enough::proved_standing;
pub use evolution::DifferentialEvolution;
pub use facets::{Facet, Facets, Mass, Normals};
pub use gradient::{Descent, GradientMethod};
pub use grid::GridSearch;
pub use methods::{METHODS, method, minima};
pub use mmls::Mmls;
pub use multistart::{Multistart, Starts};
pub use names::{BadObjective, OBJECTIVES, ObjectiveSettings, named, nearest, objective};
pub use nelder_mead::NelderMead;
pub use normals::{NormalZ, OverhangAngle};
pub use objective::{Height, Objective, Proof, Staircase, SupportArea};
pub use printable::{
    FirstLayer, Laid, PRINTABLE, PoseRole, Priced, Printable, Process, Recommendation, Runner, STANDS_DEG, Supports,
    recommend,
};
pub use sight::{Alexander, Cost, FIELD_FACETS, Smoothing, Supported};
pub use sphere::{from_angles, to_angles};
pub use ties::{StandingMinima, Tried, standing, without_ties};
pub use volumes::{ContactArea, SupportVolumeConvex, TanhOverhang, WeightedNormalZ};
pub use weighted::WeightedSum;

use crate::geom::Vec3;

/// A local minimum that a search found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Minimum {
    /// The build direction, unit.
    pub up: Vec3,
    /// The objective there.
    pub value: f64,
    /// Whether its search came to rest there and nothing beside it is lower; `false` where the budget ended it on its way down, or it got stuck.
    pub ended: bool,
}

/// What a search answers with.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// Distinct minima, best first.
    pub minima: Vec<Minimum>,
    /// How often the objective was evaluated.
    pub evaluations: usize,
    /// No direction has a lower value, proved; `None` where the search proves nothing.
    pub lower_bound: Option<f64>,
    /// Why it ended.
    pub stop: Stop,
    /// The best value so far, whenever it became better.
    pub history: Vec<Improvement>,
}

/// A new best value of a search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Improvement {
    /// Evaluations until then, this one included.
    pub evaluations: usize,
    /// The value.
    pub value: f64,
}

/// Why a search ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stop {
    /// Its steps, or the gap to its lower bound, became as small as it asks for.
    Converged,
    /// Its evaluations were used up.
    Budget,
}

/// Minima nearer than this (radians, half a degree) are one.
const SAME_MINIMUM: f64 = 0.0087;

/// `minima` best first, without those that lie beside a better one.
fn distinct(mut minima: Vec<Minimum>) -> Vec<Minimum> {
    minima.sort_by(|a, b| a.value.total_cmp(&b.value));
    let mut kept: Vec<Minimum> = Vec::new();
    for minimum in minima {
        if kept.iter().all(|k| (k.up - minimum.up).norm() > SAME_MINIMUM) {
            kept.push(minimum);
        }
    }
    kept
}

/// Finds minima of an objective over all directions.
pub trait Search: Sync {
    /// The `--method` name.
    fn name(&self) -> &'static str;

    /// Minima of `objective` for the part with `facets`; the same for the same input, whatever the machine.
    fn search(&self, objective: &dyn Objective, facets: &Facets) -> Found;
}
