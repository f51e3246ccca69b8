//! `trunnion plan`

use std::path::{Path, PathBuf};

use super::args::Plan as Verb;
use super::requests::{folder_of, outputs, profile_file, supporting};
use super::{Console, Failure, why};
use crate::document::{self, text};
use crate::job::{self, Error, FileError, OutputFile, PictureFile, PlanRequest, PlanResult, StrategyError};
use crate::planning::TimeSlot;

pub(super) fn run(args: &Verb, console: &Console) -> Result<(), Failure> {
    let profile = profile_file(&args.machine.profile);
    let models = args.arrange.files(&args.model.model);
    let mut outputs = outputs(models.iter().map(PathBuf::as_path).chain(profile.as_deref()));
    let output = args.output.as_deref().map(|path| outputs.claim(path)).transpose()?;
    let parts_file = args.output.as_deref().map(parts_file);
    let parts = parts_file.as_deref().map(|path| outputs.claim_unless_taken(path)).transpose()?.flatten();
    let picture = PictureFile::claim("sheet", args.sheet.as_deref(), &mut outputs)?;
    let mut options = args.plan.options(&args.pass)?;
    options.plans = args.top.unwrap_or(1);
    options.kept_in = folder_of(args.output.as_deref());
    let (model, arrangement) = args.arrange.request(&args.model.model, &args.model.read, parts_file.as_deref())?;
    let request = PlanRequest {
        model,
        machine: args.machine.source(),
        arrangement,
        options,
        supporting: supporting(&args.supports, &args.plan)?,
    };
    if args.all {
        return list(&request, args.limit, console);
    }
    let made = explained(job::plan(&request, &console.world()).map_err(Error::from), picture.as_ref(), console)?;
    told(&made, console);
    search(&made, console);
    if let (Some(arranged), Some(path)) = (&made.arranged, parts_file.as_deref()) {
        write_parts(path, parts.as_ref(), &arranged.bytes, console)?;
    }
    if let Some(output) = &output {
        output.write(made.plan.plan.to_text().as_bytes())?;
    }
    if let Some(picture) = &picture {
        picture.write(&made.sheet())?;
    }
    if console.json() {
        console.document(&document::planned(&made));
    } else {
        console.summary(&text::planned(&made), args.output.is_some());
        if args.top.is_some() {
            console.result(&text::comparison(&made));
        }
    }
    Ok(())
}

/// The file beside `output` for a model that is not as it was read: `OUT.parts.3mf`.
pub(super) fn parts_file(output: &Path) -> PathBuf {
    output.with_extension("parts.3mf")
}

/// Writes it.
pub(super) fn write_parts(
    path: &Path,
    file: Option<&OutputFile>,
    bytes: &[u8],
    console: &Console,
) -> Result<(), Failure> {
    let what = "an input, and would be overwritten";
    file.ok_or_else(|| FileError::Twice { path: path.to_owned(), what })?.write(bytes)?;
    console.note(&format!("the model as printed is in {}", path.display()));
    Ok(())
}

/// What was done to the model before.
pub(super) fn told(made: &PlanResult, console: &Console) {
    made.arranged.iter().flat_map(|arranged| &arranged.changes).for_each(|change| console.note(change));
}

/// Where there is no plan, says why, and what would help.
pub(super) fn explained<T>(
    done: Result<T, Error>,
    picture: Option<&PictureFile>,
    console: &Console,
) -> Result<T, Failure> {
    if let Err(Error::Strategy(StrategyError::NoPlan(no))) = &done {
        why::explain(no, picture, console)?;
    }
    Ok(done?)
}

/// How the search went.
pub(super) fn search(made: &PlanResult, console: &Console) {
    text::moved(made).iter().for_each(|moved| console.note(moved));
    console.detail(&text::searched(made));
}

/// `--all`: every sequence, as it is found.
fn list(request: &PlanRequest, most: usize, console: &Console) -> Result<(), Failure> {
    let (mut listed, mut ups): (Vec<Vec<TimeSlot>>, Vec<[f64; 3]>) = Default::default();
    let done = job::sequences(request, most, &console.world(), |up, slots| {
        if console.json() {
            listed.push(slots);
            ups.extend(up);
        } else {
            console.result(&text::sequence(up, &slots));
        }
    })?;
    if console.json() {
        console.document(&document::sequences(&listed, &ups, &done));
    } else {
        console.note(&text::listed(&done));
    }
    Ok(())
}
