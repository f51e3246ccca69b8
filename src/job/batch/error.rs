//! Why a batch is not begun.

use std::path::PathBuf;

use crate::input::InputError;
use crate::location::Location;

/// Why a batch is not begun.
#[derive(Debug, thiserror::Error, strum::IntoStaticStr)]
#[strum(serialize_all = "kebab-case", prefix = "job/")]
pub enum BatchError {
    /// What is read for it.
    #[error(transparent)]
    Input(InputError),
    /// A folder or a list without a model.
    #[error("{}: no models found; a model ends in .stl, .obj, .3mf or .off", path.display())]
    NoModels {
        /// The folder or list.
        path: PathBuf,
    },
}

impl BatchError {
    /// What stands for it in documents, for good.
    pub fn code(&self) -> &'static str {
        match self {
            Self::Input(error) => error.code(),
            own => own.into(),
        }
    }

    /// Where in what the user gave it is.
    pub fn location(&self) -> Option<Location> {
        match self {
            Self::Input(error) => error.location(),
            Self::NoModels { path } => Some(Location::path(path)),
        }
    }
}

impl<E: Into<InputError>> From<E> for BatchError {
    fn from(error: E) -> Self {
        Self::Input(error.into())
    }
}
