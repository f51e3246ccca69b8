//! A height field with a pyramid of maxima: how high anything stands, from above, at one pose.
//!
//! A cell holds an upper bound of everything that touches it. Level `k + 1` holds the maxima of `4 x 4` cells of level
//! `k`, so that "does anything under this rectangle stand higher than .." is answered from coarse to fine.

use super::hull::Hull;

/// The finest cell, mm: a little over half a line. The planner keeps room for it.
const FINEST_MM: f64 = crate::planning::CELL_MM;
/// Cells at most; a greater region gets greater cells.
const MOST_CELLS: f64 = 4e6;
/// Cells along one side of a coarser cell.
const FAN: usize = 4;
/// What rounding to 32 bits may take off a height below 1 m, mm.
const ROUNDING: f64 = 1e-4;

/// A rectangle in machine X and Y, mm.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rect {
    pub(super) min: [f64; 2],
    pub(super) max: [f64; 2],
}

struct Level {
    columns: usize,
    rows: usize,
    cell: f64,
    top: Vec<f32>,
}

/// Heights over a rectangle; nothing stands outside it.
pub(super) struct Field {
    origin: [f64; 2],
    levels: Vec<Level>,
    /// The finest level as it was when [`Field::settle`] was called.
    earlier: Vec<f32>,
}

impl Field {
    /// An empty field over `region`.
    pub(super) fn new(region: &Rect) -> Self {
        let size = [0, 1].map(|i| (region.max[i] - region.min[i]).max(FINEST_MM));
        let mut cell = (size[0] * size[1] / MOST_CELLS).sqrt().max(FINEST_MM);
        let mut count = size.map(|s| (s / cell).ceil() as usize + 1);
        let mut levels = Vec::new();
        loop {
            let [columns, rows] = count;
            levels.push(Level { columns, rows, cell, top: vec![f32::NEG_INFINITY; columns * rows] });
            if columns * rows == 1 {
                break;
            }
            count = count.map(|n| n.div_ceil(FAN));
            cell *= FAN as f64;
        }
        Self { origin: region.min, levels, earlier: Vec::new() }
    }

    /// Half of a cell's diagonal, mm: nothing in a cell is farther from its centre.
    pub(super) fn reach(&self) -> f64 {
        self.levels[0].cell * std::f64::consts::FRAC_1_SQRT_2
    }

    /// The highest height of all; minus infinity for an empty field.
    pub(super) fn highest(&self) -> f64 {
        self.levels.last().map_or(f64::NEG_INFINITY, |l| f64::from(l.top[0]))
    }

    /// Takes what stands now as made earlier.
    pub(super) fn settle(&mut self) {
        self.earlier = self.levels[0].top.clone();
    }

    /// What cell `(x, y)` of the finest level holds.
    pub(super) fn top(&self, x: usize, y: usize) -> f64 {
        f64::from(self.levels[0].top[y * self.levels[0].columns + x])
    }

    /// Raises cell `(x, y)` of the finest level to `height`, and what lies above it in the pyramid.
    pub(super) fn raise(&mut self, x: usize, y: usize, height: f64) {
        let height = (height + ROUNDING) as f32;
        let (mut x, mut y) = (x, y);
        for level in &mut self.levels {
            let top = &mut level.top[y * level.columns + x];
            if *top >= height {
                return;
            }
            *top = height;
            (x, y) = (x / FAN, y / FAN);
        }
    }

    /// Calls `visit(field, column, row, centre)` for the cells whose centre may lie within `reach` of the segment from
    /// `a` to `b`: row by row, the cells of the slanted band and few more.
    pub(super) fn along(
        &mut self,
        [a, b]: [[f64; 2]; 2],
        reach: f64,
        mut visit: impl FnMut(&mut Self, usize, usize, [f64; 2]),
    ) {
        let (cell, columns, rows) = (self.levels[0].cell, self.levels[0].columns, self.levels[0].rows);
        let index = |v: f64, axis: usize, most: usize| {
            (((v - self.origin[axis]) / cell).floor().max(0.0) as usize).min(most - 1)
        };
        let low = index(a[1].min(b[1]) - reach, 1, rows);
        let high = index(a[1].max(b[1]) + reach, 1, rows);
        for row in low..=high {
            let y = self.origin[1] + (row as f64 + 0.5) * cell;
            let [left, right] = crossing(a, b, [y - reach, y + reach]);
            let first = (((left - reach - self.origin[0]) / cell).floor().max(0.0) as usize).min(columns - 1);
            let last = (((right + reach - self.origin[0]) / cell).floor().max(0.0) as usize).min(columns - 1);
            for column in first..=last {
                let x = self.origin[0] + (column as f64 + 0.5) * cell;
                visit(self, column, row, [x, y]);
            }
        }
    }

    /// Whether anything within `reach` (a square) of `at` stands at `height` or higher, or stood at `earlier_height` or
    /// higher before this setup.
    pub(super) fn stands(&self, at: [f64; 2], reach: f64, height: f64, earlier_height: f64) -> bool {
        let level = &self.levels[0];
        let index = |v: f64, axis: usize| ((v - self.origin[axis]) / level.cell).floor();
        let holds = |i: usize| f64::from(level.top[i]) >= height || f64::from(self.earlier[i]) >= earlier_height;
        let limit = [level.columns, level.rows];
        let clamp = |v: f64, axis: usize| (v.max(0.0) as usize).min(limit[axis] - 1);
        let middle = [0, 1].map(|i| clamp(index(at[i], i), i));
        if holds(middle[1] * level.columns + middle[0]) {
            return true;
        }
        let [x, y] = [0, 1].map(|i| clamp(index(at[i] - reach, i), i)..=clamp(index(at[i] + reach, i), i));
        y.into_iter().any(|row| x.clone().any(|column| holds(row * level.columns + column)))
    }

    /// A lower bound of the vertical room (mm) between `hull`, its origin anywhere in `origins` at height `z`, and what
    /// stands below it; rooms of `cap` and more are not told apart.
    ///
    /// Sound: for a cell, the underside is at least the greatest of its supporting planes' least values over all
    /// offsets from origin to cell.
    pub(super) fn room(&self, hull: &Hull, origins: &Rect, z: f64, cap: f64) -> f64 {
        let mut best = cap;
        let bounds = [[hull.bounds.min.x, hull.bounds.max.x], [hull.bounds.min.y, hull.bounds.max.y]];
        let reach = [0, 1].map(|i| [origins.min[i] + bounds[i][0], origins.max[i] + bounds[i][1]]);
        self.descend(
            self.levels.len() - 1,
            [0, 0],
            &Probe { hull, origins, reach, z, lowest: z + hull.bounds.min.z },
            &mut best,
        );
        best
    }

    fn descend(&self, depth: usize, [x, y]: [usize; 2], probe: &Probe<'_>, best: &mut f64) {
        let level = &self.levels[depth];
        let top = f64::from(level.top[y * level.columns + x]);
        if probe.lowest - top >= *best {
            return;
        }
        let min = [self.origin[0] + x as f64 * level.cell, self.origin[1] + y as f64 * level.cell];
        let Some(under) = probe.underside(&Rect { min, max: min.map(|v| v + level.cell) }) else { return };
        let room = under - top;
        if room >= *best {
            return;
        }
        if depth == 0 {
            *best = room;
            return;
        }
        let finer = &self.levels[depth - 1];
        let range = |axis: usize, at: usize, most: usize| {
            let index = |v: f64| ((v - self.origin[axis]) / finer.cell).floor().max(0.0) as usize;
            let first = (at * FAN).max(index(probe.reach[axis][0]));
            first..(at * FAN + FAN).min(most).min(index(probe.reach[axis][1]) + 1)
        };
        let columns = range(0, x, finer.columns);
        for row in range(1, y, finer.rows) {
            columns.clone().for_each(|column| self.descend(depth - 1, [column, row], probe, best));
        }
    }
}

struct Probe<'a> {
    hull: &'a Hull,
    origins: &'a Rect,
    /// Where the hull may be, along X and Y.
    reach: [[f64; 2]; 2],
    z: f64,
    lowest: f64,
}

impl Probe<'_> {
    /// A lower bound of the underside over `cell`; `None` where the hull is not above it.
    fn underside(&self, cell: &Rect) -> Option<f64> {
        let low = [0, 1].map(|i| cell.min[i] - self.origins.max[i]);
        let high = [0, 1].map(|i| cell.max[i] - self.origins.min[i]);
        let least =
            |a: f64, b: f64| a * if a > 0.0 { low[0] } else { high[0] } + b * if b > 0.0 { low[1] } else { high[1] };
        if self.hull.outline.iter().any(|&[x, y, c]| least(x, y) > c) {
            return None;
        }
        Some(self.z + self.hull.under.iter().map(|&[a, b, c]| least(a, b) + c).fold(f64::NEG_INFINITY, f64::max))
    }
}

/// Where the segment from `a` to `b` runs in X while its Y lies within `band`; both ends' X where it never does.
fn crossing(a: [f64; 2], b: [f64; 2], band: [f64; 2]) -> [f64; 2] {
    let rise = b[1] - a[1];
    let (mut from, mut to) = (0.0f64, 1.0f64);
    if rise.abs() > 1e-9 {
        let [s, t] = band.map(|y| (y - a[1]) / rise);
        from = from.max(s.min(t));
        to = to.min(s.max(t));
    }
    if from > to {
        return [a[0].min(b[0]), a[0].max(b[0])];
    }
    let [p, q] = [from, to].map(|t| a[0] + (b[0] - a[0]) * t);
    [p.min(q), p.max(q)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::{Body, Vec3};

    fn field() -> Field {
        let mut field = Field::new(&Rect { min: [-20.0, -20.0], max: [20.0, 20.0] });
        // A post 2 mm wide and 30 high about (10, 0).
        field.along([[10.0, -1.0], [10.0, 1.0]], 1.0, |f, x, y, _| f.raise(x, y, 30.0));
        field
    }

    fn at(x: f64, y: f64) -> Rect {
        Rect { min: [x, y], max: [x, y] }
    }

    #[test]
    fn room_over_beside_and_against_a_post() {
        let block =
            Hull::new(Body::cuboid("b", Vec3::new(-5.0, -5.0, 10.0), Vec3::new(5.0, 5.0, 60.0), [true; 3]), 0.4);
        let field = field();
        assert_eq!(field.room(&block, &at(-10.0, 0.0), 1.0, 50.0), 50.0);
        let over = field.room(&block, &at(8.0, 0.0), 25.0, 50.0);
        assert!((over - 5.0).abs() < 1e-3, "{over}");
        assert!(field.room(&block, &at(5.0, 0.0), 1.0, 50.0) < -18.0);
        let swept = Rect { min: [-15.0, 0.0], max: [8.0, 0.0] };
        assert!(field.room(&block, &swept, 1.0, 50.0) < -18.0);
    }

    #[test]
    fn what_stands_is_seen_within_reach_only() {
        let mut field = field();
        assert_eq!(field.highest() as f32, 30.0 + ROUNDING as f32);
        field.settle();
        assert!(field.stands([10.0, 0.0], 0.2, 29.0, 99.0));
        assert!(field.stands([11.5, 0.0], 1.0, 29.0, 99.0));
        assert!(!field.stands([13.0, 0.0], 1.0, 29.0, 99.0));
        assert!(field.stands([10.0, 0.0], 0.2, 99.0, 29.0));
        assert!(!field.stands([10.0, 0.0], 0.2, 31.0, 31.0));
    }

    #[test]
    fn a_crossing_holds_the_part_in_the_band() {
        assert_eq!(crossing([0.0, 0.0], [10.0, 10.0], [4.0, 6.0]), [4.0, 6.0]);
        assert_eq!(crossing([10.0, 0.0], [0.0, 10.0], [4.0, 6.0]), [4.0, 6.0]);
        assert_eq!(crossing([3.0, 5.0], [1.0, 5.0], [4.0, 6.0]), [1.0, 3.0]);
    }
}
