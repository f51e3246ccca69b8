//! What is common to all firmwares: lines of files, numbers with the lines they come from, keys of a profile, and why files are refused.

use crate::location::Location;
use crate::profile::ranges::check_number;
use std::path::{Component, Path, PathBuf};

use toml::Value;

/// Files that one configuration may consist of.
const MOST_FILES: usize = 200;
/// A corner of 90 degrees passed at v mm/s, accelerating by a mm/s², has the junction deviation v² / a times this.
pub(super) const CORNER: f64 = std::f64::consts::SQRT_2 - 1.0;
/// Of a line as much as a message shows, characters.
const SHOWN: usize = 60;

/// A line of a file, counted from 1.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StatedAt {
    /// The file, as given or as another file names it.
    pub file: String,
    /// The line.
    pub line: usize,
}

impl std::fmt::Display for StatedAt {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}:{}", self.file, self.line)
    }
}

/// Why files describe no machine.
#[derive(Debug, PartialEq, Eq, thiserror::Error, strum::IntoStaticStr)]
#[strum(serialize_all = "kebab-case", prefix = "import/")]
pub enum ImportError {
    /// A line that cannot be taken as it stands.
    #[error("{place}: {why}")]
    At {
        /// Where.
        place: StatedAt,
        /// What is wrong, and what helps.
        why: String,
    },
    /// Two lines of which only one can be right.
    #[error("{}: {} is {} here, but {} in {}; remove one of the two lines", .0.second, .0.what, .0.other, .0.one, .0.first)]
    Contradiction(Box<Contradiction>),
    /// A file of another kind, or files of several machines.
    #[error("{file}: {why}")]
    File {
        /// The file.
        file: String,
        /// What is wrong, and what helps.
        why: String,
    },
}

impl ImportError {
    /// Where in what the user gave it is.
    pub fn location(&self) -> Location {
        let at = |place: &StatedAt| Location::file(&place.file).line(place.line as u64);
        match self {
            Self::At { place, .. } => at(place),
            Self::Contradiction(lines) => at(&lines.second).word(&lines.other),
            Self::File { file, .. } => Location::file(file),
        }
    }
}

/// Two lines of which only one can be right.
#[derive(Debug, PartialEq, Eq)]
pub struct Contradiction {
    /// What they say.
    pub what: String,
    /// The line that was read first.
    pub first: StatedAt,
    /// Its words.
    pub one: String,
    /// The other line.
    pub second: StatedAt,
    /// Its words.
    pub other: String,
}

impl From<Contradiction> for ImportError {
    fn from(lines: Contradiction) -> Self {
        Self::Contradiction(Box::new(lines))
    }
}

/// A number of the files, in the profile's units.
#[derive(Clone, Debug, PartialEq)]
pub struct Stated {
    /// The number.
    pub value: f64,
    /// The lines that say it.
    pub from: Vec<StatedAt>,
}

impl Stated {
    /// The first line.
    pub(super) fn place(&self) -> StatedAt {
        self.from.first().cloned().unwrap_or(StatedAt { file: String::new(), line: 0 })
    }
}

/// A key of a profile that files state.
#[derive(Clone, Debug, PartialEq)]
pub struct Fact {
    /// Its path.
    pub key: &'static str,
    /// Its value.
    pub value: Value,
    /// The lines that say it.
    pub from: Vec<StatedAt>,
    /// How it follows from them, where it is not simply written there; else empty.
    pub how: String,
}

impl Fact {
    pub(super) fn new(key: &'static str, value: impl Into<Value>, from: Vec<StatedAt>, how: &str) -> Self {
        Self { key, value: value.into(), from, how: how.to_owned() }
    }

    pub(super) fn number(key: &'static str, stated: &Stated, how: &str) -> Self {
        Self::new(key, stated.value, stated.from.clone(), how)
    }
}

/// A rotary axis.
#[derive(Clone, Debug)]
pub struct Rotary {
    /// The letter of its words.
    pub letter: char,
    /// Lowest word, degrees.
    pub min: Option<Stated>,
    /// Highest word, degrees.
    pub max: Option<Stated>,
    /// Fastest turn, degrees a second.
    pub rate: Option<Stated>,
    /// How fast that changes, degrees a second and second.
    pub acceleration: Option<Stated>,
    /// Where it is made an axis.
    pub from: StatedAt,
    /// The firmware's own name of its motor, where it has one.
    pub motor: String,
}

/// How files that others name are had.
pub trait Shelf {
    /// The text of a file, or why there is none, in words.
    ///
    /// # Errors
    ///
    /// The words.
    fn text(&self, path: &Path) -> Result<String, String>;

    /// The names of the files in a folder, in order.
    fn names(&self, folder: &Path) -> Vec<String>;
}

/// A file as given.
#[derive(Clone, Debug)]
pub struct File {
    /// Its path; empty where it is none.
    pub path: PathBuf,
    /// What messages call it.
    pub name: String,
    /// What is in it.
    pub text: String,
}

impl File {
    /// A line of it.
    pub(super) fn place(&self, line: usize) -> StatedAt {
        StatedAt { file: self.name.clone(), line }
    }

    /// Its lines with their places.
    pub(super) fn lines(&self) -> impl Iterator<Item = (StatedAt, &str)> {
        self.text.lines().enumerate().map(|(i, line)| (self.place(i + 1), line))
    }

    /// The path that it names, from its own folder.
    pub(super) fn beside(&self, named: &str) -> PathBuf {
        self.path.parent().unwrap_or(Path::new("")).join(named)
    }
}

/// Files that are being read, each named by a line of the one before.
pub(super) struct Open<'a> {
    pub(super) shelf: &'a dyn Shelf,
    stack: Vec<PathBuf>,
    count: usize,
}

impl<'a> Open<'a> {
    pub(super) fn new(shelf: &'a dyn Shelf) -> Self {
        Self { shelf, stack: Vec::new(), count: 0 }
    }

    /// Reads the files that were given, one after the other, and through `read` those that they name.
    pub(super) fn each(
        files: &[File],
        shelf: &'a dyn Shelf,
        mut read: impl FnMut(&File, &mut Self) -> Result<(), ImportError>,
    ) -> Result<(), ImportError> {
        let mut open = Self::new(shelf);
        for file in files {
            open.enter(file);
            read(file, &mut open)?;
            open.leave();
        }
        Ok(())
    }

    /// Goes into a file that was given.
    pub(super) fn enter(&mut self, file: &File) {
        self.stack.push(plain(&file.path));
    }

    /// Goes into the file at `path` that the line at `from` names.
    pub(super) fn named(&mut self, path: PathBuf, from: &StatedAt, missing: &str) -> Result<File, ImportError> {
        let wrong = |why: String| ImportError::At { place: from.clone(), why };
        self.count += 1;
        let path = plain(&path);
        if self.stack.contains(&path) {
            return Err(wrong(format!(
                "{} includes itself, directly or through other files; remove this include",
                path.display()
            )));
        }
        if self.count > MOST_FILES {
            return Err(wrong(format!(
                "more than {MOST_FILES} files are included; pass only those that describe the axes"
            )));
        }
        let text = self.shelf.text(&path).map_err(|why| wrong(format!("{}: {why}; {missing}", path.display())))?;
        let name = path.to_string_lossy().into_owned();
        self.stack.push(path.clone());
        Ok(File { path, name, text })
    }

    pub(super) fn leave(&mut self) {
        self.stack.pop();
    }
}

/// The same path without `.` and, where that can be told, without `..`.
fn plain(path: &Path) -> PathBuf {
    let mut out = PathBuf::new();
    for part in path.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir if out.file_name().is_some() => {
                out.pop();
            }
            other => out.push(other),
        }
    }
    out
}

/// A piece of a line as messages show it.
pub(super) fn shown(text: &str) -> String {
    let short: String = text.chars().take(SHOWN).collect();
    let dots = if short.len() < text.len() { ".." } else { "" };
    format!("{short:?}{dots}")
}

/// The number that `text` is.
pub(super) fn number(what: &str, text: &str, place: &StatedAt) -> Result<f64, ImportError> {
    match text.trim().parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err(ImportError::At {
            place: place.clone(),
            why: format!("{what} must be a finite number, got {}", shown(text)),
        }),
    }
}

/// A number in the profile's unit, without what the change of units leaves behind the sixth place.
pub(super) fn scaled(value: f64, factor: f64) -> f64 {
    if factor == 1.0 { value } else { (value * factor * 1e6).round() / 1e6 + 0.0 }
}

/// What of two statements on one thing holds; the same number twice is one.
pub(super) fn same(what: &str, first: &Stated, second: &Stated) -> Result<(), ImportError> {
    if first.value == second.value {
        return Ok(());
    }
    Err(Contradiction {
        what: what.to_owned(),
        first: first.place(),
        one: first.value.to_string(),
        second: second.place(),
        other: second.value.to_string(),
    }
    .into())
}

/// `limits.x_mm` and the like of two ends; whether they are in order is asked once it is known that no answer goes over them.
pub(super) fn span(key: &'static str, low: &Stated, high: &Stated, how: &str) -> Fact {
    let ends = Value::Array(vec![low.value.into(), high.value.into()]);
    Fact::new(key, ends, [&low.from[..], &high.from[..]].concat(), how)
}

/// Refuses two ends that are not in order.
pub(super) fn spans(fact: &Fact) -> Result<(), ImportError> {
    let axis = fact.key.trim_start_matches("limits.").trim_end_matches("_mm").to_uppercase();
    match fact.value.as_array().map(|ends| ends.iter().filter_map(Value::as_float).collect::<Vec<f64>>()).as_deref() {
        Some(&[low, high]) => {
            let of = |value: f64, from: Option<&StatedAt>| Stated { value, from: from.cloned().into_iter().collect() };
            ordered(&axis, &of(low, fact.from.first()), &of(high, fact.from.last()))
        }
        _ => Ok(()),
    }
}

/// Refuses a lowest end above the highest.
pub(super) fn ordered(axis: &str, low: &Stated, high: &Stated) -> Result<(), ImportError> {
    if low.value < high.value {
        return Ok(());
    }
    let why = format!(
        "{axis} goes from {} ({}) to {}: the lowest end must be below the highest; they may be swapped",
        low.value,
        low.place(),
        high.value
    );
    Err(ImportError::At { place: high.place(), why })
}

/// `limits.junction_mm`, where a profile may have it; else why not, as a note.
pub(super) fn junction(stated: &Stated, how: &str, facts: &mut Vec<Fact>, notes: &mut Vec<String>) {
    match check_number("limits.junction_mm", stated.value) {
        Ok(()) => facts.push(Fact::number("limits.junction_mm", stated, how)),
        Err(out) => {
            let why = if how.is_empty() { String::new() } else { format!(" ({how})") };
            notes.push(format!("{}: {out}, so it is not imported{why}", stated.place()));
        }
    }
}

/// The fastest of X and Y, and what travels and Z may be at most: mm a minute.
pub(super) fn feeds(xy: Option<Stated>, z: Option<Stated>, how: &str, facts: &mut Vec<Fact>) -> Vec<Fact> {
    facts.extend(xy.iter().map(|feed| Fact::number("limits.max_feed_mm_per_min", feed, how)));
    let travel = xy.map(|feed| Fact::number("transition.travel_mm_per_min", &feed, "lowered to the slower of X and Y"));
    let z = z.map(|z| Fact::number("transition.z_mm_per_min", &z, "lowered to the maximum speed of Z"));
    travel.into_iter().chain(z).collect()
}

/// The lesser of what is stated.
pub(super) fn least<'a>(of: impl IntoIterator<Item = Option<&'a Stated>>) -> Option<Stated> {
    of.into_iter().flatten().min_by(|a, b| a.value.total_cmp(&b.value)).cloned()
}
