//! One line to words.
//!
//! Source of the grammar's oddities: files of PrusaSlicer, Slic3r and Cura (`tests/it/sliced_files.rs`).

use super::number::number;
use super::plain;

/// A letter with the number that follows it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Word {
    /// The letter, upper case.
    pub letter: u8,
    /// The number; `None` for a bare letter as in `G28 X`.
    pub value: Option<f64>,
}

/// A command word: `G1`, `M204`, `T0`, `G92.1`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Command {
    /// `b'G'`, `b'M'` or `b'T'`.
    pub letter: u8,
    /// The whole number.
    pub number: u32,
    /// The digit after the point, 0 for none.
    pub minor: u8,
}

impl Command {
    /// `G<number>`.
    pub const fn g(number: u32) -> Self {
        Self { letter: b'G', number, minor: 0 }
    }

    /// `M<number>`.
    pub const fn m(number: u32) -> Self {
        Self { letter: b'M', number, minor: 0 }
    }
}

impl std::fmt::Display for Command {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}{}", self.letter as char, self.number)?;
        if self.minor > 0 { write!(f, ".{}", self.minor) } else { Ok(()) }
    }
}

/// What a line is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LineKind {
    /// Blank, or a comment alone.
    Empty,
    /// Words; the commands among them are in [`ParsedLine::commands`].
    Words,
    /// A command that carries free text (`M117 hello`, `M23 file`), named by [`ParsedLine::commands`]`[0]`.
    Text,
    /// A firmware macro by name (`START_PRINT EXTRUDER_TEMP=210`, `@pause`).
    Macro,
    /// `%`, as around a CNC program.
    Percent,
}

/// Why a line is not G-code.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ParseError {
    /// A byte that starts no word.
    #[error("unexpected {found:?} at column {column}")]
    Unexpected {
        /// What stands there, at most 12 characters.
        found: String,
        /// Counted from 1.
        column: usize,
    },
    /// `( ...` that does not end on its line.
    #[error("comment opened by '(' at column {column} is not closed")]
    OpenComment {
        /// Counted from 1.
        column: usize,
    },
    /// The checksum behind `*` is not that of the line: the file is damaged.
    #[error("checksum *{stated} does not match the line (computed {actual}); the file is damaged")]
    Checksum {
        /// As written.
        stated: u32,
        /// As computed.
        actual: u8,
    },
}

impl ParseError {
    /// Where in the line, from 1, if it is at one place.
    pub fn column(&self) -> Option<usize> {
        match self {
            Self::Unexpected { column, .. } | Self::OpenComment { column } => Some(*column),
            Self::Checksum { .. } => None,
        }
    }
}

/// A line taken apart; reused from line to line so that parsing allocates nothing.
#[derive(Clone, Debug)]
pub struct ParsedLine {
    /// What it is.
    pub kind: LineKind,
    /// All words but commands, in order.
    pub words: Vec<Word>,
    /// The G, M and T words, in order.
    pub commands: Vec<Command>,
    /// The span of the comment's text in the line, without `;`; empty for none.
    pub comment: std::ops::Range<usize>,
    /// The span of the code: without line number, checksum and `;` comment.
    pub code: std::ops::Range<usize>,
    /// The code's bytes where it is text or a macro, whose meaning is in its letters; else empty.
    pub text: Vec<u8>,
}

impl Default for ParsedLine {
    fn default() -> Self {
        let (words, commands, text) = (Vec::new(), Vec::new(), Vec::new());
        Self { kind: LineKind::Empty, words, commands, comment: 0..0, code: 0..0, text }
    }
}

/// Commands whose argument is text, not words.
const TEXT_COMMANDS: [u32; 12] = [16, 20, 23, 28, 30, 32, 33, 36, 117, 118, 486, 555];

impl ParsedLine {
    /// The value of the last word with `letter`; `None` where it is missing or bare.
    pub fn value(&self, letter: u8) -> Option<f64> {
        self.words.iter().rev().find(|w| w.letter == letter).and_then(|w| w.value)
    }

    /// Whether a word with `letter` is there, with or without a number.
    pub fn has(&self, letter: u8) -> bool {
        self.words.iter().any(|w| w.letter == letter)
    }

    /// Takes `line` apart in place.
    ///
    /// # Errors
    ///
    /// [`ParseError`] where the line is neither words, text, macro nor comment; the contents are then unspecified.
    pub fn read(&mut self, line: &[u8]) -> Result<(), ParseError> {
        self.words.clear();
        self.commands.clear();
        self.text.clear();
        if self.read_plain(line) { Ok(()) } else { self.read_whole(line) }
    }

    /// The same by the whole grammar.
    pub(super) fn read_whole(&mut self, line: &[u8]) -> Result<(), ParseError> {
        self.words.clear();
        self.commands.clear();
        self.text.clear();
        self.kind = LineKind::Empty;
        let text_end = memchr::memchr(b';', line).unwrap_or(line.len());
        self.comment = (text_end + 1).min(line.len())..line.len();
        let start = skip_blank(line, 0, text_end);
        let end = trim_end(line, start, text_end);
        self.code = start..end;
        if start == end {
            return Ok(());
        }
        if line[start] == b'%' && end == start + 1 {
            self.kind = LineKind::Percent;
            return Ok(());
        }
        self.drop_number_and_checksum(line)?;
        if is_macro(&line[self.code.clone()]) {
            self.kind = LineKind::Macro;
            self.text.extend_from_slice(&line[self.code.clone()]);
            return Ok(());
        }
        self.read_words(line)?;
        if self.kind == LineKind::Text {
            self.text.extend_from_slice(&line[self.code.clone()]);
        }
        Ok(())
    }

    /// Takes a plain move (see [`plain`](super::plain)), what nearly every line is, in one pass; `false` for all else, with
    /// words left over.
    fn read_plain(&mut self, line: &[u8]) -> bool {
        let words = &mut self.words;
        let word = |letter, value| {
            words.push(Word { letter, value: Some(value) });
            !matches!(letter, b'G' | b'M' | b'T')
        };
        let Some(end) = plain::walk(line, word) else { return false };
        let after = line.get(end..).unwrap_or_default();
        self.comment = match after {
            [] | [b'\r'] => line.len()..line.len(),
            [b';', ..] => end + 1..line.len(),
            [b' ', b';', ..] => end + 2..line.len(),
            _ => return false,
        };
        self.code = 0..end;
        self.kind = LineKind::Words;
        self.commands.push(Command::g(u32::from(line[1] - b'0')));
        true
    }

    fn drop_number_and_checksum(&mut self, line: &[u8]) -> Result<(), ParseError> {
        let code = &line[self.code.clone()];
        let is_n = code.first().is_some_and(|b| b.eq_ignore_ascii_case(&b'N'));
        if !is_n || !code.get(1).is_some_and(u8::is_ascii_digit) {
            return Ok(());
        }
        if let Some(star) = memchr::memchr(b'*', code) {
            let stated = std::str::from_utf8(&code[star + 1..]).ok().and_then(|t| t.trim().parse::<u32>().ok());
            let Some(stated) = stated else {
                return Err(unexpected(line, self.code.start + star));
            };
            let actual = code[..star].iter().fold(0u8, |sum, byte| sum ^ byte);
            if stated != u32::from(actual) {
                return Err(ParseError::Checksum { stated, actual });
            }
            self.code.end = trim_end(line, self.code.start, self.code.start + star);
        }
        let digits = code[1..].iter().take_while(|b| b.is_ascii_digit()).count();
        self.code.start = skip_blank(line, self.code.start + 1 + digits, self.code.end);
        Ok(())
    }

    fn read_words(&mut self, line: &[u8]) -> Result<(), ParseError> {
        let mut at = self.code.start;
        let end = self.code.end;
        while at < end {
            match line[at] {
                b' ' | b'\t' | b'\r' => at += 1,
                b'(' => match memchr::memchr(b')', &line[at..end]) {
                    Some(length) => at += length + 1,
                    None => return Err(ParseError::OpenComment { column: at + 1 }),
                },
                _ => {
                    let (letter, value, minor, length) = word(&line[at..end]).ok_or_else(|| unexpected(line, at))?;
                    at += length;
                    if self.take(letter, value, minor) {
                        self.kind = LineKind::Text;
                        return Ok(());
                    }
                }
            }
        }
        if !(self.words.is_empty() && self.commands.is_empty()) {
            self.kind = LineKind::Words;
        }
        Ok(())
    }

    /// Files one word away; `true` where the rest of the line is free text.
    fn take(&mut self, letter: u8, value: Option<f64>, minor: u8) -> bool {
        // Behind an M the T is a parameter: `M104 S210 T0`, `M204 P800 T1500`.
        let parameter = letter == b'T' && self.commands.iter().any(|c| c.letter == b'M');
        let command = matches!(letter, b'G' | b'M' | b'T') && !parameter;
        match value {
            Some(number) if command && number >= 0.0 => {
                self.commands.push(Command { letter, number: number as u32, minor });
                letter == b'M' && self.commands.len() == 1 && TEXT_COMMANDS.contains(&(number as u32))
            }
            _ => {
                self.words.push(Word { letter, value });
                false
            }
        }
    }
}

fn skip_blank(line: &[u8], mut at: usize, end: usize) -> usize {
    while at < end && matches!(line[at], b' ' | b'\t') {
        at += 1;
    }
    at
}

fn trim_end(line: &[u8], start: usize, mut end: usize) -> usize {
    while end > start && matches!(line[end - 1], b' ' | b'\t' | b'\r') {
        end -= 1;
    }
    end
}

/// A macro is a name of two or more letters that is not a word and its number: `GET_POSITION`, `_home`, `@pause`.
fn is_macro(code: &[u8]) -> bool {
    let letters = code.iter().take_while(|b| b.is_ascii_alphabetic() || **b == b'_').count();
    code.first() == Some(&b'@') || code.first() == Some(&b'_') || letters >= 2
}

fn unexpected(line: &[u8], at: usize) -> ParseError {
    let found = String::from_utf8_lossy(&line[at..line.len().min(at + 12)]).into_owned();
    ParseError::Unexpected { found, column: at + 1 }
}

/// The word at the start of `input`: its letter, its number, the first digit behind the point, and its length in bytes.
///
/// A text in quotes and the further members of a list (`M208 U-200:200`) are passed over. `None` where there is no word.
fn word(input: &[u8]) -> Option<(u8, Option<f64>, u8, usize)> {
    let letter = input.first().filter(|b| b.is_ascii_alphabetic())?.to_ascii_uppercase();
    let start = skip_blank(input, 1, input.len());
    if input.get(start) == Some(&b'"') {
        let end = memchr::memchr(b'"', &input[start + 1..])?;
        return Some((letter, None, 0, start + end + 2));
    }
    let Some((value, minor, length)) = number(&input[start..])? else { return Some((letter, None, 0, start)) };
    let mut at = start + length;
    while input.get(at) == Some(&b':') {
        at += 1 + number(&input[at + 1..])?.map_or(0, |(_, _, length)| length);
    }
    Some((letter, Some(value), minor, at))
}

#[cfg(test)]
mod tests {
    use super::{Command, LineKind, ParseError, ParsedLine};

    #[track_caller]
    fn read(line: &[u8]) -> ParsedLine {
        let mut parsed = ParsedLine::default();
        parsed.read(line).unwrap();
        parsed
    }

    fn words(line: &[u8]) -> Vec<(char, Option<f64>)> {
        read(line).words.iter().map(|w| (w.letter as char, w.value)).collect()
    }

    #[test]
    fn reads_compact_lower_case_words() {
        let line = read(b"g1x-3.9y2f7800");
        assert_eq!(line.commands, vec![Command::g(1)]);
        assert_eq!(words(b"g1x-3.9y2f7800"), vec![('X', Some(-3.9)), ('Y', Some(2.0)), ('F', Some(7800.0))]);
    }

    #[test]
    fn an_exponent_is_a_word() {
        assert_eq!(words(b"G1 X1E5"), vec![('X', Some(1.0)), ('E', Some(5.0))]);
    }

    #[test]
    fn takes_odd_numbers_and_bare_letters() {
        assert_eq!(
            words(b"G1 X.25 Y-.5 Z+1 E.26814"),
            vec![('X', Some(0.25)), ('Y', Some(-0.5)), ('Z', Some(1.0)), ('E', Some(0.26814))]
        );
        assert_eq!(words(b"G28 X Y"), vec![('X', None), ('Y', None)]);
        assert_eq!(words(b"G1 X1.23456789012345678"), vec![('X', Some(1.234_567_890_123_456_8))]);
    }

    #[test]
    fn knows_comments_macros_text_and_percent() {
        assert_eq!(read(b"; G1 X5").kind, LineKind::Empty);
        let travel = read(b"M204 P800 T1500");
        assert_eq!((travel.commands.len(), travel.value(b'T')), (1, Some(1500.0)));
        assert_eq!(read(b"T1").commands.len(), 1);
        assert_eq!(read(b"G1 (X9) X5 ; hello").words.len(), 1);
        assert_eq!(read(b"START_PRINT EXTRUDER_TEMP=210").kind, LineKind::Macro);
        assert_eq!(read(b"GET_POSITION").kind, LineKind::Macro);
        assert_eq!(read(b"@pause").kind, LineKind::Macro);
        assert_eq!(read(b"%").kind, LineKind::Percent);
        let text = read(b"M117 X marks the spot");
        assert_eq!((text.kind, text.words.len()), (LineKind::Text, 0));
        assert_eq!(words(b"M98 P\"home all.g\" S1"), vec![('P', None), ('S', Some(1.0))]);
        assert_eq!(words(b"M208 U-200:200 X1"), vec![('U', Some(-200.0)), ('X', Some(1.0))]);
        assert_eq!(read(b"G92.1").commands, vec![Command { letter: b'G', number: 92, minor: 1 }]);
        assert_eq!(read(b"G01 X1").commands, vec![Command::g(1)]);
    }

    #[test]
    fn drops_line_numbers_and_checks_their_sum() {
        // The RepRap wiki's own first numbered line.
        assert_eq!(read(b"N3 T0*57").commands, vec![Command { letter: b'T', number: 0, minor: 0 }]);
        let mut line = ParsedLine::default();
        assert_eq!(line.read(b"N3 T0*58"), Err(ParseError::Checksum { stated: 58, actual: 57 }));
        assert_eq!(words(b"N12 G1 X5"), vec![('X', Some(5.0))]);
    }

    #[test]
    fn refuses_what_is_no_gcode() {
        let mut line = ParsedLine::default();
        for bad in [&b"G1 X--5"[..], b"G1 X5 !", b"G1 (open", b"\xff\xfe", b"G1 X-", b"M98 P\"x", b"M208 X1:-"] {
            assert!(line.read(bad).is_err(), "{:?}", String::from_utf8_lossy(bad));
        }
    }
}
