//! What a program asks of the table, by hand: torque on the tilt axis, wound cables, times with a hot nozzle; and how well shared surfaces are filled.

use std::path::Path;

use serde_json::{Value, json};
use trunnion::mesh::stl_binary;

use crate::pipeline::{fixture, prepare};
use crate::split::solids::block;
use crate::support::{folder, said, trunnion};

const GRAMS_PER_MM3: f64 = 1.24e-3;
const NEWTON: f64 = 9.80665e-3;
const FILAMENT_MM2: f64 = std::f64::consts::PI / 4.0 * 1.75 * 1.75;

fn machine(folder: &Path, text: &str) -> String {
    let file = folder.join("machine.toml");
    std::fs::write(&file, format!("extends = \"generic-ac\"\n{text}")).unwrap();
    file.display().to_string()
}

/// The fixture's program with its plan, and the report.
fn made(model: &str, machine: &str, folder: &Path) -> (String, Value) {
    let (file, plan) = (folder.join("made.gcode"), folder.join("plan.json"));
    let document = prepare(model, machine, "builtin", &file, &["--plan-out", &plan.display().to_string()]);
    (std::fs::read_to_string(file).unwrap(), document["verify"].clone())
}

/// The report of a changed program.
fn changed(program: &str, folder: &Path, more: &[&str]) -> Value {
    std::fs::write(folder.join("changed.gcode"), program).unwrap();
    let words = ["verify", "changed.gcode", "--plan", "plan.json", "--json"];
    let run = trunnion().args(words).args(more).current_dir(folder).output().unwrap();
    serde_json::from_slice(&run.stdout).unwrap_or_else(|_| panic!("{}", said(&run)))
}

fn number(of: &Value, key: &str) -> f64 {
    of[key].as_f64().unwrap()
}

#[test]
fn the_torque_on_the_tilt_axis_is_weight_times_lever() {
    let folder = folder();
    let model = folder.path().join("bar.stl");
    std::fs::write(&model, stl_binary(&block(40.0, 10.0, 8.0).mesh())).unwrap();
    for y in [-70.0, 0.0, 30.0, 80.0] {
        let (file, plan) = (folder.path().join("bar.gcode"), folder.path().join("bar.json"));
        let words = ["--way", "as-drawn", "--unit", "mm", "--plan-out", &plan.display().to_string()];
        let origin = format!("-20,{}", y - 5.0);
        let document = prepare(
            &model.display().to_string(),
            "generic-ac",
            "builtin",
            &file,
            &[&words[..], &["--origin", &origin]].concat(),
        );
        let report = &document["verify"];
        let weight = number(report, "filament_mm") * FILAMENT_MM2 * GRAMS_PER_MM3 * NEWTON;
        let wanted = weight * f64::abs(y) / 1000.0;
        // The plastic's middle is the bar's but for a seam and the infill's pattern.
        let torque = number(&report["table"], "torque_nm");
        assert!((torque - wanted).abs() <= weight * 0.3 / 1000.0, "{y}: {torque} {wanted}");
        assert_eq!(report["table"]["turns"], 0);
    }
}

/// The second box is printed with the table upright: its weight hangs beside the axis, which no level table tells.
#[test]
fn a_tilt_axis_holds_what_it_is_stated_to_hold() {
    let folder = folder();
    let (_, report) = made(&fixture("two-boxes"), "generic-ac", folder.path());
    let torque = number(&report["table"], "torque_nm");
    for (share, clean) in [(0.5, false), (0.99, false), (1.01, true), (3.0, true)] {
        let own = machine(folder.path(), &format!("[kinematics.tilt]\nholding_nm = {:.6}\n", torque * share));
        let words =
            ["prepare", &fixture("two-boxes"), "-m", &own, "--slicer", "builtin", "--way", "as-drawn", "--json"];
        let out = folder.path().join("held.gcode");
        let run = trunnion().args(words).arg("-o").arg(&out).output().unwrap();
        assert_eq!((run.status.success(), out.exists()), (clean, clean), "{share}: {}", said(&run));
        let document: Value = serde_json::from_slice(&run.stdout).unwrap();
        let found = &document["verify"]["findings"];
        assert_eq!(found.as_array().unwrap().is_empty(), clean, "{found}");
        if !clean {
            assert_eq!(found[0]["rule"], "standing");
            assert!((number(&found[0], "measured") - torque).abs() < 1e-9);
        }
    }
}

/// The same pose one turn further is the same print; only the cables know.
#[test]
fn cables_are_wound_no_further_than_the_profile_lets_them() {
    let folder = folder();
    let own = machine(folder.path(), "[kinematics.rotation]\nmax_turns = 1.0\n");
    let (program, report) = made(&fixture("two-boxes"), &own, folder.path());
    let turn = "G1 C90 F1800";
    assert!(program.contains(turn) && report["table"]["wound_turns"] == 0.25, "{report}");
    for turns in 0..4 {
        let word = format!("C{}", 90 + 360 * turns);
        let moved = program.replace(turn, &format!("G1 {word} F1800")).replace("C=90", &word.replace('C', "C="));
        let report = changed(&moved, folder.path(), &[]);
        assert_eq!(number(&report["table"], "wound_turns"), 0.25 + f64::from(turns));
        let beyond = report["counts"].get("axis-limit").is_some();
        assert_eq!(beyond, turns > 0, "{turns}: {}", report["findings"]);
    }
}

/// With a rest of half a minute before the turn's last move, that rest is in the figure.
#[test]
fn the_time_with_a_hot_nozzle_is_that_between_two_printed_lines() {
    let folder = folder();
    let (program, report) = made(&fixture("two-boxes"), "generic-ac", folder.path());
    let (waits, longest) = (number(&report["table"], "waiting_s"), number(&report["table"], "longest_s"));
    assert_eq!((report["table"]["turns"].as_u64(), waits), (Some(1), longest));
    // A quarter turn each at 30 and 20 degrees a second, and the travels.
    assert!(longest > 90.0 / 30.0 + 90.0 / 20.0 && longest < 30.0, "{longest}");
    let slower = program.replace("G1 A90 F1200", "G1 A90 F600");
    let slower = changed(&slower, folder.path(), &[]);
    assert!((number(&slower["table"], "longest_s") - longest - 4.5).abs() < 1e-3, "{slower}");
}

/// The lines of the second box drawn away from the first one, from nothing to gross: as soon as no line of it is within reach, nothing is filled.
#[test]
fn a_joint_that_does_not_meet_is_not_filled() {
    let folder = folder();
    let (program, report) = made(&fixture("two-boxes"), "generic-ac", folder.path());
    let share = |report: &Value| number(&report["interfaces"][0], "share");
    assert!((number(&report["interfaces"][0], "area_mm2") - 400.0).abs() < 1e-6 && share(&report) > 0.99);
    let start = program.find(";TRUNNION print=1").unwrap();
    let lifted = |mm: f64| {
        let rest =
            program[start..].lines().map(|line| match line.strip_prefix("G1 Z").and_then(|z| z.split_once(' ')) {
                Some((z, rest)) => format!("G1 Z{:.3} {rest}", z.parse::<f64>().unwrap() + mm),
                None => line.to_owned(),
            });
        program[..start].to_owned() + &rest.collect::<Vec<_>>().join("\n")
    };
    for (mm, filled) in [(0.0, true), (0.05, true), (0.1, true), (0.2, false), (0.5, false), (2.0, false)] {
        let report = changed(&lifted(mm), folder.path(), &[]);
        assert_eq!(share(&report) > 0.5, filled, "{mm} mm: {}", report["interfaces"]);
        assert!(filled || share(&report) < 0.01, "{mm} mm: {}", report["interfaces"]);
    }
    // Of the first layer what reaches over to one half is missing: of lines at 45 degrees a corner of 10 x 10 mm is left, and walls. The layer
    // above is not within reach.
    let end = start + program[start..].find("Z:0.4").unwrap();
    let mut from = 0.0;
    let half = program[start..end].lines().map(|line| {
        let to = line.split(' ').find_map(|word| word.strip_prefix('X')?.parse::<f64>().ok()).unwrap_or(from);
        let left = line.starts_with("G1") && f64::min(std::mem::replace(&mut from, to), to) < 0.0;
        let words = line.split(' ').filter(|word| !(left && word.starts_with('E')));
        words.collect::<Vec<_>>().join(" ")
    });
    let half = program[..start].to_owned() + &half.collect::<Vec<_>>().join("\n") + "\n" + &program[end..];
    let report = changed(&half, folder.path(), &[]);
    assert!((0.125..0.3).contains(&share(&report)), "{}", report["interfaces"]);
}

/// With walls first printing goes on with a wall after the turn; with infill first it does not.
#[test]
fn starts_on_outer_walls_are_listed_with_their_places() {
    let folder = folder();
    let infill = machine(folder.path(), "[process]\ninfill_first = true\n");
    let (_, report) = made(&fixture("two-boxes"), &infill, folder.path());
    assert_eq!((&report["wall_starts"], &report["table"]["starts_on_walls"]), (&json!([]), &json!(0)));
    let walls = machine(folder.path(), "[process]\nwalls = 1\n");
    let (program, report) = made(&fixture("two-boxes"), &walls, folder.path());
    let starts = report["wall_starts"].as_array().unwrap();
    assert_eq!((starts.len(), &report["table"]["starts_on_walls"]), (1, &json!(1)));
    // By hand: the travel before the line, at A90 C90 on this table (see the unit tests of `verify`): x' = -y, y' = -z - 20, z' = x - 20.
    let line = starts[0]["line"].as_u64().unwrap() as usize;
    let before: Vec<&str> = program.lines().take(line - 1).collect();
    let last = |letter: char| -> f64 {
        let word = |line: &&str| line.split(' ').find_map(|word| word.strip_prefix(letter)?.parse().ok());
        before.iter().rev().filter(|line| line.starts_with('G')).find_map(word).unwrap()
    };
    let at: Vec<f64> = starts[0]["at_mm"].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect();
    for (found, by_hand) in at.iter().zip([last('Z') + 20.0, -last('X'), -last('Y') - 20.0]) {
        assert!((found - by_hand).abs() < 2e-3, "{at:?}, by hand {by_hand}");
    }
    assert_eq!(starts[0]["part"], 1);
}
