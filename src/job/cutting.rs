//! One solid that has no plan as it is: cut by planes, and its parts planned. The model itself is never changed: the parts are a
//! model of their own, for whoever asked to write beside the output.

use super::arrange::arranged;
use super::load::spanning;
use super::plan::{planned, planned_along};
use super::split::cut_up;
use super::supported::on_supports;
use super::{
    Error, HeldModel, LoadedModel, LoadedProfile, PlanOptions, PlanRequest, PlanResult, SplitOptions, SplitResult,
    Supporting, World, load_profile,
};
use crate::spelling::counted;

/// Whether one solid may be cut where there is no plan for it as it is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Cutting {
    /// It is planned as it is, or not at all.
    Never,
    /// It may be cut.
    Auto {
        /// What the plan calls the parts' file (3MF).
        file: String,
    },
}

/// What became of a solid that was cut.
#[derive(Clone, Debug)]
pub struct CutModel {
    /// The parts and the cuts.
    pub split: SplitResult,
    /// The parts as 3MF, to be written to [`CutModel::file`].
    pub bytes: Vec<u8>,
    /// What the plan calls that.
    pub file: String,
    /// Why there is no plan for the model as it is, in one sentence.
    pub why: String,
}

impl CutModel {
    /// What was done, what it costs and why, in one sentence; `seconds` of printing and turning.
    pub fn story(&self, seconds: f64) -> String {
        let split = &self.split.split;
        format!(
            "cut by {} into {}: {}, seams {:.1} mm2, about {:.0} min; as it is: {}",
            counted(split.cuts.len(), "plane"),
            counted(split.parts.len(), "part"),
            counted(split.setups(), "setup"),
            split.seam_mm2(),
            seconds / 60.0,
            self.why
        )
    }
}

/// Plans.
///
/// # Errors
///
/// [`Error::NoPlan`] with reasons and remedies; [`Error::Infeasible`] and [`Error::Misplaced`] for a model that cannot be
/// planned at all; [`Error::Setting`]; what reading model and machine may say.
pub fn plan(request: &PlanRequest, world: &World<'_>) -> Result<PlanResult, Error> {
    let machine = load_profile(&request.machine, world)?;
    let (model, arranged) = arranged(&request.model, &request.arrangement, &machine, world)?;
    let ways = WaysOut { cutting: Cutting::Never, supporting: request.supporting };
    let plan = planned_or_cut(model, machine, (&request.options, &ways), world)?.plan;
    Ok(plan.of_arranged(arranged))
}

/// What may be done with one solid that has no plan as it is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WaysOut {
    /// Whether it may be cut; that comes first.
    pub cutting: Cutting,
    /// Whether it may stand on supports.
    pub supporting: Supporting,
}

/// A plan, and what was done to the model for it.
pub(super) struct PlannedSomehow {
    pub(super) plan: PlanResult,
    pub(super) cut: Option<CutModel>,
    pub(super) held: Option<HeldModel>,
}

impl PlannedSomehow {
    fn as_it_is(plan: PlanResult) -> Self {
        Self { plan, cut: None, held: None }
    }
}

/// Plans `model` as it is, or, where it is one solid without a plan and `ways` allow it, its parts; or else on supports.
///
/// # Errors
///
/// What [`plan`](super::plan()) says of the model as it is; with why cutting does not help.
pub(super) fn planned_or_cut(
    model: LoadedModel,
    machine: LoadedProfile,
    (options, ways): (&PlanOptions, &WaysOut),
    world: &World<'_>,
) -> Result<PlannedSomehow, Error> {
    let none = matches!(ways, WaysOut { cutting: Cutting::Never, supporting: Supporting::Never });
    if none || model.model.parts.len() != 1 {
        return planned(model, machine, options, world).map(PlannedSomehow::as_it_is);
    }
    let quiet = PlanOptions { remedies: false, ..options.clone() };
    let why = match planned(model.clone(), machine.clone(), &quiet, world) {
        Err(Error::NoPlan(no)) => no.infeasible.to_string(),
        done => return done.map(PlannedSomehow::as_it_is),
    };
    let mut not = None;
    if let Cutting::Auto { file } = &ways.cutting {
        match in_parts(&model, &machine, (options, file), world) {
            Ok((mut plan, split, bytes)) => {
                let cut = CutModel { split, bytes, file: file.clone(), why };
                plan.story = Some(cut.story(plan.best().seconds));
                return Ok(PlannedSomehow { cut: Some(cut), ..PlannedSomehow::as_it_is(plan) });
            }
            Err(why_not) => not = Some(why_not),
        }
    }
    let mut unheld = None;
    if ways.supporting == Supporting::Auto {
        match on_supports(&model, &machine, (options, &why), world) {
            Ok((plan, held)) => return Ok(PlannedSomehow { held: Some(held), ..PlannedSomehow::as_it_is(plan) }),
            Err(why_not) => unheld = Some(why_not),
        }
    }
    match planned(model, machine, options, world) {
        Err(Error::NoPlan(mut no)) => {
            (no.cut, no.held) = (not, unheld);
            Err(Error::NoPlan(no))
        }
        done => done.map(PlannedSomehow::as_it_is),
    }
}

/// The plan of the parts, with the cuts and the parts' file; else why not.
fn in_parts(
    model: &LoadedModel,
    machine: &LoadedProfile,
    (options, file): (&PlanOptions, &str),
    world: &World<'_>,
) -> Result<(PlanResult, SplitResult, Vec<u8>), String> {
    let words = |error: Error| error.to_string();
    let cuts = SplitOptions {
        overhang_deg: options.overhang_deg,
        bridge_mm: options.bridge_mm,
        tolerate_mm2: options.tolerate_mm2,
        margin_mm: options.margin_mm,
        ..SplitOptions::default()
    };
    let spanned = spanning(machine.clone(), options.bridge_mm).map_err(|e| words(e.into()))?;
    let split = cut_up(model.clone(), &spanned, &cuts, world).map_err(words)?;
    if let Some(why) = split.why_not() {
        return Err(why);
    }
    let bytes = split.threemf();
    let parts = LoadedModel::made(file.to_owned(), &bytes).map_err(words)?;
    // Exceptions are of the model's own parts.
    let plain = PlanOptions { remedies: false, allow: Vec::new(), ..options.clone() };
    // The cuts' own directions have a plan, and are few; a search over all that the parts offer may take a hundred times as long.
    let ups = split.split.ups();
    let plan = match planned_along(Some(&ups), parts.clone(), machine.clone(), &plain, world) {
        Err(Error::NoPlan(_)) => planned(parts, machine.clone(), &plain, world),
        found => found,
    };
    Ok((plan.map_err(words)?, split, bytes))
}
