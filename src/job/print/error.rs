//! Why a program is not made, or not proved.

use crate::input::{CheckedPlan, InputError};
use crate::location::Location;
use crate::slicing::SliceError;
use crate::spelling::counted;
use crate::strategy::{StrategyError, TriedWay};
use crate::toolpath::{RewriteError, SlicedError, TooLarge};
use crate::verify::{Report, Unjudged};
use crate::world::NoSlicer;

/// Why a program is not made, or not proved.
#[derive(Debug, thiserror::Error, strum::IntoStaticStr)]
#[strum(serialize_all = "kebab-case", prefix = "job/")]
pub enum PrintError {
    /// What is read for it.
    #[error(transparent)]
    Input(InputError),
    /// A model that has no way to be printed.
    #[error(transparent)]
    Strategy(StrategyError),
    /// A finished program where a slicer's file was to be.
    #[error("{file} is already a finished program of another plan; slice again, or pass the plan that made it")]
    OtherPlan {
        /// The file.
        file: String,
    },
    /// A file that is not a finished program.
    #[error(
        "{file} was not written by prepare or rewrite (no ;TRUNNION comment with a plan at its head); rewrite the slicer's file first"
    )]
    NotOurs {
        /// The file.
        file: String,
    },
    /// A file that another plan made.
    #[error(
        "{file} was made from the plan with hash {made_by:.12}.., and this one has {given:.12}..; pass the plan that made it"
    )]
    MadeByAnother {
        /// The file.
        file: String,
        /// In the file.
        made_by: String,
        /// Of the plan.
        given: String,
    },
    /// A program in which nothing moves.
    #[error("{file} has no moves, so there is nothing to see; check that it is complete")]
    NoMoves {
        /// The file.
        file: String,
    },
    /// A print that the slicer's bed does not hold.
    #[error("{0}")]
    OffBed(#[from] TooLarge),
    /// The slicer failed.
    #[error(transparent)]
    Slice(#[from] SliceError),
    /// A sliced file that is not understood.
    #[error(transparent)]
    Sliced(#[from] SlicedError),
    /// Sliced files that do not make a program.
    #[error(transparent)]
    Rewrite(#[from] RewriteError),
    /// A sliced file that could be any print of the plan.
    #[error("{file}: cannot tell which print this is; name the file print-NN.., or label objects in the slicer")]
    WhichPrint {
        /// The file.
        file: String,
    },
    /// A program without a plan of which no rule says anything.
    #[error("{file}: {why}")]
    Unjudged {
        /// The file.
        file: String,
        /// Why.
        why: Unjudged,
    },
    /// The program was made, and has findings.
    #[error("{0}")]
    Rejected(Box<Rejected>),
}

impl PrintError {
    /// What stands for it in documents, for good.
    pub fn code(&self) -> &'static str {
        match self {
            Self::Input(error) => error.code(),
            Self::Strategy(error) => error.code(),
            Self::Unjudged { why, .. } => why.into(),
            Self::Slice(error) => error.into(),
            Self::Sliced(error) | Self::Rewrite(RewriteError::Sliced(error)) => error.into(),
            Self::Rewrite(error) => error.into(),
            own => own.into(),
        }
    }

    /// Where in what the user gave it is.
    pub fn location(&self) -> Option<Location> {
        match self {
            Self::Input(error) => error.location(),
            Self::Strategy(error) => error.location(),
            Self::OtherPlan { file }
            | Self::NotOurs { file }
            | Self::MadeByAnother { file, .. }
            | Self::NoMoves { file }
            | Self::Unjudged { file, .. }
            | Self::WhichPrint { file } => Some(Location::file(file)),
            Self::Sliced(error) => Some(error.location()),
            Self::Rewrite(error) => error.location(),
            Self::OffBed(_) | Self::Slice(_) | Self::Rejected(_) => None,
        }
    }
}

impl<E: Into<InputError>> From<E> for PrintError {
    fn from(error: E) -> Self {
        Self::Input(error.into())
    }
}

impl From<StrategyError> for PrintError {
    /// Settings and files are told as the job's own.
    fn from(error: StrategyError) -> Self {
        match error {
            StrategyError::Setting(bad) => bad.into(),
            StrategyError::Input(error) => error.into(),
            error => Self::Strategy(error),
        }
    }
}

impl From<NoSlicer> for PrintError {
    fn from(no: NoSlicer) -> Self {
        match no {
            NoSlicer::File(error) => error.into(),
            NoSlicer::Slice(error) => error.into(),
        }
    }
}

/// A program with findings.
#[derive(Clone, Debug)]
pub struct Rejected {
    /// What was found.
    pub report: Report,
    /// What the replay took.
    pub seconds: f64,
    /// To be looked at; nobody prints it.
    pub(super) program: Vec<u8>,
    /// The plan, where it was made on the way.
    pub(super) plan: Option<CheckedPlan>,
    /// The ways to print the model that came to this, where several were tried.
    pub ways: Vec<TriedWay>,
}

impl std::fmt::Display for Rejected {
    /// The number of findings, and the first.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}", counted(self.report.count(), "finding"))?;
        match self.report.findings.first() {
            Some(first) => write!(f, ": line {}: {}", first.line, first.text),
            None => Ok(()),
        }
    }
}
