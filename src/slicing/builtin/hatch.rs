//! Parallel lines across a region.

use super::region::{Point, Region, distance_mm, mm, pairs};

/// A straight line of extrusion.
pub(super) type Stroke = [Point; 2];

/// Strokes shorter than this are left out, mm: an extruder cannot meter them.
const SHORTEST_MM: f64 = 0.1;

struct Row {
    index: i64,
    spans: Vec<(f64, f64)>,
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

    /// Whole rows from border to border of the region, about `pitch` apart: a narrow one is filled wherever it lies.
    pub(super) fn fitted(region: &Region, angle: f64, pitch: f64) -> Self {
        let (sin, cos) = angle.sin_cos();
        let across = region.iter().flatten().flatten().map(|p| f64::from(p.y) * cos - f64::from(p.x) * sin);
        let (low, high) = across.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
        let rows = ((high - low) / pitch).round();
        if rows >= 1.0 { Self { angle, origin: low, pitch: (high - low) / rows } } else { Self::common(angle, pitch) }
    }

    fn row(&self, index: i64) -> f64 {
        self.origin + (index as f64 + 0.5) * self.pitch
    }
}

/// Lines across the region, as chains of neighbours run to and fro.
pub(super) fn chains(region: &Region, lattice: Lattice) -> Vec<Vec<Stroke>> {
    let rows = rows(region, lattice);
    let mut used: Vec<Vec<bool>> = rows.iter().map(|row| vec![false; row.spans.len()]).collect();
    let mut found = Vec::new();
    for row in 0..rows.len() {
        for span in 0..rows[row].spans.len() {
            if !used[row][span] {
                let chain = chain(&rows, &mut used, (row, span), lattice);
                found.extend((!chain.is_empty()).then_some(chain));
            }
        }
    }
    found
}

/// The longest line of the hatch, mm; 0 for a region that no line meets.
pub(super) fn longest_mm(region: &Region, lattice: Lattice) -> f64 {
    let spans = rows(region, lattice).into_iter().flat_map(|row| row.spans);
    spans.map(|(a, b)| mm(b - a)).fold(0.0, f64::max)
}

/// Where each line lies inside the region, in coordinates turned by minus the lattice's angle; rows ascend.
fn rows(region: &Region, lattice: Lattice) -> Vec<Row> {
    let (sin, cos) = lattice.angle.sin_cos();
    let turned = |p: Point| {
        let (x, y) = (f64::from(p.x), f64::from(p.y));
        (x * cos + y * sin, y * cos - x * sin)
    };
    let mut hits: Vec<(i64, f64)> = Vec::new();
    for (a, b) in region.iter().flatten().flat_map(|ring| pairs(ring)) {
        crossings(turned(a), turned(b), lattice, &mut hits);
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
fn crossings(a: (f64, f64), b: (f64, f64), lattice: Lattice, hits: &mut Vec<(i64, f64)>) {
    let (low, high) = if a.1 <= b.1 { (a, b) } else { (b, a) };
    let row = |y: f64| ((y - lattice.origin) / lattice.pitch - 0.5).ceil() as i64;
    for index in row(low.1)..row(high.1) {
        let y = lattice.row(index);
        hits.push((index, low.0 + (high.0 - low.0) * (y - low.1) / (high.1 - low.1)));
    }
}

fn chain(rows: &[Row], used: &mut [Vec<bool>], start: (usize, usize), lattice: Lattice) -> Vec<Stroke> {
    let (sin, cos) = lattice.angle.sin_cos();
    let mut strokes = Vec::new();
    let mut next = Some(start);
    while let Some((row, span)) = next {
        used[row][span] = true;
        let y = lattice.row(rows[row].index);
        let (from, to) = rows[row].spans[span];
        let [a, b] =
            [from, to].map(|x| Point::new((x * cos - y * sin).round() as i32, (x * sin + y * cos).round() as i32));
        if distance_mm(a, b) >= SHORTEST_MM {
            strokes.push(if strokes.len() % 2 == 0 { [a, b] } else { [b, a] });
        }
        next = rows.get(row + 1).filter(|above| above.index == rows[row].index + 1).and_then(|above| {
            let free = |i: &usize| !used[row + 1][*i] && above.spans[*i].0 < to && above.spans[*i].1 > from;
            (0..above.spans.len()).find(free).map(|i| (row + 1, i))
        });
    }
    strokes
}

#[cfg(test)]
mod tests {
    use super::super::region::{Contour, enclosed};
    use super::*;

    fn square(x0: i32, x1: i32) -> Contour {
        [(x0, x0), (x1, x0), (x1, x1), (x0, x1)].map(|(x, y)| Point::new(x, y)).to_vec()
    }

    #[test]
    fn lines_cover_a_square_at_any_angle_as_densely_as_told() {
        let region = enclosed(&[square(0, 100_000)]);
        for angle in [0.0, 0.3, 0.785, 1.57, 2.4] {
            let chains = chains(&region, Lattice::common(angle, 4000.0));
            assert_eq!(chains.len(), 1, "one convex region is one chain");
            let length: f64 = chains[0].iter().map(|[a, b]| distance_mm(*a, *b)).sum();
            assert!((length * 0.4 - 100.0).abs() < 0.5, "{angle}: {length} mm");
        }
    }

    #[test]
    fn a_fitted_lattice_has_its_outer_lines_half_a_pitch_inside() {
        for (low, high) in [(0, 10_000), (3_333, 15_000), (-777, 4_100)] {
            let region = enclosed(&[square(low, high)]);
            let lattice = Lattice::fitted(&region, 0.0, 4000.0);
            let rows: Vec<f64> = chains(&region, lattice).concat().iter().map(|[a, _]| f64::from(a.y)).collect();
            let wanted = (f64::from(high - low) / 4000.0).round();
            assert_eq!(rows.len() as f64, wanted);
            assert!((rows[0] - f64::from(low) - lattice.pitch / 2.0).abs() < 1.0, "{rows:?}");
            assert!((f64::from(high) - rows[rows.len() - 1] - lattice.pitch / 2.0).abs() < 1.0, "{rows:?}");
        }
    }

    #[test]
    fn no_line_crosses_a_hole() {
        let mut hole = square(40_000, 60_000);
        hole.reverse();
        let region = enclosed(&[square(0, 100_000), hole]);
        let strokes: Vec<Stroke> = chains(&region, Lattice::common(0.0, 5000.0)).concat();
        let length: f64 = strokes.iter().map(|[a, b]| distance_mm(*a, *b)).sum();
        assert!((length - (20.0 * 10.0 - 4.0 * 2.0)).abs() < 1e-6, "{length}");
    }
}
