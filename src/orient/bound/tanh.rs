//! `tanh-overhang`: a product of two smooth functions for each facet.

use std::sync::Arc;

use super::super::Facets;
use super::super::volumes::{TanhOverhang, one_and_tanh, tanh};
use super::extent::least_across;
use super::{Cap, Local, Minorant};
use crate::geom::{Mat3, Vec3};

/// A facet costs `|S| (1 + tanh S) tanh h` with `S` and `h` linear in `d`: `h = max (b - v).d` over the corners `v`, so any
/// `v` gives less, and `|S|` is the larger of `+-S`. With `v` and the sign fixed the cost is smooth, `u(S) tanh h`. Its
/// curvature is bounded in two ways from the ranges of `S` and `h` on the cap, of which the better holds: term by term,
/// and by the second derivatives at the centre, summed over the facets, less what the third ones can make of them.
///
/// A facet whose term would count for less than nothing is left out, for none costs less: so is one of open sign whose `h` may
/// be negative (for a `v` that is not the lowest), and one that faces up too steeply to cost more than a rounding error.
#[derive(Clone)]
pub(crate) struct Hanging<'a> {
    f: &'a TanhOverhang,
    facets: &'a Facets,
    cap: Cap,
    /// Facets that may cost something on the cap.
    may: Arc<Vec<u32>>,
    /// The corner lowest at the centre.
    low: Vec3,
    /// With that corner, the facets whose sign is settled.
    settled: Sum,
    /// The others that count.
    open: Arc<Vec<u32>>,
}

/// `1 + tanh S` is below 1e-15 from here down.
const NOTHING: f64 = -18.0;

impl<'a> Hanging<'a> {
    pub(crate) fn of(f: &'a TanhOverhang, facets: &'a Facets) -> Self {
        let may = Arc::new((0..facets.each.len() as u32).collect());
        Self { f, facets, cap: Cap::WHOLE, may, low: Vec3::zeros(), settled: Sum::default(), open: Arc::default() }
    }

    fn term(&self, i: u32, v: &Vec3) -> Term {
        let facet = &self.facets.each[i as usize];
        let [square, lift] = self.f.factors();
        Term::of(facet.area * square, (facet.barycentre - v) * lift, &self.cap)
    }

    /// The sum with corner `v` over facets whose sign is settled, and the facets whose sign is open but that count.
    fn sorted(&self, v: &Vec3) -> (Sum, Vec<u32>) {
        let (mut sum, mut open) = (Sum::default(), Vec::new());
        for &i in self.may.iter() {
            let term = self.term(i, v);
            if !term.is_open() {
                sum.add(&term, term.s.signum(), &self.cap);
            } else if term.h >= term.stray_h {
                open.push(i);
            }
        }
        (sum, open)
    }
}

/// One facet on a cap: `S` and `h` with their plain gradients, both at the centre.
struct Term {
    a: Vec3,
    b: Vec3,
    s: f64,
    h: f64,
    /// How far they stray on the cap.
    stray_s: f64,
    stray_h: f64,
    /// How fast they change along a great circle at most.
    fast_s: f64,
    fast_h: f64,
}

impl Term {
    fn of(a: Vec3, b: Vec3, cap: &Cap) -> Self {
        let (c, sine) = (&cap.centre, cap.sine());
        let drop = 1.0 - cap.radius.min(std::f64::consts::PI).cos();
        let (s, h) = (a.dot(c), b.dot(c));
        let across = |v: &Vec3, along: f64| (v.norm_squared() - along * along).max(0.0).sqrt();
        let (across_s, across_h) = (across(&a, s), across(&b, h));
        let stray = |at: f64, across: f64| (across * sine + at.abs() * drop) * (1.0 + 1e-9);
        let (fast_s, fast_h) = (across_s + s.abs() * sine, across_h + h.abs() * sine);
        Self { a, b, s, h, stray_s: stray(s, across_s), stray_h: stray(h, across_h), fast_s, fast_h }
    }

    fn is_open(&self) -> bool {
        self.s.abs() <= self.stray_s
    }
}

/// Bounds of `u = +-S (1 + tanh S)` and `tanh h` and of their first three derivatives by their own arguments, on a cap.
struct Sizes {
    /// The second derivative of `u tanh h` by `S` is nowhere below minus this times the size of `tanh h`.
    concave: f64,
    u: [f64; 4],
    t: [f64; 4],
}

impl Sizes {
    fn of(term: &Term, ts: f64, sign: f64) -> Self {
        let (s0, s1) = (term.s - term.stray_s, term.s + term.stray_s);
        let far = s0.abs().max(s1.abs());
        let near = if term.is_open() { 0.0 } else { s0.abs().min(s1.abs()) };
        // sech^2 S = 1 - tanh^2 S <= 4 exp(-2 |S|), and tanh is no steeper than 1.
        let sech = match near {
            n if n > 20.0 => 1e-16,
            n if n > 1.0 => (4.0 * (-2.0 * n).exp()).min(1.0),
            _ => 1.0 - (ts.abs() - term.stray_s).max(0.0).powi(2),
        };
        let risen = (1.0 + ts + term.stray_s).min(2.0);
        // With s = sech^2 S: the first is 1 + tanh S + S s, the second 2 s (1 - S tanh S), the third
        // -4 s tanh S (1 - S tanh S) - 2 s (tanh S + S s).
        let first = (risen + s1.max(0.0) * sech).max(if s0 < 0.0 { far * sech } else { 0.0 }).min(2.2);
        let size = if s1 > 0.0 { risen * far } else { (far * risen).min(0.28) };
        let second = 2.0 * sech * (far - 1.0).max(1.0);
        let third = 2.0 * second + 2.0 * sech * (1.0 + far * sech);
        let most = term.h.abs() + term.stray_h;
        // Above -1.19 the second is negative only where S tanh S > 1, and by 0.15 at most.
        let concave = if sign > 0.0 && s0 > -1.19 { (2.0 * sech * (far - 1.0).max(0.0)).min(0.15) } else { second };
        let sure = term.h >= term.stray_h;
        Self {
            concave: if sure { concave } else { second },
            u: [size, first, second, third],
            t: [most.min(1.0), 1.0, (2.0 * most).min(0.77), 2.0],
        }
    }

    /// No second derivative along a great circle is below minus the first; no third one exceeds the other. By the product
    /// rule; along a great circle the second derivatives of `S` and `h` are `-S` and `-h`.
    fn along(&self, term: &Term) -> [f64; 2] {
        let ([u, u1, u2, u3], [t, t1, t2, t3]) = (self.u, self.t);
        let (s, h) = (term.s.abs() + term.stray_s, term.h.abs() + term.stray_h);
        let (ds, dh) = (term.fast_s, term.fast_h);
        let (ds2, dh2) = (ds * ds, dh * dh);
        let (by_s, by_ss, by_sss) = (u1 * ds, u2 * ds2 + u1 * s, u3 * ds2 * ds + 3.0 * u2 * ds * s + u1 * ds);
        let (by_h, by_hh, by_hhh) = (t1 * dh, t2 * dh2 + t1 * h, t3 * dh2 * dh + 3.0 * t2 * dh * h + t1 * dh);
        let second = (self.concave * ds2 + u1 * s) * t + 2.0 * by_s * by_h + u * by_hh;
        [second, by_sss * t + 3.0 * by_ss * by_h + 3.0 * by_s * by_hh + u * by_hhh]
    }
}

/// A sum of smooth terms.
#[derive(Clone, Copy, Default)]
struct Sum {
    value: f64,
    slope: Vec3,
    /// The second derivative at the centre along the unit tangent `t` is `t'Ht` less `turn`.
    hessian: Mat3,
    turn: f64,
    second: f64,
    third: f64,
}

impl Sum {
    fn add(&mut self, term: &Term, sign: f64, cap: &Cap) {
        let (ts, th) = (one_and_tanh(term.s) - 1.0, tanh(term.h));
        let (a, b, s, h) = (&term.a, &term.b, term.s, term.h);
        let (sech, flat) = (1.0 - ts * ts, 1.0 - th * th);
        let (u, u1, u2) = (sign * s * (1.0 + ts), sign * (1.0 + ts + s * sech), sign * 2.0 * sech * (1.0 - s * ts));
        let slope = (a - cap.centre * s) * (u1 * th) + (b - cap.centre * h) * (u * flat);
        let [second, third] = Sizes::of(term, ts, sign).along(term);
        let r = cap.radius;
        if u * th < (slope.norm() + 0.5 * second * r) * r {
            return;
        }
        self.value += u * th;
        self.slope += slope;
        let (aa, ab, bb) = (u2 * th, u1 * flat, -2.0 * u * th * flat);
        self.hessian += a * (a * aa + b * ab).transpose() + b * (a * ab + b * bb).transpose();
        self.turn += u1 * s * th + u * flat * h;
        self.second += second;
        self.third += third;
    }

    fn minorant(&self, cap: &Cap) -> Minorant {
        let here = self.turn - least_across(&self.hessian, &cap.centre);
        let curve = self.second.min(here + self.third * cap.radius + 1e-12 * self.second);
        Minorant { value: self.value, slope: self.slope, curve }
    }
}

impl Hanging<'_> {
    /// `sum` with the facets of open sign, each with the sign it has at `e`.
    fn completed(&self, mut sum: Sum, open: &[u32], v: &Vec3, e: &Vec3) -> Minorant {
        for &i in open {
            let term = self.term(i, v);
            sum.add(&term, if term.a.dot(e) < 0.0 { -1.0 } else { 1.0 }, &self.cap);
        }
        sum.minorant(&self.cap).added(0.25, &Minorant::ZERO)
    }
}

impl<'a> Local<'a> for Hanging<'a> {
    fn within(&self, cap: &Cap) -> Box<dyn Local<'a> + 'a> {
        let square = self.f.factors()[0];
        let may = |i: &&u32| {
            let a = self.facets.each[**i as usize].area * square;
            let s = a.dot(&cap.centre);
            s >= NOTHING || Term::of(a, Vec3::zeros(), cap).stray_s + s >= NOTHING
        };
        let may = Arc::new(self.may.iter().filter(may).copied().collect());
        let low = self.facets.lowest(&cap.centre);
        let mut local = Self { cap: *cap, may, low, settled: Sum::default(), open: Arc::default(), ..*self };
        let (settled, open) = local.sorted(&low);
        (local.settled, local.open) = (settled, Arc::new(open));
        Box::new(local)
    }

    fn estimate(&self) -> f64 {
        self.minorant(&self.cap.centre).value
    }

    fn minorant(&self, e: &Vec3) -> Minorant {
        let v = self.facets.lowest(e);
        if v == self.low {
            return self.completed(self.settled, &self.open, &v, e);
        }
        let (sum, open) = self.sorted(&v);
        self.completed(sum, &open, &v, e)
    }

    /// The facets are sorted once for each corner.
    fn minorants(&self, places: &[Vec3]) -> Vec<Minorant> {
        let mut known: Vec<(Vec3, Sum, Arc<Vec<u32>>)> = vec![(self.low, self.settled, self.open.clone())];
        let one = |e: &Vec3| {
            let v = self.facets.lowest(e);
            let place = known.iter().position(|(corner, ..)| *corner == v).unwrap_or_else(|| {
                let (sum, open) = self.sorted(&v);
                known.push((v, sum, Arc::new(open)));
                known.len() - 1
            });
            self.completed(known[place].1, &known[place].2, &v, e)
        };
        places.iter().map(one).collect()
    }
}
