//! Algorithms 2 and 3 of seed 004: all feasible sequences of time slots, one after the other.
//!
//! What is blocked by what, and who carries whom, is worked out before; the search itself is bit operations. Departures
//! from the printed algorithm, each without loss of a feasible sequence:
//!
//! - A slot's parts are grouped by setup; the groups are printed one after the other, the parts of a group together,
//!   layer by layer, so that parts of one group never obstruct each other. Within a group parts are added in
//!   ascending order, so that no set is met twice.
//! - A part that every earlier *slot* leaves no way to print ends the branch at once, since more parts only block
//!   more; the search jumps back to the end of the slot that took the last way (also to the first: the base is no
//!   exception). To the slot's end and not to the part itself: the blocked part may still join that slot.
//! - Orientations are tried best first. A printed part's own orientation blocks nobody, so an order that fails with one
//!   fails with all.

use super::candidates::Candidate;
use super::part_set::PartSet;

/// A part with the number of its candidate.
pub(super) type Choice = (usize, usize);

/// A feasible sequence: slots of (part, candidate), in printing order.
pub type Sequence = Vec<Vec<Choice>>;

/// Which sequences come first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Priority {
    /// As many parts in a slot as can be (line 18 before 19).
    Together,
    /// One part after the other where possible (lines 18 and 19 swapped).
    Single,
    /// Never two parts in a slot (without line 18).
    OnlySingle,
}

/// What the search works on.
pub(super) struct Problem<'a> {
    pub(super) candidates: &'a [Vec<Candidate>],
    /// For each part and candidate: the parts that must not be there before.
    pub(super) blocked: &'a [Vec<PartSet>],
    /// For each part: the parts it touches.
    pub(super) touching: &'a [PartSet],
    pub(super) on_table: &'a PartSet,
    /// Whether everything that stands on the table belongs to the first slot (seed 004, section 5.1).
    pub(super) table_first: bool,
    pub(super) priority: Priority,
}

/// How a search ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum End {
    /// Every sequence was seen.
    Exhausted,
    /// The caller had enough.
    Stopped,
    /// The budget of steps was spent.
    Budget,
}

/// What the search leaves behind.
pub(super) struct Outcome {
    pub(super) end: End,
    /// Steps taken: candidates looked at.
    pub(super) steps: u64,
    /// The largest set of parts that some branch had printed in closed slots.
    pub(super) farthest: PartSet,
}

enum Next {
    Go,
    /// Back to the choice at this depth: all below it are beside the point.
    BackTo(usize),
    Stop(End),
}

struct Search<'a, F> {
    problem: &'a Problem<'a>,
    found: F,
    closed: Sequence,
    current: Vec<Choice>,
    /// Parts of closed slots.
    printed: PartSet,
    /// Depth at which each part was placed.
    placed_at: Vec<Option<usize>>,
    /// For the parts of closed slots: the depth of the last part of their slot.
    slot_end: Vec<usize>,
    depth: usize,
    steps: u64,
    budget: u64,
    farthest: PartSet,
}

/// Calls `found` for every feasible sequence until it returns `false` or `budget` steps are spent.
pub(super) fn enumerate(problem: &Problem<'_>, budget: u64, found: impl FnMut(&Sequence) -> bool) -> Outcome {
    let parts = problem.candidates.len();
    let mut search = Search {
        problem,
        found,
        closed: Vec::new(),
        current: Vec::new(),
        printed: PartSet::new(parts),
        placed_at: vec![None; parts],
        slot_end: vec![0; parts],
        depth: 0,
        steps: 0,
        budget,
        farthest: PartSet::new(parts),
    };
    let end = match search.level() {
        Next::Stop(end) => end,
        Next::Go | Next::BackTo(_) => End::Exhausted,
    };
    Outcome { end, steps: search.steps, farthest: search.farthest }
}

impl<F: FnMut(&Sequence) -> bool> Search<'_, F> {
    /// Algorithm 3.
    fn level(&mut self) -> Next {
        if self.depth == self.placed_at.len() {
            let go_on = !self.current.is_empty() || (self.found)(&self.closed);
            return if go_on { Next::Go } else { Next::Stop(End::Stopped) };
        }
        if self.current.is_empty()
            && let Some(depth) = self.dead_end()
        {
            return Next::BackTo(depth);
        }
        for choice in self.connected() {
            self.steps += 1;
            if self.steps > self.budget {
                return Next::Stop(End::Budget);
            }
            if !self.feasible(choice) {
                continue;
            }
            match self.place(choice) {
                Next::BackTo(depth) if depth >= self.depth => {}
                Next::Go => {}
                other => return other,
            }
        }
        Next::Go
    }

    /// Lines 17 to 19 for one part.
    fn place(&mut self, choice: Choice) -> Next {
        self.placed_at[choice.0] = Some(self.depth);
        self.depth += 1;
        self.current.push(choice);
        let order: &[bool] = match self.problem.priority {
            Priority::Together => &[false, true],
            Priority::Single => &[true, false],
            Priority::OnlySingle => &[true],
        };
        let mut next = Next::Go;
        for &close in order {
            next = if close { self.close_slot() } else { self.level() };
            if matches!(next, Next::Stop(_)) {
                break;
            }
            // A jump past this choice passes its other half too; one to this choice leaves it: the slot may yet grow.
            if matches!(next, Next::BackTo(depth) if depth + 1 < self.depth) {
                break;
            }
        }
        self.current.pop();
        self.depth -= 1;
        self.placed_at[choice.0] = None;
        next
    }

    /// Line 19: what is in the slot becomes an obstacle.
    fn close_slot(&mut self) -> Next {
        if self.problem.table_first && self.closed.is_empty() {
            let here = self.current.iter().filter(|c| self.problem.on_table.has(c.0)).count();
            if here < self.problem.on_table.len() {
                return Next::Go;
            }
        }
        let slot = std::mem::take(&mut self.current);
        for &(part, _) in &slot {
            self.printed.insert(part);
            self.slot_end[part] = self.depth - 1;
        }
        if self.printed.len() > self.farthest.len() {
            self.farthest = self.printed.clone();
        }
        self.closed.push(slot);
        let next = self.level();
        self.current = self.closed.pop().unwrap_or_default();
        for &(part, _) in &self.current {
            self.printed.remove(part);
        }
        next
    }

    /// Line 11: what may come next, the running setup's parts first, then by part, best orientation first.
    fn connected(&self) -> Vec<Choice> {
        let running = self.current.last().map(|&(p, k)| (self.problem.candidates[p][k].setup, p));
        let mut first = Vec::new();
        let mut others = Vec::new();
        for part in (0..self.placed_at.len()).filter(|&p| self.placed_at[p].is_none()) {
            let starts = if self.closed.is_empty() { self.problem.on_table.has(part) } else { self.joins(part) };
            if !starts {
                continue;
            }
            for (k, candidate) in self.problem.candidates[part].iter().enumerate() {
                match running {
                    Some((setup, last)) if setup == candidate.setup => {
                        if part > last {
                            first.push((part, k));
                        }
                    }
                    _ if self.setup_left(candidate.setup) => {}
                    _ => others.push((part, k)),
                }
            }
        }
        first.append(&mut others);
        first
    }

    fn joins(&self, part: usize) -> bool {
        let table = !self.problem.table_first && self.problem.on_table.has(part);
        table || self.problem.touching[part].meets(&self.printed)
    }

    /// Whether the slot has had this setup and left it for another.
    fn setup_left(&self, setup: usize) -> bool {
        self.current.iter().any(|&(p, k)| self.problem.candidates[p][k].setup == setup)
    }

    /// Line 16.
    fn feasible(&self, (part, k): Choice) -> bool {
        let candidate = &self.problem.candidates[part][k];
        let blocked = &self.problem.blocked[part][k];
        let earlier_groups = || {
            let other = |&&(p, j): &&Choice| self.problem.candidates[p][j].setup != candidate.setup;
            self.current.iter().filter(other).any(|&(p, _)| blocked.has(p))
        };
        !blocked.meets(&self.printed) && !earlier_groups() && candidate.needs.met_by(&self.printed)
    }

    /// Where to go back to if some part has no way left: the end of the slot whose change would free one.
    fn dead_end(&self) -> Option<usize> {
        let unplaced = (0..self.placed_at.len()).filter(|&p| self.placed_at[p].is_none());
        for part in unplaced {
            let ways = &self.problem.blocked[part];
            if ways.iter().any(|b| !b.meets(&self.printed)) {
                continue;
            }
            // To free a way, no blocker may be there before: the first slot with one must change. The ways differ; the
            // one whose slot comes last is the least jump.
            let earliest = |b: &PartSet| b.iter().filter(|&q| self.printed.has(q)).map(|q| self.slot_end[q]).min();
            return Some(ways.iter().filter_map(earliest).max().unwrap_or(0));
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::super::support::Needs;
    use super::*;
    use crate::geom::Dir;
    use crate::motion::Pose;

    /// A small problem made up from a seed.
    struct Made {
        candidates: Vec<Vec<Candidate>>,
        blocked: Vec<Vec<PartSet>>,
        touching: Vec<PartSet>,
        on_table: PartSet,
    }

    fn made(seed: u64, parts: usize) -> Made {
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
            let of = |&setup: &usize| {
                let (up, pose) = (Dir::z(), Pose::LEVEL);
                Candidate { up, pose, setup, value: 0.0, needs: Needs::none() }
            };
            candidates.push(setups.iter().map(of).collect());
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

    fn problem(made: &Made, table_first: bool, priority: Priority) -> Problem<'_> {
        let Made { candidates, blocked, touching, on_table } = made;
        Problem { candidates, blocked, touching, on_table, table_first, priority }
    }

    /// Slots of setups of parts, by the definition alone: nothing is pruned and nothing jumps.
    fn by_definition(p: &Problem<'_>, closed: &Sequence, current: &[Choice], found: &mut BTreeSet<Sequence>) {
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
                let blocked = printed.iter().copied().chain(others).any(|q| blockers.has(q));
                if !left && !unordered && !blocked {
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

    /// Seed 004, section 5.4, first study: part 1 upright needs support and hits part 0; lying it does not. {L2, L4}.
    #[test]
    fn the_first_study_has_exactly_two_sequences() {
        let candidates = vec![
            vec![way(0, Needs::none()), way(1, Needs::none())],
            vec![way(0, Needs::support()), way(1, Needs::none())],
        ];
        let blocked = vec![vec![set(2, &[]); 2], vec![set(2, &[0]), set(2, &[])]];
        let (touching, on_table) = (vec![set(2, &[1]), set(2, &[0])], set(2, &[0]));
        let made = Made { candidates, blocked, touching, on_table };
        let found = all(&problem(&made, true, Priority::Together));
        assert_eq!(found, vec![vec![vec![(0, 0)], vec![(1, 1)]], vec![vec![(0, 1)], vec![(1, 1)]]]);
    }

    /// Seed 004, section 5.4, second study: part 1 only lying, parts 2 and 3 only together. L5 = L7 and L13 = L15: two
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
}
