//! Regions of a layer that are surfaces, and the windows that lie in them.

use super::Around;
use super::map::{Mask, SOLID, Sums};

/// A window's edge, in cells, and how far it stays clear of the region's border.
pub(super) const WINDOW: usize = 8;
pub(super) const CLEAR: usize = 2;
pub(super) const OUTER: usize = WINDOW + 2 * CLEAR;

/// Cells of a layer, and what they lie within: the lowest and the highest column and row.
pub(super) struct Region<'a> {
    sums: Sums,
    around: &'a Around<'a>,
    low: [usize; 2],
    high: [usize; 2],
}

impl<'a> Region<'a> {
    /// Cells of the layer that the other one has not; `None` where they hold no window.
    pub(super) fn exposed(around: &'a Around<'a>, other: Option<&Mask>) -> Option<Self> {
        let mask = &around.here.layer.mask;
        let columns = mask.frame.size[0];
        let (mut cells, mut count) = (Vec::new(), 0);
        let (mut low, mut high) = ([usize::MAX; 2], [0; 2]);
        mask.each_other_row(other, |row, here, there| {
            if cells.is_empty() {
                cells = vec![0_u8; mask.cells.len()];
            }
            for (column, here) in here.iter().enumerate().filter(|(_, here)| **here == SOLID) {
                if there(column) == 0 {
                    cells[row * columns + column] = *here;
                    count += 1;
                    low = [low[0].min(column), low[1].min(row)];
                    high = [high[0].max(column), high[1].max(row)];
                }
            }
        });
        let holds = count >= OUTER * OUTER;
        holds.then(|| Self { sums: Sums::of_solid(&mask.frame, &cells), around, low, high })
    }

    /// Visits windows that lie in the region, clear of its border: each by its lowest cell.
    pub(super) fn windows(&self, mut visit: impl FnMut([usize; 2])) {
        let size = self.around.here.layer.mask.frame.size;
        let all = (OUTER * OUTER) as f64 - 0.5;
        let places = |axis: usize| {
            let end = size[axis].min(self.high[axis] + 2).saturating_sub(OUTER);
            (self.low[axis].next_multiple_of(2)..end).step_by(2)
        };
        for row in places(1) {
            for column in places(0) {
                if self.sums.square([column, row], OUTER) > all {
                    visit([column + CLEAR, row + CLEAR]);
                }
            }
        }
    }
}
