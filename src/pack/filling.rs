//! The most value in one run: boxes in an order of their own, changed a little at a time (simulated annealing over orders), the best of
//! all rules.

use super::fill::{RULES, Ready};
use super::instance::Placed;
use super::spaces::{Rule, Run};
use super::watch::Watch;
use crate::geom::SplitMix64;

/// Orders that are tried until the search begins anew from the best.
const ROUND: usize = 4000;

/// The fullest run that is found; ends where `bound` is met.
pub(super) fn fullest(ready: &Ready, bound: f64, seed: u64, watch: &mut Watch<'_>) -> Vec<Placed> {
    let mut numbers = SplitMix64::seeded(seed);
    let mut run = Run::empty(ready.space);
    let mut best: (f64, Vec<Placed>) = (0.0, Vec::new());
    let met = |value: f64| value >= bound * (1.0 - 1e-8);
    for round in 0.. {
        let rule = RULES[round % RULES.len()];
        let mut here = Way::first(ready, round / RULES.len());
        let mut value = here.value(ready, &mut run, rule, watch);
        keep(&mut best, value, &run);
        // Warm enough at first to lose the least of the values now and then.
        let warmest = 0.05 * value.max(f64::MIN_POSITIVE);
        for step in 0..ROUND {
            if met(best.0) || !watch.spend(1) {
                return best.1;
            }
            let warm = warmest * (1.0 - step as f64 / ROUND as f64).powi(3);
            let there = here.changed(ready, &mut numbers);
            let worth = there.value(ready, &mut run, rule, watch);
            if worth >= value || numbers.unit() < ((worth - value) / warm.max(f64::MIN_POSITIVE)).exp() {
                (here, value) = (there, worth);
                keep(&mut best, value, &run);
            }
        }
    }
    best.1
}

/// An order of the boxes, and which of them must be turned how ([`Ready::fill`]).
#[derive(Clone)]
pub(super) struct Way {
    order: Vec<usize>,
    turns: Vec<u8>,
}

impl Way {
    /// By falling value, volume, value a volume, longest side.
    pub(super) fn first(ready: &Ready, which: usize) -> Self {
        let longest = |item: usize| ready.sizes[item].iter().flatten().copied().max().unwrap_or(0) as f64;
        let key = |item: usize| match which % 4 {
            0 => ready.values[item],
            1 => ready.volumes[item],
            2 => ready.values[item] / ready.volumes[item],
            _ => longest(item),
        };
        let mut order: Vec<usize> = (0..ready.sizes.len()).collect();
        order.sort_by(|&a, &b| key(b).total_cmp(&key(a)).then(a.cmp(&b)));
        Self { turns: vec![0; order.len()], order }
    }

    /// What the run then holds: first each box as it must be turned, then what is left as it fits.
    pub(super) fn value(&self, ready: &Ready, run: &mut Run, rule: Rule, watch: &mut Watch<'_>) -> f64 {
        run.clear();
        let mut left = self.order.clone();
        ready.fill(run, &mut left, &self.turns, rule, watch);
        if self.turns.iter().any(|&turn| turn > 0) {
            ready.fill(run, &mut left, &[], rule, watch);
        }
        run.placed.iter().map(|p| ready.values[p.item]).sum()
    }

    /// A box at another place of the order, or some in sequence turned another way.
    pub(super) fn changed(&self, ready: &Ready, numbers: &mut SplitMix64) -> Self {
        let mut next = self.clone();
        let count = next.order.len();
        let at = numbers.below(count);
        let turns = ready.sizes[next.order[at]].len();
        if turns > 1 && numbers.below(2) == 0 {
            let (turn, many) = (numbers.below(turns + 1) as u8, 1 + numbers.below(count.min(24)));
            for i in at..(at + many).min(count) {
                next.turns[next.order[i]] = turn;
            }
        } else {
            let item = next.order.remove(at);
            next.order.insert(numbers.below(count), item);
        }
        next
    }
}

fn keep(best: &mut (f64, Vec<Placed>), value: f64, run: &Run) {
    if value > best.0 {
        *best = (value, run.placed.clone());
    }
}
