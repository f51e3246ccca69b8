//! Why there is no way to print a model, with the facts as fields.

use std::sync::Arc;

use super::no_plan::NoPlan;
use super::refused::Refused;
use super::ways::NoWay;
use crate::assembly::FitError;
use crate::input::{BadSetting, InputError};
use crate::location::Location;
use crate::mesh::MeshError;
use crate::planning::{Infeasible, Misplaced};
use crate::profile::ProfileError;
use crate::world::FileError;

/// Why a model is not planned, cut or set up.
#[derive(Debug, thiserror::Error, strum::IntoStaticStr)]
#[strum(serialize_all = "kebab-case", prefix = "strategy/")]
pub enum StrategyError {
    /// What is read for it.
    #[error(transparent)]
    Input(#[from] InputError),
    /// A setting of a request that cannot be.
    #[error(transparent)]
    Setting(#[from] BadSetting),
    /// A model that does not lie on its table.
    #[error(transparent)]
    Misplaced(#[from] Misplaced),
    /// A model that does not lie on its table, but on that of another shipped machine.
    #[error("{source}; it fits on {machine} (-m {machine})")]
    RoomElsewhere {
        /// Why it does not.
        source: Misplaced,
        /// The other machine.
        machine: &'static str,
    },
    /// Models that fit on the table one by one, but not at once.
    #[error(
        "{bodies} separate objects do not fit on the table ({extent}) at once: print them on {plates} plates (prepare --plates DIR){}",
        machine.map_or_else(String::new, |name| format!(", or on {name}, where they fit (-m {name})"))
    )]
    SeveralPlates {
        /// How many stand apart.
        bodies: usize,
        /// The table's size, in words.
        extent: String,
        /// How many plates they take.
        plates: usize,
        /// Another machine that has room for all of them.
        machine: Option<&'static str>,
    },
    /// Parts that cannot be made to meet.
    #[error(transparent)]
    Fit(#[from] FitError),
    /// A model of several parts where one solid is cut.
    #[error(
        "{file} has {parts} closed parts, and only one solid can be cut; choose one (--part), or plan the parts as they are"
    )]
    NotOneSolid {
        /// The model.
        file: String,
        /// How many.
        parts: usize,
    },
    /// A model that cannot be planned at all, or has no sequence.
    #[error(transparent)]
    Infeasible(#[from] Infeasible),
    /// A model without a plan, with reasons and remedies.
    #[error("{}", .0.infeasible)]
    NoPlan(Box<NoPlan>),
    /// Nothing is left of the ways that were asked for.
    #[error("{0}")]
    NoWay(Box<NoWay>),
}

impl StrategyError {
    /// What stands for it in documents, for good, as `plan/no-plan`.
    pub fn code(&self) -> &'static str {
        match self {
            Self::Input(error) => error.code(),
            Self::Setting(error) => error.into(),
            Self::Misplaced(error) => error.into(),
            Self::Fit(error) => error.into(),
            Self::Infeasible(error) => error.into(),
            Self::NoPlan(no) => (&no.infeasible).into(),
            own => own.into(),
        }
    }

    /// Where in what the user gave it is.
    pub fn location(&self) -> Option<Location> {
        match self {
            Self::Input(error) => error.location(),
            Self::Misplaced(Misplaced::OverRim { part, .. })
            | Self::RoomElsewhere { source: Misplaced::OverRim { part, .. }, .. } => {
                Some(Location::default().part(*part))
            }
            Self::NotOneSolid { file, .. } => Some(Location::file(file)),
            _ => None,
        }
    }
}

impl From<MeshError> for StrategyError {
    fn from(error: MeshError) -> Self {
        InputError::from(error).into()
    }
}

impl From<ProfileError> for StrategyError {
    fn from(error: ProfileError) -> Self {
        InputError::from(error).into()
    }
}

impl From<FileError> for StrategyError {
    fn from(error: FileError) -> Self {
        InputError::from(error).into()
    }
}

impl From<StrategyError> for Refused {
    fn from(error: StrategyError) -> Self {
        match error {
            StrategyError::NoPlan(no) => Self::NoPlan(no.infeasible),
            StrategyError::Infeasible(no) => Self::NoPlan(no),
            error => Self::Failed { code: error.code(), why: Arc::new(error) },
        }
    }
}

impl From<InputError> for Refused {
    fn from(error: InputError) -> Self {
        StrategyError::from(error).into()
    }
}
