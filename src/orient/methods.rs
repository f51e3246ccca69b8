//! Searches by name, and all minima of an objective by any of them.

use super::gradient::Method;
use super::{
    Certified, Descent, DifferentialEvolution, Direct, Facets, Found, Grid, Mmls, Multistart, NelderMead, Objective,
    Search, Starts,
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
    let descent = |method: Method| {
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
            let usual =
                Multistart { from: Starts::LatinHypercube, descent: Some(Method::Bfgs), seed, ..Multistart::default() };
            Box::new(Multistart { budget: (or(usual.budget * usual.starts) / usual.starts).max(3), ..usual })
        }
        "bfgs" => descent(Method::Bfgs),
        "cg" => descent(Method::ConjugateGradient),
        "newton-cg" => descent(Method::NewtonCg),
        "nelder-mead" => {
            let usual = NelderMead::default();
            Box::new(NelderMead { budget: or(usual.budget), ..usual })
        }
        "direct" => Box::new(Direct { budget: or(Direct::default().budget) }),
        "differential-evolution" => {
            let usual = DifferentialEvolution::default();
            Box::new(DifferentialEvolution { budget: or(usual.budget), seed, ..usual })
        }
        "grid" => Box::new(Grid { budget: or(Grid::default().budget) }),
        _ => return None,
    })
}

/// All distinct local and global minima of `objective` that `search` finds, best first, and the dips at the largest facet
/// normals, which no descent finds; directions are in the frame of the part's mesh. The dips take up to 1000 evaluations;
/// the history is the search's alone.
///
/// Minima within half a degree of a better one are left out. A part without facets has one minimum somewhere, of value 0.
/// The lower bound, where `search` proves one, holds for the dips as well.
///
/// Where `budget` is given, search and dips together take no more.
pub fn minima(facets: &Facets, objective: &dyn Objective, search: &dyn Search, budget: Option<usize>) -> Found {
    let found = search.search(objective, facets);
    match budget {
        Some(budget) => {
            let left = budget.saturating_sub(found.evaluations);
            found.with_dips_within(objective, facets, left)
        }
        None => found.with_dips(objective, facets),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::candelabrum;
    use crate::orient::{Height, Stop};

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
