//! What several jobs begin with: models, profiles and plans, read and held against each other.

use std::path::{Path, PathBuf};

use super::source::{MachineSource, ModelSource, Source, near_file};
use super::{BadExtends, BadSetting, InputError, memory};
use crate::assembly::as_printed;
use crate::mesh::{Model, ReadOptions, Unit, read_model, read_project};
use crate::planning::{MachineRef, ModelRef, Plan, PlanError, Print, Workpiece, sha256_hex};
use crate::profile::{Base, Origin, Profile, ProfileError, check_number, resolve, resolve_over, shipped};
use crate::spelling::unnamed;
use crate::world::World;

/// What the names of model files end in.
const ENDINGS: [&str; 5] = ["stl", "obj", "off", "3mf", "parts"];

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
    /// As a plan that is kept in a folder names it.
    pub(crate) fn reference(&self, kept_in: Option<&Path>, world: &World<'_>) -> ModelRef {
        let file = named(&self.file, self.path.as_deref(), kept_in, world);
        ModelRef { file, sha256: self.sha256.clone(), unit: self.model.unit.short().to_owned() }
    }

    /// What people call a part: its name where the file has one for it, else, where it is the only one, that of the file.
    pub fn called(&self, part: usize) -> String {
        let name = &self.model.parts[part].name;
        if self.model.parts.len() > 1 || *name != unnamed(part) {
            return name.clone();
        }
        let mut stem =
            Path::new(&self.file).file_name().map_or(name.clone(), |file| file.to_string_lossy().into_owned());
        while let Some((rest, end)) = stem.rsplit_once('.')
            && ENDINGS.contains(&end.to_ascii_lowercase().as_str())
            && !rest.is_empty()
        {
            stem = rest.to_owned();
        }
        stem
    }
}

/// Reads a model; its warnings are told, and kept in it.
///
/// # Errors
///
/// [`InputError::Mesh`], and what keeps a file from being read.
pub fn load_model(from: &ModelSource, world: &World<'_>) -> Result<LoadedModel, InputError> {
    let loaded = read_quietly(from, world)?;
    tell(&loaded.model.warnings, world);
    Ok(loaded)
}

pub(crate) fn tell(warnings: &[String], world: &World<'_>) {
    warnings.iter().for_each(|text| world.progress.warning(text));
}

/// The same for a job that changes the pose: the warnings about it are not told.
pub(crate) fn load_unposed(from: &ModelSource, world: &World<'_>) -> Result<LoadedModel, InputError> {
    let loaded = read_quietly(from, world)?;
    world.progress.reached(&loaded);
    loaded.model.warnings_in_any_pose().for_each(|text| world.progress.warning(text));
    Ok(loaded)
}

/// As [`load_model`], for a job whose first word is what it has read.
pub(crate) fn load_aloud(from: &ModelSource, world: &World<'_>) -> Result<LoadedModel, InputError> {
    let loaded = read_quietly(from, world)?;
    world.progress.reached(&loaded);
    tell(&loaded.model.warnings, world);
    Ok(loaded)
}

/// Reads a model; its warnings are kept in it, and not told.
pub(crate) fn read_quietly(from: &ModelSource, world: &World<'_>) -> Result<LoadedModel, InputError> {
    let bytes = from.source.bytes(world)?;
    let file = from.source.name().into_owned();
    let options = ReadOptions { unit: from.unit, repair: from.repair, plates: from.plates };
    memory::of_model(&file, &bytes, from.plates, world)?;
    let model = as_printed(read_project(&bytes, &file, &options)?)?;
    Ok(LoadedModel { model, file, sha256: sha256_hex(&bytes), path: from.source.path().map(Path::to_owned) })
}

impl LoadedModel {
    /// Some of its parts, as if there were no others; for planning alone.
    pub(crate) fn only(&self, parts: &[usize]) -> Self {
        let of = |&part: &usize| (self.model.parts[part].name.clone(), self.model.parts[part].mesh.clone());
        let model = Model::from_parts(parts.iter().map(of).collect());
        Self { model: Model { unit: self.model.unit, ..model }, ..self.clone() }
    }

    /// One part alone.
    ///
    /// # Errors
    ///
    /// [`BadSetting::NoSuchPart`].
    pub(crate) fn alone(&self, part: usize) -> Result<Self, BadSetting> {
        let last = self.model.parts.len() - 1;
        if part > last {
            return Err(BadSetting::NoSuchPart { name: "part", given: part, last, model: self.file.clone() });
        }
        Ok(self.only(&[part]))
    }

    /// A model that was made on the way, as it will be written to `file`.
    pub(crate) fn made(file: String, bytes: &[u8]) -> Result<Self, InputError> {
        let model = read_model(bytes, &file, &ReadOptions::default())?;
        Ok(Self { model, sha256: sha256_hex(bytes), path: Some(PathBuf::from(&file)), file })
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
    /// As a plan that is kept in a folder names it.
    pub(crate) fn reference(&self, kept_in: Option<&Path>, world: &World<'_>) -> MachineRef {
        let profile = named(&self.name, self.path.as_deref(), kept_in, world);
        MachineRef { profile, sha256: self.sha256.clone() }
    }

    /// Whether it is none of the shipped ones.
    pub(crate) fn is_own(&self) -> bool {
        let shipped = shipped(&self.name).and_then(|(file, text)| resolve(file, text));
        !shipped.is_ok_and(|(profile, _)| profile == self.profile)
    }

    /// Every key with its value, as TOML, and behind it where the value comes from.
    ///
    /// # Errors
    ///
    /// [`InputError::Unwritable`] for a value that TOML has no words for.
    pub fn annotated(&self) -> Result<String, InputError> {
        let text = toml::to_string(&self.profile).map_err(|e| InputError::Unwritable { why: e.to_string() })?;
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

/// The machine with the span that is asked for in the place of its own.
///
/// # Errors
///
/// [`BadSetting::Number`] for a span that no profile may have.
pub(crate) fn spanning(mut machine: LoadedProfile, bridge_mm: Option<f64>) -> Result<LoadedProfile, BadSetting> {
    if let Some(mm) = bridge_mm {
        check_number("process.bridge_mm", mm).map_err(|source| BadSetting::Number { name: "bridge", source })?;
        machine.profile.process.bridge_mm = mm;
    }
    Ok(machine)
}

fn named(name: &str, path: Option<&Path>, kept_in: Option<&Path>, world: &World<'_>) -> String {
    let from = |(path, folder): (&Path, &Path)| world.files.seen_from(path, folder).to_string_lossy().into_owned();
    path.zip(kept_in).map_or_else(|| name.to_owned(), from)
}

/// Reads a profile over the shipped ones and the defaults.
///
/// # Errors
///
/// [`InputError::Profile`], and what keeps a file from being read.
pub fn load_profile(from: &MachineSource, world: &World<'_>) -> Result<LoadedProfile, InputError> {
    let mut path = from.path().map(Path::to_owned);
    let (name, (profile, origin)) = match from {
        MachineSource::Shipped(name) => match own_file(name, world) {
            Some(own) => {
                let resolved = resolve_over(&own_layers(&Source::File(own.clone()), world)?)?;
                path = Some(own);
                (name.clone(), resolved)
            }
            None => {
                let (file, text) =
                    shipped(name).map_err(|error| not_found(error.with_own(name, own_names(world)), world))?;
                (name.clone(), resolve(file, text)?)
            }
        },
        MachineSource::Toml(source) => {
            let resolved = resolve_over(&own_layers(source, world)?)?;
            (source.name().into_owned(), resolved)
        }
        MachineSource::Profile(profile) => {
            profile.validate()?;
            (profile.machine.name.clone(), ((**profile).clone(), Origin::default()))
        }
    };
    let sha256 = sha256_hex(profile.canonical().as_bytes());
    Ok(LoadedProfile { profile, origin, name, sha256, path })
}

/// Why there is no such profile: where no profile's name is near, a file's may be.
fn not_found(error: ProfileError, world: &World<'_>) -> InputError {
    match &error {
        ProfileError::NoSuchProfile { name, nearest: None, .. } => {
            match near_file(Path::new(name), world, |file| file.ends_with(".toml")) {
                Some(near) => InputError::Absent { file: name.clone(), near: Some(near) },
                None => error.into(),
            }
        }
        _ => error.into(),
    }
}

/// The same of a machine whose table tilts and turns.
///
/// # Errors
///
/// [`InputError::Chain`] for any other chain, and those of [`load_profile`].
pub fn load_table(from: &MachineSource, world: &World<'_>) -> Result<LoadedProfile, InputError> {
    let loaded = load_profile(from, world)?;
    if loaded.profile.kinematics().is_table() { Ok(loaded) } else { Err(InputError::Chain { profile: loaded.name }) }
}

/// The user's own profile of that name; a shipped one of the same name goes first.
fn own_file(name: &str, world: &World<'_>) -> Option<PathBuf> {
    let path = world.files.own_profiles()?.join(format!("{name}.toml"));
    (shipped(name).is_err() && world.files.exists(&path)).then_some(path)
}

fn own_names(world: &World<'_>) -> Vec<String> {
    let files = world.files.own_profiles().map(|folder| world.files.toml_files(&folder)).unwrap_or_default();
    files.iter().filter_map(|path| Some(path.file_stem()?.to_string_lossy().into_owned())).collect()
}

/// The user's own profiles, each with its name and its file, and why it cannot be used where it cannot.
pub fn own_profiles(world: &World<'_>) -> Vec<(String, PathBuf, Result<LoadedProfile, InputError>)> {
    let folder = world.files.own_profiles().unwrap_or_default();
    let of = |name: String| {
        let path = folder.join(format!("{name}.toml"));
        let loaded = if shipped(&name).is_ok() {
            Err(InputError::Hidden { path: path.clone(), name: name.clone() })
        } else {
            load_profile(&MachineSource::Shipped(name.clone()), world)
        };
        (name, path, loaded)
    };
    own_names(world).into_iter().map(of).collect()
}

/// Files that may extend each other, at most.
const MOST_LAYERS: usize = 8;

/// A profile's file and those that it extends, the lowest first.
fn own_layers(top: &Source, world: &World<'_>) -> Result<Vec<(String, String)>, InputError> {
    let mut layers = vec![(top.name().into_owned(), top.text(world)?)];
    let mut folder = top.path().and_then(Path::parent).map(Path::to_owned);
    loop {
        let (file, text) = &layers[layers.len() - 1];
        let (named, path) = match Base::of(file, text)? {
            Base::File(named) => (named.clone(), folder.as_ref().map(|beside| beside.join(named))),
            Base::Shipped(name) => match own_file(&name, world) {
                Some(path) => (name, Some(path)),
                None => break,
            },
            Base::Defaults => break,
        };
        let wrong = |fault: BadExtends| InputError::Layers { file: file.clone(), fault };
        let Some(path) = path else { return Err(wrong(BadExtends::NoFile { named })) };
        if layers.len() >= MOST_LAYERS {
            let comes_back = layers[..layers.len() - 1].iter().any(|(_, earlier)| earlier == text);
            let too_many = BadExtends::TooMany { most: MOST_LAYERS };
            return Err(wrong(if comes_back { BadExtends::Circle { named } } else { too_many }));
        }
        folder = path.parent().map(Path::to_owned);
        layers.push((path.to_string_lossy().into_owned(), Source::File(path).text(world)?));
    }
    layers.reverse();
    Ok(layers)
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
/// [`InputError::Plan`], stale plans among them, [`InputError::NoModel`], [`InputError::Misplaced`], and all that reading the model and
/// the profile may give.
pub fn load_plan(from: &PlanSource, world: &World<'_>) -> Result<CheckedPlan, InputError> {
    let text = from.plan.text(world)?;
    let name = from.plan.name();
    let plan = Plan::parse(&name, &text)?;
    let machine = match &from.machine {
        Some(given) => load_profile(given, world)?,
        None => find_machine(&from.plan, &plan, world)?,
    };
    let machine = spanning(machine, plan.bridge_mm)?;
    let source = match &from.model {
        Some(given) => given.clone(),
        None => find_model(&from.plan, &plan, world)?,
    };
    let unit =
        plan.model.unit.parse::<Unit>().map_err(|source| InputError::Unit { plan: name.into_owned(), source })?;
    // The plan was made from the repaired model if it was repaired; reading it the same way changes nothing else.
    let model = load_model(&ModelSource { unit: Some(unit), ..ModelSource::from(source) }, world)?;
    let checked = CheckedPlan { sha256: plan.sha256(), plan, model, machine };
    checked.check()?;
    Ok(checked)
}

/// The files that a plan may mean by a path: from beside the plan, from here, or under its bare name beside the plan.
fn meant(from: &Source, path: &str, world: &World<'_>) -> Vec<PathBuf> {
    let named = PathBuf::from(path);
    let beside = from.path().and_then(Path::parent).unwrap_or(Path::new("."));
    let tried = [beside.join(&named), named.clone(), beside.join(named.file_name().unwrap_or_default())];
    tried.into_iter().filter(|path| world.files.exists(path)).collect()
}

/// The model that the plan was made for; where none of the files it may mean is that, the first of them.
fn find_model(from: &Source, plan: &Plan, world: &World<'_>) -> Result<Source, InputError> {
    let tried = meant(from, &plan.model.file, world);
    let is_it = |path: &&PathBuf| world.files.read(path).is_ok_and(|bytes| sha256_hex(&bytes) == plan.model.sha256);
    let found = if tried.len() > 1 { tried.iter().find(is_it) } else { None };
    let missing = || InputError::NoModel { plan: from.name().into_owned(), model: plan.model.file.clone() };
    found.or(tried.first()).cloned().map(Source::File).ok_or_else(missing)
}

/// The machine that the plan was made for: its file where that is found, so that a change since then is noticed, else the values
/// that the plan keeps.
fn find_machine(from: &Source, plan: &Plan, world: &World<'_>) -> Result<LoadedProfile, InputError> {
    let recorded = MachineSource::from(plan.machine.profile.as_str());
    let files = recorded.path().map(|_| meant(from, &plan.machine.profile, world));
    let mut first = None;
    for path in files.into_iter().flatten() {
        let machine = load_profile(&MachineSource::Toml(Source::File(path)), world);
        if machine.as_ref().is_ok_and(|machine| machine.sha256 == plan.machine.sha256) {
            return machine;
        }
        first.get_or_insert(machine);
    }
    match (first, &plan.machine_values) {
        (Some(changed), _) => changed,
        (None, Some(values)) => {
            let kept = load_profile(&MachineSource::Profile(values.clone()), world)?;
            Ok(LoadedProfile { name: plan.machine.profile.clone(), ..kept })
        }
        (None, None) => load_profile(&recorded, world),
    }
}

impl CheckedPlan {
    pub(crate) fn check(&self) -> Result<(), InputError> {
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
