//! Turns by which a body goes into a space that it does not fit into along its own axes: about Z exactly, in every way by branch and bound.
//!
//! About Z a body's width is that of its convex outline across a direction, which between two directions across its edges is the length
//! of one chord times a cosine. So the angles at which it is too wide are one interval each, and what they leave is exact.
//!
//! In every way: the ball of radius pi holds every turn as axis times angle. Within a cube of half side `h` no direction is farther from
//! that of its middle than `sqrt(3) h` (R. Hartley and F. Kahl, "Global optimization through rotation space search", 2009), and a width
//! changes by no more than the body's diameter times the chord of that. What is too wide by more is left out, the rest is parted.
//!
//! Lengths mm, angles radians.

use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

use crate::geom::{Bounds, Mat3, Vec3, convex_outline};

/// Whether a body goes into a space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Askew {
    /// Turned so.
    Fits(Mat3),
    /// In no way: proved.
    Never,
    /// None was found, and none is ruled out.
    Unknown,
}

/// Rounding, mm.
const OFF_MM: f64 = 1e-9;
/// Cubes of turns that are looked at.
const CUBES: usize = 60_000;
/// So many directions have their farthest points kept for bounds.
const DIRECTIONS: usize = 200;

/// The angle about Z at which the outline of `points` goes into a rectangle, with the most room to either side; `None`: there is none.
pub(super) fn about_z(points: &[Vec3], [wide, deep]: [f64; 2]) -> Option<f64> {
    let ring = convex_outline(points.iter().map(|p| [p.x, p.y]).collect(), 0.0);
    let edges = (0..ring.len()).map(|i| {
        let (a, b) = (ring[i], ring[(i + 1) % ring.len()]);
        [b[0] - a[0], b[1] - a[1]]
    });
    let mut turns: Vec<f64> = edges
        .flat_map(|[x, y]| [x.atan2(y), (-y).atan2(x)])
        .map(|angle| angle.rem_euclid(PI))
        .chain([0.0, FRAC_PI_2, PI])
        .collect();
    turns.sort_by(f64::total_cmp);
    let mut best: Option<[f64; 2]> = None;
    for pair in turns.windows(2).filter(|pair| pair[1] > pair[0]) {
        let middle = f64::midpoint(pair[0], pair[1]);
        let (sin, cos) = middle.sin_cos();
        // The chords across which it is widest, as long as no edge comes into play.
        let chord = |along: [f64; 2]| {
            let height = |p: &&[f64; 2]| p[0] * along[0] + p[1] * along[1];
            let by = |a: &&[f64; 2], b: &&[f64; 2]| height(a).total_cmp(&height(b));
            let (high, low) = (ring.iter().max_by(by)?, ring.iter().min_by(by)?);
            Some([high[0] - low[0], high[1] - low[1]])
        };
        let (Some([px, py]), Some([qx, qy])) = (chord([cos, -sin]), chord([sin, cos])) else { continue };
        // Width: |p| cos(angle + phase of p); depth: |q| cos(angle - phase of q from Y).
        let bad = [(px.hypot(py), -py.atan2(px), wide), (qx.hypot(qy), qx.atan2(qy), deep)];
        let mut left = vec![[pair[0], pair[1]]];
        for (length, at, most) in bad {
            if length <= most + OFF_MM {
                continue;
            }
            let half = ((most + OFF_MM) / length).clamp(-1.0, 1.0).acos();
            let at = at + ((middle - at) / TAU).round() * TAU;
            left = left.iter().flat_map(|[a, b]| [[*a, b.min(at - half)], [a.max(at + half), *b]]).collect();
            left.retain(|[a, b]| a <= b);
        }
        let room = |of: &[f64; 2]| of[1] - of[0];
        let widest = left.into_iter().max_by(|a, b| room(a).total_cmp(&room(b)));
        best = best.into_iter().chain(widest).max_by(|a, b| room(a).total_cmp(&room(b)));
    }
    best.map(|[a, b]| f64::midpoint(a, b))
}

/// A cube of turns.
struct Cube {
    middle: Vec3,
    half: f64,
    /// By how much it is too large at least, mm; what is least is looked at first.
    over_mm: f64,
}

impl Ord for Cube {
    fn cmp(&self, other: &Self) -> Ordering {
        other.over_mm.total_cmp(&self.over_mm)
    }
}

impl PartialOrd for Cube {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Cube {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Cube {}

/// Whether the body with these corners goes into a space, turned in whatever way.
pub(super) fn in_every_way(points: &[Vec3], space_mm: [f64; 3]) -> Askew {
    let space = Vec3::from(space_mm);
    // Of some points only a width is no more than of all: what they rule out is ruled out.
    let few = farthest(points);
    let diameter = few.iter().flat_map(|a| few.iter().map(move |b| (a - b).norm())).fold(0.0, f64::max);
    let over = |points: &[Vec3], turn: &Mat3| -> f64 {
        let size = Bounds::of(points.iter().map(|p| turn * p)).size();
        (0..3).map(|k| size[k] - space[k]).fold(f64::NEG_INFINITY, f64::max)
    };
    let turn_of = |middle: &Vec3| nalgebra::Rotation3::new(*middle).into_inner();
    let cube = |middle: Vec3, half: f64| {
        let away = (3.0_f64.sqrt() * half).min(PI);
        let least = over(&few, &turn_of(&middle)) - diameter * 2.0 * (away / 2.0).sin();
        Cube { middle, half, over_mm: least }
    };
    let mut heap = BinaryHeap::from([cube(Vec3::zeros(), PI)]);
    for _ in 0..CUBES {
        let Some(Cube { middle, half, over_mm }) = heap.pop() else { return Askew::Never };
        // The least of all: nothing that is left goes in.
        if over_mm > OFF_MM {
            return Askew::Never;
        }
        let turn = turn_of(&middle);
        if over(&few, &turn) <= OFF_MM && over(points, &turn) <= OFF_MM {
            return Askew::Fits(turn);
        }
        let quarter = half / 2.0;
        let corner = |k: u32| Vec3::new(f64::from(k & 1), f64::from(k >> 1 & 1), f64::from(k >> 2)) * half;
        let parts = (0..8).map(|k| middle - Vec3::repeat(quarter) + corner(k));
        // Beyond the ball every turn is one that lies within it, too.
        let within = |at: &Vec3| at.norm() <= PI + 3.0_f64.sqrt() * quarter;
        heap.extend(parts.filter(within).map(|at| cube(at, quarter)).filter(|cube| cube.over_mm <= OFF_MM));
    }
    Askew::Unknown
}

/// The points that are the farthest in directions spread evenly, each once.
fn farthest(points: &[Vec3]) -> Vec<Vec3> {
    let spread = (0..DIRECTIONS).map(|i| {
        let z = 1.0 - 2.0 * (i as f64 + 0.5) / DIRECTIONS as f64;
        let (turn, r) = (i as f64 * 2.399_963_229_728_653, (1.0 - z * z).sqrt());
        Vec3::new(r * turn.cos(), r * turn.sin(), z)
    });
    let mut few: Vec<Vec3> = Vec::new();
    for along in spread.chain((0..3).flat_map(|k| [Vec3::ith(k, 1.0), -Vec3::ith(k, 1.0)])) {
        let far = points.iter().max_by(|a, b| a.dot(&along).total_cmp(&b.dot(&along)));
        few.extend(far.filter(|p| !few.contains(p)).copied().into_iter().collect::<Vec<_>>());
    }
    few
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::SplitMix64;

    fn corners(size: [f64; 3], turn: &Mat3) -> Vec<Vec3> {
        let corner = |k: u32| Vec3::new(f64::from(k & 1), f64::from(k >> 1 & 1), f64::from(k >> 2));
        (0..8).map(|k| turn * corner(k).component_mul(&Vec3::from(size))).collect()
    }

    fn about(angle: f64) -> Mat3 {
        nalgebra::Rotation3::new(Vec3::z() * angle).into_inner()
    }

    /// A rectangle `p x q` goes into `a x b` (p >= q, a >= b) where p <= a and q <= b, or p > a and
    /// b >= (2 p q a + (p^2 - q^2) sqrt(p^2 + q^2 - a^2)) / (p^2 + q^2) (J. Carver, 1957).
    fn carver(p: f64, q: f64, a: f64, b: f64) -> bool {
        let (p, q, a, b) = (p.max(q), p.min(q), a.max(b), a.min(b));
        let askew = || {
            let (sum, less) = (p * p + q * q, p * p - q * q);
            p > a && q <= b && sum >= a * a && b >= (2.0 * p * q * a + less * (sum - a * a).sqrt()) / sum
        };
        (p <= a && q <= b) || askew()
    }

    #[test]
    fn rectangles_in_rectangles_as_carver_says() {
        let mut random = SplitMix64::seeded(5);
        let mut between = move |low: f64, high: f64| low + (high - low) * random.unit();
        let mut counts = [0; 2];
        for _ in 0..20_000 {
            let [p, q, a, b] = [between(1.0, 80.0), between(1.0, 30.0), between(20.0, 70.0), between(20.0, 70.0)];
            let wanted = carver(p, q, a, b);
            let drawn = about(between(-3.0, 3.0));
            let points = corners([p, q, 1.0], &drawn);
            let found = about_z(&points, [a, b]);
            assert_eq!(found.is_some(), wanted, "{p} x {q} into {a} x {b}");
            if let Some(angle) = found {
                let size = Bounds::of(points.iter().map(|v| about(angle) * v)).size();
                assert!(size.x <= a + 1e-6 && size.y <= b + 1e-6, "{size:?} in {a} x {b}");
            }
            counts[usize::from(wanted && !(p.max(q) <= a.max(b) && p.min(q) <= a.min(b)))] += 1;
        }
        assert!(counts[1] > 200, "{counts:?}: too few go in askew only");
    }

    #[test]
    fn polygons_go_in_where_a_fine_sweep_says_so() {
        let mut random = SplitMix64::seeded(9);
        let mut disagree = 0;
        for _ in 0..300 {
            let mut between = |low: f64, high: f64| low + (high - low) * random.unit();
            let points: Vec<Vec3> =
                (0..7).map(|_| Vec3::new(between(-40.0, 40.0), between(-12.0, 12.0), 0.0)).collect();
            let space = [between(30.0, 75.0), between(15.0, 75.0)];
            let fits = |angle: f64| {
                let size = Bounds::of(points.iter().map(|v| about(angle) * v)).size();
                size.x <= space[0] && size.y <= space[1]
            };
            let swept = (0..20_000).any(|k| fits(f64::from(k) * PI / 20_000.0));
            let found = about_z(&points, space);
            assert!(found.is_some() || !swept, "{points:?} {space:?}");
            disagree += usize::from(found.is_some() && !swept);
            found.into_iter().for_each(|angle| {
                let size = Bounds::of(points.iter().map(|v| about(angle) * v)).size();
                assert!(size.x <= space[0] + 1e-6 && size.y <= space[1] + 1e-6);
            });
        }
        assert!(disagree <= 3, "{disagree}: what no angle of the sweep finds lies between two of them");
    }

    #[test]
    fn rods_go_in_along_the_diagonal_and_no_longer_ones() {
        // A thin rod fits a cube's diagonal; one that is longer than that nowhere.
        let drawn = nalgebra::Rotation3::new(Vec3::new(0.3, -0.8, 0.5)).into_inner();
        for (length, fits) in [(60.0, true), (90.0, true), (100.0, true), (112.0, false), (150.0, false)] {
            let rod = corners([length, 1.0, 1.0], &drawn);
            match in_every_way(&rod, [60.0; 3]) {
                Askew::Fits(turn) => {
                    let size = Bounds::of(rod.iter().map(|p| turn * p)).size();
                    assert!(fits && size.max() <= 60.0 + 1e-6, "{length}: {size:?}");
                }
                Askew::Never => assert!(!fits, "{length}"),
                Askew::Unknown => panic!("{length}: not settled"),
            }
        }
        // A square plate that is wider than the cube goes in up to 1.0607 times (Prince Rupert), less its thickness.
        let plate = corners([62.0, 62.0, 0.2], &drawn);
        assert!(matches!(in_every_way(&plate, [60.0; 3]), Askew::Fits(_)));
        assert_eq!(in_every_way(&corners([80.0, 80.0, 2.0], &drawn), [60.0; 3]), Askew::Never);
        // A cube that is a little too large: none is found, and none is ruled out in reasonable time, or all are.
        assert!(!matches!(in_every_way(&corners([60.1; 3], &drawn), [60.0; 3]), Askew::Fits(_)));
    }
}
