//! How long a file takes, by a planner of the test's own: the whole file looked ahead at once, speeds that rise and fall evenly, corners
//! as fast as a deviation of 0.013 mm allows (Marlin's junction deviation), the accelerations of the shipped defaults. The estimate that
//! all verbs share comes within 5 % of it.

use trunnion::mesh::stl_binary;

use super::shapes;
use crate::support::{folder, note, said, trunnion};

/// X, Y, Z, mm/s², and E.
const AXES: [f64; 3] = [1000.0, 1000.0, 200.0];
const EXTRUDER: f64 = 3000.0;
const DEVIATION_MM: f64 = 0.013;

/// One move: its direction (none of it for filament alone), its length, mm, and the speed it is asked for, mm/s.
struct Leg {
    along: Option<[f64; 3]>,
    length: f64,
    speed: f64,
    /// mm/s².
    acceleration: f64,
}

fn legs(gcode: &str) -> Vec<Leg> {
    let (mut at, mut speed) = ([f64::NAN; 3], 0.0);
    let mut found = Vec::new();
    for line in gcode.lines() {
        let code = line.split(';').next().unwrap();
        if !matches!(code.split_whitespace().next(), Some("G0" | "G1")) {
            continue;
        }
        let word = |letter: char| code.split_whitespace().find_map(|w| w.strip_prefix(letter)?.parse::<f64>().ok());
        speed = word('F').map_or(speed, |feed| feed / 60.0);
        let from = at;
        for (i, letter) in ['X', 'Y', 'Z'].into_iter().enumerate() {
            at[i] = word(letter).unwrap_or(at[i]);
        }
        let by = [0, 1, 2].map(|i| at[i] - from[i]);
        let length = by.iter().map(|v| v * v).sum::<f64>().sqrt();
        let pushed = word('E').unwrap_or(0.0).abs();
        if length > 0.0 {
            let of_axes = by.iter().zip(AXES).map(|(v, most)| most * length / v.abs());
            let acceleration = of_axes.fold(EXTRUDER * length / pushed, f64::min);
            found.push(Leg { along: Some(by.map(|v| v / length)), length, speed, acceleration });
        } else if pushed > 0.0 && !length.is_nan() {
            found.push(Leg { along: None, length: pushed, speed, acceleration: EXTRUDER });
        }
    }
    found
}

/// Without accelerations, s.
fn plain(legs: &[Leg]) -> f64 {
    legs.iter().map(|leg| leg.length / leg.speed).sum()
}

/// With them, s.
fn planned(legs: &[Leg]) -> f64 {
    let mut ends = vec![0.0; legs.len() + 1];
    for (i, pair) in legs.windows(2).enumerate() {
        ends[i + 1] = corner(&pair[0], &pair[1]).min(pair[0].speed).min(pair[1].speed);
    }
    let reached = |from: f64, leg: &Leg| (from * from + 2.0 * leg.acceleration * leg.length).sqrt();
    for (i, leg) in legs.iter().enumerate().rev() {
        ends[i] = ends[i].min(reached(ends[i + 1], leg));
    }
    for (i, leg) in legs.iter().enumerate() {
        ends[i + 1] = ends[i + 1].min(reached(ends[i], leg));
    }
    let seconds = |(i, leg): (usize, &Leg)| {
        let [from, to] = [ends[i], ends[i + 1]];
        let rate = leg.acceleration;
        let top = ((2.0 * rate * leg.length + from * from + to * to) / 2.0).sqrt().min(leg.speed).max(from.max(to));
        let ramps = (2.0 * top * top - from * from - to * to) / (2.0 * rate);
        (2.0 * top - from - to) / rate + (leg.length - ramps).max(0.0) / top
    };
    legs.iter().enumerate().map(seconds).sum()
}

/// How fast the corner between two moves may be gone round, mm/s.
fn corner(a: &Leg, b: &Leg) -> f64 {
    let rate = a.acceleration.min(b.acceleration);
    let (Some(a), Some(b)) = (a.along, b.along) else { return 0.0 };
    let cos = -(0..3).map(|i| a[i] * b[i]).sum::<f64>();
    let half = ((1.0 - cos) / 2.0).max(0.0).sqrt();
    if half > 0.999_999 { f64::INFINITY } else { (rate * DEVIATION_MM * half / (1.0 - half)).sqrt() }
}

#[test]
fn a_move_by_hand_takes_what_it_must() {
    // 100 mm at 50 mm/s: 50 ms up, 50 ms down, 2.5 mm less than at full speed; a corner of 90 degrees in between, at 5.6 mm/s.
    let one = legs("G1 X0 Y0 Z0 F3000\nG1 X100 F3000\n");
    assert!((plain(&one) - 2.0).abs() < 1e-9 && (planned(&one) - 2.05).abs() < 1e-9);
    let two = legs("G1 X0 Y0 Z0 F3000\nG1 X50 F3000\nG1 Y50\n");
    let round = (1000.0 * 0.013 * 0.5f64.sqrt() / (1.0 - 0.5f64.sqrt())).sqrt();
    let wanted = 2.0 * (1.0 + 0.025 + (50.0 - round).powi(2) / (2.0 * 1000.0 * 50.0));
    assert!((planned(&two) - wanted).abs() < 1e-9, "{} {wanted}", planned(&two));
}

#[test]
fn the_estimate_comes_within_a_twentieth_of_a_planner_of_other_code() {
    let folder = folder();
    let mut table = vec!["shape      estimate s  this planner's  at constant speed".to_owned()];
    for name in ["cube", "gear", "cone", "star", "text"] {
        let shape = shapes::all().into_iter().find(|shape| shape.name == name).unwrap();
        let (model, output) = (folder.path().join("model.stl"), folder.path().join(format!("{name}.gcode")));
        std::fs::write(&model, stl_binary(&shape.mesh)).unwrap();
        let args = ["-m", "generic-ac", "--slicer", "builtin", "--json", "--overhang", "89", "-o"];
        let done = trunnion().arg("prepare").arg(&model).args(args).arg(&output).output().unwrap();
        assert_eq!(done.status.code(), Some(0), "{name}: {}", said(&done));
        let document: serde_json::Value = serde_json::from_slice(&done.stdout).unwrap();
        let estimate = document["verify"]["seconds_print"].as_f64().unwrap();
        let legs = legs(&std::fs::read_to_string(&output).unwrap());
        let (plain, planned) = (plain(&legs), planned(&legs));
        table.push(format!("{name:10} {estimate:10.1} {planned:14.1} {plain:18.1}"));
        assert!((estimate / planned - 1.0).abs() < 0.05, "{name}: {estimate} s, {planned} s");
    }
    note(&table.join("\n"));
}
