//! Brim and skirt: lines around the first layer of what stands on the table, on the bare table. Grid units of 0.1 micrometres where not mm.
//!
//! Whoever asks for them knows how much room there is ([`Adhesion`]); here are only their lines, from the outside in: loops first, so that the
//! nozzle is full when the brim begins. A brim's innermost line touches the outer wall side by side; holes of the part stay free.

use super::Line;
use super::region::{Contour, Region, enclosed, rounded, units};
use crate::slicing::Adhesion;

/// The closed lines around `outline`, in printing order.
pub(super) fn rings(outline: &Region, line: &Line, adhesion: &Adhesion) -> Vec<Contour> {
    let brim = brim_lines(line, adhesion.brim_mm);
    if brim == 0 && adhesion.skirt_loops == 0 {
        return Vec::new();
    }
    // All at once: one after the other takes the square of their number.
    let filled = enclosed(&outline.iter().map(|shape| shape[0].clone()).collect::<Vec<_>>());
    let beyond_mm = if brim == 0 { 0.0 } else { line.width_mm + f64::from(brim - 1) * line.spacing_mm };
    let at = |from_mm: f64, k: u32| units(from_mm + line.width_mm / 2.0 + f64::from(k) * line.spacing_mm);
    let skirt = (0..adhesion.skirt_loops).rev().map(|k| (at(beyond_mm + adhesion.skirt_distance_mm, k), true));
    let brim = (0..brim).rev().map(|k| (at(0.0, k), false));
    let around = |(by, loops): (i32, bool)| {
        let region = rounded(&filled, by);
        // A loop goes around everything; a brim lies in the part's bays, too.
        region.into_iter().flat_map(move |shape| shape.into_iter().take(if loops { 1 } else { usize::MAX }))
    };
    skirt.chain(brim).flat_map(around).collect()
}

/// How many lines fit into a brim.
fn brim_lines(line: &Line, brim_mm: f64) -> u32 {
    // A thousandth of a millimetre: what is asked for in whole lines must not lose one by rounding.
    if brim_mm + 1e-3 < line.width_mm { 0 } else { ((brim_mm + 1e-3 - line.width_mm) / line.spacing_mm) as u32 + 1 }
}

#[cfg(test)]
mod tests {
    use super::super::region::{GridPoint, UNITS_PER_MM, signed_area_mm2};
    use super::*;

    fn square(x0: f64, x1: f64) -> Contour {
        let [a, b] = [x0, x1].map(|x| (x * UNITS_PER_MM) as i32);
        [(a, a), (b, a), (b, b), (a, b)].map(|(x, y)| GridPoint::new(x, y)).to_vec()
    }

    #[test]
    fn loops_lie_outside_of_the_brim_and_the_brim_outside_of_the_part() {
        let line = Line::new(0.45, 0.2);
        let mut hole = square(8.0, 12.0);
        hole.reverse();
        let part = enclosed(&[square(0.0, 20.0), hole]);
        let adhesion = Adhesion { brim_mm: 2.0, skirt_loops: 2, skirt_distance_mm: 3.0 };
        let got: Vec<f64> = rings(&part, &line, &adhesion).iter().map(|ring| signed_area_mm2(ring).abs()).collect();
        // By hand: a spacing of 0.45 - 0.2 (1 - pi/4) = 0.40708; four lines, 0.45 + 3 x 0.40708 = 1.671 wide.
        let at = |mm: f64| 400.0 + 80.0 * mm + std::f64::consts::PI * mm * mm;
        let wanted = [5.303, 4.896, 1.446, 1.039, 0.632, 0.225].map(at);
        assert_eq!(got.len(), wanted.len());
        // A polygon of 5 degrees lacks 0.13 % of its circle.
        let near = |(got, wanted): (&f64, f64)| (0.998 * wanted..=wanted + 0.1).contains(got);
        assert!(got.iter().zip(wanted).all(near), "{got:?} for {wanted:?}");
    }

    #[test]
    fn nothing_lies_farther_away_than_the_brim_is_wide_not_even_at_sharp_corners() {
        let line = Line::new(0.45, 0.2);
        let tip =
            enclosed(&[[(0, 0), (200_000, -10_000), (200_000, 10_000)].map(|(x, y)| GridPoint::new(x, y)).to_vec()]);
        let farthest = |brim_mm: f64| {
            let rings = rings(&tip, &line, &Adhesion { brim_mm, ..Adhesion::default() });
            rings.iter().flatten().map(|p| -f64::from(p.x) / UNITS_PER_MM).fold(f64::NEG_INFINITY, f64::max)
        };
        for brim_mm in [0.45, 1.0, 3.0, 5.0, 20.0] {
            assert!(farthest(brim_mm) + 0.225 < brim_mm + 0.002, "{brim_mm}: {}", farthest(brim_mm));
            assert!(farthest(brim_mm) + 0.225 > brim_mm - 0.42, "{brim_mm}: {}", farthest(brim_mm));
        }
    }

    #[test]
    fn a_brim_narrower_than_a_line_is_none_and_whole_lines_are_not_lost() {
        let line = Line::new(0.45, 0.2);
        let lines = |mm| brim_lines(&line, mm);
        assert_eq!((lines(0.0), lines(0.44), lines(0.45), lines(0.45 + line.spacing_mm)), (0, 0, 1, 2));
        assert!(rings(&Region::new(), &line, &Adhesion { brim_mm: 5.0, ..Adhesion::default() }).is_empty());
    }

    #[test]
    fn two_islands_near_each_other_share_their_loops() {
        let line = Line::new(0.45, 0.2);
        let both = enclosed(&[square(0.0, 10.0), square(14.0, 24.0)]);
        let loops = rings(&both, &line, &Adhesion { brim_mm: 0.0, skirt_loops: 1, skirt_distance_mm: 3.0 });
        assert_eq!(loops.len(), 1);
        let brim = rings(&both, &line, &Adhesion { brim_mm: 0.5, ..Adhesion::default() });
        assert_eq!(brim.len(), 2);
    }
}
