//! Why a machine is not described, measured or rehearsed.

use std::path::PathBuf;

use crate::calibrate::{JogFault, TouchError, TowerError, Uncalibrated};
use crate::input::InputError;
use crate::job::printer::PrinterError;
use crate::location::Location;
use crate::profile::{HeadFault, ImportError};
use crate::publish::PublishError;

/// Why a machine is not described, measured or rehearsed.
#[derive(Debug, thiserror::Error, strum::IntoStaticStr)]
#[strum(serialize_all = "kebab-case", prefix = "job/")]
pub enum MachineError {
    /// What is read for it.
    #[error(transparent)]
    Input(InputError),
    /// An invalid answer about a new machine.
    #[error("{what}: {why}")]
    Answer {
        /// The answer, or its file.
        what: String,
        /// What is wrong with it.
        why: String,
    },
    /// A machine with unanswered questions.
    #[error(
        "not answered: {keys}; pass --set KEY=VALUE or --answers FILE, or keep the values of the --like profile with --keep-rest"
    )]
    Unanswered {
        /// The keys.
        keys: String,
    },
    /// A machine that its firmware's files do not describe completely.
    #[error("not in these files: {keys}; pass --set KEY=VALUE or --answers FILE{rest}")]
    Untold {
        /// The keys, each with what is asked.
        keys: String,
        /// What the profile that the machine is like answers of them, as the end of the sentence.
        rest: String,
    },
    /// Files of a firmware that describe no machine.
    #[error(transparent)]
    Import(#[from] ImportError),
    /// An existing file, which is never overwritten.
    #[error("{} already exists and is never overwritten; choose another name or delete it", path.display())]
    There {
        /// The file.
        path: PathBuf,
    },
    /// Touches that are none.
    #[error(transparent)]
    Touches(#[from] TouchError),
    /// Touches that do not determine the machine.
    #[error("{0}")]
    Calibration(Box<Uncalibrated>),
    /// A tower that cannot be made, or measurements of one that cannot be used.
    #[error(transparent)]
    Tower(#[from] TowerError),
    /// A rehearsal on the machine that is not proved clear.
    #[error("no dry run: {why}; leave out --dry-run")]
    NoDryRun {
        /// The pose, and what is in the way.
        why: String,
    },
    /// A printer that cannot be had, or does not answer.
    #[error(transparent)]
    Printer(#[from] PrinterError),
    /// A server that does not tell of its machine.
    #[error(transparent)]
    Server(#[from] PublishError),
    /// A firmware that tells none of its settings over a port.
    #[error(
        "Klipper does not tell its configuration over this port; read it with --host moonraker:URL, or pass printer.cfg to trunnion profile import"
    )]
    Speechless,
    /// A test of the axes that tells nothing.
    #[error(transparent)]
    Jog(#[from] JogFault),
    /// A machine whose table no tip can touch.
    #[error(
        "profile {profile}: no pose within the axis limits lets the nozzle reach the table; check limits, pivot_mm and offset_mm"
    )]
    NoTouches {
        /// The profile.
        profile: String,
    },
}

impl MachineError {
    /// What stands for it in documents, for good.
    pub fn code(&self) -> &'static str {
        match self {
            Self::Input(error) => error.code(),
            Self::Import(error) => error.into(),
            Self::Touches(error) => error.into(),
            Self::Tower(error) => error.into(),
            Self::Printer(error) => error.code(),
            Self::Jog(error) => error.into(),
            Self::Server(error) => (&error.fault).into(),
            own => own.into(),
        }
    }

    /// Where in what the user gave it is.
    pub fn location(&self) -> Option<Location> {
        match self {
            Self::Input(error) => error.location(),
            Self::Import(error) => Some(error.location()),
            Self::Touches(error) => Some(error.location()),
            Self::Tower(error) => error.location(),
            Self::There { path } => Some(Location::path(path)),
            _ => None,
        }
    }
}

impl<E: Into<InputError>> From<E> for MachineError {
    fn from(error: E) -> Self {
        Self::Input(error.into())
    }
}

impl From<HeadFault> for MachineError {
    fn from(HeadFault { what, why }: HeadFault) -> Self {
        Self::Answer { what, why }
    }
}
