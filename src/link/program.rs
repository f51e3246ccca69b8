//! A file as what goes on the wire: compact blocks, how long each takes, where slots and layers begin.
//!
//! What would confuse the firmware's own counter or the host's is refused here, before a byte is sent: `M110` in any line
//! (Marlin looks for it with `strstr`, even in the text of M117), commands that jump the queue, that write or start
//! files, or that print a false `ok`.
//!
//! Units: seconds, bytes, file lines from 1, blocks from 0.

use super::compact::push_compact;
use super::timing::{Rates, seconds};
use super::wire::{Protocol, numbered_len};
use crate::gcode::marks;
use crate::gcode::meaning::{Effect, Firmware, Hazard, effect, waits};
use crate::gcode::{Command, LineKind, ParsedLine, lines};
use crate::motion::replay::{Controller, Reading, Step};

/// What the firmware on the other side takes.
#[derive(Clone, Debug)]
pub struct Rules {
    /// Its protocol.
    pub protocol: Protocol,
    /// Bytes of its longest line, number and checksum included.
    pub longest_line: usize,
    /// How lines are replayed.
    pub reading: Reading,
    /// The axes' speeds, for the time of each block.
    pub rates: Rates,
}

/// Where something begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MarkKind {
    /// A pose change: `;TRUNNION slot=`.
    Slot(u32),
    /// A print: `;TRUNNION print=`.
    Print(u32),
    /// `;LAYER_CHANGE` or `;LAYER:`.
    Layer,
}

/// A place of the program by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Mark {
    /// The first block behind the mark.
    pub block: u32,
    /// What begins.
    pub kind: MarkKind,
}

/// The program on its way to the machine.
#[derive(Clone, Debug)]
pub struct Program {
    firmware: Firmware,
    bytes: Vec<u8>,
    ends: Vec<u32>,
    file_lines: Vec<u32>,
    seconds: Vec<f32>,
    /// The blocks at which the program waits for something other than its own motion, in order.
    waiting: Vec<u32>,
    /// Slots, prints and layers, in order.
    pub marks: Vec<Mark>,
    /// The first line that the replay could not follow, with its reason; a re-entry is then impossible.
    pub unknown: Option<(u32, String)>,
}

/// Why a file cannot be sent.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ProgramError {
    /// Bytes that are no G-code.
    #[error("line {line}: {why}; the file is damaged or not G-code")]
    Damaged {
        /// In the file, from 1.
        line: u32,
        /// What was found.
        why: String,
    },
    /// A command that must not be streamed.
    #[error("line {line}: {command} {why}; take it out of the file")]
    Forbidden {
        /// In the file, from 1.
        line: u32,
        /// The command.
        command: String,
        /// What it would do.
        why: &'static str,
    },
    /// More bytes than the firmware's line holds.
    #[error("line {line} is {bytes} bytes on the wire; {protocol} takes {allowed}; shorten the text or macro")]
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
    #[error("there is no command in the file")]
    Empty,
    /// More than one job can be.
    #[error("the file has {bytes} bytes; up to {allowed} (1 GiB) are sent as one job; split it at a slot")]
    TooBig {
        /// The file's size.
        bytes: u64,
        /// The most.
        allowed: u64,
    },
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
    pub fn read(file: &[u8], rules: &Rules) -> Result<Self, ProgramError> {
        if file.len() as u64 > LARGEST_FILE {
            return Err(ProgramError::TooBig { bytes: file.len() as u64, allowed: LARGEST_FILE });
        }
        let firmware = rules.protocol.firmware();
        let mut program = Self {
            firmware,
            bytes: Vec::with_capacity(file.len()),
            ends: Vec::new(),
            file_lines: Vec::new(),
            seconds: Vec::new(),
            waiting: Vec::new(),
            marks: Vec::new(),
            unknown: None,
        };
        let mut parsed = ParsedLine::default();
        let mut controller = Controller::new(Reading { firmware, ..rules.reading.clone() });
        for line in lines(file) {
            let damaged = |why: String| ProgramError::Damaged { line: line.number, why };
            parsed.read(line.bytes).map_err(|e| damaged(e.to_string()))?;
            if let Some(kind) = mark(&line.bytes[parsed.comment.clone()]) {
                program.marks.push(Mark { block: program.len(), kind });
            }
            let code = &line.bytes[parsed.code.clone()];
            if !program.push(code, &parsed, line.number, rules)? {
                continue;
            }
            let took = match controller.step(&parsed) {
                Ok(Step::Move(m)) => seconds(&m, &rules.rates).min(LONGEST_S),
                Ok(Step::Effect(Effect::Dwell(s))) => s.clamp(0.0, LONGEST_S),
                Ok(_) => 0.0,
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
        if program.ends.is_empty() { Err(ProgramError::Empty) } else { Ok(program) }
    }

    /// Adds one block; `false` where the line holds none.
    fn push(&mut self, code: &[u8], parsed: &ParsedLine, line: u32, rules: &Rules) -> Result<bool, ProgramError> {
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
        if let Some((command, why)) = forbidden(block, parsed, rules.protocol) {
            return Err(ProgramError::Forbidden { line, command, why });
        }
        let numbered = rules.protocol.numbered();
        let bytes = if numbered { numbered_len(LATE_NUMBER, block) + 3 } else { block.len() + 1 };
        if bytes > rules.longest_line {
            let (allowed, protocol) = (rules.longest_line, rules.protocol.name());
            return Err(ProgramError::TooLong { line, bytes, allowed, protocol });
        }
        self.ends.push(self.bytes.len() as u32);
        self.file_lines.push(line);
        Ok(true)
    }

    /// Whose words its blocks are, as `reading` reads them.
    pub(super) fn reading(&self, reading: &Reading) -> Reading {
        Reading { firmware: self.firmware, ..reading.clone() }
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

    /// Whether the program stands at block `index` until heat, homing, a person or the end of a wait.
    pub fn waits(&self, index: u32) -> bool {
        self.waiting.binary_search(&index).is_ok()
    }

    /// Seconds that block `index` asks for, accelerations left out; 10⁶ at most.
    pub fn seconds(&self, index: u32) -> f64 {
        self.seconds.get(index as usize).map_or(0.0, |s| f64::from(*s))
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

/// The beginnings of lines that mean something to a host; M118 must not print them.
const HOST_WORDS: [&str; 10] = ["ok", "resend", "rs ", "error", "start", "!!", "wait", "grbl", "alarm", "//"];

fn forbidden(block: &[u8], parsed: &ParsedLine, protocol: Protocol) -> Option<(String, &'static str)> {
    let firmware = protocol.firmware();
    // They would break the count of answers, or print something else.
    if let Effect::Hazard(hazard @ (Hazard::Counter | Hazard::OutOfBand | Hazard::File | Hazard::Stop)) =
        effect(firmware, parsed)
    {
        let name = parsed.commands.first().map_or_else(|| first_word(block), ToString::to_string);
        return Some((name, hazard.does()));
    }
    if parsed.commands.first() == Some(&Command::m(118)) {
        let text = String::from_utf8_lossy(&block[4..]).to_ascii_lowercase();
        let said = text.trim_start().trim_start_matches("e1").trim_start();
        if HOST_WORDS.iter().any(|word| said.starts_with(word)) {
            return Some(("M118".to_owned(), "would print a line that looks like the printer's own answer"));
        }
    }
    if memchr::memmem::find(block, b"M110").is_some() {
        return Some(("M110".to_owned(), "sets the printer's line counter, which streaming needs"));
    }
    if protocol == Protocol::Grbl { not_grbl(block, parsed) } else { None }
}

fn first_word(block: &[u8]) -> String {
    String::from_utf8_lossy(block).split(' ').next().unwrap_or_default().to_owned()
}

fn not_grbl(block: &[u8], parsed: &ParsedLine) -> Option<(String, &'static str)> {
    let not_g = parsed.commands.first().is_none_or(|c| c.letter != b'G');
    // A G-code that it does not know it answers with an error itself, and the print stops there.
    if not_g && effect(Firmware::Grbl, parsed) == Effect::Hazard(Hazard::Unknown) {
        let name = parsed.commands.first().map_or_else(|| first_word(block), ToString::to_string);
        return Some((name, "is not known to Grbl (error:20); use a profile whose dialect is rs274"));
    }
    if parsed.has(b'E') {
        return Some((
            "an E word".to_owned(),
            "is not known to Grbl (error:20); give the profile a spare axis as extruder",
        ));
    }
    let real_time = block.iter().any(|b| matches!(b, b'?' | b'!' | b'~' | 0x18 | 0x80..));
    real_time.then(|| ("a real-time character".to_owned(), "would act at once, whatever stands around it"))
}

fn mark(comment: &[u8]) -> Option<MarkKind> {
    match marks::mark(comment) {
        Some(marks::Mark::Slot(slot)) => Some(MarkKind::Slot(slot as u32)),
        Some(marks::Mark::Print { print, .. }) => Some(MarkKind::Print(print as u32)),
        Some(_) => None,
        None => (marks::hint(comment) == Some(marks::Hint::Layer)).then_some(MarkKind::Layer),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rules(protocol: Protocol) -> Rules {
        Rules { protocol, longest_line: 96, reading: Reading::sliced(), rates: Rates::default() }
    }

    fn read(text: &[u8]) -> Result<Program, ProgramError> {
        Program::read(text, &rules(Protocol::Marlin))
    }

    #[test]
    fn blocks_know_their_lines_times_and_marks() {
        let text = b"; hello\nG28\n;TRUNNION slot=3 part=1 A=70 C=90\n;LAYER_CHANGE\nG1 X0 F600\n\nG1 X10.0 ; there\n";
        let program = read(text).unwrap();
        let blocks: Vec<_> =
            (0..program.len()).map(|i| String::from_utf8_lossy(program.block(i)).into_owned()).collect();
        assert_eq!(blocks, ["G28", "G1X0F600", "G1X10"]);
        assert_eq!((0..3).map(|i| program.file_line(i)).collect::<Vec<_>>(), [2, 5, 7]);
        assert!((program.seconds(2) - 1.0).abs() < 1e-6);
        let slot = Mark { block: 1, kind: MarkKind::Slot(3) };
        assert_eq!(program.marks, [slot, Mark { block: 1, kind: MarkKind::Layer }]);
    }

    #[test]
    fn a_feed_next_to_nothing_gives_a_time_that_can_be_waited_for() {
        for feed in ["0.0000000000000000001", "0.00000000000000000000000000000000000000000000000001", "0.001"] {
            let program = read(format!("G28\nG1 X0\nG1 X100 F{feed}\n").as_bytes()).unwrap();
            assert!((program.seconds(2) - 1e6).abs() < 1.0, "F{feed}: {} s", program.seconds(2));
        }
    }

    #[test]
    fn what_breaks_the_counters_is_refused_with_its_line() {
        for text in ["M110 N5", "M112", "M108", "M410", "M23 x.g", "M28 x.g", "M118 ok", "M118 E1 Resend: 1", "M999"] {
            let error = read(format!("G28\n{text}\n").as_bytes()).unwrap_err();
            assert!(matches!(error, ProgramError::Forbidden { line: 2, .. }), "{text}: {error}");
        }
        let error = read(b"G28\nSET_X M110\n").unwrap_err();
        assert!(matches!(error, ProgramError::Forbidden { line: 2, .. }), "{error}");
    }

    #[test]
    fn a_message_that_holds_m110_is_rewritten_and_odd_bytes_go() {
        let program = read(b"M117 see M110 N7 and M110\nM117 caf\xe9\x00\n").unwrap();
        assert_eq!(program.block(0), b"M117 see m110 N7 and m110");
        assert_eq!(program.block(1), b"M117 caf??");
        assert!(matches!(read(b"G1 X\xff5\n"), Err(ProgramError::Damaged { line: 1, .. })));
    }

    #[test]
    fn too_long_empty_and_foreign_lines_are_refused() {
        let long = format!("M117 {}\n", "x".repeat(90));
        assert!(matches!(read(long.as_bytes()), Err(ProgramError::TooLong { line: 1, bytes: 111, allowed: 96, .. })));
        assert_eq!(read(b"; nothing\n").unwrap_err(), ProgramError::Empty);
        let grbl = |text: &str| Program::read(text.as_bytes(), &rules(Protocol::Grbl));
        for text in ["M104 S200", "G1 X1 E2", "M117 what?"] {
            assert!(matches!(grbl(text), Err(ProgramError::Forbidden { line: 1, .. })), "{text}");
        }
        assert!(grbl("G1 X1 F100\nM2").is_ok());
    }
}
