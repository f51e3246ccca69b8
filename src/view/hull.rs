//! The faces of a convex body that is known by its corners: for drawing, not for proofs.
//!
//! Incremental: each point beyond a face takes away the faces that it sees and is joined to their rim. Points within a millionth
//! of the body's size of a face count as on it, so corners on a plane give a fan of triangles, some of them thin.

use std::collections::HashSet;

use crate::geom::{Bounds, Vec3};

/// Beyond this many points (a hull from a file) only those that reach farthest along so many directions are joined.
const MOST_POINTS: usize = 400;

/// A body's corners and the triangles between them, counter-clockwise seen from outside.
#[derive(Clone, Debug, PartialEq)]
pub struct Hull {
    /// Corners, mm; some may lie inside.
    pub points: Vec<Vec3>,
    /// Triples of their indices; empty where all lie in one plane.
    pub faces: Vec<[u32; 3]>,
}

struct Face {
    corners: [usize; 3],
    normal: Vec3,
    offset: f64,
}

impl Hull {
    /// The hull of `points`.
    pub fn of(points: &[Vec3]) -> Self {
        let points = if points.len() > MOST_POINTS { outermost(points) } else { points.to_vec() };
        let size = Bounds::of(points.iter().copied()).size().norm().max(1e-9);
        let Some(mut faces) = first(&points, size) else { return Self { points, faces: Vec::new() } };
        for index in 0..points.len() {
            join(&points, index, &mut faces, size * 1e-6);
        }
        let faces = faces.iter().map(|f| f.corners.map(|i| i as u32)).collect();
        Self { points, faces }
    }
}

/// The points that reach farthest along directions spread evenly (a Fibonacci lattice).
fn outermost(points: &[Vec3]) -> Vec<Vec3> {
    let direction = |i: usize| {
        let z = 1.0 - 2.0 * (i as f64 + 0.5) / MOST_POINTS as f64;
        let (s, c) = (i as f64 * 2.399_963_229_728_653).sin_cos();
        let r = (1.0 - z * z).sqrt();
        Vec3::new(r * c, r * s, z)
    };
    let farthest = |d: Vec3| {
        let along = |i: &usize| points[*i].dot(&d);
        (0..points.len()).max_by(|a, b| along(a).total_cmp(&along(b))).unwrap_or_default()
    };
    let mut kept: Vec<usize> = (0..MOST_POINTS).map(|i| farthest(direction(i))).collect();
    kept.sort_unstable();
    kept.dedup();
    kept.into_iter().map(|i| points[i]).collect()
}

fn face(points: &[Vec3], corners: [usize; 3]) -> Face {
    let [a, b, c] = corners.map(|i| points[i]);
    let normal = (b - a).cross(&(c - a));
    let length = normal.norm();
    // A face without an area sees nothing and is seen by nobody.
    let normal = if length > 0.0 { normal / length } else { Vec3::zeros() };
    Face { corners, normal, offset: normal.dot(&a) }
}

/// A tetrahedron of points far from each other; `None` where all lie in a plane.
fn first(points: &[Vec3], size: f64) -> Option<Vec<Face>> {
    let farthest = |measure: &dyn Fn(&Vec3) -> f64| {
        let best = (0..points.len()).max_by(|&i, &j| measure(&points[i]).total_cmp(&measure(&points[j])));
        best.filter(|&i| measure(&points[i]) > size * 1e-6)
    };
    let a = 0;
    let b = farthest(&|p| (p - points[a]).norm())?;
    let along = (points[b] - points[a]).normalize();
    let c = farthest(&|p| (p - points[a]).cross(&along).norm())?;
    let normal = (points[b] - points[a]).cross(&(points[c] - points[a])).normalize();
    let d = farthest(&|p| (p - points[a]).dot(&normal).abs())?;
    let above = (points[d] - points[a]).dot(&normal) > 0.0;
    let [b, c] = if above { [c, b] } else { [b, c] };
    Some([[a, b, c], [a, d, b], [b, d, c], [c, d, a]].map(|corners| face(points, corners)).into())
}

fn join(points: &[Vec3], index: usize, faces: &mut Vec<Face>, slack: f64) {
    let seen = |f: &Face| f.normal.dot(&points[index]) > f.offset + slack;
    let edges: HashSet<(usize, usize)> = faces.iter().filter(|f| seen(f)).flat_map(|f| edges(f.corners)).collect();
    if edges.is_empty() {
        return;
    }
    faces.retain(|f| !seen(f));
    // In a fixed order, or the bytes of a page would change from run to run.
    let mut rim: Vec<_> = edges.iter().filter(|(a, b)| !edges.contains(&(*b, *a))).collect();
    rim.sort_unstable();
    faces.extend(rim.into_iter().map(|&(a, b)| face(points, [a, b, index])));
}

fn edges([a, b, c]: [usize; 3]) -> [(usize, usize); 3] {
    [(a, b), (b, c), (c, a)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Body;

    fn volume(hull: &Hull) -> f64 {
        let corner = |i: u32| hull.points[i as usize] - hull.points[0];
        hull.faces.iter().map(|f| corner(f[0]).dot(&corner(f[1]).cross(&corner(f[2]))) / 6.0).sum()
    }

    /// Every edge is run through once each way, and no corner lies outside.
    fn is_closed_and_convex(hull: &Hull) {
        let all: Vec<_> = hull.faces.iter().flat_map(|f| edges(f.map(|i| i as usize))).collect();
        assert!(all.iter().all(|(a, b)| all.iter().filter(|e| **e == (*b, *a)).count() == 1), "{all:?}");
        for f in &hull.faces {
            let face = face(&hull.points, f.map(|i| i as usize));
            assert!(hull.points.iter().all(|p| face.normal.dot(p) <= face.offset + 1e-3), "{f:?}");
        }
    }

    #[test]
    fn a_box_and_a_round_body_are_whole() {
        let cuboid =
            Hull::of(&Body::cuboid("b", Vec3::new(-1.0, 0.0, 2.0), Vec3::new(1.0, 3.0, 7.0), [true; 3]).points);
        is_closed_and_convex(&cuboid);
        assert!((volume(&cuboid) - 30.0).abs() < 1e-9 && cuboid.faces.len() == 12, "{}", volume(&cuboid));
        // A cone's stump of 32 sides around radii 1 and 6: (a1 + a2 + sqrt(a1 a2)) h / 3.
        let stump = Hull::of(&Body::frustum("f", [0.0, 5.0], [1.0, 6.0], [true; 3]).points);
        is_closed_and_convex(&stump);
        let area = |r: f64| 32.0 * (std::f64::consts::PI / 32.0).tan() * r * r;
        let wanted = (area(1.0) + area(6.0) + (area(1.0) * area(6.0)).sqrt()) * 5.0 / 3.0;
        assert!((volume(&stump) - wanted).abs() < 1e-6 * wanted, "{} for {wanted}", volume(&stump));
    }

    #[test]
    fn inner_points_doubled_points_and_many_points_do_no_harm() {
        let mut random = crate::geom::SplitMix64::seeded(7);
        let ball: Vec<Vec3> =
            (0..3000).map(|_| Vec3::from_fn(|_, _| random.unit() * 2.0 - 1.0)).filter(|p| p.norm() < 1.0).collect();
        let hull = Hull::of(&[&ball[..], &ball[..40]].concat());
        is_closed_and_convex(&hull);
        assert!((3.5..4.19).contains(&volume(&hull)), "{}", volume(&hull));
    }

    #[test]
    fn what_is_flat_has_no_faces() {
        let flat = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[x, y]| Vec3::new(x, y, 3.0));
        assert!(
            Hull::of(&flat).faces.is_empty() && Hull::of(&[]).faces.is_empty() && Hull::of(&flat[..1]).faces.is_empty()
        );
    }
}
