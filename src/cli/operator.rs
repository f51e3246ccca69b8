//! The terminal as the one who stands by a print: events as lines, Ctrl-C, what is typed.

use std::cell::{OnceCell, RefCell};
use std::io::{BufRead, IsTerminal};

use super::{Console, progress};
use crate::document::{self, Lines, Tone};
use crate::job::{Answer, At, Desk, Operator, SendError, Sending};
use crate::link::Reentry;
use crate::link::serial::Twin;
use crate::world::interrupts::Interrupts;
use crossbeam_channel::{Receiver, TryRecvError, bounded};

pub(super) struct Terminal<'a> {
    console: &'a Console,
    /// Whether `--yes` has agreed to everything.
    yes: bool,
    /// From the moment on at which something is sent.
    interrupts: OnceCell<Interrupts>,
    typed: RefCell<Option<Receiver<String>>>,
    /// Where it is one of several prints: what is typed for all of them, and which it is.
    desk: Option<(&'a Desk, usize)>,
}

impl<'a> Terminal<'a> {
    pub(super) fn new(console: &'a Console, yes: bool) -> Self {
        Self { console, yes, interrupts: OnceCell::new(), typed: RefCell::new(None), desk: None }
    }

    pub(super) fn at(self, desk: &'a Desk, print: usize) -> Self {
        Self { desk: Some((desk, print)), ..self }
    }

    /// In a pause, where somebody can type.
    fn listen(&self) {
        let text = document::paused(self.print());
        if let Some((desk, print)) = self.desk {
            desk.pauses(print, self.ctrl_c());
        } else if !std::io::stdin().is_terminal() {
            return;
        }
        self.console.note(&text);
        if self.desk.is_some() {
            return;
        }
        let (typed, lines) = bounded(1);
        let draws = self.console.draws();
        self.typed.replace(Some(lines));
        // Without it the pause is ended from elsewhere, as where there is no terminal.
        let _ = std::thread::Builder::new().spawn(move || {
            let mut text = String::new();
            // The end of input is no Enter.
            if std::io::stdin().read_line(&mut text).is_ok_and(|n| n > 0) {
                progress::typed(None, draws.then(|| Lines::new(0, true)).as_deref());
                let _ = typed.send(text);
            }
        });
    }

    fn ctrl_c(&self) -> u32 {
        self.interrupts.get().map_or(0, Interrupts::count)
    }

    /// Which of several.
    fn print(&self) -> Option<usize> {
        self.desk.map(|(_, print)| print)
    }

    fn say(&self, what: &Sending<'_>, at: At) {
        let console = self.console;
        match document::said(what, at, self.print()) {
            Some((Tone::Detail, text)) => console.detail(&text),
            Some((Tone::Note, text)) => console.note(&text),
            Some((Tone::Warning, text)) => console.warning(&text),
            Some((Tone::Status, text)) if !console.json() => console.status(&text),
            _ => {}
        }
    }
}

impl Operator for Terminal<'_> {
    fn told(&self, what: &Sending<'_>, at: At) {
        self.say(what, at);
        if let (true, Some(mut event)) = (self.console.json(), document::event(what, at)) {
            if let Some(port) = self.console.name() {
                event["port"] = port.into();
            }
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
        self.desk.map_or(self.ctrl_c(), |(desk, print)| desk.interrupts(print, self.ctrl_c()))
    }

    fn forget_interrupts(&self) {
        self.desk.iter().for_each(|(desk, print)| desk.forget(*print));
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
        if let Some((desk, print)) = self.desk {
            return desk.answer(print);
        }
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
        if self.desk.is_some() || !std::io::stdin().is_terminal() {
            return false;
        }
        self.console.note("type yes to confirm:");
        let mut text = String::new();
        let read = std::io::stdin().lock().read_line(&mut text);
        read.is_ok() && text.trim() == "yes"
    }

    /// At once: the others may go on for hours.
    fn ended(&self, error: Option<&SendError>) {
        if let Some(error) = error {
            self.console.warning(&error.to_string());
        }
        self.console.status(if error.is_some() { "stopped" } else { "complete" });
    }
}
