//! Surfaces are full.
//!
//! Every slicer closes what is seen from above and below: of a layer, all over which the part does not go on, all below which it does not
//! begin, and all of the first layer. A window of 2 x 2 mm in such a region, clear of its border, has about the plastic that fills it, and
//! all windows together have it more closely. What is too much is not told here: slicers lay threads a third thicker over whole regions.
//!
//! Shares of a layer that is full to its height; lengths in cells.

use super::super::prints::PrintedPart;
use super::super::report::Findings;
use super::map::{CELL_MM, Mask, SOLID, Sums};
use super::{Around, add, full_share};

/// A window's edge, in cells, and how far it stays clear of the region's border.
const WINDOW: usize = 8;
const CLEAR: usize = 2;
const OUTER: usize = WINDOW + 2 * CLEAR;
/// What a full region holds at least, in one window and all together. Of sound files the emptiest windows had 0.81, and regions 0.91: what is told
/// lies well beyond.
pub(in crate::verify) const LEAST: [f64; 2] = [0.7, 0.85];
/// Fewer windows than this, of some 5 x 5 mm, are one place and no region.
const SEVERAL: usize = 50;
/// What threads over air fill at least, which each slicer draws as it likes.
pub(in crate::verify) const OVER_AIR: f64 = 0.35;
/// Less than this is meant, or gone altogether.
const NONE: f64 = 0.5;

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

    fn take(&mut self, share: f64, at: [usize; 2]) {
        if self.count == 0 || share < self.worst {
            (self.worst, self.at) = (share, at);
        }
        self.count += 1;
        self.sum += share;
    }

    /// The worst window's share, or that of all, with the limit that it does not keep: first that of a window, then that of the region.
    fn below(&self, [window, region]: [f64; 2]) -> Option<[f64; 2]> {
        let mean = self.sum / self.count as f64;
        if self.count > 0 && self.worst < window {
            return Some([self.worst, window]);
        }
        (self.count >= SEVERAL && mean < region).then_some([mean, region])
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
    let mut least = Held::NOTHING;
    windows(around, region, |at| {
        let share = around.here.plastic.square(at, WINDOW) / cells;
        least.take(share, at);
    });
    let limits = if kind == Kind::OverAir { [OVER_AIR; 2] } else { LEAST };
    if let Some(short) = least.below(limits) {
        say(printed, around, (kind, least), short, findings);
    }
}

/// A region that is not full: all of it, or its worst window.
fn say(
    printed: &PrintedPart<'_>,
    around: &Around<'_>,
    (kind, held): (Kind, Held),
    [share, limit]: [f64; 2],
    findings: &mut Findings,
) {
    let level = around.here.layer.level;
    add(printed, level.line, [share, limit], findings, || {
        let [x, y] = around.here.layer.mask.frame.middle(held.at, WINDOW);
        let (part, mm) = (printed.planned.part, WINDOW as f64 * CELL_MM);
        let over = if share == held.worst { format!(" over {mm} x {mm} mm") } else { " on average, worst".to_owned() };
        let (what, remedy) = (kind.words(), kind.remedy(share));
        format!(
            "{what} of part {part} at Z {:.2} is {:.0} % full{over} at X {x:.1} Y {y:.1} (minimum {:.0} %{remedy})",
            level.z,
            share * 100.0,
            limit * 100.0
        )
    });
}
