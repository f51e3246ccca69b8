//! What the sender is doing: print, leave the part, return to it, end. Each step begins when no line is unanswered.

use super::ledger::Purpose;
use super::outcome::unit;
use super::{Notice, Outcome, Sender, StopReason};
use crate::link::journal::Record;
use crate::link::place::Place;
use crate::link::state::MachineState;

/// M114 has two decimals, and a step of any usual axis is less than this, mm or degrees.
const SAME_PLACE: f64 = 0.05;

/// What the sender is doing.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Activity {
    /// The program's blocks.
    Print {
        /// All of them are answered, and the wait for the last move's end is under way.
        ending: bool,
    },
    /// No new block; those under way are answered first.
    Drain(Departure),
    /// The head is on its way off the part.
    Leave {
        /// What comes then.
        then: Then,
        /// Whether the printer is where the file has brought it.
        place: PositionCheck,
    },
    /// The head is off the part: a pause.
    Away,
    /// After a cancel the heaters' last lines are under way.
    Cool,
    /// Nothing moves before the printer has said where it is, which tells how far it has come.
    Locate {
        /// Where it can be.
        places: Vec<Place>,
        /// Above the part, in a pause.
        away: bool,
        /// Whether it has been asked.
        asked: bool,
        /// What it says.
        said: Option<Vec<(u8, f64)>>,
    },
    /// Back to the part.
    Return {
        /// Our own lines are not worked out yet: the printer has to say first where it is.
        owed: bool,
        /// A pause that waits until the head is back.
        pause_behind: bool,
    },
}

/// Why the head leaves the part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Departure {
    Pause,
    Cancel,
}

/// What follows once the head is off the part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Then {
    Pause,
    Cancel,
    /// Continue: asked for before the head was off.
    Continue,
}

/// The printer's own word of where it is (M114), before it leaves the part.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum PositionCheck {
    /// Asked; where the file has brought each axis.
    Asked(Vec<(u8, f64)>),
    /// There, or not to be asked.
    Agrees,
    /// Elsewhere.
    Differs(StopReason),
}

/// Where the printer has to be.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct PlaceAsked {
    /// The line that asks.
    number: i64,
    /// The first block behind it.
    block: u32,
    /// As M114 has them; empty once it has answered.
    words: Vec<(u8, f64)>,
}

/// The first axis that is elsewhere: its letter, where it is, and where it should be.
fn differs(believed: &[(u8, f64)], words: &[(u8, f64)]) -> Option<(u8, f64, f64)> {
    believed.iter().find_map(|&(letter, believed)| {
        let found = words.iter().find(|(l, _)| *l == letter)?.1;
        ((found - believed).abs() > SAME_PLACE).then_some((letter, found, believed))
    })
}

impl Sender {
    /// No further block; when those under way are answered the head leaves the part along the tool's axis and waits.
    pub fn pause(&mut self) {
        match &mut self.activity {
            Activity::Print { .. } => self.activity = Activity::Drain(Departure::Pause),
            Activity::Return { pause_behind, .. } => *pause_behind = true,
            Activity::Leave { then: then @ Then::Continue, .. } => *then = Then::Pause,
            // Nothing has moved, and it can be asked again.
            Activity::Locate { .. } => self.finish(Outcome::Cancelled),
            Activity::Leave { .. } | Activity::Drain(_) | Activity::Away | Activity::Cool => {}
        }
    }

    /// As [`Sender::pause`], then the heaters by policy and the end.
    pub fn cancel(&mut self) {
        match &mut self.activity {
            Activity::Leave { then, .. } => *then = Then::Cancel,
            // The head is off the part already.
            Activity::Away | Activity::Return { owed: true, .. } => {
                self.activity = Activity::Leave { then: Then::Cancel, place: PositionCheck::Agrees };
            }
            Activity::Print { .. } | Activity::Drain(_) | Activity::Return { .. } => {
                self.activity = Activity::Drain(Departure::Cancel)
            }
            Activity::Locate { .. } => self.finish(Outcome::Cancelled),
            Activity::Cool => {}
        }
        // A wait for heat would hold the rest back for minutes.
        if let Some(words) = self.traits().end_wait.filter(|_| self.printer.emergency_parser && self.waits_long()) {
            self.outbox.push(words);
        }
    }

    /// Continues after a pause: heat, the table's axes at a safe height, then back along the tool's axis.
    pub fn resume(&mut self) {
        match &mut self.activity {
            Activity::Drain(Departure::Pause) => self.activity = Activity::Print { ending: false },
            Activity::Leave { then: then @ Then::Pause, .. } => *then = Then::Continue,
            Activity::Away => self.come_back(),
            _ => {}
        }
    }

    /// Our own lines, and what proves them.
    pub(super) fn queue(&mut self, lines: &[String]) {
        self.own.extend(lines.iter().map(|line| Purpose::Own(line.as_bytes().into())));
        if self.proves() {
            self.own.push_back(Purpose::Proof);
        }
    }

    fn come_back(&mut self) {
        let lines = self.return_lines();
        self.queue(&lines);
        self.activity = Activity::Return { owed: false, pause_behind: false };
    }

    fn state(&self) -> Option<MachineState> {
        MachineState::before(&self.program, self.next_block).ok()
    }

    pub(super) fn return_lines(&self) -> Vec<String> {
        self.state().map_or(Vec::new(), |state| self.settings.retreat.come_back(&state, self.settings.protocol))
    }

    /// The printer's word of where it stands before it leaves the part, against where the file has brought it.
    pub(super) fn compare(&mut self, words: &[(u8, f64)]) {
        let line = self.program.file_line(self.next_block.saturating_sub(1));
        self.compare_at_layer(words);
        if let Activity::Locate { said, asked: true, .. } = &mut self.activity {
            *said = Some(words.to_vec());
        }
        let Activity::Leave { place, .. } = &mut self.activity else { return };
        let PositionCheck::Asked(believed) = place else { return };
        let elsewhere =
            |(letter, found, believed)| StopReason::Elsewhere { axis: char::from(letter), found, believed, line };
        *place = differs(believed, words).map(elsewhere).map_or(PositionCheck::Agrees, PositionCheck::Differs);
    }

    /// Whether the next line is the question where the printer is: at the end of each layer, where that is wanted.
    pub(super) fn asks_for_its_place(&self) -> bool {
        let asked = self.place.as_ref().is_some_and(|place| place.block >= self.next_block);
        self.settings.prove_layers && !asked && self.program.place_before(self.next_block).is_some()
    }

    /// The next line asks where the printer is.
    pub(super) fn expect_its_place(&mut self) {
        let (number, block) = (self.ledger.cursor(), self.next_block);
        let words = self.program.place_before(block).map(|at| self.settings.retreat.words_at(at)).unwrap_or_default();
        self.place = Some(PlaceAsked { number, block, words });
    }

    /// The printer's word at the end of a layer. Where it is elsewhere the head leaves the part; before it does, the printer is asked again, and
    /// what it says then decides.
    fn compare_at_layer(&mut self, words: &[(u8, f64)]) {
        // A file may ask, too.
        let answers = self.ledger.unanswered().find(|(_, purpose)| purpose.text(&self.program).starts_with(b"M114"));
        let answers = answers.map(|(number, _)| number);
        let Some(place) = self.place.as_mut().filter(|place| Some(place.number) == answers) else { return };
        let believed = std::mem::take(&mut place.words);
        let Some((letter, found, believed)) = differs(&believed, words) else { return };
        let line = self.program.file_line(place.block.saturating_sub(1));
        let axis = char::from(letter);
        self.note(format!(
            "after line {line} the printer reports {axis} at {found:.2} {unit} (expected {believed:.2} {unit}); pausing above the part",
            unit = unit(axis)
        ));
        self.pause();
    }

    /// The next step, where nothing is under way.
    pub(super) fn advance(&mut self) {
        let busy = !self.ledger.is_sent() || !self.own.is_empty() || self.ledger.in_flight() > 0;
        if busy || !self.phase.is_open() {
            return;
        }
        let ended = self.next_block >= self.end_block;
        // In a journal `anew` says that the head is not away.
        if self.is_full() && !ended && matches!(self.activity, Activity::Print { .. } | Activity::Drain(_)) {
            self.renumber();
            return;
        }
        match &self.activity {
            Activity::Print { .. } if !ended => {}
            Activity::Print { ending: true } => {
                self.say_brake();
                self.event(Notice::Journal(Record::Done));
                self.finish(Outcome::Done);
            }
            // Every block is answered: wait until the last move has ended, and prove that all were taken.
            Activity::Print { ending: false } => {
                self.activity = Activity::Print { ending: true };
                self.queue(&[self.traits().drain.to_owned()]);
            }
            Activity::Drain(departure) => self.leave(*departure),
            Activity::Leave { then: Then::Cancel, .. } => self.cool(),
            Activity::Leave { place: PositionCheck::Differs(elsewhere), .. } => self.stop(elsewhere.clone()),
            Activity::Leave { then: Then::Continue, .. } => self.come_back(),
            Activity::Leave { then: Then::Pause, .. } => {
                self.activity = Activity::Away;
                self.event(Notice::Journal(Record::Paused(self.next_block)));
                self.event(Notice::Paused);
            }
            Activity::Away => {}
            Activity::Locate { said: Some(_), .. } => self.located(),
            Activity::Locate { asked: false, .. } => self.ask_where(),
            // A machine without M114 is asked for its status until it stands still.
            Activity::Locate { .. } if !self.proves() => {}
            Activity::Locate { .. } => self.stop(StopReason::Misplaced { said: "nowhere".to_owned() }),
            Activity::Cool => self.finish(Outcome::Cancelled),
            Activity::Return { pause_behind, .. } => {
                self.activity =
                    if *pause_behind { Activity::Drain(Departure::Pause) } else { Activity::Print { ending: false } };
                self.knows_all = true;
                self.event(Notice::Journal(Record::Back));
                self.event(Notice::Resumed);
            }
        }
    }

    fn leave(&mut self, departure: Departure) {
        let (retreat, protocol) = (&self.settings.retreat, self.settings.protocol);
        let (place, lines) = match self.state() {
            Some(state) => (PositionCheck::Asked(retreat.words(&state)), retreat.leave(&state, protocol)),
            None => (PositionCheck::Agrees, vec![retreat.drain(protocol).to_owned()]),
        };
        self.event(Notice::Journal(Record::Away));
        self.queue(&lines);
        let then = match departure {
            Departure::Pause => Then::Pause,
            Departure::Cancel => Then::Cancel,
        };
        self.activity = Activity::Leave { then, place };
    }

    fn cool(&mut self) {
        let lines = self.settings.retreat.heaters_on_cancel(self.settings.protocol);
        if lines.is_empty() {
            self.finish(Outcome::Cancelled);
            return;
        }
        self.queue(&lines);
        self.activity = Activity::Cool;
    }

    /// Whether the numbers are to begin anew, long before a 32-bit counter is full: a numbered M110 is taken whatever its number.
    pub(super) fn is_full(&self) -> bool {
        self.ledger.cursor() >= self.settings.renumber_at
    }

    /// One step each time nothing is under way: prove everything, set the printer's counter, count from 1.
    fn renumber(&mut self) {
        if self.ledger.newest() == Some(&Purpose::Renumber) {
            self.ledger.begin_anew();
            self.place = None;
            self.event(Notice::Journal(Record::Anew));
            self.event(Notice::Journal(Record::Run { number: 1, block: self.next_block }));
            return;
        }
        let proven = self.ledger.proven() == self.ledger.last();
        self.own.push_back(if proven { Purpose::Renumber } else { Purpose::Proof });
    }
}
