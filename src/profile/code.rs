//! The profile's own start, end and re-homing lines, held against the same table and controller as every file: what cannot be
//! carried out is said when the profile is checked, not when everything has been sliced.

use super::layers::{Origin, ProfileError};
use super::schema::{Commands, Profile};
use crate::gcode::ParsedLine;
use crate::gcode::meaning::{Effect, Firmware, Hazard};
use crate::motion::replay::{Controller, Step};
use crate::trace;

/// Temperatures that stand for the placeholders.
const NOZZLE_C: f64 = 210.0;
const BED_C: f64 = 60.0;

impl Profile {
    /// The first line of the profile's own code that has no safe meaning on its firmware.
    pub(super) fn check_code(&self, origin: &Origin) -> Result<(), ProfileError> {
        for (key, code) in [
            ("dialect.start", &self.dialect.start),
            ("dialect.end", &self.dialect.end),
            ("link.rehome", &self.link.rehome),
        ] {
            let place = origin.get(key).cloned().unwrap_or_default();
            self.check_lines(code).map_err(|(line, why)| ProfileError::Code {
                place,
                key: key.to_owned(),
                line,
                why,
            })?;
        }
        let why = if !self.starts_hot() {
            format!(
                "no line of it waits for the nozzle, so that a print would begin below min_extrude_c ({:.0} C); add M109 S{{nozzle_c}}",
                self.limits.min_extrude_c
            )
        } else if let Some(letter) = self.unregistered() {
            format!(
                "no line of it registers axis {letter}, and Klipper drops the words of an axis that it does not know without a word of its own: \
                 the table would stand still; add MANUAL_STEPPER STEPPER=name GCODE_AXIS= (so that a second print can begin) and, \
                 behind G28, MANUAL_STEPPER STEPPER=name GCODE_AXIS={letter}; where a macro does, say so: ; GCODE_AXIS={letter}"
            )
        } else {
            return Ok(());
        };
        let place = origin.get("dialect.start").cloned().unwrap_or_default();
        Err(ProfileError::Code { place, key: "dialect.start".to_owned(), line: String::new(), why })
    }

    /// A rotary axis that Klipper is never told of.
    fn unregistered(&self) -> Option<char> {
        let table = self.kinematics();
        let start = self.dialect.start.to_ascii_uppercase();
        let named = |letter: char| start.split_ascii_whitespace().any(|word| word == format!("GCODE_AXIS={letter}"));
        let letters = [table.tilt.letter, table.rotation.letter].map(char::from);
        letters.into_iter().find(|&letter| self.firmware() == Firmware::Klipper && !named(letter))
    }

    fn check_lines(&self, code: &str) -> Result<(), (String, String)> {
        let mut controller = Controller::new(self.reading());
        let mut parsed = ParsedLine::default();
        for line in filled(code).lines().map(str::trim) {
            let wrong = |why: String| (line.to_owned(), why);
            parsed.read(line.as_bytes()).map_err(|e| wrong(e.to_string()))?;
            if let Step::Effect(Effect::Hazard(hazard)) = controller.step(&parsed).map_err(|e| wrong(e.to_string()))?
                && matches!(hazard, Hazard::Stop | Hazard::Counter | Hazard::OutOfBand | Hazard::File)
            {
                return Err(wrong(format!("it {}", hazard.does())));
            }
        }
        Ok(())
    }

    /// Whether filament may be pushed after the start code.
    fn starts_hot(&self) -> bool {
        if self.dialect.commands == Commands::Rs274
            || !self.firmware().is_printer()
            || self.dialect.start.trim().is_empty()
        {
            return true;
        }
        let probe = filled(&self.dialect.start) + &format!("\nG1 {}1 F60\n", self.dialect.extruder);
        let trace = trace::read(probe.as_bytes(), &self.trace_setting());
        let Some(last) = trace.moves().last() else { return true };
        // A macro may heat; nobody knows.
        let macros =
            trace.events.iter().any(|e| matches!(e.what, trace::What::Effect(Effect::Hazard(Hazard::Unknown), _)));
        macros || f64::from(trace.state(&last).nozzle_c) >= self.limits.min_extrude_c
    }
}

fn filled(code: &str) -> String {
    code.replace("{nozzle_c}", &NOZZLE_C.to_string()).replace("{bed_c}", &BED_C.to_string())
}

#[cfg(test)]
mod tests {
    use crate::profile::resolve;

    fn checked(text: &str) -> String {
        resolve("mine.toml", text).err().map_or_else(String::new, |e| e.to_string())
    }

    #[test]
    fn the_machines_own_code_is_carried_out_once_before_anything_is_sliced() {
        let with = |key: &str, code: &str| checked(&format!("[dialect]\n{key} = \"\"\"\n{code}\"\"\"\n"));
        assert_eq!(with("start", "G28\nM206 Z5\nM109 S{nozzle_c}\nM42 P1 S1\nMY_MACRO\n"), "");
        for (code, said) in [
            ("G20\nM109 S{nozzle_c}", "inches"),
            ("G1 X--5", "unexpected"),
            ("G90 G28", "first"),
            ("G92 X0", "shifts"),
            ("G1 X5 R2", "R word"),
            ("M112", "stops or resets"),
            ("M28 x.g", "another file"),
            ("G28\nM104 S{nozzle_c}", "waits for the nozzle"),
            ("G93", "not known to this firmware"),
        ] {
            let text = with("start", code);
            assert!(
                text.contains(said) && text.contains("dialect.start") && text.contains("mine.toml"),
                "{code}: {text}"
            );
        }
        assert_eq!(with("start", "G92 A0 C0\nG28 X Y Z\nM109 S{nozzle_c}"), "");
        assert!(with("start", "G92 A0 C5\nG28\nM109 S{nozzle_c}").contains("set level with both axes"));
        assert!(with("end", "G91\nG1 Z10 Q3").contains("dialect.end"));
        let klipper = |start: &str| {
            checked(&format!(
                "[dialect]\nfirmware = \"klipper\"\nstart = \"\"\"\nG28\n{start}\nM109 S{{nozzle_c}}\"\"\"\n"
            ))
        };
        assert!(klipper("").contains("registers axis A"), "{}", klipper(""));
        assert!(klipper("MANUAL_STEPPER STEPPER=t GCODE_AXIS=A").contains("registers axis C"));
        let both = "MANUAL_STEPPER STEPPER=t GCODE_AXIS=a\nMANUAL_STEPPER STEPPER=r GCODE_AXIS=C LIMIT_VELOCITY=30";
        assert_eq!((klipper(both), klipper("START_PRINT ; GCODE_AXIS=A GCODE_AXIS=C")), (String::new(), String::new()));
        assert!(checked("[link]\nrehome = \"\"\"G20\"\"\"\n").contains("link.rehome"));
    }
}
