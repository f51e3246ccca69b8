//! Blocks with no byte that a firmware does not need: on a serial wire every byte counts.

use memchr::memchr;

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
}
