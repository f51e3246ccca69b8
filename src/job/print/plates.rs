//! What does not fit on a table at once: plate after plate, each with a model, a plan and a program of its own.

use std::path::{Path, PathBuf};

use super::error::PrintError;
use super::prepare::{PrepareRequest, PrepareResult, prepare};
use crate::input::{ModelSource, load_profile};
use crate::strategy::{Arrangement, Cutting, PlanOptions, PlateModel, PlateQueue, StrategyError, WaysOut};
use crate::world::{OutputFile, Outputs, World};

/// The right to write plates into a folder: `plate-N.3mf`, its plan and its G-code; of one whose solids are cut or moved the model as it is printed, too.
pub struct PlateFolder {
    folder: PathBuf,
    outputs: Outputs,
    first: Option<PlateOutputs>,
}

struct PlateOutputs {
    model: OutputFile,
    printed: OutputFile,
    plan: OutputFile,
    gcode: OutputFile,
}

impl PlateFolder {
    /// Makes the folder if it is not there, and claims the files of the first plate in it, so that what cannot be written is known before the work.
    ///
    /// # Errors
    ///
    /// What [`Outputs::folder`] and [`Outputs::claim`] say.
    pub fn claim(folder: &Path, mut outputs: Outputs) -> Result<Self, PrintError> {
        outputs.folder(folder)?;
        let first = Some(PlateOutputs::claim(folder, 1, &mut outputs)?);
        Ok(Self { folder: folder.to_owned(), outputs, first })
    }

    /// The programs of an earlier run, to be set aside: which of them belong to this one could not be told.
    ///
    /// # Errors
    ///
    /// What [`Outputs::claim`] says.
    pub fn earlier(&self) -> Result<Vec<OutputFile>, PrintError> {
        let path = |number: usize| self.folder.join(format!("plate-{number}.gcode"));
        let there = (1..).map(path).take_while(|path| path.is_file());
        Ok(there.map(|path| Outputs::new([]).claim(&path)).collect::<Result<_, _>>()?)
    }

    fn plate(&mut self, number: usize) -> Result<PlateOutputs, PrintError> {
        match self.first.take() {
            Some(first) => Ok(first),
            None => PlateOutputs::claim(&self.folder, number, &mut self.outputs),
        }
    }
}

impl PlateOutputs {
    fn claim(folder: &Path, number: usize, outputs: &mut Outputs) -> Result<Self, PrintError> {
        let mut claim = |end: &str| outputs.claim(&folder.join(format!("plate-{number}.{end}")));
        let (model, printed, plan, gcode) = (claim("3mf")?, claim("parts.3mf")?, claim("plan.json")?, claim("gcode")?);
        Ok(Self { model, printed, plan, gcode })
    }

    /// What is asked of the main job for this plate, whose solids were set up already.
    fn request(&self, whole: &PrepareRequest, folder: &Path) -> PrepareRequest {
        let file = self.printed.path().display().to_string();
        let cutting = match whole.ways.cutting {
            Cutting::Never => Cutting::Never,
            Cutting::Auto { .. } => Cutting::Auto { file: file.clone() },
        };
        PrepareRequest {
            model: ModelSource::from(self.model.path()),
            arrangement: Arrangement { snap_mm: 0.0, file: Some(file), ..Arrangement::default() },
            plan: PlanOptions { kept_in: Some(folder.to_owned()), ..whole.plan.clone() },
            ways: WaysOut { cutting, ..whole.ways.clone() },
            ..whole.clone()
        }
    }
}

/// What happens while plates are made.
#[derive(Clone, Copy, Debug)]
pub enum PlateEvent<'a> {
    /// One is begun.
    Begun {
        /// Which file, from 1.
        number: usize,
        /// What is on it.
        plate: &'a PlateModel,
    },
    /// It has no plan so: what is on it is laid out again, further apart.
    MoreRoom,
    /// It was written.
    Made {
        /// Its program.
        output: &'a Path,
        /// Its model.
        model: &'a Path,
        /// What is on it.
        plate: &'a PlateModel,
        /// How it came about.
        done: &'a PrepareResult,
    },
}

/// Prepares models on as many plates as they take. A plate is written as soon as it is proved, and stays whatever becomes of the next.
///
/// # Errors
///
/// What setting up the models may say, and what [`prepare`] says of the first plate that cannot be printed.
pub fn prepare_plates(
    request: &PrepareRequest,
    mut files: PlateFolder,
    told: &mut dyn FnMut(PlateEvent<'_>),
    world: &World<'_>,
) -> Result<(), PrintError> {
    let machine = load_profile(&request.machine, world)?;
    let mut queue = PlateQueue::of(&request.model, &request.arrangement, machine, world)?;
    let mut number = 1;
    let mut to = files.plate(number)?;
    while let Some(plate) = queue.next_plate() {
        told(PlateEvent::Begun { number, plate: &plate });
        to.model.write(&plate.bytes)?;
        let done = match prepare(&to.request(request, &files.folder), world) {
            Err(PrintError::Strategy(StrategyError::NoPlan(_))) if queue.with_more_room(&plate) => {
                told(PlateEvent::MoreRoom);
                continue;
            }
            done => done?,
        };
        let arranged = done.planned.arranged.as_ref().map(|arranged| &arranged.bytes);
        let printed = done.cut.as_ref().map(|cut| &cut.bytes).or(arranged);
        printed.map(|bytes| to.printed.write(bytes)).transpose()?;
        to.plan.write(done.planned.plan.plan.to_text().as_bytes())?;
        to.gcode.write(done.gcode.program())?;
        told(PlateEvent::Made { output: to.gcode.path(), model: to.model.path(), plate: &plate, done: &done });
        number += 1;
        to = files.plate(number)?;
    }
    Ok(())
}
