//! A file as what goes on the wire: compact blocks, how long each takes, where slots and layers begin.
//!
//! What would confuse the firmware's own counter or the host's is refused here, before a byte is sent: `M110` in any line
//! (Marlin looks for it with `strstr`, even in the text of M117), commands that jump the queue, that write or start
//! files, or that print a false `ok`.
//!
//! Units: seconds, bytes, file lines from 1, blocks from 0.

mod refused;
mod replay;

use super::compact::push_compact;
use super::padding::Padding;
use super::protocol::Protocol;
use super::wire::numbered_len;
use crate::gcode::marks;
use crate::gcode::meaning::{Firmware, waits};
use crate::gcode::{Command, LineKind, ParsedLine, lines};
use crate::location::Location;
use crate::motion::replay::{Position, Reading};
use crate::trace::{Interpreter, MotionClock, TraceSetting};
use refused::refused;
use replay::Replay;

/// What the firmware on the other side takes.
#[derive(Clone, Debug)]
pub struct ProgramRules {
    /// Its protocol.
    pub protocol: Protocol,
    /// Bytes of its longest line, number and checksum included.
    pub longest_line: usize,
    /// How its lines are read, and the axes' speeds: those that verification has.
    pub setting: TraceSetting,
}

/// Where something begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BoundaryKind {
    /// A pose change: `;TRUNNION slot=`.
    Slot(u32),
    /// A print: `;TRUNNION print=`.
    Print(u32),
    /// `;LAYER_CHANGE` or `;LAYER:`.
    Layer,
}

/// A place at which a print can go on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Boundary {
    /// The first block behind it.
    pub block: u32,
    /// What begins.
    pub kind: BoundaryKind,
}

/// The program on its way to the machine.
#[derive(Clone, Debug)]
pub struct Program {
    setting: TraceSetting,
    bytes: Vec<u8>,
    ends: Vec<u32>,
    file_lines: Vec<u32>,
    seconds: Vec<f32>,
    seconds_print: f64,
    /// The blocks at which the program waits for something other than its own motion, in order.
    waiting: Vec<u32>,
    /// Where the machine is before the first block of each layer, as far as that is known.
    places: Vec<(u32, Position)>,
    /// Slots, prints and layers, in order.
    pub boundaries: Vec<Boundary>,
    /// The first line that the replay could not follow, with its reason: behind it nobody knows where the head is.
    pub unknown: Option<(u32, String)>,
}

/// Why a file cannot be sent.
#[derive(Clone, Debug, PartialEq, thiserror::Error, strum::IntoStaticStr)]
#[strum(serialize_all = "kebab-case", prefix = "program/")]
pub enum ProgramError {
    /// Bytes that are not G-code.
    #[error("line {line}: {why}; the file is damaged or not G-code")]
    Damaged {
        /// In the file, from 1.
        line: u32,
        /// What was found.
        why: String,
    },
    /// A command that must not be streamed.
    #[error("line {line}: {command} {why}; remove it from the file")]
    Forbidden {
        /// In the file, from 1.
        line: u32,
        /// The command.
        command: String,
        /// What it would do.
        why: &'static str,
    },
    /// A line after which the head's position is unknown, so that no pause or resume is possible.
    #[error(
        "line {line}: {why}; the head's position is unknown after it, so a pause cannot lift the head; use moves with a known end point"
    )]
    Unfollowed {
        /// In the file, from 1.
        line: u32,
        /// Why the replay cannot follow it.
        why: String,
    },
    /// More bytes than the firmware's line holds.
    #[error("line {line} is {bytes} bytes on the wire; {protocol} accepts {allowed}; shorten the text or macro")]
    TooLong {
        /// In the file, from 1.
        line: u32,
        /// With number and checksum.
        bytes: usize,
        /// What the firmware takes.
        allowed: usize,
        /// The protocol's name.
        protocol: &'static str,
    },
    /// Nothing to send.
    #[error("the file has no commands")]
    Empty,
    /// More than one job can be.
    #[error(
        "the file has {bytes} bytes; at most {allowed} (1 GiB) are sent as one job; print fewer parts at once, or slice with a coarser G-code \
         resolution"
    )]
    TooBig {
        /// The file's size.
        bytes: u64,
        /// The most.
        allowed: u64,
    },
}

impl ProgramError {
    /// Where in what the user gave it is.
    pub fn location(&self) -> Location {
        match self {
            Self::Damaged { line, .. } | Self::Unfollowed { line, .. } | Self::TooLong { line, .. } => {
                Location::default().line(*line)
            }
            Self::Forbidden { line, command, .. } => Location::default().line(*line).word(command),
            Self::Empty | Self::TooBig { .. } => Location::default(),
        }
    }
}

/// The largest file that is sent as one job, bytes.
pub const LARGEST_FILE: u64 = 1 << 30;

/// What a block asks for beyond this is cut, so that sums of such times are still times: 11 days.
const LONGEST_S: f64 = 1e6;

/// A number of the size that a program's last lines have, for the length of a line.
const LATE_NUMBER: i64 = 9_999_999;

impl Program {
    /// Takes a whole file apart.
    ///
    /// # Errors
    ///
    /// [`ProgramError`] names the first line that must not be sent.
    pub fn read(file: &[u8], rules: &ProgramRules) -> Result<Self, ProgramError> {
        if file.len() as u64 > LARGEST_FILE {
            return Err(ProgramError::TooBig { bytes: file.len() as u64, allowed: LARGEST_FILE });
        }
        let firmware = rules.protocol.firmware();
        let reading = Reading { firmware, ..rules.setting.reading.clone() };
        let mut program = Self {
            setting: TraceSetting { reading, ..rules.setting.clone() },
            bytes: Vec::with_capacity(file.len()),
            ends: Vec::new(),
            file_lines: Vec::new(),
            seconds: Vec::new(),
            seconds_print: 0.0,
            waiting: Vec::new(),
            places: Vec::new(),
            boundaries: Vec::new(),
            unknown: None,
        };
        let mut parsed = ParsedLine::default();
        let mut interpreter = Interpreter::new(&program.setting);
        let mut clock = MotionClock::new(&program.setting.accelerations);
        for line in lines(file) {
            let damaged = |why: String| ProgramError::Damaged { line: line.number, why };
            parsed.read(line.bytes).map_err(|e| damaged(e.to_string()))?;
            if parsed.kind == LineKind::Empty
                && let Some(kind) = boundary(&line.bytes[parsed.comment.clone()])
            {
                program.boundaries.push(Boundary { block: program.len(), kind });
                if kind == BoundaryKind::Layer && program.unknown.is_none() {
                    program.places.push((program.len(), interpreter.controller().at));
                }
            }
            let code = &line.bytes[parsed.code.clone()];
            if !program.push(code, &parsed, line.number, rules)? {
                continue;
            }
            let took = match interpreter.take(&parsed) {
                Ok(action) => {
                    clock.take(&action);
                    action.seconds().min(LONGEST_S)
                }
                Err(why) => {
                    program.unknown.get_or_insert((line.number, why.to_string()));
                    0.0
                }
            };
            if waits(firmware, &parsed) {
                program.waiting.push(program.seconds.len() as u32);
            }
            program.seconds.push(took as f32);
        }
        program.seconds_print = clock.seconds();
        if program.ends.is_empty() { Err(ProgramError::Empty) } else { Ok(program) }
    }

    /// Adds one block; `false` where the line holds none.
    fn push(
        &mut self,
        code: &[u8],
        parsed: &ParsedLine,
        line: u32,
        rules: &ProgramRules,
    ) -> Result<bool, ProgramError> {
        let start = self.bytes.len();
        match parsed.kind {
            LineKind::Empty | LineKind::Percent => return Ok(false),
            LineKind::Words => push_compact(&mut self.bytes, code),
            LineKind::Text | LineKind::Macro => self.bytes.extend(code.iter().map(|&b| printable(b))),
        }
        if self.bytes.len() == start {
            return Ok(false);
        }
        rewrite_numbering_text(&mut self.bytes, start, parsed);
        let block = &self.bytes[start..];
        if let Some((command, why)) = refused(block, parsed, rules.protocol) {
            return Err(ProgramError::Forbidden { line, command, why });
        }
        let numbered = rules.protocol.numbered();
        let bytes = if numbered { numbered_len(LATE_NUMBER, block) + Padding::MOST } else { block.len() + 1 };
        if bytes > rules.longest_line {
            let (allowed, protocol) = (rules.longest_line, rules.protocol.name());
            return Err(ProgramError::TooLong { line, bytes, allowed, protocol });
        }
        self.ends.push(self.bytes.len() as u32);
        self.file_lines.push(line);
        Ok(true)
    }

    /// Its blocks once more, from the first: what each does to the machine.
    pub(super) fn replay(&self) -> Replay<'_> {
        Replay::new(self, &self.setting)
    }

    /// The tip's fastest, mm/min.
    pub(super) fn max_feed(&self) -> f64 {
        self.setting.rates.max_feed
    }

    /// Whose words its blocks are.
    pub(crate) fn firmware(&self) -> Firmware {
        self.setting.reading.firmware
    }

    /// Where the machine is before block `block`, where a layer begins there.
    pub(super) fn place_before(&self, block: u32) -> Option<&Position> {
        let index = self.places.partition_point(|(first, _)| *first < block);
        self.places.get(index).filter(|(first, _)| *first == block).map(|(_, place)| place)
    }

    /// How many blocks there are.
    pub fn len(&self) -> u32 {
        self.ends.len() as u32
    }

    /// Whether there are none; never for a program that was read.
    pub fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// The bytes of block `index`, without number, checksum or newline.
    ///
    /// # Panics
    ///
    /// Panics where `index` is not below [`Program::len`].
    pub fn block(&self, index: u32) -> &[u8] {
        let index = index as usize;
        let start = if index == 0 { 0 } else { self.ends[index - 1] as usize };
        &self.bytes[start..self.ends[index] as usize]
    }

    /// The line of the file that block `index` stands on; the last one's for an index at or beyond the end.
    pub fn file_line(&self, index: u32) -> u32 {
        self.file_lines.get(index as usize).or(self.file_lines.last()).copied().unwrap_or(0)
    }

    /// The first block on line `line` of the file or behind it.
    pub fn block_on(&self, line: u32) -> u32 {
        self.file_lines.partition_point(|l| *l < line) as u32
    }

    /// Whether the program stands at block `index` until heat, homing, a person or the end of a wait.
    pub fn waits(&self, index: u32) -> bool {
        self.waiting.binary_search(&index).is_ok()
    }

    /// Seconds that block `index` takes at the speeds written; 10⁶ at most.
    pub fn seconds(&self, index: u32) -> f64 {
        self.seconds.get(index as usize).map_or(0.0, |s| f64::from(*s))
    }

    /// Seconds of all blocks, heating left out: the time that verification states.
    pub fn seconds_print(&self) -> f64 {
        self.seconds_print
    }
}

/// What stands for a byte that no firmware's text can show.
fn printable(byte: u8) -> u8 {
    match byte {
        b'\t' => b' ',
        b' '..=b'~' => byte,
        _ => b'?',
    }
}

/// Marlin finds `M110` anywhere in a line and would renumber its counter for the text of a message.
fn rewrite_numbering_text(bytes: &mut [u8], start: usize, parsed: &ParsedLine) {
    let is_text = parsed.kind == LineKind::Text && parsed.commands.first() != Some(&Command::m(110));
    if !is_text {
        return;
    }
    let text = &mut bytes[start..];
    while let Some(at) = memchr::memmem::find(&text[1..], b"M110") {
        text[at + 1] = b'm';
    }
}

fn boundary(comment: &[u8]) -> Option<BoundaryKind> {
    match marks::mark(comment) {
        Some(marks::Mark::Slot(slot)) => Some(BoundaryKind::Slot(slot as u32)),
        Some(marks::Mark::Print { print, .. }) => Some(BoundaryKind::Print(print as u32)),
        Some(_) => None,
        None => (marks::hint(comment) == Some(marks::Hint::Layer)).then_some(BoundaryKind::Layer),
    }
}

#[cfg(test)]
mod tests;
