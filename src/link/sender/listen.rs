//! What each reply does to the count.

use std::time::Duration;

use super::activity::Activity;
use super::ledger::{Purpose, RefusalKind};
use super::phase::Phase;
use super::{Notice, Sender, StopReason, Time};
use crate::gcode::ParsedLine;
use crate::gcode::meaning::{Effect, Hazard, Heater, effect, waits};
use crate::link::protocol::Accounting;
use crate::link::reply::{BufferRoom, Busy, Reply, Temperatures};

/// An error line's companion (`Resend:`, or the next line) comes within this.
const COMPANION: Time = Duration::from_secs(1);

/// Marlin's usual BUFSIZE: of so few lines no refusals are left over.
const USUAL_QUEUE: usize = 4;

/// So many unknown commands are remembered.
const MOST_UNKNOWN: usize = 64;

/// What the printer has said half of; the other half may come in whatever phase.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Dialog {
    /// `Last Line: n`, and when: its `Resend:` follows, or never comes.
    line_error: Option<(i64, Time)>,
    /// An error that may be a wire error whose text noise has spoilt; then its `Resend:` follows.
    error: Option<(String, Time)>,
    pub(super) own_ok: OwnOk,
}

/// The `ok` of a refusal, which answers no line; some firmwares send none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum OwnOk {
    /// None is expected.
    #[default]
    None,
    /// The next `ok` is one.
    Expected,
    /// As long as nothing is under way: an `ok` that comes until then is one, and shows that this firmware sends them.
    Watched(Time),
    /// As long as nothing is under way: until then answers come to proofs that count as answered already.
    Late(Time),
}

impl Sender {
    pub(super) fn hear(&mut self, now: Time, reply: Reply) {
        if !matches!(reply, Reply::Resend(_) | Reply::Temperatures(_) | Reply::Busy(_)) {
            self.error_stands();
        }
        if self.phase.is_over() {
            return;
        }
        if self.phase.is_deaf() && reply.is_answer() {
            self.overhear(now);
            return;
        }
        match reply {
            Reply::Repeated(word) => self.repeated(now, &word),
            Reply::Fatal(text) => self.stop(StopReason::Fatal { text }),
            Reply::Greeting(text) => self.greeted(now, text),
            Reply::Identity(text) => {
                self.heard = now;
                self.identify(&text);
            }
            Reply::Temperatures(t) => {
                if self.waits_long() {
                    self.heard = now;
                }
                self.take_heat(t);
            }
            Reply::Busy(busy) => self.busy(now, busy),
            Reply::Action(action, text) => self.obey(now, action, &text),
            Reply::Position(words) => {
                self.heard = now;
                self.compare(&words);
                self.event(Notice::Position(words));
            }
            reply => match (&self.phase, self.traits().accounting) {
                (Phase::Hello { tries, .. }, _) => self.hear_hello(now, *tries, &reply),
                (_, Accounting::Status) => self.hear_grbl(now, reply),
                _ => self.hear_answer(now, reply),
            },
        }
    }

    fn hear_answer(&mut self, now: Time, reply: Reply) {
        match reply {
            Reply::Ok { number, report, room } => self.hear_ok(now, number, report, room),
            Reply::OkIdentity(text) => {
                self.identify(&text);
                self.hear_ok(now, None, None, None);
            }
            Reply::LineError(last) => self.line_error(now, last),
            Reply::Resend(number) => self.hear_resend(now, number),
            Reply::Unknown(command) => self.unknown(&command),
            Reply::Undone(text) => {
                self.heard = now;
                self.trouble(text);
            }
            Reply::Error(text) => self.error(now, text),
            _ => {}
        }
    }

    fn busy(&mut self, now: Time, busy: Busy) {
        self.heard = now;
        if busy == Busy::User && !self.user_wait {
            self.event(Notice::UserWait);
        }
        self.user_wait = busy == Busy::User;
        if self.user_wait {
            // A person's time is not the printer's.
            self.moved = now;
        }
    }

    fn hear_ok(&mut self, now: Time, number: Option<i64>, report: Option<Temperatures>, room: Option<BufferRoom>) {
        self.heard = now;
        if let Some(t) = report {
            self.take_heat(t);
        }
        if matches!(self.dialog.own_ok, OwnOk::Late(_)) {
            return;
        }
        if number.is_none() && report.is_none() && self.dialog.own_ok != OwnOk::None {
            if matches!(self.dialog.own_ok, OwnOk::Watched(_)) {
                self.printer.ok_follows_resend = true;
            }
            self.dialog.own_ok = OwnOk::None;
            return;
        }
        if let (Some(room), Phase::Flow(_)) = (room, &self.phase) {
            self.take_room(now, number, room);
        }
        // Behind a break of the link an `ok` may be to what went before it.
        if matches!(self.phase, Phase::Flow(_) | Phase::Probe(_)) && !self.phase.asks_after_break() {
            self.answered(now, number, report.is_some());
        }
    }

    fn take_heat(&mut self, heat: Temperatures) {
        self.bed_c = heat.bed.map(|[is_c, _]| is_c).or(self.bed_c);
        self.event(Notice::Temperatures(heat));
    }

    /// A refusal has come: its `ok` may follow.
    fn expect_own_ok(&mut self) {
        let follows = self.printer.ok_follows_resend || matches!(self.phase, Phase::Probe(_));
        if !matches!(self.dialog.own_ok, OwnOk::Watched(_)) {
            self.dialog.own_ok = if follows { OwnOk::Expected } else { OwnOk::None };
        }
    }

    /// `Error:.., Last Line: n`
    fn line_error(&mut self, now: Time, last: Option<i64>) {
        self.heard = now;
        self.expect_own_ok();
        self.dialog.line_error = last.map(|n| (n, now));
    }

    /// Errors whose companion did not come.
    pub(super) fn act_on_errors(&mut self, now: Time) {
        if self.dialog.error.as_ref().is_some_and(|(_, at)| now > *at + COMPANION) {
            self.error_stands();
        }
        if let Some((last, at)) = self.dialog.line_error
            && now > at + COMPANION
        {
            self.dialog.line_error = None;
            self.refuse(now, last.saturating_add(1), false);
        }
    }

    fn error(&mut self, now: Time, text: String) {
        self.heard = now;
        if self.phase.is_fresh() && self.traits().accounting == Accounting::Proof {
            // None of our lines can fail yet: it answers somebody who was here before.
            self.note(format!("ignored an error from an earlier program: {text}"));
        } else if self.traits().accounting == Accounting::Counter {
            // A wire error whose text noise has spoilt is followed by its Resend; any other stands.
            self.dialog.error = Some((text, now));
        } else {
            self.stop_with_error(text);
        }
    }

    fn error_stands(&mut self) {
        if let Some((text, _)) = self.dialog.error.take() {
            self.stop_with_error(text);
        }
    }

    pub(super) fn stop_with_error(&mut self, text: String) {
        // Klipper answers M105, M114 and M115 as ever, and nothing else.
        if text.to_ascii_lowercase().contains("shutdown") {
            self.stop(StopReason::Fatal { text });
            return;
        }
        let line = self.line_of(self.ledger.credited() + 1);
        self.stop(StopReason::Error { text, line });
    }

    fn hear_resend(&mut self, now: Time, number: Option<i64>) {
        self.heard = now;
        self.expect_own_ok();
        self.dialog.error = None;
        let stated = self.dialog.line_error.take().map(|(last, _)| last.saturating_add(1));
        let Some(number) = number else {
            match stated {
                Some(stated) => self.refuse(now, stated, false),
                None => self.doubt(now, "a resend request without a number"),
            }
            return;
        };
        let sure = stated == Some(number);
        if matches!(self.phase, Phase::Probe(_)) {
            // Error and resend that contradict each other say nothing.
            if sure || stated.is_none() {
                self.counter_is(now, number.saturating_sub(1), sure);
            }
            return;
        }
        self.refuse(now, number, sure);
    }

    /// The printer wants `number`; `sure` where error and resend name the same one.
    fn refuse(&mut self, now: Time, number: i64, sure: bool) {
        if number <= self.ledger.proven() || number > self.ledger.cursor() {
            self.doubt(now, "a resend request for an impossible line number");
            return;
        }
        if sure {
            self.credit(now, self.ledger.credited().max(number - 1));
            self.ledger.prove(number - 1);
        }
        if number == self.ledger.cursor() {
            return;
        }
        let RefusalKind::Times(times) = self.ledger.refuse(number) else { return };
        if times > self.most_refusals() {
            self.stop(StopReason::EndlessResend { line: self.line_of(number), times: times - 1 });
            return;
        }
        self.moved = now;
        self.rewind(number, "refused");
    }

    /// So often one line may be refused. Lines that went out twice, since a printer asked for what was under way already, are each refused
    /// in the name of the next one: the longer the queue, the more.
    pub(super) fn most_refusals(&self) -> u32 {
        let queued = self.settings.window_lines.clamp(USUAL_QUEUE, MOST_UNKNOWN) - USUAL_QUEUE;
        self.settings.refusals + 2 * queued as u32
    }

    /// `Unknown command`: of our own line, or of a line that lost its number; then its `ok` is none of ours.
    fn unknown(&mut self, command: &str) {
        let next = self.ledger.credited() + 1;
        let own = match self.ledger.purpose(next) {
            Some(purpose @ (Purpose::Block(_) | Purpose::Own(_))) => purpose.text(&self.program) == command.as_bytes(),
            _ => false,
        };
        if own && !self.unknown.iter().any(|known| known == command) {
            if self.unknown.len() < MOST_UNKNOWN {
                self.unknown.push(command.to_owned());
            }
            if self.matters(next) {
                self.trouble(format!("the printer rejected unknown command {command:?}"));
            } else {
                let line = self.line_of(next);
                self.note(format!("line {line}: the printer ignored unknown command {command:?}"));
            }
        } else if !own && self.traits().accounting == Accounting::Counter && self.dialog.own_ok == OwnOk::None {
            self.dialog.own_ok = OwnOk::Expected;
        }
    }

    /// Whether line `number` is of the file and does anything.
    fn matters(&self, number: i64) -> bool {
        let Some(Purpose::Block(block)) = self.ledger.purpose(number) else { return false };
        let mut line = ParsedLine::default();
        let says = |line: &ParsedLine| {
            matches!(
                effect(self.traits().firmware, line),
                Effect::Report | Effect::Label | Effect::Progress | Effect::Nothing
            )
        };
        line.read(self.program.block(*block)).is_err() || !says(&line)
    }

    /// The line in hand was not carried out as it is written: said, and the head leaves the part until somebody has looked.
    fn trouble(&mut self, text: String) {
        let line = self.line_of(self.ledger.credited() + 1);
        self.event(Notice::Trouble { line, text });
        if self.settings.pauses && matches!(self.activity, Activity::Print { .. }) {
            self.pause();
        }
    }

    /// What the printer is waiting for at the oldest line without an answer, in words.
    pub fn waits_for(&self) -> Option<&'static str> {
        if self.user_wait || self.paused_itself {
            return Some("a person");
        }
        let (_, purpose) = self.ledger.unanswered().next()?;
        let mut line = ParsedLine::default();
        line.read(purpose.text(&self.program)).ok()?;
        match effect(self.traits().firmware, &line) {
            Effect::Heat { heater: Heater::Bed, waits: true, .. } => Some("bed heating"),
            Effect::Heat { heater: Heater::Chamber, waits: true, .. } => Some("chamber heating"),
            Effect::Heat { waits: true, .. } => Some("nozzle heating"),
            Effect::HeatWait => Some("heating"),
            Effect::Home => Some("homing"),
            Effect::Hazard(Hazard::Person) => Some("a person"),
            Effect::Dwell(_) => Some("the end of a dwell"),
            _ => None,
        }
    }

    /// Whether a command is in hand that may take minutes.
    pub(super) fn waits_long(&self) -> bool {
        self.ledger.unanswered().any(|(_, purpose)| match purpose {
            Purpose::Block(index) => self.program.waits(*index),
            Purpose::Own(text) => self.own_line_waits(text),
            _ => false,
        })
    }

    /// What is no G-code is one of Grbl's `$` commands; its homing waits.
    fn own_line_waits(&self, text: &[u8]) -> bool {
        let mut line = ParsedLine::default();
        match line.read(text) {
            Ok(()) => waits(self.traits().firmware, &line),
            Err(_) => text.starts_with(b"$H"),
        }
    }

    /// Seconds of motion that may still lie before the answer: the planner's and the window's blocks.
    pub(super) fn motion_in_hand(&self) -> f64 {
        let first = self.acked_blocks.saturating_sub(self.settings.planner_blocks);
        (first..self.next_block).map(|i| self.program.seconds(i)).sum()
    }
}
