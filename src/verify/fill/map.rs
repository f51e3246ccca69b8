//! One layer in square cells: where the part is, and how much plastic lies there.
//!
//! A line is spread evenly over as wide a strip as its plastic covers at the layer's height: its width comes from its filament and its
//! length alone. What a layer has in a square of whole cells is then exact to about a hundredth, wherever its lines run.

use crate::section::{PlanePoint, Segment};

/// Edge of a cell, mm: a third of a line and more are told apart.
pub(super) const CELL_MM: f64 = 0.25;
/// What lies around a part is kept for so many cells.
const RIM: i64 = 4;
/// Layers of more cells than this are not looked at: 600 x 600 mm.
const MOST_CELLS: usize = 6_000_000;
/// How far apart plastic is laid down, along a line and across, mm.
const SPREAD_MM: f64 = 0.2;
/// Strips of one line at most.
const MOST_STRIPS: f64 = 64.0;
/// And drops along it: longer lines than 2 m are none of a part's.
const MOST_STEPS: f64 = 1e4;

/// A rectangle of cells, counted from the machine's origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Frame {
    pub(super) low: [i64; 2],
    pub(super) size: [usize; 2],
}

impl Frame {
    /// Around all of `segments`; `None` for none, and where there would be too many cells.
    pub(super) fn around<'a>(segments: impl Iterator<Item = &'a Segment>) -> Option<Self> {
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for point in segments.flatten() {
            for axis in 0..2 {
                low[axis] = low[axis].min(point[axis]);
                high[axis] = high[axis].max(point[axis]);
            }
        }
        let cell = |mm: f64| (mm / CELL_MM).floor();
        let span = [0, 1].map(|axis| cell(high[axis]) - cell(low[axis]) + 1.0 + 2.0 * RIM as f64);
        let fits = span.iter().all(|n| n.is_finite()) && span[0] * span[1] <= MOST_CELLS as f64;
        fits.then(|| Self { low: low.map(|mm| cell(mm) as i64 - RIM), size: span.map(|n| n as usize) })
    }

    /// The place of a cell in a column of them, by row.
    pub(super) fn index(&self, [column, row]: [i64; 2]) -> Option<usize> {
        let [x, y] = [column - self.low[0], row - self.low[1]];
        let inside = x >= 0 && y >= 0 && (x as usize) < self.size[0] && (y as usize) < self.size[1];
        inside.then(|| y as usize * self.size[0] + x as usize)
    }

    /// The cell that holds a point.
    pub(super) fn cell(p: PlanePoint) -> [i64; 2] {
        p.map(|mm| (mm / CELL_MM).floor() as i64)
    }

    /// The middle of a square of `cells` whose lowest cell stands at `at`, counted from the frame's own lowest, mm.
    pub(super) fn middle(&self, at: [usize; 2], cells: usize) -> PlanePoint {
        [0, 1].map(|axis| (self.low[axis] as f64 + at[axis] as f64 + cells as f64 / 2.0) * CELL_MM)
    }
}

/// What is cut a little below a layer's middle, and a little above.
pub(super) const BELOW: u8 = 1;
pub(super) const ABOVE: u8 = 2;
/// Both.
pub(super) const SOLID: u8 = BELOW | ABOVE;

/// Where a part is in one layer: a face in the layer's middle is there for one of both cuts.
pub(super) struct Mask {
    pub(super) frame: Frame,
    pub(super) cells: Vec<u8>,
}

impl Mask {
    /// Of the two cuts; material lies to the left of each segment.
    pub(super) fn of(cuts: [&[Segment]; 2]) -> Option<Self> {
        let frame = Frame::around(cuts.iter().flat_map(|cut| cut.iter()))?;
        let mut cells = vec![0; frame.size[0] * frame.size[1]];
        for (cut, bit) in cuts.into_iter().zip([BELOW, ABOVE]) {
            fill(&frame, cut, bit, &mut cells);
        }
        Some(Self { frame, cells })
    }

    /// What is at a cell; nothing beyond the frame.
    pub(super) fn at(&self, cell: [i64; 2]) -> u8 {
        self.frame.index(cell).map_or(0, |index| self.cells[index])
    }

    /// Calls with each row that is not the same in another mask, and what that has in a column of it.
    pub(super) fn each_other_row(
        &self,
        other: Option<&Self>,
        mut visit: impl FnMut(usize, &[u8], &dyn Fn(usize) -> u8),
    ) {
        let shift = other.map_or(0, |other| self.frame.low[0] - other.frame.low[0]);
        let (before, from) = ((-shift).max(0) as usize, shift.max(0) as usize);
        for (row, here) in self.cells.chunks_exact(self.frame.size[0]).enumerate() {
            let there = other.map_or(&[][..], |other| other.row(self.frame.low[1] + row as i64));
            let there = there.get(from..).unwrap_or_default();
            let there = &there[..there.len().min(here.len().saturating_sub(before))];
            let beside = here.get(before..before + there.len()).unwrap_or_default();
            let empty = |cells: &[u8]| cells.iter().all(|cell| *cell == 0);
            let is_same = beside == there
                && empty(&here[..before.min(here.len())])
                && empty(here.get(before + there.len()..).unwrap_or_default());
            if !is_same {
                visit(row, here, &|column| {
                    column.checked_sub(before).and_then(|at| there.get(at)).copied().unwrap_or(0)
                });
            }
        }
    }

    /// The cells of a row, counted from the machine's origin; none beyond the frame.
    fn row(&self, row: i64) -> &[u8] {
        let columns = self.frame.size[0];
        let row = usize::try_from(row - self.frame.low[1]).ok().filter(|row| *row < self.frame.size[1]);
        row.map_or(&[], |row| &self.cells[row * columns..(row + 1) * columns])
    }
}

/// Sets `bit` in the cells whose middles the segments wind around.
fn fill(frame: &Frame, segments: &[Segment], bit: u8, cells: &mut [u8]) {
    let mut crossed: Vec<(u32, f64, i32)> = Vec::new();
    let row_of = |y: f64| (y / CELL_MM - 0.5).ceil() as i64 - frame.low[1];
    for &[a, b] in segments {
        let (low, high, up) = if a[1] < b[1] { (a, b, 1) } else { (b, a, -1) };
        for row in row_of(low[1]).max(0)..row_of(high[1]).min(frame.size[1] as i64) {
            let y = ((frame.low[1] + row) as f64 + 0.5) * CELL_MM;
            let x = low[0] + (high[0] - low[0]) * ((y - low[1]) / (high[1] - low[1]));
            crossed.push((row as u32, x, up));
        }
    }
    crossed.sort_unstable_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)));
    let column = |x: f64| ((x / CELL_MM - 0.5).ceil() as i64 - frame.low[0]).clamp(0, frame.size[0] as i64) as usize;
    for row in crossed.chunk_by(|a, b| a.0 == b.0) {
        let start = row[0].0 as usize * frame.size[0];
        let mut winding = 0;
        for pair in row.windows(2) {
            // Material lies to the right of what goes down.
            winding -= pair[0].2;
            if winding > 0 {
                cells[start + column(pair[0].1)..start + column(pair[1].1)].iter_mut().for_each(|cell| *cell |= bit);
            }
        }
    }
}

/// Plastic by cell, as a share of what fills it to the layer's height.
pub(super) struct Plastic {
    frame: Frame,
    pub(super) cells: Vec<f32>,
    height_mm: f64,
}

impl Plastic {
    pub(super) fn none(frame: Frame, height_mm: f64) -> Self {
        Self { frame, cells: vec![0.0; frame.size[0] * frame.size[1]], height_mm }
    }

    /// Lays a line of `mm3`.
    pub(super) fn lay(&mut self, [a, b]: Segment, mm3: f64) {
        let [dx, dy] = [b[0] - a[0], b[1] - a[1]];
        let length = dx.hypot(dy);
        let wide = if length > 0.0 { mm3 / length / self.height_mm } else { 0.0 };
        let strips = (wide / SPREAD_MM).ceil().clamp(1.0, MOST_STRIPS);
        let steps = (length / SPREAD_MM).ceil().clamp(1.0, MOST_STEPS);
        let across = if length > 0.0 { [-dy / length * wide, dx / length * wide] } else { [0.0; 2] };
        let each = (mm3 / (strips * steps * CELL_MM * CELL_MM * self.height_mm)) as f32;
        let low = self.frame.low;
        let cell = |p: PlanePoint, axis: usize| p[axis] / CELL_MM - 0.5 - low[axis] as f64;
        let step = [dx, dy].map(|mm| mm / CELL_MM / steps);
        for strip in 0..strips as usize {
            let side = (strip as f64 + 0.5) / strips - 0.5;
            let from = [a[0] + across[0] * side, a[1] + across[1] * side];
            let from = [0, 1].map(|axis| cell(from, axis));
            for along in 0..steps as usize {
                let along = along as f64 + 0.5;
                self.drop([from[0] + step[0] * along, from[1] + step[1] * along], each);
            }
        }
    }

    /// Shares a drop, its place counted in cells, among the four whose middles are around it.
    fn drop(&mut self, at: [f64; 2], amount: f32) {
        let [columns, rows] = self.frame.size;
        let inside = at[0] >= 0.0 && at[1] >= 0.0 && at[0] + 1.0 < columns as f64 && at[1] + 1.0 < rows as f64;
        if !inside {
            return;
        }
        let [column, row] = at.map(|v| v as usize);
        let [x, y] = [(at[0] - column as f64) as f32, (at[1] - row as f64) as f32];
        let (left, right) = (amount * (1.0 - x), amount * x);
        let (lower, upper) = self.cells[row * columns + column..].split_at_mut(columns);
        if let ([one, two, ..], [three, four, ..]) = (lower, upper) {
            *one += left * (1.0 - y);
            *two += right * (1.0 - y);
            *three += left * y;
            *four += right * y;
        }
    }

    pub(super) fn height_mm(&self) -> f64 {
        self.height_mm
    }

    /// The share at a point; 0 beyond the frame.
    pub(super) fn at(&self, p: PlanePoint) -> f64 {
        self.frame.index(Frame::cell(p)).map_or(0.0, |index| f64::from(self.cells[index]))
    }
}

/// Sums over squares of cells.
///
/// Four bytes a cell: values are counted in whole parts, and sums wrap around. The difference of two is right all the same, since no square of
/// cells holds as much as would wrap.
pub(super) struct Sums {
    columns: usize,
    sums: Vec<u32>,
    /// Of which one is made.
    parts: f64,
}

/// Parts of 1 in which shares are counted, and the most that one is taken for: far beyond what any layer holds, and squares of 1,000 cells
/// do not wrap.
const PARTS: f32 = 4096.0;
const MOST: f32 = 1000.0;

impl Sums {
    /// Of a share a cell, row by row; none is below 0.
    pub(super) fn of_shares(frame: &Frame, cells: &[f32]) -> Self {
        Self::of(frame, cells, f64::from(PARTS), |share| (share.min(MOST) * PARTS + 0.5) as u32)
    }

    /// Of the cells that are [`SOLID`].
    pub(super) fn of_solid(frame: &Frame, cells: &[u8]) -> Self {
        Self::of(frame, cells, 1.0, |cell| u32::from(cell == SOLID))
    }

    fn of<T: Copy>(frame: &Frame, cells: &[T], parts: f64, count: impl Fn(T) -> u32) -> Self {
        let columns = frame.size[0] + 1;
        let mut sums = vec![0_u32; columns * (frame.size[1] + 1)];
        for (row, cells) in cells.chunks_exact(frame.size[0]).enumerate() {
            let (before, here) = sums[row * columns..(row + 2) * columns].split_at_mut(columns);
            let mut sum = 0_u32;
            for ((cell, before), here) in cells.iter().zip(&before[1..]).zip(&mut here[1..]) {
                sum = sum.wrapping_add(count(*cell));
                *here = sum.wrapping_add(*before);
            }
        }
        Self { columns, sums, parts }
    }

    /// Over the square of `cells` whose lowest cell is `at`; it must lie within the frame.
    pub(super) fn square(&self, [column, row]: [usize; 2], cells: usize) -> f64 {
        let [low, high] = [row, row + cells].map(|row| row * self.columns + column);
        let upper = self.sums[high + cells].wrapping_sub(self.sums[high]);
        f64::from(upper.wrapping_sub(self.sums[low + cells].wrapping_sub(self.sums[low]))) / self.parts
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::SplitMix64;

    /// Against adding up cell by cell; the values wrap around many times.
    #[test]
    fn sums_of_squares_are_right_though_they_wrap() {
        let mut numbers = SplitMix64::seeded(3);
        let frame = Frame { low: [-3, 7], size: [90, 70] };
        let values: Vec<f32> = (0..frame.size[0] * frame.size[1]).map(|_| (900.0 * numbers.unit()) as f32).collect();
        let parts = f64::from(PARTS);
        assert!(values.iter().copied().map(f64::from).sum::<f64>() * parts > 2.0 * f64::from(u32::MAX));
        let sums = Sums::of_shares(&frame, &values);
        for _ in 0..500 {
            let cells = 1 + numbers.below(16);
            let at = [numbers.below(frame.size[0] - cells), numbers.below(frame.size[1] - cells)];
            let rows = at[1]..at[1] + cells;
            let row = |row: usize| &values[row * frame.size[0] + at[0]..][..cells];
            let of_row = |at: usize| -> f64 { row(at).iter().copied().map(f64::from).sum() };
            let wanted: f64 = rows.map(of_row).sum();
            let found = sums.square(at, cells);
            assert!((found - wanted).abs() <= 0.8 * (cells * cells) as f64 / parts, "{found} for {wanted}");
        }
    }
}
