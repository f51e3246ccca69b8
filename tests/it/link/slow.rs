//! A printer that is slower than anybody expects says "done" by its deeds: the host ends when the last move has ended, and not before.

use std::sync::Arc;
use std::time::Duration;

use trunnion::link::sim::{Logged, Quirks, Script, Sim};
use trunnion::link::{Outcome, Protocol, Sender};

use super::bench_machine::{joined, program, settings, text_at, without_padding};
use crate::support::note;

/// No conversation takes as long.
const BOUND: Duration = Duration::from_secs(40 * 3600);

/// What a host makes of a printer that is so many times slower than it should be: how it ended, and what was carried out by then and all in all.
fn ended(protocol: Protocol, times: u32, quirks: Quirks, feed: u32) -> (Outcome, usize, usize) {
    // A few lines, and a last move that takes a while.
    let text = text_at(protocol, 12, feed) + &format!("G1 X-140 Y-100 F{}\nG1 X140 F{}\nM84\n", feed / 4, feed / 4);
    let program = program(protocol, &text);
    let mut sim = joined(&program, settings(protocol), quirks, Script::none()).sim;
    let mut sender = Sender::new(Arc::clone(&program), settings(protocol));
    let begun = if protocol == Protocol::Grbl { Duration::from_secs(30) } else { Duration::ZERO };
    // The printer's clock.
    let its = |now: Duration| begun + now / times;
    let mut now = Duration::ZERO;
    while now < BOUND {
        sim.advance(its(now));
        sender.poll(now);
        while sender.next_event().is_some() {}
        let out = sender.pending().to_vec();
        sender.took(out.len());
        sim.receive(its(now), &out);
        let back = sim.pending().to_vec();
        sim.took(back.len());
        sender.receive(now, &back);
        if let (Some(outcome), true) = (sender.outcome().cloned(), sender.pending().is_empty()) {
            let done = carried_out(&mut sim);
            sim.advance(its(now + Duration::from_secs(3600) * times));
            return (outcome, done, done + carried_out(&mut sim));
        }
        if out.is_empty() && back.is_empty() {
            let printer =
                sim.next_wake().map(|at| (at.saturating_sub(begun) * times).max(now + Duration::from_millis(1)));
            let wakes = [sender.wake(now), printer].into_iter().flatten().filter(|at| *at > now).min();
            now = wakes.unwrap_or(now + Duration::from_secs(1));
        }
    }
    panic!("no end")
}

/// Lines of the file and waits for the end of all moves that were carried out.
fn carried_out(sim: &mut Sim) -> usize {
    let of_ours = |block: &[u8]| {
        let line = without_padding(&String::from_utf8_lossy(block));
        !["M105", "M110", "M115"].iter().any(|own| line.starts_with(own))
    };
    sim.take_log().iter().filter(|(_, logged)| matches!(logged, Logged::Accepted(block) if of_ours(block))).count()
}

#[test]
fn done_is_said_when_the_last_move_has_ended() {
    let mut told = Vec::new();
    for (protocol, busy) in [(Protocol::Marlin, true), (Protocol::Marlin, false), (Protocol::RepRapFirmware, true)] {
        for times in [1, 2, 5, 10, 20, 50] {
            for feed in [1800, 600, 200] {
                let quirks = Quirks { busy, ..Quirks::of(protocol) };
                let (outcome, by_then, all) = ended(protocol, times, quirks, feed);
                match outcome {
                    Outcome::Done => {
                        assert_eq!(by_then, all, "{protocol:?}, busy {busy}, {times} times slower, F{feed}");
                        told.push(1);
                    }
                    // It has said that it does not know.
                    Outcome::Stopped(_) => told.push(0),
                    other => panic!("{other:?}"),
                }
            }
        }
    }
    let done: usize = told.iter().sum();
    note(&format!("{done} of {} prints ended, no one early", told.len()));
    assert!(done >= 18, "{told:?}");
}
