//! Numbers to few bytes, and bytes to the page's letters.
//!
//! Whole numbers go as LEB128: seven bits a byte, the lowest first, the eighth says that more follow; signed ones are folded first
//! (0, -1, 1, -2 to 0, 1, 2, 3). What belongs together stands together, each section behind its length (four bytes, the lowest
//! first); all sections are one raw deflate stream (RFC 1951), written in base64 (RFC 4648).

use std::io::Write;

use flate2::{Compression, write::DeflateEncoder};

/// Numbers of one kind, one behind the other.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Column(pub(super) Vec<u8>);

impl Column {
    /// Appends a number that is not negative.
    pub(super) fn unsigned(&mut self, mut value: u64) {
        while value >= 0x80 {
            self.0.push(value as u8 | 0x80);
            value >>= 7;
        }
        self.0.push(value as u8);
    }

    /// Appends a number of either sign.
    pub(super) fn signed(&mut self, value: i64) {
        self.unsigned(((value << 1) ^ (value >> 63)) as u64);
    }
}

/// All sections, each behind its length, compressed.
pub(super) fn deflated<'a>(sections: impl IntoIterator<Item = &'a Column>) -> Vec<u8> {
    let mut encoder = DeflateEncoder::new(Vec::new(), Compression::new(6));
    for Column(bytes) in sections {
        // A vector takes whatever is written to it.
        let _ = encoder.write_all(&(bytes.len() as u32).to_le_bytes());
        let _ = encoder.write_all(bytes);
    }
    encoder.finish().unwrap_or_default()
}

const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

/// Appends `bytes` in base64.
pub(super) fn push_base64(bytes: &[u8], out: &mut String) {
    out.reserve(bytes.len().div_ceil(3) * 4);
    for three in bytes.chunks(3) {
        let at = |i: usize| u32::from(three.get(i).copied().unwrap_or_default());
        let bits = at(0) << 16 | at(1) << 8 | at(2);
        for i in 0..4 {
            let letter = LETTERS[(bits >> (18 - 6 * i) & 63) as usize];
            out.push(if i <= three.len() { char::from(letter) } else { '=' });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// RFC 4648, section 10.
    #[test]
    fn base64_is_that_of_the_standard() {
        for (plain, wanted) in
            [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foob", "Zm9vYg=="), ("foobar", "Zm9vYmFy")]
        {
            let mut out = String::new();
            push_base64(plain.as_bytes(), &mut out);
            assert_eq!(out, wanted);
        }
    }

    #[test]
    fn small_numbers_of_either_sign_take_a_byte() {
        let mut column = Column::default();
        [0, -1, 1, -64, 63, 64, -300].into_iter().for_each(|v| column.signed(v));
        assert_eq!(column.0, [0, 1, 2, 127, 126, 0x80, 1, 0xd7, 4]);
    }
}
