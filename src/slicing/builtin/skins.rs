//! Which part of a layer's inside is solid, sparse, or a bridge.

use std::borrow::Cow;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

use super::hatch::{Lattice, longest_mm};
use super::near::Shapes;
use super::onto::onto_rows;
use super::region::{Region, and, area_mm2, grown, minus, opened, or, units};
use super::{Line, bridges};
use crate::slicing::SliceSettings;

/// What is narrower than twice this is rounding, grid units: 0.1 mm.
const ROUNDING: i32 = 500;

/// The layers' sections, and for each the lowest layer of the run of equal ones it belongs to.
pub(super) struct Stack<'a> {
    pub(super) outlines: &'a [Region],
    pub(super) same_as: &'a [usize],
    /// The sections once more, to be asked for what is near.
    shapes: Vec<Shapes<'a>>,
}

impl<'a> Stack<'a> {
    pub(super) fn new(outlines: &'a [Region], same_as: &'a [usize]) -> Self {
        Self { outlines, same_as, shapes: outlines.iter().map(Shapes::of).collect() }
    }

    /// The layer's section near `region`; `None` above the last.
    pub(super) fn near(&self, layer: usize, region: &Region) -> Option<Cow<'a, Region>> {
        self.shapes.get(layer).map(|shapes| shapes.near(region, 0))
    }

    /// Whether two layers have the same section.
    pub(super) fn are_alike(&self, layer: usize, other: usize) -> bool {
        self.same_as.get(layer) == self.same_as.get(other)
    }

    /// What of `region` has nothing below it.
    fn air(&self, region: &Region, at: usize, line: &Line) -> Region {
        match at.checked_sub(1) {
            Some(below) if !self.are_alike(at, below) => {
                over_air(region, &self.shapes[below].near(region, line.width), line)
            }
            _ => Region::new(),
        }
    }

    /// `region` without what every one of `layers` covers; layers beyond the stack cover nothing.
    fn uncovered(&self, region: &Region, at: usize, layers: impl Iterator<Item = isize>) -> Region {
        let mut covered = region.clone();
        let mut seen = self.same_as[at];
        for layer in layers {
            let Some(shapes) = usize::try_from(layer).ok().and_then(|i| self.shapes.get(i)) else {
                return region.clone();
            };
            let class = self.same_as[layer as usize];
            if class != seen {
                covered = and(&covered, &shapes.near(region, 0));
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
    // A line width more on every side, so that what lies beneath a wall's edge is solid too; what bridges air lies on more.
    let solid = or(&grown(&skin, line.width), &grown(&stack.air(infill, at, line), units(s.anchor_mm)));
    let solid = and(&solid, infill);
    let hollow = minus(infill, &solid);
    if s.infill <= 0.0 {
        return Inside { solid, hollow };
    }
    let (hollow, small) = without_small(hollow, s);
    Inside { solid: or(&solid, &small), hollow }
}

impl Inside {
    /// Brings what is solid over the hollow `below` out to its sparse `rows`, so that none of its lines ends between two; the layer's own
    /// are across these. Both share `infill`.
    pub(super) fn onto(
        &mut self,
        infill: &Region,
        below: &Region,
        [rows, own]: [Lattice; 2],
        line: &Line,
        s: &SliceSettings,
    ) {
        loop {
            let over = over_sparse(&self.solid, below, line);
            let onto = onto_rows(&over, rows, [own, Lattice::full(own.angle, line)], f64::from(line.width / 2));
            if grown(&and(&onto, &self.hollow), -ROUNDING).is_empty() {
                return;
            }
            // What is too small to stay hollow is over sparse rows as well; and no slit stays open where both met before.
            let (hollow, _) = without_small(minus(&self.hollow, &onto), s);
            *self = Self { solid: minus(infill, &hollow), hollow };
        }
    }
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

/// What of `solid` lies over the `hollow` inside below it.
fn over_sparse(solid: &Region, hollow: &Region, line: &Line) -> Region {
    opened(&and(solid, hollow), line.width / 2)
}

/// What of `region` does not lie on `below`, but for a half line along its border.
fn over_air(region: &Region, below: &Region, line: &Line) -> Region {
    opened(&minus(region, below), line.width / 2)
}

/// A piece that spans something.
pub(super) struct Bridge {
    pub(super) region: Region,
    /// The direction of its lines, rad from +X.
    pub(super) angle: f64,
    /// Whether it runs straight across sparse rows: as the layer's other rows do, so that all are to lie on one lattice.
    pub(super) is_on_rows: bool,
}

/// A solid region's lines: bridges over air and sparse infill, the top skin, and the rest.
#[derive(Default)]
pub(super) struct Solids {
    pub(super) bridges: Vec<Bridge>,
    pub(super) top: Region,
    pub(super) rest: Region,
}

/// What a solid region of a layer lies between.
pub(super) struct Between<'a> {
    /// What is printed below it, and the hollow inside of that.
    pub(super) below: Option<[Cow<'a, Region>; 2]>,
    /// The sparse rows in that inside, where they run one way.
    pub(super) rows: Option<Lattice>,
    /// The section above; as its own where that is the same.
    pub(super) above: Option<Cow<'a, Region>>,
    /// Whether the section above is the layer's own.
    pub(super) goes_on: bool,
}

/// Shares out a solid region; bridges reach `anchor` beyond the air.
pub(super) fn solids(solid: &Region, between: &Between<'_>, line: &Line, anchor: i32) -> Solids {
    let mut found = Solids { rest: solid.clone(), ..Solids::default() };
    if let Some([outline, hollow]) = &between.below {
        let air = over_air(solid, outline, line);
        found.span(&air, solid, anchor, |own| bridges::direction(own, outline), line);
        let over_air = found.bridges.len();
        // Straight across sparse rows, each span is the shortest; and along the border of what is hollow walls carry.
        let across = between.rows.map(|rows| rows.angle + FRAC_PI_2);
        found.span(&over_sparse(&found.rest, hollow, line), solid, 2 * line.width, |_| across, line);
        found.bridges[over_air..].iter_mut().for_each(|bridge| bridge.is_on_rows = across.is_some());
    }
    if between.goes_on {
        return found;
    }
    if let Some(above) = &between.above {
        found.top = opened(&minus(&found.rest, above), line.width / 4);
        found.rest = minus(&found.rest, &found.top);
    } else {
        found.top = std::mem::take(&mut found.rest);
    }
    found
}

impl Solids {
    /// Takes `air`, grown by `reach`, from the rest for bridges.
    fn span(
        &mut self,
        air: &Region,
        solid: &Region,
        reach: i32,
        direction: impl Fn(&Region) -> Option<f64>,
        line: &Line,
    ) {
        if air.is_empty() {
            return;
        }
        let mut bridging = and(&and(&grown(air, reach), solid), &self.rest);
        // A strip beside it that has no room for a line of its own is bridged too: its plastic would lie on the bridge's turns.
        let left = minus(&self.rest, &bridging);
        let strips = minus(&left, &opened(&left, line.width / 2));
        let beside = opened(&and(&strips, &grown(&bridging, line.width)), line.width / 16);
        if !beside.is_empty() {
            bridging = or(&bridging, &beside);
        }
        self.rest = minus(&self.rest, &bridging);
        for shape in bridging {
            let one = vec![shape];
            let own = and(&one, air);
            let angle = if own.is_empty() { None } else { direction(&own) };
            let angle = angle.unwrap_or_else(|| shortest_span(&own, line));
            self.bridges.push(Bridge { region: one, angle, is_on_rows: false });
        }
    }
}

/// The direction, of four, in which the longest unsupported line is shortest.
fn shortest_span(unsupported: &Region, line: &Line) -> f64 {
    let angles = [0.0, 2.0 * FRAC_PI_4, FRAC_PI_4, 3.0 * FRAC_PI_4];
    let mut best = (f64::INFINITY, FRAC_PI_4);
    if area_mm2(unsupported) <= 0.0 {
        return best.1;
    }
    for angle in angles {
        let span = longest_mm(unsupported, Lattice::full(angle, line));
        // A micrometre of advantage is rounding, not a shorter span.
        if span < best.0 - 0.001 {
            best = (span, angle);
        }
    }
    best.1
}
