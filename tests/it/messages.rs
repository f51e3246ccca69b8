//! The list of all messages (`docs/reference/messages.md`) is made of the sources: each case's code, what its documentation says of it, and
//! its sentence. UPDATE_FIXTURES=1 writes it anew: read the difference before it is committed, since codes are promised to scripts.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use regex_lite::Regex;

use crate::support::{folder, is_kept, root, said, trunnion};

/// What is said of a code.
#[derive(Default)]
struct Entry {
    meaning: String,
    says: Vec<String>,
}

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    let mut entries: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    entries.sort();
    for path in entries {
        match path.is_dir() {
            true => sources(&path, found),
            false if path.extension().is_some_and(|end| end == "rs") => found.push(path),
            false => {}
        }
    }
}

/// `NotAFile` as `not-a-file`.
fn kebab(name: &str) -> String {
    let mut out = String::new();
    for (place, letter) in name.char_indices() {
        if letter.is_ascii_uppercase() && place > 0 {
            out.push('-');
        }
        out.push(letter.to_ascii_lowercase());
    }
    out
}

/// A variant: its name, what its documentation says, and its sentence.
type Variant = (String, String, Option<String>);

/// The variants of the body of an enum, as it stands in its file.
fn variants(body: &str) -> Vec<Variant> {
    let literal = Regex::new(r#"(?s)"((?:[^"\\]|\\.)*)""#).unwrap();
    let (mut all, mut doc, mut attribute, mut open) = (Vec::new(), Vec::new(), String::new(), false);
    for line in body.lines() {
        let Some(inner) = line.strip_prefix("    ").filter(|_| !line.starts_with("        ") || open) else { continue };
        if open {
            attribute += line;
            attribute.push('\n');
            open = !(line == "    )]" || (line.starts_with("    #[") && line.ends_with(")]")));
        } else if let Some(text) = inner.strip_prefix("/// ") {
            doc.push(text.to_owned());
        } else if inner.starts_with("#[error(") {
            attribute = format!("{line}\n");
            open = !line.ends_with(")]");
        } else if inner.starts_with(|letter: char| letter.is_ascii_uppercase()) {
            let name: String = inner.chars().take_while(char::is_ascii_alphanumeric).collect();
            let says = literal.captures(&attribute).map(|found| {
                let joined = Regex::new(r"\\\n\s*").unwrap().replace_all(&found[1], "").into_owned();
                joined.replace("\\\"", "\"")
            });
            all.push((name, doc.join(" "), says));
            doc.clear();
            attribute.clear();
        }
    }
    all
}

/// All of them, by code.
fn messages() -> BTreeMap<String, Entry> {
    let mut files = Vec::new();
    sources(&root().join("src"), &mut files);
    let coded = Regex::new(
        r#"(?s)#\[strum\(serialize_all = "kebab-case", prefix = "([a-z-]+/)"\)\]\n(?:#\[[^\n]*\]\n)*pub enum \w+ \{\n(.*?)\n\}\n"#,
    )
    .unwrap();
    let own = Regex::new(r"(?s)pub(?:\(crate\))? enum (\w+) \{\n(.*?)\n\}\n").unwrap();
    let arm = Regex::new(r#"((?:\|?\s*Self::\w+(?:\([^)]*\)| \{[^}]*\})?\s*)+)=> "([a-z-]+/[a-z-]+)""#).unwrap();
    let variant = Regex::new(r"Self::(\w+)").unwrap();
    let rules = Regex::new(r"(?s)pub enum Rule \{\n(.*?)\n\}\n").unwrap();
    let mut all: BTreeMap<String, Entry> = BTreeMap::new();
    let mut add = |code: String, (_, meaning, says): &Variant| {
        let entry = all.entry(code).or_default();
        if entry.meaning.is_empty() {
            entry.meaning.clone_from(meaning);
        }
        entry.says.extend(says.iter().filter(|text| *text != "{0}").cloned());
    };
    for file in files {
        let text = std::fs::read_to_string(&file).unwrap();
        for found in coded.captures_iter(&text) {
            for one in variants(&found[2]).iter().filter(|one| one.2.is_some()) {
                add(format!("{}{}", &found[1], kebab(&one.0)), one);
            }
        }
        if text.contains("fn code(&self) -> &'static str") && !text.contains("prefix = \"") {
            let of: Vec<Variant> = own.captures_iter(&text).flat_map(|found| variants(&found[2])).collect();
            for found in arm.captures_iter(&text) {
                for name in variant.captures_iter(&found[1]) {
                    let one = of.iter().find(|one| one.0 == name[1]);
                    one.into_iter().for_each(|one| add(found[2].to_owned(), one));
                }
            }
        }
        if file.ends_with("verify/report.rs") {
            let found = rules.captures(&text).expect("the rules");
            variants(&found[1]).iter().for_each(|one| add(format!("verify/{}", kebab(&one.0)), one));
        }
    }
    for (code, meaning) in [
        ("command/usage", "Words on the command line that mean nothing, or do not go together."),
        (
            "verify/findings",
            "What was to be written breaks rules of `verify`: each finding has its own, and `verify/` before it is its code.",
        ),
    ] {
        all.entry(code.to_owned()).or_default().meaning = meaning.to_owned();
    }
    all
}

const HEAD: &str = "# Messages

Every failure has a code, which stays as it is, and a sentence, which may be said better some day. JSON documents have both (`code`, `error`);
scripts ask for the code. `trunnion explain CODE` says what is here. This list is made of the sources by a test.
";

#[test]
fn the_list_of_messages_is_that_of_the_sources() {
    let mut made = HEAD.to_owned();
    for (code, Entry { meaning, says }) in messages() {
        assert!(!meaning.is_empty(), "{code} is not documented");
        let _ = write!(made, "\n## {code}\n\n{meaning}\n");
        if !says.is_empty() {
            made.push('\n');
        }
        says.iter().for_each(|text| _ = writeln!(made, "> {}", text.replace('\n', " ")));
    }
    is_kept("docs/reference/messages.md", &made);
}

/// A stranger's first mistakes: each has a code that is explained.
#[test]
fn first_mistakes_have_codes_that_are_explained() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name).display().to_string();
    let cube = crate::pipeline::fixture("cube");
    let caged = crate::pipeline::fixture("caged");
    std::fs::write(at("bad.toml"), "[machine]\nnam = 3\n").unwrap();
    std::fs::write(at("open.off"), "OFF\n4 2 0\n0 0 0\n20 0 0\n0 20 0\n20 20 9\n3 0 1 2\n3 1 3 2\n").unwrap();
    std::fs::create_dir(at("empty")).unwrap();
    std::fs::write(at("part.step"), "ISO-10303-21;\n").unwrap();
    let [out, bad, open, step, gone, empty] =
        ["out.gcode", "bad.toml", "open.off", "part.step", "gone.stl", "empty"].map(at);
    let cases: [(&[&str], i32, &str); 11] = [
        (&["prepare", &gone, "-m", "generic-ac", "-o", &out], 2, "input/absent"),
        (&["prepare", &cube, "-m", "open5", "-o", &out], 2, "profile/no-such-profile"),
        (&["prepare", &cube, "-m", &bad, "-o", &out], 2, "profile/"),
        (&["prepare", &cube], 2, "command/usage"),
        (&["prepare", &cube, "-m", "generic-ac", "-o", &out, "--wya", "cut"], 2, "command/usage"),
        (&["prepare", &open, "-m", "generic-ac", "-o", &out], 2, "mesh/open"),
        (&["prepare", &step, "-m", "generic-ac", "-o", &out], 2, "mesh/"),
        (&["prepare", &empty, "-m", "generic-ac", "-o", &out], 2, "job/no-models"),
        (&["plan", &caged, "-m", "generic-ac", "--no-remedies"], 1, "plan/no-plan"),
        (&["prepare", &cube, "-m", "generic-ac", "-o", &out, "--way", "cut"], 1, "strategy/no-way"),
        (&["pack", &cube, "--space", "5,5,5"], 2, "pack/no-fit"),
    ];
    for (args, exit, wanted) in cases {
        let done = trunnion().args(args).arg("--json").output().unwrap();
        let document: serde_json::Value = serde_json::from_slice(&done.stdout).unwrap_or_default();
        let code = document["code"].as_str().unwrap_or_default();
        assert!(done.status.code() == Some(exit) && code.starts_with(wanted), "{args:?}: {code:?}, {}", said(&done));
        if !code.is_empty() {
            let explained = trunnion().args(["explain", code]).output().unwrap();
            assert!(explained.status.success(), "{code}: {}", said(&explained));
        }
    }
    let nearest = trunnion().args(["explain", "mesh/opn"]).output().unwrap();
    assert!(nearest.status.code() == Some(2) && said(&nearest).contains("mesh/open"), "{}", said(&nearest));
}
