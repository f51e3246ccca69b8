//! Why a batch is not begun.

use std::path::PathBuf;

use crate::input::InputError;

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
}

impl<E: Into<InputError>> From<E> for BatchError {
    fn from(error: E) -> Self {
        Self::Input(error.into())
    }
}
