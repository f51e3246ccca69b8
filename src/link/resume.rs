//! The state of a program at a block, leaving the part and coming back to it, and re-entry after a reset.
//!
//! The tool's axis is machine +Z at any tilt, because it is the table that turns; so leaving is a lift in Z, and the table's
//! axes turn only at the height where they cannot touch anything.
//!
//! Units: mm, degrees in the written words, mm/min.

use std::ops::Range;

use super::program::{MarkKind, Program};
use super::sender::Settings;
use super::wire::Protocol;
use crate::gcode::meaning::{Effect, Firmware, Hazard, Heater, effect, index_letter};
use crate::gcode::{ParsedLine, push_fixed};
use crate::geom::Angle;
use crate::motion::AxisRange;
use crate::motion::replay::{Position, ReplayError};
use crate::trace::Action;

/// What the machine is told before a block.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// Tip and table.
    pub at: Position,
    /// G90.
    pub absolute: bool,
    /// M82.
    pub extruder_absolute: bool,
    /// What the extruder counts.
    pub extruder_count: f64,
    /// The last F.
    pub feed: Option<f64>,
    /// G93.
    pub inverse_time: bool,
    /// Nozzle, degrees Celsius.
    pub nozzle_c: f64,
    /// Bed, degrees Celsius.
    pub bed_c: f64,
    /// The last line of each setting that stays, and earlier ones of which it says only a part: fans, accelerations, flow, tool.
    pub kept: Vec<String>,
    /// Whether anything was extruded before.
    pub printed: bool,
}

/// Whether what `old` sets is set again by `new`, a later line: the same fan, pin or extruder, and every word of `old`.
fn replaces(new: &ParsedLine, old: &ParsedLine, firmware: Firmware) -> bool {
    let (Some(n), Some(o)) = (new.commands.first(), old.commands.first()) else {
        // By name: the same first word.
        let name = |line: &ParsedLine| line.text.split(|b| *b == b' ').next().map(<[u8]>::to_ascii_uppercase);
        return new.kind == old.kind && name(new) == name(old);
    };
    let fan = |line: &ParsedLine| match effect(firmware, line) {
        Effect::Fan { index, .. } => Some(index),
        _ => None,
    };
    if let (Some(new), Some(old)) = (fan(new), fan(old)) {
        return new == old;
    }
    let index = |line: &ParsedLine| index_letter(*n).and_then(|letter| line.value(letter)).unwrap_or(0.0);
    n == o && index(new) == index(old) && old.words.iter().all(|w| new.has(w.letter))
}

impl State {
    /// The state before block `block`, by replaying everything in front of it.
    ///
    /// # Errors
    ///
    /// [`ReplayError`] where a line has no meaning that is known.
    pub fn before(program: &Program, block: u32) -> Result<Self, ReplayError> {
        let mut replay = program.replay();
        let (mut kept, mut printed) = (Kept { firmware: program.firmware(), lines: Vec::new() }, false);
        while replay.at() < block
            && let Some((index, line, action)) = replay.step()
        {
            match action? {
                Action::Move(timed) => printed |= timed.made.e > 0.0 && timed.made.written != 0,
                Action::Effect(effect) => kept.take(effect, line, program.block(index)),
                Action::Nothing => {}
            }
        }
        let (controller, targets) = (replay.machine().controller(), replay.machine().targets());
        Ok(Self {
            at: controller.at,
            absolute: controller.is_absolute(),
            extruder_absolute: controller.extruder_is_absolute(),
            extruder_count: controller.extruder_count(),
            feed: controller.feed(),
            inverse_time: controller.is_inverse_time(),
            nozzle_c: targets.nozzle_c,
            bed_c: targets.bed_c,
            kept: kept.lines,
            printed,
        })
    }
}

/// The lines of settings that stay, as a later line replaces an earlier one.
struct Kept {
    firmware: Firmware,
    lines: Vec<String>,
}

impl Kept {
    fn take(&mut self, effect: Effect, line: &ParsedLine, bytes: &[u8]) {
        match effect {
            Effect::Heat { heater: Heater::Nozzle | Heater::Bed, .. } => {}
            Effect::Hazard(Hazard::Tool) => {
                self.lines.retain(|text| !matches!(text.as_bytes().first(), Some(b'T')));
                self.lines.insert(0, String::from_utf8_lossy(bytes).into_owned());
            }
            Effect::Heat { .. }
            | Effect::Fan { .. }
            | Effect::Setting
            | Effect::Factor { .. }
            | Effect::Hazard(Hazard::Output) => {
                let mut old = ParsedLine::default();
                self.lines.retain(|text| old.read(text.as_bytes()).is_err() || !replaces(line, &old, self.firmware));
                self.lines.push(String::from_utf8_lossy(bytes).into_owned());
            }
            _ => {}
        }
    }
}

/// What becomes of the heaters when a print is stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Heaters {
    /// Both off.
    Off,
    /// The nozzle off, the bed kept so that the part stays on it.
    KeepBed,
    /// As they are.
    Keep,
}

/// How the head leaves and comes back, from the profile.
#[derive(Clone, Debug, PartialEq)]
pub struct Retreat {
    /// The table's axes: tilt, rotation.
    pub axes: [AxisRange; 2],
    /// The highest Z.
    pub z_max_mm: f64,
    /// How far up.
    pub lift_mm: f64,
    /// Filament pulled.
    pub retract_mm: f64,
    /// Speed of the pull, mm/min.
    pub retract_feed: f64,
    /// In X and Y, mm/min.
    pub travel_feed: f64,
    /// In Z, mm/min.
    pub z_feed: f64,
    /// The extruder's letter.
    pub extruder: u8,
    /// After a fault or a cancel.
    pub heaters: Heaters,
    /// Lines that home the machine without touching a part on its table; empty where there is no such way.
    pub home: Vec<String>,
}

impl Retreat {
    /// The line that waits until the last move has ended.
    pub fn drain(&self, protocol: Protocol) -> &'static str {
        if protocol == Protocol::Grbl { "G4P0.01" } else { "M400" }
    }

    /// Heater lines after a fault.
    pub fn heaters_on_stop(&self) -> &'static [&'static str] {
        match self.heaters {
            Heaters::Off => &["M104S0", "M140S0"],
            Heaters::KeepBed => &["M104S0"],
            Heaters::Keep => &[],
        }
    }

    /// Heater lines after a cancel.
    pub fn heaters_on_cancel(&self, protocol: Protocol) -> Vec<String> {
        if protocol == Protocol::Grbl {
            return Vec::new();
        }
        self.heaters_on_stop().iter().chain(&["M107"]).map(|l| (*l).to_owned()).collect()
    }

    fn pull(&self, sign: &str, protocol: Protocol) -> Vec<String> {
        if protocol == Protocol::Grbl && self.extruder == b'E' {
            return Vec::new();
        }
        let (letter, feed) = (char::from(self.extruder), number(self.retract_feed));
        vec!["G91".to_owned(), format!("G1{letter}{sign}{}F{feed}", number(self.retract_mm)), "G90".to_owned()]
    }

    /// The words of all axes that are known at `state`, as M114 has them.
    pub fn words(&self, state: &State) -> Vec<(u8, f64)> {
        let linear = [b'X', b'Y', b'Z'].into_iter().zip(state.at.linear);
        let angles = self.axes.iter().zip([state.at.tilt, state.at.rotation]);
        let angles = angles.map(|(axis, angle)| (axis.letter, angle.map(|a| axis.word_of(a).deg())));
        linear.chain(angles).filter_map(|(letter, value)| Some((letter, value?))).collect()
    }

    /// From `state` up along the tool's axis; the table stays.
    pub fn leave(&self, state: &State, protocol: Protocol) -> Vec<String> {
        let mut lines = vec![self.drain(protocol).to_owned()];
        if protocol != Protocol::Grbl {
            lines.push("M114".to_owned());
        }
        let Some(z) = state.at.linear[2] else { return lines };
        lines.push("G94".to_owned());
        if !state.inverse_time {
            lines.pop();
        }
        if state.printed {
            if protocol != Protocol::Grbl {
                lines.push("M83".to_owned());
            }
            lines.extend(self.pull("-", protocol));
        }
        if lines.last().is_none_or(|l| l != "G90") {
            lines.push("G90".to_owned());
        }
        let up = (z + self.lift_mm).min(self.z_max_mm.max(z));
        lines.push(format!("G1Z{}F{}", number(up), number(self.z_feed)));
        lines.push(self.drain(protocol).to_owned());
        lines
    }

    /// From above back to `state`: heat, the table's axes each alone, X and Y, down, filament, modes.
    pub fn come_back(&self, state: &State, protocol: Protocol) -> Vec<String> {
        let mut lines = Vec::new();
        if protocol != Protocol::Grbl {
            lines.extend((state.bed_c > 0.0).then(|| format!("M190S{}", number(state.bed_c))));
            lines.extend((state.nozzle_c > 0.0).then(|| format!("M109S{}", number(state.nozzle_c))));
        }
        lines.push("G90".to_owned());
        lines.extend(self.turn(state));
        if let [Some(x), Some(y), Some(z)] = state.at.linear {
            lines.push(format!("G1X{}Y{}F{}", number(x), number(y), number(self.travel_feed)));
            lines.push(format!("G1Z{}F{}", number(z), number(self.z_feed)));
        }
        if state.printed {
            if protocol != Protocol::Grbl {
                lines.push("M83".to_owned());
            }
            lines.extend(self.pull("", protocol));
        }
        lines.extend(self.modes(state, protocol));
        lines
    }

    /// The rotation first, then the tilt, as the file itself turns: so the way there is the one that was planned.
    fn turn(&self, state: &State) -> Vec<String> {
        let angles = [state.at.rotation, state.at.tilt];
        let word = |(axis, angle): (&AxisRange, Option<Angle>)| {
            let rate = axis.max_rate.to_degrees() * 60.0;
            Some(format!(
                "G1{}{}F{}",
                char::from(axis.letter),
                number(axis.word_of(angle?).deg()),
                number(rate.floor())
            ))
        };
        self.axes.iter().rev().zip(angles).filter_map(word).collect()
    }

    fn modes(&self, state: &State, protocol: Protocol) -> Vec<String> {
        let mut lines = Vec::new();
        if !state.absolute {
            lines.push("G91".to_owned());
        }
        if protocol != Protocol::Grbl {
            lines.push(if state.extruder_absolute { "M82" } else { "M83" }.to_owned());
            lines.push(format!("G92E{}", number(state.extruder_count)));
        }
        if state.inverse_time {
            lines.push("G93".to_owned());
        } else if let Some(feed) = state.feed {
            lines.push(format!("G1F{}", number(feed)));
        }
        lines
    }
}

fn number(value: f64) -> String {
    let mut out = Vec::new();
    push_fixed(&mut out, value.clamp(-1e9, 1e9), 5);
    String::from_utf8(out).unwrap_or_default()
}

/// Motion that a printer other than Marlin may hold and has answered already, seconds: Klipper buffers about 2.
const BUFFERED_S: f64 = 3.0;

/// How a print is taken up again after the printer has forgotten where it is.
#[derive(Clone, Debug, PartialEq)]
pub struct Reentry {
    /// The block with which it goes on.
    pub block: u32,
    /// Its line of the file.
    pub file_line: u32,
    /// The last block that is known to be executed.
    pub executed: u32,
    /// Our own lines before it.
    pub lines: Vec<String>,
    /// Which of them home, as the profile says.
    pub home: Range<usize>,
    /// What will happen, a sentence each.
    pub words: Vec<String>,
    /// The state there.
    pub state: State,
}

/// Why a print cannot be taken up again.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ReentryError {
    /// Homing could hit the part.
    #[error(
        "the profile gives no way to home with a part on the table ([link] rehome): homing as usual could drive the nozzle \
         into the print"
    )]
    NoHoming,
    /// Nothing to begin at.
    #[error(
        "no layer or slot of the file lies before line {line}, the last that is known to be executed; print it anew"
    )]
    NoBoundary {
        /// Of the file.
        line: u32,
    },
    /// The replay cannot follow.
    #[error("the file cannot be followed up to line {line}: {why}")]
    Unknown {
        /// Of the file.
        line: u32,
        /// What the replay says.
        why: String,
    },
}

impl Reentry {
    /// The re-entry for a print of which blocks before `answered` were answered.
    ///
    /// An answered block may still have been in the printer's planner, or (not on Marlin) in a buffer that holds motion by its
    /// time, so that the last [`Settings::planner_blocks`] of them, and three seconds before those, do not count as executed. The
    /// print goes on at the last slot, print or layer that began before that.
    ///
    /// # Errors
    ///
    /// [`ReentryError`] where that is not safe.
    pub fn find(program: &Program, settings: &Settings, answered: u32) -> Result<Self, ReentryError> {
        let Settings { protocol, retreat, planner_blocks, .. } = settings;
        let mut executed = answered.saturating_sub(*planner_blocks);
        // Marlin answers what its planner has room for, however long that takes.
        let mut left = if *protocol == Protocol::Marlin { 0.0 } else { BUFFERED_S };
        while left > 0.0 && executed > 0 {
            executed -= 1;
            left -= program.seconds(executed);
        }
        let line = program.file_line(executed);
        if retreat.home.is_empty() {
            return Err(ReentryError::NoHoming);
        }
        let unknown = |why: ReplayError| ReentryError::Unknown { line, why: why.to_string() };
        let known = |s: &State| s.at.tip().is_some() && s.at.pose().is_some();
        for mark in program.marks.iter().rev().filter(|m| m.block <= executed) {
            let state = State::before(program, mark.block).map_err(unknown)?;
            if known(&state) {
                return Ok(Self::at(program, retreat, mark.kind, mark.block, executed, state));
            }
        }
        Err(ReentryError::NoBoundary { line })
    }

    fn at(program: &Program, retreat: &Retreat, kind: MarkKind, block: u32, executed: u32, state: State) -> Self {
        let top = number(retreat.z_max_mm);
        let mut lines = Vec::new();
        let protocol = Protocol::Marlin;
        lines.extend((state.bed_c > 0.0).then(|| format!("M140S{}", number(state.bed_c))));
        // The printer may not have been reset since an earlier way back ended in the file's modes.
        lines.extend(state.inverse_time.then(|| "G94".to_owned()));
        lines.push("G90".to_owned());
        let home = lines.len()..lines.len() + retreat.home.len();
        lines.extend(retreat.home.iter().cloned());
        lines.push("G90".to_owned());
        lines.push(format!("G1Z{top}F{}", number(retreat.z_feed)));
        lines.extend(state.kept.iter().cloned());
        lines.extend(retreat.come_back(&state, protocol));
        let [x, y, z] = state.at.linear.map(|v| number(v.unwrap_or(0.0)));
        let file_line = program.file_line(block);
        let what = match kind {
            MarkKind::Slot(n) => format!("slot {n}"),
            MarkKind::Print(n) => format!("print {n}"),
            MarkKind::Layer => "its layer".to_owned(),
        };
        let turns = retreat.turn(&state).join(", ");
        let words = vec![
            format!("lines up to {} of the file are known to be executed", program.file_line(executed)),
            format!("heat the bed to {:.0} and home with: {}", state.bed_c, retreat.home.join(", ")),
            format!("up to Z {top}, heat the nozzle to {:.0}, turn the table: {turns}", state.nozzle_c),
            format!("across to X {x} Y {y}, straight down to Z {z}, prime {} mm", number(retreat.retract_mm)),
            format!(
                "go on with {what}, line {file_line}; {} lines are printed again",
                program.file_line(executed).saturating_sub(file_line)
            ),
        ];
        Self { block, file_line, executed, lines, home, words, state }
    }
}
