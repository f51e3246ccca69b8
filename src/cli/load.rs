//! What several verbs begin with: reading models, profiles and plans.

use std::path::{Path, PathBuf};

use super::args::{BedArgs, MachineArgs, ModelArgs, PlanRef};
use super::{Console, Failure, files};
use crate::mesh::{Model, ReadOptions, Unit, read_model};
use crate::planning::{MachineRef, ModelRef, Plan, PlanError, Workpiece, sha256_hex};
use crate::profile::{Origin, Profile, resolve, shipped};

/// A model with what identifies it.
pub(super) struct LoadedModel {
    pub(super) model: Model,
    pub(super) file: PathBuf,
    pub(super) sha256: String,
}

impl LoadedModel {
    pub(super) fn reference(&self) -> ModelRef {
        ModelRef {
            file: self.file.display().to_string(),
            sha256: self.sha256.clone(),
            unit: self.model.unit.short().to_owned(),
        }
    }
}

pub(super) fn model(args: &ModelArgs, console: &Console) -> Result<LoadedModel, Failure> {
    let unit = args.unit.as_deref().map(str::parse::<Unit>).transpose().map_err(|e| Failure::Usage(e.to_string()))?;
    read(&args.model, unit, args.repair, console)
}

fn read(path: &Path, unit: Option<Unit>, repair: bool, console: &Console) -> Result<LoadedModel, Failure> {
    let bytes = files::read(path)?;
    let model = read_model(&bytes, &path.display().to_string(), &ReadOptions { unit, repair })?;
    model.warnings.iter().for_each(|w| console.warning(w));
    Ok(LoadedModel { model, file: path.to_owned(), sha256: sha256_hex(&bytes) })
}

/// A profile with what identifies it.
pub(super) struct LoadedProfile {
    pub(super) profile: Profile,
    pub(super) origin: Origin,
    pub(super) name: String,
    pub(super) sha256: String,
}

impl LoadedProfile {
    pub(super) fn reference(&self) -> MachineRef {
        MachineRef { profile: self.name.clone(), sha256: self.sha256.clone() }
    }
}

pub(super) fn machine(args: &MachineArgs) -> Result<LoadedProfile, Failure> {
    profile(&args.profile)
}

/// A shipped name, or a file where the word looks like a path or is one.
pub(super) fn profile(name: &str) -> Result<LoadedProfile, Failure> {
    let is_file = name.ends_with(".toml") || name.contains(['/', '\\']);
    let (file, text) = if is_file {
        (name.to_owned(), files::read_text(Path::new(name))?)
    } else {
        let (file, text) = shipped(name)?;
        (file.to_owned(), text.to_owned())
    };
    let (profile, origin) = resolve(&file, &text)?;
    let sha256 = sha256_hex(serde_json::to_string(&profile).unwrap_or_default().as_bytes());
    Ok(LoadedProfile { profile, origin, name: name.to_owned(), sha256 })
}

/// A plan with the model and the machine it was made for, all checked against each other.
pub(super) struct LoadedPlan {
    pub(super) plan: Plan,
    pub(super) sha256: String,
    pub(super) model: LoadedModel,
    pub(super) machine: LoadedProfile,
}

pub(super) fn plan(path: &Path, refs: &PlanRef, console: &Console) -> Result<LoadedPlan, Failure> {
    let text = files::read_text(path)?;
    let plan = Plan::parse(&path.display().to_string(), &text)?;
    let machine = profile(refs.profile.as_deref().unwrap_or(&plan.machine.profile))?;
    let model_path = match &refs.model {
        Some(given) => given.clone(),
        None => find_model(path, &plan)?,
    };
    let unit = plan.model.unit.parse::<Unit>().map_err(|e| Failure::Usage(format!("{}: {e}", path.display())))?;
    // The plan was made from the repaired model if it was repaired; reading it the same way changes nothing else.
    let model = read(&model_path, Some(unit), true, console)?;
    let stale = |what: String, planned: &str, actual: &str| {
        let (planned, actual) = (planned.to_owned(), actual.to_owned());
        if planned == actual { Ok(()) } else { Err(PlanError::Stale { what, planned, actual }) }
    };
    stale(format!("model {}", plan.model.file), &plan.model.sha256, &model.sha256)?;
    stale(format!("profile {}", plan.machine.profile), &plan.machine.sha256, &machine.sha256)?;
    plan.check(&machine.profile.kinematics(), model.model.parts.len())?;
    Workpiece::place(&model.model, &plan.placement).check(&machine.profile)?;
    Ok(LoadedPlan { sha256: sha256_hex(text.as_bytes()), plan, model, machine })
}

/// The model where the plan says it is: from here, from beside the plan, or under its bare name beside the plan.
fn find_model(plan_path: &Path, plan: &Plan) -> Result<PathBuf, Failure> {
    let named = PathBuf::from(&plan.model.file);
    let beside = plan_path.parent().unwrap_or(Path::new("."));
    let tried = [named.clone(), beside.join(&named), beside.join(named.file_name().unwrap_or_default())];
    tried.into_iter().find(|p| files::exists(p)).ok_or_else(|| {
        Failure::Usage(format!(
            "{}: the model {} is not there; say where with --model",
            plan_path.display(),
            plan.model.file
        ))
    })
}

impl LoadedPlan {
    pub(super) fn workpiece(&self) -> Workpiece<'_> {
        Workpiece::place(&self.model.model, &self.plan.placement)
    }
}

/// Beyond this the `f32` of an STL no longer holds a micron, mm.
const LARGEST_BED_MM: f64 = 5000.0;

/// The bed's size.
pub(super) fn bed(args: &BedArgs) -> Result<[f64; 2], Failure> {
    let number = |t: &str| t.trim().parse::<f64>().ok().filter(|v| *v > 0.0 && *v <= LARGEST_BED_MM);
    let parsed = args.bed.split_once(['x', 'X', ',']).and_then(|(x, y)| Some([number(x)?, number(y)?]));

    parsed.ok_or_else(|| {
        Failure::Usage(format!(
            "--bed {}: give width x depth in mm up to {LARGEST_BED_MM}, for example 250x210",
            args.bed
        ))
    })
}
