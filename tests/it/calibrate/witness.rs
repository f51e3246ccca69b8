//! The same least squares by scipy, on a chain that is written there once more: the same numbers, and the same errors.

use std::io::Write as _;
use std::process::{Command, Stdio};

use trunnion::calibrate::{FitOptions, Of, Unknown, choose, fit};
use trunnion::geom::SplitMix64;
use trunnion::motion::TiltAbout;

use super::touched::Machine;
use super::{NOISE, shipped, tip, touch_all};
use crate::support::{every, python, root, skip};

#[test]
fn scipy_finds_the_same_machine() {
    let Some(python) = python(&["python3", "/usr/bin/python3"], "scipy") else {
        return skip("no python3 with scipy: the least squares of calibration have no witness of other code");
    };
    let mut numbers = SplitMix64::seeded(40);
    for name in ["fibr3d", "generic-ac"].into_iter().step_by(every(2)) {
        let profile = shipped(name);
        let nominal = profile.kinematics();
        let chosen = choose(&profile, &tip(), 0.01, 120, false);
        let places: Vec<[f64; 2]> = chosen.marks.iter().map(|(_, at)| *at).collect();
        let mut machine = Machine::any(nominal.clone(), &mut numbers, 0.3);
        machine.by[Unknown::Sag as usize] = 0.08;
        let touches = touch_all(&machine, &chosen.poses, &places, NOISE, &mut numbers);
        let ours = fit(&profile, &touches, &FitOptions::default()).unwrap();
        let touch = |t: &trunnion::calibrate::Touch| {
            let of = if let Of::Feature(i) = t.of { i as i64 } else { -1 };
            serde_json::json!({"of": of, "words": t.words_deg, "at": t.at.as_slice()})
        };
        let problem = serde_json::json!({
            "about": if nominal.about == TiltAbout::X { "X" } else { "Y" },
            "pivot": nominal.pivot.as_slice(), "offset": nominal.offset.as_slice(), "marks": places,
            "radius": touches.tip.radius_mm, "paper": touches.tip.paper_mm,
            "touches": touches.touches.iter().map(touch).collect::<Vec<_>>(),
        });
        let mut child = Command::new(&python)
            .arg(root().join("tests/harness/calibrate_scipy.py"))
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        child.stdin.take().unwrap().write_all(problem.to_string().as_bytes()).unwrap();
        let output = child.wait_with_output().unwrap();
        assert!(output.status.success());
        let theirs: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        let list =
            |key: &str| -> Vec<f64> { theirs[key].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect() };
        // Without the rotation's zero, which is not looked for.
        let by: Vec<f64> = (0..13).filter(|i| *i != 6).map(|i| ours.chain.by()[i]).collect();
        for (i, (ours, theirs)) in by.iter().zip(list("by")).enumerate() {
            assert!((ours - theirs).abs() < 1e-6, "{name} {i}: {ours} for {theirs}");
        }
        let rms = theirs["rms"].as_f64().unwrap();
        assert!((ours.rms_mm - rms).abs() < 1e-7, "{name}: {} for {rms}", ours.rms_mm);
        // The errors of the bends, which come from the same fit, to a thousandth.
        let errors = list("errors");
        for (place, estimate) in ours.estimates.iter().filter(|e| e.unknown.bends()).enumerate() {
            let theirs = errors[6 + place].to_degrees() * theirs["student"].as_f64().unwrap();
            assert!(
                (estimate.error / theirs - 1.0).abs() < 2e-3,
                "{name} {}: {} for {theirs}",
                estimate.name,
                estimate.error
            );
        }
    }
}
