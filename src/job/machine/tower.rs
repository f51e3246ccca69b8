//! A calibration tower, printable on one machine with proof, and what its measurements say.

use std::path::Path;

use super::calibrate::{CalibrateRequest, CalibrateResult, Written, calibrate};
use super::error::MachineError;
use crate::calibrate::{Readings, TOWER_REPEATS_MM, Tower, TowerDesign, TowerError, TowerFit, fit_tower, tower_errors};
use crate::input::{BadSetting, CheckedPlan, LoadedModel, LoadedProfile, MachineSource, Source, load_table};
use crate::job::print::{PrintError, Prints, RewriteRequest, SliceRequest, SlicingOptions, Verified, rewrite, slice};
use crate::mesh::threemf;
use crate::pictures;
use crate::planning::{MachineRef, ModelRef, PartRef, Placement, Plan, Print, TimeSlot};
use crate::slicing::SlicerChoice;
use crate::view::Drawing;
use crate::world::{OutputFile, Outputs, Silent, World};

/// A tower for a machine.
#[derive(Clone, Debug)]
pub struct TowerRequest {
    /// The machine.
    pub machine: MachineSource,
    /// The tilt's word of its blocks, degrees; `None` for the steepest that can be printed.
    pub tilt_deg: Option<f64>,
    /// Standard deviation of one reading of the callipers, mm.
    pub repeats_mm: f64,
}

impl TowerRequest {
    /// As the command does it without flags.
    pub fn new(machine: impl Into<MachineSource>) -> Self {
        Self { machine: machine.into(), tilt_deg: None, repeats_mm: TOWER_REPEATS_MM }
    }
}

/// A tower that is printed with proof.
#[derive(Clone, Debug)]
pub struct TowerResult {
    /// The machine.
    pub machine: LoadedProfile,
    /// The tower.
    pub tower: Tower,
    /// Its model, a 3MF: [`Self::MODEL`].
    pub model: Vec<u8>,
    /// Its plan; the model is beside it.
    pub plan: CheckedPlan,
    /// Its program, proved.
    pub gcode: Verified<Vec<u8>>,
    /// The file to be filled in.
    pub form: String,
    /// What it will tell: name, standard error (mm or degrees) where it tells it, and whether it is an angle.
    pub errors: Vec<(String, Option<f64>, bool)>,
}

impl TowerResult {
    /// What its model is called, beside its plan.
    pub const MODEL: &'static str = "tower.3mf";

    /// The tower with its numbered dimensions.
    pub fn sheet(&self) -> Drawing {
        pictures::tower_sheet(&self.tower, &self.machine.name)
    }

    /// How long it is printed, s.
    pub fn seconds(&self) -> f64 {
        self.gcode.report().map_or(0.0, |report| report.seconds_print)
    }
}

/// What `--repeats-to` may be, mm.
const REPEATS_MM: [f64; 2] = [0.005, 0.5];

/// Makes the tower that tells most of those which pass verification on this machine; its plan is to be kept in the folder `kept_in`.
///
/// # Errors
///
/// What cannot be read, [`TowerError::NotSquare`], [`TowerError::Range`], [`TowerError::NoRoom`], and [`TowerError::NotProved`] where none
/// passes.
pub fn tower(request: &TowerRequest, kept_in: Option<&Path>, world: &World<'_>) -> Result<TowerResult, MachineError> {
    BadSetting::within("repeats-to", request.repeats_mm, " mm", REPEATS_MM)?;
    let machine = load_table(&request.machine, world)?;
    let quiet = World { progress: &Silent, ..*world };
    let candidates = TowerDesign::candidates(&machine.profile, &machine.name, request.tilt_deg)?;
    let bar = world.progress.begin("tower", candidates.len());
    let mut first = None;
    for (index, design) in candidates.into_iter().enumerate() {
        let tower = Tower::of(&machine.profile.kinematics(), design);
        match proved(&tower, &machine, kept_in, &quiet) {
            Ok(Proved { model, plan, gcode }) => {
                let form = tower.form(&machine.profile, request.repeats_mm);
                let errors = tower_errors(&machine.profile, &tower, request.repeats_mm);
                return Ok(TowerResult { machine, tower, model, plan, gcode, form, errors });
            }
            Err(why) => first = first.or(Some(why)),
        }
        bar.at(index + 1);
    }
    let why = first.map_or_else(String::new, |why| why.to_string());
    Err(TowerError::NotProved { profile: machine.name, why }.into())
}

/// A tower that passed.
struct Proved {
    model: Vec<u8>,
    plan: CheckedPlan,
    gcode: Verified<Vec<u8>>,
}

/// The tower by the ordinary way: model and plan, sliced, rewritten and replayed.
fn proved(
    tower: &Tower,
    machine: &LoadedProfile,
    kept_in: Option<&Path>,
    world: &World<'_>,
) -> Result<Proved, PrintError> {
    let meshes: Vec<_> = tower.blocks.iter().map(|block| (block.name.to_owned(), block.mesh())).collect();
    let objects: Vec<_> = meshes.iter().map(|(name, mesh)| (name.clone(), mesh)).collect();
    let bytes = threemf(&objects);
    let model = LoadedModel::made(TowerResult::MODEL.to_owned(), &bytes)?;
    let plan = plan_of(tower, &model, machine.reference(kept_in, world), machine);
    let plan = CheckedPlan { sha256: plan.sha256(), plan, model, machine: machine.clone() };
    plan.check()?;
    let options = SlicingOptions { slicer: SlicerChoice::BuiltIn, ..SlicingOptions::default() };
    let prints = Prints::of(&plan, options.bed);
    let sliced = slice(&SliceRequest { plan: &plan, prints: &prints, options: &options }, world)?.sliced;
    let named = prints.names.iter().zip(sliced);
    let sliced = named.map(|(name, bytes)| Source::Bytes { name: format!("{name}.gcode"), bytes }).collect();
    let request = RewriteRequest { plan: &plan, sliced, print: None, bed: options.bed };
    let gcode = rewrite(&request, world)?.gcode;
    Ok(Proved { model: bytes, plan, gcode })
}

/// A slot for each of the four poses.
fn plan_of(tower: &Tower, model: &LoadedModel, reference: MachineRef, machine: &LoadedProfile) -> Plan {
    let table = machine.profile.kinematics();
    let words = tower.words_deg();
    let print = |part: usize, step: usize| {
        let [tilt_deg, rotation_deg] = words[step];
        let upright = Print { part, up: [0.0, 0.0, 1.0], tilt_deg, rotation_deg, supports: None };
        let pose = upright.pose(&table);
        let up = table.forward(pose).inverse().dir(crate::geom::Dir::z());
        Print::new(part, up, pose, &table)
    };
    let slot = |step: usize| {
        let parts = tower.blocks.iter().enumerate().filter(|(_, block)| block.step == step);
        TimeSlot { id: step, prints: parts.map(|(part, _)| print(part, step)).collect() }
    };
    Plan {
        format: Plan::FORMAT.to_owned(),
        version: Plan::VERSION,
        made_by: format!("trunnion {}", env!("CARGO_PKG_VERSION")),
        model: ModelRef { file: model.file.clone(), sha256: model.sha256.clone(), unit: "mm".to_owned() },
        machine: reference,
        placement: Placement { origin_mm: [0.0; 3], turn_deg: 0.0 },
        bridge_mm: None,
        parts: model.model.parts.iter().map(|part| PartRef { id: part.id, name: part.name.clone() }).collect(),
        slots: (0..words.len()).map(slot).collect(),
        machine_values: machine.is_own().then(|| Box::new(machine.profile.clone())),
    }
}

/// What was measured of a tower.
#[derive(Clone, Debug)]
pub struct TowerReading {
    /// The machine, as its profile said when the tower was printed.
    pub machine: LoadedProfile,
    /// The form's file, as given.
    pub file: String,
    /// What was measured.
    pub readings: Readings,
    /// What it comes to.
    pub fit: TowerFit,
    /// Why no profile can hold the result, if none can.
    pub unfit: Option<String>,
}

/// What a file of measurements says, of touches or of a tower.
#[derive(Clone, Debug)]
pub enum Calibrated {
    /// Touches.
    Touches(Box<CalibrateResult>),
    /// A tower.
    Tower(Box<TowerReading>),
}

impl Calibrated {
    /// Why nothing may be written; `None` where it may.
    pub fn refusal(&self) -> Option<String> {
        match self {
            Self::Touches(done) => done.refusal(),
            Self::Tower(done) => done.unfit.clone(),
        }
    }

    /// A profile that extends the machine's, kept in the folder `kept_in`; without one, its keys alone.
    pub fn profile(&self, kept_in: Option<&Path>, world: &World<'_>) -> String {
        match self {
            Self::Touches(done) => done.profile(kept_in, world),
            Self::Tower(done) => done.profile(kept_in, world),
        }
    }
}

/// Fits a machine to its measurements, whichever they are.
///
/// # Errors
///
/// As [`calibrate`](super::calibrate()) and [`read_tower`].
pub fn calibrate_by(request: &CalibrateRequest, world: &World<'_>) -> Result<Calibrated, MachineError> {
    let text = request.touches.text(world)?;
    let touches = Source::Bytes { name: request.touches.name().into_owned(), bytes: text.into_bytes() };
    let request = CalibrateRequest { touches, ..request.clone() };
    if Readings::is_tower(&request.touches.text(world)?) {
        return Ok(Calibrated::Tower(Box::new(read_tower(&request.machine, &request.touches, world)?)));
    }
    Ok(Calibrated::Touches(Box::new(calibrate(&request, world)?)))
}

/// The right to write a tower's form, where none is there yet: what was typed into one is never overwritten.
///
/// # Errors
///
/// [`MachineError::There`], and as [`Outputs::claim`].
pub fn keep_form(path: &Path, outputs: &mut Outputs, world: &World<'_>) -> Result<OutputFile, MachineError> {
    if world.files.exists(path) {
        return Err(MachineError::There { path: path.to_owned() });
    }
    Ok(outputs.claim(path)?)
}

/// Reads a tower's measurements.
///
/// # Errors
///
/// What cannot be read, and [`TowerError`].
pub fn read_tower(machine: &MachineSource, form: &Source, world: &World<'_>) -> Result<TowerReading, MachineError> {
    let machine = load_table(machine, world)?;
    let file = form.name().into_owned();
    let readings = Readings::parse(&file, &form.text(world)?)?;
    let fit = fit_tower(&machine.profile, &machine.name, &file, &readings)?;
    let mut done = TowerReading { machine, file, readings, fit, unfit: None };
    done.unfit = done.written().profile().validate().err().map(|error| error.to_string());
    Ok(done)
}

impl TowerReading {
    /// The keys as they are written.
    pub fn written(&self) -> Written<'_> {
        Written { machine: &self.machine, table: &self.fit.table, misaligned: false }
    }

    /// A profile that extends the machine's, kept in the folder `kept_in`; without one, its keys alone.
    pub fn profile(&self, kept_in: Option<&Path>, world: &World<'_>) -> String {
        let count = self.fit.deviations.len();
        let head = format!(
            "# From {count} dimensions of a tower in {:?}, which scatter by {:.3} mm (trunnion profile calibrate).\n",
            self.file, self.fit.rms_mm
        );
        self.written().text(&head, &self.fit.estimates, kept_in, world)
    }
}
