//! `trunnion preview`: one page for the browser.

use std::path::PathBuf;

use super::args::Preview as Verb;
use super::requests::{outputs, profile_file};
use super::{Console, Failure, plan};
use crate::document::{self, text};
use crate::job::{self, Error, OutputFile, PreviewResult, StrategyError};
use crate::spelling::counted;
use crate::verify::Report;

pub(super) fn run(args: &Verb, console: &Console) -> Result<(), Failure> {
    job::is_page("output", &args.output)?;
    let profile = args.plan_ref.profile.as_deref().and_then(profile_file);
    let files: Vec<_> = args.files().chain(profile).collect();
    let output = outputs(files.iter().map(PathBuf::as_path)).claim(&args.output)?;
    let world = console.world();
    let two = args.requests().iter().map(|one| job::preview(one, &world)).collect::<Result<Vec<_>, _>>()?;
    if let [one, other] = &two[..] {
        let bytes = put(&document::page_of_two([one, other]), &output, args.open, console)?;
        if console.json() {
            console.document(&document::compared(&args.output.display().to_string(), bytes, [one, other]));
        }
        return found(&two);
    }
    let shown = job::preview(&args.request()?, &world)?;
    let bytes = write(&shown, &output, args.open, console)?;
    if console.json() {
        console.document(&document::previewed(&args.output.display().to_string(), bytes, &shown));
    }
    match shown.no_plan {
        None => found(&[shown]),
        // With --json there is one document, and that is the page's.
        Some(no) if console.json() => Err(Error::from(StrategyError::NoPlan(no)).into()),
        Some(no) => plan::explained(Err(StrategyError::NoPlan(no).into()), None, console),
    }
}

/// Findings are the exit code's, whatever is shown.
fn found(shown: &[PreviewResult]) -> Result<(), Failure> {
    let count: usize = shown.iter().filter_map(|one| one.report.as_ref()).map(Report::count).sum();
    let text = || format!("{}; the page shows them", counted(count, "finding"));
    if count == 0 { Ok(()) } else { Err(Failure::Findings(text())) }
}

/// Writes the page; how large it is.
pub(super) fn write(
    shown: &PreviewResult,
    output: &OutputFile,
    open: bool,
    console: &Console,
) -> Result<usize, Failure> {
    if !shown.packed.has_text && shown.scene.program.is_some() {
        console.warning(text::WITHOUT_LINES);
    }
    put(&document::page(shown), output, open, console)
}

fn put(page: &str, output: &OutputFile, open: bool, console: &Console) -> Result<usize, Failure> {
    output.write(page.as_bytes())?;
    console.note(&format!("{}: {:.2} MB, open it in a browser", output.path().display(), page.len() as f64 / 1e6));
    if open && !job::open_in_browser(output.path()) {
        console.warning("cannot start a browser; open the page yourself");
    }
    Ok(page.len())
}
