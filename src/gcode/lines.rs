//! Lines of a file: LF or CR LF, with or without a final newline, an optional byte-order mark.

use memchr::memchr;

/// One line without its end, and its number counted from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NumberedLine<'a> {
    /// The line's number in the file, from 1.
    pub number: u32,
    /// The bytes, without LF, CR LF or byte-order mark.
    pub bytes: &'a [u8],
}

/// The lines of `file`; a final newline does not make an empty last line.
pub fn lines(file: &[u8]) -> impl Iterator<Item = NumberedLine<'_>> {
    let mut rest = file.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(file);
    let mut number = 0;
    std::iter::from_fn(move || {
        if rest.is_empty() {
            return None;
        }
        let (line, after) = match memchr(b'\n', rest) {
            Some(end) => (&rest[..end], &rest[end + 1..]),
            None => (rest, &rest[rest.len()..]),
        };
        rest = after;
        number += 1;
        Some(NumberedLine { number, bytes: line.strip_suffix(b"\r").unwrap_or(line) })
    })
}

#[cfg(test)]
mod tests {
    use super::lines;

    #[test]
    fn takes_every_line_end_and_a_byte_order_mark() {
        let got: Vec<_> = lines(b"\xEF\xBB\xBFG1\r\n\nG2").map(|l| (l.number, l.bytes.to_vec())).collect();
        assert_eq!(got, vec![(1, b"G1".to_vec()), (2, b"".to_vec()), (3, b"G2".to_vec())]);
        assert_eq!(lines(b"").count(), 0);
        assert_eq!(lines(b"a\n").count(), 1);
    }
}
