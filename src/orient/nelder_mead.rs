//! Nelder and Mead's simplex on the sphere: no gradient, and kinks do no harm at the scale of a simplex.

use super::sphere::{lattice, tangents};
use super::trial::Trial;
use super::{Facets, Found, Minimum, Objective, Search, Stop};
use crate::geom::Vec3;

/// Simplex searches from many starts, each in the plane that touches the sphere at its best point so far.
#[derive(Clone, Copy, Debug)]
pub struct NelderMead {
    /// How many starts, spread evenly (Fibonacci's lattice).
    pub starts: usize,
    /// The only start, instead.
    pub start: Option<Vec3>,
    /// Evaluations of all walks together at most.
    pub budget: usize,
}

impl Default for NelderMead {
    fn default() -> Self {
        Self { starts: 32, start: None, budget: 20_000 }
    }
}

/// The first simplex's edge, radians; a restart's is this times the walk's progress.
const FIRST_STEP: f64 = 0.1;
/// A simplex smaller than this (radians) is done.
const LAST_STEP: f64 = 1e-9;
/// A collapsed simplex is set up anew at its best point until that gains nothing, at most so often.
const MOST_RESTARTS: usize = 16;
/// How far from where it touches a plane is used (tangent of the angle): beyond, it stretches the sphere too much.
const REACH: f64 = 0.5;

impl Search for NelderMead {
    fn name(&self) -> &'static str {
        "nelder-mead"
    }

    fn search(&self, objective: &dyn Objective, facets: &Facets) -> Found {
        let starts: Vec<Vec3> = match self.start {
            Some(start) => vec![start],
            None => (0..self.starts).map(|i| lattice(i, self.starts)).collect(),
        };
        let mut trial = Trial::new(objective, facets, self.budget);
        let (mut minima, mut stop) = (Vec::new(), Stop::Converged);
        for (i, start) in starts.iter().enumerate() {
            let share = trial.left() / (starts.len() - i);
            let before = trial.spent();
            minima.push(descend(&mut trial, *start, share, LAST_STEP));
            stop = if trial.spent() - before + 4 > share { Stop::Budget } else { stop };
        }
        trial.found(minima, None, stop)
    }
}

/// Walks down from `start` with at most `budget` evaluations (at least 1) until the simplex is smaller than `last`.
pub(super) fn descend(trial: &mut Trial<'_>, start: Vec3, budget: usize, last: f64) -> Minimum {
    let mut best = trial.at(start.normalize());
    let until = trial.spent() + budget.saturating_sub(1);
    let mut edge = FIRST_STEP;
    for _ in 0..MOST_RESTARTS {
        let before = best;
        collapse(trial, &mut best, [edge, last], until);
        let gain = before.value - best.value;
        if gain <= (1e-12f64).max(1e-3 * last) * before.value.abs() || trial.spent() + 3 > until {
            break;
        }
        edge = (before.up - best.up).norm().clamp(1e-6, FIRST_STEP);
    }
    best
}

type Corner = ([f64; 2], f64);

/// One simplex with the first edge from `best` until it is smaller than the last; `best` becomes its best corner.
fn collapse(trial: &mut Trial<'_>, best: &mut Minimum, [edge, last]: [f64; 2], until: usize) {
    if trial.spent() + 6 > until {
        return;
    }
    let (centre, [e1, e2]) = (best.up, tangents(&best.up));
    let up = |p: [f64; 2]| (centre + e1 * p[0] + e2 * p[1]).normalize();
    let mut left = until - trial.spent() - 2;
    let mut at = |p: [f64; 2]| (p, trial.value(&up(p)));
    let mut corners: [Corner; 3] = [([0.0; 2], best.value), at([edge, 0.0]), at([-0.5 * edge, 0.8 * edge])];
    loop {
        corners.sort_by(|a, b| a.1.total_cmp(&b.1));
        let size = (1..3).map(|i| distance(corners[i].0, corners[0].0)).fold(0.0, f64::max);
        if size < last || left < 4 || distance(corners[0].0, [0.0; 2]) > REACH {
            break;
        }
        left -= step(&mut corners, &mut at);
    }
    if corners[0].1 < best.value {
        *best = Minimum { up: up(corners[0].0), value: corners[0].1, ended: true };
    }
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// Reflects, expands, contracts or shrinks sorted corners; says how many evaluations that took (at most 4).
fn step(corners: &mut [Corner; 3], at: &mut impl FnMut([f64; 2]) -> Corner) -> usize {
    let middle = [0, 1].map(|k| 0.5 * (corners[0].0[k] + corners[1].0[k]));
    let worst = corners[2];
    let along = |t: f64| [0, 1].map(|k| middle[k] + t * (middle[k] - worst.0[k]));
    let reflected = at(along(1.0));
    if reflected.1 < corners[0].1 {
        let expanded = at(along(2.0));
        corners[2] = if expanded.1 < reflected.1 { expanded } else { reflected };
        return 2;
    }
    if reflected.1 < corners[1].1 {
        corners[2] = reflected;
        return 1;
    }
    let contracted = at(along(if reflected.1 < worst.1 { 0.5 } else { -0.5 }));
    if contracted.1 < worst.1.min(reflected.1) {
        corners[2] = contracted;
        return 2;
    }
    let kept = corners[0].0;
    for corner in &mut corners[1..] {
        *corner = at([0, 1].map(|k| 0.5 * (corner.0[k] + kept[k])));
    }
    4
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::orient::{NormalZ, Staircase};

    #[test]
    fn finds_the_smallest_eigenvector() {
        let e = [Vec3::new(2.0, 1.0, -1.0).normalize(), Vec3::new(1.0, -1.0, 1.0).normalize()];
        let last = e[0].cross(&e[1]);
        // 5, 3 and 1 normals along three axes at right angles: eigenvalues 5, 3, 1.
        let normals = [vec![e[0]; 5], vec![e[1]; 3], vec![last]].concat();
        let facets = Facets::with(normals, vec![1.0; 9], vec![]);
        let found = NelderMead::default().search(&NormalZ, &facets);
        assert!((found.minima[0].value - 1.0).abs() < 1e-12);
        assert!(found.minima[0].up.dot(&last).abs() > 1.0 - 1e-12);
        assert_eq!(found.minima.len(), 2, "both senses");
        assert!(found.evaluations <= 20_000);
    }

    #[test]
    fn finds_the_corner_between_two_faces_of_a_box() {
        // Without the dips |d.n| is least on an axis, beside the dip of its faces: 0.02 * 2 * 6 for z.
        let normals = [Vec3::x(), Vec3::y(), Vec3::z()].map(|n| [n, -n]).concat();
        let facets = Facets::with(normals, vec![12.0, 12.0, 8.0, 8.0, 6.0, 6.0], vec![]);
        let start = Some(Vec3::new(0.3, 0.2, 0.9));
        let found = NelderMead { start, ..NelderMead::default() }.search(&Staircase { layer_mm: 0.2 }, &facets);
        // Inside the dip, 0.1 degree wide, the walls' share falls on to 0 with the lean.
        assert!(found.minima[0].value < 1e-8, "{found:?}");
        assert!((found.minima[0].up - Vec3::z()).norm() < 1e-8);
    }

    #[test]
    fn keeps_to_its_budget() {
        let facets = Facets::with(vec![Vec3::x(), Vec3::y()], vec![1.0, 2.0], vec![]);
        let search = NelderMead { budget: 500, ..NelderMead::default() };
        let found = search.search(&NormalZ, &facets);
        assert!(found.evaluations <= 500, "{}", found.evaluations);
    }
}
