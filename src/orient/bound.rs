//! Lower bounds of objectives over a cap of the sphere, that hold.
//!
//! All of them come from minorants: smooth functions `g <= f` on the cap of which the value and slope at its centre and
//! a bound of the curvature are known. Along a great circle from the centre, Taylor's theorem gives `g(t) >= g(0) -
//! |g'(0)| t - curve t^2 / 2`. A convex mixture of minorants is a minorant, and at a kink the right mixture has no slope:
//! that makes the bounds of second order beside kinks as well.

use super::facets::tangential;
use super::objective::FLAT;
use super::sphere::tangents;
use super::{Facets, Height, NormalZ, Objective, OverhangAngle, Staircase, SupportArea, WeightedNormalZ};
use crate::geom::{Mat3, Vec3};

/// All directions within `radius` (radians, below pi/2) of `centre`.
#[derive(Clone, Copy, Debug)]
pub struct Cap {
    /// Unit.
    pub centre: Vec3,
    /// Radians.
    pub radius: f64,
}

/// What is known of an objective on a cap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bound {
    /// No direction of the cap has a lower value.
    pub value: f64,
    /// A direction worth an evaluation, where a search would not find it.
    pub hint: Option<Vec3>,
}

/// Taken off each bound for rounding, relative to the sums it comes from.
const ROUNDING: f64 = 1e-12;

#[derive(Clone, Copy, Debug)]
struct Minorant {
    value: f64,
    slope: Vec3,
    curve: f64,
}

impl Minorant {
    /// Of `p.d`: its second derivative along a great circle is `-p.d`, at least `-(p.c + |slope| r)` on the cap.
    fn linear(p: Vec3, cap: &Cap) -> Self {
        let slope = tangential(p, &cap.centre);
        let value = p.dot(&cap.centre);
        Self { value, slope, curve: value.max(0.0) + slope.norm() * cap.radius }
    }

    fn mixed(&self, other: &Self, share: f64) -> Self {
        let mix = |a: f64, b: f64| a + (b - a) * share;
        let slope = self.slope + (other.slope - self.slope) * share;
        Self { value: mix(self.value, other.value), slope, curve: mix(self.curve, other.curve) }
    }

    fn least(&self, r: f64) -> f64 {
        self.value - self.slope.norm() * r - self.curve * r * r / 2.0
    }
}

/// The best bound by a mixture of `all`: each is mixed in by the share that is best, several times over.
///
/// Any mixture is valid, so that stopping early costs tightness only. 0 for none.
fn best(all: &[Minorant], r: f64) -> f64 {
    let start = all.iter().copied().max_by(|a, b| a.least(r).total_cmp(&b.least(r)));
    let Some(mut mixture) = start else { return 0.0 };
    let distinct = all.iter().any(|m| (m.slope - mixture.slope).norm() > 1e-9 * mixture.slope.norm());
    for _ in 0..if distinct { ROUNDS } else { 0 } {
        for other in all {
            let (mut low, mut high) = (0.0, 1.0);
            for _ in 0..TERNARY {
                let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
                if mixture.mixed(other, a).least(r) < mixture.mixed(other, b).least(r) { low = a } else { high = b }
            }
            let tried = mixture.mixed(other, 0.5 * (low + high));
            if tried.least(r) > mixture.least(r) {
                mixture = tried;
            }
        }
    }
    mixture.least(r) - ROUNDING * mixture.value.abs()
}

const ROUNDS: usize = 6;
const TERNARY: usize = 24;

/// The centre and six directions on the rim, where the minorants are taken.
fn places(cap: &Cap) -> impl Iterator<Item = Vec3> + use<> {
    let (c, [e1, e2], (s, k)) = (cap.centre, tangents(&cap.centre), cap.radius.sin_cos());
    let rim = move |i: i32| {
        let (sa, ca) = (f64::from(i) * std::f64::consts::FRAC_PI_3).sin_cos();
        c * k + (e1 * ca + e2 * sa) * s
    };
    std::iter::once(c).chain((0..6).map(rim))
}

/// Of an objective that is the largest of `form(e)` over some set, `form(e)` being the one that is largest at `e`: at the
/// centre alone where that gives more than `enough`. None of these objectives is below 0.
fn largest_of(cap: &Cap, enough: f64, form: impl Fn(&Vec3) -> Minorant) -> f64 {
    let mut places = places(cap);
    let mut all: Vec<Minorant> = places.next().iter().map(&form).collect();
    let alone = best(&all, cap.radius).max(0.0);
    if alone > enough {
        return alone;
    }
    all.extend(places.map(|e| form(&e)));
    best(&all, cap.radius).max(0.0)
}

/// `max v.d - min v.d` is the largest of `(v - w).d` over pairs of points.
pub(super) fn height(_: &Height, facets: &Facets, cap: &Cap, enough: f64) -> Bound {
    let form = |e: &Vec3| Minorant::linear(facets.lowest(&-e) - facets.lowest(e), cap);
    Bound { value: largest_of(cap, enough, form), hint: None }
}

/// `f` is the largest of the cubic forms of [`Moments`](super::moments::Moments) over the hull's points (METHODS section
/// 2), and of their mixtures. With `S` such a form, `S(d, d, d)'' = 6 S(d, d', d') - 3 S(d, d, d) >= -9 |S|`.
pub(super) fn weighted_normal_z(_: &WeightedNormalZ, facets: &Facets, cap: &Cap, enough: f64) -> Bound {
    let form = |e: &Vec3| {
        let form = facets.sums().form(&facets.lowest(e));
        let at = form.at(&cap.centre);
        let value = at.dot(&cap.centre);
        Minorant { value, slope: tangential(at * 3.0, &cap.centre), curve: 9.0 * form.norm() }
    };
    Bound { value: largest_of(cap, enough, form), hint: None }
}

/// The smallest eigenvalue of `N = sum n n'`, everywhere; its eigenvector has it.
pub(super) fn normal_z(_: &NormalZ, facets: &Facets) -> Bound {
    let weighted = facets.normals.iter().zip(&facets.counts);
    let form = weighted.fold(Mat3::zeros(), |sum, (n, count)| sum + n * n.transpose() * *count);
    let solved = form.symmetric_eigen();
    let i = solved.eigenvalues.imin();
    let value = (solved.eigenvalues[i] - ROUNDING * form.trace()).max(0.0);
    Bound { value, hint: Some(solved.eigenvectors.column(i).into_owned()) }
}

/// `staircase` is the largest of `sum +-A n.d` over all signs, once the facets are left out that may lie flat somewhere
/// in the cap (they cost nothing at least).
pub(super) fn staircase(f: &Staircase, facets: &Facets, cap: &Cap, enough: f64) -> Bound {
    let scale = f.layer_mm * f.layer_mm / 2.0;
    let bound = dipped(facets, cap, enough / scale, false);
    Bound { value: bound.value * scale, ..bound }
}

/// `support-area` is the largest of `sum -A n.d` over all sets of facets, with the same exception.
pub(super) fn support_area(_: &SupportArea, facets: &Facets, cap: &Cap, enough: f64) -> Bound {
    dipped(facets, cap, enough, true)
}

/// Of `sum A |d.n|`, or with `down` of `sum A max(-d.n, 0)`, over the facets that lie flat nowhere in the cap.
fn dipped(facets: &Facets, cap: &Cap, enough: f64, down: bool) -> Bound {
    let flat = (cap.radius + FLAT.acos() + 1e-9).cos();
    let level = cap.radius.sin() * (1.0 + 1e-9);
    let (mut fixed, mut open, mut dip) = (Vec3::zeros(), Vec::new(), (0.0, None));
    for (n, &area) in facets.normals.iter().zip(&facets.areas) {
        let along = n.dot(&cap.centre);
        if along <= -flat || (along >= flat && !down) {
            dip = if area > dip.0 { (area, Some(n * along.signum())) } else { dip };
        } else if along < -level {
            fixed -= n * area;
        } else if along <= level {
            open.push(n * area);
        } else if !down {
            fixed += n * area;
        }
    }
    let signed = |a: &Vec3, e: &Vec3| match a.dot(e) {
        along if along < 0.0 => -a,
        _ if down => Vec3::zeros(),
        _ => *a,
    };
    let form = |e: &Vec3| Minorant::linear(open.iter().fold(fixed, |sum, a| sum + signed(a, e)), cap);
    Bound { value: largest_of(cap, enough, form), hint: dip.1 }
}

/// Each facet costs `max(g, 0)` with `g = pi/2 - theta - angle(d, +-n)`, which is at least `s g` for `s` 0 or 1 and either
/// sense of `n`. `g'' >= -cot(angle)`, as the angle from a point of the sphere has that curvature across; beside the
/// normal itself, where that has no bound, `g` falls by the angle at most.
pub(super) fn overhang_angle(f: &OverhangAngle, facets: &Facets, cap: &Cap, enough: f64) -> Bound {
    let reach = std::f64::consts::FRAC_PI_2 - f.theta.rad();
    let (c, r) = (cap.centre, cap.radius);
    let mut fixed = Minorant { value: 0.0, slope: Vec3::zeros(), curve: 0.0 };
    let mut open: Vec<(Vec3, Minorant)> = Vec::new();
    for (n, &count) in facets.normals.iter().zip(&facets.counts) {
        let pole = if n.dot(&c) < 0.0 { -n } else { *n };
        let across = tangential(pole, &c);
        let angle = across.norm().atan2(pole.dot(&c));
        if angle > reach + r {
            continue;
        }
        let g = reach - angle;
        if angle <= 1.5 * r {
            fixed.value += count * (g - r).max(0.0);
            continue;
        }
        let curve = (1.0 / (angle - r).tan()).max(0.0);
        let one = Minorant { value: count * g, slope: across * (count / across.norm()), curve: count * curve };
        if g > r { fixed = fixed.plus(&one) } else { open.push((pole, one)) }
    }
    let cosine = reach.cos();
    let form =
        |e: &Vec3| open.iter().filter(|(pole, _)| pole.dot(e) > cosine).fold(fixed, |sum, (_, one)| sum.plus(one));
    Bound { value: largest_of(cap, enough, form), hint: None }
}

impl Minorant {
    fn plus(&self, other: &Self) -> Self {
        let slope = self.slope + other.slope;
        Self { value: self.value + other.value, slope, curve: self.curve + other.curve }
    }
}

/// Whether `f` has bounds at all: asked on a cap about +Z.
pub fn has_bounds(f: &dyn Objective, facets: &Facets) -> bool {
    f.bound(facets, &Cap { centre: Vec3::z(), radius: 0.1 }, f64::INFINITY).is_some()
}
