//! The printer link: exactly-once streaming, re-entry, and a simulated printer that knows motion.
//!
//! ```text
//! file --Program--> blocks --Sender--> bytes on the wire --> Sim or a printer
//!                             ^  '--> Journal            <-- replies
//! ```
//!
//! The program is read by the interpreter that verification uses (`trace`), so that both state the same time. [`Sender`] and
//! [`sim::Sim`] are state machines with a passed-in clock: no threads, no ports, no sleeping. Only `serial/`
//! touches the world. The rule: an accepted number is executed once; a line known to be accepted is never sent again;
//! what is unknown stops the print with its reason.
//!
//! This room must not know profiles, plans or files: `job` builds its settings. Sources: the firmwares, as
//! `fixtures/wire/README.md` says.

mod action;
mod compact;
mod doubt;
mod journal;
mod loopback;
mod pace;
mod padding;
mod place;
mod preflight;
mod program;
mod protocol;
mod reentry;
mod reply;
mod retreat;
mod sender;
pub mod serial;
mod settings;
pub mod sim;
mod state;
#[cfg(test)]
mod testing;
mod wire;

pub use action::HostAction;
pub use compact::push_compact;
pub use journal::{Header, JournalError, JournalSummary, Record};
pub use loopback::{Heading, Loopback};
pub use pace::{TooSlow, too_slow};
pub use place::Place;
pub use preflight::{Abilities, Unfit};
pub use program::{Boundary, BoundaryKind, LARGEST_FILE, Program, ProgramError, ProgramRules};
pub(crate) use protocol::Accounting;
pub use protocol::Protocol;
pub use reentry::{Reentry, ReentryError};
pub use reply::{BufferRoom, Busy, Reply, Status, Temperatures, Wording};
pub use retreat::{Heaters, Retreat, Turning};
pub use sender::{AfterStop, Counts, Notice, Outcome, Sender, StopReason, StopWatch};
pub use settings::SenderSettings;
pub use state::MachineState;
pub use wire::{LineAssembler, checksum, push_numbered};

/// Time since any fixed moment.
pub type Time = std::time::Duration;
