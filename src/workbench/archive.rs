//! A project as one file: a zip of the command that the page shows, of the models and the profile that it names, and of the plan.
//!
//! `project.json` says what it is, in which version, and has the words of the command: whoever reads it makes its choices out of them and
//! of nothing else, so that a stranger's file can say no more than the page can. Pure: from and into whatever can be read and written.

use std::collections::BTreeSet;
use std::io::{Read, Seek, Write};

use serde_json::{Value, json};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipArchive, ZipWriter};

use super::WorkbenchError;
use super::choices::Choices;
use super::doors::{is_below, shown};

/// What the file says of itself.
const FORMAT: &str = "trunnion project";
/// The newest version of the format that is read, and the one that is written.
const VERSION: u64 = 1;
const MANIFEST: &str = "project.json";
/// The plan of what was prepared.
pub(super) const PLAN: &str = "plan.json";
/// The manifest has a word for each model and choice.
const MOST_MANIFEST: u64 = 1 << 20;
/// Files in a project.
const MOST_MEMBERS: usize = 5_000;
/// As of 3MF files: models pack five to fifty times smaller, nothing but repetitions a thousand times.
const MAX_RATIO: u64 = 200;
/// What any project may unpack to, and no project may exceed.
const UNPACKED: [u64; 2] = [64 << 20, 4 << 30];
const LEVEL: i64 = 2;

/// A project file that is read.
#[derive(Debug)]
pub(super) struct Archive<R> {
    zip: ZipArchive<R>,
    name: String,
    /// What all of it may unpack to, and what of that is left.
    allowed: u64,
    left: u64,
}

impl<R: Read + Seek> Archive<R> {
    /// The file of this name and size, if every name in it is one of a file below its folder.
    ///
    /// # Errors
    ///
    /// [`WorkbenchError::ProjectDamaged`], [`WorkbenchError::ProjectName`] and [`WorkbenchError::ProjectTooLarge`].
    pub(super) fn open(from: R, name: &str, size: u64) -> Result<Self, WorkbenchError> {
        let damaged = |error: &dyn std::fmt::Display| damaged(name, error);
        let zip = ZipArchive::new(from).map_err(|error| damaged(&error))?;
        let allowed = size.saturating_mul(MAX_RATIO).clamp(UNPACKED[0], UNPACKED[1]);
        if zip.len() > MOST_MEMBERS {
            return Err(too_large(name, allowed));
        }
        for member in zip.file_names() {
            let member = member.map_err(|error| damaged(&error))?;
            if !is_below(member.strip_suffix('/').unwrap_or(&member)) {
                return Err(WorkbenchError::ProjectName { project: name.to_owned(), name: shown(&member) });
            }
        }
        Ok(Self { zip, name: name.to_owned(), allowed, left: allowed })
    }

    /// What was chosen, by the names of the files in it.
    ///
    /// # Errors
    ///
    /// [`WorkbenchError::ProjectDamaged`], [`WorkbenchError::ProjectNewer`], [`WorkbenchError::ProjectWord`] and [`WorkbenchError::ProjectMissing`].
    pub(super) fn choices(&mut self) -> Result<Choices, WorkbenchError> {
        let mut text = Vec::new();
        if !self.has(MANIFEST) {
            return Err(damaged(&self.name, &"it has no project.json"));
        }
        self.unpack_within(MANIFEST, MOST_MANIFEST, &mut text)?;
        let manifest: Value =
            serde_json::from_slice(&text).map_err(|error| damaged(&self.name, &format!("project.json: {error}")))?;
        if manifest["format"] != FORMAT {
            return Err(damaged(&self.name, &"project.json is not that of a trunnion project"));
        }
        let version =
            manifest["version"].as_u64().ok_or_else(|| damaged(&self.name, &"project.json has no version"))?;
        if version > VERSION {
            return Err(WorkbenchError::ProjectNewer { project: self.name.clone(), version, known: VERSION });
        }
        let words: Option<Vec<String>> = manifest["command"]
            .as_array()
            .and_then(|all| all.iter().map(|word| word.as_str().map(str::to_owned)).collect());
        let words = words.ok_or_else(|| damaged(&self.name, &"project.json has no command"))?;
        let choices = Choices::of_words(&words)
            .map_err(|word| WorkbenchError::ProjectWord { project: self.name.clone(), word: shown(&word) })?;
        for file in choices.files() {
            if !self.has(file) {
                return Err(WorkbenchError::ProjectMissing { project: self.name.clone(), name: shown(file) });
            }
        }
        Ok(choices)
    }

    /// Whether there is a file of this name in it.
    pub(super) fn has(&self, member: &str) -> bool {
        self.zip.index_for_name(member).is_some()
    }

    /// Unpacks a file.
    ///
    /// # Errors
    ///
    /// [`WorkbenchError::ProjectDamaged`] and [`WorkbenchError::ProjectTooLarge`].
    pub(super) fn unpack(&mut self, member: &str, into: &mut dyn Write) -> Result<(), WorkbenchError> {
        self.unpack_within(member, u64::MAX, into)
    }

    fn unpack_within(&mut self, member: &str, most: u64, into: &mut dyn Write) -> Result<(), WorkbenchError> {
        let failed = |error: &dyn std::fmt::Display| damaged(&self.name, &format!("{}: {error}", shown(member)));
        let most = self.left.min(most);
        let entry = self.zip.by_name(member).map_err(|error| failed(&error))?;
        // An archive may say anything of itself: what comes out is measured as well.
        let over = entry.size() > most;
        let count =
            if over { 0 } else { std::io::copy(&mut entry.take(most + 1), into).map_err(|error| failed(&error))? };
        if over || count > most {
            return Err(too_large(&self.name, self.allowed));
        }
        self.left -= count;
        Ok(())
    }
}

fn damaged(project: &str, reason: &dyn std::fmt::Display) -> WorkbenchError {
    WorkbenchError::ProjectDamaged { project: project.to_owned(), reason: reason.to_string() }
}

fn too_large(project: &str, allowed: u64) -> WorkbenchError {
    WorkbenchError::ProjectTooLarge { project: project.to_owned(), limit_mb: allowed >> 20 }
}

/// A project file that is written: the same bytes for the same project on every day.
pub(super) struct ArchiveWriter<W: Write + Seek> {
    zip: ZipWriter<W>,
    names: BTreeSet<String>,
}

impl<W: Write + Seek> ArchiveWriter<W> {
    /// One of these choices, whose models and machine have the names of the files in it.
    ///
    /// # Errors
    ///
    /// The system's.
    pub(super) fn new(into: W, command: &[String]) -> std::io::Result<Self> {
        let mut writer = Self { zip: ZipWriter::new(into), names: BTreeSet::new() };
        let manifest =
            json!({"format": FORMAT, "version": VERSION, "program": env!("CARGO_PKG_VERSION"), "command": command});
        writer.add(MANIFEST, &mut format!("{manifest:#}\n").as_bytes())?;
        Ok(writer)
    }

    /// Adds a file.
    ///
    /// # Errors
    ///
    /// The system's.
    pub(super) fn add(&mut self, name: &str, from: &mut dyn Read) -> std::io::Result<()> {
        // What is packed already grows by packing.
        let packed = name.to_ascii_lowercase().ends_with(".3mf");
        let options = SimpleFileOptions::default()
            .compression_method(if packed { CompressionMethod::Stored } else { CompressionMethod::Deflated })
            .compression_level((!packed).then_some(LEVEL))
            .last_modified_time(DateTime::default())
            .unix_permissions(0o644)
            .large_file(true);
        if self.names.insert(name.to_owned()) {
            self.zip.start_file(name, options)?;
            std::io::copy(from, &mut self.zip)?;
        }
        Ok(())
    }

    /// The whole file.
    ///
    /// # Errors
    ///
    /// The system's.
    pub(super) fn finish(self) -> std::io::Result<W> {
        Ok(self.zip.finish()?)
    }
}
