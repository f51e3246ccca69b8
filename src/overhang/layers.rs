//! The rule layer by layer: what a layer has beyond the one below, grown by what it may reach, and what of that no bridge carries.
//!
//! ```text
//! carried(i)  = layer(i) within h tan(threshold) of carried(i - 1)
//! hangs(i)    = what of layer(i) is not carried, where any of it lies beyond h tan(threshold) + w/2 of carried(i - 1)
//! ```
//!
//! The half line is let pass once and does not add up: what only it lets pass carries nothing. Layer by layer it would make slopes of
//! 64.8 degrees of a threshold of 45 (0.2 and 0.45 mm). What is found to hang, or is bridged, counts as there from then on.
//!
//! Layers are cut in their middle, as slicers cut them, from the part's lowest point up. Only those are looked at between which a
//! facet looks down by more than the threshold: between all others the surface goes out by no more than the threshold allows.

use std::collections::BTreeMap;
use std::fmt;

use super::Rule;
use super::chords::Air;
use super::region::{Corners, Region, and, area_mm2, covered, enclosed, grown, minus, or, strips, with_few_points};
use crate::geom::{Mat3, Sets, Slot, Vec3};
use crate::mesh::TriangleMesh;
use crate::section::Sections;

/// Facets of a part that lie on something, and what of it is there.
#[derive(Clone, Debug, Default)]
pub struct Footing {
    /// The part's own facets.
    pub own: Vec<[Vec3; 3]>,
    /// What lies below them; empty where that is more than they cover (the table).
    pub below: Vec<[Vec3; 3]>,
}

/// What a part stands on.
#[derive(Clone, Debug, Default)]
pub struct Ground {
    /// Facets that lie on something.
    pub footings: Vec<Footing>,
    /// Whether the lowest layer lies on something that goes on beyond the part, as the table does: then all of it is carried, though it
    /// be wider than the part's foot.
    pub table: bool,
    /// Supports that stand below it; for parts that are printed along +Z of their own frame only.
    pub held: Held,
}

/// Supports as lines.
#[derive(Clone, Debug, Default)]
pub struct Held {
    /// The top of each layer and the middles of its lines, upward, mm.
    pub layers: Vec<(f64, Vec<[[f64; 2]; 2]>)>,
    /// Width of a line, mm.
    pub line_mm: f64,
    /// The air between them and what lies on them, mm; they end in layers of their own.
    pub gap_mm: f64,
    /// So far beside them, and beside what is carried, a layer may reach, mm: lines lie across sheets that are no farther apart than
    /// twice that.
    pub beside_mm: f64,
}

impl Held {
    /// What holds a layer that goes from `under` up by `high`: what ends in the air below it.
    fn under(&self, under: f64, high: f64) -> Region {
        let air = (self.gap_mm / high - SAME_LAYER).ceil().max(0.0) * high;
        let near = SAME_LAYER * high;
        let below = self.layers.iter().filter(|(top, _)| (under - air - near..=under + near).contains(top));
        strips(below.flat_map(|(_, lines)| lines), self.line_mm)
    }
}

/// What a part lays on nothing, connected from layer to layer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patch {
    /// Summed over its layers, mm².
    pub area_mm2: f64,
    /// Its middle, the mesh's frame.
    pub at: Vec3,
    /// Why.
    pub cause: Cause,
}

/// Why a patch hangs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cause {
    /// It touches nothing below.
    Island,
    /// A flat ceiling too wide for a bridge, or held at one side only.
    Ceiling {
        /// Its box across the build direction, the longer side first.
        size_mm: [f64; 2],
        /// What may be spanned.
        bridge_mm: f64,
    },
    /// A slope that goes out too far.
    Slope {
        /// How high it is.
        high_mm: f64,
        /// The threshold, from the vertical.
        most_deg: f64,
    },
}

impl fmt::Display for Cause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Island => write!(f, "it begins in the air"),
            Self::Ceiling { size_mm: [long, wide], bridge_mm } => {
                write!(
                    f,
                    "ceiling {long:.1} x {wide:.1} mm, a bridge may span {bridge_mm} mm between two ends on material"
                )
            }
            Self::Slope { high_mm, most_deg } => {
                write!(f, "slope of more than {most_deg:.0} deg over {high_mm:.1} mm of height")
            }
        }
    }
}

/// Areas below this are rounding, mm².
const NOTHING_MM2: f64 = 1e-4;
/// A share of a piece that no chord carries is the rounding of its border up to this, where it is less than half of what is tolerated.
const ROUNDING: f64 = 0.02;
/// Rounding of normals: an overhang of exactly the threshold is none.
const SINE_SLACK: f64 = 1e-6;
/// What the threshold may be passed by, radians (half a degree): facets are let pass by as much.
const ANGLE_SLACK: f64 = 0.5 * std::f64::consts::PI / 180.0;
/// A slope hangs in every few of its layers, since what was found to hang counts as there: pieces no farther apart in height than this
/// are of one patch, mm, ..
const SAME_PATCH_MM: f64 = 2.0;
/// .. where their boxes are no farther apart than this, and as much more as they are apart in height, mm.
const TOGETHER_MM: f64 = 0.5;
/// A face whose normal leans up or down by less than this (sine) covers nothing: 0.3 micrometres in a layer of 0.3 mm.
const EDGE_ON: f64 = 1e-3;
/// Heights that differ by less than this share of a layer are the same.
const SAME_LAYER: f64 = 0.01;
/// A patch of at most so many layers is a ceiling.
const CEILING_LAYERS: usize = 2;

/// What `mesh` printed along `up` lays on nothing, the largest first, patches that `rule` tolerates left out. It stands on `ground`;
/// facets that `stands` says yes to are of it, and need not be looked at. With `enough` the search ends as soon as there is
/// a patch that is not tolerated.
///
/// Whatever angle a facet has, what begins in the air and what hangs on a ridge is [`Relief`](super::Relief)'s to say: a point has
/// no area.
pub fn unsupported<F>(
    mesh: &TriangleMesh<F>,
    up: &Vec3,
    ground: &Ground,
    stands: impl Fn(usize) -> bool,
    rule: &Rule,
    enough: bool,
) -> Vec<Patch> {
    if rule.reach_mm().is_infinite() {
        return Vec::new();
    }
    let mut stack = Stack::of(mesh, up, ground, rule);
    let mut found: Vec<Patch> = Vec::new();
    for run in stack.steep(mesh, up, stands) {
        found.extend(stack.patches(run, enough));
        if enough && !found.is_empty() {
            break;
        }
    }
    found.sort_by(|a, b| b.area_mm2.total_cmp(&a.area_mm2));
    found
}

/// What hangs in one layer, connected.
struct Piece {
    layer: usize,
    area_mm2: f64,
    middle: [f64; 2],
    bounds: [[f64; 2]; 2],
    island: bool,
}

/// The layers of an upright part, cut as they are asked for.
struct Stack<'a> {
    rule: &'a Rule,
    /// To the upright frame.
    upright: Mat3,
    sections: Sections,
    low: f64,
    high: f64,
    /// Of what lies on something: the facets upright, and what is below them, whole.
    footings: Vec<(Vec<[Vec3; 3]>, Option<Region>)>,
    table: bool,
    held: &'a Held,
}

impl<'a> Stack<'a> {
    fn of<F>(mesh: &TriangleMesh<F>, up: &Vec3, ground: &'a Ground, rule: &'a Rule) -> Self {
        let across = Vec3::ith(if up.z.abs() > 0.999 { 1 } else { up.iamin() }, 1.0).cross(up).normalize();
        let upright = Mat3::from_rows(&[across.transpose(), up.cross(&across).transpose(), up.transpose()]);
        let turned = mesh.vertices().iter().map(|v| upright * v).collect();
        let sections = Sections::of(&TriangleMesh::<Slot>::new(turned, mesh.facets().to_vec()));
        let [low, high] = sections.range();
        let all = |facets: &[[Vec3; 3]]| facets.iter().map(|f| f.map(|p| upright * p)).collect::<Vec<_>>();
        let footing = |one: &Footing| {
            let below = (!one.below.is_empty()).then(|| seen(&all(&one.below), [f64::NEG_INFINITY, f64::INFINITY]));
            (all(&one.own), below)
        };
        let footings = ground.footings.iter().map(footing).collect();
        Self { rule, upright, sections, low, high, footings, table: ground.table, held: &ground.held }
    }

    /// The middle of layer `i`, upright; of the layer below the first, infinitely low.
    fn middle(&self, i: Option<usize>) -> f64 {
        i.map_or(f64::NEG_INFINITY, |i| self.low + (i as f64 + 0.5) * self.rule.layer_mm)
    }

    /// The layers to look at, in runs of neighbours; the run with the most area at stake first.
    fn steep<F>(
        &self,
        mesh: &TriangleMesh<F>,
        up: &Vec3,
        stands: impl Fn(usize) -> bool,
    ) -> Vec<std::ops::RangeInclusive<usize>> {
        let h = self.rule.layer_mm;
        let sine = self.rule.overhang.rad().sin() + SINE_SLACK;
        let mut stake: BTreeMap<usize, f64> = BTreeMap::new();
        // The last whose middle lies below the top.
        let last = ((self.high - self.low) / h - 0.5).ceil() - 1.0;
        for facet in 0..mesh.facets().len() {
            let steep = mesh.normal(facet).is_some_and(|n| n.dot(up) < -sine);
            if !steep || stands(facet) {
                continue;
            }
            let z = mesh.corners(facet).map(|p| p.dot(up));
            let number = |z: f64| ((z - self.low) / h + 0.5).floor().clamp(0.0, last.max(0.0));
            let near = 1e-3 * h;
            let lowest = number(z.iter().copied().fold(f64::INFINITY, f64::min) - near);
            let highest = number(z.iter().copied().fold(f64::NEG_INFINITY, f64::max) + near);
            let share = mesh.facet_area(facet) / (highest - lowest + 1.0);
            (lowest as usize..=highest as usize).for_each(|i| *stake.entry(i).or_default() += share);
        }
        let layers: Vec<(usize, f64)> = stake.into_iter().collect();
        let mut runs: Vec<&[(usize, f64)]> = layers.chunk_by(|a, b| b.0 == a.0 + 1).collect();
        let sum = |run: &[(usize, f64)]| run.iter().map(|(_, area)| area).sum::<f64>();
        runs.sort_by(|a, b| sum(b).total_cmp(&sum(a)));
        runs.into_iter().map(|run| run[0].0..=run[run.len() - 1].0).collect()
    }

    fn layer(&self, i: usize) -> Region {
        enclosed(&self.sections.segments_at(self.middle(Some(i))))
    }

    /// What is there below layer `i`: what of the layer below is `carried`, and whatever else.
    fn below(&self, i: usize, carried: Region) -> Region {
        let band = [self.middle(i.checked_sub(1)), self.middle(Some(i))];
        let carried = match self.held.layers.is_empty() {
            true => carried,
            false => or(&carried, &self.held.under(self.low + i as f64 * self.rule.layer_mm, self.rule.layer_mm)),
        };
        self.footings.iter().fold(carried, |below, (own, under)| {
            let foot = seen(own, band);
            or(&below, &under.as_ref().map_or_else(|| foot.clone(), |under| and(&foot, under)))
        })
    }

    /// What hangs in a run of layers.
    fn patches(&mut self, run: std::ops::RangeInclusive<usize>, enough: bool) -> Vec<Patch> {
        let mut carried = run.start().checked_sub(1).map(|i| self.layer(i)).unwrap_or_default();
        let mut pieces: Vec<Piece> = Vec::new();
        for i in run {
            let layer = self.layer(i);
            if i == 0 && self.table {
                carried = layer;
                continue;
            }
            let below = with_few_points(&self.below(i, carried));
            let count = pieces.len();
            carried = self.hanging(i, layer, &below, &mut pieces);
            if enough && pieces.len() > count {
                let found = patches(&pieces, self);
                if !found.is_empty() {
                    return found;
                }
            }
        }
        patches(&pieces, self)
    }

    /// What of layer `i` is carried, or counts as there from now on; what hangs goes to `pieces`.
    fn hanging(&self, i: usize, layer: Region, below: &Region, pieces: &mut Vec<Piece>) -> Region {
        let is_nothing = |region: &Region| region.iter().map(area_mm2).sum::<f64>() < NOTHING_MM2;
        let over = minus(&layer, below);
        if is_nothing(&over) {
            return layer;
        }
        let cone = self.rule.layer_mm * (self.rule.overhang.rad() + ANGLE_SLACK).tan();
        let past = minus(&over, &grown(below, cone, Corners::Sharp));
        if is_nothing(&past) {
            return layer;
        }
        let reach_mm = self.rule.reach_mm();
        let reach_mm = if self.held.layers.is_empty() { reach_mm } else { reach_mm.max(self.held.beside_mm) };
        let beyond = minus(&past, &grown(below, reach_mm, Corners::Round));
        if is_nothing(&beyond) {
            return minus(&layer, &past);
        }
        let (hangs, rests): (Region, Region) =
            past.into_iter().partition(|one| !is_nothing(&and(&vec![one.clone()], &beyond)));
        let air = Air::of(&over, below);
        for one in hangs {
            let Some(loose) = air.loose(&one, self.rule) else { continue };
            let area_mm2 = area_mm2(&one) * loose.share;
            if loose.share > ROUNDING || area_mm2 > self.rule.tolerate_mm2 / 2.0 {
                let own = vec![one];
                let around = over.iter().find(|whole| !is_nothing(&and(&vec![(*whole).clone()], &own)));
                let island = around.is_some_and(|whole| !air.is_held(whole));
                pieces.push(Piece { layer: i, area_mm2, middle: loose.middle, bounds: loose.bounds, island });
            }
        }
        minus(&layer, &rests)
    }
}

/// What facets between two heights cover, seen from above.
fn seen(facets: &[[Vec3; 3]], [low, high]: [f64; 2]) -> Region {
    let outline = |facet: &[Vec3; 3]| {
        let normal = (facet[1] - facet[0]).cross(&(facet[2] - facet[0]));
        let is_seen = normal.z.abs() > EDGE_ON * normal.norm();
        is_seen.then(|| (clipped(facet, low, high).iter().map(|p| [p.x, p.y]).collect(), normal.z > 0.0))
    };
    covered(facets.iter().filter_map(outline))
}

/// The part of a facet above `low` and not above `high`.
fn clipped(facet: &[Vec3; 3], low: f64, high: f64) -> Vec<Vec3> {
    let mut corners = facet.to_vec();
    for (sign, level) in [(1.0, low), (-1.0, high)] {
        if level.is_infinite() {
            continue;
        }
        let height = |p: &Vec3| sign * (p.z - level);
        let mut kept = Vec::with_capacity(corners.len() + 1);
        for i in 0..corners.len() {
            let (a, b) = (corners[i], corners[(i + 1) % corners.len()]);
            let (ha, hb) = (height(&a), height(&b));
            if ha >= 0.0 {
                kept.push(a);
            }
            if (ha >= 0.0) != (hb >= 0.0) {
                kept.push(a + (b - a) * (ha / (ha - hb)));
            }
        }
        corners = kept;
    }
    corners
}

/// Pieces that hang together from layer to layer, without what is tolerated.
fn patches(pieces: &[Piece], stack: &Stack<'_>) -> Vec<Patch> {
    let mut sets = Sets::new(pieces.len());
    for (i, a) in pieces.iter().enumerate() {
        for (j, b) in pieces.iter().enumerate().skip(i + 1) {
            let apart = a.layer.abs_diff(b.layer) as f64 * stack.rule.layer_mm;
            if apart <= SAME_PATCH_MM && near(&a.bounds, &b.bounds, TOGETHER_MM + apart) {
                sets.join(i as u32, j as u32);
            }
        }
    }
    let mut groups: BTreeMap<u32, Vec<&Piece>> = BTreeMap::new();
    for (i, piece) in pieces.iter().enumerate() {
        groups.entry(sets.root(i as u32)).or_default().push(piece);
    }
    let mut all: Vec<Patch> = groups.into_values().map(|group| patch(&group, stack)).collect();
    all.retain(|patch| patch.area_mm2 > stack.rule.tolerate_mm2);
    all
}

fn near(a: &[[f64; 2]; 2], b: &[[f64; 2]; 2], mm: f64) -> bool {
    (0..2).all(|i| a[0][i] <= b[1][i] + mm && b[0][i] <= a[1][i] + mm)
}

fn patch(group: &[&Piece], stack: &Stack<'_>) -> Patch {
    let area_mm2: f64 = group.iter().map(|p| p.area_mm2).sum();
    let mean = |of: &dyn Fn(&Piece) -> f64| group.iter().map(|p| of(p) * p.area_mm2).sum::<f64>() / area_mm2;
    // A layer's underside, where its lines would need something.
    let under = |p: &Piece| stack.low + p.layer as f64 * stack.rule.layer_mm;
    let upright = Vec3::new(mean(&|p| p.middle[0]), mean(&|p| p.middle[1]), mean(&under));
    let first = group.iter().map(|p| p.layer).min().unwrap_or(0);
    let last = group.iter().map(|p| p.layer).max().unwrap_or(0);
    let high_mm = (last - first + 1) as f64 * stack.rule.layer_mm;
    let cause = if group.iter().any(|p| p.layer == first && p.island) {
        Cause::Island
    } else if last - first < CEILING_LAYERS {
        let size = [0, 1].map(|i| {
            let ends = group.iter().map(|p| [p.bounds[0][i], p.bounds[1][i]]);
            let [low, high] = ends.fold([f64::INFINITY, f64::NEG_INFINITY], |r, e| [r[0].min(e[0]), r[1].max(e[1])]);
            high - low
        });
        Cause::Ceiling { size_mm: [size[0].max(size[1]), size[0].min(size[1])], bridge_mm: stack.rule.bridge_mm }
    } else {
        Cause::Slope { high_mm, most_deg: stack.rule.overhang.deg() }
    };
    Patch { area_mm2, at: stack.upright.transpose() * upright, cause }
}

#[cfg(test)]
mod tests;
