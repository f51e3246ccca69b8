//! Assemblies as people draw them, from one file to a verified one: gaps, overlaps, models turned and beside each other.

use std::fs;
use std::path::Path;
use std::process::Output;

use serde_json::Value;
use trunnion::fixtures::solid_box;
use trunnion::geom::{Object, Vec3};
use trunnion::mesh::{ReadOptions, TriangleMesh, read_model, stl_binary_parts};

use crate::split::solids::{Shape, block, rod};
use crate::support::{every, fails, folder as new_folder, installed, note, root, skip, states, trunnion};

fn run(folder: &Path, args: &[&str]) -> Output {
    trunnion().current_dir(folder).args(args).output().unwrap()
}

fn written(folder: &Path, name: &str, parts: &[TriangleMesh<Object>]) {
    fs::write(folder.join(name), stl_binary_parts(&parts.iter().collect::<Vec<_>>())).unwrap();
}

fn boxed(from: [f64; 3], to: [f64; 3]) -> TriangleMesh<Object> {
    solid_box(Vec3::from(from), Vec3::from(to))
}

/// A post on a plate and an arm on the post, so far apart (negative: overlapping).
pub(crate) fn tree(gap: f64) -> [TriangleMesh<Object>; 3] {
    [
        boxed([-20.0, -20.0, 0.0], [20.0, 20.0, 8.0]),
        boxed([-6.0, -6.0, 8.0 + gap], [6.0, 6.0, 60.0]),
        boxed([6.0 + gap, -5.0, 40.0], [40.0, 5.0, 50.0]),
    ]
}

fn prepared(folder: &Path, model: &str, more: &[&str]) -> Output {
    prepared_by("builtin", folder, model, more)
}

fn prepared_by(slicer: &str, folder: &Path, model: &str, more: &[&str]) -> Output {
    let args = ["prepare", model, "-m", "generic-ac", "--slicer", slicer, "-o", "out.gcode", "--json"];
    run(folder, &[&args[..], more].concat())
}

#[test]
fn gaps_and_overlaps_go_to_a_verified_file() {
    let folder = new_folder();
    let here = folder.path();
    for gap in [0.0, 0.04, 0.1, 0.2, -0.07, -0.36, -3.0] {
        written(here, "tree.stl", &tree(gap));
        let done = prepared(here, "tree.stl", &["--plan-out", "out.json"]);
        let told = String::from_utf8_lossy(&done.stderr).into_owned();
        assert!(done.status.success(), "{gap}: {told}");
        let document: Value = serde_json::from_slice(&done.stdout).unwrap();
        let changes = document["plan"]["arranged"]["changes"].as_array().map_or(0, Vec::len);
        // Up to 0.05 mm either way parts touch.
        assert_eq!(changes, if gap.abs() > 0.051 { 2 } else { 0 }, "{gap}: {told}");
        assert_eq!(here.join("out.parts.3mf").exists(), changes > 0, "{gap}");
        if changes > 0 {
            let parts = fs::read(here.join("out.parts.3mf")).unwrap();
            let model = read_model(&parts, "out.parts.3mf", &ReadOptions::default()).unwrap();
            assert_eq!(model.interfaces.len(), 2, "{gap}");
            assert_eq!(document["plan"]["model"]["file"], "out.parts.3mf");
            assert!(told.contains(if gap > 0.0 { "was closed" } else { "mm3 were removed from it" }), "{told}");
            let verify = run(here, &["verify", "out.gcode", "--plan", "out.json"]);
            assert!(verify.status.success(), "by the plan and the model beside it: {verify:?}");
        }
        fs::remove_file(here.join("out.gcode")).unwrap();
        let _ = fs::remove_file(here.join("out.parts.3mf"));
    }
}

/// Two blocks that stand beside each other, printed together: their lines keep the gap that was drawn.
#[test]
fn what_stands_by_itself_is_printed_with_its_gap() {
    let folder = new_folder();
    let here = folder.path();
    for gap in [0.1, 0.2] {
        written(
            here,
            "joint.stl",
            &[boxed([0.0; 3], [10.0, 10.0, 2.0]), boxed([10.0 + gap, 0.0, 0.0], [20.0, 10.0, 2.0])],
        );
        let done = prepared(here, "joint.stl", &[]);
        let told = String::from_utf8_lossy(&done.stderr);
        assert!(done.status.success() && !told.contains("was closed"), "{gap}: {told}");
        assert!(!here.join("out.parts.3mf").exists(), "{gap}");
        let document: Value = serde_json::from_slice(&done.stdout).unwrap();
        let joints = document["verify"]["joints"].as_array().unwrap();
        assert_eq!(joints.len(), 1, "{joints:?}");
        assert_eq!(joints[0]["parts"], serde_json::json!([0, 1]));
        let said = joints[0]["gap_mm"].as_f64().unwrap();
        let (mut print, mut x, mut reach) = (0, 0.0_f64, [f64::NEG_INFINITY, f64::INFINITY]);
        for line in fs::read_to_string(here.join("out.gcode")).unwrap().lines() {
            if let Some(number) = line.strip_prefix(";TRUNNION print=") {
                print = number.split(' ').next().unwrap().parse().unwrap();
            }
            let word = |letter: char| line.split(' ').find_map(|w| w.strip_prefix(letter)?.parse::<f64>().ok());
            let before = x;
            x = word('X').unwrap_or(x);
            if line.starts_with("G1 ") && word('E').is_some() && (word('X').is_some() || word('Y').is_some()) {
                let ends = [before, x];
                reach[print] = ends.into_iter().fold(reach[print], if print == 0 { f64::max } else { f64::min });
            }
        }
        let left = reach[1] - reach[0] - 0.45;
        assert!((left - gap).abs() < 0.06, "{gap}: {left} mm between the lines");
        // Widths follow from what is extruded; the file's own comment says 0.45.
        assert!((said - left).abs() < 0.02, "{gap}: {said} mm said, {left} mm measured");
    }
}

#[test]
fn what_is_too_far_apart_is_told_with_its_distance() {
    let folder = new_folder();
    let here = folder.path();
    written(here, "tree.stl", &tree(0.3));
    let done = prepared(here, "tree.stl", &[]);
    let told = String::from_utf8_lossy(&done.stderr).into_owned();
    assert!(!done.status.success() && !here.join("out.gcode").exists());
    assert!(fails(&told, "plan/floating: part 0 | 0.30 mm | --snap"), "{told}");
    assert!(prepared(here, "tree.stl", &["--snap", "0.3"]).status.success());
    for snap in ["1.5", "-0.1"] {
        let done = prepared(here, "tree.stl", &[&format!("--snap={snap}")]);
        let said = String::from_utf8_lossy(&done.stderr);
        assert!(fails(&said, &format!("setting/out-of-range: --snap | 0 and 1 | got {snap} mm")), "{said}");
    }
    written(here, "over.stl", &tree(-0.3));
    let done = prepared(here, "over.stl", &["--snap", "0"]);
    assert!(!done.status.success(), "as drawn: {}", String::from_utf8_lossy(&done.stderr));
    let inspected = run(here, &["inspect", "tree.stl"]);
    assert!(states(&String::from_utf8_lossy(&inspected.stdout), "part 1 | 0.30 mm | part 0"));
    // Two bars through each other: neither stays whole, and any slicer prints one cross.
    written(
        here,
        "cross.stl",
        &[boxed([-20.0, -3.0, 0.0], [20.0, 3.0, 6.0]), boxed([-3.0, -20.0, 0.0], [3.0, 20.0, 6.0])],
    );
    let done = prepared(here, "cross.stl", &[]);
    let said = String::from_utf8_lossy(&done.stderr);
    assert!(done.status.success() && said.contains("joined"), "{said}");
    let document: Value = serde_json::from_slice(&done.stdout).unwrap();
    assert_eq!(document["plan"]["parts"].as_array().unwrap().len(), 1);
}

/// A pipe along z and a round arm drawn into it, leaning by so much from the upright.
fn saddle(lean_deg: f64) -> [TriangleMesh<Object>; 2] {
    let arm: Shape = rod(7.0, 60.0, 48).about_y(lean_deg).at(0.0, 0.0, 35.0);
    [rod(15.0, 80.0, 64).mesh(), arm.mesh()]
}

#[test]
fn a_round_arm_on_a_round_pipe_is_cut_along_it() {
    let folder = new_folder();
    let here = folder.path();
    let mut slicers = vec!["builtin"];
    if installed("prusa-slicer") {
        slicers.push("prusa-slicer");
    } else {
        skip("PrusaSlicer is not installed");
    }
    for (index, lean) in [60.0, 70.0].into_iter().enumerate() {
        // In the suite each with one of them.
        for slicer in slicers.iter().skip(index.min(every(2) - 1)).step_by(every(2)) {
            written(here, "saddle.stl", &saddle(lean));
            let args = ["prepare", "saddle.stl", "-m", "generic-ac", "--slicer", slicer, "-o", "out.gcode"];
            let done = run(here, &args);
            assert!(done.status.success(), "{lean} {slicer}: {}", String::from_utf8_lossy(&done.stderr));
        }
    }
}

#[test]
fn models_are_turned_and_stand_beside_each_other() {
    let folder = new_folder();
    let here = folder.path();
    // A T, which hangs as it is drawn.
    let tee = block(10.0, 10.0, 40.0).and(&block(40.0, 10.0, 10.0).at(-15.0, 0.0, 40.0));
    written(here, "tee.stl", &[tee.mesh()]);
    let plan = |more: &[&str]| {
        let args = ["plan", "tee.stl", "-m", "generic-ac", "-o", "tee.json", "--json"];
        run(here, &[&args[..], more].concat())
    };
    let turned = plan(&["--up", "0,0,-1"]);
    assert!(turned.status.success(), "{}", String::from_utf8_lossy(&turned.stderr));
    let document: Value = serde_json::from_slice(&turned.stdout).unwrap();
    assert!(document["arranged"]["changes"][0].as_str().unwrap().contains("(0.0000, 0.0000, -1.0000) up"));
    let model = read_model(&fs::read(here.join("tee.parts.3mf")).unwrap(), "x.3mf", &ReadOptions::default()).unwrap();
    assert!((model.parts[0].mesh.bounds().size().z - 50.0).abs() < 1e-9);
    for (more, says) in [
        (["--up", "0,0,0"], "setting/direction: --up 0,0,0"),
        (["--up", "0,0"], "command/usage: '--up <X,Y,Z>' | '0,0' | 0,0,1"),
        (["--up", "best"], "command/usage: '--up <X,Y,Z>' | 'best' | auto"),
        (["--base", "3"], "setting/no-such-part: 3 | tee.stl | 0..0"),
        (["--gap", "0"], "setting/out-of-range: --gap | 0.5 and 500 | got 0 mm"),
    ] {
        let done = plan(&more);
        assert!(!done.status.success());
        assert!(fails(&String::from_utf8_lossy(&done.stderr), says), "{more:?}: {done:?}");
    }
    // Laid down, as a person would print them; each model by itself.
    let chosen = plan(&["--up", "auto", "slab.stl"]);
    assert!(!chosen.status.success(), "there is no slab yet");
    written(here, "slab.stl", &[boxed([0.0; 3], [2.0, 40.0, 30.0])]);
    let chosen = plan(&["--up", "auto", "slab.stl"]);
    assert!(chosen.status.success(), "{}", String::from_utf8_lossy(&chosen.stderr));
    let document: Value = serde_json::from_slice(&chosen.stdout).unwrap();
    let changes = document["arranged"]["changes"].as_array().unwrap();
    assert!(states(changes[0].as_str().unwrap(), "1.0000, 0.0000) up | orient"), "{changes:?}");
    assert!(changes[1].as_str().unwrap().starts_with("slab.stl "), "{changes:?}");
    let model = read_model(&fs::read(here.join("tee.parts.3mf")).unwrap(), "x.3mf", &ReadOptions::default()).unwrap();
    let heights: Vec<f64> = model.parts.iter().map(|part| part.mesh.bounds().size().z).collect();
    assert!((heights[0] - 10.0).abs() < 1e-6 && (heights[1] - 2.0).abs() < 1e-6, "{heights:?}");
    written(here, "two.stl", &[boxed([0.0; 3], [9.0; 3]), boxed([0.0, 0.0, 9.0], [9.0, 9.0, 20.0])]);
    let several = run(here, &["plan", "two.stl", "-m", "generic-ac", "-o", "two.json", "--up", "auto"]);
    assert!(
        fails(&String::from_utf8_lossy(&several.stderr), "setting/several-to-stand: two.stl | 2 parts"),
        "{several:?}"
    );
    written(here, "cube.stl", &[boxed([0.0; 3], [12.0; 3])]);
    written(here, "post.stl", &[boxed([5.0; 3], [15.0, 15.0, 45.0])]);
    let args =
        ["prepare", "cube.stl*3", "post.stl", "-m", "generic-ac", "--slicer", "builtin", "-o", "all.gcode", "--json"];
    let done = run(here, &args);
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let document: Value = serde_json::from_slice(&done.stdout).unwrap();
    assert_eq!(document["plan"]["parts"].as_array().unwrap().len(), 4);
    let model = read_model(&fs::read(here.join("all.parts.3mf")).unwrap(), "x.3mf", &ReadOptions::default()).unwrap();
    assert_eq!((model.parts.len(), model.on_table.len()), (4, 4));
    let twice = run(here, &["prepare", "cube.stl*0", "-m", "generic-ac", "-o", "none.gcode"]);
    assert!(fails(&String::from_utf8_lossy(&twice.stderr), "setting/out-of-range: 1 and 1000 | got 0"), "{twice:?}");
    let many = run(here, &["prepare", "cube.stl*400", "-m", "generic-ac", "-o", "none.gcode"]);
    assert!(!many.status.success() && !here.join("none.gcode").exists());
}

#[test]
fn overlapping_shells_are_joined_and_cut_again() {
    let folder = new_folder();
    let here = folder.path();
    // A T of two shells, as drawn by somebody who never joined them.
    written(
        here,
        "tee.stl",
        &[boxed([-5.0, -5.0, 0.0], [5.0, 5.0, 45.0]), boxed([-30.0, -5.0, 40.0], [30.0, 5.0, 50.0])],
    );
    let done = prepared(here, "tee.stl", &["--join", "--way", "cut"]);
    let told = String::from_utf8_lossy(&done.stderr).into_owned();
    assert!(done.status.success(), "{told}");
    assert!(states(&told, "part 1 | part 0") && states(&told, "2 planes"), "{told}");
    let document: Value = serde_json::from_slice(&done.stdout).unwrap();
    assert_eq!(document["plan"]["parts"].as_array().unwrap().len(), 3);
    let both = prepared(here, "tee.stl", &["--join", "--snap", "0.1"]);
    assert!(fails(&String::from_utf8_lossy(&both.stderr), "command/usage: '--join' | '--snap <MM>'"), "{both:?}");
}

/// The candelabrum as one solid: what somebody would have drawn who has never heard of several parts.
#[test]
#[ignore = "two minutes: scripts/soak.sh"]
fn the_candelabrum_as_one_solid_is_cut_and_verified() {
    for slicer in ["builtin", "prusa-slicer"] {
        if slicer == "prusa-slicer" && !installed(slicer) {
            skip("the candelabrum as one solid: PrusaSlicer is not installed");
            continue;
        }
        let folder = new_folder();
        let here = folder.path();
        fs::copy(root().join("fixtures/candelabrum.stl"), here.join("candelabrum.stl")).unwrap();
        let done = prepared_by(slicer, here, "candelabrum.stl", &["--join", "--way", "cut"]);
        let told = String::from_utf8_lossy(&done.stderr).into_owned();
        assert!(done.status.success() && !told.contains("instead"), "{slicer}: {told}");
        let document: Value = serde_json::from_slice(&done.stdout).unwrap();
        let cut = &document["cut"];
        let (cuts, parts) = (cut["planes"].as_array().unwrap().len(), cut["parts"].as_u64().unwrap());
        let left = cut["needs_support_mm2"]["after"].as_f64().unwrap();
        note(&format!("the candelabrum as one solid, {slicer}: {cuts} cuts, {parts} parts, {left} mm2 left"));
        // Drawn in parts it has eighteen.
        assert!(cuts <= 8 && parts <= 18 && left <= 0.45 * parts as f64, "{cut}");
    }
}

/// A roof over a foot, the two joined by a stem that no head gets into: as parts there is no plan, as one solid there is, on supports or
/// without, and the answer says so; it is also what happens.
#[test]
fn parts_that_have_no_plan_and_one_as_one_solid_are_told_to_be_joined() {
    let folder = new_folder();
    let here = folder.path();
    fs::copy(root().join("fixtures/caged.stl"), here.join("caged.stl")).unwrap();
    let table = [
        boxed([-8.0, -8.0, 0.0], [8.0, 8.0, 30.0]),
        boxed([-30.0, -30.0, 30.0], [30.0, 30.0, 34.0]),
        boxed([-30.0, -30.0, 34.0], [30.0, 30.0, 36.0]),
    ];
    written(here, "table.stl", &table);
    // Tilted, the plates could be printed; this machine does not.
    fs::write(
        here.join("level.toml"),
        "extends = \"generic-ac\"\n[machine]\nname = \"level\"\n[kinematics.tilt]\nmin_deg = -1.0\nmax_deg = 1.0\n",
    )
    .unwrap();
    for (model, machine, on_supports) in [("caged.stl", "generic-ac", false), ("table.stl", "level.toml", true)] {
        // On supports they would be one solid at once, where that prints as it was drawn.
        let supports = if on_supports { "auto" } else { "never" };
        let run = run(here, &["plan", model, "-m", machine, "--supports", supports, "--json"]);
        let document: Value = serde_json::from_slice(&run.stdout).unwrap();
        let remedies = document["remedies"].as_array().unwrap();
        let join = remedies.iter().find(|r| r["kind"] == "join").unwrap_or_else(|| panic!("{model}: {document}"));
        assert_eq!(join["amount"], 1.0, "{model}");
        let text = join["text"].as_str().unwrap();
        assert_eq!((text.contains("--join"), text.contains("on supports")), (true, on_supports), "{text}");
        let done =
            self::run(here, &["prepare", model, "-m", machine, "--slicer", "builtin", "--join", "-o", "out.gcode"]);
        assert!(done.status.success(), "{model}: {}", crate::support::said(&done));
    }
    // Nobody has to ask for what every slicer does.
    let one = prepared(here, "caged.stl", &[]);
    let told = String::from_utf8_lossy(&one.stderr).into_owned();
    assert!(one.status.success() && states(&told, "joined to"), "{told}");
    // Where it was asked for, it is not proposed.
    let joined = run(here, &["plan", "caged.stl", "-m", "generic-ac", "--join", "--json"]);
    assert!(!String::from_utf8_lossy(&joined.stdout).contains("\"join\""));
}
