//! `trunnion prepare`: the whole way, in memory, with one file at the end or none.

use std::path::{Path, PathBuf};
use std::time::Instant;

use serde_json::{Value, json};

use super::args::Prepare as Verb;
use super::files::Scratch;
use super::rewrite::{finish, read_prints};
use super::slice::{Prints, choose};
use super::{Console, Failure, files, load, plan, send};
use crate::planning::{Workpiece, sha256_hex};
use crate::toolpath::{Input, Segment, SlicedError};

pub(super) fn run(args: &Verb, console: &Console) -> Result<(), Failure> {
    let configs = args.slicing.slicer_config.iter().map(PathBuf::as_path);
    let inputs: Vec<&Path> =
        [args.model.model.as_path(), Path::new(&args.machine.profile)].into_iter().chain(configs).collect();
    files::check_output(&args.output, &inputs)?;
    if let Some(plan) = &args.plan_out {
        files::check_output(plan, &inputs)?;
        if *plan == args.output {
            return Err(Failure::Usage(format!("{} is both the output and the plan; give two names", plan.display())));
        }
    }
    let done = work(args, console);
    // A file that is proved stays, whatever becomes of the printer.
    let unproved = done.as_ref().is_err_and(|failure| !matches!(failure, Failure::Printer(_) | Failure::Port(_)));
    if unproved && let Some(aside) = files::set_aside(&args.output) {
        console.warning(&format!("the file of an earlier run is now {}", aside.display()));
    }
    done
}

fn work(args: &Verb, console: &Console) -> Result<(), Failure> {
    let mut clock = Clock::default();
    let machine = load::machine(&args.machine)?;
    let bed = load::bed(&args.bed)?;
    let model = load::model(&args.model, console)?;
    clock.lap("read");
    console.note(&format!("{} parts in {}", model.model.parts.len(), args.model.model.display()));
    let scratch = Scratch::new()?;
    let slicer = choose(&args.slicing, &scratch)?;
    let made = plan::make(&model, &machine, &args.plan, &plan::Wanted { plans: 1, sheet: None }, console)?;
    clock.lap("plan");
    clock.split("plan", "orient", made.orient_seconds);
    console.note(made.text(&machine).trim_end());
    let plan_text = made.plan.to_text();
    let workpiece = Workpiece::place(&model.model, &made.plan.placement);
    let prints = Prints::of(&made.plan, &workpiece, &machine.profile, bed);
    let sliced = prints.slice(slicer.as_ref(), &machine.profile, bed, console)?;
    clock.lap("slice");
    console.note(&format!("{} prints sliced by {} {}", sliced.len(), slicer.name(), slicer.version()));
    let segments = read_all(&sliced, &prints.names)?;
    let inputs: Vec<Input<'_>> = segments
        .iter()
        .enumerate()
        .map(|(print, segment)| Input {
            print,
            centre_mm: [bed[0] / 2.0, bed[1] / 2.0],
            file: &prints.names[print],
            bytes: &sliced[print],
            sliced: &segment.sliced,
        })
        .collect();
    let (gcode, proof) =
        finish(&inputs, &made.plan, &sha256_hex(plan_text.as_bytes()), &machine.profile, &workpiece, console)?;
    clock.lap("rewrite");
    if let Some(path) = &args.plan_out {
        files::write(path, plan_text.as_bytes())?;
    }
    files::write(&args.output, &gcode)?;
    let verify = &proof["verify"];
    let verify_seconds = verify["seconds"].as_f64().unwrap_or(0.0);
    clock.split("rewrite", "verify", verify_seconds);
    console.note(&format!(
        "{}: {} lines, verified; about {:.0} min, clearance {:.2} mm",
        args.output.display(),
        gcode.iter().filter(|b| **b == b'\n').count(),
        verify["seconds_print"].as_f64().unwrap_or(0.0) / 60.0,
        verify["clearance_mm"].as_f64().unwrap_or(0.0),
    ));
    let document = json!({
        "output": args.output.display().to_string(),
        "plan": made.document(),
        "verify": verify,
        "slicer": {"name": slicer.name(), "version": slicer.version()},
        "seconds": clock.document(),
    });
    if console.json() {
        console.document(&document);
    }
    let Some(port) = &args.port else { return Ok(()) };
    let (plan, workpiece) = (Some(&made.plan), Some(&workpiece));
    let job = send::Job { path: &args.output, bytes: &gcode, machine: &machine, plan, workpiece };
    send::stream(&job, port, &args.stream, console)
}

/// One print a file.
fn read_all(sliced: &[Vec<u8>], names: &[String]) -> Result<Vec<Segment>, Failure> {
    let mut segments = Vec::new();
    for (bytes, name) in sliced.iter().zip(names) {
        let found = read_prints(bytes, name)?;
        segments.push(found.into_iter().next().ok_or_else(|| SlicedError::NoExtrusion { file: name.clone() })?);
    }
    Ok(segments)
}

/// Seconds of each step.
struct Clock {
    last: Instant,
    laps: Vec<(&'static str, f64)>,
}

impl Default for Clock {
    fn default() -> Self {
        Self { last: Instant::now(), laps: vec![("read", 0.0), ("orient", 0.0)] }
    }
}

impl Clock {
    fn lap(&mut self, name: &'static str) {
        let seconds = self.last.elapsed().as_secs_f64();
        self.last = Instant::now();
        self.add(name, seconds);
    }

    fn add(&mut self, name: &'static str, seconds: f64) {
        match self.laps.iter_mut().find(|(n, _)| *n == name) {
            Some((_, sum)) => *sum += seconds,
            None => self.laps.push((name, seconds)),
        }
    }

    /// `seconds` of lap `from` were `to`'s.
    fn split(&mut self, from: &'static str, to: &'static str, seconds: f64) {
        self.add(from, -seconds);
        self.add(to, seconds);
    }

    fn document(&self) -> Value {
        let laps = self.laps.iter().map(|(name, seconds)| ((*name).to_owned(), json!(seconds.max(0.0))));
        Value::Object(laps.collect())
    }
}
