//! `push-relabel`: the largest flow (Goldberg and Tarjan, 1986), with straight arcs first both ways (Leitereg (2020), section 3.3).
//!
//! Every arc goes one level down and every node reaches the ground, so a node's level plus one is its true distance from the
//! sink: the labels begin exact. Active states are taken highest label first, which is one wave down the levels as long as
//! nothing is full. A label above all levels that nothing has any more is a gap: what lies above it is cut off.
//!
//! Where the flow is stuck at a cut, the smallest limit in it is raised by one, a straight arc's first, and the flow goes on:
//! nothing stays unsupported that can be held.

use std::collections::VecDeque;

use super::flow::{Flow, FlowLimits};
use super::graph::Graph;
use super::residual::{Order, Residual, Step, VERTICAL_FIRST};

/// The label of what is cut off from the ground.
const CUT_OFF: u32 = u32::MAX;

/// A flow from every red square, with the limits that it needed.
pub fn push_relabel(graph: &Graph, limits: FlowLimits, at: &mut dyn FnMut(usize)) -> (Flow, FlowLimits) {
    in_order(graph, limits, VERTICAL_FIRST, at)
}

/// The same with arcs in another order.
pub(super) fn in_order(
    graph: &Graph,
    limits: FlowLimits,
    order: Order,
    at: &mut dyn FnMut(usize),
) -> (Flow, FlowLimits) {
    let mut preflow = Preflow::new(graph, limits, order);
    let mut grown = 0;
    loop {
        preflow.push_all();
        if preflow.stuck.is_empty() {
            return (preflow.residual.flow, preflow.residual.limits);
        }
        grown += 1;
        at(grown);
        preflow.grow();
    }
}

struct Preflow<'a> {
    residual: Residual<'a>,
    excess: Vec<u16>,
    label: Vec<u32>,
    /// Active states by label.
    active: Vec<Vec<u32>>,
    highest: usize,
    /// Labels above this are had by few; how many have each of them.
    levels: u32,
    count: Vec<u32>,
    /// States whose label was above that once.
    lifted: Vec<u32>,
    /// States with excess that are cut off.
    stuck: Vec<u32>,
}

impl<'a> Preflow<'a> {
    fn new(graph: &'a Graph, limits: FlowLimits, order: Order) -> Self {
        let residual = Residual::new(graph, limits, order);
        let (squares, level) = (graph.squares(), graph.grid.level());
        let split = residual.states() > squares;
        // With two states a node the ways are twice as long.
        let true_label = |state: usize| {
            let z = (state % squares / level) as u32;
            if split { 2 * z + if state < squares { 2 } else { 1 } } else { z + 1 }
        };
        let label: Vec<u32> = (0..residual.states()).map(true_label).collect();
        let levels = 2 * graph.grid.size[2] as u32 + 2;
        let mut preflow = Self {
            excess: vec![0; residual.states()],
            label,
            active: Vec::new(),
            highest: 0,
            levels,
            count: Vec::new(),
            lifted: Vec::new(),
            stuck: Vec::new(),
            residual,
        };
        for &red in &graph.red {
            preflow.excess[red as usize] = 1;
            preflow.activate(red as usize);
        }
        preflow
    }

    fn activate(&mut self, state: usize) {
        let label = self.label[state] as usize;
        if self.active.len() <= label {
            self.active.resize_with(label + 1, Vec::new);
        }
        self.active[label].push(state as u32);
        self.highest = self.highest.max(label);
    }

    /// Pushes until every unit has arrived or is cut off.
    fn push_all(&mut self) {
        loop {
            let Some(state) = self.active.get_mut(self.highest).and_then(Vec::pop) else {
                if self.highest == 0 {
                    return;
                }
                self.highest -= 1;
                continue;
            };
            // One that was relabelled, emptied or cut off since stands in the list all the same.
            if self.label[state as usize] as usize == self.highest && self.excess[state as usize] > 0 {
                self.discharge(state as usize);
            }
        }
    }

    fn discharge(&mut self, state: usize) {
        loop {
            let label = self.label[state];
            for &(step, to) in self.residual.steps(state).as_slice() {
                if self.label[to].saturating_add(1) == label {
                    self.push(state, step, to);
                    if self.excess[state] == 0 {
                        return;
                    }
                }
            }
            self.relabel(state);
            if self.label[state] == CUT_OFF {
                return;
            }
        }
    }

    fn push(&mut self, from: usize, step: Step, to: usize) {
        let units = self.excess[from].min(self.residual.room(step));
        self.residual.take(step, units);
        self.excess[from] -= units;
        if self.residual.is_end(to) {
            return;
        }
        if self.excess[to] == 0 {
            self.activate(to);
        }
        self.excess[to] += units;
    }

    /// Lifts a state above the lowest that it can push to; closes the gap that this may leave.
    fn relabel(&mut self, state: usize) {
        let lowest = self.residual.steps(state).as_slice().iter().map(|&(_, to)| self.label[to]).min();
        let (old, new) = (self.label[state], lowest.map_or(CUT_OFF, |label| label.saturating_add(1)));
        self.set_label(state, new);
        if old > self.levels && self.count[old as usize] == 0 {
            let above: Vec<u32> = std::mem::take(&mut self.lifted);
            for other in above {
                let label = self.label[other as usize];
                if label != CUT_OFF && label > old {
                    self.set_label(other as usize, CUT_OFF);
                } else if label != CUT_OFF && label > self.levels {
                    self.lifted.push(other);
                }
            }
        }
    }

    fn set_label(&mut self, state: usize, label: u32) {
        let old = std::mem::replace(&mut self.label[state], label);
        if old > self.levels && old != CUT_OFF {
            self.count[old as usize] -= 1;
        }
        if label == CUT_OFF {
            if self.excess[state] > 0 {
                self.stuck.push(state as u32);
            }
            return;
        }
        if label > self.levels {
            if self.count.len() <= label as usize {
                self.count.resize(label as usize + 1, 0);
            }
            self.count[label as usize] += 1;
            if old <= self.levels || old == CUT_OFF {
                self.lifted.push(state as u32);
            }
        }
    }

    /// Raises the smallest limit in the cut that holds the excess back, and labels anew what can go on through it.
    fn grow(&mut self) {
        let inside = self.reached();
        let mut is_inside: Vec<u32> = inside.clone();
        is_inside.sort_unstable();
        let holds = |state: usize| is_inside.binary_search(&(state as u32)).is_ok();
        let straight = |step: Step| !matches!(step, Step::Push { arc, .. } if arc > 0);
        let forbidden = inside.iter().flat_map(|&state| {
            let from = state as usize;
            self.residual
                .forbidden(from)
                .into_iter()
                .map(move |(most, step, to)| (most, !straight(step), from, step, to))
        });
        let leads_on = |to: usize| self.label[to] != CUT_OFF;
        let cut = forbidden.filter(|&(.., to)| !holds(to));
        // What leads to where the ground can be reached comes first. Red squares have ways to the ground, so a cut that holds them back
        // is made of limits only.
        let least = cut.min_by_key(|&(most, oblique, from, _, to)| (!leads_on(to), most, oblique, from));
        let Some((.., from, step, to)) = least else { unreachable!("every red square has a way to the ground") };
        let beyond = self.label[to];
        self.residual.raise(step);
        if beyond == CUT_OFF {
            // One cut lies behind another: the next turn sees it.
            return;
        }
        self.label_behind(from, beyond + 1);
        let stuck = std::mem::take(&mut self.stuck);
        for state in stuck {
            match self.label[state as usize] {
                CUT_OFF => self.stuck.push(state),
                _ => self.activate(state as usize),
            }
        }
    }

    /// Everything that the stuck excess can still reach.
    fn reached(&mut self) -> Vec<u32> {
        let mut seen = vec![false; self.residual.states()];
        let mut queue: Vec<u32> = self.stuck.clone();
        queue.iter().for_each(|&state| seen[state as usize] = true);
        let mut next = 0;
        while let Some(&state) = queue.get(next) {
            next += 1;
            for &(_, to) in self.residual.steps(state as usize).as_slice() {
                if !std::mem::replace(&mut seen[to], true) {
                    queue.push(to as u32);
                }
            }
        }
        queue
    }

    /// True labels of what leads to `first` within the cut, which gets `label`.
    fn label_behind(&mut self, first: usize, label: u32) {
        let mut queue = VecDeque::from([first]);
        self.set_label(first, label);
        while let Some(state) = queue.pop_front() {
            let next = self.label[state] + 1;
            for before in self.residual.before(state) {
                if self.label[before] == CUT_OFF || self.label[before] > next {
                    self.set_label(before, next);
                    queue.push_back(before);
                }
            }
        }
    }
}
