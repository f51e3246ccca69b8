//! `support-volume` and `interface-area` with supports on the part itself by connectivity sets: Boogers (2024), chapter 4.
//!
//! The formula is the printed one. Where the thesis's numbers differ, it is for reasons that are known: its program re-orders
//! facets on extraction and pairs weights with the wrong ones, and it works in single precision.
//!
//! The lowest point is smoothed by `-1/w log sum exp(-w z)` **without** the division by the number of points that equation
//! 3.29 (mellowmin) has: that division lifts the bed by `ln(n / k) / w` into the part, where `k` points are about lowest,
//! and is worth 3 of 18.7 mm³ on the thesis's own part. So the bed here is `ln(k) / w` below the lowest point.

mod alexander;
mod bound;
mod field;
#[cfg(test)]
mod tests;

pub use alexander::Alexander;
pub use field::FIELD_FACETS;

use rayon::prelude::*;

use super::facets::{chunked, tangential};
use super::{Facets, Local, Objective, Proof};
use crate::geom::{Angle, Vec3};
use bound::Smooth;

/// How the smoothed objectives are smoothed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Smoothing {
    /// Surfaces up to this angle from the vertical need no support: the middle of the step in `-n.d`, `t_d = sin`.
    pub overhang: Angle,
    /// Surfaces must face up by more than this from the vertical to carry support: the middle of the step in `n.d`, `t_u`.
    pub carrying: Angle,
    /// Steepness of the steps, `1 / (1 + exp(-2 k (x - t)))`.
    pub k: f64,
    /// Weight of the lowest points, 1/mm.
    pub w: f64,
}

impl Smoothing {
    /// `1 / (1 + exp(-2 k (x - t)))` and its slope by `x`.
    fn step(&self, x: f64, t: f64) -> [f64; 2] {
        let h = 1.0 / (1.0 + (-2.0 * self.k * (x - t)).exp());
        [h, 2.0 * self.k * h * (1.0 - h)]
    }

    /// How much a facet with `n.d = x` hangs, 1 or 0 but for the smoothing, and its slope by `x`: the field D of Boogers' equation 4.5.
    pub fn hangs(&self, x: f64) -> [f64; 2] {
        let [h, slope] = self.step(-x, self.overhang.rad().sin());
        [h, -slope]
    }

    /// How much a facet with `n.d = x` carries supports, and its slope by `x`: the field U of Boogers' equation 4.6.
    pub fn carries(&self, x: f64) -> [f64; 2] {
        self.step(x, self.carrying.rad().sin())
    }

    /// The smoothed height of the lowest point along the unit direction `up`, mm, and its plain gradient; 0 for no points.
    pub fn bed(&self, facets: &Facets, up: &Vec3) -> (f64, Vec3) {
        let low = facets.lowest(up).dot(up);
        let (mut sum, mut pull) = (0.0, Vec3::zeros());
        for point in &facets.points {
            let share = (-self.w * (point.dot(up) - low)).exp();
            sum += share;
            pull += point * share;
        }
        if sum > 0.0 { (low - sum.ln() / self.w, pull / sum) } else { (0.0, Vec3::zeros()) }
    }
}

/// Which sum over the facets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cost {
    /// `sum M A^p h` with `A^p = -A n.d` and `h = b.d - z_min` (equation 3.24), mm³.
    Volume,
    /// `sum M A` (equation 4.8), mm².
    Interface,
    /// The volume without supports on the part, `M = D` (equation 3.24 with 3.27), mm³.
    Convex,
}

/// `support-volume`, `interface-area` and `support-volume-convex-smooth`.
///
/// `M_i = D_i + U_i / |C_i| sum_j v_ij D_j` (equation 4.2) over the facets `j` that `i` sees, `v_ij = d.(c_j - c_i) /
/// |c_j - c_i|`. The sets are worked out when first asked for, from about 0.05 F² pairs. From [`FIELD_FACETS`] facets on
/// they are not: there the area of facet `i` that carries support is taken from the part's columns along `d` instead,
/// which has no gradient and no bound. Closed meshes only; 0 for no facets.
#[derive(Clone, Copy, Debug)]
pub struct Supported {
    /// What is summed up.
    pub cost: Cost,
    /// The steps and the bed.
    pub smoothing: Smoothing,
    /// Width of the columns for large parts, mm.
    pub resolution_mm: f64,
}

/// What hangs and carries at a direction: for each facet `[D, D', U, U']`, by `n.d`.
type Masks = Vec<[f64; 4]>;

/// Less than this of a step is nothing: 1e-18 of an area.
const NOTHING: f64 = 1e-18;

impl Supported {
    fn masks(&self, facets: &Facets, up: &Vec3) -> Masks {
        let mask = |along: f64| {
            let ([d, by_d], [u, by_u]) = (self.smoothing.hangs(along), self.smoothing.carries(along));
            [d, by_d, u, by_u]
        };
        facets.each.iter().map(|f| mask(f.area.dot(up) / f.area.norm())).collect()
    }

    fn is_large(&self, facets: &Facets) -> bool {
        self.cost != Cost::Convex && facets.each.len() >= FIELD_FACETS
    }

    /// `1/|C_i| sum_j v_ij D_j` and its plain gradient; 0 for a facet that sees none.
    fn carried(&self, facets: &Facets, masks: &Masks, i: usize, up: &Vec3) -> (f64, Vec3) {
        let set = if self.cost == Cost::Convex { &[][..] } else { facets.sets().of_facet(i) };
        let (mut sum, mut slope) = (0.0, Vec3::zeros());
        for &j in set {
            let ([d, by_d, ..], other) = (masks[j as usize], &facets.each[j as usize]);
            if d > NOTHING {
                let unit = (other.barycentre - facets.each[i].barycentre).normalize();
                let v = unit.dot(up);
                sum += v * d;
                slope += unit * d + other.area * (v * by_d / other.area.norm());
            }
        }
        let count = set.len().max(1) as f64;
        (sum / count, slope / count)
    }

    /// `1/|C_i| sum_j v_ij D_j` for each facet that carries, 0 for the others: without gradients a tenth of the work.
    fn all_carried(&self, facets: &Facets, masks: &Masks, up: &Vec3) -> Vec<f64> {
        let heights: Vec<f64> = facets.each.iter().map(|f| f.barycentre.dot(up)).collect();
        let hanging: Vec<f64> = masks.iter().map(|mask| mask[0]).collect();
        let carried = |i: usize| {
            if self.cost == Cost::Convex || masks[i][2] <= NOTHING {
                return 0.0;
            }
            let set = facets.sets().with_inverse(i);
            let sum: f64 = set.map(|(j, inverse)| (heights[j] - heights[i]) * inverse * hanging[j]).sum();
            sum / facets.sets().of_facet(i).len().max(1) as f64
        };
        (0..facets.each.len()).into_par_iter().map(carried).collect()
    }

    /// The value and its plain gradient.
    fn both(&self, facets: &Facets, up: &Vec3) -> (f64, Vec3) {
        let masks = self.masks(facets, up);
        let (low, pull) = self.smoothing.bed(facets, up);
        let term = |i: usize| {
            let (facet, [d, by_d, u, by_u]) = (&facets.each[i], masks[i]);
            let n = facet.area / facet.area.norm();
            let (w, by_w) = if u > NOTHING { self.carried(facets, &masks, i, up) } else { (0.0, Vec3::zeros()) };
            let (m, by_m) = (d + u * w, n * (by_d + by_u * w) + by_w * u);
            if self.cost == Cost::Interface {
                let area = facet.area.norm();
                return Pair(m * area, by_m * area);
            }
            let (hangs, h) = (-facet.area.dot(up), facet.barycentre.dot(up) - low);
            let slope = by_m * (hangs * h) - facet.area * (m * h) + (facet.barycentre - pull) * (m * hangs);
            Pair(m * hangs * h, slope)
        };
        let sum: Pair = chunked(facets.each.len(), |range| range.map(term).sum());
        (sum.0, sum.1)
    }

    /// The summand of each facet: what Boogers (2024), figure 4.6 paints.
    pub(super) fn costs(&self, facets: &Facets, up: &Vec3) -> Vec<f64> {
        let masks = self.masks(facets, up);
        let low = self.smoothing.bed(facets, up).0;
        let is_large = self.is_large(facets);
        let carried =
            if is_large { field::carried(self, facets, &masks, up) } else { self.all_carried(facets, &masks, up) };
        let cost = |i: usize| {
            let (facet, [d, _, u, _]) = (&facets.each[i], masks[i]);
            let (size, along, h) = (facet.area.norm(), facet.area.dot(up), facet.barycentre.dot(up) - low);
            // What carries, of the facet's own area.
            let carries = carried[i] * if is_large { 1.0 / along.max(1e-3 * size) } else { u };
            (d + carries) * if self.cost == Cost::Interface { size } else { -along * h }
        };
        (0..facets.each.len()).map(cost).collect()
    }
}

/// A value with its gradient.
#[derive(Clone, Copy, Default)]
struct Pair(f64, Vec3);

impl std::iter::Sum for Pair {
    fn sum<I: Iterator<Item = Self>>(all: I) -> Self {
        all.fold(Self::default(), |sum, one| Self(sum.0 + one.0, sum.1 + one.1))
    }
}

impl Objective for Supported {
    fn name(&self) -> &str {
        match self.cost {
            Cost::Volume => "support-volume",
            Cost::Interface => "interface-area",
            Cost::Convex => "support-volume-convex-smooth",
        }
    }

    fn value(&self, facets: &Facets, up: &Vec3) -> f64 {
        self.costs(facets, up).iter().sum()
    }

    fn needs_closed(&self) -> bool {
        true
    }

    fn gradient(&self, facets: &Facets, up: &Vec3) -> Option<Vec3> {
        (!self.is_large(facets)).then(|| tangential(self.both(facets, up).1, up))
    }

    fn by_facet(&self, facets: &Facets, up: &Vec3) -> Option<Vec<f64>> {
        Some(self.costs(facets, up))
    }

    fn proof(&self) -> Proof {
        Proof::ROUGH
    }

    fn local<'a>(&'a self, facets: &'a Facets) -> Option<Box<dyn Local<'a> + 'a>> {
        if self.is_large(facets) { None } else { Some(Box::new(Smooth::of(self, facets))) }
    }

    fn unproved(&self, facets: &Facets) -> Option<String> {
        let (name, count) = (self.name(), facets.each.len());
        self.is_large(facets).then(|| {
            format!(
                "no lower bound is computed for {name} at {FIELD_FACETS} facets or more, and this part has {count}; support-volume-column has one"
            )
        })
    }
}
