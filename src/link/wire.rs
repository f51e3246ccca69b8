//! Bytes of the wire: framing, line numbers, checksums, compact blocks, and lines out of whatever arrives.
//!
//! The checksum is the XOR of every byte before `*`, in decimal (RepRap wiki, *G-code*; Marlin `queue.cpp`).
//!
//! This file must not know what a reply means: that is `reply`'s.

use memchr::{memchr, memchr2};

/// Which firmware's manners the wire has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Protocol {
    /// Numbers, checksums, `ok`, `Resend`.
    Marlin,
    /// `RepRapFirmware` over USB: numbers and checksums are taken, a bad line is dropped without a word.
    RepRapFirmware,
    /// Klipper's pty: one `ok` a line, numbers ignored.
    Klipper,
    /// Grbl, grblHAL, FluidNC: character counting, real-time bytes.
    Grbl,
}

impl Protocol {
    /// The protocol of a profile's `[link] protocol`; `None` for `"none"` and unknown words.
    pub fn named(name: &str) -> Option<Self> {
        match name {
            "marlin" => Some(Self::Marlin),
            "rrf" => Some(Self::RepRapFirmware),
            "klipper" => Some(Self::Klipper),
            "grbl" => Some(Self::Grbl),
            _ => None,
        }
    }

    /// The word of a profile.
    pub fn name(self) -> &'static str {
        match self {
            Self::Marlin => "marlin",
            Self::RepRapFirmware => "rrf",
            Self::Klipper => "klipper",
            Self::Grbl => "grbl",
        }
    }

    /// Whether lines carry a number and a checksum.
    pub fn numbered(self) -> bool {
        matches!(self, Self::Marlin | Self::RepRapFirmware)
    }
}

/// XOR of all bytes.
pub fn checksum(bytes: &[u8]) -> u8 {
    bytes.iter().fold(0, |sum, byte| sum ^ byte)
}

/// Appends `N<number><block>*<checksum>` and a newline.
///
/// `block` is one block without comment or newline; anything else would be counted as a second line by the firmware.
///
/// ```
/// let mut out = Vec::new();
/// trunnion::link::push_numbered(&mut out, 3, b" T0");
/// assert_eq!(out, b"N3 T0*57\n"); // the RepRap wiki's own first numbered line
/// ```
pub fn push_numbered(out: &mut Vec<u8>, number: i64, block: &[u8]) {
    let start = out.len();
    out.push(b'N');
    push_integer(out, number);
    out.extend_from_slice(block);
    let sum = checksum(&out[start..]);
    out.push(b'*');
    push_integer(out, i64::from(sum));
    out.push(b'\n');
}

/// The most bytes that [`push_spaced`] will append.
pub(crate) fn numbered_len(number: i64, block: &[u8]) -> usize {
    let digits = number.unsigned_abs().checked_ilog10().unwrap_or(0) as usize + 1;
    // The checksum has one to three digits; the longest is taken.
    1 + usize::from(number < 0) + digits + block.len() + 5
}

/// What a line's tail adds to the checksum of a line that it melts into: its own sum, `*` and the sum's digits.
///
/// Never 0, so that two lines melted into one are refused. Three are not where the first two have the same seam: XOR cancels.
/// [`Seams`] keeps that from happening.
fn seam(sum: u8) -> u8 {
    let digits = [sum / 100, sum / 10 % 10, sum % 10].map(|d| b'0' + d);
    let used = if sum >= 100 {
        0
    } else if sum >= 10 {
        1
    } else {
        2
    };
    digits[used..].iter().fold(sum ^ b'*', |all, digit| all ^ digit)
}

/// Bytes that say nothing, put in so that melted lines never look like a good one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Filling {
    /// A leading zero of the number.
    zero: bool,
    /// A blank behind it.
    blank: bool,
    /// A zero behind the block's first fraction.
    tail: bool,
}

/// The end of the block's first fraction, where one more zero says nothing; `None` without a fraction, and in texts.
fn fraction_end(block: &[u8]) -> Option<usize> {
    let point = memchr(b'.', block).filter(|_| matches!(block.get(..2), Some(b"G0" | b"G1" | b"G2" | b"G3")))?;
    let digits = block[point + 1..].iter().take_while(|b| b.is_ascii_digit()).count();
    (digits > 0).then_some(point + 1 + digits)
}

/// The seams of the last lines: of a run of these that could melt together, the sums must not cancel, and neither may the
/// beginning of one that is cut anywhere and melts into the next.
///
/// Two whole lines never do. Against the other cases the best of four fillings is taken; an XOR of eight bits cannot be made
/// proof against everything (measured in the tests: a fiftieth of the cut lines and an eighth of the runs are left that plain
/// lines would let pass).
#[derive(Clone, Debug, Default)]
pub(crate) struct Seams {
    /// Sums of all seams up to each of the last lines, the newest first.
    sums: [u8; Self::RUN],
    sum: u8,
}

impl Seams {
    const RUN: usize = 5;

    /// The filling with which line `number` ends no run that cancels; the plain line where that is so already.
    pub(crate) fn fill(&mut self, number: i64, block: &[u8]) -> Filling {
        let mut digits = [0_u8; 21];
        let head = checksum(integer_digits(&mut digits, number)) ^ b'N';
        let block_sum = checksum(block);
        let tail = fraction_end(block);
        let head_of = |f: &Filling| head ^ if f.zero { b'0' } else { 0 } ^ if f.blank { b' ' } else { 0 };
        let whole = |f: &Filling| head_of(f) ^ block_sum ^ if f.tail { b'0' } else { 0 };
        let sum_with = |f: &Filling| self.sum ^ seam(whole(f));
        let nearest = |f: &Filling| self.sums.iter().position(|s| *s == sum_with(f)).unwrap_or(Self::RUN);
        let beginnings = [Beginnings::of(block, None), Beginnings::of(block, tail)];
        let safe = |f: &Filling| !beginnings[usize::from(f.tail)].cancel(head_of(f), whole(f));
        let rank = |f: &Filling| (safe(f), nearest(f));
        let mut filling = Filling::default();
        for bits in 1_u8..if tail.is_some() { 8 } else { 4 } {
            if rank(&filling) == (true, Self::RUN) {
                break;
            }
            let other = Filling { zero: bits & 1 > 0, blank: bits & 2 > 0, tail: bits & 4 > 0 };
            if rank(&other) > rank(&filling) {
                filling = other;
            }
        }
        self.sum = sum_with(&filling);
        self.sums.copy_within(0..Self::RUN - 1, 1);
        self.sums[0] = self.sum;
        filling
    }
}

/// The sums of all beginnings of a block. A line that is cut where its sum is 0 melts into the next one unseen.
struct Beginnings([u64; 4]);

impl Beginnings {
    /// With one more zero at `zero_at`.
    fn of(block: &[u8], zero_at: Option<usize>) -> Self {
        let mut seen = Self([0; 4]);
        let mut sum = 0_u8;
        for (index, byte) in block.iter().enumerate() {
            if zero_at == Some(index) {
                sum ^= b'0';
                seen.add(sum);
            }
            sum ^= byte;
            seen.add(sum);
        }
        if zero_at == Some(block.len()) {
            seen.add(sum ^ b'0');
        }
        seen
    }

    fn add(&mut self, sum: u8) {
        self.0[usize::from(sum >> 6)] |= 1 << (sum & 63);
    }

    fn contain(&self, sum: u8) -> bool {
        self.0[usize::from(sum >> 6)] >> (sum & 63) & 1 == 1
    }

    /// Whether a beginning of the line sums to 0, where what stands before the block sums to `head`, all of it to `whole`.
    fn cancel(&self, head: u8, whole: u8) -> bool {
        let digits = [whole / 100, whole / 10 % 10].map(|d| b'0' + d);
        let first = if whole >= 100 { digits[0] } else { digits[1] };
        let behind = [whole ^ b'*', whole ^ b'*' ^ first, whole ^ b'*' ^ digits[0] ^ digits[1]];
        self.contain(head) || behind[..if whole >= 100 { 3 } else { 2 }].contains(&0)
    }
}

/// As [`push_numbered`], with a filling.
pub(crate) fn push_spaced(out: &mut Vec<u8>, number: i64, filling: Filling, block: &[u8]) {
    let start = out.len();
    out.push(b'N');
    if filling.zero {
        out.push(b'0');
    }
    push_integer(out, number);
    if filling.blank {
        out.push(b' ');
    }
    match fraction_end(block).filter(|_| filling.tail) {
        Some(end) => {
            out.extend_from_slice(&block[..end]);
            out.push(b'0');
            out.extend_from_slice(&block[end..]);
        }
        None => out.extend_from_slice(block),
    }
    let sum = checksum(&out[start..]);
    out.push(b'*');
    push_integer(out, i64::from(sum));
    out.push(b'\n');
}

fn push_integer(out: &mut Vec<u8>, value: i64) {
    out.extend_from_slice(integer_digits(&mut [0; 21], value));
}

fn integer_digits(digits: &mut [u8; 21], value: i64) -> &[u8] {
    let mut at = digits.len();
    let mut rest = value.unsigned_abs();
    loop {
        at -= 1;
        digits[at] = b'0' + (rest % 10) as u8;
        rest /= 10;
        if rest == 0 {
            break;
        }
    }
    if value < 0 {
        at -= 1;
        digits[at] = b'-';
    }
    &digits[at..]
}

/// Appends a block with every byte left out that firmwares do not need: blanks, `( )` comments, zeros at a number's ends.
///
/// A blank stays before `E` (some parsers would read `1E5` as an exponent) and after a bare letter (`G28X Y`).
/// `code` is a block of words, as [`crate::gcode::LineKind::Words`] has them.
pub fn push_compact(out: &mut Vec<u8>, code: &[u8]) {
    let mut at = 0;
    let start = out.len();
    while at < code.len() {
        match code[at] {
            b'(' => at = memchr(b')', &code[at..]).map_or(code.len(), |end| at + end + 1),
            letter if letter.is_ascii_alphabetic() => {
                let letter = letter.to_ascii_uppercase();
                let bare = out.len() > start && !out.last().is_some_and(|b| b.is_ascii_digit() || *b == b'.');
                if out.len() > start && (bare || letter == b'E') {
                    out.push(b' ');
                }
                out.push(letter);
                at += 1;
                while at < code.len() && matches!(code[at], b' ' | b'\t') {
                    at += 1;
                }
                let end = code[at..].iter().position(|b| !matches!(b, b'0'..=b'9' | b'.' | b'-' | b'+'));
                let end = end.map_or(code.len(), |n| at + n);
                push_number(out, &code[at..end], matches!(letter, b'G' | b'M' | b'T'));
                at = end;
            }
            _ => at += 1,
        }
    }
}

/// A number without needless characters; a command's own (`G92.1`, `G0`) keeps its digits.
fn push_number(out: &mut Vec<u8>, text: &[u8], command: bool) {
    let text = text.strip_prefix(b"+").unwrap_or(text);
    let (sign, digits) = match text.strip_prefix(b"-") {
        Some(rest) => (&b"-"[..], rest),
        None => (&b""[..], text),
    };
    if digits.is_empty() || command {
        out.extend_from_slice(text);
        return;
    }
    let (whole, fraction) = match memchr(b'.', digits) {
        Some(point) => (&digits[..point], &digits[point + 1..]),
        None => (digits, &b""[..]),
    };
    let zeros = whole.iter().take_while(|b| **b == b'0').count();
    let whole = &whole[zeros..];
    let fraction = &fraction[..fraction.iter().rposition(|b| *b != b'0').map_or(0, |last| last + 1)];
    if whole.is_empty() && fraction.is_empty() {
        out.push(b'0');
        return;
    }
    out.extend_from_slice(sign);
    out.extend_from_slice(whole);
    if !fraction.is_empty() {
        out.push(b'.');
        out.extend_from_slice(fraction);
    }
}

/// Longer than any reply: what grows beyond it is noise and is dropped.
const LONGEST_REPLY: usize = 1024;

/// Puts lines together from reads of any size; bytes are never decoded here.
#[derive(Clone, Debug, Default)]
pub struct LineAssembler {
    held: Vec<u8>,
    read: usize,
}

impl LineAssembler {
    /// Takes what arrived.
    pub fn push(&mut self, bytes: &[u8]) {
        if self.read > 0 {
            self.held.drain(..self.read);
            self.read = 0;
        }
        self.held.extend_from_slice(bytes);
    }

    /// The next whole line without its end; empty lines are left out.
    pub fn next_line(&mut self) -> Option<&[u8]> {
        loop {
            let rest = &self.held[self.read..];
            let Some(end) = memchr2(b'\n', b'\r', rest) else {
                if rest.len() > LONGEST_REPLY {
                    self.held.clear();
                    self.read = 0;
                }
                return None;
            };
            let start = self.read;
            self.read += end + 1;
            if end > 0 {
                return Some(&self.held[start..start + end]);
            }
        }
    }

    /// Forgets a half line: after a break of the link it belongs to nothing.
    pub fn clear(&mut self) {
        self.held.clear();
        self.read = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn compacted(from: &str, to: &str) {
        let mut out = Vec::new();
        push_compact(&mut out, from.as_bytes());
        assert_eq!(String::from_utf8(out).unwrap(), to);
    }

    #[test]
    fn a_compact_block_says_the_same_with_fewer_bytes() {
        compacted("G1 X12.400 Y-0.50 Z0.20 E0.04120 F1800", "G1X12.4Y-.5Z.2 E.0412F1800");
        compacted("g28 x y", "G28X Y");
        compacted("G1 X-0.000 Y+10 Z100", "G1X0Y10Z100");
        compacted("M204 P800 T1500", "M204P800T1500");
        compacted("G1 (there) X5", "G1X5");
        compacted("G92.10 E0", "G92.10 E0");
    }

    #[test]
    fn a_compact_block_parses_to_the_same_words() {
        use crate::gcode::ParsedLine;
        for text in
            ["G1 X12.400 Y-0.50 E0.0412", "G0 A-0 C+090.50 F1800", "G28 X Y", "M109 S210 T0", "G2 X.5 I-.250 J0"]
        {
            let mut out = Vec::new();
            push_compact(&mut out, text.as_bytes());
            let (mut one, mut two) = (ParsedLine::default(), ParsedLine::default());
            one.read(text.as_bytes()).unwrap();
            two.read(&out).unwrap();
            assert_eq!((&one.words, &one.commands), (&two.words, &two.commands), "{text}");
        }
    }

    #[test]
    fn numbers_of_all_sizes_frame_within_their_length() {
        for number in [0, 7, 1_000_000, i64::from(i32::MAX), -5] {
            let mut out = Vec::new();
            push_numbered(&mut out, number, b"G1X1");
            let text = String::from_utf8(out.clone()).unwrap();
            let (body, sum) = text.trim_end().split_once('*').unwrap();
            assert_eq!(sum.parse::<u8>().unwrap(), checksum(body.as_bytes()));
            assert!(body.starts_with(&format!("N{number}G1")) && out.len() <= numbered_len(number, b"G1X1"));
        }
    }

    /// Two lines of which the newline between was lost never look like one good line.
    #[test]
    fn joined_lines_never_pass_the_checksum() {
        for sum in 0..=255_u8 {
            let mut between = format!("*{sum}").into_bytes();
            between.insert(0, sum);
            assert_ne!(checksum(&between), 0, "a body that sums to {sum}");
            assert_eq!(checksum(&between), seam(sum));
        }
    }

    /// Nor do three or more, which plain lines sometimes do; as Marlin checks it: the sum in front of the last `*`.
    #[test]
    fn lines_melted_or_cut_hardly_ever_pass_the_checksum() {
        let passes = |lines: &[Vec<u8>]| {
            let melted: Vec<u8> = lines.iter().flat_map(|l| l[..l.len() - 1].to_vec()).collect();
            let star = melted.iter().rposition(|b| *b == b'*').unwrap();
            std::str::from_utf8(&melted[star + 1..]).unwrap().parse::<u8>().unwrap() == checksum(&melted[..star])
        };
        let (mut plain, mut filled, mut seams) = (Vec::new(), Vec::new(), Seams::default());
        for number in 1..20_000_i64 {
            let block = format!("G1X{}Y-98.{} E.0{}", number % 97, number % 1000, 3000 + number % 777);
            let (mut one, mut two) = (Vec::new(), Vec::new());
            push_numbered(&mut one, number, block.as_bytes());
            let filling = seams.fill(number, block.as_bytes());
            push_spaced(&mut two, number, filling, block.as_bytes());
            assert!(two.len() <= numbered_len(number, block.as_bytes()) + 3);
            plain.push(one);
            filled.push(two);
        }
        let count = |lines: &[Vec<u8>], run: usize| lines.windows(run).filter(|w| passes(w)).count();
        assert!(count(&plain, 3) > 100, "the danger is real: {}", count(&plain, 3));
        assert_eq!(count(&filled, 2), 0);
        let runs = |lines: &[Vec<u8>]| (3..=6).map(|run| count(lines, run)).sum::<usize>();
        assert!(runs(&filled) * 8 < runs(&plain), "{} {}", runs(&filled), runs(&plain));
        // A line cut anywhere, its end lost with the newline, melts into the next.
        let cut = |lines: &[Vec<u8>]| {
            let pairs = lines.windows(2);
            pairs
                .map(|w| (1..w[0].len()).filter(|&n| passes(&[[&w[0][..n], b"\n"].concat(), w[1].clone()])).count())
                .sum::<usize>()
        };
        assert!(cut(&plain) > 1000 && cut(&filled) * 50 < cut(&plain), "{} {}", cut(&plain), cut(&filled));
        let bytes = |lines: &[Vec<u8>]| lines.iter().map(Vec::len).sum::<usize>() as f64;
        assert!(bytes(&filled) < bytes(&plain) * 1.03, "{}", bytes(&filled) / bytes(&plain));
    }

    #[test]
    fn lines_come_whole_from_split_reads_and_noise() {
        let mut lines = LineAssembler::default();
        lines.push(b"o");
        assert_eq!(lines.next_line(), None);
        lines.push(b"k\r\n\n\xff\0ok\nok");
        assert_eq!(lines.next_line(), Some(&b"ok"[..]));
        assert_eq!(lines.next_line(), Some(&b"\xff\0ok"[..]));
        assert_eq!(lines.next_line(), None);
        lines.push(&[b'x'; 5000]);
        assert_eq!(lines.next_line(), None);
        lines.push(b"ok\n");
        assert_eq!(lines.next_line(), Some(&b"ok"[..]));
    }
}
