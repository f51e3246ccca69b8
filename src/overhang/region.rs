//! A layer's material as `section`'s polygons: cut, grown and measured, mm.

use i_overlay::i_float::int::angle::Angle;
use i_overlay::mesh::int::arc::ArcOptions;
use i_overlay::mesh::int::outline::offset::IntOutlineOffset;
use i_overlay::mesh::int::style::{IntLineJoin, IntOutlineStyle};
use std::collections::BTreeMap;

use crate::section::Segment;
use crate::section::polygons::UNITS_PER_MM;
pub(super) use crate::section::polygons::{Point, Region, Shape, and, minus, or, units, wound};

/// Round corners are drawn in steps of so many degrees: at 0.5 mm the chord lies 2 micrometres inside.
const ROUND_STEP_DEG: f64 = 10.0;
/// Corners sharper than this are cut off.
const SHARPEST_DEG: f64 = 60.0;

/// The point of the grid nearest to `(x, y)` mm.
pub(super) fn point([x, y]: [f64; 2]) -> Point {
    Point::new(units(x), units(y))
}

/// Its coordinates, mm.
pub(super) fn at(p: Point) -> [f64; 2] {
    [f64::from(p.x) / UNITS_PER_MM, f64::from(p.y) / UNITS_PER_MM]
}

/// The material that a cut's segments go around: wherever they wind at least once. Chains that do not close, of a surface that is
/// not closed, enclose up to a straight line between their ends.
pub(super) fn enclosed(segments: &[Segment]) -> Region {
    let mut from: BTreeMap<Point, Vec<Point>> = BTreeMap::new();
    for [a, b] in segments {
        let (a, b) = (point(*a), point(*b));
        if a != b {
            from.entry(a).or_default().push(b);
        }
    }
    let mut rings: Vec<Vec<Point>> = Vec::new();
    while let Some((&start, _)) = from.first_key_value() {
        let mut ring = vec![start];
        let mut last = start;
        while let Some(next) = take(&mut from, last).filter(|next| *next != start) {
            ring.push(next);
            last = next;
        }
        rings.push(ring);
    }
    wound(&rings)
}

fn take(from: &mut BTreeMap<Point, Vec<Point>>, at: Point) -> Option<Point> {
    let ways = from.get_mut(&at)?;
    let next = ways.pop();
    if ways.is_empty() {
        from.remove(&at);
    }
    next
}

/// The triangle, counter-clockwise whatever it was; `None` where it has no area on the grid.
pub(super) fn triangle(corners: [[f64; 2]; 3]) -> Option<Vec<Point>> {
    let [a, b, c] = corners.map(point);
    let [ux, uy, vx, vy] = [b.x - a.x, b.y - a.y, c.x - a.x, c.y - a.y].map(i64::from);
    match (ux * vy - uy * vx).signum() {
        1 => Some(vec![a, b, c]),
        -1 => Some(vec![a, c, b]),
        _ => None,
    }
}

/// What becomes of corners that grow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Corners {
    /// Round: everything within the distance, and nothing else.
    Round,
    /// Sharp where they are not sharper than 60 degrees: every side goes out by the distance.
    Sharp,
}

/// The region and everything within `mm` of it.
pub(super) fn grown(region: &Region, mm: f64, corners: Corners) -> Region {
    let by = units(mm);
    if region.is_empty() || by == 0 {
        return region.clone();
    }
    let angle = |deg: f64| Angle::from_radians(deg.to_radians()).unwrap_or(ArcOptions::MAX_STEP);
    let join = match corners {
        Corners::Round => IntLineJoin::Round(ArcOptions { max_step: angle(ROUND_STEP_DEG), rotation_precision: 8 }),
        Corners::Sharp => IntLineJoin::Miter(angle(SHARPEST_DEG)),
    };
    let style = IntOutlineStyle::new(by).line_join(join);
    // The outline's only error is a range check that construction does not make: the grid reaches 107 m.
    region.outline(&style).unwrap_or_default()
}

/// A shape's area, mm²; holes count as missing.
pub(super) fn area_mm2(shape: &Shape) -> f64 {
    let twice: i64 = shape.iter().flat_map(|ring| edges(ring)).map(|[a, b]| cross(a, b)).fold(0, i64::wrapping_add);
    twice as f64 / (2.0 * UNITS_PER_MM * UNITS_PER_MM)
}

fn cross(a: Point, b: Point) -> i64 {
    i64::from(a.x) * i64::from(b.y) - i64::from(b.x) * i64::from(a.y)
}

/// A ring's edges, the closing one last.
pub(super) fn edges(ring: &[Point]) -> impl Iterator<Item = [Point; 2]> + '_ {
    (0..ring.len()).map(|i| [ring[i], ring[(i + 1) % ring.len()]])
}

/// The box around a shape, mm: lowest and highest corner.
pub(super) fn bounds(shape: &Shape) -> [[f64; 2]; 2] {
    let all = shape.iter().flatten().map(|p| at(*p));
    all.fold([[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]], |[low, high], p| {
        [[low[0].min(p[0]), low[1].min(p[1])], [high[0].max(p[0]), high[1].max(p[1])]]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(low: f64, high: f64) -> Region {
        let corners = [[low, low], [high, low], [high, high], [low, high]];
        let segments: Vec<Segment> = (0..4).map(|i| [corners[i], corners[(i + 1) % 4]]).collect();
        enclosed(&segments)
    }

    fn area(region: &Region) -> f64 {
        region.iter().map(area_mm2).sum()
    }

    #[test]
    fn squares_by_hand() {
        let (large, small) = (square(0.0, 10.0), square(4.0, 6.0));
        assert!((area(&minus(&large, &small)) - 96.0).abs() < 1e-9);
        assert!((area(&and(&large, &square(8.0, 12.0))) - 4.0).abs() < 1e-9);
        assert!((area(&or(&large, &square(8.0, 12.0))) - 112.0).abs() < 1e-9);
        // Grown by 0.5 mm: four strips, and four quarters of a disc drawn a little inside.
        let more = area(&grown(&large, 0.5, Corners::Round)) - 100.0;
        let wanted = 20.0 + std::f64::consts::PI * 0.25;
        assert!(more <= wanted && more > wanted - 0.02, "{more} for {wanted}");
        // A hole shrinks by as much.
        let ring = minus(&large, &small);
        assert!((area(&grown(&ring, 0.5, Corners::Round)) - (100.0 + more - 1.0)).abs() < 1e-3);
    }
}
