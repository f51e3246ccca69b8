//! `tanh-overhang`: a product of two smooth functions for each facet.

mod term;

use std::sync::Arc;

use super::super::Facets;
use super::super::volumes::TanhOverhang;
use super::{Cap, Local, Minorant};
use crate::geom::Vec3;
use term::{Frame, Sum, Term};

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
#[derive(Clone)]
pub(crate) struct Hanging<'a> {
    f: &'a TanhOverhang,
    facets: &'a Facets,
    frame: Frame,
    /// Facets that may cost something on the cap.
    may: Arc<Vec<u32>>,
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

/// Up to this radius (radians) the other corners are looked at as well.
const KINKED: f64 = 0.03;

impl<'a> Hanging<'a> {
    pub(crate) fn of(f: &'a TanhOverhang, facets: &'a Facets) -> Self {
        let may = Arc::new((0..facets.each.len() as u32).collect());
        Self {
            f,
            facets,
            frame: Frame::of(&Cap::WHOLE),
            may,
            low: Vec3::zeros(),
            settled: Sum::default(),
            open: Arc::default(),
            centre: Minorant::ZERO,
        }
    }

    fn term(&self, i: u32, v: &Vec3) -> Term {
        let facet = &self.facets.each[i as usize];
        let [square, lift] = self.f.factors();
        Term { s: self.frame.line(&(facet.area * square)), h: self.frame.line(&((facet.barycentre - v) * lift)) }
    }

    /// The sum with corner `v` over facets whose sign is settled, and the facets whose sign is open but that count.
    fn sorted(&self, v: &Vec3) -> (Sum, Vec<u32>) {
        let (mut sum, mut open) = (Sum::default(), Vec::new());
        for &i in self.may.iter() {
            let term = self.term(i, v);
            if !term.is_open() {
                sum.add(&term, term.s.at.signum(), &self.frame);
            } else if term.h.at >= term.h.stray {
                open.push(i);
            }
        }
        (sum, open)
    }
}

impl Hanging<'_> {
    /// `sum` with the facets of open sign, each with the sign it has at `e`.
    fn completed(&self, mut sum: Sum, open: &[u32], v: &Vec3, e: &Vec3) -> Minorant {
        for &i in open {
            let rises = self.f.factors()[0] * self.facets.each[i as usize].area.dot(e);
            sum.add(&self.term(i, v), if rises < 0.0 { -1.0 } else { 1.0 }, &self.frame);
        }
        sum.minorant(&self.frame).added(0.25, &Minorant::ZERO)
    }
}

impl<'a> Local<'a> for Hanging<'a> {
    fn within(&self, cap: &Cap) -> Box<dyn Local<'a> + 'a> {
        let (frame, square) = (Frame::of(cap), self.f.factors()[0]);
        let may = |i: &&u32| {
            let s = frame.line(&(self.facets.each[**i as usize].area * square));
            s.at + s.stray >= NOTHING
        };
        let fewer: Vec<u32> = self.may.iter().filter(may).copied().collect();
        // A list is worth its room where it is a good deal shorter.
        let may = if 4 * fewer.len() < 3 * self.may.len() { Arc::new(fewer) } else { self.may.clone() };
        let low = self.facets.lowest(&cap.centre);
        let mut local = Self { frame, may, low, settled: Sum::default(), open: Arc::default(), ..*self };
        let (settled, open) = local.sorted(&low);
        (local.settled, local.open) = (settled, Arc::new(open));
        local.centre = local.completed(local.settled, &local.open, &local.low, &cap.centre);
        Box::new(local)
    }

    fn estimate(&self) -> f64 {
        self.centre.value
    }

    fn minorant(&self, e: &Vec3) -> Minorant {
        if *e == self.frame.cap.centre {
            return self.centre;
        }
        let v = self.facets.lowest(e);
        if v == self.low {
            return self.completed(self.settled, &self.open, &v, e);
        }
        let (sum, open) = self.sorted(&v);
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
                let (sum, open) = self.sorted(&v);
                known.push((v, sum, Arc::new(open)));
                known.len() - 1
            });
            self.completed(known[place].1, &known[place].2, &v, e)
        };
        places.iter().map(one).collect()
    }
}
