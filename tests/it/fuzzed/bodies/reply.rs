//! Bytes as a printer's answers to a host, and as a host's lines to the simulated printer.

use std::sync::Arc;
use std::time::Duration;

use trunnion::link::sim::{Quirks, Script, Sim};
use trunnion::link::{LineAssembler, Reply, Sender, Wording};

use super::choice;
use super::print::{model, prints};

/// The first byte chooses the machine, the second how many bytes come at a time and how long that takes.
pub(super) fn reply(data: &[u8]) {
    let Some((how, rest)) = choice(data) else { return };
    let Some((pace, bytes)) = choice(rest) else { return };
    let mut assembler = LineAssembler::default();
    assembler.push(bytes);
    while let Some(line) = assembler.next_line() {
        for wording in [Wording::Printer, Wording::Klipper, Wording::Grbl] {
            let _ = Reply::read(wording, line);
        }
    }
    let print = &prints()[usize::from(how) % prints().len()];
    let (count, step) = (1 + usize::from(pace % 32) * 4, Duration::from_millis(20 << (pace / 32)));
    let mut sender = Sender::new(Arc::clone(&print.program), print.settings.clone());
    let mut now = Duration::ZERO;
    for piece in bytes.chunks(count) {
        sender.poll(now);
        while sender.next_event().is_some() {}
        assert!(sender.pending().len() < 16_384, "{} bytes wait for the port", sender.pending().len());
        sender.took(usize::MAX / 2);
        now += step;
        sender.receive(now, piece);
    }
    let mut sim =
        Sim::new(print.protocol, model(print.profile), Quirks::of(print.protocol), Script::none()).without_log();
    let mut now = Duration::ZERO;
    for piece in bytes.chunks(count) {
        sim.receive(now, piece);
        now += step;
        sim.advance(now);
        let said = sim.pending().len();
        sim.took(said);
    }
}
