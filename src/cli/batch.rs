//! A folder or a list of models: the same words for each, by a process of its own.

use super::args::{Args, OfMany, Verb, words_of_one};
use super::{Console, Failure};
use crate::document::{self, text};
use crate::job::{self, BatchRequest, MachineSource, Models, Share};

/// Does the verb for each model, if it was given many; `None` for one model.
pub(super) fn run(args: &Args, console: &Console) -> Option<Result<(), Failure>> {
    let given = args.of_many()?;
    match job::models_at(given.model) {
        Some(models) => Some(work(args, models, &given, console)),
        None => given.flags.any().then(|| Err(Failure::Usage(text::BATCH_FLAGS.to_owned()))),
    }
}

fn work(args: &Args, models: Models, given: &OfMany<'_>, console: &Console) -> Result<(), Failure> {
    let OfMany { model, machine, output, flags } = *given;
    let into = output.ok_or_else(|| Failure::Usage(text::batch_output(&models)))?.to_owned();
    let request = BatchRequest {
        models,
        machine: machine.map(MachineSource::from),
        share: flags.share.as_deref().map(Share::parse).transpose()?,
        words: words_of_one(std::env::args_os().skip(1), model).map_err(Failure::Usage)?,
        makes_files: matches!(args.verb, Verb::Prepare(_)),
        into,
        jobs: flags.jobs.map(usize::from),
        retry: flags.retry,
    };
    let told = |one: &job::Batched| match console.json() {
        true => console.result(&document::batched(one).to_string()),
        false => console.detail(&text::batched(one)),
    };
    let done = job::batch(&request, &told, &console.world())?;
    done.failed.iter().for_each(|(model, why)| console.warning(&format!("{}: {why}", model.display())));
    console.note(&text::batch(&done));
    if console.json() {
        console.result(&document::batch(&done).to_string());
    }
    if done.failed.is_empty() { Ok(()) } else { Err(Failure::Findings(text::batch_failed(&done))) }
}
