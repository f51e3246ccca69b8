//! What a plan comes to, by the price of its profile.

use super::plan::PlanResult;
use super::price::{Terms, Weights};
use super::supported::HeldModel;
use crate::geom::Vec3;
use crate::input::{LoadedProfile, process_of};
use crate::mesh::Model;
use crate::orient::Facets;
use crate::profile::PriceSettings;

/// What a profile says that each term is worth.
pub(super) fn weights(machine: &LoadedProfile) -> Weights {
    weights_of(&machine.profile.price)
}

fn weights_of(price: &PriceSettings) -> Weights {
    Weights {
        gram: price.gram_min,
        setup: price.setup_min,
        supports: price.supports_min,
        contact_mm2: price.contact_min_per_cm2 / 100.0,
        seam_mm2: price.seam_min_per_mm2,
        droop_mm3: price.droop_min_per_mm3,
    }
}

/// What a plan comes to, seams and supports left aside.
pub(super) fn as_planned(plan: &PlanResult) -> Terms {
    let model = &plan.plan.model.model;
    let (steps_min, risk_min) = of_its_pose(plan);
    Terms {
        minutes: plan.best().seconds / 60.0,
        grams: grams(model, &plan.plan.machine),
        setups: plan.best().pose_changes.max(1),
        parts: model.parts.len(),
        droop_mm2: plan.droops.iter().map(|droop| droop.area_mm2).sum::<f64>() + 0.0,
        droop_mm3: plan.droops.iter().map(|droop| droop.area_mm2 * droop.droop_mm).sum::<f64>() + 0.0,
        steps_min,
        risk_min,
        stands: plan.standing.map(|one| one.held.pushed).filter(|times| times.is_finite()),
        ..Terms::default()
    }
}

/// The same on supports, whose time a plan counts already.
pub(super) fn on_supports(plan: &PlanResult, held: &HeldModel) -> Terms {
    let whole = as_planned(plan);
    let support_g = process_of(&plan.plan.machine).grams(held.volume_mm3());
    Terms {
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

/// What changes of layer take at most where a model stands as in a plan, minutes: all that a lower pose could save.
pub(super) fn layers_min(plan: &PlanResult) -> f64 {
    let height_mm = plan.plan.model.model.bounds.size().z;
    process_of(&plan.plan.machine).layers(height_mm)
}

/// What the steps on slopes are worth along the directions of a plan; and, where each part is a print of its own that stands on the table,
/// what is lost by the odds that it comes loose. Minutes.
fn of_its_pose(plan: &PlanResult) -> (f64, f64) {
    let process = process_of(&plan.plan.machine);
    let parts = &plan.plan.workpiece().parts;
    let alone = plan.plan.model.model.interfaces.is_empty();
    let of_print = |part: usize, up: Vec3| {
        let facets = Facets::of(&parts[part]);
        if alone && up.z > UPRIGHT {
            let priced = process.roughly(&facets, &up);
            return (priced.steps_min, priced.risk_min);
        }
        (process.steps_along(&facets, &up), 0.0)
    };
    let prints = plan.plan.prints().map(|(_, print)| of_print(print.part, print.up.into()));
    prints.fold((0.0, 0.0), |sum, one| (sum.0 + one.0, sum.1 + one.1))
}

/// What is up as far as a print cares: the cosine of its angle to the table's normal.
const UPRIGHT: f64 = 0.999_999;

fn grams(model: &Model, machine: &LoadedProfile) -> f64 {
    let process = process_of(machine);
    model.parts.iter().map(|part| process.solid(part.mesh.volume(), part.mesh.area()).grams).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_profile_that_says_nothing_has_the_weights_of_the_room() {
        assert_eq!(weights_of(&PriceSettings::default()), Weights::default());
        let seams = PriceSettings { seam_min_per_mm2: 0.5, contact_min_per_cm2: 3.0, ..PriceSettings::default() };
        let wanted = Weights { seam_mm2: 0.5, contact_mm2: 0.03, ..Weights::default() };
        assert_eq!(weights_of(&seams), wanted);
    }
}
