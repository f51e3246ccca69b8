//! What the user sees while waiting: a bar on a terminal after a second, nothing in a pipe.

use std::cell::RefCell;
use std::io::{IsTerminal, Write};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

/// The terminal, as the flags have set it.
pub(crate) struct Console {
    json: bool,
    quiet: bool,
    verbose: bool,
}

/// A bar comes only where the work takes longer than this.
const PATIENCE: Duration = Duration::from_secs(1);

impl Console {
    pub(super) fn new(json: bool, quiet: bool, verbose: bool) -> Self {
        Self { json, quiet, verbose }
    }

    /// Whether results are one JSON document.
    pub(crate) fn json(&self) -> bool {
        self.json
    }

    /// A result, on stdout. A reader that has gone away is no error.
    pub(crate) fn result(&self, text: &str) {
        let _ = writeln!(std::io::stdout(), "{}", text.trim_end());
    }

    /// A result as JSON, on stdout.
    pub(crate) fn document(&self, value: &serde_json::Value) {
        self.result(&serde_json::to_string_pretty(value).unwrap_or_default());
    }

    /// A step that is done, on stderr.
    pub(crate) fn note(&self, text: &str) {
        if !self.quiet {
            self.say(text);
        }
    }

    /// A detail for `-v`, on stderr.
    pub(crate) fn detail(&self, text: &str) {
        if self.verbose && !self.quiet {
            self.say(text);
        }
    }

    /// Something the user should know even with `-q`.
    pub(crate) fn warning(&self, text: &str) {
        self.say(&format!("warning: {text}"));
    }

    /// Why it failed.
    pub(super) fn error(&self, text: &str) {
        self.say(&format!("error: {text}"));
    }

    fn say(&self, text: &str) {
        let _ = writeln!(std::io::stderr(), "{text}");
    }

    /// Where a long job is: in one place of a terminal, nowhere else.
    pub(crate) fn status(&self, text: &str) {
        if !self.quiet && std::io::stderr().is_terminal() {
            let _ = write!(std::io::stderr(), "\r{text:<78}\r");
        }
    }

    /// A bar of `of` steps called `what`.
    pub(crate) fn progress(&self, what: &'static str, of: usize) -> Progress {
        let shown = !self.quiet && std::io::stderr().is_terminal();
        Progress { what, of, shown, start: Instant::now(), bar: RefCell::new(None) }
    }
}

/// A bar that waits a second before it shows.
pub(crate) struct Progress {
    what: &'static str,
    of: usize,
    shown: bool,
    start: Instant,
    bar: RefCell<Option<ProgressBar>>,
}

impl Progress {
    /// `done` steps are done.
    pub(crate) fn at(&self, done: usize) {
        if !self.shown || self.start.elapsed() < PATIENCE {
            return;
        }
        let mut bar = self.bar.borrow_mut();
        let bar = bar.get_or_insert_with(|| {
            let bar = ProgressBar::new(self.of as u64).with_message(self.what);
            if let Ok(style) = ProgressStyle::with_template("{msg:12} {bar:40} {pos}/{len} {elapsed}") {
                bar.set_style(style);
            }
            bar
        });
        bar.set_position(done as u64);
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some(bar) = self.bar.borrow_mut().take() {
            bar.finish_and_clear();
        }
    }
}
