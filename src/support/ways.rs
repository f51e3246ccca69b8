//! A flow as ways: one from each red square to the ground, with what they load on arcs and nodes.
//!
//! A way from level z is z arcs, so that all ways lie in one list, each at its own place.

use rayon::prelude::*;

use super::flow::{Flow, Limits};
use super::graph::{ALL_ARCS, ARCS, COSTS, Graph};

/// The price of an arc that must not be used.
pub(super) const FULL: u32 = 1 << 24;
/// A cost of 1; an arc beside others costs an eighth less.
pub(super) const UNIT: u32 = 8;

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
}

impl<'a> Load<'a> {
    pub(super) fn none(graph: &'a Graph) -> Self {
        Self { graph, flow: Flow::none(graph), through: vec![0; graph.squares()] }
    }

    /// Calls `each` with node and arc of a way.
    fn along(graph: &Graph, red: u32, arcs: &[u8], mut each: impl FnMut(usize, usize)) -> usize {
        arcs.iter().fold(red as usize, |node, &arc| {
            each(node, arc as usize);
            graph.head(node, arc as usize)
        })
    }

    /// What a balanced flow loads.
    pub(super) fn of(graph: &'a Graph, flow: Flow) -> Self {
        let mut through: Vec<u16> = (0..graph.squares()).map(|node| flow.out(node)).collect();
        through[..graph.grid.level()].iter_mut().enumerate().for_each(|(node, all)| *all = flow.through(graph, node));
        Self { graph, flow, through }
    }

    /// Adds a way; how much longer the arcs with flow are for it, their lengths by number given.
    pub(super) fn add(&mut self, red: u32, arcs: &[u8], lengths: &[u32; ARCS]) -> u32 {
        let (Self { graph, flow, through }, mut longer) = (self, 0);
        let end = Self::along(graph, red, arcs, |node, arc| {
            longer += if flow.on[node][arc] == 0 { lengths[arc] } else { 0 };
            flow.on[node][arc] += 1;
            through[node] += 1;
        });
        through[end] += 1;
        longer
    }

    /// Takes one away; how much shorter the arcs with flow are without it.
    pub(super) fn remove(&mut self, red: u32, arcs: &[u8], lengths: &[u32; ARCS]) -> u32 {
        let (Self { graph, flow, through }, mut shorter) = (self, 0);
        let end = Self::along(graph, red, arcs, |node, arc| {
            flow.on[node][arc] -= 1;
            through[node] -= 1;
            shorter += if flow.on[node][arc] == 0 { lengths[arc] } else { 0 };
        });
        through[end] -= 1;
        shorter
    }

    /// Whether a way that is loaded meets an arc or a node with more than its limit.
    pub(super) fn is_overloaded(&self, limits: &Limits, red: u32, arcs: &[u8]) -> bool {
        let mut over = false;
        let end = Self::along(self.graph, red, arcs, |node, arc| {
            over |= self.flow.on[node][arc] > limits.of_arc(node, arc) || self.through[node] > limits.of_node(node);
        });
        over || self.through[end] > limits.of_node(end)
    }

    /// Whether a node at the side of this one carries something; a column beside another is held by it.
    pub(super) fn has_neighbour(&self, node: usize, [x, y]: [usize; 2]) -> bool {
        let [nx, ny, _] = self.graph.grid.size;
        (x > 0 && self.through[node - 1] > 0)
            || (x + 1 < nx && self.through[node + 1] > 0)
            || (y > 0 && self.through[node - nx] > 0)
            || (y + 1 < ny && self.through[node + nx] > 0)
    }
}

/// The cheapest way from every node to the ground: what it costs, and which arc it begins with.
pub(super) struct Cheapest {
    pub(super) cost: Vec<u32>,
    pub(super) arc: Vec<u8>,
    /// By row along x, from the ground up: the first cube from which an arc leads down, and the one behind the last.
    spans: Vec<[u32; 2]>,
}

impl Cheapest {
    pub(super) fn none(graph: &Graph) -> Self {
        let squares = graph.squares();
        let span = |row: &[u8]| {
            let leads = |node: &u8| node & ALL_ARCS != 0;
            let first = row.iter().position(leads).unwrap_or(0);
            [first as u32, row.iter().rposition(leads).map_or(first, |last| last + 1) as u32]
        };
        let spans = graph.node_bytes(0..squares).par_chunks(graph.grid.size[0]).map(span).collect();
        Self { cost: vec![0; squares], arc: vec![0; squares], spans }
    }

    /// One pass from the ground up (the graph has no circles). Where a way goes through a node, `prices` are those of its arcs; where
    /// none does, each costs [`UNIT`] times its own cost, or one less beside a node that carries something. Of equals the first is
    /// taken.
    pub(super) fn find(&mut self, load: &Load<'_>, prices: &(impl Fn(usize, [usize; 2]) -> [u32; ARCS] + Sync)) {
        let graph = load.graph;
        let ([nx, ny, nz], level) = (graph.grid.size, graph.grid.level());
        // Beyond the rim: nothing is carried there, and no arc leads there.
        let beyond = (vec![0; nx], vec![0; nx]);
        for z in 1..nz {
            let (below, here) = self.cost.split_at_mut(z * level);
            let below = &*below;
            let rows = here[..level].par_chunks_mut(nx).zip(self.arc[z * level..(z + 1) * level].par_chunks_mut(nx));
            rows.with_min_len(16).enumerate().for_each(|(y, (costs, arcs))| {
                let first = z * level + y * nx;
                let [low, high] = self.spans[z * ny + y].map(|x| x as usize);
                if low == high {
                    return;
                }
                let through = |dy: usize| match y + dy {
                    0 => &beyond.0[..],
                    row if row > ny => &beyond.0[..],
                    row => &load.through[z * level + (row - 1) * nx..][..nx],
                };
                let under = |dy: usize| match y + dy {
                    0 => &beyond.1[..],
                    row if row > ny => &beyond.1[..],
                    row => &below[(z - 1) * level + (row - 1) * nx..][..nx],
                };
                let row = Row {
                    nodes: graph.node_bytes(first..first + nx),
                    through: [through(0), through(1), through(2)],
                    under: [under(0), under(1), under(2)],
                };
                row.unloaded([low.max(1), high.min(nx.saturating_sub(1))], costs, arcs);
                for x in low..high {
                    if row.through[1][x] == 0 && x > 0 && x + 1 < nx {
                        continue;
                    }
                    let there = graph.arc_bits(first + x);
                    if there != 0 {
                        let price = if row.through[1][x] > 0 {
                            prices(first + x, [x, y])
                        } else {
                            let beside = u32::from(load.has_neighbour(first + x, [x, y]));
                            COSTS.map(|cost| cost * (UNIT - beside))
                        };
                        (costs[x], arcs[x]) = cheapest([nx, level], first + x, there, below, &price);
                    }
                }
            });
        }
    }
}

/// A row of cubes along x, with what is around: the rows before, at and behind it along y.
struct Row<'a> {
    /// The nodes' bytes.
    nodes: &'a [u8],
    /// Ways through the cubes of these rows.
    through: [&'a [u16]; 3],
    /// What it costs from the cubes below these rows to the ground.
    under: [&'a [u32]; 3],
}

impl Row<'_> {
    /// What the cubes from `low` to before `high` cost, and the arcs that they begin with, as if no way went through any of them; neither
    /// may be at an end of the row.
    ///
    /// Without a branch, so that several are worked on at once: a cost and its arc are one number, of which the least is taken.
    fn unloaded(&self, [low, high]: [usize; 2], costs: &mut [u32], arcs: &mut [u8]) {
        let Some(inner) = high.checked_sub(low).filter(|count| *count > 0) else { return };
        let [before, own, behind] = self.through;
        let (west, east, north, south) =
            (&own[low - 1..][..inner], &own[low + 1..][..inner], &before[low..][..inner], &behind[low..][..inner]);
        let [above, middle, below] = self.under;
        let heads = [
            &middle[low..][..inner],
            &middle[low - 1..][..inner],
            &middle[low + 1..][..inner],
            &above[low..][..inner],
            &below[low..][..inner],
        ];
        let (nodes, costs, arcs) = (&self.nodes[low..][..inner], &mut costs[low..][..inner], &mut arcs[low..][..inner]);
        for x in 0..inner {
            let unit = UNIT - u32::from((west[x] | east[x] | north[x] | south[x]) != 0);
            let node = nodes[x];
            let mut best = u32::MAX;
            for arc in 0..ARCS {
                let cost = (COSTS[arc] * unit + heads[arc][x]).min(FULL);
                let there = node & (1 << arc) != 0;
                best = best.min(if there { cost << 3 | arc as u32 } else { u32::MAX });
            }
            costs[x] = if best == u32::MAX { costs[x] } else { best >> 3 };
            arcs[x] = if best == u32::MAX { arcs[x] } else { (best & 7) as u8 };
        }
    }
}

impl Cheapest {
    /// The same for the cubes of `window` alone (see there), as if there were no others.
    pub(super) fn find_within(
        &mut self,
        graph: &Graph,
        window: &Window,
        prices: &impl Fn(usize, [usize; 2]) -> [u32; ARCS],
    ) {
        let shape = [graph.grid.size[0], graph.grid.level()];
        for z in 1..window.high[2] {
            for y in window.low[1]..window.high[1] {
                for x in window.low[0]..window.high[0] {
                    let node = graph.grid.index([x, y, z]);
                    let there = graph.arc_bits(node);
                    if there == 0 {
                        continue;
                    }
                    (self.cost[node], self.arc[node]) = match there & !window.leading_out([x, y]) {
                        0 => (FULL, 0),
                        inside => cheapest(shape, node, inside, &self.cost, &prices(node, [x, y])),
                    };
                }
            }
        }
    }
}

/// Columns of cubes from the ground up: the first along x and y, and those behind the last along x, y and z.
#[derive(Clone, Copy, Debug)]
pub(super) struct Window {
    pub(super) low: [usize; 2],
    pub(super) high: [usize; 3],
}

impl Window {
    /// Those around ways, `margin` more on each side.
    pub(super) fn around(graph: &Graph, ways: &[(u32, Vec<u8>)], margin: usize) -> Self {
        let (size, level) = (graph.grid.size, graph.grid.level());
        let (mut low, mut high) = ([usize::MAX; 2], [0; 3]);
        for (red, arcs) in ways {
            high[2] = high[2].max(*red as usize / level + 1);
            let mut see = |node: usize, _| {
                let [x, y, _] = graph.grid.cube(node);
                low = [low[0].min(x), low[1].min(y)];
                high = [high[0].max(x + 1), high[1].max(y + 1), high[2]];
            };
            let end = Load::along(graph, *red, arcs, &mut see);
            see(end, 0);
        }
        let low = low.map(|first| first.saturating_sub(margin));
        Self { low, high: [(high[0] + margin).min(size[0]), (high[1] + margin).min(size[1]), high[2]] }
    }

    /// Bits of the arcs that lead from a square out of the window.
    pub(super) fn leading_out(&self, [x, y]: [usize; 2]) -> u8 {
        u8::from(x == self.low[0]) << 1
            | u8::from(x + 1 == self.high[0]) << 2
            | u8::from(y == self.low[1]) << 3
            | u8::from(y + 1 == self.high[1]) << 4
    }
}

/// The cheapest arc of a node and what it costs with what lies below its head.
#[inline]
fn cheapest([nx, level]: [usize; 2], node: usize, there: u8, below: &[u32], prices: &[u32; ARCS]) -> (u32, u8) {
    let under = node - level;
    let mut best = (u32::MAX, 0);
    let mut consider = |arc: u8, head: usize| {
        if there & (1 << arc) != 0 {
            let cost = (prices[arc as usize] + below[head]).min(FULL);
            if cost < best.0 {
                best = (cost, arc);
            }
        }
    };
    // As `Graph::head` has them; where a step would leave the grid there is no such arc, and the head is never looked at.
    consider(0, under);
    consider(1, under.wrapping_sub(1));
    consider(2, under + 1);
    consider(3, under.wrapping_sub(nx));
    consider(4, under + nx);
    best
}

/// Finds one way at a time by looking ahead with [`Cheapest`], whose costs may be those of an earlier state, and around by
/// what is loaded now.
pub(super) struct Descent {
    /// Nodes from which no way was found.
    dead: Vec<bool>,
    buried: Vec<u32>,
}

impl Descent {
    pub(super) fn of(graph: &Graph) -> Self {
        Self { dead: vec![false; graph.squares()], buried: Vec::new() }
    }

    /// The arcs of a way from `red` on which nothing is full, if there is one: at each node the arc that now costs least with what
    /// lies below it, and back where that ends.
    pub(super) fn find(
        &mut self,
        load: &Load<'_>,
        limits: &Limits,
        cheapest: &Cheapest,
        prices: &impl Fn(usize, [usize; 2]) -> [u32; ARCS],
        red: u32,
    ) -> Option<Vec<u8>> {
        let graph = load.graph;
        let has_room = |node: usize| limits.node.is_none() || load.through[node] < limits.of_node(node);
        let (mut node, mut way) = (red as usize, Vec::with_capacity(red as usize / graph.grid.level()));
        let mut trail: Vec<u32> = Vec::with_capacity(way.capacity());
        let found = has_room(node)
            && loop {
                if graph.is_ground(node) {
                    break true;
                }
                let [x, y, _] = graph.grid.cube(node);
                let price = prices(node, [x, y]);
                let open = graph.arcs(node).filter(|&arc| price[arc] < FULL);
                let open = open.map(|arc| (arc, graph.head(node, arc)));
                let best = open
                    .filter(|&(_, head)| !self.dead[head] && has_room(head))
                    .min_by_key(|&(arc, head)| price[arc] + cheapest.cost[head]);
                if let Some((arc, head)) = best {
                    way.push(arc as u8);
                    trail.push(node as u32);
                    node = head;
                } else {
                    self.dead[node] = true;
                    self.buried.push(node as u32);
                    let Some(before) = trail.pop() else { break false };
                    way.pop();
                    node = before as usize;
                }
            };
        self.buried.drain(..).for_each(|node| self.dead[node as usize] = false);
        found.then_some(way)
    }
}
