//! Numbers and history: which lines are under way, which are answered, and which are known to be accepted.
//!
//! ```text
//! numbers   proven <= credited < cursor <= last + 1
//!           |         |          '- next to go on the wire
//!           |         '- answered with an `ok`, which may be a false one
//!           '- known to be accepted: never sent again
//! ```
//!
//! Every line has a number, on the wire or only here.
//!
//! Of the bytes without an answer those of lines up to `drained` are known to have left the firmware's receive buffer: its queue holds them.

use std::collections::VecDeque;

use crate::link::padding::{Padder, Padding, push_padded};
use crate::link::program::Program;
use crate::link::wire::numbered_len;

/// What a line is for.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Purpose {
    /// A block of the program.
    Block(u32),
    /// M105: its answer proves everything before it.
    Proof,
    /// M114: the printer has to say where it is.
    Where,
    /// M115.
    Identify,
    /// M110: the numbers begin anew behind it. Nothing else is under way meanwhile.
    Renumber,
    /// A line of our own.
    Own(Box<[u8]>),
}

impl Purpose {
    pub(super) fn text<'a>(&'a self, program: &'a Program) -> &'a [u8] {
        match self {
            Self::Block(index) => program.block(*index),
            Self::Proof => b"M105",
            Self::Where => b"M114",
            Self::Identify => b"M115",
            Self::Renumber => b"M110 N0",
            Self::Own(text) => text,
        }
    }
}

/// A line that was made and is not yet proven.
#[derive(Clone, Debug)]
struct Sent {
    purpose: Purpose,
    /// On the wire, newline included.
    bytes: usize,
    padding: Padding,
}

/// A line that was refused.
#[derive(Clone, Copy, Debug)]
struct Refused {
    number: i64,
    times: u32,
    /// Refusals of lines behind it that are still under way.
    behind: u32,
}

/// What a refusal comes to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum RefusalKind {
    /// Of a line that was under way behind the refused one: nothing to do.
    Echo,
    /// For so many times.
    Times(u32),
}

/// How a line is put on the wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Framing {
    /// As it is.
    Plain,
    /// With number and checksum.
    Numbered {
        /// And a blank behind the number.
        blank: bool,
    },
}

impl Framing {
    /// A line outside the count: a greeting, a question, an emergency stop.
    pub(super) fn write(self, out: &mut Vec<u8>, number: i64, text: &[u8]) {
        match self {
            Self::Plain => {
                out.extend_from_slice(text);
                out.push(b'\n');
            }
            Self::Numbered { blank } => push_padded(out, number, Padding::least(blank), text),
        }
    }
}

/// Lines that were made and are not proven.
#[derive(Clone, Debug)]
pub(super) struct Ledger {
    framing: Framing,
    /// Lines `proven + 1 ..= last`.
    lines: VecDeque<Sent>,
    proven: i64,
    credited: i64,
    cursor: i64,
    drained: i64,
    /// Bytes on the wire that may lie in the firmware's receive buffer.
    bytes_out: usize,
    padder: Padder,
    /// While this number is not credited, one line at a time.
    narrow: i64,
    refused: Option<Refused>,
}

impl Ledger {
    pub(super) fn new(framing: Framing) -> Self {
        Self {
            framing,
            lines: VecDeque::new(),
            proven: 0,
            credited: 0,
            cursor: 1,
            drained: 0,
            bytes_out: 0,
            padder: Padder::default(),
            narrow: 0,
            refused: None,
        }
    }

    /// The numbers begin again at 1.
    pub(super) fn begin_anew(&mut self) {
        *self = Self { padder: std::mem::take(&mut self.padder), ..Self::new(self.framing) };
    }

    /// As a journal knows it: lines up to `proven` are accepted, `lines` may have been sent behind them.
    pub(super) fn broken_off(&mut self, proven: i64, lines: impl Iterator<Item = Purpose>) {
        self.lines = lines.map(|purpose| Sent { purpose, bytes: 0, padding: Padding::default() }).collect();
        (self.proven, self.credited, self.drained, self.cursor) = (proven, proven, proven, proven + 1);
    }

    /// Whether a blank follows the numbers of lines that are made from now on; where it does, those that go out again have one, too.
    pub(super) fn space(&mut self, blank: bool) {
        if let Framing::Numbered { blank: spaced } = &mut self.framing {
            *spaced = blank;
        }
        for sent in self.lines.iter_mut().filter(|_| blank) {
            sent.bytes += usize::from(!sent.padding.is_spaced());
            sent.padding = sent.padding.spaced();
        }
    }

    /// Whether line `number` has no blank behind its number.
    pub(super) fn is_short(&self, number: i64) -> bool {
        self.sent(number).is_some_and(|sent| !sent.padding.is_spaced())
    }

    pub(super) fn framing(&self) -> Framing {
        self.framing
    }

    pub(super) fn proven(&self) -> i64 {
        self.proven
    }

    pub(super) fn credited(&self) -> i64 {
        self.credited
    }

    /// The number that goes out next.
    pub(super) fn cursor(&self) -> i64 {
        self.cursor
    }

    /// The highest number made.
    pub(super) fn last(&self) -> i64 {
        self.proven + self.lines.len() as i64
    }

    /// Lines on the wire without an answer.
    pub(super) fn in_flight(&self) -> i64 {
        self.cursor - 1 - self.credited
    }

    /// Bytes of them that may lie in the firmware's receive buffer.
    pub(super) fn bytes_out(&self) -> usize {
        self.bytes_out
    }

    /// Whether every line that was made is on the wire.
    pub(super) fn is_sent(&self) -> bool {
        self.cursor > self.last()
    }

    fn sent(&self, number: i64) -> Option<&Sent> {
        usize::try_from(number - self.proven - 1).ok().and_then(|index| self.lines.get(index))
    }

    pub(super) fn purpose(&self, number: i64) -> Option<&Purpose> {
        self.sent(number).map(|sent| &sent.purpose)
    }

    /// Lines on the wire without an answer, with their numbers.
    pub(super) fn unanswered(&self) -> impl Iterator<Item = (i64, &Purpose)> {
        (self.credited + 1..self.cursor).filter_map(|n| Some((n, self.purpose(n)?)))
    }

    /// The line that was made last, unless it is proven.
    pub(super) fn newest(&self) -> Option<&Purpose> {
        self.lines.back().map(|sent| &sent.purpose)
    }

    /// The first block that is not proven.
    pub(super) fn first_block(&self) -> Option<u32> {
        self.lines.iter().find_map(|sent| if let Purpose::Block(index) = sent.purpose { Some(index) } else { None })
    }

    /// Bytes of `text` on the wire, newline included.
    fn length(&self, text: &[u8]) -> usize {
        let Framing::Numbered { blank } = self.framing else { return text.len() + 1 };
        let (padding, mut line) = (self.padder.clone().pad(self.cursor, text, blank), Vec::with_capacity(128));
        push_padded(&mut line, self.cursor, padding, text);
        line.len()
    }

    /// The most that [`Ledger::length`] can be.
    fn length_at_most(&self, text: &[u8]) -> usize {
        match self.framing {
            Framing::Plain => text.len() + 1,
            Framing::Numbered { .. } => numbered_len(self.cursor, text) + Padding::MOST,
        }
    }

    /// Bytes of the line at the cursor, which was made before.
    pub(super) fn length_again(&self) -> usize {
        self.sent(self.cursor).map_or(0, |sent| sent.bytes)
    }

    /// Whether one more line may be without an answer, of `lines` at most.
    pub(super) fn has_room(&self, lines: usize) -> bool {
        let lines = if self.credited < self.narrow { 1 } else { lines };
        (self.in_flight() as usize) < lines
    }

    /// Whether `bytes` more find the receive buffer empty enough; nothing under way always does.
    pub(super) fn fits(&self, bytes: usize, most: usize) -> bool {
        self.in_flight() == 0 || self.bytes_out + bytes <= most
    }

    /// The same for a new line of `text`, to the byte.
    pub(super) fn fits_new(&self, text: &[u8], most: usize) -> bool {
        self.fits(self.length_at_most(text), most)
            || (self.fits(text.len(), most) && self.fits(self.length(text), most))
    }

    /// A new line, behind all others.
    pub(super) fn make(&mut self, purpose: Purpose, program: &Program) {
        let text = purpose.text(program);
        let bytes = self.length_at_most(text);
        let padding = match self.framing {
            Framing::Plain => Padding::default(),
            Framing::Numbered { blank } => self.padder.pad(self.cursor, text, blank),
        };
        self.lines.push_back(Sent { purpose, bytes, padding });
    }

    /// Writes the line at the cursor.
    pub(super) fn write(&mut self, out: &mut Vec<u8>, program: &Program) {
        let Some(sent) = usize::try_from(self.cursor - self.proven - 1).ok().and_then(|i| self.lines.get_mut(i)) else {
            return;
        };
        let start = out.len();
        let text = sent.purpose.text(program);
        match self.framing {
            Framing::Plain => self.framing.write(out, self.cursor, text),
            Framing::Numbered { .. } => push_padded(out, self.cursor, sent.padding, text),
        }
        sent.bytes = out.len() - start;
        self.bytes_out += sent.bytes;
        self.cursor += 1;
    }

    /// The oldest line without an answer counts as answered.
    pub(super) fn credit(&mut self) -> Option<Purpose> {
        self.credited += 1;
        let (bytes, purpose) = self.sent(self.credited).map(|sent| (sent.bytes, sent.purpose.clone()))?;
        if self.credited > self.drained {
            self.bytes_out = self.bytes_out.saturating_sub(bytes);
        }
        Some(purpose)
    }

    /// Lines up to `to` are known to have left the receive buffer.
    pub(super) fn drain(&mut self, to: i64) {
        let to = to.min(self.cursor - 1);
        if to > self.drained.max(self.credited) {
            self.drained = to;
            self.count_bytes();
        }
    }

    /// Everything up to `to` is known to be accepted and leaves the history.
    pub(super) fn prove(&mut self, to: i64) {
        while self.proven < to && self.lines.pop_front().is_some() {
            self.proven += 1;
        }
        self.refused = self.refused.filter(|refused| refused.number > self.proven);
    }

    /// The printer's own word: it has taken everything up to `found`, and nothing behind it. How often it has refused the next line.
    ///
    /// Each line that is under way behind that will be refused as well, and so will the question: none of these is a new refusal.
    pub(super) fn agree(&mut self, found: i64) -> u32 {
        let times = self.refused.filter(|refused| refused.number == found + 1).map_or(0, |refused| refused.times) + 1;
        let behind = u32::try_from(self.cursor - 1 - found).unwrap_or(0);
        (self.credited, self.drained) = (found, found);
        self.prove(found);
        self.refused = (behind > 0).then_some(Refused { number: found + 1, times, behind });
        self.count_bytes();
        times
    }

    /// Every line is known to have arrived, whatever was to go out again.
    pub(super) fn all_sent(&mut self) {
        self.cursor = self.last() + 1;
    }

    /// Goes back to `number`, which the printer has not taken.
    pub(super) fn rewind(&mut self, number: i64) {
        self.cursor = number;
        self.credited = self.credited.min(number - 1);
        self.drained = self.drained.min(number - 1);
        self.narrow = number;
        self.count_bytes();
    }

    /// The history is given up behind what is proven; our own lines of it, which are still wanted.
    pub(super) fn take_own(&mut self) -> Vec<Purpose> {
        let own = self.lines.drain(..).map(|sent| sent.purpose).filter(|p| matches!(p, Purpose::Own(_))).collect();
        (self.cursor, self.drained, self.narrow, self.bytes_out) = (self.proven + 1, self.proven, 0, 0);
        self.refused = None;
        own
    }

    fn count_bytes(&mut self) {
        let behind = self.credited.max(self.drained);
        self.bytes_out = (behind + 1..self.cursor).filter_map(|n| self.sent(n)).map(|s| s.bytes).sum();
    }

    /// `number` was refused, and is to go out again unless that is an echo.
    pub(super) fn refuse(&mut self, number: i64) -> RefusalKind {
        let known = self.refused.filter(|refused| refused.number == number);
        if let Some(refused) = known.filter(|refused| refused.behind > 0) {
            self.refused = Some(Refused { behind: refused.behind - 1, ..refused });
            return RefusalKind::Echo;
        }
        let times = known.map_or(1, |refused| refused.times + 1);
        let behind = u32::try_from(self.cursor - 1 - number).unwrap_or(0);
        self.refused = Some(Refused { number, times, behind });
        RefusalKind::Times(times)
    }
}
