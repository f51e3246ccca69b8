//! Supports as lines of filament, layer by layer: the sheets of `x` one line wide, kept away from what they hold.
//!
//! Slot frame, mm. Along an arc with flow stands a cross of two sheets over the diagonals of its cell; above a red square it goes on up
//! to the surface. In each layer a sheet is one line. Of it stays what keeps its distance from the part: sideways in its own layer, and
//! from below in the layers above it, so that `gap_mm` of air is left under what is held; and only where the same sheet stands
//! in the layer below. So nothing of a support begins in the air: an oblique arc moves by no more than the layer's height.
//!
//! Cubes that the surface touches have no columns, so beside a wall a strip as wide as a cube would stay bare. Below a red square
//! sheets lean out into such cubes, by as much as a layer is high in each.
//!
//! A cube on the ground that the surface touches has no square below it that could want support. What hangs there stands on sheets of
//! its own, under the part's shadow.
//!
//! What has no way to the ground may stand on the part: a straight column down to the surface below, where its sheets begin, layer by
//! layer, on what the part has there or up to three layers deeper. On a slope they grow from a strip, and are laid once they are long enough.
//!
//! A roof ([`Roof`]) lies in the last layers below the gap, in the place of sheets.
//!
//! What is free is found along a line by [`march`](crate::section::march), which passes over nothing.

use std::collections::HashMap;

use rayon::prelude::*;

use super::clear::{Clearance, Cuts, Keeps};
use super::flow::Flow;
use super::graph::{ARCS, Graph};
use super::laying::{Clear, Laying};
use super::roof::{Roof, Under};
use super::spans::{Line, SHORTEST_ON_PART_WIDTHS, SHORTEST_WIDTHS, Spans, joined, shared, where_above};
use crate::geom::Vec3;
use crate::section::{Section, Segments};

/// One layer of supports.
#[derive(Clone, Debug, PartialEq)]
pub struct SupportLayer {
    /// From where to where it goes, mm.
    pub span_mm: [f64; 2],
    /// The middles of its lines, mm.
    pub lines: Vec<Line>,
}

/// Above its red square a sheet ends at the latest after so many steps: the surface is within the cube above.
const ABOVE: f64 = 2.0;

/// Lines whose middles are nearer than so many widths would lie on each other.
const SIDE_BY_SIDE: f64 = 0.8;

/// Below a column that stands on the part its surface is at most so many steps away.
const BELOW: f64 = 2.0;
/// A line may lie so far beside what carries it, in widths.
const ASIDE: f64 = 0.8;
/// Lines of a roof are looked for as far, mm.
const ROOF_MM: f64 = 2.0;
/// What a column that stands on the part has below its lowest square.
const ON_PART: usize = ARCS + 1;

/// A sheet that ends so near the corner of its cell ends there.
const AT_CORNER_MM: f64 = 1e-6;
/// A sheet that leans out ends at the latest after so many times its own half.
const FARTHEST: f64 = 3.0;
/// What stands in a cube on the ground that the surface touches.
const LOW: usize = ARCS + 2;

/// What stands along one arc, above a red square (`ARCS`), between a column and the part (`ON_PART`), or in
/// a cube on the ground (`LOW`): the node above (of the last the cube's own), and the arc.
type Place = (usize, usize);

/// The lines of `flow`'s supports in the layers of `cuts`, clear of what these have.
pub fn lines(graph: &Graph, flow: &Flow, cuts: &Cuts, laying: &Laying) -> Vec<SupportLayer> {
    cuts.all();
    let (layers, how) = (cuts.spans(), &cuts.how);
    let columns = if laying.on_part { columns(graph) } else { Vec::new() };
    let mut by_level = by_level(graph, flow);
    for &node in columns.iter().flat_map(|column| &column[..column.len() - 1]) {
        by_level[node / graph.grid.level()].push((node, 0));
    }
    let tops: Vec<usize> =
        columns.iter().map(|column| column[0]).chain(graph.red.iter().map(|&red| red as usize)).collect();
    // Beside what they hold sheets would rise as walls around the part.
    let held = |&node: &usize| {
        let low = graph.grid.middle(node).z;
        let within = |span: &[f64; 2]| span[1] > low && span[0] < low + ABOVE * graph.grid.step_mm;
        let near = (0..layers.len()).filter(|&k| within(&layers[k]));
        let near: Vec<&[Section]> = near.map(|k| cuts.layer(k)).collect();
        (node, shadow(graph, node, &near, FARTHEST, how.line_mm))
    };
    let tops: HashMap<usize, [Spans; 2]> = tops.par_iter().map(held).collect();
    let feet = columns.iter().map(|column| column[column.len() - 1]).collect();
    let low = (0..graph.grid.level()).filter(|&cube| graph.is_black(cube) && graph.wants(cube));
    let shadow_mm = graph.grid.origin.z + BELOW * graph.grid.step_mm;
    let near = layers.iter().take_while(|span| span[1] <= shadow_mm).count();
    let near: Vec<&[Section]> = cuts.layers(0, near);
    let low: Vec<(usize, [Spans; 2])> = low.map(|cube| (cube, shadow(graph, cube, &near, 1.0, 0.0))).collect();
    let mut rising = Rising { graph, how, laying, by_level, tops, feet, low, there: HashMap::new() };
    let mut all = Vec::with_capacity(layers.len());
    for (k, span_mm) in layers.iter().enumerate() {
        let mut air = Air { keeps: cuts.around(k), under: cuts.under(k), how, roof: Segments::new(Vec::new()) };
        if let (Some(roof), Some(below)) = (&laying.roof, all.last()) {
            let held = cuts.layers(k + 1 + cuts.over(k), roof.layers);
            air.roof = Segments::new(rising.roof(roof, *span_mm, below, &air, &held));
        }
        let mut lines = rising.layer(*span_mm, &air);
        lines.extend(air.roof.all());
        // A mesh has no first layer that would be thick enough for them.
        if k == 0 && how.clear != Clear::Around {
            lines.extend(rising.feet(&air));
        }
        all.push(SupportLayer { span_mm: *span_mm, lines });
    }
    while all.last().is_some_and(|layer| layer.lines.is_empty()) {
        all.pop();
    }
    all
}

/// The arcs with flow, by the level of their node above.
fn by_level(graph: &Graph, flow: &Flow) -> Vec<Vec<Place>> {
    let mut all = vec![Vec::new(); graph.grid.size[2] + 1];
    for node in (0..graph.squares()).filter(|&node| flow.out(node) > 0) {
        let arcs = graph.arcs(node).filter(|&arc| flow.on[node][arc] > 0);
        all[node / graph.grid.level()].extend(arcs.map(|arc| (node, arc)));
    }
    all
}

/// The squares of each straight column from a red square that has no way to the ground down to the part below, from the top.
fn columns(graph: &Graph) -> Vec<Vec<usize>> {
    let level = graph.grid.level();
    let column = |&red: &u32| {
        let next = |node: &usize| node.checked_sub(level).filter(|&under| under >= level && !graph.is_black(under));
        std::iter::successors(Some(red as usize), next).collect()
    };
    graph.unreachable.iter().map(column).collect()
}

/// What of the sheets in a cube, so many times as long, lies under what is cut in these layers or no more than `beside` mm beside it.
fn shadow(graph: &Graph, cube: usize, cuts: &[&[Section]], times: f64, beside: f64) -> [Spans; 2] {
    let (middle, half) = (graph.grid.middle(cube), times * graph.grid.step_mm * std::f64::consts::FRAC_1_SQRT_2);
    let nearest =
        |p: [f64; 2]| cuts.iter().copied().flatten().map(|s| s.signed_distance(p)).fold(f64::INFINITY, f64::min);
    let covered = |p: [f64; 2]| beside - nearest(p);
    std::array::from_fn(|diagonal| {
        let ends = [-half, half].map(|t| along([middle.x, middle.y], diagonal, t));
        where_above(ends, covered).into_iter().map(|[a, b]| [a - half, b - half]).collect()
    })
}

/// What is free around one layer.
pub(super) struct Air<'a> {
    /// What a line keeps from.
    pub(super) keeps: Keeps<'a>,
    /// What the part has in the layers just below: a line sags onto the deepest of them.
    pub(super) under: Vec<&'a [Section]>,
    pub(super) how: &'a Clearance,
    /// The roof of this layer, whose lines take the place of sheets.
    pub(super) roof: Segments,
}

impl Air<'_> {
    /// How far `p` is from where no line's middle may be, mm; below 0 where it may not be. A step of so much crosses no border.
    pub(super) fn room(&self, p: [f64; 2]) -> f64 {
        let away = |(sections, from): &(&[Section], f64)| {
            let nearest = sections.iter().map(|s| s.signed_distance(p)).fold(f64::INFINITY, f64::min);
            nearest - from
        };
        let roof = self.roof.nearest(p, ROOF_MM, None).map_or(ROOF_MM, |nearest| nearest.distance);
        self.keeps.iter().map(away).fold(roof - self.how.line_mm, f64::min)
    }

    /// How far `p` is from where the part no longer carries a line, mm; below 0 there.
    pub(super) fn carried(&self, p: [f64; 2]) -> f64 {
        let nearest = self.under.iter().copied().flatten().map(|s| s.signed_distance(p)).fold(f64::INFINITY, f64::min);
        ASIDE * self.how.line_mm - nearest
    }

    /// What of the way from `a` to `b` is free, as lengths from `a`.
    fn free(&self, ends: [[f64; 2]; 2]) -> Spans {
        where_above(ends, |p| self.room(p))
    }
}

/// Supports that grow from the ground up.
struct Rising<'a> {
    graph: &'a Graph,
    how: &'a Clearance,
    laying: &'a Laying,
    by_level: Vec<Vec<Place>>,
    /// Squares at which columns end, and what of their sheets, drawn out, lies below what they hold.
    tops: HashMap<usize, [Spans; 2]>,
    /// Squares at which columns stand on the part.
    feet: Vec<usize>,
    /// Cubes on the ground that the surface touches, and what of their sheets lies under the part.
    low: Vec<(usize, [Spans; 2])>,
    /// What the last layer of a place had, of both diagonals.
    there: HashMap<Place, [Spans; 2]>,
}

impl Rising<'_> {
    /// The lines of a layer.
    fn layer(&mut self, [low, high]: [f64; 2], air: &Air<'_>) -> Vec<[[f64; 2]; 2]> {
        let grid = &self.graph.grid;
        let middle = (low + high) / 2.0;
        // Between the levels `level - 1` and `level`.
        let above = (middle - grid.origin.z) / grid.step_mm;
        let level = above.ceil().max(1.0) as usize;
        let mut places: Vec<Place> = self.by_level.get(level).cloned().unwrap_or_default();
        let first_level = (above - ABOVE).ceil().max(1.0) as usize;
        for level in first_level..=above.floor().max(0.0) as usize {
            let begins = self.by_level.get(level).map_or(&[][..], Vec::as_slice).iter();
            places.extend(begins.filter(|(node, _)| self.is_red(*node)).map(|(node, _)| (*node, ARCS)));
        }
        let on_part = |node: &usize| (above..above + BELOW).contains(&((node / grid.level()) as f64));
        places.extend(self.feet.iter().copied().filter(on_part).map(|node| (node, ON_PART)));
        if above < BELOW {
            places.extend(self.low.iter().map(|(cube, _)| (*cube, LOW)));
        }
        // Upright ones first: where sheets come together, what leans gives way.
        places.sort_unstable_by_key(|&(node, arc)| ((1..ARCS).contains(&arc), node, arc));
        places.dedup();
        let mut laid = Laid { lines: Vec::new(), line_mm: self.how.line_mm };
        let mut now = Vec::new();
        for place in places {
            let (mut below, centre) = (self.below(place), self.centre(place, middle));
            if place.1 == ON_PART {
                self.land(&mut below, centre, air);
            } else if let Some(held) = self.tops.get(&place.0) {
                self.lean_out(&mut below, place.0, high - low);
                if place.1 == ARCS {
                    below = std::array::from_fn(|diagonal| shared(&below[diagonal], &held[diagonal]));
                }
            }
            let on_part = place.1 == ON_PART;
            let shortest_mm = self.how.line_mm * if on_part { SHORTEST_ON_PART_WIDTHS } else { SHORTEST_WIDTHS };
            let spans: [Spans; 2] = std::array::from_fn(|diagonal| {
                let mut spans = self.stands(&below[diagonal], centre, diagonal, air);
                // On a slope what is too short to be laid grows with the next layers.
                spans.retain(|[a, b]| on_part || b - a >= shortest_mm);
                spans
            });
            let apart_mm = self.apart_mm(place, middle);
            for (diagonal, spans) in spans.iter().enumerate() {
                spans
                    .iter()
                    .for_each(|span| laid.add(centre, diagonal, self.short(*span, apart_mm, shortest_mm), shortest_mm));
            }
            now.push((place, spans));
        }
        self.there.extend(now);
        laid.lines.into_iter().map(|(diagonal, across, span)| span.map(|t| point(diagonal, across, t))).collect()
    }

    /// The roof in a layer, below what the sections `held` cut of the part.
    fn roof(
        &self,
        roof: &Roof,
        span_mm: [f64; 2],
        below: &SupportLayer,
        air: &Air<'_>,
        held: &[&[Section]],
    ) -> Vec<Line> {
        let grid = &self.graph.grid;
        let (step_mm, line_mm) = (grid.step_mm, self.how.line_mm);
        // The surface over a square is within two steps, and the roof and the gap lie below it.
        let thick_mm = (span_mm[1] - span_mm[0]) * (roof.layers + 1) as f64 + self.how.gap_mm;
        let near = |z: f64| (z - thick_mm..z + ABOVE * step_mm).contains(&span_mm[1]);
        let tops = self.tops.keys().chain(self.low.iter().map(|(cube, _)| cube)).map(|&node| grid.middle(node));
        // Sheets lean out, and stand between a square's corners.
        let around = |v: f64| [v - 1.5 * step_mm, v + 1.5 * step_mm];
        let cells: Vec<[[f64; 2]; 2]> = tops.filter(|at| near(at.z)).map(|at| [around(at.x), around(at.y)]).collect();
        let below = Segments::new(below.lines.clone());
        let room = |p: [f64; 2]| {
            let nearest = held.iter().copied().flatten().map(|s| s.signed_distance(p)).fold(f64::INFINITY, f64::min);
            air.room(p).min(-nearest)
        };
        roof.lines(&Under { cells: &cells, below: &below, line_mm, step_mm }, &room)
    }

    fn is_red(&self, node: usize) -> bool {
        self.tops.contains_key(&node)
    }

    /// Half a diagonal, mm.
    fn half(&self) -> f64 {
        self.graph.grid.step_mm * std::f64::consts::FRAC_1_SQRT_2
    }

    /// By how much the sheets of a place end short of the corners of its cell at a height, mm.
    fn apart_mm(&self, (node, arc): Place, z: f64) -> f64 {
        let grid = &self.graph.grid;
        if arc >= ARCS {
            return 0.0;
        }
        let below_mm = if self.is_red(node) { grid.middle(node).z - z } else { f64::INFINITY };
        self.laying.apart_mm(z - grid.origin.z, below_mm, grid.step_mm)
    }

    /// A sheet without so much of its ends at the corners of its cell, as far as it stays `shortest_mm` long; ends that keep from the part,
    /// or lean out, stay.
    fn short(&self, [from, to]: [f64; 2], apart_mm: f64, shortest_mm: f64) -> [f64; 2] {
        let [at_from, at_to] = [from, to].map(|t| f64::from(u8::from((t.abs() - self.half()).abs() < AT_CORNER_MM)));
        let most_mm = (to - from - shortest_mm).max(0.0) / (at_from + at_to).max(1.0);
        let mm = apart_mm.min(most_mm);
        [from + at_from * mm, to - at_to * mm]
    }

    /// What carries a place: what it had in the layer below, or what goes on below its foot.
    fn below(&self, place: Place) -> [Spans; 2] {
        if let Some(spans) = self.there.get(&place) {
            return spans.clone();
        }
        let (node, arc) = place;
        if arc == ON_PART {
            return Default::default();
        }
        if arc == LOW {
            // Only from the ground up: what was not there in the layer below is not there in this one.
            let own = self.low.iter().find(|(cube, _)| *cube == node);
            return own.map(|(_, spans)| spans.clone()).unwrap_or_default();
        }
        let foot = if arc == ARCS { node } else { self.graph.head(node, arc) };
        if self.graph.is_ground(foot) {
            return std::array::from_fn(|_| vec![[-self.half(), self.half()]]);
        }
        let feet: Vec<&[Spans; 2]> =
            (0..=ON_PART).filter(|&arc| arc != ARCS).filter_map(|arc| self.there.get(&(foot, arc))).collect();
        std::array::from_fn(|diagonal| joined(feet.iter().flat_map(|spans| spans[diagonal].iter().copied()).collect()))
    }

    /// The middle of a place's cross at a height.
    fn centre(&self, (node, arc): Place, z: f64) -> [f64; 2] {
        let grid = &self.graph.grid;
        let top = grid.middle(node);
        if arc >= ARCS {
            return [top.x, top.y];
        }
        let foot: Vec3 = grid.middle(self.graph.head(node, arc));
        let at = foot + (top - foot) * ((z - foot.z) / (top.z - foot.z)).clamp(0.0, 1.0);
        [at.x, at.y]
    }

    /// Lets sheets begin where the part carries them.
    fn land(&self, below: &mut [Spans; 2], centre: [f64; 2], air: &Air<'_>) {
        let half = self.half();
        for (diagonal, spans) in below.iter_mut().enumerate() {
            let ends = [-half, half].map(|t| along(centre, diagonal, t));
            let landed = where_above(ends, |p| air.carried(p)).into_iter().map(|[a, b]| [a - half, b - half]);
            *spans = joined(spans.iter().copied().chain(landed).collect());
        }
    }

    /// Lets the ends of the sheets below red square `node` go out by `mm` where a cube without columns of its own lies there.
    fn lean_out(&self, below: &mut [Spans; 2], node: usize, mm: f64) {
        let (half, farthest) = (self.half(), FARTHEST * self.half());
        for (diagonal, spans) in below.iter_mut().enumerate() {
            for end in [0, 1] {
                if !self.is_beside_wall(node, diagonal, end) {
                    continue;
                }
                let sign = if end == 0 { -1.0 } else { 1.0 };
                for span in spans.iter_mut().filter(|span| sign * span[end] > half - mm) {
                    span[end] = sign * (sign * span[end] + mm).min(farthest);
                }
            }
        }
    }

    /// Whether the cube beyond that end of a diagonal of red square `node` is black, and the one below it too.
    fn is_beside_wall(&self, node: usize, diagonal: usize, end: usize) -> bool {
        let grid = &self.graph.grid;
        let [x, y, z] = grid.cube(node);
        let up = (diagonal == 0) == (end == 1);
        let step = |v: usize, up: bool| if up { Some(v + 1) } else { v.checked_sub(1) };
        let (Some(x), Some(y), Some(under)) = (step(x, end == 1), step(y, up), z.checked_sub(1)) else { return false };
        let inside = x < grid.size[0] && y < grid.size[1];
        inside && [z, under].iter().all(|&z| self.graph.is_black(grid.index([x, y, z])))
    }

    /// What of a sheet stands in this layer.
    fn stands(&self, below: &Spans, centre: [f64; 2], diagonal: usize, air: &Air<'_>) -> Spans {
        let (Some([from, _]), Some([_, to])) = (below.first().copied(), below.last().copied()) else {
            return Spans::new();
        };
        let free = air.free([from, to].map(|t| along(centre, diagonal, t)));
        let free: Spans = free.into_iter().map(|[a, b]| [a + from, b + from]).collect();
        shared(below, &free)
    }

    /// The edges of the cells on the ground, each once: a cross alone sticks too little.
    fn feet(&self, air: &Air<'_>) -> Vec<[[f64; 2]; 2]> {
        let grid = &self.graph.grid;
        let feet = self.by_level.get(1).into_iter().flatten().map(|&(node, arc)| self.graph.head(node, arc));
        let mut edges: Vec<[[usize; 2]; 2]> = Vec::new();
        for foot in feet {
            let [x, y, _] = grid.cube(foot);
            edges.extend([
                [[x, y], [x + 1, y]],
                [[x, y + 1], [x + 1, y + 1]],
                [[x, y], [x, y + 1]],
                [[x + 1, y], [x + 1, y + 1]],
            ]);
        }
        edges.sort_unstable();
        edges.dedup();
        let corner =
            |[x, y]: [usize; 2]| [grid.origin.x + x as f64 * grid.step_mm, grid.origin.y + y as f64 * grid.step_mm];
        let shortest = SHORTEST_WIDTHS * self.how.line_mm;
        let mut lines = Vec::new();
        for edge in edges {
            let [a, b] = edge.map(corner);
            let at = |t: f64| [0, 1].map(|i| a[i] + (b[i] - a[i]) * t / grid.step_mm);
            let free = air.free([a, b]).into_iter().filter(|[from, to]| to - from >= shortest);
            lines.extend(free.map(|span| span.map(at)));
        }
        lines
    }
}

/// The lines of a layer, each by its diagonal, its distance from the origin across that, and from where to where it goes along it.
struct Laid {
    lines: Vec<(usize, f64, [f64; 2])>,
    line_mm: f64,
}

impl Laid {
    /// Lays what of a span no line lies on yet, in lines no shorter than `shortest_mm`.
    fn add(&mut self, centre: [f64; 2], diagonal: usize, span: [f64; 2], shortest_mm: f64) {
        let (across, middle) = turned(diagonal, centre);
        let mut left = vec![span.map(|t| middle + t)];
        for &(other, at, [from, to]) in &self.lines {
            if other == diagonal && (at - across).abs() < SIDE_BY_SIDE * self.line_mm {
                left = left
                    .into_iter()
                    .flat_map(|[a, b]| [[a, b.min(from)], [a.max(to), b]])
                    .filter(|[a, b]| a < b)
                    .collect();
            }
        }
        let left = left.into_iter().filter(|[a, b]| b - a >= shortest_mm);
        self.lines.extend(left.map(|span| (diagonal, across, span)));
    }
}

/// The direction of a diagonal.
fn direction(diagonal: usize) -> [f64; 2] {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    [half, if diagonal == 0 { half } else { -half }]
}

/// A point as its distance from the origin across a diagonal, and along it.
fn turned(diagonal: usize, [x, y]: [f64; 2]) -> (f64, f64) {
    let [dx, dy] = direction(diagonal);
    (y * dx - x * dy, x * dx + y * dy)
}

/// The point that lies so far across a diagonal, and along it.
fn point(diagonal: usize, across: f64, along: f64) -> [f64; 2] {
    let [dx, dy] = direction(diagonal);
    [along * dx - across * dy, along * dy + across * dx]
}

/// The point at `t` mm from the middle of a cell along a diagonal.
fn along(centre: [f64; 2], diagonal: usize, t: f64) -> [f64; 2] {
    let [dx, dy] = direction(diagonal);
    [centre[0] + t * dx, centre[1] + t * dy]
}
