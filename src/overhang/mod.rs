//! What a part printed layer by layer would lay on nothing: one rule for whoever plans, cuts or verifies.
//!
//! ```text
//! facets steeper than the threshold, lowest places, ridges   relief.rs    fast; nothing of these means nothing hangs
//!   ridges also where facets without area lie between         slivers.rs
//! layer i on those below: fine, droops, or hangs              layers.rs    cut as they are asked for
//!   one layer                                                  step.rs
//!   bridges: chords between ends on what is below              chords.rs
//!   layers that droop in a row                                 memory.rs
//!   layers that were judged before                             answers.rs
//!   pieces of layers, put together                             patch.rs
//!   what the part stands on                                    ground.rs
//! what a slicer lays nothing of, though something wider follows keels.rs     for whoever holds it
//! ```
//!
//! A plate on a stem, and what of it is printed in mid-air:
//!
//! ```
//! use trunnion::geom::{Bounds, Vec3};
//! use trunnion::mesh::TriangleMesh;
//! use trunnion::overhang::{BRIDGE_MM, Cause, Ground, OverhangRule, TOLERATE_MM2, unsupported};
//!
//! let cuboid =
//!     |min: [f64; 3], max: [f64; 3]| TriangleMesh::<()>::cuboid(&Bounds { min: min.into(), max: max.into() });
//! // A plate of 20 x 20 mm on a stem of 4 x 4 mm, printed along its own +Z.
//! let stem = cuboid([8.0, 8.0, 0.0], [12.0, 12.0, 10.0]);
//! let mushroom = TriangleMesh::joined([&stem, &cuboid([0.0, 0.0, 10.0], [20.0, 20.0, 12.0])]);
//!
//! let (layer_mm, line_mm, bridge_mm, tolerate_mm2) = (0.2, 0.45, BRIDGE_MM, TOLERATE_MM2);
//! let overhang = OverhangRule::practised(layer_mm, line_mm);
//! let rule = OverhangRule { overhang, layer_mm, line_mm, bridge_mm, tolerate_mm2, droops: true };
//! let table = Ground { table: true, ..Ground::default() };
//! let stands = |facet: usize| mushroom.corners(facet).iter().all(|corner| corner.z == 0.0);
//! let hangs = unsupported(&mushroom, &Vec3::z(), &table, stands, &rule, false);
//! // The plate's underside is a ceiling that the stem supports in its middle only. Within a line of the stem it is fine.
//! assert!(hangs.len() == 1 && matches!(hangs[0].cause, Cause::Ceiling { .. }));
//! assert!((hangs[0].area_mm2 - (20.0 * 20.0 - 4.0 * 4.0)).abs() < 4.0 * (4.0 + line_mm) * line_mm);
//! ```
//!
//! `h` is the layer height, `w` the width of a line. A line's middle lies half a width inside the outline, so that most of a line
//! that goes out by no more than 0.8 w still rests on the one below: that is fine without end. What goes out farther is printed
//! everywhere, for a few layers in a row, and droops.
//! Sources: PrusaSlicer's stability analysis (0.8 and 1.2 w, its memory) and what it says of 388 shapes, OrcaSlicer (bridges of 10 mm);
//! `docs/explanation/deciding.md` has the table.
//!
//! Lengths mm, areas mm², angles from the vertical: a wall is 0, a ceiling 90. This room must not know machines or plans.

mod answers;
mod chords;
mod ground;
mod keels;
mod layers;
mod memory;
mod patch;
mod region;
mod relief;
mod slivers;
mod step;

pub use ground::{Footing, Ground, SupportLines};
pub use keels::{Keels, laid_of};
pub use layers::{LayerJudge, judged, unsupported};
pub use memory::{FREE_RIM_MM, FREE_SIDE_MM};
pub use patch::{Cause, Droop, HangingBox, Judged, Patch};
pub use relief::{Hang, LOOKS_DOWN, Relief, Ridge, SAME_HEIGHT_MM};
pub use step::{FINE_BRIDGE_MM, LEDGE_MM, SMALL_LEDGE_MM, SMALL_MM2};

use crate::geom::Angle;

/// What may hang free at one end of a line, mm, or two line widths if that is more: strings of this length stay up.
pub const FREE_SPAN_MM: f64 = 2.0;

/// What a patch may have that nothing carries, mm², where nobody says otherwise. A line that hangs where verification sees it is
/// longer than [`FREE_SPAN_MM`], and lies more than half of its width beyond what a layer may reach: it takes more than this.
pub const TOLERATE_MM2: f64 = 1.0;

/// What a line may span between two ends on material, mm, where nobody says otherwise: PrusaSlicer 2.9 is silent up to 14 mm and warns
/// from 15 on. From [`FINE_BRIDGE_MM`] on it sags.
pub const BRIDGE_MM: f64 = 14.0;

/// What is narrower, in line widths, is not laid by every slicer: the built-in one leaves it out, others lay a little less.
pub const NARROWEST_LINES: f64 = 2.0 / 3.0;

/// A step of so many line widths is fine without end.
const FINE_WIDTHS: f64 = 0.8;

/// What is let pass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OverhangRule {
    /// Slopes up to this angle from the vertical are fine, without end; see [`OverhangRule::practised`].
    pub overhang: Angle,
    /// Layer height, mm.
    pub layer_mm: f64,
    /// Width of a line, mm.
    pub line_mm: f64,
    /// What a line may span between two ends on material, mm.
    pub bridge_mm: f64,
    /// What a connected patch may have that nothing carries, mm².
    pub tolerate_mm2: f64,
    /// Whether what droops is let pass; else it hangs.
    pub droops: bool,
}

impl OverhangRule {
    /// What grows beside a part holds it from so many layers below, at most: two of air, and half a layer that a middle lies higher.
    pub const OTHERS_LAYERS: f64 = 2.5;

    /// The steepest slope that is fine without end in layers of `layer_mm` and lines of `line_mm`.
    pub fn practised(layer_mm: f64, line_mm: f64) -> Angle {
        Angle::from_rad((FINE_WIDTHS * line_mm / layer_mm).atan())
    }

    /// So far a layer may go beyond the one below without end, mm; infinite where everything may overhang.
    pub fn fine_mm(&self) -> f64 {
        if self.overhang.deg() >= 89.0 {
            return f64::INFINITY;
        }
        self.layer_mm * self.overhang.rad().tan()
    }

    /// How far its lines hang.
    pub fn hang(&self) -> Hang {
        Hang { layer_mm: self.layer_mm, span_mm: self.free_mm(), bridge_mm: self.bridge_mm }
    }

    /// So far a line may hang free, mm.
    pub fn free_mm(&self) -> f64 {
        FREE_SPAN_MM.max(2.0 * self.line_mm)
    }
}
