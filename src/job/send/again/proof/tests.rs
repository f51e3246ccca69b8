//! What stands before `verify`: line for line, and which of its findings count.

use super::*;
use crate::job::{self, Silent, World, printer};
use crate::link::Program;

const FILE: &str = ";TRUNNION slot=0 part=0 A=0 C=0\nG28\nG90\nM83\nG1 A0 F600\nG1 C0 F600\n;LAYER_CHANGE\n;Z:1\n;HEIGHT:0.2\n;TYPE:Perimeter\n\
                    ;WIDTH:0.4\nG1 X0 Y0 Z1 F600\nG1 X5 E1\n;TYPE:Infill\nG1 Y5 E1\n;note\nG1 X0 E1\n;LAYER_CHANGE\n;Z:1.2\nG1 Z1.2\n\
                    G1 X5 E1\n;TYPE:Perimeter\nG1 Y0 E1\n";

/// Of our own lines these are replayed.
const OWN: [&str; 15] = [
    "G90",
    "G28",
    "G1Z320F900",
    "G90",
    "G1Z300F900",
    "G90",
    "G1C90F1800",
    "G1A90F1200",
    "G1X0Y5F6000",
    "G1Z1F900",
    "M83",
    "G91",
    "G90",
    "M83",
    "G92E0",
];

fn profile() -> Profile {
    job::load_profile(&"generic-ac".into(), &World::here(&Silent)).unwrap().profile
}

/// A re-entry at line `at` of the file: heat, fan and filament between what moves.
fn entry(at: u32, home: &[&str]) -> Reentry {
    let profile = profile();
    let program = Program::read(FILE.as_bytes(), &printer::rules(&profile).unwrap()).unwrap();
    let block = program.block_on(at);
    let mut entry = Reentry::at(&program, &printer::settings(&profile).unwrap(), &(block..block), block).unwrap();
    let behind =
        ["G90", "G1Z300F900", "M106S255", "M109S200", "G90", "G1C90F1800", "G1A90F1200", "G1X0Y5F6000", "G1Z1F900"];
    let filament = ["M83", "G91", "G1E2F2100", "G90", "M83", "G92E0"];
    let lines = [&["M140S60", "G90"], home, &behind, &filament].concat();
    entry.home = 2..2 + home.len();
    entry.lines = lines.into_iter().map(str::to_owned).collect();
    entry
}

fn path(printed: u32, at: u32, until: u32) -> ReentryPath {
    ReentryPath::of(FILE.as_bytes(), printed, &entry(at, &["G28", "G1Z320F900"]), until, &profile())
}

fn lines(numbers: impl IntoIterator<Item = usize>) -> Vec<&'static str> {
    let file: Vec<&str> = FILE.lines().collect();
    numbers.into_iter().map(|number| file[number - 1]).collect()
}

#[track_caller]
fn assert_says(path: &ReentryPath, printed: &[&str], stands: &[&str], again: &[&str]) {
    let said = String::from_utf8(path.text.clone()).unwrap();
    let wanted = [printed, &["M84"], &OWN, stands, again].concat();
    assert_eq!(said.lines().collect::<Vec<_>>(), wanted);
    let printed = printed.len() as u32;
    // M84, G90, G28 and a first move, with which nothing is known of the table any more.
    assert_eq!((path.printed, path.posed, path.own), (printed, printed + 4, printed + 16 + stands.len() as u32));
}

#[test]
fn what_is_left_out_is_not_there_and_its_remarks_are() {
    assert_says(&path(13, 17, 21), &lines((1..=14).chain([16])), &[], &lines(17..=21));
    // To the line, and no line is both printed and behind.
    assert_says(&path(16, 17, 17), &lines(1..=16), &[], &lines([17]));
}

#[test]
fn what_is_printed_again_is_there_already_and_said_anew_what_holds_for_it() {
    let holds = lines([1, 8, 9, 11, 14]);
    assert_says(&path(20, 15, 21), &lines(1..=20), &holds, &lines(15..=21));
    assert_says(&path(15, 15, 15), &lines(1..=15), &holds, &lines([15]));
    // What may be printed already is there though nobody looks at what comes behind it.
    assert_says(&path(21, 15, 17), &lines(1..=21), &holds, &lines(15..=17));
    // From the first line that can be printed again.
    assert_says(&path(13, 13, 13), &lines(1..=13), &lines([1, 8, 9, 10, 11]), &lines([13]));
}

#[test]
fn a_turn_counts_from_the_line_on_behind_which_the_pose_is_known() {
    let posed = |home: &[&str]| {
        let path = ReentryPath::of(FILE.as_bytes(), 13, &entry(13, home), 13, &profile());
        String::from_utf8(path.text).unwrap().lines().nth(path.posed as usize - 1).unwrap().to_owned()
    };
    assert_eq!(posed(&["G28"]), "G1Z300F900");
    assert_eq!(posed(&["G28", "G1 Z320 F900"]), "G1 Z320 F900");
    assert_eq!(posed(&["G28", "G1 Z320 F900", "G1 C90 F1800", "G1 A90 F1200", "G1 A60 F1200"]), "G1 A90 F1200");
}

#[test]
fn a_finding_counts_where_it_speaks_of_the_re_entry() {
    let path = ReentryPath { text: Vec::new(), printed: 10, posed: 14, own: 30 };
    let first = |counts: &dyn Fn(&Finding) -> bool, rule: Rule| {
        let finding =
            |line| Finding { rule, line, slot: None, part: None, measured: 0.0, allowed: 0.0, text: String::new() };
        (1..50).find(|line| counts(&finding(*line)))
    };
    let strikes = |rule| first(&|finding| path.counts(finding), rule);
    let [head, limit, turn, unknown] =
        [Rule::HeadCollision, Rule::AxisLimit, Rule::TurnCollision, Rule::UnknownPosition].map(strikes);
    assert_eq!([head, limit, turn, unknown], [Some(11), Some(11), Some(15), Some(31)]);
    let hangs = |rule| first(&|finding| path.hangs(finding), rule);
    assert_eq!((hangs(Rule::InAir), hangs(Rule::HeadCollision), strikes(Rule::InAir)), (Some(31), None, None));
    // What the replay finds of the file's order and heat is none of its business.
    let others =
        [Rule::Sequence, Rule::Filament, Rule::Retract, Rule::Heat, Rule::Complete, Rule::LayerHeight, Rule::Pose];
    assert!(others.into_iter().all(|rule| strikes(rule).is_none() && hangs(rule).is_none()));
}
