//! Silence, doubt, and the question that a printer must answer with its own line counter.

use std::time::Duration;

use super::activity::Activity;
use super::ledger::Purpose;
use super::listen::OwnOk;
use super::phase::{CounterProbe, Doubt, Phase, Quiet, Session, Witness};
use super::{Sender, StopReason, Time, Watch};
use crate::link::protocol::Accounting;

/// An `ok` that belongs to a resend follows it within this.
const RESENDS_OWN_OK: Time = Duration::from_millis(100);

/// After a greeting the firmware needs this long to listen.
const BOOT: Time = Duration::from_secs(2);

/// A printer that answers and has not repeated the word within this does not repeat words.
const REPEATS: Time = Duration::from_secs(1);
/// A printer that says nothing is called again after this, so often.
const CALL_EVERY: Time = Duration::from_millis(1500);
const CALLS: u32 = 2;
/// A printer that does not repeat it is not asked again before this.
const PAUSE: Time = Duration::from_millis(250);

/// The answer to a last proof may have been lost on the way: at every fourth silence another one goes out.
const ANOTHER_PROOF: u32 = 4;
/// So many are without an answer at once, where no wider window allows more: the printer may be slow with the first, and its queue is short.
const MOST_PROOFS: i64 = 3;

/// Questions have numbers that no printer can take for its next line, however wrong this host may be about its count: so far beyond the last
/// line, and not near it in 16 bits either, in which Repetier compares them.
const BEYOND: i64 = 10_000;

impl Sender {
    /// Time-outs while lines are in flight.
    pub(super) fn check_timeouts(&mut self, now: Time) {
        let locating = self.is_locating() && !self.proves();
        if self.ledger.in_flight() == 0 && !locating {
            return;
        }
        if let Watch::Status { .. } = self.watch {
            if !self.user_wait && self.is_stuck(now) {
                return;
            }
            self.watch_grbl(now);
            return;
        }
        if self.paused_itself {
            return;
        }
        // A person takes his time, and the printer says so again and again; then it may be that only its `ok` is lost.
        if (self.user_wait && now < self.heard + self.settings.long_silence) || self.is_stuck(now) {
            return;
        }
        let asked = if let Watch::Proof { asked, .. } = self.watch { asked } else { Time::ZERO };
        let since = now.saturating_sub(self.heard.max(self.moved).max(asked));
        if since > self.patience() {
            self.doubt(now, "silence");
        }
    }

    /// Stops where no line has been taken for too long.
    fn is_stuck(&mut self, now: Time) -> bool {
        let quiet = now.saturating_sub(self.moved);
        let stuck = quiet > self.settings.no_progress;
        if stuck {
            let line = self.line_of(self.ledger.credited() + 1);
            self.stop(StopReason::NoProgress { seconds: quiet.as_secs_f64(), line });
        }
        stuck
    }

    /// How long a silence is natural.
    fn patience(&self) -> Time {
        let base = if self.waits_long() { self.settings.long_silence } else { self.settings.silence };
        base + Duration::from_secs_f64(1.5 * self.motion_in_hand())
    }

    /// Holds everything until the printer has said where it is.
    pub(super) fn doubt(&mut self, now: Time, why: &'static str) {
        self.lengthen();
        match (self.phase.session(), self.traits().accounting) {
            // Nothing has moved yet: the greeting begins again.
            (Some(Session::Fresh { .. }), _) => self.restart(now),
            (Some(Session::Begun(begun)), Accounting::Counter) if !matches!(self.phase, Phase::Probe(_)) => {
                self.note(format!("{why}: asking the printer for its line counter"));
                self.phase = Phase::Probe(CounterProbe::of(Doubt::Answer(begun)));
            }
            (Some(_), Accounting::Proof) => self.ask_for_proof(now),
            _ => {}
        }
    }

    /// Whether the wait for a resend's own `ok`, or for late answers, is over; says then whether this firmware sends the former.
    pub(super) fn settled(&mut self, now: Time) -> bool {
        let (OwnOk::Watched(until) | OwnOk::Late(until)) = self.dialog.own_ok else { return true };
        if now < until {
            return false;
        }
        self.printer.ok_follows_resend &= !matches!(self.dialog.own_ok, OwnOk::Watched(_));
        self.dialog.own_ok = OwnOk::None;
        true
    }

    /// A proof beyond the window: its answer shows whether others are missing.
    fn ask_for_proof(&mut self, now: Time) {
        let Watch::Proof { asked, unanswered } = &mut self.watch else { return };
        *unanswered += 1;
        *asked = now;
        let questions = *unanswered - 1;
        if questions >= self.settings.questions {
            self.mute(now, questions);
        } else if self.proof_in_flight().is_none() && self.ledger.is_sent() {
            self.make(Purpose::Proof);
            self.ledger.write(self.outbox.end(), &self.program);
        }
    }

    pub(super) fn mute(&mut self, now: Time, questions: u32) {
        if self.input.is_noise() {
            self.stop(StopReason::Noise);
        } else if matches!(self.phase, Phase::Probe(CounterProbe { greeted: true, .. })) {
            self.stop(StopReason::Reset { greeting: "a start-up message, then no answer".to_owned() });
        } else {
            let seconds = now.saturating_sub(self.heard).as_secs_f64();
            let said = self.input.strange.clone();
            self.stop(StopReason::Mute { seconds, questions, said });
        }
    }

    /// The question: a line whose number is wrong on purpose, refused with `Last Line: n`.
    pub(super) fn ask_again(&mut self, now: Time) {
        let Phase::Probe(CounterProbe { greeted, asked, tries, witness, .. }) = self.phase else { return };
        if !self.user_wait && self.is_stuck(now) {
            return;
        }
        if !matches!(witness, Witness::Ours { .. }) {
            self.call(now);
            return;
        }
        if let Some(at) = asked {
            let life = self.heard > at;
            let wait = if self.waits_long() && life { self.settings.long_silence } else { self.settings.silence };
            let motion = Duration::from_secs_f64(self.motion_in_hand());
            if now < at.max(self.heard) + wait + motion {
                return;
            }
            if tries >= self.settings.questions {
                self.mute(now, tries);
                return;
            }
        } else if (greeted && now < self.heard + BOOT) || self.repeats_nothing_yet(now) {
            return;
        }
        self.end_half_line();
        let wrong = self.ledger.last() + BEYOND + i64::from(tries);
        self.ledger.framing().write(self.outbox.end(), wrong, b"M105");
        if let Phase::Probe(probe) = &mut self.phase {
            (probe.asked, probe.tries) = (Some(now), tries + 1);
        }
    }

    /// Ends what an earlier host, or a break of the link, has left of a line.
    fn end_half_line(&mut self) {
        // Smoothie answers a blank line, too.
        if !self.printer.identity.contains("Smoothie") {
            self.outbox.push(b"\n");
        }
    }

    /// Has the printer repeat a word, once no answer to anybody else comes any more: no firmware knows a command of this name, nor one of any of
    /// its beginnings, should this host be killed in the middle of it (`M1` of M118 waits for a person).
    fn call(&mut self, now: Time) {
        let heard = self.heard;
        let Phase::Probe(probe) = &mut self.phase else { return };
        if probe.greeted && now < heard + BOOT {
            return;
        }
        let times = match probe.witness {
            Witness::Quiet(quiet) => {
                let quiet = quiet.unwrap_or(Quiet::from(now));
                probe.witness = Witness::Quiet(Some(quiet));
                if !quiet.is_over(now) {
                    return;
                }
                0
            }
            Witness::Called { answered: Some(at), .. } if now > at + REPEATS => CALLS,
            Witness::Called { at, .. } if now < heard.max(at) + CALL_EVERY => return,
            Witness::Called { times, .. } => times,
            Witness::Ours { .. } => return,
        };
        if times >= CALLS {
            probe.witness = Witness::Ours { proved: false };
            return;
        }
        probe.witness = Witness::Called { at: now, times: times + 1, answered: None };
        self.calls += 1;
        let line = format!("hello trunnion {}\n", self.word());
        self.end_half_line();
        self.outbox.push(line.as_bytes());
    }

    /// What the printer is to repeat: another word each time, and for each host.
    fn word(&self) -> String {
        format!("{:x}.{}", self.settings.nonce, self.calls)
    }

    /// The printer has repeated `word`. What comes from now on is an answer to this host.
    pub(super) fn repeated(&mut self, now: Time, word: &str) {
        let ours = self.calls > 0 && self.word() == word;
        let Phase::Probe(probe) = &mut self.phase else { return };
        if ours && probe.witness != (Witness::Ours { proved: true }) {
            self.heard = now;
            (probe.witness, probe.asked, probe.answer) = (Witness::Ours { proved: true }, None, None);
        }
    }

    /// An answer that may be to another host's question.
    pub(super) fn overhear(&mut self, now: Time) {
        match &mut self.phase {
            Phase::Hello { quiet: Some(quiet), .. } => quiet.disturb(now),
            Phase::Probe(CounterProbe { witness: Witness::Quiet(Some(quiet)), .. }) => quiet.disturb(now),
            Phase::Probe(CounterProbe { witness: Witness::Called { answered, .. }, .. }) => *answered = Some(now),
            _ => {}
        }
    }

    /// Whether a printer that repeats no word may still be answering somebody else.
    fn repeats_nothing_yet(&self, now: Time) -> bool {
        let Phase::Probe(probe) = &self.phase else { return false };
        probe.witness == (Witness::Ours { proved: false }) && now < self.heard + PAUSE
    }

    /// The printer's answer: its last accepted line; `sure` where two of its words say so. A word alone must come twice.
    pub(super) fn counter_is(&mut self, now: Time, found: i64, sure: bool) {
        let (proven, last) = (self.ledger.proven(), self.ledger.last());
        let renumbers = self.ledger.newest() == Some(&Purpose::Renumber);
        let Phase::Probe(probe) = &mut self.phase else { return };
        if let (0, true, true, false, Doubt::Answer(begun)) = (found, sure, renumbers, probe.greeted, probe.doubt) {
            // Our own M110 has set it; after a greeting or a break of the link a reset may have.
            self.phase = Phase::Flow(Session::Begun(begun));
            self.ledger.all_sent();
            self.credit(now, last);
            self.watch_for_ok(now);
            return;
        }
        let possible = (proven..=last).contains(&found);
        let needed = if possible && sure { probe.confirmations() } else { probe.confirmations().max(2) };
        if probe.count(found) < needed {
            probe.asked = None;
        } else if possible {
            let doubt = probe.doubt;
            self.agreed(now, found, doubt);
        } else if probe.anew {
            self.does_not_fit(found);
        } else {
            probe.anew = true;
            probe.begin_anew();
        }
    }

    /// The printer's counter is not where it can be, as it has said again and again.
    fn does_not_fit(&mut self, found: i64) {
        let (proven, last) = (self.ledger.proven(), self.ledger.last());
        let Phase::Probe(probe) = &self.phase else { return };
        let reset = probe.greeted || (found == 0 && proven > 0);
        self.stop(if reset {
            StopReason::Reset { greeting: format!("its line counter changed from {proven} to {found}") }
        } else if last == 0 {
            StopReason::Unrecorded { found }
        } else {
            StopReason::Counter { found, proven, last }
        });
    }

    fn agreed(&mut self, now: Time, found: i64, doubt: Doubt) {
        if matches!(doubt, Doubt::Answer(_)) && self.awaits_its_deeds(found) {
            self.insist(now);
            return;
        }
        self.credit(now, self.ledger.credited().max(found));
        // A proof that it answers may have let blocks go.
        let Some(session) = self.phase.session() else { return };
        self.phase = Phase::Flow(session);
        self.heard = now;
        let times = self.ledger.agree(found);
        if times > self.most_refusals() {
            self.stop(StopReason::EndlessResend { line: self.line_of(found + 1), times: times - 1 });
            return;
        }
        self.watch_for_ok(now);
        if doubt == Doubt::Link {
            // A way back to the part may lead behind what an earlier host has sent.
            self.knows_all |= !matches!(self.activity, Activity::Return { owed: false, .. });
            self.renumber_from();
        } else if self.ledger.cursor() != found + 1 {
            self.rewind(found + 1, "not accepted");
        }
    }

    /// Whether the printer has only taken the line whose answer says that all is done: its counter says what it has read, not what it has carried
    /// out, and what comes next must not begin before that.
    fn awaits_its_deeds(&self, found: i64) -> bool {
        let waits = matches!(self.activity, Activity::Print { ending: true } | Activity::Leave { .. } | Activity::Cool);
        let last = found == self.ledger.last() && found > self.ledger.credited() && self.ledger.is_sent();
        waits && last && self.printer.reports && self.ledger.newest() == Some(&Purpose::Proof)
    }

    /// Waits on for the answer. Nothing is credited, so that a printer which never answers has made no progress.
    fn insist(&mut self, now: Time) {
        let Some(session) = self.phase.session() else { return };
        self.phase = Phase::Flow(session);
        self.heard = now;
        self.insisted += 1;
        // All that went before has been read, so that one line more finds its place however narrow the window is.
        let room = self.ledger.in_flight() < MOST_PROOFS.max(self.settings.window_lines as i64);
        if self.insisted.is_multiple_of(ANOTHER_PROOF) && room {
            self.make(Purpose::Proof);
            self.ledger.write(self.outbox.end(), &self.program);
        }
    }

    /// Nothing is under way, so that an `ok` that comes now is the resend's own.
    fn watch_for_ok(&mut self, now: Time) {
        self.dialog.own_ok = OwnOk::Watched(now + RESENDS_OWN_OK);
    }

    /// After a break of the link: the printer identifies itself again before a line of motion, under new numbers.
    fn renumber_from(&mut self) {
        // Where all are taken, the journal's last word may be older than the printer's.
        self.next_block = self.ledger.first_block().unwrap_or_else(|| self.next_block.max(self.acked_blocks));
        if let Activity::Return { owed, .. } = &mut self.activity
            && std::mem::take(owed)
        {
            let lines = self.return_lines();
            self.own.extend(lines.iter().map(|line| Purpose::Own(line.as_bytes().into())));
        }
        self.place = None;
        let again = self.ledger.take_own();
        again.into_iter().rev().for_each(|line| self.own.push_front(line));
        if !self.own.is_empty() {
            self.own.push_back(Purpose::Proof);
        }
        self.ask_who();
    }

    /// The link is gone. Nothing is sent until [`Sender::reconnected`].
    pub fn lost(&mut self, _now: Time) {
        let Some(session) = self.phase.session() else { return };
        self.input.forget();
        self.outbox.clear();
        self.phase = Phase::Offline(session);
    }

    /// The link is back, with the same device as far as the port can tell; the printer's counter decides.
    pub fn reconnected(&mut self, now: Time) {
        let Phase::Offline(session) = self.phase else { return };
        self.heard = now;
        self.moved = now;
        match (session, self.traits().accounting) {
            (Session::Fresh { .. }, _) => self.restart(now),
            (_, Accounting::Counter) => self.phase = Phase::Probe(CounterProbe::of(Doubt::Link)),
            _ => self.stop(self.unaccounted()),
        }
    }

    /// A greeting in the middle of things.
    pub(super) fn greeted(&mut self, now: Time, text: String) {
        self.heard = now;
        if self.phase.is_fresh() {
            self.restart(now);
        } else if self.traits().accounting == Accounting::Counter {
            // Chatter may contain the word; only the counter tells.
            if !matches!(self.phase, Phase::Probe(_)) {
                self.outbox.drop_unsent(self.traits().ends_half_line);
                self.doubt(now, "a start-up message");
            }
            if let Phase::Probe(probe) = &mut self.phase {
                probe.greeted = true;
                if probe.doubt == Doubt::Link {
                    probe.begin_anew();
                }
            }
        } else {
            self.stop(StopReason::Reset { greeting: text });
        }
    }
}
