//! Which part of a layer's inside is solid, sparse, or a bridge.

use std::f64::consts::FRAC_PI_4;

use super::Line;
use super::hatch::{Lattice, longest_mm};
use super::region::{Region, and, area_mm2, grown, minus, opened, or, units};
use crate::slicing::SliceSettings;

/// What is narrower than twice this is rounding, grid units: 0.1 mm.
const ROUNDING: i32 = 500;

/// The layers' sections, and for each the lowest layer of the run of equal ones it belongs to.
pub(super) struct Stack<'a> {
    pub(super) outlines: &'a [Region],
    pub(super) same_as: &'a [usize],
}

impl Stack<'_> {
    /// `region` without what every one of `layers` covers; layers beyond the stack cover nothing.
    fn uncovered(&self, region: &Region, at: usize, layers: impl Iterator<Item = isize>) -> Region {
        let mut covered = region.clone();
        let mut seen = self.same_as[at];
        for layer in layers {
            let Some(outline) = usize::try_from(layer).ok().and_then(|i| self.outlines.get(i)) else {
                return region.clone();
            };
            let class = self.same_as[layer as usize];
            if class != seen {
                covered = and(&covered, outline);
                seen = class;
            }
        }
        if seen == self.same_as[at] { Region::new() } else { minus(region, &covered) }
    }
}

/// An island's inside, shared out.
#[derive(Default)]
pub(super) struct Inside {
    /// Filled line by line.
    pub(super) solid: Region,
    /// Sparse infill, or nothing.
    pub(super) hollow: Region,
}

/// Solid where a layer within reach above or below is missing, hollow elsewhere.
pub(super) fn inside(stack: &Stack<'_>, at: usize, infill: &Region, line: &Line, s: &SliceSettings) -> Inside {
    if s.infill >= 1.0 {
        return Inside { solid: infill.clone(), hollow: Region::new() };
    }
    let here = at as isize;
    let top = stack.uncovered(infill, at, (here + 1)..=(here + s.top_layers as isize));
    // Sparse infill cannot start in the air: above the first layer one solid layer is the least.
    let bottoms = if at == 0 { s.bottom_layers } else { s.bottom_layers.max(1) } as isize;
    let bottom = stack.uncovered(infill, at, ((here - bottoms)..here).rev());
    let skin = opened(&or(&top, &bottom), line.width / 4);
    // A line width more on every side, so that the skin's ends lie on something.
    let solid = and(&grown(&skin, line.width), infill);
    let hollow = minus(infill, &solid);
    if s.infill <= 0.0 {
        return Inside { solid, hollow };
    }
    let (hollow, small) = without_small(hollow, s);
    Inside { solid: or(&solid, &small), hollow }
}

/// What is large and wide enough for sparse lines, and the rest: that would be full or hollow by luck of its place.
fn without_small(hollow: Region, s: &SliceSettings) -> (Region, Region) {
    let (hollow, mut small): (Region, Region) =
        hollow.into_iter().partition(|shape| area_mm2(&vec![shape.clone()]) >= s.solid_below_mm2);
    let narrow = minus(&hollow, &opened(&hollow, units(s.solid_below_mm / 2.0)));
    // What rounding leaves along a border is nothing to fill.
    let narrow: Region =
        narrow.into_iter().filter(|shape| !grown(&vec![shape.clone()], -ROUNDING).is_empty()).collect();
    let hollow = minus(&hollow, &narrow);
    small.extend(narrow);
    (hollow, small)
}

/// A solid region's lines: bridges over air and sparse infill, the top skin, and the rest.
#[derive(Default)]
pub(super) struct Solids {
    pub(super) bridges: Vec<(Region, f64)>,
    pub(super) top: Region,
    pub(super) rest: Region,
}

/// Shares out a solid region; `below` and `above` are the neighbouring layers, with the lower one's hollow inside.
pub(super) fn solids(solid: &Region, below: Option<(&Region, &Region)>, above: Option<&Region>, line: &Line) -> Solids {
    let unsupported = below.map_or_else(Region::new, |(outline, hollow)| {
        opened(&or(&minus(solid, outline), &and(solid, hollow)), line.width / 2)
    });
    let spans: Region = grown(&unsupported, 2 * line.width);
    let bridging = and(&spans, solid);
    let rest = minus(solid, &bridging);
    let top = above.map_or_else(|| rest.clone(), |outline| opened(&minus(&rest, outline), line.width / 4));
    let rest = minus(&rest, &top);
    let bridges = bridging
        .into_iter()
        .map(|shape| {
            let one = vec![shape];
            let angle = shortest_span(&and(&one, &unsupported), line);
            (one, angle)
        })
        .collect();
    Solids { bridges, top, rest }
}

/// The direction, of four, in which the longest unsupported line is shortest.
fn shortest_span(unsupported: &Region, line: &Line) -> f64 {
    let angles = [0.0, 2.0 * FRAC_PI_4, FRAC_PI_4, 3.0 * FRAC_PI_4];
    let mut best = (f64::INFINITY, FRAC_PI_4);
    if area_mm2(unsupported) <= 0.0 {
        return best.1;
    }
    for angle in angles {
        let span = longest_mm(unsupported, Lattice::common(angle, f64::from(line.spacing)));
        // A micrometre of advantage is rounding, not a shorter span.
        if span < best.0 - 0.001 {
            best = (span, angle);
        }
    }
    best.1
}
