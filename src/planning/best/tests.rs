//! Plans and proofs against every sequence there is, on made-up problems.

use std::collections::{BTreeMap, BTreeSet};

use super::*;
use crate::planning::sequence::tests::{Made, by_definition, in_order, is_in_order, made, problem};

/// Prices drawn from a seed; whole, so that sums can be compared exactly.
fn ranks(made: &Made, seed: u64) -> Vec<Rank> {
    let mut word = seed;
    let mut random = |below: u64| {
        word = SplitMix64::seeded(word).word();
        (word % below) as f64
    };
    let count = 1 + seed as usize % 3;
    let rank = |_| Rank {
        waiting: random(3),
        slot: random(4),
        setup: random(5),
        price: made.candidates.iter().map(|c| c.iter().map(|_| random(7) - 2.0).collect()).collect(),
    };
    (0..count).map(rank).collect()
}

/// What a sequence costs, straight from the definition.
fn cost(sequence: &Sequence, made: &Made, ranks: &[Rank]) -> Vec<f64> {
    let of = |rank: &Rank| {
        let mut sum = 0.0;
        let mut table = None;
        for (t, slot) in sequence.iter().enumerate() {
            sum += rank.slot;
            for &(part, k) in slot {
                let setup = made.candidates[part][k].setup;
                if table != Some(setup) {
                    sum += rank.setup;
                    table = Some(setup);
                }
                sum += rank.price[part][k] + rank.waiting * t as f64;
            }
        }
        sum
    };
    ranks.iter().map(of).collect()
}

fn less(a: &[f64], b: &[f64]) -> std::cmp::Ordering {
    a.iter().zip(b).map(|(a, b)| a.total_cmp(b)).find(|o| o.is_ne()).unwrap_or(std::cmp::Ordering::Equal)
}

const ROOM: SearchLimits = SearchLimits { plans: 1, steps: u64::MAX, states: usize::MAX };

#[test]
fn the_best_plan_is_the_best_of_all_sequences() {
    let (mut feasible, mut infeasible) = (0, 0);
    for seed in 0..600 {
        let made = made(seed, 3 + (seed % 3) as usize);
        let ranks = ranks(&made, seed);
        let tariff = Tariff::of(&ranks);
        for priority in [Priority::Together, Priority::OnlySingle] {
            let problem = problem(&made, seed % 4 != 0, priority);
            let mut all = BTreeSet::new();
            by_definition(&problem, &Vec::new(), &[], &mut all);
            let wanted = all.iter().map(|s| cost(s, &made, &ranks)).min_by(|a, b| less(a, b));
            let got = best(&problem, &tariff, &ROOM);
            assert!(got.proved);
            match (wanted, got.plans.first()) {
                (None, None) => infeasible += 1,
                (Some(wanted), Some((_, sequence))) => {
                    feasible += 1;
                    assert!(all.iter().any(|s| canonical(s) == canonical(sequence)), "seed {seed}: {sequence:?}");
                    assert_eq!(cost(sequence, &made, &ranks), wanted, "seed {seed} {priority:?}: {sequence:?}");
                }
                (wanted, got) => panic!("seed {seed} {priority:?}: wanted {wanted:?}, got {got:?}"),
            }
        }
    }
    assert!(feasible > 200 && infeasible > 200, "{feasible} feasible, {infeasible} not: the test has grown blunt");
}

#[test]
fn the_best_plan_in_a_demanded_order_is_the_best_of_all_that_have_it() {
    let (mut feasible, mut dearer) = (0, 0);
    for seed in 0..600 {
        let free = made(seed, 3 + (seed % 3) as usize);
        let (ordered, steps) = in_order(&free, seed);
        let ranks = ranks(&free, seed);
        let tariff = Tariff::of(&ranks);
        for priority in [Priority::Together, Priority::OnlySingle] {
            let mut all = BTreeSet::new();
            by_definition(&problem(&free, false, priority), &Vec::new(), &[], &mut all);
            let cheapest =
                |of: &mut dyn Iterator<Item = &Sequence>| of.map(|s| cost(s, &free, &ranks)).min_by(|a, b| less(a, b));
            let wanted = cheapest(&mut all.iter().filter(|one| is_in_order(one, &steps)));
            let got = best(&problem(&ordered, false, priority), &tariff, &ROOM);
            assert!(got.proved);
            let found = got.plans.first().map(|(_, sequence)| {
                assert!(is_in_order(sequence, &steps), "seed {seed}: {sequence:?}");
                cost(sequence, &free, &ranks)
            });
            assert_eq!(found, wanted, "seed {seed} {priority:?} {steps:?}");
            feasible += usize::from(wanted.is_some());
            dearer += usize::from(wanted.is_some() && wanted != cheapest(&mut all.iter()));
        }
    }
    assert!(feasible > 150 && dearer > 30, "{feasible} feasible, {dearer} dearer: the test has grown blunt");
}

#[test]
fn the_best_k_plans_are_the_first_k_of_all_distinct_ones() {
    let mut compared = 0;
    for seed in 0..1500 {
        let made = made(seed, 3 + (seed % 3) as usize);
        let ranks = ranks(&made, seed);
        let problem = problem(&made, true, Priority::Together);
        let mut all = BTreeSet::new();
        by_definition(&problem, &Vec::new(), &[], &mut all);
        let mut distinct: BTreeMap<Sequence, Vec<f64>> = BTreeMap::new();
        for sequence in &all {
            let of_this = cost(sequence, &made, &ranks);
            let known = distinct.entry(canonical(sequence)).or_insert_with(|| of_this.clone());
            if less(&of_this, known).is_lt() {
                *known = of_this;
            }
        }
        let mut wanted: Vec<Vec<f64>> = distinct.into_values().collect();
        wanted.sort_by(|a, b| less(a, b));
        wanted.truncate(5);
        let got = best(&problem, &Tariff::of(&ranks), &SearchLimits { plans: 5, ..ROOM });
        let costs: Vec<Vec<f64>> = got.plans.iter().map(|(_, s)| cost(s, &made, &ranks)).collect();
        assert_eq!(costs, wanted, "seed {seed}");
        compared += usize::from(wanted.len() == 5);
    }
    assert!(compared > 60, "{compared} problems with five plans: the test has grown blunt");
}

#[test]
fn a_bound_cut_short_is_still_a_bound() {
    for seed in 0..200 {
        let made = made(seed, 5);
        let ranks = ranks(&made, seed);
        let tariff = Tariff::of(&ranks);
        let problem = problem(&made, true, Priority::Together);
        let whole = best(&problem, &tariff, &ROOM);
        for steps in [0, 10, 40, 160] {
            let short = best(&problem, &tariff, &SearchLimits { steps, ..ROOM });
            if let (Some((cost, _)), Some(bound)) = (whole.plans.first(), short.bound) {
                assert!(short.proved || bound <= *cost, "seed {seed}, {steps} steps: {bound:?} above {cost:?}");
            }
        }
    }
}
