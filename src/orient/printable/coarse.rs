//! A part of many facets with fewer: corners gathered in cells, for a first look at hundreds of poses.

use std::collections::HashMap;

use super::super::Facets;
use super::super::facets::Facet;
use crate::geom::{Bounds, Vec3};

/// A part of fewer facets is looked at as it is.
const MOST_FACETS: usize = 8_000;
/// Cells along the part's longest side, first; fewer until there are few enough facets.
const CELLS: f64 = 128.0;
const FEWEST: f64 = 24.0;

/// The part with at most some thousand facets; `None` where it has no more.
///
/// All corners in a cell of a cube's grid become their mean, and facets that lose their area so are left out. Every facet's
/// sides stay shared by the same facets, so a closed part is still entered as often as it is left.
pub(super) fn coarse(facets: &Facets) -> Option<Facets> {
    let mut cells = CELLS;
    let mut from = None;
    loop {
        let known = from.as_ref().unwrap_or(facets);
        if known.each.len() <= MOST_FACETS || cells < FEWEST {
            return from;
        }
        from = Some(gathered(facets, cells));
        cells *= 0.7;
    }
}

fn gathered(facets: &Facets, cells: f64) -> Facets {
    let bounds = Bounds::of(facets.points.iter().copied());
    let width = bounds.size().max() / cells;
    let mut numbers: HashMap<[i32; 3], u32> = HashMap::new();
    let mut sums: Vec<(Vec3, f64)> = Vec::new();
    let place = |p: &Vec3| [0, 1, 2].map(|k| ((p[k] - bounds.min[k]) / width).floor() as i32);
    let mut of_point = Vec::with_capacity(facets.points.len());
    for point in &facets.points {
        let number = *numbers.entry(place(point)).or_insert(sums.len() as u32);
        if number as usize == sums.len() {
            sums.push((Vec3::zeros(), 0.0));
        }
        let (sum, count) = &mut sums[number as usize];
        (*sum, *count) = (*sum + (point - bounds.min), *count + 1.0);
        of_point.push(number);
    }
    let points: Vec<Vec3> = sums.into_iter().map(|(sum, count)| bounds.min + sum / count).collect();
    let (mut each, mut corners) = (Vec::new(), Vec::new());
    for facet in &facets.corners {
        let kept = facet.map(|i| of_point[i as usize]);
        let [a, b, c] = kept.map(|i| points[i as usize]);
        let area = (b - a).cross(&(c - a)) * 0.5;
        if area.norm_squared() > 0.0 {
            each.push(Facet { area, barycentre: (a + b + c) / 3.0 });
            corners.push(kept);
        }
    }
    Facets::gathered(each, corners, points)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Object;
    use crate::mesh::TriangleMesh;

    /// A ball of 20 mm radius.
    fn ball(rings: usize) -> Facets {
        let at = |i: usize, j: usize| {
            let (polar, turn) = (i as f64 / rings as f64, 2.0 * j as f64 / (2 * rings) as f64);
            let (polar, turn) = (polar * std::f64::consts::PI, turn * std::f64::consts::PI);
            Vec3::new(polar.sin() * turn.cos(), polar.sin() * turn.sin(), polar.cos()) * 20.0
        };
        let (mut points, mut facets) = (vec![at(0, 0)], Vec::new());
        points.extend((1..rings).flat_map(|i| (0..2 * rings).map(move |j| (i, j))).map(|(i, j)| at(i, j)));
        points.push(at(rings, 0));
        let last = points.len() as u32 - 1;
        let index = |i: usize, j: usize| (1 + (i - 1) * 2 * rings + j % (2 * rings)) as u32;
        for j in 0..2 * rings {
            facets.extend([[0, index(1, j), index(1, j + 1)], [last, index(rings - 1, j + 1), index(rings - 1, j)]]);
            for i in 1..rings - 1 {
                let quad = [index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1)];
                facets.extend([[quad[0], quad[1], quad[2]], [quad[0], quad[2], quad[3]]]);
            }
        }
        Facets::of(&TriangleMesh::<Object>::new(points, facets))
    }

    #[test]
    fn a_ball_keeps_its_volume_and_its_closed_surface() {
        let fine = ball(120);
        let coarse = coarse(&fine).unwrap();
        assert!(coarse.each.len() <= MOST_FACETS && coarse.each.len() > 1000, "{}", coarse.each.len());
        let volume = |f: &Facets| f.mass().volume_mm3;
        assert!((volume(&coarse) / volume(&fine) - 1.0).abs() < 0.02);
        let open: Vec3 = coarse.each.iter().map(|f| f.area).sum();
        assert!(open.norm() < 1e-9 * volume(&fine));
        assert!(super::coarse(&ball(20)).is_none(), "few enough");
    }
}
