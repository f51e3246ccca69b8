//! A batch of which any call fails, its own or those of the processes of its models: what it says is so, and the next run does the rest.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::calls::{Ended, Fault, faults, harmed, unharmed};
use crate::pipeline::fixture;
use crate::support::{folder, installed, note, skip};

/// The files below, by name, their seconds set to nothing. Those without a byte that a killed process was about to write are none: an hour
/// later they go.
fn below(folder: &Path, into: &mut BTreeMap<String, Vec<u8>>) {
    for entry in std::fs::read_dir(folder).into_iter().flatten().map(Result::unwrap) {
        let (path, name) = (entry.path(), entry.file_name().to_string_lossy().into_owned());
        if path.is_dir() {
            below(&path, into);
        } else {
            let bytes = std::fs::read(&path).unwrap();
            if !(bytes.is_empty() && (name.ends_with(".writing") || name == "owned")) {
                into.insert(name, timeless(&bytes));
            }
        }
    }
}

fn timeless(bytes: &[u8]) -> Vec<u8> {
    let text = String::from_utf8_lossy(bytes);
    let seconds =
        regex_lite::Regex::new(r#""(\w*seconds|read|orient|plan|slice|rewrite|verify)": ?[0-9.e-]+"#).unwrap();
    seconds.replace_all(&text, "\"$1\":0").into_owned().into_bytes()
}

fn files(at: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    below(at, &mut found);
    found
}

/// What the lines of a batch say is what is in its folder.
fn says_what_is_there(done: &Ended, out: &BTreeMap<String, Vec<u8>>, what: &str) {
    let lines = done.documents();
    let models: Vec<_> = lines.iter().filter(|line| line["event"] == "model").collect();
    for line in &models {
        let (status, key) = (line["status"].as_str().unwrap(), line["key"].as_str().unwrap_or("none"));
        let there = out.contains_key(&format!("{key}.json"));
        assert_eq!(status == "done", there, "{what}: {line}");
        assert!(status == "done" || line["error"].as_str().is_some_and(|text| !text.is_empty()), "{what}: {line}");
    }
    let Some(last) = lines.iter().find(|line| line["event"] == "done") else {
        return assert!(done.says_why(), "{what}");
    };
    if models.len() == 3 {
        let counted = |status: &str| models.iter().filter(|line| line["status"] == status).count() as u64;
        let counts = [&last["done"], &last["failed"]].map(|count| count.as_u64().unwrap());
        assert_eq!(counts, [counted("done"), counted("failed")], "{what}");
    }
}

fn survives(words: &[&str], step: usize) {
    if !cfg!(target_os = "linux") || !installed("strace") {
        return skip("no strace to make calls fail with");
    }
    let folder = folder();
    let at = |name: &str| -> PathBuf { folder.path().join(name) };
    std::fs::create_dir(at("models")).unwrap();
    let cube = std::fs::read(fixture("cube")).unwrap();
    std::fs::write(at("models/a.stl"), &cube).unwrap();
    std::fs::write(at("models/b.stl"), &cube[..cube.len() - 30]).unwrap();
    std::fs::write(at("models/c.stl"), [b"another header", &cube[14..]].concat()).unwrap();
    let clear = || {
        for name in ["out", "tmp"] {
            let _ = std::fs::remove_dir_all(at(name));
        }
        std::fs::create_dir(at("tmp")).unwrap();
    };
    clear();
    let injected = faults(folder.path(), words, 1, step);
    let clean = files(&at("out"));
    assert!(
        clean.keys().filter(|name| name.ends_with(".json") && !name.contains(".plan.")).count() == 2,
        "{:?}",
        clean.keys()
    );
    let (mut refused, mut killed) = (0, 0);
    for one in &injected {
        clear();
        let done = harmed(folder.path(), words, one);
        let out = files(&at("out"));
        let what = format!("{one:?}: {done:?}");
        for (name, bytes) in out.iter().filter(|(name, _)| !name.ends_with(".writing")) {
            assert!(clean.get(name) == Some(bytes), "{name} is not whole: {what}");
        }
        match (one.fault, done.code) {
            (Fault::Kill, None) => killed += 1,
            (Fault::Error(_), Some(1 | 2)) | (Fault::Kill, Some(1)) => {
                says_what_is_there(&done, &out, &what);
                refused += usize::from(out != clean);
            }
            _ => panic!("{what}"),
        }
        let next = unharmed(folder.path(), words);
        let (again, left) = (files(&at("out")), files(&at("tmp")));
        assert_eq!(next.code, Some(1), "{what}, next {next:?}");
        assert!(again == clean, "{what}, next {next:?}: {:?}", again.keys());
        if !left.is_empty() {
            // What could not be removed goes with the next slicer; where all had been done, none was needed.
            std::fs::remove_dir_all(at("out")).unwrap();
            let sliced = unharmed(folder.path(), words);
            assert!(files(&at("tmp")).is_empty(), "{what}, then {sliced:?}: {:?} are left", left.keys());
        }
    }
    note(&format!("{} of a batch: {} faults, {refused} refused, {killed} kills", words[0], injected.len()));
    assert!(refused > 2 && killed > 2, "{refused} {killed}");
}

#[test]
fn no_fault_of_a_batch_is_kept_or_told_as_another() {
    survives(
        &["orient", "models", "--objective", "height", "--method", "grid", "--json", "-o", "out", "--jobs", "1"],
        5,
    );
}

#[test]
fn no_fault_of_a_batch_leaves_half_a_prepared_file() {
    survives(
        &["prepare", "models", "-m", "generic-ac", "--slicer", "builtin", "--json", "-o", "out", "--jobs", "1"],
        12,
    );
}
