//! What each layer prints, before its order is chosen.

use std::borrow::Cow;
use std::f64::consts::FRAC_PI_4;

use rayon::prelude::*;

use super::Line;
use super::hatch::{Stroke, chains};
use super::order::rearmost;
use super::overhang::Ground;
use super::region::{Point, Region, area_mm2, grown, minus};
use super::skins::{Inside, Stack, inside, solids};
use super::walls::{Loop, Walled, walled};
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
    /// Cross-section as a share of the full line's.
    pub(super) flow: f64,
    /// Whether the way here from the path before stays in the same infill, so that ooze does no harm.
    pub(super) hop: bool,
}

/// Infill of one kind.
pub(super) struct Fill {
    pub(super) feature: Feature,
    pub(super) chains: Vec<Vec<Stroke>>,
    /// The longest way between neighbouring lines, mm.
    pub(super) hop_mm: f64,
}

/// A connected piece of a layer that prints something.
pub(super) struct Island<'a> {
    pub(super) loops: &'a [Loop],
    pub(super) fills: Vec<Fill>,
}

impl Island<'_> {
    /// Where the island begins, for choosing the next one.
    pub(super) fn start(&self) -> Point {
        let wall = self.loops.first().map(|l| l.points[rearmost(&l.points)]);
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
    let layer = |at: usize| {
        let carrier = at.checked_sub(1).map(|b| printed(&stack.outlines[b], walls_of(b)));
        let below = carrier.as_deref().zip(at.checked_sub(1).map(|b| &hollows[b]));
        let islands = walls_of(at).iter().zip(&insides[at]);
        let islands = islands
            .map(|(w, i)| Island { loops: &w.loops, fills: fills(i, at, below, stack.outlines.get(at + 1), line, s) });
        let printing = islands.filter(|island| !island.loops.is_empty() || !island.fills.is_empty()).collect();
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
    let spacing = f64::from(line.spacing);
    let mut fills: Vec<Fill> =
        solids.bridges.iter().map(|(region, angle)| fill(Feature::Bridge, region, *angle, spacing)).collect();
    fills.push(fill(Feature::Solid, &solids.rest, angle, spacing));
    fills.push(fill(Feature::Top, &solids.top, angle, spacing));
    if s.infill > 0.0 {
        fills.push(fill(Feature::Sparse, &inside.hollow, angle, spacing / s.infill));
    }
    fills.retain(|fill| !fill.chains.is_empty());
    fills
}

fn fill(feature: Feature, region: &Region, angle: f64, spacing: f64) -> Fill {
    // Along a border at 45 degrees neighbouring ends lie 1.4 spacings apart.
    Fill { feature, chains: chains(region, angle, spacing), hop_mm: 2.0 * super::region::mm(spacing) }
}
