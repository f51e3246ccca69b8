//! The sums over all facets of which `weighted-normal-z` is made (de Castro (2020), equation 3.2.4).

use super::Facets;
use crate::geom::{Mat3, Vec3};

/// `f(d) = T(d, d, d) - m(d) d'Qd`, lengths counted from `centre` so that a part far from the origin loses no digits.
#[derive(Clone, Debug)]
pub(in crate::orient) struct Moments {
    /// The middle of the corner points' box, mm.
    pub(in crate::orient) centre: Vec3,
    /// `sum A b_i n_j n_k` made symmetric, as the three matrices of its first index, mm³.
    pub(in crate::orient) cubic: [Mat3; 3],
    /// `Q = sum A n n'`, mm²; positive semidefinite.
    pub(in crate::orient) square: Mat3,
}

/// The sums before they are made symmetric: `Q`, and `Q` weighted by each coordinate of the barycentre, each as the six
/// entries xx, xy, xz, yy, yz, zz.
#[derive(Clone, Copy, Default)]
struct Plain([[f64; 6]; 4]);

impl std::iter::Sum for Plain {
    fn sum<I: Iterator<Item = Self>>(all: I) -> Self {
        all.fold(Self::default(), |mut sum, one| {
            sum.0.iter_mut().flatten().zip(one.0.iter().flatten()).for_each(|(a, b)| *a += b);
            sum
        })
    }
}

impl Moments {
    pub(in crate::orient) fn of(facets: &Facets) -> Self {
        let centre = facets.middle();
        let plain: Plain = facets.sum(|facet| {
            let (a, arm) = (facet.area, facet.barycentre - centre);
            let n = a / a.norm();
            // `area` is A n already: one factor of n carries the area.
            let outer = [a.x * n.x, a.x * n.y, a.x * n.z, a.y * n.y, a.y * n.z, a.z * n.z];
            Plain([outer, outer.map(|o| o * arm.x), outer.map(|o| o * arm.y), outer.map(|o| o * arm.z)])
        });
        let full = |[xx, xy, xz, yy, yz, zz]: [f64; 6]| Mat3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
        let [square, x, y, z] = plain.0.map(full);
        Self { centre, cubic: symmetric(&[x, y, z]), square }
    }

    /// `f` at `d`, of which `lowest` is the lowest point.
    pub(in crate::orient) fn value(&self, lowest: &Vec3, d: &Vec3) -> f64 {
        let once = self.cubic[0] * d.x + self.cubic[1] * d.y + self.cubic[2] * d.z;
        (once * d).dot(d) - (lowest - self.centre).dot(d) * (self.square * d).dot(d)
    }

    /// The cubic form of `T - p (x) Q`, symmetric: below `f` everywhere for every `p` of the convex hull, and equal to
    /// it where `p` is the lowest point.
    pub(in crate::orient) fn form(&self, point: &Vec3) -> Cubic {
        let p = point - self.centre;
        let mut pull = [Mat3::zeros(); 3];
        (0..3).for_each(|i| pull[i] = self.square * p[i]);
        let pull = symmetric(&pull);
        Cubic([0, 1, 2].map(|i| self.cubic[i] - pull[i]))
    }
}

fn symmetric(plain: &[Mat3; 3]) -> [Mat3; 3] {
    [0, 1, 2].map(|i| Mat3::from_fn(|j, k| (plain[i][(j, k)] + plain[j][(i, k)] + plain[k][(i, j)]) / 3.0))
}

/// A symmetric cubic form on directions.
#[derive(Clone, Debug)]
pub(in crate::orient) struct Cubic([Mat3; 3]);

impl Cubic {
    /// `S(d, ., .)`, a symmetric matrix.
    pub(in crate::orient) fn once(&self, d: &Vec3) -> Mat3 {
        self.0[0] * d.x + self.0[1] * d.y + self.0[2] * d.z
    }

    /// `S(d, d, .)`; the value is this along `d`, the plain gradient three times this.
    pub(in crate::orient) fn at(&self, d: &Vec3) -> Vec3 {
        self.once(d) * d
    }

    /// The root of the sum of squares of its entries: no value on unit vectors is larger.
    pub(in crate::orient) fn norm(&self) -> f64 {
        self.0.iter().map(Mat3::norm_squared).sum::<f64>().sqrt()
    }
}
