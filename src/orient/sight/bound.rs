//! Bounds of the smoothed objectives, by intervals.

use rayon::prelude::*;

use super::super::{Cap, Facets, Local, Minorant};
use super::{Cost, Supported};
use crate::geom::Vec3;

/// On a cap `n.d`, `v_ij` and the heights lie in intervals, and `D`, `U` rise with their arguments; so each summand has a
/// least value, and the sum of these is a bound: of first order, so that it closes slowly. The bed lies `ln(points) / w`
/// below the lowest point at most, and not above it.
pub(super) struct Smooth<'a> {
    f: &'a Supported,
    facets: &'a Facets,
    least: f64,
}

impl<'a> Smooth<'a> {
    pub(super) fn of(f: &'a Supported, facets: &'a Facets) -> Self {
        Self { f, facets, least: f64::NEG_INFINITY }
    }

    /// The least and largest `x` of facet `i`.
    fn along(&self, cap: &Cap, i: usize) -> [f64; 2] {
        let area = self.facets.each[i].area;
        cap.range(&(area / area.norm()))
    }

    /// The least and largest of `1/|C_i| sum_j v_ij D_j`; `heights` are along the cap's centre.
    fn carried(&self, cap: &Cap, heights: &[f64], hanging: &[[f64; 2]], i: usize) -> [f64; 2] {
        if self.f.cost == Cost::Convex {
            return [0.0; 2];
        }
        let (sets, (sine, cosine)) = (self.facets.sets(), cap.radius.min(std::f64::consts::PI).sin_cos());
        let mut sum = [0.0; 2];
        for (j, inverse) in sets.with_inverse(i) {
            let [d0, d1] = hanging[j];
            if d1 < super::NOTHING {
                continue;
            }
            // A unit vector's component is the cosine of its angle, from which that strays by the cap's radius.
            let v = (heights[j] - heights[i]) * inverse;
            let across = (1.0 - v * v).max(0.0).sqrt() * sine;
            let v0 = if v >= -cosine { v * cosine - across - 1e-12 } else { -1.0 };
            let v1 = if v <= cosine { v * cosine + across + 1e-12 } else { 1.0 };
            sum[0] += (v0 * d0).min(v0 * d1);
            sum[1] += (v1 * d0).max(v1 * d1);
        }
        sum.map(|s| s / sets.of_facet(i).len().max(1) as f64)
    }

    fn least(&self, cap: &Cap) -> f64 {
        let smoothing = &self.f.smoothing;
        let count = self.facets.each.len();
        let along: Vec<[f64; 2]> = (0..count).map(|i| self.along(cap, i)).collect();
        let hanging: Vec<[f64; 2]> =
            along.iter().map(|[x0, x1]| [smoothing.hangs(*x1)[0], smoothing.hangs(*x0)[0]]).collect();
        let low = self.facets.lowest(&cap.centre);
        let below = (self.facets.points.len().max(1) as f64).ln() / smoothing.w;
        // `b.d - min v.d` exceeds its value at the centre by no more than twice the reach, turned by the cap.
        let across = 4.0 * self.facets.reach() * (0.5 * cap.radius.min(std::f64::consts::PI)).sin();
        let heights: Vec<f64> = self.facets.each.iter().map(|f| f.barycentre.dot(&cap.centre)).collect();
        let term = |i: usize| {
            let (facet, [x0, x1], [d0, d1]) = (&self.facets.each[i], along[i], hanging[i]);
            let area = facet.area.norm();
            let [u0, u1] = [x0, x1].map(|x| smoothing.carries(x)[0]);
            let [w0, w1] = if u1 > super::NOTHING { self.carried(cap, &heights, &hanging, i) } else { [0.0; 2] };
            let m0 = d0 + (u0 * w0).min(u1 * w0);
            let m1 = d1 + (u0 * w1).max(u1 * w1);
            if self.f.cost == Cost::Interface {
                return area * m0;
            }
            // Above the lowest point's tangent plane at least, and not more above it than above all points.
            let h0 = cap.range(&(facet.barycentre - low))[0].max(0.0);
            let h1 = heights[i] - low.dot(&cap.centre) + across + below;
            let [y0, y1] = [-x1, -x0];
            // The least of m y h over the box of the three.
            let my = [m0 * y0, m0 * y1, m1 * y0, m1 * y1].into_iter().fold(f64::INFINITY, f64::min);
            area * if my < 0.0 { my * h1 } else { my * h0 }
        };
        let terms: Vec<f64> = (0..count).into_par_iter().map(term).collect();
        let sum: f64 = terms.iter().sum();
        sum - 1e-12 * sum.abs()
    }
}

impl<'a> Local<'a> for Smooth<'a> {
    fn within(&self, cap: &Cap) -> Box<dyn Local<'a> + 'a> {
        Box::new(Self { f: self.f, facets: self.facets, least: self.least(cap).max(self.least) })
    }

    /// Not known without an evaluation: always worth one.
    fn estimate(&self) -> f64 {
        f64::NEG_INFINITY
    }

    fn minorant(&self, _: &Vec3) -> Minorant {
        Minorant { value: self.least, ..Minorant::ZERO }
    }

    fn floor(&self) -> f64 {
        f64::NEG_INFINITY
    }
}
