//! Descents from many starts on the sphere: along the gradient, or by a probabilistic direct search.
//!
//! The direct search walks by a step along a random tangent direction or against it, as in Ramos et al.'s (2021) appendix (a two-point
//! probabilistic direct search), here on the sphere itself so that there is neither a pole nor a seam. Kinks do not
//! stop it, since no gradient is used; isolated dips at facet normals are out of its reach and belong to
//! [`directions`](super::directions).

use std::f64::consts::{PI, TAU};

use super::evolution::latin;
use super::gradient::{GradientMethod, follow};
use super::nelder_mead::descend;
use super::sphere::{from_angles, lattice, tangents};
use super::trial::Trial;
use super::{Facets, Found, Minimum, Objective, Search, Stop};
use crate::geom::{SplitMix64, Vec3};

/// Multistart direct search.
#[derive(Clone, Copy, Debug)]
pub struct Multistart {
    /// How many starts.
    pub starts: usize,
    /// Evaluations of one walk at most.
    pub budget: usize,
    /// Seed of the starts that are drawn, and of the tangent directions.
    pub seed: u64,
    /// Where they start.
    pub from: Starts,
    /// Down the gradient, and by a simplex where a kink ends that; a direct search where there is none.
    pub descent: Option<GradientMethod>,
}

/// Where a multistart starts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Starts {
    /// Spread evenly: Fibonacci's lattice.
    Lattice,
    /// The centres of a grid in the two angles, twice as many in alpha as in beta. (de Castro's (2020) 32 starts are meant so, but
    /// by a slip, `(i + h) / 2` for `i + h / 2`, they are not, and miss the optimum of one of its parts.)
    GridCentres,
    /// A Latin hypercube over the sphere.
    LatinHypercube,
    /// Drawn evenly from the sphere.
    Random,
}

impl Starts {
    fn directions(self, count: usize, seed: u64) -> Vec<Vec3> {
        let mut random = SplitMix64::seeded(seed);
        let rows = ((count as f64 / 2.0).sqrt().round() as usize).max(1);
        let turns = count.div_ceil(rows);
        let step = |i: usize, of: usize| (i as f64 + 0.5) / of as f64 - 0.5;
        let centre = |i: usize| from_angles(TAU * step(i % turns, turns), PI * step(i / turns, rows));
        match self {
            Self::Lattice => (0..count).map(|i| lattice(i, count)).collect(),
            Self::GridCentres => (0..count).map(centre).collect(),
            Self::LatinHypercube => latin(&mut random, count).into_iter().map(|[a, b]| from_angles(a, b)).collect(),
            Self::Random => (0..count).map(|_| random.direction()).collect(),
        }
    }
}

impl Default for Multistart {
    fn default() -> Self {
        Self { starts: 32, budget: 400, seed: 1, from: Starts::Lattice, descent: None }
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
        for (i, start) in self.from.directions(self.starts, self.seed).into_iter().enumerate() {
            let (minimum, ended) = match self.descent {
                Some(method) => self.descend(&mut trial, method, start),
                None => self.walk(&mut trial, start, i as u64),
            };
            minima.push(minimum);
            stop = if ended == Stop::Budget { ended } else { stop };
        }
        trial.found(minima, None, stop)
    }
}

impl Multistart {
    /// Down the gradient, the last part by a simplex.
    fn descend(&self, trial: &mut Trial<'_>, method: GradientMethod, start: Vec3) -> (Minimum, Stop) {
        let before = trial.spent();
        let (low, stop) = follow(trial, method, start, self.budget * 2 / 3);
        let left = self.budget.saturating_sub(trial.spent() - before);
        if left < 12 {
            return (low, Stop::Budget);
        }
        let ended = descend(trial, low.up, left, LAST_STEP);
        (if ended.value < low.value { ended } else { low }, stop)
    }

    /// One direct search.
    fn walk(&self, trial: &mut Trial<'_>, start: Vec3, index: u64) -> (Minimum, Stop) {
        let mut random = SplitMix64::seeded(self.seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ (index + 1));
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
        (at, if step > LAST_STEP { Stop::Budget } else { Stop::Converged })
    }
}

/// The better of two steps along a random tangent and against it, where that is better than `at`.
fn polled(trial: &mut Trial<'_>, random: &mut SplitMix64, at: &Minimum, step: f64) -> Option<Minimum> {
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
