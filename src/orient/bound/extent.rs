//! Objectives that a few numbers and the extreme points say all of: `height`, `weighted-normal-z`, `normal-z`.

use super::super::Facets;
use super::super::facets::tangential;
use super::super::sphere::tangents;
use super::{Cap, Local, Minorant};
use crate::geom::{Mat3, Vec3};

/// `max v.d - min v.d` is the largest of `(v - w).d` over pairs of points.
#[derive(Clone)]
pub(crate) struct Extent<'a> {
    pub(crate) facets: &'a Facets,
    pub(crate) cap: Cap,
}

impl<'a> Local<'a> for Extent<'a> {
    fn within(&self, cap: &Cap) -> Box<dyn Local<'a> + 'a> {
        Box::new(Self { cap: *cap, ..*self })
    }

    fn estimate(&self) -> f64 {
        self.minorant(&self.cap.centre).value
    }

    fn minorant(&self, e: &Vec3) -> Minorant {
        Minorant::linear(self.facets.lowest(&-e) - self.facets.lowest(e), &self.cap)
    }
}

/// `weighted-normal-z` is the largest of the cubic forms of [`Moments`](super::super::moments::Moments) over the hull's
/// points (METHODS section 2), and of their mixtures.
///
/// For such a form `S(d, d, d)'' = 6 S(d, d', d') - 3 S(d, d, d) >= -9 |S|`; its own derivative is
/// `6 S(d', d', d') - 21 S(d, d, d') >= -27 |S|`, which bounds it from its least value at the centre.
#[derive(Clone)]
pub(crate) struct Heights<'a> {
    pub(crate) facets: &'a Facets,
    pub(crate) cap: Cap,
}

impl<'a> Local<'a> for Heights<'a> {
    fn within(&self, cap: &Cap) -> Box<dyn Local<'a> + 'a> {
        Box::new(Self { cap: *cap, ..*self })
    }

    fn estimate(&self) -> f64 {
        self.minorant(&self.cap.centre).value
    }

    fn minorant(&self, e: &Vec3) -> Minorant {
        let c = &self.cap.centre;
        let form = self.facets.sums().form(&self.facets.lowest(e));
        let once = form.once(c);
        let (at, size) = (once * c, form.norm());
        let value = at.dot(c);
        let here = 3.0 * value - 6.0 * least_across(&once, c);
        let curve = (9.0 * size).min(here + 27.0 * size * self.cap.radius);
        Minorant { value, slope: tangential(at * 3.0, c), curve }
    }
}

/// The least `t'Mt` of a symmetric `M` over unit `t` at right angles to `c`.
pub(super) fn least_across(m: &Mat3, c: &Vec3) -> f64 {
    let [e1, e2] = tangents(c);
    let (m1, m2) = (m * e1, m * e2);
    let (a, b, d) = (m1.dot(&e1), m1.dot(&e2), m2.dot(&e2));
    0.5 * (a + d) - (0.5 * (a - d)).hypot(b)
}

/// `normal-z` is the quadratic form of `N = sum n n'`: nowhere below its smallest eigenvalue, and there at its eigenvector.
#[derive(Clone)]
pub(crate) struct Quadratic {
    least: f64,
    at: Vec3,
}

impl Quadratic {
    pub(crate) fn of(form: &Mat3) -> Self {
        let solved = form.symmetric_eigen();
        let i = solved.eigenvalues.imin();
        let least = (solved.eigenvalues[i] - super::ROUNDING * form.trace()).max(0.0);
        Self { least, at: solved.eigenvectors.column(i).into_owned() }
    }
}

impl<'a> Local<'a> for Quadratic {
    fn within(&self, _: &Cap) -> Box<dyn Local<'a> + 'a> {
        Box::new(self.clone())
    }

    fn estimate(&self) -> f64 {
        self.least
    }

    fn minorant(&self, _: &Vec3) -> Minorant {
        Minorant { value: self.least, ..Minorant::ZERO }
    }

    fn hint(&self) -> Option<Vec3> {
        Some(self.at)
    }
}
