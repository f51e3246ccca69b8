//! G-code lines to moves: the modal state of a controller, and nothing else.
//!
//! One interpreter serves the sliced input (three axes), our own output (five), verification and timing. It carries out
//! moves and modes (G0-G3, G17, G21, G90/G91, G92 E, G93/G94, M82/M83); every other line is handed on as the
//! [`Effect`] that `gcode::meaning` says it has. Inches, other planes, `G92 X..`, words that no move has and several
//! commands on a line where the firmware would take only the first are refused.
//!
//! Units: mm, radians, mm/min as written in the file.

mod plain;

use std::ops::RangeInclusive;

use super::kinematics::{AxisRange, Pose};
use crate::gcode::meaning::{Effect, Firmware, Hazard, ManualStepper, StepperAct, effect};
use crate::gcode::{Command, ParsedLine, round_to};
use crate::geom::{Angle, Vec3};

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
}

impl Reading {
    /// Sliced 3-axis input in Marlin's words, as PrusaSlicer, Slic3r and Cura write it where nothing else is chosen.
    pub fn sliced() -> Self {
        Self::sliced_for(Firmware::Marlin)
    }

    /// Sliced 3-axis input in the words of `firmware`.
    pub fn sliced_for(firmware: Firmware) -> Self {
        let absolute_switches_extruder = firmware.absolute_switches_extruder();
        Self { firmware, extruder: b'E', rotary: None, absolute_switches_extruder, steppers: None }
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

    /// The table's pose, where both angles are known.
    pub fn pose(&self) -> Option<Pose> {
        Some(Pose { tilt: self.tilt?, rotation: self.rotation? })
    }
}

/// An arc in the XY plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arc {
    /// From the start to the centre, mm.
    pub to_centre: [f64; 2],
    /// G2.
    pub clockwise: bool,
    /// Given by radius (`R`) rather than by centre (`I`, `J`).
    pub by_radius: Option<f64>,
    /// Full turns before the end is taken (`P`), at least 1.
    pub turns: u32,
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
    #[error("G{0} takes arcs out of the XY plane; switch arc fitting off in the slicer")]
    Plane(u32),
    /// A rotary word where none belongs.
    #[error(
        "{0} word in sliced input: trunnion writes the rotary axes itself; choose a G-code flavour that extrudes with E"
    )]
    RotaryWord(char),
    /// `G92` on anything but the extruder.
    #[error(
        "G92 on an axis other than the extruder shifts all later coordinates; remove it (a table without end stops is set level with \
         both axes on one line, at their values for the level pose, before either moves)"
    )]
    ShiftedAxes,
    /// A word that no move has: `G1 R2` (from a stored place) and `G1 H2` (motors without limits) on RepRapFirmware, P of an arc on all but
    /// LinuxCNC.
    #[error("{0} word in a move: firmwares differ in what it does; remove it")]
    StrayWord(char),
    /// Several commands on a line.
    #[error("{0} and {1} on one line: this firmware carries out only the first; write each on a line of its own")]
    SeveralCommands(Command, Command),
    /// A mode that this firmware does not have.
    #[error("{0} is not known to this firmware, which would go on in the mode before")]
    UnknownMode(Command),
    /// An arc without a centre.
    #[error("arc without I, J or R")]
    ArcCentre,
    /// A move word without a number.
    #[error("{0} without a number in a move")]
    BareWord(char),
    /// A number no machine can mean.
    #[error("{0}{1} is beyond any machine; the file is damaged")]
    Absurd(char, f64),
    /// An arc that goes round and round, or in parts of turns.
    #[error(
        "an arc of P{0} turns; an arc goes round a whole number of times up to {MOST_TURNS}: write each turn on a line of its own"
    )]
    ArcTurns(f64),
    /// G4 for longer than any print.
    #[error("a wait of {0} s is longer than any print (up to {LONGEST_WAIT_S} s); the file is damaged")]
    Endless(f64),
}

const SANE_MM: RangeInclusive<f64> = -1e6..=1e7;
/// Besides 0, of either sign: beyond these no machine goes, and the times of many moves have no sum.
const SANE_FEED: RangeInclusive<f64> = 1e-3..=1e9;
/// The longest wait: 11 days.
const LONGEST_WAIT_S: f64 = 1e6;
/// Turns of one arc: each is some hundred chords for everybody who follows it.
const MOST_TURNS: u32 = 10;
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
}

impl Controller {
    /// A controller just switched on: absolute axes and extruder, position unknown.
    pub fn new(reading: Reading) -> Self {
        Self {
            reading,
            at: Position::default(),
            absolute: true,
            extruder_absolute: true,
            extruder_count: 0.0,
            feed: None,
            inverse_time: false,
            motion: None,
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
            (Effect::Hazard(Hazard::MotorsOff), _) => self.at = Position::default(),
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

    /// A `MANUAL_STEPPER` line: a turn, where it names a motor of the table. Its place may be set to where it is, or as long as nobody knows where that is; what else
    /// is done to such a motor leaves the angle unknown. Other motors are none of the machine's axes.
    fn stepper(&mut self, line: &ParsedLine) -> Result<Step, ReplayError> {
        let effect = Step::Effect(Effect::Hazard(Hazard::Stepper));
        let (Some(names), Some((tilt, rotation))) = (&self.reading.steppers, &self.reading.rotary) else {
            return Ok(effect);
        };
        let Some(ManualStepper { stepper, act }) = ManualStepper::read(&line.text) else {
            (self.at.tilt, self.at.rotation) = (None, None);
            return Ok(effect);
        };
        let Some(which) = names.iter().position(|name| *name == stepper) else { return Ok(effect) };
        let from = self.at;
        let (axis, slot) = if which == 0 { (tilt, &mut self.at.tilt) } else { (rotation, &mut self.at.rotation) };
        let angle = |word: f64| Ok(Some(axis.angle_of(Angle::from_deg(sane(axis.letter, word)?))));
        match act {
            StepperAct::Other => *slot = None,
            StepperAct::Set(place) => {
                let place = angle(place)?;
                let shifts = slot.zip(place).is_some_and(|(at, place)| (at - place).abs().deg() > 1e-9);
                if shifts {
                    return Err(ReplayError::ShiftedAxes);
                }
                *slot = place;
            }
            StepperAct::Move { to, speed } => {
                *slot = angle(to)?;
                let feed = Some(speed * 60.0).filter(|feed| is_sane_feed(*feed));
                let feed = Some(feed.ok_or(ReplayError::Absurd('F', speed))?);
                let (to, arc) = (self.at, None);
                let (rapid, inverse_time, rotary_written) = (false, false, true);
                return Ok(Step::Move(Move {
                    rapid,
                    from,
                    to,
                    e: 0.0,
                    feed,
                    inverse_time,
                    arc,
                    written: 0,
                    rotary_written,
                }));
            }
        }
        Ok(effect)
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
        let unmoved = self.at.tilt.is_none() && self.at.rotation.is_none();
        if line.words.len() != 2 || !level(tilt) || !level(rotation) || !unmoved {
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
        let (axis, slot) = if letter == tilt.letter {
            (tilt, &mut to.tilt)
        } else if letter == rotation.letter {
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

/// Whether a machine can mean this F.
fn is_sane_feed(feed: f64) -> bool {
    feed == 0.0 || SANE_FEED.contains(&feed.abs())
}

fn arc(clockwise: bool, line: &ParsedLine, firmware: Firmware) -> Result<Arc, ReplayError> {
    let word = |letter| line.value(letter).map(|value| sane(letter, value)).transpose();
    let by_radius = word(b'R')?;
    if by_radius.is_none() && !line.has(b'I') && !line.has(b'J') {
        return Err(ReplayError::ArcCentre);
    }
    let to_centre = [word(b'I')?.unwrap_or(0.0), word(b'J')?.unwrap_or(0.0)];
    // Marlin makes so many circles first, others pass it over.
    if line.has(b'P') && firmware != Firmware::LinuxCnc {
        return Err(ReplayError::StrayWord('P'));
    }
    let turns = line.value(b'P').unwrap_or(1.0);
    if turns.fract() != 0.0 || !(0.0..=f64::from(MOST_TURNS)).contains(&turns) {
        return Err(ReplayError::ArcTurns(turns));
    }
    let turns = (turns as u32).max(1);
    Ok(Arc { to_centre, clockwise, by_radius, turns })
}

/// The polyline of an arc from `from` to `to`, its start left out, its end included.
///
/// Chords deviate from the arc by at most `tolerance` mm. Z goes evenly along the turn. An arc by radius takes the minor
/// arc for R > 0 and the major one for R < 0. Where start and end coincide, an arc by centre is a full turn.
pub fn flatten(from: Vec3, to: Vec3, arc: &Arc, tolerance: f64) -> Vec<Vec3> {
    let (cx, cy) = match arc.by_radius {
        None => (from.x + arc.to_centre[0], from.y + arc.to_centre[1]),
        Some(radius) => centre_of(from, to, radius, arc.clockwise),
    };
    let radius = (from.x - cx).hypot(from.y - cy);
    let start = (from.y - cy).atan2(from.x - cx);
    let mut sweep = (to.y - cy).atan2(to.x - cx) - start;
    let turn = std::f64::consts::TAU;
    if arc.clockwise {
        sweep = -sweep;
    }
    sweep = sweep.rem_euclid(turn);
    let closed = (to.x - from.x).hypot(to.y - from.y) < 1e-9;
    if closed && arc.by_radius.is_none() {
        sweep = turn;
    }
    sweep += turn * f64::from(arc.turns - 1);
    let step = 2.0 * (1.0 - (tolerance / radius.max(tolerance)).min(1.0)).acos();
    let count = (sweep / step.max(1e-3)).ceil().max(1.0) as usize;
    let sense = if arc.clockwise { -1.0 } else { 1.0 };
    let mut points: Vec<Vec3> = (1..count)
        .map(|i| {
            let part = i as f64 / count as f64;
            let angle = start + sense * sweep * part;
            Vec3::new(cx + radius * angle.cos(), cy + radius * angle.sin(), from.z + (to.z - from.z) * part)
        })
        .collect();
    points.push(to);
    points
}

fn centre_of(from: Vec3, to: Vec3, radius: f64, clockwise: bool) -> (f64, f64) {
    let (dx, dy) = (to.x - from.x, to.y - from.y);
    let chord = dx.hypot(dy);
    let height = (radius * radius - chord * chord / 4.0).max(0.0).sqrt();
    // Left of the chord for a minor counter-clockwise arc, right for a clockwise one.
    let side = if clockwise == (radius > 0.0) { -1.0 } else { 1.0 };
    let (mx, my) = (from.x + dx / 2.0, from.y + dy / 2.0);
    if chord == 0.0 {
        return (mx, my);
    }
    (mx - side * dy / chord * height, my + side * dx / chord * height)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(text: &str) -> (Controller, Vec<Step>) {
        let mut controller = Controller::new(Reading::sliced());
        let mut line = ParsedLine::default();
        let steps = text
            .lines()
            .map(|l| {
                line.read(l.as_bytes()).unwrap();
                controller.step(&line).unwrap()
            })
            .collect();
        (controller, steps)
    }

    fn moves(text: &str) -> Vec<Move> {
        run(text).1.into_iter().filter_map(|s| if let Step::Move(m) = s { Some(m) } else { None }).collect()
    }

    /// How often a circle with this word goes round.
    fn turned(firmware: Firmware, word: &str) -> Result<u32, ReplayError> {
        let mut controller = Controller::new(Reading::sliced_for(firmware));
        let mut line = ParsedLine::default();
        line.read(b"G1 X0 Y0").unwrap();
        controller.step(&line)?;
        line.read(format!("G2 X0 Y0 I5 {word}").as_bytes()).unwrap();
        match controller.step(&line)? {
            Step::Move(Move { arc: Some(arc), .. }) => Ok(arc.turns),
            other => panic!("{other:?}"),
        }
    }

    fn refused(text: &str) -> ReplayError {
        let mut controller = Controller::new(Reading::sliced());
        let mut line = ParsedLine::default();
        line.read(text.as_bytes()).unwrap();
        controller.step(&line).unwrap_err()
    }

    #[test]
    fn a_single_word_keeps_the_other_axes() {
        let got = moves("G1 X10 Y20 Z0.2 F600\nX12\nG0 Y3");
        assert_eq!(got[1].to.tip().unwrap(), Vec3::new(12.0, 20.0, 0.2));
        assert_eq!(got[2].to.tip().unwrap(), Vec3::new(12.0, 3.0, 0.2));
        assert_eq!((got[2].feed, got[2].rapid, got[2].written), (Some(600.0), true, 0b010));
    }

    #[test]
    fn the_extruder_counts_absolute_relative_and_from_a_new_zero() {
        let got = moves("M82\nG92 E0\nG1 X1 E2\nG1 X2 E5\nM83\nG1 X3 E1.5\nM82\nG92 E10\nG1 E11\nG91\nG1 E-1");
        let e: Vec<f64> = got.iter().map(|m| m.e).collect();
        assert_eq!(e, vec![2.0, 3.0, 1.5, 1.0, -1.0]);
    }

    /// Whoever follows a program sums its times and places: none of them may be a number that is none.
    #[test]
    fn numbers_of_no_machine_are_refused() {
        let far = "9".repeat(45);
        for line in ["G1 X1 F", "G0 F", "G92 E", "G1 E", "G1 X", "G2 X1 Y1 I", "G2 X1 Y1 I1 J-", "G3 X1 Y1 R"] {
            assert!(matches!(refused(&format!("{line}{far}")), ReplayError::Absurd(..)), "{line}");
        }
        assert_eq!(refused("G1 X1 F.0000001"), ReplayError::Absurd('F', 1e-7));
        assert_eq!(refused("G4 S1000001"), ReplayError::Endless(1_000_001.0));
        for fine in ["G1 X1 F0", "G1 X1 F.001", "G4 P0", "G1 X1 F-600", "G1 X1 F400000", "G4 S1000000", "G92 E-99999"] {
            run(fine);
        }
    }

    /// Each turn is followed chord by chord: one line must not become millions of them.
    #[test]
    fn an_arc_goes_round_a_few_times() {
        for (word, turns) in [("P11", 11.0), ("P4294967295", 4_294_967_295.0), ("P-1", -1.0), ("P1.5", 1.5)] {
            assert_eq!(turned(Firmware::LinuxCnc, word), Err(ReplayError::ArcTurns(turns)));
        }
        assert_eq!(["P10", "P0", ""].map(|word| turned(Firmware::LinuxCnc, word)), [Ok(10), Ok(1), Ok(1)]);
        for (_, firmware) in Firmware::NAMES.into_iter().filter(|(_, firmware)| *firmware != Firmware::LinuxCnc) {
            assert_eq!(turned(firmware, "P2"), Err(ReplayError::StrayWord('P')));
            assert_eq!(turned(firmware, ""), Ok(1));
        }
    }

    #[test]
    fn relative_moves_from_an_unknown_place_stay_unknown() {
        let (controller, _) = run("G28\nG91\nG1 Z5\nG90\nG1 X1 Y1");
        assert_eq!(controller.at.linear, [Some(1.0), Some(1.0), None]);
    }

    #[test]
    fn refuses_what_moves_the_part_unseen() {
        assert_eq!(refused("G20"), ReplayError::Inches);
        assert_eq!(refused("G18"), ReplayError::Plane(18));
        assert_eq!(refused("G1 X1 A5"), ReplayError::RotaryWord('A'));
        assert_eq!(refused("G92 X0"), ReplayError::ShiftedAxes);
        assert_eq!(refused("G92"), ReplayError::ShiftedAxes);
        assert_eq!(refused("G1 X1 R2"), ReplayError::StrayWord('R'));
        assert_eq!(refused("G1 H2 Z5"), ReplayError::StrayWord('H'));
        assert_eq!(refused("G90 G1 X5"), ReplayError::SeveralCommands(Command::g(90), Command::g(1)));
        assert_eq!(refused("G93"), ReplayError::UnknownMode(Command::g(93)));
        assert_eq!(refused("G1 X"), ReplayError::BareWord('X'));
    }

    #[test]
    fn a_table_without_end_stops_is_set_level_once_before_it_moves() {
        let axis = |letter, direction, zero| AxisRange {
            letter,
            direction,
            zero: Angle::from_deg(zero),
            range: None,
            max_rate: 1.0,
        };
        let reading = Reading { rotary: Some((axis(b'U', 1.0, 0.0), axis(b'V', -1.0, 30.0))), ..Reading::sliced() };
        let after = |text: &str| {
            let (mut controller, mut line) = (Controller::new(reading.clone()), ParsedLine::default());
            let steps: Result<Vec<Step>, ReplayError> = text
                .lines()
                .map(|l| {
                    line.read(l.as_bytes()).unwrap();
                    controller.step(&line)
                })
                .collect();
            steps.map(|steps| (controller.at, steps))
        };
        let (at, steps) = after("G1 X5 Y6 Z7\nG92 U0 V30").unwrap();
        assert_eq!(at.pose(), Some(Pose::LEVEL));
        assert_eq!(at.linear, [Some(5.0), Some(6.0), Some(7.0)]);
        // Not by the way: only the profile's own code may say so.
        assert_eq!(steps[1], Step::Effect(Effect::Hazard(Hazard::Shift)));
        for text in ["G92 U0 V0", "G92 U0", "G92 V30", "G92 U0 V30 X0", "G1 U5\nG92 U0 V30", "G92 U0 V30\nG92 U0 V30"] {
            assert_eq!(after(text).unwrap_err(), ReplayError::ShiftedAxes, "{text}");
        }
    }

    #[test]
    fn a_named_motor_turns_the_table_and_others_leave_all_as_it_is() {
        let axis = |letter, direction| AxisRange { letter, direction, zero: Angle::ZERO, range: None, max_rate: 1.0 };
        let steppers = Some(["tilt".to_owned(), "rot".to_owned()]);
        let rotary = Some((axis(b'A', 1.0), axis(b'C', -1.0)));
        let reading = Reading { rotary, steppers, ..Reading::sliced_for(Firmware::Klipper) };
        let after = |text: &str| {
            let (mut controller, mut line) = (Controller::new(reading.clone()), ParsedLine::default());
            let mut last = Ok(Step::Nothing);
            for text in text.lines() {
                line.read(text.as_bytes()).unwrap();
                last = controller.step(&line);
            }
            last.map(|step| (controller.at, controller.feed(), step))
        };
        let begin =
            "G1 X1 Y2 Z3 F600\nMANUAL_STEPPER STEPPER=tilt SET_POSITION=0\nMANUAL_STEPPER STEPPER=rot SET_POSITION=0\n";
        let stepper = |words: &str| after(&format!("{begin}MANUAL_STEPPER {words}"));
        let (at, feed, step) = stepper("STEPPER=rot SPEED=20 MOVE=90").unwrap();
        assert_eq!(at.pose(), Some(Pose::from_deg(0.0, -90.0)));
        assert_eq!((at.linear, feed), ([Some(1.0), Some(2.0), Some(3.0)], Some(600.0)));
        let Step::Move(made) = step else { panic!("{step:?}") };
        assert!(made.feed == Some(1200.0) && made.rotary_written && made.e == 0.0 && made.written == 0);
        // G91 is not for it.
        let relative = after(&format!(
            "{begin}G91\nmanual_stepper stepper=tilt move=5 speed=1\nmanual_stepper stepper=tilt move=7 speed=1"
        ));
        assert_eq!(relative.unwrap().0.pose(), Some(Pose::from_deg(7.0, 0.0)));
        for words in ["STEPPER=brake MOVE=5 SPEED=1", "STEPPER=brake ENABLE=0"] {
            assert_eq!(stepper(words).unwrap().0.pose(), Some(Pose::LEVEL), "{words}");
            assert_eq!(stepper(words).unwrap().0.linear, at.linear, "{words}");
        }
        for words in [
            "MOVE=5",
            "MOVE=5 SPEED=0",
            "MOVE=5 SPEED=1 SYNC=0",
            "MOVE=5 SPEED=1 STOP_ON_ENDSTOP=1",
            "ENABLE=0",
            "GCODE_AXIS=A",
        ] {
            let (at, _, _) = stepper(&format!("STEPPER=tilt {words}")).unwrap();
            assert_eq!((at.tilt, at.rotation), (None, Some(Angle::ZERO)), "{words}");
        }
        assert_eq!(stepper("STEPPER=tilt MOVE=x SPEED=1").unwrap().0.pose(), None);
        assert_eq!(stepper("STEPPER=tilt SET_POSITION=5").unwrap_err(), ReplayError::ShiftedAxes);
        assert_eq!(stepper("STEPPER=tilt SPEED=1 MOVE=1e12").unwrap_err(), ReplayError::Absurd('A', 1e12));
    }

    #[test]
    fn what_is_no_move_is_handed_on_and_the_place_is_forgotten_where_it_may_move() {
        let (controller, steps) = run("G1 X1 Y1 Z1\nG10\nM106\nM206 Z5");
        assert_eq!(steps[1], Step::Effect(Effect::Retract(true)));
        assert_eq!(steps[3], Step::Effect(Effect::Hazard(Hazard::Shift)));
        assert_eq!(controller.at.linear, [None; 3]);
        assert_eq!(run("G1 X1 Y1 Z1\nM106\nM204 P5").0.at.linear, [Some(1.0); 3]);
        assert_eq!(run("G5 X1").1, vec![Step::Effect(Effect::Hazard(Hazard::Unknown))]);
    }

    #[test]
    fn arcs_flatten_onto_their_circle() {
        let arc = Arc { to_centre: [0.0, -5.0], clockwise: true, by_radius: None, turns: 1 };
        let points = flatten(Vec3::new(0.0, 5.0, 0.0), Vec3::new(5.0, 0.0, 1.0), &arc, 0.01);
        assert!(points.len() > 3);
        for p in &points {
            assert!((p.x.hypot(p.y) - 5.0).abs() < 1e-9 && p.x >= -1e-9 && p.y >= -1e-9, "{p:?}");
        }
        let full = Arc { to_centre: [0.5, 0.5], clockwise: false, by_radius: None, turns: 1 };
        let start = Vec3::new(1.0, 1.0, 0.0);
        let box_of = crate::geom::Bounds::of(flatten(start, start, &full, 0.001));
        assert!((box_of.max.x - (1.5 + 0.5f64.hypot(0.5))).abs() < 0.01, "{box_of:?}");
    }

    #[test]
    fn an_arc_by_radius_takes_the_minor_side() {
        let arc = Arc { to_centre: [0.0; 2], clockwise: false, by_radius: Some(5.0), turns: 1 };
        let points = flatten(Vec3::new(5.0, 0.0, 0.0), Vec3::new(0.0, 5.0, 0.0), &arc, 0.01);
        for p in &points {
            assert!((p.x.hypot(p.y) - 5.0).abs() < 1e-9, "{p:?}");
        }
    }
}
