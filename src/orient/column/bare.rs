//! Which facets are bare: wholly on the outside of all material, so that a column which meets one enters the part there.
//!
//! A part may be several closed shells that overlap, or one that crosses itself; of a facet inside another shell no column
//! volume begins. What cannot be told is not bare.

use super::super::Facets;
use crate::geom::{Bounds, Vec3};

/// Distances are zero up to this, of the part's size.
const SLACK: f64 = 1e-9;

/// For each facet whether it is bare.
pub(super) fn bare(facets: &Facets) -> Vec<bool> {
    let size = Bounds::of(facets.points.iter().copied()).size().norm();
    let slack = SLACK * size;
    (0..facets.corners.len()).map(|i| !is_crossed(facets, i, slack) && is_outside(facets, i, size)).collect()
}

fn corners(facets: &Facets, i: usize) -> [Vec3; 3] {
    facets.corners[i].map(|k| facets.points[k as usize])
}

/// Whether a facet that is no neighbour touches or crosses facet `i`, or a neighbour lies folded upon it.
fn is_crossed(facets: &Facets, i: usize, slack: f64) -> bool {
    let own = corners(facets, i);
    let bounds = Bounds::of(own).inflated(slack);
    let mut crossed = false;
    facets.tree().within(&bounds, &mut |k| {
        let shared = facets.corners[k as usize].iter().filter(|c| facets.corners[i].contains(c)).count();
        crossed |= match shared {
            0 => !are_apart(&own, &corners(facets, k as usize), slack),
            _ => k as usize != i && is_folded(facets, i, k as usize),
        };
        !crossed
    });
    crossed
}

/// Whether two neighbours lie on each other, face against face or back on back.
fn is_folded(facets: &Facets, i: usize, k: usize) -> bool {
    let [m, n] = [i, k].map(|i| facets.each[i].area.normalize());
    m.dot(&n) < -1.0 + 1e-9 || facets.corners[i].iter().all(|c| facets.corners[k].contains(c))
}

/// Whether some plane parts two triangles, by the axes that decide it for convex bodies: the normals, the edges of one across
/// those of the other, and in the planes across the edges.
fn are_apart(a: &[Vec3; 3], b: &[Vec3; 3], slack: f64) -> bool {
    let edges = |t: &[Vec3; 3]| [t[1] - t[0], t[2] - t[1], t[0] - t[2]];
    let (ea, eb) = (edges(a), edges(b));
    let (na, nb) = (ea[0].cross(&ea[1]), eb[0].cross(&eb[1]));
    let across = ea.iter().flat_map(|e| eb.iter().map(move |f| e.cross(f)));
    let in_planes = ea.iter().map(|e| na.cross(e)).chain(eb.iter().map(|e| nb.cross(e)));
    [na, nb].into_iter().chain(across).chain(in_planes).any(|axis| {
        let length = axis.norm();
        let span = |t: &[Vec3; 3]| {
            let [p, q, r] = t.map(|v| v.dot(&axis));
            [p.min(q).min(r), p.max(q).max(r)]
        };
        let ([a0, a1], [b0, b1]) = (span(a), span(b));
        length > 0.0 && (a0 - b1).max(b0 - a1) > slack * length
    })
}

/// Whether no material lies before the facet's middle: as many shells are left as are entered on the way out, by two rays.
///
/// The facet is crossed by no other, so what holds of its middle holds of all of it.
fn is_outside(facets: &Facets, i: usize, size: f64) -> bool {
    let facet = &facets.each[i];
    let n = facet.area.normalize();
    let aside = super::super::sphere::tangents(&n)[0];
    [n + aside * 0.0123, n - aside * 0.0217].iter().all(|along| {
        let mut depth = 0i32;
        facets.tree().visit(&facet.barycentre, along, 4.0 * size, &mut |t, k| {
            if t > 0.0 && k as usize != i {
                depth += if facets.each[k as usize].area.dot(along) > 0.0 { 1 } else { -1 };
            }
            4.0 * size
        });
        depth == 0
    })
}

#[cfg(test)]
mod tests {
    use super::super::tests::boxes;
    use super::*;

    fn count(all: &[([f64; 3], [f64; 3])]) -> usize {
        bare(&boxes(all)).into_iter().filter(|b| *b).count()
    }

    #[test]
    fn a_facet_is_bare_outside_of_all_shells_alone() {
        let one = ([0.0; 3], [30.0; 3]);
        assert_eq!(count(&[one]), 12);
        assert_eq!(count(&[one, ([40.0, 0.0, 0.0], [50.0, 10.0, 10.0])]), 24, "apart");
        assert_eq!(count(&[one, ([10.0; 3], [16.0; 3])]), 12, "the inner box is not");
        assert_eq!(count(&[one, one]), 0, "each lies on the other");
        // A bar through two walls: its own walls are crossed, its ends are bare; of the box the two walls with holes are not.
        assert_eq!(count(&[one, ([-10.0, 10.0, 10.0], [40.0, 20.0, 20.0])]), 8 + 4);
        // Standing on the box: the box's top is touched, and of the other all but its own top.
        assert_eq!(count(&[one, ([10.0, 10.0, 30.0], [20.0, 20.0, 40.0])]), 10 + 2);
    }

    #[test]
    fn triangles_are_apart_until_they_touch() {
        let t = |p: [[f64; 3]; 3]| p.map(|[x, y, z]| Vec3::new(x, y, z));
        let flat = t([[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]]);
        let through = t([[1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [5.0, 5.0, 0.0]]);
        let beside = t([[2.1, 2.1, -1.0], [2.1, 2.1, 1.0], [5.0, 5.0, 0.0]]);
        let level = t([[3.0, 3.0, 0.0], [9.0, 3.0, 0.0], [3.0, 9.0, 0.0]]);
        assert!(!are_apart(&flat, &through, 1e-9) && are_apart(&flat, &beside, 1e-9) && are_apart(&flat, &level, 1e-9));
        assert!(!are_apart(&flat, &level.map(|v| v - Vec3::new(2.0, 2.0, 0.0)), 1e-9));
    }
}
