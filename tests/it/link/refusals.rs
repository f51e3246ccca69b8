//! What a printer leaves undone though it says `ok`, and what somebody else has left behind: said, and never taken for chatter or for
//! silence.

use std::time::Duration;

use trunnion::link::sim::{Quirks, Script};
use trunnion::link::{Notice, Outcome, Protocol, Sender, StopReason};

use super::bench_machine::{end, joined, program, settings};

fn troubles(notices: &[Notice]) -> Vec<(u32, String)> {
    let trouble = |n: &Notice| match n {
        Notice::Trouble { line, text } => Some((*line, text.clone())),
        _ => None,
    };
    notices.iter().filter_map(trouble).collect()
}

/// What follows a file's start on Marlin: the pause's trouble, or the end.
fn marlin(text: &str) -> (Vec<(u32, String)>, bool) {
    let (protocol, quirks) = (Protocol::Marlin, Quirks::of(Protocol::Marlin));
    let mut link = joined(&program(protocol, text), settings(protocol), quirks, Script::none());
    link.run_to(Duration::from_secs(600));
    let paused = link.events().contains(&Notice::Paused);
    assert!(paused || link.sender.outcome() == Some(&Outcome::Done), "{:?}", link.sender.outcome());
    (troubles(link.events()), paused)
}

#[test]
fn a_line_that_is_left_undone_is_a_pause_with_its_line() {
    let (found, paused) = marlin("G28\nM83\nG1 X5 Y5 Z5 F3000\nG1 X9 E1\nG1 X12 E1\n");
    assert!(paused && found[0] == (4, "cold extrusion prevented".to_owned()), "{found:?}");
    let (found, paused) = marlin("G28\nG1 X5 F600\nG93\nG1 X9\n");
    assert!(paused && found == [(3, "the printer rejected unknown command \"G93\"".to_owned())], "{found:?}");
    // Nothing hangs on what only says how far it is.
    let (found, paused) = marlin("G28\nG1 X5 F600\nG1 X9\n");
    assert!(!paused && found.is_empty(), "{found:?}");
}

#[test]
fn after_a_look_the_print_goes_on_and_the_same_command_is_told_once() {
    let text = "G28\nG1 X5 F600\nG93\nG1 X9\nG93\nG1 X12\n";
    let protocol = Protocol::Marlin;
    let mut link = joined(&program(protocol, text), settings(protocol), Quirks::of(protocol), Script::none());
    link.run_to(Duration::from_secs(300));
    assert!(link.events().contains(&Notice::Paused));
    link.sender.resume();
    assert_eq!(end(&mut link), Outcome::Done);
    assert_eq!(troubles(link.events()).len(), 1);
}

/// A sender that has been asked for its first line, and what it has said since.
fn klipper() -> (Sender, Duration) {
    let mut sender = Sender::new(program(Protocol::Klipper, "G28\nG1 X5 F600\n"), settings(Protocol::Klipper));
    sender.poll(Duration::ZERO);
    // No answer to an earlier host has come meanwhile.
    let now = Duration::from_secs(1);
    sender.poll(now);
    (sender, now)
}

fn sent(sender: &mut Sender, now: Duration) -> String {
    sender.poll(now);
    let text = String::from_utf8_lossy(sender.pending()).into_owned();
    sender.took(text.len());
    text
}

#[test]
fn an_error_that_was_meant_for_somebody_else_ends_nothing() {
    let (mut sender, now) = klipper();
    assert_eq!(sent(&mut sender, now), "M115\n");
    sender.receive(
        now,
        b"!! Move out of range: 500.000 0.000 0.000 [0.000]\nok FIRMWARE_NAME:Klipper FIRMWARE_VERSION:v0.13\n",
    );
    assert_eq!(sent(&mut sender, now), "M400\n");
    sender.receive(now, b"ok\n");
    assert_eq!(sent(&mut sender, now), "M105\n");
    sender.receive(now, b"ok B:22.0 /0.0 T0:22.0 /0.0\n");
    assert!(sent(&mut sender, now).starts_with("G28\n"), "{:?}", sender.outcome());
    // Now it is ours.
    sender.receive(now, b"!! Must home axis first\nok\n");
    assert!(matches!(sender.outcome(), Some(Outcome::Stopped(StopReason::Error { .. }))), "{:?}", sender.outcome());
}

#[test]
fn a_klipper_that_is_shut_down_is_found_before_the_first_line_and_told_how_to_wake() {
    let (mut sender, now) = klipper();
    sent(&mut sender, now);
    // M115 and M105 answer as ever.
    sender.receive(now, b"ok FIRMWARE_NAME:Klipper FIRMWARE_VERSION:v0.13\n");
    assert_eq!(sent(&mut sender, now), "M400\n");
    sender.receive(
        now,
        b"// MCU 'mcu' shutdown: Timer too close\n// Printer is shutdown\n!! MCU 'mcu' shutdown: Timer too close\nok\n",
    );
    let Some(Outcome::Stopped(why)) = sender.outcome() else { panic!("{:?}", sender.outcome()) };
    let said = why.to_string();
    // Klipper's own words.
    assert!(said.contains("Timer too close") && said.contains("send FIRMWARE_RESTART"), "{said}");
    assert!(!sent(&mut sender, now).contains("G28"));
}

#[test]
fn what_is_not_understood_is_quoted_and_cannot_move_a_cursor() {
    let mut sender = Sender::new(program(Protocol::Marlin, "G28\n"), settings(Protocol::Marlin));
    let mut now = Duration::ZERO;
    while sender.outcome().is_none() && now < Duration::from_secs(600) {
        sent(&mut sender, now);
        sender.receive(now, b"oui \x1b[2J\n");
        now += Duration::from_secs(1);
    }
    let said = format!(
        "{}",
        match sender.outcome() {
            Some(Outcome::Stopped(why)) => why,
            other => panic!("{other:?}"),
        }
    );
    assert!(said.contains("\"oui ?[2J\""), "{said}");
}
