//! A model whose solids are cut by planes and whose parts are planned; what was read is never changed.

use std::sync::Arc;

use super::arrange::SetUp;
use super::plan::{Along, PlanOptions, PlanResult, planned_along};
use super::refused::Refused;
use super::solids::{CutSolid, CutsOf, Known, Pieces, in_parts, pins};
use crate::input::{LoadedModel, LoadedProfile};
use crate::spelling::counted;
use crate::split::Split;
use crate::world::World;

/// Whether solids may be cut where there is no plan for them as they are.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Cutting {
    /// They are planned as they are, or not at all.
    Never,
    /// They may be cut.
    Auto {
        /// What the plan calls the parts' file (3MF).
        file: String,
    },
}

/// What became of a model whose solids were cut.
#[derive(Clone, Debug)]
pub struct CutModel {
    /// The solids that were cut, copies together; at least one.
    pub solids: Vec<CutSolid>,
    /// The parts as 3MF, to be written to [`CutModel::file`]; with those that stayed whole.
    pub bytes: Vec<u8>,
    /// What the plan calls that.
    pub file: String,
    /// Why there is no plan for the model as it is.
    pub why: Refused,
}

impl CutModel {
    /// All seams, mm².
    pub fn seam_mm2(&self) -> f64 {
        self.solids.iter().map(|solid| solid.parts.len() as f64 * solid.split.split.seam_mm2()).sum()
    }

    /// What was done, what it costs and why, in one sentence; `seconds` of printing and turning.
    pub fn story(&self, seconds: f64) -> String {
        let of_all = |count: fn(&Split) -> usize| -> usize {
            self.solids.iter().map(|solid| solid.parts.len() * count(&solid.split.split)).sum()
        };
        let seams = self.seam_mm2();
        let solids: usize = self.solids.iter().map(|solid| solid.parts.len()).sum();
        let which = if solids > 1 { format!("{} ", counted(solids, "solid")) } else { String::new() };
        format!(
            "{which}cut by {} into {} ({}, seams {seams:.1} mm2, about {:.0} min); uncut: {}",
            counted(of_all(|split| split.cuts.len()), "plane"),
            counted(of_all(|split| split.parts.len()), "part"),
            counted(self.solids.iter().map(|solid| solid.split.split.setups()).max().unwrap_or(0), "setup"),
            seconds / 60.0,
            self.why
        )
    }
}

/// Steps of the search for a sequence of loose solids' parts; one solid's are few, and take as many as they are given.
const STEPS: u64 = 1_000_000;

/// The plan of the models of `set` with their solids cut, the cuts and the parts' file; else why not.
pub(super) fn in_pieces(
    set: &SetUp,
    machine: &LoadedProfile,
    options: &PlanOptions,
    how: CutsOf<'_>,
    known: &mut Known,
    world: &World<'_>,
) -> Result<(PlanResult, Vec<CutSolid>, Vec<u8>), Refused> {
    let model = &set.model;
    if model.model.parts.len() == 1 {
        let (plan, split, bytes) = in_parts(model.clone(), machine, options, how.of_part(set, 0), world)?;
        if split.split.cuts.is_empty() {
            return Err(Refused::Whole);
        }
        return Ok((plan, vec![CutSolid { parts: vec![0], pins: pins(&split, set, 0), split }], bytes));
    }
    let pieces = Pieces::of(set, machine, options, how, known, world)?;
    let bytes = pieces.threemf();
    let parts = LoadedModel::made(how.file.to_owned(), &bytes)?;
    let plain =
        PlanOptions { remedies: false, allow: pieces.allow, budget: options.budget.min(STEPS), ..options.clone() };
    let plan = planned_along(Along::These(&pieces.ups), parts, machine.clone(), &plain, world);
    let is_joint = !model.model.captive.is_empty();
    let crowded = |error| if is_joint { Refused::Jointed } else { Refused::Crowded(Arc::new(error)) };
    Ok((plan.map_err(crowded)?, pieces.cut, bytes))
}
