//! The table line by line, and five readers typed out from the firmwares' own sources, which see what the table lets pass as
//! [`ParsedLine`] does.

use std::collections::BTreeMap;

use super::{LineRules, Misreading};
use crate::gcode::meaning::Firmware;
use crate::gcode::{LineKind, ParsedLine};

fn misreading(firmware: Firmware, line: &[u8]) -> Option<Misreading> {
    let mut parsed = ParsedLine::default();
    parsed.read(line).unwrap_or_else(|why| panic!("{:?}: {why}", String::from_utf8_lossy(line)));
    LineRules::of(firmware).misreading(line, &parsed)
}

/// Of Marlin, RepRapFirmware, Klipper, Grbl, LinuxCNC: whether each misreads the line.
fn misread_by(line: &str) -> String {
    let of = |(_, firmware)| if misreading(firmware, line.as_bytes()).is_some() { 'x' } else { '-' };
    Firmware::NAMES.into_iter().map(of).collect()
}

#[test]
fn each_firmware_has_its_own_oddities() {
    let cases = [
        // What slicers write, all read.
        ("G1 X1.5 Y-.25 E.02 F1800 ; outer wall (1)", "-----"),
        ("; G1 X1 (Z-5) g1 x1 x2", "-----"),
        ("M204 P800 T1500", "-----"),
        ("M117 hello (you) X1 X2", "-----"),
        ("M291 P\"load PLA (1:2) 1e5 g1\" S3", "-----"),
        ("M0 Insert the nut", "-x-xx"),
        ("(a comment alone)", "-----"),
        ("G1 X5 (Z-5)", "xxx--"),
        ("(Z-5) G1 X5", "xxx--"),
        ("G1 X5 X6", "xx-xx"),
        ("G1 E5 E0.24", "xx-xx"),
        ("G1 X1E5", "-x---"),
        ("G1 X1.E5", "-x---"),
        ("G1 X1 E5", "-----"),
        ("g1 x5", "x----"),
        ("G1 x5", "x----"),
        ("X5 Y5", "xxx--"),
        ("F1800", "xxx--"),
        ("O100 X5", "xxxxx"),
        ("O100 call", "xxxxx"),
        ("G01 X5", "--x--"),
        ("G1.0 X5", "--x--"),
        ("G 1 X5", "-xx--"),
        ("N5 G1 X5", "-----"),
        ("G1 X5 E1:2", "xxxxx"),
        ("G3 Z.6 I1 J0 P1", "xxxx-"),
        ("G2 X5 I1 J0", "-----"),
        ("M208 U-200:200 X1", "-----"),
        ("G90 G1 X5", "-----"),
        ("G1 X5 G91", "-x---"),
        ("G1 X5 M106 S1", "-x-xx"),
        ("G1 Z-5 G4 P1", "-x-xx"),
        ("G1 X5\r", "-----"),
        ("G1 X5\r Z-5", "xx-x-"),
        ("; a\rG1 Z-5", "xx-x-"),
        ("M118 G1 Z-5", "-x---"),
        ("M118 S\"G1 Z-5\"", "-----"),
        ("M117 G1 Z-5", "-----"),
        (";py,print()", "----x"),
        ("(PY,print)", "----x"),
        ("( abort,now) G1 X5", "xxx-x"),
    ];
    for (line, wanted) in cases {
        assert_eq!(misread_by(line), wanted, "{line:?}");
    }
    let line = format!("N5 G1 X5*{}", "N5 G1 X5".bytes().fold(0, |sum, byte| sum ^ byte));
    assert_eq!(misread_by(&line), "---xx", "{line}");
}

/// The length from which on a line is misread.
#[test]
fn lines_are_as_long_as_each_firmware_reads() {
    let shortest = |firmware, line: &dyn Fn(usize) -> String| {
        (20..400).find(|&n| misreading(firmware, line(n).as_bytes()).is_some()).unwrap_or(0)
    };
    let code = |n: usize| format!("G1 X1.{}", "0".repeat(n - 6));
    let comment = |n: usize| format!("G1 X1 ;{}", "-".repeat(n - 7));
    let lengths = Firmware::NAMES.map(|(_, firmware)| [shortest(firmware, &code), shortest(firmware, &comment)]);
    // Grbl counts no blanks: 80 bytes and one blank.
    assert_eq!(lengths, [[96, 0], [256, 0], [0, 0], [81, 0], [252, 252]]);
    let text = format!("M117 {}", "a".repeat(100));
    assert_eq!(misreading(Firmware::Marlin, text.as_bytes()), None);
}

type Words = BTreeMap<u8, Option<f64>>;
/// A command's letter and number, and its words.
type Seen = Option<(u8, u32, Words)>;

/// The number at the start, as C's `strtof` without exponents takes it.
fn strtof(text: &[u8]) -> Option<f64> {
    let signed = usize::from(text.first().is_some_and(|b| b"+-".contains(b)));
    let length = text[signed..].iter().take_while(|b| b.is_ascii_digit() || **b == b'.').count();
    std::str::from_utf8(&text[..signed + length]).ok()?.parse().ok()
}

fn digits(text: &[u8]) -> (u32, usize) {
    let length = text.iter().take_while(|b| b.is_ascii_digit()).count();
    (std::str::from_utf8(&text[..length]).unwrap().parse().unwrap_or(u32::MAX), length)
}

fn uncommented(line: &[u8]) -> &[u8] {
    line.split(|b| *b == b';').next().unwrap()
}

/// Marlin: `process_stream_char`, `GCodeParser::parse`; `first`: built without FASTER_GCODE_PARSER.
fn marlin(line: &[u8], first: bool) -> Seen {
    let code = line.split(|b| *b == b'\r').next().unwrap();
    let code = uncommented(code);
    let mut code = &code[..code.len().min(95)];
    while let [b' ', rest @ ..] = code {
        code = rest;
    }
    if let [b'N', rest @ ..] = code
        && rest.first().is_some_and(u8::is_ascii_digit)
    {
        code = rest[digits(rest).1..].trim_ascii_start();
    }
    let code = code.split(|b| *b == b'*').next().unwrap();
    let [letter @ (b'G' | b'M' | b'T'), rest @ ..] = code else { return None };
    let rest = rest.trim_ascii_start();
    let (number, length) = digits(rest);
    let mut words = Words::new();
    let params = &rest[length..];
    for (at, &b) in params.iter().enumerate().filter(|(_, b)| b.is_ascii_uppercase()) {
        let value = strtof(params[at + 1..].trim_ascii_start());
        if !(first && words.contains_key(&b)) {
            words.insert(b, value);
        }
    }
    Some((*letter, number, words))
}

/// RepRapFirmware: `Put`, `DecodeCommand`, `Seen`.
fn rrf(line: &[u8]) -> Seen {
    let line = line.split(|b| *b == b'\r').next().unwrap();
    let mut code = uncommented(line).trim_ascii_start();
    if code.len() > 255 {
        return None;
    }
    if let [b'N' | b'n', rest @ ..] = code
        && rest.first().is_some_and(u8::is_ascii_digit)
    {
        code = rest[digits(rest).1..].trim_ascii_start();
    }
    let code = code.split(|b| *b == b'*').next().unwrap();
    let letter = code.first()?.to_ascii_uppercase();
    if !matches!(letter, b'G' | b'M' | b'T') || !code.get(1)?.is_ascii_digit() {
        return None;
    }
    let (number, length) = digits(&code[1..]);
    let params = &code[1 + length..];
    let end = params.iter().position(|b| b"GMgm".contains(b)).unwrap_or(params.len());
    let mut words = Words::new();
    for at in 0..end {
        let letter = params[at].to_ascii_uppercase();
        let exponent = letter == b'E' && at > 0 && params[at - 1].is_ascii_digit();
        if letter.is_ascii_uppercase() && !exponent {
            let number = &params[at + 1..];
            let length = number.iter().take_while(|b| b.is_ascii_digit() || b"+-. eE".contains(b)).count();
            let text = String::from_utf8_lossy(&number[..length]).trim().replace(' ', "x");
            let text = text.split('x').next().unwrap();
            words.entry(letter).or_insert(text.trim_end_matches(['e', 'E']).parse().ok());
        }
    }
    Some((letter, number, words))
}

/// Klipper: `_process_commands`, and `float()` of each word.
fn klipper(line: &[u8]) -> Seen {
    let text = String::from_utf8_lossy(uncommented(line)).to_ascii_uppercase();
    let text = text.trim();
    let mut parts: Vec<(String, String)> = Vec::new();
    for c in text.chars() {
        let letter = c.is_ascii_uppercase() || c == '_';
        match parts.last_mut() {
            Some((name, value)) if letter && value.is_empty() && name != "*" => name.push(c),
            _ if letter || c == '*' => parts.push((c.to_string(), String::new())),
            Some((_, value)) => value.push(c),
            None if c == ' ' || c == '\t' => {}
            // Something before the first letter is a part of the command's name.
            None => return None,
        }
    }
    let numbered = parts.first().is_some_and(|(name, _)| name == "N");
    let command = parts.get(usize::from(numbered))?;
    let (letter, number) = (command.0.clone(), command.1.trim().to_owned());
    if letter.len() != 1 || number.parse::<u32>().ok()?.to_string() != number {
        return None;
    }
    let mut words = Words::new();
    for (name, value) in &parts[usize::from(numbered) + 1..] {
        if name == "*" {
            continue;
        }
        let value = value.trim();
        let value = if value.is_empty() { None } else { Some(value.parse::<f64>().ok()?) };
        words.insert(*name.as_bytes().last().filter(|_| name.len() == 1)?, value);
    }
    Some((letter.as_bytes()[0], number.parse().ok()?, words))
}

/// Grbl's `protocol_main_loop` and LinuxCNC's `close_and_downcase`, then words, each once.
fn ngc(line: &[u8], grbl: bool) -> Seen {
    if !grbl && line.len() > 251 {
        return None;
    }
    let line = if grbl { line.split(|b| *b == b'\r').next().unwrap() } else { line };
    let (mut code, mut inside) = (Vec::new(), false);
    for &b in line {
        match b {
            b'(' => inside = true,
            b')' => inside = false,
            b';' if !inside => break,
            _ if inside || b.is_ascii_whitespace() => {}
            _ => code.push(b.to_ascii_uppercase()),
        }
    }
    if grbl && code.len() > 79 {
        return None;
    }
    let (mut at, mut seen, mut words) = (0, None, Words::new());
    while at < code.len() {
        let letter = code[at];
        let length = code[at + 1..].iter().take_while(|b| b.is_ascii_digit() || b"+-.".contains(b)).count();
        let value = std::str::from_utf8(&code[at + 1..at + 1 + length]).unwrap().parse().ok();
        at += 1 + length;
        let repeated = match letter {
            b'N' => false,
            b'G' | b'M' => seen.replace((letter, value? as u32)).is_some(),
            b'A'..=b'Z' => words.insert(letter, value).is_some(),
            _ => true,
        };
        if repeated {
            return None;
        }
    }
    seen.map(|(letter, number)| (letter, number, words))
}

/// xorshift64*: the same numbers on every run.
struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) % n as u64) as usize
    }

    fn line(&mut self) -> Vec<u8> {
        const STARTS: [&str; 9] = ["G1", "G0", "G1 ", "g1", "G01", "G 1", "N5 G1", "G1.0", "M204"];
        const LETTERS: [&str; 12] = [" X", " Y", " Z", " E", " F", "X", "E", " x", " e", " (Z", "  Y", "\tZ"];
        const NUMBERS: [&str; 8] = ["1", "-2.5", ".25", "+3", "7.", "100", "0.00001", "12.5"];
        const ENDS: [&str; 7] = ["", "", ")", " (a)", " ; X9", "\r", "\r Z-5"];
        let mut text = STARTS[self.below(9)].to_owned();
        for _ in 0..self.below(5) {
            text += LETTERS[self.below(12)];
            text += NUMBERS[self.below(8)];
        }
        if self.below(20) == 0 {
            text += &"0".repeat(self.below(300));
        }
        (text + ENDS[self.below(7)]).into_bytes()
    }
}

#[test]
fn what_is_no_misreading_five_readers_read_alike() {
    let mut random = Random(3);
    let (mut parsed, mut alike, mut otherwise) = (ParsedLine::default(), [0; 5], [0; 5]);
    for _ in 0..200_000 {
        let line = random.line();
        if parsed.read(&line).is_err()
            || parsed.kind != LineKind::Words
            || !matches!(parsed.commands[..], [c] if c.number < 1000)
        {
            continue;
        }
        let wanted: Words = parsed.words.iter().map(|w| (w.letter, w.value)).collect();
        let command = parsed.commands[0];
        let ours: Seen = Some((command.letter, command.number, wanted));
        for (i, (_, firmware)) in Firmware::NAMES.into_iter().enumerate() {
            let seen = match firmware {
                Firmware::Marlin => vec![marlin(&line, true), marlin(&line, false)],
                Firmware::RepRapFirmware => vec![rrf(&line)],
                Firmware::Klipper => vec![klipper(&line)],
                Firmware::Grbl => vec![ngc(&line, true)],
                Firmware::LinuxCnc => vec![ngc(&line, false)],
            };
            let same = seen.iter().all(|seen| *seen == ours);
            let found = LineRules::of(firmware).misreading(&line, &parsed);
            let shown = String::from_utf8_lossy(&line).into_owned();
            assert!(found.is_some() || same, "{firmware:?} {shown:?}: {ours:?}, but it reads {seen:?}");
            alike[i] += u32::from(found.is_none());
            otherwise[i] += u32::from(!same);
        }
    }
    assert!(alike.iter().all(|n| *n > 3_000) && otherwise.iter().all(|n| *n > 3_000), "{alike:?} {otherwise:?}");
}
