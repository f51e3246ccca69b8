//! One method's supports for a graph, with their tally and a bound.

use super::auto::{Effort, least_material};
use super::flow::{Flow, FlowLimits, Tally};
use super::graph::Graph;
use super::min_cost::{min_cost, unlimited_cost};
use super::preflow::push_relabel;
use super::shortest_paths::{PathDrawing, shortest_paths};

/// How supports are planned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FlowMethod {
    /// Least material within the limits.
    Auto,
    /// The cheapest flow, exactly.
    MinCost,
    /// The largest flow, straight arcs first; the fastest.
    PushRelabel,
    /// Ways that share arcs.
    ShortestPaths,
}

impl FlowMethod {
    /// All, with their names.
    pub const NAMED: [(&'static str, Self); 4] = [
        ("auto", Self::Auto),
        ("min-cost", Self::MinCost),
        ("push-relabel", Self::PushRelabel),
        ("shortest-paths", Self::ShortestPaths),
    ];
}

/// Supports as a flow.
#[derive(Clone, Debug)]
pub struct PlannedFlow {
    /// One unit from each red square that reaches the ground.
    pub flow: Flow,
    /// The limits, with those that had to be raised.
    pub limits: FlowLimits,
    /// What the flow comes to.
    pub tally: Tally,
    /// No flow within the limits costs less: of `auto` and `min-cost` the least cost itself, of the others the cost without limits.
    pub lower_bound: u64,
    /// No flow within the limits has fewer arcs: each level is passed by all that begin above it.
    pub fewest_arcs: usize,
}

/// Plans supports: `arc` units on an arc and `node` through a node at most, where that holds nothing back. `at` hears how far it is,
/// in hundredths.
pub fn plan(
    graph: &Graph,
    method: FlowMethod,
    arc: u16,
    node: Option<u16>,
    seed: u64,
    at: &mut dyn FnMut(usize),
) -> PlannedFlow {
    let (limits, count) = (FlowLimits::new(arc, node), graph.red.len().max(1));
    let drawing = PathDrawing { seed, ..PathDrawing::default() };
    let (flow, limits, bound) = match method {
        FlowMethod::Auto => {
            let effort = Effort { seed, ..Effort::default() };
            let (flow, limits, bound) = least_material(graph, limits, &effort, &mut |done, of| at(100 * done / of));
            (flow, limits, Some(bound))
        }
        FlowMethod::MinCost => {
            let (flow, limits) = min_cost(graph, limits, &mut |done| at(100 * done / count));
            let cost = flow.tally(graph, arc, node).cost;
            (flow, limits, Some(cost))
        }
        FlowMethod::PushRelabel => {
            let (flow, limits) = push_relabel(graph, limits, &mut |_| {});
            (flow, limits, None)
        }
        FlowMethod::ShortestPaths => {
            let rounds = drawing.rounds;
            let (flow, limits) = shortest_paths(graph, limits, &drawing, &mut |done| at(100 * done / rounds));
            (flow, limits, None)
        }
    };
    let tally = flow.tally(graph, arc, node);
    let lower_bound = bound.unwrap_or_else(|| unlimited_cost(graph));
    PlannedFlow { tally, lower_bound, fewest_arcs: fewest_arcs(graph, &limits), flow, limits }
}

/// Arcs that any flow within the limits uses at least: between two levels as many as what begins above fills.
fn fewest_arcs(graph: &Graph, limits: &FlowLimits) -> usize {
    let most = limits.raised_arcs.values().copied().max().unwrap_or(limits.arc).max(limits.arc);
    let mut begins = vec![0_usize; graph.grid.size[2]];
    graph.red.iter().for_each(|&red| begins[red as usize / graph.grid.level()] += 1);
    let above = begins.iter().skip(1).rev().scan(0, |above, here| {
        *above += here;
        Some(*above)
    });
    above.map(|above: usize| above.div_ceil(usize::from(most))).sum()
}
