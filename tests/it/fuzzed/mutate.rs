//! Bytes changed at random, the same on every machine: what a broken disk, a slip of the hand or somebody's own program makes of a file.

use crate::support::Numbers;

/// The words of `words.dict`, as bytes.
pub(super) fn words() -> Vec<Vec<u8>> {
    include_str!("words.dict").lines().filter(|line| !line.starts_with('#')).map(word).collect()
}

/// A line of a dictionary in libFuzzer's form: quoted, with `\\`, `\"` and `\xNN`.
fn word(line: &str) -> Vec<u8> {
    let quoted = line.strip_prefix('"').and_then(|line| line.strip_suffix('"')).expect("a word in quotes");
    let (mut bytes, mut rest) = (Vec::new(), quoted.as_bytes());
    while let Some((&first, behind)) = rest.split_first() {
        let (byte, taken) = match (first, behind) {
            (b'\\', [b'x', high, low, ..]) => {
                let hex = [*high, *low].map(|digit| char::from(digit).to_digit(16).expect("a hexadecimal digit") as u8);
                (hex[0] * 16 + hex[1], 4)
            }
            (b'\\', [escaped, ..]) => (*escaped, 2),
            _ => (first, 1),
        };
        bytes.push(byte);
        rest = &rest[taken..];
    }
    bytes
}

/// What numbers become.
const NUMBERS: [&str; 22] = [
    "0",
    "-0",
    "-1",
    "0.0000001",
    "1e308",
    "-1e308",
    "1e-320",
    "NaN",
    "inf",
    "-inf",
    "1E9",
    "255",
    "256",
    "65536",
    "2147483647",
    "-2147483649",
    "4294967296",
    "9007199254740993",
    "9223372036854775807",
    "-9223372036854775808",
    "18446744073709551616",
    "999999999999999999999999999999999999999999999999999999",
];

/// Where a number may stand in text.
fn is_number(byte: u8) -> bool {
    byte.is_ascii_digit() || matches!(byte, b'.' | b'-')
}

/// Seeds, changed.
pub(super) struct Mutator<'a> {
    pub(super) seeds: &'a [Vec<u8>],
    pub(super) words: &'a [Vec<u8>],
    /// What is made is not longer, bytes.
    pub(super) longest: usize,
}

impl Mutator<'_> {
    /// The bytes of `seed`.
    pub(super) fn bytes(&self, seed: u64) -> Vec<u8> {
        let mut numbers = Numbers::seeded(seed);
        let mut bytes = self.seeds[below(&mut numbers, self.seeds.len())].clone();
        // Mostly few changes: what is broken all over is refused at its first line.
        let changes = 1 + (numbers.between(0.0, 1.0).powi(3) * 12.0) as usize;
        for _ in 0..changes {
            self.change(&mut bytes, &mut numbers);
        }
        bytes.truncate(self.longest);
        bytes
    }

    fn change(&self, bytes: &mut Vec<u8>, numbers: &mut Numbers) {
        let at = below(numbers, bytes.len() + 1);
        let length = (numbers.between(0.0, 1.0).powi(3) * 200.0) as usize + 1;
        let end = (at + length).min(bytes.len());
        match below(numbers, 12) {
            0 if at < bytes.len() => bytes[at] ^= 1 << below(numbers, 8),
            1 if at < bytes.len() => bytes[at] = below(numbers, 256) as u8,
            2 => drop(bytes.drain(at..end)),
            3 => {
                let copied = bytes[at..end].to_vec();
                let to = below(numbers, bytes.len() + 1);
                bytes.splice(to..to, copied);
            }
            4 => {
                let other = &self.seeds[below(numbers, self.seeds.len())];
                let from = below(numbers, other.len() + 1);
                let piece = &other[from..(from + length).min(other.len())];
                bytes.splice(at..end.min(at + piece.len()), piece.iter().copied());
            }
            5 => {
                let word = &self.words[below(numbers, self.words.len())];
                bytes.splice(at..at, word.iter().copied());
            }
            6 => bytes.truncate(at),
            7 => swapped(bytes, numbers),
            8 => {
                let lines = bytes.iter().enumerate().skip(at).filter(|(_, byte)| **byte == b'\n');
                let ends: Vec<usize> = lines.map(|(index, _)| index + 1).take(2).collect();
                if let [from, to] = ends[..] {
                    let line = bytes[from..to].to_vec();
                    let many = 1 + below(numbers, 4);
                    bytes.splice(from..from, line.repeat(many));
                }
            }
            _ => numbered(bytes, at, numbers),
        }
    }
}

/// Another number in the place of the first one from `at` on.
fn numbered(bytes: &mut Vec<u8>, at: usize, numbers: &mut Numbers) {
    let Some(from) = (at..bytes.len()).find(|&i| is_number(bytes[i])) else { return };
    let to = (from..bytes.len()).find(|&i| !is_number(bytes[i])).unwrap_or(bytes.len());
    let known = std::str::from_utf8(&bytes[from..to]).ok().and_then(|text| text.parse::<f64>().ok());
    let near = |numbers: &mut Numbers| {
        let by = 10f64.powf(numbers.between(-4.0, 4.0)) * if below(numbers, 2) == 0 { 1.0 } else { -1.0 };
        known.map(|value| if below(numbers, 2) == 0 { value * by } else { value + by })
    };
    let text = match below(numbers, 3) {
        0 => near(numbers).map(|value| format!("{value:.5}")),
        1 => near(numbers).map(|value| format!("{value:.0}")),
        _ => None,
    };
    let text = text.unwrap_or_else(|| NUMBERS[below(numbers, NUMBERS.len())].to_owned());
    bytes.splice(from..to, text.into_bytes());
}

/// Two words change places.
fn swapped(bytes: &mut Vec<u8>, numbers: &mut Numbers) {
    let blank = |byte: &u8| byte.is_ascii_whitespace();
    let word_at = |at: usize| {
        let from = (at..bytes.len()).find(|&i| !blank(&bytes[i]))?;
        Some(from..(from..bytes.len()).find(|&i| blank(&bytes[i])).unwrap_or(bytes.len()))
    };
    let places = [(); 2].map(|()| word_at(below(numbers, bytes.len() + 1)));
    let [Some(a), Some(b)] = places else { return };
    let (first, second) = if a.start <= b.start { (a, b) } else { (b, a) };
    if first.end > second.start || second.len() > 200 || first.len() > 200 {
        return;
    }
    let [one, other] = [&first, &second].map(|place| bytes[place.clone()].to_vec());
    bytes.splice(second, one);
    bytes.splice(first, other);
}

fn below(numbers: &mut Numbers, count: usize) -> usize {
    (numbers.between(0.0, count as f64) as usize).min(count.saturating_sub(1))
}

#[test]
fn a_dictionary_is_read_as_libfuzzer_reads_it() {
    assert_eq!(word(r#""a\"b\\\x0d\xEF""#), b"a\"b\\\x0d\xef");
    let all = words();
    assert!(all.len() > 80 && all.iter().all(|word| !word.is_empty()) && all.contains(&b"\r\n".to_vec()));
}

/// The same seed gives the same bytes, and nearly every seed others; numbers, words and lengths all change.
#[test]
fn changes_are_many_and_repeatable() {
    let (seeds, words) = (vec![b"G1 X12.5 Y3\nG1 X4 E1\n;LAYER_CHANGE\nG92 E0\n".repeat(8)], words());
    let mutator = Mutator { seeds: &seeds, words: &words, longest: 10_000 };
    let all: Vec<Vec<u8>> = (0..2000).map(|seed| mutator.bytes(seed)).collect();
    assert!(all.iter().enumerate().all(|(seed, bytes)| *bytes == mutator.bytes(seed as u64)));
    let different: std::collections::BTreeSet<&Vec<u8>> = all.iter().collect();
    assert!(different.len() > 1800, "{} of 2000 differ", different.len());
    for wanted in ["1e308", "NaN", "-9223372036854775808", "SET_PRESSURE_ADVANCE", "\r\n"] {
        let has = |bytes: &Vec<u8>| bytes.windows(wanted.len()).any(|window| window == wanted.as_bytes());
        assert!(all.iter().any(has), "never {wanted:?}");
    }
    assert!(all.iter().any(|bytes| bytes.len() > seeds[0].len()) && all.iter().any(|b| b.len() < seeds[0].len() / 2));
}
