//! `trunnion rewrite`: offline, or as a slicer's post-processing script.
//!
//! As a script the file is the last argument and is changed in place. A slicer may ignore our exit code and keep the file
//! (PrusaSlicer's command line and Slic3r do), so that on failure the file itself is made unprintable.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use super::args::Rewrite as Verb;
use super::requests::outputs;
use super::verify::explained;
use super::{Console, Failure};
use crate::document::{self, text};
use crate::gcode::marks::finished_by;
use crate::job::{self, CheckedPlan, Error, RewriteRequest, RewriteResult, Source};
use crate::spelling;

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
    if let (true, Ok(loaded)) = (args.in_place, &loaded) {
        // The slicer's window may call its scripts for a file of an earlier call; what is finished is left as it is either way.
        if job::is_finished(&Source::from(&args.files[0]), loaded, &console.world())? {
            console.note(&format!("{}: already rewritten by this plan; left unchanged", args.files[0].display()));
            if console.json() {
                console.document(&document::left_alone());
            }
            return Ok(());
        }
    }
    let done = loaded.and_then(|loaded| work(args, &loaded, console)).and_then(|done| {
        target.write(done.gcode.program())?;
        Ok(done)
    });
    match done {
        Ok(done) => {
            if let (true, Some(report)) = (console.json(), done.gcode.report()) {
                console.document(&document::rewritten(report, done.verify_seconds));
            }
            Ok(())
        }
        Err(failure) => {
            if args.in_place {
                target.spoil(text::unprintable(&failure.to_string()).as_bytes())?;
            } else {
                console.set_aside(&target)?;
            }
            Err(failure)
        }
    }
}

/// What a script's line with a mistake in it names is made unprintable too: the slicer's own file is still upright, and a slicer may
/// go on as if nothing had happened. Only a line of this verb with the flag, however misspelt, and only its last word.
pub(super) fn spoil_unparsed(words: impl Iterator<Item = OsString>) {
    let words: Vec<OsString> = words.collect();
    let is = |word: &OsString, wanted: &str, off: usize| {
        let text = word.to_string_lossy();
        spelling::nearest(&text, [wanted]).is_some_and(|(edits, _)| edits <= off)
    };
    let asked = words.iter().any(|w| is(w, "rewrite", 2)) && words.iter().any(|w| is(w, "--in-place", 3));
    let Some(file) = words.last().filter(|_| asked).map(Path::new).filter(|path| path.is_file()) else { return };
    let finished = std::fs::read(file).is_ok_and(|bytes| finished_by(&bytes).is_some());
    let is_sliced = !["json", "toml"].iter().any(|end| file.extension().is_some_and(|e| e.eq_ignore_ascii_case(end)));
    if is_sliced && !finished {
        let failure = Failure::Usage("the script's command line cannot be parsed".to_owned());
        let _ =
            outputs([]).claim(file).and_then(|target| target.spoil(text::unprintable(&failure.to_string()).as_bytes()));
    }
}

fn work(args: &Verb, plan: &CheckedPlan, console: &Console) -> Result<RewriteResult, Failure> {
    let sliced = args.files.iter().map(Source::from).collect();
    let request = RewriteRequest { plan, sliced, print: args.print, bed: job::bed(&args.bed.bed)? };
    explained(job::rewrite(&request, &console.world()).map_err(Error::from), console)
}
