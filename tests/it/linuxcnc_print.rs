//! LinuxCNC prints a tilted object: its task controller, motion controller and `xyzac-trt` kinematics run the prepared file, and
//! the joints must stand where we say they stand, at the end of every move.
//!
//! Three things differ from a print on a machine: nothing turns (HAL feeds the joints' commands back), G61.1 stands in the start
//! code where the profile has G64 P0.01, since a path with rounded corners passes no end of a move, and all is some hundred times
//! as fast (`tests/harness/linuxcnc_print.py`). What is compared is what HAL tells the motors, each servo period.

use std::process::Command;

use trunnion::fixtures::solid_box;
use trunnion::geom::Vec3;
use trunnion::mesh::stl_binary_parts;
use trunnion::profile::{resolve, shipped};

use crate::linuxcnc::{Feed, ours};
use crate::support::{folder, note, root, said, skip};

/// X Y Z A C U: mm and degrees.
type Joints = [f64; 6];

/// What LinuxCNC's motors were told while a line was in motion.
struct Run {
    line: u32,
    joints: Vec<Joints>,
}

/// The joints as the program goes; the words of a failure; `None`, said aloud, where LinuxCNC cannot run.
fn print(program: &[u8]) -> Option<Result<Vec<Run>, String>> {
    let folder = folder();
    let inside = folder.path().join("machine");
    std::fs::create_dir(&inside).unwrap();
    // Where it must not run as root it runs as another user, who has to get there.
    #[cfg(unix)]
    std::fs::set_permissions(folder.path(), std::os::unix::fs::PermissionsExt::from_mode(0o755)).unwrap();
    let file = folder.path().join("program.ngc");
    std::fs::write(&file, program).unwrap();
    let script = root().join("tests/harness/linuxcnc_print.py");
    // Its shared memory is the machine's: one at a time, whichever process asks.
    let lock = std::fs::File::create(std::env::temp_dir().join("trunnion-linuxcnc.lock")).unwrap();
    lock.lock().unwrap();
    let Ok(output) = Command::new("python3").arg(script).arg(&file).arg(&inside).arg("100").output() else {
        skip("no Python to start LinuxCNC with");
        return None;
    };
    match output.status.code() {
        Some(0) => Some(Ok(runs(&std::fs::read_to_string(inside.join("joints.log")).unwrap()))),
        Some(77) => {
            skip(&format!("LinuxCNC prints nothing here: {}", said(&output)));
            None
        }
        _ => Some(Err(said(&output))),
    }
}

fn runs(log: &str) -> Vec<Run> {
    let mut runs: Vec<Run> = Vec::new();
    for sample in log.lines() {
        let mut words = sample.split_whitespace();
        let line = words.next().unwrap().parse().unwrap();
        let joints: Vec<f64> = words.map(|word| word.parse().unwrap()).collect();
        if runs.last().is_none_or(|run| run.line != line) {
            runs.push(Run { line, joints: Vec::new() });
        }
        runs.last_mut().unwrap().joints.push(joints.try_into().unwrap());
    }
    runs
}

fn joints(feed: &Feed) -> Joints {
    let [x, y, z, a, _, c, u, ..] = feed.to;
    [x, y, z, a, c, u]
}

fn apart(a: &Joints, b: &Joints) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// How far `place` is from the straight way between two ends, as its share of the way is told by the axis that goes furthest.
fn beside(place: &Joints, from: &Joints, to: &Joints) -> f64 {
    let way = |axis: usize| to[axis] - from[axis];
    let longest = (0..6).max_by(|a, b| way(*a).abs().total_cmp(&way(*b).abs())).unwrap();
    let share =
        if way(longest) == 0.0 { 0.0 } else { ((place[longest] - from[longest]) / way(longest)).clamp(0.0, 1.0) };
    apart(place, &std::array::from_fn(|axis| from[axis] + share * way(axis)))
}

/// The furthest that an end of a move, and a place on the way, is from where we say it is; or which line was never in motion.
fn worst(program: &[u8], runs: &[Run]) -> Result<(usize, f64, f64), String> {
    let (file, text) = shipped("linuxcnc-xyzac-trt").unwrap();
    let profile = resolve(file, text).unwrap().0;
    let (mut place, mut ends, mut ways, mut from, mut moves) = (0, 0.0f64, 0.0f64, [0.0; 6], 0);
    for feed in ours(program, &profile) {
        let to = joints(&feed);
        if apart(&from, &to) < 1e-9 {
            continue;
        }
        let missing = || format!("line {} was never in motion", feed.line);
        place += runs[place..].iter().position(|run| run.line == feed.line).ok_or_else(missing)?;
        // The pin of the line goes ahead of the joints by one period: the last place of a move is the first of what follows.
        let end = runs.get(place + 1).and_then(|run| run.joints.first()).ok_or_else(missing)?;
        ends = ends.max(apart(end, &to));
        let on_the_way = runs[place].joints.iter().skip(1);
        ways = on_the_way.map(|joints| beside(joints, &from, &to)).fold(ways, f64::max);
        from = to;
        moves += 1;
    }
    Ok((moves, ends, ways))
}

/// A post and an arm that stands out from its side, small, on a table that is no wider: a thousand moves and more, two poses.
fn prepared() -> Vec<u8> {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    let post = solid_box(Vec3::zeros(), Vec3::new(8.0, 8.0, 16.0));
    let arm = solid_box(Vec3::new(8.0, 0.0, 8.0), Vec3::new(14.0, 8.0, 16.0));
    std::fs::write(path("bracket.stl"), stl_binary_parts(&[&post, &arm])).unwrap();
    let machine = "extends = \"linuxcnc-xyzac-trt\"\n[table]\nradius_mm = 12.0\n[process]\nlayer_height_mm = 0.3\ninfill = 0.1\nwalls = 1\n\
                   bottom_layers = 1\ntop_layers = 1\nsolid_below_mm2 = 0.0\n";
    std::fs::write(path("machine.toml"), machine).unwrap();
    let (model, machine) = (path("bracket.stl"), path("machine.toml"));
    crate::pipeline::prepare(model.to_str().unwrap(), machine.to_str().unwrap(), "builtin", &path("out.ngc"), &[]);
    std::fs::read(path("out.ngc")).unwrap()
}

/// The same lines with one exchanged or taken out.
fn changed(program: &[u8], from: &str, to: &str) -> Vec<u8> {
    let text = String::from_utf8_lossy(program);
    assert!(text.contains(from), "{from}");
    text.replacen(from, to, 1).into_bytes()
}

#[test]
fn linuxcnc_prints_a_tilted_object_with_its_joints_where_we_say() {
    let program = changed(&prepared(), "\nG64 P0.01\n", "\nG61.1\n");
    let Some(runs) = print(&program) else { return };
    let runs = runs.unwrap_or_else(|words| panic!("LinuxCNC did not come to the end: {words}"));
    let (moves, ends, ways) = worst(&program, &runs).unwrap();
    note(&format!("LinuxCNC: {moves} moves, ends within {ends:.6}, on the way within {ways:.6} (mm, degrees)"));
    assert!(moves > 700, "{moves}");
    let tilted = runs.iter().flat_map(|run| &run.joints).map(|joints| joints[3].abs()).fold(0.0, f64::max);
    assert!((tilted - 90.0).abs() < 1e-3, "{tilted}");
    assert!(ends < 1e-3 && ways < 5e-3, "{ends} {ways}");

    // The witness sees what is wrong: a file that is not the one that ran, by ever more, and one that lacks a line.
    let text = String::from_utf8(program.clone()).unwrap();
    let turn = text.lines().rev().find(|line| line.starts_with("G1 A") && !line.contains("A0")).unwrap();
    let angle: f64 = turn[4..].split(' ').next().unwrap().parse().unwrap();
    for (by, seen) in [(0.0, false), (0.0005, false), (0.002, true), (0.1, true), (5.0, true)] {
        let other = changed(&program, &format!("G1 A{angle} "), &format!("G1 A{} ", angle + by));
        let (_, ends, _) = worst(&other, &runs).unwrap();
        assert_eq!(ends > 1e-3, seen, "A off by {by}: {ends}");
    }
}

/// Whoever was in M428 when the print began has LinuxCNC turn the poses a second time: M429 in the start code is what prevents it.
#[test]
fn linuxcnc_in_its_other_kinematics_ends_elsewhere() {
    let program =
        "G21\nG90\nG94\nG17\nG61.1\nM428\nG92 U0\nG1 X5 Y5 Z30 F600\nG1 A-30 F1200\nG1 C20 F1200\nG1 X10 U1 F600\nM2\n";
    let right = program.replace("M428", "M429");
    let Some(runs) = print(right.as_bytes()) else { return };
    let (moves, ends, _) = worst(right.as_bytes(), &runs.unwrap()).unwrap();
    assert!(moves == 4 && ends < 1e-3, "{moves} {ends}");
    let Some(Ok(runs)) = print(program.as_bytes()) else { panic!("it ran a moment ago") };
    let (_, ends, _) = worst(program.as_bytes(), &runs).unwrap();
    assert!(ends > 1.0, "{ends}");
}
