//! The project: models, machine and choices, the command line of every job, and which results are out of date. Pure values.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use super::WorkbenchError;
use super::choices::{CHOICES, Choices, ChosenModel, ENDINGS, FINISHES, MOST_PLATE, SLICERS, UNITS, WAYS, line};
use super::cuts::{CountedModel, CutsOfPart, by_part, renumbered};
use super::history::{History, StepName};
use super::task::{PrinterTask, Task, numbered};
use super::timeline::Timeline;

/// What a file was when it was looked at: its size and the time of its last change, ns; `None` where it is not there.
pub(super) type Stamp = Option<(u64, u128)>;

/// Plans that are kept for undo.
const MOST_TIMELINES: usize = 50;
/// Findings that the page lists; the preview has all of them.
const MOST_FINDINGS: usize = 200;

/// A change of the project that a page asks for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum ProjectChange {
    /// Removes a model from the project; its file stays.
    Remove(usize),
    /// Prints so many copies of a model.
    Copies(usize, String),
    /// Sets a choice by its name.
    Set(String, String),
    /// Prints in this order, in a way that has these parts.
    Order(String, String),
    /// Makes these cuts first.
    Cuts(String),
    /// Has one more printer.
    AddPrinter,
    /// Has one less.
    RemovePrinter(u8),
    /// Takes the last change back.
    Undo,
    /// Makes the change again that was taken back last.
    Redo,
}

/// What is known of a model of the project.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct ModelFacts {
    /// What the file was when `inspected` was made.
    pub(super) stamp: Stamp,
    /// The document of `trunnion inspect`, or its failure; `None` until it is there.
    inspected: Option<Value>,
    /// What `trunnion inspect` wrote beside its document.
    notes: Vec<String>,
    /// The command that was asked last about the file as it is.
    asked: Option<Vec<String>>,
}

/// A result of the job that prepares.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct MadeResult {
    /// Everything that it depends on, as text.
    pub(super) made_of: String,
    /// The document that the command printed.
    pub(super) document: Value,
}

/// What the command says of the cuts of one part.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct CutAnswer {
    /// The part and its cuts.
    pub(super) of: CutsOfPart,
    /// The command.
    pub(super) words: Vec<String>,
    /// What it says; `None`: nobody has asked.
    pub(super) document: Option<Value>,
}

/// What the command says of all chosen cuts.
#[derive(Clone, Debug, PartialEq)]
struct MadeCuts {
    /// What it depends on beside the commands.
    basis: String,
    /// .. and all that the project is.
    made_of: String,
    /// By part.
    answers: Vec<CutAnswer>,
}

/// The project.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Project {
    /// Counts the changes: who changes it says which state was seen.
    pub(super) revision: u64,
    /// What was chosen.
    pub(super) choices: Choices,
    /// What was chosen before, and what was taken back.
    pub(super) history: History,
    /// What is known of each model, by its number.
    facts: BTreeMap<u64, ModelFacts>,
    /// What the machine's file was, where it is one.
    machine_stamp: Stamp,
    /// Numbers that models have had.
    models: u64,
    /// The ways, with what they were priced of.
    ways: Option<MadeResult>,
    /// The last run that prepared a file or said why not.
    prepared: Option<MadeResult>,
    /// What the command says of the chosen cuts.
    cuts: Option<MadeCuts>,
    /// The plans of what was prepared, and of the orders that were found to work; the last one last.
    timelines: Vec<Timeline>,
}

impl Project {
    /// One with nothing in it.
    pub(super) fn new(machine: Option<String>) -> Self {
        Self { choices: Choices::new(machine), ..Self::default() }
    }

    /// Adds a model; one that is there already is read anew and comes last.
    pub(super) fn add(&mut self, path: &str) {
        let mut target = self.choices.clone();
        let known = target.models.iter().position(|model| model.path == path).map(|index| target.models.remove(index));
        let id = known.map_or_else(
            || {
                self.models += 1;
                self.models
            },
            |model| model.id,
        );
        self.facts.remove(&id);
        target.models.push(ChosenModel { id, path: path.to_owned(), copies: 1 });
        target.order_after(&self.choices);
        target.cuts = self.cuts_after(&target);
        let name = target.models[target.models.len() - 1].name().to_owned();
        self.history.step(self.choices.clone(), StepName { what: "add", name });
        self.adopt(target);
    }

    /// Takes the choices of a project file in the place of its own. The printers are this computer's.
    pub(super) fn open(&mut self, mut target: Choices, name: &str) {
        for model in &mut target.models {
            let known = self.choices.models.iter().find(|one| one.path == model.path).map(|one| one.id);
            model.id = known.unwrap_or_else(|| {
                self.models += 1;
                self.models
            });
        }
        target.printers.clone_from(&self.choices.printers);
        self.history.step(self.choices.clone(), StepName { what: "open", name: name.to_owned() });
        self.adopt(target);
    }

    /// What is chosen from now on.
    fn adopt(&mut self, target: Choices) {
        self.revision += 1;
        self.choices = target;
        self.facts.retain(|id, _| self.choices.models.iter().any(|model| model.id == *id));
    }

    /// Takes what the files are now: models first, the machine last. Models that are not as they were are inspected anew.
    /// Whether anything has changed.
    pub(super) fn restamp(&mut self, stamps: &[Stamp]) -> bool {
        let mut changed = false;
        for (model, stamp) in self.choices.models.iter().zip(stamps) {
            let facts = self.facts.entry(model.id).or_default();
            if facts.stamp != *stamp {
                *facts = ModelFacts { stamp: *stamp, ..ModelFacts::default() };
                changed = true;
            }
        }
        let machine = stamps.get(self.choices.models.len()).copied().flatten();
        changed |= std::mem::replace(&mut self.machine_stamp, machine) != machine;
        changed
    }

    /// The first model that `trunnion inspect` has not been asked about as it is to be read now, and the words of that command; from now on as if it had.
    pub(super) fn next_to_inspect(&mut self) -> Option<(u64, Vec<String>)> {
        for (index, model) in self.choices.models.iter().enumerate() {
            let (words, facts) = (self.choices.inspect(index), self.facts.entry(model.id).or_default());
            if facts.asked.as_ref() != Some(&words) {
                *facts = ModelFacts { stamp: facts.stamp, asked: Some(words.clone()), ..ModelFacts::default() };
                return Some((model.id, words));
            }
        }
        None
    }

    /// Takes the answer of `trunnion inspect`; of a model that was asked about otherwise meanwhile, the later answer is kept.
    pub(super) fn take_inspected(&mut self, id: u64, words: &[String], document: Value, notes: Vec<String>) {
        let facts = self.facts.get_mut(&id).filter(|facts| facts.asked.as_deref() == Some(words));
        facts.into_iter().for_each(|facts| (facts.inspected, facts.notes) = (Some(document.clone()), notes.clone()));
    }

    /// What is chosen after a change, and what the change is called; `machines` are the profiles that can be chosen. Nothing is changed yet.
    ///
    /// # Errors
    ///
    /// [`WorkbenchError::BadChoice`], [`WorkbenchError::NotFound`] and [`WorkbenchError::NoStep`].
    pub(super) fn target(&self, change: &ProjectChange, machines: &[String]) -> Result<Choices, WorkbenchError> {
        let mut target = self.choices.clone();
        match change {
            ProjectChange::Remove(index) if *index < target.models.len() => _ = target.models.remove(*index),
            ProjectChange::Remove(_) => return Err(WorkbenchError::NotFound),
            ProjectChange::Copies(index, value) => target.set_copies(*index, value)?,
            ProjectChange::Set(name, value) => target.set(name, value, machines)?,
            ProjectChange::Order(order, way) => {
                target.set("way", way, machines)?;
                target.set("order", order, machines)?;
            }
            ProjectChange::Cuts(cuts) => {
                target.set("cuts", cuts, machines)?;
                // What was decided is done: the way follows.
                let way = if cuts == "auto" { "auto" } else { "cut" };
                let stays = cuts == "auto" && target.way != "cut";
                (!stays).then(|| target.set("way", way, machines)).transpose()?;
            }
            ProjectChange::AddPrinter => target.printers.add()?,
            ProjectChange::RemovePrinter(number) => target.printers.remove(*number)?,
            ProjectChange::Undo => target = self.history.past()?.clone(),
            ProjectChange::Redo => target = self.history.future()?.clone(),
        }
        if !matches!(change, ProjectChange::Order(..) | ProjectChange::Undo | ProjectChange::Redo) {
            target.order_after(&self.choices);
            target.cuts = self.cuts_after(&target);
        }
        Ok(target)
    }

    /// The models of some choices with the parts that are known of them.
    fn counted(&self, choices: &Choices) -> Vec<CountedModel> {
        let parts = |(index, model): (usize, &ChosenModel)| {
            let facts = self.facts.get(&model.id).filter(|facts| facts.asked.as_ref() == Some(&choices.inspect(index)));
            facts?.inspected.as_ref()?["parts"].as_array().map(Vec::len)
        };
        let of = |(index, model): (usize, &ChosenModel)| CountedModel {
            id: model.id,
            copies: model.copies as usize,
            parts: parts((index, model)),
        };
        choices.models.iter().enumerate().map(of).collect()
    }

    /// The cuts of `target`: where its models are others or more, of the same parts as now; none where models are read otherwise.
    fn cuts_after(&self, target: &Choices) -> String {
        let now = &self.choices;
        let models = |choices: &Choices| -> Vec<(String, u64)> {
            choices.models.iter().map(|model| (model.path.clone(), u64::from(model.copies))).collect()
        };
        if target.cuts != now.cuts || target.cuts == "auto" {
            return target.cuts.clone();
        }
        if (&target.unit, &target.plate) != (&now.unit, &now.plate) {
            return "auto".to_owned();
        }
        if models(target) == models(now) {
            return target.cuts.clone();
        }
        renumbered(&now.cuts, &self.counted(now), &self.counted(target))
    }

    /// The chosen cuts of `target` by parts, each with its command, and with the answer where that is known.
    ///
    /// # Errors
    ///
    /// [`WorkbenchError::NotYet`] with what is missing, and [`WorkbenchError::BadChoice`].
    pub(super) fn cut_commands(&self, target: &Choices) -> Result<Vec<CutAnswer>, WorkbenchError> {
        let models = self.counted(target);
        let bad = || match models.iter().any(|model| model.parts.is_none()) {
            true => WorkbenchError::NotYet { what: "let all models be read" },
            false => WorkbenchError::BadChoice { name: "cuts", value: target.cuts.clone() },
        };
        let basis = self.basis();
        let known = self.cuts.iter().filter(|cuts| cuts.basis == basis).flat_map(|cuts| &cuts.answers);
        let answer = |of: CutsOfPart| {
            let words = target.split(&of)?;
            let document =
                known.clone().find(|answer| answer.words == words).and_then(|answer| answer.document.clone());
            Ok(CutAnswer { of, words, document })
        };
        by_part(&target.cuts, &models).ok_or_else(bad)?.into_iter().map(answer).collect()
    }

    /// Makes a change whose `target` is this; `moved` are models whose files have other names now.
    pub(super) fn change(&mut self, change: &ProjectChange, mut target: Choices, moved: &BTreeMap<u64, String>) {
        let now = self.choices.clone();
        let name_of = |index: &usize| now.models.get(*index).map_or_else(String::new, |model| model.name().to_owned());
        match change {
            ProjectChange::Remove(index) => {
                self.history.step(now.clone(), StepName { what: "remove", name: name_of(index) })
            }
            _ if target == now && !matches!(change, ProjectChange::Undo | ProjectChange::Redo) => {}
            ProjectChange::Copies(index, _) => {
                self.history.step(now.clone(), StepName { what: "copies", name: name_of(index) })
            }
            ProjectChange::Set(name, value) => {
                let plain = numbered(name).map_or("", |(plain, _)| plain);
                let what = CHOICES.into_iter().find(|one| *one == plain).unwrap_or_default();
                self.history.step(now.clone(), StepName { what, name: value.clone() });
            }
            ProjectChange::Order(order, _) => {
                self.history.step(now.clone(), StepName { what: "order", name: order.clone() })
            }
            ProjectChange::Cuts(_) => self.history.step(now.clone(), StepName { what: "cuts", name: String::new() }),
            ProjectChange::AddPrinter => {
                self.history.step(now.clone(), StepName { what: "add_printer", name: String::new() });
            }
            ProjectChange::RemovePrinter(number) => {
                self.history.step(now.clone(), StepName { what: "remove_printer", name: number.to_string() });
            }
            ProjectChange::Undo => self.history.undo(now.clone()),
            ProjectChange::Redo => self.history.redo(now.clone()),
        }
        self.history.moved(moved);
        target.moved(moved);
        self.adopt(target);
    }

    /// What the ways depend on: everything but the chosen one.
    pub(super) fn basis(&self) -> String {
        let Choices { models, machine, unit, plate, up, finish, slicer, .. } = &self.choices;
        let stamp = |model: &ChosenModel| self.facts.get(&model.id).and_then(|facts| facts.stamp);
        let stamps: Vec<Stamp> = models.iter().map(stamp).chain([self.machine_stamp]).collect();
        let choices = [unit, plate, up, finish, slicer];
        format!("{:?} {machine:?} {choices:?} {stamps:?}", self.choices.words_of_models())
    }

    /// What the prepared file depends on.
    pub(super) fn whole(&self) -> String {
        format!("{} {} {} {}", self.basis(), self.choices.way, self.choices.order, self.choices.cuts)
    }

    /// The words of the command that a task is.
    ///
    /// # Errors
    ///
    /// [`WorkbenchError::NotYet`] with what is missing, and [`WorkbenchError::BadChoice`] for a printer that is not there.
    pub(super) fn words(&self, task: impl Into<PrinterTask>) -> Result<Vec<String>, WorkbenchError> {
        let PrinterTask { task, printer } = task.into();
        let printer = self.choices.printers.get(printer)?;
        let mut prepare = self.choices.prepare()?;
        let [gcode, plan] = ["gcode", "plan.json"].map(|ending| self.choices.output(ending).unwrap_or_default());
        let own = |words: &[&str]| words.iter().map(|&word| word.to_owned()).collect::<Vec<_>>();
        if task == Task::Prepare {
            prepare.extend(self.choices.written().into_iter().flatten());
            return Ok(prepare);
        }
        if !self.is_prepared() {
            return Err(WorkbenchError::NotYet { what: "prepare the file that is to be printed" });
        }
        if task.publishes() {
            if printer.server.is_empty() {
                return Err(WorkbenchError::NotYet { what: "enter the print server" });
            }
            let mut words = own(&["publish", &gcode, "--plan", &plan, "--to"]);
            words.extend(printer.server_words());
            words.extend((task == Task::PublishAndStart).then(|| "--start".to_owned()));
            return Ok(words);
        }
        let mut words = own(&["send", &gcode, "--plan", &plan]);
        match task {
            Task::Rehearse => words.push("--dry-run".to_owned()),
            _ if printer.port.is_empty() => {
                return Err(WorkbenchError::NotYet { what: "enter the printer's port" });
            }
            _ => {
                words.extend(own(&["--port", &printer.port]));
                words.extend(printer.journal_words(&gcode));
            }
        }
        if task == Task::Resume {
            words.push("--resume".to_owned());
        }
        Ok(words)
    }

    /// What there is to do: to prepare, and what each printer can do.
    fn tasks(&self) -> impl Iterator<Item = PrinterTask> {
        let of_printer = |printer| Task::ALL.into_iter().map(move |task| PrinterTask { task, printer });
        let all = self.choices.printers.numbers().flat_map(of_printer);
        all.filter(|one| one.printer == 1 || one.task != Task::Prepare)
    }

    /// Whether there is a verified file of the project as it is now.
    pub(super) fn is_prepared(&self) -> bool {
        self.prepared.as_ref().is_some_and(|one| one.made_of == self.whole() && one.document["output"].is_string())
    }

    /// Takes the document of a run that has prepared, or has said why not; `made_of` and `basis` are of the moment when it began.
    pub(super) fn take(&mut self, made_of: String, basis: String, document: Value) {
        // Where one way was asked for, the document has that way alone: the prices of all are kept.
        let same = self.ways.as_ref().is_some_and(|ways| ways.made_of == basis);
        let count = |document: &Value| document["ways"].as_array().map_or(0, Vec::len);
        if count(&document) > 0
            && !(same && self.ways.as_ref().is_some_and(|old| count(&old.document) > count(&document)))
        {
            self.ways = Some(MadeResult { made_of: basis, document: json!({"ways": document["ways"]}) });
        }
        let chosen = document["ways"].as_array().into_iter().flatten().find(|way| way["chosen"] == true);
        let way = chosen.and_then(|way| way["way"].as_str()).unwrap_or_default().to_owned();
        self.keep(Timeline::of(made_of.clone(), way, &document["plan"]));
        self.prepared = Some(MadeResult { made_of, document: shown(document) });
    }

    /// The plan of what is chosen now, where there is one.
    ///
    /// # Errors
    ///
    /// [`WorkbenchError::NotYet`].
    pub(super) fn timeline(&self) -> Result<&Timeline, WorkbenchError> {
        let whole = self.whole();
        let current = self.timelines.iter().find(|timeline| timeline.made_of == whole);
        current.ok_or(WorkbenchError::NotYet { what: "prepare the prints whose order is to be changed" })
    }

    /// Takes the plan of an order that was found to work, of the project as it is now.
    pub(super) fn take_order(&mut self, way: &str, document: &Value) {
        self.keep(Timeline::of(self.whole(), way.to_owned(), document));
    }

    /// The latest of what is the same stays.
    fn keep(&mut self, timeline: Option<Timeline>) {
        let Some(timeline) = timeline else { return };
        self.timelines.retain(|one| one.made_of != timeline.made_of);
        if self.timelines.len() == MOST_TIMELINES {
            self.timelines.remove(0);
        }
        self.timelines.push(timeline);
    }

    /// Takes what the command says of the chosen cuts, of the project as it is now.
    pub(super) fn take_cuts(&mut self, answers: Vec<CutAnswer>) {
        self.cuts = Some(MadeCuts { basis: self.basis(), made_of: self.whole(), answers });
    }

    /// By solid that is cut, the planes of the project as it is now, those that were chosen first, and what is left that hangs, mm²: of what was
    /// prepared, else of the chosen cuts alone; empty where neither is known.
    fn cut_document(&self) -> Value {
        let whole = self.whole();
        let prepared = self.prepared.as_ref().filter(|one| one.made_of == whole).map(|one| &one.document["cut"]);
        let of_solid = |cut: &Value, of_parts: &Value| json!({"of_parts": of_parts, "planes": cut["planes"], "left_mm2": cut["needs_support_mm2"]["after"], "seam_mm2": cut["seam_mm2"], "parts": cut["parts"]});
        let solids: Vec<Value> = match prepared {
            Some(cut) if cut["planes"].is_array() => vec![of_solid(cut, &cut["of_parts"])],
            Some(cut) if cut["solids"].is_array() => {
                let solids = cut["solids"].as_array().into_iter().flatten();
                solids.map(|solid| of_solid(solid, &solid["of_parts"])).collect()
            }
            _ => {
                let current = self.cuts.iter().filter(|cuts| cuts.made_of == whole).flat_map(|cuts| &cuts.answers);
                let chosen = |answer: &CutAnswer| {
                    let mut solid = of_solid(answer.document.as_ref()?, &json!([answer.of.number.unwrap_or(0)]));
                    let planes = solid["planes"].as_array_mut().into_iter().flatten();
                    // The part alone knows no number.
                    if let Some(number) = answer.of.number {
                        planes.for_each(|plane| {
                            plane["pin"] = format!("{number}:{}", plane["pin"].as_str().unwrap_or_default()).into();
                        });
                    }
                    Some(solid)
                };
                current.filter_map(chosen).collect()
            }
        };
        solids.into()
    }

    /// The project as the page shows it.
    pub(super) fn document(&self) -> Value {
        let model = |(index, model): (usize, &ChosenModel)| {
            let facts = self.facts.get(&model.id);
            // What was read of it in another unit is not what it is.
            let read = facts.filter(|facts| facts.asked.as_ref() == Some(&self.choices.inspect(index)));
            json!({"path": model.path, "copies": model.copies, "inspected": read.and_then(|facts| facts.inspected.as_ref()),
                "notes": read.map_or(&[][..], |facts| &facts.notes), "there": facts.is_some_and(|facts| facts.stamp.is_some())})
        };
        let ways = self
            .ways
            .as_ref()
            .map(|ways| json!({"ways": ways.document["ways"], "stale": ways.made_of != self.basis()}));
        let prepared =
            self.prepared.as_ref().map(|one| json!({"document": one.document, "stale": one.made_of != self.whole()}));
        let command = |task: PrinterTask| match self.words(task) {
            Ok(words) => json!({"line": line(&words), "why_not": null}),
            Err(error) => json!({"line": null, "why_not": error.to_string()}),
        };
        let commands: serde_json::Map<String, Value> = self.tasks().map(|task| (task.name(), command(task))).collect();
        let files: Vec<Value> = ENDINGS.iter().map(|ending| self.choices.output(ending).into()).collect();
        let Choices { models, machine, unit, plate, way, up, cuts, finish, slicer, order, printers } = &self.choices;
        json!({
            "revision": self.revision,
            "models": models.iter().enumerate().map(model).collect::<Vec<_>>(),
            "inspect": (0..models.len()).map(|i| line(&self.choices.inspect(i))).collect::<Vec<_>>(),
            "machine": machine, "unit": unit, "plate": plate, "way": way, "up": up, "finish": finish, "slicer": slicer, "order": order,
            "cuts": if cuts == "auto" { Vec::new() } else { cuts.split(';').collect::<Vec<_>>() }, "cut": self.cut_document(),
            "printers": printers.document(),
            "choices": {"plates": MOST_PLATE, "way": WAYS, "unit": UNITS, "finish": FINISHES, "slicer": SLICERS},
            "commands": commands, "files": files, "ways": ways, "prepared": prepared,
            "timeline": self.timeline().ok().map(Timeline::document),
            "undo": self.history.last().map(StepName::document), "redo": self.history.next().map(StepName::document),
        })
    }
}

/// What the page shows of the document of `trunnion prepare`: it goes to every page with every change of the state.
fn shown(mut document: Value) -> Value {
    if let Some(plan) = document.get_mut("plan") {
        *plan = json!({"pose_changes": plan["pose_changes"]});
    }
    if let Some(report) = document.get_mut("verify") {
        shorten(report);
    }
    shorten(&mut document);
    document
}

/// A report of verification without what the page does not show.
fn shorten(report: &mut Value) {
    let Some(report) = report.as_object_mut() else { return };
    report.retain(|key, _| !["interfaces", "joints", "wall_starts", "stated", "table"].contains(&key.as_str()));
    let findings = report.get_mut("findings").and_then(Value::as_array_mut);
    findings.into_iter().for_each(|all| all.truncate(MOST_FINDINGS));
}

#[cfg(test)]
mod tests;
