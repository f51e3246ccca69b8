//! A stranger's first mistakes: each gets its code, what is wrong, and what helps, in at most three lines, and leaves no file. And what the
//! command does by itself, so that fewer can be made.

use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::pipeline::fixture;
use crate::support::{error_in, fails, folder as new_folder, said, trunnion};

/// What is typed, the code, and what has to be in the words that answer.
const MISTAKES: [(&str, &str, &str); 22] = [
    ("prepre a.stl", "command/usage", "'prepare'"),
    ("prepare a.stl --machin generic-ac", "command/usage", "'--machine'"),
    ("prepare a.stl -m generic-ac --way uncut -o x.gcode", "command/usage", "turned-supports"),
    ("prepare a.slt -m generic-ac", "input/absent", "a.stl"),
    ("prepare a.stl -m generic-ca", "profile/no-such-profile", "generic-ac"),
    ("prepare a.stl -m open5x", "profile/no-such-profile", "open5x-prusa"),
    ("prepare a.stl -m prusa", "profile/no-such-profile", "open5x-prusa"),
    ("prepare a.stl -m voron0", "profile/no-such-profile", "open5x-voron0"),
    ("prepare a.stl -m bad.tml", "input/absent", "bad.toml"),
    ("prepare a.stl -m bad.toml", "profile/unknown-key", "process.layer_height_mm"),
    ("prepare a.stl", "command/usage", "profile list"),
    ("plan a.stl", "command/usage", "profile new"),
    ("prepare generic-ac -m a.stl", "input/absent", "generic-ac"),
    ("prepare a.stl -m b.stl", "profile/no-such-profile", "TOML"),
    ("prepare nothing -m generic-ac -o x.gcode", "job/no-models", "no models found"),
    ("prepare https://example.org/a.stl -m generic-ac", "input/address", "download"),
    ("prepare part.step -m generic-ac", "mesh/surfaces", "export"),
    ("prepare made.gcode -m generic-ac -o x.gcode", "mesh/program", "model itself"),
    ("prepare a.stl -m generic-ac --up z", "command/usage", "0,0,1"),
    ("prepare a.stl -m generic-ac --unit inch", "command/usage", "um, mm, cm, in, ft or m"),
    ("verify plan.json --plan made.gcode", "plan-file/syntax", "not a plan"),
    ("orient", "command/usage", "MODEL"),
];

fn prepared(folder: &Path) {
    let at = |name: &str| folder.join(name);
    fs::copy(fixture("cube"), at("a.stl")).unwrap();
    fs::copy(fixture("two-boxes"), at("b.stl")).unwrap();
    fs::write(at("part.step"), "ISO-10303-21;\nHEADER;\n").unwrap();
    fs::write(at("bad.toml"), "extends = \"generic-ac\"\nlayer_height_mm = 0.3\n").unwrap();
    fs::create_dir(at("nothing")).unwrap();
    let made = ["prepare", "a.stl", "-m", "generic-ac", "--slicer", "builtin", "-q", "-o", "made.gcode", "--plan-out"];
    let run = trunnion().current_dir(folder).args(made).arg("plan.json").output().unwrap();
    assert!(run.status.success(), "{}", said(&run));
    let run =
        trunnion().current_dir(folder).args(["plan", "b.stl", "-m", "generic-ac", "-q", "-o", "other.json"]).output();
    assert!(run.unwrap().status.success());
}

fn names(folder: &Path) -> Vec<String> {
    let mut all: Vec<String> =
        fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().to_string_lossy().into_owned()).collect();
    all.sort();
    all
}

#[test]
fn a_strangers_first_mistakes_are_answered_in_three_lines() {
    let folder = new_folder();
    let here = folder.path();
    prepared(here);
    let before = names(here);
    let mut wrong = Vec::new();
    for (typed, code, helps) in MISTAKES {
        let words: Vec<&str> = typed.split(' ').collect();
        let run = trunnion().current_dir(here).args(&words).output().unwrap();
        let text = String::from_utf8_lossy(&run.stderr).into_owned();
        // What is read first says what it is, before a mistake that comes after it.
        let answer: Vec<&str> = text.lines().skip_while(|line| error_in(line).is_none()).collect();
        let document = trunnion().current_dir(here).args(&words).arg("--json").output().unwrap();
        let document: Value = serde_json::from_slice(&document.stdout).unwrap_or_default();
        let exits = run.status.code() == Some(2) && document["exit"] == 2;
        if !exits || document["code"] != code || !text.contains(helps) || !(1..=3).contains(&answer.len()) {
            wrong.push(format!("{typed}\n  {:?} {} {}\n{text}", run.status.code(), document["code"], document["exit"]));
        }
    }
    // The wrong plan: one sentence, and the findings for whoever asks.
    let verify = ["verify", "made.gcode", "--plan", "other.json"];
    let run = trunnion().current_dir(here).args(verify).output().unwrap();
    assert!(run.status.code() == Some(1) && run.stdout.is_empty(), "{}", said(&run));
    let text = String::from_utf8_lossy(&run.stderr).into_owned();
    assert!(text.lines().count() == 1 && fails(&text, "command/no: made.gcode | hash | --json"), "{text}");
    let document = trunnion().current_dir(here).args(verify).arg("--json").output().unwrap();
    let document: Value = serde_json::from_slice(&document.stdout).unwrap();
    assert!(!document["findings"].as_array().unwrap().is_empty());
    assert!(wrong.is_empty(), "{} of {}:\n{}", wrong.len(), MISTAKES.len(), wrong.join("\n"));
    assert_eq!(names(here), before, "something was left behind");
}

/// What is typed, the place that the document names (file, line, column, word), and the line that is shown with what is under it.
const PLACES: [(&str, &str, &str); 8] = [
    ("profile check range.toml", r#"["range.toml", 4, null, "-900"]"#, "4 | min_deg = -900\n  |           ^^^^"),
    (
        "profile check bad.toml",
        r#"["bad.toml", 2, null, "layer_height_mm"]"#,
        "2 | layer_height_mm = 0.3\n  | ^^^^^^^^^^^^^^^",
    ),
    (
        "profile check type.toml",
        r#"["type.toml", 3, null, "protocol"]"#,
        "3 | protocol = 5 # of the link\n  | ^^^^^^^^",
    ),
    ("prepare a.stl -m torn.toml", r#"["torn.toml", 2, null, null]"#, "2 | [kinematics.tilt\n  | ^^^^^^^^^^^^^^^^"),
    ("profile check code.toml", r#"["code.toml", 3, null, "G29"]"#, "5 | G29\n  | ^^^"),
    // What another file says is not for whoever may name it in a profile.
    ("profile check extends.toml", r#"["secret.toml", 1, null, null]"#, ""),
    ("verify made.gcode --plan typo.json", r#"["typo.json", 5, 3, null]"#, "5 |   \"modell\": {\n  |   ^^^^^^^^"),
    (
        "rewrite print-00.gcode --plan plan.json -o x.gcode",
        r#"["print-00.gcode", 2, 8, null]"#,
        "2 | G1 X10 $Y5\n  |        ^",
    ),
];

#[test]
fn the_place_of_a_mistake_is_in_the_document_and_its_line_is_shown() {
    let folder = new_folder();
    let here = folder.path();
    prepared(here);
    let lay = |name: &str, text: &str| fs::write(here.join(name), text).unwrap();
    lay("range.toml", "extends = \"generic-ac\"\n\n[kinematics.tilt]\nmin_deg = -900\n");
    lay("type.toml", "extends = \"generic-ac\"\n[link]\nprotocol = 5 # of the link\n");
    lay("torn.toml", "extends = \"generic-ac\"\n[kinematics.tilt\nmin_deg = -9\n");
    lay("code.toml", "extends = \"generic-ac\"\n[dialect]\nstart = \"\"\"\nG28\nG29\n\"\"\"\n");
    lay("extends.toml", "extends = \"secret.toml\"\n");
    lay("secret.toml", "password hunter2\n");
    lay("print-00.gcode", "G1 X1\nG1 X10 $Y5\n");
    let plan = fs::read_to_string(here.join("plan.json")).unwrap();
    let typo = plan.replacen("\"model\":", "\"modell\":", 1);
    assert_ne!(plan, typo);
    lay("typo.json", &typo);
    let mut wrong = Vec::new();
    for (typed, place, shown) in PLACES {
        let words: Vec<&str> = typed.split(' ').collect();
        let run = trunnion().current_dir(here).args(&words).output().unwrap();
        let text = String::from_utf8_lossy(&run.stderr).into_owned();
        let run = trunnion().current_dir(here).args(&words).arg("--json").output().unwrap();
        let document: Value = serde_json::from_slice(&run.stdout).unwrap_or_default();
        let at = &document["place"];
        let found = serde_json::to_string(&[&at["file"], &at["line"], &at["column"], &at["word"]]).unwrap();
        let answer: Vec<&str> = text.lines().skip_while(|line| error_in(line).is_none()).collect();
        let fits = if shown.is_empty() { answer.len() == 1 } else { answer.len() == 3 && text.contains(shown) };
        if found.replace(',', ", ") != place || !fits || text.contains("hunter2") {
            wrong.push(format!("{typed}\n{found}\n{text}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// -h shows what is used every day on one screen; --help shows every flag, under headings.
#[test]
fn help_has_a_short_form_and_a_long_one() {
    let help = |words: &[&str]| {
        let run = trunnion().args(words).env("COLUMNS", "100").output().unwrap();
        assert!(run.status.success() && run.stderr.is_empty(), "{}", said(&run));
        String::from_utf8(run.stdout).unwrap()
    };
    let (short, long) = (help(&["prepare", "-h"]), help(&["prepare", "--help"]));
    assert!(short.lines().count() <= 40, "{} lines:\n{short}", short.lines().count());
    for verb in ["plan", "split", "orient", "verify", "send", "preview"] {
        let text = help(&[verb, "-h"]);
        assert!(text.lines().count() <= 60, "{verb}: {} lines:\n{text}", text.lines().count());
    }
    for heading in ["Model", "Machine", "Planning", "Slicing", "Supports", "Output", "Printing", "General"] {
        assert!(long.lines().any(|line| line == format!("{heading}:")), "{heading} is no heading:\n{long}");
    }
    // A heading is that of its own flags alone.
    let under = |text: &str, heading: &str| -> Vec<String> {
        let rest = text.lines().skip_while(|line| *line != format!("{heading}:")).skip(1);
        let flags = rest.take_while(|line| line.is_empty() || line.starts_with(' ')).filter(|line| line.contains("--"));
        let flag = |line: &str| line.split_whitespace().find(|word| word.starts_with("--")).map(str::to_owned);
        flags.filter_map(flag).collect()
    };
    for verb in ["prepare", "plan", "split"] {
        assert_eq!(under(&help(&[verb, "-h"]), "Machine"), ["--machine"], "{verb}");
    }
    for flag in ["--machine", "--output", "--preview", "--port", "--json"] {
        assert!(short.contains(flag), "{flag}:\n{short}");
    }
    for flag in ["--margin", "--repair", "--brace", "--jobs", "--slicer-timeout", "--tolerate"] {
        assert!(!short.contains(flag) && long.contains(flag), "{flag}");
    }
}

/// The machine may stand in the environment, and the file beside the model; what somebody else made there stays.
#[test]
fn what_is_not_named_has_a_place_of_its_own() {
    let folder = new_folder();
    let here = folder.path();
    fs::copy(fixture("cube"), here.join("cube.stl")).unwrap();
    let run = |more: &[&str]| {
        let mut run = trunnion();
        run.current_dir(here)
            .env("TRUNNION_MACHINE", "generic-ac")
            .args(["prepare", "cube.stl", "--slicer", "builtin"]);
        run.args(more).output().unwrap()
    };
    let mut empty = trunnion();
    empty.current_dir(here).env("TRUNNION_MACHINE", "").args(["prepare", "cube.stl"]);
    let empty = empty.output().unwrap();
    let told = String::from_utf8_lossy(&empty.stderr).into_owned();
    assert!(empty.status.code() == Some(2) && told.contains("--machine") && !told.contains("\"\""), "{told}");
    let first = run(&[]);
    assert!(first.status.success(), "{}", said(&first));
    let made = fs::read(here.join("cube.gcode")).unwrap();
    // Its own file is made anew, and -m goes before the environment.
    let again = run(&["-m", "trident-5-axis"]);
    assert!(again.status.success(), "{}", said(&again));
    assert_ne!(fs::read(here.join("cube.gcode")).unwrap(), made);
    fs::write(here.join("cube.gcode"), "; of a slicer\nG28\n").unwrap();
    let refused = run(&[]);
    assert_eq!(refused.status.code(), Some(2), "{}", said(&refused));
    assert!(String::from_utf8_lossy(&refused.stderr).contains("-o"), "{}", said(&refused));
    assert_eq!(fs::read_to_string(here.join("cube.gcode")).unwrap(), "; of a slicer\nG28\n");
    assert!(run(&["-o", "cube.gcode"]).status.success(), "whoever names it has it replaced");
    assert_eq!(names(here), ["cube.gcode", "cube.stl"]);
}
