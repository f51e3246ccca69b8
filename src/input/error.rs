//! Why models, profiles and plans are not read, with the facts as fields.

use std::path::PathBuf;

use crate::assembly::FitError;
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
    #[error("{file}: there is no such file{}", near.as_ref().map_or(String::new(), |near| format!("; did you mean {near}?")))]
    Absent {
        /// As asked for.
        file: String,
        /// The name that may be meant.
        near: Option<String>,
    },
    /// A web address; nothing is fetched.
    #[error("{address}: a web address, and files are read from this computer alone; download it, and give the file")]
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
    /// Profiles that extend each other without end, or one in hand that names a file.
    #[error("{file}: extends {named}; only files can extend files, {most} at most one over the other, and none itself")]
    Layers {
        /// The file.
        file: String,
        /// What it extends.
        named: String,
        /// How many may be.
        most: usize,
    },
    /// A plan whose model is neither where it says nor beside it.
    #[error("{plan}: the model {model} is not there")]
    NoModel {
        /// The plan.
        plan: String,
        /// The model's file, as the plan names it.
        model: String,
    },
    /// A plan whose model has a unit that nobody knows.
    #[error("{plan}: {source}")]
    Unit {
        /// The plan.
        plan: String,
        /// The unit.
        source: UnknownUnit,
    },
    /// A profile of the user's own that nobody can ask for.
    #[error("{}: a shipped profile is called {name} too, and goes first; rename the file", path.display())]
    Hidden {
        /// The file.
        path: PathBuf,
        /// The name.
        name: String,
    },
    /// A model that cannot be read.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// A profile with a value that TOML has no words for.
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
}
