//! In which order, and from where, a layer's lines are printed.

use super::hatch::Stroke;
use super::overhang::Ground;
use super::plan::{Feature, Island, Path, PlannedLayer};
use super::region::{Contour, Point, distance_mm, perimeter_mm};
use super::walls::Loop;

/// How far behind the rearmost point a seam may lie, grid units: rounding must not throw it about.
const REAR_TOLERANCE: i32 = 200;

/// The layer's paths in printing order from `at`, which moves to the end of the last; loops end `clip_mm` early.
///
/// Islands nearest first; in each the walls from the inside out, then infill. Ties go to the first in the layer.
pub(super) fn ordered(layer: &PlannedLayer<'_>, at: &mut Point, clip_mm: f64) -> Vec<Path> {
    let mut paths = Vec::new();
    let mut islands: Vec<&Island<'_>> = layer.islands.iter().collect();
    while let Some(next) = nearest(&islands, |island| distance_mm(*at, island.start())) {
        let island = islands.remove(next);
        add_walls(island, layer.ground.as_ref(), clip_mm, at, &mut paths);
        for fill in &island.fills {
            add_fill(fill.feature, &fill.chains, fill.hop_mm, at, &mut paths);
        }
    }
    paths
}

fn nearest<T>(items: &[T], distance: impl Fn(&T) -> f64) -> Option<usize> {
    let distances: Vec<f64> = items.iter().map(distance).collect();
    (0..items.len()).min_by(|&a, &b| distances[a].total_cmp(&distances[b]))
}

fn add_walls(island: &Island<'_>, ground: Option<&Ground>, clip_mm: f64, at: &mut Point, paths: &mut Vec<Path>) {
    let deepest = island.loops.iter().map(|l| l.depth).max().unwrap_or(0);
    for depth in (0..=deepest).rev() {
        let mut loops: Vec<&Loop> = island.loops.iter().filter(|l| l.depth == depth).collect();
        while let Some(next) = nearest(&loops, |l| distance_mm(*at, l.points[start_of(l, *at)])) {
            let wall = loops.remove(next);
            let points = opened_at(&wall.points, start_of(wall, *at), clip_mm);
            *at = points[points.len() - 1];
            add_stretches(wall, points, ground, paths);
        }
    }
}

fn add_stretches(wall: &Loop, points: Contour, ground: Option<&Ground>, paths: &mut Vec<Path>) {
    let feature = match (wall.depth, wall.flow < 1.0) {
        (0, _) => Feature::OuterWall,
        (_, true) => Feature::Gap,
        (_, false) => Feature::InnerWall,
    };
    let stretches = ground.map_or_else(|| vec![(true, points.clone())], |ground| ground.split(&points));
    paths.extend(stretches.into_iter().map(|(supported, points)| Path {
        feature: if supported { feature } else { Feature::Overhang },
        points,
        flow: wall.flow,
        hop: false,
    }));
}

/// Outer walls start at the rear, the same place on every layer; inner ones wherever is nearest.
fn start_of(wall: &Loop, at: Point) -> usize {
    let points = &wall.points;
    if wall.depth > 0 {
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

fn add_fill(feature: Feature, chains: &[Vec<Stroke>], hop_mm: f64, at: &mut Point, paths: &mut Vec<Path>) {
    let mut left: Vec<&Vec<Stroke>> = chains.iter().collect();
    let ends = |chain: &[Stroke]| (chain[0][0], chain[chain.len() - 1][1]);
    let both = |from: Point, chain: &[Stroke]| {
        let (first, last) = ends(chain);
        (distance_mm(from, first), distance_mm(from, last))
    };
    while let Some(next) = nearest(&left, |chain| both(*at, chain).0.min(both(*at, chain).1)) {
        let mut strokes = left.remove(next).clone();
        let (forward, backward) = both(*at, &strokes);
        if backward < forward {
            strokes.reverse();
            strokes.iter_mut().for_each(|stroke| stroke.swap(0, 1));
        }
        for (i, [a, b]) in strokes.into_iter().enumerate() {
            let hop = i > 0 && distance_mm(*at, a) <= hop_mm;
            paths.push(Path { feature, points: vec![a, b], flow: 1.0, hop });
            *at = b;
        }
    }
}
