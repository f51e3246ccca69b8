//! What the flags of `trunnion orient` ask for, checked.

use std::time::Instant;

use super::super::Failure;
use super::super::args::Orient;
use super::outcome::Outcome;
use crate::geom::Angle;
use crate::orient::{
    ContactArea, Facets, Found, METHODS, Objective, Settings, laid, method, minima, nearest, objective,
};

/// Fewer evaluations than this say nothing of a whole sphere.
const LEAST_BUDGET: usize = 100;

pub(super) struct Asked {
    pub(super) objectives: Vec<Box<dyn Objective>>,
    pub(super) settings: Settings,
    method: &'static str,
    budget: Option<usize>,
    seed: u64,
    contact_mm2: Option<f64>,
}

impl Asked {
    pub(super) fn of(args: &Orient) -> Result<Self, Failure> {
        let settings = settings(args)?;
        if let Some(budget) = args.budget.filter(|&budget| budget < LEAST_BUDGET) {
            let text = format!("--budget {budget} is too few evaluations; give at least {LEAST_BUDGET}");
            return Err(Failure::Usage(text));
        }
        let method = METHODS.into_iter().find(|name| *name == args.method).ok_or_else(|| {
            let near = nearest(&args.method, &METHODS);
            let all = METHODS.join(", ");
            Failure::Usage(format!("--method {}: did you mean {near}? this version knows {all}", args.method))
        })?;
        let made = args.objective.iter().map(|text| objective(text, &settings));
        let objectives =
            made.collect::<Result<Vec<_>, _>>().map_err(|e| Failure::Usage(format!("--objective: {e}")))?;
        let (budget, seed, contact_mm2) = (args.budget, args.seed, args.contact_area_min);
        Ok(Self { objectives, settings, method, budget, seed, contact_mm2 })
    }

    pub(super) fn result(&self, f: &dyn Objective, facets: &Facets) -> Result<Outcome, Failure> {
        let start = Instant::now();
        let search =
            method(self.method, f, self.budget, self.seed).ok_or_else(|| Failure::Usage(self.method.to_owned()))?;
        let mut found = minima(facets, f, search.as_ref());
        if let Some(least) = self.contact_mm2 {
            found.minima = standing(f, facets, least)?;
            found.evaluations += found.minima.len();
        }
        let found = finite(found);
        let unproved = found.lower_bound.is_none().then(|| match search.name() {
            "certified" => f.unproved(facets).unwrap_or_else(|| "no bound was reached".to_owned()),
            name => format!("{name} proves nothing; --method certified does"),
        });
        Ok(Outcome {
            objective: f.name().to_owned(),
            method: search.name(),
            found,
            unproved,
            seconds: start.elapsed().as_secs_f64(),
        })
    }
}

fn finite(found: Found) -> Found {
    Found { lower_bound: found.lower_bound.filter(|bound| bound.is_finite()), ..found }
}

/// Directions that lay `least` mm² on the bed, best first by `f`. Contact is had only where a facet lies flat, so these are
/// all there are; the lower bound over all directions holds for them as well.
fn standing(f: &dyn Objective, facets: &Facets, least: f64) -> Result<Vec<crate::orient::Minimum>, Failure> {
    let all = laid(facets, least, f);
    if all.is_empty() {
        let most = laid(facets, 0.0, &ContactArea).first().map_or(0.0, |m| 0.0 - m.value);
        let text =
            format!("--contact-area-min {least} mm2: no direction lays so much on the bed; the most is {most:.3} mm2");
        return Err(Failure::Usage(text));
    }
    Ok(all)
}

fn settings(args: &Orient) -> Result<Settings, Failure> {
    let within = |flag: &str, value: f64, low: f64, high: f64, unit: &str| {
        let out = || Failure::Usage(format!("{flag} {value} is out of {low}..{high} {unit}"));
        (low..=high).contains(&value).then_some(()).ok_or_else(out)
    };
    if !(0.0..90.0).contains(&args.overhang) {
        return Err(Failure::Usage(format!("--overhang {} is out of 0..90 deg", args.overhang)));
    }
    within("--layer", args.layer, 0.001, 10.0, "mm")?;
    within("--resolution", args.resolution, 0.01, 100.0, "mm")?;
    if let Some(contact) = args.contact_area_min {
        within("--contact-area-min", contact, 0.0, 1e9, "mm2")?;
    }
    let overhang = Angle::from_deg(args.overhang);
    Ok(Settings { layer_mm: args.layer, overhang, resolution_mm: args.resolution, ..Settings::default() })
}
