//! A small valid program, worked out by hand and not by our kinematics, and one breach of each rule.
//!
//! A post 10 mm square and 60 high, and a beam on its +X face, on the generic A/C table with 0.4 mm layers and 0.8 mm
//! lines. The beam grows along +X, at A90 C90. There, with the pivot at (0, 0, -20) and the table's centre 20 mm above
//! it: `Rz(90) (x, y, z) = (-y, x, z)`; plus the offset, `(-y, x, z + 20)`; `Rx(90) (x, y, z) = (x, -z, y)`, so
//! `(-y, -z - 20, x)`; plus the pivot, `(-y, -z - 20, x - 20)`.

use super::{ReplayJob, Report, Rule, SURVEYED_MM, rooms, verify};
use crate::fixtures::solid_box;
use crate::geom::{SplitMix64, Vec3};
use crate::mesh::Model;
use crate::planning::{MachineRef, ModelRef, PartRef, Placement, Plan, Print, TimeSlot, Workpiece};
use crate::profile::{Profile, resolve, shipped};
use crate::trace::{self, TraceMove};

mod depth;
mod level;
mod lines;
mod reading;
mod rim;
mod standing;
mod states;

const LAYER: f64 = 0.4;
const WIDTH: f64 = 0.8;
/// Filament per mm of line: 0.4 x (0.8 - 0.4) + pi/4 0.4^2 mm2 of bead over pi/4 1.75^2 mm2 of filament.
const FLOW: f64 = 0.118_764;
/// How far the zigzag's lines go on into the loop around it, mm.
const REACH: f64 = 0.2;

fn profile() -> Profile {
    let (file, text) = shipped("generic-ac").unwrap();
    let mut profile = resolve(file, text).unwrap().0;
    (profile.process.layer_height_mm, profile.process.line_width_mm) = (LAYER, WIDTH);
    profile
}

/// Where the beam's underside lies, mm.
const BEAM: f64 = 48.0;

fn model() -> Model {
    model_at(BEAM)
}

fn model_at(beam: f64) -> Model {
    let post = solid_box(Vec3::new(-5.0, -5.0, 0.0), Vec3::new(5.0, 5.0, 60.0));
    let beam = solid_box(Vec3::new(5.0, -5.0, beam), Vec3::new(11.0, 5.0, beam + 10.0));
    Model::from_parts(vec![("post".to_owned(), post), ("beam".to_owned(), beam)])
}

fn plan() -> Plan {
    let print = |part, up, angle| Print { part, up, tilt_deg: angle, rotation_deg: angle, supports: None };
    Plan {
        format: Plan::FORMAT.to_owned(),
        version: Plan::VERSION,
        made_by: "a test".to_owned(),
        model: ModelRef { file: String::new(), sha256: String::new(), unit: "mm".to_owned() },
        machine: MachineRef { profile: "generic-ac".to_owned(), sha256: String::new() },
        placement: Placement { origin_mm: [0.0; 3], turn_deg: 0.0 },
        bridge_mm: None,
        parts: (0..2).map(|id| PartRef { id, name: String::new() }).collect(),
        slots: vec![
            TimeSlot { id: 0, prints: vec![print(0, [0.0, 0.0, 1.0], 0.0)] },
            TimeSlot { id: 1, prints: vec![print(1, [1.0, 0.0, 0.0], 90.0)] },
        ],
        machine_values: None,
    }
}

/// Square layers with their lower corner at `corner` (machine), 10 mm wide, `count` layers.
fn layers(text: &mut String, corner: [f64; 3], count: usize) -> f64 {
    (1..=count).map(|i| layer(text, [corner[0], corner[1], corner[2] + i as f64 * LAYER], 10.0)).sum()
}

/// A square layer, its top's lower corner at `corner` (machine): a loop and a zigzag.
fn layer(text: &mut String, corner: [f64; 3], wide: f64) -> f64 {
    let at = |x: f64, y: f64| [corner[0] + x, corner[1] + y];
    let (near, far) = (0.4, wide - 0.4);
    let ring = [at(near, near), at(far, near), at(far, far), at(near, far), at(near, near)];
    text.push_str(&format!(";TYPE:External perimeter\nG1 Z{:.3} F900\n", corner[2]));
    let mut filament = line(text, &ring);
    let (near, far) = (1.2, wide - 1.2);
    let gaps = ((far - near) / 0.76 - 0.01).ceil();
    let zigzag: Vec<[f64; 2]> = (0..=gaps as usize)
        .flat_map(|i| {
            let x = near + (far - near) * i as f64 / gaps;
            // The lines' ends reach into the loop.
            let ends = [at(x, near - REACH), at(x, far + REACH)];
            if i % 2 == 0 { ends } else { [ends[1], ends[0]] }
        })
        .collect();
    text.push_str(";TYPE:Solid infill\n");
    filament += line(text, &zigzag);
    filament
}

fn line(text: &mut String, points: &[[f64; 2]]) -> f64 {
    let mut filament = 0.0;
    text.push_str(&format!("G1 X{:.3} Y{:.3} F6000\n", points[0][0], points[0][1]));
    for pair in points.windows(2) {
        let e = (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1]) * FLOW;
        filament += (e * 1e5).round() / 1e5;
        text.push_str(&format!("G1 X{:.3} Y{:.3} E{e:.5} F1800\n", pair[1][0], pair[1][1]));
    }
    filament
}

fn program() -> String {
    program_at(BEAM)
}

fn program_at(beam_mm: f64) -> String {
    let mut post = String::new();
    let first = layers(&mut post, [-5.0, -5.0, 0.0], 150);
    // The beam: machine x = -y in -5..5, y = -z - 20 in -78..-68, z = x - 20 in -15..-9.
    let (mut beam, low) = (String::new(), -(beam_mm + 30.0));
    let second = layers(&mut beam, [-5.0, low, -15.0], 15);
    let begins = low + 0.4;
    format!(
        ";TRUNNION version=0 plan=0 profile=generic-ac
;TRUNNION expect print=0 part=0 filament_mm={first:.5}
;TRUNNION expect print=1 part=1 filament_mm={second:.5}
G21\nG90\nG28\nM190 S60\nM109 S200\nM83
G1 Z120 F900
;TRUNNION slot=0 part=0 A=0 C=0
G1 C0 F1800
G1 A0 F1200
G1 X-4.6 Y-4.6 F6000
;TRUNNION print=0 part=0
G1 Z0.4 F900
G1 E2 F2100
{post}G1 E-2 F2100
G1 Z130 F900
;TRUNNION slot=1 part=1 A=90 C=90
G1 C90 F1800
G1 A90 F1200
G1 X-4.6 Y{begins:.1} F6000
;TRUNNION print=1 part=1
G1 Z-14 F900
G1 E2 F2100
{beam}G1 E-2 F2100
G1 Z130 F900
G1 A0 F1200
;TRUNNION end
M104 S0
M140 S0
M107
M84
"
    )
}

fn run(text: &str, profile: &Profile) -> Report {
    let (plan, model) = (plan(), model());
    let workpiece = Workpiece::place(&model, &plan.placement);
    verify(text.as_bytes(), &ReplayJob { profile, plan: &plan, workpiece: &workpiece })
}

/// The program with the `n`th (from 0) occurrence of `old` replaced.
fn changed(old: &str, n: usize, new: &str) -> String {
    let text = program();
    let (at, _) = text.match_indices(old).nth(n).unwrap_or_else(|| panic!("{old:?} is not there {n} times"));
    format!("{}{new}{}", &text[..at], &text[at + old.len()..])
}

/// That breaking it in this way breaks exactly these rules.
fn breaks(text: &str, rules: &[Rule]) -> Report {
    let report = run(text, &profile());
    let found: Vec<Rule> = report.counts.keys().copied().collect();
    assert_eq!(found, rules, "{:#?}", report.findings);
    report
}

#[test]
fn the_valid_program_is_clean() {
    let report = breaks(&program(), &[]);
    assert!(report.is_clean() && report.count() == 0);
    assert_eq!(report.slots, 2);
    assert!(report.filament_mm > 1000.0 && report.seconds_print > 60.0);
    // At Z120 the block is 130 above the table's plane and the ball's radius is 100.3 about its centre.
    assert!(report.clearance_mm > 5.0 && report.clearance_line > 0, "{report:?}");
}

#[test]
fn syntax() {
    let report = breaks(&changed("M84", 0, "M84\nG20\n\u{1}junk"), &[Rule::Syntax]);
    assert_eq!(report.counts[&Rule::Syntax], 2);
    breaks(&changed(";TRUNNION end", 0, ";TRUNNION print=7x\n;TRUNNION end"), &[Rule::Syntax]);
    for bytes in [&b"\xff\xfe\x00"[..], b"", b"G1 X", b"G1 X1e99", b"\n\n\n;"] {
        let (plan, model) = (plan(), model());
        let workpiece = Workpiece::place(&model, &plan.placement);
        assert!(!verify(bytes, &ReplayJob { profile: &profile(), plan: &plan, workpiece: &workpiece }).is_clean());
    }
}

#[test]
fn command() {
    for line in [
        "M206 Z5",
        "M428",
        "M290 Z-2",
        "M92 E200",
        "G10 P0 Z5",
        "SET_GCODE_OFFSET Z=-2",
        "T1",
        "M84",
        "M112",
        "M221 S500",
        "M220 S30",
        "M200 D1.75",
        "G29",
        "M104 S200\nM302 S0",
        "M32 x.g",
        "M7777",
    ] {
        let report = run(&changed(";TRUNNION slot=1", 0, &format!("{line}\n;TRUNNION slot=1")), &profile());
        assert_eq!(report.counts.get(&Rule::Command), Some(&1), "{line}: {:?}", report.findings.first());
    }
    // A person may be waited for above all that stands, as here before a turn.
    assert!(run(&changed(";TRUNNION slot=1", 0, "M600\n;TRUNNION slot=1"), &profile()).is_clean());
    // Not below the post's top, though the axis end there: the head may be driven away.
    let mut low = profile();
    for (end, waits) in [(58.5, false), (61.0, true)] {
        low.limits.z_mm[1] = end;
        let lifted = changed("G1 Z130 F900", 0, &format!("G1 Z{end} F900"));
        let report = run(&lifted.replacen(";TRUNNION slot=1", "M600\n;TRUNNION slot=1", 1), &low);
        assert_eq!(report.counts.contains_key(&Rule::Command), !waits, "{end}: {:?}", report.findings);
    }
    // In the profile's own start and end code they stand by right, elsewhere only by name.
    breaks(&changed("G90\nG28", 0, "G90\nM206 Z5\nG28"), &[Rule::Command]);
    let mut own = profile();
    own.dialect.start += "\nM206 Z5";
    assert!(run(&changed("G90\nG28", 0, "G90\nM206 Z5\nG28"), &own).is_clean());
    own.dialect.allow = vec!["m42".to_owned()];
    assert!(run(&changed(";TRUNNION slot=1", 0, "M42 P3 S1\n;TRUNNION slot=1"), &own).is_clean());
    for harmless in ["M204 P500", "M117 M112", "M106 S9", "M400", "M220 S100", "M73 P5"] {
        breaks(&changed(";TRUNNION slot=1", 0, &format!("{harmless}\n;TRUNNION slot=1")), &[]);
    }
}

#[test]
fn axis_limit() {
    let report = breaks(&changed("G1 Z130 F900", 1, "G1 Z330 F900"), &[Rule::AxisLimit]);
    assert_eq!((report.findings[0].measured, report.findings[0].allowed), (330.0, 320.0));
    breaks(&changed("G1 A0 F1200\n;TRUNNION end", 0, "G1 A-20 F1200\n;TRUNNION end"), &[Rule::AxisLimit]);
}

#[test]
fn a_coordinate_from_nowhere_is_one_finding_of_its_own_and_spoils_no_other() {
    let far = changed("G1 X4.600 Y-77.600 E1.09263", 3, "G1 X63523.000 Y-77.600 E1.09263");
    let report = run(&far, &profile());
    assert!(
        report.counts.contains_key(&Rule::AxisLimit) && !report.counts.contains_key(&Rule::HeadCollision),
        "{report:?}"
    );
}

#[test]
fn axis_rate() {
    let report = breaks(&changed("G1 A90 F1200", 0, "G1 A90 F1500"), &[Rule::AxisRate]);
    assert_eq!(report.findings[0].measured, 25.0);
    breaks(&changed("F6000", 0, "F16000"), &[Rule::AxisRate]);
    let text = changed("G1 C0 F1800", 0, "G1 C0");
    breaks(&text.replacen("G1 Z120 F900", "G1 Z120", 1), &[Rule::AxisRate]);
}

#[test]
fn turn_while_extruding() {
    breaks(&changed("G1 A0 F1200\n;TRUNNION end", 0, "G1 A0 E1 F1200\n;TRUNNION end"), &[Rule::TurnWhileExtruding]);
}

#[test]
fn pose() {
    // A degree short of the plan, over the beam's very last line; what stands is hardly moved.
    let report = breaks(&changed("G1 A90 F1200", 0, "G1 A89.99 F1200"), &[Rule::Pose]);
    assert!((report.findings[0].measured - 0.01).abs() < 1e-6);
    let text = changed(";TRUNNION print=0 part=0", 0, "");
    let report = run(&text, &profile());
    // Of hundreds of lines before any mark it is said once.
    assert!(report.counts[&Rule::Pose] == 1 && report.counts.contains_key(&Rule::Sequence), "{:?}", report.counts);
}

/// One word too much in a line that prints: a pose that is wrong until the next turn, said once, and nothing that follows from it.
#[test]
fn a_stray_table_word_is_one_mistake_and_costs_no_more_than_none() {
    let clean = run(&program(), &profile());
    let text = program();
    let lines: Vec<usize> = text
        .match_indices(" F1800\n")
        .map(|(at, _)| at)
        .filter(|at| text[..*at].contains("print=0 part=0\nG1 Z"))
        .collect();
    for (share, word) in [(0.1, " A1"), (0.5, " A0.1"), (0.7, " A-3"), (0.5, " C1"), (0.9, " A40")] {
        let at = lines[(lines.len() as f64 * share) as usize];
        let report = run(&format!("{}{word}{}", &text[..at], &text[at..]), &profile());
        let turned = [Rule::TurnWhileExtruding, Rule::Pose, Rule::TurnCollision, Rule::Retract, Rule::AxisRate];
        let beside: Vec<_> = report.counts.iter().filter(|(rule, _)| !turned.contains(rule)).collect();
        assert!(beside.is_empty() && report.count() <= 8, "{word} at {share}: {:?}", report.counts);
        assert_eq!(report.counts[&Rule::Pose], 1);
        let pose = report.findings.iter().find(|f| f.rule == Rule::Pose).unwrap();
        assert!(pose.text.ends_with("collisions and support are not checked there"), "{}", pose.text);
        assert!(report.steps <= clean.steps, "{} steps for {}", report.steps, clean.steps);
    }
}

/// What is printed after an astray setup is judged as if that had been where the plan has it: a mistake in it is found all the same.
#[test]
fn a_mistake_behind_a_wrong_pose_is_found() {
    let post = "G1 X4.600 Y-4.600 E";
    let text = program();
    let at = text.find(post).unwrap();
    let end = at + text[at..].find(" F1800").unwrap();
    let astray = format!("{} A1{}", &text[..end], &text[end..]);
    assert!(!run(&astray, &profile()).counts.contains_key(&Rule::HeadCollision));
    // The beam's travel dips into the post, which stands where it was planned.
    let low = astray.replacen("G1 A90 F1200\n", "G1 A90 F1200\nG1 X0 Y-30 F6000\nG1 Z-30 F900\nG1 Z130\n", 1);
    let report = run(&low, &profile());
    assert!(report.counts.contains_key(&Rule::HeadCollision), "{:?}", report.counts);
}

/// A table that turns there and back without end, each time under a move: as often as a plan could ask for it is followed.
#[test]
fn a_table_that_turns_without_end_is_followed_to_a_bound() {
    let turning = |times: usize| {
        let turns = "G1 A1 F1200\nG1 X1 F6000\nG1 A0 F1200\nG1 X0 F6000\n".repeat(times);
        run(
            &changed("G1 Z130 F900\n;TRUNNION slot=1", 0, &format!("G1 Z130 F900\n{turns};TRUNNION slot=1")),
            &profile(),
        )
    };
    let few = turning(20);
    assert!(few.is_clean(), "{:?}", few.findings.first());
    let [many, more] = [100, 400].map(turning);
    for report in [&many, &more] {
        assert_eq!(report.counts.iter().collect::<Vec<_>>(), [(&Rule::Sequence, &1)]);
        assert!(report.findings[0].text.contains("far more often than 2 prints need"), "{}", report.findings[0].text);
    }
    assert_eq!(more.steps, many.steps);
}

/// Any single byte changed, of a program of a good thousand lines: the replay costs at most three times as much, and says no more than
/// it can show.
#[test]
fn no_single_byte_costs_more_than_three_times_the_clean_run() {
    let bytes = program().into_bytes();
    let clean = run(&program(), &profile());
    let mut numbers = SplitMix64::seeded(44);
    let mut dearest = (0.0, String::new());
    for _ in 0..40 {
        let at = numbers.below(bytes.len());
        let mut changed = bytes.clone();
        // Half of them a digit for a digit, which reads best.
        changed[at] = if bytes[at].is_ascii_digit() {
            b"0123456789.-"[numbers.below(12)]
        } else {
            b' ' + numbers.below(95) as u8
        };
        let text = String::from_utf8(changed).unwrap();
        let report = run(&text, &profile());
        let line = text[..at].matches('\n').count();
        let cost = report.steps as f64 / clean.steps as f64;
        if cost > dearest.0 {
            dearest = (cost, format!("{:?}: {:?}", text.lines().nth(line), report.counts));
        }
        assert!(report.moves <= clean.moves + 1 && report.findings.len() <= 1000 && report.count() < 2 * clean.moves);
    }
    assert!(dearest.0 <= 3.0, "{dearest:?}");
}

#[test]
fn a_flipped_tilt_is_a_wrong_pose() {
    let mut profile = profile();
    profile.kinematics.tilt.min_deg = -90.0;
    let report = run(&changed("G1 A90 F1200", 0, "G1 A-90 F1200"), &profile);
    assert!(report.counts.contains_key(&Rule::Pose), "{:?}", report.counts);
    let pose = report.findings.iter().find(|f| f.rule == Rule::Pose).unwrap();
    assert!(pose.text.contains("180.000 deg from upright"), "{}", pose.text);
}

#[test]
fn outside_part() {
    // The first side of the last loop bulges by 1.6 mm and goes back; its edge was on the outline. Bulging, it takes more filament.
    let text = program();
    let last = text.match_indices("G1 X4.600 Y-77.600 E").last().unwrap().0;
    let text = format!(
        "{}G1 X0 Y-79.2 E0.57842 F1800\nG1 X4.600 Y-77.600 E0.57842{}",
        &text[..last],
        &text[text[last..].find(" F1800").unwrap() + last..]
    );
    let report = breaks(&text, &[Rule::OutsidePart, Rule::Filament]);
    assert!((report.findings[0].measured - 1.6).abs() < 1e-4, "{:?}", report.findings[0]);
    assert_eq!((report.findings[0].slot, report.findings[0].part), (Some(1), Some(1)));
}

#[test]
fn in_air() {
    // A whole layer is missing, and with it the support of the one above; its filament is laid in the one below.
    let text = program();
    let (from, to) = (text.find("G1 Z8.000 F900").unwrap(), text.find("G1 Z8.400 F900").unwrap());
    let text =
        format!("{}{}{}", &text[..from], text[from..to].replace("G1 Z8.000 F900", "G1 Z7.600 F900"), &text[to..]);
    let report = breaks(&text, &[Rule::InAir, Rule::Flow, Rule::Fill, Rule::Complete]);
    let measured = |rule: Rule| report.findings.iter().find(|finding| finding.rule == rule).unwrap().measured;
    assert!(measured(Rule::Flow) > 9.0 && measured(Rule::Fill) > 1.95, "{:?}", report.findings);
}

#[test]
fn head_collision() {
    // Across the post, 3 mm below its top, at the second pose's safe height turned wrong: a travel dips into the beam's post.
    let text = changed(
        "G1 E-2 F2100\nG1 Z130 F900\n;TRUNNION slot=1",
        0,
        "G1 E-2 F2100\nG1 Z62 F900\nG1 X30 F6000\nG1 Z57 F900\nG1 X-30 F6000\nG1 Z130 F900\n;TRUNNION slot=1",
    );
    let report = breaks(&text, &[Rule::HeadCollision]);
    assert!(report.findings[0].measured > 3.0, "{:?}", report.findings[0]);
    assert!(report.findings[0].text.starts_with("the nozzle"));
    // Beside the post, low: the nozzle is free, the block is not.
    let text = changed(
        "G1 E-2 F2100\nG1 Z130 F900\n;TRUNNION slot=1",
        0,
        "G1 E-2 F2100\nG1 Z62 F900\nG1 X30 F6000\nG1 Z30 F900\nG1 X13.5 F6000\nG1 X30\nG1 Z130 F900\n;TRUNNION slot=1",
    );
    let report = breaks(&text, &[Rule::HeadCollision]);
    assert!(report.findings[0].text.starts_with("the block"), "{:?}", report.findings[0]);
    assert!((1.5..2.0).contains(&report.findings[0].measured), "{:?}", report.findings[0]);
}

/// The block, 10 mm to either side of the tip, beside the post whose face is at X 5: the distance told is the distance, and
/// what touches is a finding, to hundredths of a millimetre.
#[test]
fn clearance_sideways() {
    for gap in [4.0, 1.0, 0.3, 0.1, 0.05, 0.03, -0.03, -0.05, -0.1, -0.3, -1.0, -4.0] {
        let way = format!(
            "G1 E-2 F2100\nG1 Z62 F900\nG1 X40 Y-3 F6000\nG1 Z30 F900\nG1 X{} Y2 F6000\nG1 X40\nG1 Z130 F900\n;TRUNNION slot=1",
            15.0 + gap
        );
        let report = run(&changed("G1 E-2 F2100\nG1 Z130 F900\n;TRUNNION slot=1", 0, &way), &profile());
        let hit = report.counts.contains_key(&Rule::HeadCollision);
        assert_eq!(hit, gap < 0.0, "{gap}: {report:?}");
        if gap > 0.0 {
            assert!((report.clearance_mm - gap).abs() < 0.02, "{gap}: {}", report.clearance_mm);
        }
    }
}

/// The nozzle's flat in the side of the post, which lies on its back: a layer and half a line are let pass, 0.8 mm, and what is deeper
/// is a finding, to hundredths of a millimetre. A bead counts with the circle about its cross-section, which reaches 0.447 mm from
/// its middle where half of its width is 0.4.
#[test]
fn depth_of_the_nozzle_in_what_is_printed() {
    let more = 0.2_f64.hypot(0.4) - 0.4;
    for depth in [-1.0, 0.0, 0.5, 0.7, 0.78, 0.79, 0.81, 0.82, 0.85, 0.9, 1.0, 1.5, 3.0] {
        let z = -15.0 + more - depth;
        let way = format!("G1 X-3 Y-60 F6000\nG1 Z{z:.3} F900\nG1 X3\nG1 Z30 F900\nG1 X-4.6 Y-77.6 F6000");
        let report = run(&changed("G1 X-4.6 Y-77.6 F6000", 0, &way), &profile());
        assert_eq!(report.counts.contains_key(&Rule::HeadCollision), depth > 0.8, "{depth}: {:?}", report.findings);
    }
}

/// Two posts that do not touch, printed one after the other: how near the nozzle comes to the first beside the second.
#[test]
fn clearance_of_the_nozzle_beside_another_print() {
    // The nozzle is a cone of 32 sides about 0.5 mm at the tip and 8 mm ten higher. The first post is 8.8 mm high, its edge so much
    // above the tip in the lowest layer, and the outer wall's middle is half a line inside the second.
    let grow = 1.0 / (std::f64::consts::PI / 32.0).cos();
    let (radius, lean) = ((0.5 + 0.75 * (8.8 - LAYER)) * grow, (0.75 * grow).atan().cos());
    for gap in [1.2, 0.5, 0.2, 0.1, 0.05, 0.03] {
        let away = radius + gap / lean;
        let near = 5.0 + away + 9.6;
        let solid = |x: f64, high: f64| solid_box(Vec3::new(x - 10.0, -5.0, 0.0), Vec3::new(x, 5.0, high));
        let model = Model::from_parts(vec![("tall".to_owned(), solid(5.0, 8.8)), ("low".to_owned(), solid(near, 4.0))]);
        let mut plan = plan();
        plan.slots[1].prints[0] =
            Print { part: 1, up: [0.0, 0.0, 1.0], tilt_deg: 0.0, rotation_deg: 0.0, supports: None };
        let (mut tall, mut low) = (String::new(), String::new());
        let first = layers(&mut tall, [-5.0, -5.0, 0.0], 22);
        let second = layers(&mut low, [near - 10.0, -5.0, 0.0], 10);
        let text = program();
        let head = &text[text.find("G21").unwrap()..text.find("G1 X-4.6").unwrap()];
        let foot = &text[text.rfind("G1 A0").unwrap()..];
        let text = format!(
            ";TRUNNION version=0 plan=0 profile=generic-ac
;TRUNNION expect print=0 part=0 filament_mm={first:.5}
;TRUNNION expect print=1 part=1 filament_mm={second:.5}
{head}G1 X-4.6 Y-4.6 F6000\n;TRUNNION print=0 part=0\nG1 Z0.4 F900\nG1 E2 F2100
{tall}G1 E-2 F2100\nG1 Z130 F900\n;TRUNNION slot=1 part=1 A=0 C=0\nG1 X{} Y-4.6 F6000
;TRUNNION print=1 part=1\nG1 Z0.4 F900\nG1 E2 F2100
{low}G1 E-2 F2100\nG1 Z130 F900\n{foot}",
            near - 9.6
        );
        let workpiece = Workpiece::place(&model, &plan.placement);
        let job = ReplayJob { profile: &profile(), plan: &plan, workpiece: &workpiece };
        let report = verify(text.as_bytes(), &job);
        assert!(report.is_clean(), "{gap}: {:?}", report.findings);
        assert!((report.clearance_mm - gap).abs() < 0.02, "{gap}: {}", report.clearance_mm);
        // Move by move, for pictures: the post's upper edge beside the cone, or the heater block (20 mm wide, 10 mm up) above it.
        let rooms_are = |x: f64, z: f64| {
            let cone = (x - 5.0 - (0.5 + 0.75 * (8.8 - z)) * grow) * lean;
            cone.min((x - 15.0).max(0.0).hypot(z + 10.0 - 8.8))
        };
        rooms_hold(&text, &job, near, rooms_are);
    }
}

/// The rooms of what is printed from x = `near` - 10 on (tip at `x`, `z`) are lower bounds of `exact`, and not far below.
fn rooms_hold(text: &str, job: &ReplayJob<'_>, near: f64, exact: impl Fn(f64, f64) -> f64) {
    let trace = trace::read(text.as_bytes(), &job.profile.trace_setting());
    let rooms = rooms(&trace, job);
    assert!(rooms.windows(2).all(|two| two[0].moves.end <= two[1].moves.start));
    let (mut told, mut tight) = (0, 0);
    for m in trace.moves().filter(TraceMove::prints) {
        let [from, to] = m.ends().expect("a line has two ends");
        let (a, b, z) = (from.x, to.x, to.z);
        let at = rooms.partition_point(|room| room.moves.end <= m.index);
        let room =
            rooms.get(at).filter(|room| room.moves.contains(&m.index)).expect("each line of a print has its room").mm;
        // What the first print does not print on is not there yet.
        let exact = if a.min(b) > near - 10.0 { exact(a.min(b), z).min(SURVEYED_MM) } else { SURVEYED_MM };
        assert!(
            room <= exact + 0.02 && room >= exact - 0.55,
            "x {a}..{b}, z {z}: {room} mm told, {exact} mm are there"
        );
        (told, tight) = (told + 1, tight + usize::from(exact < SURVEYED_MM));
    }
    assert!(told > 400 && tight > 100, "{told} moves, {tight} of them tight");
}

#[test]
fn turn_collision() {
    // The tip waits over the table's rim, lower than it swings up.
    let text = changed(
        "G1 E-2 F2100\nG1 Z130 F900\n;TRUNNION slot=1",
        0,
        "G1 E-2 F2100\nG1 Z130 F900\nG1 X0 Y40 F6000\nG1 Z62 F900\n;TRUNNION slot=1",
    );
    let report = breaks(&text.replacen("G1 A90 F1200", "G1 A90 F1200\nG1 Z130 F900", 1), &[Rule::TurnCollision]);
    assert!(report.findings.iter().any(|f| f.text.contains("while the table turns")));
}

#[test]
fn a_turn_below_the_ball_is_stepped_through() {
    // Behind the post and lower than the ball's top, the tilt still clears the head.
    let text = changed(
        "G1 E-2 F2100\nG1 Z130 F900\n;TRUNNION slot=1",
        0,
        "G1 E-2 F2100\nG1 Z130 F900\nG1 X0 Y-150 F6000\nG1 Z85 F900\n;TRUNNION slot=1",
    );
    breaks(&text.replacen("G1 A90 F1200", "G1 A90 F1200\nG1 Z130 F900", 1), &[]);
}

#[test]
fn the_frame_against_what_turns() {
    use crate::profile::{BodyKind, BodySpec};
    let mut profile = profile();
    let body = |min_mm, max_mm| BodySpec {
        turns: true,
        name: "beam".to_owned(),
        kind: BodyKind::Box,
        min_mm: Some(min_mm),
        max_mm: Some(max_mm),
        moves: String::new(),
        z_mm: None,
        r_mm: None,
        points_mm: None,
    };
    profile.fixed.body = vec![body([-20.0, 130.0, -200.0], [20.0, 140.0, 300.0])];
    assert!(run(&program(), &profile).is_clean());
    // The table's lower edge swings through this one.
    profile.fixed.body = vec![body([-20.0, -10.0, -110.0], [20.0, 30.0, -90.0])];
    let report = run(&program(), &profile);
    assert!(report.counts.contains_key(&Rule::TurnCollision), "{:?}", report.counts);
}

#[test]
fn filament() {
    let report = breaks(&changed("E1.09263", 5, "E1.11263"), &[Rule::Filament]);
    assert!((report.findings[0].measured - report.findings[0].allowed - 0.02).abs() < 1e-3);
}

#[test]
fn retract() {
    let report = breaks(&changed("G1 E2 F2100", 1, ""), &[Rule::Retract]);
    assert!((report.findings[0].measured - 2.0).abs() < 1e-9);
    let text = changed("G1 Z130 F900\n;TRUNNION slot=1", 0, "G11\nG1 Z130 F900\n;TRUNNION slot=1");
    breaks(&text, &[Rule::Retract]);
    breaks(&changed(";TYPE:Solid infill", 9, "G10\n;TYPE:Solid infill"), &[Rule::Retract]);
}

#[test]
fn unknown_position() {
    let text =
        changed("G1 E-2 F2100\nG1 Z130 F900\n;TRUNNION slot=1", 0, "G1 E-2 F2100\nG28\nG1 Z130 F900\n;TRUNNION slot=1");
    breaks(&text, &[Rule::Command, Rule::UnknownPosition]);
    breaks(&changed("G1 Z120 F900", 0, "G1 X0 Y0 F6000\nG1 Z120 F900"), &[Rule::UnknownPosition]);
}

#[test]
fn sequence() {
    breaks(&changed("expect print=1", 0, "was print=1"), &[Rule::Sequence]);
    breaks(&changed(";TRUNNION slot=1", 0, ";TRUNNION slot=5"), &[Rule::Sequence]);
    breaks(&changed("print=1 part=1\nG1 Z", 0, "print=1 part=0\nG1 Z"), &[Rule::Sequence]);
    // The beam is missing altogether.
    let text = program();
    let (from, to) = (text.find(";TRUNNION slot=1").unwrap(), text.find("G1 A0 F1200\n;TRUNNION end").unwrap());
    breaks(&format!("{}{}", &text[..from], &text[to..]), &[Rule::Sequence]);
}

#[test]
fn the_report_is_the_same_for_any_number_of_threads() {
    let text = changed("E1.09263", 5, "E1.11263");
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let report = |r: &Report| serde_json::to_string(r).unwrap();
    assert_eq!(one.install(|| report(&run(&text, &profile()))), report(&run(&text, &profile())));
    assert!(report(&run(&text, &profile())).contains(r#""rule":"filament""#));
}
