//! Printable as practised: screw holes, bridges and small patches from one file to a verified one; what hangs is refused with its
//! place and its cause; one solid that has no plan as it is is cut.

use std::path::Path;

use serde_json::Value;
use trunnion::mesh::{stl_binary, stl_binary_parts};

use crate::split::solids::{self, Shape};
use crate::support::{folder, installed, said, skip, states, trunnion};

fn written(folder: &Path, name: &str, shape: &Shape) -> String {
    let path = folder.join(format!("{name}.stl"));
    std::fs::write(&path, stl_binary(&shape.mesh())).unwrap();
    path.display().to_string()
}

/// Runs a verb with `--json`: exit code, document, messages.
fn run(args: &[&str]) -> (Option<i32>, Value, String) {
    let run = trunnion().args(args).arg("--json").output().unwrap();
    let said = String::from_utf8_lossy(&run.stderr).into_owned();
    (run.status.code(), serde_json::from_slice(&run.stdout).unwrap_or(Value::Null), said)
}

fn slicers() -> Vec<&'static str> {
    if installed("prusa-slicer") {
        return vec!["builtin", "prusa-slicer"];
    }
    skip("prusa-slicer is not installed");
    vec!["builtin"]
}

/// `shape` through `prepare` with every slicer there is; the document of the first.
fn is_verified(folder: &Path, name: &str, shape: &Shape, more: &[&str]) -> Value {
    let (model, out) = (written(folder, name, shape), folder.join(format!("{name}.gcode")));
    let mut first = None;
    for slicer in slicers() {
        let out = out.display().to_string();
        let args = ["prepare", &model, "-m", "generic-ac", "--slicer", slicer, "-o", &out];
        let (code, document, said) = run(&[&args[..], more].concat());
        assert_eq!(code, Some(0), "{name} with {slicer}: {said}");
        assert_eq!(document["verify"]["findings"], Value::Array(Vec::new()), "{name} with {slicer}");
        first.get_or_insert(document);
    }
    first.unwrap()
}

/// The sentence that `plan` ends with where there is no plan, and the kinds of remedies in their order.
fn refused(folder: &Path, name: &str, shape: &Shape, more: &[&str]) -> (String, Vec<String>) {
    let model = written(folder, name, shape);
    let (code, document, said) = run(&[&["plan", &model, "-m", "generic-ac"][..], more].concat());
    assert_eq!(code, Some(1), "{name}: {said}");
    let remedies = document["remedies"].as_array().unwrap();
    let kinds = remedies.iter().map(|r| r["kind"].as_str().unwrap().to_owned()).collect();
    (document["summary"].as_str().unwrap().to_owned(), kinds)
}

/// A round hole along x (0), y (1) or z (2) through everything near `at`.
fn hole(axis: usize, diameter: f64, at: [f64; 3]) -> Shape {
    let rod = solids::rod(diameter / 2.0, 100.0, 32).at(0.0, 0.0, -50.0);
    let along = match axis {
        0 => rod.about_y(90.0),
        1 => rod.about_y(90.0).about_z(90.0),
        _ => rod,
    };
    along.at(at[0], at[1], at[2])
}

fn plate() -> Shape {
    solids::block(30.0, 20.0, 10.0)
}

#[test]
fn a_block_with_screw_holes_is_printed_as_it_is() {
    let folder = folder();
    let three = [8.0, 15.0, 22.0].iter().fold(plate(), |block, x| block.less(&hole(1, 1.0, [*x, 0.0, 5.0])));
    let done = is_verified(folder.path(), "screws", &three, &[]);
    assert_eq!(done["cut"], Value::Null);
    for diameter in [1.0, 2.0, 3.0, 4.0, 5.0] {
        // At heights of no layer and of a layer's middle; one above the other, so that none crosses another.
        let all = solids::block(30.0, 20.0, 16.0).less(&hole(0, diameter, [0.0, 5.0, 4.03]));
        let all = all.less(&hole(1, diameter, [8.0, 0.0, 11.5])).less(&hole(2, diameter, [22.0, 13.0, 0.0]));
        is_verified(folder.path(), &format!("holes-{diameter}"), &all, &[]);
    }
}

/// A screw's head sunk into a part from below: around the hole in its roof the walls lie on nothing, and are laid when bridges hold them.
#[test]
fn a_hole_in_the_roof_of_a_screws_head_is_printed() {
    let folder = folder();
    for (head, screw) in [(6.5, 3.4), (8.0, 4.2), (9.0, 5.2)] {
        let sunk = solids::rod(head / 2.0, 4.0, 48).at(15.0, 10.0, -0.01);
        let shape = plate().less(&sunk).less(&hole(2, screw, [15.0, 10.0, 0.0]));
        let model = written(folder.path(), "sunk", &shape);
        let out = folder.path().join("sunk.gcode").display().to_string();
        let args = ["prepare", &model, "-m", "generic-ac", "--slicer", "builtin", "--way", "as-drawn", "-o", &out];
        let (code, document, said) = run(&args);
        assert_eq!(code, Some(0), "{head}, {screw}: {said}");
        assert_eq!(document["verify"]["findings"], Value::Array(Vec::new()), "{head}, {screw}");
    }
}

/// Two posts with a beam over `wide` mm between them.
fn gate(wide: f64) -> Shape {
    let beam = solids::block(wide + 20.0, 10.0, 10.0).at(-wide / 2.0 - 10.0, -5.0, 30.0);
    let post = |x: f64| solids::block(10.0, 10.0, 31.0).at(x, -5.0, 0.0);
    beam.and(&post(-wide / 2.0 - 10.0)).and(&post(wide / 2.0))
}

#[test]
fn a_bridge_of_12_mm_is_printed_and_one_of_40_is_refused_with_its_place() {
    let folder = folder();
    let droops = |done: &Value| done["plan"]["droops"].as_array().unwrap().clone();
    assert_eq!(droops(&is_verified(folder.path(), "gate-7", &gate(7.0), &["--way", "as-drawn"])), Vec::<Value>::new());
    let sags = droops(&is_verified(folder.path(), "gate-12", &gate(12.0), &["--way", "as-drawn"]));
    assert!(sags.len() == 1 && (sags[0]["area_mm2"].as_f64().unwrap() - 112.8).abs() < 1.0, "{sags:?}");
    let (why, kinds) = refused(folder.path(), "gate-40", &gate(40.0), &[]);
    let words = "with (0.000, 0.000, 1.000) up 392.8 mm2 would be printed in mid-air, 392.8 of it near (0, 0, 30) mm: ceiling 39.3 x 10.0 mm; a bridge may span 14 mm between two supported ends";
    assert!(why.contains(words), "{why}");
    let flat = folder.path().join("flat.toml");
    std::fs::write(&flat, "extends = \"generic-ac\"\n[kinematics.tilt]\nmin_deg = 0.0\nmax_deg = 0.0\n").unwrap();
    let flat = flat.display().to_string();
    let (code, document, said) = run(&["plan", &format!("{}/gate-40.stl", folder.path().display()), "-m", &flat]);
    assert_eq!(code, Some(1), "{said}");
    let reasons = document["reasons"].as_array().unwrap();
    let upright = reasons.iter().find(|r| r["orientation"][2].as_f64().unwrap() > 0.999).unwrap();
    let text = upright["text"].as_str().unwrap();
    assert!(states(text, "39.3 x 10.0 mm | 14 mm"), "{text}");
    assert!(text.contains("near (0, 0, 30) mm"), "{text}");
    let hangs = &upright["hangs"];
    assert!((hangs["area_mm2"].as_f64().unwrap() - 393.0).abs() < 1.0, "{hangs}");
    assert!((hangs["at_mm"][2].as_f64().unwrap() - 30.0).abs() < 0.11, "{hangs}");
    assert!(hangs["cause"].as_str().unwrap().starts_with("ceiling"), "{hangs}");
    // What is nearest to working comes first, then a cut, then support.
    assert!(kinds.contains(&"bridge".to_owned()), "{kinds:?}");
    assert_eq!(kinds[kinds.len() - 2..], ["split", "support"], "{kinds:?}");
}

#[test]
fn one_span_is_planned_sliced_and_verified_with() {
    let folder = folder();
    let model = written(folder.path(), "gate", &gate(18.0));
    let gcode = folder.path().join("gate.gcode").display().to_string();
    let plan = folder.path().join("gate.json").display().to_string();
    let args = ["prepare", &model, "-m", "generic-ac", "--slicer", "builtin", "--way", "as-drawn", "-o", &gcode];
    let (code, _, said) = run(&args);
    assert_eq!(code, Some(1), "{said}");
    let (code, document, said) = run(&[&args[..], &["--bridge", "19", "--plan-out", &plan]].concat());
    assert_eq!(code, Some(0), "{said}");
    assert_eq!(document["plan"]["bridge_mm"], 19.0);
    // The plan's file keeps it for verification.
    assert_eq!(run(&["verify", &gcode, "--plan", &plan]).0, Some(0));
    let own = std::fs::read_to_string(&plan).unwrap().replace("\"bridge_mm\": 19.0", "\"bridge_mm\": 14.0");
    std::fs::write(&plan, own).unwrap();
    let (code, document, _) = run(&["verify", &gcode, "--plan", &plan]);
    assert_eq!(code, Some(1));
    assert!(document["findings"].as_array().unwrap().iter().any(|f| f["rule"] == "in-air"), "{document}");
    // A profile that says it needs no flag.
    let machine = folder.path().join("machine.toml");
    std::fs::write(&machine, "extends = \"generic-ac\"\n[process]\nbridge_mm = 19.0\n").unwrap();
    let machine = machine.display().to_string();
    assert_eq!(run(&["plan", &model, "-m", &machine]).0, Some(0));
}

#[test]
fn bad_exceptions_are_told_in_a_sentence() {
    let folder = folder();
    let model = written(folder.path(), "gate", &gate(12.0));
    for (more, wanted) in [
        (["--bridge", "900"], "--bridge 900: must be 0..200 mm"),
        (["--tolerate", "-1"], "unexpected argument"),
        (["--tolerate=-1", "-q"], "--tolerate must be between 0 and 1000000 mm2, got -1"),
        (["--allow", "1:5"], "has no part 1"),
        (["--allow", "a"], "--allow a: must be a part number"),
        (["--allow", "0:x"], "--allow 0:x: must be a part number"),
        (["--allow", "0:2000000"], "--allow must be between 0 and 1000000 mm2, got 2000000"),
    ] {
        let (code, _, said) = run(&[&["plan", &model, "-m", "generic-ac"][..], &more].concat());
        assert_eq!(code, Some(2), "{more:?}: {said}");
        assert!(said.contains(wanted), "{more:?}: {said}");
    }
}

#[test]
fn one_part_may_hang_and_the_others_may_not() {
    let folder = folder();
    let meshes = [gate(20.0).mesh(), gate(20.0).at(0.0, 30.0, 0.0).mesh()];
    let model = folder.path().join("two.stl");
    std::fs::write(&model, stl_binary_parts(&meshes.iter().collect::<Vec<_>>())).unwrap();
    let model = model.display().to_string();
    let plan = |more: &[&str]| run(&[&["plan", &model, "-m", "generic-ac", "--no-remedies"][..], more].concat()).0;
    // 19.28 mm of 10 mm farther out than 0.36 mm each.
    assert_eq!(plan(&["--allow", "0:194", "--allow", "1:194"]), Some(0));
    assert_eq!(plan(&["--allow", "0:194"]), Some(1));
    assert_eq!(plan(&["--allow", "0:192", "--allow", "1:194"]), Some(1));
    assert_eq!(plan(&["--allow", "0", "--allow", "1"]), Some(0));
}

/// A block whose lower edges along y are rounded.
fn rounded(radius: f64) -> Shape {
    let corner = |x: f64, low: f64| {
        // Out beyond the faces, so that no sheet without thickness stays there.
        let square = solids::block(radius + 1.0, 40.0, radius + 1.0).at(low, -10.0, -1.0);
        let round = solids::rod(radius, 60.0, 96).at(0.0, 0.0, -30.0).about_y(90.0).about_z(90.0).at(x, 0.0, radius);
        square.less(&round)
    };
    plate().less(&corner(radius, -1.0)).less(&corner(30.0 - radius, 30.0 - radius))
}

#[test]
fn a_fillet_below_is_printed_as_drawn_and_droops() {
    let folder = folder();
    for (radius, droops) in [(1.0, false), (5.0, true)] {
        let name = format!("fillet-{radius}");
        let done = is_verified(folder.path(), &name, &rounded(radius), &[]);
        assert_eq!([&done["cut"], &done["supports"]], [&Value::Null; 2], "{name}");
        assert_eq!(done["ways"][0]["way"], "as-drawn");
        assert_eq!(
            !done["plan"]["droops"].as_array().unwrap().is_empty(),
            droops,
            "{name}: {}",
            done["plan"]["droops"]
        );
    }
    // Where nothing is to droop, and where a steeper slope is said to be fine.
    let (why, _) = refused(folder.path(), "fillet-5", &rounded(5.0), &["--finish", "fine"]);
    assert!(states(&why, "mm2 | mid-air | mm"), "{why}");
    is_verified(folder.path(), "fillet-5", &rounded(5.0), &["--finish", "fine", "--overhang", "72"]);
}

/// As drawn a branch at 45 degrees is printed well; here it is not to be.
const CUT_AT_40: [&str; 6] = ["--overhang", "40", "--finish", "fine", "--way", "cut"];

#[test]
fn one_solid_that_has_no_plan_is_cut_and_says_so() {
    let folder = folder();
    for (name, shape, cuts) in [("tee", solids::tee(), 2), ("hook", solids::hook(), 1)] {
        let before = stl_binary(&shape.mesh());
        let done = is_verified(folder.path(), name, &shape, &["--way", "cut"]);
        let cut = &done["cut"];
        assert_eq!(cut["planes"].as_array().map(Vec::len), Some(cuts), "{name}: {cut}");
        assert!(states(cut["reason"].as_str().unwrap(), "--way"), "{name}: {cut}");
        for cost in ["seam_mm2", "seconds_print", "filament_mm"] {
            assert!(cut[cost].as_f64().unwrap() > 0.0, "{name}: {cost}");
        }
        // The model is what it was; its parts stand beside the output, and are what the plan is for.
        assert_eq!(std::fs::read(folder.path().join(format!("{name}.stl"))).unwrap(), before);
        let parts = folder.path().join(format!("{name}.parts.3mf"));
        assert_eq!(cut["file"], parts.display().to_string());
        let sum = trunnion::planning::sha256_hex(&std::fs::read(&parts).unwrap());
        assert_eq!(done["plan"]["model"]["sha256"], sum);
        assert_eq!(done["plan"]["parts"].as_array().unwrap().len() as u64, cut["parts"].as_u64().unwrap());
    }
    // A round body on a slant is cut and planned as well; what slicers make of its lowest layers may be refused, but never for lines
    // in the air.
    let (model, out) = (written(folder.path(), "wye", &solids::wye()), folder.path().join("wye.gcode"));
    for slicer in slicers() {
        let out = out.display().to_string();
        let (code, _, said) =
            run(&[&["prepare", &model, "-m", "generic-ac", "--slicer", slicer, "-o", &out][..], &CUT_AT_40].concat());
        assert!(said.contains("slot 1"), "{said}");
        assert!(code == Some(0) || said.contains("findings") || said.contains("1 finding"), "{slicer}: {said}");
        assert!(!said.contains("in-air") && !said.contains("mid-air"), "{slicer}: {said}");
    }
    // Not where it is not wanted: then the parts are not written either.
    let (model, out) = (written(folder.path(), "whole", &solids::tee()), folder.path().join("whole.gcode"));
    let args = ["prepare", &model, "-m", "generic-ac", "--slicer", "builtin", "-o"];
    let never = trunnion().args(args).arg(&out).args(["--way", "as-drawn", "--no-remedies"]).output().unwrap();
    assert_eq!(never.status.code(), Some(1), "{}", said(&never));
    assert!(!folder.path().join("whole.parts.3mf").exists() && !out.exists());
    // The picture and the text say what was done, and why.
    let sheet = folder.path().join("whole.svg");
    let done = trunnion().args(args).arg(&out).args(["--way", "cut", "--sheet"]).arg(&sheet).output().unwrap();
    assert!(done.status.success(), "{}", said(&done));
    let words = ["cut by 2 planes into 3 parts (", "seams ", "uncut: another way was requested"];
    let picture = std::fs::read_to_string(&sheet).unwrap();
    words.iter().for_each(|word| assert!(picture.contains(word), "{word:?} is not in the picture"));
    words.iter().for_each(|word| assert!(said(&done).contains(word), "{word:?}: {}", said(&done)));
    // What no cut helps says both.
    let flat = folder.path().join("flat.toml");
    std::fs::write(&flat, "extends = \"generic-ac\"\n[kinematics.tilt]\nmin_deg = 0.0\nmax_deg = 0.0\n").unwrap();
    let (model, out) = (written(folder.path(), "gate", &gate(40.0)), folder.path().join("gate.gcode"));
    let args = ["prepare", &model, "--slicer", "builtin", "--no-remedies", "-m", flat.to_str().unwrap(), "-o"];
    let gate = trunnion().args(args).arg(&out).args(["--way", "cut"]).output().unwrap();
    assert_eq!(gate.status.code(), Some(1), "{}", said(&gate));
    assert!(said(&gate).contains("cut: "), "{}", said(&gate));
    assert!(!folder.path().join("gate.parts.3mf").exists() && !out.exists());
}

#[test]
fn a_round_body_on_a_slant_is_verified_with_every_slicer() {
    let folder = folder();
    let done = is_verified(folder.path(), "wye", &solids::wye(), &CUT_AT_40);
    assert_eq!(done["cut"]["planes"].as_array().map(Vec::len), Some(1));
}
