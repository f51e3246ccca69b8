//! In which order, and from where, a layer's lines are printed.

use super::hatch::Stroke;
use super::overhang::Ground;
use super::plan::{Feature, Fill, Island, Path, PlannedLayer};
use super::region::{Contour, Point, distance_mm, perimeter_mm};
use super::walls::Bead;

/// How far behind the rearmost point a seam may lie, grid units: rounding must not throw it about.
const REAR_TOLERANCE: i32 = 200;

/// The layer's paths in printing order from `at`, which moves to the end of the last; loops end `clip_mm` early.
///
/// Islands nearest first; in each the walls from the inside out, then infill. Ties go to the first in the layer.
pub(super) fn ordered(layer: &PlannedLayer<'_>, at: &mut Point, clip_mm: f64) -> Vec<Path> {
    let mut paths = Vec::new();
    // Where each begins is asked once: with thousands of islands, everything else would be.
    let mut islands: Vec<(Point, &Island<'_>)> = layer.islands.iter().map(|island| (island.start(), island)).collect();
    while let Some(next) = nearest_start(&islands, *at) {
        let (_, island) = islands.remove(next);
        add_walls(island, layer.ground.as_ref(), clip_mm, at, &mut paths);
        for alike in island.fills.chunk_by(|a, b| a.feature == b.feature) {
            let mut left: Vec<&Fill> = alike.iter().collect();
            let away = |at: Point, fill: &Fill| {
                fill.chains.iter().flat_map(|chain| ends_from(at, chain)).fold(f64::INFINITY, f64::min)
            };
            while let Some(next) = nearest(&left, |fill| away(*at, fill)) {
                add_fill(left.remove(next), at, &mut paths);
            }
        }
    }
    paths
}

fn nearest_start(islands: &[(Point, &Island<'_>)], at: Point) -> Option<usize> {
    let away = |p: Point| (i64::from(p.x) - i64::from(at.x)).pow(2) + (i64::from(p.y) - i64::from(at.y)).pow(2);
    (0..islands.len()).min_by_key(|&i| away(islands[i].0))
}

fn nearest<T>(items: &[T], distance: impl Fn(&T) -> f64) -> Option<usize> {
    let distances: Vec<f64> = items.iter().map(distance).collect();
    (0..items.len()).min_by(|&a, &b| distances[a].total_cmp(&distances[b]))
}

fn add_walls(island: &Island<'_>, ground: Option<&Ground>, clip_mm: f64, at: &mut Point, paths: &mut Vec<Path>) {
    let deepest = island.beads.iter().map(|bead| bead.depth).max().unwrap_or(0);
    for depth in (0..=deepest).rev() {
        let mut beads: Vec<&Bead> = island.beads.iter().filter(|bead| bead.depth == depth).collect();
        while let Some(next) = nearest(&beads, |bead| distance_mm(*at, bead.points[start_of(bead, *at)])) {
            let bead = beads.remove(next);
            let (points, widths) = laid_from(bead, start_of(bead, *at), clip_mm);
            *at = points[points.len() - 1];
            add_stretches(bead, &points, &widths, ground, paths);
        }
    }
}

/// The bead's points in the order in which they are printed, and the width of each leg.
fn laid_from(bead: &Bead, start: usize, clip_mm: f64) -> (Contour, Vec<f64>) {
    let mut widths = bead.widths.clone();
    if bead.closed {
        let points = opened_at(&bead.points, start, clip_mm);
        if !widths.is_empty() {
            widths.rotate_left(start);
            widths.truncate(points.len() - 1);
        }
        return (points, widths);
    }
    let mut points = bead.points.clone();
    if start > 0 {
        points.reverse();
        widths.reverse();
    }
    (points, widths)
}

/// The bead cut where its width changes and where what carries it does.
fn add_stretches(bead: &Bead, points: &[Point], widths: &[f64], ground: Option<&Ground>, paths: &mut Vec<Path>) {
    let feature = match (bead.depth, widths.is_empty()) {
        (0, _) => Feature::OuterWall,
        (_, false) => Feature::Gap,
        (_, true) => Feature::InnerWall,
    };
    let mut add = |points: &[Point], width_mm: Option<f64>| {
        let stretches = ground.map_or_else(|| vec![(true, points.to_vec())], |ground| ground.split(points));
        paths.extend(stretches.into_iter().map(|(supported, points)| Path {
            feature: if supported { feature } else { Feature::Overhang },
            points,
            width_mm,
            hop: false,
        }));
    };
    if widths.is_empty() {
        add(points, None);
        return;
    }
    let mut from = 0;
    for alike in widths.chunk_by(|a, b| (a - b).abs() < 0.5e-3) {
        add(&points[from..=from + alike.len()], Some(alike[0]));
        from += alike.len();
    }
}

/// Outer walls start at the rear, the same place on every layer; inner ones wherever is nearest, open lines at the nearer end.
fn start_of(bead: &Bead, at: Point) -> usize {
    let points = &bead.points;
    if !bead.closed {
        let last = points.len() - 1;
        return if distance_mm(at, points[last]) < distance_mm(at, points[0]) { last } else { 0 };
    }
    if bead.depth > 0 {
        return nearest(points, |&p| distance_mm(at, p)).unwrap_or(0);
    }
    rearmost(points)
}

/// The vertex with the greatest y; of several, the one with the greatest x.
pub(super) fn rearmost(points: &[Point]) -> usize {
    let rear = points.iter().map(|p| p.y).max().unwrap_or(0) - REAR_TOLERANCE;
    (0..points.len()).filter(|&i| points[i].y >= rear).max_by_key(|&i| (points[i].x, usize::MAX - i)).unwrap_or(0)
}

/// The ring as a line from `start` round, ending `clip_mm` before it.
fn opened_at(ring: &[Point], start: usize, clip_mm: f64) -> Contour {
    let mut line: Contour = (0..=ring.len()).map(|i| ring[(start + i) % ring.len()]).collect();
    if perimeter_mm(ring) < 4.0 * clip_mm {
        return line;
    }
    let mut left = clip_mm;
    while let [.., before, last] = line[..] {
        let length = distance_mm(before, last);
        line.pop();
        if length > left {
            let share = 1.0 - left / length;
            let along = |a: i32, b: i32| a + (share * f64::from(b - a)).round() as i32;
            line.push(Point::new(along(before.x, last.x), along(before.y, last.y)));
            break;
        }
        left -= length;
    }
    line
}

fn add_fill(fill: &Fill, at: &mut Point, paths: &mut Vec<Path>) {
    let mut left: Vec<&Vec<Stroke>> = fill.chains.iter().collect();
    while let Some(next) = nearest(&left, |chain| ends_from(*at, chain).into_iter().fold(f64::INFINITY, f64::min)) {
        let mut strokes = left.remove(next).clone();
        let [forward, backward] = ends_from(*at, &strokes);
        if backward < forward {
            strokes.reverse();
            strokes.iter_mut().for_each(|stroke| stroke.swap(0, 1));
        }
        for (i, [a, b]) in strokes.into_iter().enumerate() {
            let hop = i > 0 && distance_mm(*at, a) <= fill.hop_mm;
            paths.push(Path { feature: fill.feature, points: vec![a, b], width_mm: fill.width_mm, hop });
            *at = b;
        }
    }
}

/// How far a chain's two ends are, mm.
fn ends_from(from: Point, chain: &[Stroke]) -> [f64; 2] {
    [chain[0][0], chain[chain.len() - 1][1]].map(|end| distance_mm(from, end))
}
