//! What a request for orientations asks for, checked.

use super::{OrientOptions, Oriented};
use crate::geom::Angle;
use crate::job::{BadSetting, Error, World};
use crate::orient::{
    ContactArea, Facets, Found, METHODS, Minimum, Objective, Settings, laid, method, minima, nearest, objective,
};

/// Fewer evaluations than this say nothing of a whole sphere.
const LEAST_BUDGET: usize = 100;
/// A horizontal surface overhangs whatever is allowed.
const STEEPEST_DEG: f64 = 89.9;

pub(super) struct OrientAsked {
    pub(super) objectives: Vec<Box<dyn Objective>>,
    pub(super) settings: Settings,
    method: &'static str,
    budget: Option<usize>,
    seed: u64,
    contact_mm2: Option<f64>,
}

impl OrientAsked {
    pub(super) fn of(options: &OrientOptions) -> Result<Self, BadSetting> {
        let settings = settings(options)?;
        if let Some(value) = options.budget.filter(|&budget| budget < LEAST_BUDGET) {
            return Err(BadSetting::TooFew { name: "budget", value, least: LEAST_BUDGET, what: "evaluations" });
        }
        let method = METHODS.into_iter().find(|name| *name == options.method).ok_or_else(|| BadSetting::Method {
            name: "method",
            given: options.method.clone(),
            nearest: nearest(&options.method, &METHODS).to_string(),
        })?;
        let made = options.objectives.iter().map(|text| objective(text, &settings));
        let bad = |source| BadSetting::Objective { name: "objective", source };
        let objectives = made.collect::<Result<Vec<_>, _>>().map_err(bad)?;
        if objectives.is_empty() {
            return Err(BadSetting::Zero { name: "objective" });
        }
        let OrientOptions { budget, seed, contact_mm2, .. } = *options;
        Ok(Self { objectives, settings, method, budget, seed, contact_mm2 })
    }

    pub(super) fn result(&self, f: &dyn Objective, facets: &Facets, world: &World<'_>) -> Result<Oriented, Error> {
        let start = world.clock.now();
        let unknown =
            || BadSetting::Method { name: "method", given: self.method.to_owned(), nearest: METHODS.join(", ") };
        let search = method(self.method, f, self.budget, self.seed).ok_or_else(unknown)?;
        let mut found = minima(facets, f, search.as_ref());
        if let Some(least) = self.contact_mm2 {
            found.minima = standing(f, facets, least)?;
            found.evaluations += found.minima.len();
        }
        let found = Found { lower_bound: found.lower_bound.filter(|bound| bound.is_finite()), ..found };
        let unproved = found.lower_bound.is_none().then(|| match search.name() {
            "certified" => f.unproved(facets).unwrap_or_else(|| "no bound was reached".to_owned()),
            name => format!("{name} proves nothing; --method certified does"),
        });
        let seconds = (world.clock.now() - start).as_secs_f64();
        Ok(Oriented { objective: f.name().to_owned(), method: search.name(), found, unproved, seconds })
    }
}

/// Directions that lay `least` mm² on the bed, best first by `f`. Contact is had only where a facet lies flat, so these are
/// all there are; the lower bound over all directions holds for them as well.
fn standing(f: &dyn Objective, facets: &Facets, least: f64) -> Result<Vec<Minimum>, BadSetting> {
    let all = laid(facets, least, f);
    if all.is_empty() {
        let most = laid(facets, 0.0, &ContactArea).first().map_or(0.0, |m| 0.0 - m.value);
        return Err(BadSetting::NoContact { least, most });
    }
    Ok(all)
}

fn settings(options: &OrientOptions) -> Result<Settings, BadSetting> {
    let OrientOptions { overhang_deg, layer_mm, resolution_mm, .. } = *options;
    BadSetting::within("overhang", overhang_deg, " deg", [0.0, STEEPEST_DEG])?;
    BadSetting::within("layer", layer_mm, " mm", [0.001, 10.0])?;
    BadSetting::within("resolution", resolution_mm, " mm", [0.01, 100.0])?;
    if let Some(contact) = options.contact_mm2 {
        BadSetting::within("contact-area-min", contact, " mm2", [0.0, 1e9])?;
    }
    Ok(Settings { layer_mm, overhang: Angle::from_deg(overhang_deg), resolution_mm, ..Settings::default() })
}
