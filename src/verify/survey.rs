//! How near the head comes to what it does not print on, move by move: for pictures. Nothing is judged by it, and verification alone
//! does without.
//!
//! What counts is everything laid before, but the part itself and its supports, and the table where the part does not stand on it or is tilted; for the piece that
//! carries the tip also without the parts that share a face with the one printed, as for the least clearance. So this is the room to
//! what a print could strike, not the constant one between the heater block and the layer just laid. A lower bound, mm: the way of the
//! tip since a measured place is taken off what was measured there, and measured anew where either way leaves the other by more than
//! [`FINE_MM`]: a short line beside one end of a long one has nothing to do with what is near the other.

use std::ops::Range;

use super::acts::{Acts, Go, Kind, Stroke};
use super::astray::{as_planned, is_astray};
use super::hull::Hull;
use super::material::Material;
use super::near::{Near, Strangers, TipWay};
use super::swivelling::head_at;
use super::walk::{LEVEL, strangers};
use super::{Planned, ReplayJob};
use crate::geom::{Bounds, Machine, Rigid, Table, Vec3};
use crate::motion::Pose;

/// Room beyond this is not told apart, mm: a greater one is nobody's worry.
pub const SURVEYED_MM: f64 = 5.0;
/// Ways no farther apart than this, mm, have one measure: the bound is at most twice as much low.
const FINE_MM: f64 = 0.125;
/// Rooms are rounded down to multiples of this, mm, so that moves with the same colour are one run.
const STEP_MM: f64 = 0.25;

/// Moves at most that are looked at together.
const LONGEST_RUN: usize = 128;
/// How far is looked, mm.
const LOOKED_MM: f64 = 2.0 * SURVEYED_MM;

/// The room that the head has during some moves.
#[derive(Clone, Debug, PartialEq)]
pub struct HeadRoom {
    /// Places in the trace.
    pub moves: Range<usize>,
    /// At least so much, mm, at most [`SURVEYED_MM`]; 0 where there is none.
    pub mm: f64,
}

/// The rooms of a program's moves, in its order; moves of no print, and those at an unknown pose or one that is not the print's, have none.
pub(super) fn survey(acts: &Acts<'_>, job: &ReplayJob<'_>, planned: &[Planned]) -> Vec<HeadRoom> {
    let of_print = |print: &Planned| {
        let level = (print.up - Vec3::z()).norm() < LEVEL;
        let touches_table = level && job.workpiece.model.on_table.contains(&print.part);
        (planned.iter().map(|other| other.part != print.part).collect(), !touches_table)
    };
    let mut surveyor = Surveyor {
        head: head_at(job.profile, Pose::LEVEL),
        material: Material::new(job.profile.table_slab()),
        strangers: strangers(job, planned),
        others: planned.iter().map(of_print).collect(),
        setup: None,
        run: Vec::new(),
        print: None,
        rooms: Vec::new(),
    };
    let table = job.profile.kinematics();
    let planned_back = as_planned(&table, planned);
    let (mut pose, mut astray) = (None, None);
    for m in acts.trace.moves() {
        if let Some(turn) = acts.turn(&m) {
            surveyor.leave();
            (pose, astray) = (turn.to, None);
        } else if acts.trace.has_new_pose(&m) {
            surveyor.leave();
            (pose, astray) = (acts.trace.state(&m).pose(), None);
        }
        if let (Some(Go::Stroke(stroke)), Some(pose)) = (acts.go(&m), pose) {
            if *astray.get_or_insert_with(|| is_astray(acts.trace, &table, planned, m.index, pose)) {
                let back = stroke.print.filter(|_| stroke.kind == Kind::Print).map(|p| &planned_back[p as usize]);
                back.into_iter().for_each(|back| surveyor.material.lay(&stroke, back));
                continue;
            }
            surveyor.goes(m.index, &stroke, || {
                (table.forward(pose), table.head.is_some().then(|| head_at(job.profile, pose)))
            });
        }
    }
    surveyor.leave();
    joined(surveyor.rooms)
}

/// Runs with the same room as one.
fn joined(rooms: Vec<HeadRoom>) -> Vec<HeadRoom> {
    let mut all: Vec<HeadRoom> = Vec::with_capacity(rooms.len());
    for room in rooms {
        match all.last_mut() {
            Some(last) if last.mm == room.mm && last.moves.end == room.moves.start => last.moves.end = room.moves.end,
            _ => all.push(room),
        }
    }
    all
}

/// One pose: its beads by place, and the way back to the table's frame.
struct Setup {
    near: Near,
    back: Rigid<Machine, Table>,
}

struct Surveyor {
    head: Vec<Hull>,
    material: Material,
    /// By print, what the piece that carries the tip must stay away from.
    strangers: Vec<Vec<bool>>,
    /// By print, what the rest must, and whether the table counts.
    others: Vec<(Vec<bool>, bool)>,
    setup: Option<Setup>,
    /// Moves of one print after one another, with the tip's ways.
    run: Vec<(usize, [Vec3; 2])>,
    print: Option<u32>,
    rooms: Vec<HeadRoom>,
}

impl Surveyor {
    fn goes(
        &mut self,
        index: usize,
        stroke: &Stroke,
        posed: impl FnOnce() -> (Rigid<Table, Machine>, Option<Vec<Hull>>),
    ) {
        if stroke.print != self.print || self.run.len() >= LONGEST_RUN {
            self.look();
            self.print = stroke.print;
        }
        let setup = self.setup.get_or_insert_with(|| {
            let (motion, head) = posed();
            if let Some(head) = head {
                self.head = head;
            }
            Setup { near: Near::new(motion, &self.material, self.head.len()), back: motion.inverse() }
        });
        if stroke.print.is_some() {
            self.run.push((index, [stroke.from, stroke.to]));
        }
        if matches!(stroke.kind, Kind::Print) {
            self.material.lay(stroke, &setup.back);
        }
    }

    /// The pose ends here.
    fn leave(&mut self) {
        self.look();
        (self.setup, self.print) = (None, None);
    }

    /// Looks at the run; the beads of its own part, laid meanwhile, do not count.
    fn look(&mut self) {
        let ways = std::mem::take(&mut self.run);
        let (Some(Setup { near, .. }), Some(print), false) = (&mut self.setup, self.print, ways.is_empty()) else {
            return;
        };
        let (prints, table) = &self.others[print as usize];
        let others = Strangers { prints, table: *table, laid: usize::MAX };
        let tip = Strangers { prints: &self.strangers[print as usize], ..others };
        let within = Bounds::of(ways.iter().flat_map(|(_, way)| *way));
        let mut rooms = vec![SURVEYED_MM; ways.len()];
        for hull in &self.head {
            let strangers = if hull.tip { &tip } else { &others };
            if !near.is_nearer(&self.material, hull, &TipWay::Within(within), SURVEYED_MM, strangers) {
                continue;
            }
            let mut known: Option<([Vec3; 2], f64)> = None;
            for ((_, way), room) in ways.iter().zip(&mut rooms) {
                if let Some((at, mm)) = &known {
                    let since = away(way, at);
                    if mm - since >= *room || since.max(away(at, way)) <= FINE_MM {
                        *room = room.min(mm - since);
                        continue;
                    }
                }
                // Looked for beyond what is told, so that the answer serves for the moves that follow.
                let mm = near.room_to_strangers(&self.material, hull, &TipWay::Line(*way), LOOKED_MM, strangers);
                known = Some((*way, mm));
                *room = room.min(mm);
            }
        }
        let told = |mm: f64| ((mm / STEP_MM).floor() * STEP_MM).max(0.0);
        let each = ways.iter().zip(rooms).map(|((index, _), mm)| HeadRoom { moves: *index..index + 1, mm: told(mm) });
        self.rooms.extend(each);
    }
}

/// How far any place of a straight way is from another at most, mm: one of its ends is the farthest.
fn away(way: &[Vec3; 2], [a, b]: &[Vec3; 2]) -> f64 {
    let along = b - a;
    let to_it = |p: &Vec3| {
        let t = ((p - a).dot(&along) / along.norm_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        (p - (a + along * t)).norm()
    };
    way.iter().map(to_it).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_short_way_is_near_a_long_one_and_not_the_other_way_round() {
        let at = |x: f64, y: f64| Vec3::new(x, y, 0.0);
        let (long, short) = ([at(0.0, 0.0), at(50.0, 0.0)], [at(48.0, 0.1), at(49.0, 0.0)]);
        assert!((away(&short, &long) - 0.1).abs() < 1e-12);
        // From its far end to the short one's near end.
        assert!((away(&long, &short) - 48.0_f64.hypot(0.1)).abs() < 1e-12);
        assert_eq!(away(&long, &[long[1], long[0]]), 0.0);
    }
}
