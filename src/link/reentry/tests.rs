//! Where a print may go on, and what is said of it, by hand.

use super::*;
use crate::gcode::meaning::Firmware;
use crate::link::journal::Header;
use crate::link::protocol::Protocol;
use crate::link::retreat::{Retreat, Turning};
use crate::link::testing::{retreat, rules};
use crate::motion::replay::Reading;

/// Block 6 is the first that lays: 10 mm; 7 another; 8 pulls, 9 travels, 10 primes; 11 lays, 12 is the fan, 13 lays; layer 2 begins
/// at 14; 15 and 16 lay.
const PART: &str = "G28\nG90\nM83\nG1 A0 F600\nG1 C0 F600\nG1 X0 Y0 Z1 F600\n;TRUNNION slot=3 part=1 A=0 C=0\n;LAYER_CHANGE\nG1 X10 E1\nG1 Y10 E1\n\
                    G1 E-1\nG1 X0 Y0\nG1 E1\nG1 X10 E1\nM106 S255\nG1 Y10 E1\n;LAYER_CHANGE\nG1 Z1.2\nG1 X0 E1\nG1 Y0 E1\nM107\n";

fn program(text: &str) -> Program {
    Program::read(text.as_bytes(), &rules(Protocol::Marlin)).unwrap()
}

fn settings() -> SenderSettings {
    SenderSettings { planner_blocks: 2, ..SenderSettings::new(Protocol::Marlin, retreat()) }
}

fn at(doubtful: Range<u32>, block: u32) -> Reentry {
    Reentry::at(&program(PART), &settings(), &doubtful, block).unwrap()
}

#[test]
fn a_print_may_go_on_where_a_line_or_a_layer_or_the_doubt_begins_or_ends() {
    let program = program(PART);
    assert_eq!(program.len(), 18);
    let choices = |doubtful: Range<u32>| Reentry::choices(&program, &doubtful).unwrap();
    assert_eq!(choices(7..15), [7, 11, 13, 14, 15]);
    // A prime that moves nothing begins no line; where the axes have no place yet nothing can.
    assert_eq!(choices(9..13), [9, 11, 13]);
    assert_eq!(choices(0..14), [6, 11, 13, 14]);
    // Behind the last line as well.
    assert_eq!(choices(14..18), [14, 15, 18]);
    // Without a line among them nothing is missing and nothing is there twice, wherever it goes on.
    assert_eq!([choices(8..11), choices(12..13), choices(14..15), choices(9..9)], [[8], [12], [14], [9]]);
    assert_eq!([choices(8..12), choices(10..12)], [[8, 11, 12], [10, 11, 12]]);
    // A single line in doubt, the first of them or the last.
    assert_eq!(choices(7..8), [7, 8]);
    assert_eq!(Reentry::choices(&program, &(0..4)).unwrap_err(), ReentryError::NoPlace { line: 1 });
    // All axes must have a place, the head's and the table's.
    assert_eq!(choices(5..14), [6, 11, 13, 14]);
    let table_last = self::program("G28\nG90\nM83\nG1 X0 Y0 Z1 F600\nG1 A0\nG1 C0\nG1 X10 E1\nG1 X0 E1\n");
    assert_eq!(Reentry::choices(&table_last, &(5..8)).unwrap(), [6, 8]);
}

#[test]
fn what_is_missing_and_what_is_twice_is_told_in_mm_and_layers() {
    let owed = |doubtful: Range<u32>, block| {
        let entry = at(doubtful, block);
        (entry.missing_mm, entry.twice_mm, entry.words[4].rsplit("; ").next().unwrap().to_owned())
    };
    // Length counts in all directions.
    let steep = program("G28\nG90\nM83\nG1 A0 F600\nG1 C0 F600\nG1 X0 Y0 Z1 F600\nG1 X2 Y3 Z7 E1\n");
    assert!((steep.laid_mm(&(6..7)) - 7.0).abs() < 1e-9);
    let (missing, twice, said) = owed(7..16, 13);
    assert_eq!((missing, twice), (20.0, 20.0));
    assert_eq!(
        said,
        "at most 20.0 mm of lines (50 % of layer 1) can be missing, at most 20.0 mm of lines (25 % of layer 1, 50 % of layer 2) is printed twice"
    );
    // Of block 7's 10 mm and what follows up to block 16: 7, 11, 13 and 15.
    assert_eq!(
        owed(7..16, 7).2,
        "nothing can be missing, at most 40.0 mm of lines (75 % of layer 1, 50 % of layer 2) is printed twice"
    );
    assert_eq!(
        owed(7..16, 16).2,
        "at most 40.0 mm of lines (75 % of layer 1, 50 % of layer 2) can be missing, nothing is printed twice"
    );
    // Of many layers the first and the last, of a share its next whole percent.
    let layers: String =
        (1..=5).map(|i| format!(";LAYER_CHANGE\nG1 Z{i}\nG1 X90 E1\nG1 X0 E1\nG1 Y{} E1\n", i % 2)).collect();
    let program = program(&format!("G28\nG90\nM83\nG1 A0 F600\nG1 C0 F600\nG1 X0 Y0 Z1 F600\n{layers}"));
    assert_eq!(super::layers(&program, &(8..9)), " (50 % of layer 1)");
    assert_eq!(super::layers(&program, &(9..10)), " (1 % of layer 1)");
    assert_eq!(super::layers(&program, &(8..14)), " (51 % of layer 1, 100 % of layer 2)");
    assert_eq!(super::layers(&program, &(9..18)), " (1 % of layer 1, 100 % of layer 2, 100 % of layer 3)");
    assert_eq!(super::layers(&program, &(9..20)), " (of layers 1 to 4)");
}

#[test]
fn where_it_goes_on_is_told_by_what_begins_there() {
    let place = |block| at(6..18, block).words[4].split("; ").next().unwrap().to_owned();
    assert_eq!(place(6), "continue at line 9, the start of slot 3");
    assert_eq!(place(13), "continue at line 16, within layer 1");
    assert_eq!(place(14), "continue at line 18, the start of layer 2");
    assert_eq!(at(4..6, 5).words[4].split("; ").next(), Some("continue at line 6, before the first layer"));
    let known = |doubtful: Range<u32>| at(doubtful.clone(), doubtful.start).words[0].clone();
    assert_eq!(known(7..15), "the file is known to be executed up to line 9; lines 10 to 18 are uncertain");
    let hint = "or inspect the part and pass --from LINE, the first of lines 10 to 19 that is missing from it; then nothing is missing or doubled";
    assert_eq!(at(7..15, 15).words.get(5).map(String::as_str), Some(hint));
    // Where nothing is missing and nothing is twice nobody need look.
    assert_eq!(at(8..10, 9).words.len(), 5);
    assert_eq!(known(9..9), "the file is executed up to line 11, and no further");
}

#[test]
fn without_a_proof_the_last_layer_that_began_is_taken_or_the_first_line_in_doubt() {
    let program = program(PART);
    let taken = |doubtful: Range<u32>| {
        let choices = Reentry::choices(&program, &doubtful).unwrap();
        Reentry::unproved(&program, &doubtful, &choices)
    };
    assert_eq!([taken(7..16), taken(7..14), taken(14..17), taken(7..13), taken(0..16)], [14, 14, 14, 7, 14]);
}

#[test]
fn a_line_that_somebody_gives_must_be_one_in_doubt() {
    let (program, settings) = (program(PART), settings());
    let text = Header::default().to_text() + "run 1 0\nack 12 12\nsent 15\n";
    let standing = JournalSummary::parse(&text).unwrap();
    let doubt = |from| Reentry::doubt(&program, &settings, &standing, true, from);
    assert_eq!(doubt(None), Ok(10..15));
    // Block 10 is line 13 of the file, 15 is line 19.
    assert_eq!([doubt(Some(13)), doubt(Some(17)), doubt(Some(19))], [Ok(10..10), Ok(14..14), Ok(15..15)]);
    for line in [12, 20] {
        assert_eq!(doubt(Some(line)), Err(ReentryError::NotInDoubt { line, first: 13, last: 19 }));
    }
    let nowhere = SenderSettings { retreat: crate::link::Retreat { home: Vec::new(), ..retreat() }, ..settings };
    assert_eq!(Reentry::doubt(&program, &nowhere, &standing, true, None), Err(ReentryError::NoHoming));
}

#[test]
fn a_machine_that_counts_nothing_and_said_nothing_needs_somebody_who_has_looked() {
    let text = "G28\nG90\nG1 X0 Y0 Z1 A0 C0 F600\n".to_owned() + &"G1 X10\nG1 X0\n".repeat(40);
    let program = Program::read(text.as_bytes(), &rules(Protocol::Grbl)).unwrap();
    let settings = SenderSettings { planner_blocks: 1, ..SenderSettings::new(Protocol::Grbl, retreat()) };
    let standing = JournalSummary::parse(&(Header::default().to_text() + "run 1 0\nack 5 5\n")).unwrap();
    let doubt = |from| Reentry::doubt(&program, &settings, &standing, true, from);
    assert_eq!(doubt(None), Err(ReentryError::Uncounted { protocol: "grbl", line: 5 }));
    // It may have come to the end of the file.
    assert_eq!([doubt(Some(7)), doubt(Some(80))], [Ok(6..6), Ok(79..79)]);
}

/// A brake is let go and put on again on the way back into the print, and named motors turn by commands.
#[test]
fn the_machines_own_lines_stand_around_the_turn_back() {
    let text = "G28\nG90\nG1 C30 F600\nG1 A20 F600\nG1 X0 Y0 Z1 F600\nG1 X10 E1\nG1 X0 E1\n";
    let program = Program::read(text.as_bytes(), &rules(Protocol::Marlin)).unwrap();
    let lines = |steppers| {
        let [before, after] = [["M400", "M42P5S255"], ["M400", "M42P5S0"]].map(|own| own.map(str::to_owned).to_vec());
        let turning = Turning { before, after, steppers };
        let settings = SenderSettings::new(Protocol::Marlin, Retreat { turning, ..retreat() });
        Reentry::at(&program, &settings, &(5..6), 5).unwrap().lines
    };
    let letters = lines(None);
    let own = letters.iter().position(|line| line == "M42P5S255").expect("the brake is let go");
    assert_eq!(
        letters[own - 1..own + 5],
        ["M400", "M42P5S255", "G1C30F3437", "G1A20F3437", "M400", "M42P5S0"],
        "{letters:?}"
    );
    let named = lines(Some(["tilt".to_owned(), "rot".to_owned()]));
    let turns: Vec<&String> = named.iter().filter(|line| line.starts_with("MANUAL_STEPPER")).collect();
    assert_eq!(
        turns,
        ["MANUAL_STEPPER STEPPER=rot SPEED=57.29 MOVE=30", "MANUAL_STEPPER STEPPER=tilt SPEED=57.29 MOVE=20"]
    );
}

/// A filament axis counts from anywhere behind a reset: its first absolute word pushed all that the print had taken so far.
#[test]
fn a_spare_axis_counts_again_what_it_has_pushed() {
    let text = "G28\nG90\nG92 U0\nG1 A0 F600\nG1 C0 F600\nG1 X0 Y0 Z1 F600\nG1 X10 U7.25\nG1 X0 U8.5\nG1 Y9 U9\n";
    let mut rules = rules(Protocol::Grbl);
    rules.setting.reading = Reading { firmware: Firmware::Grbl, extruder: b'U', ..rules.setting.reading };
    let program = Program::read(text.as_bytes(), &rules).unwrap();
    let settings = SenderSettings {
        retreat: Retreat { extruder: b'U', home: vec!["$H".to_owned()], ..retreat() },
        ..SenderSettings::new(Protocol::Grbl, retreat())
    };
    let lines = Reentry::at(&program, &settings, &(8..9), 8).unwrap().lines;
    let behind = &lines[lines.iter().position(|l| l == "G1U2F2100").unwrap()..];
    assert_eq!(behind, ["G1U2F2100", "G90", "G92U8.5", "G1F600"], "{lines:?}");
}
