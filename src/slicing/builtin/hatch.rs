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

/// Lines at `angle` (rad from +X) and `spacing` (grid units), as chains of neighbours run to and fro.
///
/// The lines of all regions and layers lie on one lattice through the origin, so that equal layers stack.
pub(super) fn chains(region: &Region, angle: f64, spacing: f64) -> Vec<Vec<Stroke>> {
    let rows = rows(region, angle, spacing);
    let mut used: Vec<Vec<bool>> = rows.iter().map(|row| vec![false; row.spans.len()]).collect();
    let mut found = Vec::new();
    for row in 0..rows.len() {
        for span in 0..rows[row].spans.len() {
            if !used[row][span] {
                let chain = chain(&rows, &mut used, (row, span), angle, spacing);
                found.extend((!chain.is_empty()).then_some(chain));
            }
        }
    }
    found
}

/// The longest line of the hatch, mm; 0 for a region that no line meets.
pub(super) fn longest_mm(region: &Region, angle: f64, spacing: f64) -> f64 {
    let spans = rows(region, angle, spacing).into_iter().flat_map(|row| row.spans);
    spans.map(|(a, b)| mm(b - a)).fold(0.0, f64::max)
}

/// Where each line lies inside the region, in coordinates turned by `-angle`; rows ascend.
fn rows(region: &Region, angle: f64, spacing: f64) -> Vec<Row> {
    let (sin, cos) = angle.sin_cos();
    let turned = |p: Point| {
        let (x, y) = (f64::from(p.x), f64::from(p.y));
        (x * cos + y * sin, y * cos - x * sin)
    };
    let mut hits: Vec<(i64, f64)> = Vec::new();
    for (a, b) in region.iter().flatten().flat_map(|ring| pairs(ring)) {
        crossings(turned(a), turned(b), spacing, &mut hits);
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

/// Crossings of an edge with the rows `y = (row + 1/2) * spacing`; its lower end counts, its upper one does not.
fn crossings(a: (f64, f64), b: (f64, f64), spacing: f64, hits: &mut Vec<(i64, f64)>) {
    let (low, high) = if a.1 <= b.1 { (a, b) } else { (b, a) };
    let row = |y: f64| (y / spacing - 0.5).ceil() as i64;
    for index in row(low.1)..row(high.1) {
        let y = (index as f64 + 0.5) * spacing;
        hits.push((index, low.0 + (high.0 - low.0) * (y - low.1) / (high.1 - low.1)));
    }
}

fn chain(rows: &[Row], used: &mut [Vec<bool>], start: (usize, usize), angle: f64, spacing: f64) -> Vec<Stroke> {
    let (sin, cos) = angle.sin_cos();
    let mut strokes = Vec::new();
    let mut next = Some(start);
    while let Some((row, span)) = next {
        used[row][span] = true;
        let y = (rows[row].index as f64 + 0.5) * spacing;
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
            let chains = chains(&region, angle, 4000.0);
            assert_eq!(chains.len(), 1, "one convex region is one chain");
            let length: f64 = chains[0].iter().map(|[a, b]| distance_mm(*a, *b)).sum();
            assert!((length * 0.4 - 100.0).abs() < 0.5, "{angle}: {length} mm");
        }
    }

    #[test]
    fn no_line_crosses_a_hole() {
        let mut hole = square(40_000, 60_000);
        hole.reverse();
        let region = enclosed(&[square(0, 100_000), hole]);
        let strokes: Vec<Stroke> = chains(&region, 0.0, 5000.0).concat();
        let length: f64 = strokes.iter().map(|[a, b]| distance_mm(*a, *b)).sum();
        assert!((length - (20.0 * 10.0 - 4.0 * 2.0)).abs() < 1e-6, "{length}");
    }
}
