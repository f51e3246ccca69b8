//! Rule `fill`: the made body against the design, from filament and sections alone.
//!
//! ```text
//! sections --Mask--> where the part is, a little below and above the middle of each layer   (cells of a quarter of a millimetre)
//! lines ----Plastic-> what lies there, as a share of the layer's height
//!                     -> skins    surfaces and first layers are full
//!                     -> walls    no slit through outer walls, layer upon layer; walls as thick as in the other layers
//!                     -> threads  walls of more than one line, where two are wanted
//!                     -> sparse   infill does not stop and go on
//!                     -> hollow   nor is it missing altogether
//!                     -> shells   behind a surface lies a second full layer
//!                     -> crowd    no more than fits, layer upon layer
//! ```
//!
//! No comment is believed: neither widths nor roles nor heights are asked for where lines themselves tell. What a header or the profile states of walls,
//! infill and solid layers only tells whether they may be missing everywhere. Layers are looked at in runs, so that three are held at a time.

mod crowd;
mod hollow;
mod map;
mod region;
mod shells;
mod skins;
mod sparse;
mod threads;
mod walls;

use rayon::prelude::*;

use super::prints::{Level, PrintedPart};
use super::report::{FindingPlace, Findings, Rule};
use crate::section::Segment;
pub(super) use crowd::{MOST, MOST_OF_THREADS, MOST_ON_TOP};
use map::{Mask, Plastic};
pub(super) use skins::{LEAST, OVER_AIR};
pub(super) use walls::{SLIT_LAYERS, SLIT_MM};

/// How far below and above its middle a layer is cut, mm: a face within belongs to neither side.
const EITHER_WAY_MM: f64 = 0.02;
/// No printer's layers are thinner on the mean, mm.
const THINNEST_MM: f64 = 0.02;
/// Layers that are looked at in one run.
const RUN: usize = 16;
/// How much higher than its neighbours' usual distance a layer may be for its distance to be its height.
const HIGHER: f64 = 1.6;
/// Layers that differ by less are alike, mm, and this part of all is nearly all.
const SAME_MM: f64 = 2e-3;
const NEARLY_ALL: f64 = 0.8;
/// What a stated height may be off the distance from the layer below, mm; see `layers`.
const HEIGHT_MM: f64 = 0.05;
/// How far the slicer's own factor on all flow is believed.
const MULTIPLIER: [f64; 2] = [0.9, 1.1];

/// One layer with what lies in it.
struct Layer<'a> {
    level: &'a Level,
    mask: Mask,
    plastic: Plastic,
    /// The upper of both cuts, each segment with what the outline moves outward per mm of height.
    outline: Vec<(Segment, f64)>,
}

/// What one layer tells of itself to be compared with others.
struct Told {
    z: f64,
    line: u32,
    height: f64,
    walls: walls::Seen,
    tiles: Vec<sparse::Tile>,
    crowds: Vec<crowd::Crowd>,
}

/// Holds one print's layers against what the design wants in them.
pub(super) fn check(printed: &PrintedPart<'_>, findings: &mut Findings) {
    // What has more layers than any printer makes has findings enough, and is not worth its cells.
    let [low, high] = printed.sections.range();
    if printed.levels.len() as f64 * THINNEST_MM > high - low + 1.0 {
        return;
    }
    let usual = Usual::of(&printed.levels);
    let starts: Vec<usize> = (0..printed.levels.len()).step_by(RUN).collect();
    let runs: Vec<(Vec<Told>, Findings)> = starts.into_par_iter().map(|start| run(printed, start, usual)).collect();
    let mut all = Vec::with_capacity(printed.levels.len());
    for (told, found) in runs {
        all.extend(told);
        findings.absorb(found);
    }
    walls::check(printed, &all, findings);
    threads::check(printed, &all, findings);
    let columns = sparse::columns(&all);
    sparse::check(printed, &all, &columns, findings);
    hollow::check(printed, &all, &columns, findings);
    crowd::check(printed, &all, findings);
}

/// What most layers of a print lie over each other, and whether nearly all do.
#[derive(Clone, Copy)]
struct Usual {
    gap_mm: f64,
    is_same: bool,
}

impl Usual {
    fn of(levels: &[Level]) -> Self {
        let mut gaps: Vec<f64> = levels.iter().map(|level| level.gap).collect();
        gaps.sort_by(f64::total_cmp);
        let gap_mm = gaps.get(gaps.len() / 2).copied().unwrap_or(0.0);
        let same = gaps.iter().filter(|gap| (*gap - gap_mm).abs() <= SAME_MM).count();
        Self { gap_mm, is_same: same as f64 >= NEARLY_ALL * gaps.len() as f64 }
    }

    /// How high a layer's lines are, mm: as far as it lies over the one below, unless something too narrow to print is between. Where all
    /// layers are alike, and one is stated to be so too, what the rule `layer-height` lets it be off is no other height.
    fn height(&self, printed: &PrintedPart<'_>, index: usize) -> Option<f64> {
        let level = printed.levels.get(index)?;
        let gap = Some(level.gap).filter(|mm| *mm > 0.0);
        let is_near = |a: f64, b: f64, mm: f64| (a - b).abs() <= mm;
        match level.stated.or(level.nominal).filter(|mm| *mm > 0.0) {
            Some(mm) if level.gap > mm + HEIGHT_MM => Some(mm),
            Some(mm) if self.is_same && is_near(mm, self.gap_mm, SAME_MM) && is_near(mm, level.gap, HEIGHT_MM) => {
                Some(mm)
            }
            None if level.gap > HIGHER * self.gap_mm => None,
            _ => gap,
        }
    }
}

/// The layers from `start` on.
fn run(printed: &PrintedPart<'_>, start: usize, usual: Usual) -> (Vec<Told>, Findings) {
    let mut findings = Findings::default();
    let end = (start + RUN).min(printed.levels.len());
    let layer = |index: usize| Layer::of(printed, printed.levels.get(index)?, usual.height(printed, index)?);
    let mut told = Vec::new();
    let mut below = start.checked_sub(1).and_then(layer).map(Full::of);
    let mut here = layer(start).map(Full::of);
    for index in start..end {
        let above = layer(index + 1).map(Full::of);
        if let Some(full) = &here {
            let first = index == 0;
            let last = index + 1 == printed.levels.len();
            // Beside a layer that cannot be looked at nothing is known to be a surface.
            let known = (first || below.is_some(), last || above.is_some());
            let around = Around { below: below.as_ref(), here: full, above: above.as_ref(), first, known };
            skins::check(printed, &around, &mut findings);
            told.push(Told {
                z: full.layer.level.z,
                line: full.layer.level.line,
                height: full.layer.height(),
                walls: walls::Seen::of(&full.layer),
                tiles: sparse::tiles(&around),
                crowds: crowd::crowds(&around),
            });
        }
        below = here;
        here = above;
    }
    (told, findings)
}

/// A layer with the sums of what is in it.
struct Full<'a> {
    layer: Layer<'a>,
    plastic: map::Sums,
    solid: map::Sums,
}

impl<'a> Full<'a> {
    fn of(layer: Layer<'a>) -> Self {
        let plastic = map::Sums::of_shares(&layer.mask.frame, &layer.plastic.cells);
        let solid = map::Sums::of_solid(&layer.mask.frame, &layer.mask.cells);
        Self { layer, plastic, solid }
    }

    /// Where a square that is all within the part lies in the layer's frame; `low` is its lowest cell, counted from the machine's origin.
    fn inside(&self, low: [i64; 2], cells: usize) -> Option<[usize; 2]> {
        let frame = &self.layer.mask.frame;
        let at = [0, 1].map(|axis| low[axis] - frame.low[axis]);
        let fits = (0..2).all(|axis| at[axis] >= 0 && at[axis] as usize + cells <= frame.size[axis]);
        let at = at.map(|v| v as usize);
        (fits && self.solid.square(at, cells) > (cells * cells) as f64 - 0.5).then_some(at)
    }

    /// Whether anything of the part is in a square of the layer; the parts of it beyond the frame have nothing.
    fn has(&self, low: [i64; 2], cells: usize) -> bool {
        let any = |cell: [i64; 2]| self.layer.mask.at(cell) != 0;
        (0..cells as i64).any(|row| (0..cells as i64).any(|column| any([low[0] + column, low[1] + row])))
    }
}

/// A layer between its neighbours.
struct Around<'a> {
    below: Option<&'a Full<'a>>,
    here: &'a Full<'a>,
    above: Option<&'a Full<'a>>,
    first: bool,
    /// Whether what is below and above is known.
    known: (bool, bool),
}

impl<'a> Layer<'a> {
    fn of(printed: &PrintedPart<'_>, level: &'a Level, height: f64) -> Option<Self> {
        let middle = level.z - height / 2.0 + level.lowered;
        let [low, high] = printed.sections.range();
        let within = |z: f64| z.clamp(low + EITHER_WAY_MM / 2.0, high - EITHER_WAY_MM / 2.0);
        let lower = printed.sections.segments_at(within(middle - EITHER_WAY_MM));
        let outline = printed.sections.sloped_segments_at(within(middle + EITHER_WAY_MM));
        let upper: Vec<Segment> = outline.iter().map(|(segment, _)| *segment).collect();
        let mask = Mask::of([&lower, &upper])?;
        let mut plastic = Plastic::none(mask.frame, height);
        for m in level.beads.iter().map(|&index| printed.bead(index)) {
            let Some([from, to]) = m.ends() else { continue };
            plastic.lay([[from.x, from.y], [to.x, to.y]], m.e * printed.filament_mm2);
        }
        Some(Self { level, mask, plastic, outline })
    }

    fn height(&self) -> f64 {
        self.plastic.height_mm()
    }
}

fn place(printed: &PrintedPart<'_>, line: u32) -> FindingPlace {
    FindingPlace { line, slot: Some(printed.planned.slot), part: Some(printed.planned.part) }
}

/// The share that a full layer has: the slicer's factor, as far as it is believed.
fn full_share(printed: &PrintedPart<'_>) -> f64 {
    printed.flow.multiplier.clamp(MULTIPLIER[0], MULTIPLIER[1])
}

fn add(
    printed: &PrintedPart<'_>,
    line: u32,
    numbers: [f64; 2],
    findings: &mut Findings,
    text: impl FnOnce() -> String,
) {
    findings.add(Rule::Fill, place(printed, line), numbers, text);
}
