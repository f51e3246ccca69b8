//! Infill is there at all.
//!
//! Where infill is stated and the part is wide enough for it, some lies below each top. Patterns that only hold tops, as lightning, leave the rest of
//! the interior empty, so that what is just below tops tells; where no top is flat, all of the interior must be empty to be told.

use std::collections::BTreeMap;

use super::super::prints::PrintedPart;
use super::super::report::Findings;
use super::sparse::{Column, EMPTY, FEWEST, HIGH_MM, SOLID_SHARE};
use super::{Told, add};

/// Tiles below tops that are asked at least, and the part of them that is empty where there is no infill.
const FEWEST_BELOW_TOPS: usize = 3;
const NEARLY_ALL_BELOW: f64 = 0.9;
/// Tiles of the interior that are asked where no top is flat, and the part of them that is empty.
const FEWEST_INSIDE: usize = 50;
const NEARLY_ALL: f64 = 0.995;

pub(super) fn check(
    printed: &PrintedPart<'_>,
    told: &[Told],
    columns: &BTreeMap<[i32; 2], Column>,
    findings: &mut Findings,
) {
    let stated = printed.flow.inside.infill.unwrap_or(true);
    if !stated || printed.job.profile.process.infill <= 0.0 {
        return;
    }
    let inside = Empty::of(columns.values().flatten().filter(|share| **share < SOLID_SHARE).copied());
    let below = Empty::of(columns.values().flat_map(|column| below_tops(told, column)));
    let (asked, fewest, most, place) = match below.all >= FEWEST_BELOW_TOPS {
        true => (below, FEWEST_BELOW_TOPS, NEARLY_ALL_BELOW, "the volume below its tops"),
        false => (inside, FEWEST_INSIDE, NEARLY_ALL, "its interior"),
    };
    if asked.all < fewest || asked.share() < most {
        return;
    }
    let is_sparse = |layer: &&Told| layer.tiles.iter().any(|tile| tile.share < SOLID_SHARE);
    let Some(layer) = told.iter().find(is_sparse) else { return };
    add(printed, layer.line, [asked.share(), most], findings, || {
        format!(
            "part {} has no infill from Z {:.2} on: {:.0} % of {place} is empty (maximum {:.0} %; for prints without infill set [process] infill = 0)",
            printed.planned.part,
            layer.z,
            asked.share() * 100.0,
            most * 100.0
        )
    });
}

/// Tiles, and those of them that are empty.
struct Empty {
    all: usize,
    empty: usize,
}

impl Empty {
    fn of(shares: impl Iterator<Item = f32>) -> Self {
        shares.fold(Self { all: 0, empty: 0 }, |sum, share| Self {
            all: sum.all + 1,
            empty: sum.empty + usize::from(share < EMPTY),
        })
    }

    /// The empty part; 0 of nothing.
    fn share(&self) -> f64 {
        self.empty as f64 / self.all.max(1) as f64
    }
}

/// What a column holds just below each of its tops, over as many layers as infill is laid at once.
fn below_tops(told: &[Told], column: &Column) -> Vec<f32> {
    let is_sparse = |share: &f32| *share < SOLID_SHARE;
    let tops = (1..column.len()).filter(|&index| column[index] >= SOLID_SHARE && is_sparse(&column[index - 1]));
    let below = tops.filter_map(|index| {
        let count = ((HIGH_MM / told[index].height.max(0.01)).ceil() as usize).max(FEWEST);
        let span = column.get(index.checked_sub(count)?..index)?;
        span.iter().all(is_sparse).then(|| span.iter().sum::<f32>() / count as f32)
    });
    below.collect()
}
