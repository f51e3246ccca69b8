//! The command: a form that is filled in, and the profile that comes of it.

use nalgebra::Vector3;
use trunnion::calibrate::{Of, Tip, TouchShape};
use trunnion::geom::SplitMix64;

use super::profile;
use super::touched::{Machine, normal};
use crate::support::{fails, folder, said, states, trunnion};

const OWN: &str =
    "extends = \"generic-ac\"\n[machine]\nname = \"mine\"\n[kinematics]\npivot_mm = [10.0, -5.0, -30.0]\n";

/// `form` with what a person would read off `machine`, the touch with the number `slipped` wrong by a millimetre.
fn filled(form: &str, machine: &Machine, slipped: Option<usize>, numbers: &mut SplitMix64) -> String {
    let values: toml::Table = form.parse().unwrap();
    let tip = Tip { paper_mm: 0.1, ..Tip::default() };
    let number = |value: &toml::Value| value.as_float().unwrap();
    let near: Vec<[f64; 2]> = form
        .lines()
        .filter_map(|line| line.strip_prefix("# ")?.split_once(": A")?.1.split_once("near X"))
        .map(|(_, rest)| {
            let (x, rest) = rest.split_once(" Y").unwrap();
            [x.parse().unwrap(), rest.split_once(" Z").unwrap().0.parse().unwrap()]
        })
        .collect();
    let touches = values["touch"].as_array().unwrap();
    assert_eq!(near.len(), touches.len());
    let mut out = form.to_owned();
    for (i, touch) in touches.iter().enumerate() {
        let words = [number(&touch["tilt_deg"]), number(&touch["rotation_deg"])];
        let mark = |at: [f64; 2]| {
            let shape = TouchShape::Mark { height: 0.0, known: None };
            machine.touch(Of::Feature(0), words, near[i], Vector3::new(at[0], at[1], 0.0), Some(shape), &tip).at
        };
        let at = match touch["of"].as_str().unwrap() {
            "mark-x" => mark([93.0, 1.0]),
            "mark-y" => mark([-0.5, 94.5]),
            _ => machine.touch(Of::Table, words, near[i], Vector3::zeros(), None, &tip).at,
        };
        let slip = if slipped == Some(i + 1) { 1.0 } else { 0.0 };
        let mut shown = || normal(numbers) * 0.02;
        let [x, y, z] = [at.x + shown(), at.y + shown(), at.z + shown() + slip];
        out = out.replacen("at_mm = []", &format!("at_mm = [{x:.3}, {y:.3}, {z:.3}]"), 1);
    }
    out
}

/// Writes `machine.toml` and what was touched on such a machine, `touches.toml`.
pub(crate) fn touched(folder: &std::path::Path) {
    std::fs::write(folder.join("machine.toml"), OWN).unwrap();
    let words = ["profile", "calibrate", "-m", "machine.toml", "--poses", "form.toml"];
    let made = trunnion().args(words).current_dir(folder).output().unwrap();
    assert!(made.status.success(), "{}", said(&made));
    let mut numbers = SplitMix64::seeded(30);
    let machine = Machine::any(profile(OWN).kinematics(), &mut numbers, 0.0);
    let form = std::fs::read_to_string(folder.join("form.toml")).unwrap();
    std::fs::write(folder.join("touches.toml"), filled(&form, &machine, Some(17), &mut numbers)).unwrap();
}

#[test]
fn a_form_is_filled_in_and_becomes_a_profile() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    std::fs::write(path("machine.toml"), OWN).unwrap();
    let run = |args: &[&str]| trunnion().args(["profile"]).args(args).current_dir(folder.path()).output().unwrap();
    let calibrate = |args: &[&str]| run(&[&["calibrate", "-m", "machine.toml"], args].concat());
    let made = calibrate(&["--poses", "form.toml", "--gcode", "visit.gcode", "--repeats-to", "0.02", "--most", "100"]);
    assert!(made.status.success(), "{}", said(&made));
    assert!(states(&said(&made), "cross") && states(&said(&made), "omitted | G-code"), "{}", said(&made));
    let form = std::fs::read_to_string(path("form.toml")).unwrap();

    // Nothing filled in.
    let empty = calibrate(&["form.toml"]);
    assert_eq!(empty.status.code(), Some(1), "{}", said(&empty));
    assert!(fails(&said(&empty), "job/calibration: form.toml | pivot X"), "{}", said(&empty));

    let mut numbers = SplitMix64::seeded(30);
    let mut machine = Machine::any(profile(OWN).kinematics(), &mut numbers, 0.0);
    machine.by[..6].copy_from_slice(&[0.8, -1.2, 0.5, 0.3, -0.7, 0.9_f64.to_radians()]);
    std::fs::write(path("touches.toml"), filled(&form, &machine, None, &mut numbers)).unwrap();
    let done = calibrate(&["touches.toml", "-o", "calibrated.toml"]);
    assert!(done.status.success(), "{}", said(&done));
    let written = std::fs::read_to_string(path("calibrated.toml")).unwrap();
    assert!(written.contains("extends = \"machine.toml\"") && written.contains("95 % confidence"), "{written}");
    let shown = run(&["show", "calibrated.toml", "--json"]);
    let shown: serde_json::Value = serde_json::from_slice(&shown.stdout).unwrap();
    let table = &shown["kinematics"];
    let near = |value: &serde_json::Value, wanted: f64, by: f64| {
        let value = value.as_f64().unwrap();
        assert!((value - wanted).abs() < by, "{value} for {wanted}:\n{written}");
    };
    for (i, wanted) in [10.8, -6.2, -29.5].into_iter().enumerate() {
        near(&table["pivot_mm"][i], wanted, 0.04);
    }
    near(&table["offset_mm"][1], 0.3, 0.04);
    near(&table["offset_mm"][2], 19.3, 0.04);
    near(&table["tilt"]["zero_deg"], -0.9, 0.02);
    assert_eq!(
        (shown["machine"]["name"].as_str(), &table["rotation"]["zero_deg"]),
        (Some("mine"), &serde_json::json!(0.0))
    );

    let json = calibrate(&["touches.toml", "--json"]);
    let document: serde_json::Value = serde_json::from_slice(&json.stdout).unwrap();
    assert_eq!(document["ok"], true);
    assert_eq!(document["estimates"].as_array().unwrap().len(), 12);
    assert_eq!(document["deviations"].as_array().unwrap().len(), form.matches("[[touch]]").count());

    // A profile is not written over, and a touch that slipped is found.
    let over = calibrate(&["touches.toml", "-o", "machine.toml"]);
    assert_eq!(over.status.code(), Some(2), "{}", said(&over));
    assert_eq!(std::fs::read_to_string(path("machine.toml")).unwrap(), OWN);
    std::fs::write(path("slipped.toml"), filled(&form, &machine, Some(17), &mut numbers)).unwrap();
    let slipped = calibrate(&["slipped.toml", "-o", "no.toml"]);
    assert_eq!(slipped.status.code(), Some(1), "{}", said(&slipped));
    assert!(said(&slipped).contains("outliers: touch 17 (slipped.toml:"), "{}", said(&slipped));
    assert!(!path("no.toml").exists());
}

/// A machine whose axes are off by half a degree, from touches to a verified print.
#[test]
fn a_machine_with_leaning_axes_is_calibrated_and_prints() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    std::fs::write(path("machine.toml"), OWN).unwrap();
    let run = |args: &[&str]| trunnion().args(args).current_dir(folder.path()).output().unwrap();
    let made = run(&["profile", "calibrate", "-m", "machine.toml", "--poses", "form.toml", "--most", "100"]);
    assert!(made.status.success(), "{}", said(&made));
    let form = std::fs::read_to_string(path("form.toml")).unwrap();
    let mut numbers = SplitMix64::seeded(31);
    let mut machine = Machine::any(profile(OWN).kinematics(), &mut numbers, 0.0);
    for (unknown, deg) in [(7, 0.5), (8, -0.3), (9, 0.25), (10, 0.4)] {
        machine.by[unknown] = f64::to_radians(deg);
    }
    std::fs::write(path("touches.toml"), filled(&form, &machine, None, &mut numbers)).unwrap();
    let done = run(&["profile", "calibrate", "-m", "machine.toml", "touches.toml", "-o", "calibrated.toml"]);
    assert!(
        done.status.success() && said(&done).contains("axes differ") && states(&said(&done), "machine.toml"),
        "{}",
        said(&done)
    );
    let document = run(&["profile", "calibrate", "-m", "machine.toml", "touches.toml", "--json"]);
    let document: serde_json::Value = serde_json::from_slice(&document.stdout).unwrap();
    let along = |key: &str, i: usize| document[key][i].as_f64().unwrap();
    assert!((along("tilt_along", 1) - 0.5_f64.to_radians()).abs() < 4e-4, "{document}");
    assert!((along("rotation_along", 1) - 0.4_f64.to_radians()).abs() < 4e-4, "{document}");
    let estimates = document["estimates"].as_array().unwrap();
    let left_out: Vec<&str> =
        estimates.iter().filter(|e| e["in_profile"] == false).map(|e| e["unknown"].as_str().unwrap()).collect();
    assert_eq!(left_out, ["surface, falling along X at A0 C0", "surface, lower at 100 mm from its middle"]);
    // What was found is what the profile has now, and nothing is left to be written.
    let again = run(&["profile", "calibrate", "-m", "calibrated.toml", "touches.toml", "--json"]);
    let again: serde_json::Value = serde_json::from_slice(&again.stdout).unwrap();
    assert_eq!((&again["ok"], &again["tilt_along"]), (&serde_json::json!(true), &serde_json::Value::Null), "{again}");
    assert!(again["bend_mm"].as_f64().unwrap() < 0.01, "{again}");
    // Beyond what an axis may lean nothing is written.
    let mut far = Machine { by: machine.by, nominal: machine.nominal.clone() };
    far.by[7] = 6.0_f64.to_radians();
    std::fs::write(path("far.toml"), filled(&form, &far, None, &mut numbers)).unwrap();
    let refused = run(&["profile", "calibrate", "-m", "machine.toml", "far.toml", "-o", "no.toml"]);
    assert!(!refused.status.success() && states(&said(&refused), "within 5 deg | +X"), "{}", said(&refused));
    assert!(!path("no.toml").exists());
    let tree = crate::pipeline::fixture("y-tree");
    let printed = run(&["prepare", &tree, "-m", "calibrated.toml", "--slicer", "builtin", "-o", "tree.gcode"]);
    assert!(printed.status.success(), "{}", said(&printed));
}

#[test]
fn bad_flags_say_what_is_allowed() {
    let folder = folder();
    std::fs::write(folder.path().join("touches.toml"), "").unwrap();
    for (args, wanted) in [
        (
            &["touches.toml", "-m", "generic-ac", "--tolerance", "nan"][..],
            "setting/out-of-range: --tolerance | 0.001 and 5 | got NaN mm",
        ),
        (
            &["-m", "generic-ac", "--poses", "p.toml", "--repeats-to", "0"],
            "setting/out-of-range: --repeats-to | 0.0005 and 1 | got 0 mm",
        ),
        (
            &["-m", "generic-ac", "--poses", "p.toml", "--most", "2"],
            "setting/out-of-range: --most | 3 and 1000 | got 2",
        ),
        (&["-m", "generic-ac"], "command/usage: <TOUCHES>"),
        (&["touches.toml", "-m", "generic-ax"], "profile/no-such-profile: \"generic-ax\" | \"generic-ac\""),
        (&["none.toml", "-m", "generic-ac"], "input/absent: none.toml"),
    ] {
        let run = trunnion().args(["profile", "calibrate"]).args(args).current_dir(folder.path()).output().unwrap();
        assert_eq!(run.status.code(), Some(2), "{}", said(&run));
        assert!(fails(&said(&run), wanted), "{args:?}: {}", said(&run));
    }
    assert!(!folder.path().join("p.toml").exists());
}
