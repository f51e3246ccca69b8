//! Bounds of the smoothed objectives, by intervals.

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

    /// The least and largest of `1/|C_i| sum_j v_ij D_j`.
    fn carried(&self, cap: &Cap, hanging: &[[f64; 2]], i: usize) -> [f64; 2] {
        let set = if self.f.cost == Cost::Convex { &[][..] } else { self.facets.sets().of_facet(i) };
        let sum = set.iter().fold([0.0; 2], |sum, &j| {
            let [d0, d1] = hanging[j as usize];
            if d1 < super::NOTHING {
                return sum;
            }
            let between = self.facets.each[j as usize].barycentre - self.facets.each[i].barycentre;
            let [v0, v1] = cap.range(&between.normalize());
            [sum[0] + (v0 * d0).min(v0 * d1), sum[1] + (v1 * d0).max(v1 * d1)]
        });
        sum.map(|s| s / set.len().max(1) as f64)
    }

    fn least(&self, cap: &Cap) -> f64 {
        let smoothing = &self.f.smoothing;
        let count = self.facets.each.len();
        let along: Vec<[f64; 2]> = (0..count).map(|i| self.along(cap, i)).collect();
        let hanging: Vec<[f64; 2]> =
            along.iter().map(|[x0, x1]| [smoothing.hangs(*x1)[0], smoothing.hangs(*x0)[0]]).collect();
        let low = self.facets.lowest(&cap.centre);
        let below = (self.facets.points.len().max(1) as f64).ln() / smoothing.w;
        let mut sum = 0.0;
        for (i, facet) in self.facets.each.iter().enumerate() {
            let ([x0, x1], [d0, d1]) = (along[i], hanging[i]);
            let area = facet.area.norm();
            let [u0, u1] = [x0, x1].map(|x| smoothing.carries(x)[0]);
            let [w0, w1] = if u1 > super::NOTHING { self.carried(cap, &hanging, i) } else { [0.0; 2] };
            let m0 = d0 + (u0 * w0).min(u1 * w0);
            let m1 = d1 + (u0 * w1).max(u1 * w1);
            if self.f.cost == Cost::Interface {
                sum += area * m0;
                continue;
            }
            // Above the lowest point's tangent plane at least, and not more above it than above all points.
            let h0 = cap.range(&(facet.barycentre - low))[0].max(0.0);
            let h1 = self.highest(cap, &facet.barycentre) + below;
            let [y0, y1] = [-x1, -x0];
            // The least of m y h over the box of the three.
            let my = [m0 * y0, m0 * y1, m1 * y0, m1 * y1].into_iter().fold(f64::INFINITY, f64::min);
            sum += area * if my < 0.0 { my * h1 } else { my * h0 };
        }
        sum - 1e-12 * sum.abs()
    }

    /// `b.d - min v.d` at most on the cap: what it is at the centre, and the part's reach across.
    fn highest(&self, cap: &Cap, b: &Vec3) -> f64 {
        let low = self.facets.lowest(&cap.centre);
        let reach = self.facets.reach();
        (b - low).dot(&cap.centre) + 2.0 * reach * 2.0 * (0.5 * cap.radius.min(std::f64::consts::PI)).sin()
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
