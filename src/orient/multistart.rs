//! Probabilistic direct search from many starts on the sphere.
//!
//! Each start walks by a step along a random tangent direction or against it, as in seed 004's appendix (a two-point
//! probabilistic direct search), here on the sphere itself so that there is neither a pole nor a seam. Kinks do not
//! stop it, since no gradient is used; isolated dips at facet normals are out of its reach and belong to
//! [`directions`](super::directions).

use super::sphere::{lattice, tangents};
use super::{Facets, Found, Minimum, Objective, Search, Stop, distinct};
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
        let mut evaluations = 0;
        let minima = (0..self.starts)
            .map(|i| self.walk(objective, facets, lattice(i, self.starts), i as u64, &mut evaluations))
            .collect();
        Found { minima: distinct(minima), evaluations, lower_bound: None, stop: Stop::Converged }
    }
}

impl Multistart {
    fn walk(&self, f: &dyn Objective, facets: &Facets, start: Vec3, index: u64, spent: &mut usize) -> Minimum {
        let mut random = Random(self.seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ (index + 1));
        let mut at = Minimum { up: start, value: f.value(facets, &start) };
        let mut step = 0.1;
        let mut left = self.budget;
        while step > LAST_STEP && left > 1 {
            let tangent = random.tangent(&at.up);
            let tries = [tangent, -tangent].map(|t| (at.up + t * step).normalize());
            left -= 2;
            *spent += 2;
            let better = tries
                .map(|up| Minimum { up, value: f.value(facets, &up) })
                .into_iter()
                .filter(|m| m.value < at.value)
                .min_by(|a, b| a.value.total_cmp(&b.value));
            match better {
                Some(minimum) => {
                    at = minimum;
                    step = (step * 2.0).min(0.2);
                }
                None => step *= 0.7,
            }
        }
        at
    }
}

/// A 64-bit linear congruential generator: all that spreading directions asks for.
struct Random(u64);

impl Random {
    fn angle(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64 * std::f64::consts::TAU
    }

    fn tangent(&mut self, up: &Vec3) -> Vec3 {
        let [e1, e2] = tangents(up);
        let (s, c) = self.angle().sin_cos();
        e1 * c + e2 * s
    }
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
