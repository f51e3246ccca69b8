//! Bytes on their way to the port. The end of the last line may be held back until the printer has room for it.

/// What is to be written, in order; the port takes it from the front.
#[derive(Clone, Debug, Default)]
pub(super) struct Outbox {
    bytes: Vec<u8>,
    taken: usize,
    /// So many bytes at the end do not go yet.
    held: usize,
}

impl Outbox {
    pub(super) fn pending(&self) -> &[u8] {
        &self.bytes[self.taken..self.bytes.len() - self.held]
    }

    /// All but the last `held` bytes may go, as far as they have not gone.
    pub(super) fn hold(&mut self, held: usize) {
        self.held = held.min(self.bytes.len() - self.taken);
    }

    /// Whether a line is cut where the printer had no more room.
    pub(super) fn holds(&self) -> bool {
        self.held > 0
    }

    pub(super) fn took(&mut self, count: usize) {
        self.taken = (self.taken + count).min(self.bytes.len() - self.held);
        if self.taken == self.bytes.len() {
            self.clear();
        }
    }

    /// The end, to write to; what was held back goes before it.
    pub(super) fn end(&mut self) -> &mut Vec<u8> {
        self.held = 0;
        &mut self.bytes
    }

    pub(super) fn push(&mut self, bytes: &[u8]) {
        self.held = 0;
        self.bytes.extend_from_slice(bytes);
    }

    pub(super) fn clear(&mut self) {
        self.bytes.clear();
        (self.taken, self.held) = (0, 0);
    }

    /// What the port has not taken is dropped, and a line that is cut in two by that is ended.
    ///
    /// Where a blank line is a line, half of one would be carried out as another one: so it goes out whole. Where lines have
    /// checksums the half is ended by `ends_half_line`, and refused.
    pub(super) fn drop_unsent(&mut self, ends_half_line: &[u8]) {
        let cut = self.taken > 0 && self.bytes.get(self.taken - 1).is_some_and(|b| *b != b'\n');
        let unsent = &self.bytes[self.taken..];
        let rest = unsent.iter().position(|b| *b == b'\n').map_or(Vec::new(), |end| unsent[..=end].to_vec());
        self.clear();
        if !ends_half_line.is_empty() {
            self.bytes.extend_from_slice(ends_half_line);
        } else if cut {
            self.bytes = rest;
        }
    }
}
