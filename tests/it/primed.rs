//! A prime line in the machine's own start code: laid on the bare table, clear of everything printed later, and the first print begins as
//! all do.

use std::path::Path;

use serde_json::Value;

use crate::pipeline::{fixture, prepare};
use crate::support::{folder, installed, said, skip, states, trunnion};

/// A start code as people have it, with the line at Y `y` and Z `z`, pushing `e` over 100 mm.
fn machine(y: f64, z: f64, e: f64) -> String {
    format!(
        "extends = \"generic-ac\"\n[machine]\nname = \"primed\"\n[dialect]\nstart = \"\"\"\nG21\nG90\nM83\nG28\nM140 S{{bed_c}}\nM104 S{{nozzle_c}}\n\
         M190 S{{bed_c}}\nM109 S{{nozzle_c}}\nG1 Z150 F900\nG1 A0 C0 F1200\nG1 X-50 Y{y} F6000\nG1 Z{z} F900\nG1 X50 E{e} F1200\nG1 Z5 F900\"\"\"\n"
    )
}

fn checked(text: &str) -> String {
    let folder = folder();
    let path = folder.path().join("machine.toml");
    std::fs::write(&path, text).unwrap();
    let run = trunnion().args(["profile", "check"]).arg(&path).output().unwrap();
    if run.status.success() { String::new() } else { said(&run) }
}

fn findings(file: &Path, plan: &Path, text: &str) -> Vec<String> {
    std::fs::write(file, text).unwrap();
    let run = trunnion().arg("verify").arg(file).arg("--plan").arg(plan).arg("--json").output().unwrap();
    let report: Value = serde_json::from_slice(&run.stdout).unwrap_or_else(|_| panic!("{}", said(&run)));
    let all = report["findings"].as_array().unwrap_or_else(|| panic!("{}", said(&run))).iter();
    all.map(|f| format!("{}: {}", f["rule"].as_str().unwrap(), f["text"].as_str().unwrap())).collect()
}

#[test]
fn a_prime_line_on_the_table_is_printed_and_what_is_wrong_with_one_is_found() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    std::fs::write(path("machine.toml"), machine(-70.0, 0.3, 8.0)).unwrap();
    let (own, file, plan) = (path("machine.toml"), path("out.gcode"), path("plan.json"));
    let more = ["--plan-out", plan.to_str().unwrap()];
    let document = prepare(&fixture("y-tree"), own.to_str().unwrap(), "builtin", &file, &more);
    assert_eq!(document["verify"]["findings"], Value::Array(Vec::new()));
    let text = std::fs::read_to_string(&file).unwrap();

    // Behind it as much is pulled as at every turn, once; without it, or with it twice, the first print lacks filament or drips.
    let behind = text.split("G1 X50 E8 F1200\n").nth(1).unwrap();
    let until = behind.split(";TRUNNION slot=0").next().unwrap();
    assert_eq!(until.matches("G1 E-2 F2100\n").count(), 1, "{until}");
    let changed = path("changed.gcode");
    assert_eq!(findings(&changed, &plan, &text), Vec::<String>::new());
    let without = findings(&changed, &plan, &text.replacen("G1 E-2 F2100\n", "", 1));
    assert!(without.iter().any(|f| f.starts_with("retract: ")), "{without:?}");
    let twice = findings(&changed, &plan, &text.replacen("G1 E-2 F2100\n", "G1 E-2 F2100\nG1 E-2 F2100\n", 1));
    assert!(twice.iter().any(|f| f.starts_with("retract: ")), "{twice:?}");
    // A start code that pulls back itself is taken at its word.
    let pulls = machine(-70.0, 0.3, 8.0).replace("G1 Z5 F900", "G1 E-1.5 F2100\nG1 Z5 F900");
    let pulling = path("pulling.toml");
    std::fs::write(&pulling, pulls).unwrap();
    prepare(&fixture("y-tree"), pulling.to_str().unwrap(), "builtin", &path("pulled.gcode"), &[]);
    assert!(std::fs::read_to_string(path("pulled.gcode")).unwrap().contains("\nG1 E-0.5 F2100\n"));

    // The file, changed by ever more: height, filament, and nearer to the trunk, which stands on -10..10.
    let line = "G1 Z0.3 F900\nG1 X50 E8 F1200\n";
    assert!(text.contains(line));
    let with = |y: f64, z: f64, e: f64| {
        let text = text.replacen(line, &format!("G1 Z{z} F900\nG1 X50 E{e} F1200\n"), 1);
        findings(&changed, &plan, &text.replacen("G1 X-50 Y-70 F6000", &format!("G1 X-50 Y{y} F6000"), 1))
    };
    let outside = |y: f64, z: f64, e: f64, words: &str| {
        let found = with(y, z, e);
        let seen = found.iter().any(|f| f.starts_with("outside-part: ") && f.contains(words));
        assert!(seen, "Y {y}, Z {z}, E {e}: {found:?}");
    };
    for (y, z, e) in [
        (-70.0, 0.3, 8.0),
        (-70.0, 0.1, 4.0),
        (-70.0, 0.4, 12.0),
        (-70.0, 0.2, 8.0),
        (-30.0, 0.3, 8.0),
        (-12.0, 0.3, 8.0),
        (-80.0, 0.3, 8.0),
    ] {
        assert_eq!(with(y, z, e), Vec::<String>::new(), "Y {y}, Z {z}, E {e}");
    }
    for z in [0.02, -0.2, 0.45, 1.0, 30.0] {
        outside(-70.0, z, 8.0, "above the table; it must be level, at 0.05..0.4 mm");
    }
    for e in [24.0, 100.0] {
        outside(-70.0, 0.3, e, "1.60 mm");
    }
    // Half of 0.7 and the nozzle's half of 0.5 or so from the wall's middle, 9.8 from the trunk's.
    for y in [-10.6, -10.0, -5.0, 0.0] {
        outside(y, 0.3, 8.0, "mm from the print at line");
    }
    for y in [-85.0, -120.0] {
        outside(y, 0.3, 8.0, "beyond the table");
    }
    // At a tilt, at an angle that is not known, from an unknown place.
    for (from, to, words) in [
        ("G1 A0 C0 F1200", "G1 A0.01 C0 F1200", "at a tilt of 0.010 deg"),
        ("G1 A0 C0 F1200", "G1 C0 F1200", "pose is unknown"),
        ("G1 Z0.3 F900", "G28 X\nG1 Z0.3 F900", "position"),
    ] {
        let found = findings(&changed, &plan, &text.replacen(from, to, 1));
        assert!(found.iter().any(|f| f.contains(words)), "{to}: {found:?}");
    }
}

#[test]
fn what_the_start_code_may_not_lay_is_said_before_anything_is_sliced() {
    assert_eq!(checked(&machine(-70.0, 0.3, 8.0)), "");
    for (text, words) in [
        (
            machine(-70.0, 0.3, 8.0).replace("G1 A0 C0 F1200\n", ""),
            "first raise Z above all that turns and turn both table axes to 0",
        ),
        (
            machine(-70.0, 0.3, 8.0).replace("G1 Z150 F900\n", ""),
            "with the tip at an unknown height, and may sweep up to Z 100.",
        ),
        (
            machine(-70.0, 0.3, 8.0).replace("G1 Z150 F900", "G1 Z99 F900"),
            "with the tip at Z 99, and may sweep up to Z 100.",
        ),
        (machine(-70.0, 0.3, 8.0).replace("G1 A0 C0", "G1 A5 C0"), "at a tilt of 5.000 deg; level the table"),
        (machine(-70.0, 0.6, 8.0), "0.60 mm above the table; it must be level, at 0.05..0.4 mm (process.nozzle_mm)"),
        (machine(-70.0, 0.3, 40.0), "or move farther"),
        (machine(-99.0, 0.3, 8.0), "beyond the table"),
    ] {
        let said = checked(&text);
        let line = if words.contains("sweep") { "G1 A0 C0 F1200" } else { "G1 X50 E" };
        assert!(said.contains(words) && said.contains("dialect.start") && said.contains(line), "{words}: {said}");
    }
}

/// Skirt, brim and prime line: what goes around the part comes upon the line, or does not.
#[test]
fn a_brim_that_comes_upon_the_prime_line_is_found() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    for (y, clean) in [(-30.0, true), (-13.0, false)] {
        let text = machine(y, 0.3, 8.0) + "[process]\nbrim_mm = 5.0\n";
        std::fs::write(path("machine.toml"), text).unwrap();
        let mut run = trunnion();
        run.args(["prepare", &fixture("y-tree"), "--slicer", "builtin", "-m"]).arg(path("machine.toml"));
        let run = run.arg("-o").arg(path("out.gcode")).output().unwrap();
        assert_eq!(run.status.success(), clean, "{y}: {}", said(&run));
        assert!(clean || states(&said(&run), "prime line"), "{}", said(&run));
    }
}

/// Pushed beyond what was pulled, behind each turn but the first, and held by `verify` from a third of a millimetre on.
#[test]
fn what_oozes_out_while_the_table_turns_is_made_up_for() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    let (own, file, plan) = (path("machine.toml"), path("out.gcode"), path("plan.json"));
    let text = machine(-70.0, 0.3, 8.0) + "[transition]\nprime_mm = 0.8\n";
    std::fs::write(&own, text).unwrap();
    let more = ["--plan-out", plan.to_str().unwrap()];
    let document = prepare(&fixture("y-tree"), own.to_str().unwrap(), "builtin", &file, &more);
    assert_eq!(document["verify"]["findings"], Value::Array(Vec::new()));
    let text = std::fs::read_to_string(&file).unwrap();
    let pushes = |mm: &str| text.matches(&format!("\nG1 E{mm} F2100\n")).count();
    // The trunk, then a branch behind each of two turns.
    assert_eq!((pushes("2"), pushes("2.8")), (1, 2));
    let changed = path("changed.gcode");
    for (by, seen) in [
        (0.0, false),
        (0.29, false),
        (-0.29, false),
        (0.31, true),
        (-0.31, true),
        (-0.8, true),
        (-2.8, true),
        (5.0, true),
    ] {
        let found = findings(
            &changed,
            &plan,
            &text.replacen("\nG1 E2.8 F2100\n", &format!("\nG1 E{:.2} F2100\n", 2.8 + by), 1),
        );
        assert_eq!(found.iter().any(|f| f.starts_with("retract: printing starts")), seen, "by {by}: {found:?}");
    }
}

/// What the first line behind each turn is, by the slicer's own words.
fn first_behind_turns(text: &str) -> Vec<String> {
    let of_slot = |slot: &str| {
        let mut kind = String::new();
        for line in slot.lines() {
            if let Some(said) = line.strip_prefix(";TYPE:") {
                said.clone_into(&mut kind);
            }
            let pushes = line.split(" E").nth(1).is_some_and(|e| !e.starts_with('-'));
            if line.starts_with("G1 ") && (line.contains(" X") || line.contains(" Y")) && pushes {
                return kind;
            }
        }
        panic!("nothing is laid")
    };
    text.split(";TRUNNION slot=").skip(1).map(of_slot).collect()
}

#[test]
fn prints_begin_on_infill_where_that_is_asked() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    for (slicer, program) in [("builtin", ""), ("prusa-slicer", "prusa-slicer")] {
        if !program.is_empty() && !installed(program) {
            skip("prusa-slicer is not installed: its infill is not laid before its walls");
            continue;
        }
        for first in [true, false] {
            let (own, file) = (path("machine.toml"), path("out.gcode"));
            std::fs::write(&own, format!("extends = \"generic-ac\"\n[process]\ninfill_first = {first}\n")).unwrap();
            let document = prepare(&fixture("y-tree"), own.to_str().unwrap(), slicer, &file, &[]);
            assert_eq!(document["verify"]["findings"], Value::Array(Vec::new()));
            let kinds = first_behind_turns(&std::fs::read_to_string(&file).unwrap());
            assert!(kinds.len() >= 2, "{kinds:?}");
            for kind in kinds {
                let is_infill = kind.to_lowercase().contains("infill");
                assert_eq!(is_infill, first, "{slicer}, infill_first = {first}: {kind}");
            }
        }
    }
}
