//! Lines and what they do, by hand.

use super::*;
use crate::geom::SplitMix64;

fn run(text: &str) -> (Controller, Vec<Step>) {
    let mut controller = Controller::new(Reading::sliced());
    let mut line = ParsedLine::default();
    let steps = text
        .lines()
        .map(|l| {
            line.read(l.as_bytes()).unwrap();
            controller.step(&line).unwrap()
        })
        .collect();
    (controller, steps)
}

fn moves(text: &str) -> Vec<Move> {
    run(text).1.into_iter().filter_map(|s| if let Step::Move(m) = s { Some(m) } else { None }).collect()
}

/// How often a circle with this word goes round.
fn turned(firmware: Firmware, word: &str) -> Result<u32, ReplayError> {
    let mut controller = Controller::new(Reading::sliced_for(firmware));
    let mut line = ParsedLine::default();
    line.read(b"G1 X0 Y0").unwrap();
    controller.step(&line)?;
    line.read(format!("G2 X0 Y0 I5 {word}").as_bytes()).unwrap();
    match controller.step(&line)? {
        Step::Move(Move { arc: Some(arc), .. }) => Ok(arc.turns),
        other => panic!("{other:?}"),
    }
}

fn refused(text: &str) -> ReplayError {
    let mut controller = Controller::new(Reading::sliced());
    let mut line = ParsedLine::default();
    line.read(text.as_bytes()).unwrap();
    controller.step(&line).unwrap_err()
}

#[test]
fn a_single_word_keeps_the_other_axes() {
    let got = moves("G1 X10 Y20 Z0.2 F600\nX12\nG0 Y3");
    assert_eq!(got[1].to.tip().unwrap(), Vec3::new(12.0, 20.0, 0.2));
    assert_eq!(got[2].to.tip().unwrap(), Vec3::new(12.0, 3.0, 0.2));
    assert_eq!((got[2].feed, got[2].rapid, got[2].written), (Some(600.0), true, 0b010));
}

#[test]
fn the_extruder_counts_absolute_relative_and_from_a_new_zero() {
    let got = moves("M82\nG92 E0\nG1 X1 E2\nG1 X2 E5\nM83\nG1 X3 E1.5\nM82\nG92 E10\nG1 E11\nG91\nG1 E-1");
    let e: Vec<f64> = got.iter().map(|m| m.e).collect();
    assert_eq!(e, vec![2.0, 3.0, 1.5, 1.0, -1.0]);
}

/// Whoever follows a program sums its times and places: none of them may be a number that is none.
#[test]
fn numbers_of_no_machine_are_refused() {
    let far = "9".repeat(45);
    for line in ["G1 X1 F", "G0 F", "G92 E", "G1 E", "G1 X", "G2 X1 Y1 I", "G2 X1 Y1 I1 J-", "G3 X1 Y1 R"] {
        assert!(matches!(refused(&format!("{line}{far}")), ReplayError::Absurd(..)), "{line}");
    }
    assert_eq!(refused("G1 X1 F.0000001"), ReplayError::Absurd('F', 1e-7));
    assert_eq!(refused("G1 X1 F-600"), ReplayError::Absurd('F', -600.0));
    assert_eq!(refused("G4 S1000001"), ReplayError::Endless(1_000_001.0));
    for fine in ["G1 X1 F0", "G1 X1 F.001", "G4 P0", "G1 X1 F400000", "G4 S1000000", "G92 E-99999"] {
        run(fine);
    }
}

/// Each turn is followed chord by chord: one line must not become millions of them.
#[test]
fn an_arc_goes_round_a_few_times() {
    for (word, turns) in [("P11", 11.0), ("P4294967295", 4_294_967_295.0), ("P-1", -1.0), ("P1.5", 1.5)] {
        assert_eq!(turned(Firmware::LinuxCnc, word), Err(ReplayError::ArcTurns(turns)));
    }
    assert_eq!(["P10", "P0", ""].map(|word| turned(Firmware::LinuxCnc, word)), [Ok(10), Ok(1), Ok(1)]);
    for (_, firmware) in Firmware::NAMES.into_iter().filter(|(_, firmware)| *firmware != Firmware::LinuxCnc) {
        assert_eq!(turned(firmware, "P2"), Err(ReplayError::StrayWord('P')));
        assert_eq!(turned(firmware, ""), Ok(1));
    }
}

#[test]
fn relative_moves_from_an_unknown_place_stay_unknown() {
    let (controller, _) = run("G28\nG91\nG1 Z5\nG90\nG1 X1 Y1");
    assert_eq!(controller.at.linear, [Some(1.0), Some(1.0), None]);
}

#[test]
fn refuses_what_moves_the_part_unseen() {
    assert_eq!(refused("G20"), ReplayError::Inches);
    assert_eq!(refused("G18"), ReplayError::Plane(18));
    assert_eq!(refused("G1 X1 A5"), ReplayError::RotaryWord('A'));
    assert_eq!(refused("G92 X0"), ReplayError::ShiftedAxes);
    assert_eq!(refused("G92"), ReplayError::ShiftedAxes);
    assert_eq!(refused("G1 X1 R2"), ReplayError::StrayWord('R'));
    assert_eq!(refused("G1 H2 Z5"), ReplayError::StrayWord('H'));
    assert_eq!(refused("G90 G1 X5"), ReplayError::SeveralCommands(Command::g(90), Command::g(1)));
    assert_eq!(refused("G93"), ReplayError::UnknownMode(Command::g(93)));
    assert_eq!(refused("G1 X"), ReplayError::BareWord('X'));
}

#[test]
fn a_table_without_end_stops_is_set_level_once_before_it_moves() {
    let axis = |letter, direction, zero| AxisRange {
        letter,
        direction,
        zero: Angle::from_deg(zero),
        range: None,
        max_rate: 1.0,
        absent: false,
    };
    let reading = Reading { rotary: Some((axis(b'U', 1.0, 0.0), axis(b'V', -1.0, 30.0))), ..Reading::sliced() };
    let after = |text: &str| {
        let (mut controller, mut line) = (Controller::new(reading.clone()), ParsedLine::default());
        let steps: Result<Vec<Step>, ReplayError> = text
            .lines()
            .map(|l| {
                line.read(l.as_bytes()).unwrap();
                controller.step(&line)
            })
            .collect();
        steps.map(|steps| (controller.at, steps))
    };
    let (at, steps) = after("G1 X5 Y6 Z7\nG92 U0 V30").unwrap();
    assert_eq!(at.pose(), Some(Pose::LEVEL));
    assert_eq!(at.linear, [Some(5.0), Some(6.0), Some(7.0)]);
    // Not by the way: only the profile's own code may say so.
    assert_eq!(steps[1], Step::Effect(Effect::Hazard(Hazard::Shift)));
    for text in ["G92 U0 V0", "G92 U0", "G92 V30", "G92 U0 V30 X0", "G1 U5\nG92 U0 V30", "G92 U0 V30\nG92 U0 V30"] {
        assert_eq!(after(text).unwrap_err(), ReplayError::ShiftedAxes, "{text}");
    }
}

#[test]
fn a_named_motor_turns_the_table_and_others_leave_all_as_it_is() {
    let axis = |letter, direction| AxisRange {
        letter,
        direction,
        zero: Angle::ZERO,
        range: None,
        max_rate: 1.0,
        absent: false,
    };
    let steppers = Some(["tilt".to_owned(), "rot".to_owned()]);
    let rotary = Some((axis(b'A', 1.0), axis(b'C', -1.0)));
    let reading = Reading { rotary, steppers, ..Reading::sliced_for(Firmware::Klipper) };
    let after = |text: &str| {
        let (mut controller, mut line) = (Controller::new(reading.clone()), ParsedLine::default());
        let mut last = Ok(Step::Nothing);
        for text in text.lines() {
            line.read(text.as_bytes()).unwrap();
            last = controller.step(&line);
        }
        last.map(|step| (controller.at, controller.feed(), step))
    };
    let begin =
        "G1 X1 Y2 Z3 F600\nMANUAL_STEPPER STEPPER=tilt SET_POSITION=0\nMANUAL_STEPPER STEPPER=rot SET_POSITION=0\n";
    let stepper = |words: &str| after(&format!("{begin}MANUAL_STEPPER {words}"));
    let (at, feed, step) = stepper("STEPPER=rot SPEED=20 MOVE=90").unwrap();
    assert_eq!(at.pose(), Some(Pose::from_deg(0.0, -90.0)));
    assert_eq!((at.linear, feed), ([Some(1.0), Some(2.0), Some(3.0)], Some(600.0)));
    let Step::Move(made) = step else { panic!("{step:?}") };
    assert!(made.feed == Some(1200.0) && made.rotary_written && made.e == 0.0 && made.written == 0);
    // G91 is not for it.
    let relative = after(&format!(
        "{begin}G91\nmanual_stepper stepper=tilt move=5 speed=1\nmanual_stepper stepper=tilt move=7 speed=1"
    ));
    assert_eq!(relative.unwrap().0.pose(), Some(Pose::from_deg(7.0, 0.0)));
    for words in ["STEPPER=brake MOVE=5 SPEED=1", "STEPPER=brake ENABLE=0"] {
        assert_eq!(stepper(words).unwrap().0.pose(), Some(Pose::LEVEL), "{words}");
        assert_eq!(stepper(words).unwrap().0.linear, at.linear, "{words}");
    }
    for words in [
        "MOVE=5",
        "MOVE=5 SPEED=0",
        "MOVE=5 SPEED=1 SYNC=0",
        "MOVE=5 SPEED=1 STOP_ON_ENDSTOP=1",
        "ENABLE=0",
        "GCODE_AXIS=A",
    ] {
        let (at, _, _) = stepper(&format!("STEPPER=tilt {words}")).unwrap();
        assert_eq!((at.tilt, at.rotation), (None, Some(Angle::ZERO)), "{words}");
    }
    assert_eq!(stepper("STEPPER=tilt MOVE=x SPEED=1").unwrap().0.pose(), None);
    assert_eq!(stepper("STEPPER=tilt SET_POSITION=5").unwrap_err(), ReplayError::ShiftedAxes);
    assert_eq!(stepper("STEPPER=tilt SPEED=1 MOVE=1e12").unwrap_err(), ReplayError::Absurd('A', 1e12));
}

#[test]
fn what_is_no_move_is_handed_on_and_the_place_is_forgotten_where_it_may_move() {
    let (controller, steps) = run("G1 X1 Y1 Z1\nG10\nM106\nM206 Z5");
    assert_eq!(steps[1], Step::Effect(Effect::Retract(true)));
    assert_eq!(steps[3], Step::Effect(Effect::Hazard(Hazard::Shift)));
    assert_eq!(controller.at.linear, [None; 3]);
    assert_eq!(run("G1 X1 Y1 Z1\nM106\nM204 P5").0.at.linear, [Some(1.0); 3]);
    assert_eq!(run("G5 X1").1, vec![Step::Effect(Effect::Hazard(Hazard::Unknown))]);
}

#[test]
fn arcs_flatten_onto_their_circle() {
    let arc = Arc { to_centre: [0.0, -5.0], clockwise: true, by_radius: None, turns: 1 };
    let points = flatten(Vec3::new(0.0, 5.0, 0.0), Vec3::new(5.0, 0.0, 1.0), &arc, 0.01);
    assert!(points.len() > 3);
    for p in &points {
        assert!((p.x.hypot(p.y) - 5.0).abs() < 1e-9 && p.x >= -1e-9 && p.y >= -1e-9, "{p:?}");
    }
    let full = Arc { to_centre: [0.5, 0.5], clockwise: false, by_radius: None, turns: 1 };
    let start = Vec3::new(1.0, 1.0, 0.0);
    let box_of = crate::geom::Bounds::of(flatten(start, start, &full, 0.001));
    assert!((box_of.max.x - (1.5 + 0.5f64.hypot(0.5))).abs() < 0.01, "{box_of:?}");
}

#[test]
fn an_arc_by_radius_takes_the_minor_side() {
    let arc = Arc { to_centre: [0.0; 2], clockwise: false, by_radius: Some(5.0), turns: 1 };
    let points = flatten(Vec3::new(5.0, 0.0, 0.0), Vec3::new(0.0, 5.0, 0.0), &arc, 0.01);
    for p in &points {
        assert!((p.x.hypot(p.y) - 5.0).abs() < 1e-9, "{p:?}");
    }
}

#[test]
fn an_arc_beyond_all_reach_is_refused_before_it_is_cut_up() {
    let go = |reach_mm: f64, text: &str| {
        let mut controller = Controller::new(Reading { reach_mm, ..Reading::sliced() });
        let mut last = Ok(Step::Nothing);
        for line in text.lines() {
            let mut parsed = ParsedLine::default();
            parsed.read(line.as_bytes()).unwrap();
            last = controller.step(&parsed);
        }
        (last, controller.at.linear)
    };
    let beyond = |text: &str| match go(100.0, text).0 {
        Err(ReplayError::ArcBeyond { farthest, reach_mm: 100.0 }) => Some(farthest),
        Ok(Step::Move(_)) => None,
        other => panic!("{text}: {other:?}"),
    };
    // Half a circle about (10, 0) to the right, and one that is a millimetre larger; whole ones; nearly straight ones whose centre is far
    // away and which are not, and the other way round. By hand.
    for (text, farthest) in [
        ("G1 X10 Y90 Z1\nG2 X10 Y-90 I0 J-90", None),
        ("G1 X10 Y90 Z1\nG2 X10 Y-92 I0 J-91", Some(101.0)),
        ("G1 X10 Y90 Z1\nG3 X10 Y-92 I0 J-91", None),
        ("G1 X0 Y0 Z1\nG2 I49", None),
        ("G1 X0 Y0 Z1\nG2 I51", Some(102.0)),
        ("G1 X0 Y0 Z1\nG2 I100000 J0", Some(200_000.0)),
        ("G1 X0 Y0 Z1\nG3 X0 Y10 R90000", None),
        ("G1 X0 Y0 Z1\nG3 X0 Y10 R-90000", Some(180_000.0)),
    ] {
        match (beyond(text), farthest) {
            (None, None) => {}
            (Some(found), Some(wanted)) if (found - wanted).abs() < 1e-3 => {}
            other => panic!("{text:?}: {other:?}"),
        }
    }
    // What follows goes on from its end.
    assert_eq!(go(100.0, "G1 X0 Y0 Z1\nG2 X3 Y4 I5000").1, [Some(3.0), Some(4.0), Some(1.0)]);
}

/// How far an arc goes, by its chords: never less, and no more than one chord beyond.
#[test]
fn how_far_an_arc_goes_is_what_its_chords_say() {
    let mut numbers = SplitMix64::seeded(8);
    for _ in 0..4000 {
        let mut at = || (numbers.unit() - 0.5) * 60.0;
        let (from, to) = (Vec3::new(at(), at(), 0.0), Vec3::new(at(), at(), 1.0));
        let by_radius = if at() > 0.0 { Some((from - to).norm() * (0.6 + at().abs() / 30.0)) } else { None };
        let arc = Arc { to_centre: [at(), at()], clockwise: at() > 0.0, by_radius, turns: 1 };
        let chords = flatten(from, to, &arc, 1e-4).into_iter().chain([from]);
        let wanted = chords.map(|p| p.x.abs().max(p.y.abs())).fold(0.0, f64::max);
        let farthest = arcs::ArcTurn::of(from, to, &arc).farthest();
        // Where an arc ends on its circle is beyond its last chord but one, which is no longer than this.
        let chord = 0.03 * (to - from).norm().max(200.0).sqrt();
        assert!(
            farthest >= wanted - 2e-4 && farthest <= wanted + chord,
            "{from:?} {to:?} {arc:?}: {farthest} for {wanted}"
        );
    }
}
