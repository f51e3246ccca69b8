//! Segments of a plane, filed by square cells: which of them is nearest to a point, and which are near it. Lengths mm.

use std::ops::ControlFlow;

/// Edge of a cell, mm, at least.
const CELL_MM: f64 = 1.0;
/// So many cells for each segment, and for so many at least: the thin outline of something wide leaves nearly all of them empty.
const CELLS_EACH: f64 = 16.0;
const FEWEST: usize = 256;
/// Cells at most along one side; what is very large gets larger cells.
const MOST_CELLS: f64 = 1000.0;
/// How near to a segment's end the nearest point may lie to be taken for a corner, as a part of its length.
const CORNER: f64 = 1e-9;
/// By how much a segment is taken longer when it is filed, mm: rounding must not lose it at a cell's edge.
const ROUNDING_MM: f64 = 1e-6;

/// Twice the area of a triangle that may as well be a line, mm²: far more than rounding.
const UNSURE: f64 = 1e-9;

/// A point of the plane, mm.
pub type PlanePoint = [f64; 2];
/// From one point to another.
pub type Segment = [PlanePoint; 2];

/// Segments by cell.
pub struct Segments {
    all: Vec<Segment>,
    bounds: [PlanePoint; 2],
    /// The grid's lowest corner.
    low: PlanePoint,
    cell: f64,
    count: [usize; 2],
    /// Where each cell's segments begin in `members`.
    starts: Vec<u32>,
    members: Vec<u32>,
    /// How many rings of cells around each, itself the first, hold no segment; what is far from all is told at once.
    empty_rings: Vec<u8>,
}

/// The nearest segment to a point.
#[derive(Clone, Copy, Debug)]
pub struct Nearest {
    /// Its place among the segments.
    pub index: u32,
    /// How far away it is, mm.
    pub distance: f64,
    /// Whether its nearest point is an end of it, where the side of the point is another question.
    pub corner: bool,
    /// Whether the point is to its left.
    pub left: bool,
}

impl Segments {
    /// `all` in their cells.
    pub fn new(all: Vec<Segment>) -> Self {
        let mut bounds = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
        for point in all.iter().flatten() {
            for axis in 0..2 {
                bounds[0][axis] = bounds[0][axis].min(point[axis]);
                bounds[1][axis] = bounds[1][axis].max(point[axis]);
            }
        }
        let low = if all.is_empty() { [0.0; 2] } else { bounds[0] };
        let size = if all.is_empty() { [0.0; 2] } else { [0, 1].map(|a| bounds[1][a] - bounds[0][a]) };
        let sparse = (size[0] * size[1] / (CELLS_EACH * all.len().max(FEWEST) as f64)).sqrt();
        let cell = CELL_MM.max(size[0].max(size[1]) / MOST_CELLS).max(sparse);
        let count = size.map(|s| (s / cell) as usize + 1);
        let cells = count[0] * count[1];
        let (starts, empty_rings) = (vec![0; cells + 1], Vec::new());
        let mut segments = Self { all, bounds, low, cell, count, starts, members: Vec::new(), empty_rings };
        segments.file();
        segments.count_empty_rings();
        segments
    }

    /// The segments, in the order in which they were given.
    pub fn all(&self) -> &[Segment] {
        &self.all
    }

    /// Lowest and highest corner, mm; infinite and inside out for none.
    pub fn bounds(&self) -> [PlanePoint; 2] {
        self.bounds
    }

    /// Columns and rows.
    pub(super) fn count(&self) -> [usize; 2] {
        self.count
    }

    /// Edge of a cell, mm.
    pub(super) fn cell_mm(&self) -> f64 {
        self.cell
    }

    /// The middle of a cell.
    pub(super) fn centre(&self, [column, row]: [usize; 2]) -> PlanePoint {
        [0, 1].map(|a| self.low[a] + ([column, row][a] as f64 + 0.5) * self.cell)
    }

    /// The segments of a cell.
    pub(super) fn members(&self, cell: usize) -> impl Iterator<Item = &Segment> {
        let members = &self.members[self.starts[cell] as usize..self.starts[cell + 1] as usize];
        members.iter().map(|&index| &self.all[index as usize])
    }

    /// The cell that holds `p`; `None` outside the grid.
    pub(super) fn cell_of(&self, p: PlanePoint) -> Option<usize> {
        let [column, row] = self.home(p);
        let inside = column >= 0 && row >= 0 && column < self.count[0] as isize && row < self.count[1] as isize;
        inside.then(|| row as usize * self.count[0] + column as usize)
    }

    /// How far (mm) `p`, a point of cell `cell`, is from every segment at least.
    pub(super) fn least_away(&self, p: PlanePoint, cell: usize) -> f64 {
        match self.empty_rings[cell] {
            0 => 0.0,
            rings => f64::from(rings - 1) * self.cell + self.to_border(p),
        }
    }

    /// Column and row of the cell that would hold `p`, were the grid endless.
    fn home(&self, p: PlanePoint) -> [isize; 2] {
        [0, 1].map(|a| floor((p[a] - self.low[a]) / self.cell))
    }

    /// The distance from `p` to the nearest side of its cell.
    fn to_border(&self, p: PlanePoint) -> f64 {
        let inside = [0, 1].map(|a| {
            let at = (p[a] - self.low[a]) / self.cell;
            let share = at - floor(at) as f64;
            share.min(1.0 - share)
        });
        inside[0].min(inside[1]).max(0.0) * self.cell
    }

    /// The nearest segment that is nearer to `p` than `cap` mm. `likely` is tried first: for points that follow one another
    /// it settles most of the search.
    pub fn nearest(&self, p: PlanePoint, cap: f64, likely: Option<u32>) -> Option<Nearest> {
        if self.all.is_empty() {
            return None;
        }
        let mut best = Nearer { square: cap * cap, index: None, corner: false, left: true };
        if let Some(&segment) = likely.and_then(|index| self.all.get(index as usize)) {
            best.take(segment, likely, p);
        }
        let home = self.home(p);
        let first = self.cell_of(p).map_or(0, |cell| isize::from(self.empty_rings[cell]));
        let border = self.to_border(p);
        for ring in first..=(cap / self.cell).ceil() as isize {
            // Nothing of this ring is nearer than so much.
            let away = if ring == 0 { 0.0 } else { (ring - 1) as f64 * self.cell + border };
            if away * away >= best.square {
                break;
            }
            self.ring(home, ring, p, &mut best);
        }
        let index = best.index?;
        Some(Nearest { index, distance: best.square.sqrt(), corner: best.corner, left: best.left })
    }

    /// Whether a segment meets or touches the way from `a` to `b`.
    pub fn meets(&self, [a, b]: Segment) -> bool {
        if self.all.is_empty() {
            return false;
        }
        let mut met = false;
        self.through(&[a, b], |cell| met = met || self.members(cell).any(|&[p, q]| crosses([a, b], [p, q])));
        met
    }

    /// Visits all segments that come within `reach` of `p`, and some that do not, until `visit` breaks off; some of them several times. None for a `p`
    /// that is no number.
    pub fn each_near(&self, p: PlanePoint, reach: f64, mut visit: impl FnMut(u32) -> ControlFlow<()>) {
        if self.all.is_empty() || !p.iter().all(|v| v.is_finite()) {
            return;
        }
        let index = |mm: f64, axis: usize| floor((mm - self.low[axis]) / self.cell);
        let range = |axis: usize| {
            let last = self.count[axis] as isize - 1;
            index(p[axis] - reach, axis).max(0)..=index(p[axis] + reach, axis).min(last)
        };
        for row in range(1) {
            for column in range(0) {
                let cell = row as usize * self.count[0] + column as usize;
                let members = &self.members[self.starts[cell] as usize..self.starts[cell + 1] as usize];
                if members.iter().any(|index| visit(*index).is_break()) {
                    return;
                }
            }
        }
    }

    /// Tries the segments of the cells that lie `ring` cells from `home`.
    fn ring(&self, home: [isize; 2], ring: isize, p: PlanePoint, best: &mut Nearer) {
        let [columns, rows] = self.count.map(|n| n as isize);
        let beyond = |at: isize, axis: usize| {
            let low = self.low[axis] + at as f64 * self.cell;
            (low - p[axis]).max(p[axis] - low - self.cell).max(0.0)
        };
        for row in (home[1] - ring).max(0)..=(home[1] + ring).min(rows - 1) {
            let dy = beyond(row, 1);
            let edge = (row - home[1]).abs() == ring;
            let step = if edge || ring == 0 { 1 } else { 2 * ring };
            let mut column = home[0] - ring;
            while column <= home[0] + ring {
                if (0..columns).contains(&column) {
                    let dx = beyond(column, 0);
                    if dx * dx + dy * dy < best.square {
                        self.cell((row * columns + column) as usize, p, best);
                    }
                }
                column += step;
            }
        }
    }

    fn cell(&self, cell: usize, p: PlanePoint, best: &mut Nearer) {
        for &index in &self.members[self.starts[cell] as usize..self.starts[cell + 1] as usize] {
            best.take(self.all[index as usize], Some(index), p);
        }
    }

    /// Counts, then places, each segment in every cell that it runs through.
    fn file(&mut self) {
        let mut starts = std::mem::take(&mut self.starts);
        for segment in &self.all {
            self.through(segment, |cell| starts[cell] += 1);
        }
        let mut total = 0;
        for start in &mut starts {
            total += std::mem::replace(start, total);
        }
        let mut members = vec![0; total as usize];
        let mut next = starts.clone();
        for (index, segment) in self.all.iter().enumerate() {
            self.through(segment, |cell| {
                members[next[cell] as usize] = index as u32;
                next[cell] += 1;
            });
        }
        (self.starts, self.members) = (starts, members);
    }

    /// Visits the cells that a segment runs through, row by row.
    fn through(&self, [a, b]: &Segment, mut visit: impl FnMut(usize)) {
        let index = |v: f64, axis: usize| {
            floor((v - self.low[axis]) / self.cell).clamp(0, self.count[axis] as isize - 1) as usize
        };
        let [low, high] = [index(a[1].min(b[1]) - ROUNDING_MM, 1), index(a[1].max(b[1]) + ROUNDING_MM, 1)];
        for row in low..=high {
            let [mut left, mut right] = [a[0].min(b[0]), a[0].max(b[0])];
            if low < high {
                let bottom = self.low[1] + row as f64 * self.cell;
                let rise = b[1] - a[1];
                let at = |y: f64| a[0] + (b[0] - a[0]) * ((y - a[1]) / rise).clamp(0.0, 1.0);
                let [x, y] = [at(bottom - ROUNDING_MM), at(bottom + self.cell + ROUNDING_MM)];
                (left, right) = (x.min(y), x.max(y));
            }
            for column in index(left - ROUNDING_MM, 0)..=index(right + ROUNDING_MM, 0) {
                visit(row * self.count[0] + column);
            }
        }
    }

    /// Chessboard distances to the nearest cell with a segment, forward and back over the grid.
    fn count_empty_rings(&mut self) {
        let [columns, rows] = self.count;
        let full = |cell: usize| self.starts[cell] < self.starts[cell + 1];
        let mut rings: Vec<u8> = (0..columns * rows).map(|cell| if full(cell) { 0 } else { u8::MAX }).collect();
        let mut pass = |cells: &mut dyn Iterator<Item = usize>, sign: isize| {
            for cell in cells {
                if rings[cell] == 0 {
                    continue;
                }
                let (column, row) = ((cell % columns) as isize, (cell / columns) as isize);
                for (dx, dy) in [(-1, 0), (-1, -1), (0, -1), (1, -1)] {
                    let (x, y) = (column + sign * dx, row + sign * dy);
                    if (0..columns as isize).contains(&x) && (0..rows as isize).contains(&y) {
                        let beside = rings[(y * columns as isize + x) as usize];
                        rings[cell] = rings[cell].min(beside.saturating_add(1));
                    }
                }
            }
        };
        pass(&mut (0..columns * rows), 1);
        pass(&mut (0..columns * rows).rev(), -1);
        self.empty_rings = rings;
    }
}

/// Whether two segments meet, or come so near that rounding cannot tell.
fn crosses([a, b]: Segment, [p, q]: Segment) -> bool {
    let side = |from: PlanePoint, to: PlanePoint, at: PlanePoint| {
        (to[0] - from[0]) * (at[1] - from[1]) - (to[1] - from[1]) * (at[0] - from[0])
    };
    let apart = |one: f64, other: f64| one > UNSURE && other > UNSURE || one < -UNSURE && other < -UNSURE;
    !(apart(side(a, b, p), side(a, b, q)) || apart(side(p, q, a), side(p, q, b)))
}

/// The distance of `p` from a segment, mm.
pub fn to_segment(p: PlanePoint, [a, b]: Segment) -> f64 {
    let (abx, aby) = (b[0] - a[0], b[1] - a[1]);
    let square = abx * abx + aby * aby;
    let along = (p[0] - a[0]) * abx + (p[1] - a[1]) * aby;
    let t = if square > 0.0 { (along / square).clamp(0.0, 1.0) } else { 0.0 };
    let (dx, dy) = (p[0] - a[0] - abx * t, p[1] - a[1] - aby * t);
    (dx * dx + dy * dy).sqrt()
}

/// The greatest whole number that is not above `v`, without a call.
fn floor(v: f64) -> isize {
    let whole = v as isize;
    whole - isize::from(whole as f64 > v)
}

/// Segments whose distances differ by less than this are equally near, mm: which side a point lies on is then asked of the whole outline.
const TIE_MM: f64 = 1e-6;

pub(super) struct Nearer {
    pub(super) square: f64,
    pub(super) index: Option<u32>,
    pub(super) corner: bool,
    pub(super) left: bool,
}

impl Nearer {
    pub(super) fn take(&mut self, [a, b]: Segment, index: Option<u32>, p: PlanePoint) {
        let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
        let (px, py) = (p[0] - a[0], p[1] - a[1]);
        let square = dx * dx + dy * dy;
        let along = if square > 0.0 { (px * dx + py * dy) / square } else { 0.0 };
        let t = along.clamp(0.0, 1.0);
        let (ex, ey) = (px - dx * t, py - dy * t);
        let square = ex * ex + ey * ey;
        // The two sides of a slit, as where a plane just touches the top of a hole, are equally near.
        let tie = self.index.is_some() && (square - self.square).abs() < TIE_MM * TIE_MM + 2.0 * TIE_MM * square.sqrt();
        if square < self.square {
            let corner = tie || !(CORNER..=1.0 - CORNER).contains(&along);
            *self = Self { square, index, corner, left: dx * py - dy * px > 0.0 };
        } else if tie {
            self.corner = true;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::SplitMix64;

    /// The same numbers every time.
    fn shares() -> impl FnMut() -> f64 {
        let mut numbers = SplitMix64::seeded(7);
        move || numbers.unit()
    }

    #[test]
    fn the_nearest_of_segments_short_and_long_is_that_of_trying_all() {
        let mut share = shares();
        let mut point = |size: f64| [(); 2].map(|()| (share() - 0.5) * size);
        let all: Vec<Segment> = (0..200)
            .map(|i| {
                let (a, by) = (point(30.0), point(if i % 5 == 0 { 30.0 } else { 1.0 }));
                [a, [a[0] + by[0], a[1] + by[1]]]
            })
            .collect();
        let segments = Segments::new(all.clone());
        let mut likely = None;
        for k in 0..5000 {
            let (p, cap) = (point(40.0), [0.3, 2.0, 5.0][k % 3]);
            let mut best = Nearer { square: cap * cap, index: None, corner: false, left: true };
            all.iter().enumerate().for_each(|(i, s)| best.take(*s, Some(i as u32), p));
            let got = segments.nearest(p, cap, likely);
            assert_eq!(got.map(|n| n.distance), best.index.map(|_| best.square.sqrt()), "{p:?}");
            likely = got.map_or(likely, |n| Some(n.index));
            if let Some(cell) = segments.cell_of(p) {
                let away = Nearer { square: 1e9, index: None, corner: false, left: true };
                let away = all.iter().fold(away, |mut b, s| {
                    b.take(*s, Some(0), p);
                    b
                });
                assert!(segments.least_away(p, cell) <= away.square.sqrt() + 1e-9, "{p:?}");
            }
        }
        for k in 0..500 {
            let (p, reach) = (point(50.0), [0.3, 2.0, 5.0][k % 3]);
            let mut seen = vec![false; all.len()];
            segments.each_near(p, reach, |index| {
                seen[index as usize] = true;
                ControlFlow::Continue(())
            });
            let near = |segment: &Segment| crate::section::to_segment(p, *segment) <= reach;
            assert!(all.iter().zip(&seen).all(|(segment, seen)| *seen || !near(segment)), "{p:?} {reach}");
            assert!(reach > 0.5 || seen.iter().filter(|seen| **seen).count() < 40, "{p:?}");
        }
        let on = |[a, b]: Segment, t: f64| [a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t];
        let (mut met, mut free) = (0, 0);
        for _ in 0..3000 {
            let way = [point(36.0), point(36.0)];
            let got = segments.meets(way);
            // By the nearest distance along the way, in steps far smaller than what would be missed.
            let near = (0..=2000).any(|k| segments.nearest(on(way, f64::from(k) / 2000.0), 1e-2, None).is_some());
            assert!(got || !all.iter().any(|s| crosses(way, *s)), "{way:?}");
            assert!(!got || near, "{way:?}");
            (met, free) = (met + u32::from(got), free + u32::from(!got));
        }
        assert!(met > 100 && free > 100, "{met} {free}");
        assert!(Segments::new(Vec::new()).nearest([0.0; 2], 1.0, None).is_none());
    }
}
