//! `[transition] before_turn` and `after_turn`: the machine's own lines around each turn of the table, in a print, verified, printed on
//! the simulated printer, and in a rehearsal.

use std::path::{Path, PathBuf};

use serde_json::Value;
use trunnion::profile::resolve;

use crate::pipeline::{fixture, prepare};
use crate::support::{coded, fails, folder, said, states, trunnion};

const BRAKE: &str = "extends = \"generic-ac\"\n[machine]\nname = \"braked\"\n[transition]\nbefore_turn = \"\"\"\nM400\nM42 P5 S255\nG4 P200\"\"\"\n\
                     after_turn = \"\"\"\nM400\nM42 P5 S0\"\"\"\n";
const BEFORE: &str = "M400\nM42 P5 S255\nG4 P200\n";
const AFTER: &str = "M400\nM42 P5 S0\n";

fn braked(folder: &Path) -> PathBuf {
    let path = folder.join("braked.toml");
    std::fs::write(&path, BRAKE).unwrap();
    path
}

/// Each run of lines that turn the table, with `before` and `after` characters of the file around it.
fn turns(text: &str) -> Vec<(String, String)> {
    let turn = |line: &str| line.starts_with("G1 A") || line.starts_with("G1 C");
    let lines: Vec<&str> = text.lines().collect();
    let mut all = Vec::new();
    for at in 0..lines.len() {
        if !turn(lines[at]) || turn(lines[at - 1]) {
            continue;
        }
        let end = (at..lines.len()).find(|&i| !turn(lines[i])).unwrap();
        let joined = |lines: &[&str]| lines.iter().map(|line| format!("{line}\n")).collect::<String>();
        all.push((joined(&lines[at - 3..at]), joined(&lines[end..end + 2])));
    }
    all
}

#[test]
fn they_stand_around_every_turn_and_are_printed() {
    let folder = folder();
    let machine = braked(folder.path());
    let (file, plan, dry) =
        (folder.path().join("out.gcode"), folder.path().join("plan.json"), folder.path().join("dry.gcode"));
    let more = ["--plan-out", plan.to_str().unwrap(), "--dry-run", dry.to_str().unwrap()];
    let document = prepare(&fixture("y-tree"), machine.to_str().unwrap(), "builtin", &file, &more);
    assert_eq!(document["verify"]["findings"], Value::Array(Vec::new()));
    for (path, least) in [(&file, 4), (&dry, 3)] {
        let all = turns(&std::fs::read_to_string(path).unwrap());
        assert!(all.len() >= least, "{}: {}", path.display(), all.len());
        assert!(all.iter().all(|(before, after)| before == BEFORE && after == AFTER), "{}: {all:?}", path.display());
    }
    // Without them the file is the one that the plain profile makes.
    let plain = folder.path().join("plain.toml");
    std::fs::write(&plain, BRAKE.split("[transition]").next().unwrap()).unwrap();
    let bare = folder.path().join("bare.gcode");
    prepare(&fixture("y-tree"), plain.to_str().unwrap(), "builtin", &bare, &[]);
    let [with, without] = [&file, &bare].map(|path| std::fs::read_to_string(path).unwrap());
    let moves = |text: &str| text.lines().filter(|l| l.starts_with("G1")).map(str::to_owned).collect::<Vec<_>>();
    assert_eq!(moves(&with), moves(&without));
    #[cfg(unix)]
    crate::link::sent(folder.path(), &machine, &file, &plan);
}

fn found(file: &Path, plan: &Path, text: &str) -> Vec<String> {
    std::fs::write(file, text).unwrap();
    let run = trunnion().arg("verify").arg(file).arg("--plan").arg(plan).arg("--json").output().unwrap();
    let report: Value = serde_json::from_slice(&run.stdout).unwrap_or_else(|_| panic!("{}", said(&run)));
    report["findings"]
        .as_array()
        .unwrap()
        .iter()
        .map(|f| format!("{}: {}", f["rule"].as_str().unwrap(), f["text"].as_str().unwrap()))
        .collect()
}

/// Every single line left out, doubled or put elsewhere is seen.
#[test]
fn a_file_that_lacks_one_or_has_one_elsewhere_is_found() {
    let folder = folder();
    let machine = braked(folder.path());
    let (file, plan) = (folder.path().join("out.gcode"), folder.path().join("plan.json"));
    prepare(&fixture("y-tree"), machine.to_str().unwrap(), "builtin", &file, &["--plan-out", plan.to_str().unwrap()]);
    let text = std::fs::read_to_string(&file).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    let changed = folder.path().join("changed.gcode");
    let joined = |lines: Vec<&str>| lines.join("\n") + "\n";
    assert_eq!(found(&changed, &plan, &text), Vec::<String>::new());
    let own: Vec<usize> = (0..lines.len()).filter(|&i| lines[i].starts_with("M42 P5")).collect();
    assert!(own.len() >= 8, "{}", own.len());
    for &at in &own {
        let mut without = lines.clone();
        without.remove(at);
        let findings = found(&changed, &plan, &joined(without));
        assert!(
            findings.iter().any(|f| f.starts_with("command: ") && states(f, "[transition]")),
            "line {at}: {findings:?}"
        );
    }
    // The brake let go while the part is printed, and a pin that is none of these.
    let printing = (own[2]..).find(|&i| lines[i].starts_with("G1 X") && lines[i].contains(" E")).unwrap() + 1;
    for (line, words) in [("M42 P5 S255", "table"), ("M42 P5 S0", "table"), ("M42 P6 S0", "M42 | pin")] {
        let mut stray = lines.clone();
        stray.insert(printing, line);
        let findings = found(&changed, &plan, &joined(stray));
        assert!(findings.iter().any(|f| f.starts_with("command: ") && states(f, words)), "{line}: {findings:?}");
    }
}

#[test]
fn lines_that_leave_something_else_behind_are_refused() {
    let checked = |base: &str, key: &str, line: &str| {
        let start = if base == "klipper" {
            "[dialect]\nfirmware = \"klipper\"\nstart = \"\"\"\nG28\nMANUAL_STEPPER STEPPER=tilt GCODE_AXIS=A\nMANUAL_STEPPER STEPPER=rot GCODE_AXIS=C\nM109 S{nozzle_c}\"\"\"\n"
        } else {
            ""
        };
        let text = format!("{start}[transition]\n{key} = \"\"\"\n{line}\"\"\"\n");
        resolve("mine.toml", &text).err().map_or_else(String::new, |e| coded((&e).into(), &e))
    };
    for line in ["M400", "M42 P5 S255", "G4 P100", "M117 turning", "M204 P500"] {
        assert_eq!(checked("marlin", "before_turn", line), "", "{line}");
    }
    for (line, words) in [
        ("G1 X5", "moves"),
        ("G91", "moves"),
        ("G92 E0", "moves"),
        ("G28", "homes"),
        ("M84", "motors"),
        ("M104 S0", "heat, fans"),
        ("M106 S0", "heat, fans"),
        ("G10", "heat, fans"),
        ("M206 Z1", "coordinates"),
        ("BRAKE_ON", "BRAKE_ON | firmware"),
        ("M999999", "M999999 | firmware"),
    ] {
        for key in ["before_turn", "after_turn"] {
            let text = checked("marlin", key, line);
            assert!(fails(&text, &format!("profile/code: transition.{key} | \"{line}\" | {words}")), "{line}: {text}");
        }
    }
    assert_eq!(checked("klipper", "before_turn", "MANUAL_STEPPER STEPPER=brake MOVE=5 SPEED=10"), "");
    for (line, words) in [
        ("MANUAL_STEPPER STEPPER=tilt MOVE=5", "table"),
        ("MANUAL_STEPPER STEPPER=brake GCODE_AXIS=B", "table"),
        ("FORCE_MOVE STEPPER=stepper_x", "machine"),
    ] {
        let text = checked("klipper", "before_turn", line);
        assert!(fails(&text, &format!("profile/code: transition.before_turn | \"{line}\" | {words}")), "{text}");
    }
}

const STEPPERS: &str = "extends = \"fractal-5-pro\"\n[machine]\nname = \"older\"\n[kinematics.tilt]\nstepper = \"tilt\"\n\
                        [kinematics.rotation]\nstepper = \"rot\"\n[transition]\nbefore_turn = \"MANUAL_STEPPER STEPPER=brake MOVE=5 SPEED=20\"\n\
                        after_turn = \"MANUAL_STEPPER STEPPER=brake MOVE=0 SPEED=20\"\n[dialect]\nstart = \"\"\"\nG21\nG90\nG28\n\
                        MANUAL_STEPPER STEPPER=tilt SET_POSITION=0\nMANUAL_STEPPER STEPPER=rot SET_POSITION=0\n\
                        M140 S{bed_c}\nM104 S{nozzle_c}\nM190 S{bed_c}\nM109 S{nozzle_c}\"\"\"\nend = \"\"\"\nM104 S0\nM140 S0\nM107\nM84\"\"\"\n\
                        [link]\nrehome = \"G28\"\n";

/// A line's turn by a reader of its own: letter, word, degrees a minute.
fn turn(line: &str) -> Option<(char, f64, f64)> {
    let words: Vec<&str> = line.split(' ').collect();
    let value = |key: &str| words.iter().find_map(|word| word.strip_prefix(key)?.parse::<f64>().ok());
    match words[..] {
        ["MANUAL_STEPPER", "STEPPER=tilt", ..] => Some(('A', value("MOVE=")?, value("SPEED=")? * 60.0)),
        ["MANUAL_STEPPER", "STEPPER=rot", ..] => Some(('C', value("MOVE=")?, value("SPEED=")? * 60.0)),
        ["G1", word, _] if word.starts_with(['A', 'C']) => {
            Some((word.chars().next()?, word[1..].parse().ok()?, value("F")?))
        }
        _ => None,
    }
}

/// Klipper before GCODE_AXIS: the same print, whose turns are commands. Verified, printed on the simulated printer, rehearsed.
#[test]
fn a_table_without_letters_is_turned_by_commands() {
    let folder = folder();
    let machine = folder.path().join("older.toml");
    std::fs::write(&machine, STEPPERS).unwrap();
    let path = |name: &str| folder.path().join(name);
    let (file, plan, dry) = (path("out.gcode"), path("plan.json"), path("dry.gcode"));
    let more = ["--plan-out", plan.to_str().unwrap(), "--dry-run", dry.to_str().unwrap()];
    let document = prepare(&fixture("y-tree"), machine.to_str().unwrap(), "builtin", &file, &more);
    assert_eq!(document["verify"]["findings"], Value::Array(Vec::new()));
    let by_letters = path("letters.gcode");
    let letters = prepare(&fixture("y-tree"), "fractal-5-pro", "builtin", &by_letters, &[]);
    let [ours, theirs] = [&file, &by_letters].map(|file| std::fs::read_to_string(file).unwrap());
    let turns = |text: &str| text.lines().filter_map(turn).collect::<Vec<_>>();
    assert!(turns(&ours).len() >= 6 && turns(&ours) == turns(&theirs), "{:?} {:?}", turns(&ours), turns(&theirs));
    assert!(!ours.lines().any(|line| line.starts_with("G1 A") || line.starts_with("G1 C")));
    let cold = std::fs::read_to_string(&dry).unwrap();
    assert!(turns(&cold).len() >= 6 && !cold.lines().any(|line| line.starts_with("G1 A") || line.starts_with("G1 C")));
    // The brake is let go before the first of a pose's turns and put on behind the last.
    let lines: Vec<&str> = ours.lines().collect();
    for (at, _) in lines.iter().enumerate().filter(|(_, line)| turn(line).is_some_and(|(_, _, rate)| rate > 0.0)) {
        let beside = |line: &str| line.starts_with("MANUAL_STEPPER STEPPER=");
        assert!(beside(lines[at - 1]) && beside(lines[at + 1]), "{:?}", &lines[at - 1..=at + 1]);
    }
    // One clock: what a turn takes does not depend on how it is written.
    let seconds = |document: &Value| document["verify"]["seconds_print"].as_f64().unwrap();
    assert!(
        (seconds(&document) - seconds(&letters)).abs() < 1e-3 * seconds(&letters),
        "{} {}",
        seconds(&document),
        seconds(&letters)
    );
    #[cfg(unix)]
    crate::link::sent(folder.path(), &machine, &file, &plan);

    // A turn to elsewhere, by ever more; one that does not wait; one of a motor that is called otherwise.
    let tilted =
        lines.iter().position(|line| turn(line).is_some_and(|(axis, to, _)| axis == 'A' && to != 0.0)).unwrap();
    let word = turn(lines[tilted]).unwrap().1;
    let changed = |line: &str| {
        let mut lines = lines.clone();
        lines[tilted] = line;
        found(&path("changed.gcode"), &plan, &(lines.join("\n") + "\n"))
    };
    for (by, seen) in [(0.0, false), (0.0005, false), (0.002, true), (0.5, true), (20.0, true)] {
        let findings = changed(&format!("MANUAL_STEPPER STEPPER=tilt SPEED=20 MOVE={}", word + by));
        assert_eq!(findings.iter().any(|f| f.starts_with("pose: ")), seen, "{by}: {findings:?}");
    }
    for line in [
        format!("MANUAL_STEPPER STEPPER=tilt SPEED=20 MOVE={word} SYNC=0"),
        format!("MANUAL_STEPPER STEPPER=tilt MOVE={word}"),
        format!("MANUAL_STEPPER STEPPER=tilt SPEED=20 MOVE={word} STOP_ON_ENDSTOP=1"),
        format!("MANUAL_STEPPER STEPPER=tlit SPEED=20 MOVE={word}"),
        format!("MANUAL_STEPPER STEPPER=tilt SET_POSITION={word}"),
    ] {
        assert!(!changed(&line).is_empty(), "{line}");
    }
    let fast = changed(&format!("MANUAL_STEPPER STEPPER=tilt SPEED=40 MOVE={word}"));
    assert!(fast.iter().any(|f| f.starts_with("axis-rate: ")), "{fast:?}");
}

#[test]
fn names_of_motors_are_checked() {
    let checked = |from: &str, to: &str| {
        assert!(STEPPERS.contains(from));
        resolve("mine.toml", &STEPPERS.replacen(from, to, 1)).err().map_or_else(String::new, |e| e.to_string())
    };
    assert_eq!(checked("G21", "G21"), "");
    for (from, to, words) in [
        ("stepper = \"rot\"\n", "", "set for both axes or for neither"),
        ("stepper = \"rot\"", "stepper = \"tilt\"", "two different names"),
        ("stepper = \"rot\"", "stepper = \"r t\"", "two different names of letters, digits and _"),
        ("[dialect]\n", "[dialect]\nfirmware = \"marlin\"\n", "only Klipper has MANUAL_STEPPER"),
        ("STEPPER=tilt SET_POSITION=0", "STEPPER=tilt GCODE_AXIS=A", "and Klipper rejects MANUAL_STEPPER MOVE for it"),
        ("STEPPER=brake MOVE=5", "STEPPER=tilt MOVE=5", "may move an axis of the table"),
    ] {
        let text = checked(from, to);
        assert!(text.contains(words), "{to}: {text}");
    }
}
