//! The head on its way over what stands: the piece that carries the tip may dip into what it prints on and keeps away from other prints, all other
//! pieces touch nothing. Machine coordinates, mm. The height field bounds the room from below ([`Field`]), [`Near`](super::super::near::Near) has
//! the distance itself.

use std::ops::Range;

use super::super::field::{Field, Rect};
use super::super::hull::Hull;
use super::super::near::{Strangers, TipWay};
use super::super::report::{NearestApproach, Rule};
use super::{Setup, Walker};
use crate::geom::{Bounds, Machine, Rigid, Table, Vec3};

/// To how much the least distance is told, mm.
const FIGURE_MM: f64 = 0.01;

/// Moves at most that are held against other prints as one, and runs of them at most that wait for it.
const LONGEST_RUN: usize = 128;
const MOST_RUNS: usize = 512;
/// One of so many is looked at first.
const LOOKED_AT_FIRST: usize = 16;

/// Moves of one print after one another.
pub(super) struct Run {
    print: u32,
    /// Places in the trace.
    moves: Range<usize>,
    /// How many beads had been laid before.
    laid: usize,
}

impl Walker<'_> {
    /// The head on the tip's way between `ends`; judged by pieces of the way down to `finest`.
    pub(super) fn sweep(&mut self, setup: &mut Setup, ends: [Vec3; 2], line: u32, finest: [f64; 2]) {
        if self.strikes >= self.most_strikes {
            return;
        }
        let head = std::mem::take(&mut self.head);
        for (piece, hull) in head.iter().enumerate() {
            if hull.tip {
                self.touch(setup, hull, ends, line, finest[0]);
            } else {
                self.pass(setup, piece, hull, ends, line, finest[1]);
            }
        }
        self.head = head;
    }

    /// The piece that carries the tip may dip into what it prints on by as much as lines give way.
    ///
    /// Where the field's cells say that it dips deeper, what they hold is asked: so much higher, with all above it, it would meet none.
    fn touch(&mut self, setup: &mut Setup, hull: &Hull, ends: [Vec3; 2], line: u32, finest: f64) {
        let room = least(&setup.field, hull, ends, finest, -self.contact, Field::room, &mut self.walked.steps);
        if room >= -self.contact {
            return;
        }
        let higher = TipWay::Line(ends.map(|tip| tip + Vec3::z() * self.contact));
        if !finest.is_finite() || setup.near.meets(&self.material, hull, &higher) {
            self.hit(hull, line, [-room, self.contact]);
        }
    }

    /// Takes note that a move of the print goes past what it does not stand on; see [`Walker::apart`].
    pub(super) fn passes(&mut self, setup: &mut Setup, index: usize) {
        let Some(print) = self.print else { return };
        match self.runs.last_mut() {
            Some(run) if run.print == print && index - run.moves.start < LONGEST_RUN => run.moves.end = index + 1,
            _ => {
                if self.runs.len() >= MOST_RUNS {
                    self.apart(setup);
                }
                self.runs.push(Run { print, moves: index..index + 1, laid: self.material.beads().len() });
            }
        }
    }

    /// How near the piece that carries the tip comes to the prints that carry nothing of the one it prints, and to the table where that
    /// does not stand on it, or is tilted: of all runs of moves so far.
    ///
    /// A few are looked at first: what they come near to is what most others need not be looked at for.
    pub(super) fn apart(&mut self, setup: &mut Setup) {
        let runs = std::mem::take(&mut self.runs);
        let (first, rest): (Vec<_>, Vec<_>) = runs.iter().enumerate().partition(|(i, _)| i % LOOKED_AT_FIRST == 0);
        let head = std::mem::take(&mut self.head);
        for (_, run) in first.into_iter().chain(rest) {
            for hull in head.iter().filter(|hull| hull.tip) {
                self.stays_apart(setup, hull, run, run.moves.clone());
            }
        }
        self.head = head;
    }

    /// The same of some moves of a run: as one, then by halves.
    fn stays_apart(&mut self, setup: &mut Setup, hull: &Hull, run: &Run, moves: Range<usize>) {
        let cap = self.walked.clearance - FIGURE_MM;
        let strokes = moves.clone().filter_map(|index| self.acts.stroke(index));
        let (within, count, line) = strokes.fold((Bounds::EMPTY, 0, 0), |(all, count, _), stroke| {
            (all.union(&Bounds::of([stroke.from, stroke.to])), count + 1, stroke.line)
        });
        if count == 0 || cap <= 0.0 {
            return;
        }
        let prints = &self.strangers[run.print as usize];
        let table = !(setup.level && self.on_table.contains(&self.planned[run.print as usize].part));
        let strangers = Strangers { prints, table, laid: run.laid };
        if count > 1 {
            if setup.near.is_nearer(&self.material, hull, &TipWay::Within(within), cap, &strangers) {
                let middle = usize::midpoint(moves.start, moves.end);
                self.stays_apart(setup, hull, run, moves.start..middle);
                self.stays_apart(setup, hull, run, middle..moves.end);
            }
            return;
        }
        let Some(stroke) = moves.clone().find_map(|index| self.acts.stroke(index)) else { return };
        let way = TipWay::Line([stroke.from, stroke.to]);
        let room = setup.near.room_to_strangers(&self.material, hull, &way, cap, &strangers);
        if room < cap {
            let pair = setup.near.nearest(hull, &way, room + FIGURE_MM, Some(&strangers));
            self.note(room, line);
            self.walked.clearance_at = NearestApproach::of(pair, hull, [stroke.from, stroke.to], &setup.back);
        }
    }

    /// The rest of the head touches nothing at all.
    fn pass(&mut self, setup: &mut Setup, piece: usize, hull: &Hull, ends: [Vec3; 2], line: u32, finest: f64) {
        let cap = self.walked.clearance.max(0.0);
        let bound = least(&setup.field, hull, ends, finest, cap, Field::distance, &mut self.walked.steps);
        if bound >= cap - FIGURE_MM {
            return;
        }
        // Somewhere in a box is not on the way between its corners.
        let way = finest.is_finite();
        let room = if way { setup.near.distance(&self.material, piece, hull, &TipWay::Line(ends), cap) } else { 0.0 };
        let room = if room > 0.0 || (!way && bound > 0.0) { room.max(bound) } else { bound.min(0.0) };
        if self.note(room, line) && way && room > 0.0 {
            let pair = setup.near.nearest(hull, &TipWay::Line(ends), room + FIGURE_MM, None);
            self.walked.clearance_at = NearestApproach::of(pair, hull, ends, &setup.back);
        }
        if room <= 0.0 {
            self.hit(hull, line, [-room, 0.0]);
        }
    }

    fn hit(&mut self, hull: &Hull, line: u32, [deep, most]: [f64; 2]) {
        let (at, name) = (self.place(line), &hull.name);
        self.strikes += 1;
        self.walked.findings.add(Rule::HeadCollision, at, [deep, most], || {
            format!("the {name} reaches {deep:.2} mm into the table or the print (maximum {most:.3} mm)")
        });
    }
}

/// A lower bound of what `measure` says of `hull` on the way of the tip, up to `cap`; each place that it is asked of is a step.
fn least(
    field: &Field,
    hull: &Hull,
    [a, b]: [Vec3; 2],
    finest: f64,
    cap: f64,
    measure: impl Fn(&Field, &Hull, &Rect, f64, f64) -> f64 + Copy,
    steps: &mut u64,
) -> f64 {
    *steps += 1;
    let low = a.inf(&b);
    let (low, high) = (hull.body.origin_at(&low), hull.body.origin_at(&a.sup(&b)));
    if low.z + hull.bounds.min.z - field.highest() >= cap {
        return cap;
    }
    let origins = Rect { min: [low.x, low.y], max: [high.x, high.y] };
    let bound = measure(field, hull, &origins, low.z, cap);
    if bound >= cap || (b - a).norm() <= finest {
        return bound;
    }
    let middle = (a + b) * 0.5;
    let first = least(field, hull, [a, middle], finest, cap, measure, &mut *steps);
    least(field, hull, [middle, b], finest, first.min(cap), measure, steps).min(first)
}

impl NearestApproach {
    /// Of a place of a hull on the tip's way and of what is near it, with the origin of the hull's body there; machine frame.
    fn of(pair: Option<[Vec3; 3]>, hull: &Hull, [from, to]: [Vec3; 2], back: &Rigid<Machine, Table>) -> Option<Self> {
        let [head, other, origin] = pair?;
        // A ten-thousandth of a millimetre is less than beads are known to.
        let table = |p: Vec3| <[f64; 3]>::from(back.point(p.into()).at).map(|v| (v * 1e4).round() / 1e4 + 0.0);
        // A piece that does not follow every axis tells less of the tip; along the others it is where the tip is.
        let (start, along) = (hull.body.origin_at(&from), hull.body.origin_at(&to) - hull.body.origin_at(&from));
        let share = (origin - start).dot(&along) / along.norm_squared();
        let share = if share.is_finite() { share.clamp(0.0, 1.0) } else { 1.0 };
        Some(Self { head_mm: table(head), other_mm: table(other), share })
    }
}
