//! What pictures are of: plans, reasons, parts and supports as frames for [`crate::view`], and the files they go to.

mod machine;
mod parts;
mod plan;
mod tower;

use crate::geom::Vec3;
use crate::planning::Workpiece;
use crate::view::{self, Colour, Surface};

pub(crate) use machine::from_the_side;
pub(crate) use parts::{Painted, SUPPORT_WORD, coloured, cut_up, solids, standing};
pub(crate) use plan::{Told, plan_sheet, reasons_sheet};
pub(crate) use tower::tower_sheet;

pub(crate) const TABLE: Colour = [214, 219, 226];
pub(crate) const BEFORE: Colour = [150, 160, 174];
pub(crate) const NEW: Colour = [240, 170, 60];
pub(crate) const STRUCK: Colour = [204, 121, 167];
pub(crate) const HEAD: Colour = [47, 62, 78];
pub(crate) const OVERHANG: Colour = [213, 94, 0];
pub(crate) const SUPPORT: Colour = [86, 180, 233];
pub(crate) const PART: Colour = [218, 212, 200];
/// Told apart by colour-blind people too (Okabe and Ito 2008).
pub(crate) const KINDS: [Colour; 6] =
    [[230, 159, 0], [86, 180, 233], [0, 158, 115], [240, 228, 66], [213, 94, 0], [204, 121, 167]];

/// The model on its table in small pictures, as comments for the head of its program; each part in a colour of its own.
pub(crate) fn thumbnails(workpiece: &Workpiece<'_>) -> String {
    let part = |(i, mesh)| Surface { edges: false, ..Surface::of(mesh, KINDS[i % KINDS.len()]) };
    view::thumbnails(&workpiece.parts.iter().enumerate().map(part).collect::<Vec<_>>())
}

/// The farthest place along Z; `None` of none.
fn highest<'a>(points: impl Iterator<Item = &'a Vec3>) -> Option<Vec3> {
    points.copied().max_by(|a, b| a.z.total_cmp(&b.z))
}
