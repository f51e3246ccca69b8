//! Why a file cannot be read or written, with the facts as fields.

use std::io::ErrorKind;
use std::path::PathBuf;

use crate::link::JournalError;
use crate::location::Location;
use crate::slicing::SliceError;

/// Why a file was not read or written.
#[derive(Debug, thiserror::Error, strum::IntoStaticStr)]
#[strum(serialize_all = "kebab-case", prefix = "file/")]
pub enum FileError {
    /// A file that cannot be read.
    #[error("{}: {}", path.display(), in_words(source))]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's words.
        source: std::io::Error,
    },
    /// A file that cannot be written.
    #[error("{}: cannot be written: {}{}", path.display(), in_words(source), remedy(source))]
    Write {
        /// The file.
        path: PathBuf,
        /// The system's words.
        source: std::io::Error,
    },
    /// A pipe or a device might never end.
    #[error("{} is {kind}; give a file name", path.display())]
    NotAFile {
        /// What was to be read.
        path: PathBuf,
        /// What it is.
        kind: &'static str,
    },
    /// A file that could not be held beside what is made of it.
    #[error("{}: {bytes} bytes; at most {most} (4 GiB) are read", path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// Its size.
        bytes: u64,
        /// What is allowed.
        most: u64,
    },
    /// Not UTF-8.
    #[error("{name}: not a text file")]
    NotText {
        /// The file.
        name: String,
    },
    /// An output that is no file.
    #[error("{} is {kind}; give a file name for the output", path.display())]
    NoOutput {
        /// What was to be written.
        path: PathBuf,
        /// What it is.
        kind: &'static str,
    },
    /// An output in a folder that is not there.
    #[error("{}: folder {} does not exist; create it", path.display(), folder.display())]
    NoFolder {
        /// The output.
        path: PathBuf,
        /// Its folder.
        folder: PathBuf,
    },
    /// An output whose owner forbids writing.
    #[error("{} is read-only; change its permissions, or choose another output", path.display())]
    Protected {
        /// The output.
        path: PathBuf,
    },
    /// An output that the same call reads, or writes otherwise.
    #[error("{} is also {what}; choose another output", path.display())]
    Twice {
        /// The output.
        path: PathBuf,
        /// `an input` or `another output`.
        what: &'static str,
    },
    /// A file that is no journal.
    #[error("{}: {source}", path.display())]
    Journal {
        /// The journal.
        path: PathBuf,
        /// What is wrong with it.
        source: JournalError,
    },
}

impl FileError {
    /// Where in what the user gave it is.
    pub fn location(&self) -> Location {
        match self {
            Self::NotText { name } => Location::file(name),
            Self::Read { path, .. }
            | Self::Write { path, .. }
            | Self::NotAFile { path, .. }
            | Self::TooLarge { path, .. }
            | Self::NoOutput { path, .. }
            | Self::NoFolder { path, .. }
            | Self::Protected { path }
            | Self::Twice { path, .. }
            | Self::Journal { path, .. } => Location::path(path),
        }
    }
}

/// Why a slicer was not found.
#[derive(Debug, thiserror::Error)]
pub enum NoSlicer {
    /// Its folder cannot be made.
    #[error(transparent)]
    File(#[from] FileError),
    /// There is none, or not that one.
    #[error(transparent)]
    Slice(#[from] SliceError),
}

/// The system's words without its number, and plainer for what happens every day.
pub fn in_words(source: &std::io::Error) -> String {
    match source.kind() {
        ErrorKind::NotFound => "file not found".to_owned(),
        ErrorKind::PermissionDenied => "permission denied".to_owned(),
        _ => {
            let words = source.to_string();
            words.split(" (os error ").next().unwrap_or_default().to_lowercase()
        }
    }
}

/// What can be done where the system's own words do not say; begins with a semicolon, or is empty.
pub fn remedy(source: &std::io::Error) -> &'static str {
    match source.kind() {
        ErrorKind::StorageFull => "; free some disk space, or choose another disk",
        ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem => {
            "; choose another folder, or change its permissions"
        }
        _ => "",
    }
}
