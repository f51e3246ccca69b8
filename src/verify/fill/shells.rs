//! Surfaces are more than one layer thick where the settings want three or more.
//!
//! What lies below a top surface, and above a bottom one, is full too, as far as it is within the part. Shares of a layer that is full to its height.

use super::super::prints::PrintedPart;
use super::super::report::Findings;
use super::region::{CLEAR, OUTER, Region, WINDOW};
use super::{Around, add, full_share};

/// So many solid layers must be stated: of fewer, slicers may lay one where they count by height.
const FEWEST: u32 = 3;
/// What the second layer holds at least, all windows together, and how many windows tell.
const LEAST: f64 = 0.6;
const SEVERAL: usize = 50;

/// Which side a surface is seen from.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Side {
    Top,
    Bottom,
}

/// The layer behind a surface.
pub(super) fn check(
    printed: &PrintedPart<'_>,
    around: &Around<'_>,
    side: Side,
    region: &Region<'_>,
    findings: &mut Findings,
) {
    let (process, stated) = (&printed.job.profile.process, printed.flow.inside);
    let (wanted, claimed, behind, place) = match side {
        Side::Top => (process.top_layers, stated.tops, around.below, "below"),
        Side::Bottom => (process.bottom_layers, stated.bottoms, around.above, "above"),
    };
    let Some(behind) = behind.filter(|_| wanted >= FEWEST && claimed.is_none_or(|count| count >= FEWEST)) else {
        return;
    };
    let frame = around.here.layer.mask.frame;
    let (mut count, mut sum) = (0_usize, 0.0);
    region.windows(|at| {
        let low = [0, 1].map(|axis| frame.low[axis] + at[axis] as i64 - CLEAR as i64);
        if let Some(at) = behind.inside(low, OUTER) {
            count += 1;
            sum += behind.plastic.square(at.map(|v| v + CLEAR), WINDOW);
        }
    });
    let share = sum / (count.max(1) * WINDOW * WINDOW) as f64 / full_share(printed);
    if count < SEVERAL || share >= LEAST {
        return;
    }
    let level = around.here.layer.level;
    add(printed, level.line, [share, LEAST], findings, || {
        let key = if side == Side::Top { "top_layers" } else { "bottom_layers" };
        format!(
            "the layer {place} a surface of part {} at Z {:.2} is {:.0} % full (minimum {:.0} %; for surfaces of one layer set [process] {key} = 1)",
            printed.planned.part,
            level.z,
            share * 100.0,
            LEAST * 100.0
        )
    });
}
