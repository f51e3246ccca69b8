//! The search against all orders there are, on small random problems.

use std::collections::BTreeSet;

use super::*;
use crate::geom::{Dir, Vec3};
use crate::motion::Pose;
use crate::planning::support::Needs;

const PARTS: usize = 4;
const SETUPS: usize = 3;

/// A source of small numbers, the same in every run.
struct Dice(u64);

impl Dice {
    fn below(&mut self, sides: u64) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % sides
    }

    fn set(&mut self, but: usize, one_in: u64) -> PartSet {
        let mut set = PartSet::new(PARTS);
        for part in (0..PARTS).filter(|&p| p != but) {
            if self.below(one_in) == 0 {
                set.insert(part);
            }
        }
        set
    }
}

struct Case {
    candidates: Vec<Vec<Candidate>>,
    blocked: Vec<Vec<PartSet>>,
    touching: Vec<PartSet>,
    on_table: PartSet,
    table_first: bool,
}

fn case(dice: &mut Dice) -> Case {
    let mut candidates = Vec::new();
    let mut blocked = Vec::new();
    let mut touching = vec![PartSet::new(PARTS); PARTS];
    for part in 0..PARTS {
        let first = dice.below(SETUPS as u64) as usize;
        let setups: Vec<usize> = (0..1 + dice.below(2) as usize).map(|i| (first + i) % SETUPS).collect();
        blocked.push(setups.iter().map(|_| dice.set(part, 3)).collect());
        let candidate = |&setup: &usize| Candidate {
            up: Dir::new(Vec3::z()).unwrap(),
            pose: Pose::LEVEL,
            setup,
            value: 0.0,
            needs: if dice.below(3) == 0 { Needs::to_begin_on(dice.set(part, 2)) } else { Needs::none() },
        };
        candidates.push(setups.iter().map(candidate).collect());
        for other in 0..part {
            if dice.below(3) > 0 {
                touching[part].insert(other);
                touching[other].insert(part);
            }
        }
    }
    let mut on_table = dice.set(PARTS, 3);
    on_table.insert(0);
    Case { candidates, blocked, touching, on_table, table_first: dice.below(2) == 0 }
}

/// All orders of the parts, each with every choice of candidates.
fn orders(case: &Case, so_far: &mut Vec<Choice>, found: &mut impl FnMut(&[Choice])) {
    if so_far.len() == PARTS {
        found(so_far);
    }
    for part in (0..PARTS).filter(|p| so_far.iter().all(|c| c.0 != *p)).collect::<Vec<_>>() {
        for k in 0..case.candidates[part].len() {
            so_far.push((part, k));
            orders(case, so_far, found);
            so_far.pop();
        }
    }
}

/// Whether the sequence obeys every rule, asked of the whole and without a search.
fn obeys(case: &Case, sequence: &Sequence, single: bool) -> bool {
    let mut printed = PartSet::new(PARTS);
    for (t, slot) in sequence.iter().enumerate() {
        if single && slot.len() > 1 {
            return false;
        }
        let setup = |c: &Choice| case.candidates[c.0][c.1].setup;
        for (i, &(part, k)) in slot.iter().enumerate() {
            let on_table = case.on_table.has(part);
            let starts =
                if t == 0 { on_table } else { on_table && !case.table_first || case.touching[part].meets(&printed) };
            let before = &slot[..i];
            let here = setup(&slot[i]);
            // A setup's parts stand together, ascending; other setups' parts before are obstacles.
            let group = before.iter().rposition(|c| setup(c) != here).map_or(0, |last| last + 1);
            let whole = before[..group].iter().all(|c| setup(c) != here);
            let ascending = before[group..].iter().all(|c| c.0 < part);
            let blocked = &case.blocked[part][k];
            let clear = !blocked.meets(&printed) && before[..group].iter().all(|c| !blocked.has(c.0));
            if !(starts && whole && ascending && clear && case.candidates[part][k].needs.met_by(&printed)) {
                return false;
            }
        }
        slot.iter().for_each(|c| printed.insert(c.0));
        if t == 0 && case.table_first && case.on_table.iter().any(|p| !printed.has(p)) {
            return false;
        }
    }
    true
}

fn by_force(case: &Case, single: bool) -> BTreeSet<Sequence> {
    let mut all = BTreeSet::new();
    orders(case, &mut Vec::new(), &mut |order| {
        for breaks in 0..1 << (PARTS - 1) {
            let mut sequence: Sequence = vec![vec![order[0]]];
            for (i, &choice) in order.iter().enumerate().skip(1) {
                if breaks >> (i - 1) & 1 == 1 {
                    sequence.push(Vec::new());
                }
                sequence.last_mut().unwrap().push(choice);
            }
            if obeys(case, &sequence, single) {
                all.insert(sequence);
            }
        }
    });
    all
}

#[test]
fn the_search_finds_every_sequence_once_and_no_other() {
    let mut dice = Dice(4);
    let mut feasible = 0;
    for round in 0..400 {
        let case = case(&mut dice);
        for priority in [Priority::Together, Priority::Single, Priority::OnlySingle] {
            let problem = Problem {
                candidates: &case.candidates,
                blocked: &case.blocked,
                touching: &case.touching,
                on_table: &case.on_table,
                table_first: case.table_first,
                priority,
            };
            let mut found = Vec::new();
            let outcome = enumerate(&problem, u64::MAX, |sequence| {
                found.push(sequence.clone());
                true
            });
            assert_eq!(outcome.end, End::Exhausted);
            let count = found.len();
            let found: BTreeSet<Sequence> = found.into_iter().collect();
            assert_eq!(found.len(), count, "round {round}, {priority:?}: some sequence was found twice");
            assert_eq!(found, by_force(&case, priority == Priority::OnlySingle), "round {round}, {priority:?}");
            feasible += usize::from(count > 0);
        }
    }
    assert!((200..1100).contains(&feasible), "{feasible} of 1200 problems have a sequence");
}
