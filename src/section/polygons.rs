//! Polygons with holes on an integer grid of 0.1 micrometres, and what two of them share: for slicing, and for telling what hangs.
//!
//! Coordinates become integers once, where the plane cuts the mesh: the floating-point interface of `i_overlay` snaps each call's
//! input to a grid of its own, so that one vertex could land on two places. On the grid what lies on what is a question of equal
//! numbers.

use i_overlay::core::fill_rule::FillRule;
use i_overlay::core::overlay::Overlay;
use i_overlay::core::overlay_rule::OverlayRule;
use i_overlay::i_float::int::point::IntPoint;

/// A point of the grid.
pub type GridPoint = IntPoint<i32>;
/// A closed ring; the last point is not the first again.
pub type Contour = Vec<GridPoint>;
/// A counter-clockwise outer ring and its clockwise holes.
pub type Shape = Vec<Contour>;
/// Shapes that do not overlap.
pub type Region = Vec<Shape>;

/// Grid units in one millimetre: the grid reaches 107 m either way.
pub const UNITS_PER_MM: f64 = 10_000.0;

/// Millimetres in grid units, rounded.
pub fn units(mm: f64) -> i32 {
    (mm * UNITS_PER_MM).round() as i32
}

/// What closed contours enclose: where they wind at least once, either way.
pub fn wound(contours: &[Contour]) -> Region {
    Overlay::from_subj(contours).overlay(OverlayRule::Subject, FillRule::NonZero)
}

/// The same, but only where they wind anticlockwise.
pub fn positive(contours: &[Contour]) -> Region {
    Overlay::from_subj(contours).overlay(OverlayRule::Subject, FillRule::Positive)
}

/// `a` without `b`.
pub fn minus(a: &Region, b: &Region) -> Region {
    if a.is_empty() || b.is_empty() {
        return a.clone();
    }
    Overlay::from_subj_and_clip(a, b).overlay(OverlayRule::Difference, FillRule::NonZero)
}

/// What `a` and `b` share.
pub fn and(a: &Region, b: &Region) -> Region {
    if a.is_empty() || b.is_empty() {
        return Region::new();
    }
    Overlay::from_subj_and_clip(a, b).overlay(OverlayRule::Intersect, FillRule::NonZero)
}

/// What lies in `a` or `b`.
pub fn or(a: &Region, b: &Region) -> Region {
    if a.is_empty() || b.is_empty() {
        return if a.is_empty() { b.clone() } else { a.clone() };
    }
    Overlay::from_subj_and_clip(a, b).overlay(OverlayRule::Union, FillRule::NonZero)
}
