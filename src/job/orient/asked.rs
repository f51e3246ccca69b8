//! What a request for orientations asks for, checked.

use super::error::OrientError;
use super::{OrientOptions, Oriented, finer};
use crate::geom::{Angle, Bounds, Vec3};
use crate::input::process;
use crate::input::{BadSetting, load_profile};
use crate::orient::{
    Facets, Found, METHODS, Minimum, Objective, ObjectiveSettings, PRINTABLE, Printable, Process, Recommendation,
    StandingMinima, Stop, Tried, method, minima, nearest, objective, proved_standing, recommend, standing,
    without_ties,
};
use crate::profile::SliceSettings;
use crate::world::World;

/// Fewer evaluations than this say nothing of a whole sphere.
const LEAST_BUDGET: usize = 100;
/// Columns along a part's longest side, unless the user wants others.
const COLUMNS: f64 = 200.0;
/// A horizontal surface overhangs whatever is allowed.
const STEEPEST_DEG: f64 = 89.9;

pub(super) struct OrientAsked {
    /// Each makes an objective.
    texts: Vec<String>,
    settings: ObjectiveSettings,
    /// Columns as the user wants them, else as they suit the part.
    resolution_mm: Option<f64>,
    pub(super) up: Option<Vec3>,
    process: Process,
    method: &'static str,
    budget: Option<usize>,
    seed: u64,
    contact_mm2: Option<f64>,
}

impl OrientAsked {
    pub(super) fn of(options: &OrientOptions, world: &World<'_>) -> Result<Self, OrientError> {
        let machine = options.machine.as_ref().map(|machine| load_profile(machine, world)).transpose()?;
        let print = machine.map(|loaded| loaded.profile.process);
        let settings = settings(options, print.as_ref())?;
        if let Some(value) = options.budget.filter(|&budget| budget < LEAST_BUDGET) {
            return Err(BadSetting::TooFew { name: "budget", value, least: LEAST_BUDGET, what: "evaluations" }.into());
        }
        let method = METHODS.into_iter().find(|name| *name == options.method).ok_or_else(|| BadSetting::Method {
            name: "method",
            given: options.method.clone(),
            nearest: nearest(&options.method, &METHODS).to_string(),
        })?;
        let process = process(print.as_ref().unwrap_or(&SliceSettings::default()), &settings);
        let texts = options.objectives.clone();
        let bad = |source| BadSetting::Objective { name: "objective", source };
        texts.iter().try_for_each(|text| objective(text, &settings).map(drop)).map_err(bad)?;
        if texts.is_empty() {
            return Err(BadSetting::Zero { name: "objective" }.into());
        }
        let up = options.up.map(own_pose).transpose()?;
        if up.is_some() && !options.compare && !texts.iter().any(|text| text.trim() == PRINTABLE) {
            return Err(BadSetting::OwnPose.into());
        }
        let OrientOptions { budget, seed, contact_mm2, resolution_mm, .. } = *options;
        Ok(Self { texts, settings, resolution_mm, up, process, method, budget, seed, contact_mm2 })
    }

    /// The objectives for a part.
    pub(super) fn objectives(&self, facets: &Facets) -> Vec<Box<dyn Objective>> {
        let settings = self.settings(facets);
        let made = |text: &String| match text.trim() {
            PRINTABLE => Some(Box::new(Printable { process: self.process }) as Box<dyn Objective>),
            _ => objective(text, &settings).ok(),
        };
        self.texts.iter().filter_map(made).collect()
    }

    /// The settings for a part: columns of half a millimetre, wider where the part is longer than [`COLUMNS`] of them.
    pub(super) fn settings(&self, facets: &Facets) -> ObjectiveSettings {
        let longest = Bounds::of(facets.points.iter().copied()).size().max();
        let suits = self.settings.resolution_mm.max(longest / COLUMNS);
        ObjectiveSettings { resolution_mm: self.resolution_mm.unwrap_or(suits), ..self.settings }
    }

    /// The first objective that means nothing on an open surface.
    pub(super) fn closed_only(&self) -> Option<String> {
        let needs = |text: &&String| objective(text, &self.settings).is_ok_and(|f| f.needs_closed());
        self.texts.iter().find(needs).cloned()
    }

    pub(super) fn count(&self) -> usize {
        self.texts.len()
    }

    pub(super) fn result(
        &self,
        f: &dyn Objective,
        facets: &Facets,
        world: &World<'_>,
    ) -> Result<Oriented, OrientError> {
        let start = world.clock.now();
        let made = if f.name() == PRINTABLE && self.method == METHODS[0] {
            self.recommended(facets)?
        } else {
            self.searched(f, facets)?
        };
        Ok(Oriented { seconds: (world.clock.now() - start).as_secs_f64(), ..made })
    }

    fn recommended(&self, facets: &Facets) -> Result<Oriented, BadSetting> {
        let mut made = recommend(facets, &self.process, self.up, self.budget);
        if let Some(least) = self.contact_mm2 {
            let most = made.poses.iter().map(|p| p.footprint_mm2).fold(0.0, f64::max);
            if !made.keep_standing_on(least) {
                return Err(BadSetting::NoContact { least, most });
            }
        }
        let Recommendation { poses, at_least_min, evaluations, .. } = &made;
        let minima = poses.iter().map(|p| Minimum { up: p.up, value: p.price_min, ended: true }).collect();
        let (evaluations, lower_bound) = (*evaluations, Some(*at_least_min));
        let found = Found { minima, evaluations, lower_bound, stop: Stop::Converged, history: Vec::new() };
        let unproved = "the bound is the part alone at the least height, without supports, steps or risk";
        Ok(Oriented {
            objective: PRINTABLE.to_owned(),
            method: "candidates",
            found,
            unproved: Some(unproved.to_owned()),
            recommendation: Some((made, self.process)),
            finer: None,
            tie: 0.0,
            seconds: 0.0,
        })
    }

    fn searched(&self, f: &dyn Objective, facets: &Facets) -> Result<Oriented, BadSetting> {
        let unknown =
            || BadSetting::Method { name: "method", given: self.method.to_owned(), nearest: METHODS.join(", ") };
        // Of a budget a quarter is kept for dips and ties.
        let share = self.budget.map(|budget| budget - budget / 4);
        let search = method(self.method, f, share, self.seed).ok_or_else(unknown)?;
        let mut found = minima(facets, f, search.as_ref(), self.budget.map(|budget| budget - budget / 8));
        let tie = f.tie(facets);
        if let Some(least) = self.contact_mm2 {
            let StandingMinima { minima, most_mm2, evaluations } =
                standing(f, facets, &found.minima, least, self.settings.layer_mm);
            if minima.is_empty() {
                return Err(BadSetting::NoContact { least, most: most_mm2 });
            }
            found.evaluations += evaluations;
            found.minima = minima;
        }
        let left = |found: &Found| self.budget.map_or(usize::MAX, |budget| budget.saturating_sub(found.evaluations));
        let held = self.contact_mm2.filter(|least| *least > 0.0 && found.lower_bound.is_some());
        if let Some(least) = held {
            // The bound so far is over all directions; this one is over those that stand.
            let first = found.minima[0];
            let proved = proved_standing(f, facets, &first, least, self.settings.layer_mm, left(&found));
            found.evaluations += proved.evaluations;
            found.lower_bound = proved.lower_bound.into_iter().chain(found.lower_bound).reduce(f64::max);
            found.minima.splice(0..0, proved.minima.into_iter().filter(|better| better.value < first.value));
        }
        let left = left(&found);
        let tried = Tried { least_mm2: self.contact_mm2, most: left };
        found = without_ties(found, f, facets, self.settings.layer_mm, tried);
        let reached = found.lower_bound.filter(|bound| bound.is_finite());
        let best = found.minima[0].value;
        let lower_bound = reached.filter(|bound| best - bound <= (LOOSE * best.abs()).max(tie).max(ROUNDING));
        let found = Found { lower_bound, ..found };
        let unproved = match (found.lower_bound, search.name()) {
            (Some(_), _) => None,
            (None, "certified") if reached.is_some() => {
                Some("the bound that was reached is too far below the best value to say much".to_owned())
            }
            (None, "certified") => Some(f.unproved(facets).unwrap_or_else(|| "no bound was reached".to_owned())),
            (None, name) => Some(format!("{name} proves no bound; use --method certified")),
        };
        let (objective, method) = (f.name().to_owned(), search.name());
        let columns = finer(&self.settings(facets));
        let finer = (objective == columns.name()).then(|| columns.value(facets, &found.minima[0].up));
        Ok(Oriented { objective, method, found, unproved, recommendation: None, finer, tie, seconds: 0.0 })
    }
}

/// A bound that is farther below the best value, relative, says nothing of it and is not told.
const LOOSE: f64 = 0.25;
/// Beside a best value of 0 a bound is off by rounding, mm, mm² or mm³.
const ROUNDING: f64 = 1e-6;

/// A direction that the user gives.
fn own_pose(given: [f64; 3]) -> Result<Vec3, BadSetting> {
    BadSetting::direction("up", given)?;
    Ok(Vec3::from(given).normalize())
}

fn settings(options: &OrientOptions, print: Option<&SliceSettings>) -> Result<ObjectiveSettings, BadSetting> {
    let OrientOptions { overhang_deg, smooth_k, smooth_w, carrying_deg, .. } = *options;
    let own = print.map_or(SliceSettings::default().layer_height_mm, |print| print.layer_height_mm);
    let layer_mm = options.layer_mm.unwrap_or(own);
    BadSetting::within("overhang", overhang_deg, " deg", [0.0, STEEPEST_DEG])?;
    BadSetting::within("layer", layer_mm, " mm", [0.001, 10.0])?;
    BadSetting::within("smooth-k", smooth_k, "", [0.1, 1e4])?;
    BadSetting::within("smooth-w", smooth_w, " per mm", [1e-3, 1e6])?;
    BadSetting::within("carrying", carrying_deg, " deg", [0.0, STEEPEST_DEG])?;
    if let Some(resolution) = options.resolution_mm {
        BadSetting::within("resolution", resolution, " mm", [0.01, 100.0])?;
    }
    if let Some(contact) = options.contact_mm2 {
        BadSetting::within("contact-area-min", contact, " mm2", [0.0, 1e9])?;
    }
    let [overhang, carrying] = [overhang_deg, carrying_deg].map(Angle::from_deg);
    let usual = ObjectiveSettings::default();
    Ok(ObjectiveSettings { layer_mm, overhang, carrying, k: smooth_k, w: smooth_w, ..usual })
}
