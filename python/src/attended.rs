//! A print that Python stands by: told what happens, paused by the first interrupt, stopped by the second.

use std::cell::RefCell;
use std::panic::resume_unwind;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use serde_json::Value;
use trunnion::document::{self, Tone};
use trunnion::job::{At, Operator, Sending};
use trunnion::link::Reentry;
use trunnion::link::serial::Twin;
use trunnion::slicing::Interrupt;

use crate::run::{Cancelled, Told};

/// More than a print's own thread naps, and soon enough.
pub(crate) const HEAD_START: Duration = Duration::from_millis(300);

/// How far a call is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Stage {
    /// It can be taken back.
    #[default]
    Free,
    /// It was.
    Cancelled,
    /// A printer is at work: it ends by a pause above the part, never by unwinding.
    Printing,
}

/// A port, and what stops what is behind it.
type LastWords = Option<(Twin, &'static [u8])>;

/// What Python's thread and the job's have in common.
#[derive(Debug, Default)]
pub(crate) struct Course {
    /// Ends the job at its next step, and its slicers at once.
    pub(crate) stop: Interrupt,
    stage: Mutex<Stage>,
    interrupts: AtomicU32,
    last_words: Mutex<LastWords>,
}

/// A lock holds no half-made value, so that whoever has panicked with it does not matter.
fn locked<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Course {
    /// Takes the call back; false where a printer is at work, which must be interrupted instead.
    pub(crate) fn cancel(&self) -> bool {
        let mut stage = locked(&self.stage);
        if *stage == Stage::Printing {
            return false;
        }
        *stage = Stage::Cancelled;
        self.stop.ask();
        true
    }

    /// Asks the print to pause; whether that was asked before, so that it is to stop now.
    pub(crate) fn interrupt(&self) -> bool {
        self.interrupts.fetch_add(1, Ordering::SeqCst) > 0
    }

    /// Stops the printer past the print's own thread, were that held up by a disk.
    pub(crate) fn stop_printer(&self) {
        if let Some((port, words)) = locked(&self.last_words).as_mut() {
            port.write(words);
        }
    }

    fn print(&self) {
        let mut stage = locked(&self.stage);
        if *stage == Stage::Cancelled {
            drop(stage);
            resume_unwind(Box::new(Cancelled));
        }
        *stage = Stage::Printing;
    }
}

/// Python as the one who stands by a print. Nobody types in a pause, so that it ends the job, which can be resumed.
pub(crate) struct Attendant<'a> {
    course: &'a Course,
    /// Hears all, and waits for nobody: the printer does not either.
    say: &'a dyn Fn(Told),
    /// Whether a machine may home and move with a part on its table.
    yes: bool,
    last: RefCell<Value>,
}

impl<'a> Attendant<'a> {
    pub(crate) fn new(course: &'a Course, say: &'a dyn Fn(Told), yes: bool) -> Self {
        Self { course, say, yes, last: RefCell::default() }
    }

    /// The last event, as the command has it.
    pub(crate) fn last(&self) -> Value {
        self.last.borrow().clone()
    }
}

impl Operator for Attendant<'_> {
    fn told(&self, what: &Sending<'_>, at: At) {
        let (line, of) = (at.line as usize, at.of as usize);
        let kind = |tone| match tone {
            Tone::Detail => Some("detail"),
            Tone::Note => Some("note"),
            Tone::Warning => Some("warning"),
            // Its figures are the event's.
            Tone::Status => None,
        };
        if let Some((tone, text)) = document::said(what, at, None)
            && let Some(kind) = kind(tone)
        {
            (self.say)((kind, text, line, of));
        }
        if let Some(event) = document::event(what, at) {
            (self.say)(("event", event.to_string(), line, of));
            self.last.replace(event);
        }
    }

    fn begin(&self) {
        self.course.print();
    }

    fn interrupts(&self) -> u32 {
        self.course.interrupts.load(Ordering::SeqCst)
    }

    fn forget_interrupts(&self) {
        self.course.interrupts.store(0, Ordering::SeqCst);
    }

    fn last_words(&self, words: LastWords) {
        *locked(&self.course.last_words) = words;
    }

    fn agrees(&self, _: &Reentry) -> bool {
        self.yes
    }
}
