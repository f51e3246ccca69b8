//! Rust source as the architecture test reads it: comments, strings and test code blanked, paths into the crate found.
//!
//! Blanking keeps every byte's place and every line break, so that a finding names the true line.

use std::ops::Range;

/// `text` with comments, strings and characters blanked.
pub(crate) fn masked(text: &str) -> String {
    let bytes = text.as_bytes();
    let mut out = bytes.to_vec();
    let mut at = 0;
    while at < bytes.len() {
        let end = skipped(bytes, at);
        match end {
            Some(end) => {
                out[at..end].iter_mut().filter(|b| **b != b'\n').for_each(|b| *b = b' ');
                at = end;
            }
            None => at += 1,
        }
    }
    String::from_utf8(out).expect("whole characters are blanked")
}

/// The string literals of `text`, each with its quotes.
pub(crate) fn literals(text: &str) -> Vec<Range<usize>> {
    let bytes = text.as_bytes();
    let (mut found, mut at) = (Vec::new(), 0);
    while at < bytes.len() {
        let end = skipped(bytes, at);
        found.extend(end.filter(|_| !matches!(bytes[at], b'/' | b'\'')).map(|end| at..end));
        at = end.unwrap_or(at + 1);
    }
    found
}

/// The end of the comment, string or character that begins at `at`.
fn skipped(bytes: &[u8], at: usize) -> Option<usize> {
    let rest = &bytes[at..];
    let inside_word = at > 0 && is_word(bytes[at - 1]);
    if rest.starts_with(b"//") {
        return Some(at + rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len()));
    }
    if rest.starts_with(b"/*") {
        return Some(at + block_comment(rest));
    }
    if rest[0] == b'"' {
        return Some(at + quoted(rest, b'"'));
    }
    if !inside_word && (rest[0] == b'r' || rest.starts_with(b"br")) {
        return raw_string(rest).map(|length| at + length);
    }
    if rest[0] == b'\'' {
        // A lifetime has no closing quote behind its first character.
        let character = std::str::from_utf8(&rest[1..]).ok()?.chars().next()?;
        let closes = rest.get(1 + character.len_utf8()) == Some(&b'\'');
        return (character == '\\' || closes).then(|| at + quoted(rest, b'\''));
    }
    None
}

fn block_comment(rest: &[u8]) -> usize {
    let (mut depth, mut at) = (0, 0);
    while at < rest.len() {
        if rest[at..].starts_with(b"/*") {
            depth += 1;
            at += 2;
        } else if rest[at..].starts_with(b"*/") {
            depth -= 1;
            at += 2;
            if depth == 0 {
                return at;
            }
        } else {
            at += 1;
        }
    }
    at
}

fn quoted(rest: &[u8], quote: u8) -> usize {
    let mut at = 1;
    while at < rest.len() && rest[at] != quote {
        at += 1 + usize::from(rest[at] == b'\\');
    }
    (at + 1).min(rest.len())
}

fn raw_string(rest: &[u8]) -> Option<usize> {
    let start = rest.iter().position(|&b| b == b'r')? + 1;
    let hashes = rest[start..].iter().take_while(|&&b| b == b'#').count();
    if rest.get(start + hashes) != Some(&b'"') {
        return None;
    }
    let close = [b"\"".as_slice(), &vec![b'#'; hashes]].concat();
    let body = start + hashes + 1;
    let end = rest[body..].windows(close.len()).position(|w| w == close);
    Some(end.map_or(rest.len(), |end| body + end + close.len()))
}

/// Whether `byte` can stand inside an identifier.
pub(crate) fn is_word(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || byte == b'_'
}

/// The attributes of an item that is test code.
const TEST_ITEMS: [&str; 2] = ["#[cfg(test)]", "#[cfg(all(test,"];

/// The items of masked `code` that are test code.
pub(crate) fn test_items(code: &str) -> Vec<Range<usize>> {
    let all = TEST_ITEMS.iter().flat_map(|marker| code.match_indices(marker));
    all.map(|(at, _)| at..item_end(code.as_bytes(), at)).collect()
}

/// Masked `code` with every item under `#[cfg(test)]` blanked too.
pub(crate) fn without_tests(code: &str) -> String {
    let mut out = code.as_bytes().to_vec();
    for marker in TEST_ITEMS {
        while let Some(at) = find(&out, marker.as_bytes()) {
            let end = item_end(&out, at);
            out[at..end].iter_mut().filter(|b| **b != b'\n').for_each(|b| *b = b' ');
        }
    }
    String::from_utf8(out).expect("whole characters are blanked")
}

fn find(bytes: &[u8], wanted: &[u8]) -> Option<usize> {
    bytes.windows(wanted.len()).position(|window| window == wanted)
}

/// Behind the item whose attributes begin at `at`: behind its `;`, or behind its braces.
fn item_end(bytes: &[u8], at: usize) -> usize {
    let mut depth = 0_usize;
    for (i, byte) in bytes.iter().enumerate().skip(at) {
        match byte {
            b'{' => depth += 1,
            b'}' if depth <= 1 => return i + 1,
            b'}' => depth -= 1,
            b';' if depth == 0 => return i + 1,
            _ => {}
        }
    }
    bytes.len()
}

/// The line (from 1) of the byte at `at`.
pub(crate) fn line_of(code: &str, at: usize) -> usize {
    1 + code.as_bytes()[..at].iter().filter(|&&b| b == b'\n').count()
}

/// Where the whole word `word` (it may be a path, `std::fs`) stands in `code`.
pub(crate) fn words(code: &str, word: &str) -> Vec<usize> {
    let bytes = code.as_bytes();
    let whole = |&(at, _): &(usize, &str)| {
        let before = at == 0 || !is_word(bytes[at - 1]);
        before && bytes.get(at + word.len()).is_none_or(|&b| !is_word(b))
    };
    code.match_indices(word).filter(whole).map(|(at, _)| at).collect()
}

/// What follows each `prefix::` in `code`: the next name, or the first names of a `{..}` group; with their places.
pub(crate) fn names_after(code: &str, prefix: &str) -> Vec<(String, usize)> {
    let mut found = Vec::new();
    // `super::super::a` names nothing that `super::` does.
    for at in words(code, prefix).into_iter().filter(|at| !code[..*at].trim_end().ends_with("::")) {
        let rest = &code[at + prefix.len()..];
        let Some(tail) = rest.trim_start().strip_prefix("::") else { continue };
        let tail = tail.trim_start();
        match tail.strip_prefix('{') {
            Some(group) => found.extend(group_heads(group).into_iter().map(|name| (name, at))),
            None => found.push((head(tail), at)),
        }
    }
    found
}

/// The name at the start of `text`; `*` for a glob.
fn head(text: &str) -> String {
    if text.starts_with('*') {
        return "*".to_owned();
    }
    text.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect()
}

/// First names of a group's members, `{` already taken.
fn group_heads(group: &str) -> Vec<String> {
    let (mut depth, mut start, mut members) = (0, 0, Vec::new());
    for (i, c) in group.char_indices() {
        match c {
            '{' => depth += 1,
            '}' if depth == 0 => {
                members.push(&group[start..i]);
                break;
            }
            '}' => depth -= 1,
            ',' if depth == 0 => {
                members.push(&group[start..i]);
                start = i + 1;
            }
            _ => {}
        }
    }
    members.iter().map(|member| head(member.trim_start())).filter(|name| !name.is_empty()).collect()
}

#[test]
fn strings_comments_and_characters_are_blanked_in_place() {
    let text =
        "let a = \"std::fs \\\" x\"; // std::fs\nlet b = r#\"a \"q\" \"#; /* /* */ z */ let c = '\"'; fn f<'a>() {}";
    let code = masked(text);
    assert_eq!(code.len(), text.len());
    assert_eq!(code.split_whitespace().collect::<Vec<_>>().join(" "), "let a = ; let b = ; let c = ; fn f<'a>() {}");
    assert_eq!(line_of(&code, code.find("let b").unwrap()), 2);
}

#[test]
fn test_modules_are_blanked_wherever_they_stand() {
    let code = "#[cfg(test)]\nmod t {\n fn x() { a(); }\n}\nfn kept() {}\n#[cfg(test)]\nmod far;\nfn too() {}";
    assert_eq!(without_tests(code).split_whitespace().collect::<Vec<_>>(), ["fn", "kept()", "{}", "fn", "too()", "{}"]);
}

#[test]
fn groups_give_their_first_names() {
    let names = |code| names_after(code, "crate").into_iter().map(|(name, _)| name).collect::<Vec<_>>();
    assert_eq!(names("use crate::{geom::{Vec3, Dir}, mesh, self as x};"), ["geom", "mesh", "self"]);
    assert_eq!(names("use crate::gcode::lines; crate::*; pub(crate) fn a() {} mycrate::b"), ["gcode", "*"]);
}
