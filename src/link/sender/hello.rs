//! The first words: who is there, and where does it count from.

use std::time::Duration;

use super::{Goal, Sender, Stage, Stop, Time, What};
use crate::link::journal::Standing;
use crate::link::reply::Reply;
use crate::link::seams::Filling;
use crate::link::wire::{Protocol, push_numbered};

/// A printer that was reset by opening the port is silent for some seconds.
const HELLO_EVERY: Time = Duration::from_secs(3);
const HELLOS: u32 = 10;

/// Three that move straight and the table's two.
const AXES: u32 = 5;

/// What Marlin says of itself in M115 (`AXIS_COUNT:5`, extruders not counted); `None` where it says nothing.
fn axes(identity: &str) -> Option<u32> {
    let word = identity.split_ascii_whitespace().find_map(|w| w.strip_prefix("AXIS_COUNT:"))?;
    word.parse().ok()
}

impl Sender {
    /// Asks for the printer's attention, again and again.
    pub(super) fn greet(&mut self, now: Time, asked: Option<Time>, tries: u32) {
        if asked.is_some_and(|at| now < at + HELLO_EVERY) {
            return;
        }
        if tries >= HELLOS {
            self.mute(now, tries);
            return;
        }
        match self.settings.protocol {
            Protocol::Marlin => {
                self.out.push(b'\n');
                push_numbered(&mut self.out, 0, b"M110N0");
            }
            Protocol::Grbl => self.out.extend_from_slice(b"$I\n"),
            Protocol::RepRapFirmware | Protocol::Klipper => {
                self.begin(now);
                return;
            }
        }
        self.hellos = tries + 1;
        self.stage = Stage::Hello { asked: Some(now), tries: tries + 1 };
    }

    /// Back to the first words: nothing has moved yet.
    pub(super) fn restart(&mut self, now: Time) {
        let tries = if let Stage::Hello { tries, .. } = self.stage { tries } else { self.hellos };
        self.drop_unsent();
        self.out.clear();
        self.history.clear();
        (self.proven, self.credited, self.cursor, self.bytes_out) = (0, 0, 1, 0);
        // The question and the proof come again; a proof behind lines of our own stays.
        while self.scripts.front().is_some_and(|w| matches!(w, What::Identify | What::Proof)) {
            self.scripts.pop_front();
        }
        self.pending_last = None;
        self.pending_error = None;
        self.identity.clear();
        self.refused = (0, 0, 0);
        // The boot's own words come first.
        self.stage =
            Stage::Hello { asked: Some((now + Duration::from_millis(500)).saturating_sub(HELLO_EVERY)), tries };
    }

    pub(super) fn hear_hello(&mut self, now: Time, reply: &Reply) {
        match (self.settings.protocol, reply) {
            (Protocol::Marlin, Reply::Ok { .. }) => self.begin(now),
            (Protocol::Grbl, _) => self.hear_hello_grbl(now, reply),
            _ => {}
        }
    }

    /// The counter is at 0: identity and a first proof, one line at a time.
    pub(super) fn begin(&mut self, now: Time) {
        self.stage = Stage::Flow;
        self.heard = now;
        self.moved = now;
        self.scripts.push_front(What::Proof);
        self.scripts.push_front(What::Identify);
    }

    /// A line of `M115` or `$I`.
    pub(super) fn identify(&mut self, text: &str) {
        if !self.identity.is_empty() {
            self.identity.push('\n');
        }
        self.identity.push_str(text);
        if text.starts_with("Cap:EMERGENCY_PARSER:1") {
            self.emergency_parser = true;
        }
        if text.contains("FIRMWARE_NAME:") {
            self.check_identity(text);
        }
    }

    fn check_identity(&mut self, text: &str) {
        let other = match self.settings.protocol {
            Protocol::Marlin => text.contains("RepRapFirmware") || text.contains("FIRMWARE_NAME:Klipper"),
            Protocol::RepRapFirmware => !text.contains("RepRapFirmware"),
            Protocol::Klipper => !text.contains("Klipper"),
            Protocol::Grbl => false,
        };
        let wanted = match &self.settings.identity {
            Some(wanted) if !text.contains(wanted.as_str()) => wanted.clone(),
            _ if other => format!("a printer of protocol {}", self.settings.protocol.name()),
            _ if axes(text).is_some_and(|count| count < AXES) => {
                let [tilt, rotation] = self.settings.retreat.axes.each_ref().map(|a| char::from(a.letter));
                format!("a printer of at least {AXES} axes (X Y Z {tilt} {rotation})")
            }
            _ => return,
        };
        self.stop(Stop::OtherPrinter { found: text.to_owned(), wanted });
    }

    /// Lines of our own before the first block.
    pub(super) fn prepend(&mut self, lines: &[String]) {
        self.scripts.extend(lines.iter().map(|l| What::Script(l.as_bytes().into())));
        if !lines.is_empty() {
            self.scripts.push_back(What::Proof);
        }
    }

    /// What a journal knows, as the state in which the link broke.
    pub(super) fn take_standing(&mut self, standing: &Standing) {
        self.proven = standing.proven;
        self.credited = standing.proven;
        let last = standing.last(self.end_block);
        for number in standing.proven + 1..=last {
            let what = standing.block_at(number).filter(|b| *b < self.end_block).map_or(What::Proof, What::Block);
            self.history.push_back(super::Sent { what, bytes: 0, filling: Filling::default() });
        }
        self.cursor = self.proven + 1;
        self.next_block = standing.next_block(self.proven).min(self.end_block);
        self.acked_blocks = self.next_block;
        if standing.away {
            // From which block is not known before the printer's counter is.
            self.way_back_owed = true;
            self.goal = Goal::Return;
        }
        self.lost_at_least_once = true;
        self.stage = Stage::Offline;
    }
}
