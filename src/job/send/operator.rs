//! Whoever stands by while a printer prints: told what happens, asked where a person must decide.

use std::path::Path;
use std::time::Duration;

use super::error::SendError;
use crate::link::Reentry;
use crate::link::serial::Twin;

/// Whoever stands by a print.
pub trait Operator {
    /// What happens.
    fn told(&self, what: &Sending<'_>, at: At);

    /// From now on interrupts are counted, and end nothing by themselves.
    fn begin(&self) {}

    /// How often it was asked to end: once is a safe pause, more is an emergency stop.
    fn interrupts(&self) -> u32 {
        0
    }

    /// The interrupts so far are forgotten: a pause is over.
    fn forget_interrupts(&self) {}

    /// A hand on the port, and what to write with it when the print's own thread is held up; `None` takes it back.
    fn last_words(&self, _words: Option<(Twin, &'static [u8])>) {}

    /// Asked again and again in a pause.
    fn answer(&self) -> Answer {
        Answer::Nobody
    }

    /// Whether the machine may home and move as `entry` says; nothing has moved yet.
    fn agrees(&self, _entry: &Reentry) -> bool {
        false
    }

    /// One of several prints has ended, whatever becomes of the others; why, where it failed.
    fn ended(&self, _error: Option<&SendError>) {}
}

/// What somebody says in a pause.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answer {
    /// Nothing yet.
    NotYet,
    /// Continue.
    Continue,
    /// End the print.
    Cancel,
    /// There is nobody who could say anything: the job ends here, and can be resumed.
    Nobody,
}

/// Where a print is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct At {
    /// The last line of the file that the printer has answered.
    pub line: u32,
    /// The file's last line that is sent.
    pub of: u32,
}

/// What happens while a program is sent.
#[derive(Clone, Debug, PartialEq)]
pub enum Sending<'a> {
    /// It begins.
    Start,
    /// What the printer calls itself.
    Printer(&'a str),
    /// A line goes out again.
    Resend {
        /// Its number on the wire.
        number: i64,
        /// Its line of the file, where it is one of the file's.
        file_line: Option<u32>,
        /// Why.
        why: &'static str,
    },
    /// The printer waits for a person.
    UserWait,
    /// Something worth a line on the screen.
    Note(&'a str),
    /// How far it is, about once a second.
    Progress(Figures),
    /// A line of the file was not carried out as it is written; a pause follows.
    Trouble {
        /// Of the file.
        file_line: u32,
        /// The printer's words.
        text: &'a str,
    },
    /// It was asked to pause; the moves under way end first, and what the printer waits for.
    Pausing {
        /// In words.
        waits_for: Option<&'a str>,
    },
    /// The head is away from the part.
    Paused,
    /// The print continues.
    Resumed,
    /// The disk has no more room for the journal: the print pauses while its last records still fit.
    Short {
        /// The journal.
        journal: &'a str,
    },
    /// It is to go on, and there is still no room.
    StillShort,
    /// The journal cannot be written at all; nothing is sent until it can.
    Full {
        /// The journal.
        journal: &'a str,
    },
    /// The link is gone; the same device is waited for.
    Lost {
        /// Why.
        why: &'a str,
        /// How long.
        wait: Duration,
    },
    /// The journal of an earlier, interrupted print was put aside.
    Aside {
        /// Its new name.
        journal: &'a Path,
    },
    /// Without a plan there is no proof that the path of a re-entry is clear.
    UnprovedReentry,
    /// The printer was reset.
    Reset {
        /// In words.
        reason: &'a str,
    },
    /// The print has ended before its end.
    Stopped {
        /// In words.
        reason: &'a str,
    },
    /// The print has ended.
    Done {
        /// Lines sent again.
        resends: u32,
    },
}

/// How far a print is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figures {
    /// Of its time, 0 to 1.
    pub share: f64,
    /// Layers begun.
    pub layer: usize,
    /// Layers that the file has.
    pub layers: usize,
    /// The plan's slot.
    pub slot: Option<u32>,
    /// Its last; 0 where the file names none.
    pub slots: u32,
    /// Time left, with homing, heating and accelerations as the rehearsal has them.
    pub seconds_left: f64,
    /// The nozzle, and what it shall become.
    pub nozzle_c: Option<[f64; 2]>,
    /// The bed, and what it shall become.
    pub bed_c: Option<[f64; 2]>,
    /// What the printer waits for, in words.
    pub waits_for: Option<&'static str>,
    /// Lines sent again.
    pub resends: u32,
}

/// Nobody stands by: nobody interrupts, a pause ends the job, and no machine homes with a part on its table.
#[derive(Clone, Copy, Debug, Default)]
pub struct Unattended;

impl Operator for Unattended {
    fn told(&self, _: &Sending<'_>, _: At) {}
}
