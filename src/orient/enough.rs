//! The best of the directions whose first layer lies on enough of the bed, with a bound that holds for just those.
//!
//! Over a cap the footprint is at most the sum over the facets that face down somewhere on it, each with the share that may lie within
//! the first layer: heights are measured from the point that is lowest at the cap's centre, and every point is at least as high above the
//! bed as above that one. Caps on which even so much is too little are left out of the search.

use super::printable::share_below;
use super::ties::footprint;
use super::{Cap, Certified, Facets, Found, Local, Minimum, Minorant, Objective, Proof};
use crate::geom::Vec3;

/// What rounding may take off a footprint, relative.
const ROUNDED: f64 = 1e-9;

/// Proves how good `best`, which lies on enough, is among the directions that lay at least `least_mm2` of the first layer on the bed, or
/// finds a better one; `budget` evaluations and bounds at most, and as many as are worth it for `f` without one.
pub fn proved_standing(
    f: &dyn Objective,
    facets: &Facets,
    best: &Minimum,
    least_mm2: f64,
    layer_mm: f64,
    budget: usize,
) -> Found {
    let search = Certified::of(f);
    let search = Certified { budget: budget.min(search.budget), ..search };
    search.improving(&Enough { f, least_mm2, layer_mm }, facets, best)
}

/// An objective where the footprint is large enough; infinite elsewhere.
struct Enough<'f> {
    f: &'f dyn Objective,
    least_mm2: f64,
    layer_mm: f64,
}

impl Objective for Enough<'_> {
    fn name(&self) -> &str {
        self.f.name()
    }

    fn value(&self, facets: &Facets, up: &Vec3) -> f64 {
        let enough = footprint(facets, up, self.layer_mm) >= self.least_mm2;
        if enough { self.f.value(facets, up) } else { f64::INFINITY }
    }

    fn gradient(&self, _: &Facets, _: &Vec3) -> Option<Vec3> {
        None
    }

    fn proof(&self) -> Proof {
        self.f.proof()
    }

    fn local<'a>(&'a self, facets: &'a Facets) -> Option<Box<dyn Local<'a> + 'a>> {
        let all = (0..facets.corners.len() as u32).collect();
        let most = Most { facets, kept: all, layer_mm: self.layer_mm, mm2: f64::INFINITY };
        Some(Box::new(OnEnough {
            inner: self.f.local(facets)?,
            least_mm2: self.least_mm2,
            most,
            centre_mm2: f64::INFINITY,
        }))
    }
}

/// An upper bound of the footprint over a cap.
struct Most<'a> {
    facets: &'a Facets,
    /// The facets that may lie in the first layer there and face down.
    kept: Vec<u32>,
    layer_mm: f64,
    mm2: f64,
}

impl<'a> Most<'a> {
    /// The same for a cap inside this one.
    fn within(&self, cap: &Cap) -> Most<'a> {
        let facets = self.facets;
        let lowest = facets.lowest(&cap.centre);
        let low = Low::of(cap);
        let (mut kept, mut mm2) = (Vec::new(), 0.0);
        for &index in &self.kept {
            let facing = -low.least(&facets.each[index as usize].area);
            if facing <= 0.0 {
                continue;
            }
            // Nothing lies below the bed.
            let corners = facets.corners[index as usize];
            let heights = corners.map(|i| low.least(&(facets.points[i as usize] - lowest)).max(0.0));
            if heights.iter().any(|z| *z <= self.layer_mm) {
                kept.push(index);
                mm2 += facing * share_below(&heights, self.layer_mm);
            }
        }
        Most { facets, kept, layer_mm: self.layer_mm, mm2 }
    }
}

/// How far a cap lets a vector turn down.
struct Low {
    centre: Vec3,
    sine: f64,
    cosine: f64,
}

impl Low {
    fn of(cap: &Cap) -> Self {
        let (sine, cosine) = cap.radius.min(std::f64::consts::PI).sin_cos();
        Self { centre: cap.centre, sine, cosine }
    }

    /// The least `v.d` over the cap, as [`Cap::range`] has it, without angles.
    fn least(&self, v: &Vec3) -> f64 {
        let (along, square) = (v.dot(&self.centre), v.norm_squared());
        let length = square.sqrt();
        if along < -length * self.cosine {
            return -length;
        }
        along * self.cosine - (square - along * along).max(0.0).sqrt() * self.sine
    }
}

/// What is known of the objective on a cap, and how much may lie on the bed there.
struct OnEnough<'a> {
    inner: Box<dyn Local<'a> + 'a>,
    least_mm2: f64,
    most: Most<'a>,
    /// The footprint at the centre.
    centre_mm2: f64,
}

impl<'a> Local<'a> for OnEnough<'a> {
    fn within(&self, cap: &Cap) -> Box<dyn Local<'a> + 'a> {
        let most = self.most.within(cap);
        let centre_mm2 = most.within(&Cap { centre: cap.centre, radius: 0.0 }).mm2;
        Box::new(OnEnough { inner: self.inner.within(cap), least_mm2: self.least_mm2, most, centre_mm2 })
    }

    fn minorant(&self, e: &Vec3) -> Minorant {
        self.inner.minorant(e)
    }

    fn minorants(&self, places: &[Vec3]) -> Vec<Minorant> {
        self.inner.minorants(places)
    }

    fn estimate(&self) -> f64 {
        if self.centre_mm2 < self.least_mm2 { f64::INFINITY } else { self.inner.estimate() }
    }

    fn floor(&self) -> f64 {
        let none = self.most.mm2 * (1.0 + ROUNDED) < self.least_mm2;
        if none { f64::INFINITY } else { self.inner.floor() }
    }

    fn hint(&self) -> Option<Vec3> {
        self.inner.hint()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::{prism, solid_box};
    use crate::geom::SplitMix64;
    use crate::orient::sphere::lattice;
    use crate::orient::ties::standing;
    use crate::orient::{ObjectiveSettings, Search, objective};

    const LAYER: f64 = 0.2;

    struct Numbers(SplitMix64);

    impl Numbers {
        fn between(&mut self, low: f64, high: f64) -> f64 {
            low + (high - low) * self.0.unit()
        }
    }

    fn solids() -> Vec<Facets> {
        let rise = 10.0 * 0.2f64.to_radians().tan();
        let keel = [[-10.0, rise], [0.0, 0.0], [10.0, rise], [0.0, 6.0]];
        let dart = [[-8.0, 0.0], [0.0, 3.0], [8.0, 0.0], [0.0, 20.0]];
        let solids = [
            solid_box(Vec3::new(3.0, -4.0, 5.0), Vec3::new(23.0, 26.0, 65.0)),
            prism(&keel, [0.0, 4.0]),
            prism(&dart, [1.0, 12.0]),
        ];
        solids.iter().map(Facets::of).collect()
    }

    #[test]
    fn no_direction_of_a_cap_lays_more_on_the_bed_than_is_said() {
        let mut numbers = Numbers(SplitMix64::seeded(16));
        let mut close = 0;
        for facets in solids() {
            let whole = Most {
                facets: &facets,
                kept: (0..facets.each.len() as u32).collect(),
                layer_mm: LAYER,
                mm2: f64::INFINITY,
            };
            for i in 0..400 {
                // About every other one a plane lies flat.
                let flat = -facets.each[i % facets.each.len()].area.normalize();
                let centre = if i % 2 == 0 { lattice(i, 400) } else { flat };
                let radius = numbers.between(1e-5_f64.ln(), 1.0_f64.ln()).exp();
                let cap = Cap { centre, radius };
                let most = whole.within(&Cap { centre, radius: 2.0 * radius }).within(&cap).mm2;
                for _ in 0..40 {
                    let aside = numbers.0.direction();
                    let across = (aside - centre * aside.dot(&centre)).normalize();
                    let angle = radius * numbers.between(0.0, 1.0);
                    let up = centre * angle.cos() + across * angle.sin();
                    let seen = footprint(&facets, &up, LAYER);
                    assert!(seen <= most * (1.0 + ROUNDED), "{seen} mm2 at {up:?}, {most} at most within {radius}");
                    close += usize::from(seen > 0.0 && seen > 0.99 * most);
                }
            }
        }
        assert!(close > 1000, "{close} directions have what is said");
    }

    #[test]
    fn the_bound_is_that_of_the_directions_that_stand() {
        let mut numbers = Numbers(SplitMix64::seeded(17));
        for (facets, least) in solids().iter().zip([700.0, 79.0, 150.0]) {
            for name in ["-1*height", "height", "staircase"] {
                let f =
                    objective(name, &ObjectiveSettings { layer_mm: LAYER, ..ObjectiveSettings::default() }).unwrap();
                let anywhere = Certified::of(f.as_ref()).search(f.as_ref(), facets);
                let known = standing(f.as_ref(), facets, &anywhere.minima, least, LAYER);
                let best = known.minima[0];
                let found = proved_standing(f.as_ref(), facets, &best, least, LAYER, 400_000);
                let bound = found.lower_bound.unwrap();
                let here = found.minima[0];
                assert!(here.value <= best.value && footprint(facets, &here.up, LAYER) >= least, "{name}: {here:?}");
                let gap = here.value - bound;
                assert!((0.0..0.02 * here.value.abs() + 1e-6).contains(&gap), "{name}: {here:?}, at least {bound}");
                // By sampling, mostly about the directions that lie flat.
                for i in 0..20_000 {
                    let flat = -facets.each[i % facets.each.len()].area.normalize();
                    let off = numbers.between(1e-6_f64.ln(), 2.0_f64.ln()).exp();
                    let up = (flat + numbers.0.direction() * off).normalize();
                    if footprint(facets, &up, LAYER) >= least {
                        let value = f.value(facets, &up);
                        assert!(value >= bound, "{name}: {value} at {up:?}, at least {bound}");
                    }
                }
            }
        }
        // What would be best anywhere stands on nothing.
        let (facets, f) = (&solids()[0], objective("-1*height", &ObjectiveSettings::default()).unwrap());
        let best = standing(f.as_ref(), facets, &[], 700.0, LAYER).minima[0];
        let bound = proved_standing(f.as_ref(), facets, &best, 700.0, LAYER, 400_000).lower_bound.unwrap();
        assert!((-31.5..=-30.0).contains(&bound), "a box of 20 x 30 x 60 on its sides: {bound}");
    }
}
