//! What was chosen before, step by step, and what was taken back. Pure values.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::{Value, json};

use super::WorkbenchError;
use super::choices::Choices;

/// Steps that can be taken back.
const MOST_STEPS: usize = 200;

/// What a step was.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct StepName {
    /// `add`, `remove`, `copies`, or the name of a choice.
    pub(super) what: &'static str,
    /// The model's name, or the value that was chosen.
    pub(super) name: String,
}

impl StepName {
    /// The name as the page gets it.
    pub(super) fn document(&self) -> Value {
        json!({"what": self.what, "name": self.name})
    }
}

/// The steps before now, and behind it those that were taken back.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct History {
    past: Vec<(Choices, StepName)>,
    future: Vec<(Choices, StepName)>,
}

impl History {
    /// A step from `before`; what was taken back is gone.
    pub(super) fn step(&mut self, before: Choices, name: StepName) {
        self.future.clear();
        if self.past.len() == MOST_STEPS {
            self.past.remove(0);
        }
        self.past.push((before, name));
    }

    /// What was chosen before the last step.
    ///
    /// # Errors
    ///
    /// [`WorkbenchError::NoStep`].
    pub(super) fn past(&self) -> Result<&Choices, WorkbenchError> {
        self.past.last().map(|(choices, _)| choices).ok_or(WorkbenchError::NoStep { what: "undo" })
    }

    /// What was chosen before the last step was taken back.
    ///
    /// # Errors
    ///
    /// [`WorkbenchError::NoStep`].
    pub(super) fn future(&self) -> Result<&Choices, WorkbenchError> {
        self.future.last().map(|(choices, _)| choices).ok_or(WorkbenchError::NoStep { what: "redo" })
    }

    /// The last step is taken back from `now`.
    pub(super) fn undo(&mut self, now: Choices) {
        self.future.extend(self.past.pop().map(|(_, name)| (now, name)));
    }

    /// The step that was taken back last is made again from `now`.
    pub(super) fn redo(&mut self, now: Choices) {
        self.past.extend(self.future.pop().map(|(_, name)| (now, name)));
    }

    /// The step that can be taken back.
    pub(super) fn last(&self) -> Option<&StepName> {
        self.past.last().map(|(_, name)| name)
    }

    /// The step that can be made again.
    pub(super) fn next(&self) -> Option<&StepName> {
        self.future.last().map(|(_, name)| name)
    }

    /// Models that have another file now.
    pub(super) fn moved(&mut self, files: &BTreeMap<u64, String>) {
        self.past.iter_mut().chain(&mut self.future).for_each(|(choices, _)| choices.moved(files));
    }

    /// Numbers of all models that a step could bring back.
    pub(super) fn models(&self) -> BTreeSet<u64> {
        self.past.iter().chain(&self.future).flat_map(|(choices, _)| &choices.models).map(|model| model.id).collect()
    }
}
