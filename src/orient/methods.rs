//! Searches by name, and all minima of an objective by any of them.

use super::gradient::GradientMethod;
use super::{
    Certified, Descent, DifferentialEvolution, Direct, Facets, Found, GridSearch, Mmls, Multistart, NelderMead,
    Objective, Search, Starts,
};

/// The `--method` names, the default first.
pub const METHODS: [&str; 10] = [
    "certified",
    "mmls",
    "multistart",
    "bfgs",
    "cg",
    "newton-cg",
    "nelder-mead",
    "direct",
    "differential-evolution",
    "grid",
];

/// The search called `name` as it suits `objective`, with `budget` evaluations (its own usual number where none is given)
/// and `seed` for those that draw; `None` for a name that is none of [`METHODS`].
pub fn method(name: &str, objective: &dyn Objective, budget: Option<usize>, seed: u64) -> Option<Box<dyn Search>> {
    let or = |own: usize| budget.unwrap_or(own);
    let descent = |method: GradientMethod| {
        let usual = Descent::by(method);
        Box::new(Descent { budget: or(usual.budget), ..usual })
    };
    Some(match name {
        "certified" => {
            let usual = Certified::of(objective);
            Box::new(Certified { budget: or(usual.budget), ..usual })
        }
        "mmls" => {
            let usual = Mmls::default();
            Box::new(Mmls { budget: or(usual.budget), seed, ..usual })
        }
        "multistart" => {
            let usual = Multistart {
                from: Starts::LatinHypercube,
                descent: Some(GradientMethod::Bfgs),
                seed,
                ..Multistart::default()
            };
            Box::new(Multistart { budget: (or(usual.budget * usual.starts) / usual.starts).max(3), ..usual })
        }
        "bfgs" => descent(GradientMethod::Bfgs),
        "cg" => descent(GradientMethod::ConjugateGradient),
        "newton-cg" => descent(GradientMethod::NewtonCg),
        "nelder-mead" => {
            let usual = NelderMead::default();
            Box::new(NelderMead { budget: or(usual.budget), ..usual })
        }
        "direct" => Box::new(Direct { budget: or(Direct::default().budget) }),
        "differential-evolution" => {
            let usual = DifferentialEvolution::default();
            Box::new(DifferentialEvolution { budget: or(usual.budget), seed, ..usual })
        }
        "grid" => Box::new(GridSearch { budget: or(GridSearch::default().budget) }),
        _ => return None,
    })
}

/// Evaluations around minima: of twenty.
const LOOKS: usize = 720;

/// All distinct local and global minima of `objective` that `search` finds, best first, and the dips at the largest facet
/// normals, which no descent finds; directions are in the frame of the part's mesh. The dips take up to 1000 evaluations;
/// the history is the search's alone.
///
/// Around the best of them it is looked whether something is lower ([`Found::looked_around`]; up to 720 evaluations more).
///
/// Minima within half a degree of a better one are left out. A part without facets has one minimum somewhere, of value 0.
/// The lower bound, where `search` proves one, holds for the dips as well.
///
/// Where `budget` is given, search and dips together take no more.
pub fn minima(facets: &Facets, objective: &dyn Objective, search: &dyn Search, budget: Option<usize>) -> Found {
    let found = search.search(objective, facets);
    match budget {
        Some(budget) => {
            let left = |found: &Found| budget.saturating_sub(found.evaluations);
            let most = left(&found);
            let found = found.with_dips_within(objective, facets, most);
            let most = left(&found);
            found.looked_around(objective, facets, most)
        }
        None => found.with_dips(objective, facets).looked_around(objective, facets, LOOKS),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::candelabrum;
    use crate::orient::{Height, Stop};

    /// Where the budget ends a search, or a run of it is stuck, what it lists is no minimum, and says so; of all others nothing around is lower.
    #[test]
    fn what_a_search_was_stopped_at_is_no_minimum() {
        let facets = Facets::of(&candelabrum().parts[1].1);
        let f = crate::orient::Staircase { layer_mm: 0.2 };
        let (mut rested, mut stopped) = (0, 0);
        for seed in 1..=3 {
            let found = minima(&facets, &f, &*method("mmls", &f, None, seed).unwrap(), None);
            for minimum in &found.minima {
                let [e1, e2] = crate::orient::sphere::tangents(&minimum.up);
                let around = (0..160).map(|k| {
                    let (s, c) = (std::f64::consts::TAU * f64::from(k) / 160.0).sin_cos();
                    let far = (0.02 + 0.02 * f64::from(k % 5)).to_radians();
                    f.value(&facets, &(minimum.up + (e1 * c + e2 * s) * far).normalize())
                });
                let least = around.fold(f64::INFINITY, f64::min);
                let is_beaten = least < minimum.value * (1.0 - 1e-4);
                assert!(!minimum.ended || !is_beaten, "seed {seed}: {minimum:?} and {least} beside it");
                rested += usize::from(minimum.ended);
                stopped += usize::from(!minimum.ended && is_beaten);
            }
        }
        assert!(rested > 0 && stopped > 0, "{rested} at rest, {stopped} stopped");
    }

    #[test]
    fn every_method_is_there_keeps_to_its_budget_and_finds_the_least_height_of_an_arm() {
        let facets = Facets::of(&candelabrum().parts[3].1);
        let least = Certified::default().search(&Height, &facets).lower_bound.unwrap();
        for name in METHODS {
            let search = method(name, &Height, Some(3000), 1).unwrap();
            assert_eq!(search.name(), name);
            let found = search.search(&Height, &facets);
            let best = found.minima[0].value;
            assert!(found.evaluations <= 3000, "{name}: {}", found.evaluations);
            assert!(best >= least * (1.0 - 1e-12), "{name}");
            let reach = if matches!(name, "bfgs" | "cg" | "newton-cg" | "grid") { 6.0 } else { 1.02 };
            assert!(best <= least * reach, "{name}: {best} for {least}");
            let history = &found.history;
            assert!(
                history.windows(2).all(|w| w[0].value > w[1].value && w[0].evaluations < w[1].evaluations),
                "{name}"
            );
            assert_eq!(history.last().map(|h| h.value), Some(best), "{name}");
        }
        assert!(method("certain", &Height, None, 1).is_none());
    }

    #[test]
    fn a_search_that_ran_out_says_so() {
        let facets = Facets::of(&candelabrum().parts[3].1);
        for name in METHODS.into_iter().filter(|&name| name != "grid") {
            let found = method(name, &Height, Some(120), 1).unwrap().search(&Height, &facets);
            let ends_by_itself = matches!(name, "bfgs" | "cg" | "newton-cg");
            assert!(found.stop == Stop::Budget || ends_by_itself, "{name}");
        }
    }
}
