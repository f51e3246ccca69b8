//! What carries supports on large parts: from columns instead of connectivity sets.

use super::super::Facets;
use super::super::column::Raster;
use super::{Masks, Supported};
use crate::geom::Vec3;

/// From so many facets on, connectivity sets (0.05 F² pairs) are not worked out.
pub const FIELD_FACETS: usize = 20_001;

/// For each facet the area across the direction of the columns that begin on it below a hanging facet, weighted by how
/// much that one hangs, mm²: what `U_i W_i A_i n.d` stands for. Small facets that no column's middle meets have none, their
/// neighbours the more.
pub(super) fn carried(objective: &Supported, facets: &Facets, masks: &Masks, up: &Vec3) -> Vec<f64> {
    let raster = Raster::of(facets, up, objective.resolution_mm);
    let mut carried = vec![0.0; facets.each.len()];
    for gap in raster.gaps() {
        if let Some(below) = gap.below {
            carried[below as usize] += masks[gap.above as usize][0] * raster.width * raster.width;
        }
    }
    carried
}
