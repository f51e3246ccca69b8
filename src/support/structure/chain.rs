//! Arcs with flow put together to chains, from the top of each to its foot.

use super::outline::Outline;
use crate::geom::Vec3;
use crate::support::flow::Flow;
use crate::support::graph::{ARCS, Graph};

/// The end of a chain beside another is so much of a step short of their node, so that they share no corner.
const SHORT: f64 = 0.005;

/// Arcs that follow each other.
pub(super) struct Chain {
    /// Middle and size of each cross-section, from the top; level between two of them everything is straight.
    pub(super) rings: Vec<(Vec3, f64)>,
    /// The red square at its top, where it begins at one.
    pub(super) red: Option<u32>,
    /// Whether its foot stands on the ground.
    pub(super) on_ground: bool,
}

/// All chains of a flow, by their tops from high to low.
pub(super) fn chains(graph: &Graph, flow: &Flow, outline: &Outline) -> Vec<Chain> {
    let mut is_red = vec![false; graph.squares()];
    graph.red.iter().for_each(|&red| is_red[red as usize] = true);
    let mut found = Vec::new();
    for node in (0..graph.squares()).rev().filter(|&node| flow.out(node) > 0) {
        let used: Vec<usize> = graph.arcs(node).filter(|&arc| flow.on[node][arc] > 0).collect();
        let from_above = comes(graph, flow, node).count();
        // What comes from above goes on; what more there is begins here. Nothing comes from above to a red square: the cube over
        // it is black.
        for &arc in used.iter().skip(from_above) {
            let red = is_red[node].then_some(node as u32);
            found.push(follow(graph, flow, node, arc, red, outline));
        }
    }
    found
}

/// The arcs with flow that lead to a node, straight first.
fn comes<'a>(graph: &'a Graph, flow: &'a Flow, node: usize) -> impl Iterator<Item = (usize, usize)> + 'a {
    let tails = (0..ARCS).filter_map(move |arc| graph.tail(node, arc).map(|tail| (tail, arc)));
    tails.filter(|&(tail, arc)| flow.on[tail][arc] > 0)
}

/// The chain that begins with arc `arc` of `node`.
fn follow(graph: &Graph, flow: &Flow, node: usize, arc: usize, red: Option<u32>, outline: &Outline) -> Chain {
    let size = |node: usize, arc: usize| outline.size(flow.on[node][arc]);
    let (mut rings, mut at, mut by) = (vec![(graph.grid.middle(node), size(node, arc))], node, arc);
    if red.is_none() {
        rings[0].0 = between(graph, node, graph.head(node, arc), SHORT);
    }
    loop {
        let head = graph.head(at, by);
        let middle = graph.grid.middle(head);
        if graph.is_ground(head) {
            let others = comes(graph, flow, head).next() != Some((at, by));
            // The ground takes all of them: those beside the first stand a hair smaller in its place.
            let size = size(at, by) * if others { 1.0 - SHORT } else { 1.0 };
            rings.push((middle, size));
            return Chain { rings, red, on_ground: true };
        }
        let place = comes(graph, flow, head).position(|one| one == (at, by)).unwrap_or(0);
        let Some(next) = graph.arcs(head).filter(|&arc| flow.on[head][arc] > 0).nth(place) else {
            rings.push((between(graph, head, at, SHORT), size(at, by)));
            return Chain { rings, red, on_ground: false };
        };
        let here = size(head, next).max(size(at, by));
        // A run of equal arcs needs no cross-section in between.
        if next != by || outline.grows() {
            rings.push((middle, here));
        }
        (at, by) = (head, next);
    }
}

/// The point `share` of the way from one node to another.
fn between(graph: &Graph, from: usize, to: usize, share: f64) -> Vec3 {
    let [a, b] = [from, to].map(|node| graph.grid.middle(node));
    a + (b - a) * share
}
