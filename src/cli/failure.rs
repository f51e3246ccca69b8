//! Everything that can go wrong, in the command's words, and the exit code that says so.

use super::args::in_flags;
use crate::document;
use crate::job::{self, interrupts};
use crate::location::Location;
use crate::workbench::WorkbenchError;

/// Why a verb did not do its work.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Failure {
    #[error("{}", in_flags(.0))]
    Job(job::Error),
    #[error(transparent)]
    Workbench(WorkbenchError),
    /// A result that could not be written.
    #[error("cannot write the result to stdout: {}{}", job::in_words(source), job::remedy(source))]
    Stdout {
        /// The system's words.
        source: std::io::Error,
    },
    /// Arguments that are wrong in a way that clap cannot see.
    #[error("{0}")]
    Usage(String),
    /// The work was done, and its answer is no.
    #[error("{0}")]
    Findings(String),
    /// Of several prints some have failed.
    #[error("{text}")]
    Prints {
        /// Which, and why.
        text: String,
        /// The exit code of the first.
        code: u8,
    },
    /// Asked to end; what was found until then is written.
    #[error("interrupted; the best so far was kept")]
    Interrupted,
}

impl<E: Into<job::Error>> From<E> for Failure {
    fn from(error: E) -> Self {
        Self::Job(error.into())
    }
}

impl Failure {
    /// What stands for it in documents.
    pub(crate) fn code(&self) -> &'static str {
        match self {
            Self::Job(error) => error.code(),
            Self::Stdout { .. } => "command/stdout",
            Self::Workbench(error) => error.code(),
            Self::Usage(_) => "command/usage",
            Self::Findings(_) => "command/no",
            Self::Prints { .. } => "send/prints",
            Self::Interrupted => "command/interrupted",
        }
    }

    /// Where in what the user gave it is.
    pub(crate) fn location(&self) -> Option<Location> {
        match self {
            Self::Job(error) => error.location(),
            _ => None,
        }
    }

    /// 1 for an answer that is no, 3 for a slicer, 4 for printer or wire, 130 for an interrupt, 2 for everything that the user gave.
    pub(crate) fn exit_code(&self) -> u8 {
        match self {
            Self::Findings(_) => 1,
            Self::Prints { code, .. } => *code,
            Self::Interrupted => interrupts::EXIT_CODE,
            Self::Job(error) => document::exit_code(error),
            _ => 2,
        }
    }
}
