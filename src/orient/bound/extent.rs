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

/// `weighted-normal-z` is the largest of the cubic forms of [`Moments`](super::super::facets::Moments) over the hull's
/// points, and of their mixtures.
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
        let form = self.facets.sums().form(&self.facets.lowest(e));
        let once = form.once(&self.cap.centre);
        cubic(&once, form.norm(), &self.cap)
    }
}

/// The minorant of a symmetric cubic form of the given size, of which `once` is `S(c, ., .)` at the centre.
pub(super) fn cubic(once: &Mat3, size: f64, cap: &Cap) -> Minorant {
    let c = &cap.centre;
    let at = once * c;
    let value = at.dot(c);
    let here = 3.0 * value - 6.0 * least_across(once, c);
    let curve = (9.0 * size).min(here + 27.0 * size * cap.radius);
    Minorant { value, slope: tangential(at * 3.0, c), curve }
}

/// The minorant of `d'Bd` on a cap, for any square `B`.
pub(crate) fn quadratic(b: &Mat3, cap: &Cap) -> Minorant {
    let c = &cap.centre;
    let symmetric = (b + b.transpose()) * 0.5;
    let at = symmetric * c;
    let value = at.dot(c);
    // Two eigenvalues differ by this at most, since their distances from the mean of all have no more squares than it.
    let mean = symmetric.trace() / 3.0;
    let spread = std::f64::consts::SQRT_2 * (symmetric - Mat3::identity() * mean).norm();
    let here = 2.0 * (value - least_across(&symmetric, c));
    Minorant { value, slope: tangential(at * 2.0, c), curve: (2.0 * spread).min(here + 4.0 * spread * cap.radius) }
}

/// The least `t'Mt` of a symmetric `M` over unit `t` at right angles to `c`.
fn least_across(m: &Mat3, c: &Vec3) -> f64 {
    let [e1, e2] = tangents(c);
    let (m1, m2) = (m * e1, m * e2);
    let (a, b, d) = (m1.dot(&e1), m1.dot(&e2), m2.dot(&e2));
    0.5 * (a + d) - (0.5 * (a - d)).hypot(b)
}

/// `normal-z` is the quadratic form of `N = sum n n'`, minus it that of `-N`: nowhere below its smallest eigenvalue, and there
/// at its eigenvector. For sums with others its own minorant on the cap is better than that.
#[derive(Clone)]
pub(crate) struct Quadratic {
    form: Mat3,
    least: f64,
    at: Vec3,
    cap: Cap,
}

impl Quadratic {
    pub(crate) fn of(form: &Mat3) -> Self {
        let solved = form.symmetric_eigen();
        let i = solved.eigenvalues.imin();
        let least = solved.eigenvalues[i] - super::ROUNDING * form.trace().abs();
        // A sum of squares is not negative.
        let least = if form.trace() > 0.0 { least.max(0.0) } else { least };
        Self { form: *form, least, at: solved.eigenvectors.column(i).into_owned(), cap: Cap::WHOLE }
    }
}

impl<'a> Local<'a> for Quadratic {
    fn within(&self, cap: &Cap) -> Box<dyn Local<'a> + 'a> {
        Box::new(Self { cap: *cap, ..self.clone() })
    }

    fn estimate(&self) -> f64 {
        (self.form * self.cap.centre).dot(&self.cap.centre)
    }

    fn minorant(&self, _: &Vec3) -> Minorant {
        quadratic(&self.form, &self.cap)
    }

    fn floor(&self) -> f64 {
        self.least
    }

    fn hint(&self) -> Option<Vec3> {
        Some(self.at)
    }
}
