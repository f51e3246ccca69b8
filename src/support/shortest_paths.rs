//! `shortest-paths`: ways that share arcs while few use them (Leitereg (2020), section 3.4), and then keep to the limits.
//!
//! A unit more on an arc with `n` units costs `g(n)` times the arc's own cost, `g = 1, 0, 0, 0, 1, 2, 3, 4, ..`: an arc is paid
//! once, shared three more times for nothing, and dearer from then on. A tenth of the ways is drawn anew thirty times. All ways
//! of a round are found in one pass, so that many of them crowd onto the same arcs: of those that are used some 5 to 27 of a
//! hundred end above four. The thesis leaves them so; here the ways over them are taken up and laid where there is room.

use super::cheapest::{Cheapest, Descent, FULL, UNIT};
use super::flow::{Flow, FlowLimits};
use super::graph::{ARCS, COSTS, Graph};
use super::preflow::push_relabel;
use super::residual::Residual;
use super::ways::{Load, Ways};
use crate::geom::SplitMix64;

/// How ways are drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathDrawing {
    /// Times that ways are drawn anew.
    pub rounds: usize,
    /// The share of the ways that is drawn anew each time.
    pub share: f64,
    /// Seed of the choice.
    pub seed: u64,
    /// Whether ways over full arcs are laid elsewhere in the end, as the thesis does not.
    pub repair: bool,
}

impl Default for PathDrawing {
    fn default() -> Self {
        Self { rounds: 30, share: 0.1, seed: 1, repair: true }
    }
}

/// The price of one unit more on an arc that carries `n`, as a multiple of the arc's own cost: 1, 0, 0, 0, 1, 2, 3, 4 and so on.
///
/// Source: Leitereg (2020), section 3.4, the function g.
pub fn shared_price(n: u16) -> u32 {
    match n {
        0 => 1,
        1..FREE => 0,
        more => u32::from(more + 1 - FREE),
    }
}

/// An arc that carries this much is no longer shared for nothing.
const FREE: u16 = 4;

/// Ways from every red square that share arcs, with the limits that they needed.
pub fn shortest_paths(
    graph: &Graph,
    limits: FlowLimits,
    how: &PathDrawing,
    at: &mut dyn FnMut(usize),
) -> (Flow, FlowLimits) {
    let (mut ways, mut load, mut cheapest) =
        (Ways::of(graph), Load::none(graph, FREE.min(limits.arc)), Cheapest::none(graph));
    cheapest.find(&load, &|node, beside| prices(&load, node, beside));
    (0..graph.red.len()).for_each(|way| draw(&mut ways, &mut load, &cheapest, way));
    let mut numbers = SplitMix64::seeded(how.seed);
    let count = ((graph.red.len() as f64 * how.share).ceil() as usize).min(graph.red.len());
    for round in 0..how.rounds {
        let chosen = chosen(&mut numbers, graph.red.len(), count);
        chosen.iter().for_each(|&way| _ = load.remove(graph.red[way], ways.arcs(way), &COSTS));
        cheapest.find(&load, &|node, beside| prices(&load, node, beside));
        chosen.iter().for_each(|&way| draw(&mut ways, &mut load, &cheapest, way));
        at(round + 1);
    }
    if how.repair { repaired(load, &ways, limits) } else { (load.flow, limits) }
}

/// `count` different numbers below `of`, ascending (Knuth, volume 2, algorithm S).
fn chosen(numbers: &mut SplitMix64, of: usize, count: usize) -> Vec<usize> {
    let mut found = Vec::with_capacity(count);
    for number in 0..of {
        if (of - number) as f64 * numbers.unit() < (count - found.len()) as f64 {
            found.push(number);
        }
    }
    found
}

#[inline]
fn prices(load: &Load<'_>, node: usize, beside: u32) -> [u32; ARCS] {
    let on = &load.flow.on[node];
    std::array::from_fn(|arc| shared_price(on[arc]) * COSTS[arc] * (UNIT - beside))
}

/// Lays a way down along the cheapest arcs.
fn draw(ways: &mut Ways, load: &mut Load<'_>, cheapest: &Cheapest, way: usize) {
    let red = load.graph.red[way];
    let mut node = red as usize;
    let arcs: Vec<u8> = (0..ways.arcs(way).len())
        .map(|_| {
            let arc = cheapest.arc[node];
            node = load.graph.head(node, arc as usize);
            arc
        })
        .collect();
    load.add(red, &arcs, &COSTS);
    ways.set(way, &arcs);
}

/// Takes up the ways over arcs and nodes above their limit, as few as in their order are needed, and lays them where there is
/// room; where there is none, others make way.
fn repaired(mut load: Load<'_>, ways: &Ways, limits: FlowLimits) -> (Flow, FlowLimits) {
    let graph = load.graph;
    let mut taken = Vec::new();
    for (way, &red) in graph.red.iter().enumerate() {
        if load.is_overloaded(&limits, red, ways.arcs(way)) {
            load.remove(red, ways.arcs(way), &COSTS);
            taken.push(red);
        }
    }
    let mut cheapest = Cheapest::none(graph);
    cheapest.find(&load, &|node, beside| within(&load, &limits, node, beside));
    let mut descent = Descent::of(graph);
    taken.retain(|&red| {
        let now = |node, at| within(&load, &limits, node, u32::from(load.has_neighbour(node, at)));
        match descent.find(&load, &limits, &cheapest, &now, red) {
            Some(arcs) => {
                load.add(red, &arcs, &COSTS);
                false
            }
            None => true,
        }
    });
    completed(graph, load.flow, limits, &taken)
}

/// Prices under limits: what is used already costs nothing more.
fn within(load: &Load<'_>, limits: &FlowLimits, node: usize, beside: u32) -> [u32; ARCS] {
    let on = &load.flow.on[node];
    std::array::from_fn(|arc| match on[arc] {
        0 => COSTS[arc] * (UNIT - beside),
        n if n < limits.of_arc(node, arc) => 0,
        _ => FULL,
    })
}

/// The flow with a unit more from each of `missing`: what is there makes way, and where that is not enough limits are raised as
/// [`push_relabel`] raises them.
pub(super) fn completed(graph: &Graph, flow: Flow, limits: FlowLimits, missing: &[u32]) -> (Flow, FlowLimits) {
    if missing.is_empty() {
        return (flow, limits);
    }
    let mut residual = Residual::of(graph, limits, flow);
    for (k, &red) in missing.iter().enumerate() {
        if residual.send(red as usize) {
            continue;
        }
        let (_, raised) = push_relabel(graph, residual.limits.clone(), &mut |_| {});
        residual.limits = raised;
        // With the limits of a flow from all of them, each finds its way.
        missing[k..].iter().for_each(|&red| assert!(residual.send(red as usize), "a flow of this size is known to be"));
        break;
    }
    (residual.flow, residual.limits)
}
