//! A reader of unpacked text that stops where more comes out than may: a small archive can hold any amount of nothing.

use std::io::{BufRead, Error, Read, Result};

/// The longest tag or text between two tags, bytes: the parser holds one of them as a whole.
const LONGEST_PIECE: u64 = 16 << 20;

/// Unpacked text, measured.
pub(super) struct Meter<R> {
    inner: R,
    /// What may still come.
    left: u64,
    /// What may still come of the piece at hand.
    piece: u64,
    over: bool,
}

impl<R: BufRead> Meter<R> {
    /// At most `left` bytes of `inner`.
    pub(super) fn new(inner: R, left: u64) -> Self {
        Self { inner, left, piece: LONGEST_PIECE, over: false }
    }

    /// The next piece begins.
    pub(super) fn piece(&mut self) {
        self.piece = LONGEST_PIECE;
    }

    /// What may still come.
    pub(super) fn left(&self) -> u64 {
        self.left
    }

    /// Whether there was more than may be.
    pub(super) fn is_over(&self) -> bool {
        self.over
    }
}

impl<R: BufRead> BufRead for Meter<R> {
    fn fill_buf(&mut self) -> Result<&[u8]> {
        let room = usize::try_from(self.left.min(self.piece)).unwrap_or(usize::MAX);
        let there = self.inner.fill_buf()?;
        if room == 0 && !there.is_empty() {
            self.over = true;
            return Err(Error::other("more than is read"));
        }
        Ok(&there[..there.len().min(room)])
    }

    fn consume(&mut self, count: usize) {
        self.inner.consume(count);
        self.left = self.left.saturating_sub(count as u64);
        self.piece = self.piece.saturating_sub(count as u64);
    }
}

impl<R: BufRead> Read for Meter<R> {
    fn read(&mut self, into: &mut [u8]) -> Result<usize> {
        let count = self.fill_buf()?.read(into)?;
        self.consume(count);
        Ok(count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_may_come_comes_and_no_byte_more() {
        let mut text = Vec::new();
        let mut meter = Meter::new(&b"abcdef"[..], 6);
        assert_eq!((meter.read_to_end(&mut text).unwrap(), meter.left(), meter.is_over()), (6, 0, false));
        let mut meter = Meter::new(&b"abcdef"[..], 5);
        assert!(meter.read_to_end(&mut text).is_err() && meter.is_over());
    }

    #[test]
    fn pieces_are_measured_one_by_one() {
        let long = vec![b'x'; LONGEST_PIECE as usize];
        let two = [&long[..], &long[..]].concat();
        let mut meter = Meter::new(&two[..], u64::MAX);
        meter.read_exact(&mut long.clone()).unwrap();
        meter.piece();
        meter.read_exact(&mut long.clone()).unwrap();
        let mut meter = Meter::new(&two[..], u64::MAX);
        assert!(meter.read_to_end(&mut Vec::new()).is_err() && meter.is_over());
    }
}
