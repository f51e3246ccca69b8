//! What a connected machine says of itself: Marlin's M115, M503 and M211, grblHAL's `$I` and `$$`, `RepRapFirmware`'s object model (M409).
//!
//! One text, as `machine read` keeps it or a host's terminal shows it: lines that were sent begin with `>>>` or `Send:`. Sources: Marlin 2.1's
//! `settings.cpp`, `M211.cpp` and `M115.cpp`, grblHAL's list of settings. Marlin tells neither where its table lies nor whether an axis turns:
//! every letter besides X, Y, Z and E is taken for a rotary axis. Grbl tells how far an axis travels and not from where, so no ends are stated.

use std::collections::BTreeMap;

use super::marlin::{TRT, tilting_table};
use super::stated::{
    CORNER, Fact, File, ImportError, Rotary, Stated, StatedAt, feeds, junction, least, number, same, scaled, span,
};
use super::{Imported, by_name, corrects, two};
use crate::gcode::meaning::Firmware;

/// Ends farther out are said of axes that have none, degrees.
pub(super) const ENDLESS_DEG: f64 = 9999.0;
/// grblHAL's letters of rotary axes; U, V and W are linear unless a machine has no others, and often one of them is the filament.
const GRBL_ROTARY: [&str; 2] = ["ABC", "ABCUVW"];

/// Lines that the machine has said, with their places. A last line without an end may be cut off, and is none.
pub(super) fn lines(file: &File) -> impl Iterator<Item = (StatedAt, &str)> {
    let sent = |line: &str| [">>>", "Send:", "Sent:"].iter().any(|mark| line.starts_with(mark));
    let ended = file.text.matches('\n').count();
    file.lines()
        .take(ended)
        .map(|(place, line)| (place, untimed(line)))
        .filter(move |(_, line)| !sent(line.trim_start()))
        .map(|(place, line)| {
            let line = line.trim();
            let line = ["Recv:", "<<<"].iter().find_map(|mark| line.strip_prefix(mark)).unwrap_or(line).trim_start();
            (place, line.strip_prefix("echo:").unwrap_or(line).trim())
        })
}

/// A line without the time that a host's log has before it (`22:59:43.907:`, `2026-11-28 19:00:00,123 -`).
pub(super) fn untimed(line: &str) -> &str {
    let mut rest = line.trim_start();
    while let Some((first, behind)) = rest.split_once(char::is_whitespace)
        && !first.is_empty()
        && first.chars().all(|c| c.is_ascii_digit() || "-:.,[]T".contains(c))
    {
        rest = behind.trim_start();
    }
    rest
}

/// Words such as `X200.00`, of the letters that stand before numbers.
fn words<'a>(text: &'a str) -> impl Iterator<Item = (char, &'a str)> {
    let plain = |word: &'a str| {
        let letter = word.chars().next().filter(char::is_ascii_uppercase)?;
        Some((letter, word[1..].trim_start_matches(':')))
    };
    text.split_ascii_whitespace().filter_map(plain)
}

/// What each letter of a line says.
type Row = BTreeMap<char, Stated>;

#[derive(Default)]
struct Said {
    /// By command: M203, M201, M204, M205.
    rows: BTreeMap<&'static str, Row>,
    low: Row,
    high: Row,
    identity: Option<(StatedAt, String)>,
    notes: Vec<String>,
}

const ROWS: [&str; 4] = ["M203", "M201", "M204", "M205"];

/// Marlin's answers.
pub(super) fn marlin(file: &File) -> Result<Imported, ImportError> {
    let mut said = Said::default();
    for (place, line) in lines(file) {
        said.line(line, &place)?;
    }
    said.machine(file)
}

impl Said {
    fn line(&mut self, line: &str, place: &StatedAt) -> Result<(), ImportError> {
        if line.contains("FIRMWARE_NAME:") {
            self.identity.get_or_insert((place.clone(), line.to_owned()));
        }
        let plain = line.split(';').next().unwrap_or_default().trim();
        if let Some((before, after)) = plain.split_once("Max:")
            && let Some((_, low)) = before.split_once("Min:")
        {
            put("Min", low, place, &mut self.low)?;
            return put("Max", after, place, &mut self.high);
        }
        let code = plain.split_ascii_whitespace().next().unwrap_or_default();
        if code == "G20" {
            let why = "the firmware reports inches; send G21 to it, and read the machine again".to_owned();
            return Err(ImportError::At { place: place.clone(), why });
        }
        // One for each extruder, where each has its own.
        if words(&plain[code.len()..]).any(|(letter, _)| letter == 'T') && ["M203", "M201"].contains(&code) {
            return Ok(());
        }
        if let Some(row) = ROWS.into_iter().find(|row| *row == code) {
            return put(row, &plain[code.len()..], place, self.rows.entry(row).or_default());
        }
        if code == "M211" && plain.ends_with("S0") {
            self.notes.push(format!("{place}: software endstops are off, so nothing stops an axis at its end"));
        }
        if code.starts_with(['G', 'M']) {
            self.notes.extend(corrects(Firmware::Marlin, plain, place));
        }
        Ok(())
    }

    fn get(&self, row: &str, letter: char) -> Option<&Stated> {
        self.rows.get(row)?.get(&letter)
    }

    fn machine(self, file: &File) -> Result<Imported, ImportError> {
        let lacks = |what: &str| ImportError::File {
            file: file.name.clone(),
            why: format!("the answer to {what} is missing or incomplete; read the machine again"),
        };
        let speeds = self.rows.get("M203").ok_or_else(|| lacks("M503 (M203: fastest speeds)"))?;
        // Of what is told in part, the least would be another number than of all.
        for row in ["M201", "M204"] {
            self.rows.get(row).ok_or_else(|| lacks(&format!("M503 ({row}: accelerations)")))?;
        }
        let (at, identity) = self.identity.clone().ok_or_else(|| lacks("M115"))?;
        if identity.contains("PENTA_AXIS_HT") || identity.contains("PENTA_AXIS_HH") {
            let why = "the head of this machine tilts, which is not read into a profile; write one that extends generic-hh, generic-ht or rep5x-ender-3-v3-se".to_owned();
            return Err(ImportError::At { place: at, why });
        }
        let letters: Vec<char> = speeds.keys().copied().filter(|letter| !"XYZE".contains(*letter)).collect();
        let count = word(&identity, "AXIS_COUNT:").and_then(|word| word.parse::<usize>().ok());
        if let Some(count) = count.filter(|count| *count != letters.len() + 3) {
            let why = format!(
                "M115 counts {count} axes, but M203 ({}) names X, Y, Z and {} more; read the machine again",
                speeds.values().next().map_or_else(String::new, |stated| stated.place().to_string()),
                letters.len()
            );
            return Err(ImportError::At { place: at, why });
        }
        let rotary: Vec<Rotary> = letters.iter().map(|letter| self.rotary(*letter, &speeds[letter])).collect();
        two(&rotary, &at, "every axis of M203 besides X, Y, Z and E")?;
        let mut facts =
            vec![Fact::new("dialect.firmware", "marlin", vec![at.clone()], "as the machine says of itself (M115)")];
        for (letter, key) in [('X', "limits.x_mm"), ('Y', "limits.y_mm"), ('Z', "limits.z_mm")] {
            let ends = self.low.get(&letter).zip(self.high.get(&letter));
            facts.extend(ends.map(|(low, high)| span(key, low, high, "its software endstops")));
        }
        let (mut notes, most) = (self.notes.clone(), self.speeds(speeds, &mut facts));
        if self.low.is_empty() {
            notes.push("the firmware does not answer M211, so the limits of its axes are unknown".to_owned());
        }
        match self.junction() {
            Some((stated, how)) => junction(&stated, how, &mut facts, &mut notes),
            None => notes.push("M205 is not told, so limits.junction_mm is unknown".to_owned()),
        }
        let mut roles = by_name(&rotary);
        if identity.contains(TRT) {
            roles = Some(tilting_table(&letters, &at, &mut facts));
        }
        let called = identity.split_once("MACHINE_TYPE:").map(|(_, rest)| {
            let end = rest.split(" KINEMATICS:").next().and_then(|rest| rest.split(" EXTRUDER_COUNT:").next());
            end.unwrap_or_default().trim().to_owned()
        });
        Ok(Imported { firmware: "marlin", facts, most, rotary, roles, by_command: false, notes, called })
    }

    fn rotary(&self, letter: char, rate: &Stated) -> Rotary {
        let end = |row: &Row| row.get(&letter).filter(|end| end.value.abs() < ENDLESS_DEG).cloned();
        let both = end(&self.low).zip(end(&self.high));
        let (min, max) = both.map_or((None, None), |(low, high)| (Some(low), Some(high)));
        Rotary {
            letter,
            min,
            max,
            rate: Some(rate.clone()),
            acceleration: self.get("M201", letter).cloned(),
            from: rate.place(),
            motor: String::new(),
        }
    }

    fn speeds(&self, speeds: &Row, facts: &mut Vec<Fact>) -> Vec<Fact> {
        let minute = |stated: Stated| Stated { value: scaled(stated.value, 60.0), ..stated };
        let xy = least([speeds.get(&'X'), speeds.get(&'Y')]).map(minute);
        let most = feeds(xy, speeds.get(&'Z').cloned().map(minute), "the slower of X and Y, in mm/min", facts);
        let print = self.get("M204", 'P');
        let of = |letter| self.get("M201", letter);
        let all = least([of('X'), of('Y'), print]);
        facts.extend(all.map(|a| Fact::number("limits.acceleration_mm_per_s2", &a, "the lowest of X, Y and M204 P")));
        let z = least([of('Z'), print]);
        facts.extend(z.map(|a| Fact::number("limits.z_acceleration_mm_per_s2", &a, "the lower of Z and M204 P")));
        facts.extend(of('E').map(|a| Fact::number("limits.e_acceleration_mm_per_s2", a, "the extruder's")));
        most
    }

    /// Its junction deviation, or the one that comes to its jerk.
    fn junction(&self) -> Option<(Stated, &'static str)> {
        if let Some(stated) = self.get("M205", 'J') {
            return Some((stated.clone(), ""));
        }
        let jerk = least([self.get("M205", 'X'), self.get("M205", 'Y')])?;
        let all = least([self.get("M201", 'X'), self.get("M201", 'Y'), self.get("M204", 'P')])?;
        let value = jerk.value * jerk.value * CORNER / all.value;
        let how = "jerk of X and Y, squared * 0.414 / acceleration; exact for corners of 90 degrees";
        Some((Stated { value, from: [jerk.from, all.from].concat() }, how))
    }
}

fn put(what: &str, text: &str, place: &StatedAt, row: &mut Row) -> Result<(), ImportError> {
    for (letter, text) in words(text) {
        let what = format!("{what} {letter}");
        let stated = Stated { value: number(&what, text, place)? + 0.0, from: vec![place.clone()] };
        match row.get(&letter) {
            Some(first) => same(&what, first, &stated)?,
            None => {
                row.insert(letter, stated);
            }
        }
    }
    Ok(())
}

/// What stands behind `key` up to the next blank.
fn word<'a>(text: &'a str, key: &str) -> Option<&'a str> {
    text.split_once(key)?.1.split_ascii_whitespace().next()
}

/// grblHAL's answers.
pub(super) fn grbl(file: &File) -> Result<Imported, ImportError> {
    let (mut settings, mut letters) = (BTreeMap::new(), None);
    for (place, line) in lines(file) {
        if let Some(all) = line.strip_prefix("[AXS:").and_then(|rest| rest.split([':', ']']).nth(1)) {
            letters = Some((place, all.to_owned()));
        } else if let Some((key, value)) = line.strip_prefix('$').and_then(|rest| rest.split_once('='))
            && let Ok(key) = key.parse::<u32>()
            && (key == 11 || (110..130).contains(&key))
        {
            // Behind the value stands its name, in brackets.
            let value = value.split([' ', '(']).next().unwrap_or_default();
            let stated = Stated { value: number(&format!("${key}"), value, &place)?, from: vec![place] };
            if let Some(first) = settings.get(&key) {
                same(&format!("${key}"), first, &stated)?;
            }
            settings.insert(key, stated);
        }
    }
    let lacks = |what: &str| ImportError::File {
        file: file.name.clone(),
        why: format!("the answer to {what} is missing or incomplete; read the machine again"),
    };
    let (at, letters) = letters.ok_or_else(|| lacks("$I ([AXS:..]: the letters of the axes, which grblHAL tells)"))?;
    let axis = |letter: char| letters.find(letter).and_then(|i| u32::try_from(i).ok());
    let get = |first: u32, letter: char| settings.get(&(first + axis(letter)?));
    if get(110, 'X').is_none() {
        return Err(lacks("$$ ($110: fastest speed of X)"));
    }
    let second = |stated: Stated| Stated { value: scaled(stated.value, 1.0 / 60.0), ..stated };
    let of = |names: &str| letters.chars().filter(|letter| names.contains(*letter)).collect::<Vec<char>>();
    let more = GRBL_ROTARY.map(of).into_iter().find(|all| all.len() >= 2).unwrap_or_default();
    let rotary: Vec<Rotary> = more
        .into_iter()
        .map(|letter| Rotary {
            letter,
            min: None,
            max: None,
            rate: get(110, letter).cloned().map(second),
            acceleration: get(120, letter).cloned(),
            from: at.clone(),
            motor: String::new(),
        })
        .collect();
    two(&rotary, &at, "every axis besides X, Y and Z")?;
    let mut facts = vec![Fact::new("dialect.firmware", "grbl", vec![at], "as the machine says of itself ($I)")];
    let most =
        feeds(least([get(110, 'X'), get(110, 'Y')]), get(110, 'Z').cloned(), "the slower of X and Y", &mut facts);
    let all = least([get(120, 'X'), get(120, 'Y')]);
    facts.extend(all.map(|a| Fact::number("limits.acceleration_mm_per_s2", &a, "the lower of X and Y")));
    facts.extend(get(120, 'Z').map(|a| Fact::number("limits.z_acceleration_mm_per_s2", a, "")));
    let mut notes = vec![
        "Grbl tells how far each axis travels ($130..), but not from where: limits and tilt range are asked".to_owned(),
    ];
    settings.get(&11).into_iter().for_each(|stated| junction(stated, "", &mut facts, &mut notes));
    let roles = by_name(&rotary);
    Ok(Imported { firmware: "grbl", facts, most, rotary, roles, by_command: false, notes, called: None })
}
