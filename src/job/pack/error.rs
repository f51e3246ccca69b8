//! Why pieces are not packed.

use super::BadPacking;
use crate::input::InputError;

/// Why pieces are not packed.
#[derive(Debug, thiserror::Error)]
pub enum PackError {
    /// What is read for it.
    #[error(transparent)]
    Input(InputError),
    /// What cannot be packed.
    #[error(transparent)]
    Packing(#[from] BadPacking),
}

impl PackError {
    /// What stands for it in documents, for good.
    pub fn code(&self) -> &'static str {
        match self {
            Self::Input(error) => error.code(),
            Self::Packing(error) => error.into(),
        }
    }
}

impl<E: Into<InputError>> From<E> for PackError {
    fn from(error: E) -> Self {
        Self::Input(error.into())
    }
}
