//! Programs as they are sent, by hand.

use super::*;
use crate::link::testing::{rules, setting};
use crate::trace::{self, FeedCount, Rates};

fn read(text: &[u8]) -> Result<Program, ProgramError> {
    Program::read(text, &rules(Protocol::Marlin))
}

#[test]
fn blocks_know_their_lines_times_and_marks() {
    let text = b"; hello\nG28\n;TRUNNION slot=3 part=1 A=70 C=90\n;LAYER_CHANGE\nG1 X0 F600\n\nG1 X10.0 ; there\n";
    let program = read(text).unwrap();
    let blocks: Vec<_> = (0..program.len()).map(|i| String::from_utf8_lossy(program.block(i)).into_owned()).collect();
    assert_eq!(blocks, ["G28", "G1X0F600", "G1X10"]);
    assert_eq!((0..3).map(|i| program.file_line(i)).collect::<Vec<_>>(), [2, 5, 7]);
    assert!((program.seconds(2) - 1.0).abs() < 1e-6);
    let slot = Boundary { block: 1, kind: BoundaryKind::Slot(3) };
    assert_eq!(program.boundaries, [slot, Boundary { block: 1, kind: BoundaryKind::Layer }]);
}

#[test]
fn a_feed_next_to_nothing_gives_a_time_that_can_be_waited_for() {
    let with = |feed: &str| read(format!("G28\nG1 X0\nG1 X100 F{feed}\n").as_bytes()).unwrap();
    for feed in ["0.001", "0.0011"] {
        let program = with(feed);
        assert!((program.seconds(2) - 1e6).abs() < 1.0, "F{feed}: {} s", program.seconds(2));
        assert_eq!(program.unknown, None, "F{feed}");
    }
    for feed in ["0.0009", "0.0000000000000000001", "0.00000000000000000000000000000000000000000000000001"] {
        let (line, why) = with(feed).unknown.unwrap();
        assert!(line == 3 && why.contains("beyond any machine"), "F{feed}: {why}");
    }
}

#[test]
fn what_breaks_the_counters_is_refused_with_its_line() {
    for text in ["M110 N5", "M112", "M108", "M410", "M23 x.g", "M28 x.g", "M118 ok", "M118 E1 Resend: 1", "M999"] {
        let error = read(format!("G28\n{text}\n").as_bytes()).unwrap_err();
        assert!(matches!(error, ProgramError::Forbidden { line: 2, .. }), "{text}: {error}");
    }
    let error = read(b"G28\nSET_X M110\n").unwrap_err();
    assert!(matches!(error, ProgramError::Forbidden { line: 2, .. }), "{error}");
}

#[test]
fn a_message_that_holds_m110_is_rewritten_and_odd_bytes_go() {
    let program = read(b"M117 see M110 N7 and M110\nM117 caf\xe9\x00\n").unwrap();
    assert_eq!(program.block(0), b"M117 see m110 N7 and m110");
    assert_eq!(program.block(1), b"M117 caf??");
    assert!(matches!(read(b"G1 X\xff5\n"), Err(ProgramError::Damaged { line: 1, .. })));
}

#[test]
fn too_long_empty_and_foreign_lines_are_refused() {
    let long = format!("M117 {}\n", "x".repeat(90));
    assert!(matches!(read(long.as_bytes()), Err(ProgramError::TooLong { line: 1, bytes: 111, allowed: 96, .. })));
    assert_eq!(read(b"; nothing\n").unwrap_err(), ProgramError::Empty);
    let grbl = |text: &str| Program::read(text.as_bytes(), &rules(Protocol::Grbl));
    for text in ["M104 S200", "G1 X1 E2", "M117 what?"] {
        assert!(matches!(grbl(text), Err(ProgramError::Forbidden { line: 1, .. })), "{text}");
    }
    assert!(grbl("G1 X1 F100\nM2").is_ok());
}

/// Words that the clocks of a file once disagreed on: F over all axes, free rapids, arcs by radius and of a whole turn.
#[test]
fn the_time_of_a_program_is_the_time_that_its_trace_has() {
    let with = |feed, rapid_is_free| Rates { feed, rapid_is_free, ..setting().rates };
    let start = "G28\nG1 X0 Y0 Z0 A0 C0 F6000\n";
    for (rates, text, by_hand) in [
        (with(FeedCount::Linear, false), "G1 X3 A4 F60\n", 3.0),
        (with(FeedCount::AllAxes, false), "G1 X3 A4 F60\n", 5.0),
        (with(FeedCount::LargestAxis, false), "G1 A30 C40 F600\n", 4.0),
        (with(FeedCount::Linear, false), "G0 X100 F600\n", 10.0),
        (with(FeedCount::Linear, true), "G0 X100 F600\n", 0.5),
        (with(FeedCount::Linear, false), "G3 X-10 Y0 R5 F60\n", 5.0 * std::f64::consts::PI),
        (with(FeedCount::Linear, false), "G2 X0 Y0 I5 J0 F600\n", std::f64::consts::PI),
        (with(FeedCount::Linear, false), "G4 P2500\nG1 E3 F60\n", 5.5),
        (with(FeedCount::Linear, false), "G1 A30 F60000\n", 1.5),
    ] {
        let setting = TraceSetting { rates, ..setting() };
        let seconds = |text: &str| {
            let rules = ProgramRules { setting: setting.clone(), ..rules(Protocol::Marlin) };
            let program = Program::read(text.as_bytes(), &rules).unwrap();
            let traced = trace::read(text.as_bytes(), &setting).seconds;
            let sent = program.seconds_print();
            assert!((sent - traced).abs() < 1e-4 * sent.max(1.0), "{text}: {sent} s sent, {traced} s traced");
            sent
        };
        let took = seconds(&format!("{start}{text}")) - seconds(start);
        assert!((took - by_hand).abs() < 2e-3 * by_hand, "{text}: {took} s, by hand {by_hand}");
    }
}

#[test]
fn a_layer_is_a_comment_of_its_own_here_as_in_a_trace() {
    let text = "G28\nM117 layer ;LAYER:1\n;LAYER:2\nG1 X0 F60\n";
    let program = read(text.as_bytes()).unwrap();
    let traced = trace::read(text.as_bytes(), &setting());
    let layers = traced.events.iter().filter(|e| e.what == trace::What::Layer).count();
    assert_eq!((program.boundaries.len(), layers), (1, 1));
}
