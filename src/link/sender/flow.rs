//! Numbers, window and history: which line goes out next, and what an answer proves.

use super::{Event, Goal, Sender, Sent, Stage, Step, Time, What};
use crate::link::journal::Record;
use crate::link::seams::{Filling, push_spaced};
use crate::link::wire::{Protocol, numbered_len};

impl Sender {
    /// The highest number made.
    pub(super) fn last(&self) -> i64 {
        self.proven + self.history.len() as i64
    }

    pub(super) fn in_flight(&self) -> i64 {
        self.cursor - 1 - self.credited
    }

    fn sent(&self, number: i64) -> Option<&Sent> {
        usize::try_from(number - self.proven - 1).ok().and_then(|index| self.history.get(index))
    }

    pub(super) fn what(&self, number: i64) -> Option<&What> {
        self.sent(number).map(|s| &s.what)
    }

    /// The first M105 without an answer, ours or the file's: nothing else is answered with temperatures.
    pub(super) fn proof_in_flight(&self) -> Option<i64> {
        (self.credited + 1..self.cursor).find(|&n| self.what(n).is_some_and(|what| self.text(what) == b"M105"))
    }

    /// Sends what the window has room for: lines to repeat first, then new ones.
    pub(super) fn fill(&mut self, now: Time) {
        while self.stage == Stage::Flow {
            if self.cursor > self.last() {
                let Some(what) = self.next_what() else { return };
                let bytes = self.length(&what, self.cursor);
                if !self.fits(bytes) {
                    self.put_back(what);
                    return;
                }
                self.make(what, bytes);
            } else if !self.fits(self.sent(self.cursor).map_or(0, |s| s.bytes)) {
                return;
            }
            self.put_on_wire();
            self.moved = now;
        }
    }

    fn fits(&self, bytes: usize) -> bool {
        let in_flight = self.in_flight() as usize;
        let lines = if self.credited < self.narrow || !self.ready { 1 } else { self.settings.window_lines };
        in_flight == 0 || (in_flight < lines && self.bytes_out + bytes <= self.settings.window_bytes)
    }

    /// The next new line, by rank: our own, a proof that is due, a block of the program.
    fn next_what(&mut self) -> Option<What> {
        if let Some(what) = self.scripts.pop_front() {
            return Some(what);
        }
        let counts = self.settings.protocol != Protocol::Grbl;
        if counts && self.since_proof >= self.settings.prove_every {
            return Some(What::Proof);
        }
        let full = self.cursor >= self.settings.renumber_at;
        let may = self.ready && self.goal == Goal::Print && self.next_block < self.end_block && !full;
        may.then_some(What::Block(self.next_block))
    }

    fn put_back(&mut self, what: What) {
        match what {
            What::Block(_) => {}
            What::Proof if self.since_proof >= self.settings.prove_every => {}
            other => self.scripts.push_front(other),
        }
    }

    fn text<'a>(&'a self, what: &'a What) -> &'a [u8] {
        match what {
            What::Block(index) => self.program.block(*index),
            What::Proof => b"M105",
            What::Identify => b"M115",
            What::Script(text) => text,
        }
    }

    /// Bytes on the wire, newline included. Grbl counts to the byte, so there it is exact.
    pub(super) fn length(&self, what: &What, number: i64) -> usize {
        let text = self.text(what);
        if self.settings.protocol.numbered() { numbered_len(number, text) + 3 } else { text.len() + 1 }
    }

    pub(super) fn make(&mut self, what: What, bytes: usize) {
        self.since_proof += 1;
        self.begun |= matches!(what, What::Block(_) | What::Script(_));
        match what {
            What::Block(index) => self.next_block = index + 1,
            _ => {
                if what == What::Proof {
                    self.since_proof = 0;
                }
                let record = Record::Run { number: self.cursor + 1, block: self.next_block };
                self.event(Event::Journal(record));
            }
        }
        let filling = if self.settings.protocol.numbered() {
            let mut seams = std::mem::take(&mut self.seams);
            let filling = seams.fill(self.cursor, self.text(&what));
            self.seams = seams;
            filling
        } else {
            Filling::default()
        };
        self.history.push_back(Sent { what, bytes, filling });
    }

    pub(super) fn put_on_wire(&mut self) {
        let Some(index) = usize::try_from(self.cursor - self.proven - 1).ok() else { return };
        let mut out = std::mem::take(&mut self.out);
        let start = out.len();
        if let Some(sent) = self.history.get(index) {
            let text = self.text(&sent.what);
            if self.settings.protocol.numbered() {
                push_spaced(&mut out, self.cursor, sent.filling, text);
            } else {
                out.extend_from_slice(text);
                out.push(b'\n');
            }
        }
        let bytes = out.len() - start;
        if let Some(sent) = self.history.get_mut(index) {
            sent.bytes = bytes;
        }
        self.bytes_out += bytes;
        self.out = out;
        self.cursor += 1;
    }

    /// An `ok`; `number` of ADVANCED_OK, `report` where it carries temperatures.
    pub(super) fn answered(&mut self, now: Time, number: Option<i64>, report: bool) {
        let sent = self.cursor - 1;
        let proof = self.proof_in_flight();
        let mut to = match (report, number) {
            (true, _) => proof.unwrap_or(self.credited),
            (false, Some(n)) => n,
            (false, None) => self.credited + 1,
        };
        // A proof's own answer carries temperatures: no other reaches past it.
        if let (false, Some(proof)) = (report, proof) {
            to = to.min(proof - 1);
        }
        if to > sent || to <= self.credited {
            return;
        }
        let missed = to - self.credited - 1;
        if report && missed > 0 && self.settings.protocol != Protocol::Marlin {
            let (first, last) = (self.line_of(self.credited + 1), self.line_of(to - 1));
            self.stop(super::Stop::Unaccounted { lines: missed, first, last });
            return;
        }
        self.credit(now, to);
        if report {
            self.prove(to);
        }
    }

    /// Everything up to `to` counts as answered.
    pub(super) fn credit(&mut self, now: Time, to: i64) {
        for number in self.credited + 1..=to {
            if let Some(sent) = self.sent(number) {
                let (bytes, what) = (sent.bytes, sent.what.clone());
                self.bytes_out = self.bytes_out.saturating_sub(bytes);
                self.acked(&what);
            }
        }
        self.credited = to;
        self.moved = now;
        self.unanswered = 0;
        self.user_wait = false;
        if self.settings.protocol == Protocol::Grbl {
            self.prove(to);
        }
    }

    fn acked(&mut self, what: &What) {
        match what {
            What::Block(index) => self.acked_blocks = self.acked_blocks.max(index + 1),
            What::Proof if !self.ready && !self.renumber && self.scripts.is_empty() => self.now_ready(),
            _ => {}
        }
    }

    /// Everything up to `to` is known to be accepted and leaves the history.
    pub(super) fn prove(&mut self, to: i64) {
        while self.proven < to && self.history.pop_front().is_some() {
            self.proven += 1;
        }
        if self.refused.0 <= self.proven {
            self.refused = (0, 0, 0);
        }
    }

    /// Goes back to `number`, which the printer has not taken.
    pub(super) fn rewind(&mut self, number: i64, why: &'static str) {
        self.resends += 1;
        let file_line = self.file_line(number);
        self.event(Event::Resend { number, file_line, why });
        self.cursor = number;
        self.credited = self.credited.min(number - 1);
        self.narrow = number;
        self.count_bytes();
    }

    pub(super) fn count_bytes(&mut self) {
        self.bytes_out = (self.credited + 1..self.cursor).filter_map(|n| self.sent(n)).map(|s| s.bytes).sum();
    }

    pub(super) fn file_line(&self, number: i64) -> Option<u32> {
        match self.what(number)? {
            What::Block(index) => Some(self.program.file_line(*index)),
            _ => None,
        }
    }

    /// The file's line at or before `number`, for a message.
    pub(super) fn line_of(&self, number: i64) -> u32 {
        self.file_line(number).unwrap_or_else(|| self.program.file_line(self.acked_blocks.saturating_sub(1)))
    }

    pub(super) fn goal_is_reached(&self) -> bool {
        matches!(self.goal, Goal::Leave { step: Step::Away, .. })
    }
}
