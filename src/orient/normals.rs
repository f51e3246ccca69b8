//! The objectives of de Castro (2020) that know the facets' normals alone: an open mesh will do.

use super::facets::tangential;
use super::{Facets, Local, Objective, bound};
use crate::geom::{Angle, Mat3, Vec3};

/// `sum max(|acos(n.d) - pi/2| - theta, 0)` over the facets, each counted once whatever its area (de Castro (2020), equation
/// 3.1.2), radians; 0 for a mesh of walls.
#[derive(Clone, Copy, Debug)]
pub struct OverhangAngle {
    /// Facets up to this angle from the vertical cost nothing.
    pub theta: Angle,
}

/// From this `|n.d|` on the angle is taken from the sine: `acos` would turn an error of 1e-16 into one of 1e-8.
const STEEP: f64 = 0.9;

/// Nearer to 1 than this, `acos` has no slope that means anything: the tip of a cone, 1.4e-6 degrees wide.
const TIP: f64 = 1.0 - 3e-16;

impl Objective for OverhangAngle {
    fn name(&self) -> &str {
        "overhang-angle"
    }

    fn value(&self, facets: &Facets, up: &Vec3) -> f64 {
        let theta = self.theta.rad();
        let (normals, from) = (facets.normals(), theta.sin());
        normals.sum(|n, _, i| {
            let along = n.dot(up).abs();
            if along <= from {
                return 0.0;
            }
            let steep = || std::f64::consts::FRAC_PI_2 - n.cross(up).norm().min(1.0).asin();
            let lean = if along > STEEP { steep() } else { along.asin() };
            normals.counts[i] * (lean - theta).max(0.0)
        })
    }

    fn gradient(&self, facets: &Facets, up: &Vec3) -> Option<Vec3> {
        let from = self.theta.rad().sin();
        let normals = facets.normals();
        let sum: Vec3 = normals.sum(|n, _, i| {
            let along = n.dot(up);
            let leans = along.abs() > from && along.abs() < TIP;
            n * if leans { normals.counts[i] * along.signum() / (1.0 - along * along).sqrt() } else { 0.0 }
        });
        Some(tangential(sum, up))
    }

    fn local<'a>(&'a self, facets: &'a Facets) -> Option<Box<dyn Local<'a> + 'a>> {
        Some(Box::new(bound::Leaning::of(facets, self.theta)))
    }

    fn negated<'a>(&'a self, facets: &'a Facets) -> Option<Box<dyn Local<'a> + 'a>> {
        Some(Box::new(bound::MinusLeaning::of(facets, self.theta)))
    }
}

/// `sum (n.d)^2` over the facets, each counted once (de Castro (2020), equation 3.2.2), no unit.
///
/// The quadratic form of `N = sum n n'`: its minimum is the smallest eigenvalue, its minima that eigenvector's senses.
#[derive(Clone, Copy, Debug)]
pub struct NormalZ;

impl Objective for NormalZ {
    fn name(&self) -> &str {
        "normal-z"
    }

    fn value(&self, facets: &Facets, up: &Vec3) -> f64 {
        let normals = facets.normals();
        normals.sum(|n, _, i| normals.counts[i] * n.dot(up).powi(2))
    }

    fn gradient(&self, facets: &Facets, up: &Vec3) -> Option<Vec3> {
        let normals = facets.normals();
        let sum: Vec3 = normals.sum(|n, _, i| n * (2.0 * normals.counts[i] * n.dot(up)));
        Some(tangential(sum, up))
    }

    fn local<'a>(&'a self, facets: &'a Facets) -> Option<Box<dyn Local<'a> + 'a>> {
        Some(Box::new(bound::Quadratic::of(&form(facets))))
    }

    fn negated<'a>(&'a self, facets: &'a Facets) -> Option<Box<dyn Local<'a> + 'a>> {
        Some(Box::new(bound::Quadratic::of(&-form(facets))))
    }
}

/// `sum n n'`.
fn form(facets: &Facets) -> Mat3 {
    let normals = facets.normals();
    normals.sum(|n, _, i| n * n.transpose() * normals.counts[i])
}
