//! A print that is resumed on a bed that has cooled: somebody has to look at it first.

use std::sync::Arc;
use std::time::Duration;

use trunnion::link::sim::{Logged, Quirks, Script};
use trunnion::link::{Loopback, Outcome, Protocol, Sender, SenderSettings, StopReason};

use super::bench_machine::{end, joined, program, settings, text, without_padding};
use super::second_resume::Journal;

/// Of what the printer has carried out since it was asked last, whatever moves or heats.
fn moved(link: &mut Loopback) -> Vec<String> {
    let lines = link.sim.take_log().into_iter().filter_map(|(_, logged)| match logged {
        Logged::Accepted(block) => Some(without_padding(&String::from_utf8_lossy(&block))),
        _ => None,
    });
    lines
        .filter(|l| ["G0", "G1", "G28", "M104", "M109", "M140", "M190"].iter().any(|word| l.starts_with(word)))
        .collect()
}

/// A host is killed in the print, the bed is switched off for so long, and the next one resumes: how that ends, and what has moved by then.
fn resumed(off: Duration, bed_was_c: Option<f64>) -> (Outcome, Vec<String>) {
    let program = program(Protocol::Marlin, &text(Protocol::Marlin, 400));
    let mut link = joined(&program, settings(Protocol::Marlin), Quirks::of(Protocol::Marlin), Script::none());
    let mut journal = Journal::new();
    while link.sender.progress().acked < 200 {
        journal.step(&mut link);
    }
    let mut now = link.now() + Duration::from_secs(60);
    let mut sim = link.sim.clone();
    sim.advance(now);
    if !off.is_zero() {
        sim.receive(now, b"M140 S0\n");
        sim.advance(now);
    }
    now += off;
    sim.advance(now);
    sim.took(sim.pending().len());
    sim.take_log();
    let settings = SenderSettings { bed_was_c, ..settings(Protocol::Marlin) };
    let mut sender = Sender::resuming(Arc::clone(&program), settings, &journal.standing());
    sender.reconnected(now);
    let mut link = Loopback::resumed(sender, sim, now);
    let outcome = end(&mut link);
    (outcome, moved(&mut link))
}

#[test]
fn a_bed_that_has_cooled_is_looked_at_before_anything_moves() {
    // It falls below 50 C in 9 s: this printer is twenty times as fast as others.
    for (seconds, cold) in [(0, false), (3, false), (6, false), (12, true), (30, true), (3600, true)] {
        let (outcome, moved) = resumed(Duration::from_secs(seconds), Some(60.0));
        if cold {
            assert!(
                matches!(outcome, Outcome::Stopped(StopReason::Cooled { was_c: 60.0, .. })),
                "{seconds} s: {outcome:?}"
            );
            assert!(moved.is_empty(), "{seconds} s: {moved:?}");
        } else {
            assert_eq!(outcome, Outcome::Done, "{seconds} s");
        }
    }
    let (outcome, moved) = resumed(Duration::from_secs(3600), None);
    assert_eq!(outcome, Outcome::Done, "somebody has looked");
    assert!(moved.len() > 150, "{}", moved.len());
}
