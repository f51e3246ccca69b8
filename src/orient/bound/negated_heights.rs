//! Minus the objectives that know the lowest corner, for the negative weights of sums: which corner is the lowest is settled on small
//! caps, and elsewhere it is short by a known length at most.

use std::sync::Arc;

use super::super::Facets;
use super::super::facets::Normals;
use super::extent::{cubic, quadratic};
use super::{Cap, Local, Minorant};
use crate::geom::{Angle, Mat3, Vec3};

/// The lowest corner along the direction times `sense`: everywhere on the cap `sense min v.d >= (point.d - short)`, where
/// `point` is the lowest at the centre.
#[derive(Clone)]
struct Bottom<'a> {
    facets: &'a Facets,
    sense: f64,
    /// Corners that may be the lowest on the cap.
    may: Arc<Vec<u32>>,
    /// Times `sense`.
    point: Vec3,
    short: f64,
}

impl<'a> Bottom<'a> {
    fn of(facets: &'a Facets, sense: f64) -> Self {
        let may = Arc::new((0..facets.points.len() as u32).collect());
        Self { facets, sense, may, point: Vec3::zeros(), short: 0.0 }
    }

    fn within(&self, cap: &Cap) -> Self {
        let point = self.facets.lowest(&(cap.centre * self.sense)) * self.sense;
        let (mut may, mut short) = (Vec::new(), 0.0_f64);
        for &i in self.may.iter() {
            let least = cap.range(&(self.facets.points[i as usize] * self.sense - point))[0];
            if least <= 0.0 {
                may.push(i);
                short = short.max(-least);
            }
        }
        Self { may: Arc::new(may), point, short: short * (1.0 + 1e-12), ..*self }
    }
}

/// Minus `height`: `min v.d + min (-v).d`.
#[derive(Clone)]
pub(crate) struct MinusHeight<'a> {
    ends: [Bottom<'a>; 2],
    cap: Cap,
}

impl<'a> MinusHeight<'a> {
    pub(crate) fn of(facets: &'a Facets) -> Self {
        Self { ends: [1.0, -1.0].map(|sense| Bottom::of(facets, sense)), cap: Cap::WHOLE }
    }
}

impl<'a> Local<'a> for MinusHeight<'a> {
    fn within(&self, cap: &Cap) -> Box<dyn Local<'a> + 'a> {
        Box::new(Self { ends: [0, 1].map(|k| self.ends[k].within(cap)), cap: *cap })
    }

    fn estimate(&self) -> f64 {
        self.minorant(&self.cap.centre).value
    }

    fn minorant(&self, _: &Vec3) -> Minorant {
        let [low, high] = &self.ends;
        let linear = Minorant::linear(low.point + high.point, &self.cap);
        Minorant { value: linear.value - low.short - high.short, ..linear }
    }

    fn floor(&self) -> f64 {
        f64::NEG_INFINITY
    }
}

/// Minus `weighted-normal-z`: minus its cubic form at the lowest corner, and what that may be short of times `-d'Qd`.
#[derive(Clone)]
pub(crate) struct MinusHeights<'a> {
    bottom: Bottom<'a>,
    cap: Cap,
}

impl<'a> MinusHeights<'a> {
    pub(crate) fn of(facets: &'a Facets) -> Self {
        Self { bottom: Bottom::of(facets, 1.0), cap: Cap::WHOLE }
    }
}

impl<'a> Local<'a> for MinusHeights<'a> {
    fn within(&self, cap: &Cap) -> Box<dyn Local<'a> + 'a> {
        Box::new(Self { bottom: self.bottom.within(cap), cap: *cap })
    }

    fn estimate(&self) -> f64 {
        self.minorant(&self.cap.centre).value
    }

    fn minorant(&self, _: &Vec3) -> Minorant {
        let sums = self.bottom.facets.sums();
        let form = sums.form(&self.bottom.point);
        let short = quadratic(&(-sums.square * self.bottom.short), &self.cap);
        cubic(&-form.once(&self.cap.centre), form.norm(), &self.cap).added(1.0, &short)
    }

    fn floor(&self) -> f64 {
        f64::NEG_INFINITY
    }
}

/// Minus `support-volume-convex`: a facet costs `-A n.d (b.d - v.d + short)` at most with the lowest corner `v` at the centre. Those
/// that hang everywhere on the cap are one quadratic form and one vector; the others are counted at their most.
#[derive(Clone)]
pub(crate) struct MinusColumns<'a> {
    normals: &'a Normals,
    middle: Vec3,
    from: f64,
    bottom: Bottom<'a>,
    cap: Cap,
    /// As in `Columns`.
    form: Mat3,
    area: Vec3,
    open: Arc<Vec<u32>>,
    /// Of the open ones, mm³.
    most: f64,
}

impl<'a> MinusColumns<'a> {
    pub(crate) fn of(facets: &'a Facets, overhang: Angle) -> Self {
        let (normals, middle, from) = (facets.normals(), facets.middle(), overhang.rad().sin());
        let open = Arc::new((0..normals.units.len() as u32).collect());
        let (bottom, form, area) = (Bottom::of(facets, 1.0), Mat3::zeros(), Vec3::zeros());
        Self { normals, middle, from, bottom, cap: Cap::WHOLE, form, area, open, most: 0.0 }
    }
}

impl<'a> Local<'a> for MinusColumns<'a> {
    fn within(&self, cap: &Cap) -> Box<dyn Local<'a> + 'a> {
        let bottom = self.bottom.within(cap);
        let (mut form, mut area, mut open, mut most) = (self.form, self.area, Vec::new(), 0.0);
        for &i in self.open.iter() {
            let i = i as usize;
            let (n, a, moment) = (&self.normals.units[i], self.normals.areas[i], &self.normals.moments[i]);
            let [least, down] = cap.range(&-n);
            if least > self.from + 1e-9 {
                form -= n * (moment - self.middle * a).transpose();
                area += n * a;
            } else if down >= self.from - 1e-9 {
                open.push(i as u32);
                let high = cap.range(&(moment - bottom.point * a))[1] + bottom.short * a;
                most += down.max(0.0) * high.max(0.0);
            }
        }
        let most = most * (1.0 + 1e-12);
        Box::new(Self { bottom, cap: *cap, form, area, open: Arc::new(open), most, ..*self })
    }

    fn estimate(&self) -> f64 {
        self.minorant(&self.cap.centre).value
    }

    fn minorant(&self, _: &Vec3) -> Minorant {
        let v = self.bottom.point - self.middle;
        let hanging = quadratic(&-(self.form + self.area * v.transpose()), &self.cap);
        let sum = Minorant::linear(self.area * self.bottom.short, &self.cap).added(1.0, &hanging);
        Minorant { value: sum.value - self.most, ..sum }
    }

    fn floor(&self) -> f64 {
        f64::NEG_INFINITY
    }
}
