//! What the user sees while waiting: a bar on a terminal after a second, nothing in a pipe.

use std::any::Any;
use std::cell::{Cell, RefCell};
use std::io::{Error, ErrorKind, IsTerminal, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use super::{Failure, plan};
use crate::document::{self, Lines, Row, text};
use crate::job::{self, Bar, Installed, LoadedModel, OutputFile, PlanResult, Progress, SliceResult, World, interrupts};
use crate::workbench::PROGRESS_VARIABLE;

/// The terminal, as the flags have set it.
pub(crate) struct Console {
    json: bool,
    quiet: bool,
    verbose: bool,
    /// What reading may take, MB.
    max_memory: Option<u64>,
    /// The first result that did not arrive.
    lost: OnceLock<Error>,
    /// Whether stdout has had anything, of any row.
    spoke: Arc<AtomicBool>,
    row: Option<Row>,
    searches: interrupts::Searches,
}

/// A bar comes only where the work takes longer than this.
const PATIENCE: Duration = Duration::from_secs(1);

impl Console {
    pub(super) fn new(json: bool, quiet: bool, verbose: bool, max_memory: Option<u64>) -> Self {
        let (lost, searches) = (OnceLock::new(), interrupts::Searches::default());
        Self { json, quiet, verbose, max_memory, lost, spoke: Arc::default(), row: None, searches }
    }

    /// The same screen for one of several things that go on at the same time.
    pub(super) fn row(&self, row: Row) -> Self {
        Self {
            row: Some(row),
            spoke: self.spoke.clone(),
            ..Self::new(self.json, self.quiet, self.verbose, self.max_memory)
        }
    }

    /// Its name, where it shares the screen.
    pub(super) fn name(&self) -> Option<&str> {
        self.row.as_ref().map(|row| row.name.as_str())
    }

    /// Makes room for the lines of `of` such things; whether they are there: where a person looks on, and the terminal is high enough.
    pub(super) fn rows(&self, of: usize) -> Arc<Lines> {
        let lines = size()[1];
        let high = of + 2 <= lines;
        match (self.draws(), high) {
            (true, true) => put(&"\n".repeat(of)),
            (true, false) => self.note(&document::too_low(lines, of)),
            _ => {}
        }
        Lines::new(of, high && self.draws())
    }

    /// Whether there is a status.
    pub(super) fn draws(&self) -> bool {
        !self.quiet && !self.json && std::io::stderr().is_terminal()
    }

    fn say(&self, text: &str) {
        match &self.row {
            Some(row) if row.lines.are_drawn() => row.above(text, size()[0], put),
            Some(row) => say(&format!("{}: {text}", row.name)),
            None => say(text),
        }
    }

    /// Whether results are one JSON document.
    pub(crate) fn json(&self) -> bool {
        self.json
    }

    /// A result, on stdout. A reader that has gone away is no error; any other is kept for [`Console::end`], since a
    /// print goes on whatever becomes of the screen.
    pub(crate) fn result(&self, text: &str) {
        self.spoke.store(true, Ordering::Relaxed);
        if let Err(error) = writeln!(std::io::stdout(), "{}", document::visible(text.trim_end())) {
            self.lose(error);
        }
    }

    /// The same; what was `written` to a file as well is not told for `-q`.
    pub(crate) fn summary(&self, text: &str, written: bool) {
        if !(self.quiet && written) {
            self.result(text);
        }
    }

    fn lose(&self, error: Error) {
        if error.kind() != ErrorKind::BrokenPipe {
            let _ = self.lost.set(error);
        }
    }

    /// Whether all results have arrived.
    pub(super) fn end(self) -> Result<(), Failure> {
        if let Err(error) = std::io::stdout().flush() {
            self.lose(error);
        }
        self.lost.into_inner().map_or(Ok(()), |source| Err(Failure::Stdout { source }))
    }

    /// A result as JSON, on stdout.
    pub(crate) fn document(&self, value: &serde_json::Value) {
        self.result(&serde_json::to_string_pretty(value).unwrap_or_default());
    }

    /// Why a verb did not do its work: on stdout too where scripts read that and have read nothing yet.
    pub(super) fn failed(&self, failure: &Failure) {
        if self.json && !self.spoke.load(Ordering::Relaxed) {
            let (text, place) = (failure.to_string(), failure.location());
            self.result(
                &document::failed(failure.code(), &text, failure.exit_code(), place.as_ref(), None).to_string(),
            );
        }
    }

    /// A step that is done, on stderr.
    pub(crate) fn note(&self, text: &str) {
        if !self.quiet {
            self.say(text);
        }
    }

    /// A question, on stderr: whoever is asked must see it, whatever else is quiet.
    pub(crate) fn ask(&self, text: &str) {
        self.say(text);
    }

    /// A detail for `-v`, on stderr.
    pub(crate) fn detail(&self, text: &str) {
        if self.verbose && !self.quiet {
            self.say(text);
        }
    }

    /// Where a long job is: in one place of a terminal, nowhere else.
    pub(crate) fn status(&self, text: &str) {
        match &self.row {
            Some(row) if row.lines.are_drawn() => row.over(text, size()[0], put),
            None if self.draws() => put(&format!("\r{}\x1b[K\r", document::fitting(text, size()[0]))),
            _ => {}
        }
    }

    /// Something the user should know even with `-q`.
    pub(crate) fn warning(&self, text: &str) {
        self.say(&format!("warning: {text}"));
    }

    /// Puts what an earlier run left in the place of `output` aside, and says so.
    pub(super) fn set_aside(&self, output: &OutputFile) -> Result<(), Failure> {
        if let Some(aside) = output.set_aside()? {
            self.warning(&text::set_aside(&aside));
        }
        Ok(())
    }

    /// This computer, with this terminal watching.
    pub(crate) fn world(&self) -> World<'_> {
        let memory = self.max_memory.map(|mb| mb.saturating_mul(1_000_000));
        World { slicers: &Installed { interrupt: interrupts::stop_slicers }, memory, ..World::here(self) }
    }
}

impl Progress for Console {
    fn reached(&self, done: &dyn Any) {
        done.downcast_ref().into_iter().for_each(|model: &LoadedModel| self.note(&text::read(model)));
        done.downcast_ref().into_iter().for_each(|sliced: &SliceResult| self.note(&text::sliced(sliced)));
        if let Some(made) = done.downcast_ref::<PlanResult>() {
            plan::told(made, self);
            plan::search(made, self);
            self.note(text::planned(made).trim_end());
        }
    }

    fn warning(&self, text: &str) {
        Self::warning(self, text);
    }

    fn may_end(&self, known: Option<&str>) {
        self.searches.begin(known.is_some());
        let say = if self.draws() { Self::note } else { Self::detail };
        known.iter().for_each(|known| say(self, &text::searching(known)));
    }

    fn enough(&self) -> bool {
        self.searches.enough()
    }

    fn begin(&self, what: &'static str, of: usize) -> Box<dyn Bar + '_> {
        let shown = !self.quiet && std::io::stderr().is_terminal();
        let told = Cell::new(if std::env::var_os(PROGRESS_VARIABLE).is_some() { 0 } else { usize::MAX });
        Box::new(SlowBar { what, of, shown, told, start: Instant::now(), bar: RefCell::new(None) })
    }
}

/// Why it failed, with the code that `trunnion explain` takes; what is wrong on the command line itself says so without one.
pub(super) fn error(failure: &Failure) {
    let code = Some(failure.code()).filter(|code| !code.starts_with("command/"));
    say(&format!("error{}: {failure}", code.map_or_else(String::new, |code| format!("[{code}]"))));
    failure.location().and_then(|location| job::shown_line(&location)).iter().for_each(|excerpt| say(excerpt));
}

/// Somebody has typed a line, which has moved the cursor behind the screen's `lines`: `wrong` where it means nothing.
pub(super) fn typed(wrong: Option<&str>, lines: Option<&Lines>) {
    match (wrong, lines) {
        (_, Some(lines)) => lines.typed(wrong, size()[0], put),
        (Some(text), None) => say(&format!("error: {text}")),
        (None, None) => {}
    }
}

/// Columns and lines of the terminal; 80 and 24 of one that does not say.
fn size() -> [usize; 2] {
    let size = terminal_size::terminal_size_of(std::io::stderr());
    size.map_or([80, 24], |(columns, lines)| [columns.0.into(), lines.0.into()])
}

/// At once: others write, too.
fn put(text: &str) {
    let _ = std::io::stderr().write_all(text.as_bytes());
}

fn say(text: &str) {
    // What stands in the place of the status goes first.
    let clear = if std::io::stderr().is_terminal() { "\r\x1b[K" } else { "" };
    let _ = writeln!(std::io::stderr(), "{clear}{}", document::visible(text));
}

/// A bar that waits a second before it shows.
struct SlowBar {
    what: &'static str,
    of: usize,
    shown: bool,
    /// For the workbench: hundredths that were reported; of nobody who reads them, all.
    told: Cell<usize>,
    start: Instant,
    bar: RefCell<Option<ProgressBar>>,
}

impl Bar for SlowBar {
    fn at(&self, done: usize) {
        let share = done * 100 / self.of.max(1) + 1;
        if share > self.told.get() {
            self.told.set(share);
            say(&format!("progress: {} {done}/{}", self.what, self.of));
        }
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

impl Drop for SlowBar {
    fn drop(&mut self) {
        if let Some(bar) = self.bar.borrow_mut().take() {
            bar.finish_and_clear();
        }
    }
}
