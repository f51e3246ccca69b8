//! The last line of a file that the built-in slicer wrote: a checksum of everything before it, so that no change goes unnoticed.
//!
//! `; crc32 = 1a2b3c4d` (IEEE 802.3, as in zip and png). Infill may lie in many ways, so that a line in a wrong place within a part
//! looks like one that was meant; a checksum sees it.

const KEY: &[u8] = b"\n; crc32 = ";

/// The line that closes `bytes`, which must end with a line feed.
pub fn closing_line(bytes: &[u8]) -> String {
    format!("; crc32 = {:08x}\n", crc32fast::hash(bytes))
}

/// Whether the file has such a line and it does not fit what stands before it, or is not the last; a file without it is as it is.
pub fn is_changed(bytes: &[u8]) -> bool {
    let Some(at) = memchr::memmem::rfind(bytes, KEY) else { return false };
    let (before, line) = bytes.split_at(at + 1);
    closing_line(before).as_bytes() != line
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_change_is_seen() {
        let text = b"G1 X1 E2\n; filament used [mm] = 2.00\n".to_vec();
        let whole = [text.as_slice(), closing_line(&text).as_bytes()].concat();
        assert!(whole.ends_with(b"\n; crc32 = 3f3dfac6\n"), "{}", String::from_utf8_lossy(&whole));
        assert!(!is_changed(&whole) && !is_changed(&text));
        for at in 0..whole.len() {
            let mut changed = whole.clone();
            changed[at] ^= 1;
            // Where the key itself is broken the file is one without a checksum.
            let key = at + 1 >= text.len() && at < text.len() + KEY.len() - 1;
            assert!(key || is_changed(&changed), "byte {at}");
        }
        assert!(is_changed(&[whole.as_slice(), b"G1 X5\n"].concat()));
    }
}
