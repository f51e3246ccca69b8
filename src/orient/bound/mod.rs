//! Lower bounds of objectives over a cap of the sphere, that hold.
//!
//! All of them come from minorants: smooth functions `g <= f` on the cap of which the value and slope at its centre and
//! a bound of the curvature are known. Along a great circle from the centre, Taylor's theorem gives `g(t) >= g(0) -
//! |g'(0)| t - curve t^2 / 2`. A convex mixture of minorants is a minorant, and at a kink the right mixture has no slope:
//! that makes the bounds of second order beside kinks as well. A weighted sum of minorants is one of the weighted sum;
//! for a negative weight it takes a minorant of minus the objective (`negated`, `negated_heights`).
//!
//! What a cap has settled (a facet's side, say) is settled on all caps inside it: a [`Local`] hands the rest down, so
//! that small caps cost little.

mod angle;
mod contact;
mod extent;
mod negated;
mod negated_heights;
mod tanh;
mod volume;
mod zonotope;

pub(super) use angle::Leaning;
pub(super) use contact::Lying;
pub(super) use extent::{Extent, Heights, Quadratic, quadratic};
pub(super) use negated::{MinusLeaning, MinusShadow, SomeArea};
pub(super) use negated_heights::{MinusColumns, MinusHeight, MinusHeights};
pub(super) use tanh::HangingTerm;
pub(super) use volume::Columns;
pub(super) use zonotope::Shadow;

use super::sphere::tangents;
use crate::geom::Vec3;

/// All directions within `radius` (radians) of `centre`; from pi on the whole sphere.
#[derive(Clone, Copy, Debug)]
pub struct Cap {
    /// Unit.
    pub centre: Vec3,
    /// Radians.
    pub radius: f64,
}

impl Cap {
    /// The whole sphere.
    pub const WHOLE: Self = Self { centre: Vec3::new(0.0, 0.0, 1.0), radius: std::f64::consts::PI };

    /// The sine of the radius, 1 from a right angle on: how far `v.d` strays for a unit `v` at right angles to the centre.
    pub(super) fn sine(&self) -> f64 {
        if self.radius < std::f64::consts::FRAC_PI_2 { self.radius.sin() } else { 1.0 }
    }

    /// The least and largest `v.d` on the cap.
    pub(super) fn range(&self, v: &Vec3) -> [f64; 2] {
        let along = v.dot(&self.centre);
        let across = (v - self.centre * along).norm();
        let angle = across.atan2(along);
        let length = along.hypot(across);
        let end = |a: f64| length * a.clamp(0.0, std::f64::consts::PI).cos();
        [end(angle + self.radius), end(angle - self.radius)]
    }
}

/// What is known of an objective on a cap, for bounds there and on the caps inside.
pub trait Local<'a>: Send + Sync {
    /// The same for a cap inside this one.
    fn within(&self, cap: &Cap) -> Box<dyn Local<'a> + 'a>;

    /// A function nowhere above the objective on the cap, chosen to be near it at `e`.
    fn minorant(&self, e: &Vec3) -> Minorant;

    /// The minorants near each of `places`; some may be left out.
    fn minorants(&self, places: &[Vec3]) -> Vec<Minorant> {
        places.iter().map(|e| self.minorant(e)).collect()
    }

    /// The objective at the centre but for rounding, or less: where that beats the best known, it is worth an evaluation.
    fn estimate(&self) -> f64;

    /// Nothing is below this, whatever the minorants say.
    fn floor(&self) -> f64 {
        0.0
    }

    /// A direction worth an evaluation, where a search would not find it.
    fn hint(&self) -> Option<Vec3> {
        None
    }
}

/// Taken off each bound for rounding, relative to the sums it comes from.
const ROUNDING: f64 = 1e-12;

/// A smooth function on a cap: its value and slope at the centre, and how fast the slope may fall.
#[derive(Clone, Copy, Debug)]
pub struct Minorant {
    /// At the cap's centre.
    pub value: f64,
    /// At right angles to the centre, per radian.
    pub slope: Vec3,
    /// The second derivative along any great circle through the centre is nowhere on the cap below minus this.
    pub curve: f64,
}

impl Minorant {
    /// 0 everywhere.
    pub const ZERO: Self = Self { value: 0.0, slope: Vec3::new(0.0, 0.0, 0.0), curve: 0.0 };

    /// Of `p.d`, whose second derivative along a great circle is `-p.d`.
    pub(super) fn linear(p: Vec3, cap: &Cap) -> Self {
        let value = p.dot(&cap.centre);
        let slope = p - cap.centre * value;
        let most = if value > 0.0 { value } else { value * cap.radius.min(std::f64::consts::FRAC_PI_2).cos() };
        Self { value, slope, curve: most + slope.norm() * cap.sine() }
    }

    fn mixed(&self, other: &Self, share: f64) -> Self {
        let mix = |a: f64, b: f64| a + (b - a) * share;
        let slope = self.slope + (other.slope - self.slope) * share;
        Self { value: mix(self.value, other.value), slope, curve: mix(self.curve, other.curve) }
    }

    /// `weight` times this, added to `sum`; the weight is not negative.
    pub(super) fn added(&self, weight: f64, sum: &Self) -> Self {
        let value = sum.value + self.value * weight;
        Self { value, slope: sum.slope + self.slope * weight, curve: sum.curve + self.curve * weight }
    }

    /// The least value on the cap.
    fn least(&self, r: f64) -> f64 {
        let slope = self.slope.norm();
        // Convex with its bottom inside the cap: that bottom.
        let t = if -self.curve * r > slope { slope / -self.curve } else { r };
        self.value - (slope + 0.5 * self.curve * t) * t
    }
}

/// The best bound by a mixture of `all`: each is mixed in by the share that is best, several times over.
///
/// Any mixture is valid, so that stopping early costs tightness only.
fn best(all: &[Minorant], r: f64) -> f64 {
    let start = all.iter().copied().max_by(|a, b| a.least(r).total_cmp(&b.least(r)));
    let Some(mut mixture) = start else { return 0.0 };
    for _ in 0..ROUNDS {
        let before = mixture.least(r);
        for other in all {
            if (other.slope - mixture.slope).norm_squared() > 1e-18 * mixture.slope.norm_squared() {
                mixture = improved(mixture, other, r);
            }
        }
        if mixture.least(r) - before <= 1e-3 * (before - mixture.value).abs() {
            break;
        }
    }
    mixture.least(r) - ROUNDING * mixture.value.abs()
}

/// `mixture` with the share of `other` that is best, by golden section.
fn improved(mixture: Minorant, other: &Minorant, r: f64) -> Minorant {
    let at = |share: f64| mixture.mixed(other, share).least(r);
    let (mut low, mut high) = (0.0, 1.0);
    let (mut a, mut b) = (1.0 - GOLDEN, GOLDEN);
    let (mut at_a, mut at_b) = (at(a), at(b));
    for _ in 0..SECTIONS {
        if at_a < at_b {
            (low, a, at_a) = (a, b, at_b);
            b = low + GOLDEN * (high - low);
            at_b = at(b);
        } else {
            (high, b, at_b) = (b, a, at_a);
            a = high - GOLDEN * (high - low);
            at_a = at(a);
        }
    }
    let tried = mixture.mixed(other, 0.5 * (low + high));
    if tried.least(r) > mixture.least(r) { tried } else { mixture }
}

const ROUNDS: usize = 6;
const SECTIONS: usize = 14;
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// Six directions on the cap's rim, where minorants are taken beside the centre.
fn rim(cap: &Cap) -> impl Iterator<Item = Vec3> + use<> {
    let (c, [e1, e2], (s, k)) = (cap.centre, tangents(&cap.centre), cap.radius.sin_cos());
    (0..6).map(move |i| {
        let (sa, ca) = (f64::from(i) * std::f64::consts::FRAC_PI_3).sin_cos();
        c * k + (e1 * ca + e2 * sa) * s
    })
}

/// A lower bound over `cap` of what `local` knows there, in the objective's unit: no direction of the cap is below it.
///
/// With the centre's minorant alone where that gives more than `enough`, or where the centre itself is below `enough`.
pub fn lower(local: &dyn Local<'_>, cap: &Cap, enough: f64) -> f64 {
    let centre = local.minorant(&cap.centre);
    let floor = local.floor();
    let alone = best(&[centre], cap.radius).max(floor);
    if alone > enough || centre.value < enough {
        return alone;
    }
    let mut all = vec![centre];
    for one in local.minorants(&rim(cap).collect::<Vec<_>>()) {
        if all.iter().all(|known| known.slope != one.slope) {
            all.push(one);
        }
    }
    best(&all, cap.radius).max(floor)
}
