//! Silence, doubt, and the question that a printer must answer with its own count.

use std::time::Duration;

use super::{Event, Sender, Stage, Stop, Time, What};
use crate::link::wire::{Protocol, push_numbered};

/// An `ok` that belongs to a resend follows it within this.
const RESENDS_OWN_OK: Time = Duration::from_millis(100);

/// After a greeting the firmware needs this long to listen.
const BOOT: Time = Duration::from_secs(2);

impl Sender {
    /// Time-outs while lines are in flight.
    pub(super) fn watch(&mut self, now: Time) {
        if self.in_flight() == 0 {
            return;
        }
        // A person takes his time, and the printer says so again and again; then it may be that only its `ok` is lost.
        if self.user_wait && self.settings.protocol == Protocol::Grbl {
            self.watch_grbl(now);
            return;
        }
        if self.user_wait && now < self.heard + self.settings.long_silence {
            return;
        }
        let quiet = now.saturating_sub(self.moved);
        if quiet > self.settings.no_progress {
            let line = self.line_of(self.credited + 1);
            self.stop(Stop::NoProgress { seconds: quiet.as_secs_f64(), line });
            return;
        }
        if self.settings.protocol == Protocol::Grbl {
            self.watch_grbl(now);
            return;
        }
        let since = now.saturating_sub(self.heard.max(self.moved).max(self.asked));
        if since > self.patience() {
            self.doubt(now, "silence");
        }
    }

    /// How long a silence is natural.
    fn patience(&self) -> Time {
        let base = if self.waits_long() { self.settings.long_silence } else { self.settings.silence };
        base + Duration::from_secs_f64(1.5 * self.motion_in_hand())
    }

    /// Holds everything until the printer has said where it is.
    pub(super) fn doubt(&mut self, now: Time, why: &'static str) {
        if !self.ready && !self.lost_at_least_once && !self.begun {
            // Nothing has moved yet: the greeting begins again.
            self.restart(now);
            return;
        }
        match self.settings.protocol {
            Protocol::Marlin if !matches!(self.stage, Stage::Probe { .. }) => {
                self.note(format!("{why}: asking the printer where it is"));
                self.stage = Stage::Probe { asked: None, tries: 0, answer: None, confirm: 1 };
            }
            Protocol::Klipper | Protocol::RepRapFirmware => self.ask_uncounted(now),
            _ => {}
        }
    }

    /// Whether the wait for a resend's own `ok` is over; says then whether this firmware sends one.
    pub(super) fn settled(&mut self, now: Time) -> bool {
        let Some(until) = self.hold_until else { return true };
        if self.swallow_ok && now < until {
            return false;
        }
        self.resends_end_with_ok = !self.swallow_ok;
        self.swallow_ok = false;
        self.hold_until = None;
        true
    }

    /// A proof beyond the window: its answer shows whether others are missing.
    fn ask_uncounted(&mut self, now: Time) {
        self.unanswered += 1;
        self.asked = now;
        if self.unanswered > self.settings.questions {
            self.mute(now, self.unanswered - 1);
        } else if self.proof_in_flight().is_none() {
            self.make_now(What::Proof);
        }
    }

    pub(super) fn mute(&mut self, now: Time, questions: u32) {
        let (lines, noise) = self.noise;
        if lines > 3 && noise * 2 > lines {
            self.stop(Stop::Noise);
        } else if self.greeting {
            self.stop(Stop::Reset { greeting: "a greeting, then no answer".to_owned() });
        } else {
            let seconds = now.saturating_sub(self.heard).as_secs_f64();
            self.stop(Stop::Mute { seconds, questions });
        }
    }

    /// The question: a line whose number is wrong on purpose, refused with `Last Line: n`.
    pub(super) fn ask_again(&mut self, now: Time, asked: Option<Time>, tries: u32) {
        if let Some(at) = asked {
            let stuck = now.saturating_sub(self.moved);
            if stuck > self.settings.no_progress && !self.user_wait {
                let line = self.line_of(self.credited + 1);
                self.stop(Stop::NoProgress { seconds: stuck.as_secs_f64(), line });
                return;
            }
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
        } else if self.greeting && now < self.heard + BOOT {
            return;
        }
        self.out.push(b'\n');
        // Neither the next line nor one that the printer would drop as a double.
        let wrong = self.last() + 2 + i64::from(tries);
        push_numbered(&mut self.out, wrong, b"M105");
        if let Stage::Probe { asked, tries, .. } = &mut self.stage {
            *asked = Some(now);
            *tries += 1;
        }
    }

    /// The printer's answer: its last accepted line.
    pub(super) fn counter_is(&mut self, now: Time, found: i64) {
        let Stage::Probe { answer, confirm, tries, .. } = self.stage else { return };
        if self.renumbering == 2 && found == 0 {
            self.stage = Stage::Flow;
            self.credited = self.cursor - 1;
            self.bytes_out = 0;
            return;
        }
        let possible = found >= self.proven && found <= self.last();
        let again = answer == Some(found);
        let needed = if possible { confirm } else { 2 };
        if needed > 1 && !again {
            self.stage = Stage::Probe { asked: None, tries, answer: Some(found), confirm };
            return;
        }
        if !possible {
            let (proven, last) = (self.proven, self.last());
            self.stop(if self.greeting || (found == 0 && proven > 0) {
                Stop::Reset { greeting: format!("its counter is at {found}, after {proven}") }
            } else {
                Stop::Counter { found, proven, last }
            });
            return;
        }
        self.agreed(now, found);
    }

    fn agreed(&mut self, now: Time, found: i64) {
        self.stage = Stage::Flow;
        self.greeting = false;
        self.heard = now;
        self.credit(now, self.credited.max(found));
        self.credited = found;
        self.prove(found);
        self.refused = (0, 0, 0);
        // Nothing is under way, so that an `ok` that comes now is the resend's own.
        self.hold_until = Some(now + RESENDS_OWN_OK);
        if std::mem::take(&mut self.renumber) {
            self.renumber_from(found);
            return;
        }
        if self.cursor != found + 1 {
            self.rewind(found + 1, "not accepted");
        }
        self.count_bytes();
    }

    /// After a break of the link: the printer identifies itself again before a line of motion, under new numbers.
    fn renumber_from(&mut self, found: i64) {
        let blocks = self.history.iter().find_map(|s| if let What::Block(i) = s.what { Some(i) } else { None });
        // Where all are taken, the journal's last word may be older than the printer's.
        self.next_block = blocks.unwrap_or_else(|| self.next_block.max(self.acked_blocks));
        if std::mem::take(&mut self.way_back_owed) {
            let lines = self.return_lines();
            self.scripts.extend(lines.iter().map(|l| What::Script(l.as_bytes().into())));
        }
        let scripts: Vec<What> =
            self.history.drain(..).filter(|s| matches!(s.what, What::Script(_))).map(|s| s.what).collect();
        scripts.into_iter().rev().for_each(|s| self.scripts.push_front(s));
        if !self.scripts.is_empty() {
            self.scripts.push_back(What::Proof);
        }
        self.cursor = found + 1;
        self.bytes_out = 0;
        self.narrow = 0;
        self.scripts.push_front(What::Proof);
        self.scripts.push_front(What::Identify);
    }

    /// The link is gone. Nothing is sent until [`Sender::reconnected`].
    pub fn lost(&mut self, _now: Time) {
        if self.stage == Stage::Over {
            return;
        }
        self.lines.clear();
        self.out.clear();
        self.taken = 0;
        self.stage = Stage::Offline;
    }

    /// The link is back, with the same device as far as the port can tell; the printer's counter decides.
    pub fn reconnected(&mut self, now: Time) {
        if self.stage != Stage::Offline {
            return;
        }
        self.heard = now;
        self.moved = now;
        if !self.ready && !self.lost_at_least_once && !self.begun {
            self.restart(now);
        } else if self.settings.protocol == Protocol::Marlin {
            self.ready = false;
            self.lost_at_least_once = true;
            self.renumber = true;
            self.stage = Stage::Probe { asked: None, tries: 0, answer: None, confirm: 2 };
        } else {
            let (first, last) = (self.line_of(self.credited + 1), self.line_of(self.cursor - 1));
            let lines = self.in_flight();
            self.stage = Stage::Flow;
            self.stop(Stop::Unaccounted { lines, first, last });
        }
    }

    /// A greeting in the middle of things.
    pub(super) fn greeted(&mut self, now: Time, text: String) {
        self.heard = now;
        if matches!(self.stage, Stage::Hello { .. }) || (!self.ready && !self.lost_at_least_once && !self.begun) {
            self.restart(now);
            return;
        }
        if self.settings.protocol == Protocol::Marlin {
            // Chatter may contain the word; only the counter tells.
            if !matches!(self.stage, Stage::Probe { .. }) {
                self.drop_unsent();
                self.doubt(now, "a greeting");
            }
            self.greeting = true;
        } else {
            self.stop(Stop::Reset { greeting: text });
        }
    }

    /// Puts a new line on the wire at once, whatever the window says.
    fn make_now(&mut self, what: What) {
        if self.cursor > self.last() {
            let bytes = self.length(&what, self.cursor);
            self.make(what, bytes);
            self.put_on_wire();
        }
    }

    pub(super) fn now_ready(&mut self) {
        if self.ready {
            return;
        }
        self.ready = true;
        let identity = self.identity.clone();
        self.event(Event::Connected(identity));
        if self.lost_at_least_once && !self.goal_is_reached() {
            self.event(Event::Resumed);
        }
    }
}
