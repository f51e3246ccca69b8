//! G-code lines to moves: the modal state of a controller, and nothing else.
//!
//! One interpreter serves the sliced input (three axes), our own output (five), verification and timing. It carries out
//! moves and modes (G0-G3, G17, G21, G90/G91, G92 E, G93/G94, M82/M83); every other line is handed on as the
//! [`Effect`] that `gcode::meaning` says it has. Inches, other planes, `G92 X..`, words that no move has and several
//! commands on a line where the firmware would take only the first are refused.
//!
//! Units: mm, radians, mm/min as written in the file.

mod arcs;
mod plain;
mod stepper;
#[cfg(test)]
mod tests;

use std::ops::RangeInclusive;

use super::kinematics::AxisRange;
use super::pose::Pose;
use crate::gcode::meaning::{Effect, Firmware, Hazard, effect};
use crate::gcode::{Command, ParsedLine, round_to};
use crate::geom::{Angle, Vec3};

pub use arcs::{Arc, CHORD_MM, flatten};
use arcs::{ArcTurn, ChordBudget, MOST_TURNS, arc};
pub use plain::{PlainMoved, PlainStep};

/// What the reader must know of the dialect.
#[derive(Clone, Debug)]
pub struct Reading {
    /// Whose words they are.
    pub firmware: Firmware,
    /// The extruder's letter, `b'E'` for most.
    pub extruder: u8,
    /// The tilt and rotation axes; `None` for sliced input, where a rotary word is refused.
    pub rotary: Option<(AxisRange, AxisRange)>,
    /// Whether G90/G91 switch the extruder too (Marlin: yes; Klipper, RepRapFirmware: no).
    pub absolute_switches_extruder: bool,
    /// Klipper's names of the motors of tilt and rotation where these are turned by commands and not by letters.
    pub steppers: Option<[String; 2]>,
    /// The greatest X and Y of either sign that an arc may come to, mm: beyond it nothing can be meant, and no chord is made.
    pub reach_mm: f64,
}

impl Reading {
    /// Sliced 3-axis input in Marlin's words, as PrusaSlicer, Slic3r and Cura write it where nothing else is chosen.
    pub fn sliced() -> Self {
        Self::sliced_for(Firmware::Marlin)
    }

    /// Sliced 3-axis input in the words of `firmware`.
    pub fn sliced_for(firmware: Firmware) -> Self {
        let absolute_switches_extruder = firmware.absolute_switches_extruder();
        Self {
            firmware,
            extruder: b'E',
            rotary: None,
            absolute_switches_extruder,
            steppers: None,
            reach_mm: LARGEST_BED_MM,
        }
    }
}

impl Reading {
    /// A machine of which nothing is known but what cannot move.
    fn unknown(&self) -> Position {
        let angle = |axis: &AxisRange| axis.absent.then_some(Angle::ZERO);
        let [tilt, rotation] =
            self.rotary.as_ref().map_or([None; 2], |(tilt, rotation)| [angle(tilt), angle(rotation)]);
        Position { tilt, rotation, ..Position::default() }
    }
}

/// Where the tip and the table are; `None` where the file has not said it yet.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Position {
    /// X, Y, Z of the tip, mm.
    pub linear: [Option<f64>; 3],
    /// The table's tilt.
    pub tilt: Option<Angle>,
    /// The table's rotation.
    pub rotation: Option<Angle>,
}

impl Position {
    /// The tip, where all three coordinates are known.
    pub fn tip(&self) -> Option<Vec3> {
        let [x, y, z] = self.linear;
        Some(Vec3::new(x?, y?, z?))
    }

    /// The pose, where both angles are known.
    pub fn pose(&self) -> Option<Pose> {
        Some(Pose { tilt: self.tilt?, rotation: self.rotation? })
    }
}

/// A move of any axis, extrusion included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Move {
    /// G0.
    pub rapid: bool,
    /// Before.
    pub from: Position,
    /// After.
    pub to: Position,
    /// Filament pushed (negative: pulled), mm as the file counts.
    pub e: f64,
    /// F as written: mm/min in G94, 1/min in G93; `None` before the first F.
    pub feed: Option<f64>,
    /// Whether `feed` is the inverse time of G93.
    pub inverse_time: bool,
    /// Set for G2 and G3.
    pub arc: Option<Arc>,
    /// Which of X, Y, Z were written, as bits 0, 1, 2.
    pub written: u8,
    /// Whether a rotary word was written.
    pub rotary_written: bool,
}

/// What a line did.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Step {
    /// Nothing that moves: blank, comment, mode.
    Nothing,
    /// A move.
    Move(Move),
    /// The extruder's count was set (G92 E) to this value.
    ExtruderSet(f64),
    /// Anything else; after homing and after whatever moves unseen the position is unknown.
    Effect(Effect),
}

/// Why a line cannot be interpreted safely.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ReplayError {
    /// G20.
    #[error("G20 switches to inches; slice in millimetres (G21)")]
    Inches,
    /// G18, G19.
    #[error("G{0} draws arcs outside the XY plane; switch off arc fitting in the slicer")]
    Plane(u32),
    /// A rotary word where none belongs.
    #[error(
        "{0} word in sliced input: trunnion writes the rotary axes itself; choose a G-code flavour that extrudes with E"
    )]
    RotaryWord(char),
    /// `G92` on anything but the extruder.
    #[error(
        "G92 on an axis other than the extruder shifts all later coordinates; remove it (to set a table without end stops level, write \
         both axes with their level values on one line, before either moves)"
    )]
    ShiftedAxes,
    /// A word that no move has: `G1 R2` (from a stored place) and `G1 H2` (motors without limits) on RepRapFirmware, P of an arc on all but
    /// LinuxCNC.
    #[error("{0} word in a move: firmwares interpret it differently; remove it")]
    StrayWord(char),
    /// Several commands on a line.
    #[error("{0} and {1} on one line: this firmware executes only the first; write each on its own line")]
    SeveralCommands(Command, Command),
    /// A mode that this firmware does not have.
    #[error("{0} is unknown to this firmware, which would keep the previous mode")]
    UnknownMode(Command),
    /// An arc without a centre.
    #[error("arc without I, J or R")]
    ArcCentre,
    /// A move word without a number.
    #[error("{0} without a number in a move")]
    BareWord(char),
    /// A number no machine can mean.
    #[error("{0}{1} is beyond any machine (allowed: {range}); the file is damaged", range = sane_range(*.0))]
    Absurd(char, f64),
    /// An arc that goes round and round, or in parts of turns.
    #[error(
        "the turns of an arc must be a whole number from 0 to {MOST_TURNS}, got P{0}; write each turn on its own line"
    )]
    ArcTurns(f64),
    /// An arc to where no axis reaches.
    #[error("an arc reaches {farthest:.0} mm; arcs must stay within {reach_mm:.0} mm of zero")]
    ArcBeyond {
        /// The greatest X or Y of either sign on the way, mm.
        farthest: f64,
        /// What it may be, mm.
        reach_mm: f64,
    },
    /// More of arcs than the file's size pays for.
    #[error(
        "with this arc of {0} chords, the file's arcs have more chords than its size allows; write long arcs as straight lines"
    )]
    ManyChords(usize),
    /// G4 for longer than any print.
    #[error("a dwell of {0} s is longer than any print (at most {LONGEST_WAIT_S} s); the file is damaged")]
    Endless(f64),
}

const SANE_MM: RangeInclusive<f64> = -1e6..=1e7;
/// Besides 0, of either sign: beyond these no machine goes, and the times of many moves have no sum.
const SANE_FEED: RangeInclusive<f64> = 1e-3..=1e9;
/// No slicer's bed is larger, nor its origin farther, mm.
const LARGEST_BED_MM: f64 = 1e4;
/// The longest wait: 11 days.
const LONGEST_WAIT_S: f64 = 1e6;
/// Digits that a sum of relative moves keeps, far beyond those of any file.
const SUM_DIGITS: u32 = 9;

/// The modal state of a controller.
#[derive(Clone, Debug)]
pub struct Controller {
    reading: Reading,
    /// Where the machine is.
    pub at: Position,
    absolute: bool,
    extruder_absolute: bool,
    extruder_count: f64,
    feed: Option<f64>,
    inverse_time: bool,
    motion: Option<u32>,
    chords: ChordBudget,
}

impl Controller {
    /// A controller just switched on: absolute axes and extruder, position unknown.
    pub fn new(reading: Reading) -> Self {
        Self {
            at: reading.unknown(),
            reading,
            absolute: true,
            extruder_absolute: true,
            extruder_count: 0.0,
            feed: None,
            inverse_time: false,
            motion: None,
            chords: ChordBudget::default(),
        }
    }

    /// The last F, as written.
    pub fn feed(&self) -> Option<f64> {
        self.feed
    }

    /// Whether axis words are targets (G90).
    pub fn is_absolute(&self) -> bool {
        self.absolute
    }

    /// Whether the extruder's words are targets (M82).
    pub fn extruder_is_absolute(&self) -> bool {
        self.extruder_absolute
    }

    /// What the extruder counts, mm as the file counts.
    pub fn extruder_count(&self) -> f64 {
        self.extruder_count
    }

    /// Whether F is an inverse time (G93).
    pub fn is_inverse_time(&self) -> bool {
        self.inverse_time
    }

    /// Takes one line and says what it did.
    ///
    /// # Errors
    ///
    /// [`ReplayError`] for what has no safe meaning; the state is then unspecified.
    pub fn step(&mut self, line: &ParsedLine) -> Result<Step, ReplayError> {
        if let [first, second, ..] = line.commands[..]
            && matches!(self.reading.firmware, Firmware::Marlin | Firmware::Klipper)
        {
            return Err(ReplayError::SeveralCommands(first, second));
        }
        // Nearly every line is a plain move.
        let plain = matches!(line.commands[..], [Command { letter: b'G', number: 0..=3, minor: 0 }]);
        if !plain {
            match effect(self.reading.firmware, line) {
                Effect::Nothing => return Ok(Step::Nothing),
                Effect::Motion => {}
                other => return self.other(other, line),
            }
        }
        let mut motion = None;
        for &command in &line.commands {
            match (command.letter, command.number, command.minor) {
                (b'G', 0..=3, 0) => motion = Some(command.number),
                (b'G', 92, 0) => return self.set_extruder(line),
                _ => self.mode(command),
            }
        }
        let bare_words = line.commands.is_empty() && line.words.iter().any(|w| self.is_axis(w.letter));
        if motion.is_none() && bare_words {
            motion = self.motion;
        }
        let Some(kind) = motion else {
            self.take_feed(line)?;
            return Ok(Step::Nothing);
        };
        self.motion = Some(kind);
        self.take_feed(line)?;
        self.make_move(kind, line)
    }

    /// A line that is neither a move nor a mode.
    fn other(&mut self, effect: Effect, line: &ParsedLine) -> Result<Step, ReplayError> {
        let command = line.commands.first().filter(|c| c.letter == b'G').map_or((0, 0), |c| (c.number, c.minor));
        if effect == Effect::Hazard(Hazard::Stepper) {
            return self.stepper(line);
        }
        match (effect, command) {
            (Effect::Hazard(_), (20 | 70, 0)) => return Err(ReplayError::Inches),
            (Effect::Hazard(_), (plane @ (18 | 19), 0)) => return Err(ReplayError::Plane(plane)),
            (Effect::Hazard(_), (92, 0)) => return self.set_level(line),
            (Effect::Hazard(Hazard::Unknown), (93, 0)) => return Err(ReplayError::UnknownMode(line.commands[0])),
            // Its sum with others is a time still.
            (Effect::Dwell(seconds), _) if seconds.abs() > LONGEST_WAIT_S => return Err(ReplayError::Endless(seconds)),
            (Effect::Hazard(Hazard::MotorsOff), _) => self.at = self.reading.unknown(),
            (
                Effect::Home
                | Effect::Hazard(Hazard::Shift | Hazard::Steps | Hazard::Units | Hazard::Moves | Hazard::Unknown),
                _,
            ) => {
                self.at.linear = [None; 3];
            }
            _ => {}
        }
        Ok(Step::Effect(effect))
    }

    fn is_axis(&self, letter: u8) -> bool {
        matches!(letter, b'X' | b'Y' | b'Z') || letter == self.reading.extruder
    }

    /// A, B, C anywhere, and whatever letters the machine's own rotary axes have.
    fn is_rotary(&self, letter: u8) -> bool {
        let own = self.reading.rotary.as_ref().is_some_and(|(t, r)| letter == t.letter || letter == r.letter);
        own || matches!(letter, b'A' | b'B' | b'C')
    }

    fn take_feed(&mut self, line: &ParsedLine) -> Result<(), ReplayError> {
        if let Some(feed) = line.value(b'F') {
            if !is_sane_feed(feed) {
                return Err(ReplayError::Absurd('F', feed));
            }
            self.feed = Some(feed);
        }
        Ok(())
    }

    /// A mode; those that change nothing here (G17, G21, ..) are passed over.
    fn mode(&mut self, command: Command) {
        match (command.letter, command.number) {
            (b'M', 82 | 83) => self.extruder_absolute = command.number == 82,
            (b'G', 90 | 91) => self.set_absolute(command.number == 90),
            (b'G', 93 | 94) => self.inverse_time = command.number == 93,
            _ => {}
        }
    }

    fn set_absolute(&mut self, absolute: bool) {
        self.absolute = absolute;
        if self.reading.absolute_switches_extruder {
            self.extruder_absolute = absolute;
        }
    }

    fn set_extruder(&mut self, line: &ParsedLine) -> Result<Step, ReplayError> {
        let only = line.words.iter().all(|w| w.letter == self.reading.extruder || w.letter == b'F');
        match line.value(self.reading.extruder) {
            Some(count) if only => {
                sane(self.reading.extruder, count)?;
                self.extruder_count = count;
                Ok(Step::ExtruderSet(count))
            }
            _ => self.set_level(line),
        }
    }

    /// `G92 A0 C0`: without end stops a person levels the table, and this says so. Both axes, at what the level pose is called, before
    /// either has moved; anything else shifts.
    fn set_level(&mut self, line: &ParsedLine) -> Result<Step, ReplayError> {
        let Some((tilt, rotation)) = &self.reading.rotary else { return Err(ReplayError::ShiftedAxes) };
        let level = |axis: &AxisRange| {
            line.value(axis.letter).is_some_and(|word| (word - axis.word_of(Angle::ZERO).deg()).abs() < 1e-9)
        };
        let axes = [(tilt, self.at.tilt), (rotation, self.at.rotation)];
        let mut own = axes.into_iter().filter(|(axis, _)| !axis.absent);
        let present = own.clone().count();
        if line.words.len() != present || !own.all(|(axis, at)| level(axis) && at.is_none()) {
            return Err(ReplayError::ShiftedAxes);
        }
        (self.at.tilt, self.at.rotation) = (Some(Angle::ZERO), Some(Angle::ZERO));
        Ok(Step::Effect(Effect::Hazard(Hazard::Shift)))
    }

    fn make_move(&mut self, kind: u32, line: &ParsedLine) -> Result<Step, ReplayError> {
        let from = self.at;
        let mut to = from;
        let mut e = 0.0;
        let (mut written, mut rotary_written, mut any) = (0u8, false, false);
        for word in &line.words {
            let axis = match word.letter {
                letter if letter == self.reading.extruder => {
                    e = self.extrude(number(word)?);
                    any = true;
                    continue;
                }
                b'X' => 0,
                b'Y' => 1,
                b'Z' => 2,
                letter if self.is_rotary(letter) => {
                    self.turn(&mut to, word.letter, number(word)?)?;
                    rotary_written = true;
                    any = true;
                    continue;
                }
                b'F' => continue,
                b'I' | b'J' | b'R' | b'P' if kind >= 2 => continue,
                letter => return Err(ReplayError::StrayWord(char::from(letter))),
            };
            to.linear[axis] = self.target(from.linear[axis], number(word)?);
            written |= 1 << axis;
            any = true;
        }
        let arc = if kind >= 2 { Some(arc(kind == 2, line, self.reading.firmware)?) } else { None };
        if !any && arc.is_none() {
            return Ok(Step::Nothing);
        }
        self.at = to;
        if let (Some(arc), Some(from), Some(to)) = (&arc, from.tip(), to.tip()) {
            self.chords.take(&ArcTurn::of(from, to, arc), line.code.len(), self.reading.reach_mm)?;
        }
        Ok(Step::Move(Move {
            rapid: kind == 0,
            from,
            to,
            e,
            feed: self.feed,
            inverse_time: self.inverse_time,
            arc,
            written,
            rotary_written,
        }))
    }

    /// An axis word's target; unknown stays unknown where the word is relative.
    fn target(&self, from: Option<f64>, word: f64) -> Option<f64> {
        // Sums of decimals keep their digits, so that a step there and back ends where it began.
        if self.absolute { Some(word) } else { from.map(|at| round_to(at + word, SUM_DIGITS)) }
    }

    fn extrude(&mut self, word: f64) -> f64 {
        if self.extruder_absolute {
            let pushed = word - self.extruder_count;
            self.extruder_count = word;
            pushed
        } else {
            self.extruder_count += word;
            word
        }
    }

    fn turn(&self, to: &mut Position, letter: u8, degrees: f64) -> Result<(), ReplayError> {
        let refused = Err(ReplayError::RotaryWord(char::from(letter)));
        let Some((tilt, rotation)) = &self.reading.rotary else { return refused };
        let (axis, slot) = if letter == tilt.letter && !tilt.absent {
            (tilt, &mut to.tilt)
        } else if letter == rotation.letter && !rotation.absent {
            (rotation, &mut to.rotation)
        } else {
            return refused;
        };
        let word = Angle::from_deg(degrees);
        if self.absolute {
            *slot = Some(axis.angle_of(word));
        } else {
            *slot = slot.map(|at| axis.angle_of(axis.word_of(at) + word));
        }
        Ok(())
    }
}

fn number(word: &crate::gcode::Word) -> Result<f64, ReplayError> {
    let value = word.value.ok_or(ReplayError::BareWord(char::from(word.letter)))?;
    sane(word.letter, value)
}

fn sane(letter: u8, value: f64) -> Result<f64, ReplayError> {
    if SANE_MM.contains(&value) { Ok(value) } else { Err(ReplayError::Absurd(char::from(letter), value)) }
}

/// What [`sane`] and [`is_sane_feed`] take, in words.
fn sane_range(letter: char) -> &'static str {
    if letter == 'F' { "0, and 0.001 to 1e9" } else { "-1e6 to 1e7" }
}

/// Whether a machine can mean this F: below zero Marlin ignores it, and Klipper stops.
fn is_sane_feed(feed: f64) -> bool {
    feed == 0.0 || SANE_FEED.contains(&feed)
}
