//! What is remembered of layers that droop: one is printed everywhere, many in a row collapse.
//!
//! A stretch that goes out by more than [`Rule::fine_mm`](super::OverhangRule::fine_mm) loses quality, and a layer that does not gives it all
//! back. Where the quality is gone, or where lines have nothing below them at all, a point is noted; [`COLLAPSE`] of them in one
//! place are a collapse.
//!
//! ```text
//! fine < step <= 1.5 fine   quality of the stretch below, less 0.3; a point where that is below 0, and 0.5 from then on
//! 1.5 fine < step           quality 0.8, and a point
//! ```
//!
//! Source: PrusaSlicer 2.9, `SupportSpotsGenerator.cpp` (`check_extrusion_entity_stability`, `gather_issues`), which works along lines:
//! its points lie as far apart as a line spans freely, and at corners, so that sides longer than that count more. How much more, and that it
//! takes five points, is fitted to what it says of shapes: `docs/explanation/deciding.md`.

use super::region::{Corners, Region, Shape, and, grown, longest_side_mm, minus};

/// Quality lost in a layer, tenths.
const LOST: i8 = 3;
/// What lines with nothing below them leave, tenths.
const FLOATING: i8 = 8;
/// Where a point was noted, tenths.
const NOTED: i8 = 5;
const WHOLE: i8 = 10;
/// So many points in one place are a collapse, hundredths.
const COLLAPSE: u16 = 500;
/// A stretch remembers what lies so near to it sideways, mm: as far as lines hang free.
const NEAR_MM: f64 = 2.0;
/// A line spans so much freely along a ledge, mm: longer sides have points along them, too.
pub const FREE_SIDE_MM: f64 = 16.0;
/// And so much along a ledge around a corner.
pub const FREE_RIM_MM: f64 = 2.0 * FREE_SIDE_MM;

/// How a stretch goes out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Lean {
    /// So little, and so short, that it never falls.
    Little,
    /// With what is below it half below.
    Out,
    /// With nothing below it.
    Floats,
}

/// What is remembered of a stretch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Mark {
    /// Hundredths.
    points: u16,
    /// Tenths.
    quality: i8,
}

impl Mark {
    const NEW: Self = Self { points: 0, quality: WHOLE };

    /// With one more layer, of which a point counts for so much.
    fn then(self, lean: Lean, more: u16) -> Self {
        let points = self.points.saturating_add(more);
        match (lean, self.quality - LOST) {
            (Lean::Floats, _) => Self { points, quality: FLOATING },
            (Lean::Out, quality) if quality < 0 => Self { points, quality: NOTED },
            (_, quality) => Self { quality: quality.max(0), ..self },
        }
    }
}

/// What the last layer's stretches have behind them.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Memory(Vec<(Mark, Region)>);

impl Memory {
    /// The next layer has this stretch, which goes to `next`: what of it collapses.
    pub(super) fn add(&self, stretch: Shape, lean: Lean, next: &mut Self) -> Region {
        let more = points(&stretch);
        let mut rest = vec![stretch];
        let mut collapsed = Region::new();
        let mut take = |mark: Mark, region: Region| {
            if region.is_empty() {
                return;
            }
            let mark = mark.then(lean, more);
            if mark.points >= COLLAPSE {
                collapsed.extend(region.iter().cloned());
            }
            match next.0.iter_mut().find(|(known, _)| *known == mark) {
                Some((_, known)) => known.extend(region),
                None => next.0.push((mark, region)),
            }
        };
        let mut worst_first: Vec<&(Mark, Region)> = self.0.iter().collect();
        worst_first.sort_by_key(|(mark, _)| (u16::MAX - mark.points, mark.quality));
        for (mark, below) in worst_first {
            if rest.is_empty() {
                break;
            }
            let near = grown(below, NEAR_MM, Corners::Round);
            take(*mark, and(&rest, &near));
            rest = minus(&rest, &near);
        }
        take(Mark::NEW, rest);
        collapsed
    }
}

/// What a point along `stretch` counts for, hundredths: sides longer than a line spans have more than one, and two of them at corners.
fn points(stretch: &Shape) -> u16 {
    match (longest_side_mm(stretch) > FREE_SIDE_MM, stretch.len() > 1) {
        (false, _) => 100,
        (true, false) => 120,
        (true, true) => 170,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::overhang::region::enclosed;

    /// A strip along x, as long and as far out as that.
    fn strip(long: f64, y: f64) -> Shape {
        let corners = [[0.0, y], [long, y], [long, y + 0.1], [0.0, y + 0.1]];
        let sides: Vec<_> = (0..4).map(|i| [corners[i], corners[(i + 1) % 4]]).collect();
        enclosed(&sides).remove(0)
    }

    /// In which layer a strip collapses whose layers all go out so.
    fn collapses(long: f64, lean: Lean) -> Option<usize> {
        let mut memory = Memory::default();
        (1..60).find(|layer| {
            let mut next = Memory::default();
            let collapsed = memory.add(strip(long, *layer as f64 * 0.4), lean, &mut next);
            memory = next;
            !collapsed.is_empty()
        })
    }

    #[test]
    fn layers_in_a_row_collapse_and_those_of_a_ring_of_long_sides_sooner() {
        // Qualities 0.7, 0.4, 0.1, -0.2 (a point), then 0.5 and every second layer one: the fifth point in layer 12.
        assert_eq!(collapses(12.0, Lean::Out), Some(12));
        assert_eq!(collapses(12.0, Lean::Floats), Some(5));
        // Each counts for 1.2: the fifth point again.
        assert_eq!(
            [Lean::Out, Lean::Floats, Lean::Little].map(|lean| collapses(30.0, lean)),
            [Some(12), Some(5), None]
        );
    }

    #[test]
    fn a_ring_of_long_sides_collapses_in_its_third_layer_without_anything_below() {
        let square = |half: f64| -> Vec<[[f64; 2]; 2]> {
            let corners = [[-half, -half], [half, -half], [half, half], [-half, half]];
            (0..4).map(|i| [corners[i], corners[(i + 1) % 4]]).collect()
        };
        let ring = |half: f64| minus(&enclosed(&square(half + 0.1)), &enclosed(&square(half))).remove(0);
        let collapses = |half: f64| {
            let mut memory = Memory::default();
            (1..60).find(|layer| {
                let mut next = Memory::default();
                let collapsed = memory.add(ring(half + 0.4 * f64::from(*layer)), Lean::Floats, &mut next);
                memory = next;
                !collapsed.is_empty()
            })
        };
        assert_eq!([collapses(10.0), collapses(3.0)], [Some(3), Some(5)]);
    }

    #[test]
    fn what_lies_elsewhere_is_not_remembered() {
        let mut memory = Memory::default();
        for layer in 0..40 {
            let mut next = Memory::default();
            let y = if layer % 2 == 0 { 0.0 } else { 5.0 };
            assert!(memory.add(strip(12.0, y), Lean::Floats, &mut next).is_empty(), "layer {layer}");
            memory = next;
        }
    }
}
