//! What a terminal may be given: names and sentences of strangers' files and programs, without the bytes that would drive it.

use std::borrow::Cow;

/// `text` as a terminal may have it: control characters but line feed and tab, and those that turn the direction of writing, are
/// spelt out (`\u001b`), as JSON, TOML and Rust have them, so that a document means the same. A carriage return before a line feed goes.
///
/// Everything that the command prints for people goes through here, whatever room it comes from; files do not.
pub fn visible(text: &str) -> Cow<'_, str> {
    if !text.contains(drives) {
        return Cow::Borrowed(text);
    }
    let text = text.replace("\r\n", "\n");
    let spelt = text.chars().map(|c| if drives(c) { format!("\\u{:04x}", u32::from(c)) } else { c.to_string() });
    Cow::Owned(spelt.collect())
}

/// Whether a terminal acts on a character in place of showing it.
fn drives(c: char) -> bool {
    let turns = matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    turns || (c.is_control() && c != '\n' && c != '\t')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_that_drives_a_terminal_is_left() {
        let all: String = (0..0x3000).filter_map(char::from_u32).collect();
        let seen = visible(&all);
        // Unicode's own classes Cc and Bidi_Control, by number.
        let bad = |c: char| {
            let n = u32::from(c);
            let control = n < 0x20 || (0x7f..=0x9f).contains(&n);
            let bidi = n == 0x61c
                || n == 0x200e
                || n == 0x200f
                || (0x202a..=0x202e).contains(&n)
                || (0x2066..=0x2069).contains(&n);
            (control && c != '\n' && c != '\t') || bidi
        };
        assert!(all.chars().any(bad) && !seen.chars().any(bad));
        assert!(all.chars().filter(|c| !drives(*c)).all(|c| seen.contains(c)));
        assert_eq!(visible("a\u{1b}]0;x\u{7}b"), "a\\u001b]0;x\\u0007b");
        assert_eq!(visible("one\r\ntwo\u{7f}"), "one\ntwo\\u007f");
    }

    #[test]
    fn plain_text_is_not_copied_and_a_document_means_the_same() {
        assert!(matches!(visible("bracket, 12 × 3 mm: größer\n\tno"), Cow::Borrowed(_)));
        let document = serde_json::json!({"name": "\u{1b}]0;x\u{7}\u{9b}31m\u{202e}gpj.exe\u{7f}"});
        let printed = serde_json::to_string_pretty(&document).unwrap();
        let seen = visible(&printed);
        assert!(seen.is_ascii() && seen != printed);
        assert_eq!(serde_json::from_str::<serde_json::Value>(&seen).unwrap(), document);
    }
}
