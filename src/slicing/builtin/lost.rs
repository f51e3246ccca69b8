//! What a sliced part lacks, and whether that can be borne.

use super::Line;
use super::plan::PlannedLayer;
use super::region::{Region, Shape, area_mm2, mm};
use super::skins::Stack;
use super::walls::Walled;
use crate::slicing::{LeftOut, SliceError};

/// Area of a layer below which a loss is rounding, mm².
const WORTH_TELLING_MM2: f64 = 0.05;
/// More of a part's volume than this may not be missing: what is printed is another part.
pub(super) const MOST_LEFT_OUT: f64 = 0.05;

/// What stands on a layer of which nothing is printed may be left out with it up to this volume, mm³: the crumb above a neck, as where a
/// cut through a round part leaves a point.
const CRUMB_MM3: f64 = 1.0;

/// The layers that are printed: those up to a gap, where what stands above it is a crumb; else all.
pub(super) fn without_crumb(stack: &Stack<'_>, layers: &mut [PlannedLayer<'_>], line: &Line) -> usize {
    let first = layers.iter().position(|layer| !layer.islands.is_empty()).unwrap_or(0);
    let Some(gap) = (first..layers.len()).find(|&at| layers[at].islands.is_empty()) else { return layers.len() };
    let above_mm2: f64 = stack.outlines[gap..].iter().map(area_mm2).sum();
    if above_mm2 * line.height_mm > CRUMB_MM3 {
        return layers.len();
    }
    layers[gap..].iter_mut().for_each(|layer| layer.islands.clear());
    gap
}

/// What was left out, if anything worth telling; all of it from layer `end` on.
///
/// # Errors
///
/// More than [`MOST_LEFT_OUT`] of the volume, or a layer of which nothing is printed between others of which something is: what
/// stands above would be printed on air. At its bottom and top a part may end in a point.
pub(super) fn left_out(
    name: &str,
    stack: &Stack<'_>,
    walls: &[Vec<Walled>],
    layers: &[PlannedLayer<'_>],
    end: usize,
    line: &Line,
) -> Result<Option<LeftOut>, SliceError> {
    let (name, thinnest_mm) = (name.to_owned(), line.thinnest_mm());
    let top_mm = |at: usize| (at + 1) as f64 * line.height_mm;
    let printed: Vec<usize> = (0..layers.len()).filter(|&at| !layers[at].islands.is_empty()).collect();
    if let Some(pair) = printed.windows(2).find(|pair| pair[1] > pair[0] + 1) {
        let (z_mm, layers) = (top_mm(pair[0] + 1), pair[1] - pair[0] - 1);
        return Err(SliceError::LayerLeftOut { name, z_mm, layers, thinnest_mm });
    }
    let (mut area, mut lost, mut missing, mut largest) = (0.0, 0.0, 0, (0.0, [0.0; 3]));
    for at in 0..layers.len() {
        area += area_mm2(&stack.outlines[at]);
        let pieces: Vec<&Shape> = if at < end {
            walls[stack.same_as[at]].iter().flat_map(|island| &island.lost).collect()
        } else {
            stack.outlines[at].iter().collect()
        };
        let areas: Vec<(f64, [f64; 2])> = pieces.into_iter().map(|shape| measured(&vec![shape.clone()])).collect();
        let here: f64 = areas.iter().map(|(area, _)| area).sum();
        if here <= WORTH_TELLING_MM2 {
            continue;
        }
        (lost, missing) = (lost + here, missing + 1);
        for (area, [x, y]) in areas {
            if area > largest.0 {
                largest = (area, [x, y, top_mm(at)]);
            }
        }
    }
    if missing == 0 {
        return Ok(None);
    }
    let (volume_mm3, share) = (lost * line.height_mm, lost / area);
    let left = LeftOut { volume_mm3, share, layers: missing, at_mm: largest.1, thinnest_mm };
    if share > MOST_LEFT_OUT {
        return Err(SliceError::LeftOut { name, left, most: MOST_LEFT_OUT });
    }
    Ok(Some(left))
}

/// The area, mm², and the middle of the box around it, mm.
fn measured(region: &Region) -> (f64, [f64; 2]) {
    let points = region.iter().flatten().flatten();
    let (low, high) = points.fold(([i32::MAX; 2], [i32::MIN; 2]), |(low, high), p| {
        ([low[0].min(p.x), low[1].min(p.y)], [high[0].max(p.x), high[1].max(p.y)])
    });
    (area_mm2(region), [0, 1].map(|i| mm((f64::from(low[i]) + f64::from(high[i])) / 2.0)))
}
