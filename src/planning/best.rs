//! The best sequence of a goal, and a proof: best-first search over what is printed, with a bound for the rest.
//!
//! **State.** What closed slots left behind, what the running slot holds in setups before the running one, and the parts of
//! the running setup. The order in which they got there does not matter any more: what a printed part blocks does not
//! depend on how it was printed.
//!
//! **Bound.** Each part's cheapest way, were the obstacles of now the only ones to come and were every part printed as soon
//! as something carries it (the *delete relaxation* of planning): blocking only grows and support only grows, so no real
//! continuation can print a part earlier or in a way that is not among these. Prices are sums over parts, so the sum
//! of the parts' least prices is below every continuation; ranks are compared one after the other, which sums respect.
//! Pose changes: parts no two of which share a setup need a setup each.
//!
//! **Forced moves.** A part that fits the running setup now, at its cheapest price, and that no other part ever minds, is
//! printed at once: in every continuation that prints it later it can be moved here, and nothing gets dearer.
//!
//! Costs are whole numbers of a unit per rank (a power of two, `2^-50` of the largest sum there can be), so that sums do not
//! depend on their order.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};

use super::candidates::Candidate;
use super::options::Priority;
use super::part_set::PartSet;
use super::pricing::Rank;
use super::sequence::{Choice, Problem, Sequence};
use crate::geom::SplitMix64;

/// Most ranks of a goal.
const RANKS: usize = 4;

/// A sum of prices, rank by rank, compared in that order.
pub(super) type SequenceCost = [i64; RANKS];

/// Prices in whole units.
pub(super) struct Tariff {
    waiting: SequenceCost,
    slot: SequenceCost,
    setup: SequenceCost,
    price: Vec<Vec<SequenceCost>>,
    /// Each part's least price, whatever stands in the way.
    cheapest: Vec<SequenceCost>,
    unit: [f64; RANKS],
}

/// Bits of the largest sum; the rest of an `i64` is room for the search's own arithmetic.
const COST_BITS: f64 = 50.0;

impl Tariff {
    /// At most four ranks count.
    pub(super) fn of(ranks: &[Rank]) -> Self {
        let parts = ranks.first().map_or(0, |r| r.price.len());
        let mut tariff = Self {
            waiting: [0; RANKS],
            slot: [0; RANKS],
            setup: [0; RANKS],
            price: ranks.first().map_or(Vec::new(), |r| r.price.iter().map(|p| vec![[0; RANKS]; p.len()]).collect()),
            cheapest: Vec::new(),
            unit: [1.0; RANKS],
        };
        for (r, rank) in ranks.iter().take(RANKS).enumerate() {
            let most = |prices: &Vec<f64>| prices.iter().map(|p| p.abs()).fold(0.0, f64::max);
            let n = parts as f64;
            let largest = rank.price.iter().map(most).sum::<f64>() + n * (n * rank.waiting + rank.slot + rank.setup);
            let unit = if largest > 0.0 { (largest.log2().ceil() - COST_BITS).exp2() } else { 1.0 };
            let whole = |price: f64| (price / unit).round() as i64;
            tariff.unit[r] = unit;
            tariff.waiting[r] = whole(rank.waiting);
            tariff.slot[r] = whole(rank.slot);
            tariff.setup[r] = whole(rank.setup);
            for (to, from) in tariff.price.iter_mut().zip(&rank.price) {
                to.iter_mut().zip(from).for_each(|(to, from)| to[r] = whole(*from));
            }
        }
        tariff.cheapest = tariff.price.iter().map(|p| p.iter().copied().min().unwrap_or_default()).collect();
        tariff
    }

    /// What `sequence` costs.
    pub(super) fn of_sequence(&self, sequence: &Sequence, candidates: &[Vec<Candidate>]) -> SequenceCost {
        let mut sum = times(&self.slot, sequence.len());
        let mut table = None;
        for (t, &(part, k)) in sequence.iter().enumerate().flat_map(|(t, slot)| slot.iter().map(move |c| (t, c))) {
            sum = plus(&sum, &plus(&self.price[part][k], &times(&self.waiting, t)));
            if table.replace(candidates[part][k].setup) != Some(candidates[part][k].setup) {
                sum = plus(&sum, &self.setup);
            }
        }
        sum
    }

    /// The first rank of `cost` in the goal's own unit.
    pub(super) fn value(&self, cost: &SequenceCost) -> f64 {
        cost[0] as f64 * self.unit[0]
    }
}

/// What the search found.
pub(super) struct Best {
    /// The best distinct plans, cheapest first; empty where none was found.
    pub(super) plans: Vec<(SequenceCost, Sequence)>,
    /// Nothing that is not in `plans` costs less; `None` where nothing else exists.
    pub(super) bound: Option<SequenceCost>,
    /// Whether every plan was either found or proved no better than the last of `plans`.
    pub(super) proved: bool,
    /// Candidates looked at.
    pub(super) steps: u64,
}

/// How to search.
#[derive(Clone, Copy, Debug)]
pub(super) struct SearchLimits {
    /// How many distinct plans.
    pub(super) plans: usize,
    /// Most candidates to look at.
    pub(super) steps: u64,
    /// Most states to keep; some 200 bytes each.
    pub(super) states: usize,
}

/// How much the quick looks hurry, one after the other.
const HASTES: [i64; 3] = [2, 8, 40];

/// The cheapest plans of `problem`, whose priority decides whether a slot may hold more than one part.
pub(super) fn best(problem: &Problem<'_>, tariff: &Tariff, limits: &SearchLimits) -> Best {
    // A quick look first: a plan in hand lets the proof leave out whatever cannot beat it. More haste finds a plan where
    // less does not, but a worse one.
    let (mut plans, mut steps) = (Vec::new(), 0);
    for haste in HASTES {
        let share = SearchLimits { steps: limits.steps / 10, states: limits.states / 10, plans: 1 };
        let mut quick = Search::new(problem, tariff, share, haste);
        quick.run();
        steps += quick.steps;
        plans = quick.plans;
        if !plans.is_empty() || quick.finished {
            break;
        }
    }
    let mut search = Search::new(problem, tariff, *limits, 1);
    search.steps = steps;
    search.plans = plans;
    search.run();
    Best {
        bound: search.open.iter().map(|e| e.0.0.floor).min(),
        proved: search.finished,
        plans: search.plans,
        steps: search.steps,
    }
}

/// What decides the future.
#[derive(Clone, PartialEq, Eq, Hash)]
struct State {
    /// Parts of closed slots.
    closed: PartSet,
    /// Parts of the running slot in setups that were left.
    before: PartSet,
    /// Parts of the running setup.
    group: PartSet,
    /// Setups of the running slot that were left, ascending; a slot does not come back to one.
    left: Vec<usize>,
    /// The running setup; `None` in a slot that has not begun.
    setup: Option<usize>,
    /// Where the table stands, if turning it costs anything.
    table: Option<usize>,
}

#[derive(Clone, Copy)]
enum Act {
    Start,
    Print(Choice),
    Close,
}

struct Expanded {
    parent: usize,
    act: Act,
    spent: SequenceCost,
    state: State,
    /// Number of the running slot.
    slot: u64,
    /// Which part went into which slot in which way, whatever the order within a slot.
    signature: u64,
}

/// An entry of the queue: by estimate, the youngest first among equals.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct Entry {
    estimate: SequenceCost,
    age: Reverse<usize>,
    node: usize,
    /// Proved: nothing below this node costs less.
    floor: SequenceCost,
    /// Whether `estimate` is this node's own, or still its parent's.
    own: bool,
}

#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct ByEstimate(Entry);

struct Search<'a> {
    problem: &'a Problem<'a>,
    tariff: &'a Tariff,
    limits: SearchLimits,
    /// How much the bound weighs in the estimate: 1 proves, more hurries.
    haste: i64,
    /// For each part: those that mind it.
    minded_by: Vec<PartSet>,
    /// For each part: those that come no later, since it stands in the way of all their ways.
    no_later: Vec<PartSet>,
    nodes: Vec<Expanded>,
    /// How each state was met: cost and signature, the cheapest of as many as plans are wanted. The best plans pass through
    /// a state only by its so many best beginnings.
    met: HashMap<State, Vec<(SequenceCost, u64)>>,
    open: BinaryHeap<Reverse<ByEstimate>>,
    plans: Vec<(SequenceCost, Sequence)>,
    steps: u64,
    age: usize,
    finished: bool,
}

fn plus(a: &SequenceCost, b: &SequenceCost) -> SequenceCost {
    std::array::from_fn(|r| a[r] + b[r])
}

fn times(a: &SequenceCost, n: usize) -> SequenceCost {
    a.map(|c| c * n as i64)
}

impl<'a> Search<'a> {
    fn new(problem: &'a Problem<'a>, tariff: &'a Tariff, limits: SearchLimits, haste: i64) -> Self {
        let parts = problem.candidates.len();
        let mut minded_by = vec![PartSet::new(parts); parts];
        for (part, ways) in problem.blocked.iter().enumerate() {
            ways.iter().flat_map(PartSet::iter).for_each(|q| minded_by[q].insert(part));
        }
        Self {
            problem,
            tariff,
            limits,
            haste,
            no_later: no_later(problem),
            minded_by,
            nodes: Vec::new(),
            met: HashMap::new(),
            open: BinaryHeap::new(),
            plans: Vec::new(),
            steps: 0,
            age: 0,
            finished: false,
        }
    }

    fn run(&mut self) {
        let parts = self.problem.candidates.len();
        let none = || PartSet::new(parts);
        let start = State { closed: none(), before: none(), group: none(), left: Vec::new(), setup: None, table: None };
        self.nodes.push(Expanded {
            parent: 0,
            act: Act::Start,
            spent: [0; RANKS],
            state: start,
            slot: 0,
            signature: 0,
        });
        self.push(0, [i64::MIN; RANKS], [i64::MIN; RANKS], false);
        while let Some(Reverse(ByEstimate(entry))) = self.open.pop() {
            if self.plans.len() >= self.limits.plans && self.worst().is_some_and(|w| entry.floor >= w) {
                if self.haste == 1 {
                    self.open.push(Reverse(ByEstimate(entry)));
                    self.finished = true;
                    return;
                }
                continue;
            }
            if self.steps > self.limits.steps || self.nodes.len() > self.limits.states {
                self.open.push(Reverse(ByEstimate(entry)));
                return;
            }
            if !entry.own {
                self.estimate(entry);
            } else if self.expand(entry.node, entry.floor) && self.haste > 1 {
                return;
            }
        }
        self.finished = true;
    }

    /// What a plan must beat; `None` as long as not enough are in hand.
    fn worst(&self) -> Option<SequenceCost> {
        if self.plans.len() < self.limits.plans { None } else { self.plans.last().map(|(cost, _)| *cost) }
    }

    fn push(&mut self, node: usize, estimate: SequenceCost, floor: SequenceCost, own: bool) {
        self.age += 1;
        self.open.push(Reverse(ByEstimate(Entry { estimate, age: Reverse(self.age), node, floor, own })));
    }

    /// Works the node's own bound out and puts it back.
    fn estimate(&mut self, entry: Entry) {
        let node = &self.nodes[entry.node];
        let spent = node.spent;
        let Some(rest) = self.rest(entry.node) else { return };
        let floor = plus(&spent, &rest).max(entry.floor);
        let estimate = std::array::from_fn(|r| spent[r] + self.haste * rest[r]);
        self.open.push(Reverse(ByEstimate(Entry { estimate, floor, own: true, ..entry })));
    }

    /// Adds what can follow the node; whether a plan was completed.
    fn expand(&mut self, at: usize, floor: SequenceCost) -> bool {
        let parts = self.problem.candidates.len();
        let mut complete = false;
        // The last pushed is looked at first: first close, then other setups, then the running one, best ways first.
        for (act, price) in self.acts(at).into_iter().rev() {
            let spent = plus(&self.nodes[at].spent, &price);
            let state = self.after(&self.nodes[at].state, act);
            let done = state.closed.len() + state.before.len() + state.group.len() == parts;
            let (slot, signature) = self.signed(at, act);
            if !self.meet(&state, spent, signature) {
                continue;
            }
            self.nodes.push(Expanded { parent: at, act, spent, state, slot, signature });
            let node = self.nodes.len() - 1;
            if done {
                complete |= self.keep(node);
            } else {
                let estimate = if self.haste == 1 { floor } else { self.hurried(at, floor) };
                self.push(node, estimate, floor, false);
            }
        }
        complete
    }

    fn signed(&self, at: usize, act: Act) -> (u64, u64) {
        let Expanded { slot, signature, .. } = self.nodes[at];
        match act {
            Act::Print((part, k)) => {
                let word = slot << 40 ^ (part as u64) << 20 ^ k as u64;
                (slot, signature.wrapping_add(SplitMix64::seeded(word).word()))
            }
            Act::Close => (slot + 1, signature),
            Act::Start => (slot, signature),
        }
    }

    /// Whether this beginning of `state` is worth going on with.
    fn meet(&mut self, state: &State, spent: SequenceCost, signature: u64) -> bool {
        let most = self.limits.plans;
        let signature = if most == 1 { 0 } else { signature };
        let seen = self.met.entry(state.clone()).or_default();
        if let Some(known) = seen.iter_mut().find(|(_, sign)| *sign == signature) {
            return known.0 > spent && {
                known.0 = spent;
                true
            };
        }
        if seen.len() >= most && seen.iter().all(|(cost, _)| *cost <= spent) {
            return false;
        }
        seen.push((spent, signature));
        seen.sort_unstable();
        seen.truncate(most);
        true
    }

    fn hurried(&self, at: usize, floor: SequenceCost) -> SequenceCost {
        let spent = &self.nodes[at].spent;
        std::array::from_fn(|r| spent[r] + self.haste * (floor[r] - spent[r]))
    }

    /// Takes a complete plan in if it is new and good enough.
    fn keep(&mut self, node: usize) -> bool {
        let cost = self.nodes[node].spent;
        if self.worst().is_some_and(|worst| cost >= worst) {
            return false;
        }
        let sequence = self.sequence(node);
        let same = |a: &Sequence, b: &Sequence| canonical(a) == canonical(b);
        if let Some(twin) = self.plans.iter_mut().find(|(_, known)| same(known, &sequence)) {
            if cost < twin.0 {
                *twin = (cost, sequence);
                self.plans.sort_by_key(|(cost, _)| *cost);
            }
            return true;
        }
        let place = self.plans.partition_point(|(known, _)| *known <= cost);
        self.plans.insert(place, (cost, sequence));
        self.plans.truncate(self.limits.plans);
        true
    }

    fn sequence(&self, mut node: usize) -> Sequence {
        let mut acts = Vec::new();
        while !matches!(self.nodes[node].act, Act::Start) {
            acts.push(self.nodes[node].act);
            node = self.nodes[node].parent;
        }
        let mut slots: Sequence = vec![Vec::new()];
        for act in acts.into_iter().rev() {
            match (act, slots.last_mut()) {
                (Act::Print(choice), Some(slot)) => slot.push(choice),
                (Act::Close, _) => slots.push(Vec::new()),
                _ => {}
            }
        }
        // The parts of one setup grow together; their order says nothing.
        let setup = |&(part, k): &Choice| self.problem.candidates[part][k].setup;
        for slot in &mut slots {
            slot.chunk_by_mut(|a, b| setup(a) == setup(b)).for_each(<[Choice]>::sort_unstable);
        }
        slots
    }

    fn after(&self, state: &State, act: Act) -> State {
        let mut next = state.clone();
        match act {
            Act::Start => {}
            Act::Print((part, k)) => {
                let setup = self.problem.candidates[part][k].setup;
                if next.setup != Some(setup) {
                    next.before = next.before.union(&next.group);
                    next.group = PartSet::new(self.problem.candidates.len());
                    if let Some(left) = next.setup {
                        let place = next.left.partition_point(|&s| s < left);
                        next.left.insert(place, left);
                    }
                    next.setup = Some(setup);
                }
                next.table = (self.tariff.setup != [0; RANKS]).then_some(setup);
                next.group.insert(part);
            }
            Act::Close => {
                next.closed = next.closed.union(&next.before).union(&next.group);
                next.before = PartSet::new(self.problem.candidates.len());
                next.group = next.before.clone();
                next.left.clear();
                next.setup = None;
            }
        }
        next
    }

    fn single(&self) -> bool {
        self.problem.priority == Priority::OnlySingle
    }

    fn placed(state: &State) -> PartSet {
        state.closed.union(&state.before).union(&state.group)
    }

    /// What may follow, what is to be tried first in front, with its price.
    fn acts(&mut self, at: usize) -> Vec<(Act, SequenceCost)> {
        let state = &self.nodes[at].state;
        let placed = Self::placed(state);
        let parts = self.problem.candidates.len();
        let full = self.single() && state.setup.is_some();
        let mut here = Vec::new();
        let mut elsewhere = Vec::new();
        for part in (0..parts).filter(|&p| !full && !placed.has(p)) {
            if !self.starts(part, state.closed.is_empty(), &state.closed) {
                continue;
            }
            for (k, candidate) in self.problem.candidates[part].iter().enumerate() {
                self.steps += 1;
                let running = state.setup == Some(candidate.setup);
                if !self.free(state, part, k) || !candidate.needs.met_by(&state.closed) {
                    continue;
                }
                let mut price = self.tariff.price[part][k];
                if running {
                    let harmless = self.minded_by[part].iter().all(|q| q == part || placed.has(q));
                    if self.limits.plans == 1 && harmless && price <= self.tariff.cheapest[part] {
                        return vec![(Act::Print((part, k)), price)];
                    }
                    here.push((Act::Print((part, k)), price));
                } else if !state.left.contains(&candidate.setup) {
                    if state.setup.is_none() {
                        price = plus(&price, &self.tariff.slot);
                    }
                    if state.table != Some(candidate.setup) {
                        price = plus(&price, &self.tariff.setup);
                    }
                    elsewhere.push((Act::Print((part, k)), price));
                }
            }
        }
        here.sort_by_key(|(_, price)| *price);
        elsewhere.sort_by_key(|(_, price)| *price);
        here.append(&mut elsewhere);
        if state.setup.is_some() && self.may_close(state, &placed) {
            here.push((Act::Close, times(&self.tariff.waiting, parts - placed.len())));
        }
        here
    }

    fn may_close(&self, state: &State, placed: &PartSet) -> bool {
        let first = state.closed.is_empty() && self.problem.table_first;
        !first || self.problem.on_table.iter().all(|p| placed.has(p))
    }

    /// Whether a part may begin when `printed` stands, in the first slot or later.
    fn starts(&self, part: usize, first: bool, printed: &PartSet) -> bool {
        let on_table = self.problem.on_table.has(part);
        if first {
            on_table
        } else {
            (!self.problem.table_first && on_table) || self.problem.touching[part].meets(printed)
        }
    }

    /// Whether nothing that stands now is in the head's way.
    fn free(&self, state: &State, part: usize, k: usize) -> bool {
        let blocked = &self.problem.blocked[part][k];
        let mates = state.setup == Some(self.problem.candidates[part][k].setup);
        !blocked.meets(&state.closed) && !blocked.meets(&state.before) && (mates || !blocked.meets(&state.group))
    }

    /// A bound of what the rest costs; `None` where some part can never be printed.
    fn rest(&mut self, at: usize) -> Option<SequenceCost> {
        let state = &self.nodes[at].state;
        let placed = Self::placed(state);
        let parts = self.problem.candidates.len();
        let missing = parts - placed.len();
        let mut pending: Vec<Choice> = Vec::new();
        for part in (0..parts).filter(|&p| !placed.has(p)) {
            let ways = 0..self.problem.candidates[part].len();
            pending.extend(ways.filter(|&k| self.free(state, part, k)).map(|k| (part, k)));
        }
        self.steps += pending.len() as u64;
        let mut least: Vec<Option<SequenceCost>> = vec![None; parts];
        let mut setups: Vec<Vec<usize>> = vec![Vec::new(); if self.tariff.setup == [0; RANKS] { 0 } else { parts }];
        let full = self.single() && state.setup.is_some();
        let mut reached = if full { placed.clone() } else { state.closed.clone() };
        let mut level = usize::from(full);
        let mut last_needed = level;
        loop {
            let mut next = reached.union(&placed);
            let first = state.closed.is_empty() && level == 0;
            let before = next.clone();
            let mut grown = |pending: &mut Vec<Choice>| {
                pending.retain(|&(part, k)| {
                    let candidate = &self.problem.candidates[part][k];
                    if !self.starts(part, first, &reached)
                        || !candidate.needs.met_by(&reached)
                        || !self.no_later[part].within(&next)
                    {
                        return true;
                    }
                    let waits = if self.single() { 0 } else { level };
                    let price = plus(&self.tariff.price[part][k], &times(&self.tariff.waiting, waits));
                    if least[part].is_none() {
                        last_needed = level;
                    }
                    least[part] = Some(least[part].map_or(price, |known| known.min(price)));
                    if let Some(of_part) = setups.get_mut(part) {
                        of_part.push(candidate.setup);
                    }
                    next.insert(part);
                    false
                })
            };
            // What must come no later may become possible in the same slot.
            loop {
                let count = pending.len();
                grown(&mut pending);
                if pending.len() == count {
                    break;
                }
            }
            if next == before && next == reached {
                break;
            }
            reached = next;
            level += 1;
        }
        let mut sum = [0; RANKS];
        for part in (0..parts).filter(|&p| !placed.has(p)) {
            sum = plus(&sum, &least[part]?);
        }
        let begun = usize::from(state.setup.is_some());
        let slots = if self.single() { missing } else { last_needed + 1 - begun };
        if self.single() {
            sum = plus(&sum, &times(&self.tariff.waiting, missing * (missing - 1) / 2 + missing * begun));
        }
        let turns = if setups.is_empty() { 0 } else { setups_needed(&mut setups, state.table) };
        Some(plus(&plus(&sum, &times(&self.tariff.slot, slots)), &times(&self.tariff.setup, turns)))
    }
}

/// For each part those whose every way it blocks: they come in the same slot or before. Parts that would have to come no
/// later than each other can only be printed together, and say nothing.
fn no_later(problem: &Problem<'_>) -> Vec<PartSet> {
    let parts = problem.candidates.len();
    let mut sets = vec![PartSet::new(parts); parts];
    for (other, ways) in problem.blocked.iter().enumerate() {
        for (part, set) in sets.iter_mut().enumerate() {
            if part != other && !ways.is_empty() && ways.iter().all(|blocked| blocked.has(part)) {
                set.insert(other);
            }
        }
    }
    let mut closure = sets.clone();
    for middle in 0..parts {
        let through = closure[middle].clone();
        for set in closure.iter_mut().filter(|set| set.has(middle)) {
            *set = set.union(&through);
        }
    }
    for part in 0..parts {
        for other in closure[part].iter().filter(|&q| closure[q].has(part)) {
            sets[part].remove(other);
        }
    }
    sets
}

/// Parts no two of which share a setup, and none of which has the table's: as many turns are needed at least.
fn setups_needed(setups: &mut [Vec<usize>], table: Option<usize>) -> usize {
    setups.sort_by_key(Vec::len);
    let mut taken: Vec<usize> = table.into_iter().collect();
    let mut needed = 0;
    for of_part in setups.iter().filter(|s| !s.is_empty()) {
        if of_part.iter().all(|s| !taken.contains(s)) {
            taken.extend(of_part);
            needed += 1;
        }
    }
    needed
}

/// The same for plans that differ only in the order of setups within a slot.
fn canonical(sequence: &Sequence) -> Sequence {
    let sorted = |slot: &Vec<Choice>| {
        let mut slot = slot.clone();
        slot.sort_unstable();
        slot
    };
    sequence.iter().map(sorted).collect()
}

#[cfg(test)]
mod tests;
