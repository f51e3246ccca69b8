//! Start, middle and end as states: homed, hot and waited for, settings as the print began with them. Each fault from nothing to gross.

use super::{Rule, breaks, changed, profile, program, run};
use crate::profile::Profile;
use crate::verify::Report;

/// The program with lines in the middle of the post.
fn within(lines: &str) -> String {
    changed(";TYPE:Solid infill", 60, &format!("{lines}\n;TYPE:Solid infill"))
}

fn start(lines: &str) -> String {
    changed("G28\nM190 S60\nM109 S200\n", 0, lines)
}

fn finds(text: &str, rule: Rule) -> bool {
    run(text, &profile()).counts.contains_key(&rule)
}

#[track_caller]
fn only(report: &Report, rule: Rule, is: bool) {
    let found: Vec<Rule> = report.counts.keys().copied().collect();
    assert_eq!(found, if is { vec![rule] } else { vec![] }, "{:#?}", report.findings);
}

#[test]
fn every_axis_is_homed_before_it_moves() {
    for (home, wrong) in [
        ("G28\n", false),
        ("G28 X Y Z\n", false),
        ("G28 X Y\nG28 Z\n", false),
        ("G28 W\n", false),
        ("", true),
        ("G28 X Y\n", true),
        ("G28 Z\n", true),
        ("G28 A C\n", true),
    ] {
        let report = run(&start(&format!("{home}M190 S60\nM109 S200\n")), &profile());
        only(&report, Rule::UnknownPosition, wrong);
    }
    // Motors off, and nobody knows any more; a macro of the start code may home.
    let mut macros = profile();
    macros.dialect.start = "START_PRINT".to_owned();
    let text = start("START_PRINT\nM190 S60\nM109 S200\n");
    assert!(!run(&text, &macros).counts.contains_key(&Rule::UnknownPosition));
    assert!(finds(&start("G28\nM18\nM190 S60\nM109 S200\n"), Rule::UnknownPosition));
}

#[test]
fn the_nozzle_is_waited_for() {
    for (heat, wrong) in [
        ("M109 S200", false),
        ("M109 R200", false),
        ("M104 S200", true),
        ("M104 S200\nM109", true),
        ("M109", true),
        ("M104 S200\nM116", true),
    ] {
        let report = run(&start(&format!("G28\nM190 S60\n{heat}\n")), &profile());
        assert_eq!(report.counts.contains_key(&Rule::Heat), wrong, "{heat}: {:#?}", report.findings);
    }
    let mut rrf = profile();
    rrf.dialect.firmware = "reprapfirmware".to_owned();
    assert!(run(&start("G28\nM140 S60\nM104 S200\nM116\n"), &rrf).is_clean());
}

#[test]
fn the_bed_is_waited_for_and_stays_warm() {
    for (bed, wrong) in [
        ("M190 S60", false),
        ("M140 S60\nM190 S60", false),
        ("M190 R60", false),
        // A table without heat, said so.
        ("M190 S0", false),
        ("M140 S60", true),
        ("M140 S60\nM140 S60", true),
        ("M140 S60\nM190", true),
        ("M140 S60\nM190 S0", true),
        ("", true),
    ] {
        only(&run(&start(&format!("G28\n{bed}\nM109 S200\n")), &profile()), Rule::Heat, wrong);
    }
    // Half of the heat that it began with.
    for (celsius, wrong) in
        [(60.0, false), (55.0, false), (40.0, false), (30.0, false), (29.9, true), (10.0, true), (0.0, true)]
    {
        let report = run(&within(&format!("M140 S{celsius}")), &profile());
        only(&report, Rule::Heat, wrong);
        assert!(!wrong || report.findings[0].measured == celsius);
    }
    // Where nothing heats the bed and the profile does not ask for it, nothing is missing.
    let mut cold = profile();
    cold.dialect.start = "G28\nM109 S{nozzle_c}".to_owned();
    assert!(run(&start("G28\nM109 S200\n"), &cold).is_clean());
    // A slicer's bed for the layers behind the first, where the start code has another way to heat it.
    let later = start("G28\nM109 S200\n").replacen("G1 Z2.000", "M140 S55\nG1 Z2.000", 1);
    assert!(later.contains("M140 S55") && run(&later, &cold).is_clean());
}

#[test]
fn at_the_end_nothing_is_hot() {
    for (line, wrong) in [
        ("M104 S0", false),
        ("M104 S1", true),
        ("M104 S250", true),
        ("M140 S60", true),
        ("M141 S40", true),
        ("M104 T1 S200", true),
    ] {
        let report = run(&format!("{}{line}\n", program()), &profile());
        assert_eq!(report.counts.contains_key(&Rule::Heat), wrong, "{line}: {:#?}", report.findings);
    }
    // End code that leaves the bed on, and one that may do anything.
    for (end, wrong) in [("M104 S0\nM84", true), ("END_PRINT", false)] {
        let mut own = profile();
        own.dialect.end = end.to_owned();
        let text = program().replace("M104 S0\nM140 S0\nM107\nM84\n", &format!("{end}\n"));
        assert_eq!(run(&text, &own).counts.contains_key(&Rule::Heat), wrong, "{end}");
    }
}

#[test]
fn accelerations_are_within_reach_of_the_profiles() {
    for (value, wrong) in [
        (0.0, true),
        (1.0, true),
        (9.0, true),
        (10.0, false),
        (500.0, false),
        (1_500.0, false),
        (20_000.0, false),
        (50_000.0, false),
        (50_001.0, true),
        (100_000.0, true),
    ] {
        for letter in ["S", "P", "T"] {
            only(&run(&within(&format!("M204 {letter}{value}")), &profile()), Rule::Setting, wrong);
        }
    }
    // For each kind of line anew, as slicers do.
    breaks(&within("M204 S800\nM205 X8 Y8\nM201 X900 Y900").replace("M107", "M204 S1000\nM107"), &[]);
    for line in ["M201 X1", "M201 Z0.5", "M205 X200", "M566 X90000", "M205 J3"] {
        assert!(finds(&within(line), Rule::Setting), "{line}");
    }
}

#[test]
fn what_a_print_begins_with_it_ends_with() {
    let begun = "M203 X200 Y200 Z12 E120\nM900 K0.05\nM207 S2 F2400\nM208 S0\nM205 S0 T0\n";
    let text = |line: &str| within(line).replacen("M83\n", &format!("M83\n{begun}"), 1);
    for (line, wrong) in [
        ("M203 X200 Y200", false),
        ("M203 X199", true),
        ("M203 X5", true),
        ("M900 K0.05", false),
        // As far as a slicer adapts it.
        ("M900 K0.03", false),
        ("M900 K0.15", false),
        ("M900 K0.16", true),
        ("M900 K0", true),
        ("M900 K5", true),
        ("M207 S2", false),
        ("M207 S1.9", true),
        ("M207 S0", true),
        ("M208 S0", false),
        ("M208 S0.01", true),
        ("M208 S10", true),
        ("M205 S5", true),
    ] {
        only(&run(&text(line), &profile()), Rule::Setting, wrong);
    }
    // What was never set before is not set in the middle; before a print's first line it may be, within bounds.
    assert!(finds(&within("M900 K0.05"), Rule::Setting));
    for (line, wrong) in [("M900 K0.05", false), ("M900 K2.1", true), ("M203 X9", true), ("M203 X10", false)] {
        let text = changed(";TRUNNION print=1 part=1\n", 0, &format!(";TRUNNION print=1 part=1\n{line}\n"));
        only(&run(&text, &profile()), Rule::Setting, wrong);
    }
    // Behind the last line, as in the end code of many printers, it may.
    breaks(&text("M117 nothing").replacen(";TRUNNION end", "M900 K0\n;TRUNNION end", 1), &[]);
}

#[test]
fn what_the_profile_permits_is_no_finding() {
    let permitted = |change: &dyn Fn(&mut Profile)| {
        let mut profile = profile();
        change(&mut profile);
        profile
    };
    let own = permitted(&|p| p.dialect.start += "\nM204 S200000");
    assert!(run(&start("G28\nM190 S60\nM109 S200\nM204 S200000\n"), &own).is_clean());
    let allowed = permitted(&|p| p.dialect.allow = vec!["M203".to_owned()]);
    assert!(run(&within("M203 X5"), &allowed).is_clean());
    let turns = permitted(&|p| p.transition.after_turn = "M204 S200000".to_owned());
    assert!(!run(&program(), &turns).counts.contains_key(&Rule::Setting));
}

#[test]
fn names_of_klipper_are_settings_too() {
    let mut klipper = profile();
    klipper.dialect.firmware = "klipper".to_owned();
    for (line, wrong) in [
        ("SET_VELOCITY_LIMIT ACCEL=3000", false),
        ("SET_VELOCITY_LIMIT ACCEL=100000", true),
        ("SET_VELOCITY_LIMIT VELOCITY=5", true),
        ("SET_PRESSURE_ADVANCE ADVANCE=5", true),
        ("SET_RETRACTION UNRETRACT_EXTRA_LENGTH=10", true),
    ] {
        assert_eq!(run(&within(line), &klipper).counts.contains_key(&Rule::Setting), wrong, "{line}");
    }
}

#[test]
fn a_move_that_as_good_as_stands_is_found() {
    for (feed, wrong) in [(1800.0, false), (60.0, false), (30.0, false), (29.0, true), (1.0, true), (0.01, true)] {
        let text = changed("F1800\n", 60, &format!("F{feed}\n"));
        only(&run(&text, &profile()), Rule::AxisRate, wrong);
        let pull = changed("G1 E-2 F2100", 0, &format!("G1 E-2 F{feed}"));
        only(&run(&pull, &profile()), Rule::AxisRate, wrong);
    }
    for (feed, wrong) in [(1200.0, false), (13.0, false), (11.0, true), (0.01, true)] {
        only(&run(&changed("G1 A90 F1200", 0, &format!("G1 A90 F{feed}")), &profile()), Rule::AxisRate, wrong);
    }
}

#[test]
fn no_object_is_left_out() {
    for (line, wrong) in [("M486 S1", false), ("M486 T3", false), ("M486 P0", true), ("M486 C", true)] {
        only(&run(&within(line), &profile()), Rule::Command, wrong);
    }
}

/// The profile's own lines may level the bed and follow the tip, as long as both are off when a print begins.
#[test]
fn no_correction_of_the_firmwares_own_is_on_while_something_is_printed() {
    let of = |firmware: &str, lines: &str, allow: &[&str]| {
        let mut own = profile();
        own.dialect.firmware = firmware.to_owned();
        own.dialect.start = format!("G28\n{lines}M190 S60\nM109 S200\n");
        own.dialect.allow = allow.iter().map(|name| (*name).to_owned()).collect();
        own
    };
    for (firmware, lines, wrong) in [
        ("marlin", "", false),
        ("marlin", "G29\n", true),
        ("marlin", "G29\nM420 S0\n", false),
        ("marlin", "M420 S0\nG29\n", true),
        ("marlin", "M420 S1\n", true),
        ("reprapfirmware", "G29 S1\n", true),
        ("reprapfirmware", "G29 S1\nG29 S2\n", false),
        ("klipper", "BED_MESH_PROFILE LOAD=default\n", true),
        ("klipper", "BED_MESH_CALIBRATE\nBED_MESH_CLEAR\n", false),
    ] {
        let text = start(&format!("G28\n{lines}M190 S60\nM109 S200\n"));
        // What drives the tip to the bed leaves its place unknown, too.
        let report = run(&text, &of(firmware, lines, &[]));
        assert_eq!(report.counts.contains_key(&Rule::Command), wrong, "{lines}: {:#?}", report.findings);
    }
    for (lines, count) in [("M420 S1", Some(1)), ("M420 S1\nM420 S0", None)] {
        let report = run(&within(lines), &of("marlin", "", &["M420"]));
        assert_eq!(report.counts.get(&Rule::Command).copied(), count, "{lines}: {:#?}", report.findings);
    }
}
