//! `support-volume-convex`: columns to the bed.

use std::sync::Arc;

use super::super::Facets;
use super::super::facets::Normals;
use super::extent::quadratic;
use super::{Cap, Local, Minorant};
use crate::geom::{Angle, Mat3, Vec3};

/// A facet that hangs everywhere on the cap costs `-A n.d (b - v).d` at least, whatever the corner `v` (the lowest gives
/// the most); so all of them cost at least one quadratic form `d'Bd`. Facets that hang on a part of the cap only are
/// left out, for none costs less than nothing.
///
/// Along a great circle `(d'Bd)'' = 2 (t'Bt - d'Bd)`; its derivative is `-8 d'Bt`, at least `-4` times the spread of the
/// eigenvalues, which bounds it from its least value at the centre.
#[derive(Clone)]
pub(crate) struct Columns<'a> {
    facets: &'a Facets,
    normals: &'a Normals,
    middle: Vec3,
    /// `-n.d` from which a facet needs support.
    from: f64,
    cap: Cap,
    /// Of the facets that hang everywhere on the cap: `-sum n m'` with the moments `m` about the middle, and `sum A n`.
    form: Mat3,
    area: Vec3,
    /// Facets that hang on a part of the cap.
    open: Arc<Vec<u32>>,
}

impl<'a> Columns<'a> {
    pub(crate) fn of(facets: &'a Facets, overhang: Angle) -> Self {
        let normals = facets.normals();
        let open = Arc::new((0..normals.units.len() as u32).collect());
        let (form, area, from) = (Mat3::zeros(), Vec3::zeros(), overhang.rad().sin());
        Self { facets, normals, middle: facets.middle(), from, cap: Cap::WHOLE, form, area, open }
    }

    fn narrowed(&self, cap: &Cap) -> Self {
        let angle = self.from.acos();
        let always = if angle > cap.radius { (angle - cap.radius - 1e-9).cos() } else { f64::INFINITY };
        let never = (angle + cap.radius + 1e-9).min(std::f64::consts::PI).cos();
        let (mut form, mut area, mut open) = (self.form, self.area, Vec::new());
        for &i in self.open.iter() {
            let (n, a) = (&self.normals.units[i as usize], self.normals.areas[i as usize]);
            let down = -n.dot(&cap.centre);
            if down >= always {
                form -= n * (self.normals.moments[i as usize] - self.middle * a).transpose();
                area += n * a;
            } else if down >= never {
                open.push(i);
            }
        }
        Self { cap: *cap, form, area, open: Arc::new(open), ..*self }
    }
}

impl<'a> Local<'a> for Columns<'a> {
    fn within(&self, cap: &Cap) -> Box<dyn Local<'a> + 'a> {
        Box::new(self.narrowed(cap))
    }

    fn estimate(&self) -> f64 {
        let (c, v) = (&self.cap.centre, self.facets.lowest(&self.cap.centre));
        let hanging = self.open.iter().map(|&i| {
            let i = i as usize;
            let (along, area) = (self.normals.units[i].dot(c), self.normals.areas[i]);
            if -along > self.from { -along * (self.normals.moments[i] - v * area).dot(c) } else { 0.0 }
        });
        (self.form * c).dot(c) + self.area.dot(c) * (v - self.middle).dot(c) + hanging.sum::<f64>()
    }

    fn minorant(&self, e: &Vec3) -> Minorant {
        let v = self.facets.lowest(e) - self.middle;
        quadratic(&(self.form + self.area * v.transpose()), &self.cap)
    }
}
