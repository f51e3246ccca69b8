//! The lines that nearly all of a file consists of: `G1 X12.5 Y-3 E.0421 F1200`, read in one pass over their bytes.
//!
//! ```text
//! plain = ("G0" | "G1") (" " LETTER ["-"] number)+        one blank, upper case, no sign but "-"
//! ```
//!
//! What is spelt in any other way is left to the whole grammar of [`ParsedLine::read`](super::ParsedLine::read), which finds the
//! same words in these.

use super::number::{POWERS_OF_TEN, number};

/// A move of X, Y, Z and the extruder E, each at most once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlainMove {
    /// G0.
    pub rapid: bool,
    /// Which of X, Y, Z, E, F are written, as bits 0 to 4; never none.
    pub written: u8,
    /// The numbers of X, Y, Z, E, F; 0 where not written.
    pub values: [f64; 5],
    /// Bytes of the line, its end (LF, CR LF) included.
    pub length: usize,
}

impl PlainMove {
    /// The bit of E in [`PlainMove::written`].
    pub const E: u8 = 1 << 3;
    /// The bit of F in [`PlainMove::written`].
    pub const F: u8 = 1 << 4;

    /// The move in the first line of `rest`; `None` where it is spelt in any other way or has anything else in it.
    #[inline]
    pub fn read(rest: &[u8]) -> Option<Self> {
        let mut plain = Self { rapid: false, written: 0, values: [0.0; 5], length: 0 };
        let end = walk(rest, |letter, value| {
            let place = match letter {
                b'X' => 0,
                b'Y' => 1,
                b'Z' => 2,
                b'E' => 3,
                b'F' => 4,
                _ => return false,
            };
            let new = plain.written & 1 << place == 0;
            plain.written |= 1 << place;
            plain.values[place] = value;
            new
        })?;
        plain.rapid = rest[1] == b'0';
        plain.length = match rest.get(end..)? {
            [] => end,
            [b'\n', ..] => end + 1,
            [b'\r', b'\n', ..] => end + 2,
            _ => return None,
        };
        Some(plain)
    }
}

/// Hands the words behind G0 or G1 to `word` while it answers `true`; comes back with where the last of them ends.
///
/// `None` where there is none, where `word` answers `false`, and for words that are not plain.
#[inline(always)]
pub(super) fn walk(line: &[u8], mut word: impl FnMut(u8, f64) -> bool) -> Option<usize> {
    let [b'G', b'0' | b'1', b' ', ..] = line else { return None };
    let mut at = 2;
    while let [b' ', letter @ b'A'..=b'Z', ..] = line[at..] {
        let (value, length) = decimal(line, at + 2)?;
        at += 2 + length;
        if !word(letter, value) {
            return None;
        }
    }
    // A list (`U-200:200`) and whatever else goes on is not plain, nor is a second blank.
    let ends = matches!(line[at..], [] | [b'\n' | b'\r' | b';', ..] | [b' ', b';', ..]);
    (ends && at > 2).then_some(at)
}

/// The number at `at` and its length: eight bytes at once where it is short enough, which most are.
#[inline(always)]
fn decimal(line: &[u8], at: usize) -> Option<(f64, usize)> {
    let negative = line.get(at) == Some(&b'-');
    let from = at + usize::from(negative);
    let read = eight(line, from).and_then(short);
    let (magnitude, length) = match read {
        Some(found) => found,
        None => long(line, from)?,
    };
    Some((if negative { -magnitude } else { magnitude }, from - at + length))
}

/// Any number without a sign; `None` where there is none.
#[inline(never)]
fn long(line: &[u8], from: usize) -> Option<(f64, usize)> {
    let rest = line.get(from..)?;
    if matches!(rest.first(), Some(b'-' | b'+')) {
        return None;
    }
    let (value, _, length) = number(rest)??;
    Some((value, length))
}

/// The eight bytes from `at` on, the first the lowest; zeros behind the end of the line. `None` for lines of less than eight.
#[inline(always)]
fn eight(line: &[u8], at: usize) -> Option<u64> {
    if let Some(bytes) = line.get(at..at + 8) {
        return Some(u64::from_le_bytes(bytes.try_into().ok()?));
    }
    let bytes = line.last_chunk::<8>()?;
    let missing = at + 8 - line.len();
    u64::from_le_bytes(*bytes).checked_shr(8 * missing as u32)
}

/// The number at the start of eight bytes, and its length; `None` where none begins, or where it goes on behind them.
///
/// Source: D. Lemire, "Number parsing at a gigabyte per second" (2021), section 6, with the point taken out first.
#[inline(always)]
fn short(bytes: u64) -> Option<(f64, usize)> {
    const ONES: u64 = 0x0101_0101_0101_0101;
    // Digits become 0 to 9, everything else 10 or more.
    let digits = bytes ^ (0x30 * ONES);
    let others = (((digits & (0x7F * ONES)) + 0x76 * ONES) | digits) & (0x80 * ONES);
    if others == 0 {
        return None;
    }
    let whole = others.trailing_zeros() & !7;
    let pointed = (bytes >> whole) as u8 == b'.';
    let (packed, count, end) = if pointed {
        let behind = others & (others - 1);
        if behind == 0 {
            return None;
        }
        let end = behind.trailing_zeros() & !7;
        let below = (1 << whole) - 1;
        ((digits & below) | ((digits >> 8) & !below), end - 8, end)
    } else {
        (digits, whole, whole)
    };
    if count == 0 {
        return None;
    }
    // The last digit comes to lie highest, zeros in front of the first, and what is behind the number falls off.
    let mut packed = packed << (64 - count);
    packed = packed.wrapping_mul(10).wrapping_add(packed >> 8) & 0x00FF_00FF_00FF_00FF;
    packed = packed.wrapping_mul(100).wrapping_add(packed >> 16) & 0x0000_FFFF_0000_FFFF;
    packed = packed.wrapping_mul(10_000).wrapping_add(packed >> 32) & 0xFFFF_FFFF;
    let mantissa = whole_number(packed as u32);
    let places = (count - whole) / 8;
    // Both are exact, so that the quotient is the nearest number to what is written, as `str::parse` has it.
    Some((mantissa / POWERS_OF_TEN[places as usize & 15], end as usize / 8))
}

/// `number` as [`f64::from`] gives it, but without the processor's conversion: on x86 that waits for the number before, and all
/// divisions of a line would wait for each other.
#[inline(always)]
fn whole_number(number: u32) -> f64 {
    const TWO_TO_52: f64 = 4_503_599_627_370_496.0;
    f64::from_bits(TWO_TO_52.to_bits() | u64::from(number)) - TWO_TO_52
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gcode::{LineKind, ParsedLine};

    /// xorshift64*: the same numbers on every run.
    struct Random(u64);

    impl Random {
        fn next(&mut self, below: u64) -> u64 {
            self.0 ^= self.0 >> 12;
            self.0 ^= self.0 << 25;
            self.0 ^= self.0 >> 27;
            self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) % below
        }

        fn digits(&mut self, most: u64) -> String {
            (0..self.next(most + 1)).map(|_| char::from(b'0' + self.next(10) as u8)).collect()
        }
    }

    #[test]
    fn a_number_is_exactly_what_the_standard_library_reads() {
        let mut random = Random(7);
        let mut read = 0;
        for round in 0..300_000 {
            let (most, sign) = (if round % 3 == 0 { 12 } else { 5 }, ["", "-"][random.next(2) as usize]);
            let point = ["", "."][random.next(2) as usize];
            let number = format!("{sign}{}{point}{}", random.digits(most), random.digits(most));
            let line = format!("G1 X{number}{}", ["", "\n", " E1\nG1 X7", "\r\n", ";1"][random.next(5) as usize]);
            let wanted = number.parse::<f64>().ok().map(f64::to_bits);
            let mut found = None;
            walk(line.as_bytes(), |letter, value| {
                found = found.or((letter == b'X').then_some(value.to_bits()));
                true
            });
            assert_eq!(found, wanted, "{line:?}");
            read += u32::from(found.is_some());
        }
        assert!(read > 200_000, "{read}");
    }

    /// A line of pieces that plain moves, other moves and damaged ones are made of.
    fn line(random: &mut Random) -> Vec<u8> {
        const PIECES: [&str; 24] = [
            " ", " ", " ", " X", " Y", " Z", " E", " F", " I", "-", "+", ".", ":", ";", "  ", "\t", "\r", "x", "T1",
            "M3", "(a)", "\n", "\"", "*5",
        ];
        let mut text =
            ["G1", "G0", "G1 X1", "G10", "g1", "G1.5", "N5 G1", "G1 Y2.5"][random.next(8) as usize].to_owned();
        for _ in 0..random.next(5) {
            text += [" X", " Y", " Z", " E", " F", " A"][random.next(6) as usize];
            text += ["", "", "", "-"][random.next(4) as usize];
            text += &random.digits(4);
            text += ["", "."][random.next(2) as usize];
            text += &random.digits(6);
            if random.next(8) == 0 {
                text += PIECES[random.next(24) as usize];
            }
        }
        text.into_bytes()
    }

    #[test]
    fn a_plain_move_is_what_the_whole_grammar_reads() {
        let mut random = Random(11);
        let (mut whole, mut fast) = (ParsedLine::default(), ParsedLine::default());
        let mut plain = 0;
        for _ in 0..200_000 {
            let text = line(&mut random);
            let shown = String::from_utf8_lossy(&text).into_owned();
            let (wanted, found) = (whole.read_whole(&text), fast.read(&text));
            assert_eq!(found, wanted, "{shown:?}");
            if wanted.is_ok() {
                assert_eq!(format!("{fast:?}"), format!("{whole:?}"), "{shown:?}");
            }
            let Some(one) = PlainMove::read(&text) else { continue };
            plain += 1;
            let first = text.split(|b| *b == b'\n').next().unwrap();
            whole.read_whole(first).unwrap();
            assert_eq!((whole.kind, whole.commands[0].number), (LineKind::Words, u32::from(!one.rapid)), "{shown:?}");
            assert!(one.length == first.len() + usize::from(first.len() < text.len()), "{shown:?}");
            assert_eq!(whole.words.len(), one.written.count_ones() as usize, "{shown:?}");
            for (place, letter) in b"XYZEF".iter().enumerate() {
                let written = (one.written >> place & 1 != 0).then_some(one.values[place]);
                assert_eq!(whole.value(*letter), written, "{shown:?}");
            }
        }
        assert!(plain > 20_000, "{plain}");
    }

    #[test]
    fn what_is_not_plain_is_left_to_the_grammar() {
        for text in [
            "G1", "G1 ", "G2 X1", "G1 X", "G1 X1 X2", "G1 X1 ;", "G1  X1", "G1 X+1", "G1 X1:2", "G1 X1 A2", "G1 X1 ",
            "G10 X1",
        ] {
            assert_eq!(PlainMove::read(text.as_bytes()), None, "{text:?}");
        }
        let one = PlainMove::read(b"G0 X-1.5 Z.25\r\nG1").unwrap();
        assert_eq!((one.rapid, one.written, one.length), (true, 0b101, 15));
        assert_eq!(one.values, [-1.5, 0.0, 0.25, 0.0, 0.0]);
    }
}
