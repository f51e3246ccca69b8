//! Flags as the requests of `job`.

use std::any::Any;
use std::path::{Path, PathBuf};
use std::time::Duration;

use super::Failure;
use super::args::{
    ArrangeArgs, BedArgs, MachineArgs, ModelArgs, PassArgs, PlanArgs, PlanRef, Preview, ReadArgs, SliceArgs, copies,
};
use crate::job::{
    self, Arrangement, MachineSource, ModelSource, Outputs, PlaceRequest, PlanOptions, PlanRequest, PlanSource,
    PoseChoice, PreviewRequest, SlicingOptions, Source, SupportForm, Supporting, interrupts,
};
use crate::mesh::{ProjectPlates, Repair, Unit};
use crate::planning::Priority;
use crate::slicing::SlicerChoice;
use crate::spelling::numbers;

impl ModelArgs {
    pub(super) fn source(&self) -> Result<ModelSource, Failure> {
        self.read.source(&self.model)
    }
}

impl ReadArgs {
    pub(super) fn source(&self, model: &Path) -> Result<ModelSource, Failure> {
        let unit = self.unit.as_deref().map(str::parse::<Unit>).transpose();
        let unit = unit.map_err(|e| Failure::Usage(e.to_string()))?;
        let repair = repair(&self.repair, self.no_repair);
        let plates = self.plate.map_or(ProjectPlates::Only, ProjectPlates::Number);
        Ok(ModelSource { source: Source::from(model), unit, repair, plates })
    }
}

/// What becomes of meshes that are not sound; `off` is the older word for one of the choices.
pub(super) fn repair(named: &str, off: bool) -> Repair {
    Repair::named(named).filter(|_| !off).unwrap_or_default()
}

impl ArrangeArgs {
    /// The first model and how all are set up; `file` is where an arranged model is to be kept.
    pub(super) fn request(
        &self,
        model: &Path,
        read: &ReadArgs,
        file: Option<&Path>,
    ) -> Result<(ModelSource, Arrangement), Failure> {
        let first = read.source(model)?;
        let of = |word: &Path| {
            let (name, copies) = copies(word);
            (ModelSource { source: Source::from(name), plates: ProjectPlates::Only, ..first.clone() }, copies)
        };
        let (named, copies) = of(model);
        let named = ModelSource { plates: first.plates, ..named };
        let standing = match (self.up, self.base) {
            (Some(standing), _) => standing,
            (None, Some(part)) => PoseChoice::On(part),
            (None, None) => PoseChoice::AsDrawn,
        };
        let arrangement = Arrangement {
            snap_mm: self.snap,
            join: self.join,
            standing,
            copies,
            beside: self.more.iter().map(|word| of(word)).collect(),
            gap_mm: self.gap,
            file: file.map(|path| path.display().to_string()),
        };
        Ok((named, arrangement))
    }

    /// The files that are read.
    pub(super) fn files(&self, model: &Path) -> Vec<PathBuf> {
        std::iter::once(model).chain(self.more.iter().map(|w| &**w)).map(|w| copies(w).0.to_owned()).collect()
    }
}

impl MachineArgs {
    pub(super) fn source(&self) -> MachineSource {
        MachineSource::from(self.profile.as_str())
    }
}

impl PlanArgs {
    pub(super) fn options(&self, pass: &PassArgs) -> Result<PlanOptions, Failure> {
        Ok(PlanOptions {
            objective: self.objective.clone(),
            orient_by: self.orient_by.clone(),
            method: self.method.clone(),
            orient_budget: self.orient_budget,
            overhang_deg: self.overhang,
            finish: pass.finish.unwrap_or_default(),
            bridge_mm: pass.bridge,
            tolerate_mm2: pass.tolerate,
            allow: self.allow.iter().map(|text| job::allowed(text)).collect::<Result<_, _>>()?,
            margin_mm: self.margin,
            priority: match self.slots.as_str() {
                "single" => Priority::Single,
                "only-single" => Priority::OnlySingle,
                _ => Priority::Together,
            },
            table_first: !self.table_later,
            order: self.order.as_deref().map_or(Ok(Vec::new()), job::ordered)?,
            seed: self.seed,
            place: self.place()?,
            explain: true,
            remedies: !self.no_remedies,
            form: self.form(),
            budget: self.budget,
            ..PlanOptions::default()
        })
    }

    fn form(&self) -> SupportForm {
        SupportForm { roof_mm: self.roof, roof_pitch_mm: self.roof_pitch, brace_mm: self.brace }
    }

    /// The place that `--origin` and `--turn` ask for.
    fn place(&self) -> Result<Option<PlaceRequest>, Failure> {
        let bad =
            |text| Failure::Usage(format!("--origin {text}: must be two numbers in mm, for example --origin 12.5,-30"));
        let origin = self.origin.as_deref();
        let origin_mm = origin.map(|text| numbers(text).ok_or_else(|| bad(text))).transpose()?;
        let asked = origin_mm.is_some() || self.turn.is_some();
        Ok(asked.then(|| PlaceRequest { origin_mm, turn_deg: self.turn.unwrap_or(0.0) }))
    }
}

impl SliceArgs {
    pub(super) fn options(&self, bed: &BedArgs) -> Result<SlicingOptions, Failure> {
        Ok(SlicingOptions {
            slicer: self.slicer.parse().unwrap_or(SlicerChoice::Auto),
            configs: self.slicer_config.clone(),
            timeout: Duration::from_secs(self.slicer_timeout),
            bed: job::bed(&bed.bed)?,
        })
    }
}

impl PlanRef {
    pub(super) fn source(&self, plan: &Path) -> PlanSource {
        PlanSource {
            plan: plan.into(),
            model: self.model.as_ref().map(Source::from),
            machine: self.profile.as_deref().map(MachineSource::from),
        }
    }
}

impl Preview {
    /// A finished file by its plan, a plan alone, or a model that is planned first.
    pub(super) fn request(&self) -> Result<PreviewRequest, Failure> {
        let plan = self.plan.as_deref().map(|path| self.plan_ref.source(path));
        Ok(match (plan, &self.file) {
            (Some(plan), Some(file)) => PreviewRequest::Program(Source::from(file), plan),
            (Some(plan), None) => PreviewRequest::Plan(plan),
            (None, file) => PreviewRequest::Model(Box::new(self.planned(file.as_deref().unwrap_or(Path::new("")))?)),
        })
    }

    /// What `trunnion plan` would be asked with the same flags.
    fn planned(&self, model: &Path) -> Result<PlanRequest, Failure> {
        let (model, arrangement) = self.arrange.request(model, &self.read, None)?;
        Ok(PlanRequest {
            model,
            machine: MachineSource::from(self.plan_ref.profile.as_deref().unwrap_or_default()),
            arrangement,
            options: self.planning.options(&self.pass)?,
            supporting: supporting(&self.supports, &self.planning)?,
        })
    }
}

/// What the word after `--supports` means, beside the flags that shape supports.
pub(super) fn supporting(word: &str, plan: &PlanArgs) -> Result<Supporting, Failure> {
    match plan.form().shaped_by().filter(|_| word == "never") {
        None if word == "never" => Ok(Supporting::Never),
        None => Ok(Supporting::Auto),
        Some(name) => Err(Failure::Usage(format!(
            "--{name} shapes supports, but --supports never disables them; use --supports auto"
        ))),
    }
}

/// What a word of `--compare` names: a plan, or a finished file and its plan behind an equals sign.
fn compared(word: &str) -> (Option<&Path>, &Path) {
    word.split_once('=').map_or((None, Path::new(word)), |(file, plan)| (Some(Path::new(file)), Path::new(plan)))
}

impl Preview {
    /// The files that are read.
    pub(super) fn files(&self) -> impl Iterator<Item = PathBuf> {
        let two = self.compare.iter().flat_map(|word| {
            let (file, plan) = compared(word);
            file.into_iter().chain([plan])
        });
        let one = [&self.file, &self.plan, &self.plan_ref.model].into_iter().flatten().map(PathBuf::as_path);
        one.chain(two).map(Path::to_owned).chain(self.arrange.files(Path::new("")).into_iter().skip(1))
    }

    /// The two that are shown side by side; none where one is shown.
    pub(super) fn requests(&self) -> Vec<PreviewRequest> {
        let request = |word: &String| {
            let (file, plan) = compared(word);
            let plan = self.plan_ref.source(plan);
            match file {
                Some(file) => PreviewRequest::Program(Source::from(file), plan),
                None => PreviewRequest::Plan(plan),
            }
        };
        self.compare.iter().map(request).collect()
    }
}

/// The right to write, for a call that reads `inputs`.
pub(super) fn outputs<'a>(inputs: impl IntoIterator<Item = &'a Path>) -> Outputs {
    Outputs::new(inputs).held_by(|| -> Box<dyn Any> { Box::new(interrupts::held()) })
}

/// The file that a profile's word means; `None` for a shipped name.
pub(super) fn profile_file(word: &str) -> Option<PathBuf> {
    MachineSource::from(word).path().map(Path::to_owned)
}

/// The folder in which a file is to be written.
pub(super) fn folder_of(file: Option<&Path>) -> Option<PathBuf> {
    file.and_then(Path::parent).map(Path::to_owned)
}
