//! The most value in one run: boxes in an order of their own, changed a little at a time (simulated annealing over orders), the best of
//! all rules.

use super::fill::{RULES, Ready};
use super::instance::Placed;
use super::spaces::Run;
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
        let mut order = first_order(ready, round / RULES.len());
        let mut here = value(ready, &mut run, &order, rule, watch);
        keep(&mut best, here, &run);
        // Warm enough at first to lose the least of the values now and then.
        let warmest = 0.05 * here.max(f64::MIN_POSITIVE);
        for step in 0..ROUND {
            if met(best.0) || !watch.spend(1) {
                return best.1;
            }
            let warm = warmest * (1.0 - step as f64 / ROUND as f64).powi(3);
            let undo = change(&mut order, &mut numbers);
            let there = value(ready, &mut run, &order, rule, watch);
            if there >= here || numbers.unit() < ((there - here) / warm.max(f64::MIN_POSITIVE)).exp() {
                here = there;
                keep(&mut best, here, &run);
            } else {
                undo_change(&mut order, undo);
            }
        }
    }
    best.1
}

/// By falling value, volume, value a volume, longest side.
fn first_order(ready: &Ready, which: usize) -> Vec<usize> {
    let longest = |item: usize| ready.sizes[item].iter().flatten().copied().max().unwrap_or(0) as f64;
    let key = |item: usize| match which % 4 {
        0 => ready.values[item],
        1 => ready.volumes[item],
        2 => ready.values[item] / ready.volumes[item],
        _ => longest(item),
    };
    let mut order: Vec<usize> = (0..ready.sizes.len()).collect();
    order.sort_by(|&a, &b| key(b).total_cmp(&key(a)).then(a.cmp(&b)));
    order
}

fn value(ready: &Ready, run: &mut Run, order: &[usize], rule: super::spaces::Rule, watch: &mut Watch<'_>) -> f64 {
    run.clear();
    ready.fill(run, &mut order.to_vec(), rule, watch);
    run.placed.iter().map(|p| ready.values[p.item]).sum()
}

fn keep(best: &mut (f64, Vec<Placed>), value: f64, run: &Run) {
    if value > best.0 {
        *best = (value, run.placed.clone());
    }
}

/// Moves a box to another place of the order: from where to where.
fn change(order: &mut Vec<usize>, numbers: &mut SplitMix64) -> [usize; 2] {
    let moved = [numbers.below(order.len()), numbers.below(order.len())];
    let item = order.remove(moved[0]);
    order.insert(moved[1], item);
    moved
}

fn undo_change(order: &mut Vec<usize>, [from, to]: [usize; 2]) {
    let item = order.remove(to);
    order.insert(from, item);
}
