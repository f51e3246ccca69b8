//! Tests hold codes, names, places and numbers against what is said, and no sentences: a sentence that is said better breaks no test.
//!
//! What is left is counted: literals that read as prose and are compared with something.

use std::path::Path;

use crate::rust_source::{is_word, line_of, literals, masked, test_items};
use crate::support::root;

/// Literals of this many words are prose.
const WORDS: usize = 4;

/// So many are left, most of them words of other programs, text of G-code, and warnings without a code. It may only fall.
const MOST: usize = 69;

/// These are about sentences, or hold made-up ones.
const EXCEPT: [&str; 4] =
    ["tests/it/architecture.rs", "tests/it/messages.rs", "tests/it/readable.rs", "tests/it/prose.rs"];

/// Words of two letters or more in a literal's source text; names with signs or digits in them are none, nor are placeholders.
fn words(literal: &str) -> usize {
    let text = literal.replace("\\n", " ");
    let is_prose = |token: &&str| {
        let word = token.trim_matches(|c: char| !c.is_alphanumeric());
        word.len() > 1 && !token.contains(['{', '}']) && word.chars().all(|c| c.is_alphabetic() || "-'’".contains(c))
    };
    text.split_whitespace().filter(is_prose).count()
}

/// Where the bracket stands that is open at `at`.
fn open_at(code: &[u8], at: usize) -> Option<usize> {
    let mut depth = 0_usize;
    for i in (0..at).rev() {
        match code[i] {
            b')' | b']' | b'}' => depth += 1,
            b'(' | b'[' | b'{' if depth == 0 => return Some(i),
            b'(' | b'[' | b'{' => depth -= 1,
            b';' if depth == 0 => return None,
            _ => {}
        }
    }
    None
}

/// Behind the bracket that is open at `from`.
fn close_of(code: &[u8], from: usize) -> usize {
    let mut depth = 0_usize;
    for (i, byte) in code.iter().enumerate().skip(from) {
        match byte {
            b'(' | b'[' | b'{' => depth += 1,
            b')' | b']' | b'}' if depth == 0 => return i + 1,
            b')' | b']' | b'}' => depth -= 1,
            _ => {}
        }
    }
    code.len()
}

/// Whether what stands from `start` to `end` of masked `code` is compared with something, alone or in a list, a tuple, or one of [`WRAPPERS`].
fn is_compared(code: &str, start: usize, end: usize) -> bool {
    let before = code[..start].trim_end_matches(|c: char| c.is_whitespace() || c == '&');
    let after = code[end..].trim_start();
    if ["==", "!="].iter().any(|sign| before.ends_with(sign) || after.starts_with(sign)) {
        return true;
    }
    let Some(open) = open_at(code.as_bytes(), start).filter(|open| code.as_bytes()[*open] != b'{') else {
        return false;
    };
    let head = code[..open].trim_end();
    let outside = || is_compared(code, open - name_length(head), close_of(code.as_bytes(), end));
    if code.as_bytes()[open] == b'[' {
        return outside();
    }
    if [".contains", ".starts_with", ".ends_with"].iter().any(|call| head.ends_with(call)) {
        return true;
    }
    if head.ends_with("assert_eq!") || head.ends_with("assert_ne!") {
        // The third argument is what is said when it fails.
        let mut depth = 0_i32;
        let commas = code[open + 1..start].bytes().filter(|byte| {
            depth += i32::from(b"([{".contains(byte)) - i32::from(b")]}".contains(byte));
            *byte == b',' && depth == 0
        });
        return commas.count() < 2;
    }
    // A tuple has no name before it.
    let tuple = head.ends_with(['(', '[', ',', '&', '=']);
    (tuple || WRAPPERS.iter().any(|name| head.ends_with(name))) && outside()
}

/// What wraps a value that is compared.
const WRAPPERS: [&str; 5] = ["Some", "Ok", "Err", "format!", "::from"];

/// The length of the path that ends `head`, as `String::from`.
fn name_length(head: &str) -> usize {
    head.bytes().rev().take_while(|byte| is_word(*byte) || b":!.".contains(byte)).count()
}

/// The prose that is compared in the test code of `text`, as `path:line: literal`.
fn prose(path: &str, text: &str) -> Vec<String> {
    let code = masked(text);
    let all = path.starts_with("tests/") || path.contains("/tests/") || path.ends_with("/tests.rs");
    let tests = test_items(&code);
    let is_test = |at: usize| all || tests.iter().any(|item| item.contains(&at));
    let found = literals(text)
        .into_iter()
        .filter(|at| is_test(at.start) && words(&text[at.clone()]) >= WORDS && is_compared(&code, at.start, at.end));
    found.map(|at| format!("{path}:{}: {}", line_of(text, at.start), &text[at])).collect()
}

fn all_below(folder: &Path, found: &mut Vec<String>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            all_below(&path, found);
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            let name = path.strip_prefix(root()).unwrap().display().to_string().replace('\\', "/");
            if !EXCEPT.contains(&name.as_str()) {
                found.extend(prose(&name, &std::fs::read_to_string(&path).unwrap()));
            }
        }
    }
}

#[test]
fn tests_compare_few_sentences() {
    let mut found = Vec::new();
    for folder in ["src", "tests"] {
        all_below(&root().join(folder), &mut found);
    }
    found.sort();
    assert!(
        found.len() <= MOST,
        "{} of at most {MOST}; compare codes and facts instead:\n{}",
        found.len(),
        found.join("\n")
    );
}

#[test]
fn a_sentence_is_found_wherever_it_is_compared() {
    let found = |line: &str| prose("tests/it/made_up.rs", &format!("fn f() {{\n    {line}\n}}\n")).len();
    for line in [
        r#"assert!(text.contains("the file is not there"));"#,
        r#"assert!(text.starts_with(&format!("{name} is also an input of it")));"#,
        r#"assert_eq!(text, "the file is not there", "{name}");"#,
        r#"assert_eq!(one(x, y), Some("the file is not there"));"#,
        r#"assert_eq!((code, text), (2, "the file is not there"));"#,
        r#"assert_eq!(notes, ["the file is not there"]);"#,
        r#"assert!(text == "the file is not there");"#,
        r#"assert!(text.ends_with(r"the file is not there"));"#,
    ] {
        assert_eq!(found(line), 1, "{line}");
    }
    for line in [
        r#"assert!(fails(&text, "mesh/open: a.stl:3 | 4 edges | --no-repair | out.gcode"));"#,
        r#"assert!(text.contains("a.stl:2 has 3 of them"));"#,
        r#"assert_eq!(text, wanted, "this is what is said of it");"#,
        r#"assert!(text.is_empty(), "this is what is said of it");"#,
        r#"let text = "this is some text that is given";"#,
        r#"// text.contains("this is only a comment here")"#,
    ] {
        assert_eq!(found(line), 0, "{line}");
    }
    let own = "fn f() { x.contains(\"no test code at all here\"); }\n#[cfg(test)]\nmod t { fn f() { x.contains(\"the file is not there\"); } }\n";
    assert_eq!(prose("src/made_up.rs", own), ["src/made_up.rs:3: \"the file is not there\""]);
}
