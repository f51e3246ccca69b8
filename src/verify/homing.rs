//! Rule `unknown-position` from switching on: an axis is homed before it is sent anywhere.
//!
//! Machines of RS274/NGC are homed outside the program, and a macro of the start code may home: nobody knows.

use crate::gcode::ParsedLine;
use crate::gcode::meaning::{Effect, Firmware, Hazard};
use crate::trace::TraceMove;

/// Which axes are homed, line after line.
pub(super) struct Homing {
    /// Letters of the table's axes, which a G28 may name without the others.
    table: [u8; 2],
    homed: [bool; 3],
    told: bool,
}

impl Homing {
    pub(super) fn of(firmware: Firmware, table: [u8; 2]) -> Self {
        Self { table, homed: [!firmware.is_printer(); 3], told: false }
    }

    pub(super) fn note(&mut self, effect: Effect, line: &ParsedLine) {
        match effect {
            Effect::Home => self.home(line),
            Effect::Hazard(Hazard::Unknown | Hazard::Moves) => self.homed = [true; 3],
            Effect::Hazard(Hazard::MotorsOff) => self.homed = [false; 3],
            _ => {}
        }
    }

    /// G28 homes the axes that it names, and all where it names none; its other words are options.
    fn home(&mut self, line: &ParsedLine) {
        let table = self.table.iter().any(|letter| line.has(*letter));
        let all = !table && !b"XYZ".iter().any(|letter| line.has(*letter));
        let named = [b'X', b'Y', b'Z'].map(|letter| all || line.has(letter));
        self.homed.iter_mut().zip(named).for_each(|(homed, named)| *homed |= named);
    }

    /// The axis that a move sends somewhere before it was homed; once.
    pub(super) fn unhomed(&mut self, m: &TraceMove) -> Option<char> {
        let axis = (0..3).find(|&i| m.wrote(i) && m.to[i].is_some() && !self.homed[i])?;
        (!std::mem::replace(&mut self.told, true)).then_some(['X', 'Y', 'Z'][axis])
    }
}
