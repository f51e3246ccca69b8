//! Why a job was not done, with the facts as fields.

use std::path::PathBuf;

use super::{BadSetting, BadSimulation, Rejected};
use crate::input::InputError;
use crate::link::serial::PortError;
use crate::link::{ProgramError, Unfit};
use crate::mesh::MeshError;
use crate::profile::{ImportError, ProfileError};
use crate::publish::{BadInput, PublishError};
use crate::slicing::SliceError;
use crate::strategy;
use crate::toolpath::{RewriteError, SlicedError, TooLarge};
use crate::world::{FileError, NoSlicer};

/// Why a job was not done.
#[derive(Debug, thiserror::Error, strum::IntoStaticStr)]
#[strum(serialize_all = "kebab-case", prefix = "job/")]
pub enum Error {
    /// A model, a profile or a plan that is not read.
    #[error(transparent)]
    Input(InputError),
    /// A model that has no way to be printed.
    #[error(transparent)]
    Strategy(strategy::Error),
    /// A file that is not read or written.
    #[error(transparent)]
    File(#[from] FileError),
    /// Two prints of one call for the same printer.
    #[error("{port}: two prints cannot use one port ({} and {}); give each its own", files[0].display(), files[1].display())]
    SamePort {
        /// The port.
        port: String,
        /// Their files.
        files: [PathBuf; 2],
    },
    /// A finished program where a slicer's file was to be.
    #[error("{file} is already a finished program of another plan; slice again, or pass the plan that made it")]
    OtherPlan {
        /// The file.
        file: String,
    },
    /// A file that is not a finished program.
    #[error(
        "{file} was not written by prepare or rewrite (no ;TRUNNION mark with a plan at its head); rewrite the slicer's file first"
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
    /// A setting of a request that cannot be.
    #[error(transparent)]
    Setting(#[from] BadSetting),
    /// What cannot be packed.
    #[error(transparent)]
    Packing(#[from] super::BadPacking),
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
        "not answered: {keys}; pass --set KEY=VALUE or --answers FILE, or keep the other profile's values with --keep-rest"
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
    Touches(#[from] crate::calibrate::TouchError),
    /// Touches that do not determine the machine.
    #[error("{0}")]
    Calibration(Box<super::Uncalibrated>),
    /// A rehearsal on the machine that is not proved clear.
    #[error("no dry run: {why}; leave out --dry-run")]
    NoDryRun {
        /// The pose, and what is in the way.
        why: String,
    },
    /// A machine whose table no tip can touch.
    #[error(
        "profile {profile}: no pose within the axis limits lets the nozzle reach the table; check limits, pivot_mm and offset_mm"
    )]
    NoTouches {
        /// The profile.
        profile: String,
    },
    /// A simulated printer that cannot be.
    #[error(transparent)]
    Simulation(#[from] BadSimulation),
    /// An open surface where an objective is a volume or needs an inside.
    #[error("{source}; {objective} needs a volume or an inside, so the mesh must be closed")]
    NeedsClosed {
        /// Where it is open.
        source: Box<MeshError>,
        /// The objective.
        objective: String,
    },
    /// A part of which no direction is better than another.
    #[error(
        "part {part}: none of its {facets} facets has an area, so all directions are equal; export the model again"
    )]
    NoArea {
        /// The part.
        part: usize,
        /// Its facets.
        facets: usize,
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
    /// A profile whose printer cannot be streamed to.
    #[error("profile {profile}: [link] protocol {protocol:?} cannot be streamed; use marlin, rrf, klipper or grbl")]
    Protocol {
        /// The profile.
        profile: String,
        /// As it says.
        protocol: String,
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
    /// A place where no host can connect.
    #[error("{link}: {source}")]
    Link {
        /// The place.
        link: String,
        /// The system's words.
        source: std::io::Error,
    },
    /// A simulated printer's log that cannot be written.
    #[error("log: {source}")]
    Log {
        /// The system's words.
        source: std::io::Error,
    },
    /// A port that cannot be had.
    #[error(transparent)]
    Port(#[from] PortError),
    /// A folder or a list without a model.
    #[error("{}: no models found; a model ends in .stl, .obj, .3mf or .off", path.display())]
    NoModels {
        /// The folder or list.
        path: PathBuf,
    },
    /// A server, a key or a name that cannot be.
    #[error(transparent)]
    PublishInput(#[from] BadInput),
    /// A server that does not take a program.
    #[error(transparent)]
    Publish(#[from] PublishError),
    /// The printer, the wire or the operator ended the print.
    #[error("{0}")]
    Printer(String),
    /// The program was made, and has findings.
    #[error("{0}")]
    Rejected(Box<Rejected>),
}

impl Error {
    /// What stands for it in documents, for good, as `slice/timeout`: `trunnion explain` says what each means.
    pub fn code(&self) -> &'static str {
        match self {
            Self::Input(error) => error.code(),
            Self::Strategy(error) => error.code(),
            Self::File(error) => error.into(),
            Self::Setting(error) => error.into(),
            Self::Packing(error) => error.into(),
            Self::Import(error) => error.into(),
            Self::Touches(error) => error.into(),
            Self::Simulation(error) => error.into(),
            Self::Slice(error) => error.into(),
            Self::Sliced(error) | Self::Rewrite(RewriteError::Sliced(error)) => error.into(),
            Self::Rewrite(error) => error.into(),
            Self::Program { source, .. } => source.into(),
            Self::Unfit { unfit, .. } => unfit.into(),
            Self::Port(error) => error.into(),
            Self::PublishInput(error) => error.into(),
            Self::Publish(error) => (&error.fault).into(),
            own => own.into(),
        }
    }
}

impl From<InputError> for Error {
    /// Settings and files are told as the job's own.
    fn from(error: InputError) -> Self {
        match error {
            InputError::Setting(bad) => bad.into(),
            InputError::File(error) => error.into(),
            error => Self::Input(error),
        }
    }
}

impl From<strategy::Error> for Error {
    /// The same.
    fn from(error: strategy::Error) -> Self {
        match error {
            strategy::Error::Setting(bad) => bad.into(),
            strategy::Error::Input(error) => error.into(),
            error => Self::Strategy(error),
        }
    }
}

impl From<NoSlicer> for Error {
    fn from(no: NoSlicer) -> Self {
        match no {
            NoSlicer::File(error) => error.into(),
            NoSlicer::Slice(error) => error.into(),
        }
    }
}

impl From<MeshError> for Error {
    fn from(error: MeshError) -> Self {
        InputError::from(error).into()
    }
}

impl From<ProfileError> for Error {
    fn from(error: ProfileError) -> Self {
        InputError::from(error).into()
    }
}
