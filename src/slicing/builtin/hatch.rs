//! Parallel rows across a region.

use super::Line;
use super::region::{GridPoint, Region, mm, pairs};

/// What of one row lies inside.
pub(super) struct Row {
    pub(super) index: i64,
    pub(super) spans: Vec<(f64, f64)>,
}

/// Parallel rows, in grid units and turned coordinates.
#[derive(Clone, Copy)]
pub(super) struct Lattice {
    /// The rows' direction, rad from +X.
    pub(super) angle: f64,
    /// Half a pitch before the row of index 0.
    origin: f64,
    pub(super) pitch: f64,
}

impl Lattice {
    /// Rows on one lattice through the origin, so that those of all regions and layers stack.
    pub(super) fn common(angle: f64, pitch: f64) -> Self {
        Self { angle, origin: 0.0, pitch }
    }

    /// Those that fill a layer line by line.
    pub(super) fn full(angle: f64, line: &Line) -> Self {
        Self::common(angle, f64::from(line.spacing))
    }

    /// The same, moved across the rows by `shift` grid units.
    pub(super) fn shifted(self, shift: f64) -> Self {
        Self { origin: self.origin + shift, ..self }
    }

    /// Whole rows from border to border of the region, about `pitch` apart: a narrow one is filled wherever it lies.
    pub(super) fn fitted(region: &Region, angle: f64, pitch: f64) -> Self {
        let (sin, cos) = angle.sin_cos();
        let across = region.iter().flatten().flatten().map(|p| f64::from(p.y) * cos - f64::from(p.x) * sin);
        let (low, high) = across.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
        let rows = ((high - low) / pitch).round();
        if rows >= 1.0 { Self { angle, origin: low, pitch: (high - low) / rows } } else { Self::common(angle, pitch) }
    }

    pub(super) fn row(&self, index: i64) -> f64 {
        self.origin + (index as f64 + 0.5) * self.pitch
    }

    /// A point in coordinates turned by minus the angle: along the rows, and across.
    pub(super) fn turned(&self, p: GridPoint) -> (f64, f64) {
        let (sin, cos) = self.angle.sin_cos();
        let (x, y) = (f64::from(p.x), f64::from(p.y));
        (x * cos + y * sin, y * cos - x * sin)
    }

    /// The last row at or before `y`.
    pub(super) fn before(&self, y: f64) -> i64 {
        ((y - self.origin) / self.pitch - 0.5).floor() as i64
    }

    /// The point of a row at `x` along it.
    pub(super) fn point(&self, x: f64, row: i64) -> GridPoint {
        self.place(x, self.row(row))
    }

    /// The point that lies at `x` along the rows, and at `y` across them.
    pub(super) fn place(&self, x: f64, y: f64) -> GridPoint {
        let (sin, cos) = self.angle.sin_cos();
        GridPoint::new((x * cos - y * sin).round() as i32, (x * sin + y * cos).round() as i32)
    }
}

/// The longest line of the hatch, mm; 0 for a region that no line meets.
pub(super) fn longest_mm(region: &Region, lattice: Lattice) -> f64 {
    let spans = rows(region, lattice).into_iter().flat_map(|row| row.spans);
    spans.map(|(a, b)| mm(b - a)).fold(0.0, f64::max)
}

/// Where each line lies inside the region, in coordinates turned by minus the lattice's angle; rows ascend.
pub(super) fn rows(region: &Region, lattice: Lattice) -> Vec<Row> {
    let mut hits: Vec<(i64, f64)> = Vec::new();
    for (a, b) in region.iter().flatten().flat_map(|ring| pairs(ring)) {
        crossings(lattice.turned(a), lattice.turned(b), lattice, &mut hits);
    }
    hits.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let mut rows: Vec<Row> = Vec::new();
    for hits in hits.chunk_by(|a, b| a.0 == b.0) {
        // Each ring is crossed an even number of times, so the hits pair up.
        let spans = hits.chunks_exact(2).map(|pair| (pair[0].1, pair[1].1)).collect();
        rows.push(Row { index: hits[0].0, spans });
    }
    rows
}

/// Crossings of an edge with the rows; its lower end counts, its upper one does not.
pub(super) fn crossings(a: (f64, f64), b: (f64, f64), lattice: Lattice, hits: &mut Vec<(i64, f64)>) {
    let (low, high) = if a.1 <= b.1 { (a, b) } else { (b, a) };
    let row = |y: f64| ((y - lattice.origin) / lattice.pitch - 0.5).ceil() as i64;
    for index in row(low.1)..row(high.1) {
        let y = lattice.row(index);
        hits.push((index, low.0 + (high.0 - low.0) * (y - low.1) / (high.1 - low.1)));
    }
}
