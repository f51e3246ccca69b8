//! What each layer prints, before its order is chosen.

use std::borrow::Cow;
use std::f64::consts::FRAC_PI_4;

use rayon::prelude::*;

use super::Line;
use super::hatch::{Lattice, Stroke, chains};
use super::order::rearmost;
use super::overhang::Ground;
use super::region::{Point, Region, Shape, area_mm2, grown, minus, mm};
use super::skins::{Inside, Stack, inside, solids};
use super::walls::{Bead, Walled, walled};
use crate::slicing::SliceSettings;

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
}

/// One line of extrusion.
pub(super) struct Path {
    pub(super) feature: Feature,
    pub(super) points: Vec<Point>,
    /// The line's width where it is not the usual one, mm.
    pub(super) width_mm: Option<f64>,
    /// Whether the way here from the path before stays in the same infill, so that ooze does no harm.
    pub(super) hop: bool,
}

/// Infill of one kind.
pub(super) struct Fill {
    pub(super) feature: Feature,
    pub(super) chains: Vec<Vec<Stroke>>,
    /// The lines' width where it is not the usual one, mm.
    pub(super) width_mm: Option<f64>,
    /// The longest way between neighbouring lines, mm.
    pub(super) hop_mm: f64,
}

/// A connected piece of a layer that prints something.
pub(super) struct Island<'a> {
    pub(super) beads: &'a [Bead],
    pub(super) fills: Vec<Fill>,
}

impl Island<'_> {
    /// Where the island begins, for choosing the next one.
    pub(super) fn start(&self) -> Point {
        let wall = self.beads.first().map(|l| l.points[rearmost(&l.points)]);
        let fill = || self.fills.first().map(|f| f.chains[0][0][0]);
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
pub(super) fn all_walls(stack: &Stack<'_>, line: &Line, walls: u32) -> Vec<Vec<Walled>> {
    let of = |at: usize| stack.outlines[at].iter().map(|shape| walled(shape, line, walls)).collect();
    (0..stack.outlines.len())
        .into_par_iter()
        .map(|at| if stack.same_as[at] == at { of(at) } else { Vec::new() })
        .collect()
}

/// Every layer, planned.
pub(super) fn planned<'a>(
    stack: &Stack<'_>,
    walls: &'a [Vec<Walled>],
    line: &Line,
    s: &SliceSettings,
) -> Vec<PlannedLayer<'a>> {
    let count = stack.outlines.len();
    let walls_of = |at: usize| &walls[stack.same_as[at]];
    let insides: Vec<Vec<Inside>> = (0..count)
        .into_par_iter()
        .map(|at| walls_of(at).iter().map(|w| inside(stack, at, &w.infill, line, s)).collect())
        .collect();
    let hollows: Vec<Region> =
        insides.iter().map(|islands| islands.iter().flat_map(|i| i.hollow.clone()).collect()).collect();
    // What is printed first lies on what is there, even where layers below it were too narrow to print.
    let prints = |at: &usize| walls_of(*at).iter().any(|w| !w.beads.is_empty() || !w.infill.is_empty());
    let first = (0..count).find(prints).unwrap_or(0);
    let layer = |at: usize| {
        let under = at.checked_sub(1).filter(|_| at > first);
        let carrier = under.map(|b| printed(&stack.outlines[b], walls_of(b)));
        let below = carrier.as_deref().zip(under.map(|b| &hollows[b]));
        let islands = walls_of(at).iter().zip(&insides[at]);
        let islands = islands
            .map(|(w, i)| Island { beads: &w.beads, fills: fills(i, at, below, stack.outlines.get(at + 1), line, s) });
        let printing = islands.filter(|island| !island.beads.is_empty() || !island.fills.is_empty()).collect();
        PlannedLayer { islands: printing, ground: carrier.as_deref().and_then(|below| ground(stack, at, below, line)) }
    };
    (0..count).into_par_iter().map(layer).collect()
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
    below: Option<(&Region, &Region)>,
    above: Option<&Region>,
    line: &Line,
    s: &SliceSettings,
) -> Vec<Fill> {
    let angle = if at.is_multiple_of(2) { FRAC_PI_4 } else { 3.0 * FRAC_PI_4 };
    let solids = solids(&inside.solid, below, above, line);
    let mut fills = Vec::new();
    for (region, angle) in &solids.bridges {
        fills.extend(region.iter().map(|shape| solid(Feature::Bridge, shape, *angle, line)));
    }
    fills.extend(solids.rest.iter().map(|shape| solid(Feature::Solid, shape, angle, line)));
    fills.extend(solids.top.iter().map(|shape| solid(Feature::Top, shape, angle, line)));
    if s.infill > 0.0 {
        let lattice = Lattice::common(angle, f64::from(line.spacing) / s.infill);
        fills.push(fill(Feature::Sparse, &inside.hollow, lattice, None));
    }
    fills.retain(|fill| !fill.chains.is_empty());
    fills
}

/// A shape filled line by line; the lines are as wide as their pitch asks for.
fn solid(feature: Feature, shape: &Shape, angle: f64, line: &Line) -> Fill {
    let region = vec![shape.clone()];
    let lattice = Lattice::fitted(&region, angle, f64::from(line.spacing));
    let width_mm = mm(lattice.pitch) + line.width_mm - line.spacing_mm;
    fill(feature, &region, lattice, Some(width_mm))
}

fn fill(feature: Feature, region: &Region, lattice: Lattice, width_mm: Option<f64>) -> Fill {
    // Along a border at 45 degrees neighbouring ends lie 1.4 spacings apart.
    Fill { feature, chains: chains(region, lattice), width_mm, hop_mm: 2.0 * mm(lattice.pitch) }
}
