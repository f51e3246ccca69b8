//! A program as the machine would carry it out: bytes to moves, read once, for everybody who asks what a file does.
//!
//! ```text
//! bytes --read(.., &Setting)--> Trace { moves: columns, states: what changes seldom, events: what is no move }
//! line  --Interpreter::take--> Action { a move with its time, or an effect }     what read() does line by line
//! ```
//!
//! A program of five lines, and what its last move does:
//!
//! ```
//! use trunnion::profile::resolve;
//! use trunnion::trace::read;
//!
//! let (profile, _) = resolve("mine.toml", "extends = \"generic-ac\"")?;
//! // The table tilts to 90 degrees; then 30 mm of travel along Z, and 40 mm with filament along X (machine frame).
//! let program = b"G1 A90 C0 F1200\nG1 X0 Y0 Z10 F6000\nG92 E0\nG1 Z40\nG1 X40 E2.5 F1200\n";
//! let trace = read(program, &profile.trace_setting());
//!
//! let last = trace.moves().last().ok_or("no move")?;
//! assert_eq!((last.line, last.prints()), (5, true));
//! let [from, to] = last.ends().ok_or("an unknown place")?;
//! assert_eq!((to - from).norm(), 40.0);
//! assert_eq!(trace.state(&last).pose().map(|pose| pose.tilt.deg().round()), Some(90.0));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Moves are straight lines of the tip (arcs are taken along their chords), each with the line it stands on, the filament it
//! takes, what the slicer says of it, its time, and the [`State`] in which it ends: pose, print, heat. Where the head turns
//! ([`SwivelHead`]), the tip's places are those seen with the tool upright, each move at the pose in which it ends; while the pose is unknown
//! they are the words, counted from the table's centre. Everything else of the file
//! is an [`Event`] between two moves. Nothing is judged here, and nothing is left out.
//!
//! Units: mm, mm/min, seconds, degrees Celsius. Columns rather than records: 39 bytes a move, and a reader that looks at
//! heights alone reads heights alone.
//!
//! This room must not know profiles (they build its [`TraceSetting`]), plans or rules.

mod build;
mod clock;
mod interpreter;
mod rates;
#[cfg(test)]
mod tests;
mod totals;

pub use build::{TraceReader, read};
pub use clock::MotionClock;
pub use interpreter::{Action, Interpreter, Targets, TimedMove};
pub use rates::{FeedCount, Rates, TooFast};
pub use totals::totals;

use std::ops::Range;

use crate::gcode::marks::{Mark, Role};
use crate::gcode::meaning::Effect;
use crate::geom::Vec3;
use crate::motion::replay::{Position, Reading};
use crate::motion::{Accelerations, Pose, SwivelHead};

/// How a machine's files are read.
#[derive(Clone, Debug)]
pub struct TraceSetting {
    /// The words.
    pub reading: Reading,
    /// What F means, and the axes' fastest.
    pub rates: Rates,
    /// How fast speeds change.
    pub accelerations: Accelerations,
    /// The head, where it turns: moves are then those of the tip in its own frame.
    pub swivel: Option<SwivelHead>,
}

/// Where in the program something stands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Zone {
    /// Before the first slot's mark: the machine's own start code.
    #[default]
    Start,
    /// Among the prints.
    Prints,
    /// Behind the end's mark: the machine's own end code.
    End,
}

/// What changes seldom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    /// The table's tilt; `None` where the file has not said it yet.
    pub tilt: Option<crate::geom::Angle>,
    /// Its rotation.
    pub rotation: Option<crate::geom::Angle>,
    /// The print that the last mark named, in the order of the plan.
    pub print: Option<u32>,
    /// The slot that the last mark named.
    pub slot: Option<u32>,
    /// Which part of the program it is.
    pub zone: Zone,
    /// The least temperature that the nozzle is known to have; 0 where nothing has been waited for, and after motors or heaters
    /// went off.
    pub nozzle_c: f32,
}

impl State {
    /// The pose, where both angles are known.
    pub fn pose(&self) -> Option<Pose> {
        Some(Pose { tilt: self.tilt?, rotation: self.rotation? })
    }
}

/// What is no move.
#[derive(Clone, Debug, PartialEq)]
pub struct Event {
    /// The move that follows it.
    pub before: u32,
    /// In the file, from 1.
    pub line: u32,
    /// What it is.
    pub what: What,
}

/// The kinds of [`Event`].
#[derive(Clone, Debug, PartialEq)]
pub enum What {
    /// One of our marks.
    Mark(Mark),
    /// A broken mark's text.
    BrokenMark(String),
    /// A slicer's mark of a layer.
    Layer,
    /// A line that does something; its code's place in the file.
    Effect(Effect, Range<usize>),
    /// A line without a safe meaning.
    Refused(String),
    /// The move that follows asks an axis for more than it can.
    TooFast(TooFast),
}

/// What a move has besides its numbers, as bits.
mod flag {
    /// X, Y, Z written: bits 0 to 2.
    pub(super) const WRITTEN: u16 = 0b111;
    pub(super) const RAPID: u16 = 1 << 3;
    pub(super) const INVERSE_TIME: u16 = 1 << 4;
    pub(super) const ROTARY: u16 = 1 << 5;
    /// X, Y, Z unknown before: bits 6 to 8.
    pub(super) const FROM_UNKNOWN: u16 = 6;
    /// A chord of an arc but its first.
    pub(super) const CHORD: u16 = 1 << 9;
    /// A chord of an arc.
    pub(super) const ARC: u16 = 1 << 10;
}

/// Coordinates are kept in units of a tenth of a micron: no file's digits are lost, and 32 bits reach 200 m.
const UNITS_PER_MM: f64 = 1e4;
/// A coordinate that is not known.
const UNKNOWN: i32 = i32::MIN;

/// The whole program.
#[derive(Clone, Debug, Default)]
pub struct Trace {
    line: Vec<u32>,
    to: [Vec<i32>; 3],
    e: Vec<f32>,
    feed: Vec<f32>,
    at_speed_s: Vec<f32>,
    state: Vec<u32>,
    width_um: Vec<u16>,
    height_um: Vec<u16>,
    role: Vec<Role>,
    flags: Vec<u16>,
    /// States in the order in which they come up; the first is that of a machine just switched on.
    pub states: Vec<State>,
    /// Everything that is no move, in order.
    pub events: Vec<Event>,
    /// Lines in the file.
    pub lines: u32,
    /// Time of all moves, with accelerations, and waits (G4), s; see [`MotionClock`].
    pub seconds: f64,
}

/// One move, taken out of the columns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TraceMove {
    /// Its place in the trace.
    pub index: usize,
    /// In the file, from 1.
    pub line: u32,
    /// The tip before, mm; `None` where it is not known.
    pub from: [Option<f64>; 3],
    /// The tip after.
    pub to: [Option<f64>; 3],
    /// Filament, mm as the file counts; negative: pulled.
    pub e: f64,
    /// F as written; `None` before the first.
    pub feed: Option<f64>,
    /// Time at the speed written or the axes' fastest, s.
    pub seconds: f64,
    /// What the slicer says it is for.
    pub role: Role,
    /// Width and height that the slicer states, mm; `None` where it does not.
    pub width: Option<f64>,
    /// See `width`.
    pub height: Option<f64>,
    flags: u16,
    state: u32,
}

impl TraceMove {
    /// Both ends, where all is known.
    pub fn ends(&self) -> Option<[Vec3; 2]> {
        let point = |p: [Option<f64>; 3]| Some(Vec3::new(p[0]?, p[1]?, p[2]?));
        Some([point(self.from)?, point(self.to)?])
    }

    /// Whether the tip moves, as far as is known.
    pub fn travels(&self) -> bool {
        self.from != self.to
    }

    /// Whether filament is laid: pushed while the tip moves.
    pub fn prints(&self) -> bool {
        self.e > 0.0 && (self.travels() || self.flags & flag::ARC != 0)
    }

    /// Whether the word of axis `i` (X, Y, Z) was written.
    pub fn wrote(&self, i: usize) -> bool {
        self.flags & flag::WRITTEN & (1 << i) != 0
    }

    /// Whether a rotary word was written.
    pub fn wrote_rotary(&self) -> bool {
        self.flags & flag::ROTARY != 0
    }

    /// G0.
    pub fn is_rapid(&self) -> bool {
        self.flags & flag::RAPID != 0
    }

    /// Whether F counts an inverse time.
    pub fn is_inverse_time(&self) -> bool {
        self.flags & flag::INVERSE_TIME != 0
    }

    /// Whether it is a chord of an arc.
    pub fn is_arc(&self) -> bool {
        self.flags & flag::ARC != 0
    }

    /// Whether it is a chord of an arc that began with an earlier move.
    pub fn continues_arc(&self) -> bool {
        self.flags & flag::CHORD != 0
    }
}

impl Trace {
    /// Moves of any axis.
    pub fn len(&self) -> usize {
        self.line.len()
    }

    /// Whether nothing moves.
    pub fn is_empty(&self) -> bool {
        self.line.is_empty()
    }

    /// Move `index`.
    ///
    /// # Panics
    ///
    /// Panics where `index` is not below [`Trace::len`].
    pub fn at(&self, index: usize) -> TraceMove {
        let flags = self.flags[index];
        let known = |v: i32| (v != UNKNOWN).then(|| f64::from(v) / UNITS_PER_MM);
        let from = [0, 1, 2].map(|i| {
            let unknown = index == 0 || flags & (1 << (flag::FROM_UNKNOWN + i)) != 0;
            if unknown { None } else { known(self.to[usize::from(i)][index - 1]) }
        });
        let stated = |um: u16| (um > 0).then(|| f64::from(um) / 1000.0);
        TraceMove {
            index,
            line: self.line[index],
            from,
            to: [0, 1, 2].map(|i: usize| known(self.to[i][index])),
            e: f64::from(self.e[index]),
            feed: Some(f64::from(self.feed[index])).filter(|f| !f.is_nan()),
            seconds: f64::from(self.at_speed_s[index]),
            role: self.role[index],
            width: stated(self.width_um[index]),
            height: stated(self.height_um[index]),
            flags,
            state: self.state[index],
        }
    }

    /// All moves, in order.
    pub fn moves(&self) -> impl ExactSizeIterator<Item = TraceMove> + '_ {
        (0..self.len()).map(|index| self.at(index))
    }

    /// The state in which a move ends.
    pub fn state(&self, of: &TraceMove) -> &State {
        &self.states[of.state as usize]
    }

    /// The state in which a move begins, its pose above all.
    pub fn state_before(&self, of: &TraceMove) -> &State {
        if of.index == 0 { &self.states[0] } else { &self.states[self.state[of.index - 1] as usize] }
    }

    /// Whether the table turns during a move.
    pub fn turns(&self, of: &TraceMove) -> bool {
        of.wrote_rotary() && self.has_new_pose(of)
    }

    /// Whether a move is made at another pose than the one before it: it turns, or the pose was declared (`G92 A0 C0`) or
    /// forgotten (M84) between them.
    pub fn has_new_pose(&self, of: &TraceMove) -> bool {
        let (from, to) = (self.state_before(of), self.state(of));
        (from.tilt, from.rotation) != (to.tilt, to.rotation)
    }

    /// Gives each line the number that it has in another file: the one that this was made of.
    pub(crate) fn renumber(&mut self, number: impl Fn(u32) -> u32) {
        let lines = self.line.iter_mut().chain(self.events.iter_mut().map(|event| &mut event.line));
        lines.chain(std::iter::once(&mut self.lines)).for_each(|line| *line = number(*line));
    }

    /// Bytes that the moves take.
    pub fn bytes(&self) -> usize {
        let each = 4 + 3 * 4 + 3 * 4 + 4 + 2 + 2 + size_of::<Role>() + 2;
        self.len() * each + self.states.len() * size_of::<State>()
    }
}

/// The tip of a position, unknown coordinates `None`, in whole units.
fn units(at: &Position) -> [i32; 3] {
    at.linear.map(|v| v.map_or(UNKNOWN, |mm| (mm * UNITS_PER_MM).round().clamp(-2.1e9, 2.1e9) as i32))
}
