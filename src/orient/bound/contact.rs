//! `contact-area`: what may lie on the bed.

use std::sync::Arc;

use super::super::Facets;
use super::super::facets::FLAT;
use super::{Cap, Local, Minorant};
use crate::geom::Vec3;
use crate::mesh::TABLE_GAP_MM;

/// Minus the area of all facets that may lie flat on the bed somewhere on the cap: no direction lays down more.
///
/// A facet may not where it is turned away by more than the tolerance everywhere, or where its barycentre is higher than
/// the bed's gap above some corner everywhere.
#[derive(Clone)]
pub(crate) struct Lying<'a> {
    facets: &'a Facets,
    may: Arc<Vec<u32>>,
    area: f64,
    largest: Option<Vec3>,
}

impl<'a> Lying<'a> {
    pub(crate) fn of(facets: &'a Facets) -> Self {
        let area = facets.sum(|f| f.area.norm());
        Self { facets, may: Arc::new((0..facets.each.len() as u32).collect()), area, largest: None }
    }
}

impl<'a> Local<'a> for Lying<'a> {
    fn within(&self, cap: &Cap) -> Box<dyn Local<'a> + 'a> {
        let turned = (cap.radius + FLAT.acos() + 1e-9).min(std::f64::consts::PI).cos();
        let low = self.facets.lowest(&cap.centre);
        let (mut may, mut area, mut largest) = (Vec::new(), 0.0, (0.0, None));
        for &i in self.may.iter() {
            let facet = &self.facets.each[i as usize];
            let size = facet.area.norm();
            if -facet.area.dot(&cap.centre) < turned * size {
                continue;
            }
            if cap.range(&(facet.barycentre - low))[0] > TABLE_GAP_MM * (1.0 + 1e-9) {
                continue;
            }
            may.push(i);
            area += size;
            largest = if size > largest.0 { (size, Some(-facet.area / size)) } else { largest };
        }
        Box::new(Self { facets: self.facets, may: Arc::new(may), area: area * (1.0 + 1e-12), largest: largest.1 })
    }

    fn estimate(&self) -> f64 {
        0.0 - self.area
    }

    fn minorant(&self, _: &Vec3) -> Minorant {
        Minorant { value: 0.0 - self.area, ..Minorant::ZERO }
    }

    fn floor(&self) -> f64 {
        f64::NEG_INFINITY
    }

    fn hint(&self) -> Option<Vec3> {
        self.largest
    }
}
