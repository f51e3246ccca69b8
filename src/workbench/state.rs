//! The state of the workbench: the project, the runs of its jobs, and the machines that can be chosen. What changes it is counted.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use super::WorkbenchError;
use super::choices::Choices;
use super::project::{Project, ProjectChange};
use super::routes::JobWord;
use super::run::Run;
use super::runs::{Job, JobSaid};
use super::task::{PrinterTask, Task};

/// The state.
#[derive(Debug, Default)]
pub(super) struct State {
    /// The project's folder, as it is shown.
    pub(super) folder: String,
    /// The project.
    pub(super) project: Project,
    /// The last run of each job.
    pub(super) runs: BTreeMap<PrinterTask, Run>,
    /// The processes of those that run.
    pub(super) jobs: BTreeMap<PrinterTask, Job>,
    /// The document of `trunnion profile list`.
    pub(super) machines: Value,
    /// Names and files of the machines, and the one that the command was given.
    pub(super) names: Vec<String>,
    /// The file that the project was opened from or saved to.
    pub(super) saved: Saved,
    /// Counts every change that a page could show.
    pub(super) version: u64,
}

/// What is known of the project's file.
#[derive(Debug, Default)]
pub(super) struct Saved {
    /// The file in the project's folder that this workbench may replace.
    pub(super) own: Option<String>,
    /// What it is called, without its ending.
    pub(super) stem: Option<String>,
    /// The words of the command that it has.
    words: Option<Vec<String>>,
}

impl State {
    /// That the page has seen the project as it is.
    ///
    /// # Errors
    ///
    /// [`WorkbenchError::OldRevision`].
    pub(super) fn seen(&self, revision: &str) -> Result<(), WorkbenchError> {
        let current = revision.parse() == Ok(self.project.revision);
        if current { Ok(()) } else { Err(WorkbenchError::OldRevision) }
    }

    /// That no job runs which is like that.
    fn idle(&self, is_like: impl Fn(PrinterTask) -> bool) -> Result<(), WorkbenchError> {
        let busy = self.runs.iter().any(|(task, run)| run.running && is_like(*task));
        if busy { Err(WorkbenchError::Busy) } else { Ok(()) }
    }

    /// Makes a change whose `target` is this, as [`Project::change`] does. What a printer has done goes with it, so that the next one of its number
    /// begins anew.
    ///
    /// # Errors
    ///
    /// [`WorkbenchError::Busy`] where a printer would go that has something to do.
    pub(super) fn change(
        &mut self,
        change: &ProjectChange,
        target: Choices,
        moved: &BTreeMap<u64, String>,
    ) -> Result<(), WorkbenchError> {
        let goes = |task: PrinterTask| target.printers.get(task.printer).is_err();
        self.idle(goes)?;
        self.runs.retain(|task, _| !goes(*task));
        self.project.change(change, target, moved);
        self.version += 1;
        Ok(())
    }

    /// A project file was unpacked to these choices; `own` is its name where it is in the project's folder.
    pub(super) fn opened(&mut self, choices: Choices, name: &str, own: Option<String>) {
        self.names.extend(choices.machine.clone());
        self.project.open(choices, name);
        let stem = name.rsplit_once('.').map(|(stem, _)| stem.to_owned());
        self.saved = Saved { own, stem, words: self.project.choices.prepare().ok() };
        self.version += 1;
    }

    /// These choices were saved in the file of this name.
    pub(super) fn saved(&mut self, choices: &Choices, name: String) {
        self.saved = Saved { stem: None, words: choices.prepare().ok(), own: Some(name) };
        self.version += 1;
    }

    /// A job begins: the words of its command.
    ///
    /// # Errors
    ///
    /// [`WorkbenchError::Busy`] and [`WorkbenchError::NotYet`].
    pub(super) fn begin(&mut self, task: PrinterTask) -> Result<Vec<String>, WorkbenchError> {
        self.idle(|other| task.excludes(other))?;
        let words = self.project.words(task)?;
        let made_of = (self.project.whole(), self.project.basis());
        // Of uploads the last one counts, whether it started the print or not; and none of a file that is made anew.
        let again = |other: PrinterTask| {
            other.task.publishes() && task.excludes(other) && (task.task.publishes() || task.task == Task::Prepare)
        };
        self.runs.retain(|other, _| !again(*other));
        self.runs.insert(task, Run::new(task.task, words.clone(), made_of));
        self.version += 1;
        Ok(words)
    }

    /// A job says something.
    pub(super) fn hear(&mut self, task: PrinterTask, said: JobSaid) {
        self.version += 1;
        let Some(run) = self.runs.get_mut(&task) else { return };
        let document = run.hear(said).cloned();
        let (made_of, running) = (run.made_of.clone(), run.running);
        if let Some(document) = document.filter(|_| task.task == Task::Prepare) {
            self.project.take(made_of.0, made_of.1, document);
        }
        if !running {
            self.jobs.remove(&task);
        }
    }

    /// A running job gets a word.
    ///
    /// # Errors
    ///
    /// [`WorkbenchError::NotRunning`] and [`WorkbenchError::NotStarted`].
    pub(super) fn word(&mut self, task: PrinterTask, word: JobWord) -> Result<(), WorkbenchError> {
        self.version += 1;
        let job = self.jobs.get_mut(&task).ok_or(WorkbenchError::NotRunning)?;
        job.word(word, task.task.prints()).map_err(|source| WorkbenchError::NotStarted { source })?;
        self.runs.get_mut(&task).into_iter().for_each(|run| run.answered(word == JobWord::Stop));
        Ok(())
    }

    /// Whether a print runs.
    pub(super) fn prints(&self) -> bool {
        self.runs.values().any(|run| run.running && run.task.prints())
    }

    /// Ends every job that is no print; the processes of those that are.
    pub(super) fn end(&self) -> Vec<u32> {
        let (prints, others): (Vec<_>, Vec<_>) = self.jobs.iter().partition(|(task, _)| task.task.prints());
        others.into_iter().for_each(|(_, job)| job.end());
        prints.into_iter().map(|(_, job)| job.process).collect()
    }

    /// Takes the document of `trunnion profile list`.
    pub(super) fn take_machines(&mut self, list: Value) {
        let text = |row: &Value, key: &str| row[key].as_str().map(str::to_owned);
        let rows = list.as_array().into_iter().flatten();
        self.names.extend(rows.filter_map(|row| text(row, "file").or_else(|| text(row, "name"))));
        self.machines = list;
        self.version += 1;
    }

    /// The state as the page shows it.
    pub(super) fn document(&self) -> Value {
        let mut document = self.project.document();
        document["runs"] = self.runs.iter().map(|(task, run)| (task.name(), run.document())).collect();
        document["version"] = self.version.into();
        document["folder"] = self.folder.as_str().into();
        let same = self.saved.words.is_some() && self.saved.words == self.project.choices.prepare().ok();
        document["file"] = json!({"name": self.saved.own, "saved": same && self.saved.own.is_some()});
        document["busy"] = self.runs.values().any(|run| run.running).into();
        document
    }

    /// The machines as the page shows them, and the one that was named on the command line.
    pub(super) fn machines(&self) -> Value {
        json!({"machines": self.machines, "own": self.names.first()})
    }
}
