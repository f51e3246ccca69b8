//! Klipper: printer.cfg with what it includes.
//!
//! Sources: Klipper's configuration reference and command reference. Rotary axes are `[manual_stepper ..]`s, whose millimetres are degrees; a
//! line `MANUAL_STEPPER STEPPER=.. GCODE_AXIS=A` of some macro gives one its letter. `position_min` of X, Y and Z is 0 where it is not given.

use std::collections::BTreeSet;

use super::stated::{
    CORNER, Contradiction, Fact, File, ImportError, Open, Rotary, Shelf, Stated, StatedAt, junction, least, number,
    scaled, shown, span,
};
use super::{AxisRoles, Imported, by_name, corrects, two};
use crate::gcode::meaning::Firmware;

/// Kinematics whose X, Y and Z are the tip's, each with its own stops.
const STRAIGHT: [&str; 5] = ["cartesian", "corexy", "corexz", "hybrid_corexy", "hybrid_corexz"];
/// Others whose X, Y and Z are the tip's; how far it goes is no matter of three stops.
const ROUND: [&str; 6] = ["delta", "deltesian", "rotary_delta", "polar", "winch", "none"];

/// What the axes are called that commands turn.
const LETTERS: [char; 2] = ['A', 'C'];
/// Files that come with servers' pages.
const CLIENTS: [&str; 3] = ["mainsail.cfg", "fluidd.cfg", "client.cfg"];
/// How many controls `[pivot_coord]` may have.
const PIVOT_CONTROLS: usize = 3;

struct Entry {
    section: String,
    key: String,
    value: String,
    place: StatedAt,
}

/// A line that tells Klipper of an axis.
struct Told {
    stepper: String,
    letter: char,
    limits: [Option<Stated>; 2],
    place: StatedAt,
}

#[derive(Default)]
struct Config {
    entries: Vec<Entry>,
    sections: Vec<(String, StatedAt)>,
    told: Vec<Told>,
    notes: Vec<String>,
    /// The motors that commands turn, as somebody has told them.
    motors: Option<[String; 2]>,
}

pub(super) fn read(files: &[File], motors: Option<&[String; 2]>, shelf: &dyn Shelf) -> Result<Imported, ImportError> {
    let mut config = Config { motors: motors.cloned(), ..Config::default() };
    Open::each(files, shelf, |file, open| config.file(file, open))?;
    config.machine()
}

impl Config {
    fn file(&mut self, file: &File, open: &mut Open<'_>) -> Result<(), ImportError> {
        let mut section = String::new();
        for (place, whole) in file.lines() {
            // What Klipper has saved itself stands behind these marks.
            let line = whole.strip_prefix("#*#").map_or(whole, str::trim_start);
            let line = line.split('#').next().unwrap_or_default();
            let line = line.split(" ;").next().unwrap_or_default();
            let plain = line.trim();
            if plain.is_empty() || plain.starts_with(';') {
                continue;
            }
            self.command(plain, &place)?;
            if let Some((name, _)) = line.strip_prefix('[').and_then(|rest| rest.split_once(']')) {
                let name = name.split_ascii_whitespace().collect::<Vec<_>>().join(" ");
                match name.strip_prefix("include ") {
                    Some(named) => self.include(file, named, &place, open)?,
                    None => self.sections.push((name.clone(), place)),
                }
                section = name;
            } else if !line.starts_with(char::is_whitespace)
                && let Some((key, value)) = line.split_once([':', '='])
            {
                let (key, value) = (key.trim().to_ascii_lowercase(), value.trim().to_owned());
                self.entries.push(Entry { section: section.clone(), key, value, place });
            }
        }
        Ok(())
    }

    fn include(&mut self, file: &File, named: &str, place: &StatedAt, open: &mut Open<'_>) -> Result<(), ImportError> {
        let path = file.beside(named);
        let pattern = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        let folder = path.parent().unwrap_or(std::path::Path::new("")).to_owned();
        let names = if pattern.contains(['*', '?']) {
            let names = open.shelf.names(&folder).into_iter();
            names.filter(|name| matches(pattern.as_bytes(), name.as_bytes())).collect()
        } else {
            vec![pattern]
        };
        for name in names {
            // Their owners' servers keep these; they hold macros alone.
            if CLIENTS.contains(&&*name) && open.shelf.text(&folder.join(&name)).is_err() {
                self.notes
                    .push(format!("{place}: {name} not found and skipped; it holds only macros of the web interface"));
                continue;
            }
            let inner = open.named(folder.join(name), place, "put it where the line says, or remove the line")?;
            self.file(&inner, open)?;
            open.leave();
        }
        Ok(())
    }

    fn command(&mut self, line: &str, place: &StatedAt) -> Result<(), ImportError> {
        self.notes.extend(corrects(Firmware::Klipper, line, place));
        let mut words = line.split_ascii_whitespace();
        if !words.next().is_some_and(|word| word.eq_ignore_ascii_case("MANUAL_STEPPER")) {
            return Ok(());
        }
        let pairs: Vec<(String, &str)> = words
            .filter_map(|word| word.split_once('='))
            .map(|(key, value)| (key.to_ascii_uppercase(), value))
            .collect();
        let get = |name: &str| pairs.iter().find(|(key, _)| key == name).map(|(_, value)| *value);
        let (Some(stepper), Some(letter)) = (get("STEPPER"), get("GCODE_AXIS").filter(|letter| !letter.is_empty()))
        else {
            return Ok(());
        };
        let mut limits = [None, None];
        for (limit, name) in limits.iter_mut().zip(["LIMIT_VELOCITY", "LIMIT_ACCEL"]) {
            match get(name) {
                Some(text) if text.contains('{') => {
                    self.notes.push(format!("{place}: {name}={} is computed by Klipper and is not read", shown(text)));
                }
                Some(text) => *limit = Some(Stated { value: number(name, text, place)?, from: vec![place.clone()] }),
                None => {}
            }
        }
        match letter.as_bytes() {
            [one] if one.is_ascii_alphabetic() && !stepper.contains('{') => {
                let letter = one.to_ascii_uppercase().into();
                self.told.push(Told { stepper: stepper.to_owned(), letter, limits, place: place.clone() });
            }
            _ => self
                .notes
                .push(format!("{place}: {} is not read: its stepper or its axis is not a plain name", shown(line))),
        }
        Ok(())
    }

    /// The value of a key that only one line may give; Klipper itself takes the last, which hides the others.
    fn one(&self, section: &str, key: &str) -> Result<Option<&Entry>, ImportError> {
        let mut all = self.entries.iter().filter(|entry| entry.section == section && entry.key == key);
        let first = all.next();
        match (first, all.find(|other| first.is_some_and(|first| first.value != other.value))) {
            (Some(first), Some(other)) => Err(Contradiction {
                what: format!("[{section}] {key}"),
                first: first.place.clone(),
                one: first.value.clone(),
                second: other.place.clone(),
                other: other.value.clone(),
            }
            .into()),
            _ => Ok(first),
        }
    }

    fn number(&self, section: &str, key: &str) -> Result<Option<Stated>, ImportError> {
        let Some(entry) = self.one(section, key)? else { return Ok(None) };
        let value = number(&format!("[{section}] {key}"), &entry.value, &entry.place)?;
        Ok(Some(Stated { value, from: vec![entry.place.clone()] }))
    }

    fn machine(mut self) -> Result<Imported, ImportError> {
        let rotary = self.rotary()?;
        let Some(kinematics) = self.one("printer", "kinematics")? else {
            let file = rotary[0].from.file.clone();
            let why = "[printer] has no kinematics, so this is not a complete printer.cfg; pass printer.cfg itself"
                .to_owned();
            return Err(ImportError::File { file, why });
        };
        let (name, place) = (kinematics.value.clone(), kinematics.place.clone());
        let mut facts = vec![Fact::new("dialect.firmware", "klipper", vec![place.clone()], "a printer.cfg of Klipper")];
        if STRAIGHT.contains(&&*name) {
            for (axis, key) in [("x", "limits.x_mm"), ("y", "limits.y_mm"), ("z", "limits.z_mm")] {
                facts.extend(self.limits(axis, key)?);
            }
        } else if ROUND.contains(&&*name) {
            self.notes.push(format!(
                "{place}: limits of X, Y and Z cannot be read for kinematics {name}; set limits.x_mm, y_mm and z_mm to what the nozzle reaches at every height"
            ));
        } else {
            let why = format!(
                "kinematics {} is unknown, so its effect on the table is unknown; use one of {}, {}",
                shown(&name),
                STRAIGHT.join(", "),
                ROUND.join(", ")
            );
            return Err(ImportError::At { place, why });
        }
        let most = self.speeds(&mut facts)?;
        self.heat(&mut facts)?;
        let by_command = self.motors.is_some();
        let pivot = self.pivot_coord(&rotary);
        let roles = if by_command {
            // Letters of this order: see `rotary`.
            let how = "from your answers: commands turn the motors, so the axis letters are only labels".to_owned();
            let about = pivot.and_then(|roles| roles.about);
            Some(AxisRoles { tilt: LETTERS[0], rotation: LETTERS[1], about, how })
        } else {
            pivot.or_else(|| by_name(&rotary))
        };
        Ok(Imported { firmware: "klipper", facts, most, rotary, roles, by_command, notes: self.notes, called: None })
    }

    /// What `[pivot_coord]` says of the axes: each of its controls turns about one of the machine's axes. Where they lie is noted alone: it
    /// counts from the tip, and the table's surface is in none of its numbers.
    fn pivot_coord(&mut self, rotary: &[Rotary]) -> Option<AxisRoles> {
        let of = |key: &str| self.entries.iter().find(|entry| entry.section == "pivot_coord" && entry.key == key);
        let (_, place) = self.sections.iter().find(|(name, _)| name == "pivot_coord")?.clone();
        let axis = |i: usize| {
            let name = of(&format!("control_{i}"))?.value.strip_prefix("manual_stepper ")?.trim().to_owned();
            let about = of(&format!("rotate_axis_{i}"))?.value.to_ascii_uppercase().chars().next()?;
            Some((rotary.iter().find(|axis| axis.motor == name)?.letter, about))
        };
        let axes: Vec<(char, char)> = (0..PIVOT_CONTROLS).filter_map(axis).collect();
        let offsets: Vec<String> = self
            .entries
            .iter()
            .filter(|entry| entry.section == "pivot_coord" && entry.key.starts_with("offset_"))
            .map(|entry| format!("{} = {}", entry.key, entry.value))
            .collect();
        self.notes.push(format!(
            "{place}: do not run PIVOT_COORD ACTIVATE=1, which would apply the tilt a second time; its offsets{} count from the nozzle tip, so \
             compare kinematics.pivot_mm and kinematics.offset_mm with them by hand",
            if offsets.is_empty() { String::new() } else { format!(" ({})", offsets.join(", ")) }
        ));
        let tilts = |about: char| matches!(about, 'X' | 'Y');
        match axes[..] {
            [(tilt, about), (rotation, 'Z')] | [(rotation, 'Z'), (tilt, about)] if tilts(about) => {
                let how = format!("by [pivot_coord]: {tilt} is about {about}, {rotation} about Z");
                Some(AxisRoles { tilt, rotation, about: Some(about), how })
            }
            _ => None,
        }
    }

    fn limits(&self, axis: &str, key: &'static str) -> Result<Option<Fact>, ImportError> {
        let section = format!("stepper_{axis}");
        let Some(high) = self.number(&section, "position_max")? else { return Ok(None) };
        let low = self.number(&section, "position_min")?;
        let how = if low.is_none() { "position_min is not set; Klipper's default is 0" } else { "" };
        let low = low.unwrap_or(Stated { value: 0.0, from: Vec::new() });
        Ok(Some(span(key, &low, &high, how)))
    }

    fn speeds(&mut self, facts: &mut Vec<Fact>) -> Result<Vec<Fact>, ImportError> {
        let minute = |stated: Stated| Stated { value: scaled(stated.value, 60.0), ..stated };
        let get = |key| self.number("printer", key);
        let mut most = Vec::new();
        if let Some(feed) = get("max_velocity")?.map(minute) {
            facts.push(Fact::number("limits.max_feed_mm_per_min", &feed, "max_velocity in mm/min"));
            most.push(Fact::number("transition.travel_mm_per_min", &feed, "lowered to max_velocity"));
        }
        most.extend(
            get("max_z_velocity")?
                .map(minute)
                .map(|z| Fact::number("transition.z_mm_per_min", &z, "lowered to max_z_velocity")),
        );
        let Some(all) = get("max_accel")? else { return Ok(most) };
        facts.push(Fact::number("limits.acceleration_mm_per_s2", &all, ""));
        let z = get("max_z_accel")?;
        let how = if z.is_none() { "max_z_accel is not set; Klipper's default is max_accel" } else { "" };
        facts.push(Fact::number(
            "limits.z_acceleration_mm_per_s2",
            &least([z.as_ref(), Some(&all)]).unwrap_or(all.clone()),
            how,
        ));
        let corner = get("square_corner_velocity")?;
        let how = match &corner {
            Some(_) => "square_corner_velocity squared * 0.414 / max_accel",
            None => "square_corner_velocity is not set; Klipper's default is 5: its square * 0.414 / max_accel",
        };
        let speed = corner.as_ref().map_or(5.0, |corner| corner.value);
        let from = corner.map_or_else(Vec::new, |corner| corner.from).into_iter().chain(all.from.clone()).collect();
        junction(&Stated { value: speed * speed * CORNER / all.value, from }, how, facts, &mut self.notes);
        Ok(most)
    }

    fn heat(&mut self, facts: &mut Vec<Fact>) -> Result<(), ImportError> {
        for (section, name, key) in [
            ("extruder", "nozzle_diameter", "process.nozzle_mm"),
            ("extruder", "filament_diameter", "process.filament_mm"),
            ("extruder", "min_extrude_temp", "limits.min_extrude_c"),
            ("extruder", "max_temp", "link.max_nozzle_c"),
            ("extruder", "max_extrude_only_accel", "limits.e_acceleration_mm_per_s2"),
            ("heater_bed", "max_temp", "link.max_bed_c"),
        ] {
            facts.extend(self.number(section, name)?.map(|stated| Fact::number(key, &stated, "")));
        }
        if !self.sections.iter().any(|(name, _)| name == "heater_bed") {
            self.notes.push(
                "there is no [heater_bed], and Klipper then rejects M140 and M190; remove them from dialect.start and dialect.end".to_owned(),
            );
        }
        Ok(())
    }

    /// The steppers that a line gives a letter.
    fn rotary(&self) -> Result<Vec<Rotary>, ImportError> {
        let steppers =
            self.sections.iter().filter_map(|(name, place)| Some((name.strip_prefix("manual_stepper ")?, place)));
        let mut seen = BTreeSet::new();
        let steppers: Vec<(&str, &StatedAt)> = steppers.filter(|(name, _)| seen.insert(*name)).collect();
        if let Some(motors) = &self.motors {
            return self.commanded(motors, &steppers);
        }
        let mut rotary: Vec<Rotary> = Vec::new();
        for (name, place) in &steppers {
            let mut letter: Option<&Told> = None;
            for told in self.told.iter().filter(|told| told.stepper == **name) {
                let first = *letter.get_or_insert(told);
                agree(&format!("GCODE_AXIS of {name}"), first, told)?;
            }
            if let Some(told) = letter {
                if let Some(other) = rotary.iter().find(|axis| axis.letter == told.letter) {
                    let why = format!(
                        "axis letter {} is already used by {} ({}); give each stepper its own letter",
                        told.letter, other.motor, other.from
                    );
                    return Err(ImportError::At { place: told.place.clone(), why });
                }
                rotary.push(self.axis(name, place, told)?);
            }
        }
        let end = self.sections.last().map_or(StatedAt { file: String::new(), line: 0 }, |(_, place)| place.clone());
        if steppers.len() >= 2 && rotary.len() < 2 {
            let without: Vec<_> =
                steppers.iter().filter(|(name, _)| !rotary.iter().any(|axis| axis.motor == *name)).collect();
            let (name, place) = without[0];
            let why = format!(
                "[manual_stepper {name}] has no axis letter; register tilt and rotation in a macro (MANUAL_STEPPER STEPPER={name} GCODE_AXIS=LETTER), \
                 or, if MANUAL_STEPPER MOVE turns the table, pass --set kinematics.tilt.stepper=NAME --set \
                 kinematics.rotation.stepper=NAME (steppers: {})",
                steppers.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ")
            );
            return Err(ImportError::At { place: (*place).clone(), why });
        }
        let at = rotary.first().map_or(end, |axis| axis.from.clone());
        two(
            &rotary,
            &at,
            "an axis is a [manual_stepper ..] that a macro registers, as MANUAL_STEPPER STEPPER=tilt GCODE_AXIS=A",
        )?;
        Ok(rotary)
    }

    /// The motors that commands turn, the tilt's first.
    fn commanded(&self, motors: &[String; 2], steppers: &[(&str, &StatedAt)]) -> Result<Vec<Rotary>, ImportError> {
        let mut rotary = Vec::new();
        for (motor, letter) in motors.iter().zip(LETTERS) {
            let Some((name, place)) = steppers.iter().find(|(name, _)| name.eq_ignore_ascii_case(motor)) else {
                let known: Vec<&str> = steppers.iter().map(|(name, _)| *name).collect();
                let file = self.sections.first().map_or_else(String::new, |(_, place)| place.file.clone());
                let why = format!(
                    "[manual_stepper {motor}] not found; the files have: {}",
                    if known.is_empty() { "none".to_owned() } else { known.join(", ") }
                );
                return Err(ImportError::File { file, why });
            };
            let told = Told { stepper: (*name).to_owned(), letter, limits: [None, None], place: (*place).clone() };
            rotary.push(self.axis(name, place, &told)?);
        }
        Ok(rotary)
    }

    fn axis(&self, name: &str, place: &StatedAt, told: &Told) -> Result<Rotary, ImportError> {
        let section = format!("manual_stepper {name}");
        let get = |key| self.number(&section, key);
        let [rate, acceleration] = told.limits.clone();
        // An acceleration of 0 is none at all.
        let moving = |stated: &Stated| stated.value > 0.0;
        Ok(Rotary {
            letter: told.letter,
            min: get("position_min")?,
            max: get("position_max")?,
            rate: rate.or(get("velocity")?),
            acceleration: acceleration.or(get("accel")?).filter(moving),
            from: if told.place.line > 0 { told.place.clone() } else { place.clone() },
            motor: name.to_owned(),
        })
    }
}

/// Refuses two lines on one stepper that do not say the same.
fn agree(what: &str, first: &Told, second: &Told) -> Result<(), ImportError> {
    let said = |told: &Told| {
        let limit = |i: usize| told.limits[i].as_ref().map_or_else(String::new, |limit| format!(" {}", limit.value));
        format!("{}{}{}", told.letter, limit(0), limit(1))
    };
    let (one, other) = (said(first), said(second));
    if one == other {
        return Ok(());
    }
    let (first, second) = (first.place.clone(), second.place.clone());
    Err(Contradiction { what: what.to_owned(), first, one, second, other }.into())
}

/// Whether a name fits a pattern with `*` and `?`.
fn matches(pattern: &[u8], name: &[u8]) -> bool {
    // Where the last * began, and what it has taken so far.
    let (mut p, mut n, mut star) = (0, 0, None);
    while n < name.len() {
        match pattern.get(p) {
            Some(b'*') => {
                star = Some((p, n));
                p += 1;
            }
            Some(&c) if c == b'?' || c == name[n] => {
                p += 1;
                n += 1;
            }
            _ => {
                let Some((at, taken)) = star else { return false };
                star = Some((at, taken + 1));
                (p, n) = (at + 1, taken + 1);
            }
        }
    }
    pattern[p..].iter().all(|c| *c == b'*')
}

/// The lines of `code` that register axes `was`, for the steppers and letters of `axes`; `None` where it registers none of that kind.
/// Without them where commands turn the table: Klipper takes no MOVE of what is an axis.
pub(super) fn renamed(
    code: &str,
    was: [char; 2],
    axes: [&Rotary; 2],
    registered: &str,
    by_command: bool,
) -> Option<String> {
    let motor = |letter: char| {
        let end = format!("GCODE_AXIS={letter}");
        let line = registered.lines().find(|line| line.split_ascii_whitespace().any(|word| word == end))?;
        line.split_ascii_whitespace().find_map(|word| word.strip_prefix("STEPPER="))
    };
    let motors = [motor(was[0])?, motor(was[1])?];
    let line = |line: &str| {
        let own = line.split_ascii_whitespace().find_map(|word| word.strip_prefix("STEPPER="));
        let Some(i) = motors.iter().position(|motor| own == Some(motor)) else { return line.to_owned() };
        let axis = axes[i];
        let word = |word: &str| match word.split_once('=') {
            Some(("STEPPER", _)) => format!("STEPPER={}", axis.motor),
            Some(("GCODE_AXIS", letter)) if !letter.is_empty() => format!("GCODE_AXIS={}", axis.letter),
            Some((key @ "LIMIT_VELOCITY", value)) => format!("{key}={}", said(axis.rate.as_ref(), value)),
            Some((key @ "LIMIT_ACCEL", value)) => format!("{key}={}", said(axis.acceleration.as_ref(), value)),
            _ => word.to_owned(),
        };
        line.split_ascii_whitespace().map(word).collect::<Vec<_>>().join(" ")
    };
    let registers = |line: &&str| line.split_ascii_whitespace().any(|word| word.starts_with("GCODE_AXIS="));
    Some(code.lines().filter(|line| !(by_command && registers(line))).map(line).collect::<Vec<_>>().join("\n"))
}

fn said(stated: Option<&Stated>, otherwise: &str) -> String {
    stated.map_or_else(|| otherwise.to_owned(), |stated| stated.value.to_string())
}

#[cfg(test)]
mod tests {
    use super::matches;

    #[test]
    fn names_fit_patterns() {
        for (pattern, name, fits) in [
            ("*.cfg", "a.cfg", true),
            ("*.cfg", "a.cfg.old", false),
            ("a?c*", "abcd", true),
            ("a?c", "ac", false),
            ("*a*b", "xaxxab", true),
            ("", "", true),
        ] {
            assert_eq!(matches(pattern.as_bytes(), name.as_bytes()), fits, "{pattern} {name}");
        }
    }
}
