//! `trunnion preview`: one page for the browser.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use super::args::Preview as Verb;
use super::requests::{outputs, profile_file};
use super::{Console, Failure, plan};
use crate::document;
use crate::job::{self, Error, OutputFile, PreviewResult};
use crate::spelling::counted;

pub(super) fn run(args: &Verb, console: &Console) -> Result<(), Failure> {
    job::is_page("output", &args.output)?;
    let profile = args.plan_ref.profile.as_deref().and_then(profile_file);
    let read = [&args.file, &args.plan, &args.plan_ref.model, &profile];
    let output = outputs(read.into_iter().flatten().map(PathBuf::as_path)).claim(&args.output)?;
    let shown = job::preview(&args.request(), &console.world())?;
    let bytes = write(&shown, &output, args.open, console)?;
    if console.json() {
        console.document(&document::previewed(&args.output.display().to_string(), bytes, &shown));
    }
    let found =
        shown.report.as_ref().filter(|report| !report.is_clean()).map(|report| counted(report.count(), "finding"));
    match (shown.no_plan, found) {
        (None, None) => Ok(()),
        (None, Some(count)) => Err(Failure::Findings(format!("{count}; the page shows them"))),
        // With --json there is one document, and that is the page's.
        (Some(no), _) if console.json() => Err(Error::NoPlan(no).into()),
        (Some(no), _) => plan::explained(Err(Error::NoPlan(no)), None, console),
    }
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
