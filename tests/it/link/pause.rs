//! In a pause the printer is asked where it stands, and its word is taken seriously.

use std::time::Duration;

use trunnion::link::sim::{Quirks, SURVIVABLE, Script, SimFault};
use trunnion::link::{Loopback, Notice, Outcome, Protocol, SenderSettings, StopReason};

use super::bench_machine::{end, executed, joined, program, settings, text, without_padding};
use crate::support::{note, seeds};

/// Moves to `x` at a tilt, then on for a long time; paused among them.
fn paused(protocol: Protocol, x: f64) -> (Option<Outcome>, bool, f64) {
    let slow: String = (0..200).map(|i| format!("G1 Y{:.3}\n", f64::from(i) * 0.5)).collect();
    let text = format!("G28\nG90\nG1 X0 Y0 Z50 F6000\nG1 A45 F1200\nG1 C400 F1800\nG1 X{x} F6000\nG1 F60\n{slow}");
    let program = program(protocol, &text);
    let mut link = joined(&program, settings(protocol), Quirks::of(protocol), Script::none());
    link.run_to(Duration::from_secs(60));
    link.sender.pause();
    link.run_to(Duration::from_secs(300));
    let z = link.sim.position(link.now())[2];
    (link.sender.outcome().cloned(), link.events().contains(&Notice::Paused), z)
}

#[test]
fn a_printer_that_stands_where_the_file_has_brought_it_is_paused() {
    for protocol in [Protocol::Marlin, Protocol::Klipper, Protocol::RepRapFirmware] {
        let (outcome, reached, z) = paused(protocol, 100.0);
        assert!(outcome.is_none() && reached && z > 69.0, "{protocol:?}: {outcome:?} at Z {z}");
    }
}

#[test]
fn a_printer_that_stands_elsewhere_leaves_the_part_and_stops() {
    // Marlin cuts a target beyond its limit without a word; only M114 shows it.
    let (outcome, reached, z) = paused(Protocol::Marlin, 200.0);
    let Some(Outcome::Stopped(why)) = outcome else { panic!("{outcome:?}") };
    assert!(matches!(why, StopReason::Elsewhere { axis: 'X', found: 150.0, believed: 200.0, .. }), "{why}");
    assert!(why.to_string().contains("X at 150.00") && why.to_string().contains("expected 200.00 mm"), "{why}");
    assert!(!reached && z > 69.0, "above the part first: {z}");
}

#[test]
fn a_cancel_does_not_wait_for_agreement() {
    let text = "G28\nG90\nG1 X0 Y0 Z50 F6000\nG1 X200\nG1 F60\n".to_owned() + &"G1 Y1\nG1 Y0\n".repeat(100);
    let program = program(Protocol::Marlin, &text);
    let mut link = joined(&program, settings(Protocol::Marlin), Quirks::of(Protocol::Marlin), Script::none());
    link.run_to(Duration::from_secs(60));
    link.sender.cancel();
    assert_eq!(end(&mut link), Outcome::Cancelled);
}

/// A print at a tilt in layers of 20 lines, whose place is asked for at the end of each; `x` is where the fifth begins and all from there on are.
fn in_layers(protocol: Protocol, x: f64, script: Script) -> Loopback {
    let mut text = "G28\nG90\nG1 X0 Y0 Z50 F6000\nG1 A45 F1200\nG1 C400 F1800\nG1 X100 F6000\n".to_owned();
    for i in 0..200 {
        if i % 20 == 0 {
            text += ";LAYER_CHANGE\n";
        }
        if i == 80 {
            text += &format!("G1 X{x}\n");
        }
        text += &format!("G1 Y{:.3}\n", f64::from(i) * 0.05);
    }
    let settings = SenderSettings { prove_layers: true, ..settings(protocol) };
    joined(&program(protocol, &text), settings, Quirks::of(protocol), script)
}

#[test]
fn a_place_that_is_lost_is_found_at_the_end_of_the_layer() {
    for (x, lost) in
        [(100.0, false), (149.99, false), (150.0, false), (150.04, false), (150.06, true), (151.0, true), (200.0, true)]
    {
        let mut link = in_layers(Protocol::Marlin, x, Script::none());
        let outcome = end(&mut link);
        let height = link.sim.position(link.now())[2];
        let lines = executed(&mut link).iter().filter(|line| line.starts_with("G1Y")).count();
        if lost {
            assert!(matches!(outcome, Outcome::Stopped(StopReason::Elsewhere { axis: 'X', .. })), "{x}: {outcome:?}");
            assert!((100..125).contains(&lines) && height > 69.0, "{x}: {lines} lines, at Z {height}");
        } else {
            assert_eq!((outcome, lines), (Outcome::Done, 200), "{x}");
        }
    }
    // Klipper and RepRapFirmware refuse such a move themselves; what they say of their place is understood.
    for protocol in [Protocol::Klipper, Protocol::RepRapFirmware] {
        assert_eq!(end(&mut in_layers(protocol, 140.0, Script::none())), Outcome::Done, "{protocol:?}");
    }
}

#[test]
fn a_place_that_was_not_asked_for_is_no_reason_to_stop() {
    let own = "G28\nG90\nM114\nG1 X5 Y5 Z50 F6000\nM114\n;LAYER_CHANGE\nM114\nG1 X6\nM114\n;LAYER_CHANGE\nG1 X7\n;LAYER_CHANGE\nG1 X9\nM114\n";
    for protocol in [Protocol::Marlin, Protocol::Klipper, Protocol::RepRapFirmware] {
        let settings = SenderSettings { prove_layers: true, ..settings(protocol) };
        let mut link = joined(&program(protocol, own), settings, Quirks::of(protocol), Script::none());
        assert_eq!(end(&mut link), Outcome::Done, "{protocol:?}");
    }
}

#[test]
fn layers_are_proved_through_every_fault_that_a_print_survives() {
    let faults: Vec<SimFault> = SURVIVABLE.into_iter().chain([SimFault::HangUp]).collect();
    let mut asked = 0;
    // In the last of them the last line goes out again, alone as all do that do so, and its answer is lost.
    for seed in seeds(40, 1000).chain([1_796_045_302]) {
        let file = text(Protocol::Marlin, 600);
        let program = program(Protocol::Marlin, &file);
        let settings = SenderSettings { prove_layers: true, ..settings(Protocol::Marlin) };
        let mut link = joined(&program, settings, Quirks::of(Protocol::Marlin), Script::random(&faults, 0.01, seed));
        let outcome = end(&mut link);
        assert_eq!(outcome, Outcome::Done, "seed {seed}");
        asked += link.events().iter().filter(|event| matches!(event, Notice::Position(_))).count();
        let done = executed(&mut link);
        let wanted: Vec<String> =
            (0..program.len()).map(|i| without_padding(&String::from_utf8_lossy(program.block(i)))).collect();
        assert_eq!(done, wanted, "seed {seed}");
    }
    note(&format!("asked {asked} times where the head was, 40 prints of 12 layers"));
    assert!(asked > 40 * 11, "{asked}");
}
