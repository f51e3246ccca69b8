//! RepRapFirmware: config.g with the files that it calls (M98).
//!
//! Source: the Duet documentation's G-code dictionary. Speeds are a minute (mm or degrees), accelerations a second and second. Axes A to D are
//! rotational unless M584 says R0, all others linear unless it says R1; of two more linear axes (Open5x's U and V) the user says which is which.

mod words;

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde_json::Value;

use self::words::{Command, command};
use super::said::ENDLESS_DEG;
use super::stated::{
    CORNER, Fact, File, ImportError, Open, Rotary, Shelf, Stated, StatedAt, feeds, junction, least, number, same,
    scaled, shown, span,
};
use super::{Imported, by_name, corrects, two};
use crate::gcode::meaning::{Correction, Firmware};

/// What is read, so that none of it may stand under a condition.
const READ: [&str; 12] =
    ["M584", "M208", "M203", "M201", "M204", "M566", "M302", "M404", "M143", "M140", "M563", "M669"];
/// M669 K of kinematics whose X, Y and Z are the tip's, each with its own stops: Cartesian, CoreXY, CoreXZ, CoreXYU, CoreXYUV, Markforged.
const STRAIGHT: [f64; 6] = [0.0, 1.0, 2.0, 5.0, 8.0, 11.0];
/// M669 K of the fork for robots, in which the firmware works out the axes from the tip and the table's angles itself.
const ROBOT: f64 = 13.0;
/// What lines begin with that are no commands.
const CONDITIONS: [&str; 4] = ["if", "elif", "else", "while"];

/// An axis, in the firmware's units.
#[derive(Clone, Default)]
struct Axis {
    from: Option<StatedAt>,
    rotates: bool,
    low: Option<Stated>,
    high: Option<Stated>,
    speed: Option<Stated>,
    acceleration: Option<Stated>,
    jerk: Option<Stated>,
}

#[derive(Default)]
struct Config {
    axes: BTreeMap<char, Axis>,
    /// Other numbers, by command and letter.
    numbers: BTreeMap<&'static str, Stated>,
    /// Heaters and their limits.
    heaters: Vec<(f64, Stated)>,
    notes: Vec<String>,
    called: Option<String>,
    last: Option<StatedAt>,
}

pub(super) fn read(files: &[File], shelf: &dyn Shelf) -> Result<Imported, ImportError> {
    let mut config = Config::default();
    Open::each(files, shelf, |file, open| config.file(file, open))?;
    config.machine()
}

/// The axes as the board's own object model has them, a piece a line: `{"key":"move.axes[3]",..,"result":{"letter":"A",..}}`.
pub(super) fn said(file: &File) -> Result<Imported, ImportError> {
    let mut config = Config::default();
    for (place, line) in super::said::lines(file).filter(|(_, line)| line.starts_with('{')) {
        let wrong = |why: String| ImportError::At { place: place.clone(), why };
        let answer: Value = serde_json::from_str(line).map_err(|_| {
            wrong("this piece of the object model is cut off or not JSON; read the machine again".to_owned())
        })?;
        let (key, result) = (answer["key"].as_str().unwrap_or_default(), &answer["result"]);
        if key.starts_with("move.axes[") && !result.is_null() {
            config.axis_said(key, result, &place)?;
        } else if key == "move.kinematics" {
            config.kinematics_said(result, &place);
        } else if key == "network" {
            config.called = result["name"].as_str().map(str::to_owned);
        }
        config.last = Some(place);
    }
    config.machine()
}

/// Kinematics as the object model names them, and as M669 numbers them.
const NAMED: [(&str, f64); 7] = [
    ("cartesian", 0.0),
    ("corexy", 1.0),
    ("corexz", 2.0),
    ("corexyu", 5.0),
    ("corexyuv", 8.0),
    ("markforged", 11.0),
    ("robot", ROBOT),
];
/// Any other.
const UNNAMED: f64 = -1.0;

impl Config {
    fn axis_said(&mut self, key: &str, result: &Value, place: &StatedAt) -> Result<(), ImportError> {
        let wrong = |what: &str| ImportError::At {
            place: place.clone(),
            why: format!("{key} has no {what}; read the machine again"),
        };
        let letter = result["letter"].as_str().and_then(|text| text.chars().next());
        let letter = letter.ok_or_else(|| wrong("letter"))?;
        if !letter.is_ascii_uppercase() {
            let why = format!("axis {letter:?} is not supported; only axes A to Z are");
            return Err(ImportError::At { place: place.clone(), why });
        }
        let get = |what: &str| -> Result<Stated, ImportError> {
            let value = result[what].as_f64().filter(|value| value.is_finite()).ok_or_else(|| wrong(what))?;
            Ok(Stated { value, from: vec![place.clone()] })
        };
        let (low, high) = (get("min")?, get("max")?);
        let rotates = "ABCD".contains(letter);
        let endless = rotates && [&low, &high].iter().any(|end| end.value.abs() >= ENDLESS_DEG);
        let ends = if endless { [None, None] } else { [Some(low), Some(high)] };
        let [low, high] = ends;
        let axis = Axis {
            from: Some(place.clone()),
            rotates,
            low,
            high,
            speed: Some(get("speed")?),
            acceleration: Some(get("acceleration")?),
            jerk: Some(get("jerk")?),
        };
        if self.axes.insert(letter, axis).is_some() {
            return Err(ImportError::At { place: place.clone(), why: format!("axis {letter} is told twice") });
        }
        Ok(())
    }

    fn kinematics_said(&mut self, result: &Value, place: &StatedAt) {
        let name = result["name"].as_str().unwrap_or_default().to_ascii_lowercase();
        let value = NAMED.iter().find(|(named, _)| *named == name).map_or(UNNAMED, |(_, value)| *value);
        self.numbers.insert("M669 K", Stated { value, from: vec![place.clone()] });
    }

    fn file(&mut self, file: &File, open: &mut Open<'_>) -> Result<(), ImportError> {
        // How far in the innermost condition stands; its lines stand farther in.
        let mut conditions: Vec<usize> = Vec::new();
        for (place, line) in file.lines() {
            let inner = line.trim_start();
            let depth = line.len() - inner.len();
            if inner.is_empty() || inner.starts_with(';') {
                continue;
            }
            conditions.retain(|at| *at < depth);
            let first = inner.split(|c: char| !c.is_ascii_alphanumeric()).next().unwrap_or_default();
            if CONDITIONS.contains(&first) {
                conditions.push(depth);
                continue;
            }
            self.notes.extend(corrects(Firmware::RepRapFirmware, inner, &place));
            let Some(command) = command(inner, &place)? else { continue };
            if let Some(number) = command.stray.first().filter(|_| READ.contains(&&*command.code)) {
                self.notes
                    .push(format!("{place}: {number} in {} has no letter before it and is not read", command.code));
            }
            if conditions.is_empty() {
                self.command(&command, &place, file, open)?;
            } else if READ.contains(&&*command.code) {
                let why = format!(
                    "{} is inside a condition, which is not evaluated; pass a copy of the file where it is unconditional or removed",
                    command.code
                );
                return Err(ImportError::At { place, why });
            } else if command.code == "M98" {
                self.notes.push(format!("{place}: a conditional M98 is not read"));
            }
            self.last = Some(place);
        }
        Ok(())
    }

    fn command(
        &mut self,
        command: &Command,
        place: &StatedAt,
        file: &File,
        open: &mut Open<'_>,
    ) -> Result<(), ImportError> {
        match &*command.code {
            "M584" => self.drives(command, place),
            "M208" => self.limits(command, place),
            "M203" => self.each(command, place, |axis| &mut axis.speed),
            "M201" => self.each(command, place, |axis| &mut axis.acceleration),
            "M566" => self.each(command, place, |axis| &mut axis.jerk),
            "M204" => self.keep(command, 'P', "M204 P", place),
            "M302" => self.keep(command, 'S', "M302 S", place),
            "M404" => {
                self.keep(command, 'N', "M404 N", place)?;
                self.keep(command, 'D', "M404 D", place)
            }
            "M563" if command.number('P', place)?.is_none_or(|tool| tool == 0.0) => {
                self.keep(command, 'H', "M563 H", place)
            }
            "M140" => self.keep(command, 'H', "M140 H", place),
            "M143" if !command.words.iter().any(|(letter, _)| "PTAC".contains(*letter)) => {
                let heater = command.number('H', place)?.unwrap_or(1.0);
                let limit = command.number('S', place)?;
                let stated = limit.map(|value| (heater, Stated { value, from: vec![place.clone()] }));
                self.heaters.extend(stated);
                Ok(())
            }
            "M669" => self.keep(command, 'K', "M669 K", place),
            "M550" => {
                self.called = command.text('P').or(command.text('S'));
                Ok(())
            }
            "M98" => self.call(command, place, file, open),
            "G20" => {
                let why = "G20 switches to inches; only millimetres are read".to_owned();
                Err(ImportError::At { place: place.clone(), why })
            }
            _ => Ok(()),
        }
    }

    fn call(
        &mut self,
        command: &Command,
        place: &StatedAt,
        file: &File,
        open: &mut Open<'_>,
    ) -> Result<(), ImportError> {
        let Some(named) = command.text('P') else {
            self.notes.push(format!("{place}: M98 without a literal file name is not read"));
            return Ok(());
        };
        // config.g lies in /sys of the card.
        let plain = named.strip_prefix("0:").unwrap_or(&named);
        let path = match plain.strip_prefix('/') {
            Some(of_card) => PathBuf::from(of_card.strip_prefix("sys/").map_or(format!("../{of_card}"), str::to_owned)),
            None => PathBuf::from(plain),
        };
        let path = file.beside(&path.to_string_lossy());
        let inner = open.named(path, place, "copy it from the board to the same relative path beside this file")?;
        self.file(&inner, open)?;
        open.leave();
        Ok(())
    }

    fn drives(&mut self, command: &Command, place: &StatedAt) -> Result<(), ImportError> {
        let kind = command.number('R', place)?;
        for (letter, _) in command.words.iter().filter(|(letter, _)| !"EPRS".contains(*letter)) {
            let axis = self.axes.entry(*letter).or_default();
            if axis.from.is_none() {
                axis.from = Some(place.clone());
                axis.rotates = kind.map_or("ABCD".contains(*letter), |kind| kind == 1.0);
            }
        }
        Ok(())
    }

    fn limits(&mut self, command: &Command, place: &StatedAt) -> Result<(), ImportError> {
        let lowest = command.number('S', place)?.is_some_and(|kind| kind == 1.0);
        for (letter, text) in command.words.iter().filter(|(letter, _)| *letter != 'S') {
            let what = format!("M208 {letter}");
            let of = |text: &str| -> Result<Stated, ImportError> {
                Ok(Stated { value: number(&what, text, place)?, from: vec![place.clone()] })
            };
            let axis = self.axes.entry(*letter).or_default();
            let ends = match text.split_once(':') {
                Some((low, high)) => {
                    let (low, high) = (of(low)?, of(high)?);
                    if low.value > high.value {
                        let note = format!("{place}: {what}{text} is read as {}:{}", high.value, low.value);
                        self.notes.push(note);
                        [Some(high), Some(low)]
                    } else {
                        [Some(low), Some(high)]
                    }
                }
                None if lowest => [Some(of(text)?), None],
                None => [None, Some(of(text)?)],
            };
            for (end, to) in ends.into_iter().zip([&mut axis.low, &mut axis.high]) {
                end.map_or(Ok(()), |end| put(&what, end, to))?;
            }
        }
        Ok(())
    }

    /// A number for each axis; of a list, which drives of one axis have, the least.
    fn each(
        &mut self,
        command: &Command,
        place: &StatedAt,
        of: impl Fn(&mut Axis) -> &mut Option<Stated>,
    ) -> Result<(), ImportError> {
        let read = |(letter, _): &&(char, String)| *letter == 'E' || !"IPST".contains(*letter);
        for (letter, text) in command.words.iter().filter(read) {
            let what = format!("{} {letter}", command.code);
            let all: Result<Vec<f64>, _> = text.split(':').map(|one| number(&what, one, place)).collect();
            let value = all?.into_iter().fold(f64::INFINITY, f64::min);
            put(&what, Stated { value, from: vec![place.clone()] }, of(self.axes.entry(*letter).or_default()))?;
        }
        Ok(())
    }

    fn keep(
        &mut self,
        command: &Command,
        letter: char,
        name: &'static str,
        place: &StatedAt,
    ) -> Result<(), ImportError> {
        let Some(value) = command.number(letter, place)? else { return Ok(()) };
        let stated = Stated { value, from: vec![place.clone()] };
        let mut kept = self.numbers.remove(name);
        put(name, stated, &mut kept)?;
        self.numbers.extend(kept.map(|kept| (name, kept)));
        Ok(())
    }

    fn machine(mut self) -> Result<Imported, ImportError> {
        let rotary = self.rotary()?;
        let firmware = rotary[0].from.clone();
        let mut facts =
            vec![Fact::new("dialect.firmware", "reprapfirmware", vec![firmware], "a config.g of RepRapFirmware")];
        for (letter, key) in [('X', "limits.x_mm"), ('Y', "limits.y_mm"), ('Z', "limits.z_mm")] {
            let axis = self.axes.get(&letter);
            if let Some((low, high)) = axis.and_then(|axis| axis.low.as_ref().zip(axis.high.as_ref())) {
                facts.push(span(key, low, high, ""));
            }
        }
        if let Some(kind) = self.numbers.get("M669 K").filter(|kind| kind.value == ROBOT) {
            let why = format!(
                "M669 K{ROBOT} {}; give the config.g of a firmware with Cartesian or CoreXY kinematics (M669 K0, K1)",
                Correction::TipFollowing.harm()
            );
            return Err(ImportError::At { place: kind.place(), why });
        }
        if let Some(kind) = self.numbers.get("M669 K").filter(|kind| !STRAIGHT.contains(&kind.value)) {
            self.notes.push(format!(
                "{}: M669 K{} is not Cartesian or CoreXY kinematics; check the limits of X, Y and Z, and that each rotary axis moves only the \
                 table",
                kind.place(),
                kind.value
            ));
        }
        let most = self.speeds(&mut facts);
        self.heat(&mut facts);
        let roles = by_name(&rotary);
        let notes = self.notes;
        Ok(Imported {
            firmware: "reprapfirmware",
            facts,
            most,
            rotary,
            roles,
            by_command: false,
            notes,
            called: self.called,
        })
    }

    fn rotary(&self) -> Result<Vec<Rotary>, ImportError> {
        let more = || self.axes.iter().filter(|(letter, axis)| !"XYZE".contains(**letter) && axis.from.is_some());
        let rotating = more().filter(|(_, axis)| axis.rotates).count();
        let mut rotary = Vec::new();
        for (letter, axis) in more().filter(|(_, axis)| axis.rotates || rotating < 2) {
            let Some(from) = axis.from.clone() else { continue };
            let second = |stated: Stated| Stated { value: scaled(stated.value, 1.0 / 60.0), ..stated };
            rotary.push(Rotary {
                letter: *letter,
                min: axis.low.clone(),
                max: axis.high.clone(),
                rate: axis.speed.clone().map(second),
                acceleration: axis.acceleration.clone(),
                from,
                motor: String::new(),
            });
        }
        let end = self.last.clone().unwrap_or(StatedAt { file: String::new(), line: 0 });
        let at = self.axes.values().find_map(|axis| axis.from.clone()).unwrap_or(end);
        two(&rotary, &at, "M584 creates them")?;
        Ok(rotary)
    }

    fn speeds(&mut self, facts: &mut Vec<Fact>) -> Vec<Fact> {
        let get =
            |letter: char, of: fn(&Axis) -> &Option<Stated>| self.axes.get(&letter).and_then(|axis| of(axis).clone());
        let slower = |of: fn(&Axis) -> &Option<Stated>| {
            let (x, y) = (get('X', of)?, get('Y', of)?);
            least([Some(&x), Some(&y)])
        };
        let most = feeds(slower(|axis| &axis.speed), get('Z', |axis| &axis.speed), "the slower of X and Y", facts);
        let all = least([slower(|axis| &axis.acceleration).as_ref(), self.numbers.get("M204 P")]);
        facts.extend(
            all.iter().map(|all| Fact::number("limits.acceleration_mm_per_s2", all, "the lowest of X, Y and M204 P")),
        );
        for (letter, key) in [('Z', "limits.z_acceleration_mm_per_s2"), ('E', "limits.e_acceleration_mm_per_s2")] {
            facts.extend(get(letter, |axis| &axis.acceleration).map(|stated| Fact::number(key, &stated, "")));
        }
        let jerk = slower(|axis| &axis.jerk);
        if let (Some(all), Some(jerk)) = (all, jerk) {
            let value = (jerk.value / 60.0).powi(2) * CORNER / all.value;
            let stated = Stated { value, from: [&jerk.from[..], &all.from[..]].concat() };
            let how = "M566 jerk in mm/s, squared * 0.414 / acceleration; exact for corners of 90 degrees";
            junction(&stated, how, facts, &mut self.notes);
        }
        most
    }

    fn heat(&mut self, facts: &mut Vec<Fact>) {
        for (name, key) in
            [("M302 S", "limits.min_extrude_c"), ("M404 N", "process.filament_mm"), ("M404 D", "process.nozzle_mm")]
        {
            facts.extend(self.numbers.get(name).map(|stated| Fact::number(key, stated, "")));
        }
        for (name, key) in [("M563 H", "link.max_nozzle_c"), ("M140 H", "link.max_bed_c")] {
            let heater = self.numbers.get(name).map(|heater| heater.value);
            let limit = self.heaters.iter().rev().find(|(number, _)| Some(*number) == heater);
            facts.extend(limit.map(|(number, limit)| Fact::number(key, limit, &format!("heater {number}, by {name}"))));
        }
        if let Some(none) = self.numbers.get("M140 H").filter(|heater| heater.value < 0.0) {
            self.notes.push(format!(
                "{}: there is no bed heater (M140 H-1), and M190 would wait for ever: remove M140 and M190 from dialect.start and dialect.end",
                none.place()
            ));
        }
    }
}

/// Keeps a number; another one for the same is refused.
fn put(what: &str, stated: Stated, to: &mut Option<Stated>) -> Result<(), ImportError> {
    if let Some(first) = to {
        return same(what, first, &stated);
    }
    *to = Some(stated);
    Ok(())
}

/// Refuses a word that the firmware would work out.
fn worked_out(what: &str, text: &str, place: &StatedAt) -> ImportError {
    let why = format!("{what} is {}, which the firmware computes; write the number", shown(text));
    ImportError::At { place: place.clone(), why }
}
