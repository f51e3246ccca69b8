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
    /// What supports laid since reach there; empty where there are none.
    held: Vec<f32>,
    /// Which body reaches highest of what was laid since; empty where nobody asks.
    bodies: Vec<Highest>,
}

/// The highest of what was laid over a cell, by body.
#[derive(Clone, Copy)]
struct Highest {
    body: u32,
    top: f32,
    /// Of all other bodies.
    others: f32,
}

impl Highest {
    const NONE: Self = Self { body: u32::MAX, top: f32::NEG_INFINITY, others: f32::NEG_INFINITY };

    fn lay(&mut self, body: u32, height: f32) {
        if body == self.body {
            self.top = self.top.max(height);
        } else if height > self.top {
            *self = Self { body, top: height, others: self.top };
        } else {
            self.others = self.others.max(height);
        }
    }

    /// Of all bodies but this.
    fn but(&self, body: u32) -> f64 {
        f64::from(if body == self.body { self.others } else { self.top })
    }
}

/// How high something must be to lie below a line.
#[derive(Clone, Copy, Debug)]
pub(super) struct Below {
    /// Whatever it is.
    pub(super) height: f64,
    /// What was there before this setup.
    pub(super) earlier: f64,
    /// What was laid in it.
    pub(super) laid: f64,
    /// A support.
    pub(super) held: f64,
    /// Another body than this one.
    pub(super) other: Option<(u32, f64)>,
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
        Self { origin: region.min, levels, earlier: Vec::new(), held: Vec::new(), bodies: Vec::new() }
    }

    /// Half of a cell's diagonal, mm: nothing in a cell is farther from its centre.
    pub(super) fn reach(&self) -> f64 {
        self.levels[0].cell * std::f64::consts::FRAC_1_SQRT_2
    }

    /// The highest height of all; minus infinity for an empty field.
    pub(super) fn highest(&self) -> f64 {
        self.levels.last().map_or(f64::NEG_INFINITY, |l| f64::from(l.top[0]))
    }

    /// Takes what was rendered as made earlier.
    pub(super) fn settle(&mut self) {
        for depth in 1..self.levels.len() {
            let (finer, coarser) = self.levels.split_at_mut(depth);
            let (finer, coarser) = (&finer[depth - 1], &mut coarser[0]);
            for (row, cells) in finer.top.chunks_exact(finer.columns).enumerate() {
                let above = &mut coarser.top[row / FAN * coarser.columns..][..coarser.columns];
                for (cells, top) in cells.chunks(FAN).zip(above) {
                    *top = cells.iter().fold(*top, |most, v| most.max(*v));
                }
            }
        }
        self.earlier = self.levels[0].top.clone();
    }

    /// Raises the cells whose centre lies within `reach` of the segment `ends` to `height`.
    pub(super) fn deposit(&mut self, ends: [[f64; 2]; 2], reach: f64, height: f64) {
        let height = (height + ROUNDING) as f32;
        let mut rows = self.rows(ends, reach);
        while let Some((row, columns)) = rows.next(&self.levels[0]) {
            let (mut row, mut first, mut last) = (row, *columns.start(), *columns.end());
            for level in &mut self.levels {
                let cells = &mut level.top[row * level.columns + first..=row * level.columns + last];
                let lower = cells.iter().fold(false, |lower, top| lower | (*top < height));
                if !lower {
                    break;
                }
                cells.iter_mut().for_each(|top| *top = top.max(height));
                (row, first, last) = (row / FAN, first / FAN, last / FAN);
            }
        }
    }

    /// Takes note that a support was laid to `height` over those cells.
    pub(super) fn hold(&mut self, ends: [[f64; 2]; 2], reach: f64, height: f64) {
        if self.held.is_empty() {
            self.held = vec![f32::NEG_INFINITY; self.levels[0].top.len()];
        }
        let height = (height + ROUNDING) as f32;
        self.rows(ends, reach).change(&self.levels[0], &mut self.held, |top| *top = top.max(height));
    }

    /// Takes note that a body was laid to `height` over those cells.
    pub(super) fn lay(&mut self, ends: [[f64; 2]; 2], reach: f64, height: f64, body: u32) {
        if self.bodies.is_empty() {
            self.bodies = vec![Highest::NONE; self.levels[0].top.len()];
        }
        let height = (height + ROUNDING) as f32;
        self.rows(ends, reach).change(&self.levels[0], &mut self.bodies, |cell| cell.lay(body, height));
    }

    /// Calls `height(x, y, top)` for the cells whose centre lies within `reach` of the segment `ends`, and raises them to what
    /// it answers; [`Field::settle`] must follow.
    pub(super) fn render(&mut self, ends: [[f64; 2]; 2], reach: f64, height: impl Fn(f64, f64, f64) -> Option<f64>) {
        let mut rows = self.rows(ends, reach);
        let cell = self.levels[0].cell;
        while let Some((row, columns)) = rows.next(&self.levels[0]) {
            let y = self.origin[1] + (row as f64 + 0.5) * cell;
            let start = row * self.levels[0].columns;
            for column in columns {
                let top = &mut self.levels[0].top[start + column];
                let x = self.origin[0] + (column as f64 + 0.5) * cell;
                if let Some(height) = height(x, y, f64::from(*top)) {
                    *top = top.max((height + ROUNDING) as f32);
                }
            }
        }
    }

    /// Raises to `height(x, y)` the cells of each row whose centre lies within `span(y)`; [`Field::settle`] must follow.
    pub(super) fn render_rows(&mut self, span: impl Fn(f64) -> Option<[f64; 2]>, height: impl Fn(f64, f64) -> f64) {
        let (origin, level) = (self.origin, &mut self.levels[0]);
        for (row, cells) in level.top.chunks_exact_mut(level.columns).enumerate() {
            let y = origin[1] + (row as f64 + 0.5) * level.cell;
            let Some(columns) = span(y).and_then(|span| columns(span, origin[0], level.cell, level.columns)) else {
                continue;
            };
            for column in columns {
                let x = origin[0] + (column as f64 + 0.5) * level.cell;
                cells[column] = cells[column].max((height(x, y) + ROUNDING) as f32);
            }
        }
    }

    /// The rows of cells about a segment.
    fn rows(&self, [a, b]: [[f64; 2]; 2], reach: f64) -> Rows {
        let level = &self.levels[0];
        let row = |y: f64| ((y - self.origin[1]) / level.cell).max(0.0) as usize;
        let [dx, dy] = [b[0] - a[0], b[1] - a[1]];
        let length = (dx * dx + dy * dy).sqrt();
        let along = if length > 1e-9 { [dx / length, dy / length] } else { [1.0, 0.0] };
        let last = row(a[1].max(b[1]) + reach).min(level.rows - 1);
        Rows { origin: self.origin, a, b, along, length, reach, row: row(a[1].min(b[1]) - reach), last }
    }

    /// Whether anything within `reach` (a square) of `at` is as high as `below` wants it.
    pub(super) fn stands(&self, at: [f64; 2], reach: f64, below: Below) -> bool {
        let level = &self.levels[0];
        let index = |v: f64, axis: usize| (v - self.origin[axis]) / level.cell;
        let held = |i: usize| self.held.get(i).is_some_and(|top| f64::from(*top) >= below.held);
        let other = |i: usize| {
            let others = below.other.and_then(|(body, height)| Some((self.bodies.get(i)?.but(body), height)));
            others.is_some_and(|(top, height)| top >= height)
        };
        let holds = |i: usize| {
            f64::from(level.top[i]) >= below.height
                || f64::from(self.earlier[i]) >= below.earlier
                || (f64::from(level.top[i]) >= below.laid && level.top[i] > self.earlier[i])
                || held(i)
                || other(i)
        };
        let limit = [level.columns, level.rows];
        let clamp = |v: f64, axis: usize| (v.max(0.0) as usize).min(limit[axis] - 1);
        let middle = [0, 1].map(|i| clamp(index(at[i], i), i));
        if holds(middle[1] * level.columns + middle[0]) {
            return true;
        }
        let [x, y] = [0, 1].map(|i| clamp(index(at[i] - reach, i), i)..=clamp(index(at[i] + reach, i), i));
        y.into_iter().any(|row| x.clone().any(|column| holds(row * level.columns + column)))
    }

    /// Whether something within `reach` (a square) of `at` ends between these heights: laid before the layer that is being laid.
    pub(super) fn ends_between(&self, at: [f64; 2], reach: f64, [low, high]: [f64; 2]) -> bool {
        let level = &self.levels[0];
        let limit = [level.columns, level.rows];
        let index =
            |v: f64, axis: usize| (((v - self.origin[axis]) / level.cell).max(0.0) as usize).min(limit[axis] - 1);
        let [x, y] = [0, 1].map(|i| index(at[i] - reach, i)..=index(at[i] + reach, i));
        let ends = |i: usize| (low..=high).contains(&f64::from(level.top[i]));
        y.into_iter().any(|row| x.clone().any(|column| ends(row * level.columns + column)))
    }

    /// A lower bound of the vertical room (mm) between `hull`, its origin anywhere in `origins` at height `z`, and what
    /// stands below it; rooms of `cap` and more are not told apart.
    ///
    /// Sound: for a cell, the underside is at least the greatest of its supporting planes' least values over all
    /// offsets from origin to cell.
    pub(super) fn room(&self, hull: &Hull, origins: &Rect, z: f64, cap: f64) -> f64 {
        let probe = Probe::new(hull, origins, z, 0.0);
        let mut best = cap;
        self.descend(self.levels.len() - 1, [0, 0], &probe, &mut best, |probe, cell, top| probe.above(cell, top));
        best
    }

    /// A lower bound of the distance (mm) in any direction between `hull` with all above it, its origin anywhere in `origins` at
    /// height `z`, and what stands; below 0 where they may meet. Distances of `cap` and more are not told apart.
    pub(super) fn distance(&self, hull: &Hull, origins: &Rect, z: f64, cap: f64) -> f64 {
        let probe = Probe::new(hull, origins, z, cap.max(0.0));
        let mut best = cap;
        self.descend(self.levels.len() - 1, [0, 0], &probe, &mut best, |probe, cell, top| probe.away(cell, top));
        best
    }

    fn descend<M: Fn(&Probe<'_>, &Rect, f64) -> Option<f64> + Copy>(
        &self,
        depth: usize,
        [x, y]: [usize; 2],
        probe: &Probe<'_>,
        best: &mut f64,
        measure: M,
    ) {
        let level = &self.levels[depth];
        let top = f64::from(level.top[y * level.columns + x]);
        if probe.lowest - top >= *best {
            return;
        }
        let min = [self.origin[0] + x as f64 * level.cell, self.origin[1] + y as f64 * level.cell];
        let Some(room) = measure(probe, &Rect { min, max: min.map(|v| v + level.cell) }, top) else { return };
        if room >= *best {
            return;
        }
        if depth == 0 {
            *best = room;
            return;
        }
        let finer = &self.levels[depth - 1];
        let range = |axis: usize, at: usize, most: usize| {
            let index = |v: f64| ((v - self.origin[axis]) / finer.cell).max(0.0) as usize;
            let first = (at * FAN).max(index(probe.reach[axis][0]));
            first..(at * FAN + FAN).min(most).min(index(probe.reach[axis][1]) + 1)
        };
        let columns = range(0, x, finer.columns);
        for row in range(1, y, finer.rows) {
            columns.clone().for_each(|column| self.descend(depth - 1, [column, row], probe, best, measure));
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

impl<'a> Probe<'a> {
    fn new(hull: &'a Hull, origins: &'a Rect, z: f64, around: f64) -> Self {
        let bounds = [[hull.bounds.min.x, hull.bounds.max.x], [hull.bounds.min.y, hull.bounds.max.y]];
        let reach = [0, 1].map(|i| [origins.min[i] + bounds[i][0] - around, origins.max[i] + bounds[i][1] + around]);
        Self { hull, origins, reach, z, lowest: z + hull.bounds.min.z }
    }

    /// The least value of `a x + b y` over all offsets from origin to `cell`.
    fn least(&self, cell: &Rect) -> impl Fn(f64, f64) -> f64 {
        let low = [0, 1].map(|i| cell.min[i] - self.origins.max[i]);
        let high = [0, 1].map(|i| cell.max[i] - self.origins.min[i]);
        move |a, b| a * if a > 0.0 { low[0] } else { high[0] } + b * if b > 0.0 { low[1] } else { high[1] }
    }

    /// A lower bound of the distance from what stands in `cell` up to `top`: that of one of the planes.
    fn away(&self, cell: &Rect, top: f64) -> Option<f64> {
        let least = self.least(cell);
        let sides = self.hull.sides.iter();
        Some(sides.map(|&[x, y, z, c]| least(x, y) + z * (top - self.z) - c).fold(f64::NEG_INFINITY, f64::max))
    }

    /// A lower bound of the room between the underside and what stands in `cell` up to `top`; `None` where the hull is not above
    /// it.
    fn above(&self, cell: &Rect, top: f64) -> Option<f64> {
        let least = self.least(cell);
        if self.hull.outline.iter().any(|&[x, y, c]| least(x, y) > c) {
            return None;
        }
        Some(self.z + self.hull.under.iter().map(|&[a, b, c]| least(a, b) + c).fold(f64::NEG_INFINITY, f64::max) - top)
    }
}

/// The rows of a field that a segment comes near to, and which of their cells.
struct Rows {
    origin: [f64; 2],
    a: [f64; 2],
    b: [f64; 2],
    /// Unit vector from `a` to `b`.
    along: [f64; 2],
    length: f64,
    reach: f64,
    row: usize,
    last: usize,
}

impl Rows {
    /// The next row and the columns whose cells' centres lie within reach.
    fn next(&mut self, level: &Level) -> Option<(usize, std::ops::RangeInclusive<usize>)> {
        while self.row <= self.last {
            let row = self.row;
            self.row += 1;
            let Some(span) = self.span(self.origin[1] + (row as f64 + 0.5) * level.cell) else { continue };
            if let Some(columns) = columns(span, self.origin[0], level.cell, level.columns) {
                return Some((row, columns));
            }
        }
        None
    }

    /// Changes what `cells`, one for each of the level, have there.
    fn change<T>(mut self, level: &Level, cells: &mut [T], mut change: impl FnMut(&mut T)) {
        while let Some((row, columns)) = self.next(level) {
            let first = row * level.columns;
            cells[first + columns.start()..=first + columns.end()].iter_mut().for_each(&mut change);
        }
    }

    /// From where to where the line at height `y` lies within reach of the segment: what is within reach of either end, or
    /// beside it, is one interval because all of it is convex.
    fn span(&self, y: f64) -> Option<[f64; 2]> {
        let mut span = [f64::INFINITY, f64::NEG_INFINITY];
        for end in [self.a, self.b] {
            let rest = self.reach * self.reach - (y - end[1]) * (y - end[1]);
            if rest >= 0.0 {
                let half = rest.sqrt();
                span = [span[0].min(end[0] - half), span[1].max(end[0] + half)];
            }
        }
        let [ux, uy] = self.along;
        let dy = y - self.a[1];
        // Beside it: 0 <= dx ux + dy uy <= length and |dy ux - dx uy| <= reach.
        let along = between(ux, -dy * uy, self.length - dy * uy);
        let across = between(uy, dy * ux - self.reach, dy * ux + self.reach);
        let (from, to) = (along[0].max(across[0]), along[1].min(across[1]));
        if from <= to {
            span = [span[0].min(self.a[0] + from), span[1].max(self.a[0] + to)];
        }
        (span[0] <= span[1]).then_some(span)
    }
}

/// The columns of `count` whose cells' centres lie in `span`.
fn columns(span: [f64; 2], origin: f64, cell: f64, count: usize) -> Option<std::ops::RangeInclusive<usize>> {
    let [first, last] = span.map(|x| (x - origin) / cell - 0.5);
    // A hair more: rounding must not leave out a cell.
    let (first, last) = ((first - 1e-9).max(-1.0), (last + 1e-9).min(count as f64 - 1.0));
    if last < 0.0 {
        return None;
    }
    let whole = first.max(0.0) as usize;
    let first = whole + usize::from((whole as f64) < first);
    (first <= last as usize).then_some(first..=last as usize)
}

/// Where `low <= factor x <= high`; inside out for nowhere.
fn between(factor: f64, low: f64, high: f64) -> [f64; 2] {
    if factor.abs() < 1e-12 {
        let inside = low <= 0.0 && 0.0 <= high;
        return if inside { [f64::NEG_INFINITY, f64::INFINITY] } else { [f64::INFINITY, f64::NEG_INFINITY] };
    }
    let [p, q] = [low / factor, high / factor];
    [p.min(q), p.max(q)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::{Body, SplitMix64, Vec3};

    fn field() -> Field {
        let mut field = Field::new(&Rect { min: [-20.0, -20.0], max: [20.0, 20.0] });
        // A post 2 mm wide and 30 high about (10, 0).
        field.deposit([[10.0, -1.0], [10.0, 1.0]], 1.0, 30.0);
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
        let below = |height: f64, earlier: f64, laid: f64| Below { height, earlier, laid, held: 99.0, other: None };
        assert!(field.stands([10.0, 0.0], 0.2, below(29.0, 99.0, 99.0)));
        assert!(field.stands([11.5, 0.0], 1.0, below(29.0, 99.0, 99.0)));
        assert!(!field.stands([13.0, 0.0], 1.0, below(29.0, 99.0, 99.0)));
        assert!(field.stands([10.0, 0.0], 0.2, below(99.0, 29.0, 99.0)));
        assert!(!field.stands([10.0, 0.0], 0.2, below(31.0, 31.0, 99.0)));
        // What was there before is nothing that was laid since.
        assert!(!field.stands([10.0, 0.0], 0.2, below(99.0, 99.0, 29.0)));
        field.deposit([[9.0, 0.0], [11.0, 0.0]], 0.3, 33.0);
        assert!(field.stands([10.0, 0.0], 0.2, below(99.0, 99.0, 32.0)));
        assert!(!field.stands([10.0, 0.0], 0.2, below(99.0, 99.0, 34.0)));
    }

    #[test]
    fn the_cells_about_a_segment_are_those_within_reach() {
        let mut numbers = SplitMix64::seeded(1);
        let mut share = || numbers.unit();
        for round in 0..300 {
            let mut p = || [(); 2].map(|()| share() * 44.0 - 22.0);
            let (a, mut b) = (p(), p());
            match round % 4 {
                0 => b[0] = a[0],
                1 => b[1] = a[1],
                2 => b = a,
                _ => {}
            }
            let reach = 0.2 + 2.0 * share();
            let mut field = Field::new(&Rect { min: [-20.0, -20.0], max: [20.0, 20.0] });
            field.deposit([a, b], reach, 7.0);
            let level = &field.levels[0];
            for (i, top) in level.top.iter().enumerate() {
                let centre = [i % level.columns, i / level.columns].map(|n| (n as f64 + 0.5) * level.cell - 20.0);
                let away = crate::section::to_segment(centre, [a, b]);
                assert!(
                    (away - reach).abs() < 1e-6 || (away < reach) == (*top > 0.0),
                    "{a:?} {b:?} {reach} {centre:?}"
                );
            }
            let mut rendered = Field::new(&Rect { min: [-20.0, -20.0], max: [20.0, 20.0] });
            rendered.render([a, b], reach, |_, _, _| Some(7.0));
            rendered.settle();
            for (one, other) in field.levels.iter().zip(&rendered.levels) {
                assert_eq!(one.top, other.top);
            }
        }
    }
}
