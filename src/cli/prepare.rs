//! `trunnion prepare`: the whole way, with one file at the end or none.

use std::path::PathBuf;

use serde_json::{Value, json};

use super::args::Prepare as Verb;
use super::requests::{outputs, profile_file};
use super::{Console, Failure, plan, send, slice, verify};
use crate::job::{self, Bar, Output, PrepareRequest, PrepareResult, Progress, Seconds, SendRequest, Step, World};
use crate::spelling::counted;
use crate::verify::Report;

pub(super) fn run(args: &Verb, console: &Console) -> Result<(), Failure> {
    let configs = args.slicing.slicer_config.iter().map(PathBuf::as_path);
    let profile = profile_file(&args.machine.profile);
    let read = [args.model.model.as_path()].into_iter().chain(profile.as_deref());
    let mut outputs = outputs(read.chain(configs));
    let output = outputs.claim(&args.output)?;
    let plan = args.plan_out.as_deref().map(|path| outputs.claim(path)).transpose()?;
    let journal = args.port.as_ref().map(|_| send::journal(&mut outputs, &args.output, &args.stream)).transpose()?;
    let done = work(args, &output, plan.as_ref(), console);
    if done.is_err() {
        console.set_aside(&output)?;
    }
    let done = done?;
    let (Some(port), Some(journal)) = (&args.port, journal) else { return Ok(()) };
    // A file that is proved stays, whatever becomes of the printer.
    let plan = &done.planned.plan;
    let (path, program, machine, options) = (&args.output, &done.gcode, &plan.machine, &args.stream.options());
    let request = SendRequest { path, program, machine, plan: Some(plan), options };
    send::stream(&request, (port, &journal), &args.stream, console)
}

fn work(args: &Verb, output: &Output, plan_out: Option<&Output>, console: &Console) -> Result<PrepareResult, Failure> {
    let request = PrepareRequest {
        model: args.model.source()?,
        machine: args.machine.source(),
        plan: args.plan.options()?,
        slicing: args.slicing.options(&args.bed)?,
    };
    let teller = Teller(console);
    let done = job::prepare(&request, &World { progress: &teller, ..console.world() });
    let done = match done {
        Err(job::Error::NoPlan(_)) => plan::explained(done, None, console)?,
        done => verify::explained(done, console)?,
    };
    if let Some(plan) = plan_out {
        plan.write(done.planned.plan.plan.to_text().as_bytes())?;
    }
    output.write(done.gcode.program())?;
    if let Some(report) = done.gcode.report() {
        console.note(&format!(
            "{}: {} lines, verified; about {:.0} min, clearance {:.2} mm",
            args.output.display(),
            done.gcode.program().iter().filter(|b| **b == b'\n').count(),
            report.seconds_print / 60.0,
            report.clearance_mm,
        ));
        if console.json() {
            console.document(&document(args, &done, report));
        }
    }
    Ok(done)
}

fn document(args: &Verb, done: &PrepareResult, report: &Report) -> Value {
    let Seconds { read, orient, plan, slice, rewrite, verify } = done.seconds;
    json!({
        "output": args.output.display().to_string(),
        "plan": plan::document(&done.planned),
        "verify": verify::document(report, verify),
        "slicer": {"name": done.slicer.name, "version": done.slicer.version},
        "left_out": slice::left_out(&done.flaws),
        "warnings": done.warnings,
        "seconds": {
            "read": read, "orient": orient, "plan": plan, "slice": slice, "rewrite": rewrite, "verify": verify,
        },
    })
}

/// The terminal, told step by step.
struct Teller<'a>(&'a Console);

impl Progress for Teller<'_> {
    fn warning(&self, text: &str) {
        self.0.warning(text);
    }

    fn begin(&self, what: &'static str, of: usize) -> Box<dyn Bar + '_> {
        self.0.begin(what, of)
    }

    fn reached(&self, step: Step<'_>) {
        match step {
            Step::Read(model) => {
                self.0.note(&format!("{} in {}", counted(model.model.parts.len(), "part"), model.file))
            }
            Step::Planned(made) => {
                plan::search(made, self.0);
                self.0.note(plan::text(made).trim_end());
            }
            Step::Sliced(done) => {
                let (prints, by) = (counted(done.sliced.len(), "print"), &done.slicer);
                self.0.note(&format!("{prints} sliced by {} {}", by.name, by.version));
            }
        }
    }
}
