//! A flow as ways: one from each red square to the ground, with what they load on arcs and nodes.
//!
//! A way from level z is z arcs, so that all ways lie in one list, each at its own place.

use super::flow::{Flow, FlowLimits};
use super::graph::{ARCS, Graph};

/// A way from each red square, in the order of [`Graph::red`].
#[derive(Clone, Debug)]
pub(super) struct Ways {
    first: Vec<usize>,
    arcs: Vec<u8>,
}

impl Ways {
    /// Places for the ways of `graph`, all straight down as yet.
    pub(super) fn of(graph: &Graph) -> Self {
        let mut first = vec![0];
        for &red in &graph.red {
            first.push(first[first.len() - 1] + red as usize / graph.grid.level());
        }
        let arcs = vec![0; first[first.len() - 1]];
        Self { first, arcs }
    }

    /// The arcs of a way, from the top.
    pub(super) fn arcs(&self, way: usize) -> &[u8] {
        &self.arcs[self.first[way]..self.first[way + 1]]
    }

    /// Gives a way other arcs.
    pub(super) fn set(&mut self, way: usize, arcs: &[u8]) {
        self.arcs[self.first[way]..self.first[way + 1]].copy_from_slice(arcs);
    }
}

/// What ways load on arcs and nodes.
pub(super) struct Load<'a> {
    pub(super) graph: &'a Graph,
    pub(super) flow: Flow,
    /// Ways through each node.
    pub(super) through: Vec<u16>,
    /// By node, the arcs that carry something, in the bits of [`Graph::arc_bits`], and [`BUSY`].
    pub(super) marks: Vec<u8>,
    /// An arc is busy with so many units.
    busy: u16,
}

/// What a node is marked with while one of its arcs is busy.
pub(super) const BUSY: u8 = 1 << 7;

impl<'a> Load<'a> {
    /// Nothing yet; an arc is to be busy with `busy` units.
    pub(super) fn none(graph: &'a Graph, busy: u16) -> Self {
        let squares = graph.squares();
        Self { graph, flow: Flow::none(graph), through: vec![0; squares], marks: vec![0; squares], busy }
    }

    /// Calls `each` with node and arc of a way.
    pub(super) fn along(graph: &Graph, red: u32, arcs: &[u8], mut each: impl FnMut(usize, usize)) -> usize {
        arcs.iter().fold(red as usize, |node, &arc| {
            each(node, arc as usize);
            graph.head(node, arc as usize)
        })
    }

    /// What a balanced flow loads.
    pub(super) fn of(graph: &'a Graph, flow: Flow) -> Self {
        let mut through: Vec<u16> = (0..graph.squares()).map(|node| flow.out(node)).collect();
        through[..graph.grid.level()].iter_mut().enumerate().for_each(|(node, all)| *all = flow.through(graph, node));
        let busy = u16::MAX;
        let marks = flow.on.iter().map(|on| mark(on, busy)).collect();
        Self { graph, flow, through, marks, busy }
    }

    /// Adds a way; how much longer the arcs with flow are for it, their lengths by number given.
    pub(super) fn add(&mut self, red: u32, arcs: &[u8], lengths: &[u32; ARCS]) -> u32 {
        let (Self { graph, flow, through, marks, busy }, mut longer) = (self, 0);
        let end = Self::along(graph, red, arcs, |node, arc| {
            let on = &mut flow.on[node][arc];
            longer += if *on == 0 { lengths[arc] } else { 0 };
            *on += 1;
            through[node] += 1;
            marks[node] |= 1 << arc | if *on >= *busy { BUSY } else { 0 };
        });
        through[end] += 1;
        longer
    }

    /// Takes one away; how much shorter the arcs with flow are without it.
    pub(super) fn remove(&mut self, red: u32, arcs: &[u8], lengths: &[u32; ARCS]) -> u32 {
        let (Self { graph, flow, through, marks, busy }, mut shorter) = (self, 0);
        let end = Self::along(graph, red, arcs, |node, arc| {
            let on = &mut flow.on[node];
            on[arc] -= 1;
            through[node] -= 1;
            shorter += if on[arc] == 0 { lengths[arc] } else { 0 };
            marks[node] = mark(on, *busy);
        });
        through[end] -= 1;
        shorter
    }

    /// Whether a way that is loaded meets an arc or a node with more than its limit.
    pub(super) fn is_overloaded(&self, limits: &FlowLimits, red: u32, arcs: &[u8]) -> bool {
        let mut over = false;
        let end = Self::along(self.graph, red, arcs, |node, arc| {
            over |= self.flow.on[node][arc] > limits.of_arc(node, arc) || self.through[node] > limits.of_node(node);
        });
        over || self.through[end] > limits.of_node(end)
    }

    /// Whether a node at the side of this one, which is above the ground, carries something; a column beside another is held by it.
    pub(super) fn has_neighbour(&self, node: usize, [x, y]: [usize; 2]) -> bool {
        let [nx, ny, _] = self.graph.grid.size;
        (x > 0 && self.marks[node - 1] != 0)
            || (x + 1 < nx && self.marks[node + 1] != 0)
            || (y > 0 && self.marks[node - nx] != 0)
            || (y + 1 < ny && self.marks[node + nx] != 0)
    }
}

/// The mark of a node from whose arcs `on` goes.
fn mark(on: &[u16; ARCS], busy: u16) -> u8 {
    let one = |(arc, &units): (usize, &u16)| u8::from(units > 0) << arc | if units >= busy { BUSY } else { 0 };
    on.iter().enumerate().map(one).fold(0, |all, one| all | one)
}
