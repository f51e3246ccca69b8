//! Shapes that are the same elsewhere have the same walls elsewhere, and those that are nearly the same their own.

use super::super::region::{Contour, GridPoint, Region, Shape, UNITS_PER_MM};
use super::super::walls::{Walled, walled_once};
use super::super::{Line, SliceSettings};

const CORNERS: i32 = 12;

fn pin(radius_mm: f64, [x, y]: [i32; 2]) -> Shape {
    let corner = |i: i32| {
        let angle = std::f64::consts::TAU * f64::from(i) / f64::from(CORNERS);
        let [dx, dy] = [angle.cos(), angle.sin()].map(|part| (part * radius_mm * UNITS_PER_MM).round() as i32);
        GridPoint::new(x + dx, y + dy)
    };
    vec![(0..CORNERS).map(corner).collect()]
}

/// The furthest that points of the first lie from those of the second, grid units; `None` where these are others.
fn apart(a: &Walled, b: &Walled) -> Option<u32> {
    let flat = |region: &Region| region.iter().flatten().cloned().collect::<Vec<Contour>>();
    let rings = |walled: &Walled| {
        let mut all: Vec<Contour> = walled.beads.iter().map(|bead| bead.points.clone()).collect();
        [&walled.centre, &walled.infill, &walled.lost].into_iter().for_each(|region| all.extend(flat(region)));
        all
    };
    let (a, b) = (rings(a), rings(b));
    let same = a.len() == b.len() && a.iter().zip(&b).all(|(a, b)| a.len() == b.len());
    let points = a.iter().flatten().zip(b.iter().flatten());
    same.then(|| points.map(|(p, q)| p.x.abs_diff(q.x).max(p.y.abs_diff(q.y))).max().unwrap_or(0))
}

#[test]
fn pins_alike_have_walls_alike() {
    let line = Line::new(0.45, SliceSettings::default().layer_height_mm);
    for radius_mm in [0.3, 0.45, 0.9, 1.7, 6.0] {
        let places = [[250_000, 250_000], [278_000, 250_000], [250_000, 731_234], [1_999_999, 3]];
        let shapes: Region = places.map(|place| pin(radius_mm, place)).to_vec();
        let together = walled_once(&shapes, &line, 2);
        for (shape, got) in shapes.iter().zip(&together) {
            let alone = &walled_once(&vec![shape.clone()], &line, 2)[0];
            let apart = apart(got, alone);
            assert!(apart.is_some_and(|units| units <= 2), "radius {radius_mm}: {apart:?} units");
        }
    }
}

#[test]
fn nearly_is_not_alike() {
    let line = Line::new(0.45, SliceSettings::default().layer_height_mm);
    let first = pin(1.7, [250_000, 250_000]);
    // One corner 0 to 0.1 mm further out, and a pin with a hole.
    for (units, alike) in [(0, true), (2, true), (3, false), (10, false), (1000, false)] {
        let mut second = pin(1.7, [290_000, 250_000]);
        second[0][3].y += units;
        let both = walled_once(&vec![first.clone(), second.clone()], &line, 2);
        let moved: Vec<Contour> = both[0]
            .beads
            .iter()
            .map(|b| b.points.iter().map(|p| GridPoint::new(p.x + 40_000, p.y)).collect())
            .collect();
        let same = moved == both[1].beads.iter().map(|b| b.points.clone()).collect::<Vec<_>>();
        assert_eq!(same, alike, "{units} units");
    }
    let mut ring = pin(1.7, [290_000, 250_000]);
    let hole: Contour = pin(0.5, [290_000, 250_000])[0].iter().rev().copied().collect();
    ring.push(hole);
    let both = walled_once(&vec![first, ring], &line, 2);
    assert!(apart(&both[0], &both[1]).is_none());
}
