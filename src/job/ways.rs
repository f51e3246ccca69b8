//! The ways that were tried for a model, each with what it comes to, and the cheapest of them.

use super::orient::process_of;
use super::{HeldModel, LoadedProfile, PlanResult};
use crate::mesh::Model;
use crate::strategy::{Terms, Way, Weights};

/// A way that was tried.
#[derive(Clone, Debug, PartialEq)]
pub struct TriedWay {
    /// Which.
    pub way: Way,
    /// Whether it was taken.
    pub chosen: bool,
    /// What it comes to; `None` where it does not work, or was not worked out.
    pub terms: Option<Terms>,
    /// Its price, minutes; of a way that was not worked out the least that it can be.
    pub price_min: Option<f64>,
    /// Why it was not taken, in a sentence.
    pub why_not: Option<String>,
}

impl TriedWay {
    pub(super) fn refused(way: Way, why_not: &str) -> Self {
        Self { way, chosen: false, terms: None, price_min: None, why_not: Some(why_not.to_owned()) }
    }

    pub(super) fn priced(way: Way, terms: Terms) -> Self {
        let price_min = Some(Weights::default().price(&terms));
        Self { way, chosen: false, terms: Some(terms), price_min, why_not: None }
    }
}

/// What a plan comes to as its model stands, without supports.
pub(super) fn as_planned(plan: &PlanResult) -> Terms {
    let model = &plan.plan.model.model;
    Terms {
        minutes: plan.best().seconds / 60.0,
        grams: grams(model, &plan.plan.machine),
        setups: plan.best().pose_changes.max(1),
        parts: model.parts.len(),
        droop_mm3: plan.droops.iter().map(|droop| droop.area_mm2 * droop.droop_mm).sum(),
        ..Terms::default()
    }
}

/// The same on supports.
pub(super) fn on_supports(plan: &PlanResult, held: &HeldModel) -> Terms {
    let whole = as_planned(plan);
    let support_g = process_of(&plan.plan.machine).grams(held.volume_mm3());
    Terms {
        minutes: whole.minutes + held.seconds() / 60.0,
        grams: whole.grams + support_g,
        support_g,
        contact_mm2: held.parts.iter().map(|part| part.contact_mm2).sum(),
        ..whole
    }
}

/// The same in parts with such seams.
pub(super) fn in_parts(plan: &PlanResult, seam_mm2: f64) -> Terms {
    Terms { seam_mm2, ..as_planned(plan) }
}

fn grams(model: &Model, machine: &LoadedProfile) -> f64 {
    let process = process_of(machine);
    model.parts.iter().map(|part| process.solid(part.mesh.volume(), part.mesh.area()).grams).sum()
}
