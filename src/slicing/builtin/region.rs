//! Sections as `section`'s polygons, grown, shrunk and measured as walls and infill need it; grid units of 0.1 micrometres where not mm.

use crate::section::simplify::simplified;
use i_overlay::i_float::int::angle::Angle;
use i_overlay::mesh::int::arc::ArcOptions;
use i_overlay::mesh::int::outline::offset::IntOutlineOffset;
use i_overlay::mesh::int::style::{IntLineJoin, IntOutlineStyle};

pub(super) use crate::section::polygons::wound as enclosed;
pub(super) use crate::section::polygons::{Contour, GridPoint, Region, Shape, UNITS_PER_MM, and, minus, or, units};

/// How far a dropped point may lie from the line that replaces it while sections are worked on: 3 micrometres, a quarter of what
/// PrusaSlicer drops. Diagonals of flat sides leave points along straight lines, each layer elsewhere; without them equal layers are
/// equal.
pub(super) const FINE_UNITS: f64 = 30.0;
/// Corners sharper than this are cut off when a region grows: a miter three times the distance, as PrusaSlicer does.
const SHARPEST_MITER_DEG: f64 = 39.0;
/// And when it shrinks, about what cuts into it: a wall's middle stays within 0.4 of its width of where a round turn would be.
const SHARPEST_NOTCH_DEG: f64 = 80.0;

/// Round corners have a point every so many degrees.
const ROUND_STEP_DEG: f64 = 5.0;

/// Grid units in millimetres.
pub(super) fn mm(units: f64) -> f64 {
    units / UNITS_PER_MM
}

/// The region grown by `by` grid units, or shrunk where that is negative; corners stay corners.
pub(super) fn grown(region: &Region, by: i32) -> Region {
    if region.is_empty() || by == 0 {
        return region.clone();
    }
    let sharpest = if by < 0 { SHARPEST_NOTCH_DEG } else { SHARPEST_MITER_DEG };
    let sharpest = Angle::from_radians(sharpest.to_radians()).unwrap_or(Angle::from_bits(0));
    let style = IntOutlineStyle::new(by).line_join(IntLineJoin::Miter(sharpest));
    // The outline's only error is a range check that construction does not make: the grid reaches 107 m.
    let mut result = region.outline(&style).unwrap_or_default();
    if by < 0 {
        result.retain(|shape| lies_within(shape, region, f64::from(-by)));
    }
    // Rounding leaves edges of a micrometre in any direction where nearly straight edges meet; offset once more, these
    // would stand out as spikes. And every shallow corner has become two.
    result.iter_mut().flatten().for_each(|ring| *ring = simplified(ring, FINE_UNITS));
    result
}

/// The region grown by `by` grid units, with round corners: nothing of it is farther away than that.
pub(super) fn rounded(region: &Region, by: i32) -> Region {
    let max_step = Angle::from_radians(ROUND_STEP_DEG.to_radians()).unwrap_or(ArcOptions::MIN_STEP);
    let style =
        IntOutlineStyle::new(by).line_join(IntLineJoin::Round(ArcOptions { max_step, ..ArcOptions::default() }));
    region.outline(&style).unwrap_or_default()
}

/// Whether a shape of the shrunk region is where it belongs.
///
/// Shrinking a sliver turns it inside out, and where its ends are round crumbs of that survive beside or outside it.
fn lies_within(shape: &Shape, region: &Region, inset: f64) -> bool {
    let Some(&p) = shape.first().and_then(|ring| ring.first()) else { return false };
    let mut inside = false;
    for (a, b) in region.iter().flatten().flat_map(|ring| pairs(ring)) {
        let [ax, ay, bx, by] = [a.x - p.x, a.y - p.y, b.x - p.x, b.y - p.y].map(f64::from);
        let (dx, dy) = (bx - ax, by - ay);
        let t = (-(ax * dx + ay * dy) / (dx * dx + dy * dy)).clamp(0.0, 1.0);
        if (ax + t * dx).powi(2) + (ay + t * dy).powi(2) < (0.9 * inset).powi(2) {
            return false;
        }
        inside ^= (ay <= 0.0) != (by <= 0.0) && ax - ay / dy * dx > 0.0;
    }
    inside
}

/// Whether a point lies in the region.
pub(super) fn holds(region: &Region, p: GridPoint) -> bool {
    let (x, y) = (f64::from(p.x), f64::from(p.y));
    let right_of = |&(a, b): &(GridPoint, GridPoint)| {
        (a.y <= p.y) != (b.y <= p.y) && {
            let [ax, ay, bx, by] = [a.x, a.y, b.x, b.y].map(f64::from);
            ax + (y - ay) / (by - ay) * (bx - ax) > x
        }
    };
    region.iter().flatten().flat_map(|ring| pairs(ring)).filter(right_of).count() % 2 == 1
}

/// What remains where nothing narrower than `2 * radius` does.
pub(super) fn opened(region: &Region, radius: i32) -> Region {
    grown(&grown(region, -radius), radius)
}

/// The area in mm²; holes count as missing.
pub(super) fn area_mm2(region: &Region) -> f64 {
    region.iter().flatten().map(|ring| signed_area_mm2(ring)).sum()
}

/// The ring's area in mm², negative where it runs clockwise.
pub(super) fn signed_area_mm2(ring: &[GridPoint]) -> f64 {
    let twice: i64 = pairs(ring)
        .map(|(a, b)| i64::from(a.x) * i64::from(b.y) - i64::from(b.x) * i64::from(a.y))
        .fold(0, i64::wrapping_add);
    twice as f64 / (2.0 * UNITS_PER_MM * UNITS_PER_MM)
}

/// The ring's length in mm.
pub(super) fn perimeter_mm(ring: &[GridPoint]) -> f64 {
    pairs(ring).map(|(a, b)| distance_mm(a, b)).sum()
}

/// The distance in mm.
pub(super) fn distance_mm(a: GridPoint, b: GridPoint) -> f64 {
    mm(length([b.x - a.x, b.y - a.y].map(f64::from)))
}

/// How long a vector is.
pub(super) fn length(v: [f64; 2]) -> f64 {
    // `hypot` takes longer, to guard against an overflow that nothing on a bed comes near.
    (v[0] * v[0] + v[1] * v[1]).sqrt()
}

/// The ring's edges, the closing one last.
pub(super) fn pairs(ring: &[GridPoint]) -> impl Iterator<Item = (GridPoint, GridPoint)> + '_ {
    (0..ring.len()).map(|i| (ring[i], ring[(i + 1) % ring.len()]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(x0: i32, x1: i32) -> Contour {
        [(x0, x0), (x1, x0), (x1, x1), (x0, x1)].map(|(x, y)| GridPoint::new(x, y)).to_vec()
    }

    #[test]
    fn a_square_of_20_mm_shrinks_exactly_and_grows_back() {
        let outer = enclosed(&[square(0, 200_000)]);
        let inner = grown(&outer, -2250);
        let mut corners = inner[0][0].clone();
        corners.sort();
        let mut wanted = square(2250, 197_750);
        wanted.sort();
        assert_eq!(corners, wanted);
        assert!((area_mm2(&grown(&inner, 2250)) - 400.0).abs() < 1e-9);
    }

    #[test]
    fn a_sliver_shrinks_to_nothing() {
        let arc = |radius: f64| {
            (0..=40).map(move |i| (f64::from(i) * 0.02).sin_cos()).map(move |(s, c)| (radius * c, radius * s))
        };
        let sliver = arc(100_000.0).chain(arc(99_990.0).collect::<Vec<_>>().into_iter().rev());
        let region = enclosed(&[sliver.map(|(x, y)| GridPoint::new(x.round() as i32, y.round() as i32)).collect()]);
        assert!(!region.is_empty());
        assert_eq!(grown(&region, -1350), Region::new());
    }

    #[test]
    fn a_hole_grows_when_the_region_shrinks_and_vanishes_with_it() {
        let mut hole = square(90_000, 110_000);
        hole.reverse();
        let ring = enclosed(&[square(0, 200_000), hole]);
        assert!((area_mm2(&ring) - 396.0).abs() < 1e-9);
        assert!((area_mm2(&grown(&ring, -5000)) - (19.0 * 19.0 - 9.0)).abs() < 1e-9);
        assert!(grown(&ring, -50_000).is_empty());
    }
}
