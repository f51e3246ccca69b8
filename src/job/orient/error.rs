//! Why no direction is found for a part.

use crate::input::InputError;
use crate::location::Location;
use crate::mesh::MeshError;

/// Why no direction is found for a part.
#[derive(Debug, thiserror::Error, strum::IntoStaticStr)]
#[strum(serialize_all = "kebab-case", prefix = "job/")]
pub enum OrientError {
    /// What is read for it.
    #[error(transparent)]
    Input(InputError),
    /// An open surface where an objective is a volume or needs an inside.
    #[error("{objective} needs a closed mesh: {source}")]
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
}

impl OrientError {
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
            Self::NeedsClosed { source, .. } => Some(source.location()),
            Self::NoArea { part, .. } => Some(Location::default().part(*part)),
        }
    }
}

impl<E: Into<InputError>> From<E> for OrientError {
    fn from(error: E) -> Self {
        Self::Input(error.into())
    }
}
