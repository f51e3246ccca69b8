//! MMLS: the multistart multisplit local search of Ramos et al. (2021) (algorithms 1 and 4, appendix A), for all local minima.
//!
//! Runs of a probabilistic direct search share their history. At each outer iteration every point ever evaluated goes to
//! the nearest run; a quadratic is fitted below each run's points by a linear program; where it does not fit, a new run
//! begins at one of those points. Runs that come near each other are merged, the worse one goes.
//!
//! What the paper leaves open is settled so: sufficient decrease is `1e-4 step^2`, steps double and halve, runs are kept in
//! the box by clamping (its edges and corners are minima of the paper's examples); a run that has converged keeps its
//! place among the at most 20, so that the search ends when all have; ties of the clustering go to the older run.

#[cfg(test)]
mod tests;
mod underestimate;

use super::sphere::from_angles;
use super::trial::Trial;
use super::{Facets, Found, Minimum, Objective, Search, Stop};
use crate::geom::SplitMix64;
use underestimate::misfit;

/// The search over a box of the two angles, degrees.
#[derive(Clone, Debug)]
pub struct Mmls {
    /// Least and largest `alpha` and `beta`.
    pub ranges_deg: [[f64; 2]; 2],
    /// Where runs begin at once, degrees.
    pub guesses_deg: Vec<[f64; 2]>,
    /// Points drawn before the first run; the best of them begins one.
    pub first: usize,
    /// Runs at most.
    pub runs: usize,
    /// Steps of each run in an outer iteration, and outer iterations.
    pub iterations: [usize; 2],
    /// First step and the one below which a run has converged, degrees.
    pub steps_deg: [f64; 2],
    /// Evaluations at most.
    pub budget: usize,
    /// Seed of all draws.
    pub seed: u64,
}

impl Mmls {
    /// As in Ramos et al. (2021), section 6.1: `[0, 180]^2`, which is a half of the sphere, enough for objectives that do not tell up
    /// from down, such as `staircase`.
    pub fn as_published() -> Self {
        Self {
            ranges_deg: [[0.0, 180.0]; 2],
            guesses_deg: vec![[0.0, 0.0], [180.0, 180.0], [0.0, 90.0], [90.0, 0.0]],
            first: 10,
            runs: 20,
            iterations: [10, 1000],
            steps_deg: [180.0 / 500.0, 1e-5],
            budget: 10_000,
            seed: 1,
        }
    }
}

impl Default for Mmls {
    /// The same over the whole sphere, from the six senses of the axes.
    fn default() -> Self {
        Self {
            ranges_deg: [[-180.0, 180.0], [-90.0, 90.0]],
            guesses_deg: vec![[0.0, 0.0], [180.0, 0.0], [90.0, 0.0], [-90.0, 0.0], [0.0, 90.0], [0.0, -90.0]],
            steps_deg: [360.0 / 500.0, 1e-5],
            ..Self::as_published()
        }
    }
}

type Angles = [f64; 2];

/// A local search and where it stands.
#[derive(Clone, Copy)]
struct Run {
    at: Angles,
    value: f64,
    step: f64,
}

/// A point that was evaluated; whether a run began at it.
#[derive(Clone, Copy)]
struct Point {
    at: Angles,
    value: f64,
    used: bool,
}

struct State<'a> {
    search: &'a Mmls,
    trial: Trial<'a>,
    random: SplitMix64,
    history: Vec<Point>,
    runs: Vec<Run>,
}

fn distance(a: Angles, b: Angles) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// How near two runs are one, and how far from a run another begins: appendix A.4, `step^2`, its root or twice it.
fn apart(step: f64) -> f64 {
    match step {
        s if s > 1.0 => s * s,
        s if s < 1.0 => s.sqrt(),
        s => 2.0 * s,
    }
}

impl Search for Mmls {
    fn name(&self) -> &'static str {
        "mmls"
    }

    fn search(&self, objective: &dyn Objective, facets: &Facets) -> Found {
        let trial = Trial::new(objective, facets, self.budget);
        let random = SplitMix64::seeded(self.seed);
        let mut state = State { search: self, trial, random, history: Vec::new(), runs: Vec::new() };
        state.begin();
        let stop = state.iterate();
        let minimum = |run: &Run| Minimum { up: up(run.at), value: run.value, ended: run.step < self.steps_deg[1] };
        let minima = state.runs.iter().map(minimum).collect();
        state.trial.found(minima, None, stop)
    }
}

fn up(at: Angles) -> crate::geom::Vec3 {
    from_angles(at[0].to_radians(), at[1].to_radians())
}

impl State<'_> {
    fn evaluate(&mut self, at: Angles) -> f64 {
        let value = self.trial.value(&up(at));
        self.history.push(Point { at, value, used: false });
        value
    }

    fn start(&mut self, at: Angles, value: f64) {
        self.runs.push(Run { at, value, step: self.search.steps_deg[0] });
        self.history.iter_mut().filter(|p| p.at == at).for_each(|p| p.used = true);
    }

    fn anywhere(&mut self) -> Angles {
        self.search.ranges_deg.map(|[low, high]| low + (high - low) * self.random.unit())
    }

    fn begin(&mut self) {
        for _ in 0..self.search.first.max(1) {
            let at = self.anywhere();
            self.evaluate(at);
        }
        let best = self.history.iter().copied().min_by(|a, b| a.value.total_cmp(&b.value));
        if let Some(best) = best {
            self.start(best.at, best.value);
        }
        for at in self.search.guesses_deg.clone() {
            let value = self.evaluate(at);
            self.start(at, value);
        }
    }

    fn iterate(&mut self) -> Stop {
        for _ in 0..self.search.iterations[1] {
            self.split();
            let last = self.search.steps_deg[1];
            if self.runs.iter().all(|run| run.step < last) {
                return Stop::Converged;
            }
            for i in 0..self.runs.len() {
                for _ in 0..self.search.iterations[0] {
                    if self.runs[i].step < last {
                        break;
                    }
                    if self.trial.left() < 2 {
                        return Stop::Budget;
                    }
                    self.step(i);
                }
            }
            self.merge();
        }
        Stop::Budget
    }

    /// New runs in the clusters that their quadratics do not fit.
    fn split(&mut self) {
        let mut clusters = vec![Vec::new(); self.runs.len()];
        for (i, point) in self.history.iter().enumerate() {
            let to = |run: &Run| distance(run.at, point.at);
            let nearest = (0..self.runs.len()).min_by(|&a, &b| to(&self.runs[a]).total_cmp(&to(&self.runs[b])));
            clusters[nearest.unwrap_or(0)].push(i);
        }
        for (j, cluster) in clusters.into_iter().enumerate() {
            if self.runs.len() >= self.search.runs || self.trial.left() < 2 {
                return;
            }
            let points: Vec<(Angles, f64)> =
                cluster.iter().map(|&i| (self.history[i].at, self.history[i].value)).collect();
            if misfit(&points) <= self.runs[j].step {
                continue;
            }
            let (from, least) = (self.runs[j].at, apart(self.runs[j].step));
            let fresh = |i: &&usize| !self.history[**i].used && distance(self.history[**i].at, from) >= least;
            let fresh: Vec<usize> = cluster.iter().filter(fresh).copied().collect();
            if fresh.is_empty() {
                let mut at = self.anywhere();
                for _ in 0..100 {
                    if distance(at, from) >= least {
                        break;
                    }
                    at = self.anywhere();
                }
                let value = self.evaluate(at);
                self.start(at, value);
            } else {
                let point = self.history[fresh[self.random.below(fresh.len())]];
                self.start(point.at, point.value);
            }
        }
    }

    /// One iteration of the direct search: a random direction and its opposite (A.4).
    fn step(&mut self, i: usize) {
        let run = self.runs[i];
        let (s, c) = (std::f64::consts::TAU * self.random.unit()).sin_cos();
        let ranges = self.search.ranges_deg;
        let mut better = None;
        for sense in [1.0, -1.0] {
            let at = [0, 1].map(|k| (run.at[k] + sense * run.step * [c, s][k]).clamp(ranges[k][0], ranges[k][1]));
            let value = self.evaluate(at);
            if value < run.value - 1e-4 * (run.step * run.step).min(run.value.abs()) {
                better = Some(Run { at, value, step: 2.0 * run.step });
                break;
            }
        }
        self.runs[i] = better.unwrap_or(Run { step: 0.5 * run.step, ..run });
    }

    /// Of two runs within the larger of their distances the worse one goes.
    fn merge(&mut self) {
        let mut kept: Vec<Run> = Vec::new();
        let mut order = self.runs.clone();
        order.sort_by(|a, b| a.value.total_cmp(&b.value));
        for run in order {
            let near = |k: &Run| distance(k.at, run.at) <= apart(k.step.max(run.step));
            if !kept.iter().any(near) {
                kept.push(run);
            }
        }
        self.runs = kept;
    }
}
