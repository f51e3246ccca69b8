//! One solid that has no plan as it is: cut by planes, and its parts planned. The model itself is never changed: the parts are a
//! model of their own, for whoever asked to write beside the output.

use super::load::spanning;
use super::plan::planned;
use super::split::cut_up;
use super::{Error, LoadedModel, LoadedProfile, PlanOptions, PlanResult, SplitOptions, SplitResult, World};
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

/// Plans `model` as it is, or, where it is one solid without a plan and `cutting` allows it, its parts.
///
/// # Errors
///
/// What [`plan`](super::plan()) says of the model as it is; with why cutting does not help.
pub(super) fn planned_or_cut(
    model: LoadedModel,
    machine: LoadedProfile,
    (options, cutting): (&PlanOptions, &Cutting),
    world: &World<'_>,
) -> Result<(PlanResult, Option<CutModel>), Error> {
    let Cutting::Auto { file } = cutting else { return Ok((planned(model, machine, options, world)?, None)) };
    if model.model.parts.len() != 1 {
        return Ok((planned(model, machine, options, world)?, None));
    }
    let quiet = PlanOptions { remedies: false, ..options.clone() };
    let why = match planned(model.clone(), machine.clone(), &quiet, world) {
        Err(Error::NoPlan(no)) => no.infeasible.to_string(),
        done => return Ok((done?, None)),
    };
    let not = match in_parts(&model, &machine, (options, file), world) {
        Ok((mut plan, split, bytes)) => {
            let cut = CutModel { split, bytes, file: file.clone(), why };
            plan.story = Some(cut.story(plan.best().seconds));
            return Ok((plan, Some(cut)));
        }
        Err(why_not) => why_not,
    };
    match planned(model, machine, options, world) {
        Err(Error::NoPlan(mut no)) => {
            no.cut = Some(not);
            Err(Error::NoPlan(no))
        }
        done => Ok((done?, None)),
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
    let plan = planned(parts, machine.clone(), &plain, world).map_err(words)?;
    Ok((plan, split, bytes))
}
