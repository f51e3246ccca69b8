//! A layer's material as `section`'s polygons: cut, grown and measured, mm.

use i_overlay::i_float::int::angle::Angle;
use i_overlay::mesh::int::arc::ArcOptions;
use i_overlay::mesh::int::outline::offset::IntOutlineOffset;
use i_overlay::mesh::int::style::{IntLineJoin, IntOutlineStyle};
use std::collections::BTreeMap;

use crate::section::Segment;
use crate::section::polygons::UNITS_PER_MM;
pub(super) use crate::section::polygons::{GridPoint, Region, Shape, and, minus, or, units, wound};
use crate::section::simplify::simplified;

/// Round corners are drawn in steps of so many degrees: at 0.5 mm the chord lies 2 micrometres inside.
const ROUND_STEP_DEG: f64 = 10.0;
/// What is carried is kept to half a micrometre: half a degree lets 3.5 um pass in a layer of 0.2 mm, 0.9 in one of 0.05.
const KEPT_UNITS: f64 = 5.0;
/// What is drawn by fewer points is grown whole.
const FEW_POINTS: usize = 64;
/// Corners sharper than this are cut off.
const SHARPEST_DEG: f64 = 60.0;

/// The point of the grid nearest to `(x, y)` mm.
pub(super) fn point([x, y]: [f64; 2]) -> GridPoint {
    GridPoint::new(units(x), units(y))
}

/// Its coordinates, mm.
pub(super) fn at(p: GridPoint) -> [f64; 2] {
    [f64::from(p.x) / UNITS_PER_MM, f64::from(p.y) / UNITS_PER_MM]
}

/// The material that a cut's segments go around: wherever they wind at least once. Chains that do not close, of a surface that is
/// not closed, enclose up to a straight line between their ends.
pub(super) fn enclosed(segments: &[Segment]) -> Region {
    wound(&rings(segments.iter().map(|ends| ends.map(point))))
}

/// Edges that follow each other, joined.
fn rings(edges: impl Iterator<Item = [GridPoint; 2]>) -> Vec<Vec<GridPoint>> {
    let mut from: BTreeMap<GridPoint, Vec<GridPoint>> = BTreeMap::new();
    for [a, b] in edges.filter(|[a, b]| a != b) {
        from.entry(a).or_default().push(b);
    }
    let mut rings: Vec<Vec<GridPoint>> = Vec::new();
    while let Some((&start, _)) = from.first_key_value() {
        let mut ring = vec![start];
        let mut last = start;
        while let Some(next) = take(&mut from, last).filter(|next| *next != start) {
            ring.push(next);
            last = next;
        }
        rings.push(ring);
    }
    rings
}

fn take(from: &mut BTreeMap<GridPoint, Vec<GridPoint>>, at: GridPoint) -> Option<GridPoint> {
    let ways = from.get_mut(&at)?;
    let next = ways.pop();
    if ways.is_empty() {
        from.remove(&at);
    }
    next
}

/// The border of polygons of a surface that all look up, or all down: what two of them share runs both ways, and cancels.
#[derive(Default)]
struct Border(BTreeMap<[GridPoint; 2], usize>);

impl Border {
    fn add(&mut self, edge: [GridPoint; 2]) {
        let back = [edge[1], edge[0]];
        match self.0.get_mut(&back) {
            Some(1) => drop(self.0.remove(&back)),
            Some(count) => *count -= 1,
            None => *self.0.entry(edge).or_default() += 1,
        }
    }
}

/// What polygons, mm, cover together; each is said to be seen from above, or from below. Those of a face seen nearly from its side are
/// slivers: joined one by one they would leave thousands of points along their edges, and on the grid some are turned over.
pub(super) fn covered(polygons: impl Iterator<Item = (Vec<[f64; 2]>, bool)>) -> Region {
    let mut borders = [Border::default(), Border::default()];
    for (polygon, above) in polygons {
        let ring: Vec<GridPoint> = polygon.into_iter().map(point).collect();
        let along = edges(&ring).filter(|[a, b]| a != b).map(|[a, b]| if above { [a, b] } else { [b, a] });
        along.for_each(|edge| borders[usize::from(above)].add(edge));
    }
    let all = borders.iter().flat_map(|border| &border.0);
    let rings = rings(all.flat_map(|(edge, count)| std::iter::repeat_n(*edge, *count)));
    with_few_points(&wound(&rings))
}

/// What lines of a width cover.
pub(super) fn strips<'a>(lines: impl Iterator<Item = &'a [[f64; 2]; 2]>, width_mm: f64) -> Region {
    let strip = |[a, b]: &[[f64; 2]; 2]| {
        let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
        let half = width_mm / 2.0 / dx.hypot(dy).max(f64::MIN_POSITIVE);
        let (nx, ny) = (-dy * half, dx * half);
        [[a[0] - nx, a[1] - ny], [b[0] - nx, b[1] - ny], [b[0] + nx, b[1] + ny], [a[0] + nx, a[1] + ny]]
            .map(point)
            .to_vec()
    };
    wound(&lines.map(strip).collect::<Vec<_>>())
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

/// What of a region is no farther than `mm` from the boxes of some pieces; all of one that is drawn by few points.
pub(super) fn about(region: &Region, pieces: &Region, mm: f64) -> Region {
    if region.iter().flatten().map(Vec::len).sum::<usize>() < FEW_POINTS {
        return region.clone();
    }
    let boxes = pieces.iter().map(|piece| {
        let [low, high] = bounds(piece);
        let ([x0, y0], [x1, y1]) = (low.map(|v| v - mm), high.map(|v| v + mm));
        [[x0, y0], [x1, y0], [x1, y1], [x0, y1]].map(point).to_vec()
    });
    and(region, &wound(&boxes.collect::<Vec<_>>()))
}

/// The region with as few points as keep it within half a micrometre: grown and cut layer after layer it would gather hundreds.
pub(super) fn with_few_points(region: &Region) -> Region {
    let ring = |ring: &Vec<GridPoint>| simplified(ring, KEPT_UNITS);
    let shape = |shape: &Shape| shape.iter().map(ring).filter(|ring| ring.len() > 2).collect::<Shape>();
    region.iter().map(shape).filter(|shape| !shape.is_empty()).collect()
}

/// A shape's area, mm²; holes count as missing.
pub(super) fn area_mm2(shape: &Shape) -> f64 {
    let twice: i64 = shape.iter().flat_map(|ring| edges(ring)).map(|[a, b]| cross(a, b)).fold(0, i64::wrapping_add);
    twice as f64 / (2.0 * UNITS_PER_MM * UNITS_PER_MM)
}

fn cross(a: GridPoint, b: GridPoint) -> i64 {
    i64::from(a.x) * i64::from(b.y) - i64::from(b.x) * i64::from(a.y)
}

/// A ring's edges, the closing one last.
pub(super) fn edges(ring: &[GridPoint]) -> impl Iterator<Item = [GridPoint; 2]> + '_ {
    (0..ring.len()).map(|i| [ring[i], ring[(i + 1) % ring.len()]])
}

/// The lengths of a shape's sides, mm.
fn sides_mm(shape: &Shape) -> impl Iterator<Item = f64> + '_ {
    let length = |[[ax, ay], [bx, by]]: [[f64; 2]; 2]| (bx - ax).hypot(by - ay);
    shape.iter().flat_map(|ring| edges(ring)).map(move |ends| length(ends.map(at)))
}

/// The length of a shape's border, mm.
pub(super) fn around_mm(shape: &Shape) -> f64 {
    sides_mm(shape).sum()
}

/// A shape's longest straight side, mm.
pub(super) fn longest_side_mm(shape: &Shape) -> f64 {
    sides_mm(shape).fold(0.0, f64::max)
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

    #[test]
    fn a_face_of_many_facets_seen_nearly_from_its_side_is_one_sliver() {
        // A disc of 200 facets about its middle, 20 mm wide, tilted until it is 0.02 mm wide from above.
        let corner = |k: usize, wide: f64| {
            let (sin, cos) = (std::f64::consts::TAU * k as f64 / 200.0).sin_cos();
            [10.0 * cos, wide / 2.0 * sin]
        };
        for wide in [0.02, 0.3, 20.0] {
            let facet = |k: usize| vec![[0.0, 0.0], corner(k, wide), corner(k + 1, wide)];
            let region = covered((0..200).map(|k| (facet(k), true)));
            let points: usize = region.iter().flatten().map(Vec::len).sum();
            let wanted = 10.0 * wide / 2.0 * 100.0 * (std::f64::consts::TAU / 200.0).sin();
            assert_eq!(region.len(), 1, "{wide}");
            assert!(points <= 200 && (area(&region) - wanted).abs() < 0.02, "{wide}: {points}, {}", area(&region));
        }
        // Two that lie over each other, one seen from below: together they cover what either does.
        let both = |x: f64| vec![[x, 0.0], [x + 2.0, 0.0], [x + 2.0, 1.0], [x, 1.0]];
        let turned = both(1.0).into_iter().rev().collect();
        assert!((area(&covered([(both(0.0), true), (turned, false)].into_iter())) - 3.0).abs() < 1e-9);
    }
}
