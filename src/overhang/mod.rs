//! What a part printed layer by layer would lay on nothing: one rule for whoever plans, cuts or verifies.
//!
//! ```text
//! facets steeper than the threshold, lowest places, ridges   relief.rs    fast; nothing of these means nothing hangs
//!   ridges also where facets without area lie between         slivers.rs
//! layer i less layer i-1 grown by h tan(threshold) + w/2     layers.rs    what a layer may reach, the half line only once
//!   less bridges: chords of at most bridge_mm between ends   chords.rs
//!   on what is below, and less patches of at most tolerate_mm2
//! ```
//!
//! `h` is the layer height, `w` the width of a line. A line's middle lies half a width inside the outline, so that within half a
//! width beyond what is below most of the line still rests on it; `h tan` is what the threshold itself allows.
//! Source of the rule by layers: what slicers call an overhang (PrusaSlicer's supports compare a layer with the grown one below).
//!
//! Lengths mm, areas mm², angles from the vertical: a wall is 0, a ceiling 90. This room must not know machines or plans.

mod chords;
mod layers;
mod region;
mod relief;
mod slivers;

pub use layers::{Cause, Footing, Ground, Held, Patch, unsupported};
pub use relief::{Hang, LOOKS_DOWN, Relief, Ridge, SAME_HEIGHT_MM};
pub(crate) use slivers::THIN_MM;

use crate::geom::Angle;

/// What may hang free at one end of a line, mm, or two line widths if that is more: strings of this length stay up.
pub const FREE_SPAN_MM: f64 = 2.0;

/// What a patch may have that nothing carries, mm², where nobody says otherwise. A line that hangs where verification sees it is
/// longer than [`FREE_SPAN_MM`], and lies more than half of its width beyond what a layer may reach: it takes more than this.
pub const TOLERATE_MM2: f64 = 1.0;

/// What is let pass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rule {
    /// Surfaces up to this angle from the vertical need no support.
    pub overhang: Angle,
    /// Layer height, mm.
    pub layer_mm: f64,
    /// Width of a line, mm.
    pub line_mm: f64,
    /// What a line may span between two ends on material, mm.
    pub bridge_mm: f64,
    /// What a connected patch may have that nothing carries, mm².
    pub tolerate_mm2: f64,
}

impl Rule {
    /// So far a layer may reach beyond the one below, mm; infinite where everything may overhang.
    pub fn reach_mm(&self) -> f64 {
        if self.overhang.deg() >= 89.0 {
            return f64::INFINITY;
        }
        self.layer_mm * self.overhang.rad().tan() + self.line_mm / 2.0
    }

    /// So far a line may hang free, mm.
    pub fn free_mm(&self) -> f64 {
        FREE_SPAN_MM.max(2.0 * self.line_mm)
    }
}
