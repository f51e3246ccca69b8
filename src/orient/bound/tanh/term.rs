//! What one facet costs on a cap, `u(S) tanh h`, and how far that and its derivatives may change there.

use super::super::super::hyperbolic::{one_and_tanh, tanh};
use super::super::super::sphere::tangents;
use super::{Cap, Minorant};
use crate::geom::Vec3;

/// A cap with axes across its centre.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    pub(super) cap: Cap,
    across: [Vec3; 2],
    sine: f64,
    /// One minus the cosine of the radius.
    drop: f64,
}

impl Frame {
    pub(super) fn of(cap: &Cap) -> Self {
        let drop = 1.0 - cap.radius.min(std::f64::consts::PI).cos();
        Self { cap: *cap, across: tangents(&cap.centre), sine: cap.sine(), drop }
    }

    pub(super) fn line(&self, v: &Vec3) -> LineTerm {
        let (at, slope) = (v.dot(&self.cap.centre), self.across.map(|e| v.dot(&e)));
        let steep = length(slope);
        let stray = (steep * self.sine + at.abs() * self.drop) * (1.0 + 1e-9);
        LineTerm { at, slope, stray, fast: steep + at.abs() * self.sine }
    }
}

/// `v.d` on a cap. Along a great circle its second derivative is minus itself.
#[derive(Clone, Copy, Debug)]
pub(super) struct LineTerm {
    /// At the centre.
    pub(super) at: f64,
    /// Across it.
    slope: [f64; 2],
    /// How far it strays on the cap.
    pub(super) stray: f64,
    /// How fast it changes along a great circle at most.
    fast: f64,
}

impl LineTerm {
    /// Nowhere on the cap is it below.
    pub(super) fn least(&self) -> f64 {
        self.at - self.stray
    }
}

/// One facet on a cap.
#[derive(Clone, Copy, Debug)]
pub(super) struct Term {
    pub(super) s: LineTerm,
    pub(super) h: LineTerm,
}

impl Term {
    pub(super) fn is_open(&self) -> bool {
        self.s.at.abs() <= self.s.stray
    }
}

/// Bounds of `u = +-S (1 + tanh S)` and of its first three derivatives by `S`, on a cap.
struct Sizes {
    u: [f64; 4],
    /// The second is nowhere below minus this where `tanh h` is sure to be positive.
    concave: f64,
}

impl Sizes {
    fn of(s: &LineTerm, ts: f64, sign: f64, is_open: bool) -> Self {
        let (s0, s1) = (s.at - s.stray, s.at + s.stray);
        let far = s0.abs().max(s1.abs());
        let near = if is_open { 0.0 } else { s0.abs().min(s1.abs()) };
        // sech^2 S = 1 - tanh^2 S <= 4 exp(-2 |S|), it falls and grows by exp(2) at most where S changes by 1, exp(x) is
        // nowhere above 1 / (1 - x), and tanh is no steeper than 1.
        let sech = match near {
            n if n > 20.0 => 1e-16,
            n if n > 1.0 && s.stray < 0.1 => (((1.0 - ts * ts) + 1e-15) / (1.0 - 2.0 * s.stray)).min(1.0),
            n if n > 1.0 => (4.0 * (-2.0 * n).exp()).min(1.0),
            _ => 1.0 - (ts.abs() - s.stray).max(0.0).powi(2),
        };
        let risen = (1.0 + ts + s.stray).min(2.0);
        // With s = sech^2 S: the first is 1 + tanh S + S s, the second 2 s (1 - S tanh S), the third
        // -4 s tanh S (1 - S tanh S) - 2 s (tanh S + S s).
        let first = (risen + s1.max(0.0) * sech).max(if s0 < 0.0 { far * sech } else { 0.0 }).min(2.2);
        let size = if s1 > 0.0 { risen * far } else { (far * risen).min(0.28) };
        let second = 2.0 * sech * (far - 1.0).max(1.0);
        let third = 2.0 * second + 2.0 * sech * (1.0 + far * sech);
        // Above -1.19 the second is negative only where S tanh S > 1, and by 0.15 at most.
        let concave = if sign > 0.0 && s0 > -1.19 { (2.0 * sech * (far - 1.0).max(0.0)).min(0.15) } else { second };
        Self { u: [size, first, second, third], concave }
    }

    /// Of `u` alone: its second derivative along a great circle is nowhere below minus the first, its third exceeds the other
    /// nowhere.
    fn along(&self, s: &LineTerm, concave: f64) -> [f64; 2] {
        let ([_, u1, u2, u3], ds, s) = (self.u, s.fast, s.at.abs() + s.stray);
        [concave * ds * ds + u1 * s, u3 * ds * ds * ds + 3.0 * u2 * ds * s + u1 * ds]
    }

    /// The same of `u tanh h`, by the product rule.
    fn along_both(&self, s: &LineTerm, h: &LineTerm) -> [f64; 2] {
        let [u, u1, u2, _] = self.u;
        let most = h.at.abs() + h.stray;
        let [t, t1, t2, t3] = [most.min(1.0), 1.0, (2.0 * most).min(0.77), 2.0];
        let concave = if h.at >= h.stray { self.concave } else { u2 };
        let ([down_s, by_sss], ds, dh) = (self.along(s, concave), s.fast, h.fast);
        let (by_s, by_ss) = (u1 * ds, u2 * ds * ds + u1 * (s.at.abs() + s.stray));
        let (by_h, by_hh) = (t1 * dh, t2 * dh * dh + t1 * most);
        let by_hhh = t3 * dh * dh * dh + 3.0 * t2 * dh * most + t1 * dh;
        let second = down_s * t + 2.0 * by_s * by_h + u * by_hh;
        [second, by_sss * t + 3.0 * by_ss * by_h + 3.0 * by_s * by_hh + u * by_hhh]
    }
}

/// A sum of smooth terms: its derivatives at the centre, and bounds of them on the cap.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sum {
    value: f64,
    slope: [f64; 2],
    /// By the first axis twice, by both, by the second twice: along the great circle that way.
    bend: [f64; 3],
    /// The second derivative along a great circle is nowhere below minus this.
    second: f64,
    /// The third exceeds this nowhere.
    third: f64,
    /// Of the facets that cost `2 S`, the sum of the vectors that `S` is linear in.
    pub(super) even: Vec3,
}

impl Sum {
    /// Counts in the facet with the given sign of `S`, in the better of two ways, or not at all where even that counts for less
    /// than nothing: for none costs less than nothing.
    pub(super) fn add(&mut self, term: &Term, sign: f64, frame: &Frame) {
        let Term { s, h } = term;
        let ts = one_and_tanh(s.at) - 1.0;
        let u = sign * s.at * (1.0 + ts);
        let sech = 1.0 - ts * ts;
        let (u1, u2) = (sign * (1.0 + ts + s.at * sech), sign * 2.0 * sech * (1.0 - s.at * ts));
        let sizes = Sizes::of(s, ts, sign, term.is_open());
        let r = frame.cap.radius;
        let th = tanh(h.at);
        let held = held(h, th);
        let alone = sizes.along(s, sizes.concave).map(|bound| bound * held);
        // Where tanh h is 1 there is nothing to choose.
        let both = if held > LEVEL { [f64::INFINITY; 2] } else { sizes.along_both(s, h) };
        if held > LEVEL || u > 0.0 && u * (th - held) + 0.5 * alone[0] * r * r < 0.5 * both[0] * r * r {
            let slope = s.slope.map(|x| x * u1 * held);
            let turn = u1 * s.at * held;
            return self.count(u * held, slope, products(s, s).map(|x| x * u2 * held), turn, alone, r);
        }
        let flat = 1.0 - th * th;
        let (ss, sh, hh) = (products(s, s), products(s, h), products(h, h));
        let bend = [0, 1, 2].map(|i| ss[i] * (u2 * th) + 2.0 * sh[i] * (u1 * flat) - hh[i] * (2.0 * u * th * flat));
        let slope = [0, 1].map(|i| s.slope[i] * (u1 * th) + h.slope[i] * (u * flat));
        self.count(u * th, slope, bend, u1 * s.at * th + u * flat * h.at, both, r);
    }

    /// `bend` without `turn`, what the plain second derivative loses on the sphere.
    fn count(&mut self, value: f64, slope: [f64; 2], bend: [f64; 3], turn: f64, bounds: [f64; 2], r: f64) {
        if value < (length(slope) + 0.5 * bounds[0] * r) * r {
            return;
        }
        self.value += value;
        self.slope = [0, 1].map(|i| self.slope[i] + slope[i]);
        self.bend = [0, 1, 2].map(|i| self.bend[i] + bend[i] - if i == 1 { 0.0 } else { turn });
        self.second += bounds[0];
        self.third += bounds[1];
    }

    pub(super) fn minorant(&self, frame: &Frame) -> Minorant {
        let [a, b, d] = self.bend;
        let here = (0.5 * (a - d)).hypot(b) - 0.5 * (a + d);
        let curve = self.second.min(here + self.third * frame.cap.radius + 1e-12 * self.second);
        let slope = frame.across[0] * self.slope[0] + frame.across[1] * self.slope[1];
        Minorant { value: self.value, slope, curve }
    }
}

/// From here on `tanh h` is as good as constant.
const LEVEL: f64 = 1.0 - 1e-9;

/// The least `tanh h` on the cap, 0 where that is negative, from `th` at the centre: by the theorem of addition where `h` strays
/// little.
fn held(h: &LineTerm, th: f64) -> f64 {
    match h.least() {
        least if least <= 0.0 => 0.0,
        _ if h.stray < 0.6 => {
            let less = tanh(h.stray);
            ((th - less) / (1.0 - th * less)).max(0.0)
        }
        least => tanh(least),
    }
}

/// Plainly: `hypot` takes care of numbers beyond 1e150, and takes as long as all the rest.
fn length([a, b]: [f64; 2]) -> f64 {
    (a * a + b * b).sqrt()
}

/// Of two slopes, symmetric: by the first axis twice, by both, by the second twice.
fn products(a: &LineTerm, b: &LineTerm) -> [f64; 3] {
    let ([a1, a2], [b1, b2]) = (a.slope, b.slope);
    [a1 * b1, 0.5 * (a1 * b2 + a2 * b1), a2 * b2]
}
