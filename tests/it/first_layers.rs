//! `[joint]`: the first layers of a print that begins on an earlier part, from the profile to the verified file, with the built-in
//! slicer and the real ones; and what verification says of a file that has them otherwise.

use std::path::{Path, PathBuf};

use serde_json::Value;
use trunnion::fixtures::solid_box;
use trunnion::geom::Vec3;
use trunnion::mesh::stl_binary_parts;

use crate::pipeline::{fixture, prepare};
use crate::support::{fails, folder, installed, said, skip, trunnion};

/// A post of two parts on each other: the upper one is printed upright on the lower one, `height` mm high.
fn post(folder: &Path, height: f64) -> String {
    let lower = solid_box(Vec3::zeros(), Vec3::new(12.0, 12.0, height));
    let upper = solid_box(Vec3::new(0.0, 0.0, height), Vec3::new(12.0, 12.0, height + 3.0));
    let path = folder.join("post.stl");
    std::fs::write(&path, stl_binary_parts(&[&lower, &upper])).unwrap();
    path.display().to_string()
}

fn machine(folder: &Path, name: &str, keys: &str) -> PathBuf {
    let path = folder.join(format!("{name}.toml"));
    std::fs::write(&path, format!("extends = \"generic-ac\"\n{keys}")).unwrap();
    path
}

const JOINT: &str = "[joint]\nlayers = 2\noverlap_mm = 0.08\nmm_per_s = 12.0\nfan = 0.25\nnozzle_c = 222.0\n";

/// The post on a machine with these keys, verified; the file.
fn printed(folder: &Path, name: &str, slicer: &str, keys: &str) -> String {
    let machine = machine(folder, name, keys);
    let (file, plan) = (folder.join(format!("{name}.gcode")), folder.join(format!("{name}.json")));
    let model = post(folder, 6.0);
    let document =
        prepare(&model, machine.to_str().unwrap(), slicer, &file, &["--plan-out", &plan.display().to_string()]);
    assert_eq!(document["verify"]["findings"], Value::Array(Vec::new()), "{name}");
    std::fs::read_to_string(file).unwrap()
}

/// What is laid at each height, by a reader of its own that knows relative E and nothing else: height, filament, fastest F, and the
/// nozzle and fan set last, of the lines behind the mark of `print`.
#[derive(Debug)]
struct Layer {
    z: f64,
    e: f64,
    feed: f64,
    nozzle: String,
    fan: String,
}

fn layers(text: &str, print: usize) -> Vec<Layer> {
    let (mut ours, mut z, mut feed, mut nozzle, mut fan) = (false, 0.0, 0.0, String::new(), String::new());
    let mut all: Vec<Layer> = Vec::new();
    for line in text.lines() {
        if line.starts_with(";TRUNNION print=") {
            ours = line.starts_with(&format!(";TRUNNION print={print} "));
        }
        if line.starts_with("M104") || line.starts_with("M109") {
            line.clone_into(&mut nozzle);
        } else if line.starts_with("M106") || line.starts_with("M107") {
            line.clone_into(&mut fan);
        }
        if !line.starts_with("G1 ") {
            continue;
        }
        let word = |letter: char| line.split(' ').find_map(|w| w.strip_prefix(letter)?.parse::<f64>().ok());
        (z, feed) = (word('Z').unwrap_or(z), word('F').unwrap_or(feed));
        let lays = word('E').is_some_and(|e| e > 0.0) && (word('X').is_some() || word('Y').is_some());
        if !lays || !ours {
            continue;
        }
        if all.last().is_none_or(|layer| (layer.z - z).abs() > 1e-6) {
            all.push(Layer { z, e: 0.0, feed: 0.0, nozzle: nozzle.clone(), fan: fan.clone() });
        }
        let layer = all.last_mut().unwrap();
        (layer.e, layer.feed) = (layer.e + word('E').unwrap(), layer.feed.max(feed));
    }
    all
}

#[test]
fn nothing_asked_for_changes_nothing() {
    let folder = folder();
    let plain = printed(folder.path(), "plain", "builtin", "[machine]\nname = \"x\"\n");
    let said =
        printed(folder.path(), "said", "builtin", "[machine]\nname = \"x\"\n[joint]\nlayers = 1\noverlap_mm = 0.0\n");
    // The plan names the profile's file, so its hash is another one each time. More layers of nothing are nothing.
    let more = printed(folder.path(), "more", "builtin", "[machine]\nname = \"x\"\n[joint]\nlayers = 5\n");
    let without_plan = |text: &str| text.replace(text.split("plan=").nth(1).unwrap().split(' ').next().unwrap(), "");
    assert_eq!(without_plan(&plain), without_plan(&said));
    assert_eq!(without_plan(&plain), without_plan(&more));
}

#[test]
fn the_first_layers_on_an_earlier_part_are_pressed_slow_and_hot() {
    for slicer in ["builtin", "prusa-slicer", "slic3r"] {
        if slicer != "builtin" && !installed(slicer) {
            skip(&format!("{slicer} is not installed: its first layers are not tried"));
            continue;
        }
        let folder = folder();
        let plain = printed(folder.path(), "plain", slicer, "");
        let joint = printed(folder.path(), "joint", slicer, JOINT);
        assert_eq!(layers(&plain, 0).len(), layers(&joint, 0).len());
        for (a, b) in layers(&plain, 0).iter().zip(layers(&joint, 0)) {
            assert!((a.z, a.feed) == (b.z, b.feed) && (a.e - b.e).abs() < 1e-6, "{slicer}: on the table: {a:?} {b:?}");
        }
        let (plain, joint) = (layers(&plain, 1), layers(&joint, 1));
        assert!(plain.len() == joint.len() && plain.len() > 10, "{slicer}: {} {}", plain.len(), joint.len());
        for (index, (a, b)) in plain.iter().zip(&joint).enumerate() {
            let at = format!("{slicer}, layer {index}: {a:?} {b:?}");
            assert!((a.z - b.z - if index == 0 { 0.08 } else { 0.0 }).abs() < 1e-6, "{at}");
            // Of lines of 0.45 mm one of 0.28 mm holds 1.341 times one of 0.2 where its sides are round (w h - h^2 (1 - pi / 4)), 1.4 times
            // where it is a rectangle; wider ones less.
            let allowed = match (index, slicer) {
                (1, "builtin") => 1.33..=1.35,
                (1, _) => 1.3..=1.41,
                _ => 0.9999..=1.0001,
            };
            assert!(allowed.contains(&(b.e / a.e)), "{at}: {} for {allowed:?}", b.e / a.e);
            if index < 2 {
                assert!(b.feed <= 720.0 && a.feed > 720.0, "{at}");
                assert_eq!((b.nozzle.as_str(), b.fan.as_str()), ("M109 S222", "M106 S63.75"), "{at}");
            } else {
                assert!(b.feed == a.feed && !b.nozzle.contains("222") && b.fan == a.fan, "{at}");
                // Nobody waits with the nozzle on the part.
                assert!(b.nozzle.starts_with("M104"), "{at}");
            }
        }
    }
}

#[test]
fn tilted_prints_and_prints_that_take_turns_stay_clean() {
    let all = [("y-tree", "builtin"), ("candelabrum", "builtin"), ("y-tree", "prusa-slicer"), ("two-boxes", "slic3r")];
    for (model, slicer) in all {
        if slicer != "builtin" && !installed(slicer) {
            skip(&format!("{slicer} is not installed: {model} is not tried"));
            continue;
        }
        let folder = folder();
        let machine = machine(folder.path(), "joint", &JOINT.replace("0.08", "0.1"));
        let file = folder.path().join("out.gcode");
        let document = prepare(&fixture(model), machine.to_str().unwrap(), slicer, &file, &[]);
        assert_eq!(document["verify"]["findings"], Value::Array(Vec::new()), "{model}, {slicer}");
        let text = std::fs::read_to_string(&file).unwrap();
        assert!(text.contains("\nM109 S222\n") && text.contains("\nM106 S63.75\n"), "{model}, {slicer}");
    }
}

fn rules(folder: &Path, name: &str, text: &str) -> Vec<String> {
    let file = folder.join("changed.gcode");
    std::fs::write(&file, text).unwrap();
    let run = trunnion()
        .arg("verify")
        .arg(file)
        .arg("--plan")
        .arg(folder.join(format!("{name}.json")))
        .arg("--json")
        .output();
    let run = run.unwrap();
    let report: Value = serde_json::from_slice(&run.stdout).unwrap_or_else(|_| panic!("{}", said(&run)));
    let mut rules: Vec<String> =
        report["findings"].as_array().unwrap().iter().map(|f| f["rule"].as_str().unwrap().to_owned()).collect();
    rules.dedup();
    rules
}

/// The first layer of the upper part laid lower or higher than the profile says, from nothing to gross, both ways.
#[test]
fn an_overlap_that_is_not_the_profiles_is_found() {
    let folder = folder();
    let text = printed(folder.path(), "swept", "builtin", JOINT);
    let first = layers(&text, 1)[0].z;
    let lifted = |by: f64| {
        let begins = text.find(";TRUNNION print=1 ").unwrap();
        let (before, after) = text.split_at(begins);
        let z = format!("Z{first} ");
        assert!(after.contains(&z), "{z}");
        format!("{before}{}", after.replacen(&z, &format!("Z{:.3} ", first + by), 1))
    };
    for (by, seen) in [
        (0.0, false),
        (0.01, false),
        (0.03, false),
        (-0.03, false),
        (0.05, true),
        (-0.05, true),
        // None at all, and twice as much.
        (0.08, true),
        (-0.08, true),
        (0.2, true),
        (-0.15, true),
        (1.0, true),
    ] {
        let found = rules(folder.path(), "swept", &lifted(by));
        assert_eq!(found.iter().any(|rule| rule == "layer-height" || rule == "in-air"), seen, "{by}: {found:?}");
        assert!(seen || found.is_empty(), "{by}: {found:?}");
    }
    // The second layer stated as high as sliced, with the filament of one that is higher.
    let [_, second] = [0.2, 0.28].map(|mm| format!(";HEIGHT:{mm:.3}\n"));
    assert_eq!(text.matches(&second).count(), 1);
    let found = rules(folder.path(), "swept", &text.replace(&second, ";HEIGHT:0.2\n"));
    assert!(found.iter().any(|rule| rule == "flow") && found.iter().any(|rule| rule == "layer-height"), "{found:?}");
}

#[test]
fn what_cannot_be_is_refused_in_words() {
    let folder = folder();
    let refused = |keys: &str| {
        let machine = machine(folder.path(), "wrong", keys);
        let run = trunnion().args(["profile", "check"]).arg(machine).output().unwrap();
        assert_eq!(run.status.code(), Some(2), "{keys}: {}", said(&run));
        said(&run)
    };
    for (keys, words) in [
        ("[joint]\noverlap_mm = 0.2", "joint.overlap_mm = 0.2: must be 0..0.1 mm"),
        (
            "[joint]\noverlap_mm = 0.1\n[process]\nlayer_height_mm = 0.15",
            "joint.overlap_mm = 0.1: must be 0..0.075 mm, half of process.layer_height_mm",
        ),
        (
            "[joint]\nnozzle_c = 300.0",
            "joint.nozzle_c = 300: must be 170..260 deg C (limits.min_extrude_c, link.max_nozzle_c)",
        ),
        ("[joint]\nnozzle_c = 20.0", "joint.nozzle_c = 20: must be 170..260 deg C"),
        ("[joint]\nfan = 50.0", "joint.fan = 50.0: must be 0..1"),
        ("[joint]\nlayers = 0", "joint.layers = 0: must be 1..20"),
        ("[joint]\nmm_per_s = 0.0", "joint.mm_per_s = 0.0: must be 0.1..2000 mm/s"),
        ("[joint]\noverlap = 0.1", "joint.overlap_mm"),
    ] {
        assert!(refused(keys).contains(words), "{keys}: {}", refused(keys));
    }
    // 6.12 mm are printed as 31 layers of 0.2 mm, so that the upper part has 0.12 mm of room: the overlap would take most of it.
    let machine = machine(folder.path(), "joint", &JOINT.replace("0.08", "0.1"));
    let out = folder.path().join("out.gcode");
    let mut command = trunnion();
    command.args(["prepare", &post(folder.path(), 6.12), "--slicer", "builtin", "-q", "-m"]).arg(&machine);
    let run = command.arg("-o").arg(&out).output().unwrap();
    let text = said(&run);
    assert!(!run.status.success() && !out.exists(), "{text}");
    assert!(fails(&text, "rewrite/pressed: 0.120 mm | overlap_mm = 0.1 | 0.060"), "{text}");
}

/// Slow first layers are in the time that a plan is priced by, before anything is sliced.
#[test]
fn the_plan_knows_how_slowly_first_layers_are_laid() {
    let folder = folder();
    let model = post(folder.path(), 6.0);
    let of = |name: &str, keys: &str| {
        let machine = machine(folder.path(), name, keys);
        let file = folder.path().join(format!("{name}.gcode"));
        let document = prepare(&model, machine.to_str().unwrap(), "builtin", &file, &[]);
        [&document["plan"]["seconds_print_estimate"], &document["verify"]["seconds_print"]].map(|s| s.as_f64().unwrap())
    };
    let [planned, counted] = of("usual", "");
    let [slow_planned, slow_counted] = of("slow", "[joint]\nlayers = 4\nmm_per_s = 4.0\n");
    let (told, true_one) = (slow_planned - planned, slow_counted - counted);
    crate::support::note(&format!("slow first layers take {true_one:.0} s more, and the plan says {told:.0} s"));
    assert!(true_one > 60.0 && (told / true_one - 1.0).abs() < 0.3, "{told} s for {true_one} s");
}
