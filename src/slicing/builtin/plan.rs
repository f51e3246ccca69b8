//! What each layer prints, before its order is chosen.

use std::borrow::Cow;
use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_4, TAU};
use std::sync::Arc;

use rayon::prelude::*;

use super::hatch::Lattice;
use super::near::Shapes;
use super::overhang::Ground;
use super::region::{Contour, GridPoint, Region, Shape, area_mm2, distance_mm, grown, holds, minus, mm, units};
use super::seam::rearmost;
use super::skins::{Between, Bridge, Inside, Stack, inside, solids};
use super::strips::{Strips, fitted};
use super::walls::{Bead, Walled, walled_once};
use super::zigzag::lines;
use super::{Line, Lines};
use crate::slicing::{InfillPattern, SliceSettings};

/// What a line is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Feature {
    OuterWall,
    InnerWall,
    Overhang,
    Gap,
    Bridge,
    Solid,
    Top,
    Sparse,
    Support,
    Adhesion,
}

/// One line of extrusion.
pub(super) struct Path {
    pub(super) feature: Feature,
    pub(super) points: Vec<GridPoint>,
    /// The line's width where it is not the usual one, mm.
    pub(super) width_mm: Option<f64>,
    /// The corners of the way here from the path before.
    pub(super) way: Vec<GridPoint>,
    /// Whether the filament is pulled back on that way.
    pub(super) pull: bool,
}

/// Infill of one kind.
pub(super) struct Fill {
    pub(super) feature: Feature,
    /// Rows across the region.
    pub(super) lines: Vec<Contour>,
    /// Lines along its border.
    pub(super) beads: Arc<[Bead]>,
    /// The rows' width where it is not the usual one, mm.
    pub(super) width_mm: Option<f64>,
}

impl Fill {
    /// A place where it may begin; `None` where it has no lines.
    fn start(&self) -> Option<GridPoint> {
        let along = || self.beads.first().map(|bead| &bead.points);
        self.lines.first().or_else(along).map(|points| points[0])
    }
}

/// A connected piece of a layer that prints something.
pub(super) struct Island<'a> {
    pub(super) shape: &'a Shape,
    /// The middles of its outer walls where whole lines fit.
    pub(super) centre: &'a Region,
    pub(super) beads: &'a [Bead],
    pub(super) fills: Vec<Fill>,
}

impl Island<'_> {
    /// Where the island begins, for choosing the next one.
    pub(super) fn start(&self) -> GridPoint {
        let wall = self.beads.first().map(|l| l.points[rearmost(&l.points)]);
        let fill = || self.fills.first().and_then(Fill::start);
        wall.or_else(fill).unwrap_or_default()
    }
}

/// One layer.
pub(super) struct PlannedLayer<'a> {
    pub(super) islands: Vec<Island<'a>>,
    /// Where walls are carried from below; `None` when they are everywhere.
    pub(super) ground: Option<Ground>,
}

/// The walls of every layer; equal layers share those of the lowest one.
pub(super) fn all_walls(outlines: &[Region], same_as: &[usize], lines: &Lines, walls: u32) -> Vec<Vec<Walled>> {
    let of = |at: usize| walled_once(&outlines[at], lines.at(at), walls);
    let each = (0..outlines.len()).into_par_iter();
    each.map(|at| if same_as[at] == at { of(at) } else { Vec::new() }).collect()
}

/// Every layer, planned.
pub(super) fn planned<'a>(
    stack: &Stack<'a>,
    walls: &'a [Vec<Walled>],
    lines: &Lines,
    s: &SliceSettings,
) -> Vec<PlannedLayer<'a>> {
    let count = stack.outlines.len();
    let walls_of = |at: usize| &walls[stack.same_as[at]];
    let mut insides: Vec<Vec<Inside>> = (0..count)
        .into_par_iter()
        .map(|at| walls_of(at).iter().map(|w| inside(stack, at, &w.infill, lines.at(at), s)).collect())
        .collect();
    onto_sparse_rows(&mut insides, stack, walls, lines, s);
    let hollows = hollows(&insides);
    // What is printed first lies on what is there, even where layers below it were too narrow to print.
    let prints = |at: &usize| walls_of(*at).iter().any(|w| !w.beads.is_empty() || !w.infill.is_empty());
    let first = (0..count).find(prints).unwrap_or(0);
    let strips = Strips::default();
    let layer = |at: usize| {
        let line = lines.at(at);
        let under = at.checked_sub(1).filter(|_| at > first);
        let carrier = under.map(|b| printed(&stack.outlines[b], walls_of(b)));
        let below = carrier.as_deref().zip(under).map(|(carrier, b)| [carrier, &hollows[b]].map(Shapes::of));
        let reach = units(s.anchor_mm) + 2 * line.width;
        let between = |solid: &Region| Between {
            below: below.as_ref().map(|below| [0, 1].map(|i| below[i].near(solid, reach))),
            rows: under.and_then(|below| sparse_rows(below, lines.at(below), s)),
            above: stack.near(at + 1, solid),
            goes_on: stack.are_alike(at, at + 1),
        };
        let islands = stack.outlines[stack.same_as[at]].iter().zip(walls_of(at)).zip(&insides[at]);
        let islands = islands.map(|((shape, w), i)| Island {
            shape,
            centre: &w.centre,
            beads: &w.beads,
            fills: fills(i, at, &between(&i.solid), &strips, line, s),
        });
        let printing = islands.filter(|island| !island.beads.is_empty() || !island.fills.is_empty()).collect();
        PlannedLayer { islands: printing, ground: carrier.as_deref().and_then(|below| ground(stack, at, below, line)) }
    };
    (0..count).into_par_iter().map(layer).collect()
}

/// The hollow inside of every layer.
fn hollows(insides: &[Vec<Inside>]) -> Vec<Region> {
    insides.iter().map(|islands| islands.iter().flat_map(|i| i.hollow.clone()).collect()).collect()
}

/// Brings what is solid on sparse rows out to the next of them.
fn onto_sparse_rows(
    insides: &mut [Vec<Inside>],
    stack: &Stack<'_>,
    walls: &[Vec<Walled>],
    lines: &Lines,
    s: &SliceSettings,
) {
    let hollows = hollows(insides);
    insides.par_iter_mut().enumerate().for_each(|(at, islands)| {
        let Some(below) = at.checked_sub(1) else { return };
        let [Some(rows), Some(own)] = [below, at].map(|layer| sparse_rows(layer, lines.at(layer), s)) else { return };
        let hollow = Shapes::of(&hollows[below]);
        for (inside, walled) in islands.iter_mut().zip(&walls[stack.same_as[at]]) {
            let below = hollow.near(&inside.solid, 0);
            inside.onto(&walled.infill, &below, [rows, own], lines.at(at), s);
        }
    });
}

/// The layer without what was too narrow to print: nothing rests on that.
fn printed<'a>(outline: &'a Region, walls: &[Walled]) -> Cow<'a, Region> {
    let lost: Region = walls.iter().flat_map(|w| w.lost.clone()).collect();
    if lost.is_empty() { Cow::Borrowed(outline) } else { Cow::Owned(minus(outline, &lost)) }
}

/// What carries this layer's walls, unless the layer below carries all of them: half a line width beyond its border.
fn ground(stack: &Stack<'_>, at: usize, below: &Region, line: &Line) -> Option<Ground> {
    if stack.same_as[at] != at {
        return None;
    }
    let air = minus(&stack.outlines[at], &grown(below, line.width));
    (area_mm2(&air) > 0.0).then(|| Ground::new(&grown(below, line.width / 2)))
}

fn fills(
    inside: &Inside,
    at: usize,
    between: &Between<'_>,
    strips: &Strips,
    line: &Line,
    s: &SliceSettings,
) -> Vec<Fill> {
    let angle = angle_of(at);
    let solids = solids(&inside.solid, between, line, units(s.anchor_mm));
    let mut fills = Vec::new();
    // Borders that were brought out to sparse rows run along this layer's: side by side on one lattice, no two rows lie on each other
    // there, and none is missing.
    let is_skin = solids.bridges.iter().any(|bridge| bridge.is_on_rows);
    for Bridge { region, angle, is_on_rows } in &solids.bridges {
        // The way from one line over air to the next lies on something, or is none.
        let carried = |way: &[GridPoint]| {
            between.below.as_ref().is_none_or(|[outline, _]| way.iter().all(|&p| holds(outline, p)))
        };
        let rows = |shape: &Shape| match is_on_rows {
            true => Lattice::full(*angle, line),
            false => Lattice::fitted(&vec![shape.clone()], *angle, f64::from(line.spacing)),
        };
        fills.extend(region.iter().map(|shape| solid(Feature::Bridge, shape, rows(shape), line, s, carried)));
    }
    let anywhere = |_: &[GridPoint]| true;
    for (feature, region) in [(Feature::Solid, &solids.rest), (Feature::Top, &solids.top)] {
        fills.extend(region.iter().map(|shape| {
            if is_skin {
                return solid(feature, shape, Lattice::full(angle, line), line, s, anywhere);
            }
            let rows = solid(feature, shape, fitted(shape, angle, line), line, s, anywhere);
            let turns = rows.lines.iter().map(Vec::len).sum();
            let along = strips.along(shape, line, turns);
            along.map_or(rows, |beads| Fill { feature, lines: Vec::new(), beads, width_mm: None })
        }));
    }
    if s.infill > 0.0 {
        let joined = s.infill_pattern == InfillPattern::Lines;
        // Three sets joined along the same wall would lie on each other there.
        let sparse = |lattice: Lattice| lines(&inside.hollow, lattice, inset(line.spacing, line, s), |_| joined);
        let sets = match sparse_rows(at, line, s) {
            Some(rows) => vec![sparse(rows)],
            None => cubic(at, apart(line, s), s.layer_height_mm).map(sparse).into(),
        };
        fills.extend(sets.into_iter().map(|lines| Fill {
            feature: Feature::Sparse,
            lines,
            beads: Arc::default(),
            width_mm: None,
        }));
    }
    fills.retain(|fill| fill.start().is_some());
    fills
}

/// The direction of a layer's rows, rad from +X.
fn angle_of(layer: usize) -> f64 {
    if layer.is_multiple_of(2) { FRAC_PI_4 } else { 3.0 * FRAC_PI_4 }
}

/// How far sparse rows lie apart, grid units.
fn apart(line: &Line, s: &SliceSettings) -> f64 {
    f64::from(line.spacing) / s.infill
}

/// A layer's sparse rows where they run one way; `None` in cubes, and where there are none.
fn sparse_rows(layer: usize, line: &Line, s: &SliceSettings) -> Option<Lattice> {
    let has = s.infill > 0.0 && s.infill_pattern == InfillPattern::Lines;
    has.then(|| Lattice::common(angle_of(layer), apart(line, s)))
}

/// Where a layer cuts the faces of cubes that stand on a corner: three sets of rows with as much plastic together as one of rows `apart`.
///
/// Those faces lean by `asin(1/sqrt(3))` from the vertical, so the rows wander by `sqrt(1/2)` of the height.
fn cubic(layer: usize, apart: f64, layer_height_mm: f64) -> [Lattice; 3] {
    let wander = f64::from(units(layer_height_mm)) * (layer as f64 + 0.5) * FRAC_1_SQRT_2;
    [0.0, 1.0, 2.0].map(|third| Lattice::common(FRAC_PI_4 + third * TAU / 3.0, 3.0 * apart).shifted(wander))
}

/// A shape filled line by line; the lines are as wide as its area asks for.
fn solid(
    feature: Feature,
    shape: &Shape,
    lattice: Lattice,
    line: &Line,
    s: &SliceSettings,
    allowed: impl Fn(&[GridPoint]) -> bool,
) -> Fill {
    let region = vec![shape.clone()];
    let lines = lines(&region, lattice, inset(lattice.pitch as i32, line, s), allowed);
    let legs = lines.iter().flat_map(|points| points.windows(2));
    let length: f64 = legs.map(|leg| distance_mm(leg[0], leg[1])).sum();
    // Where lines turn they lie in the wall by the overlap; the plastic that this takes is none too much.
    let pitch = mm(lattice.pitch);
    let spacing = (area_mm2(&region) / length.max(1e-9)).clamp((1.0 - MOST_OFF) * pitch, (1.0 + MOST_OFF) * pitch);
    let full = spacing + line.width_mm - line.spacing_mm;
    let spared =
        if feature == Feature::Bridge { (1.0 - s.bridge_flow) * line.area_of(full) / line.height_mm } else { 0.0 };
    Fill { feature, lines, beads: Arc::default(), width_mm: Some(full - spared) }
}

/// So much may a line be wider or narrower than its pitch asks for, so that the plastic is what the area holds.
const MOST_OFF: f64 = 0.1;

/// How far inside the border the lines that fill a row of this `pitch` are joined, grid units: half of it, less what they overlap the walls by.
fn inset(pitch: i32, line: &Line, s: &SliceSettings) -> i32 {
    pitch / 2 - units(s.infill_overlap * line.width_mm).max(LEAST_OVERLAP)
}

/// So much of an overlap there always is, grid units, half a micrometre: a row may lie half a pitch inside the border.
const LEAST_OVERLAP: i32 = 5;
