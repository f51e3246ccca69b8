//! `trunnion rewrite`: offline, or as a slicer's post-processing script.
//!
//! As a script the file is the last argument and is changed in place. A slicer may ignore our exit code and keep the file
//! (PrusaSlicer's command line and Slic3r do), so that on failure the file itself is made unprintable.

use std::path::PathBuf;

use serde_json::json;

use super::args::Rewrite as Verb;
use super::requests::outputs;
use super::verify::explained;
use super::{Console, Failure};
use crate::document;
use crate::job::{self, CheckedPlan, RewriteRequest, RewriteResult, Source};

pub(super) fn run(args: &Verb, console: &Console) -> Result<(), Failure> {
    let [target] = (if args.in_place { &args.files[..] } else { args.output.as_slice() }) else {
        return Err(Failure::Usage(format!("--in-place takes one file, not {}", args.files.len())));
    };
    let sources = if args.in_place { &[] } else { &args.files[..] };
    let mut outputs = outputs(sources.iter().map(PathBuf::as_path).chain([args.plan.as_path()]));
    let target = outputs.claim(target)?;
    let loaded = job::load_plan(&args.plan_ref.source(&args.plan), &console.world()).map_err(Failure::from);
    if let Ok(loaded) = &loaded {
        loaded.inputs().try_for_each(|path| outputs.reads(path))?;
    }
    let done = loaded.and_then(|loaded| work(args, &loaded, console)).and_then(|done| {
        target.write(done.gcode.program())?;
        Ok(done)
    });
    match done {
        Ok(done) => {
            if let (true, Some(report)) = (console.json(), done.gcode.report()) {
                console.document(&json!({"verify": document::verified(report, done.verify_seconds)}));
            }
            Ok(())
        }
        Err(failure) => {
            if args.in_place {
                target.spoil(unprintable(&failure).as_bytes())?;
            } else {
                console.set_aside(&target)?;
            }
            Err(failure)
        }
    }
}

fn work(args: &Verb, plan: &CheckedPlan, console: &Console) -> Result<RewriteResult, Failure> {
    let sliced = args.files.iter().map(Source::from).collect();
    let request = RewriteRequest { plan, sliced, print: args.print, bed_mm: args.bed.size()? };
    explained(job::rewrite(&request, &console.world()), console)
}

/// A file that any printer takes and no printer moves on.
fn unprintable(failure: &Failure) -> String {
    let reason = failure.to_string().replace(['\n', '\r'], " ");
    format!("; trunnion: not printable, nothing was rewritten\n; {reason}\nM117 trunnion: not printable\n")
}
