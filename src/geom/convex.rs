//! Distances between convex sets, by the Gilbert-Johnson-Keerthi algorithm.
//!
//! A convex set is known by its support function alone: the point farthest along a direction. Minkowski sums of sets
//! are sums of supports, so "head body swept over a part against another part" is one query.
//!
//! Source: E. G. Gilbert, D. W. Johnson, S. S. Keerthi, *A fast procedure for computing the distance between complex
//! objects in three-dimensional space*, IEEE J. Robotics and Automation 4 (1988), 193-203; the closest point of a
//! simplex by Voronoi regions, after C. Ericson, *Real-Time Collision Detection* (2005), section 5.1.

use super::Vec3;

/// What is known of the distance between the origin and a convex set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Separation {
    /// Proved: every point of the set is at least this far (mm, > 0) from the origin.
    Apart(f64),
    /// The origin lies in the set, or could not be proved outside it.
    Meeting,
}

impl Separation {
    /// The proved distance, 0 where the sets meet.
    pub fn distance(self) -> f64 {
        match self {
            Self::Apart(mm) => mm,
            Self::Meeting => 0.0,
        }
    }
}

/// The point of `points` farthest along `direction`; the origin for none.
pub fn support(points: &[Vec3], direction: &Vec3) -> Vec3 {
    let mut best = f64::NEG_INFINITY;
    let mut farthest = Vec3::zeros();
    for point in points {
        let along = point.dot(direction);
        if along > best {
            best = along;
            farthest = *point;
        }
    }
    farthest
}

/// More rounds than any pair of sets with a few thousand points took in the tests; beyond it nothing is proved.
const MOST_ROUNDS: usize = 128;

/// The distance from the origin to the convex set with the given `support` function.
///
/// Stops as soon as more than `enough` mm are proved (pass infinity for the distance itself, proved to within
/// `1e-6` relative). A set that touches the origin counts as [`Separation::Meeting`], and so does one that the
/// iteration could not settle: "not proved free" is "not free".
pub fn separation(support: impl FnMut(&Vec3) -> Vec3, enough: f64) -> Separation {
    separation_by(support, enough, &mut Vec3::x())
}

/// The same, where `axis` may tell the two apart at once, as the one that told apart the two before often does; it becomes what did.
///
/// Only [`Separation::Apart`] below `enough` is the distance: above, it is what was proved.
pub fn separation_by(mut support: impl FnMut(&Vec3) -> Vec3, enough: f64, axis: &mut Vec3) -> Separation {
    let first = support(&-*axis);
    let along = first.dot(axis);
    if along > enough {
        return Separation::Apart(along);
    }
    let apart = nearest(support, enough, first);
    if let Some(direction) = apart.1 {
        *axis = direction;
    }
    apart.0
}

/// From the point `nearest` of the set on; with the unit direction that proved the distance.
fn nearest(mut support: impl FnMut(&Vec3) -> Vec3, enough: f64, mut nearest: Vec3) -> (Separation, Option<Vec3>) {
    let mut simplex = Simplex::default();
    simplex.push(nearest);
    let (mut proved, mut by) = (0.0f64, None);
    for _ in 0..MOST_ROUNDS {
        let length = nearest.norm();
        if length < 1e-9 {
            return (Separation::Meeting, None);
        }
        let candidate = support(&-nearest);
        let along = nearest.dot(&candidate) / length;
        if along > proved {
            (proved, by) = (along, Some(nearest / length));
        }
        if proved > enough || (proved > 0.0 && length - proved <= 1e-6 * length) {
            return (Separation::Apart(proved), by);
        }
        if simplex.has(&candidate) {
            break;
        }
        simplex.push(candidate);
        match simplex.nearest_to_origin() {
            Some(point) if point.norm_squared() < nearest.norm_squared() => nearest = point,
            Some(_) => break,
            None => return (Separation::Meeting, None),
        }
    }
    (if proved > 0.0 { Separation::Apart(proved) } else { Separation::Meeting }, by)
}

#[derive(Default)]
struct Simplex {
    points: [Vec3; 4],
    count: usize,
}

impl Simplex {
    fn push(&mut self, point: Vec3) {
        self.points[self.count] = point;
        self.count += 1;
    }

    fn has(&self, point: &Vec3) -> bool {
        self.points[..self.count].iter().any(|p| (p - point).norm_squared() < 1e-24)
    }

    /// The point of the simplex nearest to the origin, the simplex reduced to the corners that make it; `None` where
    /// the origin is inside.
    fn nearest_to_origin(&mut self) -> Option<Vec3> {
        let p = self.points;
        let (point, keep) = match self.count {
            1 => (p[0], Corners::of(&[p[0]])),
            2 => on_segment(p[0], p[1]),
            3 => on_triangle(p[0], p[1], p[2]),
            _ => on_tetrahedron(&p)?,
        };
        self.points[..3].copy_from_slice(&keep.points);
        self.count = keep.count;
        Some(point)
    }
}

/// The corners of a simplex that make its nearest point: a corner, an edge or a face.
#[derive(Clone, Copy, Default)]
struct Corners {
    points: [Vec3; 3],
    count: usize,
}

impl Corners {
    fn of(corners: &[Vec3]) -> Self {
        let mut points = [Vec3::zeros(); 3];
        points[..corners.len()].copy_from_slice(corners);
        Self { points, count: corners.len() }
    }
}

fn on_segment(a: Vec3, b: Vec3) -> (Vec3, Corners) {
    let ab = b - a;
    let t = -a.dot(&ab) / ab.norm_squared();
    if t <= 0.0 {
        (a, Corners::of(&[a]))
    } else if t >= 1.0 {
        (b, Corners::of(&[b]))
    } else {
        (a + ab * t, Corners::of(&[a, b]))
    }
}

fn on_triangle(a: Vec3, b: Vec3, c: Vec3) -> (Vec3, Corners) {
    let normal = (b - a).cross(&(c - a));
    let area = normal.norm_squared();
    // Inside where the origin is on the inner side of all three edges.
    let inside = |p: Vec3, q: Vec3| (q - p).cross(&normal).dot(&-p) <= 0.0;
    if area > 1e-30 && inside(a, b) && inside(b, c) && inside(c, a) {
        return (normal * (a.dot(&normal) / area), Corners::of(&[a, b, c]));
    }
    nearest_of([on_segment(a, b), on_segment(b, c), on_segment(c, a)])
}

/// The nearer of several; the first where they are alike.
fn nearest_of<const N: usize>(choices: [(Vec3, Corners); N]) -> (Vec3, Corners) {
    let nearer = |best: (Vec3, Corners), choice: (Vec3, Corners)| {
        if choice.0.norm_squared() < best.0.norm_squared() { choice } else { best }
    };
    choices.into_iter().reduce(nearer).unwrap_or_default()
}

/// `None` where the origin is inside.
fn on_tetrahedron(p: &[Vec3; 4]) -> Option<(Vec3, Corners)> {
    let mut outside = false;
    for [a, b, c, d] in &[[0, 1, 2, 3], [0, 1, 3, 2], [0, 2, 3, 1], [1, 2, 3, 0]] {
        let (a, b, c, d) = (p[*a], p[*b], p[*c], p[*d]);
        let normal = (b - a).cross(&(c - a));
        let inner = (d - a).dot(&normal);
        let origin = (-a).dot(&normal);
        // A flat tetrahedron has no inside: every face is then a candidate.
        if inner.abs() < 1e-18 || origin * inner < 0.0 {
            outside = true;
        }
    }
    outside.then(|| {
        nearest_of([
            on_triangle(p[0], p[1], p[2]),
            on_triangle(p[0], p[1], p[3]),
            on_triangle(p[0], p[2], p[3]),
            on_triangle(p[1], p[2], p[3]),
        ])
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cube(centre: Vec3, half: f64) -> Vec<Vec3> {
        (0..8)
            .map(|i| {
                let sign = |bit: usize| if i >> bit & 1 == 1 { half } else { -half };
                centre + Vec3::new(sign(0), sign(1), sign(2))
            })
            .collect()
    }

    fn distance(a: &[Vec3], b: &[Vec3]) -> f64 {
        separation(|d| support(a, d) - support(b, &-d), f64::INFINITY).distance()
    }

    #[test]
    fn cubes_face_edge_and_corner_apart() {
        let a = cube(Vec3::zeros(), 1.0);
        for (at, wanted) in [
            (Vec3::new(5.0, 0.3, -0.2), 3.0),
            (Vec3::new(4.0, 5.0, 0.0), 13f64.sqrt()),
            (Vec3::new(4.0, 4.0, 4.0), 12f64.sqrt()),
            (Vec3::new(1.5, 1.5, 0.0), 0.0),
            (Vec3::new(2.0, 0.0, 0.0), 0.0),
        ] {
            let got = distance(&a, &cube(at, 1.0));
            assert!((got - wanted).abs() < 1e-5, "{at:?}: {got} for {wanted}");
        }
    }

    #[test]
    fn agrees_with_brute_force_over_random_hulls() {
        // Witness: the distance along a dense set of directions, which bounds the true one from below.
        let mut seed = 12345u64;
        let mut random = move || {
            seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (seed >> 33) as f64 / (1u64 << 31) as f64
        };
        for _ in 0..200 {
            let mut cloud = |shift: f64| -> Vec<Vec3> {
                (0..12).map(|_| Vec3::new(random() * 4.0 + shift, random() * 3.0, random() * 5.0)).collect()
            };
            let (a, b) = (cloud(0.0), cloud(3.7));
            let got = distance(&a, &b);
            let along = |d: &Vec3| -(support(&a, d) - support(&b, &-d)).dot(d);
            let mut best = Vec3::x();
            for i in 0..4000 {
                let z = 1.0 - 2.0 * (i as f64 + 0.5) / 4000.0;
                let turn = i as f64 * 2.399963;
                let r = (1.0 - z * z).sqrt();
                let d = Vec3::new(r * turn.cos(), r * turn.sin(), z);
                best = if along(&d) > along(&best) { d } else { best };
            }
            let mut step = 0.05;
            while step > 1e-7 {
                let tries = [Vec3::x(), Vec3::y(), Vec3::z()].map(|e| [e * step, e * -step]).concat();
                let better = tries.iter().map(|e| (best + e).normalize()).find(|d| along(d) > along(&best));
                match better {
                    Some(d) => best = d,
                    None => step *= 0.5,
                }
            }
            let bound = along(&best).max(0.0);
            // The search may stick on a ridge of this concave but kinked function, so it only bounds from below.
            assert!(got >= bound - 1e-6 && got <= bound + 0.05, "{got} for {bound}");
        }
    }

    #[test]
    fn stops_when_enough_is_proved() {
        let (a, b) = (cube(Vec3::zeros(), 1.0), cube(Vec3::new(50.0, 3.0, 9.0), 1.0));
        let got = separation(|d| support(&a, d) - support(&b, &-d), 1.0);
        assert!(matches!(got, Separation::Apart(mm) if mm > 1.0 && mm <= 49.0), "{got:?}");
    }
}
