//! The loop between a sender and a port: bytes, clock, journal, interrupts.

use std::path::PathBuf;
use std::time::Duration;

use super::error::SendError;
use super::figures::Timing;
use super::operator::{Answer, At, Operator, Sending};
use crate::link::serial::{Address, Heard, Port};
use crate::link::{AfterStop, Notice, Outcome, Record, Sender, StopReason, Temperatures, Time};
use crate::world::JournalFile;
use crate::world::World;

const NAP: Duration = Duration::from_millis(100);
const EVERY: Duration = Duration::from_secs(1);
const REOPEN_EVERY: Duration = Duration::from_millis(500);
/// After the end the last bytes get this long to leave.
const LAST_BYTES: Duration = Duration::from_secs(2);

/// Where the printer is, how it is found again, and how long it takes.
#[derive(Clone)]
pub(super) struct Connection {
    pub(super) timing: Timing,
    pub(super) address: Address,
    pub(super) baud: u32,
    pub(super) identity: Option<String>,
    pub(super) devices: PathBuf,
    pub(super) wait: Duration,
}

pub(super) struct Stream<'a> {
    sender: Sender,
    port: Option<Port>,
    place: Connection,
    journal: JournalFile,
    world: &'a World<'a>,
    operator: &'a dyn Operator,
    start: Duration,
    said: Time,
    /// Since when no byte has come, once the link was lost.
    lost_at: Option<Time>,
    tried: Time,
    temperatures: Temperatures,
    interrupts: u32,
    /// The disk takes nothing more; what is kept for a pause can still be written.
    short: bool,
    /// Not even that.
    full: bool,
    paused: bool,
    /// What it pauses for, where the printer has left something undone.
    trouble: Option<String>,
}

impl<'a> Stream<'a> {
    pub(super) fn new(
        sender: Sender,
        port: Port,
        place: Connection,
        journal: JournalFile,
        world: &'a World<'a>,
        operator: &'a dyn Operator,
    ) -> Self {
        Self {
            sender,
            port: Some(port),
            place,
            journal,
            world,
            operator,
            start: world.clock.now(),
            said: Time::ZERO,
            lost_at: None,
            tried: Time::ZERO,
            temperatures: Temperatures::default(),
            interrupts: operator.interrupts(),
            short: false,
            full: false,
            paused: false,
            trouble: None,
        }
    }

    fn now(&self) -> Time {
        self.world.clock.now().saturating_sub(self.start)
    }

    /// Runs to the end.
    pub(super) fn run(mut self) -> Result<Outcome, SendError> {
        self.hand_on();
        self.tell(&Sending::Start);
        let (now, resuming) = (self.now(), self.sender.wake(self.now()).is_none());
        if resuming {
            self.sender.reconnected(now);
        }
        loop {
            self.interrupted(self.operator.interrupts())?;
            if self.port.is_none() && !self.reopened()? {
                continue;
            }
            self.sender.poll(self.now());
            if let Some(outcome) = self.sender.outcome().cloned() {
                return self.close(outcome);
            }
            self.take_events();
            let sent = self.write();
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
        self.operator.last_words(twin.map(|twin| (twin, self.sender.stop_words())));
    }

    /// Writes the journal first, then bytes; whether all went. Last words, heaters off or a feed hold, wait for no journal.
    fn write(&mut self) -> bool {
        if self.sender.outcome().is_some() {
            return self.put();
        }
        let kept = self.journal.retry() && self.journal.progress(self.sender.progress(), false);
        self.keep_room();
        if !kept {
            if !std::mem::replace(&mut self.full, true) {
                let journal = &self.journal.path().display().to_string();
                self.tell(&Sending::Full { journal });
            }
            return false;
        }
        self.full = false;
        self.put()
    }

    /// Writes what the port takes; whether all went.
    fn put(&mut self) -> bool {
        let Some(port) = &mut self.port else { return false };
        let count = port.write(self.sender.pending());
        self.sender.took(count);
        self.sender.pending().is_empty()
    }

    /// Pauses where the disk runs full, while the way off the part can still be written down.
    fn keep_room(&mut self) {
        let short = self.journal.renew().is_err();
        if short && !self.short {
            self.sender.pause();
            let journal = &self.journal.path().display().to_string();
            self.tell(&Sending::Short { journal });
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
                self.sender.receive(self.world.clock.now().saturating_sub(self.start), bytes);
            }
            Heard::Gone(why) => self.lost(&why),
            Heard::Nothing => {}
        }
    }

    fn lost(&mut self, why: &str) {
        self.port = None;
        self.operator.last_words(None);
        let again = self.lost_at.is_some();
        let now = self.now();
        self.lost_at.get_or_insert(now);
        self.sender.lost(now);
        self.journal.progress(self.sender.progress(), true);
        if again {
            return;
        }
        self.tell(&Sending::Lost { why, wait: self.place.wait });
    }

    /// Looks for the same device, wherever it is now.
    fn reopened(&mut self) -> Result<bool, SendError> {
        let since = self.lost_at.map_or(Duration::ZERO, |at| self.now().saturating_sub(at));
        if since > self.place.wait {
            let text = format!(
                "the device did not come back within {} s; continue with trunnion send --resume",
                self.place.wait.as_secs()
            );
            self.tell(&Sending::Stopped { reason: &text });
            return Err(SendError::Printer(text));
        }
        if self.now().saturating_sub(self.tried) < REOPEN_EVERY {
            self.world.clock.sleep(NAP.min(REOPEN_EVERY));
            return Ok(false);
        }
        self.tried = self.now();
        let place = &self.place;
        let address = self.world.ports.find_again(&place.address, place.identity.as_deref(), &place.devices);
        let Ok(port) = self.world.ports.open(&address, place.baud) else { return Ok(false) };
        self.port = Some(port);
        self.hand_on();
        let now = self.now();
        self.sender.reconnected(now);
        Ok(true)
    }

    fn interrupted(&mut self, count: u32) -> Result<(), SendError> {
        if count == self.interrupts {
            return Ok(());
        }
        // A pause may have come without an interrupt: from a disk that is full.
        let first = self.interrupts == 0 && count == 1 && !self.paused;
        self.interrupts = count;
        if first && !self.sender.has_begun() {
            let text = "stopped before anything moved or heated: the printer is unchanged";
            return Err(SendError::Printer(text.to_owned()));
        }
        if first && self.sender.progress().sent > 0 {
            self.tell(&Sending::Pausing { waits_for: self.sender.waits_for() });
            self.sender.pause();
            return Ok(());
        }
        self.sender.emergency_stop();
        self.operator.last_words(None);
        let Some(port) = &mut self.port else {
            return Err(SendError::Printer(
                "emergency stop, but the connection is lost: switch the printer off".to_owned(),
            ));
        };
        // Before the journal, the screen, or anything else that could hang.
        let count = port.write(self.sender.pending());
        self.sender.took(count);
        Ok(())
    }

    fn take_events(&mut self) {
        while let Some(event) = self.sender.next_event() {
            match event {
                Notice::Journal(record) => {
                    self.journal.record(&record);
                }
                Notice::Connected(identity) => {
                    let first = identity.lines().next().unwrap_or_default().to_owned();
                    self.journal.record(&Record::Printer(first.clone()));
                    self.tell(&Sending::Printer(&first));
                }
                Notice::Resend { number, file_line, why } => {
                    self.tell(&Sending::Resend { number, file_line, why });
                }
                Notice::Temperatures(t) => self.temperatures = t,
                Notice::UserWait => self.tell(&Sending::UserWait),
                Notice::Trouble { line, text } => {
                    self.tell(&Sending::Trouble { file_line: line, text: &text });
                    self.trouble = Some(format!("at line {line} of the file the printer reports: {text}; "));
                }
                Notice::Note(text) => self.tell(&Sending::Note(&text)),
                Notice::Paused => self.pause(),
                Notice::Resumed => {
                    (self.paused, self.trouble) = (false, None);
                    self.tell(&Sending::Resumed);
                }
                Notice::Position(_) | Notice::Status(_) | Notice::Over(_) => {}
            }
        }
    }

    fn pause(&mut self) {
        self.paused = true;
        self.tell(&Sending::Paused);
    }

    /// In a pause: what somebody says is done; where nobody can say anything, the job ends here.
    fn leave_after_pause(&mut self) -> bool {
        let answer = self.operator.answer();
        match answer {
            Answer::Nobody => return true,
            Answer::NotYet => {}
            Answer::Continue if self.short => {
                self.tell(&Sending::StillShort);
                self.pause();
            }
            Answer::Continue | Answer::Cancel => {
                self.interrupts = 0;
                self.operator.forget_interrupts();
                self.paused = false;
                if answer == Answer::Cancel { self.sender.cancel() } else { self.sender.resume() }
            }
        }
        false
    }

    fn paused_for_good(&mut self) -> SendError {
        let line = self.line();
        let why = match self.short {
            true => format!("{}: no disk space left: ", self.journal.path().display()),
            false => self.trouble.take().unwrap_or_default(),
        };
        let first = if self.short { "free some disk space, then " } else { "" };
        let again = self.sender.way_back();
        let heat = if self.sender.program().firmware().is_printer() { " and the heaters on" } else { "" };
        let text = format!(
            "{why}paused at line {line} with the head above the part{heat}; {first}continue with trunnion send --resume{again}"
        );
        self.tell(&Sending::Stopped { reason: &text });
        SendError::Printer(text)
    }

    fn close(&mut self, outcome: Outcome) -> Result<Outcome, SendError> {
        let end = self.now() + LAST_BYTES;
        while self.now() < end && !self.put() {
            self.world.clock.sleep(Duration::from_millis(5));
        }
        if outcome != Outcome::Done {
            // Last words that nobody will answer: some devices forget them when they are closed at once.
            self.world.clock.sleep(Duration::from_millis(50));
        }
        // A mere newline ends a line that was cut in two.
        let unsaid = self.sender.pending().iter().any(|b| *b != b'\n');
        self.take_events();
        self.journal.progress(self.sender.progress(), true);
        self.say_sent();
        self.operator.last_words(None);
        if unsaid {
            return Err(self.unsaid(&outcome));
        }
        if outcome == Outcome::EmergencyStopped {
            return self.stopped_or_not();
        }
        match &outcome {
            Outcome::Done => self.tell(&Sending::Done { resends: self.sender.progress().resends }),
            Outcome::Stopped(why) => {
                let reason = &why.to_string();
                self.journal.record(&Record::Stopped(reason.clone()));
                if matches!(why, StopReason::Reset { .. }) {
                    self.tell(&Sending::Reset { reason });
                }
                self.tell(&Sending::Stopped { reason });
            }
            Outcome::Cancelled => self.tell(&Sending::Stopped { reason: "cancelled" }),
            Outcome::EmergencyStopped => {}
        }
        Ok(outcome)
    }

    /// Behind an emergency stop: stays until the printer has stopped, and says whether it has.
    fn stopped_or_not(&mut self) -> Result<Outcome, SendError> {
        let text = match self.watch() {
            AfterStop::Stopped => {
                self.tell(&Sending::Stopped { reason: "emergency stop" });
                return Ok(Outcome::EmergencyStopped);
            }
            AfterStop::Silent => {
                "emergency stop sent, but the printer has not answered since: check that it stopped, or switch it off"
                    .to_owned()
            }
            AfterStop::GoesOn(said) => {
                format!("emergency stop sent, but the printer has NOT stopped (it reports {said:?}): switch it off")
            }
        };
        self.tell(&Sending::Stopped { reason: &text });
        Err(SendError::Printer(text))
    }

    /// Listens behind the emergency stop, which is said again now and then.
    fn watch(&mut self) -> AfterStop {
        let (mut watch, mut said) = (self.sender.stop_watch(self.now()), self.now());
        loop {
            let now = self.now();
            if let Some(verdict) = watch.verdict(now) {
                return verdict;
            }
            let Some(port) = &mut self.port else { return AfterStop::Silent };
            if now >= said + EVERY {
                said = now;
                port.write(self.sender.stop_words());
            }
            match port.read(NAP, false) {
                Heard::Bytes(bytes) => watch.receive(now, bytes),
                Heard::Gone(_) => watch.gone(),
                Heard::Nothing => {}
            }
        }
    }

    /// How far it has come at most, which a host that is killed cannot say.
    fn say_sent(&mut self) {
        if let Some(sent) = self.sender.sent_at_most() {
            self.journal.record(&Record::Sent(sent));
        }
    }

    /// Last words that the port did not take.
    fn unsaid(&mut self, outcome: &Outcome) -> SendError {
        let why = match outcome {
            Outcome::Stopped(why) => {
                self.journal.record(&Record::Stopped(why.to_string()));
                why.to_string()
            }
            _ => "emergency stop".to_owned(),
        };
        let text = format!("{why}; the port does not even accept the stop command: switch the printer off");
        self.tell(&Sending::Stopped { reason: &text });
        SendError::Printer(text)
    }

    fn line(&self) -> u32 {
        let progress = self.sender.progress();
        self.sender.program().file_line(progress.acked.saturating_sub(1))
    }

    fn progress(&mut self) {
        let now = self.now();
        if now.saturating_sub(self.said) < EVERY {
            return;
        }
        self.said = now;
        let figures = self.place.timing.figures(&self.sender, self.temperatures);
        self.tell(&Sending::Progress(figures));
    }

    fn tell(&self, what: &Sending<'_>) {
        let program = self.sender.program();
        self.operator.told(what, At { line: self.line(), of: program.file_line(program.len()) });
    }
}

#[cfg(test)]
mod tests;
