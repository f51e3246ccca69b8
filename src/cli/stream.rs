//! The loop between a sender and a port: bytes, clock, journal, interrupts, words for the user.

use std::io::IsTerminal;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use crossbeam_channel::{Receiver, TryRecvError, bounded};
use serde_json::{Value, json};

use super::journal_file::JournalFile;
use super::{Console, Failure};
use crate::link::serial::{Address, Heard, Port, Twin, find_again};
use crate::link::{Event, MarkKind, Outcome, Record, Sender, Stop, Temperatures, Time};

/// Ctrl-C so far: once is a safe pause, twice an emergency stop.
static INTERRUPTS: AtomicU32 = AtomicU32::new(0);

/// What the second Ctrl-C writes by itself, were the print's own thread held up by a disk or by a screen that takes nothing.
static LAST_WORDS: Mutex<Option<(Twin, &'static [u8])>> = Mutex::new(None);

fn keep_last_words(words: Option<(Twin, &'static [u8])>) {
    *LAST_WORDS.lock().unwrap_or_else(PoisonError::into_inner) = words;
}

const NAP: Duration = Duration::from_millis(100);
/// More than a nap, and soon enough.
const HEAD_START: Duration = Duration::from_millis(300);
const EVERY: Duration = Duration::from_secs(1);
const REOPEN_EVERY: Duration = Duration::from_millis(500);
/// After the end the last bytes get this long to leave.
const LAST_BYTES: Duration = Duration::from_secs(2);

/// Catches Ctrl-C from now on.
pub(super) fn catch_interrupts() {
    let _ = ctrlc::set_handler(|| {
        if INTERRUPTS.fetch_add(1, Ordering::Relaxed) == 0 {
            return;
        }
        // The print's own thread stops in better order, if it still can.
        std::thread::sleep(HEAD_START);
        if let Some((port, words)) = LAST_WORDS.lock().unwrap_or_else(PoisonError::into_inner).as_mut() {
            port.write(words);
        }
    });
}

/// Where the printer is, and how it is found again.
pub(super) struct Place {
    pub(super) address: Address,
    pub(super) baud: u32,
    pub(super) identity: Option<String>,
    pub(super) devices: PathBuf,
    pub(super) wait: Duration,
}

pub(super) struct Stream<'a> {
    sender: Sender,
    port: Option<Port>,
    place: Place,
    journal: JournalFile,
    console: &'a Console,
    start: Instant,
    seconds_to: Vec<f64>,
    said: Instant,
    /// Since when no byte has come, once the link was lost.
    lost_at: Option<Instant>,
    tried: Instant,
    temperatures: Temperatures,
    interrupts: u32,
    /// The disk takes nothing more; what is kept for a pause can still be written.
    short: bool,
    /// Not even that.
    full: bool,
    typed: Option<Receiver<String>>,
    paused: bool,
}

impl<'a> Stream<'a> {
    pub(super) fn new(sender: Sender, port: Port, place: Place, journal: JournalFile, console: &'a Console) -> Self {
        let program = sender.program();
        let mut sum = 0.0;
        let mut seconds_to = vec![0.0];
        for index in 0..program.len() {
            sum += program.seconds(index);
            seconds_to.push(sum);
        }
        let now = Instant::now();
        Self {
            sender,
            port: Some(port),
            place,
            journal,
            console,
            start: now,
            seconds_to,
            said: now,
            lost_at: None,
            tried: now,
            temperatures: Temperatures::default(),
            interrupts: INTERRUPTS.load(Ordering::Relaxed),
            short: false,
            full: false,
            typed: None,
            paused: false,
        }
    }

    fn now(&self) -> Time {
        self.start.elapsed()
    }

    /// Runs to the end.
    pub(super) fn run(mut self) -> Result<Outcome, Failure> {
        self.hand_on();
        self.event("start", json!({}));
        let (now, resuming) = (self.now(), self.sender.wake(self.now()).is_none());
        if resuming {
            self.sender.reconnected(now);
        }
        loop {
            self.interrupted(INTERRUPTS.load(Ordering::Relaxed))?;
            if self.port.is_none() && !self.reopened()? {
                continue;
            }
            self.sender.poll(self.now());
            self.take_events();
            let sent = self.write();
            if let Some(outcome) = self.sender.outcome().cloned() {
                return self.close(outcome);
            }
            if self.paused && self.leave_after_pause() {
                self.journal.progress(self.sender.progress(), true);
                return Err(self.paused_for_good());
            }
            self.progress();
            self.listen(sent);
        }
    }

    /// Gives the second Ctrl-C a hand on the port that is open now.
    fn hand_on(&self) {
        let twin = self.port.as_ref().and_then(Port::twin);
        keep_last_words(twin.map(|twin| (twin, self.sender.stop_words())));
    }

    /// Writes the journal first, then bytes; whether all went.
    fn write(&mut self) -> bool {
        // Last words, heaters off or a feed hold, wait for nothing.
        let stopping = self.sender.outcome().is_some();
        let kept = self.journal.retry() && self.journal.progress(self.sender.progress(), false);
        self.keep_room();
        if !kept && !stopping {
            if !std::mem::replace(&mut self.full, true) {
                let path = self.journal.path().display().to_string();
                self.console.warning(&format!("{path}: cannot be written any more; nothing is sent until it can"));
                self.event("full", json!({"journal": path}));
            }
            return false;
        }
        self.full = false;
        let Some(port) = &mut self.port else { return false };
        let count = port.write(self.sender.pending());
        self.sender.took(count);
        self.sender.pending().is_empty()
    }

    /// Pauses where the disk runs full, while the way off the part can still be written down.
    fn keep_room(&mut self) {
        let short = self.journal.renew().is_err();
        if short {
            // Again and again: a pause is not heard on the way back from another.
            self.sender.pause();
        }
        if short && !self.short {
            let path = self.journal.path().display().to_string();
            self.console.warning(&format!("{path}: no room left on the disk for the journal; pausing"));
            self.event("full", json!({"journal": path}));
        }
        self.short = short;
    }

    fn listen(&mut self, sent: bool) {
        let now = self.now();
        let wake = self.sender.wake(now).map_or(NAP, |wake| wake.saturating_sub(now)).min(NAP);
        let Some(port) = &mut self.port else { return };
        // Without room for the journal nothing goes out, whatever room the port has.
        match port.read(wake, !sent && !self.full) {
            Heard::Bytes(bytes) => {
                // Only a word is a sign of life: something between may accept and hang up again and again.
                self.lost_at = None;
                self.sender.receive(self.start.elapsed(), bytes);
            }
            Heard::Gone(why) => self.lost(&why),
            Heard::Nothing => {}
        }
    }

    fn lost(&mut self, why: &str) {
        self.port = None;
        keep_last_words(None);
        let again = self.lost_at.is_some();
        self.lost_at.get_or_insert_with(Instant::now);
        let now = self.now();
        self.sender.lost(now);
        self.journal.progress(self.sender.progress(), true);
        if again {
            return;
        }
        let wait = self.place.wait.as_secs();
        self.console.warning(&format!("the link is gone ({why}); waiting up to {wait} s for the same device"));
        self.event("lost", json!({"why": why}));
    }

    /// Looks for the same device, wherever it is now.
    fn reopened(&mut self) -> Result<bool, Failure> {
        let since = self.lost_at.map_or(Duration::ZERO, |at| at.elapsed());
        if since > self.place.wait {
            let text = format!(
                "the device has not come back within {} s; trunnion send --resume goes on",
                self.place.wait.as_secs()
            );
            self.event("stopped", json!({"reason": text}));
            return Err(Failure::Printer(text));
        }
        if self.tried.elapsed() < REOPEN_EVERY {
            std::thread::sleep(NAP.min(REOPEN_EVERY));
            return Ok(false);
        }
        self.tried = Instant::now();
        let address = find_again(&self.place.address, self.place.identity.as_deref(), &self.place.devices);
        let Ok(port) = Port::open(&address, self.place.baud) else { return Ok(false) };
        self.port = Some(port);
        self.hand_on();
        let now = self.now();
        self.sender.reconnected(now);
        Ok(true)
    }

    fn interrupted(&mut self, count: u32) -> Result<(), Failure> {
        if count == self.interrupts {
            return Ok(());
        }
        // A pause may have come without an interrupt: from a disk that is full.
        let first = self.interrupts == 0 && count == 1 && !self.paused;
        self.interrupts = count;
        if first && self.sender.progress().sent > 0 {
            self.console.note("pausing: the moves under way end first; Ctrl-C again is an emergency stop");
            self.sender.pause();
            return Ok(());
        }
        self.sender.emergency_stop();
        keep_last_words(None);
        let Some(port) = &mut self.port else {
            return Err(Failure::Printer("emergency stop, but the link is gone: switch the printer off".to_owned()));
        };
        // Before the journal, the screen, or anything else that could hang.
        let count = port.write(self.sender.pending());
        self.sender.took(count);
        Ok(())
    }

    fn take_events(&mut self) {
        while let Some(event) = self.sender.next_event() {
            match event {
                Event::Journal(record) => {
                    self.journal.record(&record);
                }
                Event::Connected(identity) => {
                    let first = identity.lines().next().unwrap_or_default().to_owned();
                    self.journal.record(&Record::Printer(first.clone()));
                    self.console.note(&format!("printer: {first}"));
                }
                Event::Resend { number, file_line, why } => {
                    self.console.detail(&format!("line {number} on the wire goes out again ({why})"));
                    self.event("resend", json!({"number": number, "file_line": file_line, "why": why}));
                }
                Event::Temperatures(t) => self.temperatures = t,
                Event::UserWait => self.console.note("the printer waits for somebody"),
                Event::Note(text) => self.console.note(&text),
                Event::Paused => self.pause(),
                Event::Resumed => {
                    self.paused = false;
                    self.event("resumed", json!({}));
                }
                Event::Position(_) | Event::Status(_) | Event::Over(_) => {}
            }
        }
    }

    fn pause(&mut self) {
        self.paused = true;
        self.event("pause", json!({}));
        if std::io::stdin().is_terminal() {
            self.console.note("paused above the part; Enter goes on, c and Enter cancels, Ctrl-C is an emergency stop");
            let (typed, lines) = bounded(1);
            self.typed = Some(lines);
            std::thread::spawn(move || {
                let mut text = String::new();
                // The end of input is no Enter.
                if std::io::stdin().read_line(&mut text).is_ok_and(|n| n > 0) {
                    let _ = typed.send(text);
                }
            });
        }
    }

    /// In a pause: what was typed is done; without a terminal, or behind the end of its input, nobody can type, and the program
    /// ends here.
    fn leave_after_pause(&mut self) -> bool {
        let Some(typed) = &self.typed else { return true };
        let heard = typed.try_recv();
        if matches!(heard, Err(TryRecvError::Disconnected)) {
            return true;
        }
        if let Ok(text) = heard {
            self.typed = None;
            let cancel = text.trim().eq_ignore_ascii_case("c");
            if self.short && !cancel {
                self.console.warning("there is still no room on the disk for the journal");
                self.pause();
                return false;
            }
            self.interrupts = 0;
            INTERRUPTS.store(0, Ordering::Relaxed);
            self.paused = false;
            if cancel { self.sender.cancel() } else { self.sender.resume() }
        }
        false
    }

    fn paused_for_good(&mut self) -> Failure {
        let line = self.line();
        let why = match self.short {
            true => format!("{}: no room left on the disk: ", self.journal.path().display()),
            false => String::new(),
        };
        let first = if self.short { "free some, then " } else { "" };
        let text =
            format!("{why}paused at line {line} above the part, heaters kept; {first}trunnion send --resume goes on");
        self.event("stopped", json!({"reason": text}));
        Failure::Printer(text)
    }

    fn close(&mut self, outcome: Outcome) -> Result<Outcome, Failure> {
        keep_last_words(None);
        let end = Instant::now() + LAST_BYTES;
        while Instant::now() < end && !self.write() {
            std::thread::sleep(Duration::from_millis(5));
        }
        if outcome != Outcome::Done {
            // Last words that nobody will answer: some devices forget them when they are closed at once.
            std::thread::sleep(Duration::from_millis(50));
        }
        // A mere newline ends a line that was cut in two.
        let unsaid = self.sender.pending().iter().any(|b| *b != b'\n');
        self.take_events();
        self.journal.progress(self.sender.progress(), true);
        if unsaid {
            return Err(self.unsaid(&outcome));
        }
        match &outcome {
            Outcome::Done => self.event("done", json!({"resends": self.sender.progress().resends})),
            Outcome::Stopped(why) => {
                self.journal.record(&Record::Stopped(why.to_string()));
                if matches!(why, Stop::Reset { .. }) {
                    self.event("reset", json!({"reason": why.to_string()}));
                }
                self.event("stopped", json!({"reason": why.to_string()}));
            }
            Outcome::Cancelled => self.event("stopped", json!({"reason": "cancelled"})),
            Outcome::EmergencyStopped => self.event("stopped", json!({"reason": "emergency stop"})),
        }
        Ok(outcome)
    }

    /// Last words that the port did not take.
    fn unsaid(&mut self, outcome: &Outcome) -> Failure {
        let why = match outcome {
            Outcome::Stopped(why) => {
                self.journal.record(&Record::Stopped(why.to_string()));
                why.to_string()
            }
            _ => "emergency stop".to_owned(),
        };
        let text = format!("{why}; but the port takes nothing more, not even that: switch the printer off");
        self.event("stopped", json!({"reason": text}));
        Failure::Printer(text)
    }

    fn line(&self) -> u32 {
        let progress = self.sender.progress();
        self.sender.program().file_line(progress.acked.saturating_sub(1))
    }

    fn progress(&mut self) {
        if self.said.elapsed() < EVERY {
            return;
        }
        self.said = Instant::now();
        let (facts, text) = self.facts();
        self.event("progress", facts);
        if !self.console.json() {
            self.console.status(&text);
        }
    }

    fn facts(&self) -> (Value, String) {
        let progress = self.sender.progress();
        let program = self.sender.program();
        let behind = program.marks.partition_point(|m| m.block < progress.acked.max(1));
        let layer = program.marks[..behind].iter().filter(|m| m.kind == MarkKind::Layer).count();
        let slot = program.marks[..behind]
            .iter()
            .rev()
            .find_map(|m| if let MarkKind::Slot(n) = m.kind { Some(n) } else { None });
        let at = |block: u32| self.seconds_to.get(block as usize).copied().unwrap_or(0.0);
        let left = at(program.len()) - at(progress.acked);
        let celsius = |t: Option<[f64; 2]>| t.map(|[now, _]| now);
        let (nozzle, bed) = (celsius(self.temperatures.nozzle), celsius(self.temperatures.bed));
        let facts = json!({
            "layer": layer, "slot": slot, "seconds_left": left, "nozzle_c": nozzle, "bed_c": bed,
            "resends": progress.resends,
        });
        let heat = nozzle.map_or(String::new(), |n| format!(", nozzle {n:.0}, bed {:.0}", bed.unwrap_or(0.0)));
        let slot = slot.map_or(String::new(), |s| format!(", slot {s}"));
        let text = format!(
            "line {} of {}, layer {layer}{slot}, about {:.0} min left{heat}",
            self.line(),
            program.file_line(program.len()),
            left / 60.0
        );
        (facts, text)
    }

    /// One event line with `--json`.
    fn event(&self, name: &str, facts: Value) {
        if !self.console.json() {
            return;
        }
        let program = self.sender.program();
        let mut line = json!({"event": name, "line": self.line(), "of": program.file_line(program.len())});
        if let (Some(all), Value::Object(more)) = (line.as_object_mut(), facts) {
            all.extend(more);
        }
        self.console.result(&line.to_string());
    }
}

#[cfg(test)]
mod tests;
