//! A machine from the configuration of its firmware: what the files state, as keys of a profile, each with file and line.
//!
//! Pure: texts come in, files that they name are asked for through a [`Shelf`]. Lengths mm, angles degrees, whatever the firmware counts
//! in. Nothing is guessed: what no line says is no fact; two lines that cannot both hold are refused; what touches the table's axes and is
//! not understood is a note or a refusal. Sources: LinuxCNC's, Klipper's, RepRapFirmware's and Marlin's own documentation of their
//! configuration; the code of Koala's simulator, whose machine.json is the one file that knows a head and names no firmware.

mod klipper;
mod koala;
mod linuxcnc;
mod marlin;
mod reprap;
mod said;
mod stated;

pub use stated::{Contradiction, Fact, File, ImportError, Rotary, Shelf, Stated, StatedAt};

use self::stated::{least, ordered, shown, spans};
use super::ranges::{check, range};
use crate::gcode::ParsedLine;
use crate::gcode::meaning::{Firmware, correction};

/// What a configuration states.
#[derive(Clone, Debug)]
pub struct Imported {
    /// The firmware's name, as `dialect.firmware` has it; `"koala"` for the simulator's machine, which names none.
    pub firmware: &'static str,
    /// Keys that do not depend on which axis tilts.
    pub facts: Vec<Fact>,
    /// What keys may be at most, since an axis goes no faster.
    pub most: Vec<Fact>,
    /// The rotary axes, at least two.
    pub rotary: Vec<Rotary>,
    /// Which axis tilts and which turns; `None` where no line tells.
    pub roles: Option<AxisRoles>,
    /// Whether the table is turned by commands, each of which waits for its end, and not by words of moves.
    pub by_command: bool,
    /// What touches the axes, or will stop a print, and no key can say.
    pub notes: Vec<String>,
    /// The machine's own name, where a line gives it.
    pub called: Option<String>,
}

/// Which of the rotary axes tilts and which turns, as the files tell.
#[derive(Clone, Debug)]
pub struct AxisRoles {
    /// Letter of the axis that tilts.
    pub tilt: char,
    /// Letter of the axis that turns.
    pub rotation: char,
    /// The machine axis that the tilt is about, `'X'` or `'Y'`; `None` where no line tells.
    pub about: Option<char>,
    /// Why, for a comment.
    pub how: String,
}

/// The firmwares whose files are known, and what tells them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    LinuxCnc,
    Klipper,
    RepRap,
    Marlin,
    Hal,
    Koala,
    /// Answers of a connected machine.
    MarlinSaid,
    RepRapSaid,
    GrblSaid,
}

const LOOKED_FOR: &str = "searched for the sections [KINS], [TRAJ] or [EMC] (LinuxCNC's ini), [printer], [stepper_x] or [manual_stepper ..] (Klipper's printer.cfg), lines of M584, M208 or M669 (RepRapFirmware's config.g), #define X_DRIVER_TYPE or X_BED_SIZE (Marlin's Configuration.h), {\"_version\": .., \"limits\": ..} (the machine.json of Koala's simulator), and answers to M115, M503 or $I";

/// Whether a line is one of those that every Marlin has in the one or the other of its two files.
fn defines(line: &str) -> bool {
    let mut words = line.split_ascii_whitespace();
    let names = [
        "X_DRIVER_TYPE",
        "X_BED_SIZE",
        "DEFAULT_MAX_FEEDRATE",
        "CONFIGURATION_H_VERSION",
        "CONFIGURATION_ADV_H_VERSION",
    ];
    words.next() == Some("#define") && words.next().is_some_and(|name| names.contains(&name))
}

impl Kind {
    fn of(text: &str) -> Option<Self> {
        if let Some(said) = Self::said(text) {
            return Some(said);
        }
        if text.trim_start().starts_with('{') {
            let keys = ["\"_version\"", "\"limits\"", "\"proxies\""];
            return keys.iter().any(|key| text.contains(key)).then_some(Self::Koala);
        }
        let lines = || text.lines().map(str::trim);
        let sections: Vec<&str> = lines().filter_map(|line| Some(line.strip_prefix('[')?.split_once(']')?.0)).collect();
        let has = |names: &[&str]| sections.iter().any(|s| names.contains(&s.split_whitespace().next().unwrap_or("")));
        let begins = |words: &[&str]| {
            lines().any(|line| line.split_ascii_whitespace().next().is_some_and(|word| words.contains(&word)))
        };
        if has(&["KINS", "TRAJ", "EMC", "EMCMOT"]) {
            Some(Self::LinuxCnc)
        } else if has(&[
            "printer",
            "mcu",
            "stepper_x",
            "manual_stepper",
            "gcode_macro",
            "delayed_gcode",
            "extruder",
            "include",
        ]) {
            Some(Self::Klipper)
        } else if sections.is_empty() && begins(&["M584", "M208", "M669"]) {
            Some(Self::RepRap)
        } else if sections.is_empty() && lines().any(defines) {
            Some(Self::Marlin)
        } else if sections.is_empty() && begins(&["setp", "sets", "net", "loadrt"]) {
            Some(Self::Hal)
        } else {
            None
        }
    }

    /// What a machine says of itself, as [`said`] reads it.
    fn said(text: &str) -> Option<Self> {
        let plain = |line| {
            let line: &str = said::untimed(line).trim_start_matches("Recv:").trim_start();
            line.strip_prefix("ok ").unwrap_or(line)
        };
        if let Some(name) = text.lines().find_map(|line| plain(line).strip_prefix("FIRMWARE_NAME:")) {
            return match Firmware::introduced(name)? {
                Firmware::Marlin => Some(Self::MarlinSaid),
                Firmware::RepRapFirmware => Some(Self::RepRapSaid),
                Firmware::Grbl => Some(Self::GrblSaid),
                _ => None,
            };
        }
        let numbered = |line| ["[AXS:", "$110="].iter().any(|mark| plain(line).starts_with(mark));
        text.lines().any(numbered).then_some(Self::GrblSaid)
    }

    fn name(self) -> &'static str {
        match self {
            Self::LinuxCnc | Self::Hal => "a LinuxCNC file",
            Self::Klipper => "a Klipper file",
            Self::RepRap => "a RepRapFirmware file",
            Self::Marlin => "a Marlin file",
            Self::Koala => "a file of Koala's simulator",
            Self::MarlinSaid | Self::RepRapSaid | Self::GrblSaid => "what a machine says of itself",
        }
    }
}

/// Reads what `files` state of one machine; they are told apart by what is in them. `motors` are Klipper's names of those that commands turn,
/// the tilt's and the rotation's, where somebody has told them.
///
/// # Errors
///
/// [`ImportError`] with file and line: a kind that is not known, two kinds, a file that is named and not there, a number that is none, two
/// lines that contradict each other, fewer than two rotary axes, kinematics that no profile can say.
pub fn import(files: &[File], motors: Option<&[String; 2]>, shelf: &dyn Shelf) -> Result<Imported, ImportError> {
    let mut kinds: Vec<Kind> = Vec::new();
    for file in files {
        let wrong = |why: String| ImportError::File { file: file.name.clone(), why };
        if file.text.trim().is_empty() {
            return Err(wrong("the file is empty".to_owned()));
        }
        let kind = Kind::of(&file.text)
            .ok_or_else(|| wrong(format!("not the configuration of a known firmware; {LOOKED_FOR}")))?;
        if let Some(first) = kinds.first().filter(|first| first.name() != kind.name()) {
            let (one, other) = (kind.name(), first.name());
            return Err(wrong(format!(
                "this is {one}, but {} is {other}; pass the files of one machine",
                files[0].name
            )));
        }
        kinds.push(kind);
    }
    match kinds.iter().find(|kind| **kind != Kind::Hal) {
        Some(Kind::LinuxCnc) => {
            let (ini, hal): (Vec<_>, Vec<_>) = files.iter().zip(&kinds).partition(|(_, kind)| **kind == Kind::LinuxCnc);
            let only = |of: Vec<(_, _)>| of.into_iter().map(|(file, _)| file).collect::<Vec<&File>>();
            linuxcnc::read(&only(ini), &only(hal), shelf)
        }
        Some(Kind::Klipper) => klipper::read(files, motors, shelf),
        Some(Kind::RepRap) => reprap::read(files, shelf),
        Some(Kind::Marlin) => marlin::read(files, shelf),
        Some(Kind::Koala) => koala::read(files),
        Some(Kind::MarlinSaid) => said::marlin(alone(files)?),
        Some(Kind::RepRapSaid) => reprap::said(alone(files)?),
        Some(Kind::GrblSaid) => said::grbl(alone(files)?),
        _ => {
            let why = "HAL files alone do not give the axis limits; give the ini that names them".to_owned();
            Err(ImportError::File { file: files.first().map_or_else(String::new, |f| f.name.clone()), why })
        }
    }
}

/// The only file.
fn alone(files: &[File]) -> Result<&File, ImportError> {
    match files {
        [one] => Ok(one),
        [_, more, ..] => {
            let why = "pass what one machine said, as one file".to_owned();
            Err(ImportError::File { file: more.name.clone(), why })
        }
        [] => Err(ImportError::File { file: String::new(), why: "no file".to_owned() }),
    }
}

/// Letters of which by their names (ISO 841) one tilts and one turns a table: A is about X, B about Y, C about Z.
fn by_name(rotary: &[Rotary]) -> Option<AxisRoles> {
    let letters: Vec<char> = rotary.iter().map(|axis| axis.letter).collect();
    match letters[..] {
        [tilt @ ('A' | 'B'), 'C'] | ['C', tilt @ ('A' | 'B')] => {
            let how = format!("by the axis letters (ISO 841): {tilt} rotates about {}, C about Z", about(tilt));
            Some(AxisRoles { tilt, rotation: 'C', about: Some(about(tilt)), how })
        }
        _ => None,
    }
}

fn about(letter: char) -> char {
    if letter == 'B' { 'Y' } else { 'X' }
}

/// What a line of a file does to coordinates, where it switches a correction on that must be off while something is printed.
fn corrects(firmware: Firmware, line: &str, place: &StatedAt) -> Option<String> {
    let mut parsed = ParsedLine::default();
    parsed.read(line.as_bytes()).ok()?;
    let (what, _) = correction(firmware, &parsed).filter(|(_, on)| *on)?;
    let (harm, off) = (what.harm(), what.off(firmware));
    Some(format!("{place}: {} {harm}; put {off} into dialect.start, after whatever may run this line", shown(line)))
}

/// Refuses a machine of fewer than two rotary axes.
fn two(rotary: &[Rotary], place: &StatedAt, seen: &str) -> Result<(), ImportError> {
    let letters: Vec<String> = rotary.iter().map(|axis| axis.letter.to_string()).collect();
    let which = if letters.is_empty() { "none".to_owned() } else { format!("only {}", letters.join(", ")) };
    let why = format!("a table that tilts and turns needs two rotary axes, but this machine has {which} ({seen})");
    if rotary.len() >= 2 { Ok(()) } else { Err(ImportError::At { place: place.clone(), why }) }
}

impl Imported {
    /// The shipped profile that speaks the same words.
    pub fn base(&self) -> &'static str {
        let has = |letter: char| self.rotary.iter().any(|axis| axis.letter == letter);
        match self.firmware {
            "linuxcnc" if has('B') && !has('A') => "linuxcnc-xyzbc-trt",
            "linuxcnc" => "linuxcnc-xyzac-trt",
            "klipper" if has('A') && has('B') => "pentos",
            "klipper" => "fractal-5-pro",
            "reprapfirmware" if has('U') && has('V') && !has('C') => "open5x-prusa",
            "reprapfirmware" if has('B') && !has('A') => "open5x-voron0",
            "reprapfirmware" => "trident-5-axis",
            "grbl" => "grblhal-ac",
            _ if self.facts.iter().any(|fact| fact.key == "link.identity") && has('B') => "penta-trt-bc",
            _ if self.facts.iter().any(|fact| fact.key == "link.identity") => "hendrikjan-5d",
            // Koala's machines all tilt about Y.
            _ if has('B') && !has('A') => "generic-bc",
            _ => "generic-ac",
        }
    }

    /// The letters of the axis that tilts and of the one that turns: as `answered`, else as the files tell; never another machine's.
    ///
    /// # Errors
    ///
    /// [`ImportError::File`] for a letter that no rotary axis has, with those there are.
    pub fn letters(&self, answered: [Option<char>; 2]) -> Result<[Option<char>; 2], ImportError> {
        let told = self.roles.as_ref().map_or([None; 2], |roles| [Some(roles.tilt), Some(roles.rotation)]);
        let letters = [answered[0].or(told[0]), answered[1].or(told[1])];
        for (letter, key) in letters.into_iter().zip(["tilt", "rotation"]) {
            let Some(letter) = letter.filter(|letter| !self.rotary.iter().any(|axis| axis.letter == *letter)) else {
                continue;
            };
            let there: Vec<String> =
                self.rotary.iter().map(|axis| format!("{} ({})", axis.letter, axis.from)).collect();
            let why = format!(
                "rotary axis {letter} not found; the machine has {}; pass --set kinematics.{key}.letter=LETTER",
                there.join(", ")
            );
            return Err(ImportError::File { file: self.rotary[0].from.file.clone(), why });
        }
        Ok(letters)
    }

    /// The profile's start or end code (`key`, `code`), which registers axes `was` in the lines `registered`, with the motors and letters of
    /// this machine; `None` where its firmware has no such names.
    pub fn renamed(&self, key: &str, code: &str, registered: &str, was: [char; 2], letters: [char; 2]) -> Option<Fact> {
        let key = *["dialect.start", "dialect.end"].iter().find(|of| **of == key)?;
        let axis = |letter: char| self.rotary.iter().find(|axis| axis.letter == letter && !axis.motor.is_empty());
        let axes = [axis(letters[0])?, axis(letters[1])?];
        let text = klipper::renamed(code, was, axes, registered, self.by_command)?;
        Some(Fact::new(key, text, axes.map(|axis| axis.from.clone()).to_vec(), ""))
    }

    /// All keys that the files state, with the rotary axes of these letters; those of `answered` are not looked at.
    ///
    /// # Errors
    ///
    /// [`ImportError`] for stops in the wrong order, one stop without the other, and a number that no profile may have.
    pub fn keys(&self, letters: [Option<char>; 2], answered: &dyn Fn(&str) -> bool) -> Result<Vec<Fact>, ImportError> {
        let mut facts = self.facts.clone();
        let axis = |i: usize| letters[i].and_then(|letter| self.rotary.iter().find(|axis| axis.letter == letter));
        let [tilt, rotation] = [axis(0), axis(1)];
        let told = self.roles.as_ref().filter(|roles| letters == [Some(roles.tilt), Some(roles.rotation)]);
        for (axis, keys) in [(tilt, &TILT), (rotation, &ROTATION)] {
            let Some(axis) = axis else { continue };
            let how = told.map_or("", |roles| &roles.how);
            facts.push(Fact::new(keys[0], axis.letter.to_string(), vec![axis.from.clone()], how));
            stops(axis, keys, answered, &mut facts)?;
            facts.extend(axis.rate.iter().map(|rate| Fact::number(keys[3], rate, "")));
        }
        if let (Some((about, how)), Some(axis)) = (told.and_then(|roles| Some((roles.about?, &roles.how))), tilt) {
            facts.push(Fact::new("kinematics.tilt.about", about.to_string(), vec![axis.from.clone()], how));
        }
        let slower = least([tilt, rotation].map(|axis| axis.and_then(|axis| axis.acceleration.as_ref())));
        let both = tilt.zip(rotation).is_some_and(|(a, b)| a.acceleration.is_some() && b.acceleration.is_some());
        facts.extend(
            slower
                .filter(|_| both)
                .map(|s| Fact::number("limits.turn_acceleration_deg_per_s2", &s, "the slower of the two")),
        );
        facts.retain(|fact| !answered(fact.key));
        for fact in &mut facts {
            narrow(fact);
            if fact.key.starts_with("limits.") {
                spans(fact)?;
            }
            check(fact.key, &fact.value).map_err(|out| {
                let place = fact.from.first().cloned().unwrap_or(StatedAt { file: String::new(), line: 0 });
                let why = format!("{out}; if the machine differs from this, pass --set {}=VALUE", fact.key);
                ImportError::At { place, why }
            })?;
        }
        Ok(facts)
    }
}

/// A limit that is wider than any profile's is taken where those end: it allows less than the machine does.
fn narrow(fact: &mut Fact) {
    const WIDE: [&str; 5] = ["_per_min", "_per_s", "_per_s2", "kinematics.tilt.min_deg", "kinematics.tilt.max_deg"];
    let ends = WIDE.iter().any(|end| fact.key.ends_with(end)).then(|| range(fact.key)).flatten();
    let (Some(ends), Some(value)) = (ends, fact.value.as_float()) else { return };
    let taken = if fact.key.ends_with("min_deg") { value.max(*ends.start()) } else { value.min(*ends.end()) };
    if taken != value {
        let gap = if fact.how.is_empty() { "" } else { "; " };
        let most = if taken > value { "at least" } else { "at most" };
        fact.how = format!("{}{gap}the file has {value}, but a profile allows {most} {taken}", fact.how);
        fact.value = taken.into();
    }
}

/// Letter, lowest and highest word, fastest turn.
const TILT: [&str; 4] =
    ["kinematics.tilt.letter", "kinematics.tilt.min_deg", "kinematics.tilt.max_deg", "kinematics.tilt.max_deg_per_s"];
const ROTATION: [&str; 4] = [
    "kinematics.rotation.letter",
    "kinematics.rotation.min_deg",
    "kinematics.rotation.max_deg",
    "kinematics.rotation.max_deg_per_s",
];

fn stops(
    axis: &Rotary,
    keys: &[&'static str; 4],
    answered: &dyn Fn(&str) -> bool,
    facts: &mut Vec<Fact>,
) -> Result<(), ImportError> {
    let (lowest, highest) = (keys[1], keys[2]);
    if let (Some(low), Some(high)) = (&axis.min, &axis.max)
        && !answered(lowest)
        && !answered(highest)
    {
        ordered(&axis.letter.to_string(), low, high)?;
    }
    if let (Some(one), None) | (None, Some(one)) = (&axis.min, &axis.max)
        && keys == &ROTATION
        && !answered(lowest)
        && !answered(highest)
    {
        let why = format!(
            "{} has a limit on one side only; give the other, or both with --set {lowest}=.. and --set {highest}=..",
            axis.letter
        );
        return Err(ImportError::At { place: one.place(), why });
    }
    facts.extend(axis.min.iter().map(|low| Fact::number(lowest, low, "")));
    facts.extend(axis.max.iter().map(|high| Fact::number(highest, high, "")));
    Ok(())
}
