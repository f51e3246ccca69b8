//! Prints that take turns or follow each other at one pose: travels over what stands, and each print's own settings.

use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use crate::bad_input::{cuboid, stl};
use crate::pipeline::{fixture, prepare};
use crate::support::{folder, said, trunnion};

/// A tower between two posts, planned with the parts of `slots`, and sliced by the built-in slicer.
fn sliced(folder: &Path, tower_mm: f32, post_mm: f32, slots: &[&[usize]]) -> PathBuf {
    let parts = [
        cuboid([-5.0, -5.0, 0.0], [5.0, 5.0, tower_mm]),
        cuboid([-45.0, -5.0, 0.0], [-35.0, 5.0, post_mm]),
        cuboid([35.0, -5.0, 0.0], [45.0, 5.0, post_mm]),
    ];
    let (model, plan) = (folder.join("towers.stl"), folder.join("plan.json"));
    std::fs::write(&model, stl(&parts.concat())).unwrap();
    let run = trunnion().arg("plan").arg(&model).args(["-m", "generic-ac", "-o"]).arg(&plan).output().unwrap();
    assert!(run.status.success(), "{}", said(&run));
    let mut document: Value = serde_json::from_slice(&std::fs::read(&plan).unwrap()).unwrap();
    let print = |part: &usize| json!({"part": part, "up": [0.0, 0.0, 1.0], "tilt_deg": 0.0, "rotation_deg": 0.0});
    let slot =
        |(id, parts): (usize, &&[usize])| json!({"id": id, "prints": parts.iter().map(print).collect::<Vec<_>>()});
    document["slots"] = slots.iter().enumerate().map(slot).collect();
    std::fs::write(&plan, document.to_string()).unwrap();
    let run = trunnion().arg("slice").arg(&plan).args(["--slicer", "builtin", "-o"]).arg(folder).output().unwrap();
    assert!(run.status.success(), "{}", said(&run));
    plan
}

fn file(folder: &Path, print: usize, part: usize) -> PathBuf {
    folder.join(format!("print-{print:02}-part-{part}.gcode"))
}

fn edit(path: &Path, change: impl Fn(String) -> String) {
    let mut text = std::fs::read_to_string(path).unwrap();
    // The change is meant: no checksum.
    text.truncate(text.rfind("; crc32 = ").unwrap_or(text.len()));
    std::fs::write(path, change(text)).unwrap();
}

/// All prints rewritten into one file.
fn rewritten(folder: &Path, plan: &Path) -> String {
    let files = (0..3).map(|i| file(folder, i, i));
    let output = folder.join("out.gcode");
    let run = trunnion().arg("rewrite").args(files).arg("--plan").arg(plan).arg("-o").arg(&output).output().unwrap();
    assert!(run.status.success(), "{}", said(&run));
    std::fs::read_to_string(output).unwrap()
}

fn word(line: &str, letter: char) -> Option<f64> {
    line.split(';').next()?.split(' ').find_map(|w| w.strip_prefix(letter)?.parse().ok())
}

/// The heights at which the tip crosses the tower's middle without extruding.
fn crossings(gcode: &str) -> Vec<f64> {
    let (mut x, mut z) = (f64::NAN, f64::NAN);
    let mut found = Vec::new();
    for line in gcode.lines().filter(|l| l.starts_with("G1")) {
        let from = x;
        x = word(line, 'X').unwrap_or(x);
        z = word(line, 'Z').unwrap_or(z);
        if (from < -20.0 && x > 20.0) || (from > 20.0 && x < -20.0) {
            found.push(z);
        }
    }
    found
}

#[test]
fn the_way_to_a_print_at_the_same_pose_goes_over_what_stands() {
    let folder = folder();
    let plan = sliced(folder.path(), 40.0, 6.0, &[&[0], &[1], &[2]]);
    let crossed = crossings(&rewritten(folder.path(), &plan));
    assert!(!crossed.is_empty() && crossed.iter().all(|&z| z > 41.0), "{crossed:?}");
}

#[test]
fn the_way_between_prints_that_grow_together_does_not_plough_a_top_between_them() {
    let folder = folder();
    let plan = sliced(folder.path(), 40.0, 45.0, &[&[0], &[1, 2]]);
    let crossed = crossings(&rewritten(folder.path(), &plan));
    assert!(crossed.len() > 200 && crossed.iter().all(|&z| z > 40.4), "{crossed:?}");
}

#[test]
fn prints_that_take_turns_keep_their_own_fan_heat_and_limits() {
    let folder = folder();
    let plan = sliced(folder.path(), 6.0, 6.0, &[&[0, 1, 2]]);
    let own = [(255.0, 205.0, 700.0), (80.0, 215.0, 900.0)];
    for (print, (fan, heat, limit)) in own.into_iter().enumerate() {
        edit(&file(folder.path(), print, print), |text| {
            let lines = text.lines().filter(|l| !l.starts_with("M106") && !l.starts_with("M107"));
            let set = format!(";LAYER_CHANGE\nM106 S{fan}\nM104 S{heat} T0\nM204 P{limit} T1500");
            lines.collect::<Vec<_>>().join("\n").replacen(";LAYER_CHANGE", &set, 1)
        });
    }
    // The third says nothing: no fan, and the heat of its settings.
    edit(&file(folder.path(), 2, 2), |text| {
        let lines = text.lines().filter(|l| !["M104", "M106", "M107", "M109"].iter().any(|c| l.starts_with(c)));
        lines.collect::<Vec<_>>().join("\n").replace("; temperature = 210", "; temperature = 233")
    });
    let text = rewritten(folder.path(), &plan);
    let (mut print, mut fan, mut heat, mut limit) = (0, f64::NAN, f64::NAN, f64::NAN);
    let mut switches = 0;
    for line in text.lines() {
        if let Some(rest) = line.strip_prefix(";TRUNNION print=") {
            print = rest[..1].parse::<usize>().unwrap();
            switches += 1;
        }
        match line.split(' ').next() {
            Some("M106") => fan = word(line, 'S').unwrap(),
            Some("M107") => fan = 0.0,
            Some("M104" | "M109") => heat = word(line, 'S').unwrap(),
            Some("M204") => limit = word(line, 'P').unwrap(),
            Some("G1") if word(line, 'X').is_some() && word(line, 'E').is_some_and(|e| e > 0.0) => match own.get(print)
            {
                Some(wanted) => assert_eq!((fan, heat, limit), *wanted, "print {print}: {line}"),
                None => assert_eq!((fan, heat), (0.0, 233.0), "print {print}: {line}"),
            },
            _ => {}
        }
    }
    assert!(switches > 80, "{switches}");
}

#[test]
fn a_table_without_end_stops_is_set_level_by_the_machines_own_code_and_by_nothing_else() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    // One machine over another over a shipped one, in folders of their own.
    std::fs::create_dir(path("bases")).unwrap();
    let start = "G92 U0 V0\\nG28 X Y Z\\nM140 S{bed_c}\\nG10 P0 S{nozzle_c}\\nM116\\n";
    let base = "extends = \"open5x-prusa\"\n[dialect]\nstart = \"G28\\nM109 S{nozzle_c}\"\n[process]\nlayer_height_mm = 0.25\n";
    std::fs::write(path("bases/mine.toml"), base).unwrap();
    let top = format!("extends = \"bases/mine.toml\"\n[dialect]\nstart = \"{start}\"\n");
    std::fs::write(path("level.toml"), top).unwrap();
    let (machine, plan, whole) = (path("level.toml"), path("plan.json"), path("whole.gcode"));
    let more = ["--plan-out", &plan.display().to_string()];
    prepare(&fixture("two-boxes"), &machine.display().to_string(), "builtin", &whole, &more);
    let text = std::fs::read_to_string(&whole).unwrap();
    assert!(text.contains("\nG92 U0 V0\nG28 X Y Z\n") && text.contains(";HEIGHT:0.25"), "the layers of the profile");
    let found = |text: &str| {
        std::fs::write(path("changed.gcode"), text).unwrap();
        let run = trunnion().arg("verify").arg(path("changed.gcode")).arg("--plan").arg(&plan).output().unwrap();
        (run.status.code(), said(&run))
    };
    // Once more in the middle, at other values, or after a turn, the table would be believed elsewhere than it is.
    let middle = text.find(";TRUNNION slot=1").unwrap();
    for line in ["G92 U0 V0\n", "G92 U90 V180\n", "G92 U0\n"] {
        let (code, said) = found(&format!("{}{line}{}", &text[..middle], &text[middle..]));
        assert!(code == Some(1) && said.contains("G92"), "{line}: {said}");
    }
    std::fs::write(path("bases/mine.toml"), "extends = \"../level.toml\"\n").unwrap();
    let run = trunnion().args(["profile", "check"]).arg(&machine).output().unwrap();
    assert!(run.status.code() == Some(2) && said(&run).contains("extends itself"), "{}", said(&run));
}
