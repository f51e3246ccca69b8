//! Ways to print a model: those that may be taken, and those that were tried, each with what it comes to.

use std::fmt::{self, Display, Formatter};

use super::cutting::Cutting;
use super::orient::process_of;
use super::supported::Holding;
use super::{HeldModel, LoadedProfile, PlanResult, Refused, Supporting};
use crate::geom::Vec3;
use crate::mesh::Model;
use crate::orient::Facets;
use crate::profile::PriceSettings;
use crate::strategy::{Terms, Way, Weights};

/// A way that was tried.
#[derive(Clone, Debug)]
pub struct TriedWay {
    /// Which.
    pub way: Way,
    /// The direction of the file that is up, where the model was turned for it.
    pub up: Option<[f64; 3]>,
    /// Whether it was taken.
    pub chosen: bool,
    /// What it comes to; `None` where it does not work, or was not worked out.
    pub terms: Option<Terms>,
    /// Its price, minutes; of a way that was not worked out the least that it can be.
    pub price_min: Option<f64>,
    /// Why it was not taken.
    pub why_not: Option<Refused>,
}

impl TriedWay {
    pub(super) fn refused(way: Way, why_not: Refused) -> Self {
        Self { way, up: None, chosen: false, terms: None, price_min: None, why_not: Some(why_not) }
    }

    /// One that was not worked out, since it cannot cost less than this.
    pub(super) fn dearer(way: Way, least_min: f64) -> Self {
        Self { price_min: Some(least_min), ..Self::refused(way, Refused::Dearer { least_min }) }
    }

    pub(super) fn priced(way: Way, up: Option<[f64; 3]>, terms: Terms, weights: &Weights) -> Self {
        let price_min = Some(weights.price(&terms));
        Self { way, up, chosen: false, terms: Some(terms), price_min, why_not: None }
    }
}

impl TriedWay {
    /// A way that was not taken, in a line; `None` for the one that was, and for what is told of every model that does not print as it was drawn.
    pub fn beside(&self) -> Option<String> {
        if self.way == Way::AsDrawn && self.terms.is_none() {
            return None;
        }
        let price = self.price_min.map(|min| format!("{min:.0} min by one price"));
        let facts: Vec<String> = price.into_iter().chain(self.why_not.iter().map(ToString::to_string)).collect();
        (!self.chosen).then(|| format!("not {}: {}", self.way.word(), facts.join("; ")))
    }
}

/// What may be done with a model beside printing it as it was drawn.
#[derive(Clone, Debug)]
pub struct WaysOut {
    /// Whether its solids may be cut.
    pub cutting: Cutting,
    /// Whether they may stand on supports.
    pub supporting: Supporting,
    /// Whether it may stand otherwise than it was drawn, where nobody said how.
    pub turning: bool,
    /// The only way that is wanted.
    pub only: Option<Way>,
    /// What supports hold.
    pub holding: Holding,
    /// Ways that came to nothing, and are not tried again.
    pub lost: Vec<TriedWay>,
}

impl WaysOut {
    /// As it was drawn, or not at all.
    pub const NONE: Self = Self {
        cutting: Cutting::Never,
        supporting: Supporting::Never,
        turning: false,
        only: None,
        holding: Holding::Usual,
        lost: Vec::new(),
    };

    pub(super) fn allow(&self, way: Way) -> bool {
        let held = self.supporting == Supporting::Auto;
        let may = match way {
            Way::AsDrawn => true,
            Way::Turned => self.turning,
            Way::Supports => held,
            Way::TurnedSupports => self.turning && held,
            Way::Cut => self.cutting != Cutting::Never,
        };
        may && self.only.is_none_or(|only| only.covers(way)) && self.lost.iter().all(|lost| lost.way != way)
    }
}

/// No way to print a model is left of those that were asked for.
#[derive(Clone, Debug)]
pub struct NoWay {
    /// The only one that was asked for.
    pub only: Option<Way>,
    /// All that were tried, with why not.
    pub ways: Vec<TriedWay>,
}

impl Display for NoWay {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let asked = self.only.map_or("", Way::word);
        let whys =
            self.ways.iter().filter_map(|tried| Some(format!("{}: {}", tried.way.word(), tried.why_not.as_ref()?)));
        let whys: Vec<String> = whys.collect();
        let whys = if whys.is_empty() { "it does not apply to this model".to_owned() } else { whys.join("; ") };
        write!(f, "the model cannot be printed by --way {asked}: {whys}; --way auto takes the cheapest way that works")
    }
}

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
        droop_mm3: plan.droops.iter().map(|droop| droop.area_mm2 * droop.droop_mm).sum(),
        steps_min,
        risk_min,
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
