//! Whether the surfaces of two parts pass through each other.

use super::Part;
use super::box_tree::BoxTree;
use super::winding::winding;
use crate::geom::{Bounds, Vec3};

/// Nearer than this to a plane is in it, mm: more than the rounding of `f32` coordinates.
const IN_PLANE_MM: f64 = 1e-4;

/// Whether two parts may fill the same space: a side of one passes through a facet of the other, or one may lie in the other.
///
/// Of two that `touch` in a face, sides that pass a facet's very rim do not count: those of the smaller face do, all around the
/// larger one's. Otherwise they do, and `false` is proved, but for what is thinner than 0.0001 mm.
///
/// `tree` is the second one's.
pub fn may_overlap(a: &Part, b: &Part, tree: &BoxTree, touch: bool) -> bool {
    let bounds = [a.mesh.bounds(), b.mesh.bounds()];
    if !bounds[0].meets(&bounds[1]) {
        return false;
    }
    let rim_mm = if touch { IN_PLANE_MM } else { -IN_PLANE_MM };
    let mut near = Vec::new();
    for facet in 0..a.mesh.facets().len() {
        let own = a.mesh.corners(facet);
        if !Bounds::of(own).meets(&bounds[1]) {
            continue;
        }
        near.clear();
        tree.visit(&Bounds::of(own), |other| near.push(other));
        let passes = |&other: &usize| {
            let theirs = b.mesh.corners(other);
            pierces(&own, &theirs, rim_mm) || pierces(&theirs, &own, rim_mm)
        };
        if near.iter().any(passes) {
            return true;
        }
    }
    let within = |inner: &Bounds, outer: &Bounds| {
        let outer = outer.inflated(IN_PLANE_MM);
        outer.holds(&inner.min) && outer.holds(&inner.max)
    };
    (within(&bounds[0], &bounds[1]) && inside(a, b)) || (within(&bounds[1], &bounds[0]) && inside(b, a))
}

/// Whether a part whose surface does not pass through another's lies in it: one of its corners says so, or none can tell.
fn inside(part: &Part, other: &Part) -> bool {
    let times = |at: &Vec3| winding(other.mesh.vertices(), other.mesh.facets(), at);
    part.mesh.vertices().iter().find_map(times).is_none_or(|times| times > 0.5)
}

/// Whether a side of the first triangle passes through the second one, at least `rim_mm` inside its rim.
fn pierces(sides: &[Vec3; 3], through: &[Vec3; 3], rim_mm: f64) -> bool {
    let [a, b, c] = through;
    let across = (b - a).cross(&(c - a));
    let above = sides.map(|p| (p - a).dot(&across));
    if above.iter().all(|v| *v >= 0.0) || above.iter().all(|v| *v <= 0.0) {
        return false;
    }
    let Some(normal) = across.try_normalize(0.0) else { return false };
    let above = sides.map(|p| (p - a).dot(&normal));
    (0..3).any(|k| {
        let (from, to) = (above[k], above[(k + 1) % 3]);
        if from.min(to) > -IN_PLANE_MM || from.max(to) < IN_PLANE_MM {
            return false;
        }
        let at = sides[k] + (sides[(k + 1) % 3] - sides[k]) * (from / (from - to));
        let beside = |p: &Vec3, q: &Vec3| normal.cross(&(q - p)).dot(&(at - p)) / (q - p).norm().max(f64::MIN_POSITIVE);
        [(a, b), (b, c), (c, a)].iter().all(|(p, q)| beside(p, q) >= rim_mm)
    })
}
