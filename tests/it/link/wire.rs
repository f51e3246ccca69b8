//! How much of a wire of 250,000 baud is used where the printer's receive buffer is small: a Marlin whose main loop takes time, behind an
//! adapter that takes some, too.
//!
//! The printer loses what finds its receive buffer full, so that a window which is too wide is seen: not one byte may be lost.

use std::time::Duration;

use trunnion::link::sim::{Quirks, SURVIVABLE, Script};
use trunnion::link::{Heading, Notice, Outcome, Protocol, SenderSettings};

use super::bench_machine::{assert_once_each, end, executed, joined, program, settings, tail};

const BAUD: u32 = 250_000;
const MARLIN: Protocol = Protocol::Marlin;

/// Lines of a tilted print in which X, Y, Z and E change, or X, Y and E as in a sliced layer; moves of no length to speak of.
fn text(axes: usize, lines: u32) -> String {
    let mut text = "G28\nM83\nM109 S200\nG1 X-100 Y-90 Z20 A31.125 C120.245 F12000\n".to_owned();
    for i in 0..lines {
        let t = f64::from(i) * 0.001;
        let (x, y, z, c) = (t - 100.0, 0.7 * t - 90.0, 20.0 + 0.2 * t, 120.245 + 0.001 * t);
        let e = 0.00411 + f64::from(i % 7) * 1e-5;
        text += &match axes {
            3 => format!("G1 X{x:.3} Y{y:.3} E{e:.5}\n"),
            4 => format!("G1 X{x:.3} Y{y:.3} Z{z:.3} E{e:.5}\n"),
            _ => format!("G1 X{x:.3} Y{y:.3} Z{z:.3} A{:.3} C{c:.3} E{e:.5}\n", 31.125 + 0.01 * t),
        };
    }
    text
}

/// A board behind an adapter: BUFSIZE 32, 128 bytes of receive buffer, a main loop of `loop_ms`, `latency_ms` each way.
fn board(advanced_ok: bool, loop_ms: f64, latency_ms: f64) -> Quirks {
    let ms = |v: f64| Duration::from_secs_f64(v / 1000.0);
    Quirks {
        baud: BAUD,
        advanced_ok,
        queue: 32,
        receive_buffer: 128,
        loop_time: ms(loop_ms),
        latency: ms(latency_ms),
        ..Quirks::of(MARLIN)
    }
}

struct Used {
    share: f64,
    lines_per_s: f64,
    bytes_a_line: f64,
    notes: Vec<String>,
}

/// How a print on such a board went.
struct Run {
    used: Used,
    resends: u32,
    lost: u32,
    seconds: f64,
}

fn run(text: &str, quirks: Quirks, settings: SenderSettings) -> Run {
    let program = program(MARLIN, text);
    let mut link = joined(&program, settings, quirks, Script::none());
    link.record();
    assert_eq!(end(&mut link), Outcome::Done);
    let recorded = link.recorded().to_vec();
    let out: Vec<_> = recorded.iter().filter(|(_, heading, _)| *heading == Heading::Out).collect();
    let lines = |from: usize, to: usize| -> usize {
        out[from..to].iter().map(|(_, _, b)| b.iter().filter(|b| **b == b'\n').count()).sum()
    };
    let (from, to) = (out.len() / 4, out.len() * 9 / 10);
    let span = (out[to].0 - out[from].0).as_secs_f64();
    let bytes: usize = out[from..to].iter().map(|(_, _, b)| b.len()).sum();
    let notes = link.events().iter().filter_map(|n| if let Notice::Note(t) = n { Some(t.clone()) } else { None });
    let used = Used {
        share: bytes as f64 * 10.0 / f64::from(BAUD) / span,
        lines_per_s: lines(from, to) as f64 / span,
        bytes_a_line: bytes as f64 / lines(from, to) as f64,
        notes: notes.collect(),
    };
    let seconds = link.now().as_secs_f64();
    let (resends, lost) = (link.sender.progress().resends, link.sim.overflowed());
    assert_once_each(&program, &executed(&mut link));
    Run { used, resends, lost, seconds }
}

fn wired() -> SenderSettings {
    SenderSettings { baud: BAUD, ..settings(MARLIN).with_buffers(128, 32) }
}

/// Every line once, and not a byte lost.
fn used(text: &str, quirks: Quirks, settings: SenderSettings) -> Used {
    let run = run(text, quirks, settings);
    assert_eq!((run.lost, run.resends), (0, 0), "{:?}", run.used.notes);
    run.used
}

fn told(words: &str, adapter_ms: f64, u: &Used) {
    crate::support::note(&format!(
        "{words}, adapter {adapter_ms} ms: {:.1} % of the wire, {:.0} lines/s of {:.1} bytes",
        u.share * 100.0,
        u.lines_per_s,
        u.bytes_a_line
    ));
}

/// What a window of 126 bytes carries where each answer costs the loop, its own bytes and the adapter twice; the printer's answers
/// come once a loop.
fn by_hand(bytes_a_line: f64, ok_bytes: f64, loop_ms: f64, latency_ms: f64) -> f64 {
    let per_ms = f64::from(BAUD) / 1e4;
    126.0 / (bytes_a_line + (ok_bytes / per_ms + loop_ms + 2.0 * latency_ms) * per_ms)
}

#[test]
fn a_small_receive_buffer_carries_most_of_the_wire() {
    for axes in [3, 4, 5] {
        let text = text(axes, 1500);
        for (advanced, ok_bytes) in [(false, 3.0), (true, 17.0)] {
            for latency in [0.5, 1.0, 2.0, 8.0] {
                let u = used(&text, board(advanced, 0.5, latency), wired());
                told(&format!("{axes} words, ADVANCED_OK {advanced}"), latency, &u);
                // An adapter to USB that answers in its frame of a millisecond leaves 94 % at least; a slow one what the window carries.
                let bound = by_hand(u.bytes_a_line, ok_bytes, 0.5, latency).min(1.0);
                // The end of a line that went in pieces waits for one answer more.
                assert!(u.share > bound * 0.85, "{} of {bound}", u.share);
                assert!(latency > 1.0 || u.share > if advanced { 0.94 } else { 0.99 }, "{}", u.share);
            }
        }
    }
}

/// Where the receive buffer is read sooner than the wire can fill it, only the queue counts.
#[test]
fn a_receive_buffer_that_is_read_in_time_carries_the_whole_wire_however_slow_the_adapter_is() {
    let stated = SenderSettings { reads: Duration::from_millis(5), ..wired() };
    for axes in [3, 5] {
        for latency in [1.0, 8.0, 16.0] {
            let u = used(&text(axes, 1500), board(true, 0.5, latency), stated.clone());
            told(&format!("{axes} words, reads_ms 5"), latency, &u);
            assert!(u.share > 0.95, "{}", u.share);
        }
    }
    // 5.1 ms of 25 bytes a millisecond are more than 126: then it says nothing.
    let slower = SenderSettings { reads: Duration::from_micros(5100), ..wired() };
    assert!(used(&text(5, 600), board(true, 0.5, 8.0), slower).share < 0.3);
}

/// A profile that states too much costs one line that goes out again, not the print.
#[test]
fn a_receive_buffer_that_is_not_read_in_time_loses_bytes_once_and_no_line() {
    let stated = SenderSettings { reads: Duration::from_millis(5), ..wired() };
    let done = run(&text(5, 1500), board(false, 20.0, 1.0), stated);
    assert!(done.lost > 0 && (1..=3).contains(&done.resends), "{} bytes lost, {} resends", done.lost, done.resends);
    assert!(done.used.notes.iter().any(|n| n.contains("reads_ms")), "{:?}", done.used.notes);
}

/// Moves that take time, then bursts of short ones: what the queue holds by then is what it gets through the burst with.
#[test]
fn what_the_queue_has_taken_makes_room_for_more() {
    let mut text = "G28\nM83\nM109 S200\nG1 X-100 Y0 Z20 A31.125 C120.245 F1200\n".to_owned();
    let mut x = -100.0;
    for i in 0..400 {
        // 20 ms each, then 2.5 ms each: 400 lines/s, which is more than a slow adapter carries.
        x += if i % 100 < 40 { 0.4 } else { 0.05 };
        text += &format!("G1 X{x:.3} Y0.001 E.00{}\n", 100 + i);
    }
    let with = |advanced| run(&text, board(advanced, 0.5, 16.0), wired());
    let (plain, told) = (with(false), with(true));
    assert_eq!((plain.lost, told.lost), (0, 0));
    let words = format!("bursts: {:.2} s, with ADVANCED_OK {:.2} s", plain.seconds, told.seconds);
    crate::support::note(&words);
    assert!(told.seconds < plain.seconds - 0.3, "{words}");
}

#[test]
fn what_holds_a_print_back_is_said() {
    let text = text(5, 1500);
    let says = |quirks: Quirks, settings: SenderSettings, words: &str| {
        let notes = used(&text, quirks, settings).notes;
        assert!(notes.iter().any(|n| n.contains("ran empty") && n.contains(words)), "{words}: {notes:?}");
    };
    says(board(true, 0.5, 4.0), wired(), "receive buffer of 126 bytes");
    says(board(true, 0.5, 0.2), wired(), "the link");
    let four = Quirks { queue: 4, ..board(true, 0.5, 8.0) };
    let reads = Duration::from_millis(5);
    says(four, SenderSettings { reads, ..wired() }, "queue of 4 commands");
    // A planner that is never dry has nothing to say.
    let slow = "G28\nG1 X0 Y0 Z20 F600\n".to_owned() + &"G1 X20 Y1\nG1 X0 Y0\n".repeat(60);
    let notes = used(&slow, board(true, 0.5, 1.0), wired()).notes;
    assert!(!notes.iter().any(|n| n.contains("ran empty")), "{notes:?}");
}

/// `B` tells BUFSIZE: a profile that states less or more is put right.
#[test]
fn the_queue_is_as_long_as_the_printer_says() {
    for stated in [4, 32, 64] {
        let settings = SenderSettings { baud: BAUD, ..settings(MARLIN).with_buffers(128, stated) };
        let u = used(&text(3, 600), board(true, 0.5, 1.0), settings);
        let said = u.notes.iter().any(|n| n.contains("32 commands (BUFSIZE)") && n.contains(&format!("not {stated} ")));
        assert_eq!(said, stated != 32, "{:?}", u.notes);
        assert!(u.share > 0.95, "{stated}: {}", u.share);
    }
}

/// Prusa's firmware forgets half a line after two seconds, and all of a receive buffer that has no byte left.
#[test]
fn a_firmware_that_drops_half_lines_gets_whole_ones() {
    let mut quirks = board(false, 0.5, 1.0);
    quirks.prusa();
    // Slow moves, so that lines wait for long.
    let text = "G28\nG1 X0 Y0 Z20 F300\n".to_owned()
        + &(0..60).map(|i| format!("G1 X{}.125 Y{}\n", i % 2 * 20, i)).collect::<String>();
    let program = program(MARLIN, &text);
    let mut link = joined(&program, wired(), quirks, Script::none());
    link.record();
    assert_eq!(end(&mut link), Outcome::Done);
    let back = |(_, heading, bytes): &(Duration, Heading, Vec<u8>)| (*heading == Heading::Back).then(|| bytes.clone());
    let said = String::from_utf8(link.recorded().iter().filter_map(back).flatten().collect()).unwrap();
    assert!(!said.contains("RX timeout") && !said.contains("Full RX"), "{said}");
    let out = |(_, heading, _): &&(Duration, Heading, Vec<u8>)| *heading == Heading::Out;
    assert!(link.recorded().iter().filter(out).all(|(_, _, bytes)| bytes.ends_with(b"\n")));
    assert_eq!(link.sender.progress().resends, 0);
    assert_once_each(&program, &executed(&mut link));
}

/// Faults of the wire while lines go out in pieces, or freely: every line once all the same.
#[test]
fn faults_on_a_narrow_wire_lose_and_double_nothing() {
    let text = text(5, 700);
    for seed in 1..=12 {
        for (advanced, reads) in [(false, 0), (true, 0), (true, 5)] {
            let program = program(MARLIN, &text);
            let settings = SenderSettings { reads: Duration::from_millis(reads), ..wired() };
            let quirks = board(advanced, 0.5, 1.0);
            let mut link = joined(&program, settings, quirks, Script::random(&SURVIVABLE, 0.01, seed));
            link.record();
            let outcome = end(&mut link);
            assert_eq!(outcome, Outcome::Done, "{seed}, {advanced}, {reads}:\n{}", tail(&link, 80));
            assert_once_each(&program, &executed(&mut link));
        }
    }
}
