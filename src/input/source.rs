//! Where a request's inputs come from: files by name, bytes already in hand, machines by name or value.

use std::borrow::Cow;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use super::{InputError, memory};
use crate::mesh::{ProjectPlates, Repair, Unit};
use crate::profile::Profile;
use crate::spelling::nearest;
use crate::world::{FileError, World};

/// A file, or what would be in one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Source {
    /// To be read.
    File(PathBuf),
    /// In hand.
    Bytes {
        /// What messages call it; its ending tells the format where the content does not.
        name: String,
        /// The content.
        bytes: Vec<u8>,
    },
}

impl Source {
    /// As messages call it.
    pub fn name(&self) -> Cow<'_, str> {
        match self {
            Self::File(path) => path.to_string_lossy(),
            Self::Bytes { name, .. } => Cow::Borrowed(name),
        }
    }

    /// The file, where it is one.
    pub fn path(&self) -> Option<&Path> {
        match self {
            Self::File(path) => Some(path),
            Self::Bytes { .. } => None,
        }
    }

    pub(crate) fn bytes(&self, world: &World<'_>) -> Result<Cow<'_, [u8]>, InputError> {
        match self {
            Self::File(path) => {
                let absent = |error| missing(path, error, world);
                if world.memory.is_some() {
                    memory::of_file(&self.name(), world.files.size(path).map_err(absent)?, world)?;
                }
                Ok(Cow::Owned(world.files.read(path).map_err(absent)?))
            }
            Self::Bytes { bytes, .. } => Ok(Cow::Borrowed(bytes)),
        }
    }

    /// The bytes of a program that is to be followed.
    pub(crate) fn program(&self, world: &World<'_>) -> Result<Cow<'_, [u8]>, InputError> {
        let bytes = self.bytes(world)?;
        memory::of_program(&self.name(), &bytes, world)?;
        Ok(bytes)
    }

    pub(crate) fn text(&self, world: &World<'_>) -> Result<String, InputError> {
        let text = String::from_utf8(self.bytes(world)?.into_owned());
        Ok(text.map_err(|_| FileError::NotText { name: self.name().into_owned() })?)
    }
}

/// Most letters by which a name that is there differs from the one that was meant.
const MOST_EDITS: usize = 2;

/// Why a file is not read: for one that is not there, with the name that may be meant.
pub(crate) fn missing(path: &Path, error: FileError, world: &World<'_>) -> InputError {
    let FileError::Read { source, .. } = &error else { return error.into() };
    if source.kind() != ErrorKind::NotFound {
        return error.into();
    }
    let file = path.to_string_lossy().into_owned();
    if file.split_once("://").is_some_and(|(scheme, _)| ["http", "https", "ftp", "file"].contains(&scheme)) {
        return InputError::Address { address: file };
    }
    InputError::Absent { file, near: near_file(path, world, |_| true) }
}

/// The file beside `path` whose name is near to its own, among those whose names are `right`; `None` where there is none.
pub(super) fn near_file(path: &Path, world: &World<'_>, right: impl Fn(&str) -> bool) -> Option<String> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let names = world.files.names_in(folder);
    let wanted = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let (edits, name) = nearest(&wanted, names.iter().map(String::as_str).filter(|name| right(name)))?;
    (edits <= MOST_EDITS).then(|| path.with_file_name(name).to_string_lossy().into_owned())
}

impl<P: AsRef<Path> + ?Sized> From<&P> for Source {
    fn from(path: &P) -> Self {
        Self::File(path.as_ref().to_owned())
    }
}

/// A model, and how to read it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ModelSource {
    /// STL, OBJ, 3MF or OFF with one or several closed parts.
    pub source: Source,
    /// Unit of its numbers; `None` takes the file's own word, else guesses by size.
    pub unit: Option<Unit>,
    /// What becomes of flipped and doubled facets, cracks, sides that others' corners lie on, and small holes.
    pub repair: Repair,
    /// Which plates of a project.
    pub plates: ProjectPlates,
}

impl<S: Into<Source>> From<S> for ModelSource {
    fn from(source: S) -> Self {
        Self { source: source.into(), unit: None, repair: Repair::Auto, plates: ProjectPlates::Only }
    }
}

/// A machine's profile.
#[derive(Clone, Debug, PartialEq)]
pub enum MachineSource {
    /// Shipped under this name.
    Shipped(String),
    /// A TOML file.
    Toml(Source),
    /// In hand; held to the ranges of files.
    Profile(Box<Profile>),
}

impl MachineSource {
    /// The file that is read for it.
    pub fn path(&self) -> Option<&Path> {
        if let Self::Toml(source) = self { source.path() } else { None }
    }
}

impl From<Profile> for MachineSource {
    fn from(profile: Profile) -> Self {
        Self::Profile(Box::new(profile))
    }
}

impl From<&str> for MachineSource {
    /// A file where the word looks like a path (or ends with `.toml`), else a shipped name.
    fn from(word: &str) -> Self {
        if word.ends_with(".toml") || word.contains(['/', '\\']) {
            Self::Toml(Source::from(word))
        } else {
            Self::Shipped(word.to_owned())
        }
    }
}
