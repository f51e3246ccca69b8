//! Why a print was not begun, or ended before its end.

use std::path::PathBuf;

use crate::input::InputError;
use crate::job::printer::PrinterError;
use crate::link::serial::PortError;
use crate::link::{ProgramError, Unfit};
use crate::location::Location;
use crate::world::in_words;

/// Why a print was not begun, or ended before its end.
#[derive(Debug, thiserror::Error, strum::IntoStaticStr)]
#[strum(serialize_all = "kebab-case", prefix = "job/")]
pub enum SendError {
    /// What is read for it.
    #[error(transparent)]
    Input(InputError),
    /// A printer that cannot be had.
    #[error(transparent)]
    NoPrinter(PrinterError),
    /// Two prints of one call for the same printer.
    #[error("{port}: two prints cannot use one port ({} and {}); give each its own", files[0].display(), files[1].display())]
    SamePort {
        /// The port.
        port: String,
        /// Their files.
        files: [PathBuf; 2],
    },
    /// A thread for each of several prints that the system does not give.
    #[error("cannot start a thread for each print: {}; nothing was sent, print fewer at once", in_words(source))]
    NoThread {
        /// The system's words.
        source: std::io::Error,
    },
    /// A program that cannot be sent line by line.
    #[error("{}: {source}", path.display())]
    Program {
        /// The program.
        path: PathBuf,
        /// Why.
        source: ProgramError,
    },
    /// A program that the printer cannot execute.
    #[error("{}: {unfit}; nothing was sent", path.display())]
    Unfit {
        /// The program.
        path: PathBuf,
        /// What it cannot.
        unfit: Unfit,
    },
    /// No journal where one is looked for.
    #[error(
        "{}: journal not found, so the progress of {} is unknown; pass its path with --journal FILE, or print from the start without --resume",
        path.display(),
        program.display()
    )]
    NoJournal {
        /// Where it was looked for.
        path: PathBuf,
        /// The program.
        program: PathBuf,
    },
    /// A program that is not the one whose print was interrupted.
    #[error(
        "{}: the file changed after the print started, or the journal belongs to another file ({of}, {then} bytes; this one has {now})",
        path.display()
    )]
    ProgramChanged {
        /// The program.
        path: PathBuf,
        /// The program whose journal it is.
        of: String,
        /// Its size when the print began.
        then: u64,
        /// Its size now.
        now: u64,
    },
    /// A machine that is not the one whose print was interrupted.
    #[error("profile {profile} changed after the print started; use the same one")]
    ProfileChanged {
        /// The profile.
        profile: String,
    },
    /// A print that is complete.
    #[error("{}: this print is complete; nothing to resume", path.display())]
    Ended {
        /// The program.
        path: PathBuf,
    },
    /// The operator did not confirm the move.
    #[error("nothing was moved; to continue at line {line} as described above, type yes at a terminal or pass --yes")]
    Refused {
        /// The line of the program.
        line: u32,
    },
    /// The printer, the wire or the operator ended the print.
    #[error("{0}")]
    Printer(String),
}

impl SendError {
    /// What stands for it in documents, for good.
    pub fn code(&self) -> &'static str {
        match self {
            Self::Input(error) => error.code(),
            Self::NoPrinter(error) => error.code(),
            Self::Program { source, .. } => source.into(),
            Self::Unfit { unfit, .. } => unfit.into(),
            own => own.into(),
        }
    }

    /// Where in what the user gave it is.
    pub fn location(&self) -> Option<Location> {
        match self {
            Self::Input(error) => error.location(),
            Self::Program { path, source } => Some(Location { file: Location::path(path).file, ..source.location() }),
            Self::Unfit { path, .. }
            | Self::NoJournal { path, .. }
            | Self::ProgramChanged { path, .. }
            | Self::Ended { path } => Some(Location::path(path)),
            Self::SamePort { .. }
            | Self::NoThread { .. }
            | Self::NoPrinter(_)
            | Self::ProfileChanged { .. }
            | Self::Refused { .. }
            | Self::Printer(_) => None,
        }
    }
}

impl<E: Into<InputError>> From<E> for SendError {
    fn from(error: E) -> Self {
        Self::Input(error.into())
    }
}

impl From<PrinterError> for SendError {
    fn from(error: PrinterError) -> Self {
        match error {
            PrinterError::Input(error) => error.into(),
            error => Self::NoPrinter(error),
        }
    }
}

impl From<PortError> for SendError {
    fn from(error: PortError) -> Self {
        PrinterError::from(error).into()
    }
}
