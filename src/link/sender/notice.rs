//! What the sender says to the host: events, and how far the print is.

use super::Outcome;
use crate::link::journal::Record;
use crate::link::reply::{Status, Temperatures};

/// What the host should know or keep.
#[derive(Clone, Debug, PartialEq)]
pub enum Notice {
    /// The printer answered; what it calls itself.
    Connected(String),
    /// To be written to the journal before the next bytes are taken.
    Journal(Record),
    /// A line goes out again.
    Resend {
        /// Its number on the wire.
        number: i64,
        /// Its line of the file, where it is one of the file's.
        file_line: Option<u32>,
        /// Why.
        why: &'static str,
    },
    /// Temperatures.
    Temperatures(Temperatures),
    /// The printer's own word of where it is.
    Position(Vec<(u8, f64)>),
    /// Grbl's status.
    Status(Status),
    /// The printer waits for a person.
    UserWait,
    /// A line of the file was not carried out as it is written.
    Trouble {
        /// Of the file.
        line: u32,
        /// The printer's words, or what they come to.
        text: String,
    },
    /// Something worth a line on the screen.
    Note(String),
    /// The head is away from the part.
    Paused,
    /// The print goes on.
    Resumed,
    /// No more events will come.
    Over(Outcome),
}

/// How far the print is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Blocks answered.
    pub acked: u32,
    /// Blocks on the wire at least once.
    pub sent: u32,
    /// All blocks.
    pub of: u32,
    /// Lines sent again.
    pub resends: u32,
    /// The highest number known to be accepted.
    pub proven: i64,
    /// The highest number ever made.
    pub last: i64,
}
