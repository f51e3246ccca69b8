//! What a program does, by hand.

use super::{FeedCount, Rates, TraceReader, TraceSetting, What, Zone, read, totals};
use crate::gcode::marks::{Mark, Role};
use crate::gcode::meaning::{Effect, Hazard};
use crate::geom::{Angle, SplitMix64};
use crate::motion::lookahead::AT_ONCE;
use crate::motion::replay::Reading;
use crate::motion::{Accelerations, AxisRange};

fn setting() -> TraceSetting {
    let axes = [('A', 20.0), ('C', 30.0)];
    let rates = Rates { feed: FeedCount::Linear, max_feed: 12_000.0, rapid_is_free: false, axes };
    TraceSetting { reading: Reading::sliced(), rates, accelerations: AT_ONCE, swivel: None }
}

fn trace(text: &str) -> super::Trace {
    read(text.as_bytes(), &setting())
}

#[test]
fn moves_have_their_line_place_filament_and_time() {
    let trace = trace("M83\nG1 X10 Y0 Z.2 F600\n\nG1 X20 E.5\nG1 E-1 F1800\n");
    assert_eq!((trace.len(), trace.lines), (3, 5));
    let [first, second, third] = [0, 1, 2].map(|i| trace.at(i));
    assert_eq!((first.line, first.from, first.to), (2, [None; 3], [Some(10.0), Some(0.0), Some(0.2)]));
    assert!(!first.prints() && first.ends().is_none() && second.prints() && !third.prints() && !third.travels());
    assert!((second.seconds - 1.0).abs() < 1e-6 && (second.e - 0.5).abs() < 1e-6, "{second:?}");
    assert!((trace.seconds - 1.0 - 1.0 / 30.0).abs() < 1e-3, "{}", trace.seconds);
    assert!(trace.bytes() <= 48 * trace.len() + 2 * size_of::<super::State>(), "{} bytes", trace.bytes());
}

#[test]
fn prints_that_take_turns_find_what_their_slicer_said_last() {
    let trace = trace(
        "M83\nG1 X0 Y0 Z0\n;TRUNNION slot=0 part=0,1 A=0 C=0\n;TRUNNION print=0 part=0\n;TYPE:External perimeter\n;WIDTH:0.5\n;HEIGHT:0.2\n\
         G1 X1 E1\n;TRUNNION print=1 part=1\nG1 X2 E1\n;TYPE:Solid infill\nG1 X3 E1\n;TRUNNION print=0 part=0\nG1 X4 E1\n;TRUNNION end\nG1 X5\n",
    );
    let said: Vec<_> = trace.moves().map(|m| (m.role, m.width, trace.state(&m).print)).collect();
    let wall = (Role::OuterWall, Some(0.5), Some(0));
    let none = |print| (Role::Unknown, None, print);
    assert_eq!(said[1..], [wall, none(Some(1)), (Role::Solid, None, Some(1)), wall, none(None)]);
    assert_eq!(trace.state(&trace.at(5)).zone, Zone::End);
}

#[test]
fn the_nozzle_is_as_hot_as_has_been_waited_for() {
    let at = |text: &str| {
        let trace = trace(&format!("{text}\nG1 X1 Y1 Z1\n"));
        let last = trace.at(trace.len() - 1);
        trace.state(&last).nozzle_c
    };
    for (text, celsius) in [
        ("M104 S200", 0.0),
        ("M109 S200", 200.0),
        ("M109 S200\nM104 S215", 200.0),
        ("M109 S200\nM104 S180", 180.0),
        ("M109 S200\nM104 S0", 0.0),
        // Marlin does not know it.
        ("M104 S200\nM116", 0.0),
        ("M109 S200\nM109 T1 S90", 200.0),
        ("M109 S200\nM112", 0.0),
    ] {
        assert_eq!(at(text), celsius as f32, "{text}");
    }
}

#[test]
fn an_arc_is_chords_of_one_line_that_share_its_filament() {
    let trace = trace("M83\nG1 X5 Y0 Z0 F600\nG3 X-5 Y0 I-5 J0 E2\n");
    assert!(trace.len() > 20, "{}", trace.len());
    let chords: Vec<_> = trace.moves().skip(1).collect();
    assert!(chords.iter().all(|m| m.is_arc() && m.line == 3 && m.prints()));
    assert!(!chords[0].continues_arc() && chords[1].continues_arc());
    assert!((chords.iter().map(|m| m.e).sum::<f64>() - 2.0).abs() < 1e-5);
    for m in &chords {
        let [_, to] = m.ends().unwrap();
        assert!((to.x.hypot(to.y) - 5.0).abs() < 1e-3, "{to:?}");
    }
}

#[test]
fn everything_else_is_an_event_before_the_move_that_follows() {
    let trace = trace("G28\nG1 X1 Y1 Z1 F600\nM206 Z5\nG1 X2\nG20\n;TRUNNION end\n;TRUNNION print=x\n;LAYER:3\n");
    let events: Vec<_> = trace.events.iter().map(|e| (e.before, e.line)).collect();
    assert_eq!(events, [(0, 1), (1, 3), (2, 5), (2, 6), (2, 7), (2, 8)]);
    let what: Vec<&What> = trace.events.iter().map(|e| &e.what).collect();
    assert!(matches!(what[0], What::Effect(Effect::Home, span) if *span == (0..3)));
    assert!(matches!(what[1], What::Effect(Effect::Hazard(Hazard::Shift), _)));
    assert!(matches!(what[2], What::Refused(text) if text.contains("inches")));
    assert!(matches!((what[3], what[4], what[5]), (What::Mark(Mark::End), What::BrokenMark(_), What::Layer)));
    // What shifts coordinates leaves the place unknown.
    assert_eq!((trace.at(1).from, trace.at(1).to), ([None; 3], [Some(2.0), None, None]));
}

/// 100 mm at 50 mm/s with 1000 mm/s² take 2.05 s: 50 ms up and down over 1.25 mm each.
#[test]
fn the_clock_knows_accelerations_corners_and_stops() {
    let accelerations = Accelerations { axes: [1000.0, 1000.0, 200.0, 100.0, 100.0, 1000.0], junction_mm: 0.01 };
    let axis =
        |letter| AxisRange { letter, direction: 1.0, zero: Angle::ZERO, range: None, max_rate: 1.0, absent: false };
    let reading = Reading { rotary: Some((axis(b'A'), axis(b'C'))), ..Reading::sliced() };
    let seconds = |text: &str| {
        let setting = TraceSetting { reading: reading.clone(), accelerations, ..setting() };
        let text = format!("M83\nG1 X0 Y0 Z0 A0 C0 F3000\n{text}");
        let (read, totals) =
            (read(text.as_bytes(), &setting).seconds, super::totals(text.as_bytes(), &setting).seconds);
        assert!((read - totals).abs() < 1e-9, "{text}: {read} s, {totals} s");
        read
    };
    let corner = (1000.0 * 0.01 * 0.5f64.sqrt() / (1.0 - 0.5f64.sqrt())).sqrt();
    let to_corner = 1.0 + 0.025 + (50.0 - corner).powi(2) / (2.0 * 1000.0 * 50.0);
    for (text, by_hand) in [
        ("G1 X100\n", 2.05),
        // In one piece or in a hundred.
        (&(1..=100).map(|x| format!("G1 X{x}\n")).collect::<String>(), 2.05),
        ("G1 X50\nG4 P1500\nG1 X100\n", 2.0 * 1.05 + 1.5),
        ("G1 X50\nM400\nG1 X100\n", 2.0 * 1.05),
        ("M204 S500\nG1 X100\n", 2.1),
        ("M204 P500 T2000\nG1 X100\n", 2.025),
        ("M204 P500 T2000\nG1 X100 E1\n", 2.1),
        ("G1 X50\nG1 Y50\n", 2.0 * to_corner),
        ("G1 Z50 F600\n", 5.0 + 0.05),
        // The table: 20 degrees/s, 100 degrees/s².
        ("G1 A40 F99999\n", 2.0 + 0.2),
        ("G1 E10 F600\n", 1.01),
    ] {
        let took = seconds(text);
        assert!((took - by_hand).abs() < 1e-6 * by_hand, "{text}: {took} s, by hand {by_hand} s");
    }
    // A circle of 10 mm radius along its chords: no slower than its corners demand, no faster than at constant speed.
    let round = seconds("G2 X0 Y0 I10 J0\n");
    let least = std::f64::consts::TAU * 10.0 / 50.0;
    assert!(round > least + 0.04 && round < 1.1 * least, "{round} s, at constant speed {least} s");
}

/// Full circles in as few bytes as can be: the moves that they come to are bounded by those bytes, whatever the file's size.
#[test]
fn a_file_of_arcs_costs_no_more_than_its_bytes_pay_for() {
    let chords = |line: &str, count: usize| {
        let text = format!("M83\nG1 X0 Y0 Z1\n{}", format!("{line}\n").repeat(count));
        let made = trace(&text);
        let refused =
            made.events.iter().filter(|e| matches!(&e.what, What::Refused(why) if why.contains("chords"))).count();
        assert!(made.len() <= (1 << 18) + 4 * text.len() + count, "{} moves of {} bytes", made.len(), text.len());
        (made.len(), refused)
    };
    for count in [1, 100, 1_000, 10_000] {
        let (_, refused) = chords("G2 I200 E1", count);
        assert_eq!(refused > 0, count >= 1_000, "{count}: {refused}");
    }
    // A vessel of half a metre, each wall in two half circles, is as long as anybody likes.
    let half = "G2 X250.000 Y0.000 I125.000 J0.000 E12.34567\nG2 X0.000 Y0.000 I-125.000 J0.000 E12.34567";
    assert_eq!(chords(half, 4_000).1, 0);
    // So is what goes far beyond: nothing is made of it.
    assert_eq!(chords("G2 I100000 E1", 10_000), (1, 0));
}

/// Long enough for the clock to be behind, with all that it waits for.
#[test]
fn a_program_that_is_read_in_pieces_is_the_whole_one() {
    let accelerations = Accelerations { axes: [500.0, 700.0, 60.0, 90.0, 90.0, 3000.0], junction_mm: 0.02 };
    let setting = TraceSetting { accelerations, ..setting() };
    let mut random = SplitMix64::seeded(5);
    let mut lines = vec!["M83\nG1 X0 Y0 Z0.2 F3000".to_owned()];
    for line in 0..15_000 {
        let [x, y] = [(); 2].map(|()| random.unit() * 40.0);
        lines.push(match random.below(400) {
            0 => "G4 P250".to_owned(),
            1 => format!(";LAYER_CHANGE\nG1 Z{:.2}", f64::from(line) * 0.01),
            2 => format!("G1 A{x:.2} C{y:.1}"),
            3 => "G1 X1..2".to_owned(),
            4 => "M400".to_owned(),
            5 => format!("G2 X{x:.3} Y{y:.3} I2 J1 E0.3"),
            _ => format!("G1 X{x:.3} Y{y:.3} E0.02"),
        });
    }
    let text = lines.join("\n") + "\n";
    let whole = read(text.as_bytes(), &setting);
    let pools = [1, 2, 7].map(|threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap());
    for (pool, pieces) in pools.iter().zip([1, 3, 2]) {
        let ends = text.match_indices('\n').map(|(at, _)| at + 1).collect::<Vec<usize>>();
        let mut reader = TraceReader::new(&setting, text.len());
        let mut from = 0;
        for piece in 1..=pieces {
            let to = ends[ends.len() * piece / pieces - 1];
            pool.install(|| reader.take(&text.as_bytes()[from..to]));
            from = to;
        }
        let so_far = reader.totals();
        reader.take(b"");
        let trace = reader.finish();
        assert_eq!((trace.lines, trace.seconds.to_bits()), (whole.lines, whole.seconds.to_bits()));
        assert!(trace.moves().eq(whole.moves()) && trace.events == whole.events && trace.states == whole.states);
        let all = totals(text.as_bytes(), &setting);
        assert_eq!((so_far.seconds.to_bits(), so_far.layers), (all.seconds.to_bits(), all.layers));
        assert!(all.layers > 5 && all.seconds > 100.0 && trace.events.len() > 50);
    }
}
