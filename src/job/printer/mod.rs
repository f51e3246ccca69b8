//! The printer of a profile: what the link has to know of it, and one that is simulated.

mod bench;
mod error;
mod settings;
mod simulate;
mod talk;

pub use bench::Bench;
pub use error::{BadSimulation, PrinterError};
pub(crate) use settings::{abilities, model, protocol, quirks, rules, settings};
pub use simulate::{SimulateRequest, simulate};
pub(crate) use talk::Talk;
