//! The sums over all facets of which `weighted-normal-z` is made (METHODS section 2; seed 000, equation 3.2.4).

use super::Facets;
use crate::geom::{Mat3, Vec3};

/// `f(d) = T(d, d, d) - m(d) d'Qd`, lengths counted from `centre` so that a part far from the origin loses no digits.
#[derive(Clone, Debug)]
pub(super) struct Moments {
    /// The middle of the corner points' box, mm.
    pub(super) centre: Vec3,
    /// `sum A b_i n_j n_k` made symmetric, as the three matrices of its first index, mm³.
    pub(super) cubic: [Mat3; 3],
    /// `Q = sum A n n'`, mm²; positive semidefinite.
    pub(super) square: Mat3,
}

impl Moments {
    pub(super) fn of(facets: &Facets) -> Self {
        let bounds = crate::geom::Bounds::of(facets.points.iter().copied());
        let centre = if bounds.is_empty() { Vec3::zeros() } else { bounds.centre() };
        let (mut plain, mut square) = ([Mat3::zeros(); 3], Mat3::zeros());
        for ((n, &area), moment) in facets.normals.iter().zip(&facets.areas).zip(&facets.moments) {
            let outer = n * n.transpose();
            let arm = moment - centre * area;
            square += outer * area;
            (0..3).for_each(|i| plain[i] += outer * arm[i]);
        }
        Self { centre, cubic: symmetric(&plain), square }
    }

    /// The cubic form of `T - p (x) Q`, symmetric: below `f` everywhere for every `p` of the convex hull, and equal to
    /// it where `p` is the lowest point.
    pub(super) fn form(&self, point: &Vec3) -> Cubic {
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
pub(super) struct Cubic([Mat3; 3]);

impl Cubic {
    /// `S(d, d, .)`; the value is this along `d`, the plain gradient three times this.
    pub(super) fn at(&self, d: &Vec3) -> Vec3 {
        Vec3::new((self.0[0] * d).dot(d), (self.0[1] * d).dot(d), (self.0[2] * d).dot(d))
    }

    /// The root of the sum of squares of its entries: no value on unit vectors is larger.
    pub(super) fn norm(&self) -> f64 {
        self.0.iter().map(Mat3::norm_squared).sum::<f64>().sqrt()
    }
}
