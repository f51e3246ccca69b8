//! Bytes of the wire: framing, line numbers, checksums, and lines out of whatever arrives.
//!
//! The checksum is the XOR of every byte before `*`, in decimal (RepRap wiki, *G-code*; Marlin `queue.cpp`).
//!
//! This file must not know what a reply means: that is `reply`'s.

use memchr::memchr2;

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

/// The most bytes that [`push_numbered`] will append.
pub(crate) fn numbered_len(number: i64, block: &[u8]) -> usize {
    let digits = number.unsigned_abs().checked_ilog10().unwrap_or(0) as usize + 1;
    // The checksum has one to three digits; the longest is taken.
    1 + usize::from(number < 0) + digits + block.len() + 5
}

pub(super) fn push_integer(out: &mut Vec<u8>, value: i64) {
    out.extend_from_slice(integer_digits(&mut [0; 21], value));
}

pub(super) fn integer_digits(digits: &mut [u8; 21], value: i64) -> &[u8] {
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
