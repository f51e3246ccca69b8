//! What each address answers: the state is changed here, and jobs are started.

use std::collections::BTreeMap;
use std::io::Read;
use std::sync::Arc;

use serde_json::{Value, json};

use super::WorkbenchError;
use super::choices::{Choices, ChosenModel, ENDINGS};
use super::doors::{is_plain, is_project, shown};
use super::folder::Saving;
use super::http::{HttpAnswer, RequestHead};
use super::project::{CutAnswer, ProjectChange, Stamp};
use super::routes::{FILES, WebAsked, asked, kind_of};
use super::runs::Lent;
use super::shared::Shared;
use super::state::Saved;
use super::task::PrinterTask;
use super::{folder, runs, scene};
use crate::job::{Silent, World};

/// The policy of a preview in its frame: its own program, and nothing else; the frame is a site of its own.
const PREVIEW_POLICY: &str = "sandbox allow-scripts; default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; frame-ancestors 'self'";

/// Reasons against an order that the page lists.
const MOST_REASONS: usize = 5;

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
            let name = shared.state().project.choices.machine.clone();
            let drawn = name.map_or(Value::Null, |name| scene::machine(&name, &World::here(&Silent)));
            return Ok(document(&drawn));
        }
        WebAsked::DrawnModel(index) => return model(index, revision, shared),
        WebAsked::Upload(name) if is_project(&name) => {
            opened(&name, head.length, body, shared)?;
            look(shared);
        }
        WebAsked::Order(order) => {
            return reorder(&order, revision, shared).map(|refused| with_state(refused, shared));
        }
        WebAsked::Cuts(cuts) => {
            return cut(&cuts, revision, shared).map(|refused| with_state(refused, shared));
        }
        WebAsked::Save => save(revision, shared)?,
        WebAsked::Upload(name) => {
            let name = folder::take(&shared.folder, &name, head.length, body)?;
            let mut kept = shared.kept();
            shared.with(|state| {
                state.project.add(&name);
                state.version += 1;
                kept.retain(&state.project.history.models());
            });
            drop(kept);
            look(shared);
        }
        WebAsked::ProjectChange(change) => {
            make(&change, revision, shared)?;
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

/// A project file that was dropped takes the place of what was chosen, which can be taken back.
fn opened(name: &str, length: u64, body: &mut dyn Read, shared: &Shared) -> Result<(), WorkbenchError> {
    if !is_plain(name) {
        return Err(WorkbenchError::BadName { name: shown(name) });
    }
    let mut kept = shared.kept();
    let target = folder::unpacked_upload(&shared.folder, name, length, body)?;
    let now = shared.state().project.choices.clone();
    let leaves = |model: &&ChosenModel| !target.models.iter().any(|one| one.path == model.path);
    now.models.iter().filter(leaves).for_each(|model| kept.keep(model, &shared.folder));
    shared.with(|state| {
        state.opened(target, name, None);
        kept.retain(&state.project.history.models());
    });
    Ok(())
}

/// The state, and what the command has said against a change: an answer like any other, since the question was good.
fn with_state(refused: Option<Value>, shared: &Shared) -> WebReply {
    let mut state = shared.state().document();
    state["refused"] = refused.unwrap_or(Value::Null);
    document(&state)
}

/// The document that a short command prints.
fn said(words: &[String], shared: &Shared) -> Result<Value, WorkbenchError> {
    let (_, out, _) = runs::ask(&shared.folder, words).map_err(|source| WorkbenchError::NotStarted { source })?;
    serde_json::from_str(&out).map_err(|_| WorkbenchError::Crashed)
}

/// Prints in another order, if the command has a plan for it; else what it says of it.
fn reorder(order: &str, revision: &str, shared: &Shared) -> Result<Option<Value>, WorkbenchError> {
    let (words, way) = {
        let state = shared.state();
        state.seen(revision)?;
        let timeline = state.project.timeline()?;
        let way = timeline.way.clone();
        state.project.target(&ProjectChange::Order(order.to_owned(), way.clone()), &state.names)?;
        (timeline.words(&state.project.choices, order), way)
    };
    // The page shows why not, and nothing of what would help: looking for that takes as long again.
    let words = [words, vec!["--no-remedies".to_owned()]].concat();
    let document = said(&words, shared)?;
    if !document["slots"].is_array() {
        let said = document["summary"].as_str().or(document["error"].as_str());
        let texts: Vec<&Value> =
            document["reasons"].as_array().into_iter().flatten().map(|one| &one["text"]).take(MOST_REASONS).collect();
        return Ok(Some(json!({"error": said, "code": document["code"], "reasons": texts})));
    }
    make(&ProjectChange::Order(order.to_owned(), way.clone()), revision, shared)?;
    shared.with(|state| {
        state.project.take_order(&way, &document);
        state.version += 1;
    });
    Ok(None)
}

/// Makes these cuts first, if the machine can make them; else what the command says of the first that it cannot.
fn cut(cuts: &str, revision: &str, shared: &Shared) -> Result<Option<Value>, WorkbenchError> {
    let change = ProjectChange::Cuts(cuts.to_owned());
    if cuts == "auto" {
        return make(&change, revision, shared).map(|()| None);
    }
    let (mut answers, basis) = {
        let state = shared.state();
        state.seen(revision)?;
        let target = state.project.target(&change, &state.names)?;
        (state.project.cut_commands(&target)?, state.project.basis())
    };
    for CutAnswer { of, words, document } in &mut answers {
        let document = match document {
            Some(known) => known,
            none => none.insert(said(words, shared)?),
        };
        if !document["planes"].is_array() || document["refused_cut"].is_u64() {
            let said = document["reasons"].get(0).or(document.get("error")).and_then(Value::as_str).unwrap_or_default();
            let bad = document["refused_cut"].as_u64().map(|k| k as usize);
            let place = bad.and_then(|k| Some(of.cuts.get(k)?.0));
            // The command counts the cuts of one part, the page those of all.
            let said = bad.zip(place).map_or_else(
                || said.to_owned(),
                |(own, all)| said.replacen(&format!("cut {}", own + 1), &format!("cut {}", all + 1), 1),
            );
            return Ok(Some(json!({"error": said, "code": document["code"], "cut": place})));
        }
    }
    make(&change, revision, shared)?;
    shared.with(|state| {
        // The file may have become another one meanwhile.
        if state.project.basis() == basis {
            state.project.take_cuts(answers);
        }
        state.version += 1;
    });
    Ok(None)
}

/// Saves the project as it is.
fn save(revision: &str, shared: &Shared) -> Result<(), WorkbenchError> {
    let _kept = shared.kept();
    let (choices, plan, own, stem) = {
        let state = shared.state();
        state.seen(revision)?;
        let (choices, Saved { own, stem, .. }) = (state.project.choices.clone(), &state.saved);
        let plan = state.project.is_prepared().then(|| choices.output("plan.json")).flatten();
        let first = choices.models.first().map_or("project", ChosenModel::name);
        let first = first.rsplit_once('.').map_or(first, |(stem, _)| stem).to_owned();
        (choices, plan, own.clone(), stem.clone().unwrap_or(first))
    };
    choices.prepare()?;
    let machine =
        choices.machine.as_deref().map(|name| scene::profile(name, &World::here(&Silent))).transpose()?.flatten();
    let saving = Saving { machine, plan: plan.as_deref(), own: own.as_deref(), stem: &stem };
    let name = folder::save(&shared.folder, &choices, &saving)?;
    shared.with(|state| state.saved(&choices, name));
    Ok(())
}

/// Changes the project. Models that leave it are kept, and those that come back are there before it names them.
fn make(change: &ProjectChange, revision: &str, shared: &Shared) -> Result<(), WorkbenchError> {
    let mut kept = shared.kept();
    let (now, target) = {
        let state = shared.state();
        state.seen(revision)?;
        (state.project.choices.clone(), state.project.target(change, &state.names)?)
    };
    let has = |choices: &Choices, id| choices.models.iter().any(|model| model.id == id);
    now.models.iter().filter(|model| !has(&target, model.id)).for_each(|model| kept.keep(model, &shared.folder));
    let mut moved = BTreeMap::new();
    for model in target.models.iter().filter(|model| !has(&now, model.id)) {
        moved.insert(model.id, kept.bring_back(model, &shared.folder)?);
    }
    shared.with(|state| {
        state.change(change, target, &moved)?;
        kept.retain(&state.project.history.models());
        Ok(())
    })
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
    let known = ENDINGS.iter().filter_map(|end| shared.state().project.choices.output(end)).any(|one| one == name);
    let known = known || shared.state().saved.own.as_deref() == Some(name);
    let (file, length) =
        if known { folder::result(&shared.folder, name)? } else { return Err(WorkbenchError::NotFound) };
    let (kind, header) = match name.ends_with(".html") {
        true => ("text/html; charset=utf-8", ("Content-Security-Policy", PREVIEW_POLICY.to_owned())),
        false => ("application/octet-stream", ("Content-Disposition", "attachment".to_owned())),
    };
    Ok(WebReply::File(HttpAnswer { more: vec![header], ..HttpAnswer::of(kind, Vec::new()) }, file, length))
}

/// A model of the project as the page has seen it. A page that has seen an older one is on its way to the new state: it is told, and nothing has failed.
fn model(index: usize, revision: &str, shared: &Shared) -> Result<WebReply, WorkbenchError> {
    let (path, unit, plate) = {
        let state = shared.state();
        if let Err(old) = state.seen(revision) {
            return Ok(document(&failed(&old)));
        }
        let choices = &state.project.choices;
        let model = choices.models.get(index).ok_or(WorkbenchError::NotFound)?;
        (model.path.clone(), choices.unit.clone(), choices.plate_of(index).to_owned())
    };
    Ok(match scene::model(&path, &unit, &plate, &World::here(&Silent)) {
        Ok(bytes) => WebReply::Whole(HttpAnswer::of("application/octet-stream", bytes)),
        Err(why) => document(&why),
    })
}

/// Looks at the files again, and has models inspected that are new or have changed.
pub(super) fn look(shared: &Arc<Shared>) {
    let (paths, machine) = {
        let choices = &shared.state().project.choices;
        let paths: Vec<String> = choices.models.iter().map(|model| model.path.clone()).collect();
        (paths, choices.machine.clone())
    };
    let stamps: Vec<Stamp> =
        paths.iter().chain(&machine).map(|path| folder::stamp(&shared.folder.join(path))).collect();
    shared.with(|state| {
        let Choices { models, machine: now, .. } = &state.project.choices;
        let same = models.iter().map(|model| &model.path).eq(&paths) && *now == machine;
        if same && state.project.restamp(&stamps) {
            state.version += 1;
        }
    });
    while let Some((id, words)) = shared.with(|state| state.project.next_to_inspect()) {
        let shared = shared.clone();
        runs::aside(move || inspect(id, &words, &shared));
    }
}

fn inspect(id: u64, words: &[String], shared: &Shared) {
    let (document, notes) = match runs::ask(&shared.folder, words) {
        Ok((_, out, notes)) => (serde_json::from_str(&out).ok(), notes),
        Err(source) => (Some(failed(&WorkbenchError::NotStarted { source })), Vec::new()),
    };
    let document = document.unwrap_or_else(|| failed(&WorkbenchError::Crashed));
    shared.with(|state| {
        state.version += 1;
        state.project.take_inspected(id, words, document, notes);
    });
}

fn failed(error: &WorkbenchError) -> Value {
    json!({"error": error.to_string(), "code": error.code()})
}

fn start(task: PrinterTask, revision: &str, shared: &Arc<Shared>) -> Result<(), WorkbenchError> {
    let words = shared.with(|state| state.seen(revision).and_then(|()| state.begin(task)))?;
    let heard = shared.clone();
    // The state is held until the job is in it: it may end at once.
    let mut state = shared.state();
    let lent = Lent { terminal: task.task.prints(), key: task.task.publishes() };
    let started = runs::start(&shared.folder, &words, lent, move |said| heard.with(|state| state.hear(task, said)));
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
