//! What an objective is, and those of Ramos et al. (2021) section 4.

use super::facets::{FLAT, tangential};
use super::{Cap, Facets, Local, bound};
use crate::geom::Vec3;

/// How bad a build direction is; smaller is better.
pub trait Objective: Sync {
    /// The `--objective` name.
    fn name(&self) -> &str;

    /// The value at the unit direction `up`.
    fn value(&self, facets: &Facets, up: &Vec3) -> f64;

    /// The gradient on the sphere (at right angles to `up`, per radian) where the function has one; at a kink that of
    /// one side. `None` for a function that is constant between its jumps.
    fn gradient(&self, facets: &Facets, up: &Vec3) -> Option<Vec3>;

    /// What each facet adds to the value at `up`, where it is a sum over the facets that can be painted.
    fn by_facet(&self, _facets: &Facets, _up: &Vec3) -> Option<Vec<f64>> {
        None
    }

    /// Whether it means anything on closed meshes alone: a volume, or what needs an inside.
    fn needs_closed(&self) -> bool {
        false
    }

    /// Values nearer than this are one for a printer; 0 where every difference counts.
    fn tie(&self, _facets: &Facets) -> f64 {
        0.0
    }

    /// What is worth proving of it.
    fn proof(&self) -> Proof {
        Proof::EXACT
    }

    /// What is known on the whole sphere, for lower bounds that hold; `None` where this version has none.
    fn local<'a>(&'a self, _facets: &'a Facets) -> Option<Box<dyn Local<'a> + 'a>> {
        None
    }

    /// The same of minus the objective, for negative weights in sums.
    fn negated<'a>(&'a self, _facets: &'a Facets) -> Option<Box<dyn Local<'a> + 'a>> {
        None
    }

    /// Why there is no bound for the part with `facets`, as a sentence; `None` where there is one.
    fn unproved(&self, _facets: &Facets) -> Option<String> {
        None
    }
}

/// How far `certified` goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Proof {
    /// It ends when the lower bound is within this of the best value, relative.
    pub gap: f64,
    /// Evaluations and bounds at most; the gap is then what it is.
    pub budget: usize,
}

impl Proof {
    /// For the objectives whose bounds are of second order.
    pub const EXACT: Self = Self { gap: 1e-6, budget: 400_000 };
    /// For those that jump, or bend sharply.
    pub const CLOSE: Self = Self { gap: 1e-3, budget: 400_000 };
    /// For those whose bounds are of first order and whose evaluations take long: seldom reached.
    pub const ROUGH: Self = Self { gap: 1e-2, budget: 2_000 };
}

/// Staircase error, `t²/2 * sum A |d.n|` without the facets that lie flat (Ramos et al. (2021), section 4), mm⁴ at t in mm.
#[derive(Clone, Copy, Debug)]
pub struct Staircase {
    /// Layer height `t`, mm.
    pub layer_mm: f64,
}

impl Objective for Staircase {
    fn name(&self) -> &str {
        "staircase"
    }

    fn value(&self, facets: &Facets, up: &Vec3) -> f64 {
        let sum: f64 = facets.normals().sum(|n, area, _| {
            let along = n.dot(up).abs();
            if along >= FLAT { 0.0 } else { along * area }
        });
        sum * self.layer_mm * self.layer_mm / 2.0
    }

    fn gradient(&self, facets: &Facets, up: &Vec3) -> Option<Vec3> {
        let sum: Vec3 = facets.normals().sum(|n, area, _| {
            let along = n.dot(up);
            n * if along.abs() < FLAT { area * along.signum() } else { 0.0 }
        });
        Some(tangential(sum, up) * (self.layer_mm * self.layer_mm / 2.0))
    }

    fn local<'a>(&'a self, facets: &'a Facets) -> Option<Box<dyn Local<'a> + 'a>> {
        Some(Box::new(bound::Shadow::of(facets, self.layer_mm * self.layer_mm / 2.0, false)))
    }

    fn negated<'a>(&'a self, facets: &'a Facets) -> Option<Box<dyn Local<'a> + 'a>> {
        Some(Box::new(bound::MinusShadow::of(facets, self.layer_mm * self.layer_mm / 2.0, false)))
    }
}

/// Area that faces down, projected: `sum A |d.n|` over `d.n < 0` but not flat down (Ramos et al. (2021), section 4), mm².
///
/// The paper leaves out facets on the table as well; a flat-down facet is the only one that can lie on it.
#[derive(Clone, Copy, Debug)]
pub struct SupportArea;

impl Objective for SupportArea {
    fn name(&self) -> &str {
        "support-area"
    }

    fn value(&self, facets: &Facets, up: &Vec3) -> f64 {
        facets.normals().sum(|n, area, _| {
            let along = n.dot(up);
            if along < 0.0 && along > -FLAT { -along * area } else { 0.0 }
        })
    }

    fn gradient(&self, facets: &Facets, up: &Vec3) -> Option<Vec3> {
        let sum: Vec3 = facets.normals().sum(|n, area, _| {
            let along = n.dot(up);
            n * if along < 0.0 && along > -FLAT { -area } else { 0.0 }
        });
        Some(tangential(sum, up))
    }

    fn local<'a>(&'a self, facets: &'a Facets) -> Option<Box<dyn Local<'a> + 'a>> {
        Some(Box::new(bound::Shadow::of(facets, 1.0, true)))
    }

    fn negated<'a>(&'a self, facets: &'a Facets) -> Option<Box<dyn Local<'a> + 'a>> {
        Some(Box::new(bound::MinusShadow::of(facets, 1.0, true)))
    }
}

/// Height along the direction, `max v.d - min v.d` (Ramos et al. (2021), section 4: building time), mm.
#[derive(Clone, Copy, Debug)]
pub struct Height;

impl Objective for Height {
    fn name(&self) -> &str {
        "height"
    }

    fn value(&self, facets: &Facets, up: &Vec3) -> f64 {
        facets.extent(up)
    }

    fn gradient(&self, facets: &Facets, up: &Vec3) -> Option<Vec3> {
        Some(tangential(facets.lowest(&-up) - facets.lowest(up), up))
    }

    fn local<'a>(&'a self, facets: &'a Facets) -> Option<Box<dyn Local<'a> + 'a>> {
        Some(Box::new(bound::Extent { facets, cap: Cap::WHOLE }))
    }

    fn negated<'a>(&'a self, facets: &'a Facets) -> Option<Box<dyn Local<'a> + 'a>> {
        Some(Box::new(bound::MinusHeight::of(facets)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A box of 2 x 3 x 4 mm.
    fn brick() -> Facets {
        let corner = |i: usize| Vec3::new([0.0, 2.0][i & 1], [0.0, 3.0][i >> 1 & 1], [0.0, 4.0][i >> 2 & 1]);
        let axes = [(Vec3::x(), 12.0), (Vec3::y(), 8.0), (Vec3::z(), 6.0)];
        let (mut normals, mut areas) = (vec![], vec![]);
        for (n, a) in axes {
            normals.extend([n, -n]);
            areas.extend([a, a]);
        }
        Facets::with(normals, areas, (0..8).map(corner).collect())
    }

    #[test]
    fn a_box_on_a_face_costs_nothing_and_dips_there_alone() {
        let staircase = Staircase { layer_mm: 0.2 };
        assert_eq!(staircase.value(&brick(), &Vec3::z()), 0.0);
        let tilted = Vec3::new(0.01, 0.0, 1.0).normalize();
        // 0.02 * (2 * 12 * sin + 2 * 6 * cos) for the four faces that are no longer parallel or flat.
        let wanted = 0.02 * (24.0 * tilted.x + 12.0 * tilted.z);
        assert!((staircase.value(&brick(), &tilted) - wanted).abs() < 1e-12);
        assert_eq!(SupportArea.value(&brick(), &Vec3::z()), 0.0);
        assert!((SupportArea.value(&brick(), &tilted) - (12.0 * tilted.x + 6.0 * tilted.z)).abs() < 1e-12);
    }

    #[test]
    fn height_is_the_extent_along_the_direction() {
        assert_eq!(Height.value(&brick(), &Vec3::y()), 3.0);
        let diagonal = Vec3::new(2.0, 3.0, 4.0).normalize();
        assert!((Height.value(&brick(), &diagonal) - 29f64.sqrt()).abs() < 1e-12);
    }
}
