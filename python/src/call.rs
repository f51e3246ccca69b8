//! What all verbs have in common: keyword arguments, a thread of their own, the files that they read and write.

use std::path::Path;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde_json::Value;
use trunnion::job::{MachineSource, ModelSource, OutputFile, Outputs, World};
use trunnion::world::FileError;

use crate::attended::Attendant;
use crate::given::Given;
use crate::run::{run, run_attended};
use crate::trouble::Trouble;

/// A document, and what the call made beside it, by name.
pub(crate) type Made = (String, Vec<(&'static str, Vec<u8>)>);

/// Threads of a call: what starting them costs grows with their square.
const MOST_THREADS: usize = 1024;

/// What every verb is given: where its words go, and its keyword arguments.
pub(crate) struct Call<'py> {
    told: Bound<'py, PyAny>,
    pub(crate) given: Given<'py>,
    threads: usize,
}

impl<'py> Call<'py> {
    pub(crate) fn of(told: Bound<'py, PyAny>, given: Bound<'py, PyDict>) -> PyResult<Self> {
        let given = Given(given);
        let few = |value: &Bound<'_, PyAny>| value.extract().ok().filter(|threads| *threads <= MOST_THREADS);
        let threads = given.of("threads", &format!("a whole number from 0 to {MOST_THREADS}"), few)?.unwrap_or(0);
        Ok(Self { told, given, threads })
    }

    /// The work on its own thread.
    pub(crate) fn run(
        &self,
        work: impl FnOnce(&World<'_>) -> Result<Made, Trouble> + Send + 'static,
    ) -> PyResult<Made> {
        run(&self.told, self.threads, work)
    }

    /// Work that may print, with Python standing by.
    pub(crate) fn print(
        &self,
        yes: bool,
        work: impl FnOnce(&World<'_>, &Attendant<'_>) -> Result<Made, Trouble> + Send + 'static,
    ) -> PyResult<Made> {
        run_attended(&self.told, self.threads, yes, work)
    }
}

pub(crate) fn text(document: &Value) -> String {
    serde_json::to_string_pretty(document).unwrap_or_default()
}

/// The files that a call reads.
pub(crate) fn read<'a>(
    models: impl IntoIterator<Item = &'a ModelSource>,
    machine: Option<&'a MachineSource>,
) -> Outputs {
    let models = models.into_iter().filter_map(|model| model.source.path());
    Outputs::new(models.chain(machine.and_then(MachineSource::path)))
}

pub(crate) fn claim(path: Option<&Path>, outputs: &mut Outputs) -> Result<Option<OutputFile>, FileError> {
    path.map(|path| outputs.claim(path)).transpose()
}

/// A call that was cancelled ends here, before it writes.
pub(crate) fn before_writing(world: &World<'_>) {
    let _ = world.clock.now();
}
