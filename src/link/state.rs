//! The state of the machine before a block of a program: place, modes, heat, and the settings that stay.
//!
//! Everything in front of the block is replayed by the interpreter that verification reads files with.

use super::program::Program;
use crate::gcode::ParsedLine;
use crate::gcode::meaning::{Effect, Firmware, Hazard, Heater, effect, index_letter};
use crate::motion::replay::{Position, ReplayError};
use crate::trace::Action;

/// What the machine is told before a block.
#[derive(Clone, Debug, PartialEq)]
pub struct MachineState {
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

impl MachineState {
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
