//! `trunnion verify`

use std::path::Path;

use super::args::Verify as Verb;
use super::requests::outputs;
use super::{Console, Failure};
use crate::document::{self, text};
use crate::job::{
    self, CheckedPlan, Error, MachineSource, OutputFile, PrintError, RefereeRequest, Source, StrategyError, Verified,
    VerifyRequest,
};
use crate::spelling::counted;

pub(super) fn run(args: &Verb, console: &Console) -> Result<(), Failure> {
    let Some(path) = &args.plan else { return refereed(args, console) };
    let mut outputs = outputs([args.gcode.as_path(), path]);
    let certificate = args.certificate.as_deref().map(|path| outputs.claim(path)).transpose()?;
    let plan = job::load_plan(&args.plan_ref.source(path), &console.world()).map_err(Failure::from);
    if let Ok(plan) = &plan {
        plan.inputs().try_for_each(|path| outputs.reads(path))?;
    }
    let done = plan.and_then(|plan| work(args, &plan, certificate.as_ref(), console));
    if done.is_err() {
        uncertify(certificate.as_ref(), console)?;
    }
    done
}

/// A file without a plan: what it does on the machine.
fn refereed(args: &Verb, console: &Console) -> Result<(), Failure> {
    if args.plan_ref.model.is_some() {
        return Err(Failure::Usage(text::MODEL_NEEDS_A_PLAN.to_owned()));
    }
    let (program, machine) = (Source::from(&args.gcode), args.plan_ref.profile.as_deref().unwrap_or_default());
    let request = RefereeRequest { program: &program, machine: &MachineSource::from(machine) };
    let done = job::referee(&request, &console.world())?;
    if console.json() {
        console.document(&document::refereed(&done));
    } else {
        console.result(&text::refereed(&done.refereed));
    }
    match done.refereed.report.count() {
        0 => Ok(()),
        count => Err(Failure::Findings(counted(count, "finding"))),
    }
}

fn work(args: &Verb, plan: &CheckedPlan, certificate: Option<&OutputFile>, console: &Console) -> Result<(), Failure> {
    let world = console.world();
    let done = job::verify(&VerifyRequest { program: &Source::from(&args.gcode), plan }, &world)?;
    let other = done.of_another(&args.gcode.display().to_string(), plan);
    if console.json() {
        console.document(&document::verified(&done.report, done.seconds));
    } else if other.is_none() {
        console.result(&text::verified(&done.report));
    }
    if let Some(other) = other {
        let findings = counted(done.report.count(), "finding");
        return Err(Failure::Findings(format!("{other}; {findings} against this plan, which --json lists")));
    }
    certify(certificate, &args.gcode, &done.verified()?, plan)
}

/// Puts an earlier certificate aside; what is no certificate stays.
pub(super) fn uncertify(file: Option<&OutputFile>, console: &Console) -> Result<(), Failure> {
    let world = console.world();
    let is_one = |file: &&OutputFile| world.files.read(file.path()).is_ok_and(|bytes| document::is_certificate(&bytes));
    file.filter(is_one).map_or(Ok(()), |file| console.set_aside(file))
}

/// Writes what was proved of a program that is kept in `gcode`.
pub(super) fn certify(
    file: Option<&OutputFile>,
    gcode: &Path,
    program: &Verified<Vec<u8>>,
    plan: &CheckedPlan,
) -> Result<(), Failure> {
    let name = gcode.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    let made = file.and_then(|file| Some((file, document::certificate(&name, program, plan)?)));
    Ok(made.map_or(Ok(()), |(file, made)| file.write(format!("{made:#}\n").as_bytes()))?)
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
