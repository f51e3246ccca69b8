//! `overhang-angle`: cones about the normals.

use super::super::Facets;
use super::super::facets::Normals;
use super::{Cap, Local, Minorant};
use crate::geom::{Angle, Vec3};

/// Each facet costs `max(g, 0)` with `g = pi/2 - theta - angle(d, +-n)`, which is at least `s g` for `s` 0 or 1 and either
/// sense of `n`. `g'' >= -cot(angle)`, as the angle from a point of the sphere has that curvature across; beside the
/// normal itself, where that has no bound, `g` falls by the angle at most.
///
/// No list of facets is kept from cap to cap: those in reach stay as many however small the caps.
#[derive(Clone)]
pub(crate) struct Leaning<'a> {
    normals: &'a Normals,
    reach: f64,
    cap: Cap,
    /// Of the facets that cost something everywhere on the cap.
    settled: Minorant,
    /// Near the centre.
    middle: Minorant,
}

/// Of the facets in reach on a part of the cap, `g` with the sense that is in reach.
type Open = Vec<(Vec3, Minorant)>;

impl<'a> Leaning<'a> {
    pub(crate) fn of(facets: &'a Facets, theta: Angle) -> Self {
        let reach = std::f64::consts::FRAC_PI_2 - theta.rad();
        let (settled, middle) = (Minorant::ZERO, Minorant::ZERO);
        Self { normals: facets.normals(), reach, cap: Cap::WHOLE, settled, middle }
    }

    /// What is settled on the cap, and what is open; of the settled ones perhaps only a part where `all` is not asked for.
    fn sorted(&self, cap: &Cap, all: bool) -> (Minorant, Open) {
        let (c, r) = (cap.centre, cap.radius);
        let out = (self.reach + r + 1e-9).min(std::f64::consts::FRAC_PI_2).cos();
        let inside = if all { f64::INFINITY } else { (self.reach - r - 1e-9).max(0.0).cos() };
        let (sine, cosine) = r.sin_cos();
        let (mut settled, mut open) = (Minorant::ZERO, Vec::new());
        for (n, &count) in self.normals.units.iter().zip(&self.normals.counts) {
            let signed = n.dot(&c);
            let along = signed.abs().min(1.0);
            if along < out || along > inside {
                continue;
            }
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
        (settled, open)
    }

    /// With the open ones that cost something at `e`.
    fn completed(&self, settled: &Minorant, open: &Open, e: &Vec3) -> Minorant {
        let cosine = self.reach.cos();
        let inside = open.iter().filter(|(pole, _)| pole.dot(e) > cosine);
        inside.fold(*settled, |sum, (_, one)| one.added(1.0, &sum))
    }
}

impl<'a> Local<'a> for Leaning<'a> {
    fn within(&self, cap: &Cap) -> Box<dyn Local<'a> + 'a> {
        let (settled, open) = self.sorted(cap, true);
        let middle = self.completed(&settled, &open, &cap.centre);
        Box::new(Self { cap: *cap, settled, middle, ..*self })
    }

    fn estimate(&self) -> f64 {
        self.middle.value
    }

    fn minorant(&self, e: &Vec3) -> Minorant {
        if *e == self.cap.centre { self.middle } else { self.minorants(&[*e])[0] }
    }

    fn minorants(&self, places: &[Vec3]) -> Vec<Minorant> {
        let (_, open) = self.sorted(&self.cap, false);
        places.iter().map(|e| self.completed(&self.settled, &open, e)).collect()
    }
}
