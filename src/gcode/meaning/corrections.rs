//! What a firmware does to coordinates once a line has switched it on: it follows the tip, or evens out an uneven bed.
//!
//! Both are a second opinion on poses that are worked out here. Sources: Marlin's G29, M420 and its fork's G43.4 and G49;
//! RepRapFirmware's G29, M375 and M561; Klipper's BED_MESH_* and `[pivot_coord]`; LinuxCNC's M428 and M429.

use super::Firmware;
use crate::gcode::{LineKind, ParsedLine};

/// A correction of coordinates by the firmware.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Correction {
    /// X, Y and Z are moved as the table turns, so that the tip stays where it is on the part.
    TipFollowing,
    /// Z is moved by what was measured of the level bed, by X and Y alone.
    BedMesh,
}

impl Correction {
    /// Why it must be off, as the end of a sentence about a line.
    pub fn harm(self) -> &'static str {
        match self {
            Self::TipFollowing => "makes the firmware follow the tip, which applies the tilt a second time",
            Self::BedMesh => "applies a bed mesh measured on the level table, which is wrong at a tilt",
        }
    }

    /// The line that switches it off; LinuxCNC and Grbl have no mesh.
    pub fn off(self, firmware: Firmware) -> &'static str {
        match (self, firmware) {
            (Self::TipFollowing, Firmware::LinuxCnc) => "M429",
            (Self::TipFollowing, Firmware::Klipper) => "PIVOT_COORD ACTIVATE=0",
            (Self::TipFollowing, _) => "G49",
            (Self::BedMesh, Firmware::Klipper) => "BED_MESH_CLEAR",
            (Self::BedMesh, Firmware::RepRapFirmware) => "M561",
            (Self::BedMesh, _) => "M420 S0",
        }
    }
}

/// Which correction a line switches, and whether on; nothing where it switches none. A line that may switch one on does.
pub fn correction(firmware: Firmware, line: &ParsedLine) -> Option<(Correction, bool)> {
    if line.kind == LineKind::Macro {
        return by_name(firmware, &line.text);
    }
    line.commands.iter().find_map(|command| {
        let on = match (firmware, command.letter, command.number, command.minor) {
            (Firmware::Marlin, b'G', 43, 4) | (Firmware::LinuxCnc, b'M', 428, 0) => {
                return Some((Correction::TipFollowing, true));
            }
            (Firmware::Marlin, b'G', 43 | 49, 0) | (Firmware::LinuxCnc, b'M', 429, 0) => {
                return Some((Correction::TipFollowing, false));
            }
            // S, or a mesh to load that may be applied from then on.
            (Firmware::Marlin, b'M', 420, 0) => switched(line, b'S').or_else(|| line.has(b'L').then_some(true))?,
            // UBL's D is its only way to switch it off, Q only speaks.
            (Firmware::Marlin, b'G', 29, 0) if line.has(b'Q') => return None,
            (Firmware::Marlin, b'G', 29, 0) => !line.has(b'D'),
            // S2 clears, S3 only saves; none and S0 probe, S1 loads.
            (Firmware::RepRapFirmware, b'G', 29, 0) if line.value(b'S') == Some(3.0) => return None,
            (Firmware::RepRapFirmware, b'G', 29, 0) => line.value(b'S') != Some(2.0),
            (Firmware::RepRapFirmware, b'M', 375, 0) => true,
            (Firmware::RepRapFirmware, b'M', 561, 0) => false,
            // As a macro: there is no such command.
            (Firmware::Klipper, b'G', 29, 0) => true,
            _ => return None,
        };
        Some((Correction::BedMesh, on))
    })
}

/// A word that is 0 or 1; one without a number means 1.
fn switched(line: &ParsedLine, letter: u8) -> Option<bool> {
    line.has(letter).then(|| line.value(letter) != Some(0.0))
}

/// Klipper's commands by name.
fn by_name(firmware: Firmware, text: &[u8]) -> Option<(Correction, bool)> {
    if firmware != Firmware::Klipper {
        return None;
    }
    let text = String::from_utf8_lossy(text).to_ascii_uppercase();
    let mut words = text.split_ascii_whitespace();
    let name = words.next()?;
    let mut has = |word: &str| words.any(|other| other == word);
    match name {
        "PIVOT_COORD" => Some((Correction::TipFollowing, !has("ACTIVATE=0"))),
        "BED_MESH_CALIBRATE" => Some((Correction::BedMesh, true)),
        "BED_MESH_CLEAR" => Some((Correction::BedMesh, false)),
        "BED_MESH_PROFILE" => words.any(|word| word.starts_with("LOAD=")).then_some((Correction::BedMesh, true)),
        _ => None,
    }
}

/// Which corrections are on, line after line, each with the line that switched it on.
#[derive(Clone, Debug)]
pub struct Corrections<L> {
    firmware: Firmware,
    /// Whether the firmware is to follow the tip.
    follows: bool,
    on: [Option<L>; 2],
}

impl<L: Clone> Corrections<L> {
    /// With none on; `follows` where the firmware is to follow the tip, because X, Y and Z are the tip's.
    pub fn none(firmware: Firmware, follows: bool) -> Self {
        Self { firmware, follows, on: [None, None] }
    }

    /// Whether the firmware is to follow the tip and does not.
    pub fn must_follow(&self) -> bool {
        self.follows && self.on[Correction::TipFollowing as usize].is_none()
    }

    /// Takes a line that is to be named as `at`; gives back what it switched, and whether on.
    pub fn note(&mut self, line: &ParsedLine, at: &L) -> Option<(Correction, bool)> {
        let (correction, on) = correction(self.firmware, line)?;
        self.on[correction as usize] = on.then(|| at.clone());
        Some((correction, on))
    }

    /// The first that is on and must not be, with its line.
    pub fn first(&self) -> Option<(Correction, &L)> {
        let all = [Correction::TipFollowing, Correction::BedMesh];
        let all = all.into_iter().zip(&self.on).skip(usize::from(self.follows));
        all.into_iter().find_map(|(correction, at)| Some((correction, at.as_ref()?)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A firmware, a line, and what it switches on or off.
    type Row = (Firmware, &'static str, Option<(Correction, bool)>);

    #[test]
    fn lines_switch_corrections_as_their_firmware_reads_them() {
        use Correction::{BedMesh, TipFollowing};
        let of = |firmware: Firmware, text: &str| {
            let mut line = ParsedLine::default();
            line.read(text.as_bytes()).unwrap();
            correction(firmware, &line)
        };
        let rows: &[Row] = &[
            (Firmware::Marlin, "G29", Some((BedMesh, true))),
            (Firmware::Marlin, "G29 A", Some((BedMesh, true))),
            (Firmware::Marlin, "G29 D", Some((BedMesh, false))),
            (Firmware::Marlin, "G29 Q", None),
            (Firmware::Marlin, "M420 S1 Z10", Some((BedMesh, true))),
            (Firmware::Marlin, "M420 S", Some((BedMesh, true))),
            (Firmware::Marlin, "M420 S0", Some((BedMesh, false))),
            (Firmware::Marlin, "M420 L1", Some((BedMesh, true))),
            (Firmware::Marlin, "M420 V", None),
            (Firmware::Marlin, "G28", None),
            (Firmware::Marlin, "G43.4", Some((TipFollowing, true))),
            (Firmware::Marlin, "G43", Some((TipFollowing, false))),
            (Firmware::RepRapFirmware, "G29", Some((BedMesh, true))),
            (Firmware::RepRapFirmware, "G29 S1 P\"a.csv\"", Some((BedMesh, true))),
            (Firmware::RepRapFirmware, "G29 S2", Some((BedMesh, false))),
            (Firmware::RepRapFirmware, "G29 S3", None),
            (Firmware::RepRapFirmware, "M375", Some((BedMesh, true))),
            (Firmware::RepRapFirmware, "M561", Some((BedMesh, false))),
            (Firmware::Klipper, "bed_mesh_profile load=default", Some((BedMesh, true))),
            (Firmware::Klipper, "BED_MESH_PROFILE SAVE=default", None),
            (Firmware::Klipper, "BED_MESH_CALIBRATE ADAPTIVE=1", Some((BedMesh, true))),
            (Firmware::Klipper, "BED_MESH_CLEAR", Some((BedMesh, false))),
            (Firmware::Klipper, "G29", Some((BedMesh, true))),
            (Firmware::Klipper, "PIVOT_COORD ACTIVATE=1", Some((TipFollowing, true))),
            (Firmware::Klipper, "PIVOT_COORD", Some((TipFollowing, true))),
            (Firmware::Klipper, "PIVOT_COORD ACTIVATE=0", Some((TipFollowing, false))),
            (Firmware::LinuxCnc, "M428", Some((TipFollowing, true))),
            (Firmware::LinuxCnc, "M429", Some((TipFollowing, false))),
            (Firmware::Marlin, "BED_MESH_CALIBRATE", None),
            (Firmware::Grbl, "G43.1 Z5", None),
        ];
        for (firmware, text, wanted) in rows {
            assert_eq!(of(*firmware, text), *wanted, "{firmware:?} {text}");
        }
    }

    #[test]
    fn what_is_on_has_the_line_that_switched_it() {
        let mut on = Corrections::none(Firmware::Marlin, false);
        let mut line = ParsedLine::default();
        for (at, text) in ["M420 S1", "G43.4", "G49"].into_iter().enumerate() {
            line.read(text.as_bytes()).unwrap();
            on.note(&line, &at);
        }
        assert_eq!(on.first(), Some((Correction::BedMesh, &0)));
        line.read(b"M420 S0").unwrap();
        on.note(&line, &3);
        assert_eq!(on.first(), None);
    }
}
