//! Everything that can go wrong, in the command's words, and the exit code that says so.

use crate::document;
use crate::job::{self, BadSetting, InputError, interrupts};
use crate::publish::BadInput;

/// Why a verb did not do its work.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Failure {
    #[error("{}", in_flags(.0))]
    Job(job::Error),
    /// A result that did not arrive.
    #[error("the result cannot be written to stdout: {}{}", job::in_words(source), job::remedy(source))]
    Stdout {
        /// The system's words.
        source: std::io::Error,
    },
    /// Bad words on the command line that clap cannot know of.
    #[error("{0}")]
    Usage(String),
    /// The work was done and says no.
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

/// A job's error, with the flag that is its remedy.
fn in_flags(error: &job::Error) -> String {
    match error {
        job::Error::Setting(BadSetting::SeveralParts { count }) => format!(
            "--landscape and --view are of one part, and there are {count}; choose one with --part N, or take all as one with \
             --whole"
        ),
        job::Error::Setting(BadSetting::OutOfRange { name: "models", value, allowed, .. }) => {
            format!("{value} models are out of {}..{}; MODEL*3 means three of one", allowed[0], allowed[1])
        }
        job::Error::Setting(bad) => format!("--{bad}"),
        job::Error::PublishInput(bad @ (BadInput::Key { .. } | BadInput::Name { .. })) => bad.to_string(),
        job::Error::PublishInput(bad) => format!("--{bad}"),
        job::Error::Simulation(bad) => format!("--{bad}"),
        job::Error::Log { .. } => format!("--{error}"),
        job::Error::WhichPrint { .. } => format!("{error}, or give --print N"),
        job::Error::Refused { line } => format!("nothing was moved; --yes continues at line {line} as described above"),
        job::Error::Input(InputError::NoModel { .. }) => format!("{error}; say where with --model"),
        other => other.to_string(),
    }
}

impl Failure {
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
