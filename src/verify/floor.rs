//! How low anything may stand at each place to be of no concern to any move of a setup.
//!
//! A piece of the head whose underside lies `u` above the tip stays more than `near` mm away from all that stands lower than the
//! tip's lowest height plus `u - near`, taken over all places of the tip from which the piece, widened by `near`, reaches there.
//! What stands lower everywhere need not be rendered: of a large print hardly anything is left.

use super::hull::Hull;
use crate::geom::{Bounds, Vec3};

/// Edge of a cell, mm, and cells at most along one side.
const CELL_MM: f64 = 2.0;
const MOST_CELLS: f64 = 256.0;
/// Lines ask what carries them within so much sideways, and so much below the tip, mm.
const CARRIED_MM: [f64; 2] = [2.0, 4.0];
/// The piece that carries the tip is felt by what reaches its underside to within this, mm: far more than it may dip in.
const TOUCH_MM: f64 = 2.0;

/// Lowest heights of concern by cell.
pub(super) struct Floor {
    low: [f64; 2],
    cell: f64,
    count: [usize; 2],
    /// While it is built the lowest tip over each cell, then what concerns no one.
    z: Vec<f64>,
}

impl Floor {
    /// Nothing moves yet within `bounds`; beyond it nothing will.
    pub(super) fn new(bounds: &Bounds) -> Self {
        let size = [0, 1].map(|i| (bounds.max[i] - bounds.min[i]).max(0.0));
        let cell = CELL_MM.max(size[0].max(size[1]) / MOST_CELLS);
        let count = size.map(|s| (s / cell) as usize + 1);
        Self { low: [bounds.min.x, bounds.min.y], cell, count, z: vec![f64::INFINITY; count[0] * count[1]] }
    }

    /// The tip goes from one end to the other.
    pub(super) fn goes(&mut self, ends: [Vec3; 2]) {
        let z = ends[0].z.min(ends[1].z);
        let [columns, rows] = self.cells(ends, 0.0);
        for row in rows {
            for lowest in &mut self.z[row * self.count[0]..][columns.clone()] {
                *lowest = lowest.min(z);
            }
        }
    }

    /// From the tip's heights to what concerns neither a piece of `head` within `near` mm (the one that carries the tip only
    /// where it touches) nor a line that is laid.
    pub(super) fn settle(&mut self, head: &[Hull], near: f64) {
        let tips = turned(&std::mem::take(&mut self.z), self.count);
        let [side, below] = CARRIED_MM;
        self.z = self.spread(&tips, [Some([-side, side]); 2]).into_iter().map(|z| z - below).collect();
        for hull in head {
            let (bounds, follows, near) = (hull.bounds, hull.body.follows, if hull.tip { TOUCH_MM } else { near });
            let window = [0, 1].map(|i| follows[i].then(|| [bounds.min[i] - near, bounds.max[i] + near]));
            let spread = self.spread(&tips, window);
            let under = bounds.min.z - near;
            for (z, tip) in self.z.iter_mut().zip(spread) {
                // A piece that stays behind in Z is as low wherever the tip is, as long as it is anywhere.
                let at = if follows[2] || tip == f64::INFINITY { tip } else { 0.0 };
                *z = z.min(at + under);
            }
        }
    }

    /// What stands lower than this between `ends` and within `reach` of them is of no concern.
    pub(super) fn under(&self, ends: [Vec3; 2], reach: f64) -> f64 {
        let [columns, rows] = self.cells(ends, reach);
        rows.flat_map(|row| &self.z[row * self.count[0]..][columns.clone()])
            .fold(f64::INFINITY, |least, z| least.min(*z))
    }

    /// The columns and rows of the box of `ends`, widened by `reach`.
    fn cells(&self, ends: [Vec3; 2], reach: f64) -> [std::ops::RangeInclusive<usize>; 2] {
        [0, 1].map(|i| {
            let index = |v: f64| (((v - self.low[i]) / self.cell).max(0.0) as usize).min(self.count[i] - 1);
            index(ends[0][i].min(ends[1][i]) - reach)..=index(ends[0][i].max(ends[1][i]) + reach)
        })
    }

    /// For each cell the least of the tips over the cells from which a piece with this `window` (X and Y relative to the tip; `None`
    /// for all places) reaches it: axis by axis. `tips` come column by column.
    fn spread(&self, tips: &[f64], window: [Option<[f64; 2]>; 2]) -> Vec<f64> {
        let [columns, rows] = self.count;
        let [across, along] = window.map(|window| window.map(|ends| self.window(ends)));
        slid(&turned(&slid(tips, rows, across), [rows, columns]), columns, along)
    }

    /// In cells, each end rounded outward by the cell that the tip may be anywhere in.
    fn window(&self, [low, high]: [f64; 2]) -> [isize; 2] {
        [(low / self.cell).floor() as isize - 1, (high / self.cell).ceil() as isize + 1]
    }
}

/// Rows of so many columns, as columns.
fn turned(rows: &[f64], [columns, count]: [usize; 2]) -> Vec<f64> {
    (0..columns).flat_map(|column| (0..count).map(move |row| rows[row * columns + column])).collect()
}

/// For each line of `length` places, place by place, the least of those at its number less `window`; of all of them without one. Whole lines
/// are compared at a time: from each place to the end of its block of lines as many as the window has, and from the beginning of it; a window is the
/// end of one block and the beginning of the next (van Herk 1992, Gil and Werman 1993).
fn slid(lines: &[f64], length: usize, window: Option<[isize; 2]>) -> Vec<f64> {
    let count = lines.len() / length;
    let last = count as isize - 1;
    let [low, high] = window.unwrap_or([-last, last]);
    if low > last || high < -last {
        return vec![f64::INFINITY; lines.len()];
    }
    let (low, high) = (low.max(-last), high.min(last));
    let block = (high - low + 1) as usize;
    // Of a line of lines that begins `high` before the first one.
    let padded = count + block - 1;
    let line = |k: usize| {
        let at = k as isize - high;
        (0..=last).contains(&at).then(|| &lines[at as usize * length..][..length])
    };
    let place = |k: usize| k * length..(k + 1) * length;
    let mut onward = vec![f64::INFINITY; padded * length];
    let mut so_far = onward.clone();
    for k in (0..padded).rev() {
        if (k + 1) % block != 0 && k + 1 < padded {
            onward.copy_within(place(k + 1), k * length);
        }
        line(k).into_iter().for_each(|line| take_least(&mut onward[place(k)], line));
    }
    for k in 0..padded {
        if k % block != 0 {
            so_far.copy_within(place(k - 1), k * length);
        }
        line(k).into_iter().for_each(|line| take_least(&mut so_far[place(k)], line));
    }
    onward.truncate(lines.len());
    take_least(&mut onward, &so_far[(block - 1) * length..]);
    onward
}

fn take_least(least: &mut [f64], others: &[f64]) {
    least.iter_mut().zip(others).for_each(|(least, other)| *least = if other < least { *other } else { *least });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Body;

    #[test]
    fn what_stands_below_the_reach_of_every_piece_is_of_no_concern() {
        let bounds = Bounds::of([Vec3::new(-100.0, -100.0, 0.0), Vec3::new(100.0, 100.0, 100.0)]);
        let block = Body::cuboid("b", Vec3::new(-10.0, -5.0, 8.0), Vec3::new(20.0, 5.0, 30.0), [true; 3]);
        let beam = Body::cuboid("r", Vec3::new(-3.0, -100.0, 40.0), Vec3::new(3.0, 100.0, 60.0), [true, false, true]);
        let mut floor = Floor::new(&bounds);
        floor.goes([Vec3::new(0.0, 0.0, 10.0), Vec3::new(30.0, 0.0, 12.0)]);
        floor.settle(&[Hull::new(block, 0.4), Hull::new(beam, 0.4)], 2.0);
        let under = |x: f64, y: f64| floor.under([Vec3::new(x, y, 0.0); 2], 0.0);
        // Under the line itself: what carries it. Beside it the block, 8 above the tip and 2 near; then the beam; else nothing.
        assert_eq!(under(10.0, 0.0), 6.0);
        assert_eq!((under(48.0, 0.0), under(-11.0, -6.0)), (16.0, 16.0));
        assert_eq!((under(10.0, 90.0), under(34.0, -90.0)), (48.0, 48.0));
        assert_eq!((under(75.0, 0.0), under(-40.0, 50.0)), (f64::INFINITY, f64::INFINITY));
    }

    #[test]
    fn the_least_of_each_window_is_that_of_a_search() {
        let mut state = 7_u64;
        let mut next = |most: u64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) % most
        };
        for _ in 0..2000 {
            let [count, length] = [1 + next(12) as usize, 1 + next(3) as usize];
            let lines: Vec<f64> =
                (0..count * length).map(|_| if next(4) == 0 { f64::INFINITY } else { next(100) as f64 }).collect();
            let low = next(40) as isize - 20;
            let window = (next(8) > 0).then(|| [low, low + next(30) as isize]);
            let found = slid(&lines, length, window);
            for (i, least) in found.iter().enumerate() {
                let (line, place) = ((i / length) as isize, i % length);
                let is_in = |j: &usize| window.is_none_or(|[low, high]| (low..=high).contains(&(line - *j as isize)));
                let all = (0..count).filter(is_in).map(|j| lines[j * length + place]);
                assert_eq!(*least, all.fold(f64::INFINITY, f64::min), "{lines:?} {length} {window:?}, {i}");
            }
        }
    }
}
