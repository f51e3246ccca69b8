//! Pause, go on, cancel, and the end of the program.

use super::{Event, Goal, Outcome, Sender, Step, Stop, Time, What};
use crate::link::journal::Record;
use crate::link::resume::State;
use crate::link::wire::Protocol;

/// M114 has two decimals, and a step of any usual axis is less than this, mm or degrees.
const SAME_PLACE: f64 = 0.05;

impl Sender {
    /// No further block; when those under way are answered the head leaves the part along the tool's axis and waits.
    pub fn pause(&mut self) {
        match self.goal {
            Goal::Print => self.goal = Goal::Leave { cancel: false, step: Step::Draining },
            Goal::Return => self.pause_behind = true,
            Goal::Leave { .. } => {}
        }
    }

    /// As [`Sender::pause`], then the heaters by policy and the end.
    pub fn cancel(&mut self) {
        self.goal = match self.goal {
            Goal::Leave { step: Step::Away, .. } => Goal::Leave { cancel: true, step: Step::Leaving },
            Goal::Leave { step, .. } => Goal::Leave { cancel: true, step },
            _ => Goal::Leave { cancel: true, step: Step::Draining },
        };
        // A wait for heat would hold the rest back for minutes.
        if self.emergency_parser && self.settings.protocol == Protocol::Marlin && self.waits_long() {
            self.out.extend_from_slice(b"\nM108\n");
        }
    }

    /// Goes on after a pause: heat, the table's axes at a safe height, then back along the tool's axis.
    pub fn resume(&mut self) {
        match self.goal {
            Goal::Leave { cancel: false, step: Step::Draining } => self.goal = Goal::Print,
            Goal::Leave { cancel: false, .. } => {
                let lines = self.return_lines();
                self.queue(&lines);
                self.goal = Goal::Return;
            }
            _ => {}
        }
    }

    fn queue(&mut self, lines: &[String]) {
        self.scripts.extend(lines.iter().map(|l| What::Script(l.as_bytes().into())));
        if self.settings.protocol != Protocol::Grbl {
            self.scripts.push_back(What::Proof);
        }
    }

    fn state(&self) -> Option<State> {
        State::before(&self.program, self.next_block).ok()
    }

    pub(super) fn return_lines(&self) -> Vec<String> {
        self.state().map_or(Vec::new(), |state| self.settings.retreat.come_back(&state, self.settings.protocol))
    }

    /// The printer's word of where it stands before it leaves the part, against where the file has brought it.
    pub(super) fn compare(&mut self, words: &[(u8, f64)]) {
        for (letter, believed) in std::mem::take(&mut self.believed) {
            let Some((_, found)) = words.iter().find(|(l, _)| *l == letter) else { continue };
            if (found - believed).abs() > SAME_PLACE && self.elsewhere.is_none() {
                let line = self.program.file_line(self.next_block.saturating_sub(1));
                self.elsewhere = Some(Stop::Elsewhere { axis: char::from(letter), found: *found, believed, line });
            }
        }
    }

    /// The next step towards a pause, a cancel or the end.
    pub(super) fn advance_goal(&mut self, now: Time) {
        if self.cursor <= self.last() || !self.scripts.is_empty() || self.in_flight() > 0 || !self.ready {
            return;
        }
        match self.goal {
            Goal::Print if self.next_block >= self.end_block => self.finish_program(now),
            Goal::Print => {
                if self.cursor >= self.settings.renumber_at {
                    self.renumber();
                }
            }
            Goal::Leave { cancel, step: Step::Draining } => {
                let lines = match self.state() {
                    Some(state) => {
                        self.believed = self.settings.retreat.words(&state);
                        self.settings.retreat.leave(&state, self.settings.protocol)
                    }
                    None => vec![self.settings.retreat.drain(self.settings.protocol).to_owned()],
                };
                self.event(Event::Journal(Record::Away));
                self.queue(&lines);
                self.goal = Goal::Leave { cancel, step: Step::Leaving };
            }
            Goal::Leave { cancel: true, step: Step::Leaving } => {
                if self.cooling {
                    self.finish(Outcome::Cancelled);
                    return;
                }
                self.cooling = true;
                let lines = self.settings.retreat.heaters_on_cancel(self.settings.protocol);
                self.queue(&lines);
                if lines.is_empty() {
                    self.finish(Outcome::Cancelled);
                }
            }
            Goal::Leave { cancel: false, step: Step::Leaving } => {
                if let Some(elsewhere) = self.elsewhere.take() {
                    self.stop(elsewhere);
                    return;
                }
                self.goal = Goal::Leave { cancel: false, step: Step::Away };
                self.event(Event::Paused);
            }
            Goal::Leave { step: Step::Away, .. } => {}
            Goal::Return => {
                self.event(Event::Journal(Record::Back));
                self.event(Event::Resumed);
                let again = std::mem::take(&mut self.pause_behind);
                self.goal = if again { Goal::Leave { cancel: false, step: Step::Draining } } else { Goal::Print };
            }
        }
    }

    /// Every block is answered: wait until the last move has ended, and prove that all were taken.
    fn finish_program(&mut self, _now: Time) {
        if self.finishing {
            self.event(Event::Journal(Record::Done));
            self.finish(Outcome::Done);
            return;
        }
        self.finishing = true;
        let drain = self.settings.retreat.drain(self.settings.protocol).to_owned();
        self.queue(&[drain]);
    }

    /// Begins the numbers anew, long before a 32-bit counter is full: a numbered M110 is taken whatever its number.
    ///
    /// One step each time nothing is under way: prove everything, renumber, count from 1.
    fn renumber(&mut self) {
        self.renumbering += 1;
        match self.renumbering {
            1 => self.scripts.push_back(What::Proof),
            2 => self.scripts.push_back(What::Script(b"M110N0"[..].into())),
            _ => {
                self.renumbering = 0;
                self.history.clear();
                (self.proven, self.credited, self.cursor, self.bytes_out) = (0, 0, 1, 0);
                (self.narrow, self.refused) = (0, (0, 0, 0));
                self.event(Event::Journal(Record::Anew));
                let record = Record::Run { number: 1, block: self.next_block };
                self.event(Event::Journal(record));
            }
        }
    }
}
