//! Minus the objectives, for the negative weights of sums: what bounds the objective itself from above on a cap.
//!
//! Kinks that point inwards point outwards here, so that no mixture is needed there: what is not settled on a cap (a facet's side,
//! the lowest corner) is counted at its most. That is of first order, but of little weight, since the share that is
//! not settled shrinks with the cap.

use std::sync::Arc;

use super::super::Facets;
use super::super::facets::Normals;
use super::{Cap, Local, Minorant};
use crate::geom::{Angle, Vec3};

/// Minus `staircase` or `support-area`: facets of a settled side are one vector, also those that may lie flat (they cost no
/// more than that); the others are counted with the most of `|n.d|` on the cap.
#[derive(Clone)]
pub(crate) struct MinusShadow<'a> {
    normals: &'a Normals,
    scale: f64,
    /// Only what faces down counts.
    down: bool,
    cap: Cap,
    settled: Vec3,
    open: Arc<Vec<u32>>,
    /// Of the open ones, mm².
    most: f64,
}

impl<'a> MinusShadow<'a> {
    pub(crate) fn of(facets: &'a Facets, scale: f64, down: bool) -> Self {
        let normals = facets.normals();
        let open = Arc::new((0..normals.units.len() as u32).collect());
        Self { normals, scale, down, cap: Cap::WHOLE, settled: Vec3::zeros(), open, most: 0.0 }
    }
}

impl<'a> Local<'a> for MinusShadow<'a> {
    fn within(&self, cap: &Cap) -> Box<dyn Local<'a> + 'a> {
        let (mut settled, mut open, mut most) = (self.settled, Vec::new(), 0.0);
        for &i in self.open.iter() {
            let (n, area) = (&self.normals.units[i as usize], self.normals.areas[i as usize]);
            let [low, high] = cap.range(n);
            if high < -1e-12 {
                settled -= n * area;
            } else if low <= 1e-12 {
                open.push(i);
                most += area * if self.down { -low } else { high.max(-low) }.max(0.0);
            } else if !self.down {
                settled += n * area;
            }
        }
        Box::new(Self { cap: *cap, settled, open: Arc::new(open), most: most * (1.0 + 1e-12), ..*self })
    }

    fn estimate(&self) -> f64 {
        self.minorant(&self.cap.centre).value
    }

    fn minorant(&self, _: &Vec3) -> Minorant {
        let linear = Minorant::linear(-self.settled, &self.cap);
        Minorant { value: linear.value - self.most, ..linear }.added(self.scale, &Minorant::ZERO)
    }

    fn floor(&self) -> f64 {
        f64::NEG_INFINITY
    }
}

/// Minus `overhang-angle`: where a facet is in reach everywhere on the cap, `angle(d, +-n) - reach`, which is convex along great
/// circles up to a right angle; elsewhere the most it can cost.
#[derive(Clone)]
pub(crate) struct MinusLeaning<'a> {
    normals: &'a Normals,
    reach: f64,
    sum: Minorant,
}

impl<'a> MinusLeaning<'a> {
    pub(crate) fn of(facets: &'a Facets, theta: Angle) -> Self {
        let normals = facets.normals();
        Self { normals, reach: std::f64::consts::FRAC_PI_2 - theta.rad(), sum: Minorant::ZERO }
    }
}

impl<'a> Local<'a> for MinusLeaning<'a> {
    fn within(&self, cap: &Cap) -> Box<dyn Local<'a> + 'a> {
        let (c, r) = (&cap.centre, cap.radius * (1.0 + 1e-9));
        let mut sum = Minorant::ZERO;
        for (n, &count) in self.normals.units.iter().zip(&self.normals.counts) {
            let pole = if n.dot(c) < 0.0 { -n } else { *n };
            let tangent = pole - c * pole.dot(c);
            let (across, along) = (tangent.norm(), pole.dot(c));
            let angle = across.atan2(along);
            if angle > self.reach + r {
                continue;
            }
            let always = angle + r <= self.reach.min(std::f64::consts::FRAC_PI_2);
            if always && across > 1e-7 {
                sum.value -= count * (self.reach - angle);
                sum.slope -= tangent * (count / across);
            } else {
                sum.value -= count * (self.reach - (angle - r).max(0.0));
            }
        }
        Box::new(Self { sum, ..*self })
    }

    fn estimate(&self) -> f64 {
        self.sum.value
    }

    fn minorant(&self, _: &Vec3) -> Minorant {
        self.sum
    }

    fn floor(&self) -> f64 {
        f64::NEG_INFINITY
    }
}

/// Minus `contact-area` is an area: not below 0.
#[derive(Clone, Copy)]
pub(crate) struct SomeArea;

impl<'a> Local<'a> for SomeArea {
    fn within(&self, _: &Cap) -> Box<dyn Local<'a> + 'a> {
        Box::new(*self)
    }

    fn estimate(&self) -> f64 {
        0.0
    }

    fn minorant(&self, _: &Vec3) -> Minorant {
        Minorant::ZERO
    }
}
