//! How the project speaks: pages for users have short sentences, and neither they nor messages nor help use words that only this project has.

use regex_lite::Regex;

use crate::support::{is_kept, root, trunnion};

/// Pages of the project's own people, whose sentences may be longer.
const FOR_DEVELOPERS: [&str; 3] =
    ["docs/explanation/building.md", "docs/explanation/fuzzing.md", "docs/reference/reading.md"];

/// README, CONTRIBUTING and all pages for users.
fn for_users() -> Vec<String> {
    let pages = crate::recipes::pages().into_iter().map(|page| format!("docs/{page}"));
    let all = ["README.md", "CONTRIBUTING.md"].map(str::to_owned).into_iter().chain(pages);
    all.filter(|page| !FOR_DEVELOPERS.contains(&page.as_str())).collect()
}

/// A phrase of our own, and what to write instead.
const OURS: [(&str, &str); 14] = [
    (r"\b(laid|laying) (on|down)\b", "printed, printed in mid-air"),
    (r"\bhold (\S+ )+against\b|\bheld (\S+ )?against\b", "compare with, check"),
    (r"\bis out of\b [^r]", "must be between"),
    (r"\bwould do\b", "use .., is enough"),
    (r"\bis none of\b", "is not a .., not found"),
    (r"\btake (it |them |the \S+ )?(out|away)\b", "remove"),
    (r"\bso many\b", "N, the K best"),
    (r"\b(is|are) told\b", "is reported, is shown"),
    (r"\bhaste\b|\bmind\b", "speed, check"),
    (r"\bgone (back )?to\b|\bbrought\b", "moved to, returned to"),
    (r"\bwhat (hangs|is held)\b", "overhangs, supported areas"),
    (r"\bnobody\b", "is unknown"),
    (r"\bno such [^p]", "not found"),
    (r"\bgoes on\b|\bgo on\b", "continues"),
];

fn lines_of_prose(text: &str) -> Vec<String> {
    let mut prose = Vec::new();
    let mut paragraph = String::new();
    let mut is_code = false;
    for line in text.lines() {
        if line.starts_with("```") {
            is_code = !is_code;
        }
        let is_prose = !is_code && !line.starts_with(['|', '#', '!']) && !line.starts_with("```");
        let begins = line.starts_with("- ") || line.trim().is_empty() || !is_prose;
        if begins && !paragraph.is_empty() {
            prose.push(std::mem::take(&mut paragraph));
        }
        if is_prose && !line.trim().is_empty() {
            paragraph += &format!(" {}", line.trim_start_matches("- ").trim());
        }
    }
    prose.extend(Some(paragraph).filter(|left| !left.is_empty()));
    prose
}

fn sentences(text: &str) -> Vec<String> {
    let end = Regex::new(r"[.!?](\s|$)").unwrap();
    let whole = lines_of_prose(text);
    let split = whole.iter().flat_map(|paragraph| {
        let mut from = 0;
        let mut found = Vec::new();
        for cut in end.find_iter(paragraph) {
            found.push(paragraph[from..cut.end()].trim().to_owned());
            from = cut.end();
        }
        found.push(paragraph[from..].trim().to_owned());
        found
    });
    split.filter(|sentence| !sentence.is_empty()).collect()
}

fn words(sentence: &str) -> usize {
    sentence.split_whitespace().filter(|word| word.chars().any(char::is_alphanumeric)).count()
}

#[test]
fn pages_have_short_sentences() {
    let mut long = Vec::new();
    for page in for_users() {
        // A list, of the sources.
        if page.ends_with("/messages.md") {
            continue;
        }
        let all = sentences(&std::fs::read_to_string(root().join(&page)).unwrap());
        let counts: Vec<usize> = all.iter().map(|sentence| words(sentence)).collect();
        let mean = counts.iter().sum::<usize>() as f64 / counts.len().max(1) as f64;
        if mean > 18.0 {
            long.push(format!("{page}: {mean:.1} words on the mean"));
        }
        let over = all.iter().zip(&counts).filter(|(_, count)| **count > 35);
        long.extend(over.map(|(sentence, count)| format!("{page}: {count} words: {sentence}")));
    }
    assert_eq!(long, Vec::<String>::new());
    let readme = std::fs::read_to_string(root().join("README.md")).unwrap();
    assert!(readme.split_whitespace().count() < 600, "{} words", readme.split_whitespace().count());
}

/// In all pages for users, in every message and in the help of every verb.
#[test]
fn no_word_is_ours_alone() {
    let ours: Vec<(Regex, &str)> = OURS.iter().map(|(ours, better)| (Regex::new(ours).unwrap(), *better)).collect();
    let mut found = Vec::new();
    for page in for_users() {
        let text = std::fs::read_to_string(root().join(&page)).unwrap();
        for line in text.lines() {
            let found_in = |(pattern, _): &&(Regex, &str)| pattern.is_match(&line.to_lowercase());
            found.extend(ours.iter().filter(found_in).map(|(_, better)| format!("{page}: {line} ({better})")));
        }
    }
    assert_eq!(found, Vec::<String>::new());
}

/// `docs/reference/command-line.md` is what `--help` prints. UPDATE_FIXTURES=1 writes it anew.
#[test]
fn the_command_line_is_documented_as_it_is() {
    let help = |words: &[&str]| {
        let out = trunnion().args(words).arg("--help").output().unwrap();
        assert!(out.status.success(), "{words:?}");
        let text = String::from_utf8(out.stdout).unwrap();
        text.lines().map(str::trim_end).collect::<Vec<_>>().join("\n")
    };
    let listed = |text: &str| -> Vec<String> {
        let commands = text.split("Commands:\n").nth(1).unwrap().split("\n\n").next().unwrap();
        let names = commands.lines().filter(|line| line.starts_with("  ") && !line.starts_with("   "));
        names
            .filter_map(|line| line.split_whitespace().next().map(str::to_owned))
            .filter(|name| name != "help")
            .collect()
    };
    let top = help(&[]);
    let mut page =
        format!("# Command line\n\nThis is what `--help` prints.\n\n## trunnion\n\n```text\n{}\n```\n", top.trim());
    for verb in listed(&top) {
        let text = help(&[&verb]);
        page += &format!("\n## trunnion {verb}\n\n```text\n{}\n```\n", text.trim());
        if text.contains("Commands:\n") {
            for inner in listed(&text) {
                let text = help(&[&verb, &inner]);
                page += &format!("\n### trunnion {verb} {inner}\n\n```text\n{}\n```\n", text.trim());
            }
        }
    }
    is_kept("docs/reference/command-line.md", &page);
}
