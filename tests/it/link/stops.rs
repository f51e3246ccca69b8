//! An emergency stop on a Marlin without EMERGENCY_PARSER, which reads M112 only where its queue has room; and the first words to printers
//! whose parsers want a blank behind the number. In virtual time.

use std::time::Duration;

use trunnion::link::sim::{Logged, Quirks, Script};
use trunnion::link::{Outcome, Protocol, Sender};

use super::bench_machine::{end, joined, program, settings, text};

const MARLIN: Protocol = Protocol::Marlin;

/// How long after the stop, at `at`, the printer obeys; `None` where it is never seen to.
fn obeyed(text: &str, heat: f64, at: Duration) -> Option<Duration> {
    let program = program(MARLIN, text);
    let quirks =
        Quirks { emergency_parser: false, baud: 250_000, loop_time: Duration::from_micros(500), ..Quirks::of(MARLIN) };
    let mut link = joined(&program, settings(MARLIN), quirks, Script::none());
    link.sim.set_heat_factor(heat);
    link.run_to(at);
    assert!(link.sender.outcome().is_none(), "the print has ended");
    link.sender.emergency_stop();
    assert_eq!(end(&mut link), Outcome::EmergencyStopped);
    let said = link.now();
    link.sim.advance(said + Duration::from_secs(600));
    let killed = link.sim.take_log().into_iter().find(|(_, logged)| *logged == Logged::Killed)?.0;
    Some(killed.saturating_sub(said))
}

#[test]
fn an_emergency_stop_is_read_whatever_a_stock_marlin_waits_for() {
    let moves: String = (0..60).map(|i| format!("G1 X{} Y{i}\n", i % 7)).collect();
    let slow: String = (0..60).map(|i| format!("G1 X{} Y{i}\n", i % 2 * 100)).collect();
    let states = [
        ("the nozzle's heat", format!("G28\nM109 S250\nG1 F3000\n{moves}"), 0.01),
        ("the bed's heat", format!("G28\nM190 S100\nG1 F3000\n{moves}"), 0.01),
        ("heat behind moves", format!("G28\nG1 F600\n{moves}M109 S250\n{moves}"), 0.01),
        ("homing", format!("{}G1 F3000\n{moves}", "G28\n".repeat(40)), 20.0),
        ("a dwell", format!("G28\nG1 F3000\n{moves}G4 S900\n{moves}"), 20.0),
        ("slow moves", format!("G28\nG1 X0 Y0 F60\n{slow}"), 20.0),
    ];
    for (state, text, heat) in states {
        for at in 0..40 {
            // Behind the first move, whose length nobody knows: homing ends anywhere.
            let at = Duration::from_millis(if state == "homing" { 3000 } else { 14_000 } + at * 731);
            let after = obeyed(&text, heat, at);
            // One of the shorter moves may be waited for; the others take hundreds of seconds.
            assert!(after.is_some_and(|t| t < Duration::from_secs(1)), "{state}, at {at:?}: {after:?}");
        }
    }
}

/// Between short moves the queue is full, as it must be, and has room again with the next of them.
#[test]
fn an_emergency_stop_among_short_moves_is_read_with_the_next_of_them() {
    for at in 0..20 {
        let at = Duration::from_millis(30_000 + at * 37);
        let after = obeyed(&text(MARLIN, 3000), 20.0, at);
        assert!(after.is_some_and(|t| t < Duration::from_secs(2)), "at {at:?}: {after:?}");
    }
}

/// A conversation in which each line is answered as `answer` says; what was sent.
fn talk(answer: impl Fn(usize, &str) -> String) -> Vec<String> {
    let program = program(MARLIN, &text(MARLIN, 40));
    let mut one = settings(MARLIN);
    one.window_lines = 1;
    let mut sender = Sender::new(program, one);
    let (mut now, mut sent) = (Duration::ZERO, Vec::<String>::new());
    while sender.outcome().is_none() && sent.len() < 30 {
        sender.poll(now);
        let lines: Vec<String> = String::from_utf8_lossy(sender.pending()).lines().map(str::to_owned).collect();
        sender.took(sender.pending().len());
        for line in lines.into_iter().filter(|l| !l.is_empty()) {
            let answer = answer(sent.len(), &line);
            sent.push(line);
            sender.receive(now, answer.as_bytes());
        }
        now += Duration::from_millis(100);
    }
    sent
}

fn is_spaced(line: &str) -> bool {
    line[1..].trim_start_matches(|c: char| c.is_ascii_digit()).starts_with(' ')
}

fn answer(name: &str, line: &str) -> String {
    let words = if line.contains("M115") { format!("FIRMWARE_NAME:{name} EXTRUDER_COUNT:1\n") } else { String::new() };
    let report = if line.contains("M105") { " T:20.0 /0.0 B:20.0 /0.0" } else { "" };
    format!("{words}ok{report}\n")
}

#[test]
fn the_first_words_are_those_that_everybody_reads_and_short_ones_come_when_the_firmware_is_known() {
    let known = talk(|_, line| answer("Marlin bugfix-2.1.x", line));
    assert_eq!(known[..2], ["N0 M110 N0*125", "N1 M115*39"]);
    assert!(known[3..].iter().filter(|line| !is_spaced(line)).count() > 15, "{known:?}");
    for name in ["Virtual Marlin 1.0", "Klopper 7"] {
        let unknown = talk(|_, line| answer(name, line));
        assert!(unknown.len() == 30 && unknown.iter().all(|line| is_spaced(line)), "{unknown:?}");
    }
}

#[test]
fn a_firmware_that_refuses_the_first_short_line_gets_no_more_of_them() {
    let refused = |_: usize, line: &str| match is_spaced(line) {
        true => answer("Marlin, of a kind", line),
        false => {
            let number: i64 = line[1..].split(|c: char| !c.is_ascii_digit()).next().unwrap().parse().unwrap();
            format!("Error:checksum mismatch, Last Line: {}\nResend: {number}\nok\n", number - 1)
        }
    };
    let sent = talk(refused);
    let short = sent.iter().filter(|line| !is_spaced(line)).count();
    assert!(sent.len() == 30 && (1..=3).contains(&short), "{short}: {sent:?}");
}
