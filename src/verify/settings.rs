//! Rule `setting`: what stays in force (accelerations, speeds, jerk, pressure advance, firmware retraction) is within reach of what the
//! profile states, and what a print begins with it ends with.
//!
//! Slicers set accelerations and jerk anew for each kind of line, so these have bounds alone. All of a print's lines are laid with one value of
//! everything else, whatever was set between them for another print or behind the last. What the profile's own code has, or `[dialect]
//! allow` names, passes.

use std::collections::BTreeMap;

use crate::gcode::ParsedLine;
use crate::gcode::meaning::{Firmware, index_letter};
use crate::profile::Profile;

/// A setting of an axis (X, Y, Z, E) or of all.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Setting {
    Acceleration,
    RetractAcceleration,
    AxisAcceleration(usize),
    AxisSpeed(usize),
    Jerk,
    Junction,
    LeastSpeed,
    Advance,
    Retract,
    Recover,
}

use Setting::{
    Acceleration, Advance, AxisAcceleration, AxisSpeed, Jerk, Junction, LeastSpeed, Recover, Retract,
    RetractAcceleration,
};

/// So many times what the profile states is asked of no machine, and so small a share is as good as standing.
pub(super) const TIMES: f64 = 10.0;
/// What quick machines are driven at, mm/s²: stock presets have 12,000 and 20,000. Many profiles state the default, not their machine's own.
pub(super) const QUICK: f64 = 50_000.0;
pub(super) const SHARE: f64 = 0.01;
/// A limit below this share of the speeds that the profile prints with holds a print up.
const SPEED_SHARE: f64 = 0.05;
/// Pressure advance follows the flow by so much up or down within a print, where a slicer adapts it.
const ADAPTED: f64 = 3.0;

/// What is wrong: measured, allowed, in words.
pub(super) type Objection = ([f64; 2], String);

/// A setting, and the extruder it is for.
type Key = (Setting, u32);

/// What is in force, line after line.
pub(super) struct Settings {
    firmware: Firmware,
    /// The profile's: acceleration of X and Y, Z, E; speed of X and Y, Z, E.
    accelerations: [f64; 3],
    speeds: [f64; 3],
    /// With the line that has set it.
    in_force: BTreeMap<Key, (f64, u32)>,
    /// What each print's first line was laid with.
    begun_with: BTreeMap<Option<usize>, BTreeMap<Key, f64>>,
    /// For which print they were compared since the last change.
    compared: Option<Option<usize>>,
}

impl Settings {
    pub(super) fn of(profile: &Profile) -> Self {
        let (limits, transition) = (&profile.limits, &profile.transition);
        let [xy, z, e] =
            [limits.acceleration_mm_per_s2, limits.z_acceleration_mm_per_s2, limits.e_acceleration_mm_per_s2];
        Self {
            firmware: profile.firmware(),
            accelerations: [xy, z, e],
            speeds: [limits.max_feed_mm_per_min / 60.0, transition.z_mm_per_min / 60.0, transition.retract_mm_per_s],
            in_force: BTreeMap::new(),
            begun_with: BTreeMap::new(),
            compared: None,
        }
    }

    /// Takes a line that sets something; what is beyond its bounds. What is `permitted` holds for all prints.
    pub(super) fn note(&mut self, line: &ParsedLine, number: u32, permitted: bool) -> Option<Objection> {
        let mut wrong = None;
        for (key, value) in set_by(self.firmware, line) {
            wrong = wrong.or_else(|| self.beyond(key.0, value));
            self.in_force.insert(key, (value, number));
            if permitted {
                for begun in self.begun_with.values_mut() {
                    begun.insert(key, value);
                }
            }
        }
        self.compared = None;
        wrong.filter(|_| !permitted)
    }

    /// Filament is laid for a print: what is in force must be what its first line was laid with. The line that has changed it, and how.
    pub(super) fn lay(&mut self, print: Option<usize>) -> Option<(u32, Objection)> {
        if self.compared.replace(print) == Some(print) {
            return None;
        }
        let constant = self.in_force.iter().filter(|((setting, _), _)| !varies(*setting));
        let Some(begun) = self.begun_with.get(&print) else {
            let now = constant.map(|(key, (value, _))| (*key, *value)).collect();
            self.begun_with.insert(print, now);
            return None;
        };
        let mut changed =
            constant.filter_map(|(key, (value, line))| Some((*line, changed(*key, begun.get(key), *value)?)));
        changed.next()
    }

    fn beyond(&self, setting: Setting, value: f64) -> Option<Objection> {
        let [low, high] = self.range(setting);
        let (name, unit) = (name(setting), unit(setting));
        let text = |range: String| format!("{name} is set to {value} {unit}; {range}");
        if value < low {
            Some(([value, low], text(format!("the minimum for this profile is {low:.2} {unit}"))))
        } else if value > high {
            Some(([value, high], text(format!("the maximum for this profile is {high:.2} {unit}"))))
        } else {
            None
        }
    }

    fn range(&self, setting: Setting) -> [f64; 2] {
        // X and Y, Z, E.
        let of = |values: &[f64; 3], axis: usize| values[axis.saturating_sub(1)];
        match setting {
            Acceleration => reach(self.accelerations[0]),
            RetractAcceleration => reach(self.accelerations[2]),
            // Most firmwares take the least of these and of the others.
            AxisAcceleration(axis) => [SHARE * of(&self.accelerations, axis), f64::INFINITY],
            AxisSpeed(axis) => [SPEED_SHARE * of(&self.speeds, axis), f64::INFINITY],
            Jerk => [0.0, 100.0],
            Junction => [0.0, 0.5],
            LeastSpeed => [0.0, 10.0],
            Advance => [0.0, 2.0],
            Retract => [0.1, 20.0],
            Recover => [-0.3, 0.3],
        }
    }
}

/// What an acceleration may be set to where the profile states so much.
fn reach(stated: f64) -> [f64; 2] {
    [SHARE * stated, (TIMES * stated).max(QUICK)]
}

/// Whether slicers set it anew for each kind of line.
fn varies(setting: Setting) -> bool {
    matches!(setting, Acceleration | RetractAcceleration | AxisAcceleration(_) | Jerk)
}

/// Another value than a print began with.
fn changed((setting, _): Key, before: Option<&f64>, now: f64) -> Option<Objection> {
    let (name, unit) = (name(setting), unit(setting));
    let Some(&before) = before else {
        let text = format!("{name} is set to {now} {unit} within a print, and was not set before it");
        return Some(([now, 0.0], text));
    };
    let adapted = setting == Advance && (before / ADAPTED..=before * ADAPTED).contains(&now);
    (now != before && !adapted)
        .then(|| ([now, before], format!("{name} changes from {before} to {now} {unit} within a print")))
}

/// What a line sets, in mm and seconds.
fn set_by(firmware: Firmware, line: &ParsedLine) -> Vec<(Key, f64)> {
    let Some(command) = line.commands.first() else { return set_by_name(&line.text) };
    let extruder = index_letter(*command).and_then(|letter| line.value(letter)).unwrap_or_default() as u32;
    let is_rrf = firmware == Firmware::RepRapFirmware;
    let per_minute = if is_rrf { 60.0 } else { 1.0 };
    let axes = |of: fn(usize) -> Setting| b"XYZE".iter().enumerate().map(|(i, l)| (*l, of(i))).collect();
    let (letters, unit): (Vec<(u8, Setting)>, f64) = match (command.letter, command.number) {
        (b'M', 204) => {
            (vec![(b'S', Acceleration), (b'P', Acceleration), (b'T', Acceleration), (b'R', RetractAcceleration)], 1.0)
        }
        (b'M', 201) => (axes(AxisAcceleration), 1.0),
        (b'M', 203) => (axes(AxisSpeed), per_minute),
        (b'M', 205) => ([axes(|_| Jerk), vec![(b'J', Junction), (b'S', LeastSpeed), (b'T', LeastSpeed)]].concat(), 1.0),
        (b'M', 566) => (axes(|_| Jerk), 60.0),
        (b'M', 900) => (vec![(b'K', Advance)], 1.0),
        (b'M', 572) => (vec![(b'S', Advance)], 1.0),
        (b'M', 207) if is_rrf => (vec![(b'S', Retract), (b'R', Recover)], 1.0),
        (b'M', 207) => (vec![(b'S', Retract)], 1.0),
        (b'M', 208) if !is_rrf => (vec![(b'S', Recover)], 1.0),
        _ => return Vec::new(),
    };
    letters.iter().filter_map(|(letter, setting)| Some(((*setting, extruder), line.value(*letter)? / unit))).collect()
}

/// The same of Klipper's commands by name.
fn set_by_name(text: &[u8]) -> Vec<(Key, f64)> {
    let text = String::from_utf8_lossy(text).to_ascii_uppercase();
    let mut words = text.split_ascii_whitespace();
    let keys: &[(&str, Setting)] = match words.next().unwrap_or_default() {
        "SET_VELOCITY_LIMIT" => {
            &[("ACCEL", Acceleration), ("VELOCITY", AxisSpeed(0)), ("SQUARE_CORNER_VELOCITY", Jerk)]
        }
        "SET_PRESSURE_ADVANCE" => &[("ADVANCE", Advance)],
        "SET_RETRACTION" => &[("RETRACT_LENGTH", Retract), ("UNRETRACT_EXTRA_LENGTH", Recover)],
        _ => return Vec::new(),
    };
    let value = |word: &str| {
        let (key, value) = word.split_once('=')?;
        let (_, setting) = keys.iter().find(|(known, _)| *known == key)?;
        Some(((*setting, 0), value.parse().ok()?))
    };
    words.filter_map(value).collect()
}

fn name(setting: Setting) -> &'static str {
    match setting {
        Acceleration => "acceleration",
        RetractAcceleration => "the acceleration of retractions",
        AxisAcceleration(_) => "the highest acceleration of an axis",
        AxisSpeed(_) => "the highest speed of an axis",
        Jerk => "jerk",
        Junction => "junction deviation",
        LeastSpeed => "the lowest speed",
        Advance => "pressure advance",
        Retract => "the length of firmware retraction",
        Recover => "the extra length of firmware unretraction",
    }
}

fn unit(setting: Setting) -> &'static str {
    match setting {
        Acceleration | RetractAcceleration | AxisAcceleration(_) => "mm/s2",
        AxisSpeed(_) | Jerk | LeastSpeed => "mm/s",
        Junction | Retract | Recover => "mm",
        Advance => "s",
    }
}
