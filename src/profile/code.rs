//! The profile's own start, end and re-homing lines, held against the same table and controller as every file: what cannot be
//! carried out is said when the profile is checked, not when everything has been sliced.

use super::layers::{Origin, ProfileError};
use super::prime::prime;
use super::schema::{Commands, Profile};
use crate::gcode::ParsedLine;
use crate::gcode::meaning::{Correction, Corrections, Effect, Firmware, Hazard, effect};
use crate::geom::Vec3;
use crate::motion::replay::{Controller, Step};
use crate::trace::{self, TraceMove};

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
        for (key, code) in [
            ("transition.before_turn", &self.transition.before_turn),
            ("transition.after_turn", &self.transition.after_turn),
        ] {
            let place = origin.get(key).cloned().unwrap_or_default();
            let wrong = code.lines().map(str::trim).find_map(|line| Some((line.to_owned(), self.beside_a_turn(line)?)));
            wrong.map_or(Ok(()), |(line, why)| Err(ProfileError::Code { place, key: key.to_owned(), line, why }))?;
        }
        for (key, code) in [("dialect.start", &self.dialect.start), ("link.rehome", &self.link.rehome)] {
            let place = origin.get(key).cloned().unwrap_or_default();
            self.lets_go(code).map_err(|(line, why)| ProfileError::Code { place, key: key.to_owned(), line, why })?;
        }
        self.starts_safely().map_err(|(line, why)| {
            let place = origin.get("dialect.start").cloned().unwrap_or_default();
            ProfileError::Code { place, key: "dialect.start".to_owned(), line, why }
        })?;
        let why = if !self.starts_hot() {
            format!(
                "no line waits for the nozzle, so a print would begin below min_extrude_c ({:.0} C); add M109 S{{nozzle_c}}",
                self.limits.min_extrude_c
            )
        } else if let Some(name) = self.registered() {
            format!(
                "it registers {name} as an axis of moves (GCODE_AXIS), and Klipper rejects MANUAL_STEPPER MOVE for it; remove these lines, or \
                 kinematics.tilt.stepper and kinematics.rotation.stepper"
            )
        } else if let Some(letter) = self.unregistered() {
            format!(
                "no line registers axis {letter}, so Klipper would ignore its words and the table would not turn; add MANUAL_STEPPER STEPPER=name \
                 GCODE_AXIS= (frees the axis of an earlier print) and, after G28, MANUAL_STEPPER STEPPER=name GCODE_AXIS={letter}; if a \
                 macro does this, add the comment ; GCODE_AXIS={letter}"
            )
        } else {
            return Ok(());
        };
        let place = origin.get("dialect.start").cloned().unwrap_or_default();
        Err(ProfileError::Code { place, key: "dialect.start".to_owned(), line: String::new(), why })
    }

    /// A motor of the table that commands turn and that the start code makes an axis of moves: Klipper takes no MOVE of such a one.
    fn registered(&self) -> Option<String> {
        let names = self.steppers()?;
        let start = self.dialect.start.to_ascii_uppercase();
        let axis = |line: &str| {
            line.split_ascii_whitespace().any(|word| word.starts_with("GCODE_AXIS=") && word != "GCODE_AXIS=")
        };
        let registers = |name: &String| {
            let word = format!("STEPPER={}", name.to_ascii_uppercase());
            start.lines().any(|line| axis(line) && line.split_ascii_whitespace().any(|other| other == word))
        };
        names.into_iter().find(registers)
    }

    /// Why a line may not stand beside a turn: there the head waits above all that is printed, and everything must be afterwards as it
    /// was before, but for pins and settings.
    fn beside_a_turn(&self, line: &str) -> Option<String> {
        const ALLOWED: &str = "directly before or after a turn, only waits, pins, settings and moves of other \
            steppers are allowed; remove it, or move it to dialect.start";
        let mut parsed = ParsedLine::default();
        if let Err(why) = parsed.read(line.as_bytes()) {
            return Some(why.to_string());
        }
        let name = line.split([' ', '=']).next().unwrap_or_default();
        let does = match effect(self.firmware(), &parsed) {
            Effect::Nothing
            | Effect::Dwell(_)
            | Effect::Drain
            | Effect::Setting
            | Effect::Report
            | Effect::Progress
            | Effect::Hazard(Hazard::Output) => return None,
            Effect::Hazard(Hazard::Stepper) if self.moves_no_axis(line) => return None,
            Effect::Hazard(Hazard::Stepper) => "may move an axis of the table",
            Effect::Hazard(Hazard::Unknown)
                if self.dialect.allow.iter().any(|known| known.eq_ignore_ascii_case(name)) =>
            {
                return None;
            }
            Effect::Hazard(Hazard::Unknown) => {
                return Some(format!(
                    "what {name} does is unknown for this firmware; add it to dialect.allow if it moves no axis"
                ));
            }
            Effect::Hazard(hazard) => hazard.does(),
            Effect::Motion => "moves, or changes how moves are read",
            Effect::Home => "homes",
            _ => "changes heat, fans, flow or filament",
        };
        Some(format!("it {does}; {ALLOWED}"))
    }

    /// Whether a line moves a stepper of Klipper's that turns no axis of the table, and that the start code makes no axis of.
    fn moves_no_axis(&self, line: &str) -> bool {
        let value = |line: &str, key: &str| {
            let mut words = line.split_ascii_whitespace().map(str::to_ascii_uppercase);
            words.find_map(|word| word.strip_prefix(key).filter(|value| !value.is_empty()).map(str::to_owned))
        };
        let Some(stepper) = value(line, "STEPPER=") else { return false };
        let own = self.steppers().is_some_and(|names| names.iter().any(|name| name.eq_ignore_ascii_case(&stepper)));
        let is_axis =
            |start: &str| value(start, "STEPPER=").as_ref() == Some(&stepper) && value(start, "GCODE_AXIS=").is_some();
        !own && value(line, "GCODE_AXIS=").is_none() && !self.dialect.start.lines().any(is_axis)
    }

    /// A rotary axis that Klipper is never told of.
    fn unregistered(&self) -> Option<char> {
        let table = self.kinematics();
        let start = self.dialect.start.to_ascii_uppercase();
        let named = |letter: char| start.split_ascii_whitespace().any(|word| word == format!("GCODE_AXIS={letter}"));
        let letters = [table.tilt.letter, table.rotation.letter].map(char::from);
        let asked = self.firmware() == Firmware::Klipper && self.steppers().is_none();
        letters.into_iter().find(|&letter| asked && !named(letter))
    }

    /// Refuses code behind which the firmware corrects coordinates by itself. Where it follows the tip it would turn the poses, which are
    /// worked out here, a second time, and the head would go through the part; Marlin's fork with `PENTA_AXIS_TRT` may do so from power-on.
    /// A bed mesh is of the level table.
    fn lets_go(&self, code: &str) -> Result<(), (String, String)> {
        let firmware = self.firmware();
        let follows = Correction::TipFollowing;
        let wanted = self.dialect.rtcp;
        let mut unsure = !wanted && self.link.identity.contains("PENTA_AXIS") && !code.trim().is_empty();
        let from_the_start = |remedy: &str| {
            format!(
                "firmware with PENTA_AXIS may follow the tip from power-on, which would apply the tilt a second time; {remedy} {}",
                follows.off(firmware)
            )
        };
        let mut corrections = Corrections::none(firmware, wanted);
        let letters = [self.kinematics.tilt.letter, self.kinematics.rotation.letter].map(|letter| letter as u8);
        let mut parsed = ParsedLine::default();
        for line in filled(code).lines().map(str::trim) {
            if parsed.read(line.as_bytes()).is_err() {
                continue;
            }
            if corrections.note(&parsed, &line.to_owned()).is_some_and(|(what, _)| what == follows) {
                unsure = false;
            }
            let moves = parsed.commands.iter().any(|c| c.letter == b'G' && matches!(c.number, 0..=3 | 28));
            if unsure && moves {
                return Err((line.to_owned(), from_the_start("before this line, put")));
            }
            if moves && corrections.must_follow() && letters.iter().any(|&letter| parsed.value(letter).is_some()) {
                return Err((
                    line.to_owned(),
                    "the head turns while the firmware does not yet follow the tip; put G43.4 before this line"
                        .to_owned(),
                ));
            }
        }
        if corrections.must_follow() && !code.trim().is_empty() {
            let why = "dialect.rtcp is true, but no line makes the firmware follow the tip; add G43.4 behind G28, or set dialect.rtcp = false";
            return Err((String::new(), why.to_owned()));
        }
        match corrections.first() {
            Some((what, line)) => {
                let (harm, off) = (what.harm(), what.off(firmware));
                Err((line.clone(), format!("this line {harm}; remove the line, or put {off} after it")))
            }
            None if unsure => Err((String::new(), from_the_start("begin with"))),
            None => Ok(()),
        }
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

    /// The first move of the start code that `verify` would refuse in every file, and why: a turn below what the table may sweep, a
    /// prime line that may not be laid.
    fn starts_safely(&self) -> Result<(), (String, String)> {
        let code = filled(&self.dialect.start);
        let trace = trace::read(code.as_bytes(), &self.trace_setting());
        let table = self.kinematics();
        let reach = self.table_slab().iter().map(Vec3::norm).fold(0.0, f64::max);
        let top = match &table.head {
            Some(_) => self.head_depth_mm(None),
            None => table.pivot.z + table.offset.norm() + reach,
        };
        let wrong = |m: &TraceMove| {
            let low = m.from[2].is_none_or(|z| z <= top);
            if trace.turns(m) && trace.state_before(m).pose().is_none() && low {
                let at = m.from[2].map_or("an unknown height".to_owned(), |z| format!("Z {z}"));
                return Some(format!(
                    "the table turns from an unknown angle with the tip at {at}, and may sweep up to Z {top:.1}; raise the tip above that first"
                ));
            }
            m.prints().then(|| prime(m, &trace, self).err()).flatten()
        };
        let text = |line: u32| code.lines().nth(line as usize - 1).unwrap_or_default().trim().to_owned();
        let first = trace.moves().find_map(|m| Some((text(m.line), wrong(&m)?)));
        first.map_or(Ok(()), Err)
    }

    /// How much filament must be pulled back behind the start code for the first print to begin as all others do, mm: nothing where it
    /// has laid none.
    pub(crate) fn pulls_after_start_mm(&self) -> f64 {
        let code = filled(&self.dialect.start);
        let trace = trace::read(code.as_bytes(), &self.trace_setting());
        let mut over = None;
        for m in trace.moves() {
            over = if m.prints() { Some(0.0) } else { over.map(|over: f64| over + m.e) };
        }
        over.map_or(0.0, |over| (over + self.transition.retract_mm).max(0.0))
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
            ("G93", "is unknown to this firmware"),
        ] {
            let text = with("start", code);
            assert!(
                text.contains(said) && text.contains("dialect.start") && text.contains("mine.toml"),
                "{code}: {text}"
            );
        }
        assert_eq!(with("start", "G92 A0 C0\nG28 X Y Z\nM109 S{nozzle_c}"), "");
        assert!(with("start", "G92 A0 C5\nG28\nM109 S{nozzle_c}").contains("both axes with their level values"));
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

    /// A start that left the tip followed made the firmware turn every pose again.
    #[test]
    fn no_code_leaves_the_firmware_following_the_tip() {
        let with = |base: &str, table: &str, key: &str, code: &str| {
            checked(&format!("extends = \"{base}\"\n[{table}]\n{key} = \"\"\"\n{code}\"\"\"\n"))
        };
        let start = |base: &str, code: &str| with(base, "dialect", "start", code);
        for (base, code, said) in [
            ("generic-bc", "G43.4\nG28\nM109 S{nozzle_c}", "\"G43.4\": this line makes the firmware"),
            ("generic-bc", "G49\nG43.4\nG28\nM109 S{nozzle_c}", "put G49 after it"),
            ("hendrikjan-5d", "G28\nG49\nM109 S{nozzle_c}", "\"G28\": firmware with PENTA_AXIS may follow"),
            ("penta-trt-bc", "G1 Z-1 F60\nG49\nM109 S{nozzle_c}", "this line, put G49"),
            ("penta-trt-bc", "G90\nM109 S{nozzle_c}", "begin with G49"),
            ("linuxcnc-xyzbc-trt", "G21\nM428", "put M429 after it"),
            ("fractal-5-pro", "G28\nPIVOT_COORD ACTIVATE=1", "put PIVOT_COORD ACTIVATE=0 after it"),
            ("generic-ac", "G28\nG29\nM109 S{nozzle_c}", "\"G29\": this line applies a bed mesh"),
            ("generic-ac", "G28\nM420 S1\nM109 S{nozzle_c}", "put M420 S0 after it"),
            ("trident-5-axis", "G28\nG29 S1\nM109 S{nozzle_c}", "put M561 after it"),
            ("fractal-5-pro", "BED_MESH_PROFILE LOAD=default", "put BED_MESH_CLEAR after it"),
        ] {
            let text = start(base, code);
            assert!(text.contains(said) && text.contains("mine.toml:3: dialect.start"), "{base}, {code}: {text}");
        }
        for (base, code) in [
            ("generic-bc", "G43.4\nG49\nG28\nM109 S{nozzle_c}"),
            ("generic-bc", "G28\nM109 S{nozzle_c}"),
            ("hendrikjan-5d", "G49\nG28\nM109 S{nozzle_c}"),
            ("linuxcnc-xyzac-trt", "G21"),
            ("linuxcnc-xyzac-trt", "M428\nM429"),
            ("generic-ac", "G28\nG29\nM420 S0\nM109 S{nozzle_c}"),
            ("trident-5-axis", "G28\nG29 S2\nM109 S{nozzle_c}"),
        ] {
            assert_eq!(start(base, code), "", "{base}, {code}");
        }
        let home = |code: &str| with("hendrikjan-5d", "link", "rehome", code);
        assert!(
            home("G28 Z\nG28 X Y").contains("link.rehome: \"G28 Z\": firmware with PENTA_AXIS"),
            "{}",
            home("G28 Z")
        );
        assert_eq!(home("G49\nG28 Z\nG28 X Y"), "");
    }
}
