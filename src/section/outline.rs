//! One cut: segments with material to their left, in a grid of cells.

use hashbrown::HashMap;

use super::grid::{Nearest, PlanePoint, Segment, Segments, to_segment};
use super::overlap;

/// Distances beyond this are not told apart, mm: wider than any line, and the search stays among neighbours.
const CAP_MM: f64 = 2.0;

/// What crosses a line so near to a point of it is asked for its side, mm.
const UNSURE_MM: f64 = 1e-6;

/// A cross-section of a part.
pub struct Section {
    segments: Segments,
    /// The winding number at each cell's centre.
    winding: Vec<i32>,
}

impl Section {
    pub(crate) fn new(segments: Vec<Segment>) -> Self {
        let section = Self::of(segments);
        let overlaps = match overlap::apart(&section.segments) {
            Some(curves) => section.overlaps(&curves),
            None => section.overlaps(section.segments()) || overlap::cross(&section.segments),
        };
        // Curves that are not closed are told as they are.
        overlaps.then(|| overlap::enclosed(section.segments.all())).flatten().map_or(section, Self::of)
    }

    pub(super) fn of(segments: Vec<Segment>) -> Self {
        let segments = Segments::new(segments);
        let mut section = Self { winding: Vec::new(), segments };
        section.wind();
        section
    }

    /// Whether nothing is cut.
    pub fn is_empty(&self) -> bool {
        self.segments.all().is_empty()
    }

    /// The outline, in no order; material to the left of each segment.
    pub fn segments(&self) -> &[Segment] {
        self.segments.all()
    }

    /// Lowest and highest corner of the outline, mm; infinite and inside out where nothing is cut.
    pub fn bounds(&self) -> [PlanePoint; 2] {
        self.segments.bounds()
    }

    /// Length of the outline, mm.
    pub fn perimeter(&self) -> f64 {
        self.segments().iter().map(|[a, b]| (b[0] - a[0]).hypot(b[1] - a[1])).sum()
    }

    /// What the outline encloses, mm².
    pub fn area(&self) -> f64 {
        let origin = self.bounds()[0];
        let cross =
            |[a, b]: &Segment| (a[0] - origin[0]) * (b[1] - origin[1]) - (b[0] - origin[0]) * (a[1] - origin[1]);
        self.segments().iter().map(cross).sum::<f64>() / 2.0
    }

    /// The outline's closed curves: for each of [`Self::segments`] the number of its curve. Segments belong together where they meet
    /// in the same point to the last bit, as the cuts of two facets with a common edge do.
    pub fn curves(&self) -> Vec<u32> {
        let key = |p: PlanePoint| p.map(|v| (v + 0.0).to_bits());
        let from: HashMap<[u64; 2], usize> = self.segments().iter().enumerate().map(|(i, s)| (key(s[0]), i)).collect();
        let mut curves = vec![u32::MAX; self.segments().len()];
        let mut count = 0;
        for first in 0..curves.len() {
            let mut at = Some(first);
            while let Some(segment) = at.filter(|&i| curves[i] == u32::MAX) {
                curves[segment] = count;
                at = from.get(&key(self.segments()[segment][1])).copied();
            }
            // A curve that runs into an earlier one, where two touch in a point, is a part of that.
            match at.map(|i| curves[i]).filter(|&met| met != count) {
                Some(met) => curves[first..].iter_mut().filter(|c| **c == count).for_each(|c| *c = met),
                None => count += 1,
            }
        }
        curves
    }

    /// The distance (mm) of `p` from the outline, negative inside; beyond 2 mm from it, 2 or -2.
    pub fn signed_distance(&self, p: PlanePoint) -> f64 {
        self.search().signed_distance(p)
    }

    /// The same with the outward unit normal of the nearest segment; `None` where that is farther than 2 mm.
    pub fn nearest(&self, p: PlanePoint) -> (f64, Option<PlanePoint>) {
        self.search().nearest(p)
    }

    /// The distance between two outlines, mm, exactly: that of a corner of one from a side of the other; 0 where they meet, or one lies in
    /// the other. Infinite where either is empty.
    pub fn apart(&self, other: &Self) -> f64 {
        let from = |a: &Self, b: &Self| {
            let corner = |&corner: &PlanePoint| {
                let sides = b.segments().iter().map(|side| to_segment(corner, *side));
                if b.is_inside(corner) { 0.0 } else { sides.fold(f64::INFINITY, f64::min) }
            };
            a.segments().iter().flatten().map(corner).fold(f64::INFINITY, f64::min)
        };
        let cross = |way: &Segment| other.segments().iter().any(|side| crosses(*way, *side));
        if self.segments().iter().any(cross) { 0.0 } else { from(self, other).min(from(other, self)) }
    }

    /// Whether the outline meets or touches the way from one point to another.
    pub fn meets(&self, way: Segment) -> bool {
        self.segments.meets(way)
    }

    /// For questions about points that follow one another.
    pub fn search(&self) -> OutlineSearch<'_> {
        OutlineSearch { section: self, last: None }
    }

    /// Whether one of these segments has more than one shell to its left, asked beside its middle: then shells overlap, and the nearest segment to a
    /// point does not tell its side. Those that only touch do not.
    pub(super) fn overlaps(&self, segments: &[Segment]) -> bool {
        segments.iter().any(|[a, b]| {
            let along = [b[0] - a[0], b[1] - a[1]];
            let share = UNSURE_MM / along[0].hypot(along[1]).max(UNSURE_MM);
            self.turns([(a[0] + b[0]) / 2.0 - along[1] * share, (a[1] + b[1]) / 2.0 + along[0] * share]) > 1
        })
    }

    /// Whether `p` lies inside.
    pub fn is_inside(&self, p: PlanePoint) -> bool {
        self.turns(p) > 0
    }

    /// The winding number of `p`, by that of its cell's centre and what lies between.
    fn turns(&self, p: PlanePoint) -> i32 {
        let Some(cell) = self.segments.cell_of(p) else { return 0 };
        let columns = self.segments.count()[0];
        let centre = self.segments.centre([cell % columns, cell / columns]);
        // Along x to the centre's column at p's height, then along y: both stay in this cell.
        let corner = [centre[0], p[1]];
        let mut winding = self.winding[cell];
        for &segment in self.segments.members(cell) {
            winding -= crossings_upward(segment, corner, centre[1]);
            winding -= crossings_rightward(segment, p, corner[0]);
        }
        winding
    }

    /// The winding number at each cell's centre, from what crosses its row's middle line, left to right.
    fn wind(&mut self) {
        let [columns, rows] = self.segments.count();
        self.winding = vec![0; columns * rows];
        let mut crossed: Vec<(f64, i32, Segment)> = Vec::new();
        for row in 0..rows {
            let (y, left) = (self.segments.centre([0, row])[1], self.bounds()[0][0]);
            crossed.clear();
            for column in 0..columns {
                for &segment in self.segments.members(row * columns + column) {
                    // A segment stands in several cells; the one in which it crosses the line counts.
                    let at = |x: f64| (((x - left) / self.segments.cell_mm()).max(0.0) as usize).min(columns - 1);
                    if let Some((x, up)) = crossing(segment, y).filter(|(x, _)| at(*x) == column) {
                        crossed.push((x, up, segment));
                    }
                }
            }
            crossed.sort_by(|a, b| a.0.total_cmp(&b.0));
            let (mut next, mut winding) = (0, 0);
            for column in 0..columns {
                let x = self.segments.centre([column, row])[0];
                while next < crossed.len() && crossed[next].0 <= x - UNSURE_MM {
                    // Material is to the left of what goes down, coming from outside.
                    winding -= crossed[next].1;
                    next += 1;
                }
                // Of what runs through the centre itself the side is told as everywhere.
                let near = crossed[next..].iter().take_while(|(at, ..)| *at <= x + UNSURE_MM);
                let here: i32 = near.filter(|(.., s)| is_right(*s, [x, y])).map(|(_, up, _)| up).sum();
                self.winding[row * columns + column] = winding - here;
            }
        }
    }

    /// The segments in their cells, for tests.
    #[cfg(test)]
    pub(super) fn parts(&self) -> &Segments {
        &self.segments
    }

    /// The distance by trying every segment, for tests.
    #[cfg(test)]
    pub(super) fn by_brute_force(&self, p: PlanePoint) -> f64 {
        let mut best = super::grid::Nearer { square: CAP_MM * CAP_MM, index: None, corner: false, left: true };
        self.segments().iter().enumerate().for_each(|(i, s)| best.take(*s, Some(i as u32), p));
        let winding: i32 = self
            .segments()
            .iter()
            .map(|s| crossing(*s, p[1]).map_or(0, |(x, up)| if x <= p[0] { -up } else { 0 }))
            .sum();
        if winding > 0 { -best.square.sqrt() } else { best.square.sqrt() }
    }
}

/// Distances from a [`Section`]'s outline, one point after the other: the segment that was nearest to the last one is tried
/// first.
pub struct OutlineSearch<'a> {
    section: &'a Section,
    last: Option<u32>,
}

impl OutlineSearch<'_> {
    /// See [`Section::signed_distance`].
    pub fn signed_distance(&mut self, p: PlanePoint) -> f64 {
        self.within(p, CAP_MM).map_or_else(|| self.far(p, CAP_MM), |near| self.signed(p, &near))
    }

    /// See [`Section::nearest`].
    pub fn nearest(&mut self, p: PlanePoint) -> (f64, Option<PlanePoint>) {
        let Some(near) = self.within(p, CAP_MM) else { return (self.far(p, CAP_MM), None) };
        let [a, b] = self.section.segments()[near.index as usize];
        let length = (b[0] - a[0]).hypot(b[1] - a[1]);
        (self.signed(p, &near), Some([(b[1] - a[1]) / length, (a[0] - b[0]) / length]))
    }

    /// The signed distance (mm) where `p` lies outside or not deeper inside than `exact`; else a negative number that the true
    /// one does not exceed.
    pub fn shallow(&mut self, p: PlanePoint, exact: f64) -> f64 {
        if let Some(near) = self.within(p, exact) {
            return self.signed(p, &near);
        }
        match self.section.segments.cell_of(p).filter(|_| self.section.is_inside(p)) {
            Some(cell) => -self.section.segments.least_away(p, cell).max(exact),
            None => self.signed_distance(p),
        }
    }

    fn within(&mut self, p: PlanePoint, cap: f64) -> Option<Nearest> {
        let near = self.section.segments.nearest(p, cap, self.last);
        self.last = near.map_or(self.last, |near| Some(near.index));
        near
    }

    fn signed(&self, p: PlanePoint, near: &Nearest) -> f64 {
        let inside = if near.corner { self.section.is_inside(p) } else { near.left };
        if inside { -near.distance } else { near.distance }
    }

    fn far(&self, p: PlanePoint, mm: f64) -> f64 {
        if self.section.is_inside(p) { -mm } else { mm }
    }
}

/// Where a segment crosses the line at height `y`, and +1 where it goes up there, -1 down.
fn crossing([a, b]: Segment, y: f64) -> Option<(f64, i32)> {
    let (above, beyond) = (a[1] > y, b[1] > y);
    (above != beyond).then(|| (a[0] + (b[0] - a[0]) * ((y - a[1]) / (b[1] - a[1])), if beyond { 1 } else { -1 }))
}

/// What the winding number gains on the way from `from` to `x` at the same height.
fn crossings_rightward([a, b]: Segment, from: PlanePoint, x: f64) -> i32 {
    let y = from[1];
    if (a[1] > y) == (b[1] > y) {
        return 0;
    }
    let up = if b[1] > y { 1 } else { -1 };
    up * (i32::from(is_right([a, b], from)) - i32::from(is_right([a, b], [x, y])))
}

/// What the winding number gains on the way from `from` to height `y` at the same x.
fn crossings_upward([a, b]: Segment, from: PlanePoint, y: f64) -> i32 {
    let x = from[0];
    if (a[0] > x) == (b[0] > x) {
        return 0;
    }
    let right = if b[0] > x { 1 } else { -1 };
    right * (i32::from(is_above([a, b], [x, y])) - i32::from(is_above([a, b], from)))
}

/// Whether `p` lies above the line of a segment that is not upright, asked one way for each segment and point: whichever line of sight
/// asks, the answer is the same, though it be rounding that decides. On the line, `p` counts as a little to the right, and as far less
/// a little higher, which is also what `>` says of its coordinates.
fn is_above([a, b]: Segment, p: PlanePoint) -> bool {
    let [l, r] = if a < b { [a, b] } else { [b, a] };
    let side = (r[0] - l[0]) * (p[1] - l[1]) - (r[1] - l[1]) * (p[0] - l[0]);
    side > 0.0 || side == 0.0 && r[1] <= l[1]
}

/// The same to the right of one that is not level.
fn is_right([a, b]: Segment, p: PlanePoint) -> bool {
    let rises = if a < b { b[1] > a[1] } else { a[1] > b[1] };
    is_above([a, b], p) != rises
}

/// Whether two segments cross at a point within both; not where one ends on the other, or runs along it.
fn crosses([a, b]: Segment, [c, d]: Segment) -> bool {
    let side =
        |p: PlanePoint, q: PlanePoint, r: PlanePoint| (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
    side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0
}
