//! Struts: what ties columns that stand free over a long way to others, or to the ground.
//!
//! A column is free at a level where no other piece of support is beside it, corners included; a slender one bends under the nozzle.
//! Where one is free over more levels than are allowed, a strut leaves it: along the graph's own arcs, so clear of the part and of itself
//! printable, first aside, then the shortest way to another column, or else down beside it to the ground. Struts carry nothing of
//! what is held. They are free columns themselves where they are long, so this is repeated until none is too long.
//!
//! Lengths in mm, or in levels of the grid.

use std::collections::{BTreeMap, BTreeSet};

use super::flow::Flow;
use super::graph::{ARCS, Graph};

/// Supports with their struts.
#[derive(Clone, Debug)]
pub struct Braced {
    /// The flow, and one unit on each arc of a strut: for building, since struts begin at no red square.
    pub flow: Flow,
    /// Arcs that only struts use.
    pub struts: usize,
    /// Columns that stay free over a longer way, since nothing leads aside from them.
    pub unbraced: usize,
}

/// Passes over all columns, at most: each gives every column one strut more.
const PASSES: usize = 200;

/// Ties the columns of `flow` together so that none is free over more than `most_mm`.
pub fn braced(graph: &Graph, flow: &Flow, most_mm: f64) -> Braced {
    let most = (most_mm / graph.grid.step_mm + 1e-9) as u32;
    let mut bracing = Bracing { graph, flow: flow.clone(), used: used(graph, flow), struts: 0 };
    let mut hopeless = BTreeSet::new();
    for _ in 0..PASSES {
        let long = bracing.longer_than(most);
        let mut changed = false;
        for node in long.into_iter().filter(|node| !hopeless.contains(node)).collect::<Vec<_>>() {
            // A strut of the same pass may have tied it.
            if !bracing.is_alone(node) {
                continue;
            }
            if bracing.add_strut(node) {
                changed = true;
            } else {
                hopeless.insert(node);
            }
        }
        if !changed {
            break;
        }
    }
    let unbraced = bracing.longer_than(most).len();
    Braced { flow: bracing.flow, struts: bracing.struts, unbraced }
}

/// Over how many levels down from each piece that has none beside it this is so, by its square.
pub(super) fn free_levels(graph: &Graph, flow: &Flow) -> BTreeMap<usize, u32> {
    Bracing { graph, flow: flow.clone(), used: used(graph, flow), struts: 0 }.free()
}

/// The squares that something passes.
fn used(graph: &Graph, flow: &Flow) -> BTreeSet<usize> {
    let leaving = (0..graph.squares()).filter(|&node| flow.out(node) > 0);
    let heads =
        |node: usize| (0..ARCS).filter(move |&arc| flow.on[node][arc] > 0).map(move |arc| graph.head(node, arc));
    leaving.flat_map(|node| heads(node).chain([node])).collect()
}

struct Bracing<'a> {
    graph: &'a Graph,
    flow: Flow,
    used: BTreeSet<usize>,
    struts: usize,
}

impl Bracing<'_> {
    fn heads(&self, node: usize) -> impl Iterator<Item = usize> + '_ {
        (0..ARCS).filter(move |&arc| self.flow.on[node][arc] > 0).map(move |arc| self.graph.head(node, arc))
    }

    /// Whether nothing passes the eight squares around one.
    fn is_alone(&self, node: usize) -> bool {
        let ([x, y, z], size) = (self.graph.grid.cube(node), self.graph.grid.size);
        let around = |at: usize, size: usize| at.saturating_sub(1)..(at + 2).min(size);
        let mut beside = around(y, size[1]).flat_map(|v| around(x, size[0]).map(move |u| [u, v, z]));
        !beside.any(|cube| cube != [x, y, z] && self.used.contains(&self.graph.grid.index(cube)))
    }

    /// The levels over which the column below a square is free, the square's own among them; what stands on the ground is tied there.
    fn free(&self) -> BTreeMap<usize, u32> {
        let mut free: BTreeMap<usize, u32> = BTreeMap::new();
        for &node in self.used.iter().filter(|&&node| !self.graph.is_ground(node) && self.is_alone(node)) {
            let below = self.heads(node).filter_map(|head| free.get(&head)).max().copied().unwrap_or(0);
            free.insert(node, below + 1);
        }
        free
    }

    /// Where columns have been free over one level too many, from below.
    fn longer_than(&self, most: u32) -> Vec<usize> {
        self.free().into_iter().filter(|(_, levels)| *levels == most + 1).map(|(node, _)| node).collect()
    }

    /// Ties the column at a square, by a strut that is beside it there: it leaves the square above, or this one where that is the top.
    fn add_strut(&mut self, node: usize) -> bool {
        let above = (0..ARCS).filter_map(|arc| self.graph.tail(node, arc).map(|tail| (tail, arc)));
        let above = above.filter(|&(tail, arc)| self.flow.on[tail][arc] > 0).map(|(tail, _)| tail);
        let starts: Vec<usize> = above.chain([node]).collect();
        let Some(way) = starts.into_iter().find_map(|start| self.way_aside(start)) else { return false };
        for (from, arc) in way {
            self.flow.on[from][arc] = 1;
            self.used.extend([from, self.graph.head(from, arc)]);
            self.struts += 1;
        }
        true
    }

    /// The arcs of the shortest strut from a square: aside at once, over squares that nothing passes, to one that something else
    /// passes or to the ground; of those as short, the straightest.
    fn way_aside(&self, start: usize) -> Option<Vec<(usize, usize)>> {
        let own = self.downstream(start);
        // By square: how many arcs of the way lean, and the last arc.
        let mut levels: Vec<BTreeMap<usize, (u32, usize, usize)>> = vec![BTreeMap::from([(start, (0, start, 0))])];
        loop {
            let last = levels.last().filter(|last| !last.is_empty())?;
            let mut next: BTreeMap<usize, (u32, usize, usize)> = BTreeMap::new();
            for (&from, &(leaning, ..)) in last {
                for arc in self.graph.arcs(from).filter(|&arc| levels.len() > 1 || arc > 0) {
                    let head = self.graph.head(from, arc);
                    let way = (leaning + u32::from(arc > 0), from, arc);
                    let free = !own.contains(&head) && self.flow.on[from][arc] == 0;
                    if free && next.get(&head).is_none_or(|known| way < *known) {
                        next.insert(head, way);
                    }
                }
            }
            let ends = |square: &usize| self.used.contains(square) || self.graph.is_ground(*square);
            let end = next.iter().filter(|(head, _)| ends(head)).min_by_key(|(_, way)| **way).map(|(head, _)| *head);
            levels.push(next);
            if let Some(end) = end {
                return Some(traced(&levels, end));
            }
        }
    }

    /// The squares below one that its own units pass.
    fn downstream(&self, start: usize) -> BTreeSet<usize> {
        let (mut all, mut next) = (BTreeSet::from([start]), vec![start]);
        while let Some(node) = next.pop() {
            next.extend(self.heads(node).filter(|head| all.insert(*head)).collect::<Vec<_>>());
        }
        all
    }
}

/// The arcs that led to `end`, from the top.
fn traced(levels: &[BTreeMap<usize, (u32, usize, usize)>], end: usize) -> Vec<(usize, usize)> {
    let (mut way, mut at) = (Vec::new(), end);
    for level in levels[1..].iter().rev() {
        let (_, from, arc) = level[&at];
        way.push((from, arc));
        at = from;
    }
    way.reverse();
    way
}
