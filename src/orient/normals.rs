//! The objectives of seed 000 that know the facets' normals alone: an open mesh will do.

use super::facets::tangential;
use super::{Bound, Cap, Facets, Objective, bound};
use crate::geom::{Angle, Vec3};

/// `sum max(|acos(n.d) - pi/2| - theta, 0)` over the facets, each counted once whatever its area (seed 000, equation
/// 3.1.2), radians; 0 for a mesh of walls.
#[derive(Clone, Copy, Debug)]
pub struct OverhangAngle {
    /// Facets up to this angle from the vertical cost nothing.
    pub theta: Angle,
}

/// Nearer to 1 than this, `acos` has no slope that means anything: the tip of a cone, 1.4e-6 degrees wide.
const TIP: f64 = 1.0 - 3e-16;

impl Objective for OverhangAngle {
    fn name(&self) -> &str {
        "overhang-angle"
    }

    fn value(&self, facets: &Facets, up: &Vec3) -> f64 {
        let theta = self.theta.rad();
        let lean = |n: &Vec3| (n.dot(up).abs().min(1.0).asin() - theta).max(0.0);
        facets.normals.iter().zip(&facets.counts).map(|(n, count)| count * lean(n)).sum()
    }

    fn gradient(&self, facets: &Facets, up: &Vec3) -> Option<Vec3> {
        let from = self.theta.rad().sin();
        let mut sum = Vec3::zeros();
        for (n, count) in facets.normals.iter().zip(&facets.counts) {
            let along = n.dot(up);
            if along.abs() > from && along.abs() < TIP {
                sum += n * (count * along.signum() / (1.0 - along * along).sqrt());
            }
        }
        Some(tangential(sum, up))
    }

    fn bound(&self, facets: &Facets, cap: &Cap, enough: f64) -> Option<Bound> {
        Some(bound::overhang_angle(self, facets, cap, enough))
    }
}

/// `sum (n.d)^2` over the facets, each counted once (seed 000, equation 3.2.2), no unit.
///
/// The quadratic form of `N = sum n n'`: its minimum is the smallest eigenvalue, its minima that eigenvector's senses.
#[derive(Clone, Copy, Debug)]
pub struct NormalZ;

impl Objective for NormalZ {
    fn name(&self) -> &str {
        "normal-z"
    }

    fn value(&self, facets: &Facets, up: &Vec3) -> f64 {
        facets.normals.iter().zip(&facets.counts).map(|(n, count)| count * n.dot(up).powi(2)).sum()
    }

    fn gradient(&self, facets: &Facets, up: &Vec3) -> Option<Vec3> {
        let mut sum = Vec3::zeros();
        for (n, count) in facets.normals.iter().zip(&facets.counts) {
            sum += n * (2.0 * count * n.dot(up));
        }
        Some(tangential(sum, up))
    }

    fn bound(&self, facets: &Facets, _: &Cap, _: f64) -> Option<Bound> {
        Some(bound::normal_z(self, facets))
    }
}
