//! The farthest point of a piece of the head along a direction, looked for among the few that it can be.
//!
//! A collision query asks for it a dozen times, and a cone of the head has some hundred points. Seen from above, the directions of one
//! *fan* lie between two that are an eighth of a right angle apart: of the points at one height only those are kept that another one
//! does not beat along both. What is linear and beaten at both ends is beaten in between, so the answer is exact.

use crate::geom::convex::support;
use crate::geom::{Bounds, Vec3};

/// Fans in a right angle.
const FANS: usize = 8;
/// Points belong to one height up to this, mm: bodies are written with whole micrometres.
const LEVEL_MM: f64 = 1e-9;

/// A convex piece, and above it its own shadow up to `upward`.
#[derive(Clone, Debug)]
pub(super) struct Fans {
    fans: Vec<Box<[Vec3]>>,
    upward: f64,
    /// The box around all of it.
    pub(super) bounds: Bounds,
}

impl Fans {
    /// The hull of `points`, and of the same points `upward` mm above.
    pub(super) fn of(points: &[Vec3], upward: f64) -> Self {
        let of_fan = |fan: usize| left(points, [fan, fan + 1].map(along)).into();
        let Bounds { min, max } = Bounds::of(points.iter().copied());
        let bounds = Bounds { min, max: max + Vec3::z() * upward };
        Self { fans: (0..4 * FANS).map(of_fan).collect(), upward, bounds }
    }

    /// The point farthest along `d`.
    pub(super) fn farthest(&self, d: &Vec3) -> Vec3 {
        let mut point = support(&self.fans[fan(d)], d);
        if d.z > 0.0 {
            point.z += self.upward;
        }
        point
    }
}

/// The fan of a direction, by the square that stands on its corner: the angle along its sides is a division, and grows as the true one.
fn fan(d: &Vec3) -> usize {
    let around = d.x.abs() + d.y.abs();
    if around <= 0.0 {
        return 0;
    }
    let share = d.y.abs() / around;
    let quarter = match (d.x >= 0.0, d.y >= 0.0) {
        (true, true) => share,
        (false, true) => 2.0 - share,
        (false, false) => 2.0 + share,
        (true, false) => 4.0 - share,
    };
    ((quarter * FANS as f64) as usize) % (4 * FANS)
}

/// Where fan `index` begins, seen from above.
fn along(index: usize) -> [f64; 2] {
    let share = (index % FANS) as f64 / FANS as f64;
    let (x, y) = (1.0 - share, share);
    match index / FANS % 4 {
        0 => [x, y],
        1 => [-y, x],
        2 => [-x, -y],
        _ => [y, -x],
    }
}

/// The points that are farthest of their height along some direction between two.
fn left(points: &[Vec3], ends: [[f64; 2]; 2]) -> Vec<Vec3> {
    let ahead = |p: &Vec3, q: &Vec3| ends.map(|e| (q.x - p.x) * e[0] + (q.y - p.y) * e[1]);
    let beats = |i: usize, j: usize| {
        let (p, q) = (&points[i], &points[j]);
        let by = ahead(p, q);
        // Of two alike the first stays.
        let more = by.iter().all(|v| *v >= 0.0) && (by.iter().any(|v| *v > 0.0) || j < i);
        i != j && (p.z - q.z).abs() < LEVEL_MM && more
    };
    (0..points.len()).filter(|&i| (0..points.len()).all(|j| !beats(i, j))).map(|i| points[i]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::SplitMix64;

    #[test]
    fn no_point_is_farther() {
        let mut random = SplitMix64::seeded(5);
        for case in 0..40 {
            let rings = 1 + random.below(3);
            let mut points = Vec::new();
            for ring in 0..rings {
                let (sides, r) = (3 + random.below(62), 10.0 * random.unit() + 0.1);
                let (turn, z) = (random.unit(), ring as f64 * 7.3);
                points.extend((0..sides).map(|k| {
                    let (s, c) = (std::f64::consts::TAU * (k as f64 + turn) / sides as f64).sin_cos();
                    Vec3::new(r * c + case as f64 * 0.1, r * s, z)
                }));
            }
            let upward = if case % 2 == 0 { 2000.0 } else { 0.0 };
            let fans = Fans::of(&points, upward);
            let all: Vec<Vec3> = points.iter().flat_map(|p| [*p, p + Vec3::z() * upward]).collect();
            let flat = [Vec3::x(), -Vec3::x(), Vec3::y(), -Vec3::y(), Vec3::z(), -Vec3::z(), Vec3::new(1.0, 1.0, 0.0)];
            let many = (0..2000).map(|_| random.direction());
            for d in many.chain(flat).chain((0..4 * FANS).map(|i| Vec3::new(along(i)[0], along(i)[1], 0.3))) {
                let (got, wanted) = (fans.farthest(&d).dot(&d), support(&all, &d).dot(&d));
                assert!((got - wanted).abs() <= 1e-9 * (1.0 + wanted.abs()), "{case} {d:?}: {got} for {wanted}");
            }
            let most = fans.fans.iter().map(|fan| fan.len()).max().unwrap();
            assert!(most <= 6 * rings, "{most} of {} points", points.len());
        }
    }
}
