//! Which line goes out next, and what an answer proves.

use std::ops::Range;

use super::activity::Activity;
use super::brake::Wire;
use super::ledger::Purpose;
use super::listen::OwnOk;
use super::{Notice, Phase, Sender, StopReason, Time, Watch};
use crate::link::journal::Record;
use crate::link::protocol::Accounting;
use crate::link::reply::BufferRoom;
use crate::link::settings::SenderSettings;

/// Moves in hand that take longer need no full queue behind them, s.
const SLOW_S: f64 = 2.0;

/// Where one report has answered several proofs, what the others are answered, if anything, follows it within this.
const OTHERS_FOLLOW: Time = Time::from_millis(500);

/// A bed that is colder by so much than the print had it may have let go of the part, degrees Celsius.
const COOLED_C: f64 = 10.0;

impl Sender {
    /// The first M105 without an answer, ours or the file's: nothing else is answered with temperatures.
    pub(super) fn proof_in_flight(&self) -> Option<i64> {
        self.ledger.unanswered().find(|(_, purpose)| purpose.text(&self.program) == b"M105").map(|(number, _)| number)
    }

    /// Whether a proof among the lines says something: not where every `ok` is one.
    pub(super) fn proves(&self) -> bool {
        self.traits().accounting != Accounting::Status
    }

    /// Sends what the window has room for: lines to repeat first, then new ones.
    pub(super) fn fill(&mut self, now: Time) {
        while matches!(self.phase, Phase::Flow(_)) && self.goes_next() {
            let before = self.ledger.bytes_out();
            self.ledger.write(self.outbox.end(), &self.program);
            self.brake.sends(self.ledger.bytes_out().saturating_sub(before));
            self.moved = now;
        }
        let much = self.ledger.in_flight() > 1;
        let beyond = self.ledger.bytes_out().saturating_sub(self.settings.window_bytes);
        self.outbox.hold(if much && !self.flows_freely() { beyond } else { 0 });
        if self.outbox.holds() {
            self.brake.cuts();
        }
    }

    /// Makes the next line, or finds the one that is to be repeated; `false` where there is none or no room.
    fn goes_next(&mut self) -> bool {
        if self.traits().queues && self.waits_long() {
            return false;
        }
        let lines = self.most_lines();
        let most = self.settings.window_bytes;
        if !self.ledger.is_sent() {
            return self.ledger.has_room(lines) && self.ledger.fits(self.ledger.length_again(), most);
        }
        let Some(purpose) = self.next_purpose() else { return false };
        let room = self.ledger.has_room(lines)
            && (self.ledger.fits_new(purpose.text(&self.program), most)
                || (!self.may_wait(&purpose) && (self.flows_freely() || self.goes_in_pieces())));
        if room {
            self.make(purpose);
        } else {
            self.brake.holds(!self.ledger.has_room(lines));
            self.put_back(purpose);
        }
        room
    }

    /// Lines that may be without an answer.
    ///
    /// Without EMERGENCY_PARSER Marlin reads M112 only where its queue has room. So nothing is queued behind a line that waits, and while the moves
    /// in hand take a while one place stays free; the planner does not run dry meanwhile.
    fn most_lines(&self) -> usize {
        let lines = if self.phase.is_open() { self.settings.window_lines } else { 1 };
        let spare = self.traits().queues && lines > 1 && self.motion_in_hand() > SLOW_S;
        lines - usize::from(spare)
    }

    /// Whether it or a line under way may take long: no move does.
    fn may_wait(&self, purpose: &Purpose) -> bool {
        let waits = match purpose {
            Purpose::Block(index) => self.program.waits(*index),
            Purpose::Proof | Purpose::Where => false,
            _ => true,
        };
        waits || !self.phase.is_open() || self.waits_long()
    }

    /// Whether the beginning of a line may go although its end has to wait: only between moves, and only to a firmware that waits for a
    /// line's end as long as it takes (Prusa's drops half a line after two seconds).
    fn goes_in_pieces(&self) -> bool {
        self.printer.reads_in_pieces && self.ledger.fits(1, self.settings.window_bytes)
    }

    /// Whether only the queue's room counts: where the profile says how often the receive buffer is emptied into it, and the wire
    /// cannot fill it in that time. Until a line has gone out again: then that was not so.
    fn flows_freely(&self) -> bool {
        self.resends == 0 && self.settings.never_full()
    }

    /// The next new line, by rank: our own, a proof that is due, a block of the program.
    fn next_purpose(&mut self) -> Option<Purpose> {
        if self.ledger.newest() == Some(&Purpose::Renumber) {
            return None;
        }
        if let Some(purpose) = self.own.pop_front() {
            return Some(purpose);
        }
        if self.proves() && self.since_proof >= self.settings.prove_every {
            return Some(Purpose::Proof);
        }
        let prints = self.phase.is_open() && matches!(self.activity, Activity::Print { .. });
        let may = prints && self.next_block < self.end_block && !self.is_full();
        may.then(|| if self.asks_for_its_place() { Purpose::Where } else { Purpose::Block(self.next_block) })
    }

    fn put_back(&mut self, purpose: Purpose) {
        match purpose {
            Purpose::Block(_) | Purpose::Where => {}
            Purpose::Proof if self.since_proof >= self.settings.prove_every => {}
            other => self.own.push_front(other),
        }
    }

    pub(super) fn make(&mut self, purpose: Purpose) {
        self.since_proof += 1;
        match &purpose {
            Purpose::Block(index) => {
                // Where no line of our own came before it, the journal would not know that anything was sent.
                if !std::mem::replace(&mut self.recorded, true) {
                    self.event(Notice::Journal(Record::Run { number: self.ledger.cursor(), block: *index }));
                }
                self.next_block = index + 1;
            }
            _ => {
                self.recorded = true;
                let record = Record::Run { number: self.ledger.cursor() + 1, block: self.next_block };
                self.event(Notice::Journal(record));
            }
        }
        match &purpose {
            Purpose::Proof => self.since_proof = 0,
            Purpose::Block(_) | Purpose::Own(_) => self.phase.begin(),
            Purpose::Where => self.expect_its_place(),
            Purpose::Identify | Purpose::Renumber => {}
        }
        self.ledger.make(purpose, &self.program);
    }

    /// What a firmware says beside its `ok` of its queue and its planner.
    ///
    /// At that moment its queue held the line that is answered and all that it had taken from the receive buffer behind it: so many
    /// bytes more may go.
    pub(super) fn take_room(&mut self, now: Time, number: Option<i64>, room: BufferRoom) {
        let [most, last] = &mut self.printer.queue;
        // Noise may change a digit, hardly the same way twice.
        if room.commands == *last && room.commands > *most {
            *most = room.commands;
            if self.phase.is_open() {
                self.take_queue();
            }
        }
        self.printer.queue[1] = room.commands;
        let most = self.printer.queue[0];
        let Some(number) = number.filter(|n| (1..self.ledger.cursor()).contains(n)) else { return };
        if number > self.ledger.credited() {
            self.ledger.drain(number + (most.saturating_sub(room.commands)) as i64);
        }
        let moves = matches!(self.ledger.purpose(number), Some(Purpose::Block(b)) if self.program.seconds(*b) > 0.0);
        if self.brake.answered(now, room, moves && !self.waits_long()) {
            self.say_brake();
        }
    }

    /// As many lines go ahead as the firmware says that it queues.
    pub(super) fn take_queue(&mut self) {
        let lines = self.printer.queue[0] + 1;
        // A window of one line is somebody's choice.
        if lines > 1 && lines != self.settings.window_lines && self.traits().queues && self.settings.window_lines > 1 {
            let said = self.settings.window_lines;
            self.note(format!(
                "the printer queues {lines} commands (BUFSIZE), not {said} as in the profile ([link] commands)"
            ));
            self.settings.window_lines = lines;
        }
    }

    /// Says what holds the print back, if anything does.
    pub(super) fn say_brake(&mut self) {
        let SenderSettings { baud, window_bytes, window_lines, .. } = self.settings;
        if let Some(words) = self.brake.words(Wire { baud, window_bytes, window_lines }) {
            self.note(words);
        }
    }

    /// An `ok`; `number` of ADVANCED_OK, `report` where it carries temperatures.
    pub(super) fn answered(&mut self, now: Time, number: Option<i64>, report: bool) {
        // Before it has said who it is it answers what an earlier host has sent.
        if self.is_locating() && self.proves() && self.printer.identity.is_empty() {
            return;
        }
        let (sent, credited) = (self.ledger.cursor() - 1, self.ledger.credited());
        let proof = self.proof_in_flight();
        let all = report && self.answers_all();
        let mut to = match (report, number) {
            (true, _) if all => sent,
            (true, _) => proof.unwrap_or(credited),
            (false, Some(n)) => n,
            (false, None) => credited + 1,
        };
        // A proof's own answer carries temperatures: no other reaches past it.
        if let (false, Some(proof)) = (report, proof) {
            to = to.min(proof - 1);
        }
        if to > sent || to <= credited {
            return;
        }
        let lines = to - credited - 1;
        if report && lines > 0 && self.traits().accounting != Accounting::Counter {
            let [first, last] = self.lines_of(credited + 1..to);
            self.stop(StopReason::Unaccounted { lines, first, last });
            return;
        }
        if report && let Some((is_c, was_c)) = self.has_cooled() {
            self.stop(StopReason::Cooled { is_c, was_c });
            return;
        }
        self.credit(now, to);
        if report {
            (self.printer.reports, self.insisted) = (true, 0);
            self.ledger.prove(to);
            self.try_short_again();
        }
        if all {
            self.dialog.own_ok = OwnOk::Late(now + OTHERS_FOLLOW);
        }
    }

    /// Whether a report answers whatever is under way: nothing but proofs, asked one behind the other because answers were lost, and the
    /// printer's counter has said that it has read them all. Counted one by one, the last would want another for ever.
    fn answers_all(&self) -> bool {
        let mut proofs = 0;
        let all = self.ledger.unanswered().all(|(_, purpose)| {
            proofs += 1;
            *purpose == Purpose::Proof
        });
        all && proofs > 1 && self.insisted > 0
    }

    /// What the bed is and was, where it has cooled since the print was broken off; asked at the first report, before anything moves.
    fn has_cooled(&mut self) -> Option<(f64, f64)> {
        let was_c = self.settings.bed_was_c.take()?;
        self.bed_c.filter(|is_c| *is_c < was_c - COOLED_C).map(|is_c| (is_c, was_c))
    }

    /// Everything up to `to` counts as answered.
    pub(super) fn credit(&mut self, now: Time, to: i64) {
        self.short_is_read(to);
        while self.ledger.credited() < to {
            match self.ledger.credit() {
                Some(Purpose::Block(index)) => self.acked_blocks = self.acked_blocks.max(index + 1),
                Some(Purpose::Proof) if self.own.is_empty() => self.open(),
                _ => {}
            }
        }
        self.moved = now;
        (self.user_wait, self.paused_itself) = (false, false);
        match &mut self.watch {
            Watch::Counter => {}
            Watch::Proof { unanswered, .. } => *unanswered = 0,
            Watch::Status { .. } => self.ledger.prove(to),
        }
    }

    /// Goes back to `number`, which the printer has not taken.
    pub(super) fn rewind(&mut self, number: i64, why: &'static str) {
        if self.flows_freely() {
            self.note("a line had to be resent; from now on no more is sent ahead than the receive buffer holds ([link] reads_ms)");
        }
        self.lengthen();
        self.resends += 1;
        let file_line = self.file_line(number);
        self.event(Notice::Resend { number, file_line, why });
        self.ledger.rewind(number);
    }

    pub(super) fn file_line(&self, number: i64) -> Option<u32> {
        match self.ledger.purpose(number)? {
            Purpose::Block(index) => Some(self.program.file_line(*index)),
            _ => None,
        }
    }

    /// The file's line at or before `number`, for a message.
    pub(super) fn line_of(&self, number: i64) -> u32 {
        self.file_line(number).unwrap_or_else(|| self.program.file_line(self.acked_blocks.saturating_sub(1)))
    }

    /// The first and the last line of the file among `numbers`, for a message; without any the last that was answered.
    fn lines_of(&self, numbers: Range<i64>) -> [u32; 2] {
        let answered = self.program.file_line(self.acked_blocks.saturating_sub(1));
        let first = numbers.clone().find_map(|number| self.file_line(number));
        let last = numbers.rev().find_map(|number| self.file_line(number));
        [first, last].map(|line| line.unwrap_or(answered))
    }

    /// The file's lines under way, for a message.
    pub(super) fn unaccounted(&self) -> StopReason {
        let [first, last] = self.lines_of(self.ledger.credited() + 1..self.ledger.cursor());
        StopReason::Unaccounted { lines: self.ledger.in_flight(), first, last }
    }
}
