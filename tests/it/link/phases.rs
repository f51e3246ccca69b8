//! What comes in between: a pause, a cancel, a resume or a fault at a moment that belongs to something else.

use std::sync::Arc;
use std::time::Duration;

use trunnion::link::sim::{Logged, Quirks, Script, SimFault};
use trunnion::link::{
    Header, Heading, JournalSummary, Loopback, Notice, Outcome, Protocol, Record, Sender, SenderSettings, StopReason,
};

use super::bench_machine::{assert_once_each, end, executed, joined, program, settings, tail, text, text_at};

const MARLIN: Protocol = Protocol::Marlin;
const ALL: [Protocol; 4] = [MARLIN, Protocol::RepRapFirmware, Protocol::Klipper, Protocol::Grbl];

/// Without the moves and settings of a pause.
fn of_the_program(done: Vec<String>, blocks: &[String]) -> Vec<String> {
    let mut wanted = blocks.iter().peekable();
    done.into_iter().filter(|line| wanted.next_if(|block| *block == line).is_some()).collect()
}

#[test]
fn a_printer_that_never_answers_is_given_up_whatever_its_protocol() {
    for protocol in ALL {
        let mut sender = Sender::new(program(protocol, &text(protocol, 5)), settings(protocol));
        let mut now = Duration::ZERO;
        while sender.outcome().is_none() && now < Duration::from_secs(600) {
            sender.poll(now);
            sender.took(sender.pending().len());
            now += Duration::from_millis(250);
        }
        let outcome = sender.outcome();
        assert!(
            matches!(outcome, Some(Outcome::Stopped(StopReason::Mute { .. }))),
            "{protocol:?}: {outcome:?} at {now:?}"
        );
    }
}

/// A print over a slow wire whose numbers begin anew at line 100, run to shortly before.
fn before_renumbering(script: Script) -> (Arc<trunnion::link::Program>, Loopback) {
    let program = program(MARLIN, &text_at(MARLIN, 200, 6000));
    let mut small = settings(MARLIN);
    small.renumber_at = 100;
    let quirks = Quirks { baud: 115_200, ..Quirks::of(MARLIN) };
    let mut link = joined(&program, small, quirks, script);
    link.record();
    while link.sender.progress().last < 92 {
        link.run_to(link.now() + Duration::from_millis(5));
    }
    (program, link)
}

#[test]
fn a_pause_while_the_numbers_begin_anew_loses_nothing() {
    let mut met = 0;
    for step in 0..120 {
        let (program, mut link) = before_renumbering(Script::none());
        while link.sender.progress().last < 100 {
            link.run_to(link.now() + Duration::from_micros(200));
        }
        link.run_to(link.now() + Duration::from_micros(step * 200));
        link.sender.pause();
        met += u32::from(link.sender.progress().last >= 100 || link.sender.progress().last < 5);
        while !link.events().contains(&Notice::Paused) {
            assert!(link.now() < Duration::from_secs(3600), "{step}: no pause\n{}", tail(&link, 40));
            link.run_to(link.now() + Duration::from_millis(100));
        }
        let z = link.sim.position(link.now())[2];
        assert!(z > 24.0, "{step}: a pause on the part, at Z {z}\n{}", tail(&link, 40));
        link.sender.resume();
        assert_eq!(end(&mut link), Outcome::Done, "{step}:\n{}", tail(&link, 40));
        let blocks = super::bench_machine::blocks(&program);
        assert_once_each(&program, &of_the_program(executed(&mut link), &blocks));
    }
    assert!(met > 10, "{met} pauses while the numbers begin anew");
}

/// Where a plug is pulled there, a counter of 0 may be a reset: then the print stops and does not go on blindly.
#[test]
fn a_plug_pulled_while_the_numbers_begin_anew_neither_hangs_nor_doubles_a_line() {
    let (mut done, mut stopped) = (0, 0);
    for line in 94..116 {
        let (program, mut link) = before_renumbering(Script::at(&[(line, SimFault::HangUp)]));
        match link.run(Duration::from_secs(7200)) {
            Some(Outcome::Done) => {
                assert_once_each(&program, &executed(&mut link));
                done += 1;
            }
            Some(Outcome::Stopped(StopReason::Reset { .. })) => stopped += 1,
            other => panic!("{line}: {other:?}\n{}", tail(&link, 60)),
        }
    }
    assert!(done > 10 && stopped < 4, "{done} went on, {stopped} stopped");
}

#[test]
fn a_printer_that_stands_elsewhere_stops_though_somebody_has_said_go_on() {
    let slow: String = (0..400).map(|i| format!("G1 Y{:.3}\n", f64::from(i) * 0.5)).collect();
    let text = format!("G28\nG90\nG1 X0 Y0 Z50 F6000\nG1 A45 F1200\nG1 C400 F1800\nG1 X200 F6000\nG1 F60\n{slow}");
    let program = program(MARLIN, &text);
    let mut link = joined(&program, settings(MARLIN), Quirks::of(MARLIN), Script::none());
    link.run_to(Duration::from_secs(60));
    link.sender.pause();
    while !link.events().contains(&Notice::Journal(Record::Away)) {
        link.run_to(link.now() + Duration::from_millis(10));
    }
    link.sender.resume();
    let outcome = end(&mut link);
    assert!(matches!(outcome, Outcome::Stopped(StopReason::Elsewhere { axis: 'X', .. })), "{outcome:?}");
}

/// The head comes back to the part after the program's own last wait: its way is waited for too.
#[test]
fn a_pause_at_the_very_end_is_waited_for_before_the_end() {
    let program = program(MARLIN, &(text_at(MARLIN, 40, 1800) + "G1 X140 F120\n"));
    let mut link = joined(&program, settings(MARLIN), Quirks::of(MARLIN), Script::none());
    while link.sender.progress().acked < link.sender.progress().of {
        link.run_to(link.now() + Duration::from_millis(20));
    }
    assert!(link.sender.outcome().is_none(), "its last move is under way");
    link.sender.pause();
    while !link.events().contains(&Notice::Paused) {
        link.run_to(link.now() + Duration::from_millis(100));
    }
    link.sim.take_log();
    link.sender.resume();
    assert_eq!(end(&mut link), Outcome::Done);
    let done: Vec<String> = link.sim.take_log().into_iter().filter_map(accepted).collect();
    let at = |line: &str| done.iter().rposition(|l| l.starts_with(line));
    assert!(at("M400") > at("G1Z") && at("G1Z").is_some(), "{done:?}");
}

fn accepted((_, logged): (Duration, Logged)) -> Option<String> {
    if let Logged::Accepted(block) = logged { Some(String::from_utf8_lossy(&block).into_owned()) } else { None }
}

/// The host was killed in a pause. A cancel leaves the head where it is: off the part.
#[test]
fn a_cancel_before_the_return_from_a_pause_does_not_return() {
    let program = program(MARLIN, &text_at(MARLIN, 120, 600));
    let mut link = joined(&program, settings(MARLIN), Quirks::of(MARLIN), Script::none());
    link.run_to(Duration::from_secs(60));
    link.sender.pause();
    while !link.events().contains(&Notice::Paused) {
        link.run_to(link.now() + Duration::from_millis(100));
    }
    let records =
        link.events().iter().filter_map(|e| if let Notice::Journal(r) = e { Some(r.to_text()) } else { None });
    let standing = JournalSummary::parse(&(Header::default().to_text() + &records.collect::<String>())).unwrap();
    assert!(standing.away);
    let z = link.sim.position(link.now())[2];
    executed(&mut link);
    let mut again = Sender::resuming(Arc::clone(&program), settings(MARLIN), &standing);
    again.reconnected(link.now());
    again.cancel();
    link.sender = again;
    assert_eq!(end(&mut link), Outcome::Cancelled);
    assert_eq!(executed(&mut link), ["M104S0", "M140S0", "M107"]);
    assert!((link.sim.position(link.now())[2] - z).abs() < 1e-6, "it moved");
}

#[test]
fn a_flood_of_identity_lines_is_bounded() {
    let mut sender = Sender::new(program(MARLIN, &text(MARLIN, 5)), settings(MARLIN));
    let now = Duration::from_secs(1);
    sender.poll(Duration::ZERO);
    sender.poll(now);
    sender.receive(now, b"ok\n");
    for i in 0..100_000 {
        sender.receive(now, format!("Cap:SOMETHING_{i}:1\n").as_bytes());
    }
    assert!(sender.identity().len() < 20_000, "{} bytes", sender.identity().len());
    assert!(sender.identity().starts_with("Cap:SOMETHING_0:1\n"));
}

/// Some parsers split at blanks: none of a print's lines, repeated ones, questions and the emergency stop among them, is without.
#[test]
fn where_a_blank_is_wanted_behind_the_number_every_line_has_one() {
    for protocol in [MARLIN, Protocol::RepRapFirmware] {
        let program = program(protocol, &text_at(protocol, 120, 600));
        let faults =
            if protocol == MARLIN { vec![(40, SimFault::Corrupt), (60, SimFault::LoseOk)] } else { Vec::new() };
        let spaced = SenderSettings { blank_after_number: true, ..settings(protocol) };
        let mut link = joined(&program, spaced, Quirks::of(protocol), Script::at(&faults));
        link.record();
        while link.sender.progress().acked < 80 {
            link.run_to(link.now() + Duration::from_millis(100));
        }
        link.sender.emergency_stop();
        assert_eq!(end(&mut link), Outcome::EmergencyStopped);
        let sent: Vec<u8> = link.recorded().iter().filter(|w| w.1 == Heading::Out).flat_map(|w| w.2.clone()).collect();
        let text = String::from_utf8(sent).unwrap();
        let spaced = |line: &str| line[1..].trim_start_matches(|c: char| c.is_ascii_digit()).starts_with(' ');
        let numbered: Vec<&str> = text.lines().filter(|line| line.starts_with('N')).collect();
        assert!(numbered.len() > 40 && numbered.iter().all(|line| spaced(line)), "{numbered:?}");
        assert!(protocol != MARLIN || link.sender.progress().resends > 0);
        assert!(numbered.iter().any(|line| line.contains(" M105*")), "{numbered:?}");
    }
}
