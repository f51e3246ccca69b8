//! What is still sent when a print ends.

use super::outcome::{Outcome, StopReason};
use super::phase::Phase;
use super::{Notice, Sender};
use crate::link::protocol::Accounting;

impl Sender {
    /// Ends at once; heaters by policy where the printer still listens.
    pub(super) fn stop(&mut self, why: StopReason) {
        if self.phase.is_over() {
            return;
        }
        let traits = self.traits();
        self.outbox.drop_unsent(traits.ends_half_line);
        match traits.real_time {
            // A feed hold keeps the position; a soft reset would not.
            Some(bytes) if why.holds() => {
                self.outbox.push(&[bytes.hold]);
            }
            None if why.answers() => {
                for line in self.settings.retreat.heaters_on_stop(self.settings.protocol) {
                    self.outbox.push(line.as_bytes());
                    self.outbox.push(b"\n");
                }
            }
            _ => {}
        }
        self.finish(Outcome::Stopped(why));
    }

    /// Ends, if it has not ended before.
    pub(super) fn finish(&mut self, outcome: Outcome) {
        if !self.phase.is_over() {
            self.phase = Phase::Over(outcome.clone());
            self.event(Notice::Over(outcome));
        }
    }

    /// Emergency stop: the next bytes on the wire, whatever was waiting.
    pub fn emergency_stop(&mut self) {
        if self.phase == Phase::Over(Outcome::EmergencyStopped) {
            return;
        }
        let traits = self.traits();
        self.outbox.drop_unsent(traits.ends_half_line);
        if traits.real_time.is_some() {
            self.outbox.clear();
        }
        self.outbox.push(traits.emergency);
        if traits.accounting == Accounting::Counter {
            // Where the line before it was cut, the first one is swallowed with its rest.
            self.ledger.framing().write(self.outbox.end(), self.ledger.cursor(), b"M112");
        }
        self.finish(Outcome::EmergencyStopped);
    }

    /// Whether something that moves or heats has been sent, now or before the link or the host broke.
    pub fn has_begun(&self) -> bool {
        !self.phase.is_fresh()
    }

    /// What a pause is to be ended with `--resume` under, where that does not hold always.
    pub fn way_back(&self) -> &'static str {
        let homes = !self.settings.retreat.home.is_empty();
        if homes {
            ""
        } else {
            "; leave the printer switched on: [link] rehome is empty, so its position must not be lost"
        }
    }

    /// Bytes that stop the printer whatever was sent before, for whoever cannot wait for [`Sender::emergency_stop`].
    pub fn stop_words(&self) -> &'static [u8] {
        self.traits().emergency_raw
    }
}
