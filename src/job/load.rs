//! What several jobs begin with: models, profiles and plans, read and held against each other.

use std::path::{Path, PathBuf};

use super::plan::spanning;
use super::source::{MachineSource, ModelSource, Source};
use super::{Error, World};
use crate::mesh::{Model, ReadOptions, Unit, read_model};
use crate::planning::{MachineRef, ModelRef, Plan, PlanError, Print, Workpiece, sha256_hex};
use crate::profile::{Origin, Profile, resolve, shipped};

/// A model with what identifies it.
#[derive(Clone, Debug)]
pub struct LoadedModel {
    /// The model.
    pub model: Model,
    /// Its file's name, as given.
    pub file: String,
    /// The hash of its bytes.
    pub sha256: String,
    /// The file it was read from.
    path: Option<PathBuf>,
}

impl LoadedModel {
    pub(super) fn reference(&self) -> ModelRef {
        ModelRef { file: self.file.clone(), sha256: self.sha256.clone(), unit: self.model.unit.short().to_owned() }
    }
}

/// Reads a model; its warnings are told, and kept in it.
///
/// # Errors
///
/// [`Error::Mesh`], and what keeps a file from being read.
pub fn load_model(from: &ModelSource, world: &World<'_>) -> Result<LoadedModel, Error> {
    let bytes = from.source.bytes(world)?;
    let file = from.source.name().into_owned();
    let model = read_model(&bytes, &file, &ReadOptions { unit: from.unit, repair: from.repair })?;
    model.warnings.iter().for_each(|w| world.progress.warning(w));
    Ok(LoadedModel { model, file, sha256: sha256_hex(&bytes), path: from.source.path().map(Path::to_owned) })
}

impl LoadedModel {
    /// A model that was made on the way, as it will be written to `file`.
    pub(super) fn made(file: String, bytes: &[u8]) -> Result<Self, Error> {
        let model = read_model(bytes, &file, &ReadOptions::default())?;
        Ok(Self { model, sha256: sha256_hex(bytes), path: None, file })
    }
}

/// A profile with what identifies it.
#[derive(Clone, Debug)]
pub struct LoadedProfile {
    /// The machine, resolved and checked.
    pub profile: Profile,
    /// Where each value comes from; empty for a profile given as a value.
    pub origin: Origin,
    /// The shipped name or the file, as given.
    pub name: String,
    /// The hash of all its values.
    pub sha256: String,
    /// The file it was read from.
    path: Option<PathBuf>,
}

impl LoadedProfile {
    pub(super) fn reference(&self) -> MachineRef {
        MachineRef { profile: self.name.clone(), sha256: self.sha256.clone() }
    }

    /// Every key with its value, as TOML, and behind it where the value comes from.
    ///
    /// # Errors
    ///
    /// [`Error::Unwritable`] for a value that TOML has no words for.
    pub fn annotated(&self) -> Result<String, Error> {
        let text = toml::to_string(&self.profile).map_err(|e| Error::Unwritable { why: e.to_string() })?;
        let (mut section, mut out) = (String::new(), String::new());
        for line in text.lines() {
            if line.starts_with('[') {
                section = line.trim_matches(['[', ']']).to_owned();
            }
            let key = line.split('=').next().unwrap_or_default().trim();
            let place = self.origin.get(&format!("{section}.{key}")).filter(|_| !line.ends_with("\"\"\""));
            out.push_str(&place.map_or_else(|| line.to_owned(), |place| format!("{line:48} # {place}")));
            out.push('\n');
        }
        Ok(out)
    }
}

/// Reads a profile over the shipped ones and the defaults.
///
/// # Errors
///
/// [`Error::Profile`], and what keeps a file from being read.
pub fn load_profile(from: &MachineSource, world: &World<'_>) -> Result<LoadedProfile, Error> {
    let (name, (profile, origin)) = match from {
        MachineSource::Shipped(name) => {
            let (file, text) = shipped(name)?;
            (name.clone(), resolve(file, text)?)
        }
        MachineSource::Toml(source) => {
            let name = source.name().into_owned();
            let resolved = resolve(&name, &source.text(world)?)?;
            (name, resolved)
        }
        MachineSource::Profile(profile) => {
            profile.validate()?;
            (profile.machine.name.clone(), ((**profile).clone(), Origin::default()))
        }
    };
    let sha256 = sha256_hex(profile.canonical().as_bytes());
    Ok(LoadedProfile { profile, origin, name, sha256, path: from.path().map(Path::to_owned) })
}

/// A plan, and what it was made for.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanSource {
    /// The plan's document.
    pub plan: Source,
    /// The model, where it is no longer where the plan says.
    pub model: Option<Source>,
    /// The profile, where it is no longer where the plan says.
    pub machine: Option<MachineSource>,
}

impl<S: Into<Source>> From<S> for PlanSource {
    fn from(plan: S) -> Self {
        Self { plan: plan.into(), model: None, machine: None }
    }
}

/// A plan with the model and the machine it was made for, all held against each other.
#[derive(Clone, Debug)]
pub struct CheckedPlan {
    /// The plan.
    pub plan: Plan,
    /// The hash of its document.
    pub sha256: String,
    /// Its model.
    pub model: LoadedModel,
    /// Its machine.
    pub machine: LoadedProfile,
}

/// Reads a plan with its model and its profile.
///
/// # Errors
///
/// [`Error::Plan`], stale plans among them, [`Error::NoModel`], [`Error::Misplaced`], and all that reading the model and
/// the profile may give.
pub fn load_plan(from: &PlanSource, world: &World<'_>) -> Result<CheckedPlan, Error> {
    let text = from.plan.text(world)?;
    let name = from.plan.name();
    let plan = Plan::parse(&name, &text)?;
    let recorded = || MachineSource::from(plan.machine.profile.as_str());
    let machine = load_profile(&from.machine.clone().unwrap_or_else(recorded), world)?;
    let machine = spanning(machine, plan.bridge_mm)?;
    let source = match &from.model {
        Some(given) => given.clone(),
        None => find_model(&from.plan, &plan, world)?,
    };
    let unit = plan.model.unit.parse::<Unit>().map_err(|source| Error::Unit { plan: name.into_owned(), source })?;
    // The plan was made from the repaired model if it was repaired; reading it the same way changes nothing else.
    let model = load_model(&ModelSource { source, unit: Some(unit), repair: true }, world)?;
    let checked = CheckedPlan { sha256: sha256_hex(text.as_bytes()), plan, model, machine };
    checked.check()?;
    Ok(checked)
}

/// The model where the plan says it is: from here, from beside the plan, or under its bare name beside the plan.
fn find_model(from: &Source, plan: &Plan, world: &World<'_>) -> Result<Source, Error> {
    let named = PathBuf::from(&plan.model.file);
    let beside = from.path().and_then(Path::parent).unwrap_or(Path::new("."));
    let tried = [named.clone(), beside.join(&named), beside.join(named.file_name().unwrap_or_default())];
    let missing = || Error::NoModel { plan: from.name().into_owned(), model: plan.model.file.clone() };
    tried.into_iter().find(|p| world.files.exists(p)).map(Source::File).ok_or_else(missing)
}

impl CheckedPlan {
    fn check(&self) -> Result<(), Error> {
        let stale = |what: String, planned: &str, actual: &str| {
            let (planned, actual) = (planned.to_owned(), actual.to_owned());
            if planned == actual { Ok(()) } else { Err(PlanError::Stale { what, planned, actual }) }
        };
        let Self { plan, model, machine, .. } = self;
        stale(format!("model {}", plan.model.file), &plan.model.sha256, &model.sha256)?;
        stale(format!("profile {}", plan.machine.profile), &plan.machine.sha256, &machine.sha256)?;
        plan.check(&machine.profile.kinematics(), model.model.parts.len())?;
        Ok(self.workpiece().check(&machine.profile)?)
    }

    /// The files that were read beside the plan itself.
    pub fn inputs(&self) -> impl Iterator<Item = &Path> {
        [self.model.path.as_deref(), self.machine.path.as_deref()].into_iter().flatten()
    }

    /// The plan's prints in their order, each with its slot.
    pub fn prints(&self) -> impl Iterator<Item = (usize, &Print)> {
        self.plan.prints()
    }

    /// The model on its table.
    pub fn workpiece(&self) -> Workpiece<'_> {
        Workpiece::place(&self.model.model, &self.plan.placement)
    }
}
