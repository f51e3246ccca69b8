//! One search's evaluations: counted, limited, and the improvements among them remembered.

use super::{Facets, Found, Improvement, Minimum, Objective, Stop, distinct};
use crate::geom::Vec3;

/// What every search evaluates its objective through.
pub(super) struct Trial<'a> {
    f: &'a dyn Objective,
    facets: &'a Facets,
    budget: usize,
    spent: usize,
    best: f64,
    /// The largest size of a value so far.
    size: f64,
    history: Vec<Improvement>,
}

impl<'a> Trial<'a> {
    pub(super) fn new(f: &'a dyn Objective, facets: &'a Facets, budget: usize) -> Self {
        Self { f, facets, budget, spent: 0, best: f64::INFINITY, size: 0.0, history: Vec::new() }
    }

    /// The value at `up`; one evaluation.
    pub(super) fn value(&mut self, up: &Vec3) -> f64 {
        self.spent += 1;
        let value = self.f.value(self.facets, up);
        if value.is_finite() {
            self.size = self.size.max(value.abs());
        }
        if value < self.best {
            self.best = value;
            self.history.push(Improvement { evaluations: self.spent, value });
        }
        value
    }

    /// The place with its value; one evaluation.
    pub(super) fn at(&mut self, up: Vec3) -> Minimum {
        Minimum { up, value: self.value(&up) }
    }

    /// Value and gradient; one evaluation, since they share their work.
    pub(super) fn both(&mut self, up: &Vec3) -> (f64, Option<Vec3>) {
        let gradient = self.f.gradient(self.facets, up);
        (self.value(up), gradient)
    }

    /// Counts work that was no evaluation but took as long.
    pub(super) fn charge(&mut self) {
        self.spent += 1;
    }

    /// The largest size of a value so far: what rounding errors are measured by.
    pub(super) fn size(&self) -> f64 {
        self.size
    }

    /// How many evaluations are left.
    pub(super) fn left(&self) -> usize {
        self.budget.saturating_sub(self.spent)
    }

    pub(super) fn spent(&self) -> usize {
        self.spent
    }

    /// The answer, with the distinct ones of `minima`, best first.
    pub(super) fn found(self, minima: Vec<Minimum>, lower_bound: Option<f64>, stop: Stop) -> Found {
        Found { minima: distinct(minima), evaluations: self.spent, lower_bound, stop, history: self.history }
    }
}

/// `SplitMix64`: the same numbers from a seed on every machine.
pub(super) struct Random(u64);

impl Random {
    pub(super) fn seeded(seed: u64) -> Self {
        Self(seed)
    }

    /// Evenly from 0 to 1, 1 left out.
    pub(super) fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Evenly from 0 to below `count`; 0 for none.
    pub(super) fn below(&mut self, count: usize) -> usize {
        ((self.unit() * count as f64) as usize).min(count.saturating_sub(1))
    }

    /// Evenly over the sphere.
    pub(super) fn direction(&mut self) -> Vec3 {
        let (z, turn) = (2.0 * self.unit() - 1.0, std::f64::consts::TAU * self.unit());
        let r = (1.0 - z * z).max(0.0).sqrt();
        Vec3::new(r * turn.cos(), r * turn.sin(), z)
    }
}
