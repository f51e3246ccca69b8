//! A roof: lines at a pitch of their own, in the last layers below what is held, so that its first layer spans less.
//!
//! Slot frame, mm. All lines run along x on one lattice, so that those of successive layers lie on each other. One is laid where the next
//! layers above the gap hold something of the part over it, and where it rests on what was laid in the layer below: from the first such
//! place to the last, with no more than [`FARTHEST_STEPS`] between two of them.

use super::spans::{Line, SHORTEST_WIDTHS, where_above};
use crate::section::{PlanePoint, Segments};

/// How a roof is laid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Roof {
    /// How many layers it has.
    pub layers: usize,
    /// Distance between its lines, mm.
    pub pitch_mm: f64,
}

/// A line may be free between two places on which it rests over so many steps of the grid.
const FARTHEST_STEPS: f64 = 1.5;
/// And beyond the last of them by so many.
const BEYOND_STEPS: f64 = 0.4;
/// As far from a line below, in widths, a line still lies on it.
const ON: f64 = 0.5;
/// Lines below are looked for as far, mm.
const FAR_MM: f64 = 2.0;

/// Where a roof may lie, seen from above.
pub(super) struct Under<'a> {
    /// From where to where along x, and along y.
    pub(super) cells: &'a [[[f64; 2]; 2]],
    /// What was laid in the layer below.
    pub(super) below: &'a Segments,
    /// Width of a line, mm.
    pub(super) line_mm: f64,
    /// Edge of a cell of the grid, mm.
    pub(super) step_mm: f64,
}

impl Roof {
    /// A layer's lines; `room` says how far a place is from where no roof is wanted or possible, below 0 there.
    pub(super) fn lines(&self, under: &Under<'_>, room: &dyn Fn(PlanePoint) -> f64) -> Vec<Line> {
        let ends = under.cells.iter().flat_map(|[_, y]| *y);
        let [low, high] = ends.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], y| [low.min(y), high.max(y)]);
        let [first, last] = [low, high].map(|y| (y / self.pitch_mm).floor());
        if !(last - first).is_finite() {
            return Vec::new();
        }
        let rows = (0..=(last - first) as usize).map(|row| (first + row as f64 + 0.5) * self.pitch_mm);
        rows.flat_map(|y| under.row(y, room)).collect()
    }
}

impl Under<'_> {
    /// The lines of one row.
    fn row(&self, y: f64, room: &dyn Fn(PlanePoint) -> f64) -> Vec<Line> {
        let mut ways: Vec<[f64; 2]> =
            self.cells.iter().filter(|[_, [low, high]]| (*low..*high).contains(&y)).map(|[x, _]| *x).collect();
        ways.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let mut joined: Vec<[f64; 2]> = Vec::new();
        for [from, to] in ways {
            match joined.last_mut() {
                Some(last) if from <= last[1] => last[1] = last[1].max(to),
                _ => joined.push([from, to]),
            }
        }
        let mut lines = Vec::new();
        for [x, end] in joined {
            for [from, to] in where_above([[x, y], [end, y]], room) {
                let pieces = self.resting([x + from, x + to], y);
                lines.extend(pieces.into_iter().map(|span| span.map(|x| [x, y])));
            }
        }
        lines
    }

    /// What of a free span rests on the layer below.
    fn resting(&self, [low, high]: [f64; 2], y: f64) -> Vec<[f64; 2]> {
        let on = |p: PlanePoint| {
            let nearest = self.below.nearest(p, FAR_MM, None).map_or(FAR_MM, |nearest| nearest.distance);
            ON * self.line_mm - nearest
        };
        let mut pieces: Vec<[f64; 2]> = Vec::new();
        for [from, to] in where_above([[low, y], [high, y]], on).into_iter().map(|span| span.map(|t| low + t)) {
            match pieces.last_mut() {
                Some(last) if from - last[1] <= FARTHEST_STEPS * self.step_mm => last[1] = to,
                _ => pieces.push([from, to]),
            }
        }
        let beyond = BEYOND_STEPS * self.step_mm;
        let whole = pieces.into_iter().map(|[from, to]| [(from - beyond).max(low), (to + beyond).min(high)]);
        whole.filter(|[from, to]| to - from >= SHORTEST_WIDTHS * self.line_mm).collect()
    }
}
