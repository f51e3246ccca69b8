//! Surfaces are full.
//!
//! Every slicer closes what is seen from above and below: of a layer, all over which the part does not go on, all below which it does not
//! begin, and all of the first layer. A window of 2 x 2 mm in such a region, clear of its border, has about the plastic that fills it, and
//! all windows together have it more closely. What is too much is told by `crowd`.
//!
//! Shares of a layer that is full to its height; lengths in cells.

use super::super::prints::PrintedPart;
use super::super::report::Findings;
use super::map::CELL_MM;
use super::region::{Region, WINDOW};
use super::shells::{self, Side};
use super::{Around, Full, add, full_share};

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
    let (process, stated) = (&printed.job.profile.process, printed.flow.inside);
    let other = |full: Option<&Full<'_>>| Region::exposed(around, full.map(|full| &full.layer.mask));
    // Below the first layer there is nothing.
    if around.known.0
        && process.bottom_layers > 0
        && stated.bottoms != Some(0)
        && let Some(region) = other(around.below)
    {
        full(printed, around, if around.first { Kind::First } else { Kind::OverAir }, &region, findings);
        shells::check(printed, around, Side::Bottom, &region, findings);
    }
    if around.known.1
        && process.top_layers > 0
        && stated.tops != Some(0)
        && let Some(region) = other(around.above)
    {
        full(printed, around, Kind::Top, &region, findings);
        shells::check(printed, around, Side::Top, &region, findings);
    }
}

fn full(printed: &PrintedPart<'_>, around: &Around<'_>, kind: Kind, region: &Region<'_>, findings: &mut Findings) {
    let cells = (WINDOW * WINDOW) as f64 * full_share(printed);
    let mut least = Held::NOTHING;
    region.windows(|at| {
        let share = around.here.plastic.square(at, WINDOW) / cells;
        least.take(share, at);
    });
    let limits = if kind == Kind::OverAir { [OVER_AIR; 2] } else { LEAST };
    if let Some(short) = least.below(limits) {
        say(printed, around, kind, least, short, findings);
    }
}

/// A region that is not full: all of it, or its worst window.
fn say(
    printed: &PrintedPart<'_>,
    around: &Around<'_>,
    kind: Kind,
    held: Held,
    [share, limit]: [f64; 2],
    findings: &mut Findings,
) {
    let level = around.here.layer.level;
    add(printed, level.line, [share, limit], findings, || {
        let [x, y] = around.here.layer.mask.frame.middle(held.at, WINDOW);
        let (part, mm) = (printed.planned.part, WINDOW as f64 * CELL_MM);
        let over =
            if share == held.worst { format!(" over {mm} x {mm} mm") } else { " on average, emptiest".to_owned() };
        let (what, remedy) = (kind.words(), kind.remedy(share));
        format!(
            "{what} of part {part} at Z {:.2} is {:.0} % filled{over} at X {x:.1} Y {y:.1} (minimum {:.0} %{remedy})",
            level.z,
            share * 100.0,
            limit * 100.0
        )
    });
}
