//! The files that a job's results are written to: each is claimed before any work, and only what is claimed can be written.
//!
//! A claim refuses what is no file, what the call also reads or writes otherwise, and what could not be written at the end.
//! A write goes beside the file and takes its place as a whole, so that a reader sees the old one or the new one.

use std::any::Any;
use std::fs::{File, Metadata, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use super::FileError;
use super::disk::{kind_of, with_suffix};
use super::leftovers::{WRITING, clear_writing};

/// Called before a file is put in its place; what comes back is dropped when it is there.
type Hold = fn() -> Box<dyn Any>;

/// All that one call reads and writes.
pub struct Outputs {
    inputs: Vec<Spot>,
    claimed: Vec<Spot>,
    hold: Hold,
}

impl Outputs {
    /// Of a call that reads `inputs`.
    pub fn new<'a>(inputs: impl IntoIterator<Item = &'a Path>) -> Self {
        Self { inputs: inputs.into_iter().map(Spot::of).collect(), claimed: Vec::new(), hold: || Box::new(()) }
    }

    /// While a file is put in its place, what `hold` gives is held: a program that ends when it is interrupted waits for that.
    #[must_use]
    pub fn held_by(self, hold: fn() -> Box<dyn Any>) -> Self {
        Self { hold, ..self }
    }

    /// An input that was not known at first.
    ///
    /// # Errors
    ///
    /// [`FileError::Twice`] where it is an output already.
    pub fn reads(&mut self, path: &Path) -> Result<(), FileError> {
        let place = Spot::of(path);
        if let Some(output) = self.claimed.iter().find(|claimed| claimed.is(&place)) {
            return Err(also(&output.shown, "an input"));
        }
        self.inputs.push(place);
        Ok(())
    }

    /// The right to write `path`, `None` where that is an input or another output: for what is written only where it differs.
    ///
    /// # Errors
    ///
    /// As [`Outputs::claim`].
    pub fn claim_unless_taken(&mut self, path: &Path) -> Result<Option<OutputFile>, FileError> {
        match self.claim(path) {
            Err(FileError::Twice { .. }) => Ok(None),
            claimed => Ok(Some(claimed?)),
        }
    }

    /// The right to write `path`.
    ///
    /// # Errors
    ///
    /// [`FileError::NoOutput`], [`FileError::Twice`], [`FileError::NoFolder`], [`FileError::Protected`] and [`FileError::Write`].
    pub fn claim(&mut self, path: &Path) -> Result<OutputFile, FileError> {
        let place = Spot::of(path);
        for (others, what) in [(&self.inputs, "an input"), (&self.claimed, "another output")] {
            if others.iter().any(|other| other.is(&place)) {
                return Err(also(path, what));
            }
        }
        let output = OutputFile { shown: path.to_owned(), target: place.target.clone(), hold: self.hold };
        output.check()?;
        self.claimed.push(place);
        Ok(output)
    }

    /// Makes the folder that outputs go to, if it is not there.
    ///
    /// # Errors
    ///
    /// [`FileError::Write`].
    pub fn folder(&self, path: &Path) -> Result<(), FileError> {
        let failed = |source| FileError::Write { path: path.to_owned(), source };
        if path.is_file() {
            return Err(failed(std::io::Error::other("it is a file, not a folder; choose another name")));
        }
        std::fs::create_dir_all(path).map_err(failed)
    }
}

fn also(path: &Path, what: &'static str) -> FileError {
    FileError::Twice { path: path.to_owned(), what }
}

/// A name, and what it stands for.
struct Spot {
    shown: PathBuf,
    /// Behind all links, also where there is no file yet.
    target: PathBuf,
    identity: Option<(u64, u64)>,
}

impl Spot {
    fn of(path: &Path) -> Self {
        let identity = std::fs::metadata(path).ok().as_ref().and_then(identity);
        Self { shown: path.to_owned(), target: resolved(path), identity }
    }

    /// Whether both are one file, be it under two names.
    fn is(&self, other: &Self) -> bool {
        self.target == other.target || (self.identity.is_some() && self.identity == other.identity)
    }
}

#[cfg(unix)]
fn identity(metadata: &Metadata) -> Option<(u64, u64)> {
    use std::os::unix::fs::MetadataExt;
    Some((metadata.dev(), metadata.ino()))
}

#[cfg(not(unix))]
fn identity(_: &Metadata) -> Option<(u64, u64)> {
    None
}

/// More links than any system follows.
const MOST_LINKS: usize = 40;

/// Where a write to `path` ends: behind its links, the last of which may lead to a file that is not there yet.
fn resolved(path: &Path) -> PathBuf {
    let mut at = path.to_owned();
    for _ in 0..MOST_LINKS {
        let Ok(next) = std::fs::read_link(&at) else { break };
        at = folder_of(&at).join(next);
    }
    let whole = folder_of(&at).canonicalize().ok().zip(at.file_name());
    at.canonicalize().ok().or_else(|| whole.map(|(folder, name)| folder.join(name))).unwrap_or(at)
}

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// A file that may be written.
#[derive(Debug)]
pub struct OutputFile {
    shown: PathBuf,
    target: PathBuf,
    hold: Hold,
}

impl OutputFile {
    /// As the user gave it.
    pub fn path(&self) -> &Path {
        &self.shown
    }

    fn failed(&self, source: std::io::Error) -> FileError {
        FileError::Write { path: self.shown.clone(), source }
    }

    /// Whether it could be written now.
    fn check(&self) -> Result<(), FileError> {
        // The name itself, since /dev/stdout leads to something that has none.
        let there = std::fs::metadata(&self.shown).ok();
        let path = || self.shown.clone();
        if let Some(kind) = there.as_ref().and_then(kind_of) {
            return Err(FileError::NoOutput { path: path(), kind });
        }
        let folder = folder_of(&self.target);
        if !folder.is_dir() {
            return Err(FileError::NoFolder { path: path(), folder: folder.to_owned() });
        }
        if there.is_some_and(|metadata| metadata.permissions().readonly()) {
            return Err(FileError::Protected { path: path() });
        }
        clear_writing(folder);
        // A file without a name: nothing of it stays, however this ends.
        tempfile::tempfile_in(folder).map(drop).map_err(|source| self.failed(source))
    }

    /// The whole of the file, or nothing of it. Mode and owner of a file that is there stay.
    ///
    /// # Errors
    ///
    /// [`FileError::Write`].
    pub fn write(&self, bytes: &[u8]) -> Result<(), FileError> {
        let _held = (self.hold)();
        let whole = || {
            let mut beside = beside(folder_of(&self.target))?;
            // Whoever finds it later, and can lock it, may take it away.
            let _ = beside.as_file().lock();
            beside.write_all(bytes)?;
            keep_rights(beside.as_file(), &self.target)?;
            // A disk may tell only now that it is full.
            beside.as_file().sync_all()?;
            beside.persist(&self.target).map_err(|error| error.error)
        };
        whole().map(drop).map_err(|source| self.failed(source))
    }

    /// Makes an unprintable file of it, at any price: where nothing can be written beside it, what is there is lost.
    ///
    /// # Errors
    ///
    /// [`FileError::Write`].
    pub fn spoil(&self, bytes: &[u8]) -> Result<(), FileError> {
        let over = || OpenOptions::new().write(true).truncate(true).open(&self.target)?.write_all(bytes);
        self.write(bytes).or_else(|_| over().map_err(|source| self.failed(source)))
    }

    /// An empty file, for what is written bit by bit.
    ///
    /// # Errors
    ///
    /// [`FileError::Write`].
    pub fn create(&self) -> Result<File, FileError> {
        File::create(&self.target).map_err(|source| self.failed(source))
    }

    /// Takes what an earlier run left out of the way: `x.gcode` becomes `x.gcode.stale`.
    ///
    /// # Errors
    ///
    /// [`FileError::Write`].
    pub fn set_aside(&self) -> Result<Option<PathBuf>, FileError> {
        if !self.target.is_file() {
            return Ok(None);
        }
        let aside = with_suffix(&self.target, ".stale");
        let moved = std::fs::rename(&self.target, &aside).map_err(|source| self.failed(source));
        moved.map(|()| Some(aside))
    }
}

/// A new file in `folder`, which goes if it is not kept.
fn beside(folder: &Path) -> std::io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(WRITING[0]).suffix(WRITING[1]);
    // The process's own mask is applied to it.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.tempfile_in(folder)
}

fn keep_rights(file: &File, target: &Path) -> std::io::Result<()> {
    let Ok(old) = std::fs::metadata(target) else { return Ok(()) };
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        // Only root may give a file away; for all others it is theirs already, or it becomes so.
        let _ = std::os::unix::fs::fchown(file, Some(old.uid()), Some(old.gid()));
    }
    file.set_permissions(old.permissions())
}
