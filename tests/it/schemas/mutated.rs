//! What is let pass: documents with one thing changed, each of which must be seen; and another program's verdict of the same.

use std::io::Write;
use std::process::Stdio;

use serde_json::{Value, json};

use super::every::made;
use super::schemas;
use crate::support::{python, root, said, skip};

/// Keys whose values are the user's own words or open lists, where one more or fewer is no mistake.
const OPEN: [&str; 1] = ["counts"];

/// All places in `document`, as JSON pointers.
fn places(document: &Value, at: &str, all: &mut Vec<String>) {
    all.push(at.to_owned());
    match document {
        Value::Object(map) => map.iter().for_each(|(key, one)| places(one, &format!("{at}/{key}"), all)),
        // Elements are alike: the first says all.
        Value::Array(list) => list.iter().take(1).for_each(|one| places(one, &format!("{at}/0"), all)),
        _ => {}
    }
}

/// `document` with one thing changed at `at`, by what that is.
fn mutants(document: &Value, at: &str, required: bool) -> Vec<(&'static str, Value)> {
    let with = |change: &dyn Fn(&mut Value)| {
        let mut changed = document.clone();
        change(changed.pointer_mut(at).unwrap());
        changed
    };
    let open = OPEN.iter().any(|key| at.ends_with(&format!("/{key}")));
    let mut all = match document.pointer(at).unwrap() {
        Value::Object(_) if open => vec![("another key", with(&|v| v["no-such-rule"] = json!(1)))],
        Value::Object(_) => vec![("another key", with(&|v| v["unheard_of"] = json!(1)))],
        Value::Array(_) => vec![("a number for a list", with(&|v| *v = json!(1)))],
        Value::String(_) => vec![("a number for words", with(&|v| *v = json!(7)))],
        Value::Number(_) => vec![("words for a number", with(&|v| *v = json!("7")))],
        Value::Bool(_) => vec![("a number for yes or no", with(&|v| *v = json!(1)))],
        Value::Null => vec![("a list for nothing", with(&|v| *v = json!([[]])))],
    };
    let (above, key) = at.rsplit_once('/').unwrap_or(("", ""));
    if let Some(Value::Object(_)) =
        document.pointer(above).filter(|_| required && !key.is_empty() && !at.contains("/counts/"))
    {
        let mut changed = document.clone();
        let inside = changed.pointer_mut(above).unwrap().as_object_mut().unwrap();
        let value = inside.remove(key).unwrap();
        all.push(("a key less", changed.clone()));
        changed.pointer_mut(above).unwrap().as_object_mut().unwrap().insert(format!("{key}s"), value);
        all.push(("a key renamed", changed));
    }
    all
}

/// Whether the document is one without this key too: then it is optional.
fn is_optional(at: &str) -> bool {
    const OPTIONAL: [&str; 18] = [
        "ups",
        "bridge_mm",
        "machine_values",
        "alternatives",
        "arranged",
        "three_axis",
        "supports",
        "compare",
        "unproved",
        "best_finer",
        "recommended",
        "reasons",
        "as_it_lies",
        "own",
        "process",
        "port",
        "value",
        "value_upper_bound",
    ];
    const IN_PROFILES: [&str; 25] = [
        "measured",
        "jogged",
        "jogged_as",
        "along",
        "min_deg",
        "max_deg",
        "size_mm",
        "bare_cone",
        "z_mm",
        "r_mm",
        "min_mm",
        "max_mm",
        "park_mm",
        "prime_mm",
        "before_turn",
        "after_turn",
        "joint",
        "price",
        "mm_per_s",
        "fan",
        "stepper",
        "turns",
        "from_tip_mm",
        "holding_nm",
        "max_turns",
    ];
    let key = at.rsplit('/').next().unwrap();
    // Of a plan's supports; the figures of those that were laid always have it.
    let in_plan = key == "brace_mm" && at.contains("/prints/");
    let of_a_goal = ["/height_mm", "/height_lower_bound_mm", "/inflated"].contains(&at);
    of_a_goal || OPTIONAL.contains(&key) || IN_PROFILES.contains(&key) || key == "points_mm" || in_plan
}

/// File, what was done, where, document.
type Changed = (&'static str, &'static str, String, Value);

/// Every document of `made` with every change.
fn changed() -> Vec<Changed> {
    let mut all = Vec::new();
    for (file, document) in made() {
        let mut at = Vec::new();
        places(document, "", &mut at);
        for at in at {
            let mutants = mutants(document, &at, !is_optional(&at));
            all.extend(mutants.into_iter().map(|(what, value)| (file.as_str(), what, at.clone(), value)));
        }
    }
    all
}

/// One after the other, since all need every document.
#[test]
fn what_is_changed_in_a_document_is_seen_and_another_program_says_the_same() {
    let all = changed();
    a_key_dropped_renamed_or_added_and_a_value_of_another_type_are_seen(&all);
    numbers_beyond_what_they_can_be_are_seen();
    another_program_says_the_same(&all);
}

fn a_key_dropped_renamed_or_added_and_a_value_of_another_type_are_seen(all: &[Changed]) {
    let passed = all.iter().filter(|(file, _, _, value)| schemas().faults(file, value).is_empty());
    let passed: Vec<String> = passed.map(|(file, what, at, _)| format!("{file}: {what} at {at}")).collect();
    assert!(passed.is_empty(), "{} of {} changes pass: {}", passed.len(), all.len(), passed.join("; "));
    assert!(all.len() > 3000, "{}", all.len());
}

/// Values that no document has: a direction that is none, a share above 1, a negative length, seconds in milliseconds' place are numbers
/// still, and only ranges tell.
fn numbers_beyond_what_they_can_be_are_seen() {
    let wrong = [
        ("verify.json", "/filament_mm", json!(-1)),
        ("verify.json", "/clearance_mm", json!(50.1)),
        ("verify.json", "/moves", json!(1.5)),
        ("prepare.json", "/verify/clearance_at/share", json!(1.01)),
        ("plan-file.json", "/slots/0/prints/0/up/2", json!(1.1)),
        ("plan-file.json", "/version", json!(5)),
        ("plan-file.json", "/model/sha256", json!("ab")),
        ("certificate.json", "/program/sha256", json!("0")),
        ("certificate.json", "/rules/9/rule", json!("in-the-air")),
        ("plan.json", "/lower_bound", json!(null)),
        ("inspect.json", "/unit", json!("inch")),
        ("inspect.json", "/parts/0/box_mm/0", json!([0, 0])),
        ("send.json", "/share", json!(-0.1)),
        ("profile-show.json", "/process/infill", json!(20)),
        ("profile-show.json", "/kinematics/tilt/max_deg", json!(181)),
        ("profile-show.json", "/link/baud", json!(115_200.5)),
        ("batch.json", "/key", json!("0")),
        ("publish.json", "/server", json!("klipper")),
        ("slice.json", "/bed_mm/0", json!(0)),
        ("pack.json", "/plates/0/fill", json!(-1)),
        ("orient.json", "/parts/0/results/0/minima/0/alpha_deg", json!(361)),
    ];
    for (file, at, value) in wrong {
        let has = |(of, document): &&(String, Value)| of == file && document.pointer(at).is_some();
        let (_, document) = made().iter().find(has).unwrap_or_else(|| panic!("no document of {file} has {at}"));
        let mut changed = document.clone();
        *changed.pointer_mut(at).unwrap() = value.clone();
        assert_eq!(schemas().faults(file, document), Vec::<String>::new());
        assert!(!schemas().faults(file, &changed).is_empty(), "{file}: {at} = {value} passes");
    }
}

/// Our checker's verdicts against the `jsonschema` package's, over all documents and every seventh change.
fn another_program_says_the_same(changed: &[Changed]) {
    let local = root().join(".venv/bin/python").display().to_string();
    let Some(python) = python(&[&local, "python3", "python"], "jsonschema") else {
        skip("Python's jsonschema is not installed: our schemas and their checker have no second witness");
        return;
    };
    let whole = made().iter().map(|(file, document)| (file.as_str(), document));
    let broken = changed.iter().step_by(7).map(|(file, _, _, document)| (*file, document));
    let all: Vec<(&str, &Value)> = whole.chain(broken).collect();
    let mut child = std::process::Command::new(python)
        .arg(root().join("tests/harness/check_documents.py"))
        .arg(root().join("docs/schemas"))
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let text: String = all.iter().map(|one| format!("{}\n", json!(one))).collect();
    let mut stdin = child.stdin.take().unwrap();
    let written = std::thread::spawn(move || stdin.write_all(text.as_bytes()));
    let run = child.wait_with_output().unwrap();
    assert!(run.status.success(), "{}", said(&run));
    written.join().unwrap().unwrap();
    let verdicts = String::from_utf8(run.stdout).unwrap();
    let verdicts: Vec<&str> = verdicts.lines().collect();
    assert_eq!(verdicts.len(), all.len());
    for ((file, document), verdict) in all.iter().zip(&verdicts) {
        let ours = schemas().faults(file, document);
        assert_eq!(
            ours.is_empty(),
            *verdict == "valid",
            "{file}: {verdict} there, {ours:?} here: {:.400}",
            document.to_string()
        );
    }
}
