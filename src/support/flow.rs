//! A flow from red squares to the ground, its limits, and what it comes to.
//!
//! One unit leaves every red square. Flow on an arc is a count; so are limits.

use std::collections::BTreeMap;

use super::graph::{ARCS, COSTS, Graph};

/// How much an arc and a node may carry.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FlowLimits {
    /// Each arc.
    pub arc: u16,
    /// All that passes a node; `None`: as much as its arcs.
    pub node: Option<u16>,
    /// Arcs (node above, number) that were allowed more, so that nothing stays unsupported that can be held.
    pub raised_arcs: BTreeMap<(u32, u8), u16>,
    /// Nodes that were allowed more.
    pub raised_nodes: BTreeMap<u32, u16>,
}

impl FlowLimits {
    /// `arc` on every arc, `node` through every node.
    pub fn new(arc: u16, node: Option<u16>) -> Self {
        Self { arc, node, raised_arcs: BTreeMap::new(), raised_nodes: BTreeMap::new() }
    }

    /// What an arc may carry.
    pub fn of_arc(&self, from: usize, arc: usize) -> u16 {
        if self.raised_arcs.is_empty() {
            return self.arc;
        }
        self.raised_arcs.get(&(from as u32, arc as u8)).copied().unwrap_or(self.arc)
    }

    /// What may pass a node.
    pub fn of_node(&self, node: usize) -> u16 {
        let all = self.node.unwrap_or(u16::MAX);
        if self.raised_nodes.is_empty() { all } else { self.raised_nodes.get(&(node as u32)).copied().unwrap_or(all) }
    }
}

/// Units on each arc, five a square, in the order of [`COSTS`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Flow {
    /// By the node above.
    pub on: Vec<[u16; ARCS]>,
}

/// What a flow comes to.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tally {
    /// Sum of flow times cost, 1 for straight and 2 for oblique arcs.
    pub cost: u64,
    /// Straight arcs with flow.
    pub straight: usize,
    /// Oblique arcs with flow.
    pub oblique: usize,
    /// Arcs and nodes that carry more than the limits given, raised ones among them.
    pub over_capacity: usize,
    /// The most that an arc carries.
    pub most: u16,
}

impl Tally {
    /// Arcs with flow.
    pub fn used_arcs(&self) -> usize {
        self.straight + self.oblique
    }

    /// Their lengths together, mm: a step for a straight arc, the root of two steps for an oblique one.
    pub fn length_mm(&self, step_mm: f64) -> f64 {
        step_mm * (self.straight as f64 + std::f64::consts::SQRT_2 * self.oblique as f64)
    }
}

impl Flow {
    /// No flow.
    pub fn none(graph: &Graph) -> Self {
        Self { on: vec![[0; ARCS]; graph.squares()] }
    }

    /// All that leaves a node.
    pub fn out(&self, node: usize) -> u16 {
        self.on[node].iter().sum()
    }

    /// All that passes a node: what leaves it, and on the ground what comes.
    pub fn through(&self, graph: &Graph, node: usize) -> u16 {
        if !graph.is_ground(node) {
            return self.out(node);
        }
        (0..ARCS).filter_map(|arc| graph.tail(node, arc).map(|tail| self.on[tail][arc])).sum()
    }

    /// Sums it up; `arc` and `node` are the limits asked for.
    pub fn tally(&self, graph: &Graph, arc: u16, node: Option<u16>) -> Tally {
        let mut tally = Tally::default();
        for (from, on) in self.on.iter().enumerate() {
            for (k, &units) in on.iter().enumerate().filter(|(_, units)| **units > 0) {
                tally.cost += u64::from(units) * u64::from(COSTS[k]);
                *(if k == 0 { &mut tally.straight } else { &mut tally.oblique }) += 1;
                tally.over_capacity += usize::from(units > arc);
                tally.most = tally.most.max(units);
            }
            if let Some(most) = node.filter(|_| graph.is_node(from)) {
                tally.over_capacity += usize::from(self.through(graph, from) > most);
            }
        }
        tally
    }

    /// The first node at which what comes (a unit at each red square) is not what goes, if there is one.
    pub fn unbalanced(&self, graph: &Graph) -> Option<usize> {
        let mut balance = vec![0_i64; self.on.len()];
        graph.red.iter().for_each(|&red| balance[red as usize] += 1);
        for (from, on) in self.on.iter().enumerate() {
            for (arc, &units) in on.iter().enumerate().filter(|(_, units)| **units > 0) {
                if graph.arcs(from).all(|there| there != arc) {
                    return Some(from);
                }
                balance[from] -= i64::from(units);
                balance[graph.head(from, arc)] += i64::from(units);
            }
        }
        (graph.grid.level()..balance.len()).find(|&node| balance[node] != 0)
    }
}
