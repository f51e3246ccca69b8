//! `staircase` and `support-area`: sums of `A |n.d|`, of which facets that lie flat are left out.

use std::sync::Arc;

use super::super::Facets;
use super::super::facets::FLAT;
use super::super::facets::Normals;
use super::{Cap, Local, Minorant};
use crate::geom::Vec3;

/// `sum A |d.n|` is the largest of `sum +-A n.d` over all signs, and `sum A max(-d.n, 0)` that of `sum -A n.d` over all
/// sets of facets, once the facets are left out that may lie flat somewhere on the cap (they cost nothing at least).
///
/// On a cap most signs are settled: those facets are one vector.
#[derive(Clone)]
pub(crate) struct Shadow<'a> {
    normals: &'a Normals,
    scale: f64,
    /// Only what faces down counts.
    down: bool,
    cap: Cap,
    /// Of the facets whose side is settled, `sum +-A n`.
    settled: Vec3,
    /// Not settled: both sides are on the cap.
    open: Arc<Vec<u32>>,
    /// May lie flat on the cap.
    flat: Arc<Vec<u32>>,
    dip: Option<Vec3>,
    /// Taken off for rounding, mm²: where all areas nearly cancel out, what is relative to their sum is not enough.
    slack: f64,
}

impl<'a> Shadow<'a> {
    pub(crate) fn of(facets: &'a Facets, scale: f64, down: bool) -> Self {
        let normals = facets.normals();
        let open = Arc::new((0..normals.units.len() as u32).collect());
        let (flat, settled) = (Arc::default(), Vec3::zeros());
        let slack = super::ROUNDING * normals.areas.iter().sum::<f64>();
        Self { normals, scale, down, cap: Cap::WHOLE, settled, open, flat, dip: None, slack }
    }

    fn narrowed(&self, cap: &Cap) -> Self {
        let flat_from = (cap.radius + FLAT.acos() + 1e-9).min(std::f64::consts::FRAC_PI_2).cos();
        let level = cap.sine() * (1.0 + 1e-9);
        let (mut settled, mut open, mut flat, mut dip) = (self.settled, Vec::new(), Vec::new(), (0.0, None));
        for &i in self.open.iter().chain(self.flat.iter()) {
            let (n, area) = (&self.normals.units[i as usize], self.normals.areas[i as usize]);
            let along = n.dot(&cap.centre);
            if along <= -flat_from || (along >= flat_from && !self.down) {
                flat.push(i);
                dip = if area > dip.0 { (area, Some(n * along.signum())) } else { dip };
            } else if along < -level {
                settled -= n * area;
            } else if along <= level {
                open.push(i);
            } else if !self.down {
                settled += n * area;
            }
        }
        let (open, flat) = (Arc::new(open), Arc::new(flat));
        Self { cap: *cap, settled, open, flat, dip: dip.1, ..*self }
    }
}

impl<'a> Local<'a> for Shadow<'a> {
    fn within(&self, cap: &Cap) -> Box<dyn Local<'a> + 'a> {
        Box::new(self.narrowed(cap))
    }

    fn estimate(&self) -> f64 {
        let c = &self.cap.centre;
        let rest = self.open.iter().chain(self.flat.iter()).map(|&i| {
            let along = self.normals.units[i as usize].dot(c);
            let counts = along > -FLAT && along < FLAT && (along < 0.0 || !self.down);
            if counts { along.abs() * self.normals.areas[i as usize] } else { 0.0 }
        });
        (self.settled.dot(c) + rest.sum::<f64>()) * self.scale
    }

    fn minorant(&self, e: &Vec3) -> Minorant {
        let mut sum = self.settled;
        for &i in self.open.iter() {
            let (n, area) = (&self.normals.units[i as usize], self.normals.areas[i as usize]);
            let along = n.dot(e);
            let sign = if along < 0.0 { -1.0 } else { f64::from(u8::from(!self.down)) };
            sum += n * (area * sign);
        }
        let linear = Minorant::linear(sum, &self.cap);
        Minorant { value: linear.value - self.slack, ..linear }.added(self.scale, &Minorant::ZERO)
    }

    fn hint(&self) -> Option<Vec3> {
        self.dip
    }
}
