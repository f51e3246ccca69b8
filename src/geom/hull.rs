//! The faces of a convex body that is known by its corners, mm, in whatever frame the corners are in.
//!
//! The faces are a closed convex surface for any points, but may leave one out by a millionth of the body's size, since points that lie
//! beyond a face by less are not joined. Whoever needs a proof asks the points ([`Hull::pruned`] keeps every one that sticks out) or
//! [`Hull::planes`], which are pushed out to the farthest point. How they are found: [`GrowingHull`].

use super::convex::support;
use super::growing_hull::GrowingHull;
use super::{Bounds, Vec3};

/// Rounding of a point's distance from a plane, of the body's size.
const ROUNDING: f64 = 1e-12;

/// A body's corners and the triangles between them, counter-clockwise seen from outside.
#[derive(Clone, Debug, PartialEq)]
pub struct Hull {
    /// Corners, mm; some may lie inside.
    pub points: Vec<Vec3>,
    /// Triples of their indices; empty where all lie in one plane.
    pub faces: Vec<[u32; 3]>,
}

impl Hull {
    /// The hull of `points`, all of which it keeps; the time is `O(points x faces)`.
    pub fn of(points: &[Vec3]) -> Self {
        let mut growing = GrowingHull::within(&Bounds::of(points.iter().copied()));
        growing.add(points);
        Self { faces: growing.faces(), points: growing.points().to_vec() }
    }

    /// The same without the points that lie within: what is kept are the faces' corners, and what sticks out of a face by more than
    /// rounding, so that the points' hull is the same one. A flat hull stays as it is.
    pub fn pruned(&self) -> Self {
        if self.faces.is_empty() {
            return self.clone();
        }
        let size = Bounds::of(self.points.iter().copied()).size().norm();
        let faces: Vec<(Vec3, f64)> = self.faces.iter().filter_map(|f| self.plane(f)).collect();
        let mut places = vec![u32::MAX; self.points.len()];
        self.faces.iter().flatten().for_each(|&i| places[i as usize] = 0);
        let mut points = Vec::new();
        for (point, place) in self.points.iter().zip(&mut places) {
            if *place == 0 || faces.iter().any(|(n, d)| n.dot(point) - d > size * ROUNDING) {
                *place = points.len() as u32;
                points.push(*point);
            }
        }
        let faces = self.faces.iter().map(|f| f.map(|i| places[i as usize])).collect();
        Self { points, faces }
    }

    /// The faces' planes as outward unit normals `n` and offsets `d`, mm: every point has `n . p <= d`. None where the hull is flat.
    pub fn planes(&self) -> Vec<(Vec3, f64)> {
        let plane = |f: &[u32; 3]| self.plane(f).map(|(normal, _)| (normal, self.support(&normal).dot(&normal)));
        self.faces.iter().filter_map(plane).collect()
    }

    /// A face's own plane.
    fn plane(&self, face: &[u32; 3]) -> Option<(Vec3, f64)> {
        let [a, b, c] = face.map(|i| self.points[i as usize]);
        let normal = (b - a).cross(&(c - a)).try_normalize(0.0)?;
        Some((normal, normal.dot(&a)))
    }

    /// The point farthest along `direction`; the origin for a hull of nothing.
    pub fn support(&self, direction: &Vec3) -> Vec3 {
        support(&self.points, direction)
    }

    /// What the faces enclose, mm³; 0 where the hull is flat.
    pub fn volume(&self) -> f64 {
        let corner = |i: u32| self.points[i as usize] - self.points[0];
        self.faces.iter().map(|f| corner(f[0]).dot(&corner(f[1]).cross(&corner(f[2]))) / 6.0).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::growing_hull::SLACK;
    use crate::geom::{Body, SplitMix64};

    /// Every edge is run through once each way, and no corner lies outside.
    fn is_closed_and_convex(hull: &Hull) {
        let all: Vec<_> = hull.faces.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]).collect();
        assert!(all.iter().all(|(a, b)| all.iter().filter(|e| **e == (*b, *a)).count() == 1));
        assert!(all.iter().all(|one| all.iter().filter(|e| *e == one).count() == 1));
        let size = Bounds::of(hull.points.iter().copied()).size().norm();
        for f in &hull.faces {
            let (normal, offset) = hull.plane(f).unwrap();
            assert!(hull.points.iter().all(|p| normal.dot(p) - offset <= 3.0 * SLACK * size), "{f:?}");
        }
    }

    fn ball(count: usize, seed: u64) -> Vec<Vec3> {
        let mut random = SplitMix64::seeded(seed);
        (0..count).map(|_| Vec3::from_fn(|_, _| random.unit() * 2.0 - 1.0)).filter(|p| p.norm() < 1.0).collect()
    }

    #[test]
    fn a_box_and_a_round_body_are_whole() {
        let cuboid =
            Hull::of(&Body::cuboid("b", Vec3::new(-1.0, 0.0, 2.0), Vec3::new(1.0, 3.0, 7.0), [true; 3]).points);
        is_closed_and_convex(&cuboid);
        assert!((cuboid.volume() - 30.0).abs() < 1e-9 && cuboid.faces.len() == 12, "{}", cuboid.volume());
        // A cone's stump of 32 sides around radii 1 and 6: (a1 + a2 + sqrt(a1 a2)) h / 3.
        let stump = Hull::of(&Body::frustum("f", [0.0, 5.0], [1.0, 6.0], [true; 3]).points);
        is_closed_and_convex(&stump);
        let area = |r: f64| 32.0 * (std::f64::consts::PI / 32.0).tan() * r * r;
        let wanted = (area(1.0) + area(6.0) + (area(1.0) * area(6.0)).sqrt()) * 5.0 / 3.0;
        assert!((stump.volume() - wanted).abs() < 1e-6 * wanted, "{} for {wanted}", stump.volume());
    }

    #[test]
    fn inner_points_and_doubled_points_do_no_harm_and_are_pruned() {
        let ball = ball(1500, 7);
        let hull = Hull::of(&[&ball[..], &ball[..40]].concat());
        is_closed_and_convex(&hull);
        assert!((3.0..4.19).contains(&hull.volume()), "{}", hull.volume());
        let pruned = hull.pruned();
        is_closed_and_convex(&pruned);
        assert!(pruned.points.len() < hull.points.len() / 2 && (pruned.volume() - hull.volume()).abs() < 1e-9);
        let mut random = SplitMix64::seeded(1);
        for _ in 0..1000 {
            let along = random.direction();
            let [short, long] = [&pruned, &hull].map(|h| h.support(&along).dot(&along));
            assert!((short - long).abs() < 1e-11, "{short} {long}");
        }
    }

    /// Points on a sphere, some upon or within a hair of each other, with many more on the edges and faces of a cube.
    #[test]
    fn corners_that_nearly_coincide_or_lie_in_a_plane_leave_a_whole_hull() {
        let mut random = SplitMix64::seeded(3);
        for noise in [0.0, 1e-13, 1e-9, 1e-7, 5e-7, 1e-6, 2e-6, 4e-6, 1e-5, 3e-5, 1e-3] {
            let mut points: Vec<Vec3> = Vec::new();
            for _ in 0..120 {
                let p = random.direction() * 8.0;
                points.extend([p, p + random.direction() * noise * 10.0]);
                let mut q = Vec3::from_fn(|_, _| (random.unit() * 4.0).round() * 3.0 - 6.0);
                q[random.below(3)] = 6.0;
                points.push(q + random.direction() * noise * 10.0);
            }
            let hull = Hull::of(&points);
            is_closed_and_convex(&hull);
            is_closed_and_convex(&hull.pruned());
            let size = Bounds::of(points.iter().copied()).size().norm();
            for (normal, offset) in hull.pruned().planes() {
                let reach = support(&points, &normal).dot(&normal);
                assert!((offset - reach).abs() < 1e-10, "{noise}");
                let least = hull.faces.iter().map(|f| {
                    let [a, b, c] = f.map(|i| normal.dot(&hull.points[i as usize]));
                    (reach - a.min(b).min(c)).abs()
                });
                assert!(least.fold(f64::INFINITY, f64::min) < 3.0 * SLACK * size, "{noise}");
            }
        }
    }

    #[test]
    fn what_is_flat_has_no_faces() {
        let flat = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[x, y]| Vec3::new(x, y, 3.0));
        for points in [&flat[..], &flat[..1], &flat[..2], &[], &[flat[0]; 5]] {
            let hull = Hull::of(points);
            assert!(hull.faces.is_empty() && hull.planes().is_empty() && hull.volume() == 0.0);
            assert_eq!(hull.pruned().points, points);
        }
    }
}
