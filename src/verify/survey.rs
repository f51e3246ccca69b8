//! How near the head comes, by short runs of moves: for pictures. Nothing is judged by it, and verification alone does without.
//!
//! A run of moves is the box of the tip's places, so what is told is a lower bound; where something is near the run is halved, down to
//! a few moves. The same counts as for the least clearance: the piece that carries the tip against prints that carry nothing of its
//! own, the others against everything laid before the run.

use std::ops::Range;

use super::acts::Acts;
use super::hull::Hull;
use super::material::Material;
use super::near::{Near, Strangers, TipWay};
use crate::geom::Bounds;

/// Room beyond this is not told apart, mm: a greater one is nobody's worry.
pub const SURVEYED_MM: f64 = 5.0;
/// Runs of so many moves are not halved any more.
const SHORTEST: usize = 16;

/// The room that the head has during some moves.
#[derive(Clone, Debug, PartialEq)]
pub struct Room {
    /// Places in the trace.
    pub moves: Range<usize>,
    /// At least so much, mm, at most [`SURVEYED_MM`]; 0 where the box of the moves leaves none.
    pub mm: f64,
}

/// Runs of moves with their rooms, as they come.
pub(super) struct Survey {
    pub(super) rooms: Vec<Room>,
    /// By print: everything counts.
    pub(super) all: Vec<bool>,
}

impl Survey {
    /// Looks at `moves` of one print; `strangers` are those of the piece that carries the tip.
    pub(super) fn look(
        &mut self,
        (acts, material, head): (&Acts<'_>, &Material, &[Hull]),
        near: &mut Near,
        moves: Range<usize>,
        strangers: &Strangers<'_>,
    ) {
        let strokes = moves.clone().filter_map(|index| acts.stroke(index));
        let (within, count) = strokes.fold((Bounds::EMPTY, 0), |(all, count), stroke| {
            (all.union(&Bounds::of([stroke.from, stroke.to])), count + 1)
        });
        if count == 0 {
            return;
        }
        let everything = Strangers { prints: &self.all, table: true, laid: strangers.laid };
        let way = TipWay::Within(within);
        let room = head.iter().fold(SURVEYED_MM, |room, hull| {
            let others = if hull.tip { strangers } else { &everything };
            room.min(near.room_to_strangers(material, hull, &way, room, others))
        });
        if room < SURVEYED_MM && count > SHORTEST {
            let middle = usize::midpoint(moves.start, moves.end);
            self.look((acts, material, head), near, moves.start..middle, strangers);
            self.look((acts, material, head), near, middle..moves.end, strangers);
        } else {
            self.rooms.push(Room { moves, mm: room.max(0.0) });
        }
    }
}
