//! Weighted sums of objectives, raw: nothing is normalised (Boogers (2024) equation 4.9, Ramos et al. (2021) equation 9).

use super::{Cap, Facets, Local, Minorant, Objective, Proof};
use crate::geom::Vec3;

/// A sum of objectives with weights; its name is the text it came of, its unit whatever the terms' units make of it.
pub struct WeightedSum {
    pub(super) text: String,
    pub(super) terms: Vec<(f64, Box<dyn Objective>)>,
}

impl Objective for WeightedSum {
    fn name(&self) -> &str {
        &self.text
    }

    fn value(&self, facets: &Facets, up: &Vec3) -> f64 {
        self.terms.iter().map(|(weight, f)| weight * f.value(facets, up)).sum()
    }

    fn needs_closed(&self) -> bool {
        self.terms.iter().any(|(_, f)| f.needs_closed())
    }

    fn gradient(&self, facets: &Facets, up: &Vec3) -> Option<Vec3> {
        self.terms.iter().try_fold(Vec3::zeros(), |sum, (weight, f)| Some(sum + f.gradient(facets, up)? * *weight))
    }

    fn proof(&self) -> Proof {
        let all = self.terms.iter().map(|(_, f)| f.proof());
        all.fold(Proof::EXACT, |a, b| Proof { gap: a.gap.max(b.gap), budget: a.budget.min(b.budget) })
    }

    /// The sum of the terms' minorants, each taken near the same direction; for a negative weight that of minus the term.
    fn local<'a>(&'a self, facets: &'a Facets) -> Option<Box<dyn Local<'a> + 'a>> {
        let term = |(weight, f): &'a (f64, Box<dyn Objective>)| {
            let local = if *weight < 0.0 { f.negated(facets)? } else { f.local(facets)? };
            Some((weight.abs(), local))
        };
        let terms = self.terms.iter().filter(|(weight, _)| *weight != 0.0).map(term);
        Some(Box::new(LocalSum { terms: terms.collect::<Option<Vec<_>>>()? }))
    }

    fn unproved(&self, facets: &Facets) -> Option<String> {
        self.terms.iter().find_map(|(weight, f)| {
            let name = f.name();
            let no_upper = || format!("{name} has no upper bound in this version, which its negative weight needs");
            if *weight < 0.0 { f.negated(facets).is_none().then(no_upper) } else { f.unproved(facets) }
        })
    }
}

/// Terms with their weights, all of them positive.
struct LocalSum<'a> {
    terms: Vec<(f64, Box<dyn Local<'a> + 'a>)>,
}

impl<'a> Local<'a> for LocalSum<'a> {
    fn within(&self, cap: &Cap) -> Box<dyn Local<'a> + 'a> {
        Box::new(Self { terms: self.terms.iter().map(|(weight, term)| (*weight, term.within(cap))).collect() })
    }

    fn estimate(&self) -> f64 {
        self.terms.iter().map(|(weight, term)| weight * term.estimate()).sum()
    }

    fn minorant(&self, e: &Vec3) -> Minorant {
        self.terms.iter().fold(Minorant::ZERO, |sum, (weight, term)| term.minorant(e).added(*weight, &sum))
    }

    fn floor(&self) -> f64 {
        self.terms.iter().map(|(weight, term)| weight * term.floor()).sum()
    }

    fn hint(&self) -> Option<Vec3> {
        self.terms.iter().find_map(|(_, term)| term.hint())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::hook;
    use crate::orient::{Certified, ObjectiveSettings, Search, objective};

    #[test]
    fn a_sum_adds_raw_values_and_gradients() {
        let facets = Facets::with(vec![Vec3::x(), -Vec3::x()], vec![2.0, 3.0], vec![Vec3::zeros(), Vec3::x() * 4.0]);
        let up = Vec3::new(0.6, 0.0, 0.8);
        let sum = objective("2*height + 0.5*normal-z", &ObjectiveSettings::default()).unwrap();
        assert!((sum.value(&facets, &up) - (2.0 * 4.0 * 0.6 + 0.5 * 2.0 * 0.36)).abs() < 1e-12);
        let wanted = (Vec3::x() * 8.0 + Vec3::x() * (0.5 * 4.0 * 0.6)).dot(&Vec3::new(0.8, 0.0, -0.6));
        let got = sum.gradient(&facets, &up).unwrap();
        assert!((got.dot(&Vec3::new(0.8, 0.0, -0.6)) - wanted).abs() < 1e-12, "{got:?} {wanted}");
    }

    /// The largest height of a box is its diagonal, the largest shadow of it half the area's vector: known by hand.
    #[test]
    fn a_negative_weight_has_a_bound_and_the_gap_closes() {
        let facets = Facets::of(&hook().parts[0].1);
        let diagonal = Vec3::new(40.0, 10.0, 60.0).norm();
        let highest = objective("-1*height", &ObjectiveSettings::default()).unwrap();
        let found = Certified::default().search(highest.as_ref(), &facets);
        assert!((found.minima[0].value + diagonal).abs() < 1e-9 * diagonal, "{:?}", found.minima[0]);
        let lower = found.lower_bound.unwrap();
        assert!(lower <= -diagonal * (1.0 - 1e-12) && lower > -diagonal * (1.0 + 1e-5), "{lower}");
    }

    #[test]
    fn what_has_no_upper_bound_is_named() {
        let facets = Facets::of(&hook().parts[0].1);
        let sum = objective("2*height+-1*support-volume-column", &ObjectiveSettings::default()).unwrap();
        assert!(sum.local(&facets).is_none());
        let why = sum.unproved(&facets).unwrap();
        assert!(why.starts_with("support-volume-column "), "{why}");
        assert_eq!(objective("height+-0.1*staircase", &ObjectiveSettings::default()).unwrap().unproved(&facets), None);
    }
}
