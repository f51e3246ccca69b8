//! Where closed outer walls begin and end: there the bead has its scar. Grid units of 0.1 micrometres where not mm.
//!
//! Rings run with the material to their left, outer borders and holes alike, so that a turn to the right is a corner that leads inward:
//! there a scar is hidden. The rules are those that PrusaSlicer and Cura call rear, nearest, aligned and sharpest corner.

use super::nearest::Nearest;
use super::region::{Contour, GridPoint, distance_mm};
use crate::slicing::Seam;

/// How far behind the rearmost point a seam may lie, grid units: rounding must not throw it about.
const REAR_TOLERANCE: i32 = 200;
/// A seam follows the one of the layer below from so far off at most, mm: farther away it is another wall's.
const FOLLOWED_MM: f64 = 3.0;
/// A corner turns by so much at least, degrees: less is a curve.
const CORNER_DEG: f64 = 25.0;
/// How far along the wall a corner's sides are looked at, mm: about a line.
const ARM_MM: f64 = 0.5;
/// Corners whose turns differ by no more are as good as each other, degrees: rounding must not choose among them.
const ALIKE_DEG: f64 = 5.0;

/// Chooses the seams of layer after layer.
pub(super) struct Seams {
    rule: Seam,
    /// Those of the layer below.
    below: Contour,
    near: Option<Nearest>,
    /// Those of this layer so far.
    here: Contour,
}

impl Seams {
    pub(super) fn new(rule: Seam) -> Self {
        Self { rule, below: Contour::new(), near: None, here: Contour::new() }
    }

    /// A layer is done: its seams lie below the next one's.
    pub(super) fn next_layer(&mut self) {
        self.below = std::mem::take(&mut self.here);
        self.near = (!self.below.is_empty()).then(|| Nearest::all(self.below.clone()));
    }

    /// The place in `ring` where its wall begins, if the nozzle comes from `at`.
    pub(super) fn place(&self, ring: &[GridPoint], at: GridPoint) -> usize {
        match self.rule {
            Seam::Rear => rearmost(ring),
            Seam::Nearest => nearest_place(ring, at),
            Seam::Corner => corner(ring),
            Seam::Aligned => self.above_the_one_below(ring).unwrap_or_else(|| corner(ring)),
        }
    }

    /// A wall begins here.
    pub(super) fn begun(&mut self, at: GridPoint) {
        if self.rule == Seam::Aligned {
            self.here.push(at);
        }
    }

    /// The place nearest to any seam of the layer below.
    fn above_the_one_below(&self, ring: &[GridPoint]) -> Option<usize> {
        let near = self.near.as_ref()?;
        let away = |place: usize| Some((distance_mm(ring[place], self.below[near.to(ring[place])?]), place));
        let (mm, place) = (0..ring.len()).filter_map(away).min_by(|a, b| a.0.total_cmp(&b.0))?;
        (mm <= FOLLOWED_MM).then_some(place)
    }
}

/// The vertex with the greatest y; of several, the one with the greatest x.
pub(super) fn rearmost(points: &[GridPoint]) -> usize {
    let rear = points.iter().map(|p| p.y).max().unwrap_or(0) - REAR_TOLERANCE;
    (0..points.len()).filter(|&i| points[i].y >= rear).max_by_key(|&i| (points[i].x, usize::MAX - i)).unwrap_or(0)
}

/// The vertex nearest to `at`.
pub(super) fn nearest_place(ring: &[GridPoint], at: GridPoint) -> usize {
    let away = |&i: &usize| distance_mm(at, ring[i]);
    (0..ring.len()).min_by(|a, b| away(a).total_cmp(&away(b))).unwrap_or(0)
}

/// The sharpest corner that leads inward, else outward, else the rear; of several alike the rearmost.
fn corner(ring: &[GridPoint]) -> usize {
    let turns: Vec<f64> = (0..ring.len()).map(|i| turn_deg(ring, i)).collect();
    for inward in [-1.0, 1.0] {
        let sharpest = turns.iter().map(|turn| turn * inward).fold(0.0, f64::max);
        if sharpest < CORNER_DEG {
            continue;
        }
        let alike: Vec<usize> = (0..ring.len()).filter(|&i| turns[i] * inward >= sharpest - ALIKE_DEG).collect();
        let points: Contour = alike.iter().map(|&i| ring[i]).collect();
        return alike[rearmost(&points)];
    }
    rearmost(ring)
}

/// By how much the ring turns at a vertex, degrees, to the left positive.
fn turn_deg(ring: &[GridPoint], at: usize) -> f64 {
    let count = ring.len();
    let arm = |step: usize| {
        let mut places = (1..count).map(|k| ring[(at + k * step) % count]);
        let far = places.clone().find(|&p| distance_mm(ring[at], p) >= ARM_MM);
        far.or_else(|| places.next_back()).unwrap_or(ring[at])
    };
    let (before, after) = (arm(count - 1), arm(1));
    let leg = |a: GridPoint, b: GridPoint| [f64::from(b.x) - f64::from(a.x), f64::from(b.y) - f64::from(a.y)];
    let (a, b) = (leg(before, ring[at]), leg(ring[at], after));
    (a[0] * b[1] - a[1] * b[0]).atan2(a[0] * b[0] + a[1] * b[1]).to_degrees()
}

#[cfg(test)]
mod tests {
    use super::super::region::UNITS_PER_MM;
    use super::*;

    fn ring(corners: &[(f64, f64)]) -> Contour {
        corners.iter().map(|&(x, y)| GridPoint::new((x * UNITS_PER_MM) as i32, (y * UNITS_PER_MM) as i32)).collect()
    }

    /// An L with its inner corner at (10, 10), anticlockwise.
    fn ell() -> Contour {
        ring(&[(0.0, 0.0), (20.0, 0.0), (20.0, 10.0), (10.0, 10.0), (10.0, 20.0), (0.0, 20.0)])
    }

    #[test]
    fn each_rule_has_its_place() {
        let seams = |rule| Seams::new(rule);
        let far = ring(&[(19.0, 1.0)])[0];
        assert_eq!(seams(Seam::Rear).place(&ell(), far), 4, "of the two at the rear the one to the right");
        assert_eq!(seams(Seam::Nearest).place(&ell(), far), 1);
        assert_eq!(seams(Seam::Corner).place(&ell(), far), 3, "the one that leads inward");
        assert_eq!(seams(Seam::Aligned).place(&ell(), far), 3, "nothing is below");
        // Without it all corners are alike, and the rear decides; a hole, clockwise, has four that lead inward.
        let square = ring(&[(0.0, 0.0), (20.0, 0.0), (20.0, 20.0), (0.0, 20.0)]);
        assert_eq!(seams(Seam::Corner).place(&square, far), 2);
        let hole: Contour = square.into_iter().rev().collect();
        assert_eq!(seams(Seam::Corner).place(&hole, far), 1);
    }

    #[test]
    fn a_round_wall_has_no_corner_and_a_rounded_corner_is_one_where_it_is_as_sharp_as_a_line_is_wide() {
        let arc = |radius: f64, from: f64, to: f64, at: (f64, f64)| {
            (0..=12)
                .map(move |k| (from + (to - from) * f64::from(k) / 12.0).to_radians().sin_cos())
                .map(move |(s, c)| (at.0 + radius * c, at.1 + radius * s))
        };
        let round: Vec<(f64, f64)> =
            (0..72).map(|k| (f64::from(k) * 5.0).to_radians().sin_cos()).map(|(s, c)| (10.0 * c, 10.0 * s)).collect();
        assert_eq!(corner(&ring(&round)), 18, "the rear");
        for (radius, found) in [(0.2, true), (8.0, false)] {
            // A square whose lower left corner is drawn, the others rounded by 6 mm.
            let corners: Vec<(f64, f64)> = arc(radius, 180.0, 270.0, (radius, radius))
                .chain(arc(6.0, 270.0, 360.0, (14.0, 6.0)))
                .chain(arc(6.0, 0.0, 90.0, (14.0, 14.0)))
                .chain(arc(6.0, 90.0, 180.0, (6.0, 14.0)))
                .collect();
            let ring = ring(&corners);
            let place = ring[corner(&ring)];
            assert_eq!(place.x < 20_000 && place.y < 20_000, found, "{radius}: {place:?}");
        }
    }

    #[test]
    fn a_seam_follows_the_one_below_but_not_another_walls() {
        let mut seams = Seams::new(Seam::Aligned);
        seams.begun(ring(&[(19.5, 0.5)])[0]);
        assert_eq!(seams.place(&ell(), GridPoint::default()), 3, "of its own layer it knows nothing");
        seams.next_layer();
        assert_eq!(seams.place(&ell(), GridPoint::default()), 1);
        seams.begun(ring(&[(25.0, 0.5)])[0]);
        seams.next_layer();
        assert_eq!(seams.place(&ell(), GridPoint::default()), 3, "5 mm off");
        seams.next_layer();
        assert_eq!(seams.place(&ell(), GridPoint::default()), 3);
    }
}
