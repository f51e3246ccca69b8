//! `trunnion verify`

use std::fmt::Write;

use super::args::Verify as Verb;
use super::{Console, Failure};
use crate::document;
use crate::job::{self, Error, Source, VerifyRequest};
use crate::spelling::counted;
use crate::verify::Report;

pub(super) fn run(args: &Verb, console: &Console) -> Result<(), Failure> {
    let world = console.world();
    let plan = job::load_plan(&args.plan_ref.source(&args.plan), &world)?;
    let done = job::verify(&VerifyRequest { program: &Source::from(&args.gcode), plan: &plan }, &world)?;
    if console.json() {
        console.document(&document::verified(&done.report, done.seconds));
    } else {
        console.result(&text(&done.report));
    }
    done.verified().map(drop).map_err(Failure::from)
}

/// Where the program that was to be written has findings, prints them.
pub(super) fn explained<T>(done: Result<T, Error>, console: &Console) -> Result<T, Failure> {
    let Err(Error::Rejected(rejected)) = &done else { return Ok(done?) };
    if console.json() {
        console.document(&document::rejected(rejected));
    } else {
        console.note(&text(&rejected.report));
    }
    Err(Failure::Findings(format!("{rejected}; no file was written")))
}

fn text(report: &Report) -> String {
    let mut out = String::new();
    for f in &report.findings {
        let place = match (f.slot, f.part) {
            (Some(slot), Some(part)) => format!(" (slot {slot}, part {part})"),
            _ => String::new(),
        };
        let _ = writeln!(out, "line {}: {}{place}: {}", f.line, f.rule, f.text);
    }
    let minutes = report.seconds_print / 60.0;
    let _ = writeln!(
        out,
        "{} in {}, {:.0} mm of filament, about {minutes:.0} min, clearance {:.2} mm (line {}), {}",
        counted(report.moves, "move"),
        counted(report.slots, "slot"),
        report.filament_mm,
        report.clearance_mm,
        report.clearance_line,
        counted(report.count(), "finding")
    );
    out
}
