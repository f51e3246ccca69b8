//! Why models, profiles and plans are not read, with the facts as fields.

use std::path::PathBuf;

use crate::assembly::FitError;
use crate::location::Location;
use crate::mesh::{MeshError, UnknownUnit};
use crate::planning::{Misplaced, PlanError};
use crate::profile::ProfileError;
use crate::world::FileError;

/// Why a model, a profile or a plan is not read.
#[derive(Debug, thiserror::Error, strum::IntoStaticStr)]
#[strum(serialize_all = "kebab-case", prefix = "input/")]
pub enum InputError {
    /// A file that is not read.
    #[error(transparent)]
    File(#[from] FileError),
    /// No file of that name; its folder may have one that is called nearly so.
    #[error("{file}: file not found{}", near.as_ref().map_or(String::new(), |near| format!("; the nearest name is {near}")))]
    Absent {
        /// As asked for.
        file: String,
        /// The name that may be meant.
        near: Option<String>,
    },
    /// A file that takes more memory than it may.
    #[error(
        "{file}: reading it takes at least {needs_mb} MB of memory, and --max-memory allows {most_mb} MB; allow more, or simplify the file"
    )]
    Memory {
        /// The file.
        file: String,
        /// What it takes at the least, 10^6 bytes.
        needs_mb: u64,
        /// What it may take.
        most_mb: u64,
    },
    /// A web address; nothing is fetched.
    #[error("{address}: web addresses are not fetched; download it and give the file")]
    Address {
        /// As given.
        address: String,
    },
    /// Negative volumes that leave nothing, or that cannot be cut away.
    #[error(transparent)]
    Fit(#[from] FitError),
    /// A setting that cannot be.
    #[error(transparent)]
    Setting(#[from] super::BadSetting),
    /// A profile that cannot extend what it names.
    #[error("{file}: {fault}")]
    Layers {
        /// The file.
        file: String,
        /// Why not.
        fault: BadExtends,
    },
    /// A plan whose model is neither where it says nor beside it.
    #[error("{plan}: model {model} not found")]
    NoModel {
        /// The plan.
        plan: String,
        /// The model's file, as the plan names it.
        model: String,
    },
    /// A plan whose model has an unknown unit.
    #[error("{plan}: {source}")]
    Unit {
        /// The plan.
        plan: String,
        /// The unit.
        source: UnknownUnit,
    },
    /// A user's profile hidden by a shipped one of the same name.
    #[error("{}: {name} is also a shipped profile, which takes precedence; rename the file", path.display())]
    Hidden {
        /// The file.
        path: PathBuf,
        /// The name.
        name: String,
    },
    /// A model that cannot be read.
    #[error(transparent)]
    Mesh(Box<MeshError>),
    /// A profile with a value that TOML cannot express.
    #[error("the profile cannot be written as TOML: {why}")]
    Unwritable {
        /// The writer's words.
        why: String,
    },
    /// A profile that makes no sense.
    #[error(transparent)]
    Profile(#[from] ProfileError),
    /// A model that does not lie on its table.
    #[error(transparent)]
    Misplaced(#[from] Misplaced),
    /// A plan that is none, or is stale.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// A machine whose table does not both tilt and turn, for something that only a table's axes have.
    #[error(
        "profile {profile}: the axes of a head, and of a machine with one rotary axis, are neither jogged, calibrated nor rehearsed yet; measure \
         from_tip_mm, pivot_mm and offset_mm by hand"
    )]
    Chain {
        /// The profile.
        profile: String,
    },
}

/// Why a profile cannot extend what it names.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BadExtends {
    /// It comes back to itself.
    #[error("extends itself through {named}; remove this extends")]
    Circle {
        /// What it names.
        named: String,
    },
    /// More files than may extend each other.
    #[error("more than {most} files extend each other; merge some of them")]
    TooMany {
        /// How many may.
        most: usize,
    },
    /// A profile in hand, which lies beside no file.
    #[error("the profile was not read from a file, so it cannot extend the file {named}")]
    NoFile {
        /// What it names.
        named: String,
    },
}

impl InputError {
    /// What stands for it in documents, for good, as `mesh/open`.
    pub fn code(&self) -> &'static str {
        match self {
            Self::File(error) => error.into(),
            Self::Fit(error) => error.into(),
            Self::Setting(error) => error.into(),
            Self::Mesh(error) => (&error.fault).into(),
            Self::Profile(error) => error.into(),
            Self::Misplaced(error) => error.into(),
            Self::Plan(error) => error.into(),
            own => own.into(),
        }
    }

    /// Where in what the user gave it is.
    pub fn location(&self) -> Option<Location> {
        match self {
            Self::File(error) => Some(error.location()),
            Self::Absent { file, .. } | Self::Memory { file, .. } | Self::Layers { file, .. } => {
                Some(Location::file(file))
            }
            Self::NoModel { plan, .. } | Self::Unit { plan, .. } => Some(Location::file(plan)),
            Self::Hidden { path, .. } => Some(Location::path(path)),
            Self::Mesh(error) => Some(error.location()),
            Self::Profile(error) => error.location(),
            Self::Misplaced(Misplaced::OverRim { part, .. }) => Some(Location::default().part(*part)),
            Self::Plan(error) => error.location(),
            _ => None,
        }
    }
}

impl From<MeshError> for InputError {
    fn from(error: MeshError) -> Self {
        Self::Mesh(Box::new(error))
    }
}
