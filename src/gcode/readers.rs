//! How each firmware reads a line: one table of rules, and what a firmware takes a line for where that is not what
//! [`ParsedLine`] says.
//!
//! ```text
//!                    Marlin          RepRapFirmware    Klipper       Grbl            LinuxCNC
//! ( .. )             words           words             a bad number  comment         comment
//! longest line       95 bytes, cut   255, refused      any           79, refused     251 with its comment, ends the program
//! a letter twice     last or first   first             last          refused         refused
//! X1E5               X1 E5           X100000           X1 E5         refused         refused
//! g1 x5              not read        read              read          read            read
//! X5 after G1        not read        not read          not read      a move          a move
//! G01, G1.0 / G 1    read / read     read / not read   not read      read / read     read / read
//! CR within a line   ends it         ends it or not    blank         ends it         blank
//! N1 .. *99          read            read              read          refused         refused
//! ```
//!
//! Sources: Marlin 2.1 `gcode/queue.cpp` (`process_stream_char`, `MAX_CMD_SIZE`, `PAREN_COMMENTS` off) and `gcode/parser.cpp`
//! (`GCODE_CASE_INSENSITIVE`, `GCODE_MOTION_MODES` off; without `FASTER_GCODE_PARSER` the first of two words counts);
//! RepRapFirmware 3 `GCodeBuffer/StringParser.cpp` (`Put`, `DecodeCommand`, `Seen`) as a machine that prints; Klipper
//! `klippy/gcode.py` (`_process_commands`); Grbl 1.1 `protocol.c` and `gcode.c` (`LINE_BUFFER_SIZE`, error 25); LinuxCNC
//! `rs274ngc/interp_read.cc` (`LINELEN`, `NCE_MULTIPLE_.._WORDS_ON_ONE_LINE`, `read_semicolon`).

use std::borrow::Cow;

use super::meaning::Firmware;
use super::{Command, LineKind, ParsedLine};

/// Why a firmware takes a line for something else than [`ParsedLine`] says.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Misreading {
    /// `(Z-5)` where parentheses hold no comment.
    #[error("reads what is in parentheses; write comments after ';'")]
    Parentheses,
    /// More bytes than are read.
    #[error("reads at most {most} bytes of a line, and this one has {bytes}; shorten it")]
    Long {
        /// As the firmware counts them.
        bytes: usize,
        /// What it reads.
        most: usize,
    },
    /// A letter twice.
    #[error("does not use the last of two {0} words; write each letter once")]
    Repeated(char),
    /// `X1E5` as a number.
    #[error("reads E right after a number as an exponent; write a space before E")]
    Exponent,
    /// A letter that is not a capital.
    #[error("does not read lowercase letters; write capitals")]
    SmallLetters,
    /// Words and no command.
    #[error("does not read words without a command; write G1 before them")]
    NoCommand,
    /// O-words: subroutines and loops.
    #[error("reads an O word as a subroutine, loop or condition; write out what it does")]
    ControlFlow,
    /// `G01`, `G1.0`, `G 1`.
    #[error("does not recognize a command written this way; write it as {0}")]
    Spelling(Command),
    /// Several commands of which not all that is meant is done.
    #[error("may not execute {0} commands of one line as intended; write each on its own line")]
    Several(usize),
    /// `E1:2` in a move.
    #[error("does not read a list such as E1:2 as one number; write one number")]
    List,
    /// `G3 .. P1`.
    #[error("may ignore the P word of an arc, or make full circles first; remove P and write the circles out")]
    Circles,
    /// A carriage return in the middle.
    #[error("may end the line at a carriage return; remove it")]
    CarriageReturn,
    /// A checksum.
    #[error("does not read checksums; remove '*' and what follows")]
    Checksum,
    /// A comment that is carried out.
    #[error("executes a comment that begins this way; remove it")]
    ActiveComment,
    /// A command in what is read as text.
    #[error("reads another command in the text; quote it")]
    CommandInText,
}

/// How a firmware reads lines.
#[derive(Clone, Copy, Debug)]
pub struct LineRules {
    firmware: Firmware,
    parentheses: bool,
    /// Bytes that are read.
    longest: Option<Longest>,
    last_word_counts: bool,
    exponents: bool,
    small_letters: bool,
    /// Axis words repeat the last move.
    modal: bool,
    /// `G01` is G1, `G 1` is.
    zeros: bool,
    gaps: bool,
    return_ends: bool,
    checksums: bool,
}

/// The bytes of a line that are read.
#[derive(Clone, Copy, Debug)]
struct Longest {
    most: usize,
    /// What is counted: all, all but the comment, or neither comments nor blanks.
    counts: Counts,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Counts {
    All,
    Code,
    Letters,
}

const fn longest(most: usize, counts: Counts) -> Option<Longest> {
    Some(Longest { most, counts })
}

/// Modes, which take effect before the move of their line wherever they are in it.
const MODES: [Command; 13] = [
    Command::g(17),
    Command::g(21),
    Command::g(40),
    Command::g(49),
    Command::g(61),
    Command::g(64),
    Command::g(80),
    Command::g(90),
    Command::g(91),
    Command::g(93),
    Command::g(94),
    Command::m(82),
    Command::m(83),
];

/// M0 and M1.
const PAUSE: Command = Command::m(0);
const STOP: Command = Command::m(1);

/// Commands whose text RepRapFirmware reads to the line's end.
const TEXT_TO_THE_END: [u32; 5] = [23, 28, 30, 32, 117];

impl LineRules {
    /// The rules of `firmware`.
    pub const fn of(firmware: Firmware) -> Self {
        let printer = Self {
            firmware,
            parentheses: false,
            longest: None,
            last_word_counts: false,
            exponents: false,
            small_letters: true,
            modal: false,
            zeros: true,
            gaps: true,
            return_ends: true,
            checksums: true,
        };
        let ngc = Self { parentheses: true, modal: true, checksums: false, ..printer };
        match firmware {
            Firmware::Marlin => Self { longest: longest(95, Counts::Code), small_letters: false, ..printer },
            Firmware::RepRapFirmware => {
                Self { longest: longest(255, Counts::Code), exponents: true, gaps: false, ..printer }
            }
            Firmware::Klipper => {
                Self { last_word_counts: true, zeros: false, gaps: false, return_ends: false, ..printer }
            }
            Firmware::Grbl => Self { longest: longest(79, Counts::Letters), ..ngc },
            Firmware::LinuxCnc => Self { longest: longest(251, Counts::All), return_ends: false, ..ngc },
        }
    }

    /// How many bytes a comment by itself may have.
    pub fn longest_comment(&self) -> Option<usize> {
        self.longest.filter(|longest| longest.counts == Counts::All).map(|longest| longest.most)
    }

    /// What the firmware takes `line` for, where that is not what it was `parsed` to; `None` where both read the same.
    pub fn misreading(&self, line: &[u8], parsed: &ParsedLine) -> Option<Misreading> {
        let code = &line[..memchr::memchr(b';', line).unwrap_or(line.len())];
        self.of_any_line(line, code, parsed.kind).or_else(|| match parsed.kind {
            // What follows a pause is shown to a person.
            LineKind::Words if self.takes_one_command() && matches!(parsed.commands.first(), Some(&PAUSE | &STOP)) => {
                None
            }
            LineKind::Words => self.of_words(code, parsed),
            LineKind::Text => self.of_text(parsed),
            LineKind::Empty | LineKind::Macro | LineKind::Percent => None,
        })
    }

    fn of_any_line(&self, line: &[u8], code: &[u8], kind: LineKind) -> Option<Misreading> {
        let ended = line.trim_ascii_end();
        if self.return_ends && memchr::memchr(b'\r', ended).is_some() {
            return Some(Misreading::CarriageReturn);
        }
        if self.firmware == Firmware::LinuxCnc && is_active(line, code) {
            return Some(Misreading::ActiveComment);
        }
        let Longest { most, counts } = self.longest?;
        let bytes = match (counts, kind) {
            (Counts::All, _) => line.len(),
            (_, LineKind::Empty) => 0,
            // Blanks behind the last word count.
            (Counts::Code, _) => code.strip_suffix(b"\r").unwrap_or(code).trim_ascii_start().len(),
            (Counts::Letters, _) => code.iter().filter(|b| !b.is_ascii_whitespace()).count(),
        };
        // Text that is cut or refused moves nothing.
        let matters = bytes > most && (counts == Counts::All || kind != LineKind::Text);
        matters.then_some(Misreading::Long { bytes, most })
    }

    /// Whether a line's first command is its only one.
    fn takes_one_command(&self) -> bool {
        matches!(self.firmware, Firmware::Marlin | Firmware::Klipper)
    }

    fn of_words(&self, code: &[u8], parsed: &ParsedLine) -> Option<Misreading> {
        let code = unquoted(code);
        self.of_spelling(&code, parsed).or_else(|| self.of_commands(&code, parsed))
    }

    fn of_spelling(&self, code: &[u8], parsed: &ParsedLine) -> Option<Misreading> {
        let has = |byte: u8| memchr::memchr(byte, code).is_some();
        if !self.parentheses && has(b'(') {
            return Some(Misreading::Parentheses);
        }
        if !self.checksums && has(b'*') {
            return Some(Misreading::Checksum);
        }
        if !self.small_letters && code.iter().any(u8::is_ascii_lowercase) {
            return Some(Misreading::SmallLetters);
        }
        if self.exponents
            && code.windows(2).any(|w| (w[0].is_ascii_digit() || w[0] == b'.') && w[1].eq_ignore_ascii_case(&b'E'))
        {
            return Some(Misreading::Exponent);
        }
        let moves = parsed.commands.iter().any(is_move);
        if has(b':') && (moves || parsed.commands.is_empty()) {
            return Some(Misreading::List);
        }
        let arc = |command: &Command| command.letter == b'G' && [2, 3].contains(&command.number);
        if self.firmware != Firmware::LinuxCnc && parsed.has(b'P') && parsed.commands.iter().any(arc) {
            return Some(Misreading::Circles);
        }
        self.command_spelling(&code[parsed.code.start.min(code.len())..], parsed)
    }

    /// The first command's letter and digits.
    fn command_spelling(&self, code: &[u8], parsed: &ParsedLine) -> Option<Misreading> {
        let command = *parsed.commands.first()?;
        let digits = code.get(1..)?;
        let gap = digits.first().is_some_and(u8::is_ascii_whitespace);
        let zero = matches!(digits, [b'0', b'0'..=b'9', ..]);
        let whole = digits.iter().take_while(|b| b.is_ascii_digit()).count();
        let point = command.minor == 0 && digits.get(whole) == Some(&b'.');
        let odd = (!self.gaps && gap) || (!self.zeros && (zero || point));
        odd.then_some(Misreading::Spelling(command))
    }

    fn of_commands(&self, code: &[u8], parsed: &ParsedLine) -> Option<Misreading> {
        if !self.firmware.is_printer() && parsed.has(b'O') {
            return Some(Misreading::ControlFlow);
        }
        let axis = |letter: u8| b"XYZABCUVWIJKRF".contains(&letter);
        if parsed.commands.is_empty() && !(self.modal && parsed.words.iter().all(|w| axis(w.letter))) {
            return Some(Misreading::NoCommand);
        }
        if !self.last_word_counts
            && let Some(letter) = repeated(parsed)
        {
            return Some(Misreading::Repeated(char::from(letter)));
        }
        (parsed.commands.len() > 1 && !self.takes_together(code, parsed))
            .then_some(Misreading::Several(parsed.commands.len()))
    }

    /// Whether several commands do what is read here: modes, then at most one move.
    fn takes_together(&self, code: &[u8], parsed: &ParsedLine) -> bool {
        // There `motion` refuses the line.
        if self.takes_one_command() {
            return true;
        }
        let mut others = parsed.commands.iter().filter(|command| !MODES.contains(command));
        let one = others.next();
        if others.next().is_some() || one.is_some_and(|command| !is_move(command)) {
            return false;
        }
        // RepRapFirmware goes from left to right, each command with the words behind it.
        let last = code.iter().rposition(|b| b"GMgm".contains(b)).unwrap_or_default();
        let is_last = one.is_none_or(|one| parsed.commands.last() == Some(one));
        let words = code[..last].iter().any(|b| b.is_ascii_alphabetic() && !b"GMgmNn".contains(b));
        self.firmware != Firmware::RepRapFirmware || (is_last && !words)
    }

    /// RepRapFirmware begins a command at each G and M outside quotes.
    fn of_text(&self, parsed: &ParsedLine) -> Option<Misreading> {
        let known = parsed.commands.first().is_some_and(|c| TEXT_TO_THE_END.contains(&c.number));
        if self.firmware != Firmware::RepRapFirmware || known {
            return None;
        }
        let mut quoted = false;
        let further = parsed.text.windows(2).skip(1).any(|pair| {
            quoted ^= pair[0] == b'"';
            !quoted && b"GMgm".contains(&pair[0]) && pair[1].is_ascii_digit()
        });
        further.then_some(Misreading::CommandInText)
    }
}

/// A line without what is in quotes.
fn unquoted(code: &[u8]) -> Cow<'_, [u8]> {
    if memchr::memchr(b'"', code).is_none() {
        return Cow::Borrowed(code);
    }
    let mut quoted = false;
    let outside = |b: &&u8| {
        let was = quoted;
        quoted ^= **b == b'"';
        !was && !quoted
    };
    Cow::Owned(code.iter().filter(outside).copied().collect())
}

fn is_move(command: &Command) -> bool {
    command.letter == b'G' && command.number <= 3 && command.minor == 0
}

/// The first letter that is there twice.
fn repeated(parsed: &ParsedLine) -> Option<u8> {
    let words = &parsed.words;
    let again = |(at, letter): &(usize, u8)| words[..*at].iter().any(|w| w.letter == *letter);
    words.iter().map(|w| w.letter).enumerate().find(again).map(|(_, letter)| letter)
}

/// LinuxCNC carries out `;py,..`, `(py,..)` and `(abort,..)`.
fn is_active(line: &[u8], code: &[u8]) -> bool {
    let begins = |text: &[u8], word: &[u8]| text.len() >= word.len() && text[..word.len()].eq_ignore_ascii_case(word);
    let mut opened = memchr::memchr_iter(b'(', code).map(|at| code[at + 1..].trim_ascii_start());
    begins(line, b";py,") || opened.any(|text| begins(text, b"py,") || begins(text, b"abort,"))
}

#[cfg(test)]
mod tests;
