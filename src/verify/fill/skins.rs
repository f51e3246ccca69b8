//! Surfaces are full, and nowhere is more plastic than fits.
//!
//! Every slicer closes what is seen from above and below: of a layer, all over which the part does not go on, all below which it does not
//! begin, and all of the first layer. A window of 2 x 2 mm in such a region, clear of its border, has about the plastic that fills it, and
//! all windows together have it more closely. More may lie where the layer below has room for it: over air and over sparse infill threads
//! are thick.

use super::super::prints::PrintedPart;
use super::super::report::Findings;
use super::map::{CELL_MM, Frame, Mask, SOLID, Sums};
use super::{Around, Full, add, full_share};

/// A window's edge, in cells, and how far it stays clear of the region's border.
const WINDOW: usize = 8;
const CLEAR: usize = 2;
const OUTER: usize = WINDOW + 2 * CLEAR;
/// What a full region holds at least and at most, in one window and all together: a line that lacks takes a fifth of a window, coasting before a
/// seam and odd ends of patterns a seventh; where lines turn there is a fifth more.
const LEAST: [f64; 2] = [0.84, 0.92];
const MOST: [f64; 2] = [1.25, 1.15];
/// Fewer windows than this, of some 5 x 5 mm, are one place and no region.
const SEVERAL: usize = 50;
/// What threads over air fill at least, which each slicer draws as it likes.
const OVER_AIR: f64 = 0.5;
/// Below less than this there is room for more, here or up to so many windows away: threads go on beyond what they span.
const ROOM_BELOW: f64 = 0.85;
const AROUND: i64 = 2;
/// So many cells of the part are enough to be asked for their plastic.
const TELLING: f64 = 16.0;
/// So many cells without part below are air.
const AIR: f64 = 6.0;
/// Windows with less than this are sparse, and with no more than this not too full.
const DENSE: f64 = 0.8;
const FULL: f64 = 1.1;
/// What smoothing may add.
const MOST_THIN: f64 = 0.55;

/// What a region is.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    First,
    Top,
    OverAir,
}

impl Kind {
    fn words(self) -> &'static str {
        match self {
            Self::First => "the first layer",
            Self::Top => "a top surface",
            Self::OverAir => "a bottom surface",
        }
    }

    /// What to do where such surfaces are left out on purpose.
    fn remedy(self, share: f64) -> &'static str {
        match self {
            _ if share >= NONE => "",
            Self::Top => "; for prints without tops set [process] top_layers = 0",
            Self::First | Self::OverAir => "; for prints without bottoms set [process] bottom_layers = 0",
        }
    }
}

/// Less than this is meant, or gone altogether.
const NONE: f64 = 0.5;

/// What the windows of a region hold.
#[derive(Clone, Copy)]
struct Held {
    count: usize,
    sum: f64,
    /// The one that is farthest off, and where it is.
    worst: f64,
    at: [usize; 2],
}

impl Held {
    const NOTHING: Self = Self { count: 0, sum: 0.0, worst: f64::NAN, at: [0; 2] };

    fn take(&mut self, share: f64, at: [usize; 2], is_worse: impl Fn(f64, f64) -> bool) {
        if self.count == 0 || is_worse(share, self.worst) {
            (self.worst, self.at) = (share, at);
        }
        self.count += 1;
        self.sum += share;
    }

    /// The worst window's share, or that of all, with the limit that it does not keep: first that of a window, then that of the region.
    fn beyond(&self, [window, region]: [f64; 2], is_beyond: impl Fn(f64, f64) -> bool) -> Option<[f64; 2]> {
        let mean = self.sum / self.count as f64;
        if self.count > 0 && is_beyond(self.worst, window) {
            return Some([self.worst, window]);
        }
        (self.count >= SEVERAL && is_beyond(mean, region)).then_some([mean, region])
    }
}

pub(super) fn check(printed: &PrintedPart<'_>, around: &Around<'_>, findings: &mut Findings) {
    let process = &printed.job.profile.process;
    if around.first && process.bottom_layers > 0 {
        full(printed, around, Kind::First, &around.here.solid, findings);
    }
    if !around.first && around.known.0 && process.bottom_layers > 0 {
        let below = around.below.map(|full| &full.layer.mask);
        if let Some(region) = exposed(around, below) {
            full(printed, around, Kind::OverAir, &region, findings);
        }
    }
    if around.known.1 && process.top_layers > 0 {
        let above = around.above.map(|full| &full.layer.mask);
        if let Some(region) = exposed(around, above) {
            full(printed, around, Kind::Top, &region, findings);
        }
    }
    too_full(printed, around, findings);
}

/// Cells of the layer that the other one has not; `None` where they hold no window.
fn exposed(around: &Around<'_>, other: Option<&Mask>) -> Option<Sums> {
    let mask = &around.here.layer.mask;
    let mut cells = vec![false; mask.cells.len()];
    let mut count = 0;
    mask.each_with(other, |index, here, there| {
        cells[index] = here == SOLID && there == 0;
        count += usize::from(cells[index]);
    });
    (count >= OUTER * OUTER).then(|| Sums::of(&mask.frame, cells.iter().map(|cell| f64::from(u8::from(*cell)))))
}

/// Visits windows that lie in the region, clear of its border.
fn windows(around: &Around<'_>, region: &Sums, mut visit: impl FnMut([usize; 2])) {
    let [columns, rows] = around.here.layer.mask.frame.size;
    let all = (OUTER * OUTER) as f64 - 0.5;
    for row in (0..rows.saturating_sub(OUTER)).step_by(2) {
        for column in (0..columns.saturating_sub(OUTER)).step_by(2) {
            if region.square([column, row], OUTER) > all {
                visit([column + CLEAR, row + CLEAR]);
            }
        }
    }
}

fn full(printed: &PrintedPart<'_>, around: &Around<'_>, kind: Kind, region: &Sums, findings: &mut Findings) {
    let cells = (WINDOW * WINDOW) as f64 * full_share(printed);
    let (mut least, mut most) = (Held::NOTHING, Held::NOTHING);
    windows(around, region, |at| {
        let share = around.here.plastic.square(at, WINDOW) / cells;
        least.take(share, at, |one, other| one < other);
        if kind == Kind::Top && (share < FULL || !has_room_below(around, at)) {
            most.take(share, at, |one, other| one > other);
        }
    });
    let limits = if kind == Kind::OverAir { [OVER_AIR; 2] } else { LEAST };
    if let Some(short) = least.beyond(limits, |share, limit| share < limit) {
        say(printed, around, (kind.words(), least, kind.remedy(short[0])), short, findings);
    }
    if let Some(over) = most.beyond(MOST, |share, limit| share > limit) {
        say(printed, around, (kind.words(), most, ""), over, findings);
    }
}

/// Where more lies than fits, in a layer and the two below it: PrusaSlicer lays one or two layers of thick threads over a whole region if some
/// of it lies over sparse infill.
fn too_full(printed: &PrintedPart<'_>, around: &Around<'_>, findings: &mut Findings) {
    let cells = (WINDOW * WINDOW) as f64 * full_share(printed);
    let mut held = Held::NOTHING;
    windows(around, &around.here.solid, |at| {
        let share = around.here.plastic.square(at, WINDOW).min(below(around, at)) / cells;
        if share > DENSE && (share < FULL || !has_room_below(around, at)) {
            held.take(share, at, |one, other| one > other);
        }
    });
    if let Some(over) = held.beyond(MOST, |share, limit| share > limit) {
        say(printed, around, ("a layer", held, ""), over, findings);
    }
    smoothed(printed, around, findings);
}

/// The least that the two layers below have in a window; the first layer lies on what is full.
fn below(around: &Around<'_>, at: [usize; 2]) -> f64 {
    if around.first {
        return f64::INFINITY;
    }
    let frame = &around.here.layer.mask.frame;
    let low = [0, 1].map(|axis| frame.low[axis] + at[axis] as i64);
    let of = |layer: Option<&Full<'_>>| {
        let layer = layer?;
        Some(layer.plastic.square(within(&layer.layer.mask.frame, low)?, WINDOW))
    };
    let lower = if around.second { Some(f64::INFINITY) } else { of(around.lower) };
    of(around.below).zip(lower).map_or(0.0, |(below, lower)| below.min(lower))
}

/// The place in a frame of the window whose lowest cell is `low`; `None` where it does not fit.
fn within(frame: &Frame, low: [i64; 2]) -> Option<[usize; 2]> {
    let at = [0, 1].map(|axis| low[axis] - frame.low[axis]);
    let fits = (0..2).all(|axis| at[axis] >= 0 && at[axis] as usize + WINDOW <= frame.size[axis]);
    fits.then(|| at.map(|v| v as usize))
}

/// Whether the layer below has less than fills it at a window or beside it: sparse infill, or air.
fn has_room_below(around: &Around<'_>, at: [usize; 2]) -> bool {
    if around.first {
        return false;
    }
    let Some(below) = around.below else { return true };
    let (frame, other) = (&around.here.layer.mask.frame, &below.layer.mask.frame);
    let by = WINDOW as i64;
    (-AROUND..=AROUND).any(|dy| {
        (-AROUND..=AROUND).any(|dx| {
            let low = [frame.low[0] + at[0] as i64 + dx * by, frame.low[1] + at[1] as i64 + dy * by];
            let here = within(frame, low).map_or(0.0, |at| around.here.solid.square(at, WINDOW));
            let Some(at) = within(other, low) else { return here > AIR };
            let solid = below.solid.square(at, WINDOW);
            here - solid > AIR || (solid >= TELLING && below.plastic.square(at, WINDOW) < ROOM_BELOW * solid)
        })
    })
}

/// What thin lines add.
fn smoothed(printed: &PrintedPart<'_>, around: &Around<'_>, findings: &mut Findings) {
    let Some(thin) = &around.here.layer.thin else { return };
    let sums = Sums::of(&around.here.layer.mask.frame, thin.cells.iter().map(|v| f64::from(*v)));
    let mut held = Held::NOTHING;
    windows(around, &around.here.solid, |at| {
        held.take(sums.square(at, WINDOW) / (WINDOW * WINDOW) as f64, at, |one, other| one > other);
    });
    if held.count > 0 && held.worst > MOST_THIN {
        say(printed, around, ("by thin lines alone a layer", held, ""), [held.worst, MOST_THIN], findings);
    }
}

/// A region that is too full, or not full: all of it, or its worst window.
fn say(
    printed: &PrintedPart<'_>,
    around: &Around<'_>,
    (what, held, remedy): (&str, Held, &str),
    [share, limit]: [f64; 2],
    findings: &mut Findings,
) {
    let level = around.here.layer.level;
    add(printed, level.line, [share, limit], findings, || {
        let [x, y] = around.here.layer.mask.frame.middle(held.at, WINDOW);
        let (part, mm) = (printed.planned.part, WINDOW as f64 * CELL_MM);
        let over =
            if share == held.worst { format!(" over {mm} x {mm} mm") } else { " on the mean, the worst".to_owned() };
        let bound = if share < limit { "minimum" } else { "maximum" };
        format!(
            "{what} of part {part} at Z {:.2} is {:.0} % full{over} at X {x:.1} Y {y:.1} ({bound} {:.0} %{remedy})",
            level.z,
            share * 100.0,
            limit * 100.0
        )
    });
}
