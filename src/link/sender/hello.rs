//! The first words: who is there, and where does it count from.

use std::time::Duration;

use super::activity::Activity;
use super::ledger::Purpose;
use super::phase::{Begun, Phase, Quiet, Session};
use super::{Dialog, Notice, Sender, Spelling, StopReason, Time};
use crate::link::journal::JournalSummary;
use crate::link::protocol::{Accounting, Hello};
use crate::link::reply::Reply;

/// A printer that was reset by opening the port is silent for some seconds.
const HELLO_EVERY: Time = Duration::from_secs(3);
const HELLOS: u32 = 10;
/// The boot's own words come first.
const BOOT_WORDS: Time = Duration::from_millis(500);

/// Three that move straight and the table's two.
const AXES: u32 = 5;

/// More than any firmware says of itself; what a flood of such lines says beyond it is dropped.
const LONGEST_IDENTITY: usize = 8 << 10;

/// So often something is wrong with the first short lines before that is their fault.
const STRIKES: u32 = 3;

/// Firmwares whose parsers need no blank behind a line's number (their sources; field tests). OctoPrint's "Virtual Marlin" is none.
const SHORT_READERS: [&str; 5] = [
    "FIRMWARE_NAME:Marlin",
    "FIRMWARE_NAME:Prusa-Firmware",
    "FIRMWARE_NAME:Repetier",
    "FIRMWARE_NAME:Smoothie",
    "RepRapFirmware",
];

/// What Marlin says of itself in M115 (`AXIS_COUNT:5`, extruders not counted); `None` where it says nothing.
fn axes(identity: &str) -> Option<u32> {
    let word = identity.split_ascii_whitespace().find_map(|w| w.strip_prefix("AXIS_COUNT:"))?;
    word.parse().ok()
}

impl Sender {
    /// Asks for the printer's attention, again and again.
    pub(super) fn greet(&mut self, now: Time) {
        let Phase::Hello { asked, tries, quiet } = &mut self.phase else { return };
        let waits = match asked {
            Some(at) => now < *at + HELLO_EVERY,
            None => !quiet.get_or_insert(Quiet::from(now)).is_over(now),
        };
        if waits {
            return;
        }
        let tries = *tries;
        if tries >= HELLOS {
            self.mute(now, tries);
            return;
        }
        match self.traits().hello {
            Hello::SetCounter => {
                self.outbox.push(b"\n");
                self.ledger.framing().write(self.outbox.end(), 0, b"M110 N0");
            }
            // One that may still be moving takes no command, but tells its status.
            Hello::Ask(_) if self.is_locating() && self.printer.identity.is_empty() => self.ask_status(),
            Hello::Ask(words) => self.outbox.push(words),
            Hello::None => {
                self.begin(now, tries + 1);
                return;
            }
        }
        self.phase = Phase::Hello { asked: Some(now), tries: tries + 1, quiet: None };
    }

    /// Back to the first words: nothing has moved yet.
    pub(super) fn restart(&mut self, now: Time) {
        let Some(Session::Fresh { hellos }) = self.phase.session() else { return };
        self.outbox.clear();
        self.ledger.begin_anew();
        // The question and the proof come again; a proof behind lines of our own stays.
        while self.own.front().is_some_and(|p| matches!(p, Purpose::Identify | Purpose::Proof)) {
            self.own.pop_front();
        }
        self.dialog = Dialog::default();
        self.printer.identity.clear();
        self.phase = Phase::Hello { asked: None, tries: hellos, quiet: Some(Quiet::from(now + BOOT_WORDS)) };
    }

    pub(super) fn hear_hello(&mut self, now: Time, tries: u32, reply: &Reply) {
        match (self.traits().accounting, reply) {
            (Accounting::Counter, Reply::Ok { room, .. }) => {
                room.iter().for_each(|room| self.take_room(now, None, *room));
                self.begin(now, tries);
            }
            (Accounting::Counter, Reply::OkIdentity(_)) => self.begin(now, tries),
            (Accounting::Status, _) => self.hear_hello_grbl(now, reply),
            _ => {}
        }
    }

    /// The counter is at 0: identity and a first proof, one line at a time.
    fn begin(&mut self, now: Time, hellos: u32) {
        self.flow(now, hellos);
        self.ask_who();
    }

    /// Lines may go out.
    pub(super) fn flow(&mut self, now: Time, hellos: u32) {
        self.phase = Phase::Flow(Session::Fresh { hellos });
        self.heard = now;
        self.moved = now;
    }

    pub(super) fn ask_who(&mut self) {
        self.own.push_front(Purpose::Proof);
        if let Some(line) = self.traits().refused_when_down {
            self.own.push_front(Purpose::Own(line.as_bytes().into()));
        }
        self.own.push_front(Purpose::Identify);
    }

    /// A line of `M115` or `$I`.
    pub(super) fn identify(&mut self, text: &str) {
        let identity = &mut self.printer.identity;
        if identity.len() + text.len() < LONGEST_IDENTITY {
            identity.push_str(if identity.is_empty() { "" } else { "\n" });
            identity.push_str(text);
        }
        // Its line buffer has no time limit; Prusa's has, though it is "based on Marlin".
        self.printer.reads_in_pieces |= text.contains("FIRMWARE_NAME:Marlin");
        self.shorten(text);
        self.printer.emergency_parser |= text.starts_with("Cap:EMERGENCY_PARSER:1");
        if text.contains("FIRMWARE_NAME:") {
            self.check_identity(text);
        }
    }

    /// Leaves the blank behind a line's number out where the firmware is one that is known to need none.
    fn shorten(&mut self, text: &str) {
        let known = SHORT_READERS.iter().any(|name| text.contains(name));
        if known && self.printer.spelling == Spelling::Long && !self.settings.blank_after_number {
            self.printer.spelling = Spelling::Tried { strikes: 1 };
            self.ledger.space(false);
        }
    }

    /// Line `number` is answered; whether it was one without that blank shows here.
    pub(super) fn short_is_read(&mut self, number: i64) {
        if matches!(self.printer.spelling, Spelling::Tried { .. }) && self.ledger.is_short(number) {
            self.printer.spelling = Spelling::Short;
        }
    }

    /// Something was wrong with the first lines without that blank: they have it until the count is proved again, or for good. Noise on the wire may
    /// have been what was wrong, and lines that must have a blank can be padded less well against it.
    pub(super) fn lengthen(&mut self) {
        let Spelling::Tried { strikes } = self.printer.spelling else { return };
        self.printer.spelling =
            if strikes < STRIKES { Spelling::Doubted { strikes: strikes + 1 } } else { Spelling::Never };
        self.ledger.space(true);
        if self.printer.spelling == Spelling::Never {
            self.note("the printer misreads lines without a space after the line number; from now on each has one");
        }
    }

    /// The count is proved with long lines: short ones are tried once more.
    pub(super) fn try_short_again(&mut self) {
        if let Spelling::Doubted { strikes } = self.printer.spelling {
            self.printer.spelling = Spelling::Tried { strikes };
            self.ledger.space(false);
        }
    }

    fn check_identity(&mut self, text: &str) {
        let wanted = match &self.settings.identity {
            Some(wanted) if !text.contains(wanted.as_str()) => wanted.clone(),
            _ if self.traits().is_other(text) => format!("a printer of protocol {}", self.traits().name),
            _ if axes(text).is_some_and(|count| count < AXES) => {
                let [tilt, rotation] = self.settings.retreat.axes.each_ref().map(|a| char::from(a.letter));
                format!("a printer with at least {AXES} axes (X Y Z {tilt} {rotation})")
            }
            _ => return,
        };
        self.stop(StopReason::OtherPrinter { found: text.to_owned(), wanted });
    }

    /// Blocks may go, if they could not before.
    pub(super) fn open(&mut self) {
        let Some(again) = self.phase.open() else { return };
        self.take_queue();
        self.event(Notice::Connected(self.printer.identity.clone()));
        if again && self.activity != Activity::Away {
            self.event(Notice::Resumed);
        }
    }

    /// What a journal knows, as the state in which the link broke.
    pub(super) fn take_standing(&mut self, standing: &JournalSummary) {
        let (end, every) = (self.end_block, self.settings.prove_every);
        let purpose = |number| standing.block_at(number).filter(|b| *b < end).map_or(Purpose::Proof, Purpose::Block);
        self.ledger.broken_off(standing.proven, (standing.proven + 1..=standing.last(end, every)).map(purpose));
        self.next_block = standing.next_block(standing.proven).min(end);
        self.acked_blocks = self.next_block;
        if standing.away {
            // From which block is not known before the printer's counter is.
            self.activity = Activity::Return { owed: true, pause_behind: false };
        }
        self.phase = Phase::Offline(Session::Begun(Begun::Opening { again: true }));
    }
}
