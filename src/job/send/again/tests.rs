//! The proof of a re-entry, with each of its three beginnings broken on purpose.
//!
//! Two boxes on the generic machine: a post, and a beam out of its side that is printed at A90 C90. The print was interrupted in the
//! beam.

use super::proof::ReentryPath;
use super::testing::{Prepared, boxes};
use crate::link::Reentry;

/// The print, and its machine homed by `rehome`.
struct Case {
    print: &'static Prepared,
    entry: Reentry,
}

impl Case {
    fn homed_by(rehome: &str) -> Self {
        let print = boxes();
        let program = &print.program;
        let block = program.boundaries.iter().rev().find(|b| b.block < program.len() - 400).unwrap().block;
        let entry = Reentry::at(program, &print.homed_by(rehome), &(block..block), block).unwrap();
        Self { print, entry }
    }

    fn proved(&self, entry: &Reentry) -> Result<(), String> {
        let (print, program) = (self.print, &self.print.program);
        let last = program.file_line(program.len() - 400);
        let path = ReentryPath::of(print.text(), last, entry, last, print.profile());
        path.struck(print.plan(), print.profile()).map_or(Ok(()), Err)
    }

    /// Our own lines with `change` made to each.
    fn with(&self, change: impl Fn(&str) -> Vec<String>) -> Reentry {
        let mut entry = self.entry.clone();
        let (head, tail) = entry.lines.split_at(entry.home.end);
        entry.lines = head.iter().cloned().chain(tail.iter().flat_map(|line| change(line))).collect();
        entry
    }
}

fn keep(line: &str) -> Vec<String> {
    vec![line.to_owned()]
}

/// A line in the place of the one that rises to the end of Z.
fn rising_to(z: &'static str) -> impl Fn(&str) -> Vec<String> {
    move |line| if line.starts_with("G1Z320") { keep(z) } else { keep(line) }
}

#[test]
fn a_re_entry_turns_as_the_file_does_and_is_clear() {
    let case = Case::homed_by("G28");
    let turns: Vec<&String> =
        case.entry.lines.iter().filter(|l| l.starts_with("G1A") || l.starts_with("G1C")).collect();
    assert!(turns.len() == 2 && turns[0].starts_with("G1C90F") && turns[1].starts_with("G1A90F"), "{turns:?}");
    assert_eq!(case.entry.lines[case.entry.home.clone()], ["G28"]);
    assert_eq!(case.proved(&case.entry), Ok(()));
}

#[test]
fn after_homing_nobody_knows_the_tables_angle() {
    let case = Case::homed_by("G28");
    // The print stood at A90 C90, and were the table there still, nothing would turn. It may be anywhere.
    let low = case.with(rising_to("G1Z90F900"));
    let said = case.proved(&low).unwrap_err();
    assert!(said.contains("turns from an unknown angle"), "{said}");
}

#[test]
fn the_way_from_home_to_the_first_point_is_judged() {
    let rehome = "G28\nG1 Z320 F900\nG1 C90 F1800\nG1 A90 F1200";
    let case = Case::homed_by(rehome);
    assert_eq!(case.proved(&case.entry), Ok(()));
    // At Z 50 the way from where the print was interrupted is free; from anywhere it leads through the upright table.
    let low = case.with(rising_to("G1Z50F900"));
    let said = case.proved(&low).unwrap_err();
    assert!(said.contains("mm into the table or the print"), "{said}");
}

#[test]
fn the_order_of_the_axes_is_judged_as_it_is_written() {
    // From A0 C0 with the tip at X30 Y-70 Z15: turned by C first the beam passes behind, tilted by A first it swings into the head.
    let rehome = "G28\nG1 Z150 F900\nG1 C0 F1800\nG1 A0 F1200\nG1 X30 Y-70 F6000\nG1 Z15 F900";
    let case = Case::homed_by(rehome);
    let top = || "G1Z320F900".to_owned();
    let as_file = case.with(|line| match line {
        l if l.starts_with("G1Z320") => Vec::new(),
        l if l.starts_with("G1A90") => vec![l.to_owned(), top()],
        l => keep(l),
    });
    assert_eq!(case.proved(&as_file), Ok(()));
    let turned = |letter: &str| case.entry.lines.iter().find(|l| l.starts_with(letter)).unwrap().clone();
    let otherwise = case.with(|line| match line {
        l if l.starts_with("G1Z320") => Vec::new(),
        l if l.starts_with("G1C90") => vec![turned("G1A90")],
        l if l.starts_with("G1A90") => vec![turned("G1C90"), top()],
        l => keep(l),
    });
    let said = case.proved(&otherwise).unwrap_err();
    assert!(said.contains("while the table turns"), "{said}");
}

#[test]
fn a_turn_of_homing_from_a_known_pose_is_judged() {
    let rehome = "G28\nG1 Z150 F900\nG1 C0 F1800\nG1 A0 F1200\nG1 X30 Y-70 F6000\nG1 Z15 F900\nG1 A60 F1200";
    let case = Case::homed_by(rehome);
    let said = case.proved(&case.entry).unwrap_err();
    assert!(said.contains("while the table turns"), "{said}");
}
