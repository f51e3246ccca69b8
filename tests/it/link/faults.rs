//! The rows of the fault matrix (`link::sim::NAMES`), each named after its fault: no line missing, none doubled, or the
//! stated safe stop; none hangs.

use std::time::Duration;

use trunnion::link::sim::{Quirks, SURVIVABLE, Script, SimFault};
use trunnion::link::{Loopback, Notice, Outcome, Protocol, SenderSettings, StopReason};

use super::bench_machine::{
    assert_beginning, assert_once_each, end, executed, joined, program, settings, tail, text, text_at,
};

const MARLIN: Protocol = Protocol::Marlin;
const MOVES: u32 = 120;
const BOUND: Duration = Duration::from_secs(4 * 3600);

/// Marlin's kinds: plain, with numbers in its answers, without `ok` after a resend, older ones that refuse doubles, Repetier's words.
fn kinds() -> [(&'static str, Quirks); 5] {
    let plain = Quirks::of(MARLIN);
    [
        ("plain", plain.clone()),
        ("ADVANCED_OK", Quirks { advanced_ok: true, ..plain.clone() }),
        ("no ok after resend", Quirks { ok_after_resend: false, ..plain.clone() }),
        ("refuses doubles", Quirks { silent_duplicates: false, ..plain.clone() }),
        ("Repetier's words", Quirks { repetier_errors: true, blank_behind_slash: true, ..plain }),
    ]
}

/// Each fault at one line after the other, on each kind: everything executed once.
#[track_caller]
fn survives(fault: SimFault) {
    let program = program(MARLIN, &text(MARLIN, MOVES));
    for (kind, quirks) in kinds() {
        for line in [5, 9, 14, 36, 37, 60, 61, 62, 63, 120] {
            let mut link = joined(&program, settings(MARLIN), quirks.clone(), Script::at(&[(line, fault)]));
            link.record();
            let outcome =
                link.run(BOUND).unwrap_or_else(|| panic!("{fault:?} at {line}, {kind} hangs:\n{}", tail(&link, 60)));
            assert_eq!(outcome, Outcome::Done, "{fault:?} at {line}, {kind}: {:?}", link.events().last());
            assert_once_each(&program, &executed(&mut link));
        }
    }
}

/// A fault at line 60 of a print: how it ended, after checking that nothing was lost or doubled before.
#[track_caller]
fn stops(fault: SimFault) -> (StopReason, Loopback) {
    let program = program(MARLIN, &text(MARLIN, MOVES));
    let mut link = joined(&program, settings(MARLIN), Quirks::of(MARLIN), Script::at(&[(60, fault)]));
    let Outcome::Stopped(why) = end(&mut link) else { panic!("{fault:?} did not stop the print") };
    let done = executed(&mut link);
    let done =
        &done[..done.len() - done.iter().rev().take_while(|l| l.starts_with("M104") || l.starts_with("M140")).count()];
    assert_beginning(&program, done);
    (why, link)
}

#[test]
fn row_00_without_a_fault_every_line_is_executed_once() {
    for protocol in [MARLIN, Protocol::RepRapFirmware, Protocol::Klipper, Protocol::Grbl] {
        let program = program(protocol, &text(protocol, MOVES));
        let mut link = joined(&program, settings(protocol), Quirks::of(protocol), Script::none());
        assert_eq!(end(&mut link), Outcome::Done, "{protocol:?}");
        assert_once_each(&program, &executed(&mut link));
        assert_eq!(link.sender.progress().resends, 0);
    }
}

/// However narrow the window is: behind the last line only the proof that all is done is under way, and its answer may be what is lost.
#[test]
fn a_lost_answer_ends_no_print_in_a_narrow_window() {
    let program = program(MARLIN, &text(MARLIN, 12));
    for (kind, quirks) in kinds() {
        for window_lines in [1, 2, 4] {
            for line in 1..45 {
                let settings = SenderSettings { window_lines, ..settings(MARLIN) };
                let mut link = joined(&program, settings, quirks.clone(), Script::at(&[(line, SimFault::LoseOk)]));
                link.record();
                let why = format!("a window of {window_lines}, the answer to line {line} lost, {kind}");
                let outcome = link.run(BOUND).unwrap_or_else(|| panic!("{why}: hangs:\n{}", tail(&link, 60)));
                assert_eq!(outcome, Outcome::Done, "{why}:\n{}", tail(&link, 60));
                assert_once_each(&program, &executed(&mut link));
            }
        }
    }
}

#[test]
fn row_01_a_corrupt_line_goes_out_again() {
    survives(SimFault::Corrupt);
}

#[test]
fn row_02_a_line_that_vanishes_goes_out_again() {
    survives(SimFault::Drop);
}

#[test]
fn row_03_two_lines_run_together_go_out_again() {
    survives(SimFault::Join);
}

#[test]
fn row_04_a_lost_character_is_found() {
    survives(SimFault::LoseByte);
}

#[test]
fn row_05_a_lost_ok_is_not_waited_for_for_ever() {
    survives(SimFault::LoseOk);
}

#[test]
fn row_06_a_mangled_ok_is_no_ok() {
    survives(SimFault::MangleOk);
}

#[test]
fn row_07_an_ok_in_two_reads_is_one_ok() {
    survives(SimFault::SplitOk);
}

#[test]
fn row_08_a_doubled_ok_loses_nothing() {
    survives(SimFault::DoubleOk);
}

#[test]
fn row_09_a_late_ok_and_a_slow_line_are_waited_for() {
    survives(SimFault::DelayOk);
    survives(SimFault::Slow);
    // A move of ten minutes without a word from the firmware.
    let text = "G28\nG1 F60\nG1 X0 Y0\n".to_owned() + &"G1 X10 Y0\nG1 X0 Y0\n".repeat(30);
    let program = program(MARLIN, &text);
    let quirks = Quirks { busy: false, ..Quirks::of(MARLIN) };
    let mut link = joined(&program, settings(MARLIN), quirks, Script::none());
    assert_eq!(end(&mut link), Outcome::Done);
    assert_once_each(&program, &executed(&mut link));
}

#[test]
fn row_10_resend_with_and_without_its_ok() {
    let program = program(MARLIN, &text(MARLIN, MOVES));
    for ok_after_resend in [true, false] {
        let quirks = Quirks { ok_after_resend, ..Quirks::of(MARLIN) };
        let script = Script::at(&[30, 45, 60, 75, 90].map(|line| (line, SimFault::Corrupt)));
        let mut link = joined(&program, settings(MARLIN), quirks, script);
        assert_eq!(end(&mut link), Outcome::Done);
        assert_once_each(&program, &executed(&mut link));
        assert_eq!(link.sender.progress().resends, 5, "one for each, however many lines were refused behind it");
    }
}

#[test]
fn row_11_an_error_without_resend_and_without_ok() {
    survives(SimFault::ErrorOnly);
}

#[test]
fn row_12_a_resend_of_the_line_that_is_next_anyway() {
    survives(SimFault::ResendNext);
}

#[test]
fn row_13_a_resend_of_an_acknowledged_line_replays_nothing() {
    // The printer's counter is asked and found intact: one stray line is not obeyed, and the print goes on.
    survives(SimFault::ResendOld);
}

#[test]
fn row_14_a_garbled_resend_number_is_not_obeyed() {
    survives(SimFault::GarbledResend);
}

#[test]
fn row_15_an_endless_resend_stops_at_ten() {
    let (why, link) = stops(SimFault::EndlessResend);
    assert!(matches!(why, StopReason::EndlessResend { times: 10, line } if line > 40), "{why}");
    assert!(link.sim.temperatures(link.now())[0] > 0.0);
    let asked = link.events().iter().filter(|e| matches!(e, Notice::Resend { .. })).count();
    assert_eq!(asked, 10);
}

#[test]
fn row_16_noise_and_bytes_that_are_no_text() {
    survives(SimFault::Noise);
}

#[test]
fn row_17_a_reset_stops_and_nothing_is_printed_from_the_beginning() {
    let (why, mut link) = stops(SimFault::Reset);
    assert!(matches!(why, StopReason::Reset { .. }), "{why}");
    assert!(executed(&mut link).is_empty());
    // The greeting's lines may be lost too.
    let program = program(MARLIN, &text(MARLIN, MOVES));
    let mut link = joined(
        &program,
        settings(MARLIN),
        Quirks::of(MARLIN),
        Script::at(&[(60, SimFault::Mute), (61, SimFault::Reset)]),
    );
    assert!(matches!(end(&mut link), Outcome::Stopped(StopReason::Reset { .. })));
}

#[test]
fn row_18_a_false_start_in_the_chatter_is_asked_about() {
    survives(SimFault::FalseStart);
}

#[test]
fn row_19_usb_gone_and_back_goes_on_with_the_next_line() {
    survives(SimFault::HangUp);
    let program = program(MARLIN, &text(MARLIN, MOVES));
    let mut link = joined(&program, settings(MARLIN), Quirks::of(MARLIN), Script::at(&[(60, SimFault::HangUp)]));
    assert_eq!(end(&mut link), Outcome::Done);
    assert!(link.events().contains(&Notice::Resumed));
}

#[test]
fn row_20_a_power_loss_stops() {
    let (why, _) = stops(SimFault::PowerLoss);
    assert!(matches!(why, StopReason::Reset { .. }), "{why}");
}

#[test]
fn row_21_another_printer_is_not_printed_on() {
    let program = program(MARLIN, &text(MARLIN, MOVES));
    let mut wanted = settings(MARLIN);
    wanted.identity = Some("UUID:0000".to_owned());
    let mut link = joined(&program, wanted, Quirks::of(MARLIN), Script::none());
    assert!(matches!(end(&mut link), Outcome::Stopped(StopReason::OtherPrinter { .. })));
    assert!(executed(&mut link).is_empty());
    for (here, there) in
        [(MARLIN, Protocol::RepRapFirmware), (Protocol::Klipper, MARLIN), (Protocol::RepRapFirmware, MARLIN)]
    {
        let program = self::program(here, &text(here, MOVES));
        let sim = joined(&program, settings(there), Quirks::of(there), Script::none()).sim;
        let mut link = Loopback::new(joined(&program, settings(here), Quirks::of(here), Script::none()).sender, sim);
        assert!(matches!(end(&mut link), Outcome::Stopped(StopReason::OtherPrinter { .. })), "{here:?} on {there:?}");
        assert!(executed(&mut link).is_empty());
    }
}

#[test]
fn row_22_a_mute_controller_is_given_up() {
    let (why, link) = stops(SimFault::Mute);
    assert!(matches!(why, StopReason::Mute { .. }), "{why}");
    assert!(link.now() < Duration::from_secs(600), "{:?}", link.now());
}

#[test]
fn row_23_a_fatal_error_ends_the_stream() {
    let (why, link) = stops(SimFault::Fatal);
    assert!(matches!(&why, StopReason::Fatal { text } if text.contains("Thermal Runaway")), "{why}");
    assert!(link.sender.pending().is_empty());
    let (why, _) = stops(SimFault::StrangeError);
    assert!(matches!(&why, StopReason::Error { text, .. } if text == "Probing Failed"), "{why}");
}

#[test]
fn row_24_the_receive_buffer_is_never_overrun() {
    survives(SimFault::Overflow);
    // Four long lines do not fit 128 bytes: the window counts bytes too, so nothing is lost and nothing is asked for again.
    let long: String = (0..200)
        .map(|i| format!("G1 X{:.5} Y{:.5} Z10.12345 A10.12345 C120.{i:05} E0.12345\n", i as f64 * 0.1, 50.0))
        .collect();
    let program = program(MARLIN, &("G28\nM109 S200\nM83\nG1 F3000\n".to_owned() + &long));
    let quirks = Quirks { baud: 250_000, ..Quirks::of(MARLIN) };
    let mut link = joined(&program, settings(MARLIN), quirks, Script::none());
    assert_eq!(end(&mut link), Outcome::Done);
    assert_once_each(&program, &executed(&mut link));
    assert_eq!(link.sender.progress().resends, 0);
}

#[test]
fn row_25_minutes_of_heating_are_no_silence() {
    let program = program(MARLIN, "M190 S100\nM109 S250\nG28\nG1 X0 F600\n");
    for busy in [true, false] {
        let quirks = Quirks { busy, ..Quirks::of(MARLIN) };
        let mut link = joined(&program, settings(MARLIN), quirks, Script::none());
        link.sim.set_heat_factor(0.5);
        assert_eq!(end(&mut link), Outcome::Done);
        assert!(link.now() > Duration::from_secs(300), "{:?}", link.now());
        assert_once_each(&program, &executed(&mut link));
        assert!(!link.events().iter().any(|e| matches!(e, Notice::Note(_))), "{:?}", link.events());
    }
}

#[test]
fn row_25_cancel_ends_a_wait_for_heat() {
    let program = program(MARLIN, "G28\nM109 S250\nG1 X0 F600\n");
    let mut link = joined(&program, settings(MARLIN), Quirks::of(MARLIN), Script::none());
    link.sim.set_heat_factor(0.01);
    link.run_to(Duration::from_secs(60));
    link.sender.cancel();
    assert_eq!(end(&mut link), Outcome::Cancelled);
    assert!(link.now() < Duration::from_secs(120), "{:?}", link.now());
}

#[test]
fn row_26_a_person_may_take_an_hour() {
    let program = program(MARLIN, &("G28\nM0\n".to_owned() + &text(MARLIN, 40)));
    let mut link = joined(&program, settings(MARLIN), Quirks::of(MARLIN), Script::none());
    link.sim.set_person(Duration::from_secs(7000));
    assert_eq!(end(&mut link), Outcome::Done);
    assert!(link.events().contains(&Notice::UserWait) && link.now() > Duration::from_secs(7000));
    assert_once_each(&program, &executed(&mut link));
}

#[test]
fn row_27_an_emergency_stop_overtakes_full_buffers() {
    use trunnion::link::sim::Logged;
    for protocol in [MARLIN, Protocol::RepRapFirmware, Protocol::Klipper, Protocol::Grbl] {
        let program = program(protocol, &text_at(protocol, MOVES, 200));
        let mut link = joined(&program, settings(protocol), Quirks::of(protocol), Script::none());
        link.run_to(Duration::from_secs(40));
        // Bytes that the port has not taken yet.
        link.sender.poll(link.now());
        link.sender.emergency_stop();
        let pending = link.sender.pending().to_vec();
        let first = match protocol {
            Protocol::Grbl => &b"\x18"[..],
            Protocol::Klipper => b"M112\n",
            Protocol::RepRapFirmware => b"*300\nM112\n",
            _ => b"\nM112\n",
        };
        assert!(pending.starts_with(first), "{protocol:?}: {:?}", String::from_utf8_lossy(&pending));
        assert_eq!(end(&mut link), Outcome::EmergencyStopped);
        let at = link.now();
        link.sim.advance(at + Duration::from_millis(10));
        let dead = |l: &Logged| matches!(l, Logged::Killed | Logged::Restarted);
        assert!(link.sim.take_log().iter().any(|(_, l)| dead(l)), "{protocol:?}");
    }
}

#[test]
fn row_28_cancel_with_lines_in_flight_drains_them_and_leaves_the_part() {
    let program = program(MARLIN, &text_at(MARLIN, MOVES, 200));
    let mut link = joined(&program, settings(MARLIN), Quirks::of(MARLIN), Script::none());
    link.run_to(Duration::from_secs(120));
    let z = link.sim.position(link.now())[2];
    link.sender.cancel();
    assert_eq!(end(&mut link), Outcome::Cancelled);
    let done = executed(&mut link);
    let sent = link.sender.progress().sent as usize;
    assert_beginning(&program, &done[..sent]);
    assert_eq!(done[sent..], ["M83", "G91", "G1E-2F2100", "G90", "G1Z25F900", "M104S0", "M140S0", "M107"]);
    assert!((link.sim.position(link.now())[2] - z - 20.0).abs() < 0.1, "{z}");
}

#[test]
fn row_29_a_restarted_host_goes_on_with_the_printers_next_line() {
    use trunnion::link::{Header, JournalSummary, Sender};
    let program = program(MARLIN, &text_at(MARLIN, MOVES, 200));
    for at in [60, 105, 110, 113, 117, 121] {
        let mut link = joined(&program, settings(MARLIN), Quirks::of(MARLIN), Script::none());
        link.run_to(Duration::from_millis(at * 1000));
        let sent_by_then = link.sender.progress().sent;
        // The journal as the disk has it: every run, and an acknowledgement that is old.
        let mut journal = Header::default().to_text();
        for event in link.events() {
            if let Notice::Journal(record) = event {
                journal += &record.to_text();
            }
        }
        let standing = JournalSummary::parse(&journal).unwrap();
        let mut done = executed(&mut link);
        let before = done.len();
        let mut again = Sender::resuming(program.clone(), settings(MARLIN), &standing);
        again.reconnected(link.now());
        link.record();
        link.sender = again;
        let now = link.now();
        link.run_to(now + Duration::from_millis(1));
        assert_eq!(end(&mut link), Outcome::Done, "{at}: {:?}", link.events().last());
        done.extend(executed(&mut link));
        if done.len() != program.len() as usize {
            panic!("{before} before\n{journal}\n{}", tail(&link, 200));
        }
        assert!(sent_by_then > 0 && (sent_by_then as usize) < done.len(), "{at}");
        assert_once_each(&program, &done);
    }
}

#[test]
fn row_31_answers_to_somebody_else_are_not_counted() {
    survives(SimFault::StrayOk);
    let program = program(MARLIN, &text(MARLIN, MOVES));
    let script = Script::at(&(20..80).map(|line| (line, SimFault::StrayOk)).collect::<Vec<_>>());
    let mut link = joined(&program, settings(MARLIN), Quirks::of(MARLIN), script);
    assert_eq!(end(&mut link), Outcome::Done);
    assert_once_each(&program, &executed(&mut link));
}

#[test]
fn row_32_the_counter_begins_anew_before_it_is_full() {
    let program = program(MARLIN, &text(MARLIN, 400));
    for fault in [None, Some(SimFault::Corrupt), Some(SimFault::LoseOk), Some(SimFault::Drop)] {
        for line in 98..112 {
            let mut small = settings(MARLIN);
            small.renumber_at = 100;
            let script = fault.map_or(Script::none(), |f| Script::at(&[(line, f)]));
            let mut link = joined(&program, small, Quirks::of(MARLIN), script);
            assert_eq!(end(&mut link), Outcome::Done, "{fault:?} at {line}: {:?}", link.events().last());
            assert_once_each(&program, &executed(&mut link));
        }
    }
}

#[test]
fn row_33_grbl_a_lost_answer_or_line_stops_in_feed_hold() {
    let program = program(Protocol::Grbl, &text(Protocol::Grbl, MOVES));
    for fault in [SimFault::LoseOk, SimFault::Drop, SimFault::Join, SimFault::DoubleOk, SimFault::MangleOk] {
        let mut link =
            joined(&program, settings(Protocol::Grbl), Quirks::of(Protocol::Grbl), Script::at(&[(60, fault)]));
        let outcome = end(&mut link);
        let sound = match &outcome {
            // A doubled `ok` may be noticed before the end, or have done no harm.
            Outcome::Done => fault == SimFault::DoubleOk,
            Outcome::Stopped(why) => matches!(why, StopReason::Unaccounted { .. } | StopReason::Refused { .. }),
            _ => false,
        };
        assert!(sound, "{fault:?}: {outcome:?}");
        let done = executed(&mut link);
        let mut seen = std::collections::HashSet::new();
        assert!(
            done.iter().skip(4).filter(|l| l.len() > 8).all(|l| seen.insert(l.clone())),
            "{fault:?}: a line was executed twice"
        );
    }
}

#[test]
fn row_33_grbl_an_error_holds_the_feed_and_names_the_line() {
    for latches_errors in [false, true] {
        let program = program(Protocol::Grbl, "G90\nF600\nG1 X1\nG1 X2\nG1 X9999 F600\nG5.1 X3\nG1 X4\n");
        let quirks = Quirks { latches_errors, ..Quirks::of(Protocol::Grbl) };
        let mut link = joined(&program, settings(Protocol::Grbl), quirks, Script::none());
        let outcome = end(&mut link);
        assert!(
            matches!(&outcome, Outcome::Stopped(StopReason::Fatal { text }) if text.contains("soft limit")),
            "{outcome:?}"
        );
    }
    let program = program(Protocol::Grbl, "G90\nF600\nG1 X1\nG5.1 X3\nG1 X4\n");
    let quirks = Quirks { latches_errors: true, ..Quirks::of(Protocol::Grbl) };
    let mut link = joined(&program, settings(Protocol::Grbl), quirks, Script::none());
    let outcome = end(&mut link);
    assert!(matches!(outcome, Outcome::Stopped(StopReason::Refused { line: 4, code: 20, .. })), "{outcome:?}");
}

#[test]
fn row_34_a_port_that_takes_nothing_starves_nobody() {
    use trunnion::link::Sender;
    let program = program(MARLIN, &text(MARLIN, MOVES));
    let mut sender = Sender::new(program, settings(MARLIN));
    let mut now = Duration::ZERO;
    while sender.outcome().is_none() && now < Duration::from_secs(4000) {
        sender.poll(now);
        sender.receive(now, b" T:20.00 /0.00 B:20.00 /0.00 @:0 B@:0\n");
        now += Duration::from_millis(250);
    }
    assert!(matches!(sender.outcome(), Some(Outcome::Stopped(StopReason::Mute { .. }))), "{:?}", sender.outcome());
    assert!(sender.pending().len() < 1000, "the queue for the port stays bounded");
}

#[test]
fn uncounted_protocols_stop_where_they_cannot_know() {
    for protocol in [Protocol::Klipper, Protocol::RepRapFirmware] {
        let program = program(protocol, &text(protocol, MOVES));
        for fault in [SimFault::LoseOk, SimFault::Drop] {
            let mut link = joined(&program, settings(protocol), Quirks::of(protocol), Script::at(&[(60, fault)]));
            let outcome = end(&mut link);
            assert!(
                matches!(outcome, Outcome::Stopped(StopReason::Unaccounted { lines: 1.., .. })),
                "{protocol:?} {fault:?}: {outcome:?}"
            );
        }
        for fault in [SimFault::DoubleOk, SimFault::StrayOk, SimFault::DelayOk, SimFault::SplitOk, SimFault::Slow] {
            let mut link = joined(&program, settings(protocol), Quirks::of(protocol), Script::at(&[(60, fault)]));
            assert_eq!(end(&mut link), Outcome::Done, "{protocol:?} {fault:?}: {:?}", link.events().last());
            assert_once_each(&program, &executed(&mut link));
        }
    }
}

#[test]
fn pause_and_return_come_back_to_the_same_place() {
    for protocol in [MARLIN, Protocol::Klipper, Protocol::RepRapFirmware, Protocol::Grbl] {
        let program = program(protocol, &text_at(protocol, MOVES, 200));
        let mut link = joined(&program, settings(protocol), Quirks::of(protocol), Script::none());
        link.run_to(Duration::from_secs(120));
        link.sender.pause();
        link.run_to(Duration::from_secs(200));
        assert!(link.events().contains(&Notice::Paused), "{protocol:?}");
        let away = link.sim.position(link.now());
        link.sender.resume();
        assert_eq!(end(&mut link), Outcome::Done, "{protocol:?}: {:?}", link.events().last());
        assert!(away[2] > 20.0, "{protocol:?}: {away:?}");
        let own = |l: &String| {
            ["G1Z25", "G1E", "G1A", "G1C", "M82", "G92", "M190", "G1F", "G91", "G1U"].iter().any(|p| l.starts_with(p))
        };
        let done = executed(&mut link);
        let wanted = super::bench_machine::blocks(&program);
        let mut rest = done.iter();
        assert!(wanted.iter().all(|w| rest.any(|d| d == w)), "{protocol:?}: a block is missing or out of order");
        let extra = done.len() - wanted.len();
        assert!(extra <= 20, "{protocol:?}: {extra} {:?}", done.iter().filter(|l| own(l)).collect::<Vec<_>>());
    }
}

/// 200,000 lines, each with a chance of 5 % of any fault that a host can survive; a kind of Marlin each.
#[track_caller]
fn soak(kind: usize, moves: u32) {
    let (name, quirks) = kinds()[kind].clone();
    let program = program(MARLIN, &text_at(MARLIN, moves, 12_000));
    // An overrun receive buffer, which cuts lines, is among them; two cuts are never in one window (`Script::random` says why).
    let script = Script::random(&SURVIVABLE, 0.05, 1000 + kind as u64);
    let mut link = joined(&program, settings(MARLIN), quirks, script);
    let mut done = Vec::new();
    let mut until = Duration::ZERO;
    while link.sender.outcome().is_none() {
        until += Duration::from_secs(600);
        assert!(until < Duration::from_secs(3_000_000), "{name}: no end");
        link.run_to(until);
        done.extend(executed(&mut link));
    }
    assert_eq!(link.sender.outcome(), Some(&Outcome::Done), "{name}");
    done.extend(executed(&mut link));
    assert_once_each(&program, &done);
    let resends = link.sender.progress().resends;
    crate::support::note(&format!("{name}: {} lines, {resends} resends, none missing, none doubled", done.len()));
}

#[test]
fn soak_of_200_000_lines_at_5_percent_plain() {
    soak(0, 195_840);
}

#[test]
fn soak_of_200_000_lines_at_5_percent_advanced_ok() {
    soak(1, 195_840);
}

#[test]
fn soak_of_200_000_lines_at_5_percent_without_ok_after_resend() {
    soak(2, 195_840);
}

#[test]
fn soak_of_200_000_lines_at_5_percent_refusing_doubles() {
    soak(3, 195_840);
}

#[test]
fn soak_of_200_000_lines_at_5_percent_in_repetiers_words() {
    soak(4, 195_840);
}

#[test]
fn short_soaks_of_fifteen_seeds() {
    for seed in 0..15 {
        let program = program(MARLIN, &text(MARLIN, 1500));
        let (kind, quirks) = kinds()[seed as usize % 5].clone();
        let mut link = joined(&program, settings(MARLIN), quirks, Script::random(&SURVIVABLE, 0.05, seed));
        link.record();
        let outcome = link.run(Duration::from_secs(100_000));
        assert_eq!(outcome, Some(Outcome::Done), "seed {seed}, {kind}: {}", tail(&link, 40));
        assert_once_each(&program, &executed(&mut link));
    }
}

#[test]
fn a_wrong_baud_rate_is_told_from_a_mute_printer() {
    use trunnion::link::Sender;
    let program = program(MARLIN, &text(MARLIN, 5));
    let mut sender = Sender::new(program, settings(MARLIN));
    let mut now = Duration::ZERO;
    while sender.outcome().is_none() && now < Duration::from_secs(600) {
        sender.poll(now);
        let waiting = sender.pending().len();
        sender.took(waiting);
        sender.receive(now, b"\xf8\x80\xfe\x06\xe6\x98\n");
        now += Duration::from_millis(250);
    }
    assert_eq!(sender.outcome(), Some(&Outcome::Stopped(StopReason::Noise)));
}
