//! Differential evolution, the population search that Boogers (2024) compares with.
//!
//! Source: R. Storn, K. Price, *Differential evolution*, Journal of Global Optimization 11 (1997), 341-359; variant
//! best/1/bin with a factor drawn anew each generation, as `SciPy` has it.

use std::f64::consts::{FRAC_PI_2, PI};

use super::trial::Trial;
use super::{Facets, Found, Minimum, Objective, Search, Stop, from_angles};
use crate::geom::SplitMix64;

/// Differential evolution over the two angles; gives the best direction alone.
#[derive(Clone, Copy, Debug)]
pub struct DifferentialEvolution {
    /// Members of the population, at least 4.
    pub population: usize,
    /// Evaluations at most.
    pub budget: usize,
    /// Seed of all draws.
    pub seed: u64,
}

impl Default for DifferentialEvolution {
    fn default() -> Self {
        Self { population: 30, budget: 5000, seed: 1 }
    }
}

/// Values that spread less than this about their mean, relative, have converged.
const SPREAD: f64 = 0.01;
/// How often an angle is taken from the mutant.
const CROSSOVER: f64 = 0.7;

#[derive(Clone, Copy)]
struct Member {
    /// `alpha`, `beta`, radians.
    angles: [f64; 2],
    found: Minimum,
}

impl Search for DifferentialEvolution {
    fn name(&self) -> &'static str {
        "differential-evolution"
    }

    fn search(&self, objective: &dyn Objective, facets: &Facets) -> Found {
        let mut trial = Trial::new(objective, facets, self.budget.max(4));
        let mut random = SplitMix64::seeded(self.seed);
        let count = self.population.clamp(4, trial.left());
        let starts = latin(&mut random, count);
        let member = |trial: &mut Trial<'_>, angles: [f64; 2]| Member {
            angles,
            found: trial.at(from_angles(angles[0], angles[1])),
        };
        let mut all: Vec<Member> = starts.into_iter().map(|angles| member(&mut trial, angles)).collect();
        let stop = loop {
            if has_converged(&all) {
                break Stop::Converged;
            }
            if trial.left() < count {
                break Stop::Budget;
            }
            let factor = 0.5 + 0.5 * random.unit();
            for i in 0..count {
                let tried = mutant(&all, i, factor, &mut random);
                let tried = member(&mut trial, tried);
                if tried.found.value <= all[i].found.value {
                    all[i] = tried;
                }
            }
        };
        let best = all.iter().map(|m| m.found).min_by(|a, b| a.value.total_cmp(&b.value));
        trial.found(best.into_iter().collect(), None, stop)
    }
}

/// A Latin hypercube over the angles, even over the sphere: each of `count` rows and columns once.
pub(super) fn latin(random: &mut SplitMix64, count: usize) -> Vec<[f64; 2]> {
    let mut columns: Vec<usize> = (0..count).collect();
    for i in (1..count).rev() {
        columns.swap(i, random.below(i + 1));
    }
    let share = |random: &mut SplitMix64, i: usize| (i as f64 + random.unit()) / count as f64;
    let angles = |(row, column): (usize, usize)| {
        let (turn, height) = (share(random, row), share(random, column));
        [(2.0 * turn - 1.0) * PI, (2.0 * height - 1.0).asin()]
    };
    columns.into_iter().enumerate().map(angles).collect()
}

fn has_converged(all: &[Member]) -> bool {
    let count = all.len() as f64;
    let mean = all.iter().map(|m| m.found.value).sum::<f64>() / count;
    let square = all.iter().map(|m| (m.found.value - mean).powi(2)).sum::<f64>() / count;
    square.sqrt() <= SPREAD * mean.abs()
}

/// The best and a difference of two others, mixed with member `i`; angles beyond the range come in on the other side.
fn mutant(all: &[Member], i: usize, factor: f64, random: &mut SplitMix64) -> [f64; 2] {
    let best = all.iter().min_by(|a, b| a.found.value.total_cmp(&b.found.value)).unwrap_or(&all[i]);
    let mut other = || loop {
        let j = random.below(all.len());
        if j != i {
            break &all[j];
        }
    };
    let (a, b) = (other(), other());
    let sure = random.below(2);
    let mut angles = all[i].angles;
    for k in 0..2 {
        if k == sure || random.unit() < CROSSOVER {
            let half = [PI, FRAC_PI_2][k];
            let moved = best.angles[k] + factor * (a.angles[k] - b.angles[k]);
            angles[k] = (moved + half).rem_euclid(2.0 * half) - half;
        }
    }
    angles
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Vec3;
    use crate::orient::NormalZ;

    #[test]
    fn comes_near_the_smallest_eigenvector_and_is_repeated_by_its_seed() {
        let e = [Vec3::new(2.0, 1.0, -1.0).normalize(), Vec3::new(1.0, -1.0, 1.0).normalize()];
        let last = e[0].cross(&e[1]);
        let facets = Facets::with([vec![e[0]; 5], vec![e[1]; 3], vec![last]].concat(), vec![1.0; 9], vec![]);
        let search = DifferentialEvolution::default();
        let found = search.search(&NormalZ, &facets);
        assert!((found.minima[0].value - 1.0).abs() < 0.02, "{found:?}");
        assert!(found.evaluations <= search.budget && found.stop == Stop::Converged);
        assert_eq!(found, search.search(&NormalZ, &facets));
        assert_ne!(found.history, DifferentialEvolution { seed: 2, ..search }.search(&NormalZ, &facets).history);
    }

    #[test]
    fn a_latin_hypercube_has_each_row_and_column_once() {
        let all = latin(&mut SplitMix64::seeded(5), 50);
        for k in 0..2 {
            let row = |a: &[f64; 2]| (25.0 * (if k == 0 { a[0] / PI } else { a[1].sin() } + 1.0)) as usize;
            let mut rows: Vec<usize> = all.iter().map(row).collect();
            rows.sort_unstable();
            assert_eq!(rows, (0..50).collect::<Vec<_>>());
        }
    }
}
