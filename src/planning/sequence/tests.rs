//! The search against its own definition on made-up problems, and the two studies of Ramos et al. (2021), section 5.4.

use std::collections::BTreeSet;

use super::*;
use crate::geom::Dir;
use crate::motion::Pose;
use crate::planning::support::Needs;

/// A small problem made up from a seed.
pub(in crate::planning) struct Made {
    pub(in crate::planning) candidates: Vec<Vec<Candidate>>,
    pub(in crate::planning) blocked: Vec<Vec<PartSet>>,
    touching: Vec<PartSet>,
    on_table: PartSet,
}

pub(in crate::planning) fn made(seed: u64, parts: usize) -> Made {
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
    let mut random = |below: u64| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) % below
    };
    let mut touching = vec![PartSet::new(parts); parts];
    for part in 1..parts {
        let other = random(part as u64) as usize;
        touching[part].insert(other);
        touching[other].insert(part);
    }
    let mut on_table = PartSet::new(parts);
    on_table.insert(0);
    if random(2) == 0 {
        on_table.insert(1);
    }
    let (mut candidates, mut blocked) = (Vec::new(), Vec::new());
    for part in 0..parts {
        let ways = 1 + random(2) as usize;
        let setups: BTreeSet<usize> = (0..ways).map(|_| random(3) as usize).collect();
        let mut of = |&setup: &usize| {
            let (up, pose) = (Dir::z(), Pose::LEVEL);
            let mut needs = || match random(4) {
                0 if part > 1 => Needs::carried_by(random(part as u64) as usize),
                _ => Needs::none(),
            };
            Candidate { up, pose, setup, value: 0.0, needs: needs() }
        };
        candidates.push(setups.iter().map(&mut of).collect());
        let mut sets = Vec::new();
        for _ in &setups {
            let mut set = PartSet::new(parts);
            (0..parts).filter(|&q| q != part && random(3) == 0).for_each(|q| set.insert(q));
            sets.push(set);
        }
        blocked.push(sets);
    }
    Made { candidates, blocked, touching, on_table }
}

pub(in crate::planning) fn problem(made: &Made, table_first: bool, priority: Priority) -> Problem<'_> {
    let Made { candidates, blocked, touching, on_table } = made;
    Problem { candidates, blocked, touching, on_table, table_first, priority }
}

/// Slots of setups of parts, by the definition alone: nothing is pruned and nothing jumps.
pub(in crate::planning) fn by_definition(
    p: &Problem<'_>,
    closed: &Sequence,
    current: &[Choice],
    found: &mut BTreeSet<Sequence>,
) {
    let parts = p.candidates.len();
    let placed: Vec<usize> = closed.iter().flatten().chain(current).map(|c| c.0).collect();
    if placed.len() == parts && current.is_empty() {
        found.insert(closed.clone());
        return;
    }
    let printed: Vec<usize> = closed.iter().flatten().map(|c| c.0).collect();
    let setup = |&(q, k): &Choice| p.candidates[q][k].setup;
    if !current.is_empty() {
        let all_standing = p.on_table.iter().all(|q| current.iter().any(|c| c.0 == q));
        if !(p.table_first && closed.is_empty()) || all_standing {
            let mut more = closed.clone();
            more.push(current.to_vec());
            by_definition(p, &more, &[], found);
        }
        if p.priority == Priority::OnlySingle {
            return;
        }
    }
    for part in (0..parts).filter(|q| !placed.contains(q)) {
        let first = closed.is_empty() && p.on_table.has(part);
        let joins = p.touching[part].iter().any(|q| printed.contains(&q));
        let table_later = !p.table_first && p.on_table.has(part);
        if !(first || !closed.is_empty() && (joins || table_later)) {
            continue;
        }
        for k in 0..p.candidates[part].len() {
            let choice = (part, k);
            let last = current.last().map(setup);
            let same = last == Some(setup(&choice));
            let left = !same && current.iter().any(|c| setup(c) == setup(&choice));
            let unordered = same && current.last().is_some_and(|c| c.0 > part);
            let others = current.iter().filter(|c| setup(c) != setup(&choice)).map(|c| c.0);
            let blockers = &p.blocked[part][k];
            let hangs = !p.candidates[part][k].needs.met_by(&set(parts, &printed));
            let blocked = printed.iter().copied().chain(others).any(|q| blockers.has(q));
            if !left && !unordered && !blocked && !hangs {
                let more: Vec<Choice> = current.iter().copied().chain([choice]).collect();
                by_definition(p, closed, &more, found);
            }
        }
    }
}

#[test]
fn pruning_and_jumping_lose_no_sequence_and_invent_none() {
    let (mut feasible, mut infeasible) = (0, 0);
    for seed in 0..400 {
        let made = made(seed, 3 + (seed % 3) as usize);
        for priority in [Priority::Together, Priority::Single, Priority::OnlySingle] {
            let problem = problem(&made, seed % 4 != 0, priority);
            let mut wanted = BTreeSet::new();
            by_definition(&problem, &Vec::new(), &[], &mut wanted);
            let mut got = BTreeSet::new();
            let outcome = enumerate(&problem, u64::MAX, |sequence| {
                assert!(got.insert(sequence.clone()), "seed {seed}: twice: {sequence:?}");
                true
            });
            assert_eq!(outcome.end, End::Exhausted);
            assert_eq!(got, wanted, "seed {seed}, {priority:?}");
            if wanted.is_empty() { infeasible += 1 } else { feasible += 1 }
        }
    }
    assert!(feasible > 200 && infeasible > 200, "{feasible} feasible, {infeasible} not: the test has grown blunt");
}

/// The same, behind what a made-up order of two steps demands; and the steps.
pub(in crate::planning) fn in_order(made: &Made, seed: u64) -> (Made, Vec<Vec<usize>>) {
    let parts = made.candidates.len();
    let first = seed as usize / 7 % parts;
    let rest = (1..parts).map(|k| (first + k) % parts).take(1 + seed as usize % 2).collect();
    let steps: Vec<Vec<usize>> = vec![vec![first], rest];
    let behind = |(part, ways): (usize, &Vec<Candidate>)| {
        let before = if steps[1].contains(&part) { steps[0].clone() } else { Vec::new() };
        ways.iter().map(|way| Candidate { needs: way.needs.clone().behind(before.clone()), ..way.clone() }).collect()
    };
    let Made { blocked, touching, on_table, .. } = made;
    let candidates = made.candidates.iter().enumerate().map(behind).collect();
    (Made { candidates, blocked: blocked.clone(), touching: touching.clone(), on_table: on_table.clone() }, steps)
}

/// Whether each step is in later slots than the one before.
pub(in crate::planning) fn is_in_order(sequence: &Sequence, steps: &[Vec<usize>]) -> bool {
    let slot = |part: &usize| sequence.iter().position(|slot| slot.iter().any(|(p, _)| p == part));
    steps.windows(2).all(|two| two[0].iter().map(slot).max() < two[1].iter().map(slot).min())
}

#[test]
fn of_a_demanded_order_there_are_those_sequences_that_have_it() {
    let (mut some, mut none, mut fewer) = (0, 0, 0);
    for seed in 0..600 {
        let free = made(seed, 3 + (seed % 3) as usize);
        let (ordered, steps) = in_order(&free, seed);
        for priority in [Priority::Together, Priority::OnlySingle] {
            let mut every = BTreeSet::new();
            by_definition(&problem(&free, false, priority), &Vec::new(), &[], &mut every);
            let wanted: BTreeSet<Sequence> = every.iter().filter(|one| is_in_order(one, &steps)).cloned().collect();
            let got: BTreeSet<Sequence> = all(&problem(&ordered, false, priority)).into_iter().collect();
            assert_eq!(got, wanted, "seed {seed}, {priority:?}, {steps:?}");
            if wanted.is_empty() {
                none += 1
            } else {
                some += 1
            }
            fewer += usize::from(wanted.len() < every.len());
        }
    }
    assert!(some > 150 && none > 200 && fewer > 200, "{some}, {none}, {fewer}: the test has grown blunt");
}

fn set(parts: usize, members: &[usize]) -> PartSet {
    let mut set = PartSet::new(parts);
    members.iter().for_each(|&q| set.insert(q));
    set
}

fn way(setup: usize, needs: Needs) -> Candidate {
    Candidate { up: Dir::z(), pose: Pose::LEVEL, setup, value: 0.0, needs }
}

fn all(problem: &Problem<'_>) -> Vec<Sequence> {
    let mut found = Vec::new();
    enumerate(problem, u64::MAX, |sequence| {
        found.push(sequence.clone());
        true
    });
    found
}

/// Ramos et al. (2021), section 5.4, first study: part 1 upright needs support and hits part 0; lying it does not. {L2, L4}.
#[test]
fn the_first_study_has_exactly_two_sequences() {
    let candidates =
        vec![vec![way(0, Needs::none()), way(1, Needs::none())], vec![way(0, Needs::support()), way(1, Needs::none())]];
    let blocked = vec![vec![set(2, &[]); 2], vec![set(2, &[0]), set(2, &[])]];
    let (touching, on_table) = (vec![set(2, &[1]), set(2, &[0])], set(2, &[0]));
    let made = Made { candidates, blocked, touching, on_table };
    let found = all(&problem(&made, true, Priority::Together));
    assert_eq!(found, vec![vec![vec![(0, 0)], vec![(1, 1)]], vec![vec![(0, 1)], vec![(1, 1)]]]);
}

/// Ramos et al. (2021), section 5.4, second study: part 1 only lying, parts 2 and 3 only together. L5 = L7 and L13 = L15: two
/// distinct plans.
#[test]
fn the_second_study_has_exactly_two_plans() {
    let free = || way(0, Needs::none());
    let candidates = vec![
        vec![free(), way(1, Needs::none())],
        vec![way(0, Needs::support()), way(1, Needs::none())],
        vec![free()],
        vec![free()],
    ];
    let none = || set(4, &[]);
    let blocked = vec![vec![none(), none()], vec![none(), none()], vec![set(4, &[3])], vec![set(4, &[2])]];
    let touching = vec![set(4, &[1]), set(4, &[0, 2, 3]), set(4, &[1]), set(4, &[1])];
    let made = Made { candidates, blocked, touching, on_table: set(4, &[0]) };
    let together = vec![(2, 0), (3, 0)];
    let wanted: Vec<Sequence> = (0..2).map(|k| vec![vec![(0, k)], vec![(1, 1)], together.clone()]).collect();
    assert_eq!(all(&problem(&made, true, Priority::Together)), wanted);
}
