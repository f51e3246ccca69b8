//! What each reply does to the count.

use std::time::Duration;

use super::{Event, Sender, Stage, Stop, Time, What};
use crate::gcode::ParsedLine;
use crate::gcode::meaning::waits;
use crate::link::reply::{Busy, Reply};
use crate::link::wire::Protocol;

/// An error line's companion (`Resend:`, or the next line) comes within this.
const COMPANION: Time = Duration::from_millis(1000);

impl Sender {
    pub(super) fn hear(&mut self, now: Time, reply: Reply) {
        if self.pending_error.is_some() && !matches!(reply, Reply::Resend(_) | Reply::Temperatures(_) | Reply::Busy(_))
        {
            self.pending_error_stands();
            if self.stage == Stage::Over {
                return;
            }
        }
        match reply {
            Reply::Fatal(text) => self.stop(Stop::Fatal { text }),
            Reply::Greeting(text) => self.greeted(now, text),
            Reply::Identity(text) => {
                self.heard = now;
                self.identify(&text);
            }
            Reply::Temperatures(t) => {
                if self.waits_long() {
                    self.heard = now;
                }
                self.event(Event::Temperatures(t));
            }
            Reply::Busy(busy) => self.busy(now, busy),
            Reply::Position(words) => {
                self.heard = now;
                self.compare(&words);
                self.event(Event::Position(words));
            }
            _ if matches!(self.stage, Stage::Hello { .. }) => self.hear_hello(now, &reply),
            _ if self.settings.protocol == Protocol::Grbl => self.hear_grbl(now, reply),
            Reply::Ok { number, report } => self.hear_ok(now, number, report),
            Reply::LineError(last) => self.line_error(now, last),
            Reply::Resend(number) => self.hear_resend(now, number),
            Reply::Unknown(command) => self.unknown(&command),
            Reply::Error(text) => self.error(now, text),
            Reply::Refused(_) | Reply::Alarm(_) | Reply::Status(_) | Reply::Chatter => {}
        }
    }

    fn busy(&mut self, now: Time, busy: Busy) {
        self.heard = now;
        if busy == Busy::User && !self.user_wait {
            self.event(Event::UserWait);
        }
        self.user_wait = busy == Busy::User;
    }

    fn hear_ok(&mut self, now: Time, number: Option<i64>, report: Option<crate::link::reply::Temperatures>) {
        self.heard = now;
        if let Some(t) = report {
            self.event(Event::Temperatures(t));
        }
        if self.swallow_ok && number.is_none() && report.is_none() {
            self.swallow_ok = false;
            return;
        }
        if matches!(self.stage, Stage::Flow | Stage::Probe { .. }) {
            self.answered(now, number, report.is_some());
        }
    }

    /// `Error:.., Last Line: n`: its `Resend:` follows, or never comes.
    fn line_error(&mut self, now: Time, last: Option<i64>) {
        self.heard = now;
        self.swallow_ok = self.resends_end_with_ok || matches!(self.stage, Stage::Probe { .. });
        self.pending_last = last.map(|n| (n, now));
    }

    /// Errors whose companion did not come.
    pub(super) fn act_on_pending(&mut self, now: Time) {
        if self.pending_error.as_ref().is_some_and(|(_, at)| now > *at + COMPANION) {
            self.pending_error_stands();
        }
        if let Some((last, at)) = self.pending_last
            && now > at + COMPANION
        {
            self.pending_last = None;
            self.refuse(now, last.saturating_add(1), false);
        }
    }

    fn error(&mut self, now: Time, text: String) {
        self.heard = now;
        if self.settings.protocol == Protocol::Marlin {
            // A wire error whose text noise has spoilt is followed by its Resend; any other stands.
            self.pending_error = Some((text, now));
        } else {
            self.stop_with_error(text);
        }
    }

    fn pending_error_stands(&mut self) {
        if let Some((text, _)) = self.pending_error.take() {
            self.stop_with_error(text);
        }
    }

    fn stop_with_error(&mut self, text: String) {
        let line = self.line_of(self.credited + 1);
        self.stop(Stop::Error { text, line });
    }

    fn hear_resend(&mut self, now: Time, number: Option<i64>) {
        self.heard = now;
        self.swallow_ok = self.resends_end_with_ok || matches!(self.stage, Stage::Probe { .. });
        self.pending_error = None;
        let stated = self.pending_last.take().map(|(last, _)| last.saturating_add(1));
        let Some(number) = number else {
            match stated {
                Some(stated) => self.refuse(now, stated, false),
                None => self.doubt(now, "a resend without a number"),
            }
            return;
        };
        let sure = stated == Some(number);
        if matches!(self.stage, Stage::Probe { .. }) {
            if sure {
                self.counter_is(now, number - 1);
            }
            return;
        }
        self.refuse(now, number, sure);
    }

    /// The printer wants `number`; `sure` where error and resend name the same one.
    pub(super) fn refuse(&mut self, now: Time, number: i64, sure: bool) {
        if number <= self.proven || number > self.cursor {
            self.doubt(now, "a resend of a line that cannot be wanted");
            return;
        }
        if sure {
            self.credit(now, self.credited.max(number - 1));
            self.prove(number - 1);
        }
        if number == self.cursor {
            return;
        }
        if self.refused.0 == number && self.refused.2 > 0 {
            // Of a line that was under way behind the refused one.
            self.refused.2 -= 1;
            return;
        }
        let times = if self.refused.0 == number { self.refused.1 + 1 } else { 1 };
        if times > self.settings.refusals {
            self.stop(Stop::EndlessResend { line: self.line_of(number), times: times - 1 });
            return;
        }
        let behind = u32::try_from(self.cursor - 1 - number).unwrap_or(0);
        self.refused = (number, times, behind);
        self.moved = now;
        self.rewind(number, "refused");
    }

    /// `Unknown command`: of our own line, or of a line that lost its number; then its `ok` is none of ours.
    fn unknown(&mut self, command: &str) {
        let own = match self.what(self.credited + 1) {
            Some(What::Block(index)) => self.program.block(*index) == command.as_bytes(),
            Some(What::Script(text)) => **text == *command.as_bytes(),
            _ => false,
        };
        if own {
            let line = self.line_of(self.credited + 1);
            self.note(format!("line {line}: the printer does not know {command:?} and went on"));
        } else if self.settings.protocol == Protocol::Marlin {
            self.swallow_ok = true;
        }
    }

    /// Whether a command is in hand that may take minutes.
    pub(super) fn waits_long(&self) -> bool {
        (self.credited + 1..self.cursor).any(|n| match self.what(n) {
            Some(What::Block(index)) => self.program.waits(*index),
            Some(What::Script(text)) => self.script_waits(text),
            _ => false,
        })
    }

    /// What is no G-code is one of Grbl's `$` commands; its homing waits.
    fn script_waits(&self, text: &[u8]) -> bool {
        let mut line = ParsedLine::default();
        match line.read(text) {
            Ok(()) => waits(self.settings.protocol.firmware(), &line),
            Err(_) => text.starts_with(b"$H"),
        }
    }

    /// Seconds of motion that may still lie before the answer: the planner's and the window's blocks.
    pub(super) fn motion_in_hand(&self) -> f64 {
        let first = self.acked_blocks.saturating_sub(self.settings.planner_blocks);
        (first..self.next_block).map(|i| self.program.seconds(i)).sum()
    }
}
