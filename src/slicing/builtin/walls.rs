//! The walls of one island, and what they leave for infill.

use super::Line;
use super::region::{Contour, Region, Shape, area_mm2, grown, minus, perimeter_mm};

/// A closed line of extrusion.
pub(super) struct Loop {
    /// The line's centre.
    pub(super) points: Contour,
    /// 0 for the outer wall, growing inward.
    pub(super) depth: u32,
    /// Cross-section as a share of the full line's: below 1 where the region is too narrow for whole lines.
    pub(super) flow: f64,
}

/// One connected piece of a layer.
pub(super) struct Walled {
    /// Its walls; outer ones first.
    pub(super) loops: Vec<Loop>,
    /// What infill has to cover.
    pub(super) infill: Region,
    /// What is too narrow for any line.
    pub(super) lost: Region,
}

/// Regions narrower than this share of the line width cannot be printed.
pub(super) const NARROWEST: f64 = 0.6;

/// A wall may come as close to itself as this share of the spacing, as in PrusaSlicer.
const CLOSEST: f64 = 0.6;

/// The part of a narrow region that loops farther from its border must fill as well to be taken.
const KEPT: f64 = 0.97;

/// What is narrower than twice this is rounding, grid units: 20 micrometres.
const ROUNDING: i32 = 100;

/// Walls of a shape: the first half a line width inside its border, the others one spacing apart.
///
/// Where a wall does not fit, a loop with less flow fills what is wider than [`NARROWEST`] line widths.
pub(super) fn walled(shape: &Shape, line: &Line, walls: u32) -> Walled {
    let mut zone: Region = vec![shape.clone()];
    let mut found = Walled { loops: Vec::new(), infill: Region::new(), lost: Region::new() };
    if walls == 0 {
        found.infill = grown(&zone, (line.spacing - line.width) / 2);
        return found;
    }
    for depth in 0..walls {
        let inset = if depth == 0 { line.width / 2 } else { line.spacing / 2 };
        // A wall that would run closer to itself is left to `fill_narrow`: two whole lines there are too much.
        let closest = (CLOSEST / 2.0 * f64::from(line.spacing)) as i32;
        let centre = grown(&grown(&zone, -inset - closest), closest);
        fill_narrow(&minus(&zone, &grown(&centre, inset)), depth, line, &mut found);
        found.loops.extend(centre.iter().flatten().map(|ring| Loop { points: ring.clone(), depth, flow: 1.0 }));
        zone = grown(&centre, -line.spacing / 2);
    }
    found.infill = zone;
    found
}

/// Loops along regions that are too narrow for a whole line; their flow makes up exactly the region's area.
fn fill_narrow(narrow: &Region, depth: u32, line: &Line, found: &mut Walled) {
    let inset = (NARROWEST / 2.0 * f64::from(line.width)) as i32;
    for shape in narrow {
        let one = vec![shape.clone()];
        let mut filled = Filled::new(&one, inset, line);
        // Half of the lines' own width off the border, where that loses nothing: else they would stand out beyond it.
        let wide = (filled.flow.min(1.0) * f64::from(line.spacing)) as i32 + line.width - line.spacing;
        if wide / 2 > inset {
            let farther = Filled::new(&one, wide / 2, line);
            if farther.area_mm2 >= KEPT * filled.area_mm2 {
                filled = farther;
            }
        }
        // Shorter than a line is wide: a blob, not a line.
        let printed = filled.length_mm > line.width_mm;
        if printed {
            let rings = filled.centre.iter().flatten();
            found.loops.extend(rings.map(|ring| Loop { points: ring.clone(), depth, flow: filled.flow.min(1.0) }));
        }
        if depth == 0 {
            let lost = if printed { minus(&one, &grown(&filled.centre, filled.inset)) } else { one };
            found.lost.extend(lost.into_iter().filter(|shape| !grown(&vec![shape.clone()], -ROUNDING).is_empty()));
        }
    }
}

/// A narrow region with loops along its border.
struct Filled {
    centre: Region,
    /// How far that is from its border, grid units.
    inset: i32,
    /// What lies within reach of them, mm².
    area_mm2: f64,
    length_mm: f64,
    /// Of a whole line's cross-section.
    flow: f64,
}

impl Filled {
    fn new(one: &Region, inset: i32, line: &Line) -> Self {
        let centre = grown(one, -inset);
        let area_mm2 = area_mm2(&grown(&centre, inset));
        let length_mm: f64 = centre.iter().flatten().map(|ring| perimeter_mm(ring)).sum();
        Self { centre, inset, area_mm2, length_mm, flow: area_mm2 / (length_mm * line.spacing_mm) }
    }
}
