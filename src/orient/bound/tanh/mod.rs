//! `tanh-overhang`: a product of two smooth functions for each facet.

mod term;

use std::sync::Arc;

use super::super::Facets;
use super::{Cap, Local, Minorant};
use crate::geom::Vec3;
use term::{Frame, LineTerm, Sum, Term};

/// A facet costs `|S| (1 + tanh S) tanh h` with `S` and `h` linear in `d`: `h = max (b - v).d` over the corners `v`, so any
/// `v` gives less, and `|S|` is the larger of `+-S`. With `v` and the sign fixed the cost is smooth, `u(S) tanh h`. Its
/// curvature is bounded in two ways from the ranges of `S` and `h` on the cap, of which the better holds: term by term,
/// and by the second derivatives at the centre, summed over the facets, less what the third ones can make of them.
///
/// On a cap where `h` changes by more than about 1 those bounds say nothing, but `tanh h` has its least value `t` there, and
/// `u(S) t` is below the cost and bends little: of the two, each facet is counted in by that which loses less at the rim.
///
/// A facet whose term would count for less than nothing is left out, for none costs less: so is one of open sign whose `h` may
/// be negative (for a `v` that is not the lowest), and one that faces up too steeply to cost more than a rounding error.
/// One that faces down steeply and lies high costs `2 S` but for 1e-10: those are one linear function, and settled.
#[derive(Clone)]
pub(crate) struct HangingTerm<'a> {
    /// `S` is the first times the area vector, the height the second times the barycentre over the lowest point.
    factors: [f64; 2],
    facets: &'a Facets,
    frame: Frame,
    /// Facets that may cost something on the cap, without those in `even`.
    may: Arc<Vec<u32>>,
    /// Of those that cost `2 S` on the cap, the sum of the vectors that `S` is linear in.
    even: Vec3,
    /// The corner lowest at the centre.
    low: Vec3,
    /// With that corner, the facets whose sign is settled.
    settled: Sum,
    /// The others that count.
    open: Arc<Vec<u32>>,
    /// With that corner, and the signs that the others have at the centre.
    centre: Minorant,
}

/// `1 + tanh S` is below 1e-15 from here down.
const NOTHING: f64 = -18.0;

/// From here on `tanh` is above `1 - 8e-11`.
const ONE: f64 = 12.0;

/// `(1 + tanh S) tanh h` is no less where neither is below `ONE`.
const TWICE: f64 = 2.0 * (1.0 - 2e-10);

/// Caps beyond this radius (radians) are cut unseen: no bound of theirs would say anything.
const WIDE: f64 = 0.4;

/// Up to this radius (radians) the other corners are looked at as well.
const KINKED: f64 = 0.03;

impl<'a> HangingTerm<'a> {
    pub(crate) fn of(factors: [f64; 2], facets: &'a Facets) -> Self {
        let may = Arc::new((0..facets.each.len() as u32).collect());
        Self {
            factors,
            facets,
            frame: Frame::of(&Cap::WHOLE),
            may,
            even: Vec3::zeros(),
            low: Vec3::zeros(),
            settled: Sum::default(),
            open: Arc::default(),
            centre: Minorant::ZERO,
        }
    }

    /// The vector that `S` is linear in.
    fn steep(&self, i: u32) -> Vec3 {
        self.facets.each[i as usize].area * self.factors[0]
    }

    fn height(&self, i: u32, v: &Vec3) -> LineTerm {
        self.frame.line(&((self.facets.each[i as usize].barycentre - v) * self.factors[1]))
    }

    /// The sum with corner `v` over facets whose sign is settled, and the facets whose sign is open but that count; `kept` is
    /// told of all that may cost something and are not even.
    fn sorted(&self, v: &Vec3, mut kept: impl FnMut(u32)) -> (Sum, Vec<u32>) {
        let (mut sum, mut open) = (Sum::default(), Vec::new());
        for &i in self.may.iter() {
            let steep = self.steep(i);
            let s = self.frame.line(&steep);
            if s.at + s.stray < NOTHING {
                continue;
            }
            let h = self.height(i, v);
            if s.least() >= ONE && h.least() >= ONE {
                sum.even += steep;
                continue;
            }
            kept(i);
            let term = Term { s, h };
            if !term.is_open() {
                sum.add(&term, s.at.signum(), &self.frame);
            } else if h.at >= h.stray {
                open.push(i);
            }
        }
        (sum, open)
    }
}

impl HangingTerm<'_> {
    /// `sum` with the facets of open sign, each with the sign it has at `e`.
    fn completed(&self, mut sum: Sum, open: &[u32], v: &Vec3, e: &Vec3) -> Minorant {
        for &i in open {
            let steep = self.steep(i);
            let term = Term { s: self.frame.line(&steep), h: self.height(i, v) };
            sum.add(&term, if steep.dot(e) < 0.0 { -1.0 } else { 1.0 }, &self.frame);
        }
        let even = Minorant::linear((self.even + sum.even) * TWICE, &self.frame.cap);
        even.added(0.25, &sum.minorant(&self.frame).added(0.25, &Minorant::ZERO))
    }
}

impl<'a> Local<'a> for HangingTerm<'a> {
    fn within(&self, cap: &Cap) -> Box<dyn Local<'a> + 'a> {
        let (frame, low) = (Frame::of(cap), self.facets.lowest(&cap.centre));
        let none = (Sum::default(), Arc::default());
        let mut local = Self { frame, low, settled: none.0, open: none.1, centre: Minorant::ZERO, ..self.clone() };
        if cap.radius > WIDE {
            return Box::new(local);
        }
        let mut fewer = Vec::with_capacity(self.may.len());
        let (mut settled, open) = local.sorted(&low, |i| fewer.push(i));
        // A list is worth its room where it is a good deal shorter.
        if 4 * fewer.len() < 3 * self.may.len() {
            fewer.shrink_to_fit();
            local.even += std::mem::take(&mut settled.even);
            local.may = Arc::new(fewer);
        }
        (local.settled, local.open) = (settled, Arc::new(open));
        local.centre = local.completed(local.settled, &local.open, &local.low, &cap.centre);
        Box::new(local)
    }

    fn estimate(&self) -> f64 {
        if self.frame.cap.radius > WIDE { f64::INFINITY } else { self.centre.value }
    }

    fn minorant(&self, e: &Vec3) -> Minorant {
        if *e == self.frame.cap.centre {
            return self.centre;
        }
        let v = self.facets.lowest(e);
        if v == self.low {
            return self.completed(self.settled, &self.open, &v, e);
        }
        let (sum, open) = self.sorted(&v, |_| ());
        self.completed(sum, &open, &v, e)
    }

    /// The facets are sorted once for each corner. On a large cap four smaller ones give more for the same work.
    fn minorants(&self, places: &[Vec3]) -> Vec<Minorant> {
        if self.frame.cap.radius > KINKED {
            return Vec::new();
        }
        let mut known: Vec<(Vec3, Sum, Arc<Vec<u32>>)> = vec![(self.low, self.settled, self.open.clone())];
        let one = |e: &Vec3| {
            let v = self.facets.lowest(e);
            let place = known.iter().position(|(corner, ..)| *corner == v).unwrap_or_else(|| {
                let (sum, open) = self.sorted(&v, |_| ());
                known.push((v, sum, Arc::new(open)));
                known.len() - 1
            });
            self.completed(known[place].1, &known[place].2, &v, e)
        };
        places.iter().map(one).collect()
    }
}
