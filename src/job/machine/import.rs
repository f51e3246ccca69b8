//! A profile of one's own from the configuration of its firmware, and answers to what no file states.

use std::fmt::Write;
use std::io::BufRead;
use std::path::{Path, PathBuf};

use toml::{Table, Value};

use super::check::check_profile;
use super::error::MachineError;
use super::new::{Answers, QUESTIONS};
use super::new::{SAME_HEAD, fit_name, may_be_named, told};
use crate::gcode::meaning::Firmware;
use crate::input::{LoadedProfile, MachineSource, Source, load_profile};
use crate::profile::{
    Fact, Imported, ImportedFile, Profile, ProfileError, Shelf, StatedAt, import, measured, resolve_over,
};
use crate::world::{FileError, World, in_words};

/// What is asked beside [`QUESTIONS`]: a table that turns the other way round meets the head.
const DIRECTIONS: [(&str, &str); 2] = [
    (
        "kinematics.tilt.direction",
        "1 if a larger tilt word turns the table right-handed about machine +X (a B table: +Y), else -1",
    ),
    ("kinematics.rotation.direction", "1 if a larger rotation word turns the table right-handed about +Z, else -1"),
];
/// What no other machine's profile answers: a table that tilts where another one turns, or turns the other way, meets the head.
pub const REQUIRED_KEYS: [&str; 5] = [
    "kinematics.tilt.letter",
    "kinematics.tilt.about",
    "kinematics.tilt.direction",
    "kinematics.rotation.letter",
    "kinematics.rotation.direction",
];
/// Asked only once it is known which axis tilts: its own lines may say them.
const OF_THE_TILT: [&str; 2] = ["kinematics.tilt.min_deg", "kinematics.tilt.max_deg"];
/// The order of a profile's tables.
const SECTIONS: [&str; 14] = [
    "machine",
    "kinematics",
    "kinematics.tilt",
    "kinematics.rotation",
    "limits",
    "table",
    "head",
    "fixed",
    "dialect",
    "transition",
    "joint",
    "price",
    "process",
    "link",
];
/// What stands first in its table.
const FIRST: [&str; 4] = [".name", ".letter", ".about", ".direction"];
/// A speed that the profile's own travels keep below, as its base has it.
type Travel = fn(&Profile) -> f64;
const TRAVELS: [(&str, Travel); 2] = [
    ("transition.travel_mm_per_min", |p| p.transition.travel_mm_per_min),
    ("transition.z_mm_per_min", |p| p.transition.z_mm_per_min),
];

/// A machine to be described from files.
#[derive(Clone, Debug)]
pub struct ImportProfile {
    /// The firmware's files: LinuxCNC's ini, Klipper's printer.cfg, RepRapFirmware's config.g, Marlin's two, or the machine.json of Koala's simulator; what they name is looked for beside them.
    pub files: Vec<Source>,
    /// Its name; `None` takes the first file's.
    pub name: Option<String>,
    /// What it is like; `None` takes a shipped one of the same firmware.
    pub like: Option<MachineSource>,
    /// What is told beside the files; it goes over what they state.
    pub answers: Answers,
}

/// A machine as its files state it.
#[derive(Clone, Debug)]
pub struct ImportedProfile {
    /// Its name.
    pub name: String,
    /// The whole of it, checked.
    pub profile: Profile,
    /// What it is like.
    pub like: LoadedProfile,
    /// What the files state, as far as no answer goes over it.
    pub facts: Vec<Fact>,
    /// Questions that neither the files nor anybody answered, by their keys.
    pub unanswered: Vec<&'static str>,
    /// What the files say of the axes that no key can say, and what will stop a print.
    pub notes: Vec<String>,
    /// Why `profile check` refuses it; empty where it does not.
    pub refusals: Vec<String>,
    firmware: &'static str,
    /// As it calls itself, or by its name.
    called: String,
    /// Their names, without folders.
    files: String,
    answers: Table,
}

/// The files of the world.
struct Beside<'a>(&'a World<'a>);

impl Shelf for Beside<'_> {
    fn text(&self, path: &Path) -> Result<String, String> {
        let bytes = self.0.files.read(path).map_err(|error| match error {
            FileError::Read { source, .. } => in_words(&source),
            other => other.to_string(),
        })?;
        String::from_utf8(bytes).map_err(|_| "not a text file".to_owned())
    }

    fn names(&self, folder: &Path) -> Vec<String> {
        self.0.files.names_in(folder)
    }
}

/// What files and answers come to, before anything is missing.
struct Known {
    imported: Imported,
    like: LoadedProfile,
    answers: Table,
    facts: Vec<Fact>,
    letters: [Option<char>; 2],
}

impl ImportProfile {
    fn known(&self, world: &World<'_>) -> Result<Known, MachineError> {
        let open = |source: &Source| -> Result<ImportedFile, MachineError> {
            let name = source.name().into_owned();
            Ok(ImportedFile { path: PathBuf::from(&name), text: source.text(world)?, name })
        };
        let files: Vec<ImportedFile> = self.files.iter().map(open).collect::<Result<_, _>>()?;
        let mut answers = self.answers.layer(world)?;
        let motor = |axis: &str| told(&answers, &format!("kinematics.{axis}.stepper")).and_then(Value::as_str);
        let motors =
            motor("tilt").zip(motor("rotation")).map(|(tilt, rotation)| [tilt.to_owned(), rotation.to_owned()]);
        let imported = import(&files, motors.as_ref(), &Beside(world))?;
        let base = self.like.clone().unwrap_or_else(|| imported.base().into());
        let like = load_profile(&base, world)?;
        measured(&mut answers, &as_stated(&like.profile, &imported))?;
        let letter = |key: &str| told(&answers, key).and_then(Value::as_str).and_then(|text| text.chars().next());
        let answered = ["tilt", "rotation"].map(|axis| letter(&format!("kinematics.{axis}.letter")));
        let letters = imported.letters(answered)?;
        let facts = imported.keys(letters, &|key| told(&answers, key).is_some())?;
        Ok(Known { imported, like, answers, facts, letters })
    }

    /// Asks what neither files nor answers say, a line each, until nothing is left; an empty one leaves it as in `like`, but for letters and
    /// directions, which are asked for again. `show` puts the question with the profile that it is like.
    ///
    /// # Errors
    ///
    /// As [`import_profile`], and [`MachineError::Answer`] where the answers end.
    pub fn ask(
        &mut self,
        from: impl BufRead,
        show: impl Fn(&str, &str),
        world: &World<'_>,
    ) -> Result<(), MachineError> {
        let (mut lines, mut asked) = (from.lines(), Vec::new());
        loop {
            let open = self.known(world)?.unanswered();
            let Some((key, question)) = open.into_iter().find(|(key, _)| !asked.contains(key)) else { break };
            let answers = self.answers.set.len();
            self.answers.ask(key, question, &mut lines, &show)?;
            if self.answers.set.len() > answers || !REQUIRED_KEYS.contains(&key) {
                asked.push(key);
            }
        }
        self.answers.rest = true;
        Ok(())
    }

    /// The name that it gets.
    pub fn named(&self) -> String {
        let first = self.files.first().map(|source| source.name().into_owned()).unwrap_or_default();
        let stem = Path::new(&first).file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
        let fit = || stem.chars().map(|c| if may_be_named(c) { c } else { '-' }).collect();
        self.name.clone().unwrap_or_else(fit)
    }
}

impl Known {
    fn unanswered(&self) -> Vec<(&'static str, &'static str)> {
        let stated = |key: &str| self.facts.iter().any(|fact| fact.key == key) || told(&self.answers, key).is_some();
        let later = |key: &str| self.letters[0].is_none() && OF_THE_TILT.contains(&key);
        let all = QUESTIONS.into_iter().chain(DIRECTIONS);
        all.filter(|(key, _)| !stated(key) && !later(key)).collect()
    }

    /// Keys that follow from the files and the profile that the machine is like.
    fn follow(&mut self) {
        for (key, of) in TRAVELS {
            let most = self.imported.most.iter().find(|fact| fact.key == key);
            let slower = most.filter(|fact| fact.value.as_float().is_some_and(|most| most < of(&self.like.profile)));
            self.facts.extend(slower.filter(|_| told(&self.answers, key).is_none()).cloned());
        }
        let [Some(tilt), Some(rotation)] = self.letters else { return };
        let (was, dialect) = (&self.like.profile.kinematics, &self.like.profile.dialect);
        let was = [was.tilt.letter, was.rotation.letter];
        for (key, code) in [("dialect.start", &dialect.start), ("dialect.end", &dialect.end)] {
            let renamed = self.imported.renamed(key, code, &dialect.start, was, [tilt, rotation]);
            let how = format!("as in {}, with this machine's axis letters and stepper names", self.like.name);
            let renamed = renamed.filter(|_| told(&self.answers, key).is_none());
            self.facts.extend(renamed.map(|fact| Fact { how, ..fact }));
        }
    }

    fn notes(&self) -> Vec<String> {
        let mut notes = self.imported.notes.clone();
        let theirs = &self.like.profile.dialect.firmware;
        if Firmware::named(self.imported.firmware).is_some() && theirs != self.imported.firmware {
            notes.push(format!(
                "{} is for {theirs} and this machine runs {}; check [dialect] and [link], or leave out --like",
                self.like.name, self.imported.firmware
            ));
        }
        notes
    }
}

/// The profile that files and answers describe.
///
/// # Errors
///
/// [`MachineError::Import`] for files that describe no machine, [`MachineError::Untold`] for what is in none, [`MachineError::Answer`], and all that a profile
/// may be refused for, with the line of the file that says it.
pub fn import_profile(request: &ImportProfile, world: &World<'_>) -> Result<ImportedProfile, MachineError> {
    let name = request.named();
    fit_name(&name)?;
    let mut known = request.known(world)?;
    let open = known.unanswered();
    let rest = request.answers.rest;
    let needed: Vec<String> = open
        .iter()
        .filter(|(key, _)| !rest || REQUIRED_KEYS.contains(key))
        .map(|(key, question)| format!("{key} ({question})"))
        .collect();
    if !needed.is_empty() {
        let like = &known.like.name;
        let rest = if rest {
            format!(
                "; --keep-rest does not copy axis letters, axes or directions, because {like} is a different machine"
            )
        } else {
            format!(", or keep the other values of {like} with --keep-rest (not axis letters, axes and directions)")
        };
        return Err(MachineError::Untold { keys: needed.join(", "), rest });
    }
    known.follow();
    let files: Vec<String> = request.files.iter().map(|source| file_name(&source.name())).collect();
    let mut done = ImportedProfile {
        name,
        profile: known.like.profile.clone(),
        notes: known.notes(),
        facts: known.facts,
        unanswered: open.iter().map(|(key, _)| *key).collect(),
        refusals: Vec::new(),
        firmware: known.imported.firmware,
        called: known.imported.called.unwrap_or_else(|| request.named()),
        files: files.join(", "),
        answers: known.answers,
        like: known.like,
    };
    // The base's values below, and the answers by themselves, so that what is wrong in them is told as of any file.
    let layers = [
        (done.like.name.clone(), done.like.profile.complete("")),
        ("your answers".to_owned(), done.answers.to_string()),
        (format!("{}.toml", done.name), done.keys()),
    ];
    done.profile = resolve_over(&layers).map_err(|error| placed(error, &done.facts))?.0;
    done.refusals = check_profile(&done.profile.clone().into(), world)?.refusals;
    Ok(done)
}

/// `like` with the head and the reach that the files state: what measures of a head go over.
fn as_stated(like: &Profile, imported: &Imported) -> Profile {
    let mut stated = like.clone();
    let of = |key: &str| imported.facts.iter().find(|fact| fact.key == key).map(|fact| fact.value.clone());
    for (key, ends) in [("limits.x_mm", &mut stated.limits.x_mm), ("limits.y_mm", &mut stated.limits.y_mm)] {
        *ends = of(key).and_then(|value| value.try_into().ok()).unwrap_or(*ends);
    }
    if let Some(pieces) = of("head.body").and_then(|value| value.try_into().ok()) {
        stated.head.body = pieces;
    }
    stated
}

/// What is wrong with a key that the files state, where they state it.
fn placed(error: ProfileError, facts: &[Fact]) -> ProfileError {
    let of = |key: &str| Some(facts.iter().find(|fact| fact.key == key)?.from.first()?.to_string());
    match error {
        ProfileError::Range { place, key, value, allowed } => {
            let place = of(&key).unwrap_or(place);
            ProfileError::Range { place, key, value, allowed }
        }
        other => other,
    }
}

/// Lines as comments show them: of a file its name alone, once for several lines.
fn places(from: &[StatedAt]) -> String {
    let mut out = String::new();
    for (i, place) in from.iter().enumerate() {
        // Several values of one line.
        if i > 0 && from[i - 1] == *place {
            continue;
        }
        if i > 0 && from[i - 1].file == place.file {
            let _ = write!(out, ", {}", place.line);
        } else {
            let gap = if i > 0 { "; " } else { "" };
            let _ = write!(out, "{gap}{}:{}", file_name(&place.file), place.line);
        }
    }
    out
}

fn file_name(path: &str) -> String {
    Path::new(path).file_name().map_or_else(|| path.to_owned(), |name| name.to_string_lossy().into_owned())
}

/// Keys with their values, inner tables taken apart.
fn leaves(table: &Table, prefix: &str, into: &mut Vec<(String, Value)>) {
    for (key, value) in table {
        let path = if prefix.is_empty() { key.clone() } else { format!("{prefix}.{key}") };
        match value {
            Value::Table(inner) => leaves(inner, &path, into),
            _ => into.push((path, value.clone())),
        }
    }
}

impl ImportedProfile {
    /// Its keys as TOML: what the files state and what was answered, each with where it comes from.
    fn keys(&self) -> String {
        let mut rows: Vec<(String, Value, String)> = Vec::new();
        let own = [
            ("machine.name", self.name.clone()),
            ("machine.about", format!("{}, imported from {}", self.called, self.files)),
        ];
        for (key, value) in own.into_iter().filter(|(key, _)| told(&self.answers, key).is_none()) {
            rows.push((key.to_owned(), Value::String(one_line(&value)), String::new()));
        }
        if self.profile.head.measured && self.profile.head.body == self.like.profile.head.body {
            rows.push(("head.measured".to_owned(), Value::Boolean(false), "the other machine's head".to_owned()));
        }
        for fact in &self.facts {
            let how = if fact.how.is_empty() { String::new() } else { format!(": {}", fact.how) };
            rows.push((fact.key.to_owned(), fact.value.clone(), format!("{}{how}", places(&fact.from))));
        }
        let mut answered = Vec::new();
        leaves(&self.answers, "", &mut answered);
        rows.extend(answered.into_iter().map(|(key, value)| (key, value, "your answer".to_owned())));
        let section = |key: &str| key.rsplit_once('.').map_or(String::new(), |(section, _)| section.to_owned());
        let rank = |key: &str| SECTIONS.iter().position(|name| *name == section(key)).unwrap_or(SECTIONS.len());
        let first = |key: &str| FIRST.iter().position(|name| key.ends_with(name)).unwrap_or(FIRST.len());
        rows.sort_by_key(|(key, _, _)| (rank(key), first(key)));
        let (mut out, mut within) = (String::new(), String::new());
        for (key, value, comment) in rows {
            if section(&key) != within {
                within = section(&key);
                let _ = writeln!(out, "\n[{within}]");
            }
            if !comment.is_empty() {
                let _ = writeln!(out, "# {}", one_line(&comment));
            }
            let name = key.rsplit('.').next().unwrap_or_default();
            match value.as_array().filter(|all| all.iter().any(Value::is_table)) {
                // A piece a line.
                Some(pieces) => {
                    let rows: Vec<String> = pieces.iter().map(|piece| format!("    {piece},\n")).collect();
                    let _ = writeln!(out, "{name} = [\n{}]", rows.concat());
                }
                None => {
                    let _ = writeln!(out, "{name} = {value}");
                }
            }
        }
        out
    }

    /// The profile as a file that extends the one that it is like; `kept_in` is the file's folder.
    pub fn text(&self, kept_in: Option<&Path>, world: &World<'_>) -> String {
        let like = &self.like.name;
        let mut heading = format!(
            "{}: created by trunnion profile import from {} ({}), based on {like}.\nComments after # say where each key comes from.\n",
            self.name, self.files, self.firmware
        );
        if !self.unanswered.is_empty() {
            let _ = writeln!(heading, "Not in these files, and taken from {like}: {}.", self.unanswered.join(", "));
        }
        let thick =
            if self.facts.iter().any(|fact| fact.key == "table.thickness_mm") { "" } else { "table.thickness_mm, " };
        let _ = writeln!(
            heading,
            "Such files never state {thick}dialect.start, dialect.end and link.rehome: check them on the machine."
        );
        let _ = writeln!(
            heading,
            "All other keys, such as speeds and [link], are those of {like}: trunnion profile show lists them."
        );
        if self.profile.head == self.like.profile.head {
            heading += SAME_HEAD;
        }
        for note in &self.notes {
            let _ = writeln!(heading, "{}", one_line(note));
        }
        heading += "Then: trunnion profile check, and trunnion profile calibrate (docs/how-to/machine.md).";
        let mut out = String::new();
        for line in heading.lines() {
            let _ = writeln!(out, "# {line}");
        }
        let extends = self.like.reference(kept_in, world).profile;
        let _ = writeln!(out, "extends = {}", Value::String(extends));
        out + &self.keys()
    }

    /// The firmware, as `dialect.firmware` has it.
    pub fn firmware(&self) -> &'static str {
        self.firmware
    }
}

/// Text that may stand in a comment.
fn one_line(text: &str) -> String {
    text.replace(char::is_control, " ")
}
