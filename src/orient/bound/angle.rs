//! `overhang-angle`: cones about the normals.

use std::sync::Arc;

use super::super::Facets;
use super::super::facets::Normals;
use super::{Cap, Local, Minorant};
use crate::geom::{Angle, Vec3};

/// Each facet costs `max(g, 0)` with `g = pi/2 - theta - angle(d, +-n)`, which is at least `s g` for `s` 0 or 1 and either
/// sense of `n`. `g'' >= -cot(angle)`, as the angle from a point of the sphere has that curvature across; beside the
/// normal itself, where that has no bound, `g` falls by the angle at most. Facets out of reach on a cap are forgotten.
#[derive(Clone)]
pub(crate) struct Leaning<'a> {
    normals: &'a Normals,
    reach: f64,
    cap: Cap,
    /// In reach somewhere on the cap.
    near: Arc<Vec<u32>>,
    /// Of the facets that cost something everywhere on the cap.
    settled: Minorant,
    /// Of the others, `g` with the sense that is in reach.
    open: Arc<Vec<(Vec3, Minorant)>>,
}

impl<'a> Leaning<'a> {
    pub(crate) fn of(facets: &'a Facets, theta: Angle) -> Self {
        let normals = facets.normals();
        let near = Arc::new((0..normals.units.len() as u32).collect());
        let reach = std::f64::consts::FRAC_PI_2 - theta.rad();
        Self { normals, reach, cap: Cap::WHOLE, near, settled: Minorant::ZERO, open: Arc::default() }
    }

    fn narrowed(&self, cap: &Cap) -> Self {
        let (c, r) = (cap.centre, cap.radius);
        let out = (self.reach + r + 1e-9).min(std::f64::consts::FRAC_PI_2).cos();
        let (sine, cosine) = r.sin_cos();
        let mut settled = Minorant::ZERO;
        let (mut near, mut open) = (Vec::with_capacity(self.near.len() / 2), Vec::new());
        for &i in self.near.iter() {
            let (n, count) = (&self.normals.units[i as usize], self.normals.counts[i as usize]);
            let signed = n.dot(&c);
            let along = signed.abs().min(1.0);
            if along < out {
                continue;
            }
            near.push(i);
            let pole = if signed < 0.0 { -n } else { *n };
            let tangent = pole - c * along;
            let across = tangent.norm();
            // Not `acos`: its error is 1e-8 beside the normal.
            let angle = across.atan2(along);
            let g = self.reach - angle;
            if angle <= 1.5 * r || across < 1e-7 {
                settled.value += count * (g - r).max(0.0);
                continue;
            }
            // cot(angle - r)
            let curve = (along * cosine + across * sine) / (across * cosine - along * sine);
            let one = Minorant { value: count * g, slope: tangent * (count / across), curve: count * curve.max(0.0) };
            if g > r { settled = one.added(1.0, &settled) } else { open.push((pole, one)) }
        }
        Self { cap: *cap, near: Arc::new(near), settled, open: Arc::new(open), ..*self }
    }
}

impl<'a> Local<'a> for Leaning<'a> {
    fn within(&self, cap: &Cap) -> Box<dyn Local<'a> + 'a> {
        Box::new(self.narrowed(cap))
    }

    fn estimate(&self) -> f64 {
        self.minorant(&self.cap.centre).value
    }

    fn minorant(&self, e: &Vec3) -> Minorant {
        let cosine = self.reach.cos();
        let inside = self.open.iter().filter(|(pole, _)| pole.dot(e) > cosine);
        inside.fold(self.settled, |sum, (_, one)| one.added(1.0, &sum))
    }
}
