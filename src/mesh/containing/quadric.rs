//! The sum of squared distances from planes, and where it is least on the outer side of some others: a convex quadratic program in three
//! variables, exactly, by the incremental method for low dimensions.
//!
//! Constraints are taken one after the other. Where the best place so far breaks one, the best place lies on that one's plane, so the
//! question is asked again there, one dimension lower, with those that came before (R. Seidel, "Small-dimensional linear programming
//! and convex hulls made easy", 1991; it holds for any strictly convex objective). Three levels deep at most.

use crate::geom::{Mat3, Vec3};

/// Where all costs the same, as within a plane, the place nearest to the origin is taken: this much of the planes' number weighs that.
pub(super) const NEARNESS: f64 = 1e-9;
/// A plane nearly across to all directions that are left is parallel to them.
const PARALLEL: f64 = 1e-7;

/// `v . a v + 2 b . v + c`: the sum of squared distances of `v` from planes.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Quadric {
    a: Mat3,
    b: Vec3,
    c: f64,
}

/// The points `p` with `n . p >= d`, `n` a unit vector.
#[derive(Clone, Copy, Debug)]
pub(super) struct Outside {
    pub(super) n: Vec3,
    pub(super) d: f64,
}

impl Outside {
    /// How far inside a point lies where negative.
    fn height(&self, p: &Vec3) -> f64 {
        self.n.dot(p) - self.d
    }
}

impl Quadric {
    /// Of one plane.
    pub(super) fn of(plane: &Outside) -> Self {
        Self { a: plane.n * plane.n.transpose(), b: -plane.n * plane.d, c: plane.d * plane.d }
    }

    /// Of the planes of both.
    pub(super) fn plus(&self, other: &Self) -> Self {
        Self { a: self.a + other.a, b: self.b + other.b, c: self.c + other.c }
    }

    /// The same as seen from `origin`.
    pub(super) fn from(&self, origin: &Vec3) -> Self {
        let b = self.b + self.a * origin;
        Self { a: self.a, b, c: self.c + (self.b + b).dot(origin) }
    }

    /// Its value; rounding never makes it negative.
    pub(super) fn at(&self, v: &Vec3) -> f64 {
        (v.dot(&(self.a * v)) + 2.0 * self.b.dot(v) + self.c).max(0.0)
    }

    /// What a square millimetre from the origin weighs.
    pub(super) fn nearness(&self) -> f64 {
        NEARNESS * self.a.trace().max(1.0)
    }

    /// Where it is least on the outer side of all `planes`, or within `slack` mm of it; `None` where no place is, or only one that
    /// near-parallel planes put far away.
    pub(super) fn least(&self, planes: &[Outside], slack: f64) -> Option<Vec3> {
        let strict = Self { a: self.a + Mat3::identity() * self.nearness(), ..*self };
        strict.least_on(planes, slack, Flat { point: Vec3::zeros(), basis: [Vec3::x(), Vec3::y(), Vec3::z()], left: 3 })
    }

    fn least_on(&self, planes: &[Outside], slack: f64, flat: Flat) -> Option<Vec3> {
        let mut best = self.bottom(&flat)?;
        for (index, plane) in planes.iter().enumerate() {
            if plane.height(&best) < -slack {
                best = self.least_on(&planes[..index], slack, flat.cut(plane)?)?;
            }
        }
        Some(best)
    }

    /// Where it is least on a flat.
    fn bottom(&self, flat: &Flat) -> Option<Vec3> {
        let slope = self.a * flat.point + self.b;
        // Directions that are gone are filled up with ones, and nothing goes along them.
        let within = |i: usize, j: usize| i < flat.left && j < flat.left;
        let a = Mat3::from_fn(|i, j| match within(i, j) {
            true => flat.basis[i].dot(&(self.a * flat.basis[j])),
            false => f64::from(u8::from(i == j)),
        });
        let b = Vec3::from_fn(|i, _| if i < flat.left { -flat.basis[i].dot(&slope) } else { 0.0 });
        let along = a.cholesky()?.solve(&b);
        Some(flat.point + (0..flat.left).map(|i| flat.basis[i] * along[i]).sum::<Vec3>())
    }
}

/// A point, and the unit directions in which one may go from it: space, a plane, a line or the point alone.
#[derive(Clone, Copy, Debug)]
struct Flat {
    point: Vec3,
    basis: [Vec3; 3],
    left: usize,
}

impl Flat {
    /// What of it lies on a plane; `None` where that is nothing, or all of it.
    fn cut(&self, plane: &Outside) -> Option<Self> {
        let along: Vec3 = self.basis[..self.left].iter().map(|e| e * e.dot(&plane.n)).sum();
        let steep = along.norm();
        if steep < PARALLEL {
            return None;
        }
        let across = along / steep;
        let point = self.point - across * (plane.height(&self.point) / steep);
        let mut basis = [Vec3::zeros(); 3];
        let mut left = 0;
        // The direction that lies most along the cut goes; the others are made square to it and to each other.
        let gone = (0..self.left).max_by(|&i, &j| {
            let share = |k: usize| self.basis[k].dot(&across).abs();
            share(i).total_cmp(&share(j))
        })?;
        for e in self.basis[..self.left].iter().enumerate().filter(|(i, _)| *i != gone).map(|(_, e)| e) {
            let rest = basis[..left].iter().fold(e - across * e.dot(&across), |rest, f: &Vec3| rest - f * f.dot(&rest));
            basis[left] = rest.try_normalize(1e-12)?;
            left += 1;
        }
        Some(Self { point, basis, left })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::SplitMix64;

    fn plane(n: [f64; 3], d: f64) -> Outside {
        let n = Vec3::from(n);
        Outside { n: n.normalize(), d: d / n.norm() }
    }

    #[test]
    fn squared_distances_by_hand_and_from_another_origin() {
        let sum = Quadric::of(&plane([1.0, 0.0, 0.0], 2.0)).plus(&Quadric::of(&plane([0.0, 3.0, 4.0], 10.0)));
        let p = Vec3::new(5.0, 1.0, 3.0);
        assert!((sum.at(&p) - (9.0 + 1.0)).abs() < 1e-12);
        let origin = Vec3::new(-3.0, 7.0, 0.5);
        assert!((sum.from(&origin).at(&(p - origin)) - 10.0).abs() < 1e-10);
    }

    #[test]
    fn a_corner_an_edge_a_plane_and_nothing() {
        let walls = [plane([1.0, 0.0, 0.0], 1.0), plane([0.0, 1.0, 0.0], 2.0), plane([0.0, 0.0, 1.0], 3.0)];
        let sum = walls.iter().fold(Quadric::default(), |sum, wall| sum.plus(&Quadric::of(wall)));
        let close = |got: Option<Vec3>, wanted: [f64; 3]| (got.unwrap() - Vec3::from(wanted)).norm() < 1e-8;
        assert!(close(sum.least(&walls, 0.0), [1.0, 2.0, 3.0]));
        // Of one plane alone the place nearest to the origin, whatever is asked for more than once.
        let one = Quadric::of(&walls[0]);
        assert!(close(one.least(&[walls[0]; 4], 1e-12), [1.0, 0.0, 0.0]));
        assert!(close(one.plus(&Quadric::of(&walls[1])).least(&walls[..2], 0.0), [1.0, 2.0, 0.0]));
        // Pushed out by another plane.
        assert!(close(one.least(&[walls[0], plane([1.0, 1.0, 0.0], 4.0)], 0.0), [1.0, 3.0, 0.0]));
        let facing = [plane([1.0, 0.0, 0.0], 1.0), plane([-1.0, 0.0, 0.0], 1.0)];
        assert!(one.least(&facing, 0.0).is_none());
        assert_eq!(Quadric::default().least(&[], 0.0), Some(Vec3::zeros()));
    }

    /// The best of all places where up to three planes meet, among those that are allowed: another method.
    fn by_all_meetings(sum: &Quadric, planes: &[Outside]) -> Option<f64> {
        let a = sum.a + Mat3::identity() * sum.nearness();
        let value = |v: &Vec3| v.dot(&(a * v)) + 2.0 * sum.b.dot(v) + sum.c;
        let count = planes.len();
        let mut sets = vec![vec![]];
        for i in 0..count {
            sets.push(vec![i]);
            for j in 0..i {
                sets.push(vec![i, j]);
                sets.extend((0..j).map(|k| vec![i, j, k]));
            }
        }
        let mut least: Option<f64> = None;
        for set in sets {
            let size = 3 + set.len();
            let mut system = nalgebra::DMatrix::<f64>::zeros(size, size);
            let mut right = nalgebra::DVector::<f64>::zeros(size);
            for r in 0..3 {
                right[r] = -sum.b[r];
                (0..3).for_each(|c| system[(r, c)] = a[(r, c)]);
                for (m, &i) in set.iter().enumerate() {
                    (system[(r, 3 + m)], system[(3 + m, r)]) = (planes[i].n[r], planes[i].n[r]);
                    right[3 + m] = planes[i].d;
                }
            }
            let Some(solved) = system.lu().solve(&right) else { continue };
            let v = Vec3::new(solved[0], solved[1], solved[2]);
            if planes.iter().all(|p| p.height(&v) >= -1e-7) {
                least = Some(least.map_or(value(&v), |least| least.min(value(&v))));
            }
        }
        least
    }

    #[test]
    fn is_as_low_as_the_best_of_all_meetings_of_planes() {
        let mut random = SplitMix64::seeded(4);
        let (mut some, mut none) = (0, 0);
        for case in 0..400 {
            let lean = f64::from(case % 4) * 0.5;
            let planes: Vec<Outside> = (0..3 + case % 7)
                .map(|_| Outside { n: (random.direction() + Vec3::z() * lean).normalize(), d: random.unit() - 0.5 })
                .collect();
            let sum = planes.iter().fold(Quadric::default(), |sum, p| sum.plus(&Quadric::of(p)));
            let (got, wanted) = (sum.least(&planes, 1e-12), by_all_meetings(&sum, &planes));
            match (got, wanted) {
                (Some(v), Some(wanted)) => {
                    assert!(planes.iter().all(|p| p.height(&v) >= -1e-9), "{case}");
                    let got = sum.at(&v) + sum.nearness() * v.norm_squared();
                    assert!((got - wanted).abs() <= 1e-6 * (1.0 + wanted), "{case}: {got} for {wanted}");
                    some += 1;
                }
                (None, None) => none += 1,
                other => panic!("{case}: {other:?}"),
            }
        }
        assert!(some > 100 && none > 30, "{some} {none}");
    }
}
