//! The least number of runs, by emptying one: its boxes wait outside, and runs are packed anew with some of them until none waits.
//!
//! A step takes one to three runs and some boxes that wait, packs them in a random order by a random rule, and keeps the result where what
//! waits then weighs less, or not much more as the search is warm (simulated annealing). A box weighs its volume, and more the
//! longer it has waited (Nagata and Bräysy's ejection pool, "A powerful route minimization heuristic", 2009). Each time nothing waits, a run is saved.

use super::fill::{RULES, Ready};
use super::instance::Placed;
use super::spaces::Run;
use super::watch::Watch;
use crate::geom::SplitMix64;

/// Steps without a better state until the search warms up again.
const COOL_AFTER: u32 = 3000;
/// How much what waits may grow at the warmest, mean boxes.
const WARMEST: f64 = 0.3;
/// What a box gains in weight each time the search warms up while it waits.
const HEAVIER: f64 = 1.15;
/// Waiting boxes taken into a step, at most.
const MOST_TAKEN: usize = 8;

/// `runs` with as many fewer as are found before the watch ends or `bound` is met.
pub(super) fn fewer(
    ready: &Ready,
    mut runs: Vec<Vec<Placed>>,
    bound: usize,
    seed: u64,
    watch: &mut Watch<'_>,
) -> Vec<Vec<Placed>> {
    let mut numbers = SplitMix64::seeded(seed);
    while runs.len() > bound.max(1) {
        let Some(less) = one_fewer(ready, &runs, &mut numbers, watch) else { break };
        runs = less;
    }
    runs
}

struct Search<'a> {
    ready: &'a Ready,
    runs: Vec<Vec<Placed>>,
    waiting: Vec<usize>,
    weights: Vec<f64>,
    scratch: [Run; 3],
    /// Which turn a box must have in this step; see [`Ready::fill`].
    turns: Vec<u8>,
}

/// `runs` with one fewer; `None` where the watch ended before.
fn one_fewer(
    ready: &Ready,
    runs: &[Vec<Placed>],
    numbers: &mut SplitMix64,
    watch: &mut Watch<'_>,
) -> Option<Vec<Vec<Placed>>> {
    let content = |run: &Vec<Placed>| run.iter().map(|p| ready.volumes[p.item]).sum::<f64>();
    let emptied = (0..runs.len()).min_by(|&a, &b| content(&runs[a]).total_cmp(&content(&runs[b])))?;
    let mut kept = runs.to_vec();
    let waiting = kept.swap_remove(emptied).iter().map(|p| p.item).collect();
    let mean = ready.volumes.iter().sum::<f64>() / ready.volumes.len() as f64;
    let weights = ready.volumes.iter().map(|v| v / mean).collect();
    let scratch = [(); 3].map(|()| Run::empty(ready.space));
    let mut search = Search { ready, runs: kept, waiting, weights, scratch, turns: vec![0; ready.sizes.len()] };
    search.go(numbers, watch).then_some(search.runs)
}

impl Search<'_> {
    fn go(&mut self, numbers: &mut SplitMix64, watch: &mut Watch<'_>) -> bool {
        let (mut quiet, mut least) = (0, f64::INFINITY);
        while !self.waiting.is_empty() {
            if !watch.spend(1) {
                return false;
            }
            // Cooling as far as nothing better comes; then warm again, with what waits weighing more.
            let warm = WARMEST * (1.0 - f64::from(quiet) / f64::from(COOL_AFTER)).powi(2);
            self.step(warm, numbers, watch);
            let now = self.weight(&self.waiting);
            quiet += 1;
            if now < least - 1e-9 {
                (least, quiet) = (now, 0);
            }
            if quiet >= COOL_AFTER {
                self.waiting.iter().for_each(|&item| self.weights[item] *= HEAVIER);
                (quiet, least) = (0, f64::INFINITY);
            }
        }
        true
    }

    fn weight(&self, items: &[usize]) -> f64 {
        items.iter().map(|&item| self.weights[item]).sum()
    }

    /// Packs some runs anew with some of what waits.
    fn step(&mut self, warm: f64, numbers: &mut SplitMix64, watch: &mut Watch<'_>) {
        let many = match numbers.below(10) {
            0..5 => 1,
            5..9 => 2,
            _ => 3,
        };
        let chosen = some_of(self.runs.len(), many.min(self.runs.len()), numbers);
        let taken = some_of(self.waiting.len(), self.waiting.len().min(MOST_TAKEN), numbers);
        let mut order: Vec<usize> = chosen.iter().flat_map(|&run| self.runs[run].iter().map(|p| p.item)).collect();
        order.extend(taken.iter().map(|&i| self.waiting[i]));
        self.shuffle(&mut order, numbers);
        let pool = order.clone();
        if numbers.below(2) == 0 {
            for &item in pool.iter().filter(|item| self.ready.sizes[**item].len() > 1) {
                self.turns[item] = numbers.below(self.ready.sizes[item].len() + 1) as u8;
            }
        }
        for i in 0..chosen.len() {
            let rule = RULES[numbers.below(RULES.len())];
            self.scratch[i].clear();
            self.ready.fill(&mut self.scratch[i], &mut order, &self.turns, rule, watch);
        }
        pool.iter().for_each(|&item| self.turns[item] = 0);
        let before: f64 = taken.iter().map(|&i| self.weights[self.waiting[i]]).sum();
        let more = self.weight(&order) - before;
        if more > 0.0 && more > -warm * (1.0 - numbers.unit()).ln() {
            return;
        }
        for (&run, made) in chosen.iter().zip(&mut self.scratch) {
            std::mem::swap(&mut self.runs[run], &mut made.placed);
        }
        let mut index = 0;
        self.waiting.retain(|_| {
            index += 1;
            !taken.contains(&(index - 1))
        });
        self.waiting.append(&mut order);
    }

    /// By falling volume, more or less; sometimes by another length.
    fn shuffle(&self, order: &mut [usize], numbers: &mut SplitMix64) {
        let spread = [0.1, 0.4, 1.0][numbers.below(3)];
        let axis = numbers.below(6);
        let mut keyed: Vec<(f64, usize)> = order
            .iter()
            .map(|&item| {
                let sizes = &self.ready.sizes[item];
                let own = match sizes.first() {
                    Some(size) if axis < 3 => size[axis] as f64 / self.ready.space[axis] as f64,
                    _ => self.ready.volumes[item],
                };
                (own.max(1e-12).ln() + spread * (2.0 * numbers.unit() - 1.0), item)
            })
            .collect();
        keyed.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        order.iter_mut().zip(keyed).for_each(|(place, (_, item))| *place = item);
    }
}

/// `count` different numbers below `of`.
fn some_of(of: usize, count: usize, numbers: &mut SplitMix64) -> Vec<usize> {
    let mut chosen: Vec<usize> = Vec::with_capacity(count);
    while chosen.len() < count {
        let next = numbers.below(of);
        if !chosen.contains(&next) {
            chosen.push(next);
        }
    }
    chosen
}
