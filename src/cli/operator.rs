//! The terminal as the one who stands by a print: events as lines, Ctrl-C, what is typed.

use std::cell::{OnceCell, RefCell};
use std::io::{BufRead, IsTerminal};

use super::Console;
use crate::document;
use crate::job::interrupts::Interrupts;
use crate::job::{Answer, At, Figures, Operator, Sending};
use crate::link::Reentry;
use crate::link::serial::Twin;
use crossbeam_channel::{Receiver, TryRecvError, bounded};

pub(super) struct Terminal<'a> {
    console: &'a Console,
    /// Whether `--yes` has agreed to everything.
    yes: bool,
    /// From the moment on at which something is sent.
    interrupts: OnceCell<Interrupts>,
    typed: RefCell<Option<Receiver<String>>>,
}

impl<'a> Terminal<'a> {
    pub(super) fn new(console: &'a Console, yes: bool) -> Self {
        Self { console, yes, interrupts: OnceCell::new(), typed: RefCell::new(None) }
    }

    /// In a pause, where somebody can type.
    fn listen(&self) {
        if !std::io::stdin().is_terminal() {
            return;
        }
        let text = "paused above the part: Enter continues, c and Enter cancels, Ctrl-C is an emergency stop";
        self.console.note(text);
        let (typed, lines) = bounded(1);
        self.typed.replace(Some(lines));
        std::thread::spawn(move || {
            let mut text = String::new();
            // The end of input is no Enter.
            if std::io::stdin().read_line(&mut text).is_ok_and(|n| n > 0) {
                let _ = typed.send(text);
            }
        });
    }

    fn say(&self, what: &Sending<'_>, at: At) {
        let console = self.console;
        match what {
            Sending::Printer(name) => console.note(&format!("printer: {name}")),
            Sending::Resend { number, why, .. } => {
                console.detail(&format!("wire line {number} is sent again ({why})"));
            }
            Sending::UserWait => console.note("the printer is waiting for a person"),
            Sending::Note(text) => console.note(text),
            Sending::Progress(figures) if !console.json() => console.status(&status(figures, at)),
            Sending::Pausing => {
                console.note("pausing after the moves under way; Ctrl-C again is an emergency stop");
            }
            Sending::Short { journal } => {
                console.warning(&format!("{journal}: no room left on the disk for the journal; pausing"));
            }
            Sending::StillShort => console.warning("there is still no room on the disk for the journal"),
            Sending::Full { journal } => {
                console.warning(&format!("{journal}: cannot be written any more; nothing is sent until it can"));
            }
            Sending::Lost { why, wait } => {
                let wait = wait.as_secs();
                console.warning(&format!("connection lost ({why}); waiting up to {wait} s for the same device"));
            }
            Sending::Aside { journal } => {
                let journal = journal.display();
                console.warning(&format!("the journal of an interrupted print is now {journal}"));
            }
            Sending::UnprovedReentry => {
                console.warning("without --plan there is no proof that the path of the re-entry is clear");
            }
            _ => {}
        }
    }
}

impl Operator for Terminal<'_> {
    fn told(&self, what: &Sending<'_>, at: At) {
        self.say(what, at);
        if let (true, Some(event)) = (self.console.json(), document::event(what, at)) {
            self.console.result(&event.to_string());
        }
        if matches!(what, Sending::Paused) {
            self.listen();
        }
    }

    fn begin(&self) {
        self.interrupts.get_or_init(Interrupts::listen);
    }

    fn interrupts(&self) -> u32 {
        self.interrupts.get().map_or(0, Interrupts::count)
    }

    fn forget_interrupts(&self) {
        if let Some(interrupts) = self.interrupts.get() {
            interrupts.forget();
        }
    }

    fn last_words(&self, words: Option<(Twin, &'static [u8])>) {
        if let Some(interrupts) = self.interrupts.get() {
            interrupts.last_words(words);
        }
    }

    /// Without a terminal, or behind the end of its input, nobody can type.
    fn answer(&self) -> Answer {
        let mut typed = self.typed.borrow_mut();
        let Some(lines) = typed.as_ref() else { return Answer::Nobody };
        let text = match lines.try_recv() {
            Ok(text) => text,
            Err(TryRecvError::Empty) => return Answer::NotYet,
            Err(TryRecvError::Disconnected) => return Answer::Nobody,
        };
        *typed = None;
        if text.trim().eq_ignore_ascii_case("c") { Answer::Cancel } else { Answer::Continue }
    }

    fn agrees(&self, _: &Reentry) -> bool {
        if self.yes {
            return true;
        }
        if !std::io::stdin().is_terminal() {
            return false;
        }
        self.console.note("type yes to do so:");
        let mut text = String::new();
        let read = std::io::stdin().lock().read_line(&mut text);
        read.is_ok() && text.trim() == "yes"
    }
}

fn status(figures: &Figures, at: At) -> String {
    let bed = figures.bed_c.unwrap_or(0.0);
    let heat = figures.nozzle_c.map_or(String::new(), |nozzle| format!(", nozzle {nozzle:.0}, bed {bed:.0}"));
    let slot = figures.slot.map_or(String::new(), |slot| format!(", slot {slot}"));
    let (line, of, layer, left) = (at.line, at.of, figures.layer, figures.seconds_left / 60.0);
    format!("line {line} of {of}, layer {layer}{slot}, about {left:.0} min left{heat}")
}
