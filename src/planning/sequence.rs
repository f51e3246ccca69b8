//! Algorithms 2 and 3 of Ramos et al. (2021): all feasible sequences of time slots, one after the other.
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
//! - What can follow closed slots depends on the parts in them alone: a set of parts that no sequence was found behind is not entered again,
//!   in whatever order its parts come.
//! - Orientations are tried best first. A printed part's own orientation blocks nobody, so an order that fails with one
//!   fails with all.

use std::collections::HashSet;

use super::candidates::Candidate;
use super::options::Priority;
use super::part_set::PartSet;

/// A part with the number of its candidate.
pub(super) type Choice = (usize, usize);

/// A feasible sequence: slots of (part, candidate), in printing order.
pub type Sequence = Vec<Vec<Choice>>;

/// What the search works on.
pub(super) struct Problem<'a> {
    pub(super) candidates: &'a [Vec<Candidate>],
    /// For each part and candidate: the parts that must not be there before.
    pub(super) blocked: &'a [Vec<PartSet>],
    /// For each part: the parts it touches.
    pub(super) touching: &'a [PartSet],
    pub(super) on_table: &'a PartSet,
    /// Whether everything that stands on the table belongs to the first slot (Ramos et al. (2021), section 5.1).
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
pub(super) struct SequenceOutcome {
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
    /// Sequences that were found.
    count: u64,
    /// Sets of parts in closed slots behind which there is none.
    hopeless: HashSet<PartSet>,
}

/// So many sets are remembered: some 100 MB.
const MOST_HOPELESS: usize = 1_000_000;

/// Calls `found` for every feasible sequence until it returns `false` or `budget` steps are spent.
pub(super) fn enumerate(problem: &Problem<'_>, budget: u64, found: impl FnMut(&Sequence) -> bool) -> SequenceOutcome {
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
        count: 0,
        hopeless: HashSet::new(),
    };
    let end = match search.level() {
        Next::Stop(end) => end,
        Next::Go | Next::BackTo(_) => End::Exhausted,
    };
    SequenceOutcome { end, steps: search.steps, farthest: search.farthest }
}

impl<F: FnMut(&Sequence) -> bool> Search<'_, F> {
    /// Algorithm 3.
    fn level(&mut self) -> Next {
        if self.depth == self.placed_at.len() {
            if !self.current.is_empty() {
                return Next::Go;
            }
            self.count += 1;
            return if (self.found)(&self.closed) { Next::Go } else { Next::Stop(End::Stopped) };
        }
        if !self.current.is_empty() {
            return self.choices();
        }
        if self.hopeless.contains(&self.printed) {
            return Next::Go;
        }
        if let Some(depth) = self.dead_end() {
            return Next::BackTo(depth);
        }
        let before = self.count;
        let next = self.choices();
        if self.count == before && !matches!(next, Next::Stop(_)) && self.hopeless.len() < MOST_HOPELESS {
            self.hopeless.insert(self.printed.clone());
        }
        next
    }

    /// Each part that may come next.
    fn choices(&mut self) -> Next {
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
            let earliest = |b: &PartSet| b.shared(&self.printed).map(|q| self.slot_end[q]).min();
            return Some(ways.iter().filter_map(earliest).max().unwrap_or(0));
        }
        None
    }
}

#[cfg(test)]
pub(super) mod tests;
