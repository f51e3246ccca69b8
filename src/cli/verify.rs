//! `trunnion verify`

use std::fmt::Write;
use std::time::Instant;

use serde_json::{Value, json};

use super::args::Verify as Verb;
use super::{Console, Failure, files, load};
use crate::planning::{Plan, Workpiece};
use crate::profile::Profile;
use crate::verify::{Job, Report, verify};

pub(super) fn run(args: &Verb, console: &Console) -> Result<(), Failure> {
    let loaded = load::plan(&args.plan, &args.plan_ref, console)?;
    let bytes = files::read(&args.gcode)?;
    let workpiece = loaded.workpiece();
    let start = Instant::now();
    let report = verify(&bytes, &Job { profile: &loaded.machine.profile, plan: &loaded.plan, workpiece: &workpiece });
    let seconds = start.elapsed().as_secs_f64();
    if console.json() {
        console.document(&document(&report, seconds));
    } else {
        console.result(&text(&report));
    }
    if report.is_clean() { Ok(()) } else { Err(Failure::Findings(summary(&report))) }
}

/// Verifies a file that is about to be written; findings are printed and fail.
pub(super) fn prove(
    bytes: &[u8],
    plan: &Plan,
    profile: &Profile,
    workpiece: &Workpiece<'_>,
    console: &Console,
) -> Result<(Report, f64), Failure> {
    let start = Instant::now();
    let report = verify(bytes, &Job { profile, plan, workpiece });
    let seconds = start.elapsed().as_secs_f64();
    if report.is_clean() {
        return Ok((report, seconds));
    }
    if console.json() {
        console.document(&json!({"verify": document(&report, seconds)}));
    } else {
        console.note(&text(&report));
    }
    Err(Failure::Findings(format!("{}; no file was written", summary(&report))))
}

fn summary(report: &Report) -> String {
    let first = report.findings.first().map_or(String::new(), |f| format!(": line {}: {}", f.line, f.text));
    format!("{} findings{first}", report.count())
}

pub(super) fn document(report: &Report, seconds: f64) -> Value {
    json!({
        "findings": report.findings,
        "clearance_mm": report.clearance_mm,
        "clearance_line": report.clearance_line,
        "moves": report.moves,
        "slots": report.slots,
        "filament_mm": report.filament_mm,
        "seconds_print": report.seconds_print,
        "seconds": seconds,
    })
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
        "{} moves in {} slots, {:.0} mm of filament, about {minutes:.0} min, clearance {:.2} mm (line {}), {} findings",
        report.moves,
        report.slots,
        report.filament_mm,
        report.clearance_mm,
        report.clearance_line,
        report.count()
    );
    out
}
