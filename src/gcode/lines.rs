//! Lines of a file: LF or CR LF, with or without a final newline, an optional byte-order mark.

use memchr::{memchr, memchr_iter};

/// One line without its end, and its number counted from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NumberedLine<'a> {
    /// The line's number in the file, from 1.
    pub number: u32,
    /// The bytes, without LF, CR LF or byte-order mark.
    pub bytes: &'a [u8],
}

/// What some editors put before a file's first line.
const BYTE_ORDER_MARK: &[u8] = b"\xEF\xBB\xBF";

/// The lines of `file`; a final newline does not make an empty last line.
pub fn lines(file: &[u8]) -> impl Iterator<Item = NumberedLine<'_>> {
    let file = &file[text_start(file)..];
    let mut ends = memchr_iter(b'\n', file);
    let (mut start, mut number) = (0, 0);
    std::iter::from_fn(move || {
        if start >= file.len() {
            return None;
        }
        let end = ends.next().unwrap_or(file.len());
        let line = &file[start..end];
        start = end + 1;
        number += 1;
        Some(NumberedLine { number, bytes: line.strip_suffix(b"\r").unwrap_or(line) })
    })
}

/// Where the first line of `file` begins: behind its byte-order mark, if it has one.
pub fn text_start(file: &[u8]) -> usize {
    if file.starts_with(BYTE_ORDER_MARK) { BYTE_ORDER_MARK.len() } else { 0 }
}

/// The first line of `rest`, and how many bytes it takes with its end.
pub fn first_line(rest: &[u8]) -> (&[u8], usize) {
    let end = memchr(b'\n', rest).unwrap_or(rest.len());
    let line = &rest[..end];
    (line.strip_suffix(b"\r").unwrap_or(line), (end + 1).min(rest.len()))
}

#[cfg(test)]
mod tests {
    use super::{first_line, lines, text_start};

    #[test]
    fn takes_every_line_end_and_a_byte_order_mark() {
        let got: Vec<_> = lines(b"\xEF\xBB\xBFG1\r\n\nG2").map(|l| (l.number, l.bytes.to_vec())).collect();
        assert_eq!(got, vec![(1, b"G1".to_vec()), (2, b"".to_vec()), (3, b"G2".to_vec())]);
        assert_eq!(lines(b"").count(), 0);
        assert_eq!(lines(b"a\n").count(), 1);
    }

    #[test]
    fn one_line_after_the_other_is_all_lines() {
        for file in [&b"\xEF\xBB\xBFG1\r\n\nG2\r"[..], b"a\n", b"\n\n", b"", b"a\r\nb"] {
            let (mut at, mut found) = (text_start(file), Vec::new());
            while at < file.len() {
                let (line, length) = first_line(&file[at..]);
                found.push(line);
                at += length;
            }
            assert_eq!(found, lines(file).map(|l| l.bytes).collect::<Vec<_>>(), "{file:?}");
        }
    }
}
