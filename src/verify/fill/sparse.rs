//! Sparse infill goes on: where there is some below and above, there is some between.
//!
//! Patterns change from layer to layer, and slicers lay infill of several layers at once or only where a top needs it. So what is compared
//! is what several layers hold together over a large area, with as many below and above at the same place; infill that begins to hold a top
//! does not stop before it.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use super::super::prints::PrintedPart;
use super::super::report::Findings;

use super::map::CELL_MM;
use super::{Around, Told, add};

/// A tile's edge and how far the part goes on around it, in cells: clear of walls.
const TILE: usize = 16;
const CLEAR: usize = 10;
/// Tiles are looked at together by squares of so many, and all at once.
const GROUP: i32 = 5;
/// Layers that are compared reach so high, mm, and are so many: more than infill is laid at once.
pub(super) const HIGH_MM: f64 = 0.8;
pub(super) const FEWEST: usize = 4;
/// Fuller tiles are solid.
pub(super) const SOLID_SHARE: f32 = 0.7;
/// What less is missing.
const LEAST: f64 = 0.25;
/// Line that is expected, mm: of less nothing is said.
const TELLING_MM: f64 = 100.0;
/// A line's width where it is asked how long it is, mm.
const LINE_MM: f64 = 0.4;
/// Tiles with less are empty.
pub(super) const EMPTY: f32 = 0.01;
/// Where more of a print's interior is empty than this, it is meant to be.
const MOSTLY_EMPTY: f64 = 0.5;

/// The plastic of a square within the part, clear of its walls and surfaces.
#[derive(Clone, Copy)]
pub(super) struct Tile {
    at: [i32; 2],
    pub(super) share: f32,
}

/// The layer's tiles.
pub(super) fn tiles(around: &Around<'_>) -> Vec<Tile> {
    let (frame, outer) = (around.here.layer.mask.frame, TILE + 2 * CLEAR);
    let (Some(below), Some(above)) = (around.below, around.above) else { return Vec::new() };
    let first = |axis: usize| frame.low[axis].div_euclid(TILE as i64) as i32;
    let last = |axis: usize| (frame.low[axis] + frame.size[axis] as i64).div_euclid(TILE as i64) as i32;
    let mut found = Vec::new();
    for row in first(1)..=last(1) {
        for column in first(0)..=last(0) {
            let low = [column, row].map(|v| i64::from(v) * TILE as i64 - CLEAR as i64);
            let inside = |full: &super::Full<'_>| full.inside(low, outer);
            if let (Some(at), Some(_), Some(_)) = (inside(around.here), inside(below), inside(above)) {
                let sum = around.here.plastic.square(at.map(|v| v + CLEAR), TILE);
                found.push(Tile { at: [column, row], share: (sum / (TILE * TILE) as f64) as f32 });
            }
        }
    }
    found
}

/// A tile's shares by layer; not a number where the tile is not within the part.
pub(super) type Column = Vec<f32>;

/// The tiles of all layers, by their places.
pub(super) fn columns(told: &[Told]) -> BTreeMap<[i32; 2], Column> {
    let mut columns: BTreeMap<[i32; 2], Column> = BTreeMap::new();
    for (index, layer) in told.iter().enumerate() {
        for tile in &layer.tiles {
            columns.entry(tile.at).or_insert_with(|| vec![f32::NAN; told.len()])[index] = tile.share;
        }
    }
    columns
}

pub(super) fn check(
    printed: &PrintedPart<'_>,
    told: &[Told],
    columns: &BTreeMap<[i32; 2], Column>,
    findings: &mut Findings,
) {
    let sparse = || columns.values().flatten().filter(|share| **share < SOLID_SHARE);
    let empty = sparse().filter(|share| **share < EMPTY).count();
    if empty as f64 > MOSTLY_EMPTY * sparse().count() as f64 {
        return;
    }
    let mut groups: BTreeMap<Option<[i32; 2]>, Vec<&Column>> = BTreeMap::new();
    for (at, column) in columns {
        groups.entry(Some(at.map(|v| v.div_euclid(GROUP)))).or_default().push(column);
        groups.entry(None).or_default().push(column);
    }
    let mut said = BTreeSet::new();
    for columns in groups.values() {
        stops(printed, told, columns, &mut said, findings);
    }
}

/// Layers of which a group of tiles has next to nothing.
fn stops(
    printed: &PrintedPart<'_>,
    told: &[Told],
    columns: &[&Column],
    said: &mut BTreeSet<usize>,
    findings: &mut Findings,
) {
    let mut index = 0;
    while index < told.len() {
        let count = ((HIGH_MM / told[index].height.max(0.01)).ceil() as usize).max(FEWEST);
        let Some(stop) = Stop::at(columns, index, count) else {
            index += 1;
            continue;
        };
        if said.insert(index) {
            let (from, to) = (&told[index], &told[stop.end - 1]);
            add(printed, from.line, [stop.there, stop.beside], findings, || {
                format!(
                    "the infill of part {} is interrupted from Z {:.2} to Z {:.2}: {:.1} % filled, {:.1} % above and below (minimum {:.0} % of the latter)",
                    printed.planned.part,
                    from.z,
                    to.z,
                    stop.there * 100.0,
                    stop.beside * 100.0,
                    LEAST * 100.0
                )
            });
        }
        index = stop.end;
    }
}

/// Layers without infill: up to which, what they hold, and what is beside them.
struct Stop {
    end: usize,
    there: f64,
    beside: f64,
}

impl Stop {
    /// The one that begins at `index`; `count` layers tell what is usual.
    fn at(columns: &[&Column], index: usize, count: usize) -> Option<Self> {
        let low = index.checked_sub(count)?;
        // Whatever is solid below is no infill.
        let within = |column: &&&Column, to: usize| {
            let span = column.get(low..to);
            span.is_some_and(|span| span.iter().all(|v| !v.is_nan()))
                && column[low..index].iter().all(|share| *share < SOLID_SHARE)
        };
        let first: Vec<&Column> = columns.iter().filter(|column| within(column, index + count)).copied().collect();
        let below = mean(&first, low..index)?;
        let is_missing = |columns: &[&Column], end: usize| {
            mean(columns, end - count..end).is_some_and(|share| share < LEAST * below)
        };
        if !tells(first.len(), count, below) || !is_missing(&first, index + count) {
            return None;
        }
        let mut end = index + count;
        while is_missing(&first, end + 1) {
            end += 1;
        }
        let all: Vec<&Column> = first.iter().filter(|column| within(column, end + count)).copied().collect();
        let beside = mean(&all, low..index)?.min(mean(&all, end..end + count)?);
        let there = mean(&all, index..end)?;
        (tells(all.len(), count, beside) && there < LEAST * beside).then_some(Self { end, there, beside })
    }
}

/// Whether so many tiles of so many layers hold enough line to tell.
fn tells(tiles: usize, layers: usize, share: f64) -> bool {
    let area_mm2 = (TILE * TILE) as f64 * CELL_MM * CELL_MM * (tiles * layers) as f64;
    share * area_mm2 / LINE_MM >= TELLING_MM
}

/// The mean share of some layers; `None` where there are none, or a tile is not within the part in all of them.
fn mean(columns: &[&Column], layers: Range<usize>) -> Option<f64> {
    let count = columns.len() * layers.len();
    let sum = columns.iter().map(|column| {
        let span = column.get(layers.clone())?;
        Some(span.iter().map(|share| f64::from(*share)).sum::<f64>())
    });
    let mean = sum.sum::<Option<f64>>()? / count as f64;
    mean.is_finite().then_some(mean)
}
