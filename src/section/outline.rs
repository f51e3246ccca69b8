//! One cut: segments with material to their left, in a grid of cells.

/// Distances beyond this are not told apart, mm: wider than any line, and the search stays among neighbours.
const CAP_MM: f64 = 2.0;
/// Edge of a cell, mm.
const CELL_MM: f64 = 1.0;
/// Cells at most along one side; a very large part gets larger cells.
const MOST_CELLS: f64 = 1000.0;
/// How near to a segment's end the nearest point may lie to be taken for a corner, as a part of its length.
const CORNER: f64 = 1e-9;

type Point = [f64; 2];
type Segment = [Point; 2];

/// A cross-section of a part.
pub struct Section {
    segments: Vec<Segment>,
    bounds: [Point; 2],
    cell: f64,
    count: [usize; 2],
    /// Where each cell's segments begin in `members`.
    starts: Vec<u32>,
    members: Vec<u32>,
    /// The winding number at each cell's centre.
    winding: Vec<i32>,
    /// How many rings of cells around each, itself the first, hold no segment; what is far from the outline is told at once.
    empty_rings: Vec<u8>,
}

impl Section {
    pub(super) fn new(segments: Vec<Segment>) -> Self {
        let mut bounds = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
        for point in segments.iter().flatten() {
            for axis in 0..2 {
                bounds[0][axis] = bounds[0][axis].min(point[axis]);
                bounds[1][axis] = bounds[1][axis].max(point[axis]);
            }
        }
        let size = if segments.is_empty() { [0.0; 2] } else { [0, 1].map(|a| bounds[1][a] - bounds[0][a]) };
        let cell = CELL_MM.max(size[0].max(size[1]) / MOST_CELLS);
        let count = size.map(|s| (s / cell) as usize + 1);
        let cells = count[0] * count[1];
        let mut section = Self {
            segments,
            bounds,
            cell,
            count,
            starts: vec![0; cells + 1],
            members: Vec::new(),
            winding: vec![0; cells],
            empty_rings: vec![0; cells],
        };
        if !section.segments.is_empty() {
            section.file();
            section.wind();
            section.count_empty_rings();
        }
        section
    }

    /// Whether nothing is cut.
    pub fn is_empty(&self) -> bool {
        self.segments.is_empty()
    }

    /// Lowest and highest corner of the outline, mm; infinite and inside out where nothing is cut.
    pub fn bounds(&self) -> [Point; 2] {
        self.bounds
    }

    /// Length of the outline, mm.
    pub fn perimeter(&self) -> f64 {
        self.segments.iter().map(|[a, b]| (b[0] - a[0]).hypot(b[1] - a[1])).sum()
    }

    /// What the outline encloses, mm²; where shells overlap it counts twice.
    pub fn area(&self) -> f64 {
        let origin = self.bounds[0];
        let cross =
            |[a, b]: &Segment| (a[0] - origin[0]) * (b[1] - origin[1]) - (b[0] - origin[0]) * (a[1] - origin[1]);
        self.segments.iter().map(cross).sum::<f64>() / 2.0
    }

    /// The distance (mm) of `p` from the outline, negative inside; beyond 2 mm from it, 2 or -2.
    pub fn signed_distance(&self, p: Point) -> f64 {
        self.nearest(p).0
    }

    /// The same with the outward unit normal of the nearest segment; `None` where that is farther than 2 mm.
    pub fn nearest(&self, p: Point) -> (f64, Option<Point>) {
        let mut best = Best { square: CAP_MM * CAP_MM, segment: None, corner: false, left: true };
        if self.segments.is_empty() {
            return (CAP_MM, None);
        }
        let reach = (CAP_MM / self.cell).ceil() as isize;
        let home = [0, 1].map(|a| ((p[a] - self.bounds[0][a]) / self.cell).floor());
        let first = self.cell_of(p).map_or(0, |cell| isize::from(self.empty_rings[cell]));
        for ring in first..=reach {
            // Nothing of this ring is nearer than so much.
            let away = (ring - 1).max(0) as f64 * self.cell;
            if best.segment.is_some() && away * away > best.square {
                break;
            }
            self.ring(home.map(|v| v as isize), ring, |segment| best.take(self.segments[segment as usize], segment, p));
        }
        let distance = best.square.sqrt();
        let Some(index) = best.segment else { return (if self.is_inside(p) { -CAP_MM } else { CAP_MM }, None) };
        let inside = if best.corner { self.is_inside(p) } else { best.left };
        let [a, b] = self.segments[index as usize];
        let length = (b[0] - a[0]).hypot(b[1] - a[1]);
        let normal = [(b[1] - a[1]) / length, (a[0] - b[0]) / length];
        (if inside { -distance } else { distance }, Some(normal))
    }

    /// Visits the segments of the cells that lie `ring` cells from `home`.
    fn ring(&self, home: [isize; 2], ring: isize, mut visit: impl FnMut(u32)) {
        let [columns, rows] = self.count.map(|n| n as isize);
        for row in (home[1] - ring).max(0)..=(home[1] + ring).min(rows - 1) {
            let edge = (row - home[1]).abs() == ring;
            let step = if edge || ring == 0 { 1 } else { 2 * ring };
            let mut column = home[0] - ring;
            while column <= home[0] + ring {
                if (0..columns).contains(&column) {
                    let cell = (row * columns + column) as usize;
                    let members = &self.members[self.starts[cell] as usize..self.starts[cell + 1] as usize];
                    members.iter().for_each(|&segment| visit(segment));
                }
                column += step;
            }
        }
    }

    /// Whether `p` lies inside, by the winding number of its cell's centre and what lies between.
    fn is_inside(&self, p: Point) -> bool {
        let Some(cell) = self.cell_of(p) else { return false };
        let (column, row) = (cell % self.count[0], cell / self.count[0]);
        let centre = [0, 1].map(|a| self.bounds[0][a] + ([column, row][a] as f64 + 0.5) * self.cell);
        // Along x to the centre's column at p's height, then along y: both stay in this cell.
        let corner = [centre[0], p[1]];
        let mut winding = self.winding[cell];
        for &segment in &self.members[self.starts[cell] as usize..self.starts[cell + 1] as usize] {
            let segment = self.segments[segment as usize];
            winding -= crossings_upward(segment, corner, centre[1]);
            winding -= crossings_rightward(segment, p, corner[0]);
        }
        winding > 0
    }

    /// The cell that holds `p`; `None` outside the grid.
    fn cell_of(&self, p: Point) -> Option<usize> {
        let at = [0, 1].map(|a| ((p[a] - self.bounds[0][a]) / self.cell).floor());
        let inside = (0..2).all(|a| at[a] >= 0.0 && at[a] < self.count[a] as f64);
        inside.then(|| at[1] as usize * self.count[0] + at[0] as usize)
    }

    /// Chessboard distances to the nearest cell with a segment, forward and back over the grid.
    fn count_empty_rings(&mut self) {
        let [columns, rows] = self.count;
        let full = |cell: usize| self.starts[cell] < self.starts[cell + 1];
        let mut rings: Vec<u8> = (0..columns * rows).map(|cell| if full(cell) { 0 } else { u8::MAX }).collect();
        let mut pass = |cells: &mut dyn Iterator<Item = usize>, sign: isize| {
            for cell in cells {
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

    fn file(&mut self) {
        let cells: Vec<[usize; 4]> = self.segments.iter().map(|s| self.cells_of(s)).collect();
        for &[left, right, low, high] in &cells {
            for row in low..=high {
                (left..=right).for_each(|column| self.starts[row * self.count[0] + column] += 1);
            }
        }
        let mut total = 0;
        for start in &mut self.starts {
            total += std::mem::replace(start, total);
        }
        self.members = vec![0; total as usize];
        let mut next = self.starts.clone();
        for (segment, &[left, right, low, high]) in cells.iter().enumerate() {
            for row in low..=high {
                for column in left..=right {
                    let place = &mut next[row * self.count[0] + column];
                    self.members[*place as usize] = segment as u32;
                    *place += 1;
                }
            }
        }
    }

    /// The columns and rows of the segment's box.
    fn cells_of(&self, [a, b]: &Segment) -> [usize; 4] {
        let index = |v: f64, axis: usize| {
            (((v - self.bounds[0][axis]) / self.cell).max(0.0) as usize).min(self.count[axis] - 1)
        };
        [index(a[0].min(b[0]), 0), index(a[0].max(b[0]), 0), index(a[1].min(b[1]), 1), index(a[1].max(b[1]), 1)]
    }

    /// The winding number at each cell's centre, from what crosses its row's middle line, left to right.
    fn wind(&mut self) {
        for row in 0..self.count[1] {
            let y = self.bounds[0][1] + (row as f64 + 0.5) * self.cell;
            let mut crossed: Vec<(f64, i32)> = Vec::new();
            for column in 0..self.count[0] {
                let cell = row * self.count[0] + column;
                for &segment in &self.members[self.starts[cell] as usize..self.starts[cell + 1] as usize] {
                    let segment = self.segments[segment as usize];
                    // A segment stands in several cells; the one of its left end counts.
                    let first = self.cells_of(&segment)[0] == column;
                    if let (Some((x, up)), true) = (crossing(segment, y), first) {
                        crossed.push((x, up));
                    }
                }
            }
            crossed.sort_by(|a, b| a.0.total_cmp(&b.0));
            let (mut next, mut winding) = (0, 0);
            for column in 0..self.count[0] {
                let x = self.bounds[0][0] + (column as f64 + 0.5) * self.cell;
                while next < crossed.len() && crossed[next].0 <= x {
                    // Material is to the left of what goes down, coming from outside.
                    winding -= crossed[next].1;
                    next += 1;
                }
                self.winding[row * self.count[0] + column] = winding;
            }
        }
    }

    /// The distance by trying every segment, for tests.
    #[cfg(test)]
    pub(super) fn by_brute_force(&self, p: Point) -> f64 {
        let mut best = Best { square: CAP_MM * CAP_MM, segment: None, corner: false, left: true };
        self.segments.iter().enumerate().for_each(|(i, s)| best.take(*s, i as u32, p));
        let winding: i32 =
            self.segments.iter().map(|s| crossing(*s, p[1]).map_or(0, |(x, up)| if x <= p[0] { -up } else { 0 })).sum();
        if winding > 0 { -best.square.sqrt() } else { best.square.sqrt() }
    }
}

struct Best {
    square: f64,
    segment: Option<u32>,
    /// Whether the nearest point is an end, where the side is another question.
    corner: bool,
    left: bool,
}

impl Best {
    fn take(&mut self, [a, b]: Segment, index: u32, p: Point) {
        let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
        let (px, py) = (p[0] - a[0], p[1] - a[1]);
        let along = (px * dx + py * dy) / (dx * dx + dy * dy);
        let t = along.clamp(0.0, 1.0);
        let (ex, ey) = (px - dx * t, py - dy * t);
        let square = ex * ex + ey * ey;
        if square < self.square {
            let corner = !(CORNER..=1.0 - CORNER).contains(&along);
            *self = Self { square, segment: Some(index), corner, left: dx * py - dy * px > 0.0 };
        }
    }
}

/// Where a segment crosses the line at height `y`, and +1 where it goes up there, -1 down.
fn crossing([a, b]: Segment, y: f64) -> Option<(f64, i32)> {
    let (above, beyond) = (a[1] > y, b[1] > y);
    (above != beyond).then(|| (a[0] + (b[0] - a[0]) * ((y - a[1]) / (b[1] - a[1])), if beyond { 1 } else { -1 }))
}

/// What the winding number gains on the way from `from` to `x` at the same height.
fn crossings_rightward(segment: Segment, from: Point, x: f64) -> i32 {
    match crossing(segment, from[1]) {
        Some((at, up)) if at > from[0] && at <= x => -up,
        Some((at, up)) if at > x && at <= from[0] => up,
        _ => 0,
    }
}

/// What the winding number gains on the way from `from` to height `y` at the same x.
fn crossings_upward([a, b]: Segment, from: Point, y: f64) -> i32 {
    let swap = |p: Point| [p[1], p[0]];
    match crossing([swap(a), swap(b)], from[0]) {
        Some((at, right)) if at > from[1] && at <= y => right,
        Some((at, right)) if at > y && at <= from[1] => -right,
        _ => 0,
    }
}
