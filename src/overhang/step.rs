//! One layer on those below it: what of it is fine, droops, or hangs.

use std::cell::RefCell;
use std::rc::Rc;

use super::chords::{Air, holds};
use super::keels::too_narrow;
use super::memory::{FREE_RIM_MM, FREE_SIDE_MM, Lean, Memory};
use super::patch::{Piece, State};
use super::region::{
    Corners, Region, Shape, about, and, area_mm2, around_mm, at, bounds, edges, grown, longest_side_mm, minus, or,
};
use super::{NARROWEST_LINES, OverhangRule};
use crate::section::Segment;
use crate::section::polygons::GridPoint;

/// Areas below this are rounding, mm².
const NOTHING_MM2: f64 = 1e-4;
/// A share of a piece that no chord carries is the rounding of its border up to this, where it is less than half of what is tolerated.
const ROUNDING: f64 = 0.02;
/// What a step may be longer than the threshold allows: the rounding of borders, mm.
const STEP_SLACK_MM: f64 = 5e-4;
/// A piece that is so much of what goes beyond the layer below touches nothing else of it.
const WHOLE: f64 = 0.999;
/// Shorter stretches are corners, which nobody looks at, mm.
const CORNER_MM: f64 = 3.0;
/// A step is one of lines with nothing below them from so many steps that are fine on.
const FLOATS: f64 = 1.5;
/// Stretches that are shorter than a line spans never fall below this.
const NEARLY_FLOATS: f64 = 1.18;
/// So far out a ledge may be however long it is, mm: its loops lean on each other.
pub const LEDGE_MM: f64 = 1.5;
/// What is no larger may go out by more, mm²: PrusaSlicer 2.9 is silent about ledges 6 mm wide that go out by 3 mm.
pub const SMALL_MM2: f64 = 10.0;
/// How far that may go out, mm.
pub const SMALL_LEDGE_MM: f64 = 3.0;
/// A piece of which bridges carry more lies on these.
const HALF: f64 = 0.5;
/// What of a border is no farther than this from where a step is fine begins there, mm.
const NEAR_EDGE_MM: f64 = 0.05;
/// A bridge that spans no more does not sag, mm.
pub const FINE_BRIDGE_MM: f64 = 10.0;
/// Nothing that is farther from a piece than this says how far it goes out, mm: most go out by 3 mm, and corners that grow by twice that.
const NEAR_MM: f64 = 10.0;
/// What longer ones sag by at most, mm.
const SAG_MM: f64 = 0.2;

/// A layer on those below it.
pub(super) struct Step<'a> {
    pub(super) number: usize,
    pub(super) layer: &'a Region,
    /// What it lies on.
    pub(super) below: &'a Below,
    /// What of the layer is not fine on the body alone and [left by](Self::left_by) the supports, where that is known.
    pub(super) left: Option<&'a Region>,
    /// What is one layer of air lower, or of which no slicer leaves any air.
    pub(super) near: &'a Region,
    /// The layer above it.
    pub(super) above: &'a dyn Fn() -> Region,
    /// Whether something begins here or in the layer below: then islands of any size are looked for.
    pub(super) begins: bool,
    /// What of `below` is supports, ..
    pub(super) supports: &'a Region,
    /// .. and so far beside them it may reach, mm.
    pub(super) beside_mm: f64,
    pub(super) rule: &'a OverhangRule,
}

/// What a layer lies on, grown as often as it is asked for.
pub(super) struct Below {
    region: Region,
    known: RefCell<Vec<Grown>>,
}

/// By how much, in bits of a number of mm, and with which corners.
type Grown = ((u64, Corners), Rc<Region>);

impl Below {
    pub(super) fn of(region: Region) -> Self {
        Self { region, known: RefCell::default() }
    }

    /// What of a layer would not be fine on it; empty for what is rounding.
    pub(super) fn beyond(&self, layer: &Region, rule: &OverhangRule) -> Region {
        let beyond = minus(layer, &self.grown(rule.fine_mm() + STEP_SLACK_MM, Corners::Sharp));
        if is_nothing(&beyond) { Region::new() } else { beyond }
    }

    fn grown(&self, mm: f64, corners: Corners) -> Rc<Region> {
        let key = (mm.to_bits(), corners);
        let known = self.known.borrow().iter().find(|(of, _)| *of == key).map(|(_, found)| Rc::clone(found));
        known.unwrap_or_else(|| {
            let found = Rc::new(grown(&self.region, mm, corners));
            self.known.borrow_mut().push((key, Rc::clone(&found)));
            found
        })
    }
}

fn is_nothing(region: &Region) -> bool {
    region.iter().map(area_mm2).sum::<f64>() < NOTHING_MM2
}

impl Step<'_> {
    /// What of `beyond` lies neither on supports nor so near to them that it is fine; empty for what is rounding.
    pub(super) fn left_by(supports: &Region, beyond: &Region, beside_mm: f64, rule: &OverhangRule) -> Region {
        if supports.is_empty() {
            return beyond.clone();
        }
        let fine_mm = rule.fine_mm() + STEP_SLACK_MM;
        let left = minus(beyond, &grown(supports, fine_mm.max(beside_mm), Corners::Sharp));
        if is_nothing(&left) { Region::new() } else { left }
    }

    /// What hangs and droops goes to `pieces`; what is to be remembered of it comes back.
    pub(super) fn judged(&self, memory: &Memory, pieces: &mut Vec<Piece>) -> Memory {
        let mut next = Memory::default();
        let rule = self.rule;
        let fine_mm = rule.fine_mm() + STEP_SLACK_MM;
        let (islands, rest) = self.parted(fine_mm);
        pieces.extend(islands.iter().map(|island| self.island(island)));
        let over = minus(&rest, &self.below.region);
        if is_nothing(&over) {
            return next;
        }
        let mut beyond = match self.left {
            Some(left) => minus(left, &self.below.region),
            None => {
                let beyond = minus(&over, &self.below.grown(fine_mm, Corners::Sharp));
                Self::left_by(self.supports, &beyond, self.beside_mm, rule)
            }
        };
        if is_nothing(&beyond) {
            return next;
        }
        let near = grown(&about(self.near, &beyond, NEAR_MM), fine_mm, Corners::Sharp);
        let close = and(&beyond, &near);
        if !is_nothing(&close) {
            pieces.extend(close.iter().map(|one| self.piece(one, area_mm2(one), State::Droops(rule.layer_mm))));
            beyond = minus(&beyond, &near);
        }
        let air = match too_narrow(&about(&self.below.region, &beyond, rule.bridge_mm), NARROWEST_LINES * rule.line_mm)
        {
            narrow if narrow.is_empty() => Air::of(&over, &self.below.region),
            narrow => {
                let laid = minus(&self.below.region, &narrow);
                Air::of(&minus(&rest, &laid), &laid)
            }
        };
        for one in beyond.into_iter().filter(|one| area_mm2(one) >= NOTHING_MM2) {
            self.stretch(one, &over, &air, memory, &mut next, pieces);
        }
        next
    }

    /// Where something begins: what of the layer lies on nothing and beside nothing, however small, and the rest of it.
    fn parted(&self, fine_mm: f64) -> (Region, Region) {
        if !self.begins {
            return (Region::new(), self.layer.clone());
        }
        let is_island = Self::islands(self.below, self.near, fine_mm);
        self.layer.iter().cloned().partition(is_island)
    }

    /// Whether a piece lies on nothing and beside nothing.
    fn islands(below: &Below, near: &Region, fine_mm: f64) -> impl Fn(&Shape) -> bool {
        let (below, near) = (below.grown(fine_mm, Corners::Sharp), grown(near, fine_mm, Corners::Sharp));
        let is_apart = |one: &Shape, from: &Region| and(&vec![one.clone()], from).is_empty();
        move |one| is_apart(one, &below) && is_apart(one, &near)
    }

    /// Whether one of a layer's pieces does, on what is `below` it and `near` to it.
    pub(super) fn has_islands(layer: &Region, below: &Below, near: &Region, rule: &OverhangRule) -> bool {
        layer.iter().any(Self::islands(below, near, rule.fine_mm() + STEP_SLACK_MM))
    }

    /// One connected stretch that is not fine.
    fn stretch(
        &self,
        one: Shape,
        over: &Region,
        air: &Air,
        memory: &Memory,
        next: &mut Memory,
        pieces: &mut Vec<Piece>,
    ) {
        let rule = self.rule;
        let own = vec![one];
        let area = area_mm2(&own[0]);
        if area > WHOLE * around_mm2(over, &own) && !air.is_held(&own[0]) {
            pieces.push(self.island(&own[0]));
            return;
        }
        let fine_mm = rule.fine_mm() + STEP_SLACK_MM;
        let below = Below::of(about(&self.below.region, &own, NEAR_MM));
        let farther = |mm: f64| minus(&own, &below.grown(mm, Corners::Round));
        let bridge = |mm: f64| {
            let loose = air.loose(&own[0], &OverhangRule { bridge_mm: rule.bridge_mm.min(mm), ..*rule })?;
            (loose.share > ROUNDING || area * loose.share > rule.tolerate_mm2 / 2.0).then_some(loose)
        };
        let far = !is_nothing(&farther(LEDGE_MM));
        let Some(_) = bridge(if far { FINE_BRIDGE_MM } else { 2.0 * LEDGE_MM }) else { return };
        if far || !rule.droops {
            let most_mm = if rule.droops { f64::INFINITY } else { FINE_BRIDGE_MM };
            let Some(loose) = bridge(most_mm) else {
                pieces.push(self.piece(&own[0], area, State::Droops(SAG_MM)));
                return;
            };
            // All around a pin it has no end that something holds, and PrusaSlicer 2.9 warns of it, as of one around three of its sides.
            let around = match own[0].len() {
                1 => around_mm(&own[0]) / 2.0 > FREE_RIM_MM + rule.free_mm(),
                _ => !is_within(&own[0][0], &below.grown(fine_mm + NEAR_EDGE_MM, Corners::Sharp)),
            };
            let long = around || longest_side_mm(&own[0]) > FREE_SIDE_MM;
            let loose_mm2 = area * loose.share;
            let most_mm = if loose_mm2 <= SMALL_MM2 { SMALL_LEDGE_MM } else { rule.free_mm() };
            let little = loose_mm2 <= SMALL_MM2 && loose.share < HALF;
            if !rule.droops || !little && (long || !is_nothing(&farther(most_mm))) {
                let (middle, bounds) = (loose.middle, loose.bounds);
                let is = State::Hangs;
                // Beside supports it hangs from these on.
                let mut from_there = area;
                if !self.supports.is_empty() {
                    let beside = and(over, &grown(&own, self.beside_mm, Corners::Round));
                    from_there = area.max(beside.iter().map(area_mm2).sum());
                }
                let area_mm2 = from_there * loose.share;
                pieces.push(Piece { layer: self.number, area_mm2, middle, bounds, is });
                return;
            }
        }
        let length_mm = around_mm(&own[0]) / 2.0;
        if length_mm < CORNER_MM {
            return;
        }
        // Where two sides meet it is no farther than from either.
        let out = |steps: f64| {
            let within = below.grown(steps * rule.fine_mm() + STEP_SLACK_MM, Corners::Sharp);
            !is_nothing(&minus(&own, &within))
        };
        let lean = match out(FLOATS) {
            true => Lean::Floats,
            false if length_mm > FREE_SIDE_MM || out(NEARLY_FLOATS) => Lean::Out,
            false => Lean::Little,
        };
        let whole = |part: &Region| -> f64 {
            and(over, &grown(part, rule.fine_mm(), Corners::Round)).iter().map(area_mm2).sum()
        };
        let droop_mm = if lean == Lean::Floats { rule.layer_mm } else { rule.layer_mm / 2.0 };
        let laid = whole(&own);
        let collapsed = memory.add(own[0].clone(), lean, next);
        let is = |region: &Region, area: f64, is: State| {
            let sum: f64 = region.iter().map(area_mm2).sum();
            region.iter().map(|one| self.piece(one, area * area_mm2(one) / sum, is)).collect::<Vec<_>>()
        };
        if is_nothing(&collapsed) {
            pieces.extend(is(&own, laid, State::Droops(droop_mm)));
        } else {
            pieces.extend(is(&collapsed, whole(&collapsed), State::Hangs));
        }
    }

    fn island(&self, one: &Shape) -> Piece {
        let (area, rule) = (area_mm2(one), self.rule);
        let small = rule.droops && area <= rule.tolerate_mm2 && self.merges(one);
        self.piece(one, area, if small { State::Droops(rule.layer_mm) } else { State::Island })
    }

    /// Whether an island is one with something that stands from the next layer on.
    fn merges(&self, island: &Shape) -> bool {
        let island = vec![island.clone()];
        let others = or(&self.below.region, &minus(self.layer, &island));
        (self.above)().into_iter().any(|one| {
            let one = vec![one];
            !is_nothing(&and(&one, &island)) && !is_nothing(&and(&one, &others))
        })
    }

    fn piece(&self, one: &Shape, area_mm2: f64, is: State) -> Piece {
        let bounds = bounds(one);
        let middle = [0, 1].map(|i| f64::midpoint(bounds[0][i], bounds[1][i]));
        Piece { layer: self.number, area_mm2, middle, bounds, is }
    }
}

/// Whether a border lies in a region, or a place of it does.
fn is_within(border: &[GridPoint], region: &Region) -> bool {
    let sides: Vec<Segment> = region.iter().flatten().flat_map(|ring| edges(ring)).map(|ends| ends.map(at)).collect();
    border.iter().any(|p| holds(&sides, at(*p)))
}

/// The area of the piece of `over` that holds `one`, mm².
fn around_mm2(over: &Region, one: &Region) -> f64 {
    let holds = |whole: &&Shape| !is_nothing(&and(&vec![(*whole).clone()], one));
    over.iter().find(holds).map_or(f64::INFINITY, area_mm2)
}
