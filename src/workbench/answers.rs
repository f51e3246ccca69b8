//! What each address answers: the state is changed here, and jobs are started.

use std::io::Read;
use std::sync::Arc;

use serde_json::{Value, json};

use super::WorkbenchError;
use super::http::{HttpAnswer, RequestHead};
use super::project::{Stamp, Task};
use super::routes::{FILES, WebAsked, asked, kind_of};
use super::shared::Shared;
use super::{folder, runs, scene};
use crate::job::{Silent, World};

/// The policy of a preview in its frame: its own program, and nothing else; the frame is a site of its own.
const PREVIEW_POLICY: &str = "sandbox allow-scripts; default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; frame-ancestors 'self'";

/// What is sent back.
pub(super) enum WebReply {
    /// An answer as it is.
    Whole(HttpAnswer),
    /// The last one: the server ends behind it.
    Last(HttpAnswer),
    /// The head of this answer, and the file behind it.
    File(HttpAnswer, Box<dyn Read>, u64),
    /// The state, each time it changes.
    Events,
}

/// Answers a request.
///
/// # Errors
///
/// Why it is refused.
pub(super) fn answer(
    head: &RequestHead,
    body: &mut dyn Read,
    shared: &Arc<Shared>,
) -> Result<WebReply, WorkbenchError> {
    shared.doors.near(head)?;
    let asked = asked(head);
    if let Ok(WebAsked::Static(name)) = asked {
        return Ok(WebReply::Whole(page(name)));
    }
    // Whoever has no secret does not hear which addresses there are.
    shared.doors.known(head, matches!(asked, Ok(WebAsked::File(_))))?;
    let revision = head.value("revision");
    match asked? {
        WebAsked::Static(name) => return Ok(WebReply::Whole(page(name))),
        WebAsked::Events => {
            look(shared);
            return Ok(WebReply::Events);
        }
        WebAsked::File(name) => return file(&name, shared),
        WebAsked::Session => {
            let more = vec![("Set-Cookie", shared.doors.cookie())];
            return Ok(WebReply::Whole(HttpAnswer { more, ..HttpAnswer::json(&json!({})) }));
        }
        WebAsked::Whole => look(shared),
        WebAsked::Machines => return Ok(document(&shared.state().machines())),
        WebAsked::DrawnMachine => {
            let name = shared.state().project.machine.clone();
            let drawn = name.map_or(Value::Null, |name| scene::machine(&name, &World::here(&Silent)));
            return Ok(document(&drawn));
        }
        WebAsked::DrawnModel(index) => return model(index, shared),
        WebAsked::Upload(name) => {
            let name = folder::take(&shared.folder, &name, head.length, body)?;
            shared.with(|state| {
                state.project.add(&name);
                state.version += 1;
            });
            look(shared);
        }
        WebAsked::ProjectChange(change) => {
            shared.with(|state| state.seen(revision).and_then(|()| state.change(&change)))?;
            look(shared);
        }
        WebAsked::Run(task) => {
            look(shared);
            start(task, revision, shared)?;
        }
        WebAsked::JobWord(task, word) => shared.with(|state| state.word(task, word))?,
        WebAsked::Quit if shared.state().prints() => return Err(WorkbenchError::Printing),
        WebAsked::Quit => return Ok(WebReply::Last(HttpAnswer::json(&shared.state().document()))),
    }
    Ok(document(&shared.state().document()))
}

fn document(value: &Value) -> WebReply {
    WebReply::Whole(HttpAnswer::json(value))
}

fn page(name: &str) -> HttpAnswer {
    let text = FILES.iter().find(|(known, _)| *known == name).map_or("", |(_, text)| *text);
    HttpAnswer::of(kind_of(name), text)
}

/// A file that the project's jobs make: a preview in its own frame, everything else as a download.
fn file(name: &str, shared: &Shared) -> Result<WebReply, WorkbenchError> {
    let known = ["gcode", "plan.json", "html"]
        .iter()
        .filter_map(|end| shared.state().project.output(end))
        .any(|one| one == name);
    let (file, length) =
        if known { folder::result(&shared.folder, name)? } else { return Err(WorkbenchError::NotFound) };
    let (kind, header) = match name.ends_with(".html") {
        true => ("text/html; charset=utf-8", ("Content-Security-Policy", PREVIEW_POLICY.to_owned())),
        false => ("application/octet-stream", ("Content-Disposition", "attachment".to_owned())),
    };
    Ok(WebReply::File(HttpAnswer { more: vec![header], ..HttpAnswer::of(kind, Vec::new()) }, file, length))
}

fn model(index: usize, shared: &Shared) -> Result<WebReply, WorkbenchError> {
    let (path, unit, plate) = {
        let state = shared.state();
        let model = state.project.models.get(index).ok_or(WorkbenchError::NotFound)?;
        (model.path.clone(), state.project.unit.clone(), state.project.plate_of(index).to_owned())
    };
    Ok(match scene::model(&path, &unit, &plate, &World::here(&Silent)) {
        Ok(bytes) => WebReply::Whole(HttpAnswer::of("application/octet-stream", bytes)),
        Err(why) => document(&why),
    })
}

/// Looks at the files again, and has models inspected that are new or have changed.
pub(super) fn look(shared: &Arc<Shared>) {
    let (paths, machine) = {
        let state = shared.state();
        let paths: Vec<String> = state.project.models.iter().map(|model| model.path.clone()).collect();
        (paths, state.project.machine.clone())
    };
    let stamps: Vec<Stamp> =
        paths.iter().chain(&machine).map(|path| folder::stamp(&shared.folder.join(path))).collect();
    shared.with(|state| {
        let now: Vec<&String> = state.project.models.iter().map(|model| &model.path).collect();
        if now.iter().copied().eq(&paths) && state.project.restamp(&stamps) {
            state.version += 1;
        }
    });
    while let Some((path, words)) = shared.with(|state| {
        let index = state.project.next_to_inspect()?;
        Some((state.project.models[index].path.clone(), state.project.inspect(index)))
    }) {
        let shared = shared.clone();
        runs::aside(move || inspect(&path, &words, &shared));
    }
}

fn inspect(path: &str, words: &[String], shared: &Shared) {
    let (document, notes) = match runs::ask(&shared.folder, words) {
        Ok((_, out, notes)) => (serde_json::from_str(&out).ok(), notes),
        Err(source) => (Some(failed(&WorkbenchError::NotStarted { source })), Vec::new()),
    };
    let document = document.unwrap_or_else(|| failed(&WorkbenchError::Crashed));
    shared.with(|state| {
        state.version += 1;
        // Of a model that was asked about again meanwhile, the later answer is kept.
        let model = state.project.models.iter_mut().find(|model| model.path == path && model.asked);
        model.into_iter().for_each(|model| (model.inspected, model.notes) = (Some(document.clone()), notes.clone()));
    });
}

fn failed(error: &WorkbenchError) -> Value {
    json!({"error": error.to_string(), "code": error.code()})
}

fn start(task: Task, revision: &str, shared: &Arc<Shared>) -> Result<(), WorkbenchError> {
    let words = shared.with(|state| state.seen(revision).and_then(|()| state.begin(task)))?;
    let heard = shared.clone();
    // The state is held until the job is in it: it may end at once.
    let mut state = shared.state();
    let started =
        runs::start(&shared.folder, &words, task.prints(), move |said| heard.with(|state| state.hear(task, said)));
    match started {
        Ok(job) => state.jobs.insert(task, job),
        Err(source) => {
            state.runs.remove(&task);
            return Err(WorkbenchError::NotStarted { source });
        }
    };
    Ok(())
}

/// Looks at the project's files for the first time, and asks which machines there are.
pub(super) fn begin(shared: &Arc<Shared>) {
    look(shared);
    let shared = shared.clone();
    runs::aside(move || {
        let list = runs::ask(&shared.folder, &["profile".to_owned(), "list".to_owned()]);
        let list = list.ok().and_then(|(_, out, _)| serde_json::from_str(&out).ok());
        shared.with(|state| state.take_machines(list.unwrap_or(Value::Null)));
    });
}
