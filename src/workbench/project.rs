//! The project: models, machine and choices, the command line of every job, and which results are out of date. Pure values.

use serde_json::{Value, json};

use super::WorkbenchError;

/// What a file was when it was looked at: its size and the time of its last change, ns; `None` where it is not there.
pub(super) type Stamp = Option<(u64, u128)>;

/// As many plates as a slicer's project has at most.
const MOST_PLATE: u8 = 36;
/// Most copies of one model.
const MOST_COPIES: u32 = 999;
/// Findings that the page lists; the preview has all of them.
const MOST_FINDINGS: usize = 200;
const WAYS: [&str; 6] = ["auto", "as-drawn", "turned", "supports", "turned-supports", "cut"];
const UNITS: [&str; 7] = ["auto", "um", "mm", "cm", "in", "ft", "m"];
const UPS: [&str; 2] = ["auto", "recommended"];
const FINISHES: [&str; 2] = ["auto", "fine"];
const SLICERS: [&str; 6] = ["auto", "builtin", "prusa-slicer", "slic3r", "cura", "orca"];

/// A job of the page. Each is one command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Task {
    /// All ways, the chosen one made into verified G-code, and its preview.
    Prepare,
    /// The print on the simulated printer.
    Rehearse,
    /// The print.
    Print,
    /// The print again, from its journal.
    Resume,
}

impl Task {
    /// All of them.
    pub(super) const ALL: [Self; 4] = [Self::Prepare, Self::Rehearse, Self::Print, Self::Resume];

    /// Its name in addresses and documents.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Prepare => "prepare",
            Self::Rehearse => "rehearse",
            Self::Print => "print",
            Self::Resume => "resume",
        }
    }

    /// The task of that name.
    pub(super) fn of(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|task| task.name() == name)
    }

    /// Whether it moves a real printer.
    pub(super) fn prints(self) -> bool {
        matches!(self, Self::Print | Self::Resume)
    }
}

/// A change of the project that a page asks for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum ProjectChange {
    /// Removes a model from the project; its file stays.
    Remove(usize),
    /// Prints so many copies of a model.
    Copies(usize, String),
    /// Sets a choice by its name.
    Set(String, String),
}

/// A model of the project.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ProjectModel {
    /// Its file, as the command line names it from the project's folder.
    pub(super) path: String,
    /// How many are printed.
    pub(super) copies: u32,
    /// What the file was when `inspected` was made.
    pub(super) stamp: Stamp,
    /// The document of `trunnion inspect`, or its failure; `None` until it is there.
    pub(super) inspected: Option<Value>,
    /// What `trunnion inspect` wrote beside its document.
    pub(super) notes: Vec<String>,
    /// Whether `trunnion inspect` was asked about the file as it is.
    pub(super) asked: bool,
}

/// A result of the job that prepares.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct MadeResult {
    /// Everything that it depends on, as text.
    pub(super) made_of: String,
    /// The document that the command printed.
    pub(super) document: Value,
}

/// The project.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Project {
    /// Counts the changes: who changes it says which state was seen.
    pub(super) revision: u64,
    /// The models in order.
    pub(super) models: Vec<ProjectModel>,
    /// The machine: a name or a profile's file.
    pub(super) machine: Option<String>,
    /// What the machine's file was, where it is one.
    pub(super) machine_stamp: Stamp,
    /// Unit of the models' numbers, or `auto`.
    pub(super) unit: String,
    /// The plate of the first model, which is a slicer's project with several, or `auto`.
    pub(super) plate: String,
    /// The way to print, or `auto`.
    pub(super) way: String,
    /// Direction of the model that points up, as three numbers; `auto` as drawn, `recommended` as `trunnion orient` says.
    pub(super) up: String,
    /// Quality of overhangs, or `auto`.
    pub(super) finish: String,
    /// The slicer, or `auto`.
    pub(super) slicer: String,
    /// The printer's port; empty without one.
    pub(super) port: String,
    /// The ways, with what they were priced of.
    pub(super) ways: Option<MadeResult>,
    /// The last run that prepared a file or said why not.
    pub(super) prepared: Option<MadeResult>,
}

impl Project {
    /// One with nothing in it.
    pub(super) fn new(machine: Option<String>) -> Self {
        let auto = || "auto".to_owned();
        let (unit, plate, way, up, finish, slicer) = (auto(), auto(), auto(), auto(), auto(), auto());
        Self { machine, unit, plate, way, up, finish, slicer, ..Self::default() }
    }

    /// Adds a model; one that is there already is read anew.
    pub(super) fn add(&mut self, path: &str) {
        self.revision += 1;
        self.models.retain(|model| model.path != path);
        let model = ProjectModel {
            path: path.to_owned(),
            copies: 1,
            stamp: None,
            inspected: None,
            notes: Vec::new(),
            asked: false,
        };
        self.models.push(model);
    }

    /// Takes what the files are now: models first, the machine last. Models that are not as they were are inspected anew.
    /// Whether anything has changed.
    pub(super) fn restamp(&mut self, stamps: &[Stamp]) -> bool {
        let before = (self.machine_stamp, self.models.iter().map(|model| model.stamp).collect::<Vec<_>>());
        for (model, stamp) in self.models.iter_mut().zip(stamps) {
            if model.stamp != *stamp {
                model.stamp = *stamp;
                (model.asked, model.inspected) = (false, None);
            }
        }
        self.machine_stamp = stamps.get(self.models.len()).copied().flatten();
        before != (self.machine_stamp, self.models.iter().map(|model| model.stamp).collect())
    }

    /// The first model that `trunnion inspect` has not been asked about, from now on as if it had.
    pub(super) fn next_to_inspect(&mut self) -> Option<usize> {
        let index = self.models.iter().position(|model| !model.asked)?;
        self.models[index].asked = true;
        Some(index)
    }

    /// Makes a change; `machines` are the profiles that can be chosen.
    ///
    /// # Errors
    ///
    /// [`WorkbenchError::BadChoice`] and [`WorkbenchError::NotFound`].
    pub(super) fn change(&mut self, change: &ProjectChange, machines: &[String]) -> Result<(), WorkbenchError> {
        match change {
            ProjectChange::Remove(index) if *index < self.models.len() => {
                self.models.remove(*index);
            }
            ProjectChange::Copies(index, value) => {
                let model = self.models.get_mut(*index).ok_or(WorkbenchError::NotFound)?;
                let copies = value.parse().ok().filter(|n| (1..=MOST_COPIES).contains(n));
                model.copies = copies.ok_or(WorkbenchError::BadChoice { name: "copies", value: value.clone() })?;
            }
            ProjectChange::Set(name, value) => self.set(name, value, machines)?,
            ProjectChange::Remove(_) => return Err(WorkbenchError::NotFound),
        }
        self.revision += 1;
        Ok(())
    }

    fn set(&mut self, name: &str, value: &str, machines: &[String]) -> Result<(), WorkbenchError> {
        let bad = |name| Err(WorkbenchError::BadChoice { name, value: value.to_owned() });
        match name {
            "machine" if machines.iter().any(|one| one == value) => self.machine = Some(value.to_owned()),
            "machine" => return bad("machine"),
            "way" if WAYS.contains(&value) => self.way = value.to_owned(),
            "way" => return bad("way"),
            "unit" if UNITS.contains(&value) => {
                self.unit = value.to_owned();
                self.models.iter_mut().for_each(|model| (model.asked, model.inspected) = (false, None));
            }
            "unit" => return bad("unit"),
            "plate"
                if value == "auto" || value.parse::<u8>().is_ok_and(|number| (1..=MOST_PLATE).contains(&number)) =>
            {
                self.plate = value.to_owned();
                self.models.iter_mut().take(1).for_each(|model| (model.asked, model.inspected) = (false, None));
            }
            "plate" => return bad("plate"),
            "up" if UPS.contains(&value) || is_direction(value) => self.up = value.to_owned(),
            "up" => return bad("up"),
            "finish" if FINISHES.contains(&value) => self.finish = value.to_owned(),
            "finish" => return bad("finish"),
            "slicer" if SLICERS.contains(&value) => self.slicer = value.to_owned(),
            "slicer" => return bad("slicer"),
            "port" if !value.starts_with('-') && !value.chars().any(char::is_control) => self.port = value.to_owned(),
            "port" => return bad("port"),
            _ => return Err(WorkbenchError::BadChoice { name: "name", value: name.to_owned() }),
        }
        Ok(())
    }

    /// What the ways depend on: everything but the chosen one.
    pub(super) fn basis(&self) -> String {
        let stamps: Vec<Stamp> = self.models.iter().map(|model| model.stamp).chain([self.machine_stamp]).collect();
        let choices = [&self.unit, &self.plate, &self.up, &self.finish, &self.slicer];
        format!("{:?} {:?} {choices:?} {stamps:?}", self.words_of_models(), self.machine)
    }

    /// What the prepared file depends on.
    pub(super) fn whole(&self) -> String {
        format!("{} {}", self.basis(), self.way)
    }

    fn words_of_models(&self) -> Vec<String> {
        let word = |model: &ProjectModel| match model.copies {
            1 => guarded(&model.path),
            n => format!("{}*{n}", guarded(&model.path)),
        };
        self.models.iter().map(word).collect()
    }

    /// The file of this ending that preparing makes: called after the first model, and so that it is no other program's.
    pub(super) fn output(&self, ending: &str) -> Option<String> {
        let name = self.models.first()?.path.rsplit(['/', '\\']).next()?;
        let stem = name.rsplit_once('.').map_or(name, |(stem, _)| stem);
        Some(guarded(&format!("{stem}.trunnion.{ending}")))
    }

    /// The words of the command that inspects a model.
    pub(super) fn inspect(&self, index: usize) -> Vec<String> {
        let mut words = vec!["inspect".to_owned(), guarded(&self.models[index].path)];
        push(&mut words, "--unit", &self.unit);
        push(&mut words, "--plate", self.plate_of(index));
        words
    }

    /// The plate that is read of a model: the command takes one of its first model alone.
    pub(super) fn plate_of(&self, index: usize) -> &str {
        if index == 0 { &self.plate } else { "auto" }
    }

    /// The words of the command that a task is.
    ///
    /// # Errors
    ///
    /// [`WorkbenchError::NotYet`] with what is missing.
    pub(super) fn words(&self, task: Task) -> Result<Vec<String>, WorkbenchError> {
        let gcode = self.output("gcode").ok_or(WorkbenchError::NotYet { what: "add a model" })?;
        let machine = self.machine.as_ref().ok_or(WorkbenchError::NotYet { what: "choose a machine" })?;
        let [plan, page] = ["plan.json", "html"].map(|ending| self.output(ending).unwrap_or_default());
        let own = |words: &[&str]| words.iter().map(|&word| word.to_owned()).collect::<Vec<_>>();
        if task == Task::Prepare {
            let mut words = own(&["prepare"]);
            words.extend(self.words_of_models());
            words.extend(own(&["-m", machine]));
            push(&mut words, "--unit", &self.unit);
            push(&mut words, "--plate", &self.plate);
            match self.up.as_str() {
                "recommended" => words.extend(own(&["--up", "auto"])),
                other => push(&mut words, "--up", other),
            }
            push(&mut words, "--way", &self.way);
            push(&mut words, "--finish", &self.finish);
            push(&mut words, "--slicer", &self.slicer);
            words.extend(own(&["-o", &gcode, "--plan-out", &plan, "--preview", &page]));
            return Ok(words);
        }
        if !self.is_prepared() {
            return Err(WorkbenchError::NotYet { what: "prepare the file that is to be printed" });
        }
        let mut words = own(&["send", &gcode, "--plan", &plan]);
        match task {
            Task::Rehearse => words.push("--dry-run".to_owned()),
            _ if self.port.is_empty() => return Err(WorkbenchError::NotYet { what: "enter the printer's port" }),
            _ => words.extend(own(&["--port", &self.port])),
        }
        if task == Task::Resume {
            words.push("--resume".to_owned());
        }
        Ok(words)
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
        self.prepared = Some(MadeResult { made_of, document: shown(document) });
    }

    /// The project as the page shows it.
    pub(super) fn document(&self) -> Value {
        let model = |model: &ProjectModel| {
            json!({"path": model.path, "copies": model.copies, "inspected": model.inspected, "notes": model.notes,
                "there": model.stamp.is_some()})
        };
        let ways = self
            .ways
            .as_ref()
            .map(|ways| json!({"ways": ways.document["ways"], "stale": ways.made_of != self.basis()}));
        let prepared =
            self.prepared.as_ref().map(|one| json!({"document": one.document, "stale": one.made_of != self.whole()}));
        let command = |task: Task| match self.words(task) {
            Ok(words) => json!({"line": line(&words), "why_not": null}),
            Err(error) => json!({"line": null, "why_not": error.to_string()}),
        };
        let commands: serde_json::Map<String, Value> =
            Task::ALL.into_iter().map(|task| (task.name().to_owned(), command(task))).collect();
        let files: Vec<Value> =
            ["gcode", "plan.json", "html"].iter().map(|ending| self.output(ending).into()).collect();
        json!({
            "revision": self.revision,
            "models": self.models.iter().map(model).collect::<Vec<_>>(),
            "inspect": (0..self.models.len()).map(|i| line(&self.inspect(i))).collect::<Vec<_>>(),
            "machine": self.machine, "unit": self.unit, "plate": self.plate, "way": self.way, "up": self.up, "finish": self.finish, "slicer": self.slicer, "port": self.port,
            "choices": {"plates": MOST_PLATE, "way": WAYS, "unit": UNITS, "finish": FINISHES, "slicer": SLICERS},
            "commands": commands, "files": files, "ways": ways, "prepared": prepared,
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

/// Three numbers, not all of them 0.
fn is_direction(text: &str) -> bool {
    let numbers: Vec<Option<f64>> =
        text.split(',').map(|word| word.parse().ok().filter(|v: &f64| v.is_finite())).collect();
    numbers.len() == 3 && numbers.iter().all(Option::is_some) && numbers.iter().flatten().any(|v| *v != 0.0)
}

/// A flag and its value, where it is not `auto`.
fn push(words: &mut Vec<String>, flag: &str, value: &str) {
    if value != "auto" {
        words.extend([flag.to_owned(), value.to_owned()]);
    }
}

/// A file that the command does not take for a flag.
fn guarded(path: &str) -> String {
    if path.starts_with('-') { format!("./{path}") } else { path.to_owned() }
}

/// The command line of these words, quoted for a shell.
pub(super) fn line(words: &[String]) -> String {
    let plain = |word: &str| !word.is_empty() && word.chars().all(|c| c.is_alphanumeric() || "-_./:=,+@%".contains(c));
    let quoted = |word: &String| if plain(word) { word.clone() } else { format!("'{}'", word.replace('\'', r"'\''")) };
    std::iter::once("trunnion".to_owned()).chain(words.iter().map(quoted)).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests;
