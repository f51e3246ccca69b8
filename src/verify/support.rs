//! Rule `in-air`: filament is laid on or against something.
//!
//! A bead spans from its tip's height down by its own. Below it something must reach its underside to within
//! [`SQUEEZE`]; or the line beside it, laid before in the same layer, carries it. What was printed in earlier setups may
//! lie a layer deeper: where a part grows out of a slanting surface, its slices begin in mid-layer. So may another body that grows beside it and
//! shares no face with it: a designer's own supports end a layer of air below what they hold.
//!
//! What lies on supports leaves some air below it, in whole layers: a support's top counts as if it reached so much higher. So does what a
//! support stands on.
//!
//! A line over air must begin and end on material and may span `process.bridge_mm` between; what hangs free at an end may be
//! as long as a string that stays up by itself, or a little longer where it is of a [small ledge](super::ledges). What turns on its
//! way is no bridge, whatever the slicer calls it. It may be the rim of a ledge: of one that is [`LEDGE_MM`] wide however long it is, or of one as
//! wide as such a string is long, [`FREE_SIDE_MM`] along a side and [`FREE_RIM_MM`] around corners. Or
//! [bridges beside it hold it](super::rings).
//!
//! A loop that is closed over air has no end there: what hangs behind its beginning
//! and what hangs before its end are one span (PrusaSlicer's stability analysis takes it so, too). One that touches nothing but its
//! own beginning, or hangs for more than half of itself, lies on nothing, unless what is laid after it and around it in
//! its layer [holds it](super::rings).

use std::collections::VecDeque;

use super::acts::Stroke;
use super::field::{Below, Field};
use super::ledges::{Ledges, UnsupportedGap};
use super::material::deposit;
use super::rings::{LAYER_MM, Place, Rings, TAIL_WIDTHS, TURNED_MM};
use super::way::{SAMPLE_MM, is_nearly_straight, longest_side, places_on, stretch_of};
use crate::geom::Vec3;
use crate::overhang::{FREE_RIM_MM, FREE_SIDE_MM, FREE_SPAN_MM, LEDGE_MM};

/// The part of a layer by which the support below may fall short of the bead's underside.
const SQUEEZE: f64 = 0.35;
/// So many layers of air may be between a part and another body below it.
const OTHERS_LAYERS: f64 = 2.0;
/// A closed line hangs as such where so much of it does.
const LOOP_SHARE: f64 = 0.5;

/// The line being laid.
pub(super) struct Laying {
    bridge_mm: f64,
    gap: Option<UnsupportedGap>,
    /// Where the line began.
    began: Option<Vec3>,
    /// What hung behind that, if it did.
    first: Option<UnsupportedGap>,
    /// The last that ended on material, and where along the line, mm.
    last: Option<(UnsupportedGap, f64)>,
    /// Those of the line that are longer than they may be.
    long: Vec<UnsupportedGap>,
    /// Whether the line has met material since it began.
    held: bool,
    tail: VecDeque<(Stroke, f64)>,
    travelled: f64,
    /// The air that the part being printed has below it on supports, or that it has if these are its supports, mm.
    gap_mm: f64,
    /// Whether these are supports.
    holds: bool,
    /// Which body they are of, where others grow beside it.
    body: Option<u32>,
    /// What hangs at one end.
    ledges: Ledges,
    /// The line's pieces, and places on it; the latter where a ring waits.
    way: Vec<[Vec3; 2]>,
    places: Vec<Place>,
    rings: Rings,
}

impl Laying {
    /// Nothing laid yet; lines may span `bridge_mm` between two ends on material.
    pub(super) fn new(bridge_mm: f64) -> Self {
        let (gap, began, first, last) = (None, None, None, None);
        Self {
            bridge_mm,
            gap,
            began,
            first,
            last,
            long: Vec::new(),
            held: false,
            tail: VecDeque::new(),
            travelled: 0.0,
            gap_mm: 0.0,
            holds: false,
            body: None,
            ledges: Ledges::default(),
            way: Vec::new(),
            places: Vec::new(),
            rings: Rings::default(),
        }
    }

    /// The next lines are supports (`holds`), or lie on such with so much air between.
    pub(super) fn with_supports(&mut self, gap_mm: f64, holds: bool) {
        (self.gap_mm, self.holds) = (gap_mm, holds);
    }

    /// The next lines are of this body, and others grow beside it.
    pub(super) fn with_body(&mut self, body: Option<u32>) {
        self.body = body;
    }

    /// Lays `stroke`; the gaps that end on it go to `found`.
    pub(super) fn lay(&mut self, stroke: &Stroke, field: &mut Field, found: &mut Vec<UnsupportedGap>) {
        if self.rings.are_below(stroke.to.z) {
            self.rings.settle(found);
        }
        self.began.get_or_insert(stroke.from);
        self.way.push([stroke.from, stroke.to]);
        let along = stroke.to - stroke.from;
        let length = along.norm();
        let count = (length / SAMPLE_MM).ceil().max(1.0);
        let (width, height) = (f64::from(stroke.width), f64::from(stroke.height));
        for i in 0..count as usize {
            let p = stroke.from + along * ((i as f64 + 0.5) / count);
            let under = p.z - height * (1.0 + SQUEEZE);
            // A support ends in one of its own layers.
            let air = (self.gap_mm / height - 1e-6).ceil().max(0.0) * height;
            // A support's first layer lies on the table itself.
            let earlier = if self.holds { under } else { under - height };
            // What another body ends with may be a designer's own support, with a layer of air above; or it is so near that no support fits between.
            let other = self.body.map(|body| (body, under - OTHERS_LAYERS * height));
            // Below supports that stand on a part slicers leave as much air as above them; and a floor in the middle of a layer ends a layer
            // lower with some.
            let laid = if self.holds { under - air } else { under };
            let below = Below { height: under, earlier, laid, held: under - air, other };
            let stands = field.stands([p.x, p.y], width, below);
            if self.rings.wait() {
                let lies = stands && field.ends_between([p.x, p.y], width / 2.0, [under, p.z - LAYER_MM]);
                self.places.push(Place { at: p, stands, lies });
            }
            if stands {
                self.end_gap(self.travelled + length * (i as f64) / count, field, found);
                self.held = true;
            } else {
                let (held, from) = ([self.held, false], stroke.from + along * (i as f64 / count));
                let begins = self.travelled + length * (i as f64) / count;
                let gap = self.gap.get_or_insert(UnsupportedGap {
                    held,
                    ends: [from; 2],
                    stroke: *stroke,
                    length: 0.0,
                    along: [begins; 2],
                    as_rim: 0.0,
                    allowed: 0.0,
                });
                gap.length += length / count;
                gap.along[1] = gap.along[0] + gap.length;
                gap.ends[1] = stroke.from + along * ((i + 1) as f64 / count);
            }
        }
        self.travelled += length;
        self.tail.push_back((*stroke, self.travelled));
        while self.tail.front().is_some_and(|(_, end)| self.travelled - end > TAIL_WIDTHS * width) {
            if let Some((old, _)) = self.tail.pop_front() {
                deposit(field, &old, self.holds, self.body);
            }
        }
    }

    /// The line ends here.
    pub(super) fn end(&mut self, field: &mut Field, found: &mut Vec<UnsupportedGap>) {
        let end = self.tail.back().map(|(stroke, _)| (stroke.to, f64::from(stroke.width)));
        let closed = self.began.zip(end).filter(|(began, (to, width))| (to - began).norm() <= *width);
        let (first, open) = (self.first.take(), self.gap.take());
        if let Some((_, (_, width))) = closed {
            let near_end = |(_, at): &(UnsupportedGap, f64)| self.travelled - at <= TAIL_WIDTHS * width;
            // On its own beginning a loop's last stretch finds material.
            let before = open.or_else(|| self.last.filter(near_end).map(|(gap, _)| gap));
            let one = match (first, open) {
                // On nothing but its own beginning.
                (Some(first), _) if first.length >= self.travelled - TAIL_WIDTHS * width => {
                    Some(self.measured(first.alone(), field))
                }
                (Some(first), _) => {
                    let length = first.length + before.map_or(0.0, |gap| gap.length);
                    let ends = [before.map_or(first.ends[0], |gap| gap.ends[0]), first.ends[1]];
                    let along = [before.map_or(first.along[0], |gap| gap.along[0]), first.along[1]];
                    Some(self.measured(UnsupportedGap { held: [true; 2], length, ends, along, ..first }, field))
                }
                (None, Some(gap)) if gap.held[0] => {
                    Some(self.measured(UnsupportedGap { held: [true; 2], ..gap }, field))
                }
                (None, open) => open,
            };
            // What hangs for less is no rim of a hole but the end of something.
            let hangs = |gap: &UnsupportedGap| gap.held != [true; 2] || gap.length >= LOOP_SHARE * self.travelled;
            let all: Vec<UnsupportedGap> = std::mem::take(&mut self.long).into_iter().chain(one).collect();
            let (hanging, others): (Vec<_>, Vec<_>) = all.into_iter().partition(hangs);
            let back: Vec<UnsupportedGap> = hanging.into_iter().filter_map(|gap| self.hang(gap)).collect();
            let others: Vec<UnsupportedGap> = others.into_iter().filter_map(|gap| self.turn(gap)).collect();
            others.into_iter().chain(back).for_each(|gap| self.judge(gap, found));
        } else {
            let long: Vec<_> = std::mem::take(&mut self.long).into_iter().filter_map(|gap| self.turn(gap)).collect();
            long.into_iter().chain(first).chain(open).for_each(|gap| self.judge(gap, found));
        }
        (self.began, self.last) = (None, None);
        if let Some((_, width)) = end.filter(|_| self.rings.wait() && !self.places.is_empty()) {
            self.rings.line(&self.way, width, &self.places);
        }
        self.way.clear();
        self.places.clear();
        self.tail.drain(..).for_each(|(stroke, _)| deposit(field, &stroke, self.holds, self.body));
        (self.travelled, self.held) = (0.0, false);
    }

    /// The print ends here: what hangs of all of it is judged.
    pub(super) fn settle(&mut self, found: &mut Vec<UnsupportedGap>) {
        self.rings.settle(found);
        self.ledges.settle(found);
    }

    /// A closed line that hangs as a whole, or for the greater part: back where its layer cannot hold it any more.
    fn hang(&mut self, gap: UnsupportedGap) -> Option<UnsupportedGap> {
        let allowed = self.allowed(&gap);
        let waits = gap.length > allowed && self.rings.take(UnsupportedGap { allowed, ..gap }, self.way.clone(), true);
        if waits {
            // It is a thread already.
            self.places.clear();
        }
        (!waits).then_some(gap)
    }

    /// A stretch that turns over air between two ends on material: back where it is no such one, or its layer cannot hold it any more.
    fn turn(&mut self, gap: UnsupportedGap) -> Option<UnsupportedGap> {
        let allowed = self.allowed(&gap);
        let turns = gap.held == [true; 2] && gap.length > allowed && !is_straight(&gap);
        let waits = turns && {
            let way = stretch_of(&self.way, gap.along);
            self.rings.take(UnsupportedGap { allowed, ..gap }, way, false)
        };
        (!waits).then_some(gap)
    }

    /// The gap ends on material `at` so many mm along the line.
    fn end_gap(&mut self, at: f64, field: &Field, found: &mut Vec<UnsupportedGap>) {
        let Some(mut gap) = self.gap.take() else { return };
        gap.held[1] = true;
        if gap.held[0] {
            gap = self.measured(gap, field);
            self.last = Some((gap, at));
            // At its end it is known whether the line is closed.
            if gap.length > self.allowed(&gap) {
                self.long.push(gap);
            } else {
                self.judge(gap, found);
            }
        } else {
            self.first = Some(gap);
        }
    }

    /// A gap that ends on material or on itself, and what it may be as a ledge's rim; nobody asks of one that may be so long anyway.
    fn measured(&self, gap: UnsupportedGap, field: &Field) -> UnsupportedGap {
        if gap.length <= self.allowed(&gap) {
            return gap;
        }
        let (width, height) = (f64::from(gap.stroke.width), f64::from(gap.stroke.height));
        let way = stretch_of(&self.way, gap.along);
        let is_within = |mm: f64| {
            let lies = |p: Vec3| {
                field.ends_between([p.x, p.y], mm - width / 2.0, [p.z - height * (1.0 + SQUEEZE), p.z - LAYER_MM])
            };
            places_on(&way).all(lies)
        };
        let free = FREE_SPAN_MM.max(2.0 * width);
        let as_rim = if is_within(LEDGE_MM) {
            f64::INFINITY
        } else if longest_side(&way) <= FREE_SIDE_MM + 2.0 * width && is_within(free) {
            // What is all around has no end, and waits for what holds it.
            if gap.held == [true; 2] { FREE_RIM_MM + 2.0 * free } else { f64::INFINITY }
        } else {
            0.0
        };
        UnsupportedGap { as_rim, ..gap }
    }

    /// How long a gap may be.
    fn allowed(&self, gap: &UnsupportedGap) -> f64 {
        let free = FREE_SPAN_MM.max(2.0 * f64::from(gap.stroke.width));
        match (gap.held, is_straight(gap)) {
            ([true, true], true) => self.bridge_mm.max(free).max(gap.as_rim),
            ([true, true], false) => self.bridge_mm.min(TURNED_MM).max(free).max(gap.as_rim),
            _ => free,
        }
    }

    fn judge(&mut self, mut gap: UnsupportedGap, found: &mut Vec<UnsupportedGap>) {
        gap.allowed = self.allowed(&gap);
        if !self.ledges.keep(&gap) && gap.length > gap.allowed {
            found.push(gap);
        }
    }
}

/// Whether a gap goes nearly the shortest way between its ends.
fn is_straight(gap: &UnsupportedGap) -> bool {
    is_nearly_straight(gap.length, &gap.ends, f64::from(gap.stroke.width))
}

#[cfg(test)]
mod tests;
