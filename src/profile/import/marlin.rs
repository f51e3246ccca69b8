//! Marlin: Configuration.h and Configuration_adv.h.
//!
//! Sources: the comments of Marlin 2.1's own files, and of DerAndere1's fork for `PENTA_AXIS_TRT`, whose table turns against the right hand
//! (with a B axis only that one does). The preprocessor is followed as far as the files themselves tell; of a line under a condition that they
//! do not tell nothing is known. A hot end may be asked for its MAXTEMP less the overshoot.

mod defines;

use self::defines::{Defined, Defines};
use super::stated::{Fact, File, ImportError, Rotary, Shelf, Stated, StatedAt, feeds, least, scaled, span};
use super::{AxisRoles, Imported, about, by_name, two};
use crate::gcode::meaning::{Correction, Firmware};

/// Marlin's own names of its axes behind X, Y and Z, and the letters that they have where nothing else is said.
const MORE: [(char, char); 6] = [('I', 'A'), ('J', 'B'), ('K', 'C'), ('U', 'U'), ('V', 'V'), ('W', 'W')];
/// Kinematics in which X, Y and Z have no stops of their own.
const ROUND: [&str; 6] = ["DELTA", "MORGAN_SCARA", "MP_SCARA", "AXEL_TPARA", "POLARGRAPH", "POLAR"];
/// Kinematics that turn no table as a profile has it.
const OTHERS: [&str; 2] = ["PENTA_AXIS_HT", "FOAMCUTTER_XYUV"];

/// What makes G28 switch a bed mesh on.
const LEVELS: [&str; 2] = ["ENABLE_LEVELING_AFTER_G28", "RESTORE_LEVELING_AFTER_G28"];

pub(super) fn read(files: &[File], shelf: &dyn Shelf) -> Result<Imported, ImportError> {
    let defines = Defines::read(files, shelf)?;
    Reader { file: files[0].clone(), defines, notes: Vec::new() }.machine()
}

/// What the fork that follows the tip of a tilting table says in M115.
pub(super) const TRT: &str = "KINEMATICS:PENTA_AXIS_TRT";

/// Which axis of that fork does what and which way, of the letters that there are; `place` says that it is that fork.
pub(super) fn tilting_table(letters: &[char], place: &StatedAt, facts: &mut Vec<Fact>) -> AxisRoles {
    let tilt = letters.iter().copied().find(|letter| matches!(letter, 'A' | 'B')).unwrap_or('A');
    let how = "required, because only a firmware with PENTA_AXIS_TRT has G49, which ends tip following";
    facts.push(Fact::new("link.identity", TRT, vec![place.clone()], how));
    let directions = if tilt == 'B' { [-1_i64, 1] } else { [-1, -1] };
    for (key, direction) in ["kinematics.tilt.direction", "kinematics.rotation.direction"].into_iter().zip(directions) {
        facts.push(Fact::new(key, direction, vec![place.clone()], "PENTA_AXIS_TRT counts that way"));
    }
    AxisRoles { tilt, rotation: 'C', about: Some(about(tilt)), how: "by PENTA_AXIS_TRT".to_owned() }
}

struct Reader {
    file: File,
    defines: Defines,
    notes: Vec<String>,
}

impl Reader {
    /// A number; one that stands under a condition is not told, and said.
    fn get(&mut self, name: &str) -> Result<Option<Stated>, ImportError> {
        let Some(defined) = self.told(name) else { return Ok(None) };
        let value = self.defines.number(&defined)?;
        Ok(Some(Stated { value, from: vec![defined.place] }))
    }

    /// A list of numbers, one for each axis and the extruder.
    fn list(&mut self, name: &str, axes: usize) -> Result<Option<Vec<Stated>>, ImportError> {
        let Some(defined) = self.told(name) else { return Ok(None) };
        let values = self.defines.list(&defined)?;
        if values.len() <= axes {
            let why = format!(
                "{name} has {} numbers, but this machine has {axes} axes and an extruder; give one number for each",
                values.len()
            );
            return Err(ImportError::At { place: defined.place, why });
        }
        let of = |value| Stated { value, from: vec![defined.place.clone()] };
        Ok(Some(values.into_iter().map(of).collect()))
    }

    fn told(&mut self, name: &str) -> Option<Defined> {
        let defined = self.defines.get(name)?.clone();
        if !defined.certain {
            let note = format!(
                "{}: {name} is not read, because its #if condition cannot be evaluated from these files",
                defined.place
            );
            if !self.notes.contains(&note) {
                self.notes.push(note);
            }
            return None;
        }
        Some(defined)
    }

    fn enabled(&self, name: &str) -> bool {
        self.defines.get(name).is_some_and(|defined| defined.certain)
    }

    fn machine(mut self) -> Result<Imported, ImportError> {
        for name in OTHERS {
            if let Some(defined) = self.defines.get(name).filter(|defined| defined.certain) {
                let why = format!("{name} is not supported; the machine must have a table that tilts and turns");
                return Err(ImportError::At { place: defined.place.clone(), why });
            }
        }
        let more: Vec<(usize, char, char)> = MORE
            .into_iter()
            .enumerate()
            .filter(|(_, (own, _))| self.enabled(&format!("{own}_DRIVER_TYPE")))
            .map(|(i, (own, letter))| (i + 4, own, letter))
            .collect();
        let axes = 3 + more.len();
        let speeds = self.list("DEFAULT_MAX_FEEDRATE", axes)?;
        let accelerations = self.list("DEFAULT_MAX_ACCELERATION", axes)?;
        let mut rotary = Vec::new();
        for (index, (number, own, usual)) in more.iter().enumerate() {
            if let Some(defined) = self.told(&format!("AXIS{number}_ROTATES")) {
                let name = self.told(&format!("AXIS{number}_NAME"));
                let letter = name.map_or(Ok(*usual), |name| self.defines.letter(&name))?;
                let of = |list: &Option<Vec<Stated>>| list.as_ref().map(|list| list[3 + index].clone());
                rotary.push(Rotary {
                    letter,
                    min: self.get(&format!("{own}_MIN_POS"))?,
                    max: self.get(&format!("{own}_MAX_POS"))?,
                    rate: of(&speeds),
                    acceleration: of(&accelerations),
                    from: defined.place,
                    motor: String::new(),
                });
            }
        }
        let first = more.first().and_then(|(_, own, _)| self.defines.get(&format!("{own}_DRIVER_TYPE")));
        let at = first.map_or_else(|| self.file.place(1), |defined| defined.place.clone());
        two(
            &rotary,
            &at,
            "each needs one of I_, J_, K_, U_, V_ and W_DRIVER_TYPE, and one of AXIS4_ROTATES to AXIS9_ROTATES",
        )?;
        let mut facts = vec![Fact::new("dialect.firmware", "marlin", vec![at], "a Configuration.h of Marlin")];
        self.limits(&mut facts)?;
        let most = self.speeds(axes, speeds, accelerations, &mut facts)?;
        self.rest(&mut facts)?;
        let mut roles = by_name(&rotary);
        if let Some(table) = self.told("PENTA_AXIS_TRT") {
            let letters: Vec<char> = rotary.iter().map(|axis| axis.letter).collect();
            let of_table = tilting_table(&letters, &table.place, &mut facts);
            self.table(of_table.tilt, &table, &mut facts)?;
            roles = Some(of_table);
        }
        let notes = self.notes;
        Ok(Imported { firmware: "marlin", facts, most, rotary, roles, by_command: false, notes, called: None })
    }

    fn limits(&mut self, facts: &mut Vec<Fact>) -> Result<(), ImportError> {
        if let Some(round) = ROUND.into_iter().find(|name| self.enabled(name)) {
            self.notes.push(format!(
                "{round}: limits of X, Y and Z cannot be read; set limits.x_mm, y_mm and z_mm to what the nozzle reaches at every height"
            ));
            return Ok(());
        }
        for (axis, key) in [("X", "limits.x_mm"), ("Y", "limits.y_mm"), ("Z", "limits.z_mm")] {
            let low = self.get(&format!("{axis}_MIN_POS"))?;
            if let (Some(low), Some(high)) = (low, self.get(&format!("{axis}_MAX_POS"))?) {
                facts.push(span(key, &low, &high, ""));
            }
        }
        Ok(())
    }

    fn speeds(
        &mut self,
        axes: usize,
        speeds: Option<Vec<Stated>>,
        accelerations: Option<Vec<Stated>>,
        facts: &mut Vec<Fact>,
    ) -> Result<Vec<Fact>, ImportError> {
        let minute = |stated: &Stated| Stated { value: scaled(stated.value, 60.0), ..stated.clone() };
        let most = speeds.as_ref().map_or_else(Vec::new, |speeds| {
            let xy = least([Some(&speeds[0]), Some(&speeds[1])]).map(|feed| minute(&feed));
            feeds(xy, Some(minute(&speeds[2])), "the slower of X and Y, in mm/min", facts)
        });
        if let Some(list) = &accelerations {
            let print = self.get("DEFAULT_ACCELERATION")?;
            let of = |which: &[usize]| least(which.iter().map(|&i| Some(&list[i])).chain([print.as_ref()]));
            let how = "the least of X, Y and DEFAULT_ACCELERATION";
            facts.extend(of(&[0, 1]).map(|a| Fact::number("limits.acceleration_mm_per_s2", &a, how)));
            facts.extend(of(&[2]).map(|a| {
                Fact::number("limits.z_acceleration_mm_per_s2", &a, "the lower of Z and DEFAULT_ACCELERATION")
            }));
            facts.push(Fact::number("limits.e_acceleration_mm_per_s2", &list[axes], "the extruder's"));
        }
        Ok(most)
    }

    fn rest(&mut self, facts: &mut Vec<Fact>) -> Result<(), ImportError> {
        for name in LEVELS {
            if let Some(defined) = self.defines.get(name) {
                self.notes.push(format!(
                    "{}: {name}: G28 may leave a bed mesh active that was measured on the level table; put {} after G28",
                    defined.place,
                    Correction::BedMesh.off(Firmware::Marlin)
                ));
            }
        }
        if self.enabled("CLASSIC_JERK") {
            self.notes.push("CLASSIC_JERK replaces junction deviation, so limits.junction_mm is unknown".to_owned());
        } else {
            facts.extend(self.get("JUNCTION_DEVIATION_MM")?.map(|v| Fact::number("limits.junction_mm", &v, "")));
        }
        for (name, key) in
            [("EXTRUDE_MINTEMP", "limits.min_extrude_c"), ("DEFAULT_NOMINAL_FILAMENT_DIA", "process.filament_mm")]
        {
            facts.extend(self.get(name)?.map(|stated| Fact::number(key, &stated, "")));
        }
        for (name, over, usual, key) in [
            ("HEATER_0_MAXTEMP", "HOTEND_OVERSHOOT", 15.0, "link.max_nozzle_c"),
            ("BED_MAXTEMP", "BED_OVERSHOOT", 10.0, "link.max_bed_c"),
        ] {
            let over = self.get(over)?.map_or(Stated { value: usual, from: Vec::new() }, |stated| stated);
            if let Some(most) = self.get(name)? {
                let from = [&most.from[..], &over.from[..]].concat();
                let how = format!("{name} less an overshoot of {}", over.value);
                facts.push(Fact::new(key, most.value - over.value, from, &how));
            }
        }
        for (name, key) in [
            ("BAUDRATE", "link.baud"),
            ("BUFSIZE", "link.commands"),
            ("MAX_CMD_SIZE", "link.longest_line"),
            ("BLOCK_BUFFER_SIZE", "link.planner"),
            ("RX_BUFFER_SIZE", "link.buffer"),
        ] {
            if let Some(stated) = self.get(name)? {
                if stated.value.fract() != 0.0 || stated.value.abs() > 1e9 {
                    let why = format!("{name} must be a whole number of at most 1000000000, got {}", stated.value);
                    return Err(ImportError::At { place: stated.place(), why });
                }
                facts.push(Fact::new(key, stated.value as i64, stated.from, ""));
            }
        }
        Ok(())
    }

    /// Where the axes of the fork's tilting table lie.
    fn table(&mut self, tilt: char, of: &Defined, facts: &mut Vec<Fact>) -> Result<(), ImportError> {
        let beside = if tilt == 'B' { 0 } else { 1 };
        let mut zero = Vec::new();
        for name in ["DEFAULT_MRZP_OFFSET_X", "DEFAULT_MRZP_OFFSET_Y", "DEFAULT_MRZP_OFFSET_Z"] {
            zero.extend(self.get(name)?);
        }
        let across = self.get(["DEFAULT_ROTATIONAL_JOINT_OFFSET_X", "DEFAULT_ROTATIONAL_JOINT_OFFSET_Y"][beside])?;
        let up = self.get("DEFAULT_ROTATIONAL_JOINT_OFFSET_Z")?;
        let ([x, y, z], Some(across), Some(up)) = (&zero[..], across, up) else {
            let why =
                "DEFAULT_MRZP_OFFSET_X, _Y, _Z and DEFAULT_ROTATIONAL_JOINT_OFFSET_X or _Y, _Z are not all defined";
            self.notes.push(format!("{}: {why}, so the position of the tilt axis is unknown", of.place));
            return Ok(());
        };
        let mut d = [0.0, 0.0, up.value];
        d[beside] = across.value;
        let pivot = [x.value + d[0], y.value + d[1], z.value + d[2]].map(|v| scaled(v + 0.0, 1.0));
        let list = |values: [f64; 3]| toml::Value::Array(values.map(toml::Value::Float).to_vec());
        let offsets = [across.from, up.from].concat();
        let from = [&x.from[..], &y.from, &z.from, &offsets].concat();
        facts.push(Fact::new(
            "kinematics.pivot_mm",
            list(pivot),
            from,
            "the rotary zero point and the offsets from it",
        ));
        facts.push(Fact::new(
            "kinematics.offset_mm",
            list(d.map(|v| 0.0 - v)),
            offsets,
            "from the tilt axis back to the table's middle",
        ));
        Ok(())
    }
}
