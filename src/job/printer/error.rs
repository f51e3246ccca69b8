//! Why there is no printer to send to, real or simulated.

use crate::input::InputError;
use crate::link::serial::PortError;
use crate::link::sim::{NAMES, QUIRKS};

/// Why there is no printer to send to, real or simulated.
#[derive(Debug, thiserror::Error, strum::IntoStaticStr)]
#[strum(serialize_all = "kebab-case", prefix = "job/")]
pub enum PrinterError {
    /// What is read for it.
    #[error(transparent)]
    Input(InputError),
    /// A profile whose printer cannot be streamed to.
    #[error("profile {profile}: [link] protocol {protocol:?} cannot be streamed; use marlin, rrf, klipper or grbl")]
    Protocol {
        /// The profile.
        profile: String,
        /// As it says.
        protocol: String,
    },
    /// A port that cannot be had.
    #[error(transparent)]
    Port(#[from] PortError),
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
    /// A simulated printer that cannot be.
    #[error(transparent)]
    Simulation(#[from] BadSimulation),
    /// A port at which no printer answers.
    #[error(
        "{place}: no printer answered M115 within {seconds} s at {baud} baud; check --baud (115200 and 250000 are usual) and the cable"
    )]
    Mute {
        /// The port.
        place: String,
        /// Bits a second.
        baud: u32,
        /// How long it was waited for.
        seconds: u64,
    },
    /// A printer of a firmware that is not known.
    #[error("{place}: the firmware is not supported: {says}; use Marlin, RepRapFirmware, Klipper or grblHAL")]
    Stranger {
        /// The port.
        place: String,
        /// What it says of itself.
        says: String,
    },
    /// A printer that does not carry out a line.
    #[error("{place}: the printer refuses {line}: {answer}")]
    Refuses {
        /// The port.
        place: String,
        /// What was sent.
        line: String,
        /// In its words.
        answer: String,
    },
    /// An answer without an end.
    #[error(
        "{place}: the printer stopped answering {line} (silent for {seconds} s); switch it off and on, then try again"
    )]
    Halfway {
        /// The port.
        place: String,
        /// What was sent.
        line: String,
        /// How long it was waited for.
        seconds: u64,
    },
    /// A port that is gone.
    #[error("{place}: the connection was lost: {why}")]
    Gone {
        /// The port.
        place: String,
        /// The system's words.
        why: String,
    },
}

impl PrinterError {
    /// Whether it is the port or the printer behind it, and not what was asked for.
    pub fn is_of_the_wire(&self) -> bool {
        matches!(
            self,
            Self::Port(_)
                | Self::Mute { .. }
                | Self::Stranger { .. }
                | Self::Refuses { .. }
                | Self::Halfway { .. }
                | Self::Gone { .. }
        )
    }

    /// What stands for it in documents, for good.
    pub fn code(&self) -> &'static str {
        match self {
            Self::Input(error) => error.code(),
            Self::Port(error) => error.into(),
            Self::Simulation(error) => error.into(),
            own => own.into(),
        }
    }
}

impl<E: Into<InputError>> From<E> for PrinterError {
    fn from(error: E) -> Self {
        Self::Input(error.into())
    }
}

/// A word of a request that means nothing.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, strum::IntoStaticStr)]
#[strum(serialize_all = "kebab-case", prefix = "simulate/")]
pub enum BadSimulation {
    /// An unknown quirk.
    #[error("unknown quirk {given}; use one of {}", QUIRKS.map(|(name, _)| name).join(", "))]
    Quirk {
        /// As given.
        given: String,
    },
    /// An unknown fault.
    #[error(
        "fault {given}: must be NAME@LINE, NAME:PROBABILITY or random:PROBABILITY (0 to 1); names: {}",
        NAMES.map(|(name, _)| name).join(", ")
    )]
    Fault {
        /// As given.
        given: String,
    },
}
