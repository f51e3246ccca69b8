//! Files judged without their plan: what our own say without their comments, the same files broken on purpose, and files that nobody can judge.

use std::fs;
use std::path::Path;

use serde_json::{Value, json};

use crate::mutants::{Victim, mutants, report};
use crate::pipeline::{fixture, prepare};
use crate::split::solids::block;
use crate::support::{every, fails, folder as new_folder, said, trunnion};

/// What `verify` says of a file without a plan, and its exit code.
#[track_caller]
fn refereed(file: &Path, machine: &str) -> (Value, Option<i32>) {
    let done = trunnion().arg("verify").arg(file).args(["-m", machine, "--json"]).output().unwrap();
    let document = serde_json::from_slice(&done.stdout).unwrap_or_else(|error| panic!("{error}: {}", said(&done)));
    (document, done.status.code())
}

fn rules_of(report: &Value) -> Vec<&str> {
    report["findings"].as_array().unwrap().iter().map(|finding| finding["rule"].as_str().unwrap()).collect()
}

/// The file as a stranger would have written it: no comment at all.
fn bare(program: &str) -> String {
    let code = |line: &str| line.split(';').next().unwrap().trim_end().to_owned();
    program.lines().map(code).collect::<Vec<_>>().join("\n") + "\n"
}

#[test]
fn what_is_verified_by_its_plan_is_clean_without_it() {
    let folder = new_folder();
    let whole = folder.path().join("whole.gcode");
    // Machines that tilt and turn about other letters; in the suite one each.
    let all = [
        ("two-boxes", "generic-ac"),
        ("y-tree", "penta-trt-bc"),
        ("ding", "generic-ac"),
        ("candelabrum", "generic-ac"),
    ];
    for (name, machine) in all {
        let done = prepare(&fixture(name), machine, "builtin", &whole, &[]);
        let with_plan = &done["verify"];
        let setups = poses(&done["plan"]);
        let program = fs::read_to_string(&whole).unwrap();
        let stranger = folder.path().join("stranger.gcode");
        fs::write(&stranger, bare(&program)).unwrap();
        for (file, plain) in [(&whole, false), (&stranger, true)] {
            let (judged, code) = refereed(file, machine);
            let report = &judged["report"];
            assert_eq!(
                (&report["findings"], code),
                (&json!([]), Some(0)),
                "{name} {machine}, without comments: {plain}"
            );
            assert_eq!(judged["runs"], json!(setups), "{name}");
            assert_eq!(report["moves"], with_plan["moves"], "{name}");
            for line in ["longest_line", "wound_line", "torque_line"] {
                assert_eq!(report["table"][line], with_plan["table"][line], "{name}: {line}");
            }
            // Nothing is a stranger to anything, so that the nozzle counts against less than by the plan.
            let [free, by_plan] = [report, with_plan].map(|one| one["clearance_mm"].as_f64().unwrap());
            assert!(free > by_plan - 0.06, "{name}: {free} mm without the plan, {by_plan} mm with it");
        }
    }
}

/// How often a plan changes the pose.
fn poses(plan: &Value) -> usize {
    let slots = plan["slots"].as_array().unwrap().iter();
    let prints = slots.flat_map(|slot| slot["prints"].as_array().unwrap());
    let mut all: Vec<_> =
        prints.map(|print| (print["tilt_deg"].to_string(), print["rotation_deg"].to_string())).collect();
    all.dedup();
    all.len()
}

/// The rules that need no plan, and what only a plan tells, together all there are.
#[test]
fn whatever_needs_no_plan_is_found_without_one_on_the_same_line() {
    let victim = Victim::of("two-boxes");
    let mut asked = 0;
    for (_, change) in mutants(&victim) {
        let file = victim.changed(change);
        let by_plan = report(&file, &victim.plan);
        let (judged, code) = refereed(&file, "generic-ac");
        let not_judged: Vec<&str> =
            judged["not_judged"].as_array().unwrap().iter().map(|rule| rule.as_str().unwrap()).collect();
        assert_eq!(not_judged.len(), 9);
        let found = judged["report"]["findings"].as_array().unwrap();
        assert_eq!(code, Some(i32::from(!found.is_empty())), "{judged}");
        let place = |finding: &Value| (finding["rule"].clone(), finding["line"].clone());
        // What a wrong pose leads to is not asked by the plan; here the pose is what the file says.
        let wanted = by_plan["findings"].as_array().unwrap();
        let astray = wanted.iter().any(|finding| finding["rule"] == "pose");
        for finding in wanted {
            let rule = finding["rule"].as_str().unwrap();
            if not_judged.contains(&rule) {
                assert!(found.iter().all(|one| one["rule"] != rule), "{finding}");
                continue;
            }
            asked += 1;
            assert!(astray || found.iter().any(|one| place(one) == place(finding)), "{finding} is not in {found:?}");
            assert!(rules_of(&judged["report"]).contains(&rule), "{finding}");
        }
    }
    assert!(asked > 12, "{asked}");
}

/// A run that begins above what it stands on, from half a line on: as by the plan, with and without the slicer's comments.
#[test]
fn a_run_that_begins_in_the_air_is_found_without_a_plan() {
    let victim = Victim::of("two-boxes");
    for lift in [0.3, 0.4, 0.6, 1.0] {
        let file = victim.changed(|lines| {
            let from = lines.iter().position(|line| line.starts_with(";TRUNNION slot=1")).unwrap();
            for line in &mut lines[from..] {
                let is_move = line.starts_with("G1 ");
                let raise = |word: &str| match word.strip_prefix('Z').and_then(|z| z.parse::<f64>().ok()) {
                    Some(z) if is_move => format!("Z{:.3}", z + lift),
                    _ => word.to_owned(),
                };
                *line = line.split(' ').map(raise).collect::<Vec<_>>().join(" ");
            }
        });
        let by_plan = rules_of(&report(&file, &victim.plan)).contains(&"in-air");
        let stranger = victim.folder.path().join("stranger.gcode");
        fs::write(&stranger, bare(&fs::read_to_string(&file).unwrap())).unwrap();
        for file in [&file, &stranger] {
            let found = rules_of(&refereed(file, "generic-ac").0["report"]).contains(&"in-air");
            assert!(found || !by_plan && lift < 0.5, "{lift} mm: {found} without the plan, {by_plan} with it");
        }
    }
}

/// Supports leave air below what they hold, and a stranger's comments say what is one.
#[test]
fn what_is_printed_on_supports_is_not_in_the_air() {
    let folder = new_folder();
    let here = folder.path();
    let tee = block(10.0, 10.0, 20.0).and(&block(40.0, 10.0, 6.0).at(-15.0, 0.0, 20.0));
    fs::write(here.join("tee.stl"), trunnion::mesh::stl_binary(&tee.mesh())).unwrap();
    let args =
        ["prepare", "tee.stl", "-m", "generic-ac", "--slicer", "builtin", "--way", "supports", "-o", "out.gcode"];
    let done = trunnion().current_dir(here).args(args).output().unwrap();
    assert!(done.status.success(), "{}", said(&done));
    let (judged, code) = refereed(&here.join("out.gcode"), "generic-ac");
    assert_eq!((&judged["report"]["findings"], code), (&json!([]), Some(0)), "{judged}");
    // Without them the beam is.
    let program = fs::read_to_string(here.join("out.gcode")).unwrap();
    let mut is_support = false;
    let kept = program.lines().filter(|line| {
        if let Some(role) = line.strip_prefix(";TYPE:") {
            is_support = role.starts_with("Support");
        }
        !(is_support && line.starts_with("G1") && line.contains(" E"))
    });
    fs::write(here.join("bare.gcode"), kept.collect::<Vec<_>>().join("\n")).unwrap();
    let (judged, code) = refereed(&here.join("bare.gcode"), "generic-ac");
    assert!(code == Some(1) && rules_of(&judged["report"]).contains(&"in-air"), "{judged}");
}

/// From a scratch to a crash: how deep the nozzle goes into what the file itself has printed, or how low it passes over a post.
#[test]
fn the_head_in_what_the_file_has_printed_is_found_whatever_its_depth() {
    let folder = new_folder();
    let file = folder.path().join("post.gcode");
    let depths = [0.0, 0.04, 0.1, 0.5, 2.0, 10.0];
    for depth in depths.into_iter().step_by(if every(2) == 1 { 1 } else { 2 }).chain([10.0]) {
        let mut program = String::from(
            "G21\nG90\nM83\nM104 S200\nM109 S200\nM140 S60\nM190 S60\nG28\nG1 Z110 F1800\nG1 A0 F1200\nG1 C0 F1800\n",
        );
        let mut side = |z: f64, y: f64, from: f64, to: f64| {
            program.push_str(&format!(
                "G1 X{from} Y{y} F6000\nG1 Z{z:.3} F600\nG1 X{to} Y{y} E{:.5} F1200\n",
                (to - from).abs() * 0.0365
            ));
        };
        for layer in 1..=40 {
            let z = f64::from(layer) * 0.2;
            for line in 0..10 {
                let y = f64::from(line) * 0.45;
                if line % 2 == 0 { side(z, y, 0.0, 8.0) } else { side(z, y, 8.0, 0.0) }
            }
        }
        // Over the post and back, with the tip so far below its top.
        program.push_str(&format!(
            "G1 Z{:.3} F1800\nG1 X30 F6000\nG1 Z{:.3} F1800\nG1 X-30 F6000\nG1 Z40\nM104 S0\nM140 S0\nM84\n",
            8.5,
            8.0 - depth
        ));
        fs::write(&file, &program).unwrap();
        let (judged, code) = refereed(&file, "generic-ac");
        let hits = rules_of(&judged["report"]).contains(&"head-collision");
        assert_eq!((hits, code), (depth > 0.05, Some(i32::from(depth > 0.05))), "{depth} mm deep: {judged}");
    }
}

#[test]
fn what_cannot_be_judged_is_refused_with_the_reason() {
    let folder = new_folder();
    let here = folder.path();
    let run = |program: &str, more: &[&str]| {
        fs::write(here.join("x.gcode"), program).unwrap();
        let done = trunnion().current_dir(here).args(["verify", "x.gcode"]).args(more).output().unwrap();
        (done.status.code(), said(&done))
    };
    let machine = &["-m", "generic-ac"][..];
    for (program, wanted) in [
        ("", "verify/nothing-printed: x.gcode | A, C"),
        ("G28\nG1 X5 Y5 Z5 F600\nM84\n", "verify/nothing-printed: x.gcode"),
        ("not gcode at all\n", "verify/nothing-printed: x.gcode"),
    ] {
        let (code, text) = run(program, machine);
        assert!(code == Some(2) && fails(&text, wanted), "{program:?}: {code:?} {text}");
    }
    // A vase printed while the table turns: the pose is another at each line.
    let spiral: String = (0..1500).map(|i| format!("G1 X{} C{} E0.1 F600\n", i % 7, i % 350)).collect();
    let (code, text) =
        run(&format!("G21\nG90\nM83\nM109 S200\nG28\nG1 Z110 F600\nG1 A0 C0\nG1 Z0.2\nG1 X0 Y0\n{spiral}"), machine);
    assert!(code == Some(2) && fails(&text, "verify/many-poses: x.gcode | 500"), "{code:?} {text}");
    for (more, wanted) in [
        (&[][..], "command/usage: --plan"),
        (&["-m", "generic-ac", "--model", "x.stl"], "command/usage: --model | --plan"),
        (&["-m", "generic-ac", "--certificate", "c.json"], "command/usage: --plan"),
        (&["-m", "no-such-machine"], "no-such-machine"),
    ] {
        let (code, text) = run("G28\n", more);
        assert!(code == Some(2), "{more:?}: {code:?} {text}");
        assert!(fails(&text, wanted) || text.contains(wanted), "{more:?}: {text}");
    }
}
