//! What a program says, however much: the beginning and the end of it.

use std::collections::VecDeque;

/// So many bytes of the beginning are kept, and as many of the end.
const KEPT: usize = 64 << 10;

/// The beginning and the end of a stream.
#[derive(Debug, Default)]
pub(super) struct Said {
    head: Vec<u8>,
    tail: VecDeque<u8>,
    left_out: u64,
}

impl Said {
    /// The stream goes on.
    pub(super) fn push(&mut self, bytes: &[u8]) {
        let (head, rest) = bytes.split_at(bytes.len().min(KEPT - self.head.len()));
        self.head.extend_from_slice(head);
        self.tail.extend(rest);
        let over = self.tail.len().saturating_sub(KEPT);
        self.tail.drain(..over);
        self.left_out += over as u64;
    }

    /// As text; a line says what was left out.
    pub(super) fn text(&self) -> String {
        let mut bytes = self.head.clone();
        if self.left_out > 0 {
            bytes.extend_from_slice(format!("\n[{} bytes left out]\n", self.left_out).as_bytes());
        }
        bytes.extend(&self.tail);
        String::from_utf8_lossy(&bytes).into_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_much_the_beginning_and_the_end_are_kept() {
        let mut said = Said::default();
        said.push(b"first ");
        said.push(b"second");
        assert_eq!(said.text(), "first second");
        let mut said = Said::default();
        said.push(b"first");
        (0..1000).for_each(|_| said.push(&[b'.'; 1000]));
        said.push(b"last");
        assert!(said.head.len() + said.tail.len() == 2 * KEPT);
        let text = said.text();
        let left_out = 5 + 1_000_000 + 4 - 2 * KEPT;
        assert!(text.starts_with("first.") && text.ends_with(".last"));
        assert!(text.contains(&format!("\n[{left_out} bytes left out]\n")));
    }
}
