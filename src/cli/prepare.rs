//! `trunnion prepare`: the whole way, with one file at the end or none.

use std::path::PathBuf;

use super::args::Prepare as Verb;
use super::requests::{folder_of, outputs, profile_file};
use super::{Console, Failure, plan, send, verify};
use crate::document;
use crate::job::{
    self, Bar, Cutting, OutputFile, Outputs, PlanOptions, PrepareRequest, PrepareResult, Progress, SendRequest, Step,
    World,
};
use crate::spelling::counted;

pub(super) fn run(args: &Verb, console: &Console) -> Result<(), Failure> {
    let configs = args.slicing.slicer_config.iter().map(PathBuf::as_path);
    let profile = profile_file(&args.machine.profile);
    let read = [args.model.model.as_path()].into_iter().chain(profile.as_deref());
    let mut outputs = outputs(read.chain(configs));
    let output = outputs.claim(&args.output)?;
    let plan = args.plan_out.as_deref().map(|path| outputs.claim(path)).transpose()?;
    let journal = args.port.as_ref().map(|_| send::journal(&mut outputs, &args.output, &args.stream)).transpose()?;
    let sheet = args.sheet.as_deref().map(|path| outputs.claim(path)).transpose()?;
    let parts = parts(args, &mut outputs)?;
    let done = work(args, &output, [plan, sheet, parts], console);
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

/// The right to write the parts of a model that is cut; none where that is not wanted, or where the model is such a file itself.
fn parts(args: &Verb, outputs: &mut Outputs) -> Result<Option<OutputFile>, Failure> {
    if args.split == "never" {
        return Ok(None);
    }
    match outputs.claim(&parts_file(args)) {
        Err(job::Error::Twice { .. }) => Ok(None),
        claimed => Ok(Some(claimed?)),
    }
}

fn parts_file(args: &Verb) -> PathBuf {
    args.output.with_extension("parts.3mf")
}

fn work(
    args: &Verb,
    output: &OutputFile,
    [plan_out, sheet, parts]: [Option<OutputFile>; 3],
    console: &Console,
) -> Result<PrepareResult, Failure> {
    let file = parts_file(args).display().to_string();
    let request = PrepareRequest {
        model: args.model.source()?,
        machine: args.machine.source(),
        plan: PlanOptions { kept_in: folder_of(args.plan_out.as_deref()), ..args.plan.options()? },
        slicing: args.slicing.options(&args.bed)?,
        cutting: parts.as_ref().map_or(Cutting::Never, |_| Cutting::Auto { file }),
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
    if let Some(sheet) = sheet {
        sheet.write(done.planned.sheet().as_bytes())?;
    }
    if let Some((cut, parts)) = done.cut.as_ref().zip(parts) {
        parts.write(&cut.bytes)?;
        let seconds = done.gcode.report().map_or(0.0, |report| report.seconds_print);
        console.note(&format!("{}; the parts are in {}", cut.story(seconds), cut.file));
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
            console.document(&document::prepared(&args.output.display().to_string(), &done, report));
        }
    }
    Ok(done)
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
