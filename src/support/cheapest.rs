//! The cheapest way from every node to the ground, of all nodes at once or within a window, and one way down that looks ahead by it.
//!
//! Prices are in eighths of a cost of 1.

use rayon::prelude::*;

use super::flow::FlowLimits;
use super::graph::{ALL_ARCS, ARCS, COSTS, Graph};
use super::ways::{BUSY, Load};

/// The price of an arc that must not be used.
pub(super) const FULL: u32 = 1 << 24;
/// A cost of 1; an arc beside others costs an eighth less.
pub(super) const UNIT: u32 = 8;
/// A price as [`Cheapest::cost`] has it: below it there is room for the number of an arc.
const ARC_BITS: i32 = 8;
/// [`FULL`] there.
const FULL_COST: i32 = FULL as i32 * ARC_BITS;
/// More than any cost, and a bit that none has.
const NOT_THERE: i32 = 1 << 30;

/// The cheapest way from every node to the ground: what it costs, and which arc it begins with.
pub(super) struct Cheapest {
    /// In eighths of a cost of 1, times [`ARC_BITS`].
    cost: Vec<i32>,
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

    /// One pass from the ground up (the graph has no circles). Where an arc of a node is busy, `prices` are those of its arcs, in eighths
    /// ([`UNIT`]), asked with 1 beside a node that carries something and 0 elsewhere. Where none is, an arc that carries something costs
    /// nothing, and any other [`UNIT`] times its own cost, or one less beside a node that carries something. Of equals the first is
    /// taken, and any arc where all cost [`FULL`].
    pub(super) fn find(&mut self, load: &Load<'_>, prices: &(impl Fn(usize, u32) -> [u32; ARCS] + Sync)) {
        let graph = load.graph;
        let ([nx, ny, nz], level) = (graph.grid.size, graph.grid.level());
        // Beyond the rim: nothing is carried there, and no arc leads there.
        let beyond = (vec![0; nx], vec![0; nx]);
        for z in 1..nz {
            let (below, here) = self.cost.split_at_mut(z * level);
            let below = &below[(z - 1) * level..];
            let rows = here[..level].par_chunks_mut(nx).zip(self.arc[z * level..(z + 1) * level].par_chunks_mut(nx));
            rows.with_min_len(16).enumerate().for_each(|(y, (costs, arcs))| {
                let first = z * level + y * nx;
                let [low, high] = self.spans[z * ny + y].map(|x| x as usize);
                if low == high {
                    return;
                }
                // Row `dy` of the three around this one.
                let inside = |dy: usize| (y + dy).checked_sub(1).filter(|row| *row < ny);
                let row = Row {
                    nodes: graph.node_bytes(first..first + nx),
                    marks: [0, 1, 2].map(|dy| match inside(dy) {
                        None => &beyond.0[..],
                        Some(row) => &load.marks[z * level + row * nx..][..nx],
                    }),
                    under: [0, 1, 2].map(|dy| match inside(dy) {
                        None => &beyond.1[..],
                        Some(row) => &below[row * nx..][..nx],
                    }),
                };
                row.plain([low.max(1), high.min(nx - 1)], costs, arcs);
                row.others([low, high], |x| (costs[x], arcs[x]) = row.priced(x, |beside| prices(first + x, beside)));
            });
        }
    }
}

/// A row of cubes along x, with what is around: the rows before, at and behind it along y.
struct Row<'a> {
    /// The nodes' bytes.
    nodes: &'a [u8],
    /// [`Load::marks`] of these rows.
    marks: [&'a [u8]; 3],
    /// What it costs from the cubes below these rows to the ground, as [`Cheapest::cost`] has it.
    under: [&'a [i32]; 3],
}

impl Row<'_> {
    /// What the cubes from `low` to before `high` cost, and the arcs that they begin with, as if none were busy; neither may be at an end
    /// of the row.
    ///
    /// Without a branch and in signed numbers, of which any processor compares several at once: a cost and its arc are one number, of
    /// which the least is taken, and an arc that is not there has a bit above all others.
    fn plain(&self, [low, high]: [usize; 2], costs: &mut [i32], arcs: &mut [u8]) {
        let Some(inner) = high.checked_sub(low).filter(|count| *count > 0) else { return };
        let [before, own, behind] = self.marks;
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
        let (nodes, own) = (&self.nodes[low..][..inner], &own[low..][..inner]);
        let (costs, arcs) = (&mut costs[low..][..inner], &mut arcs[low..][..inner]);
        for x in 0..inner {
            let unit = if (west[x] | east[x] | north[x] | south[x]) == 0 { UNIT } else { UNIT - 1 } as i32 * ARC_BITS;
            let (node, mark) = (i32::from(nodes[x]), i32::from(own[x]));
            let at = |arc: usize| {
                let price = if mark & (1 << arc) == 0 { COSTS[arc] as i32 * unit } else { 0 };
                let absent = if node & (1 << arc) == 0 { NOT_THERE } else { 0 };
                (heads[arc][x] + price + arc as i32) | absent
            };
            let best = at(0).min(at(1).min(at(2))).min(at(3).min(at(4)));
            // Of a square without arcs nobody asks.
            costs[x] = (best & !(ARC_BITS - 1)).min(FULL_COST);
            arcs[x] = (best & (ARC_BITS - 1)) as u8;
        }
    }

    /// Calls `each` for the nodes from `low` to before `high` of which [`Row::plain`] does not tell: busy ones, and those at an end of the
    /// row.
    fn others(&self, [low, high]: [usize; 2], mut each: impl FnMut(usize)) {
        const RUN: usize = 32;
        let last = self.nodes.len() - 1;
        for (run, marks) in self.marks[1][low..high].chunks(RUN).enumerate() {
            let first = low + run * RUN;
            let ends = first == 0 || first + marks.len() > last;
            if !ends && marks.iter().fold(0, |any, mark| any | mark) & BUSY == 0 {
                continue;
            }
            let here = marks.iter().enumerate().map(|(x, mark)| (first + x, mark));
            let other = here.filter(|(x, mark)| *mark & BUSY != 0 || *x == 0 || *x == last).map(|(x, _)| x);
            other.filter(|x| self.nodes[*x] & ALL_ARCS != 0).for_each(&mut each);
        }
    }

    /// What a node costs and the arc it begins with, at the prices that are told for it.
    #[inline]
    fn priced(&self, x: usize, prices: impl Fn(u32) -> [u32; ARCS]) -> (i32, u8) {
        let [before, own, behind] = self.marks;
        let at = |row: &[u8], x: usize| row.get(x).copied().unwrap_or(0);
        let beside = at(own, x.wrapping_sub(1)) | at(own, x + 1) | before[x] | behind[x];
        let prices = prices(u32::from(beside != 0));
        let [above, middle, below] = self.under;
        let under = |row: &[i32], x: usize| row.get(x).copied().unwrap_or(0);
        let heads = [middle[x], under(middle, x.wrapping_sub(1)), under(middle, x + 1), above[x], below[x]];
        cheapest(self.nodes[x] & ALL_ARCS, heads, &prices)
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
        for z in 1..window.high[2] {
            for y in window.low[1]..window.high[1] {
                for x in window.low[0]..window.high[0] {
                    let node = graph.grid.index([x, y, z]);
                    let there = graph.arc_bits(node);
                    if there == 0 {
                        continue;
                    }
                    (self.cost[node], self.arc[node]) = match there & !window.leading_out([x, y]) {
                        0 => (FULL_COST, 0),
                        inside => {
                            // Where a step would leave the grid there is no such arc.
                            let head = |arc: usize| {
                                if inside & (1 << arc) == 0 { 0 } else { self.cost[graph.head(node, arc)] }
                            };
                            cheapest(inside, std::array::from_fn(head), &prices(node, [x, y]))
                        }
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

/// The cheapest arc of a node, of those that are `there`, and what it costs with what lies below its head.
#[inline]
fn cheapest(there: u8, heads: [i32; ARCS], prices: &[u32; ARCS]) -> (i32, u8) {
    let at = |arc: usize| {
        let absent = if there & (1 << arc) == 0 { NOT_THERE } else { 0 };
        ((heads[arc] + prices[arc] as i32 * ARC_BITS).min(FULL_COST) + arc as i32) | absent
    };
    let best = (1..ARCS).fold(at(0), |best, arc| best.min(at(arc)));
    (best & !(ARC_BITS - 1), (best & (ARC_BITS - 1)) as u8)
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
        limits: &FlowLimits,
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
                    .min_by_key(|&(arc, head)| price[arc] as i32 * ARC_BITS + cheapest.cost[head]);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::{SplitMix64, Vec3};
    use crate::support::Grid;

    /// Up to three ways from each red square, each wherever it happens to go.
    fn ways(graph: &Graph, numbers: &mut SplitMix64) -> Vec<(u32, Vec<u8>)> {
        let way = |red: u32, numbers: &mut SplitMix64| {
            let (mut node, mut arcs) = (red as usize, Vec::new());
            while !graph.is_ground(node) {
                let open: Vec<usize> = graph.arcs(node).collect();
                let arc = open[(numbers.unit() * open.len() as f64) as usize];
                arcs.push(arc as u8);
                node = graph.head(node, arc);
            }
            (red, arcs)
        };
        let thrice = graph.red.iter().flat_map(|red| [*red; 3]);
        thrice.filter(|_| numbers.unit() < 0.6).collect::<Vec<_>>().into_iter().map(|red| way(red, numbers)).collect()
    }

    #[test]
    fn rows_at_once_are_the_same_as_node_by_node() {
        let mut numbers = SplitMix64::seeded(11);
        let (mut nodes, mut busy_nodes) = (0, 0);
        for round in 0..200 {
            let size = [(); 3].map(|()| 1 + (numbers.unit() * if round % 3 == 0 { 40.0 } else { 7.0 }) as usize);
            let size = [size[0], size[1], 2 + size[2]];
            let grid = Grid { origin: Vec3::zeros(), step_mm: 1.0, size };
            let marks: Vec<(bool, bool)> = (0..grid.len()).map(|_| numbers.unit() < 0.15).map(|m| (m, m)).collect();
            let graph = Graph::of_marks(grid, &marks);
            let busy = 1 + (numbers.unit() * 4.0) as u16;
            let mut load = Load::none(&graph, busy);
            let laid = ways(&graph, &mut numbers);
            laid.iter().for_each(|(red, arcs)| _ = load.add(*red, arcs, &COSTS));
            for (red, arcs) in laid.iter().filter(|_| numbers.unit() < 0.3) {
                load.remove(*red, arcs, &COSTS);
            }
            // As the pass has them where nothing is busy; dearer with every unit, or full, where something is.
            let price = |node: usize, beside: u32| {
                std::array::from_fn(|arc| match load.flow.on[node][arc] {
                    0 => COSTS[arc] * (UNIT - beside),
                    n if n < busy => 0,
                    n if round % 2 == 0 => u32::from(n) * COSTS[arc],
                    _ => FULL,
                })
            };
            let (mut rows, mut single) = (Cheapest::none(&graph), Cheapest::none(&graph));
            rows.find(&load, &price);
            let beside = |node, at| u32::from(load.has_neighbour(node, at));
            let window = Window { low: [0, 0], high: size };
            single.find_within(&graph, &window, &|node, at| price(node, beside(node, at)));
            let above = graph.grid.level()..graph.squares();
            for node in above.filter(|&node| graph.arc_bits(node) != 0) {
                let told = |pass: &Cheapest| (pass.cost[node], (pass.cost[node] < FULL_COST).then_some(pass.arc[node]));
                assert_eq!(told(&rows), told(&single), "round {round}, node {:?} of {size:?}", graph.grid.cube(node));
                nodes += 1;
                busy_nodes += usize::from(load.marks[node] & BUSY != 0);
            }
        }
        assert!(nodes > 100_000 && busy_nodes > 1000, "{nodes} {busy_nodes}");
    }
}
