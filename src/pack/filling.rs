//! The most value in one run: by blocks, and now and then by boxes in an order of their own, changed a little at a time (simulated annealing over orders), the best of
//! all rules.

use super::fill::{RULES, Ready, one_by_one};
use super::instance::Placed;
use super::loading::Loading;
use super::spaces::{Rule, Run};
use super::watch::Watch;
use crate::geom::SplitMix64;

/// Steps with blocks for each with orders.
const BLOCKS_PER_ORDER: u64 = 32;
/// Steps between two questions of the orders' own watch.
const STEPS_ASKED: u64 = 4000;
/// Searches for one run, each with a wider beam than the one before, at most.
const MOST_WIDTHS: usize = 34;
/// Orders that are tried until the search begins anew from the best.
const ROUND: usize = 4000;

/// The fullest run that is found by blocks and by orders; ends where `bound` is met. Orders find what blocks do not where boxes are few.
pub(super) fn most(ready: &Ready, bound: f64, seed: u64, watch: &mut Watch<'_>) -> Vec<Placed> {
    let mut run = Run::empty(ready.space);
    let value = Way::first(ready, 0).value(ready, &mut run, RULES[0], watch);
    let mut best = (value, run.placed);
    let mut loading = Loading::of(ready, watch);
    let (mut begun, mut round, mut wider) = (watch.spent(), 0, true);
    while wider {
        wider = loading.wider(bound, watch);
        if loading.value() > best.0 {
            best = (loading.value(), loading.placed());
        }
        if best.0 >= bound * (1.0 - 1e-8) || !watch.goes_on() {
            return best.1;
        }
        let due = (watch.spent() - begun) / BLOCKS_PER_ORDER;
        if wider && due < (ROUND / 4 * ready.sizes.len()) as u64 {
            continue;
        }
        // What is left once there is nothing wider.
        let steps = if wider { due } else { u64::MAX };
        let mut asked = |_| (!watch.spend(STEPS_ASKED)).then(|| watch.ended());
        let found = fullest(ready, bound, seed.wrapping_add(round), &mut Watch::new(steps, &mut asked));
        let value = found.iter().map(|p| ready.values[p.item]).sum();
        if value > best.0 {
            best = (value, found);
        }
        (begun, round) = (watch.spent(), round + 1);
    }
    best.1
}

/// All boxes run after run, each filled by blocks as full as `widths` searches find it.
pub(super) fn by_blocks(ready: &Ready, widths: usize, watch: &mut Watch<'_>) -> Vec<Vec<Placed>> {
    let mut by_volume = ready.clone();
    by_volume.values.clone_from(&ready.volumes);
    let mut loading = Loading::of(&by_volume, watch);
    let mut runs = Vec::new();
    while !loading.left().is_empty() {
        let all: f64 = loading.left().iter().map(|&item| ready.volumes[item]).sum();
        for _ in 0..widths {
            if !loading.wider(all, watch) || loading.value() >= all * (1.0 - 1e-8) {
                break;
            }
        }
        if watch.ended_early() {
            break;
        }
        runs.push(loading.take());
    }
    // Where the watch ended, the others as they fit.
    let mut rest = loading.left();
    rest.sort_by(|&a, &b| ready.volumes[b].total_cmp(&ready.volumes[a]).then(a.cmp(&b)));
    runs.extend(one_by_one(ready, rest, RULES[0], watch));
    runs
}

/// As few runs as are found so, beginning with first fit, with wider and wider searches, until the watch ends or `bound` is met.
pub(super) fn fewest_by_blocks(ready: &Ready, bound: usize, watch: &mut Watch<'_>) -> Vec<Vec<Placed>> {
    let mut order: Vec<usize> = (0..ready.sizes.len()).collect();
    order.sort_by(|&a, &b| ready.volumes[b].total_cmp(&ready.volumes[a]).then(a.cmp(&b)));
    let mut best = one_by_one(ready, order, RULES[0], watch);
    for widths in 1..MOST_WIDTHS {
        if best.len() <= bound || !watch.goes_on() {
            break;
        }
        let found = by_blocks(ready, widths, watch);
        if found.len() < best.len() {
            best = found;
        }
    }
    best
}

/// The fullest run that is found by orders; ends where `bound` is met.
fn fullest(ready: &Ready, bound: f64, seed: u64, watch: &mut Watch<'_>) -> Vec<Placed> {
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
