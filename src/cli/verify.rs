//! `trunnion verify`

use super::args::Verify as Verb;
use super::{Console, Failure};
use crate::document::{self, text};
use crate::job::{self, Error, PrintError, Source, StrategyError, VerifyRequest};
use crate::spelling::counted;

pub(super) fn run(args: &Verb, console: &Console) -> Result<(), Failure> {
    let world = console.world();
    let plan = job::load_plan(&args.plan_ref.source(&args.plan), &world)?;
    let done = job::verify(&VerifyRequest { program: &Source::from(&args.gcode), plan: &plan }, &world)?;
    let other = done.of_another(&args.gcode.display().to_string(), &plan);
    if console.json() {
        console.document(&document::verified(&done.report, done.seconds));
    } else if other.is_none() {
        console.result(&text::verified(&done.report));
    }
    if let Some(other) = other {
        let findings = counted(done.report.count(), "finding");
        return Err(Failure::Findings(format!("{other}; {findings} against this plan, which --json lists")));
    }
    done.verified().map(drop).map_err(Failure::from)
}

/// Where the program that was to be written has findings, prints them.
pub(super) fn explained<T>(done: Result<T, Error>, console: &Console) -> Result<T, Failure> {
    if let (Err(Error::Strategy(StrategyError::NoWay(no))), true) = (&done, console.json()) {
        console.document(&document::no_way(no));
    }
    let Err(Error::Print(PrintError::Rejected(rejected))) = &done else { return Ok(done?) };
    if console.json() {
        console.document(&document::rejected(rejected));
    } else {
        console.note(&text::verified(&rejected.report));
        text::ways(&rejected.ways).lines().for_each(|line| console.note(line));
    }
    Err(Failure::Findings(format!("{rejected}; no file was written")))
}
