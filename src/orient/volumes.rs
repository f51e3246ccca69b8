//! The objectives that know how high a facet lies above the lowest point: seeds 000, 001 and 002.
//!
//! All of them take the bed to be the plane through the lowest corner point, and what hangs to be held from there, never
//! from the part itself.

use super::facets::{FLAT, tangential};
use super::hyperbolic::{one_and_tanh, tanh};
use super::{Cap, Facets, Local, Objective, Proof, bound};
use crate::geom::{Angle, Vec3};
use crate::mesh::TABLE_GAP_MM;

/// `sum A (b.d - min v.d) (n.d)^2` (de Castro (2020), equations 3.2.4 and 4.0.3), mm³: what lies level, by its height.
///
/// An evaluation costs 16 sums made once and the lowest point. de Castro (2020) takes the minimum over each
/// facet's first corner in some of its printed numbers; here it is over all corners.
#[derive(Clone, Copy, Debug)]
pub struct WeightedNormalZ;

impl Objective for WeightedNormalZ {
    fn name(&self) -> &str {
        "weighted-normal-z"
    }

    fn value(&self, facets: &Facets, up: &Vec3) -> f64 {
        facets.sums().value(&facets.lowest(up), up)
    }

    fn gradient(&self, facets: &Facets, up: &Vec3) -> Option<Vec3> {
        let form = facets.sums().form(&facets.lowest(up));
        Some(tangential(form.at(up) * 3.0, up))
    }

    fn local<'a>(&'a self, facets: &'a Facets) -> Option<Box<dyn Local<'a> + 'a>> {
        Some(Box::new(bound::Heights { facets, cap: Cap::WHOLE }))
    }

    fn negated<'a>(&'a self, facets: &'a Facets) -> Option<Box<dyn Local<'a> + 'a>> {
        Some(Box::new(bound::MinusHeights::of(facets)))
    }
}

/// The volume under all that overhangs, down to the bed: `sum -A n.d (b.d - min v.d)` over `-n.d > sin(overhang)`
/// (Boogers (2024), equation 3.23, exact), mm³.
///
/// The thesis counts its angle `t` from the horizontal and asks `-n.d > cos(t)`; here it is counted from the vertical,
/// `t = 90 - overhang` degrees. Columns that would stand on the part are counted to the bed. Jumps where a facet
/// passes the threshold.
#[derive(Clone, Copy, Debug)]
pub struct SupportVolumeConvex {
    /// Facets up to this angle from the vertical need no support.
    pub overhang: Angle,
}

impl Objective for SupportVolumeConvex {
    fn name(&self) -> &str {
        "support-volume-convex"
    }

    fn value(&self, facets: &Facets, up: &Vec3) -> f64 {
        let (low, from) = (facets.lowest(up).dot(up), self.overhang.rad().sin());
        let normals = facets.normals();
        normals.sum(|n, area, i| {
            let along = n.dot(up);
            // By rounding errors a facet on the bed may seem to lie below it.
            if -along > from { -along * (normals.moments[i].dot(up) - area * low).max(0.0) } else { 0.0 }
        })
    }

    fn needs_closed(&self) -> bool {
        true
    }

    fn tie(&self, facets: &Facets) -> f64 {
        facets.mass().support_tie_mm3()
    }

    fn gradient(&self, facets: &Facets, up: &Vec3) -> Option<Vec3> {
        let (lowest, from) = (facets.lowest(up), self.overhang.rad().sin());
        let normals = facets.normals();
        let sum: Vec3 = normals.sum(|n, area, i| {
            let along = n.dot(up);
            let arm = normals.moments[i] - lowest * area;
            if -along > from { -(n * arm.dot(up) + arm * along) } else { Vec3::zeros() }
        });
        Some(tangential(sum, up))
    }

    fn proof(&self) -> Proof {
        Proof::CLOSE
    }

    fn local<'a>(&'a self, facets: &'a Facets) -> Option<Box<dyn Local<'a> + 'a>> {
        Some(Box::new(bound::Columns::of(facets, self.overhang)))
    }

    fn negated<'a>(&'a self, facets: &'a Facets) -> Option<Box<dyn Local<'a> + 'a>> {
        Some(Box::new(bound::MinusColumns::of(facets, self.overhang)))
    }
}

/// `1/4 sum |S| (1 + tanh S) tanh(k (sum z - 3 min z))`, `S` minus twice the projected area (Puri (2019), section 2).
///
/// **Depends on the unit**: both `tanh` take plain numbers, so a model twice as large does not have the same minima.
/// Lengths are counted in mm times `scale`; the value is in the square of that unit. `k` is 1/10 as in the paper's code;
/// its text has no such factor. The paper's sign conventions give the same function, its bounds cover the sphere twice.
#[derive(Clone, Copy, Debug)]
pub struct TanhOverhang {
    /// Units of the formula in one mm; 1 takes mm as they are.
    pub scale: f64,
}

/// `1 + tanh S` is below 1e-19 from here down.
const NOTHING: f64 = -22.0;

/// The paper's code divides the height above the bed by ten.
const HEIGHT: f64 = 0.1;

impl TanhOverhang {
    /// `S` is the first times the area vector, the height the second times the barycentre over the lowest point.
    pub(super) fn factors(&self) -> [f64; 2] {
        [-2.0 * self.scale * self.scale, 3.0 * self.scale * HEIGHT]
    }
}

impl Objective for TanhOverhang {
    fn name(&self) -> &str {
        "tanh-overhang"
    }

    fn value(&self, facets: &Facets, up: &Vec3) -> f64 {
        let (low, [square, lift]) = (facets.lowest(up).dot(up), self.factors());
        let sum: f64 = facets.sum(|facet| {
            let s = square * facet.area.dot(up);
            // Half of all facets, on most parts: 1e-19 of what one that hangs costs.
            if s < NOTHING {
                return 0.0;
            }
            s.abs() * one_and_tanh(s) * tanh(lift * (facet.barycentre.dot(up) - low).max(0.0))
        });
        sum * 0.25
    }

    fn gradient(&self, facets: &Facets, up: &Vec3) -> Option<Vec3> {
        let (lowest, [square, lift]) = (facets.lowest(up), self.factors());
        let sum: Vec3 = facets.sum(|facet| {
            let (s, arm) = (square * facet.area.dot(up), facet.barycentre - lowest);
            let (ts, th) = (s.tanh(), (lift * arm.dot(up)).tanh());
            let by_s = s.signum() * (1.0 + ts) + s.abs() * (1.0 - ts * ts);
            facet.area * (square * by_s * th) + arm * (lift * s.abs() * (1.0 + ts) * (1.0 - th * th))
        });
        Some(tangential(sum, up) * 0.25)
    }

    fn proof(&self) -> Proof {
        Proof::CLOSE
    }

    fn local<'a>(&'a self, facets: &'a Facets) -> Option<Box<dyn Local<'a> + 'a>> {
        Some(Box::new(bound::HangingTerm::of(self.factors(), facets)))
    }
}

/// Minus the area that lies flat on the bed, mm²: larger contact is better (Boogers (2024), chapter 6), smaller values are.
///
/// Flat is within 0.1 degree, on the bed within 0.05 mm of the lowest point. 0 for a part that stands on an edge; constant
/// between its jumps, so only directions that lay a facet flat are worth trying.
#[derive(Clone, Copy, Debug)]
pub struct ContactArea;

impl Objective for ContactArea {
    fn name(&self) -> &str {
        "contact-area"
    }

    fn value(&self, facets: &Facets, up: &Vec3) -> f64 {
        let bed = facets.lowest(up).dot(up) + TABLE_GAP_MM;
        let flat = |area: f64, along: f64| along < 0.0 && -along >= FLAT * area;
        let lies: f64 = facets.sum(|f| {
            let (area, along) = (f.area.norm(), f.area.dot(up));
            if flat(area, along) && f.barycentre.dot(up) <= bed { area } else { 0.0 }
        });
        // Not `-sum`: nothing on the bed is 0, not -0.
        0.0 - lies
    }

    fn gradient(&self, _: &Facets, _: &Vec3) -> Option<Vec3> {
        None
    }

    fn local<'a>(&'a self, facets: &'a Facets) -> Option<Box<dyn Local<'a> + 'a>> {
        Some(Box::new(bound::Lying::of(facets)))
    }

    fn negated<'a>(&'a self, _: &'a Facets) -> Option<Box<dyn Local<'a> + 'a>> {
        Some(Box::new(bound::SomeArea))
    }
}
