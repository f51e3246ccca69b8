//! Everything that can go wrong, and the exit code that says so.

use std::path::PathBuf;

use crate::link::ProgramError;
use crate::link::serial::PortError;
use crate::mesh::MeshError;
use crate::planning::{Infeasible, Misplaced, PlanError};
use crate::profile::ProfileError;
use crate::slicing::SliceError;
use crate::toolpath::{RewriteError, SlicedError};

/// Why a verb did not do its work.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Failure {
    /// A file that cannot be read.
    #[error("{}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's words.
        source: std::io::Error,
    },
    /// A file that cannot be written.
    #[error("{}: cannot be written: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// The system's words.
        source: std::io::Error,
    },
    /// Bad words on the command line that clap cannot know of.
    #[error("{0}")]
    Usage(String),
    #[error(transparent)]
    Mesh(#[from] MeshError),
    #[error(transparent)]
    Profile(#[from] ProfileError),
    #[error(transparent)]
    Misplaced(#[from] Misplaced),
    #[error(transparent)]
    Plan(#[from] PlanError),
    #[error(transparent)]
    Infeasible(#[from] Infeasible),
    #[error(transparent)]
    Slice(#[from] SliceError),
    #[error(transparent)]
    Sliced(#[from] SlicedError),
    #[error(transparent)]
    Rewrite(#[from] RewriteError),
    #[error("{}: {source}", path.display())]
    Program {
        /// The file to be sent.
        path: PathBuf,
        /// Why it cannot be.
        source: ProgramError,
    },
    #[error(transparent)]
    Port(#[from] PortError),
    /// The printer or the wire ended the print.
    #[error("{0}")]
    Printer(String),
    /// The work was done and says no.
    #[error("{0}")]
    Findings(String),
}

impl Failure {
    /// 1 for an answer that is no, 3 for a slicer, 4 for printer or wire, 2 for everything that the user gave.
    pub(crate) fn exit_code(&self) -> u8 {
        match self {
            Self::Findings(_) => 1,
            Self::Infeasible(Infeasible::NoPlan { .. } | Infeasible::NoPlace { .. } | Infeasible::Budget { .. }) => 1,
            Self::Slice(error) if error.is_slicer_failure() => 3,
            Self::Port(_) | Self::Printer(_) => 4,
            _ => 2,
        }
    }
}
