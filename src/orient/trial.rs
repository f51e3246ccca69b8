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
        Minimum { up, value: self.value(&up), ended: true }
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
