//! `auto`: least material within the limits.
//!
//! What supports cost is not how many units pass an arc but whether any does: material is the number of arcs with flow. The
//! cheapest flow ([`min_cost`]) knows nothing of that; its cost is the bound that stands beside the result. The search begins with
//! that flow, with that of [`shortest_paths`], or, where there are few red squares, with one after the other; both keep the
//! limits. Then, over and over, the units through a place
//! and the places beside it are taken up and laid anew, one after the other, each along arcs that are used already as far as they
//! have room. An arc with few units is a little dearer than one with many, so that thin columns empty into full ones. What takes
//! more material than before goes back (at first a little more is let pass, so that the search is not caught at once). No unit
//! is ever laid on a full arc or through a full node.

use super::cheapest::{Cheapest, Descent, FULL, Window};
use super::flow::{Flow, FlowLimits};
use super::graph::{ARCS, Graph};
use super::min_cost::min_cost;
use super::shortest_paths::{PathDrawing, shortest_paths};
use super::ways::Load;
use crate::geom::SplitMix64;

/// How long to look.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Effort {
    /// Times that each red square's unit is laid anew, about; `None`: the more the fewer there are.
    pub turns: Option<f64>,
    /// Seed of the choice.
    pub seed: u64,
}

impl Default for Effort {
    fn default() -> Self {
        Self { turns: None, seed: 1 }
    }
}

/// Units that are laid anew in all where nothing else is asked for, and how often each at least and at most.
const USUAL: f64 = 100_000.0;
const USUAL_TURNS: [f64; 2] = [5.0, 100.0];
/// Up to so many red squares both beginnings are tried.
const FEW: usize = 2000;

/// A flow of little material, the limits that it needed, and the cost of the cheapest flow within them. `at` hears how many of how
/// many turns are done.
pub fn least_material(
    graph: &Graph,
    limits: FlowLimits,
    effort: &Effort,
    at: &mut dyn FnMut(usize, usize),
) -> (Flow, FlowLimits, u64) {
    let (cheapest, limits) = min_cost(graph, limits, &mut |_| {});
    let bound = cheapest.tally(graph, limits.arc, limits.node).cost;
    if graph.red.is_empty() {
        return (cheapest, limits, bound);
    }
    let drawing = PathDrawing { seed: effort.seed, ..PathDrawing::default() };
    let (shared, _) = shortest_paths(graph, limits.clone(), &drawing, &mut |_| {});
    let mut begins = vec![shared, cheapest];
    begins.sort_by_key(|flow| material(graph, flow));
    begins.truncate(if graph.red.len() <= FEW { 2 } else { 1 });
    let count = graph.red.len() as f64;
    let each = effort.turns.unwrap_or((USUAL / count).clamp(USUAL_TURNS[0], USUAL_TURNS[1]));
    let turns = (each * count / GROUP as f64).ceil() as usize;
    let (all, mut done) = (turns * begins.len(), 0);
    let searched = begins.into_iter().map(|begin| {
        let mut search = Search::new(graph, &limits, begin, effort.seed);
        for turn in 0..turns {
            search.warm = (WARM * (1.0 - turn as f64 / turns as f64)) as u32;
            search.turn();
            done += 1;
            at(done, all);
        }
        search.load.flow
    });
    let found = searched.min_by_key(|flow| material(graph, flow));
    (found.expect("there is a beginning"), limits, bound)
}

/// What a flow's arcs are made of: first how many they are, then how many of them lean.
fn material(graph: &Graph, flow: &Flow) -> (usize, usize) {
    let tally = flow.tally(graph, u16::MAX, None);
    (tally.used_arcs(), tally.oblique)
}

/// What a new arc costs. A layer of it is the same cross, whether it leans or not, so that a straight arc and an oblique one are of the
/// same volume; and where sheets that lean meet others they share lines.
const NEW: [u32; ARCS] = [64; ARCS];
/// What a new arc costs less beside others.
const BESIDE: u32 = 2;
/// The price of an arc with flow, for each unit that it could still take.
const ROOM: u32 = 2;
/// Units that are laid anew together, at most.
const GROUP: usize = 4;
/// Squares aside within which units are taken up.
const REACH: usize = 2;
/// Squares aside of what was taken up within which it is laid.
const MARGIN: usize = 4;
/// What a turn may add in the beginning.
const WARM: f64 = 64.0;

/// A unit's way: its red square and its arcs from there.
type Way = (u32, Vec<u8>);

struct Search<'a> {
    limits: &'a FlowLimits,
    load: Load<'a>,
    cheapest: Cheapest,
    descent: Descent,
    numbers: SplitMix64,
    warm: u32,
}

impl<'a> Search<'a> {
    fn new(graph: &'a Graph, limits: &'a FlowLimits, flow: Flow, seed: u64) -> Self {
        let (cheapest, descent) = (Cheapest::none(graph), Descent::of(graph));
        let (load, numbers) = (Load::of(graph, flow), SplitMix64::seeded(seed));
        Self { limits, load, cheapest, descent, numbers, warm: 0 }
    }

    /// Lays the units through one place anew.
    fn turn(&mut self) {
        let (mut before, mut after) = (0, 0);
        let mut old: Vec<Way> = Vec::new();
        let place = self.place();
        for node in self.around(place) {
            while self.load.through[node] > 0 && old.len() < GROUP {
                let way = self.way_through(node);
                before += self.load.remove(way.0, &way.1, &NEW);
                old.push(way);
            }
        }
        let (load, limits) = (&self.load, self.limits);
        if old.is_empty() {
            return;
        }
        let window = Window::around(load.graph, &old, MARGIN);
        self.cheapest.find_within(load.graph, &window, &|node, at| prices(load, limits, node, at));
        let order = self.shuffled(old.len());
        let mut new: Vec<Way> = Vec::new();
        for way in order {
            let (load, limits, red) = (&self.load, self.limits, old[way].0);
            let found = self.descent.find(
                load,
                limits,
                &self.cheapest,
                &|node, at| inside(load, limits, &window, node, at),
                red,
            );
            let Some(arcs) = found else { break };
            after += self.load.add(red, &arcs, &NEW);
            new.push((red, arcs));
        }
        if new.len() < old.len() || after > before + self.warm {
            new.iter().for_each(|(red, arcs)| _ = self.load.remove(*red, arcs, &NEW));
            old.iter().for_each(|(red, arcs)| _ = self.load.add(*red, arcs, &NEW));
        }
    }

    /// A place with flow: somewhere on the way of a red square.
    fn place(&mut self) -> usize {
        let graph = self.load.graph;
        let red = graph.red[self.numbers.below(graph.red.len())] as usize;
        let depth = self.numbers.below(red / graph.grid.level() + 1);
        (0..depth).fold(red, |node, _| graph.head(node, self.down(node)))
    }

    /// The arc with flow that is followed down from a node.
    fn down(&self, node: usize) -> usize {
        let on = &self.load.flow.on[node];
        (0..ARCS).find(|&arc| on[arc] > 0).expect("what comes to a node leaves it")
    }

    /// A unit's way through a node: where nothing comes from above, the node is red.
    fn way_through(&self, node: usize) -> Way {
        let graph = self.load.graph;
        let (mut top, mut arcs) = (node, Vec::new());
        loop {
            let used = (0..ARCS).filter_map(|arc| graph.tail(top, arc).map(|tail| (arc, tail)));
            let Some((arc, tail)) = used.into_iter().find(|&(arc, tail)| self.load.flow.on[tail][arc] > 0) else {
                break;
            };
            arcs.push(arc as u8);
            top = tail;
        }
        arcs.reverse();
        let mut at = node;
        while !graph.is_ground(at) {
            let arc = self.down(at);
            arcs.push(arc as u8);
            at = graph.head(at, arc);
        }
        (top as u32, arcs)
    }

    /// A place and those beside it on its level, nearest first.
    fn around(&self, place: usize) -> Vec<usize> {
        let grid = &self.load.graph.grid;
        let [x, y, z] = grid.cube(place);
        let range = |at: usize, size: usize| at.saturating_sub(REACH)..(at + REACH + 1).min(size);
        let all = range(y, grid.size[1]).flat_map(|v| range(x, grid.size[0]).map(move |u| [u, v, z]));
        let mut around: Vec<[usize; 3]> = all.collect();
        around.sort_by_key(|[u, v, _]| u.abs_diff(x) + v.abs_diff(y));
        around.into_iter().map(|cube| grid.index(cube)).collect()
    }

    fn shuffled(&mut self, count: usize) -> Vec<usize> {
        let mut order: Vec<usize> = (0..count).collect();
        for i in (1..count).rev() {
            order.swap(i, self.numbers.below(i + 1));
        }
        order
    }
}

fn prices(load: &Load<'_>, limits: &FlowLimits, node: usize, at: [usize; 2]) -> [u32; ARCS] {
    let less = BESIDE * u32::from(load.has_neighbour(node, at));
    if load.through[node] == 0 {
        return NEW.map(|price| price - less);
    }
    let on = &load.flow.on[node];
    std::array::from_fn(|arc| match (on[arc], limits.of_arc(node, arc)) {
        (0, _) => NEW[arc] - less,
        (n, most) if n < most => ROOM * u32::from(most - n),
        _ => FULL,
    })
}

/// The same within a window.
fn inside(load: &Load<'_>, limits: &FlowLimits, window: &Window, node: usize, at: [usize; 2]) -> [u32; ARCS] {
    let (mut prices, out) = (prices(load, limits, node, at), window.leading_out(at));
    (0..ARCS).filter(|arc| out & (1 << arc) != 0).for_each(|arc| prices[arc] = FULL);
    prices
}
