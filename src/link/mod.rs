//! The printer link: exactly-once streaming, re-entry, and a simulated printer that knows motion.
//!
//! ```text
//! file --Program--> blocks --Sender--> bytes on the wire --> Sim or a printer
//!                             ^  '--> Journal            <-- replies
//! ```
//!
//! A file becomes blocks, and a block becomes a line on the wire:
//!
//! ```
//! use trunnion::link::{Program, ProgramRules, Protocol, push_numbered};
//! use trunnion::profile::resolve;
//!
//! let (profile, _) = resolve("mine.toml", "extends = \"generic-ac\"")?;
//! let rules = ProgramRules { protocol: Protocol::Marlin, longest_line: 96, setting: profile.trace_setting() };
//!
//! // Comments are not sent: two blocks go to the printer, of lines 2 and 3 of the file.
//! let program = Program::read(b"; made by hand\nG28 ; home\nG1 Z5 F600\n", &rules)?;
//! assert_eq!((program.len(), program.block(0), program.file_line(1)), (2, &b"G28"[..], 3));
//!
//! // On the wire a block has a number, and behind `*` the exclusive or of all bytes before it.
//! let mut wire = Vec::new();
//! push_numbered(&mut wire, 1, program.block(0));
//! let sum = b"N1G28".iter().fold(0, |sum, byte| sum ^ byte);
//! assert_eq!(wire, format!("N1G28*{sum}\n").into_bytes());
//! # Ok::<(), Box<dyn std::error::Error>>(())
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
mod exchange;
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
pub use exchange::{Answered, Exchange};
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
pub use sender::{AfterStop, Counts, Notice, Outcome, Sender, StopReason, StopWatch, told_axes};
pub use settings::SenderSettings;
pub use state::MachineState;
pub use wire::{LineAssembler, checksum, push_numbered};

/// Time since any fixed moment.
pub type Time = std::time::Duration;
