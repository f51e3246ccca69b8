//! `support-volume-column`: the true volume of supports that stand straight below what overhangs, the honest judge of all
//! other support objectives.

mod bare;
mod below;
mod bound;
mod raster;
#[cfg(test)]
mod tests;

pub(crate) use raster::Raster;

use super::{Facets, Local, Objective, Proof};
use crate::geom::{Angle, Vec3};

/// The volume between every surface point that overhangs and what lies below it, the part itself or the bed, mm³.
///
/// Columns of `resolution_mm` along the build direction, each cut at its middle: exact for each column, and as exact as
/// the middles say for the whole (the error is at most about the columns that an outline runs through, and falls with
/// the resolution). Corners are rounded to 1/256 of a column across the direction. For a part longer than 4096
/// columns, columns are 1/4096 of it. Meshes must be closed: a column that enters material must leave it.
#[derive(Clone, Copy, Debug)]
pub struct SupportVolumeColumn {
    /// Surfaces up to this angle from the vertical need no support; at 0 all that face down do.
    pub overhang: Angle,
    /// Width of a column, mm.
    pub resolution_mm: f64,
}

/// Parts of more facets than this have no lower bound: each of its thousands of steps would take a second.
pub const BOUNDED_FACETS: usize = 200_000;

impl Objective for SupportVolumeColumn {
    fn name(&self) -> &str {
        "support-volume-column"
    }

    fn value(&self, facets: &Facets, up: &Vec3) -> f64 {
        let raster = Raster::of(facets, up, self.resolution_mm);
        let from = self.overhang.rad().sin();
        let hangs: Vec<bool> = facets.each.iter().map(|f| -f.area.dot(up) > from * f.area.norm()).collect();
        let gaps = raster.gaps().filter(|gap| hangs[gap.above as usize]);
        let length: f64 = gaps.map(|gap| gap.to - gap.from).sum();
        length * raster.width * raster.width
    }

    fn proof(&self) -> Proof {
        Proof { gap: 1e-2, budget: 6_000 }
    }

    fn needs_closed(&self) -> bool {
        true
    }

    fn tie(&self, facets: &Facets) -> f64 {
        facets.mass().support_tie_mm3()
    }

    fn gradient(&self, _: &Facets, _: &Vec3) -> Option<Vec3> {
        None
    }

    fn local<'a>(&'a self, facets: &'a Facets) -> Option<Box<dyn Local<'a> + 'a>> {
        (facets.each.len() <= BOUNDED_FACETS)
            .then(|| Box::new(bound::Free::of(self, facets)) as Box<dyn Local<'a> + 'a>)
    }
}

/// Upright columns of support along `up`, from facets that `hangs` names down to the part or the bed: their width (mm, `width_mm` unless
/// that would make more than 4096) and the lower and upper end of each, the part's frame.
pub fn support_columns(
    facets: &Facets,
    up: &Vec3,
    width_mm: f64,
    hangs: impl Fn(usize) -> bool,
) -> (f64, Vec<[Vec3; 2]>) {
    let raster = Raster::of(facets, up, width_mm);
    let gaps = raster.gaps().filter(|gap| hangs(gap.above as usize));
    let ends = gaps.map(|gap| [gap.from, gap.to].map(|z| raster.point(gap.column, z))).collect();
    (raster.width, ends)
}
