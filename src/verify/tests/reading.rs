//! Lines that the machine's firmware takes for something else, and moves behind the end.

use super::{Rule, breaks, changed, profile, program, run};
use crate::verify::Report;

/// A line of the post in the middle of its print.
const LINE: &str = "G1 X4.600 Y-4.600 E";

/// The program with something behind a line's coordinates.
fn with(behind: &str) -> String {
    changed(LINE, 40, &format!("{}{behind} E", LINE.trim_end_matches(" E")))
}

fn found(report: &Report, rule: Rule) -> bool {
    report.counts.contains_key(&rule)
}

#[test]
fn what_marlin_takes_for_words_is_no_comment() {
    for (behind, wrong) in [("", false), (" (Z-5)", true), (" (wall)", true), (" E5", true), (" x4.6", true)] {
        let report = run(&with(behind), &profile());
        assert_eq!(found(&report, Rule::Reading), wrong, "{behind:?}: {:#?}", report.findings);
    }
    breaks(&with(" (Z-5)"), &[Rule::Reading]);
    breaks(&program().replacen("M83\n", "; X5 (Z-5) x5\nM83 ; (Z-5)\n", 1), &[]);
}

/// Digits that change no number, until the line is too long for the firmware: the size at which it is found.
#[test]
fn a_line_is_too_long_from_the_first_byte_that_is_not_read() {
    let with = |zeros: usize| changed(LINE, 40, &format!("G1 X4.600{} Y-4.600 E", "0".repeat(zeros)));
    let length = |text: &str, zeros: usize| {
        let begins = format!("G1 X4.600{}", "0".repeat(zeros));
        text.lines().find(|line| line.starts_with(&begins)).map_or(0, str::len)
    };
    let shortest = length(&with(1), 1) - 1;
    // Far from the length, just below it, at it, and beyond.
    for long in [shortest + 1, 60, 94, 95, 96, 97, 110, 150] {
        let zeros = long - shortest;
        let text = with(zeros);
        assert_eq!(length(&text, zeros), long);
        let report = run(&text, &profile());
        assert_eq!(found(&report, Rule::Reading), long >= 96, "{long} bytes");
        assert!(long < 96 || report.findings[0].measured as usize == long, "{:?}", report.findings[0]);
    }
}

#[test]
fn each_profile_has_its_own_reader() {
    let of = |firmware: &str| {
        let mut profile = profile();
        firmware.clone_into(&mut profile.dialect.firmware);
        profile
    };
    // Klipper takes the last of two words, and no leading zeros.
    for (firmware, behind, wrong) in
        [("klipper", " X4.6", false), ("reprapfirmware", " X4.6", true), ("marlin", " X4.6", true)]
    {
        assert_eq!(found(&run(&with(behind), &of(firmware)), Rule::Reading), wrong, "{firmware}");
    }
    let zeros = changed(LINE, 40, &LINE.replace("G1", "G01"));
    assert!(found(&run(&zeros, &of("klipper")), Rule::Reading) && !found(&run(&zeros, &of("marlin")), Rule::Reading));
}

/// A program in per cent signs is one; at a second sign before its last line the rest is not run.
#[test]
fn linuxcnc_ends_a_program_at_its_second_percent_sign() {
    let mut linuxcnc = profile();
    linuxcnc.dialect.firmware = "linuxcnc".to_owned();
    let middle = changed(";TYPE:Solid infill", 40, "%\n;TYPE:Solid infill");
    for (text, wrong) in [
        (program(), false),
        (format!("%\n{}%\n", program()), false),
        (middle.clone(), true),
        (format!("%\n{middle}"), true),
    ] {
        assert_eq!(found(&run(&text, &linuxcnc), Rule::Reading), wrong, "{:.20}", text);
    }
    // How far it may leave its path only the start code says.
    let blends = |report: &Report| report.findings.iter().any(|f| f.text.contains("may leave its path"));
    let blend = changed(";TRUNNION slot=1", 0, "G64 P2\n;TRUNNION slot=1");
    assert!(blends(&run(&blend, &linuxcnc)) && !blends(&run(&program(), &linuxcnc)));
}

#[test]
fn bytes_around_lines_count_too() {
    breaks(&format!("\u{feff}{}", program()), &[]);
    breaks(&format!("\u{feff}G21\n{}", program()), &[Rule::Reading]);
    breaks(&program().replace('\n', "\r\n"), &[]);
    let hidden = changed(";TYPE:Solid infill", 40, ";TYPE:Solid infill\rG1 Z-5");
    assert!(found(&run(&hidden, &profile()), Rule::Reading));
}

#[test]
fn nothing_moves_behind_the_end_but_the_profiles_own_code() {
    for line in ["G28", "G1 X0 F6000", "G1 E5 F100", "G28 X"] {
        let text = changed(";TRUNNION end\n", 0, &format!(";TRUNNION end\n{line}\n"));
        assert!(found(&run(&text, &profile()), Rule::Command), "{line}");
        let mut own = profile();
        own.dialect.end = format!("{line}\n{}", own.dialect.end);
        assert!(!found(&run(&text, &own), Rule::Command), "{line}");
    }
}
