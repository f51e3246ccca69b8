//! `prepare --dry-run`: the print's poses and its outermost places, cold, on the bare table.

use serde_json::Value;
use trunnion::calibrate::{ColdPose, dry_run};
use trunnion::geom::Vec3;
use trunnion::profile::{Profile, resolve, shipped};

use crate::calibrate::visited::visited;
use crate::pipeline::fixture;
use crate::support::{every, folder, said, states, trunnion};

/// By another reader: the box of the tip while filament is pushed, by the words of the table, in their order.
fn boxes(profile: &Profile, program: &str) -> Vec<([f64; 2], [Vec3; 2])> {
    let letters = [profile.kinematics.tilt.letter, profile.kinematics.rotation.letter];
    let (mut at, mut words, mut all) = (Vec3::zeros(), [0.0; 2], Vec::<([f64; 2], [Vec3; 2])>::new());
    let from = program.find(";TRUNNION print=").expect("a mark");
    // Where the first print begins is not known from what follows it alone.
    for (line, counts) in program[..from].lines().map(|l| (l, false)).chain(program[from..].lines().map(|l| (l, true)))
    {
        let (before, mut pushed) = (at, 0.0);
        for word in line.split(';').next().unwrap().split_ascii_whitespace().filter(|_| line.starts_with("G1")) {
            let Ok(value) = word[1..].parse::<f64>() else { continue };
            match word.chars().next().unwrap() {
                axis @ ('X' | 'Y' | 'Z') => at["XYZ".find(axis).unwrap()] = value,
                letter if letter == profile.dialect.extruder => pushed = value,
                letter => letters.iter().zip(&mut words).filter(|(l, _)| **l == letter).for_each(|(_, w)| *w = value),
            }
        }
        if counts && pushed > 0.0 && at != before {
            if all.last().is_none_or(|(at, _)| *at != words) {
                all.push((words, [before; 2]));
            }
            let (_, [low, high]) = all.last_mut().unwrap();
            (*low, *high) = (low.inf(&before).inf(&at), high.sup(&before).sup(&at));
        }
    }
    all
}

#[test]
fn a_print_is_rehearsed_cold_where_it_will_be() {
    for (model, machine, code) in [
        ("y-tree", "generic-ac", 0),
        ("y-tree", "fibr3d", 0),
        ("y-tree", "open5x-prusa", 0),
        ("y-tree", "linuxcnc-xyzac-trt", 0),
        ("candelabrum", "generic-ac", 0),
    ]
    .into_iter()
    .step_by(every(2))
    {
        let dir = folder();
        let (out, dry) = (dir.path().join("out.gcode"), dir.path().join("dry.gcode"));
        let mut run = trunnion();
        run.args(["prepare", &fixture(model), "-m", machine, "--slicer", "builtin", "--json", "-o"]).arg(&out);
        let run = run.arg("--dry-run").arg(&dry).output().unwrap();
        assert_eq!(run.status.code(), Some(code), "{model} {machine}: {}", said(&run));
        let document: Value = serde_json::from_slice(&run.stdout).unwrap();
        let poses = document["dry_run"]["poses"].as_array().unwrap();
        let (file, text) = shipped(machine).unwrap();
        let profile = resolve(file, text).unwrap().0;
        let [program, cold] = [&out, &dry].map(|path| std::fs::read_to_string(path).unwrap());
        let wanted = boxes(&profile, &program);
        let number = |v: &Value| v.as_f64().unwrap();
        let words = |pose: &Value| [0, 1].map(|i| number(&pose["words_deg"][i]));
        let told: Vec<[f64; 2]> = poses.iter().map(words).collect();
        assert_eq!(told.len(), wanted.len(), "{model} {machine}");
        let seen = visited(&profile, &cold);
        for ((pose, (at, ends)), stop) in poses.iter().zip(&wanted).zip(&seen.stops) {
            let off = |one: [f64; 2]| (one[0] - at[0]).abs().max((one[1] - at[1]).abs());
            assert!(
                off(words(pose)) < 1e-3 && off(*stop) < 1e-3,
                "{model} {machine}: {pose} for {at:?}, stop at {stop:?}"
            );
            let places = pose["places_mm"].as_array().unwrap().iter();
            let places: Vec<Vec3> = places.map(|p| Vec3::from_fn(|i, _| number(&p[i]))).collect();
            let low = places.iter().copied().reduce(|a, b| a.inf(&b)).unwrap();
            let high = places.iter().copied().reduce(|a, b| a.sup(&b)).unwrap();
            // Places within 1 mm are one.
            assert!((low - ends[0]).amax() < 1.001 && (high - ends[1]).amax() < 1.001, "{model} {machine}: {pose}");
            for place in places {
                let top = profile.limits.z_mm[1];
                let lifted = seen.tips.iter().any(|(words, tip)| {
                    let (aside, up) = ((tip.x - place.x).hypot(tip.y - place.y), tip.z - place.z);
                    off(*words) < 1e-3 && aside < 0.002 && (up - (top - place.z).min(20.0)).abs() < 0.002
                });
                assert!(lifted, "{model} {machine}: {place:?} is not gone to");
            }
        }
        assert_eq!(seen.stops.len(), wanted.len(), "{model} {machine}");
        assert!(seen.nearest > 2.9, "{model} {machine}: the head comes to {} mm from the table", seen.nearest);
        assert!(states(cold.lines().next().unwrap(), "; A dry run"), "{cold}");
    }
}

#[test]
fn a_rehearsal_that_is_not_clear_is_refused() {
    let (file, text) = shipped("generic-ac").unwrap();
    let mut profile = resolve(file, text).unwrap().0;
    let pose = |deg: f64, place: Vec3| ColdPose { words_deg: [deg, 0.0], name: "it".to_owned(), places: vec![place] };
    let place = Vec3::new(0.0, -40.0, 30.0);
    let made = dry_run(&profile, &[pose(0.0, place), pose(60.0, place)]).unwrap();
    assert_eq!(visited(&profile, &made.gcode).stops, [[0.0, 0.0], [60.0, 0.0]]);
    // Below the rim of the tilted table: 20 mm above it the block is still in the table.
    let low = dry_run(&profile, &[pose(60.0, Vec3::new(0.0, 30.0, -40.0))]).unwrap_err();
    assert!(states(&low.to_string(), "pose 1 | X0.0 Y30.0"), "{low}");
    // Z ends below the ball that the table sweeps, and the head hangs over it when the rim comes up.
    profile.limits.z_mm[1] = 30.0;
    let over = Vec3::new(0.0, 60.0, 5.0);
    let short = dry_run(&profile, &[pose(0.0, over), pose(60.0, place)]).unwrap_err();
    assert!(states(&short.to_string(), "pose 2 | head and frame"), "{short}");
}

#[test]
fn a_rehearsal_has_a_file_of_its_own() {
    let dir = folder();
    let mut run = trunnion();
    run.args(["prepare", &fixture("cube"), "-m", "generic-ac", "-o", "x.gcode", "--dry-run", "x.gcode"]);
    let run = run.current_dir(dir.path()).output().unwrap();
    assert_eq!(run.status.code(), Some(2), "{}", said(&run));
    assert!(!dir.path().join("x.gcode").exists());
}
