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
            Sending::Pausing { waits_for } => {
                let first = waits_for
                    .map_or("the moves under way".to_owned(), |what| format!("{what}, which the printer waits for"));
                console.note(&format!("pausing after {first}; Ctrl-C again is an emergency stop"));
            }
            Sending::Trouble { file_line, text } => {
                console.warning(&format!(
                    "line {file_line} was not carried out as it is written; the printer says: {text}"
                ));
            }
            Sending::Resumed => console.note("the print goes on"),
            Sending::Done { resends } => {
                console.note(&format!("the print is complete: {} lines, {resends} of them sent again", at.of));
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

/// One line of a narrow terminal.
fn status(f: &Figures, at: At) -> String {
    let mut words = vec![format!("{:.0} %", (f.share * 100.0).clamp(0.0, 100.0))];
    if f.layers > 0 {
        words.push(format!("layer {} of {}", f.layer, f.layers));
    } else {
        words.push(format!("line {} of {}", at.line, at.of));
    }
    words.extend(f.slot.map(|slot| format!("slot {slot} of {}", f.slots)));
    words.push(format!("{:.0} min left", f.seconds_left / 60.0));
    words.extend(f.waits_for.map(|what| format!("waits for {what}")));
    words.extend(f.nozzle_c.map(|[now, wanted]| format!("{now:.0}/{wanted:.0} C")));
    words.extend(f.bed_c.map(|[now, wanted]| format!("bed {now:.0}/{wanted:.0}")));
    words.join(", ")
}
