//! Every way a print ends, in words, and what is still sent then.

use super::{Event, Sender, Stage};
use crate::link::wire::{Protocol, push_numbered};

/// Why the sender stopped by itself.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Stop {
    /// A greeting, and a counter that began anew.
    #[error(
        "the printer was reset in the middle of the print ({greeting}); where its axes stand is unknown. After a look at \
         the part: trunnion send --resume"
    )]
    Reset {
        /// How it was noticed.
        greeting: String,
    },
    /// The counter is not where it can be.
    #[error(
        "the printer counts from line {found}, but lines up to {proven} were accepted and {last} were sent: it was reset, \
         or another program talks to it"
    )]
    Counter {
        /// The printer's last line.
        found: i64,
        /// Known to be accepted.
        proven: i64,
        /// Ever sent.
        last: i64,
    },
    /// One line refused again and again.
    #[error("line {line} of the file was refused {times} times; the wire or the printer's parser is broken there")]
    EndlessResend {
        /// Of the file.
        line: u32,
        /// How often.
        times: u32,
    },
    /// No answer.
    #[error("the printer has not answered for {seconds:.0} s and {questions} questions; its heaters may still be on")]
    Mute {
        /// Since its last word.
        seconds: f64,
        /// Asked in vain.
        questions: u32,
    },
    /// It answers, but nothing gets on.
    #[error("the printer shows life but has taken no line for {seconds:.0} s, at line {line} of the file")]
    NoProgress {
        /// Since the last line was taken.
        seconds: f64,
        /// Of the file.
        line: u32,
    },
    /// Bytes, but no words.
    #[error("only noise comes back: the baud rate is wrong, or this is no printer")]
    Noise,
    /// `Error:`, `!!`, `ALARM:` that ends everything.
    #[error("the printer has stopped: {text}; clear its cause and reset the printer")]
    Fatal {
        /// Its own words.
        text: String,
    },
    /// An error that no rule calls harmless.
    #[error("at line {line} of the file the printer says: {text}")]
    Error {
        /// Its own words.
        text: String,
        /// Of the file.
        line: u32,
    },
    /// Grbl refused a line.
    #[error("line {line} of the file was refused: error:{code} ({meaning}); the machine is in feed hold")]
    Refused {
        /// Of the file.
        line: u32,
        /// Grbl's number.
        code: u32,
        /// In words.
        meaning: &'static str,
    },
    /// Answers are missing or there is one too many, and the protocol has no counter to ask.
    #[error(
        "{lines} lines about lines {first}..{last} of the file have no answer, and this protocol cannot say whether they were \
         done; nothing was sent twice"
    )]
    Unaccounted {
        /// How many.
        lines: i64,
        /// Of the file.
        first: u32,
        /// Of the file.
        last: u32,
    },
    /// Its M114 is not where the file has brought it.
    #[error(
        "the printer says that {axis} stands at {found:.2}, but line {line} of the file has brought it to {believed:.2}: a move \
         was cut short, or something else moved it; the head is above the part"
    )]
    Elsewhere {
        /// The axis' letter.
        axis: char,
        /// The printer's word, mm or degrees.
        found: f64,
        /// Ours.
        believed: f64,
        /// Of the file.
        line: u32,
    },
    /// Another printer, or another firmware.
    #[error("the printer calls itself {found:?}, not {wanted:?}: wrong port, or wrong profile")]
    OtherPrinter {
        /// Its own words.
        found: String,
        /// What it should be.
        wanted: String,
    },
    /// It cannot begin.
    #[error("the printer is not ready: {state}")]
    NotReady {
        /// What it says, and what to do.
        state: String,
    },
}

impl Stop {
    /// Whether anything that is sent now could be heard and obeyed in a known way.
    fn answers(&self) -> bool {
        !matches!(
            self,
            Self::Reset { .. }
                | Self::Counter { .. }
                | Self::Mute { .. }
                | Self::Noise
                | Self::Fatal { .. }
                | Self::OtherPrinter { .. }
                | Self::NotReady { .. }
        )
    }
}

/// How a print ended.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// Every line executed.
    Done,
    /// Cancelled: the head is away, heaters by policy.
    Cancelled,
    /// Emergency stop.
    EmergencyStopped,
    /// By the sender, with the reason.
    Stopped(Stop),
}

impl Sender {
    /// Ends at once; heaters by policy where the printer still listens.
    pub(super) fn stop(&mut self, why: Stop) {
        if self.stage == Stage::Over {
            return;
        }
        let answers = why.answers();
        self.drop_unsent();
        if self.settings.protocol == Protocol::Grbl {
            // A feed hold keeps the position; a soft reset would not.
            if !matches!(why, Stop::NotReady { .. } | Stop::OtherPrinter { .. }) {
                self.out.push(b'!');
            }
        } else if answers {
            for line in self.settings.retreat.heaters_on_stop() {
                self.out.extend_from_slice(line.as_bytes());
                self.out.push(b'\n');
            }
        }
        self.finish(Outcome::Stopped(why));
    }

    pub(super) fn finish(&mut self, outcome: Outcome) {
        self.stage = Stage::Over;
        self.outcome = Some(outcome.clone());
        self.event(Event::Over(outcome));
    }

    /// Emergency stop: the next bytes on the wire, whatever was waiting.
    pub fn emergency_stop(&mut self) {
        if matches!(self.outcome, Some(Outcome::EmergencyStopped)) {
            return;
        }
        self.drop_unsent();
        match self.settings.protocol {
            Protocol::Marlin => {
                self.out.extend_from_slice(b"M112\n");
                push_numbered(&mut self.out, self.cursor, b"M112");
            }
            Protocol::RepRapFirmware => self.out.extend_from_slice(b"M112\nM999\n"),
            Protocol::Klipper => self.out.extend_from_slice(b"M112\n"),
            Protocol::Grbl => {
                self.out.clear();
                self.out.push(0x18);
            }
        }
        if self.outcome.is_none() {
            self.finish(Outcome::EmergencyStopped);
        }
    }

    /// Bytes that stop the printer whatever was sent before, for whoever cannot wait for [`Sender::emergency_stop`].
    pub fn stop_words(&self) -> &'static [u8] {
        if self.settings.protocol == Protocol::Grbl { b"\x18" } else { b"\nM112\n" }
    }

    /// What the port has not taken is dropped; a line cut in two by that is ended, with its rest where no checksum would refuse it.
    pub(super) fn drop_unsent(&mut self) {
        let cut = self.taken > 0 && self.out.get(self.taken - 1).is_some_and(|b| *b != b'\n');
        let counts_blanks = matches!(self.settings.protocol, Protocol::Grbl | Protocol::Klipper);
        let unsent = &self.out[self.taken..];
        let rest = unsent.iter().position(|b| *b == b'\n').map_or(Vec::new(), |end| unsent[..=end].to_vec());
        self.out.clear();
        self.taken = 0;
        if cut && counts_blanks {
            // Without checksums half a line would be executed as another one: it goes out whole.
            self.out = rest;
        } else if !counts_blanks {
            self.out.push(b'\n');
        }
    }
}
