//! Lines of supports as a mesh: each sheet, followed upward from layer to layer, is one closed solid.
//!
//! Slot frame, mm. A line of a layer goes on in the line above it that runs in the same direction and lies on it. Between the middles of
//! layers its ends move straight; where they move evenly over several layers no cross-section is needed, so that an upright sheet is a box
//! and a leaning one a slanted box. Sheets end a little beyond their lines, within those of the neighbouring cells, and begin a little
//! below the layer in which they do: solids overlap, and share no corner.

use std::collections::HashMap;

use rayon::prelude::*;

use crate::geom::{Bounds, Slot, Vec3};
use crate::mesh::{BoxTree, TriangleMesh};
use crate::support::lines::SupportLayer;

/// Sheets as closed solids, and what they come to.
#[derive(Clone, Debug)]
pub struct Sheets {
    /// All solids.
    pub mesh: TriangleMesh<Slot>,
    /// How many.
    pub count: usize,
    /// Those that run along x: the bars of a roof.
    pub bars: usize,
    /// Of what stands on the lowest level, mm².
    pub plate_mm2: f64,
    /// Of upper sides on which no support goes on, seen from above, mm².
    pub contact_mm2: f64,
}

/// A sheet ends so much of its width beyond its line.
const BEYOND_WIDTHS: f64 = 0.25;
/// A sheet that begins above the ground begins so much of a layer lower.
const DEEPER: f64 = 0.5;
/// Lines lie on each other where they are no farther apart, in heights of a layer: an oblique arc leans by 45 degrees, across its sheets by less.
const MOVES: f64 = 1.05;
/// What evenly moving ends may be off between two cross-sections, mm.
const EVEN_MM: f64 = 0.03;
/// A line on which another lies no farther aside, in widths, is not a top.
const COVERED_WIDTHS: f64 = 0.8;
/// Directions that differ by less than one part in so many are the same.
const DIRECTIONS: f64 = 1e4;

/// A line in its own frame: how far across its direction it lies, and from where to where along that.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Level {
    z: f64,
    across: f64,
    span: [f64; 2],
}

impl Level {
    /// The one at a height between two others.
    fn between(a: &Self, b: &Self, z: f64) -> Self {
        let t = if b.z > a.z { (z - a.z) / (b.z - a.z) } else { 0.0 };
        let mix = |a: f64, b: f64| a + (b - a) * t;
        Self { z, across: mix(a.across, b.across), span: [0, 1].map(|end| mix(a.span[end], b.span[end])) }
    }

    fn values(&self) -> [f64; 3] {
        [self.across, self.span[0], self.span[1]]
    }

    /// How far apart two are, heights left aside, mm.
    fn off(&self, other: &Self) -> f64 {
        let (a, b) = (self.values(), other.values());
        [0, 1, 2].map(|i| (a[i] - b[i]).abs()).into_iter().fold(0.0, f64::max)
    }

    /// What they share along their direction, mm.
    fn shared(&self, other: &Self) -> f64 {
        self.span[1].min(other.span[1]) - self.span[0].max(other.span[0])
    }
}

/// A sheet that grows upward.
struct Strand {
    direction: [f64; 2],
    levels: Vec<Level>,
}

/// A line's direction, towards growing x, and the line in its frame.
type Framed = ([f64; 2], Level);

fn framed([a, b]: [[f64; 2]; 2], z: f64) -> Framed {
    let length = (b[0] - a[0]).hypot(b[1] - a[1]);
    let mut d = [(b[0] - a[0]) / length, (b[1] - a[1]) / length];
    if d[0] < 0.0 || (d[0] == 0.0 && d[1] < 0.0) {
        d = d.map(|v| -v);
    }
    let along = [a, b].map(|p| p[0] * d[0] + p[1] * d[1]);
    let level = Level { z, across: a[1] * d[0] - a[0] * d[1], span: [along[0].min(along[1]), along[0].max(along[1])] };
    (d, level)
}

/// Lines by their direction and how far across it they lie, so that those near another are found at once.
struct Shelf {
    cell_mm: f64,
    by_place: HashMap<[i64; 3], Vec<usize>>,
}

impl Shelf {
    fn of<'a>(lines: impl Iterator<Item = &'a Framed>, cell_mm: f64) -> Self {
        let mut shelf = Self { cell_mm, by_place: HashMap::new() };
        for (at, line) in lines.enumerate() {
            shelf.by_place.entry(shelf.place(line)).or_default().push(at);
        }
        shelf
    }

    fn place(&self, (direction, level): &Framed) -> [i64; 3] {
        let [dx, dy] = direction.map(|d| (d * DIRECTIONS).round() as i64);
        [dx, dy, (level.across / self.cell_mm).floor() as i64]
    }

    /// Those of the same direction that lie within a cell's width aside, and more.
    fn near(&self, line: &Framed) -> impl Iterator<Item = usize> + '_ {
        let [dx, dy, across] = self.place(line);
        (across - 1..=across + 1).filter_map(move |across| self.by_place.get(&[dx, dy, across])).flatten().copied()
    }
}

/// The sheets of some layers, this wide.
pub fn sheets(layers: &[SupportLayer], wall_mm: f64) -> Sheets {
    let of_layer = |layer: &SupportLayer| -> Vec<Framed> {
        let middle = f64::midpoint(layer.span_mm[0], layer.span_mm[1]);
        layer.lines.iter().map(|line| framed(*line, middle)).collect()
    };
    let lines: Vec<Vec<Framed>> = layers.iter().map(of_layer).collect();
    let mut made = Made { ground: layers.first().map_or(0.0, |layer| layer.span_mm[0]), solids: Vec::new() };
    let mut growing: Vec<Strand> = Vec::new();
    for (layer, lines) in layers.iter().zip(&lines) {
        growing = made.grown(growing, lines, layer.span_mm);
    }
    let top = layers.last().map_or(0.0, |layer| layer.span_mm[1]);
    growing.into_iter().for_each(|strand| made.close(strand, top));
    let (mesh, [count, bars]) = made.mesh(wall_mm);
    let area = |(_, level): &Framed| (level.span[1] - level.span[0]) * wall_mm;
    let tops =
        (0..lines.len()).map(|k| wall_mm * open_mm(&lines[k], lines.get(k + 1).map_or(&[], Vec::as_slice), wall_mm));
    Sheets {
        plate_mm2: lines.first().map_or(0.0, |lines| lines.iter().map(area).sum()),
        contact_mm2: tops.sum(),
        mesh,
        count,
        bars,
    }
}

/// What of some lines no line of the next layer lies on, mm.
fn open_mm(lines: &[Framed], above: &[Framed], wall_mm: f64) -> f64 {
    let covered_mm = COVERED_WIDTHS * wall_mm;
    let shelf = Shelf::of(above.iter(), covered_mm);
    let left = |line: &Framed| {
        let level = &line.1;
        let near = shelf.near(line).map(|at| &above[at].1);
        let on = near.filter(|l| (l.across - level.across).abs() < covered_mm && l.shared(level) > 0.0);
        let mut on: Vec<[f64; 2]> = on.map(|l| l.span).collect();
        on.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let (mut left, mut from) = (0.0, level.span[0]);
        for [a, b] in on {
            left += (a - from).max(0.0);
            from = from.max(b);
        }
        left + (level.span[1] - from).max(0.0)
    };
    lines.iter().map(left).sum()
}

/// A sheet that has ended.
struct Solid {
    direction: [f64; 2],
    rings: Vec<Level>,
}

impl Solid {
    /// Its corners, ring by ring from below: counter-clockwise from above, the first two along its right side.
    fn corners(&self, wall_mm: f64) -> Vec<Vec3> {
        let (half, beyond, [dx, dy]) = (wall_mm / 2.0, BEYOND_WIDTHS * wall_mm, self.direction);
        let ring = |level: &Level| {
            let ([from, to], across) = (level.span, level.across);
            let corners = [(from - beyond, -half), (to + beyond, -half), (to + beyond, half), (from - beyond, half)];
            corners.map(|(along, aside)| {
                let across = across + aside;
                Vec3::new(along * dx - across * dy, along * dy + across * dx, level.z)
            })
        };
        self.rings.iter().flat_map(ring).collect()
    }

    /// Its facets over those corners.
    fn facets(&self) -> Vec<[u32; 3]> {
        let at = |ring: usize, k: usize| (4 * ring + k % 4) as u32;
        let end = self.rings.len() - 1;
        let side = |(ring, k): (usize, usize)| {
            let [a, b, c, d] = [at(ring, k), at(ring, k + 1), at(ring + 1, k + 1), at(ring + 1, k)];
            [[a, b, c], [a, c, d]]
        };
        let sides = (0..end).flat_map(|ring| (0..4).map(move |k| (ring, k))).flat_map(side);
        let ends = [[at(0, 0), at(0, 2), at(0, 1)], [at(0, 0), at(0, 3), at(0, 2)]];
        let tops = [[at(end, 0), at(end, 1), at(end, 2)], [at(end, 0), at(end, 2), at(end, 3)]];
        sides.chain(ends).chain(tops).collect()
    }

    /// Whether a place lies in it.
    fn holds(&self, wall_mm: f64, p: &Vec3) -> bool {
        let Some(pair) = self.rings.windows(2).find(|pair| (pair[0].z..=pair[1].z).contains(&p.z)) else {
            return false;
        };
        let level = Level::between(&pair[0], &pair[1], p.z);
        let ([dx, dy], beyond) = (self.direction, BEYOND_WIDTHS * wall_mm);
        let (along, across) = (p.x * dx + p.y * dy, p.y * dx - p.x * dy);
        (across - level.across).abs() <= wall_mm / 2.0
            && (level.span[0] - beyond..=level.span[1] + beyond).contains(&along)
    }
}

/// The solids so far.
struct Made {
    ground: f64,
    solids: Vec<Solid>,
}

impl Made {
    /// The sheets that grow on through a layer, and those that begin in it; the others end.
    fn grown(&mut self, below: Vec<Strand>, lines: &[Framed], [low, high]: [f64; 2]) -> Vec<Strand> {
        let most_mm = MOVES * (high - low);
        let last: Vec<Framed> =
            below.iter().map(|strand| (strand.direction, strand.levels[strand.levels.len() - 1])).collect();
        let shelf = Shelf::of(last.iter(), most_mm);
        let mut below: Vec<Option<Strand>> = below.into_iter().map(Some).collect();
        let mut next = Vec::with_capacity(lines.len());
        for line in lines {
            let (direction, level) = line;
            let lies = |at: &usize| {
                let under = &last[*at].1;
                below[*at].is_some() && (under.across - level.across).abs() <= most_mm && under.shared(level) > 0.0
            };
            let off = |at: &usize| last[*at].1.off(level);
            let carrier = shelf.near(line).filter(lies).min_by(|a, b| off(a).total_cmp(&off(b)));
            let strand = carrier.and_then(|at| below[at].take());
            let mut strand = strand.unwrap_or_else(|| self.begun(*direction, level, [low, high]));
            strand.levels.push(*level);
            next.push(strand);
        }
        below.into_iter().flatten().for_each(|strand| self.close(strand, low));
        next
    }

    /// A sheet that begins with this line: on the ground, or within what lies below.
    fn begun(&self, direction: [f64; 2], level: &Level, [low, high]: [f64; 2]) -> Strand {
        let deeper = if low > self.ground { DEEPER * (high - low) } else { 0.0 };
        Strand { direction, levels: vec![Level { z: low - deeper, ..*level }] }
    }

    /// Ends a sheet at a height.
    fn close(&mut self, mut strand: Strand, z: f64) {
        let top = strand.levels.last().map(|last| Level { z, ..*last });
        strand.levels.extend(top);
        self.solids.push(Solid { direction: strand.direction, rings: needed(&strand.levels) });
    }

    /// All solids as one mesh, and of those in it how many there are, and how many run along x.
    ///
    /// A reader that asks in which other solid one lies asks for its first facet. So that is one outside all others around it, and a solid
    /// that has none adds nothing.
    fn mesh(&self, wall_mm: f64) -> (TriangleMesh<Slot>, [usize; 2]) {
        let corners: Vec<Vec<Vec3>> = self.solids.iter().map(|solid| solid.corners(wall_mm)).collect();
        let bounds: Vec<Bounds> = corners.iter().map(|corners| Bounds::of(corners.iter().copied())).collect();
        let tree = BoxTree::of_boxes(bounds.clone());
        let first = |own: usize| -> Option<usize> {
            let mut around = Vec::new();
            tree.visit(&Bounds { min: bounds[own].min, max: bounds[own].min }, |other| around.push(other));
            around.retain(|&other| other != own && bounds[other].holds(&bounds[own].max));
            let middle = |facet: &[u32; 3]| facet.iter().map(|&v| corners[own][v as usize]).sum::<Vec3>() / 3.0;
            let is_outside = |p: Vec3| !around.iter().any(|&other| self.solids[other].holds(wall_mm, &p));
            self.solids[own].facets().iter().position(|facet| is_outside(middle(facet)))
        };
        let firsts: Vec<Option<usize>> = (0..corners.len()).into_par_iter().map(first).collect();
        let (mut vertices, mut facets, mut counts) = (Vec::new(), Vec::new(), [0, 0]);
        for ((solid, corners), first) in self.solids.iter().zip(&corners).zip(firsts) {
            let Some(first) = first else { continue };
            let base = vertices.len() as u32;
            let mut own = solid.facets();
            own.rotate_left(first);
            vertices.extend_from_slice(corners);
            facets.extend(own.into_iter().map(|facet| facet.map(|v| v + base)));
            counts = [counts[0] + 1, counts[1] + usize::from(solid.direction[1] == 0.0)];
        }
        (TriangleMesh::new(vertices, facets), counts)
    }
}

/// The levels without which a sheet would be another: between those that stay, all others lie on straight lines.
fn needed(levels: &[Level]) -> Vec<Level> {
    let mut kept = vec![levels[0]];
    let mut from = 0;
    while from + 1 < levels.len() {
        from = evenly(levels, from);
        kept.push(levels[from]);
    }
    kept
}

/// The last level up to which all move evenly from this one on.
fn evenly(levels: &[Level], from: usize) -> usize {
    let first = levels[from].values();
    // How fast each value may move so that all levels so far lie on its way.
    let mut pace = [[f64::NEG_INFINITY, f64::INFINITY]; 3];
    let mut last = from + 1;
    for (at, level) in levels.iter().enumerate().skip(from + 1) {
        let (up, values) = (level.z - levels[from].z, level.values());
        let own = [0, 1, 2].map(|i| (values[i] - first[i]) / up);
        if own.iter().zip(&pace).any(|(own, [slow, fast])| own < slow || own > fast) {
            break;
        }
        last = at;
        for (pace, own) in pace.iter_mut().zip(own) {
            *pace = [pace[0].max(own - EVEN_MM / up), pace[1].min(own + EVEN_MM / up)];
        }
    }
    last
}
