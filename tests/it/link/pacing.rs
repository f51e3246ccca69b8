//! A serial wire of so many bits a second, in virtual time: it is kept full, and a file that needs less never starves.

use trunnion::link::sim::{Quirks, Script};
use trunnion::link::{Outcome, Protocol};

use super::bench_machine::{end, joined, program, settings};

const LINES: u32 = 3000;

/// Five-axis lines of `step` mm at `feed` mm/min.
fn text(step: f64, feed: u32) -> String {
    let mut text = format!("G28\nG1 X-120 Y50.125 Z20.205 A31.125 C120.245 F{feed}\n");
    for i in 0..LINES {
        let t = f64::from(i) * step;
        text += &format!("G1 X{:.3} Y50.125 Z20.205 A31.125 C120.245\n", t % 250.0 - 120.0);
    }
    text
}

/// Seconds on the wire, bytes sent, and how often the planner ran dry.
fn run(text: &str, baud: u32) -> (f64, usize, u32) {
    let program = program(Protocol::Marlin, text);
    let quirks = Quirks { baud, ..Quirks::of(Protocol::Marlin) };
    let mut link = joined(&program, settings(Protocol::Marlin), quirks, Script::none());
    link.record();
    assert_eq!(end(&mut link), Outcome::Done);
    let out = |h: &trunnion::link::Heading| *h == trunnion::link::Heading::Out;
    let stream: Vec<_> = link
        .recorded()
        .iter()
        .filter(|(_, h, b)| out(h) && b.len() > 30 && b.windows(2).any(|w| w == b"X-" || w[0] == b'X'))
        .collect();
    let span = stream[stream.len() - 1].0 - stream[1000].0;
    let bytes = stream[1001..].iter().map(|(_, _, b)| b.len()).sum();
    (span.as_secs_f64(), bytes, link.sim.starved())
}

#[test]
fn a_window_keeps_the_wire_full() {
    for baud in [115_200, 250_000] {
        // Moves of no length to speak of: only the wire takes time.
        let (seconds, bytes, _) = run(&text(0.001, 12_000), baud);
        let share = bytes as f64 * 10.0 / f64::from(baud) / seconds;
        crate::support::note(&format!("{baud} baud: {:.1} % of the wire", share * 100.0));
        assert!(share > 0.98, "{baud}: {share:.4} of the wire's limit");
    }
}

#[test]
fn a_file_that_needs_less_than_the_wire_carries_never_starves_the_planner() {
    for (baud, feed) in [(115_200, 6000), (250_000, 12_000)] {
        // 1 mm at 100 and 200 mm/s are 100 and 200 lines/s; the wire carries some 230 and 500 of these.
        let text = text(1.0, feed);
        let (paced, _, starved) = run(&text, baud);
        let (free, ..) = run(&text, 0);
        assert_eq!(starved, 0, "{baud}: {paced} {free}");
        assert!(paced < free * 1.01, "{baud}: {paced:.2} s instead of {free:.2} s");
    }
    // One that needs more: the planner slows down, since it must be able to stop at the end of what it has.
    let text = text(0.1, 3600);
    let ((paced, ..), (free, ..)) = (run(&text, 115_200), run(&text, 0));
    assert!(paced > free * 1.5, "{paced:.2} s, {free:.2} s");
}
