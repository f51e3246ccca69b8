//! Why a job was not done, with the facts as fields.

use super::batch::BatchError;
use super::machine::MachineError;
use super::orient::OrientError;
use super::pack::PackError;
use super::print::PrintError;
use super::printer::PrinterError;
use super::publish::UploadError;
use super::send::SendError;
use crate::input::InputError;
use crate::location::Location;
use crate::strategy::StrategyError;
use crate::world::NoSlicer;

/// Why a job was not done: what any of them ends with.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A file, a model, a profile or a plan that is not read, and a setting that cannot be.
    #[error(transparent)]
    Input(InputError),
    /// A model that has no way to be printed.
    #[error(transparent)]
    Strategy(StrategyError),
    /// A program that is not made, or not proved.
    #[error(transparent)]
    Print(PrintError),
    /// A print that was not begun, or ended before its end.
    #[error(transparent)]
    Send(SendError),
    /// A printer that cannot be had.
    #[error(transparent)]
    Printer(PrinterError),
    /// A machine that is not described, measured or rehearsed.
    #[error(transparent)]
    Machine(MachineError),
    /// A part for which no direction is found.
    #[error(transparent)]
    Orient(OrientError),
    /// Pieces that are not packed.
    #[error(transparent)]
    Pack(PackError),
    /// A batch that is not begun.
    #[error(transparent)]
    Batch(BatchError),
    /// A program that is not at its server.
    #[error(transparent)]
    Upload(UploadError),
}

impl Error {
    /// What stands for it in documents, for good, as `slice/timeout`: `trunnion explain` says what each means.
    pub fn code(&self) -> &'static str {
        match self {
            Self::Input(error) => error.code(),
            Self::Strategy(error) => error.code(),
            Self::Print(error) => error.code(),
            Self::Send(error) => error.code(),
            Self::Printer(error) => error.code(),
            Self::Machine(error) => error.code(),
            Self::Orient(error) => error.code(),
            Self::Pack(error) => error.code(),
            Self::Batch(error) => error.code(),
            Self::Upload(error) => error.code(),
        }
    }

    /// Where in what the user gave it is.
    pub fn location(&self) -> Option<Location> {
        match self {
            Self::Input(error) => error.location(),
            Self::Strategy(error) => error.location(),
            Self::Print(error) => error.location(),
            Self::Send(error) => error.location(),
            Self::Machine(error) => error.location(),
            Self::Orient(error) => error.location(),
            Self::Batch(error) => error.location(),
            Self::Pack(PackError::Input(error)) | Self::Printer(PrinterError::Input(error)) => error.location(),
            Self::Upload(UploadError::File(error)) => Some(error.location()),
            Self::Pack(_) | Self::Printer(_) | Self::Upload(_) => None,
        }
    }
}

impl<E: Into<InputError>> From<E> for Error {
    fn from(error: E) -> Self {
        Self::Input(error.into())
    }
}

impl From<StrategyError> for Error {
    /// What is read is told as the job's own.
    fn from(error: StrategyError) -> Self {
        PrintError::from(error).into()
    }
}

impl From<NoSlicer> for Error {
    fn from(no: NoSlicer) -> Self {
        PrintError::from(no).into()
    }
}

impl From<PrintError> for Error {
    fn from(error: PrintError) -> Self {
        match error {
            PrintError::Input(error) => Self::Input(error),
            PrintError::Strategy(error) => Self::Strategy(error),
            error => Self::Print(error),
        }
    }
}

impl From<SendError> for Error {
    fn from(error: SendError) -> Self {
        match error {
            SendError::Input(error) => Self::Input(error),
            SendError::NoPrinter(error) => Self::Printer(error),
            error => Self::Send(error),
        }
    }
}

/// What is read is told as the job's own, whichever room has read it.
macro_rules! from_rooms {
    ($($room:ident($own:ident)),+) => {
        $(impl From<$own> for Error {
            fn from(error: $own) -> Self {
                match error {
                    $own::Input(error) => Self::Input(error),
                    error => Self::$room(error),
                }
            }
        })+
    };
}

from_rooms!(Printer(PrinterError), Machine(MachineError), Orient(OrientError), Pack(PackError), Batch(BatchError));

impl From<UploadError> for Error {
    fn from(error: UploadError) -> Self {
        match error {
            UploadError::File(error) => error.into(),
            error => Self::Upload(error),
        }
    }
}
