//! Grbl, grblHAL, FluidNC: no counter, no checksum; answers are counted and the status report is the witness.
//!
//! A status report that shows more bytes in the receive buffer than are counted as unanswered proves a false `ok`; a machine
//! that idles while lines are unanswered proves a lost one. Either stops the print in feed hold, since neither can be told
//! from a line that was lost or run into another.

use std::time::Duration;

use super::ledger::Purpose;
use super::phase::Phase;
use super::{Notice, Sender, StopReason, Time, Watch};
use crate::link::reply::{Reply, Status};

/// How often the status is asked for.
pub(super) const STATUS_EVERY: Time = Duration::from_millis(500);
/// Statuses without an answer before the machine counts as mute.
const UNANSWERED: Time = Duration::from_secs(10);
/// An idle machine answers within this.
const IDLE: Time = Duration::from_secs(2);

impl Sender {
    pub(super) fn hear_hello_grbl(&mut self, now: Time, reply: &Reply) {
        // What comes before a question has gone out answers an earlier one, if not an earlier host's.
        if !self.outbox.pending().is_empty() {
            return;
        }
        match reply {
            Reply::Ok { .. } => self.ask_status(),
            Reply::Status(status) if self.is_locating() && status.state.starts_with("Run") => {
                // What it was sent before ends first.
                self.phase = Phase::Hello { asked: Some(now), tries: 0, quiet: None };
            }
            Reply::Status(status)
                if self.is_locating() && status.state.starts_with("Idle") && self.printer.identity.is_empty() =>
            {
                self.outbox.push(b"$I\n");
            }
            Reply::Status(status) if status.state.starts_with("Idle") => {
                self.take_offset(status);
                self.flow(now, 0);
                self.take_buffer_size();
                self.open();
            }
            // A locked machine takes its own homing, with which our own lines begin then.
            Reply::Status(status) if status.state.starts_with("Alarm") && self.homes_first() => {
                self.flow(now, 0);
                self.take_buffer_size();
                self.open();
            }
            Reply::Status(status) => {
                let hint =
                    if status.state.starts_with("Alarm") { "; home it ($H) or unlock it ($X) first" } else { "" };
                let locked = status.state.starts_with("Alarm");
                self.stop(StopReason::NotReady { state: format!("its state is {}{hint}", status.state), locked });
            }
            Reply::Refused(code) => {
                let state = format!("it answers error:{code} ({}) to $I", meaning(*code));
                self.stop(StopReason::NotReady { state, locked: false });
            }
            Reply::Alarm(code) => {
                self.stop(StopReason::NotReady { state: format!("ALARM:{code}; home it ($H) first"), locked: true })
            }
            _ => {}
        }
    }

    fn take_offset(&mut self, status: &Status) {
        if let Some(offset) = &status.offset {
            self.offset.clone_from(offset);
        }
    }

    fn homes_first(&self) -> bool {
        matches!(self.own.front(), Some(Purpose::Own(text)) if text.starts_with(b"$"))
    }

    /// Whether a line of our own that unlocks the machine is still to be answered.
    fn homing(&self) -> bool {
        let mut unanswered = self.ledger.unanswered();
        self.homes_first() || unanswered.any(|(_, p)| matches!(p, Purpose::Own(text) if text.starts_with(b"$")))
    }

    /// `[OPT:V,15,128]`: planner blocks, receive bytes.
    fn take_buffer_size(&mut self) {
        let line = self.printer.identity.lines().find_map(|l| l.strip_prefix("[OPT:"));
        let sizes = line.map(|l| l.trim_end_matches(']').split(',').collect::<Vec<_>>());
        if let Some(bytes) = sizes.and_then(|s| s.get(2)?.parse::<usize>().ok()) {
            if let Watch::Status { buffer, .. } = &mut self.watch {
                *buffer = bytes;
            }
            self.settings.window_bytes = self.settings.window_bytes.min(bytes.saturating_sub(self.traits().margin));
        }
    }

    pub(super) fn hear_grbl(&mut self, now: Time, reply: Reply) {
        match reply {
            Reply::Ok { .. } => {
                self.heard = now;
                if let Watch::Status { idle_since, .. } = &mut self.watch {
                    *idle_since = None;
                }
                self.answered(now, None, false);
            }
            Reply::Refused(code) if self.ledger.in_flight() > 0 => {
                let line = self.line_of(self.ledger.credited() + 1);
                self.stop(StopReason::Refused { line, code, meaning: meaning(code) });
            }
            Reply::Alarm(code) => self.stop(StopReason::Fatal { text: format!("ALARM:{code} ({})", alarm(code)) }),
            Reply::Error(text) => self.stop_with_error(text),
            Reply::Status(status) => self.status(now, status),
            _ => {}
        }
    }

    fn status(&mut self, now: Time, status: Status) {
        self.heard = now;
        let waiting = status.state.starts_with("Hold") || status.state.starts_with("Door");
        if waiting && !self.user_wait {
            self.event(Notice::UserWait);
        }
        self.user_wait = waiting;
        if status.state.starts_with("Alarm") && !self.homing() {
            self.stop(StopReason::Fatal { text: format!("its state is {}", status.state) });
            return;
        }
        self.take_offset(&status);
        self.locate(&status);
        let in_flight = self.ledger.in_flight() > 0;
        let idle = status.state.starts_with("Idle") && in_flight;
        let free = status.free;
        self.event(Notice::Status(status));
        let Watch::Status { idle_since, buffer, .. } = &mut self.watch else { return };
        let used = free.map_or(0, |[_, bytes]| buffer.saturating_sub(bytes));
        // One byte of the ring is never used, and grblHAL counts it as used.
        let too_many = used > self.ledger.bytes_out() + 1;
        *idle_since = idle.then(|| idle_since.unwrap_or(now));
        if too_many || idle_since.is_some_and(|since| now > since + IDLE) {
            self.stop(self.unaccounted());
        }
    }

    /// Asks for the status now and then, and gives up where none comes.
    pub(super) fn watch_grbl(&mut self, now: Time) {
        let Watch::Status { asked, .. } = &mut self.watch else { return };
        if now > *asked + STATUS_EVERY {
            *asked = now;
            self.ask_status();
        }
        if now > self.heard.max(self.moved) + UNANSWERED {
            self.mute(now, (UNANSWERED.as_millis() / STATUS_EVERY.as_millis()) as u32);
        }
    }

    pub(super) fn ask_status(&mut self) {
        if let Some(bytes) = self.traits().real_time {
            self.outbox.push(&[bytes.status]);
        }
    }
}

fn meaning(code: u32) -> &'static str {
    match code {
        1 => "a letter was expected",
        2 => "a number is missing or wrong",
        8 => "only allowed when idle",
        9 => "locked: home or unlock it",
        11 => "the line is too long",
        15 => "beyond the machine's travel",
        20 => "an unknown command",
        22 => "no feed rate",
        24 => "two commands use the same axis words",
        33 => "an impossible arc",
        _ => "see the firmware's list",
    }
}

fn alarm(code: u32) -> &'static str {
    match code {
        1 => "hard limit",
        2 => "soft limit",
        3 => "reset while moving",
        8 | 9 => "homing failed",
        _ => "see the firmware's list",
    }
}
