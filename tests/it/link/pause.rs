//! In a pause the printer is asked where it stands, and its word is taken seriously.

use std::time::Duration;

use trunnion::link::sim::{Quirks, Script};
use trunnion::link::{Notice, Outcome, Protocol, StopReason};

use super::bench_machine::{end, joined, program, settings};

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
    assert!(why.to_string().contains("X at 150.00") && why.to_string().contains("at 200.00"), "{why}");
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
