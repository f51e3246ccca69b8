//! A convex piece of the head or the frame as half-spaces, for sound lower bounds of distances.
//!
//! Pieces of the head reach upward without end, as in `planning::collision`: what holds a head up is above it.

use crate::geom::{Body, Bounds, Vec3, convex_outline};
use crate::planning::carries_tip;

/// Up to so many points the faces are found by trying every three; beyond it supporting planes in fixed directions
/// stand for them, which makes the piece slightly bigger, never smaller.
const MOST_POINTS: usize = 80;
/// Directions of those planes.
const DIRECTIONS: usize = 256;
/// Points this near to a plane lie in it, relative to the piece's size.
const FLAT: f64 = 1e-9;

/// A half-space `normal . p <= offset`.
#[derive(Clone, Copy, Debug)]
pub(super) struct HullPlane {
    pub(super) normal: Vec3,
    pub(super) offset: f64,
}

/// A convex piece, its origin as [`Body::origin_at`] says.
pub(super) struct Hull {
    pub(super) name: String,
    pub(super) body: Body,
    pub(super) bounds: Bounds,
    /// All faces.
    pub(super) faces: Vec<HullPlane>,
    /// The underside: `z >= a x + b y + c`.
    pub(super) under: Vec<[f64; 3]>,
    /// The outline seen from above: `nx x + ny y <= c`, unit normals.
    pub(super) outline: Vec<[f64; 3]>,
    /// Underside and outline as half-spaces `nx x + ny y + nz z <= c`, unit normals, `nz` not above 0: together they hold the piece
    /// and all above it.
    pub(super) sides: Vec<[f64; 4]>,
    /// Whether it carries the tip, which touches what it prints on.
    pub(super) tip: bool,
}

impl Hull {
    pub(super) fn new(body: Body, contact: f64) -> Self {
        let bounds = body.bounds();
        let faces = faces(&body.points);
        let below = faces.iter().filter(|f| f.normal.z < -1e-6);
        let mut under: Vec<[f64; 3]> =
            below.map(|f| [-f.normal.x / f.normal.z, -f.normal.y / f.normal.z, f.offset / f.normal.z]).collect();
        under.push([0.0, 0.0, bounds.min.z]);
        let tip = carries_tip(&body, contact);
        let outline = outline(&body.points);
        let downward =
            faces.iter().filter(|f| f.normal.z < -1e-6).map(|f| [f.normal.x, f.normal.y, f.normal.z, f.offset]);
        let upright = outline.iter().map(|&[x, y, c]| [x, y, 0.0, c]);
        let sides = downward.chain(upright).chain([[0.0, 0.0, -1.0, -bounds.min.z]]).collect();
        Self { name: body.name.clone(), outline, bounds, faces, under, sides, tip, body }
    }

    /// A lower bound of the distance (mm) of `p`, seen from the piece's origin, from the piece and all above it.
    pub(super) fn distance_below(&self, p: &Vec3) -> f64 {
        let outline = self.outline.iter().map(|[x, y, c]| x * p.x + y * p.y - c);
        let under = self.faces.iter().filter(|f| f.normal.z < 0.0).map(|f| f.normal.dot(p) - f.offset);
        outline.chain(under).chain([self.bounds.min.z - p.z]).fold(f64::NEG_INFINITY, f64::max)
    }

    /// A lower bound of the distance of `p` from the piece itself.
    pub(super) fn distance(&self, p: &Vec3) -> f64 {
        let faces = self.faces.iter().map(|f| f.normal.dot(p) - f.offset);
        let sides = (0..3).map(|i| (self.bounds.min[i] - p[i]).max(p[i] - self.bounds.max[i]));
        faces.chain(sides).fold(f64::NEG_INFINITY, f64::max)
    }
}

/// Planes that hold all points on one side; together they bound the hull or a little more.
fn faces(points: &[Vec3]) -> Vec<HullPlane> {
    if points.len() > MOST_POINTS {
        return (0..DIRECTIONS).map(|i| supporting(points, direction(i))).collect();
    }
    let size = Bounds::of(points.iter().copied()).size().norm();
    let mut planes: Vec<HullPlane> = Vec::new();
    for (i, a) in points.iter().enumerate() {
        for (j, b) in points.iter().enumerate().skip(i + 1) {
            for c in points.iter().skip(j + 1) {
                let cross = (b - a).cross(&(c - a));
                if cross.norm() > FLAT * size * size {
                    let normal = cross.normalize();
                    consider(&mut planes, points, a, normal, FLAT * size);
                }
            }
        }
    }
    planes
}

fn consider(planes: &mut Vec<HullPlane>, points: &[Vec3], on: &Vec3, normal: Vec3, slack: f64) {
    let level = normal.dot(on);
    let (mut above, mut below) = (false, false);
    for point in points {
        let height = normal.dot(point) - level;
        above |= height > slack;
        below |= height < -slack;
        if above && below {
            return;
        }
    }
    for (normal, wanted) in [(normal, !above), (-normal, !below)] {
        let known = planes.iter().any(|p| (p.normal - normal).norm() < 1e-7);
        if wanted && !known {
            planes.push(supporting(points, normal));
        }
    }
}

fn supporting(points: &[Vec3], normal: Vec3) -> HullPlane {
    HullPlane { normal, offset: points.iter().map(|p| normal.dot(p)).fold(f64::NEG_INFINITY, f64::max) }
}

/// Directions spread evenly over the sphere, spiralling.
fn direction(i: usize) -> Vec3 {
    let z = 1.0 - 2.0 * (i as f64 + 0.5) / DIRECTIONS as f64;
    let (s, c) = (i as f64 * 2.399_963_229_728_653).sin_cos();
    let r = (1.0 - z * z).sqrt();
    Vec3::new(r * c, r * s, z)
}

/// The edges of the points' hull seen from above.
pub(super) fn outline(points: &[Vec3]) -> Vec<[f64; 3]> {
    let ring = convex_outline(points.iter().map(|p| [p.x, p.y]).collect(), 0.0);
    let edges = (0..ring.len()).map(|i| (ring[i], ring[(i + 1) % ring.len()]));
    let normals = edges.map(|(a, b)| [b[1] - a[1], a[0] - b[0]]).filter(|n| n[0].hypot(n[1]) > 1e-12);
    let unit = normals.map(|n| n.map(|v| v / n[0].hypot(n[1])));
    // The box's sides come first: they tell most things apart, and hold where the ring has collapsed.
    let sides = [[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]];
    sides
        .into_iter()
        .chain(unit)
        .map(|[x, y]| [x, y, points.iter().map(|p| x * p.x + y * p.y).fold(f64::NEG_INFINITY, f64::max)])
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_has_six_faces_and_four_edges_beside_those_of_its_outline_box() {
        let body = Body::cuboid("b", Vec3::new(-1.0, -2.0, 3.0), Vec3::new(1.0, 2.0, 5.0), [true; 3]);
        let hull = Hull::new(body, 0.5);
        assert_eq!((hull.faces.len(), hull.outline.len(), hull.tip), (6, 8, false));
        assert!((hull.distance_below(&Vec3::new(0.0, 0.0, 1.0)) - 2.0).abs() < 1e-12);
        assert!((hull.distance_below(&Vec3::new(4.0, 0.0, 50.0)) - 3.0).abs() < 1e-12);
        assert!((hull.distance(&Vec3::new(0.0, 0.0, 7.0)) - 2.0).abs() < 1e-12);
        assert!(hull.distance_below(&Vec3::new(0.0, 0.0, 7.0)) < 0.0, "upward without end");
    }

    #[test]
    fn a_frustum_rises_along_its_cone() {
        let hull = Hull::new(Body::frustum("n", [0.0, 10.0], [0.5, 8.0], [true; 3]), 0.4);
        assert!(hull.tip);
        let under = |x: f64, y: f64| hull.under.iter().map(|[a, b, c]| a * x + b * y + c).fold(0.0, f64::max);
        assert_eq!(under(0.2, 0.0), 0.0);
        let slope = 10.0 / 7.5;
        assert!((under(4.5, 0.0) - 4.0 * slope).abs() < 0.05, "{}", under(4.5, 0.0));
        assert!((under(0.0, 4.5) - 4.0 * slope).abs() < 0.05);
    }
}
