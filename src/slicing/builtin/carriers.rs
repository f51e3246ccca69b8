//! What is too thin to print is printed where something stands on it: a rib that is thinner at its foot would begin in the air. Slicers with
//! beads of varying width print thin places everywhere (Arachne's minimum feature size, a quarter of a nozzle); here a fin that is thin all
//! the way up is told and left out. Grid units of 0.1 micrometres where not mm².

use super::Lines;
use super::near::Shapes;
use super::region::{Region, Shape, and, area_mm2, grown, minus, opened, or, units};
use super::walls::Walled;

/// What carries less than this is not missed, mm²: half a line of a millimetre.
const WORTH_MM2: f64 = 0.2;

/// The layers' sections before any is widened, and which lines print them.
pub(super) struct Printed<'a> {
    pub(super) outlines: &'a [Region],
    pub(super) same_as: &'a [usize],
    pub(super) walls: &'a [Vec<Walled>],
}

impl Printed<'_> {
    /// The sections with the thin places wider on which something stands, as wide as what stands there; `None` where there are none.
    ///
    /// From the top down, for what is widened may stand on thinner places yet; then from below, for what itself stands on nothing helps
    /// nothing, and begins where it is wide enough. The first layer stays as it is: an edge that lies on the table, or on another part, is
    /// printed from where it is wide enough, and widened it would lie beside its place.
    pub(super) fn widened(&self, lines: &Lines) -> Option<Vec<Region>> {
        let count = self.outlines.len();
        let mut feet = vec![Region::new(); count];
        for at in (1..count.saturating_sub(1)).rev() {
            feet[at] = self.foot(at, &feet[at + 1], lines);
        }
        for at in 1..count {
            let mut foot = std::mem::take(&mut feet[at]);
            if !foot.is_empty() {
                let ground = grown(&self.with(at - 1, &feet[at - 1], &foot, lines), lines.at(at).width / 2);
                foot.retain(|shape| is_worth(shape, &ground));
            }
            feet[at] = foot;
        }
        let any = feet.iter().any(|foot| !foot.is_empty());
        any.then(|| {
            let widened =
                |(outline, foot): (&Region, &Region)| if foot.is_empty() { outline.clone() } else { or(outline, foot) };
            self.outlines.iter().zip(&feet).map(widened).collect()
        })
    }

    /// What would have to be printed of layer `at` beside what is, as the next one, widened by the foot `above`, stands on it.
    fn foot(&self, at: usize, above: &Region, lines: &Lines) -> Region {
        let missing = self.lost(at);
        if missing.is_empty() || (self.same_as[at] == self.same_as[at + 1] && above.is_empty()) {
            return Region::new();
        }
        let line = lines.at(at);
        let above = self.with(at + 1, above, &missing, lines);
        let below = self.with(at, &Region::new(), &missing, lines);
        let hangs = and(&minus(&above, &grown(&below, line.width / 2)), &missing);
        let under = grown(&missing, units(line.thinnest_mm()) / 2);
        let mut foot = opened(&and(&above, &under), line.width / 8);
        foot.retain(|shape| is_worth(shape, &hangs));
        foot
    }

    /// What is printed of layer `at` near `region`, with its `foot`.
    fn with(&self, at: usize, foot: &Region, region: &Region, lines: &Lines) -> Region {
        let near = Shapes::of(&self.outlines[at]).near(region, 4 * lines.at(at).width).into_owned();
        or(&minus(&near, &self.lost(at)), foot)
    }

    /// What of a layer no line prints.
    fn lost(&self, at: usize) -> Region {
        self.walls[self.same_as[at]].iter().flat_map(|island| island.lost.clone()).collect()
    }
}

fn is_worth(shape: &Shape, of: &Region) -> bool {
    area_mm2(&and(&vec![shape.clone()], of)) > WORTH_MM2
}
