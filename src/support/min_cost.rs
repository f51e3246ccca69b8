//! `min-cost`: the cheapest flow, exactly, by a primal-dual method (Ford and Fulkerson, 1962) on the implicit graph.
//!
//! Every node's potential is a lower bound on the cost of its way to the ground. Without limits the bounds are the ways
//! themselves, found in one pass from the ground up, and nearly every unit goes down along arcs of no reduced cost. For the
//! units that meet full arcs, the potentials of whatever they reach are raised by as much as the next way costs more (Dijkstra
//! from all of them at once; costs are small integers, so a list for each distance is the queue), and they go on. All reduced
//! costs stay at 0 or above on what can be pushed, which proves the flow the cheapest.

use super::flow::{Flow, FlowLimits};
use super::graph::{ARCS, COSTS, Graph};
use super::preflow::push_relabel;
use super::residual::{Residual, Step, VERTICAL_FIRST};

/// The cost of the cheapest way from every square to the ground, limits aside; 0 where there is none.
pub(super) fn distances(graph: &Graph) -> Vec<u32> {
    let (level, mut cost) = (graph.grid.level(), vec![0_u32; graph.squares()]);
    for node in level..graph.squares() {
        if graph.arc_bits(node) != 0 {
            cost[node] = graph.arcs(node).map(|arc| COSTS[arc] + cost[graph.head(node, arc)]).min().unwrap_or(0);
        }
    }
    cost
}

/// The cost of the flow when nothing has a limit: no flow costs less.
pub fn unlimited_cost(graph: &Graph) -> u64 {
    let cost = distances(graph);
    graph.red.iter().map(|&red| u64::from(cost[red as usize])).sum()
}

/// The cheapest flow from every red square, with the limits that it needed: where `limits` hold some back, they are raised as
/// [`push_relabel`] raises them. `at` hears how many units have arrived.
pub fn min_cost(graph: &Graph, limits: FlowLimits, at: &mut dyn FnMut(usize)) -> (Flow, FlowLimits) {
    if let Some(flow) = Search::new(graph, limits.clone()).run(at) {
        return (flow, limits);
    }
    let (_, raised) = push_relabel(graph, limits, &mut |_| {});
    let flow = Search::new(graph, raised.clone()).run(at).expect("a flow of this size is known to be");
    (flow, raised)
}

/// A distance that was not found.
const FAR: u32 = u32::MAX;

struct Search<'a> {
    residual: Residual<'a>,
    potential: Vec<i32>,
    distance: Vec<u32>,
    /// What [`Self::distance`] was set for.
    touched: Vec<u32>,
    /// States from which nothing can arrive in this round, and those on the way that is being looked for.
    closed: Vec<bool>,
    queues: Vec<Vec<u32>>,
}

impl<'a> Search<'a> {
    fn new(graph: &'a Graph, limits: FlowLimits) -> Self {
        let residual = Residual::new(graph, limits, VERTICAL_FIRST);
        let costs = distances(graph);
        let states = residual.states();
        let potential = (0..states).map(|state| costs[residual.node(state)] as i32).collect();
        let (distance, closed) = (vec![FAR; states], vec![false; states]);
        Self { residual, potential, distance, touched: Vec::new(), closed, queues: Vec::new() }
    }

    /// The flow, or nothing where the limits hold some units back.
    fn run(mut self, at: &mut dyn FnMut(usize)) -> Option<Flow> {
        let mut waiting: Vec<u32> = self.residual.graph.red.clone();
        let all = waiting.len();
        loop {
            let mut shut = Vec::new();
            waiting.retain(|&red| !self.send(red as usize, &mut shut));
            shut.into_iter().for_each(|state| self.closed[state as usize] = false);
            at(all - waiting.len());
            if waiting.is_empty() {
                return Some(self.residual.flow);
            }
            if !self.raise(&waiting) {
                return None;
            }
        }
    }

    /// Sends one unit along steps of no reduced cost, if there is such a way; `shut` gathers where there is none.
    fn send(&mut self, from: usize, shut: &mut Vec<u32>) -> bool {
        if self.closed[from] {
            return false;
        }
        let mut way: Vec<(usize, Step)> = Vec::new();
        let mut state = from;
        self.close(state, shut);
        loop {
            if self.residual.is_end(state) {
                for (before, step) in way {
                    self.residual.take(step, 1);
                    // What is on a way that was found may be on another.
                    self.closed[before] = false;
                }
                self.closed[state] = false;
                return true;
            }
            let steps = self.residual.steps(state);
            let free = |&&(step, to): &&(Step, usize)| !self.closed[to] && self.reduced(state, step, to) == 0;
            if let Some(&(step, to)) = steps.as_slice().iter().find(free) {
                way.push((state, step));
                state = to;
                self.close(state, shut);
            } else if let Some((before, _)) = way.pop() {
                state = before;
            } else {
                return false;
            }
        }
    }

    fn close(&mut self, state: usize, shut: &mut Vec<u32>) {
        self.closed[state] = true;
        shut.push(state as u32);
    }

    /// The cost of a step by the potentials; 0 or more on every step that can be taken.
    fn reduced(&self, from: usize, step: Step, to: usize) -> i32 {
        step.cost() + self.potential[to] - self.potential[from]
    }

    /// Raises potentials until one of the waiting units has a way; `false` where none ever has.
    fn raise(&mut self, waiting: &[u32]) -> bool {
        self.queues.iter_mut().for_each(Vec::clear);
        self.touched.clear();
        for &state in waiting {
            self.reach(state as usize, 0);
        }
        let found = self.nearest_end();
        let by = found.unwrap_or(0);
        for i in 0..self.touched.len() {
            let state = self.touched[i] as usize;
            let distance = std::mem::replace(&mut self.distance[state], FAR);
            if distance < by {
                self.potential[state] += (by - distance) as i32;
            }
        }
        found.is_some()
    }

    /// How much more than the potentials say the nearest end costs.
    fn nearest_end(&mut self) -> Option<u32> {
        let mut at = 0;
        while at < self.queues.len() {
            while let Some(state) = self.queues[at].pop() {
                let state = state as usize;
                if self.distance[state] != at as u32 {
                    continue;
                }
                if self.residual.is_end(state) {
                    return Some(at as u32);
                }
                for &(step, to) in self.residual.steps(state).as_slice() {
                    let further = at as u32 + self.reduced(state, step, to) as u32;
                    if further < self.distance[to] {
                        self.reach(to, further);
                    }
                }
            }
            at += 1;
        }
        None
    }

    fn reach(&mut self, state: usize, distance: u32) {
        if self.distance[state] == FAR {
            self.touched.push(state as u32);
        }
        self.distance[state] = distance;
        if self.queues.len() <= distance as usize {
            self.queues.resize_with(distance as usize + 1, Vec::new);
        }
        self.queues[distance as usize].push(state as u32);
    }
}

const _: () = assert!(ARCS == 5);
