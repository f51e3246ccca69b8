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
mod tests {
    use super::super::acts::Kind;
    use super::super::field::Rect;
    use super::*;

    const WIDTH: f32 = 0.45;
    const HEIGHT: f32 = 0.2;
    const BRIDGE_MM: f64 = 14.0;

    /// The stretches that are too long of a line through these places, 10 mm up, over two walls along y at `walls` (x from and to).
    fn too_long(walls: &[[f64; 2]], way: &[[f64; 2]]) -> Vec<f64> {
        all_too_long(walls, &[way.to_vec()])
    }

    /// The same of several lines.
    fn all_too_long(walls: &[[f64; 2]], ways: &[Vec<[f64; 2]>]) -> Vec<f64> {
        too_long_of(walls, ways, usize::MAX)
    }

    /// The same, all but the first `lower` of them a layer above the others.
    fn too_long_of(walls: &[[f64; 2]], ways: &[Vec<[f64; 2]>], lower: usize) -> Vec<f64> {
        let mut field = Field::new(&Rect { min: [-40.0; 2], max: [40.0; 2] });
        for [from, to] in walls {
            let lines = ((to - from) / 0.2).round() as usize;
            let at = |k: usize| from + (to - from) * (k as f64 + 0.5) / lines as f64;
            (0..lines).for_each(|k| field.deposit([[at(k), -30.0], [at(k), 30.0]], 0.3, 10.0 - f64::from(HEIGHT)));
        }
        field.settle();
        let (mut laying, mut found) = (Laying::new(BRIDGE_MM), Vec::new());
        for (k, way) in ways.iter().enumerate() {
            let z = if k < lower { 10.0 } else { 10.0 + f64::from(HEIGHT) };
            for ends in way.windows(2) {
                let [from, to] = [ends[0], ends[1]].map(|[x, y]| Vec3::new(x, y, z));
                let stroke = Stroke { from, to, line: 1, print: None, kind: Kind::Print, width: WIDTH, height: HEIGHT };
                laying.lay(&stroke, &mut field, &mut found);
            }
            laying.end(&mut field, &mut found);
        }
        laying.settle(&mut found);
        found.iter().map(|gap| gap.length).collect()
    }

    /// Walls on both sides of a gap so wide.
    fn gap(wide: f64) -> [[f64; 2]; 2] {
        [[-wide / 2.0 - 8.0, -wide / 2.0], [wide / 2.0, wide / 2.0 + 8.0]]
    }

    /// A ring around, from the middle of its side along x.
    fn ring([x, y]: [f64; 2]) -> Vec<[f64; 2]> {
        vec![[0.0, -y], [x, -y], [x, y], [-x, y], [-x, -y], [0.0, -y]]
    }

    #[test]
    fn a_loop_that_begins_over_a_gap_spans_it_once() {
        // From wall to wall, twice, and begun in the middle of the gap.
        assert_eq!(too_long(&gap(13.0), &ring([10.0, 3.0])), Vec::<f64>::new());
        // The same line, not closed, has two ends in the air.
        let open = ring([10.0, 3.0]).into_iter().take(5).chain([[-1.0, -3.0]]).collect::<Vec<_>>();
        assert_eq!(too_long(&gap(13.0), &open).len(), 2);
        // Too wide: both spans are.
        let found = too_long(&gap(18.0), &ring([14.0, 3.0]));
        assert!(found.len() == 2 && found.iter().all(|mm| *mm > 15.0), "{found:?}");
    }

    #[test]
    fn a_ring_that_touches_nothing_but_itself_lies_on_nothing() {
        for half in [0.6, 0.9, 1.5, 3.0] {
            let found = too_long(&gap(30.0), &ring([half, half]));
            assert!(found.len() == 1 && found[0] > 2.0, "{half}: {found:?}");
        }
    }

    /// A floor in the middle of a layer is printed a layer lower by some slicers, and they leave air below their own supports, too.
    #[test]
    fn supports_stand_on_a_part_with_as_much_air_as_above_them() {
        let layer = f64::from(HEIGHT);
        let hangs = |layers: u32, gap_mm: f64, holds: bool| {
            let mut field = Field::new(&Rect { min: [-40.0; 2], max: [40.0; 2] });
            let top = 10.0 - layer * f64::from(layers + 1);
            field.settle();
            let at = |k: i32| f64::from(k) * 0.3 - 6.0;
            (0..40).for_each(|k| field.deposit([[at(k), -30.0], [at(k), 30.0]], 0.3, top));
            let (mut laying, mut gaps) = (Laying::new(BRIDGE_MM), Vec::new());
            laying.with_supports(gap_mm, holds);
            let [from, to] = [-10.0, 10.0].map(|y| Vec3::new(0.0, y, 10.0));
            let stroke = Stroke { from, to, line: 1, print: None, kind: Kind::Print, width: WIDTH, height: HEIGHT };
            laying.lay(&stroke, &mut field, &mut gaps);
            laying.end(&mut field, &mut gaps);
            laying.settle(&mut gaps);
            !gaps.is_empty()
        };
        for (layers, gap_mm, found) in
            [(0, 0.2, false), (1, 0.2, false), (2, 0.2, true), (1, 0.0, true), (2, 0.3, false)]
        {
            assert_eq!(hangs(layers, gap_mm, true), found, "{layers} layers of air, gap {gap_mm}");
            assert_eq!(hangs(layers, 0.0, false), layers > 0, "a part with {layers} layers of air");
        }
    }

    /// A hole above a counterbore: the loop comes first, then what holds it.
    #[test]
    fn a_ring_is_held_by_what_its_layer_lays_after_it() {
        let walls = gap(9.0);
        let ring = || ring([2.0, 2.0]);
        // From wall to wall beside it, and from both walls to it.
        let across: Vec<Vec<[f64; 2]>> = [-2.4, 2.4].map(|y| vec![[-7.0, y], [7.0, y]]).to_vec();
        let left = |y: f64| vec![[-7.0, y], [-2.1, y]];
        let right = |y: f64| vec![[2.1, y], [7.0, y]];
        let spokes = |of: &dyn Fn(f64) -> Vec<[f64; 2]>| [-1.5, -0.5, 0.5, 1.5].map(of).to_vec();
        let whole = [vec![ring()], across.clone(), spokes(&left), spokes(&right)].concat();
        assert_eq!(all_too_long(&walls, &whole), Vec::<f64>::new());
        // A second ring around it, which the bridges meet.
        let outer = vec![[0.0, -2.4], [2.4, -2.4], [2.4, 2.4], [-2.4, 2.4], [-2.4, -2.4], [0.0, -2.4]];
        let far: Vec<Vec<[f64; 2]>> = [-2.8, 2.8].map(|y| vec![[-7.0, y], [7.0, y]]).to_vec();
        assert_eq!(all_too_long(&walls, &[vec![ring(), outer], far].concat()), Vec::<f64>::new());
        // From one side alone, or beyond its layer's end, it is not.
        let one_side = [vec![ring()], spokes(&left)].concat();
        assert_eq!(all_too_long(&walls, &one_side).len(), 1);
        // The filling of a disc in the air, which has nothing but the ring; as wide as it may be.
        for half in [1.0, 2.0, 4.0] {
            let lines = (0..(half * 4.0) as usize).map(|k| -half + 0.25 + 0.45 * k as f64).filter(|y| *y < half);
            let filling = lines.map(|y| vec![[-half, y], [half, y]]);
            let disc: Vec<Vec<[f64; 2]>> = std::iter::once(super::tests::ring([half, half])).chain(filling).collect();
            assert_eq!(all_too_long(&gap(30.0), &disc).len(), 1, "{half}");
        }
        // The same in one line, row after row, each beside the one before: nothing but itself.
        for half in [1.0, 2.0, 3.0, 4.0, 5.0] {
            let rows = (0..(half * 4.0) as usize).map(|k| -half + 0.25 + 0.45 * k as f64).filter(|y| *y < half);
            let rows: Vec<f64> = rows.collect();
            let turn = |k: usize, y: f64| {
                let ends = [[-half, y], [half, y]];
                if k.is_multiple_of(2) { ends } else { [ends[1], ends[0]] }
            };
            let zigzag = rows.iter().enumerate().flat_map(|(k, y)| turn(k, *y)).collect();
            let disc = [super::tests::ring([half, half]), zigzag];
            assert_eq!(all_too_long(&gap(30.0), &disc).len(), 1, "{half}");
            // On a wall at one end of its rows it lies on something, and holds the ring where it meets it: from one side.
            let far: Vec<[f64; 2]> =
                disc[1].iter().map(|[x, y]| [if *x < 0.0 { -20.0 } else { -half - 0.1 }, *y]).collect();
            assert_eq!(all_too_long(&gap(30.0), &[disc[0].clone(), far]).len(), 1, "{half}");
        }
        // What the next layer lays comes too late.
        assert_eq!(too_long_of(&walls, &[vec![ring()], across, spokes(&left), spokes(&right)].concat(), 1).len(), 1);
        // A ring too large to be held so.
        let large = [vec![super::tests::ring([6.0, 6.0])], vec![vec![[-20.0, 6.4], [20.0, 6.4]]]].concat();
        assert!(!all_too_long(&gap(13.0), &large).is_empty());
    }

    /// A tab that goes out from a wall into the air: its outline hangs for more than half of itself, and what fills it begins on the wall.
    #[test]
    fn what_fills_an_outline_does_not_hold_it() {
        for mm in [3.0, 4.0, 6.0, 10.0, 20.0] {
            let outline = vec![[-1.0, 0.0], [-1.0, -3.0], [mm, -3.0], [mm, 3.0], [-1.0, 3.0], [-1.0, 0.0]];
            let turn = |k: usize, ends: [[f64; 2]; 2]| if k.is_multiple_of(2) { ends } else { [ends[1], ends[0]] };
            // Row by row out and back, in one line or in several; or across, farther and farther out.
            let out: Vec<[[f64; 2]; 2]> = (0..13)
                .map(|k| (k, -2.6 + 0.43 * k as f64))
                .map(|(k, y)| turn(k, [[-4.0, y], [mm - 0.4, y]]))
                .collect();
            let count = ((mm + 4.0) / 0.43) as usize;
            let across: Vec<[f64; 2]> = (0..count)
                .map(|k| (k, -4.0 + 0.43 * k as f64))
                .flat_map(|(k, x)| turn(k, [[x, -2.6], [x, 2.6]]))
                .collect();
            let joined = vec![out.concat()];
            let rows = out.iter().map(|row| row.to_vec()).collect();
            for filling in [joined, rows, vec![across]] {
                let found = all_too_long(&[[-8.0, 0.0]], &[vec![outline.clone()], filling].concat());
                assert!(!found.is_empty(), "{mm}");
            }
        }
    }

    #[test]
    fn what_turns_over_air_is_no_bridge() {
        // Out from a wall, along, and back.
        let out = |mm: f64, wide: f64| {
            let (wall, end) = (-15.0 - 2.0, -15.0 + mm);
            vec![[wall, 0.0], [end, 0.0], [end, wide], [wall, wide]]
        };
        assert_eq!(too_long(&gap(30.0), &out(2.0, 3.0)), Vec::<f64>::new());
        let found = too_long(&gap(30.0), &out(2.6, 8.0));
        assert!(found.len() == 1 && found[0] > TURNED_MM && found[0] < BRIDGE_MM, "{found:?}");
        // As much in one direction is one.
        assert_eq!(too_long(&gap(12.0), &[[-10.0, 0.0], [10.0, 0.0]]), Vec::<f64>::new());
    }

    /// PrusaSlicer 2.9 does not warn of ledges 2 mm wide along 16 mm, nor of those 1.5 mm wide along 25 mm.
    #[test]
    fn the_rim_of_a_narrow_ledge_turns_over_air() {
        let rim = |out: f64, long: f64| vec![[-4.0, 0.0], [out, 0.0], [out, long], [-4.0, long]];
        let wall = [[-12.0, 0.0]];
        for (out, long, found) in [
            (1.2, 15.0, 0),
            (1.2, 25.0, 0),
            (1.2, 29.0, 0),
            (1.65, 25.0, 1),
            (1.7, 12.0, 0),
            (1.7, 15.0, 0),
            (1.7, 18.0, 1),
            (2.6, 12.0, 1),
            (2.6, 4.0, 0),
            (6.0, 4.0, 1),
        ] {
            assert_eq!(too_long(&wall, &rim(out, long)).len(), found, "out by {out} mm along {long} mm");
            // The same as a part of an outline that begins on the ledge, or beside it.
            let around = |from: [f64; 2]| {
                [vec![from, [out, long], [-10.0, long], [-10.0, 0.0], [out, 0.0]], vec![from]].concat()
            };
            assert_eq!(too_long(&wall, &around([out, long / 2.0])).len(), found, "a closed line, {out} and {long} mm");
        }
        // A thin tab's way back is not held by its way out.
        assert_eq!(too_long(&wall, &rim(7.0, 1.0)).len(), 1);
    }

    /// The roof of a hole with a notch in its side: the outline goes around the notch over air, and then bridges run beside it.
    #[test]
    fn what_turns_over_air_is_held_by_bridges_beside_it() {
        let walls = gap(9.0);
        let notch = vec![[-7.0, -2.5], [-3.0, -2.5], [-3.0, 0.5], [3.0, 0.5], [3.0, -2.5], [7.0, -2.5]];
        assert_eq!(too_long(&walls, &notch).len(), 1);
        let rows =
            |from: f64, to: f64| -> Vec<Vec<[f64; 2]>> { [0.95, 1.4].map(|y| vec![[from, y], [to, y]]).to_vec() };
        let zigzag = vec![vec![[-7.0, 0.95], [7.0, 0.95], [7.0, 1.4], [-7.0, 1.4]]];
        for (bridges, found) in [(rows(-7.0, 7.0), 0), (zigzag, 0), (rows(-7.0, 2.0), 1), (rows(-3.0, 3.0), 1)] {
            assert_eq!(
                all_too_long(&walls, &[vec![notch.clone()], bridges.clone()].concat()).len(),
                found,
                "{bridges:?}"
            );
        }
        // What the next layer lays comes too late; and a notch of which a side is too far from the bridges is not held.
        assert_eq!(too_long_of(&walls, &[vec![notch.clone()], rows(-7.0, 7.0)].concat(), 1).len(), 1);
        let deep: Vec<[f64; 2]> = notch.iter().map(|[x, y]| [*x, if *y < 0.0 { -8.5 } else { *y }]).collect();
        assert!(!all_too_long(&walls, &[vec![deep], rows(-7.0, 7.0)].concat()).is_empty());
        // A tab's rows, out and back, hold nothing: neither in one line nor in many.
        let tab = vec![[-1.0, -3.0], [6.0, -3.0], [6.0, 3.0], [-1.0, 3.0]];
        let out: Vec<[[f64; 2]; 2]> =
            (0..13).map(|k| -2.6 + 0.43 * f64::from(k)).map(|y| [[-4.0, y], [5.6, y]]).collect();
        let one = out.iter().enumerate().flat_map(|(k, [a, b])| if k % 2 == 0 { [*a, *b] } else { [*b, *a] }).collect();
        for filling in [vec![one], out.iter().map(|row| row.to_vec()).collect()] {
            assert!(!all_too_long(&[[-8.0, 0.0]], &[vec![tab.clone()], filling].concat()).is_empty());
        }
    }

    #[test]
    fn small_patches_go_out_farther_than_a_line_stays_up() {
        let wall = [[-8.0, 0.0]];
        // So many lines out from the wall, too far from each other to carry one another, begun on it and, every second one, in the air.
        let comb = |count: usize, mm: f64, from: f64| -> Vec<Vec<[f64; 2]>> {
            let line = |k: usize| {
                let y = from + k as f64;
                let way = [[-4.0, y], [mm, y]];
                if k.is_multiple_of(2) { way.to_vec() } else { way.into_iter().rev().collect() }
            };
            (0..count).map(line).collect()
        };
        // What the wall's cells reach beyond it.
        let out = |mm: f64| mm + 0.3;
        for (count, mm, found) in [
            (1, 1.9, 0),
            (30, 1.9, 0),
            (1, 2.5, 0),
            (6, 2.5, 0),
            (8, 2.5, 0),
            (14, 2.5, 14),
            (20, 2.5, 20),
            (6, 2.9, 0),
            (12, 2.9, 12),
            (1, 3.8, 1),
            (3, 3.8, 3),
        ] {
            assert_eq!(all_too_long(&wall, &comb(count, out(mm), -10.0)).len(), found, "{count} lines out by {mm} mm");
        }
        // Two patches, each small, with a gap between them; and as one, with short lines in it.
        let two = |middle: Vec<Vec<[f64; 2]>>| [comb(6, out(2.5), -12.0), middle, comb(6, out(2.5), -2.0)].concat();
        assert_eq!(all_too_long(&wall, &two(Vec::new())).len(), 0);
        assert_eq!(all_too_long(&wall, &two(comb(4, out(1.5), -6.0))).len(), 12);
    }

    #[test]
    fn a_patch_is_of_one_layer_whatever_lies_in_between() {
        // Lines out by 2.5 mm, the height of each so much above the one before, back and forth.
        let patch = |apart: f64| {
            let mut field = Field::new(&Rect { min: [-40.0; 2], max: [40.0; 2] });
            (0..40).for_each(|k| {
                field.deposit([[-8.0 + 0.2 * f64::from(k), -30.0], [-8.0 + 0.2 * f64::from(k), 30.0]], 0.3, 9.8)
            });
            field.settle();
            let (mut laying, mut found) = (Laying::new(BRIDGE_MM), Vec::new());
            for k in 0..14 {
                let at = |x: f64| Vec3::new(x, f64::from(k), 10.0 + apart * f64::from(k % 2));
                let stroke = Stroke {
                    from: at(-4.0),
                    to: at(2.8),
                    line: 1,
                    print: None,
                    kind: Kind::Print,
                    width: WIDTH,
                    height: HEIGHT,
                };
                laying.lay(&stroke, &mut field, &mut found);
                laying.end(&mut field, &mut found);
            }
            laying.settle(&mut found);
            found.len()
        };
        assert_eq!([0.0, 1e-6, 0.01].map(patch), [14; 3]);
    }
}
