//! Machines whose axes are not square: what is printed on them lies where it should, by other code; what is wrong with such a profile is said.

use std::collections::BTreeMap;
use std::path::Path;

use nalgebra::{UnitQuaternion, UnitVector3, Vector3};
use serde_json::Value;
use trunnion::geom::Vec3;
use trunnion::planning::Plan;
use trunnion::profile::{Profile, resolve};

use crate::pipeline::{fixture, prepare};
use crate::support::{folder, note, said, trunnion};

/// By how many degrees each axis of these two machines is off: 0.40 and 0.37, 0.55 and 2.2.
const LEANING: [&str; 2] = [
    "extends = \"generic-ac\"\n[machine]\nname = \"leaning-ac\"\n[kinematics.tilt]\nalong = [0.99998, 0.006, -0.0035]\n\
     [kinematics.rotation]\nalong = [0.005, -0.004, 0.99998]\n",
    "extends = \"generic-bc\"\n[machine]\nname = \"leaning-bc\"\n[kinematics.tilt]\nalong = [0.0045, 0.99995, 0.0085]\n\
     [kinematics.rotation]\nalong = [-0.027, 0.0273, 0.99926]\n",
];

fn profile(text: &str) -> Profile {
    resolve("machine.toml", text).unwrap().0
}

fn about(axis: [f64; 3], degrees: f64) -> UnitQuaternion<f64> {
    UnitQuaternion::from_axis_angle(&UnitVector3::new_normalize(Vector3::from(axis)), degrees.to_radians())
}

/// Where filament is laid, table frame, by the number of the print; each with the line's height over the table.
fn laid(file: &Path, profile: &Profile) -> BTreeMap<usize, Vec<Vec3>> {
    let k = &profile.kinematics;
    let square = if k.tilt.letter == 'A' { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
    let axes = [k.tilt.along.unwrap_or(square), k.rotation.along.unwrap_or([0.0, 0.0, 1.0])];
    let letters = ['X', 'Y', 'Z', k.tilt.letter, k.rotation.letter, 'E'];
    let (mut words, mut print, mut all) = ([0.0; 6], None, BTreeMap::<usize, Vec<Vec3>>::new());
    for line in std::fs::read_to_string(file).unwrap().lines() {
        if let Some(mark) = line.strip_prefix(";TRUNNION print=") {
            print = mark.split(' ').next().unwrap().parse::<usize>().ok();
        }
        if !(line.starts_with("G1 ") || line.starts_with("G0 ")) {
            continue;
        }
        words[5] = 0.0;
        for word in line.split(' ').skip(1) {
            let (letter, value) = word.split_at(1);
            if let Some(place) = letters.iter().position(|l| letter.starts_with(*l)) {
                words[place] = value.parse().unwrap();
            }
        }
        let [x, y, z, a, c, e] = words;
        if let (true, Some(print), true) = (e > 0.0, print, line.contains('X') || line.contains('Y')) {
            let arm = about(axes[0], a).inverse() * (Vector3::new(x, y, z) - Vector3::from(k.pivot_mm));
            let point = about(axes[1], c).inverse() * (arm - Vector3::from(k.offset_mm));
            all.entry(print).or_default().push(point);
        }
    }
    all
}

/// The direction of a print of a plan.
fn along(print: &Value) -> Vec3 {
    Vec3::from_iterator(print["up"].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()))
}

/// The height of the lowest of `points` along `up`, and by how much one is off a whole number of layers above it, at most half of one.
fn off_layers(points: &[Vec3], up: &Vec3) -> (f64, f64) {
    let heights: Vec<f64> = points.iter().map(|p| p.dot(up)).collect();
    let first = heights.iter().copied().fold(f64::INFINITY, f64::min);
    let off = heights.iter().map(|h| ((h - first) / 0.2 - ((h - first) / 0.2).round()).abs() * 0.2);
    (first, off.fold(0.0, f64::max))
}

/// The layers of a tilted print lie across its own direction, and all of it is where the model is: read back with quaternions.
#[test]
fn what_is_printed_with_leaning_axes_is_where_the_model_is() {
    let folder = folder();
    for (number, text) in LEANING.into_iter().enumerate() {
        let path = |name: &str| folder.path().join(format!("{number}{name}"));
        let (own, file, plan) = (path("machine.toml"), path("out.gcode"), path("plan.json"));
        std::fs::write(&own, text).unwrap();
        let more = ["--plan-out", plan.to_str().unwrap()];
        let document = prepare(&fixture("y-tree"), own.to_str().unwrap(), "builtin", &file, &more);
        assert_eq!(document["verify"]["findings"], Value::Array(Vec::new()));
        let plan: Value = serde_json::from_slice(&std::fs::read(&plan).unwrap()).unwrap();
        let prints: Vec<&Value> =
            plan["slots"].as_array().unwrap().iter().flat_map(|slot| slot["prints"].as_array().unwrap()).collect();
        let (mut low, mut high) = (Vec3::from_element(f64::INFINITY), Vec3::from_element(f64::NEG_INFINITY));
        let (mut tilted, mut worst) = (0, 0.0_f64);
        for (print, points) in laid(&file, &profile(text)) {
            let up = along(prints[print]);
            tilted += usize::from(up.z < 0.9);
            let (first, off) = off_layers(&points, &up);
            worst = worst.max(off);
            assert!(up.z < 0.9 || (first - 0.2).abs() < 2e-3, "the first layer is {first} mm above the table");
            for p in points {
                (low, high) = (low.inf(&p), high.sup(&p));
            }
        }
        // Read as if its axes were square, as who does not know of them would print it.
        let square: String =
            text.lines().filter(|line| !line.starts_with("along")).map(|line| format!("{line}\n")).collect();
        let as_square = laid(&file, &profile(&square));
        let tilted_ones = as_square.iter().filter(|(print, _)| along(prints[**print]).z < 0.9);
        let askew = tilted_ones.map(|(print, points)| off_layers(points, &along(prints[*print])).1).fold(0.0, f64::max);
        note(&format!(
            "machine {number}: layers are flat to {worst:.4} mm (square axes would have them {askew:.2} mm askew and more), {tilted} prints are tilted"
        ));
        assert!(askew > 0.05, "{askew}: a reader that sees nothing");
        // Three digits of X, Y and Z and four of an angle, 100 mm from its axis.
        assert!(tilted == 2 && worst < 3e-3, "{tilted} tilted, {worst} mm");
        let stl = std::fs::read(fixture("y-tree")).unwrap();
        let model = trunnion::mesh::read_model(&stl, "y-tree.stl", &trunnion::mesh::ReadOptions::default()).unwrap();
        let origin = plan["placement"]["origin_mm"].as_array().unwrap().iter().map(|v| v.as_f64().unwrap());
        let origin = Vec3::from_iterator(origin);
        for (axis, [least, most]) in [[0.1, 0.45], [0.1, 0.45]].into_iter().enumerate() {
            for inside in
                [low[axis] - model.bounds.min[axis] - origin[axis], model.bounds.max[axis] + origin[axis] - high[axis]]
            {
                assert!((least..most).contains(&inside), "axis {axis}: {inside} mm inside the model");
            }
        }
    }
}

/// A plan for square axes on a machine whose rotation axis leans: from which lean on its tilted prints are seen to be askew.
#[test]
fn a_plan_for_square_axes_is_refused_from_some_lean_on() {
    let folder = folder();
    let (file, plan) = (folder.path().join("square.gcode"), folder.path().join("plan.json"));
    prepare(&fixture("y-tree"), "generic-ac", "builtin", &file, &["--plan-out", plan.to_str().unwrap()]);
    let plan = Plan::parse("plan.json", &std::fs::read_to_string(&plan).unwrap()).unwrap();
    let mut told = Vec::new();
    for lean_deg in [0.0, 1e-5, 1e-4, 5e-4, 2e-3, 0.01, 0.1, 1.0, 4.9] {
        for way in [1.0, -1.0] {
            let (s, c) = f64::to_radians(lean_deg * way).sin_cos();
            let text = format!("extends = \"generic-ac\"\n[kinematics.rotation]\nalong = [{s}, 0.0, {c}]\n");
            let refused = plan.check(&profile(&text).kinematics(), 3).is_err();
            told.push(format!("{} {}", lean_deg * way, if refused { "refused" } else { "passes" }));
            // 0.0011 degrees are what the rounding of a plan's words may come to.
            assert_eq!(refused, lean_deg > 1e-3, "{told:?}");
        }
    }
    note(&format!("a rotation axis that leans, deg: {}", told.join(", ")));
}

#[test]
fn directions_that_no_axis_has_are_refused() {
    let folder = folder();
    let own = folder.path().join("machine.toml");
    for (keys, wanted) in [
        (
            "[kinematics.tilt]\nalong = [0.0, 1.0, 0.0]",
            "90.00 deg from it (direction of the axis while both angles are zero)",
        ),
        (
            "[kinematics.tilt]\nalong = [-1.0, 0.0, 0.0]",
            "kinematics.tilt.along = [-1.0, 0.0, 0.0]: must be within 5 deg of +X",
        ),
        ("[kinematics.rotation]\nalong = [0.1, 0.0, 1.0]", "must be within 5 deg of +Z, and is 5.71 deg from it"),
        (
            "[kinematics.rotation]\nalong = [0.0, 0.0, 0.0]",
            "kinematics.rotation.along = [0.0, 0.0, 0.0]: must be a vector of length 1",
        ),
        ("[kinematics.rotation]\nalong = [0.0, nan, 1.0]", "kinematics.rotation.along = nan: must be -2..2"),
        ("[kinematics.rotation]\nalong = [0.0, 1.0]", "along"),
        ("[kinematics.rotation]\nalnog = [0.0, 0.0, 1.0]", "nearest is \"kinematics.rotation.along\""),
    ] {
        std::fs::write(&own, format!("extends = \"generic-ac\"\n{keys}\n")).unwrap();
        let run = trunnion().args(["profile", "check"]).arg(&own).output().unwrap();
        assert!(!run.status.success() && said(&run).contains(wanted), "{keys}: {}", said(&run));
        assert!(said(&run).contains("machine.toml:3"), "{keys}: {}", said(&run));
    }
    // Square axes, said so, are the machine without these keys.
    let said_square = "extends = \"generic-ac\"\n[kinematics.tilt]\nalong = [1.0, 0.0, 0.0]\n[kinematics.rotation]\nalong = [0.0, 0.0, 1.0]\n";
    assert_eq!(profile(said_square).kinematics(), profile("extends = \"generic-ac\"\n").kinematics());
}

/// What follows from such axes is told in words and as a document.
#[test]
fn profile_check_tells_what_leaning_axes_do() {
    let folder = folder();
    let own = folder.path().join("machine.toml");
    std::fs::write(&own, LEANING[0]).unwrap();
    let run = trunnion().args(["profile", "check"]).arg(&own).output().unwrap();
    let wanted = "A points 0.40 deg from X and C 0.37 deg from Z; level at A0 C0, the table's rim rises and falls by up to 1.28 mm as C turns";
    assert!(run.status.success() && said(&run).contains(wanted), "{}", said(&run));
    let run = trunnion().args(["profile", "check", "--json"]).arg(&own).output().unwrap();
    let document: Value = serde_json::from_slice(&run.stdout).unwrap();
    let degrees: Vec<f64> = document["axes_off_deg"].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect();
    assert!((degrees[0] - 0.398).abs() < 1e-3 && (degrees[1] - 0.367).abs() < 1e-3, "{degrees:?}");
}
