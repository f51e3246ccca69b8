//! A profile of one's own, from answers.

use std::io::BufRead;
use std::path::{Path, PathBuf};

use toml::{Table, Value};

use super::error::MachineError;
use crate::input::{MachineSource, Source, load_profile};
use crate::profile::{HEAD_QUESTIONS, Profile, measured, shipped};
use crate::world::{Outputs, World};

/// What is asked of every machine: key and question.
pub const QUESTIONS: [(&str, &str); 13] = [
    ("dialect.firmware", "firmware: marlin, reprapfirmware, klipper, grbl or linuxcnc"),
    ("kinematics.tilt.letter", "letter of the axis that tilts the table"),
    ("kinematics.tilt.about", "machine axis that it tilts about: X (an A table) or Y (a B table)"),
    ("kinematics.tilt.min_deg", "lowest tilt, degrees"),
    ("kinematics.tilt.max_deg", "highest tilt, degrees"),
    ("kinematics.rotation.letter", "letter of the axis that turns the table"),
    ("limits.x_mm", "where the nozzle may go in X: [lowest, highest], mm"),
    ("limits.y_mm", "where the nozzle may go in Y: [lowest, highest], mm"),
    ("limits.z_mm", "where the nozzle may go in Z: [lowest, highest], mm"),
    ("table.radius_mm", "radius of the round table, mm (for a rectangle: 0, and --set table.size_mm=[x,y])"),
    ("kinematics.pivot_mm", "a point on the tilt axis: [x, y, z], mm, roughly (profile calibrate measures it)"),
    ("kinematics.offset_mm", "from kinematics.pivot_mm to the middle of the level table's surface: [x, y, z], mm"),
    ("process.nozzle_mm", "the nozzle's diameter, mm"),
];

/// A machine to be described.
#[derive(Clone, Debug)]
pub struct NewProfile {
    /// Its name.
    pub name: String,
    /// What it is like.
    pub base: MachineSource,
    /// What is told of it.
    pub answers: Answers,
}

/// What a user tells of a machine.
#[derive(Clone, Debug, Default)]
pub struct Answers {
    /// A file of answers: any keys of a profile.
    pub file: Option<Source>,
    /// Answers: key and value as TOML has it; words may go without quotes. They go over those of the file.
    pub set: Vec<(String, String)>,
    /// Whether what is not answered is as in the profile that the machine is like.
    pub rest: bool,
}

/// A described machine.
#[derive(Clone, Debug)]
pub struct MadeProfile {
    /// It.
    pub profile: Profile,
    /// Its file, with a comment on every key.
    pub text: String,
    /// Questions that were not answered, by their keys.
    pub unanswered: Vec<&'static str>,
}

impl NewProfile {
    /// The questions that are not answered yet.
    ///
    /// # Errors
    ///
    /// What keeps the file of answers from being read.
    pub fn unanswered(&self, world: &World<'_>) -> Result<Vec<(&'static str, &'static str)>, MachineError> {
        let given = self.answers.layer(world)?;
        // Whoever gives the pieces themselves has measured.
        let head = HEAD_QUESTIONS.into_iter().filter(|_| told(&given, "head.body").is_none());
        Ok(QUESTIONS.into_iter().chain(head).filter(|(key, _)| told(&given, key).is_none()).collect())
    }

    /// Asks what is not answered yet, a line each; an empty one leaves it as it is in `base`. `show` puts the question.
    ///
    /// # Errors
    ///
    /// As [`NewProfile::unanswered`], and [`MachineError::Answer`] where the answers end.
    pub fn ask(
        &mut self,
        from: impl BufRead,
        show: impl Fn(&str, &str),
        world: &World<'_>,
    ) -> Result<(), MachineError> {
        let mut lines = from.lines();
        for (key, question) in self.unanswered(world)? {
            self.answers.ask(key, question, &mut lines, &show)?;
        }
        self.answers.rest = true;
        Ok(())
    }
}

/// The answer to `key` among all.
pub(super) fn told<'a>(given: &'a Table, key: &str) -> Option<&'a Value> {
    let (first, rest) = key.split_once('.').map_or((key, None), |(first, rest)| (first, Some(rest)));
    let value = given.get(first)?;
    rest.map_or(Some(value), |rest| told(value.as_table()?, rest))
}

impl Answers {
    /// Asks one question; an empty line leaves it open.
    pub(super) fn ask(
        &mut self,
        key: &str,
        question: &str,
        lines: &mut impl Iterator<Item = std::io::Result<String>>,
        show: &impl Fn(&str, &str),
    ) -> Result<(), MachineError> {
        show(key, question);
        let ended = || MachineError::Answer { what: key.to_owned(), why: "no answer; nothing was written".to_owned() };
        let line = lines.next().and_then(Result::ok).ok_or_else(ended)?;
        if !line.trim().is_empty() {
            self.set.push((key.to_owned(), line.trim().to_owned()));
        }
        Ok(())
    }

    /// All of them as one table.
    pub(super) fn layer(&self, world: &World<'_>) -> Result<Table, MachineError> {
        let mut all = Table::new();
        if let Some(source) = &self.file {
            let (file, text) = (source.name(), source.text(world)?);
            let wrong = |why: String| MachineError::Answer { what: file.clone().into_owned(), why };
            all = text.parse().map_err(|e: toml::de::Error| wrong(e.message().replace('\n', " ")))?;
            if all.contains_key("extends") {
                return Err(wrong("answers cannot extend a profile; name a similar profile with --like".to_owned()));
            }
        }
        for (key, value) in &self.set {
            let why = match key.split('.').all(is_name) {
                true => "a shorter key already has a value; remove one of the two",
                false => "a key must be names separated by dots, for example kinematics.tilt.max_deg",
            };
            let wrong = || MachineError::Answer { what: format!("{key}={value}"), why: why.to_owned() };
            insert(&mut all, key, answer(value)).ok_or_else(wrong)?;
        }
        Ok(all)
    }
}

/// A value as TOML has it, else a word.
fn answer(text: &str) -> Value {
    let line = format!("value = {text}").parse::<Table>().ok();
    let value = line.filter(|table| table.len() == 1).and_then(|mut table| table.remove("value"));
    value.unwrap_or_else(|| Value::String(text.to_owned()))
}

/// Writes a new profile to `place`, else under its name into the user's own folder, made if it is not there; `text` is given the file's
/// folder. Gives back the file.
///
/// # Errors
///
/// [`MachineError::Answer`] where nobody knows a home, [`MachineError::There`] for a file that is there, and what keeps it from being written.
pub fn keep_profile(
    name: &str,
    place: Option<&Path>,
    outputs: &mut Outputs,
    text: impl FnOnce(&Path) -> String,
    world: &World<'_>,
) -> Result<PathBuf, MachineError> {
    let own = || -> Result<PathBuf, MachineError> {
        let folder = world.files.own_profiles().ok_or_else(|| MachineError::Answer {
            what: name.to_owned(),
            why: "XDG_CONFIG_HOME and HOME are not set, so there is no folder for profiles; give a file with -o"
                .to_owned(),
        })?;
        outputs.folder(&folder)?;
        Ok(folder.join(format!("{name}.toml")))
    };
    let place = place.map_or_else(own, |place| Ok(place.to_owned()))?;
    if world.files.exists(&place) {
        return Err(MachineError::There { path: place });
    }
    outputs.claim(&place)?.write(text(place.parent().unwrap_or(Path::new(""))).as_bytes())?;
    Ok(place)
}

/// Whether a key may have this as one of the names between its dots.
fn is_name(name: &str) -> bool {
    !name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
}

fn insert(into: &mut Table, key: &str, value: Value) -> Option<()> {
    match key.split_once('.') {
        None if is_name(key) => {
            into.insert(key.to_owned(), value);
            Some(())
        }
        Some((first, rest)) if is_name(first) => {
            let inner = into.entry(first).or_insert_with(|| Value::Table(Table::new()));
            insert(inner.as_table_mut()?, rest, value)
        }
        _ => None,
    }
}

/// Said at the head of a profile whose head is another's.
pub(super) const SAME_HEAD: &str =
    "The head ([[head.body]]) is that profile's: measure yours, or collisions cannot be ruled out.\n";

/// What names of own profiles are made of.
pub(super) fn may_be_named(c: char) -> bool {
    c.is_ascii_alphanumeric() || "-_".contains(c)
}

/// Refuses a name that no own profile may have.
pub(super) fn fit_name(name: &str) -> Result<(), MachineError> {
    if name.is_empty() || !name.chars().all(may_be_named) || shipped(name).is_ok() {
        let why = "use only letters, digits, - and _, and not the name of a shipped profile".to_owned();
        return Err(MachineError::Answer { what: name.to_owned(), why });
    }
    Ok(())
}

/// The profile of all answers.
///
/// # Errors
///
/// [`MachineError::Unanswered`], [`MachineError::Answer`], and all that a profile may be refused for.
pub fn new_profile(request: &NewProfile, world: &World<'_>) -> Result<MadeProfile, MachineError> {
    let name = &request.name;
    fit_name(name)?;
    let unanswered: Vec<&str> = request.unanswered(world)?.into_iter().map(|(key, _)| key).collect();
    if !unanswered.is_empty() && !request.answers.rest {
        return Err(MachineError::Unanswered { keys: unanswered.join(", ") });
    }
    let base = load_profile(&request.base, world)?;
    let mut layer = request.answers.layer(world)?;
    measured(&mut layer, &base.profile)?;
    insert(&mut layer, "machine.name", Value::String(name.clone()));
    // The base's values below, so that an unknown key and a wrong value are told as of any file.
    let below = base.profile.complete("");
    let layers = [(base.name.clone(), below), ("your answers".to_owned(), layer.to_string())];
    let (mut profile, _) = crate::profile::resolve_over(&layers)?;
    // Another machine's head was measured there.
    profile.head.measured &= profile.head.body != base.profile.head.body || told(&layer, "head.measured").is_some();
    let mut heading = format!("{name}: created by trunnion profile new, based on {}.\n", base.name);
    if !unanswered.is_empty() {
        heading += &format!("Not answered, so copied from {}: {}.\n", base.name, unanswered.join(", "));
    }
    if profile.head == base.profile.head {
        heading += SAME_HEAD;
    }
    heading += "Then: trunnion profile check, and trunnion profile calibrate (docs/how-to/machine.md).";
    let text = profile.complete(&heading);
    Ok(MadeProfile { profile, text, unanswered })
}
