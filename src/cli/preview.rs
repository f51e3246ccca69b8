//! `trunnion preview`: one page for the browser.

use std::path::Path;
use std::process::{Command, Stdio};

use super::args::Preview as Verb;
use super::requests::{outputs, profile_file};
use super::{Console, Failure, plan};
use crate::document;
use crate::job::{self, Error, MachineSource, OutputFile, PlanRequest, PreviewRequest, PreviewResult, Source};
use crate::spelling::counted;

pub(super) fn run(args: &Verb, console: &Console) -> Result<(), Failure> {
    job::is_page("output", &args.output)?;
    let profile = args.plan_ref.profile.as_deref().and_then(profile_file);
    let read = [&args.file, &args.plan, &args.plan_ref.model, &profile];
    let mut outputs = outputs(read.into_iter().flatten().map(std::path::PathBuf::as_path));
    let output = outputs.claim(&args.output)?;
    let (shown, made) = shown(args, console)?;
    let bytes = write(&shown, &output, args.open, console)?;
    if console.json() {
        console.document(&document::previewed(&args.output.display().to_string(), bytes, &shown));
    }
    made?;
    let found = shown.report.as_ref().filter(|report| !report.is_clean());
    found.map_or(Ok(()), |report| {
        Err(Failure::Findings(format!("{}; the page shows them", counted(report.count(), "finding"))))
    })
}

/// What is to be shown, and whether the answer was yes.
fn shown(args: &Verb, console: &Console) -> Result<(PreviewResult, Result<(), Failure>), Failure> {
    let world = console.world();
    let Some(path) = &args.plan else {
        let machine = MachineSource::from(args.plan_ref.profile.as_deref().unwrap_or_default());
        let request = PlanRequest::new(args.file.as_deref().unwrap_or(Path::new("")), machine);
        return match job::plan(&request, &world) {
            Ok(made) => Ok((job::preview_plan(&made.plan.model.file, &made.plan), Ok(()))),
            Err(Error::NoPlan(no)) => {
                let shown = job::preview_no_plan(&no, &request.machine, None, &world)?;
                let no = Err(Error::NoPlan(no));
                // With --json there is one document, and that is the page's.
                Ok((shown, if console.json() { no.map_err(Failure::from) } else { plan::explained(no, None, console) }))
            }
            Err(error) => Err(error.into()),
        };
    };
    let plan = job::load_plan(&args.plan_ref.source(path), &world)?;
    let Some(file) = &args.file else { return Ok((job::preview_plan(&path.display().to_string(), &plan), Ok(()))) };
    Ok((job::preview(&PreviewRequest { program: &Source::from(file), plan: &plan }, &world)?, Ok(())))
}

/// Writes the page; how large it is.
pub(super) fn write(
    shown: &PreviewResult,
    output: &OutputFile,
    open: bool,
    console: &Console,
) -> Result<usize, Failure> {
    let page = document::page(shown);
    output.write(page.as_bytes())?;
    console.note(&format!("{}: {:.2} MB, open it in a browser", output.path().display(), page.len() as f64 / 1e6));
    if !shown.packed.has_text && shown.scene.program.is_some() {
        console.warning("the file's own lines would make the page too large, so they are not in it");
    }
    if open && !opened(output.path()) {
        console.warning("no browser could be started; open the page yourself");
    }
    Ok(page.len())
}

/// Hands the page to the desktop.
fn opened(page: &Path) -> bool {
    let program = if cfg!(windows) {
        "explorer"
    } else if cfg!(target_os = "macos") {
        "open"
    } else {
        "xdg-open"
    };
    let silent = || Stdio::null();
    Command::new(program).arg(page).stdin(silent()).stdout(silent()).stderr(silent()).spawn().is_ok()
}
