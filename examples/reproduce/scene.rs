//! Solids on paper, by the library's own drawings.

use trunnion::geom::Vec3;
use trunnion::mesh::TriangleMesh;
use trunnion::view::{Colour, Frame, Ghost, Sheet, Surface};

use super::chart::svg;

pub(crate) const GREY: Colour = [190, 197, 205];
pub(crate) const BLUE: Colour = [86, 150, 210];
pub(crate) const GREEN: Colour = [0, 158, 115];
pub(crate) const AMBER: Colour = [230, 159, 0];
pub(crate) const RED: Colour = [214, 69, 65];

/// A mesh in one colour, with a name or without.
pub(crate) fn solid<F>(mesh: &TriangleMesh<F>, colour: Colour, name: Option<&str>) -> Surface {
    Surface { wanted: true, name: name.map(str::to_owned), ..Surface::of(mesh, colour) }
}

/// A mesh of many facets, its facets coloured by what `of` says of each.
pub(crate) fn painted<F>(mesh: &TriangleMesh<F>, of: impl Fn(usize) -> Option<Colour>) -> Surface {
    let marked = (0..mesh.facets().len()).filter_map(|facet| Some((facet, of(facet)?))).collect();
    Surface { marked, wanted: true, edges: false, ..Surface::of(mesh, GREY) }
}

/// Red for what raises a sum, blue for what lowers it, paler the less of the most.
pub(crate) fn tint(share: f64) -> Colour {
    let full = if share < 0.0 { RED } else { [0, 90, 181] };
    let s = share.abs().min(1.0).sqrt();
    [0, 1, 2].map(|k| (f64::from(GREY[k]) + (f64::from(full[k]) - f64::from(GREY[k])) * s).round() as u8)
}

/// A picture of surfaces, with words below it.
pub(crate) fn frame(surfaces: Vec<Surface>, below: &str) -> Frame {
    let scope: Vec<Vec3> = surfaces.iter().flat_map(|surface| surface.points.iter().copied()).collect();
    Frame { surfaces, scope, caption: vec![below.to_owned()], ..Frame::default() }
}

/// A body that what is behind it shines through.
pub(crate) fn ghost(points: Vec<Vec3>, colour: Colour) -> Ghost {
    Ghost { points, colour }
}

/// Frames beside each other, on one scale.
pub(crate) fn sheet(title: &str, columns: usize, frames: Vec<Frame>, legend: Vec<(Colour, &'static str)>) -> String {
    let side = if frames.len() == 1 { 330.0 } else { 250.0 };
    let sheet = Sheet { title: title.to_owned(), side, columns, frames, legend, story: Vec::new() };
    svg(&sheet.drawing())
}
