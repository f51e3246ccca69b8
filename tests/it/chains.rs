//! Chains of joints other than a table's: a head that yaws and tilts, one that tilts above a table that turns, machines of four axes. Held against
//! published kinematics that are typed out here, and against a head of points that is moved by them.

use std::f64::consts::PI;
use std::path::{Path, PathBuf};

use serde_json::Value;
use trunnion::geom::{Angle, SplitMix64, Vec3};
use trunnion::motion::Pose;
use trunnion::profile::{ProfileError, resolve};

use crate::pipeline::{fixture, prepare};
use crate::support::{folder, installed, note, said, skip, trunnion};

/// LinuxCNC's `5axiskins.c`: a spherical head, B counted so that +B swings the tip to +X.
fn five_axis_forward(joints: [f64; 3], b: f64, c: f64, pivot_length: f64) -> [f64; 3] {
    let (t, p) = (c.to_radians(), (180.0 - b).to_radians());
    let r = [pivot_length * p.sin() * t.cos(), pivot_length * p.sin() * t.sin(), pivot_length * p.cos()];
    [joints[0] + r[0], joints[1] + r[1], joints[2] + r[2] + pivot_length]
}

/// Marlin's `penta_axis_head_head.cpp`, `native_to_joint`: LB is the pivot length, LC the offset of the rotation axis along Y.
fn head_head_joints(tip: [f64; 3], b: f64, c: f64, lb: f64, lc: f64) -> [f64; 3] {
    let ((sb, cb), (sc, cc)) = (b.to_radians().sin_cos(), c.to_radians().sin_cos());
    [tip[0] - sc * lc + cc * sb * lb, tip[1] + (cc - 1.0) * lc + sc * sb * lb, tip[2] + (cb - 1.0) * lb]
}

/// Marlin's `penta_axis_ht.cpp`, `native_to_joint`: B in the head, C in the table, whose axis is at X = Y = 0.
fn head_table_joints(on_table: [f64; 3], b: f64, c: f64, mrzp_offset_z: f64) -> [f64; 3] {
    let (r, theta) = (on_table[0].hypot(on_table[1]), on_table[1].atan2(on_table[0]) - c.to_radians());
    let b = b.to_radians();
    [r * theta.cos() + mrzp_offset_z * b.sin(), r * theta.sin(), on_table[2] + mrzp_offset_z * b.cos() - mrzp_offset_z]
}

/// A machine whose X, Y and Z are its linear axes.
fn machine(tilt: &str, rotation: &str) -> trunnion::profile::Profile {
    let text = format!(
        "extends = \"generic-ht\"\n[kinematics]\npivot_mm = [0.0, 0.0, 0.0]\noffset_mm = [0.0, 0.0, 0.0]\n[kinematics.tilt]\nletter = \"B\"\n\
         about = \"Y\"\nturns = \"head\"\nmin_deg = -180.0\nmax_deg = 180.0\n{tilt}\n[kinematics.rotation]\n{rotation}\n"
    );
    resolve("machine.toml", &text).unwrap_or_else(|error| panic!("{error}: {text}")).0
}

/// What our chain has X, Y and Z at for a place on the table and two words.
fn ours(profile: &trunnion::profile::Profile, on_table: [f64; 3], b: f64, c: f64) -> [f64; 3] {
    let table = profile.kinematics();
    let pose =
        Pose { tilt: table.tilt.angle_of(Angle::from_deg(b)), rotation: table.rotation.angle_of(Angle::from_deg(c)) };
    let tip = table.forward(pose).point(Vec3::from(on_table).into()).at;
    assert!((table.axes(pose).point(Vec3::from(on_table).into()).at - table.words(tip, pose)).norm() < 1e-9);
    assert!((table.tip(table.words(tip, pose), pose) - tip).norm() < 1e-9);
    table.words(tip, pose).into()
}

fn apart(a: [f64; 3], b: [f64; 3]) -> f64 {
    (Vec3::from(a) - Vec3::from(b)).norm()
}

/// A thousand places and poses for each published chain.
#[test]
fn words_are_those_of_published_kinematics() {
    let mut numbers = SplitMix64::seeded(41);
    let mut any = |reach: f64| (2.0 * numbers.unit() - 1.0) * reach;
    let mut worst = [0.0_f64; 3];
    for _ in 0..10 {
        let (length, lc) = (60.0 + any(50.0), any(8.0));
        let turned = |lc: f64| format!("turns = \"head\"\nfrom_tip_mm = [0.0, {lc:?}, 3.0]");
        let from_tip = format!("from_tip_mm = [0.0, 0.0, {length:?}]");
        let spherical = machine(&format!("{from_tip}\ndirection = -1"), &turned(0.0));
        let head_head = machine(&from_tip, &turned(lc));
        let head_table = machine(&from_tip, "direction = -1");
        for _ in 0..100 {
            let (place, b, c) = ([any(150.0), any(150.0), any(150.0)], any(180.0), any(720.0));
            let joints = ours(&spherical, place, b, c);
            worst[0] = worst[0].max(apart(five_axis_forward(joints, b, c, length), place));
            worst[1] = worst[1].max(apart(ours(&head_head, place, b, c), head_head_joints(place, b, c, length, lc)));
            worst[2] = worst[2].max(apart(ours(&head_table, place, b, c), head_table_joints(place, b, c, length)));
        }
    }
    assert!(worst.iter().all(|mm| *mm < 1e-6), "{worst:?}");
}

/// The machines of this test, told by their published numbers alone.
#[derive(Clone, Copy)]
struct Told {
    name: &'static str,
    /// From tip to tilt axis.
    length: f64,
    /// The middle of the table.
    middle: [f64; 3],
    /// Whether C turns the head; else the table, right-handed.
    yaws: bool,
    /// Whether X, Y and Z are the tip's.
    of_the_tip: bool,
    /// What the profile of this test has besides.
    more: &'static str,
}

const TOLD: [Told; 3] = [
    Told { name: "generic-hh", length: 50.0, middle: [0.0; 3], yaws: true, of_the_tip: false, more: "" },
    Told { name: "generic-ht", length: 50.0, middle: [0.0; 3], yaws: false, of_the_tip: false, more: "" },
    // Below 47.9 mm a level tool has its axis below the table.
    Told {
        name: "rep5x-ender-3-v3-se",
        length: 47.9,
        middle: [100.0, 100.0, 0.0],
        yaws: true,
        of_the_tip: true,
        more: "[limits]\nz_mm = [-60.0, 174.6]\n",
    },
];

/// Where a machine is.
#[derive(Clone, Copy, Debug, Default)]
struct At {
    xyz: [f64; 3],
    b: f64,
    c: f64,
}

impl Told {
    /// The tip in the room.
    fn tip(&self, at: At) -> [f64; 3] {
        if self.of_the_tip {
            return at.xyz;
        }
        // Joints less what they are when the tip is at zero.
        let yaw = if self.yaws { at.c } else { 0.0 };
        let lever = head_head_joints([0.0; 3], at.b, yaw, self.length, 0.0);
        [0, 1, 2].map(|i| at.xyz[i] - lever[i])
    }

    /// The tip on the table.
    fn on_table(&self, at: At) -> [f64; 3] {
        let tip = self.tip(at);
        let [x, y, z] = [0, 1, 2].map(|i| tip[i] - self.middle[i]);
        let (s, c) = if self.yaws { (0.0, 1.0) } else { (-at.c).to_radians().sin_cos() };
        [c * x - s * y, s * x + c * y, z]
    }

    /// Points of the head, table frame: those that turn with the tool and those that do not.
    fn head(&self, at: At, points: &[Vec<[f64; 3]>; 2]) -> Vec<[f64; 3]> {
        let ((sb, cb), yaw) = (at.b.to_radians().sin_cos(), if self.yaws { at.c } else { 0.0 });
        let (sy, cy) = yaw.to_radians().sin_cos();
        let tip = self.tip(at);
        let axes = if self.of_the_tip { head_head_joints(tip, at.b, yaw, self.length, 0.0) } else { at.xyz };
        let turned = points[0].iter().map(|[x, y, z]| {
            let (x, z) = (cb * x + sb * z, cb * z - sb * x);
            [tip[0] + cy * x - sy * y, tip[1] + sy * x + cy * y, tip[2] + z]
        });
        let still = points[1].iter().map(|p| [axes[0] + p[0], axes[1] + p[1], axes[2] + p[2]]);
        let back = |p: [f64; 3]| {
            let [x, y, z] = [0, 1, 2].map(|i| p[i] - self.middle[i]);
            let (s, c) = if self.yaws { (0.0, 1.0) } else { (-at.c).to_radians().sin_cos() };
            [c * x - s * y, s * x + c * y, z]
        };
        turned.chain(still).map(back).collect()
    }

    /// Points of the profile's own head, 2 mm apart at most: its corners, their edges' and their faces' points.
    fn points(&self) -> [Vec<[f64; 3]>; 2] {
        let (file, text) = trunnion::profile::shipped(self.name).unwrap();
        let profile = resolve(file, text).unwrap().0;
        let mut all = [Vec::new(), Vec::new()];
        for body in &profile.head.body {
            let points = &mut all[usize::from(!body.turns)];
            if let (Some(z), Some(r)) = (body.z_mm, body.r_mm) {
                for k in 0..=10 {
                    let share = f64::from(k) / 10.0;
                    let (height, radius) = (z[0] + (z[1] - z[0]) * share, r[0] + (r[1] - r[0]) * share);
                    points.extend(
                        (0..24)
                            .map(|i| (f64::from(i) * PI / 12.0).sin_cos())
                            .map(|(s, c)| [radius * c, radius * s, height]),
                    );
                }
            } else if let (Some(min), Some(max), "XYZ") = (body.min_mm, body.max_mm, body.moves.as_str()) {
                for n in 0..11 * 11 * 11 {
                    let step = [n % 11, n / 11 % 11, n / 121];
                    if step.iter().any(|k| *k == 0 || *k == 10) {
                        points.push([0, 1, 2].map(|i| min[i] + (max[i] - min[i]) * f64::from(step[i]) / 10.0));
                    }
                }
            }
        }
        all
    }
}

/// The moves of a file, by the letters of its words: line, before and after, filament, and the part of the last mark.
fn moves(text: &str) -> Vec<(usize, At, At, f64, Option<usize>)> {
    let (mut at, mut part, mut all) = (At::default(), None, Vec::new());
    for (number, line) in text.lines().enumerate() {
        if let Some(rest) = line.strip_prefix(";TRUNNION print=") {
            part = rest.split("part=").nth(1).and_then(|n| n.parse().ok());
        }
        if line.starts_with(";TRUNNION end") {
            break;
        }
        let words: Vec<&str> = line.split(';').next().unwrap().split_whitespace().collect();
        if !matches!(words.first(), Some(&("G0" | "G1"))) {
            continue;
        }
        let (before, mut e) = (at, 0.0);
        for word in &words[1..] {
            let value: f64 = word[1..].parse().unwrap();
            match &word[..1] {
                "X" => at.xyz[0] = value,
                "Y" => at.xyz[1] = value,
                "Z" => at.xyz[2] = value,
                "B" => at.b = value,
                "C" => at.c = value,
                "E" => e = value,
                _ => {}
            }
        }
        all.push((number + 1, before, at, e, part));
    }
    all
}

/// The box of what is laid of each part, table frame.
fn laid(told: &Told, text: &str, parts: usize) -> Vec<[[f64; 3]; 2]> {
    let mut boxes = vec![[[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]]; parts];
    for (_, from, to, e, part) in moves(text) {
        let Some(part) = part.filter(|_| e > 0.0 && from.xyz != to.xyz) else { continue };
        for p in [from, to].map(|at| told.on_table(at)) {
            for i in 0..3 {
                boxes[part][0][i] = boxes[part][0][i].min(p[i]);
                boxes[part][1][i] = boxes[part][1][i].max(p[i]);
            }
        }
    }
    boxes
}

/// By part, the box of its corners.
const Y_TREE: [[[f64; 3]; 2]; 3] = [
    [[-10.0, -10.0, 0.0], [10.0, 10.0, 50.0]],
    [[0.0, -10.0, 40.0], [38.284, 10.0, 78.284]],
    [[-38.284, -10.0, 40.0], [0.0, 10.0, 78.284]],
];
const TWO_BOXES: [[[f64; 3]; 2]; 2] =
    [[[-25.0, -10.0, 0.0], [-5.0, 10.0, 60.0]], [[-5.0, -10.0, 40.0], [25.0, 10.0, 60.0]]];

/// A file that extends a shipped profile.
fn extended(base: &str, name: &str, more: &str, into: &Path) -> String {
    let file = into.join(format!("{name}.toml"));
    std::fs::write(&file, format!("extends = \"{base}\"\n[machine]\nname = \"{name}\"\n{more}")).unwrap();
    file.display().to_string()
}

impl Told {
    fn prepared(&self, name: &str, into: &Path) -> (String, PathBuf) {
        // Thick layers and hardly any infill: what matters is where the head goes between them.
        let thin = "[process]\nlayer_height_mm = 0.3\ninfill = 0.05\ntop_layers = 2\nbottom_layers = 2\n";
        prepared(name, &extended(self.name, "told", &format!("{}{thin}", self.more), into), into)
    }
}

fn prepared(name: &str, machine: &str, into: &Path) -> (String, PathBuf) {
    let (file, plan) = (into.join("out.gcode"), into.join("plan.json"));
    let document = prepare(&fixture(name), machine, "builtin", &file, &["--plan-out", plan.to_str().unwrap()]);
    assert_eq!(document["verify"]["findings"], serde_json::json!([]), "{name} on {machine}");
    (std::fs::read_to_string(file).unwrap(), plan)
}

/// What is laid lies where the model is: on the table, by the published formulas. A line's middle is half its width within a wall.
#[test]
fn heads_that_turn_lay_every_part_where_it_is() {
    for told in TOLD {
        for (name, parts) in [("y-tree", &Y_TREE[..]), ("two-boxes", &TWO_BOXES[..])] {
            let dir = folder();
            let (text, _) = told.prepared(name, dir.path());
            let laid = laid(&told, &text, parts.len());
            for (part, (got, wanted)) in laid.iter().zip(parts).enumerate() {
                let off = |side: usize, i: usize| {
                    if side == 0 { got[side][i] - wanted[side][i] } else { wanted[side][i] - got[side][i] }
                };
                let all: Vec<f64> = (0..6).map(|k| off(k / 3, k % 3)).collect();
                assert!(
                    all.iter().all(|mm| (-0.01..=0.45).contains(mm)),
                    "{name} part {part} on {}: {all:?}",
                    told.name
                );
            }
            let poses: Vec<(f64, f64)> = moves(&text).iter().map(|(_, _, to, ..)| (to.b, to.c)).collect();
            assert!(poses.iter().any(|(b, _)| b.abs() > 40.0), "{name} on {}: the head never leans", told.name);
        }
    }
}

/// As much as that of supports and brims beside a part, mm.
const BESIDE_MM: f64 = 8.0;

/// What else the main job does goes the same way: supports below a head that leans, cuts that are printed leaning, and the lines of a slicer that
/// people have. What is laid is as large as the model, by the published formulas.
#[test]
fn heads_that_turn_are_given_supports_cuts_and_slicers_too() {
    let slicer = if installed("prusa-slicer") {
        "prusa-slicer"
    } else {
        skip("PrusaSlicer is not installed: its file for a head that turns");
        "builtin"
    };
    // By --up as it is drawn: 60 x 16 x 30 mm.
    let bracket = [60.0, 16.0, 30.0];
    let rows = [
        (0, "supports", "builtin", [BESIDE_MM, BESIDE_MM, 0.0]),
        (1, "cut", "builtin", [0.0; 3]),
        (2, "supports", slicer, [BESIDE_MM, BESIDE_MM, 0.0]),
        (2, "cut", slicer, [0.0; 3]),
    ];
    for (told, way, slicer, more) in rows {
        let (dir, told) = (folder(), TOLD[told]);
        let machine = extended(told.name, "told", told.more, dir.path());
        let file = dir.path().join("out.gcode");
        let document = prepare(&fixture("bracket"), &machine, slicer, &file, &["--way", way]);
        let what = format!("{way} with {slicer} on {}", told.name);
        assert_eq!(document["verify"]["findings"], serde_json::json!([]), "{what}");
        let text = std::fs::read_to_string(&file).unwrap();
        let parts = document["plan"]["parts"].as_array().unwrap().len();
        let boxes = laid(&told, &text, parts);
        let corner =
            |side: usize, i: usize, least: fn(f64, f64) -> f64| boxes.iter().map(|b| b[side][i]).reduce(least).unwrap();
        for i in 0..3 {
            let size = corner(1, i, f64::max) - corner(0, i, f64::min);
            assert!((-0.9..=more[i] + 0.01).contains(&(size - bracket[i])), "{what}: {size} mm along {i}");
        }
        let leans = moves(&text).iter().any(|(_, _, to, e, _)| *e > 0.0 && to.b.abs() > 40.0);
        assert_eq!(leans, way == "cut", "{what}");
        assert_eq!(document["plan"]["supports"].is_null() && document["supports"].is_null(), way == "cut", "{what}");
    }
}

/// How deep the head comes into what is printed, from a line on, mm; and of its lines the worst. By points of the head, each millimetre and degree
/// of the way.
fn depth(told: &Told, text: &str, printed: &[[[f64; 3]; 2]], from_line: usize) -> (f64, usize) {
    let points = told.points();
    let mut worst = (0.0, 0);
    for (line, from, to, ..) in moves(text).into_iter().filter(|(line, ..)| *line >= from_line) {
        let way = (0..3)
            .map(|i| (to.xyz[i] - from.xyz[i]).abs())
            .fold((to.b - from.b).abs().max((to.c - from.c).abs()), f64::max);
        let steps = way.ceil().max(1.0) as usize;
        // Within a print the head goes where it has been looked at.
        if way < 3.0 {
            continue;
        }
        for step in 0..=steps {
            let mix = |a: f64, b: f64| a + (b - a) * step as f64 / steps as f64;
            let at =
                At { xyz: [0, 1, 2].map(|i| mix(from.xyz[i], to.xyz[i])), b: mix(from.b, to.b), c: mix(from.c, to.c) };
            for p in told.head(at, &points) {
                let within = |b: &[[f64; 3]; 2]| {
                    (0..3).map(|i| (p[i] - b[0][i]).min(b[1][i] - p[i])).fold(f64::INFINITY, f64::min)
                };
                let deep = printed.iter().map(within).fold(f64::NEG_INFINITY, f64::max);
                if deep > worst.0 {
                    worst = (deep, line);
                }
            }
        }
    }
    worst
}

fn findings(text: &str, plan: &Path, into: &Path) -> Vec<(String, u64)> {
    let file = into.join("changed.gcode");
    std::fs::write(&file, text).unwrap();
    let run = trunnion().arg("verify").arg(&file).arg("--plan").arg(plan).arg("--json").output().unwrap();
    assert!(matches!(run.status.code(), Some(0 | 1)), "{}", said(&run));
    let report: Value = serde_json::from_slice(&run.stdout).unwrap();
    let one = |f: &Value| (f["rule"].as_str().unwrap().to_owned(), f["line"].as_u64().unwrap());
    report["findings"].as_array().unwrap().iter().map(one).collect()
}

/// The turn to the second pose, lower and lower. What the head of points strikes is found; what is clean it does not strike.
#[test]
fn a_turn_too_low_is_found_as_soon_as_the_head_strikes() {
    for told in TOLD {
        let dir = folder();
        let (text, plan) = told.prepared("two-boxes", dir.path());
        let lines: Vec<&str> = text.lines().collect();
        let turn = lines.iter().position(|l| l.starts_with(";TRUNNION slot=1")).unwrap();
        let raised = (0..turn).rev().find(|&i| lines[i].starts_with("G1 Z")).unwrap();
        let z: f64 = lines[raised].split(['Z', ' ']).nth(2).unwrap().parse().unwrap();
        let (mut struck, mut found) = (0, 0);
        for lower in [0.0, 4.0, 6.0, 10.0, 24.0, 40.0] {
            let mut changed: Vec<String> = lines.iter().map(|l| (*l).to_owned()).collect();
            changed[raised] = changed[raised].replace(&format!("Z{z}"), &format!("Z{:.4}", z - lower));
            let changed = changed.join("\n") + "\n";
            let (deep, at) = depth(&told, &changed, &TWO_BOXES[..1], raised + 1);
            let rules: Vec<(String, u64)> = findings(&changed, &plan, dir.path());
            let meets = rules.iter().filter(|(rule, _)| rule.ends_with("-collision")).count();
            note(&format!("{} lower by {lower}: {deep:.2} mm deep in line {at}, {meets} findings", told.name));
            assert!(deep < 1.0 || meets > 0, "{} lower by {lower}: {deep} mm in line {at} was not found", told.name);
            assert!(meets == 0 || lower > 0.0, "{}: {rules:?}", told.name);
            (struck, found) = (struck + usize::from(deep >= 1.0), found + usize::from(meets > 0));
        }
        assert!(struck >= 3 && found >= struck, "{}: {struck} {found}", told.name);
    }
}

/// One thing wrong in a finished file, and the rule that says so.
#[test]
fn each_rule_sees_a_head_that_turns() {
    for told in [TOLD[0], TOLD[2]] {
        let dir = folder();
        let (text, plan) = told.prepared("two-boxes", dir.path());
        let lines: Vec<String> = text.lines().map(str::to_owned).collect();
        let turn = lines.iter().position(|l| l.starts_with(";TRUNNION slot=1")).unwrap();
        let tilt = turn + lines[turn..].iter().position(|l| l.starts_with("G1 B90")).unwrap();
        let print = tilt + lines[tilt..].iter().position(|l| l.starts_with(";TRUNNION print=")).unwrap();
        let broken = |change: &dyn Fn(&mut Vec<String>)| {
            let mut changed = lines.clone();
            change(&mut changed);
            assert_ne!(changed, lines);
            findings(&(changed.join("\n") + "\n"), &plan, dir.path())
        };
        let has = |rules: &[(String, u64)], rule: &str, line: usize| {
            assert!(
                rules.iter().any(|(r, l)| r == rule && *l == line as u64 + 1),
                "{} {rule} in line {}: {rules:?}",
                told.name,
                line + 1
            );
        };
        // The axis ends at +-200 (0 and 200 for tip words, whose axis stands 47.9 mm behind it while the head leans by 90 degrees).
        let x = if told.of_the_tip { "G1 X170 F6000" } else { "G1 X210 F6000" };
        has(&broken(&|l| l.insert(tilt + 1, x.to_owned())), "axis-limit", tilt + 1);
        if told.of_the_tip {
            // In the turn itself: the words stay within, the axis does not.
            let rules = broken(&|l| l.insert(turn, "G1 X190 F6000".to_owned()));
            has(&rules, "axis-limit", tilt + 1);
            let unfollowed = broken(&|l| drop(l.remove(l.iter().position(|line| line == "G43.4").unwrap())));
            assert!(unfollowed.iter().any(|(rule, _)| rule == "command"), "{unfollowed:?}");
            for at in [print, lines.iter().rposition(|l| l.starts_with("G1 B0")).unwrap()] {
                assert!(broken(&|l| l.insert(at, "G49".to_owned())).iter().any(|(rule, _)| rule == "command"));
            }
        } else {
            assert!(broken(&|l| l.insert(print, "G43.4".to_owned())).iter().any(|(rule, _)| rule == "command"));
        }
        // Before any pose is known each word stands for itself.
        let first = lines.iter().position(|l| l.starts_with("G1 Z")).unwrap();
        has(&broken(&|l| l.insert(first, "G1 Z9000 F900".to_owned())), "axis-limit", first);
        for off in ["G1 B89.99 F1200", "G1 B45 F1200", "G1 B-90 F1200"] {
            let rules = broken(&|l| l[tilt] = off.to_owned());
            assert!(rules.iter().any(|(rule, _)| rule == "pose"), "{} {off}: {rules:?}", told.name);
        }
        has(&broken(&|l| l[tilt] = "G1 B140 F1200".to_owned()), "axis-limit", tilt);
        // Straight to the print without the way round.
        let first = print + lines[print..].iter().position(|l| l.starts_with("G1 X") && !l.contains('E')).unwrap();
        let rules = broken(&|l| l.insert(first, "G1 X-30 Y0 Z30 F6000".to_owned()));
        assert!(rules.iter().any(|(rule, _)| rule == "head-collision"), "{}: {rules:?}", told.name);
        // A layer pushed sideways leaves the rest in mid-air.
        let laying = |l: &&usize| lines[**l].starts_with("G1 ") && lines[**l].contains(" E0.");
        let all: Vec<usize> = (print..lines.len()).collect();
        let some: Vec<usize> = all.iter().filter(laying).copied().skip(400).take(300).collect();
        let rules = broken(&|l| some.iter().rev().for_each(|at| drop(l.remove(*at))));
        assert!(!rules.is_empty(), "{}: 300 lines are missing", told.name);
    }
}

/// Four axes: without a rotation the words of C are not written, without a tilt those of A.
#[test]
fn a_machine_without_one_of_the_axes_prints_what_the_other_reaches() {
    let dir = folder();
    let machine = |name: &str, more: &str| extended("generic-bc", name, more, dir.path());
    let tilts = machine(
        "tilts",
        "[kinematics.tilt]\nmin_deg = -90.0\nmax_deg = 90.0\n[kinematics.rotation]\nturns = \"none\"\n",
    );
    let (text, _) = prepared("y-tree", &tilts, dir.path());
    assert!(text.contains("\nG1 B45 ") && text.contains("\nG1 B-45 "));
    assert!(moves(&text).iter().all(|(.., to, _, _)| to.c == 0.0) && !text.contains("\nG1 C"));
    let turns = machine("turns", "[kinematics.tilt]\nturns = \"none\"\n");
    let (text, _) = prepared("cube", &turns, dir.path());
    assert!(!text.contains("\nG1 B") && text.contains("\nG1 C0 "));
    let mut command = trunnion();
    command.args(["plan", &fixture("y-tree"), "-m", &turns, "--json", "-o"]).arg(dir.path().join("p.json"));
    let run = command.output().unwrap();
    assert_eq!(run.status.code(), Some(1), "{}", said(&run));
}

/// What a profile may say of the chain, row by row: the key, and the change that breaks it.
#[test]
fn chains_that_are_none_are_refused_with_their_key() {
    let head = "turns = \"head\"\nfrom_tip_mm = [0.0, 0.0, 50.0]\n";
    let rows: [(&str, &str, &str, &str); 13] = [
        // The gantry of this profile follows Y and Z.
        ("head.body", head, "", ""),
        ("kinematics.rotation.turns", "", head, ""),
        ("kinematics.tilt.turns", "turns = \"none\"\n", "turns = \"none\"\n", ""),
        ("kinematics.tilt.from_tip_mm", "turns = \"head\"\n", "", ""),
        ("kinematics.tilt.from_tip_mm", "from_tip_mm = [0.0, 0.0, 50.0]\n", "", ""),
        ("kinematics.rotation.from_tip_mm", head, "turns = \"head\"\n", ""),
        ("kinematics.rotation.from_tip_mm", head, "from_tip_mm = [0.0, 0.0, 50.0]\n", ""),
        ("dialect.rtcp", head, "", "[dialect]\nrtcp = true\n"),
        ("dialect.rtcp", "", "", "[dialect]\nrtcp = true\n"),
        ("kinematics.tilt.along", &format!("{head}along = [0.9999, 0.01, 0.0]\n"), "", ""),
        (
            "fixed.body",
            head,
            "",
            "[[fixed.body]]\nname = \"post\"\nkind = \"box\"\nmin_mm = [300.0, 0.0, 0.0]\nmax_mm = [310.0, 10.0, 99.0]\n",
        ),
        ("transition.park_mm", head, "", "[transition]\npark_mm = [0.0, 0.0]\n"),
        ("link.rehome", head, "", "[link]\nrehome = \"G28 X Y\"\n"),
    ];
    for (key, tilt, rotation, more) in rows {
        let text =
            format!("extends = \"generic-ac\"\n[kinematics.tilt]\n{tilt}[kinematics.rotation]\n{rotation}{more}");
        match resolve("m.toml", &text) {
            Err(ProfileError::Range { key: told, .. }) => assert_eq!(told, key, "{text}"),
            other => panic!("{key}: {:?}\n{text}", other.map(|_| ())),
        }
    }
    let follows = |start: &str| {
        let text = format!(
            "extends = \"rep5x-ender-3-v3-se\"\n[dialect]\nstart = \"\"\"\nG28\n{start}\nM109 S{{nozzle_c}}\"\"\"\n"
        );
        resolve("m.toml", &text).map(|_| ())
    };
    assert!(follows("G43.4").is_ok());
    for never in ["", "G49", "G1 B10 F600\nG43.4", "G43.4\nG49"] {
        assert!(matches!(follows(never), Err(ProfileError::Code { .. })), "{never:?}");
    }
}
