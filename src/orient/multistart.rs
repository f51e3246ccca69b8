//! Probabilistic direct search from many starts on the sphere.
//!
//! Each start walks by a step along a random tangent direction or against it, as in seed 004's appendix (a two-point
//! probabilistic direct search), here on the sphere itself so that there is neither a pole nor a seam. Kinks do not
//! stop it, since no gradient is used; isolated dips at facet normals are out of its reach and belong to
//! [`directions`](super::directions).

use super::sphere::{lattice, tangents};
use super::trial::{Random, Trial};
use super::{Facets, Found, Minimum, Objective, Search, Stop};
use crate::geom::Vec3;

/// Multistart direct search.
#[derive(Clone, Copy, Debug)]
pub struct Multistart {
    /// How many starts, spread evenly (Fibonacci's lattice).
    pub starts: usize,
    /// Evaluations of one walk at most.
    pub budget: usize,
    /// Seed of the tangent directions.
    pub seed: u64,
}

impl Default for Multistart {
    fn default() -> Self {
        Self { starts: 32, budget: 400, seed: 1 }
    }
}

/// A walk ends when its step is below this (radians): 0.00006 degrees, less than a rotary word can say.
const LAST_STEP: f64 = 1e-6;

impl Search for Multistart {
    fn name(&self) -> &'static str {
        "multistart"
    }

    fn search(&self, objective: &dyn Objective, facets: &Facets) -> Found {
        let mut trial = Trial::new(objective, facets, self.starts.saturating_mul(self.budget));
        let (mut minima, mut stop) = (Vec::new(), Stop::Converged);
        for i in 0..self.starts {
            let (minimum, step) = self.walk(&mut trial, lattice(i, self.starts), i as u64);
            minima.push(minimum);
            stop = if step > LAST_STEP { Stop::Budget } else { stop };
        }
        trial.found(minima, None, stop)
    }
}

impl Multistart {
    /// One walk: where it ended, and its last step.
    fn walk(&self, trial: &mut Trial<'_>, start: Vec3, index: u64) -> (Minimum, f64) {
        let mut random = Random::seeded(self.seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ (index + 1));
        let mut at = trial.at(start);
        let mut step = 0.1;
        let mut left = self.budget.saturating_sub(1);
        while step > LAST_STEP && left > 1 {
            left -= 2;
            let better = polled(trial, &mut random, &at, step);
            if let Some(minimum) = better {
                at = minimum;
                step = (step * 2.0).min(0.2);
            } else {
                step *= 0.7;
            }
        }
        (at, step)
    }
}

/// The better of two steps along a random tangent and against it, where that is better than `at`.
fn polled(trial: &mut Trial<'_>, random: &mut Random, at: &Minimum, step: f64) -> Option<Minimum> {
    let [e1, e2] = tangents(&at.up);
    let (s, c) = (random.unit() * std::f64::consts::TAU).sin_cos();
    let along = (e1 * c + e2 * s) * step;
    let tries = [along, -along].map(|t| trial.at((at.up + t).normalize()));
    let better = tries.into_iter().filter(|m| m.value < at.value);
    better.min_by(|a, b| a.value.total_cmp(&b.value))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::orient::Staircase;

    #[test]
    fn finds_the_axis_of_a_round_bar() {
        let axis = Vec3::new(0.3, -0.5, 0.8).normalize();
        let e1 = axis.cross(&Vec3::x()).normalize();
        let e2 = axis.cross(&e1);
        let normals: Vec<Vec3> = (0..200)
            .map(|i| {
                let (s, c) = (std::f64::consts::TAU * f64::from(i) / 200.0).sin_cos();
                e1 * c + e2 * s
            })
            .collect();
        let facets = Facets::with(normals.clone(), vec![1.0; normals.len()], vec![]);
        let found = Multistart::default().search(&Staircase { layer_mm: 0.2 }, &facets);
        let best = found.minima[0].up;
        assert!(best.dot(&axis).abs() > 1.0 - 1e-9, "{best:?}");
        assert!(found.evaluations <= 32 * 400);
    }
}
