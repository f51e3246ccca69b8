//! What a printer cannot tell apart, and what must stand: of directions that tie the one that lies best, and directions whose first
//! layer is large enough.

use super::printable::planes;
use super::trial::Trial;
use super::{Facets, FirstLayer, Found, Minimum, Objective, SAME_MINIMUM, Staircase, distinct, nelder_mead};
use crate::geom::Vec3;

/// Of the planes on which a part lies so many are tried, those with the largest footprint first.
const PLANES: usize = 24;
/// Walks to more footprint, and with enough of it to less of the objective; evaluations of each, and the simplex that ends them,
/// radians.
const WALKS: usize = 6;
const STEPS: usize = 120;
const WALKED: f64 = 1e-7;

/// A direction with its footprint.
struct Lying {
    up: Vec3,
    area_mm2: f64,
}

/// The directions of the part's own planes, the largest footprint first.
fn lying(facets: &Facets, layer_mm: f64) -> Vec<Lying> {
    let mut all: Vec<Lying> =
        planes(facets).into_iter().map(|up| Lying { up, area_mm2: footprint(facets, &up, layer_mm) }).collect();
    all.sort_by(|a, b| b.area_mm2.total_cmp(&a.area_mm2));
    all
}

/// The area of the part's footprint, mm².
pub(super) fn footprint(facets: &Facets, up: &Vec3, layer_mm: f64) -> f64 {
    FirstLayer::of(facets, facets.mass(), up, layer_mm).area_mm2
}

/// `found` with the one first that a person would take of all that tie with the best ([`Objective::tie`]): with the largest footprint
/// of the first layer, then the lowest, then the one with the least steps. The part's own planes are tried too: facets that rounding
/// lifts off the bed cost something. The lower bound stays, since it holds for all.
#[must_use]
pub fn without_ties(mut found: Found, f: &dyn Objective, facets: &Facets, layer_mm: f64, tried: Tried) -> Found {
    let tie = f.tie(facets);
    let Some(best) = found.minima.first().map(|m| m.value).filter(|_| tie > 0.0) else { return found };
    let enough = |lying: &Lying| tried.least_mm2.is_none_or(|least| lying.area_mm2 >= least);
    for lying in lying(facets, layer_mm).into_iter().filter(enough).take(PLANES.min(tried.most)) {
        found.evaluations += 1;
        let value = f.value(facets, &lying.up);
        if value <= best + tie {
            found.minima.push(Minimum { up: lying.up, value, ended: true });
        }
    }
    found.minima.sort_by(|a, b| a.value.total_cmp(&b.value));
    let mut tied: Vec<Minimum> = found.minima.iter().copied().filter(|m| m.value <= best + tie).collect();
    let steps = Staircase { layer_mm };
    let figures: [&dyn Fn(&Vec3) -> f64; 3] =
        [&|up| -footprint(facets, up, layer_mm), &|up| facets.extent(up), &|up| steps.value(facets, up)];
    for figure in figures {
        let values: Vec<f64> = tied.iter().map(|m| figure(&m.up)).collect();
        let least = values.iter().copied().fold(f64::INFINITY, f64::min);
        let mut values = values.into_iter();
        tied.retain(|_| values.next().is_some_and(|value| value <= least + SAME_FIGURE * least.abs()));
    }
    let Some(&first) = tied.first() else { return found };
    let mut minima = distinct(std::mem::take(&mut found.minima));
    minima.retain(|m| (m.up - first.up).norm() > SAME_MINIMUM);
    minima.insert(0, first);
    Found { minima, ..found }
}

/// Which of the part's own planes are tried.
#[derive(Clone, Copy, Debug)]
pub struct Tried {
    /// Those with at least this footprint, mm².
    pub least_mm2: Option<f64>,
    /// At most so many.
    pub most: usize,
}

/// Figures of the tie-break that agree to this, relative, are one.
const SAME_FIGURE: f64 = 1e-3;

/// Directions whose first layer lies on enough of the bed.
#[derive(Clone, Debug, PartialEq)]
pub struct StandingMinima {
    /// Best first; none where no direction that was found has enough.
    pub minima: Vec<Minimum>,
    /// The largest footprint that was found, mm².
    pub most_mm2: f64,
    /// How often the objective was evaluated.
    pub evaluations: usize,
}

/// The directions that lay at least `least_mm2` of the first layer on the bed, best first by `f`: of `known`, of the part's own planes,
/// and between them by walks. A lower bound over all directions holds for them as well.
pub fn standing(
    f: &dyn Objective,
    facets: &Facets,
    known: &[Minimum],
    least_mm2: f64,
    layer_mm: f64,
) -> StandingMinima {
    let mut all = lying(facets, layer_mm);
    all.extend(known.iter().map(|m| Lying { up: m.up, area_mm2: footprint(facets, &m.up, layer_mm) }));
    all.sort_by(|a, b| b.area_mm2.total_cmp(&a.area_mm2));
    let walked = |f: &dyn Objective, from: &Vec3| {
        nelder_mead::descend(&mut Trial::new(f, facets, STEPS), *from, STEPS, WALKED).up
    };
    let largest: Vec<Vec3> = all.iter().take(WALKS).map(|l| walked(&Footprint { layer_mm }, &l.up)).collect();
    all.extend(largest.into_iter().map(|up| Lying { up, area_mm2: footprint(facets, &up, layer_mm) }));
    let most_mm2 = all.iter().map(|l| l.area_mm2).fold(0.0, f64::max);
    all.retain(|l| l.area_mm2 >= least_mm2);
    let mut minima: Vec<Minimum> =
        all.iter().map(|l| Minimum { up: l.up, value: f.value(facets, &l.up), ended: true }).collect();
    minima.sort_by(|a, b| a.value.total_cmp(&b.value));
    let held = Held { f, least_mm2, layer_mm };
    let between: Vec<Vec3> = minima.iter().take(WALKS).map(|m| walked(&held, &m.up)).collect();
    let walks = between.len();
    for up in between {
        if footprint(facets, &up, layer_mm) >= least_mm2 {
            minima.push(Minimum { up, value: f.value(facets, &up), ended: true });
        }
    }
    let evaluations = minima.len() + walks * STEPS;
    StandingMinima { minima: distinct(minima), most_mm2, evaluations }
}

/// Minus the footprint, mm².
struct Footprint {
    layer_mm: f64,
}

impl Objective for Footprint {
    fn name(&self) -> &str {
        "footprint"
    }

    fn value(&self, facets: &Facets, up: &Vec3) -> f64 {
        -footprint(facets, up, self.layer_mm)
    }

    fn gradient(&self, _: &Facets, _: &Vec3) -> Option<Vec3> {
        None
    }
}

/// An objective where the footprint is large enough, else more than any value, by what is missing.
struct Held<'a> {
    f: &'a dyn Objective,
    least_mm2: f64,
    layer_mm: f64,
}

/// More than any objective's value.
const FAR: f64 = 1e30;

impl Objective for Held<'_> {
    fn name(&self) -> &str {
        self.f.name()
    }

    fn value(&self, facets: &Facets, up: &Vec3) -> f64 {
        let missing = self.least_mm2 - footprint(facets, up, self.layer_mm);
        if missing > 0.0 { FAR * (1.0 + missing / self.least_mm2) } else { self.f.value(facets, up) }
    }

    fn gradient(&self, _: &Facets, _: &Vec3) -> Option<Vec3> {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::{prism, solid_box};
    use crate::geom::Angle;
    use crate::orient::{Stop, SupportVolumeColumn};

    #[test]
    fn a_cube_that_ties_lies_on_a_face() {
        let facets = Facets::of(&solid_box(Vec3::zeros(), Vec3::repeat(20.0)));
        let f = SupportVolumeColumn { overhang: Angle::from_deg(45.0), resolution_mm: 0.5 };
        // On an edge at just 45 degrees nothing hangs either.
        let edge = Vec3::new(1.0, 0.0, 1.0).normalize();
        let only = Found {
            minima: vec![Minimum { up: edge, value: f.value(&facets, &edge), ended: true }],
            evaluations: 1,
            lower_bound: None,
            stop: Stop::Converged,
            history: vec![],
        };
        let best = without_ties(only, &f, &facets, 0.2, Tried { least_mm2: None, most: 100 }).minima[0];
        assert!(best.up.amax() > 1.0 - 1e-9 && best.value == 0.0, "{best:?}");
    }

    #[test]
    fn enough_footprint_is_found_between_two_faces() {
        // A keel whose two slopes rise by a fifth of a degree from its middle line: only between them both lie in the first layer.
        let rise = 10.0 * 0.2f64.to_radians().tan();
        let outline = [[-10.0, rise], [0.0, 0.0], [10.0, rise], [0.0, 6.0]];
        let facets = Facets::of(&prism(&outline, [0.0, 4.0]));
        let f = SupportVolumeColumn { overhang: Angle::from_deg(45.0), resolution_mm: 0.5 };
        assert!(lying(&facets, 0.05).iter().all(|l| l.area_mm2 < 79.0), "none of its planes has enough");
        let all = standing(&f, &facets, &[], 60.0, 0.05);
        assert!((all.most_mm2 - 80.0).abs() < 0.1, "{all:?}");
        let all = standing(&f, &facets, &[], 79.0, 0.05);
        assert!(all.minima.iter().any(|m| m.up.z > 0.9999), "{all:?}");
        assert!(standing(&f, &facets, &[], 81.0, 0.05).minima.is_empty());
    }
}
