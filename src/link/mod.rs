//! The printer link: exactly-once streaming, resume, and a simulated printer that knows motion.
//!
//! ```text
//! file --Program--> blocks --Sender--> bytes on the wire --> Sim or a printer
//!                             ^  '--> Journal            <-- replies
//! ```
//!
//! [`Sender`] and [`sim::Sim`] are state machines with a passed-in clock: no threads, no ports, no sleeping. Only `serial/`
//! touches the world. The rule: an accepted number is executed once; a line known to be accepted is never sent again;
//! what is unknown stops the print with its reason.
//!
//! This room must not know profiles, plans or files: `job` builds its settings. Sources: `field/link.md`,
//! `field/firmware.md` sections 3 and 4.

mod compact;
mod journal;
mod loopback;
mod preflight;
mod program;
mod reply;
mod resume;
mod seams;
mod sender;
pub mod serial;
pub mod sim;
#[cfg(test)]
mod testing;
mod timing;
mod wire;

pub use compact::push_compact;
pub use journal::{Header, JournalError, Record, Standing};
pub use loopback::{Heading, Loopback};
pub use preflight::{Abilities, Unfit};
pub use program::{LARGEST_FILE, Mark, MarkKind, Program, ProgramError, Rules};
pub use reply::{Busy, Reply, Status, Temperatures};
pub use resume::{Heaters, Reentry, ReentryError, Retreat, State};
pub use sender::{Event, Outcome, Progress, Sender, Settings, Stop, Time};
pub use timing::{TooSlow, too_slow};
pub use wire::{LineAssembler, Protocol, checksum, push_numbered};
