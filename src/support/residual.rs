//! What of a flow can still be pushed, and taken back: the residual network of the exact methods.
//!
//! A state is a node; where nodes have limits, a node is two states, above (its index) and below (its index plus the number of
//! squares), with an inner arc between them that carries what passes the node. Red squares' units begin above; the ground takes
//! whatever comes below it.

use std::collections::HashSet;

use super::flow::{Flow, FlowLimits};
use super::graph::{ARCS, COSTS, Graph};

/// One step in the residual network.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Step {
    /// One unit more on arc `arc` of `from`.
    Push { from: usize, arc: usize },
    /// One unit less on it, walked upward.
    Take { from: usize, arc: usize },
    /// One unit more through a node.
    Enter(usize),
    /// One unit less through it.
    Leave(usize),
}

impl Step {
    /// What it adds to the cost.
    pub(super) fn cost(self) -> i32 {
        match self {
            Self::Push { arc, .. } => COSTS[arc] as i32,
            Self::Take { arc, .. } => -(COSTS[arc] as i32),
            Self::Enter(_) | Self::Leave(_) => 0,
        }
    }
}

/// The order in which arcs are pushed, and taken back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Order {
    pub(super) push: [usize; ARCS],
    pub(super) take: [usize; ARCS],
}

/// Straight arcs are filled first and emptied last (Leitereg (2020), section 3.3).
pub(super) const VERTICAL_FIRST: Order = Order { push: [0, 1, 2, 3, 4], take: [1, 2, 3, 4, 0] };

/// The most steps that leave a state.
const MOST: usize = 2 * ARCS + 1;

/// Steps with the states they lead to.
pub(super) struct Steps {
    steps: [(Step, usize); MOST],
    count: usize,
}

impl Steps {
    fn none() -> Self {
        Self { steps: [(Step::Enter(0), 0); MOST], count: 0 }
    }

    fn add(&mut self, step: Step, to: usize) {
        self.steps[self.count] = (step, to);
        self.count += 1;
    }

    pub(super) fn as_slice(&self) -> &[(Step, usize)] {
        &self.steps[..self.count]
    }
}

/// A flow within limits, on its way.
pub(super) struct Residual<'a> {
    pub(super) graph: &'a Graph,
    pub(super) limits: FlowLimits,
    pub(super) flow: Flow,
    /// What passes each node, where nodes have limits.
    inner: Vec<u16>,
    order: Order,
}

impl<'a> Residual<'a> {
    pub(super) fn new(graph: &'a Graph, limits: FlowLimits, order: Order) -> Self {
        let inner = if limits.node.is_some() { vec![0; graph.squares()] } else { Vec::new() };
        Self { graph, limits, flow: Flow::none(graph), inner, order }
    }

    /// A flow that is balanced already.
    pub(super) fn of(graph: &'a Graph, limits: FlowLimits, flow: Flow) -> Self {
        let through = |node| flow.through(graph, node);
        let inner = limits.node.map_or_else(Vec::new, |_| (0..graph.squares()).map(through).collect());
        Self { graph, limits, flow, inner, order: VERTICAL_FIRST }
    }

    fn is_split(&self) -> bool {
        !self.inner.is_empty()
    }

    pub(super) fn states(&self) -> usize {
        self.graph.squares() * if self.is_split() { 2 } else { 1 }
    }

    /// The node of a state.
    pub(super) fn node(&self, state: usize) -> usize {
        state % self.graph.squares()
    }

    /// Whether a unit in this state has arrived.
    pub(super) fn is_end(&self, state: usize) -> bool {
        self.graph.is_ground(self.node(state)) && (!self.is_split() || state >= self.graph.squares())
    }

    /// Where arcs come in and where they go out.
    fn above(&self, node: usize) -> usize {
        node
    }

    fn below(&self, node: usize) -> usize {
        if self.is_split() { node + self.graph.squares() } else { node }
    }

    /// What one unit in `state` can do: downward first.
    pub(super) fn steps(&self, state: usize) -> Steps {
        let (node, mut steps) = (self.node(state), Steps::none());
        if state == self.below(node) {
            self.pushes(node, &mut steps);
            if self.is_split() && self.inner[node] > 0 {
                steps.add(Step::Leave(node), self.above(node));
            }
        }
        if state == self.above(node) {
            if self.is_split() && self.inner[node] < self.limits.of_node(node) {
                steps.add(Step::Enter(node), self.below(node));
            }
            self.takes(node, &mut steps);
        }
        steps
    }

    fn pushes(&self, node: usize, steps: &mut Steps) {
        let (there, on) = (self.graph.arc_bits(node), &self.flow.on[node]);
        for arc in self.order.push.into_iter().filter(|arc| there & (1 << arc) != 0) {
            if on[arc] < self.limits.of_arc(node, arc) {
                steps.add(Step::Push { from: node, arc }, self.above(self.graph.head(node, arc)));
            }
        }
    }

    fn takes(&self, node: usize, steps: &mut Steps) {
        for arc in self.order.take {
            if let Some(from) = self.graph.tail(node, arc).filter(|&from| self.flow.on[from][arc] > 0) {
                steps.add(Step::Take { from, arc }, self.below(from));
            }
        }
    }

    /// The states from which one step leads to `state`.
    pub(super) fn before(&self, state: usize) -> Vec<usize> {
        let (node, mut states) = (self.node(state), Vec::new());
        if state == self.above(node) {
            for arc in 0..ARCS {
                let tail = self.graph.tail(node, arc);
                let open = tail.filter(|&from| self.flow.on[from][arc] < self.limits.of_arc(from, arc));
                states.extend(open.map(|from| self.below(from)));
            }
            if self.is_split() && self.inner[node] > 0 {
                states.push(self.below(node));
            }
        }
        if state == self.below(node) {
            let used = self.graph.arcs(node).filter(|&arc| self.flow.on[node][arc] > 0);
            states.extend(used.map(|arc| self.above(self.graph.head(node, arc))));
            if self.is_split() && self.inner[node] < self.limits.of_node(node) {
                states.push(self.above(node));
            }
        }
        states
    }

    /// How many units a step can take now.
    pub(super) fn room(&self, step: Step) -> u16 {
        match step {
            Step::Push { from, arc } => self.limits.of_arc(from, arc) - self.flow.on[from][arc],
            Step::Take { from, arc } => self.flow.on[from][arc],
            Step::Enter(node) => self.limits.of_node(node) - self.inner[node],
            Step::Leave(node) => self.inner[node],
        }
    }

    /// Takes a step with `units`.
    pub(super) fn take(&mut self, step: Step, units: u16) {
        match step {
            Step::Push { from, arc } => self.flow.on[from][arc] += units,
            Step::Take { from, arc } => self.flow.on[from][arc] -= units,
            Step::Enter(node) => self.inner[node] += units,
            Step::Leave(node) => self.inner[node] -= units,
        }
    }

    /// Sends one unit from a red square along any way there is; `false`, and nothing changed, where there is none.
    pub(super) fn send(&mut self, red: usize) -> bool {
        let mut seen = HashSet::from([red]);
        let mut way: Vec<(usize, Step)> = Vec::new();
        let mut state = red;
        while !self.is_end(state) {
            let steps = self.steps(state);
            if let Some(&(step, to)) = steps.as_slice().iter().find(|&&(_, to)| !seen.contains(&to)) {
                seen.insert(to);
                way.push((state, step));
                state = to;
            } else if let Some((before, _)) = way.pop() {
                state = before;
            } else {
                return false;
            }
        }
        way.into_iter().for_each(|(_, step)| self.take(step, 1));
        true
    }

    /// Allows one unit more on what the step needs.
    pub(super) fn raise(&mut self, step: Step) {
        match step {
            Step::Push { from, arc } => {
                let now = self.limits.of_arc(from, arc);
                self.limits.raised_arcs.insert((from as u32, arc as u8), now + 1);
            }
            Step::Enter(node) => {
                let now = self.limits.of_node(node);
                self.limits.raised_nodes.insert(node as u32, now + 1);
            }
            Step::Take { .. } | Step::Leave(_) => {}
        }
    }

    /// The steps out of a state that only a limit forbids, with that limit.
    pub(super) fn forbidden(&self, state: usize) -> Vec<(u16, Step, usize)> {
        let (node, mut steps) = (self.node(state), Vec::new());
        if state == self.below(node) {
            for arc in self.graph.arcs(node) {
                let most = self.limits.of_arc(node, arc);
                if self.flow.on[node][arc] >= most {
                    steps.push((most, Step::Push { from: node, arc }, self.above(self.graph.head(node, arc))));
                }
            }
        }
        if self.is_split() && state == self.above(node) && self.inner[node] >= self.limits.of_node(node) {
            steps.push((self.limits.of_node(node), Step::Enter(node), self.below(node)));
        }
        steps
    }
}
