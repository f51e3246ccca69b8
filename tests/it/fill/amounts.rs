//! Too much plastic, and what is missing from a whole print, where nothing else of the print tells.

use std::collections::BTreeMap;

use serde_json::json;

use super::{Kind, Line, Made, agreed};
use crate::pipeline::{fixture, prepare};
use crate::support::{folder, installed, note, skip};

/// The slicers that name the roles of their lines, as far as they are installed.
fn slicers() -> Vec<&'static str> {
    let mut all = vec!["builtin"];
    match installed("prusa-slicer") {
        true => all.push("prusa-slicer"),
        false => skip("prusa-slicer is not installed: its amounts are not changed"),
    }
    if crate::cura_engine::is_there() {
        all.push("cura");
    }
    all
}

fn solid(line: &Line) -> bool {
    line.kind == Kind::Solid
}

/// The file with a second line of `share` of the filament over each solid line of the top, called ironing.
fn ironed(made: &Made, share: f64) -> Vec<String> {
    let (mut lines, mut more) = (made.lines.clone(), BTreeMap::new());
    for line in made.printed.iter().filter(|line| solid(line) && line.from_top == 0) {
        let ([x0, y0], [x, y], e) = (line.from, line.to, line.e * share);
        let back = format!(";TYPE:Ironing\nG1 X{x0:.3} Y{y0:.3} E{e:.5}\nG1 X{x:.3} Y{y:.3}\n;TYPE:Solid infill");
        lines[line.at] = format!("{}\n{back}", lines[line.at]);
        *more.entry(line.print).or_insert(0.0) += e;
    }
    agreed(lines, &more)
}

/// The file with every line's filament times `factor`, and the header's factor on all flow saying so.
fn multiplied(made: &Made, factor: f64) -> Vec<String> {
    let mut lines = made.scaled(|_| factor);
    for line in lines.iter_mut().filter(|line| line.starts_with(";TRUNNION expect ")) {
        *line = line.replace("multiplier=1 ", &format!("multiplier={factor} "));
    }
    lines
}

#[test]
fn too_much_plastic() {
    for slicer in slicers() {
        let made = Made::of("two-boxes", slicer);
        let scaled = |which: fn(&Line) -> bool, factor: f64| {
            made.scaled(move |line| if solid(line) && which(line) { factor } else { 1.0 })
        };
        let fill = |what: &'static str| (what, "fill");
        let factors = [1.05, 1.1, 1.2, 1.3, 1.5, 1.7, 2.0];
        let table = [
            made.swept(fill("solid lines times"), &factors, 1.3, |factor| scaled(|_| true, factor)),
            made.swept(fill("top lines times"), &[1.1, 1.3, 1.5, 1.7, 2.0], 1.7, |factor| {
                scaled(|line| line.from_top == 0, factor)
            }),
            made.swept(fill("solid lines of one layer times"), &[1.3, 1.5, 1.7, 2.0, 2.5], 2.0, |factor| {
                scaled(|line| line.layer == 2, factor)
            }),
            made.swept(fill("all lines, as the header says, times"), &[1.05, 1.1, 1.2, 1.25], 1.25, |factor| {
                multiplied(&made, factor)
            }),
            made.swept(fill("ironing of the top with a share"), &[0.1, 0.15, 0.3, 0.5, 0.7, 1.0], 0.7, |share| {
                ironed(&made, share)
            }),
        ];
        note(&format!("{slicer}:\n  {}", table.join("\n  ")));
    }
}

#[test]
fn what_is_missing_from_a_whole_print() {
    for slicer in slicers() {
        let made = Made::of("two-boxes", slicer);
        let without = |gone: fn(&Line) -> bool| made.scaled(move |line| if gone(line) { 0.0 } else { 1.0 });
        let changes = [
            ("inner walls", "walls = 1", without(|line| line.kind == Kind::Inner)),
            ("infill", "infill = 0", without(|line| line.kind == Kind::Sparse)),
            (
                "solid layers below the top",
                "top_layers = 1",
                without(|line| solid(line) && (1..4).contains(&line.from_top)),
            ),
            (
                "solid layers above the bottom",
                "bottom_layers = 1",
                without(|line| solid(line) && (1..4).contains(&line.layer)),
            ),
        ];
        for (what, remedy, lines) in changes {
            let found = made.findings(&lines, "fill");
            assert!(
                found.iter().any(|text| text.contains(&format!("[process] {remedy}"))),
                "{slicer}, {what}: {found:?}"
            );
            // Nor does a header that says nothing of it hide it.
            let silent = lines.iter().map(|line| match line.split_once(" walls=") {
                Some((before, _)) if line.starts_with(";TRUNNION expect ") => before.to_owned(),
                _ => line.clone(),
            });
            assert!(!made.findings(&silent.collect::<Vec<_>>(), "fill").is_empty(), "{slicer}, {what}: hidden");
        }
    }
}

/// How far the line is inside the outer walls of its layer, which are about a box, mm.
fn inward(made: &Made, line: &Line) -> f64 {
    let beside =
        made.printed.iter().filter(|one| one.kind == Kind::Outer && (one.print, one.layer) == (line.print, line.layer));
    let mut sides = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
    for end in beside.flat_map(|one| [one.from, one.to]) {
        for (side, v) in sides.iter_mut().zip(end) {
            *side = [side[0].min(v), side[1].max(v)];
        }
    }
    let to_side =
        |p: [f64; 2]| sides.iter().zip(p).map(|([low, high], v)| (v - low).min(high - v)).fold(f64::INFINITY, f64::min);
    to_side(line.from).max(to_side(line.to))
}

/// One thread of three is gone from all walls.
#[test]
fn two_walls_of_three() {
    let folder = folder();
    let three = folder.path().join("three.toml");
    std::fs::write(&three, "extends = \"generic-ac\"\n[process]\nwalls = 3\n").unwrap();
    for slicer in slicers() {
        let made = Made::on(&three.display().to_string(), "two-boxes", slicer);
        let innermost = |line: &Line| line.kind == Kind::Inner && inward(&made, line) > 0.6;
        assert!(made.printed.iter().any(innermost), "{slicer}");
        let lines = made.scaled(|line| if innermost(line) { 0.0 } else { 1.0 });
        let found = made.findings(&lines, "fill");
        assert!(found.iter().any(|text| text.contains("[process] walls = 2")), "{slicer}: {found:?}");
    }
}

/// A header that states less than the profile is believed, and the report says so.
#[test]
fn what_a_header_states_is_in_the_report() {
    let made = Made::of("two-boxes", "builtin");
    let stated = |words: [&str; 2]| {
        let lines: Vec<String> = made
            .lines
            .iter()
            .map(|line| match line.starts_with(";TRUNNION expect ") {
                true => line.replace(words[0], words[1]),
                false => line.clone(),
            })
            .collect();
        made.report(&lines)["stated"].clone()
    };
    let less = |setting: &str, file: f64, profile: f64| json!([{"setting": setting, "file": file, "profile": profile, "parts": [0, 1]}]);
    assert_eq!(stated(["walls=2", "walls=2"]), json!([]));
    assert_eq!(stated(["walls=2", "walls=3"]), json!([]));
    assert_eq!(stated(["walls=2", "walls=1"]), less("walls", 1.0, 2.0));
    assert_eq!(stated(["tops=4", "tops=2"]), less("top_layers", 2.0, 4.0));
    assert_eq!(stated(["infill=1", "infill=0"]), less("infill", 0.0, 0.2));
    assert_eq!(stated(["multiplier=1 ", "multiplier=0.95 "]), less("multiplier", 0.95, 1.0));
}

/// Thin shells without infill, where the profile or the user's own configuration wants them so.
#[test]
fn what_is_left_out_on_purpose_is_no_finding() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    let (output, config) = (path("out.gcode"), path("mine.ini"));
    let clean = |machine: &str, slicer: &str, more: &[&str]| {
        let document = prepare(&fixture("cube"), machine, slicer, &output, more);
        assert_eq!(document["verify"]["findings"], serde_json::json!([]), "{slicer}");
    };
    let thin = "[process]\nwalls = 1\ntop_layers = 1\nbottom_layers = 1\ninfill = 0.0\nbridge_mm = 40.0\n";
    std::fs::write(path("thin.toml"), format!("extends = \"generic-ac\"\n{thin}")).unwrap();
    let mut own = vec![("builtin", "perimeters = 1\nfill_density = 30%\ntop_solid_layers = 2\n")];
    if installed("prusa-slicer") {
        own.push(("prusa-slicer", "perimeters = 1\nfill_density = 30%\ntop_solid_layers = 2\n"));
    }
    if crate::cura_engine::is_there() {
        own.push(("cura", "wall_line_count = 1\ninfill_line_distance = 2\ntop_layers = 2\n"));
    }
    for (slicer, keys) in own {
        clean(&path("thin.toml").display().to_string(), slicer, &[]);
        std::fs::write(&config, keys).unwrap();
        clean("generic-ac", slicer, &["--slicer-config", &config.display().to_string()]);
    }
}
