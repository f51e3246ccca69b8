//! What every cut must keep, whatever it gains: what is left stands on the table, nothing is too small to print or too thin to
//! last, and the caps keep out of what the user wants whole.

use super::clip::{Clipped, ON_PLANE_MM};
use super::measure::{MeasureRules, Measured, PieceNeeds};
use super::surface::{Plane, Surface};
use crate::geom::{Bounds, Vec3};

/// The least patch of a cap, mm²: some twenty beads wide either way it would hold nothing.
const PATCH_MM2: f64 = 9.0;
/// The least piece, mm³.
const PIECE_MM3: f64 = 20.0;
/// Pieces smaller than this are the rounding of a cut and are dropped, mm³.
pub(super) const CRUMB_MM3: f64 = 1e-2;
/// The least height of a piece along its direction, and the least thickness of a plate, mm.
pub(super) const THICK_MM: f64 = 1.0;
/// What may be thinner than that, mm².
const THIN_MM2: f64 = 5.0;
/// Facets within this cosine of the plane's normal are parallel to it.
const PARALLEL: f64 = 0.9;

/// Why a cut may not be made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Against {
    /// The surface crosses itself in the plane.
    Crossing,
    /// A patch of the seam, or a piece, is too small to print.
    Small,
    /// A part of what is left would not stand on the table.
    Footing,
    /// A plate along the seam would be too thin.
    Thin,
    /// The seam comes where none is wanted.
    Unwanted,
    /// A piece would begin in the air, or have a ridge too flat to print.
    Beginning,
    /// The head would meet what is left, the table or the frame, or an axis would leave its stops.
    Head,
    /// Measured on the real cut it gains nothing.
    Gain,
    /// With it the cuts would cost more than they may: another way to print the model is nearly as cheap.
    Budget,
    /// Nothing lies beyond the plane, or nothing where a point says.
    Nothing,
}

/// A cut that may be made.
pub(super) struct CutParts {
    pub(super) rest: Measured,
    pub(super) pieces: Vec<Surface>,
    /// By piece, along the plane's normal.
    pub(super) needs: Vec<PieceNeeds>,
    /// Whether the cut made a place of a piece that planning would take for a lowest one.
    pub(super) falls: bool,
    pub(super) seam_mm2: f64,
    /// What was dropped as a crumb, mm³.
    pub(super) crumbs_mm3: f64,
}

/// The cut with the cap of number `cap`, if it keeps the rules.
pub(super) fn kept(
    cut: Clipped,
    plane: &Plane,
    cap: u32,
    rules: &MeasureRules,
    no_cut: &[Bounds],
) -> Result<CutParts, Against> {
    if cut.pieces.is_empty() || cut.patches_mm2.iter().any(|&area| area < PATCH_MM2) {
        return Err(Against::Small);
    }
    let (mut pieces, mut crumbs_mm3) = (Vec::new(), 0.0);
    for piece in cut.pieces {
        let volume = piece.volume();
        if volume.abs() < CRUMB_MM3 {
            crumbs_mm3 += volume;
            continue;
        }
        let height = piece.vertices.iter().map(|v| plane.height(v)).fold(0.0, f64::max);
        let stands = piece.source.contains(&cap);
        if volume < PIECE_MM3 || height < THICK_MM || !stands {
            return Err(Against::Small);
        }
        pieces.push(piece);
    }
    if pieces.is_empty() || cut.rest.facets.is_empty() {
        return Err(Against::Small);
    }
    // Before anything is measured: most cuts that are turned down are for this.
    if thin(&cut.rest, &pieces, plane, cap) {
        return Err(Against::Thin);
    }
    let pieces: Vec<Measured> = pieces.into_iter().map(|piece| Measured::of(piece, rules)).collect();
    if !pieces.iter().all(|piece| piece.is_closed()) {
        return Err(Against::Crossing);
    }
    let rest = Measured::of(cut.rest, rules);
    if !rest.is_closed() {
        return Err(Against::Crossing);
    }
    if !stands(&rest) {
        return Err(Against::Footing);
    }
    if meets(&rest.surface, cap, no_cut) {
        return Err(Against::Unwanted);
    }
    let needs = pieces.iter().map(|p| p.needs(&plane.normal, Some(cap), rules)).collect();
    let falls = rules.faults && pieces.iter().any(|p| p.has_false_bottom(&plane.normal, Some(cap)));
    let pieces = pieces.into_iter().map(|p| p.surface).collect();
    Ok(CutParts { rest, pieces, needs, falls, seam_mm2: cut.patches_mm2.iter().sum(), crumbs_mm3 })
}

/// Whether every solid of `rest` stands on the table.
fn stands(rest: &Measured) -> bool {
    let (shells, count) = rest.surface.shells();
    let (mut volume, mut standing) = (vec![0.0; count], vec![false; count]);
    let origin = rest.surface.vertices[0];
    for (facet, &shell) in shells.iter().enumerate() {
        let [a, b, c] = rest.surface.corners(facet).map(|p| p - origin);
        volume[shell as usize] += a.dot(&b.cross(&c)) / 6.0;
        standing[shell as usize] |= rest.on_table[facet];
    }
    // A shell that faces inward is a cavity of another.
    (0..count).all(|shell| standing[shell] || volume[shell] < 0.0)
}

/// Whether the cut leaves a plate along its plane that is too thin to last, on either side.
fn thin(rest: &Surface, pieces: &[Surface], plane: &Plane, cap: u32) -> bool {
    let seam = rest.source.iter().enumerate().filter(|(_, s)| **s == cap);
    let seam = Bounds::of(seam.flat_map(|(f, _)| rest.corners(f))).inflated(THICK_MM);
    let plate = |part: &Surface, side: f64| -> f64 {
        let near = |f: usize| {
            let middle = part.corners(f).iter().sum::<Vec3>() / 3.0;
            let height = side * plane.height(&middle);
            if height <= 10.0 * ON_PLANE_MM || height >= THICK_MM || !seam.holds(&middle) {
                return None;
            }
            let doubled = part.area_vector(f);
            let area = doubled.norm();
            (doubled.dot(&plane.normal) * side > PARALLEL * area).then_some(area / 2.0)
        };
        (0..part.facets.len()).filter_map(near).sum()
    };
    plate(rest, -1.0) > THIN_MM2 || pieces.iter().any(|piece| plate(piece, 1.0) > THIN_MM2)
}

/// Whether the cap of number `cap` comes into one of `boxes`.
fn meets(surface: &Surface, cap: u32, boxes: &[Bounds]) -> bool {
    let caps = || (0..surface.facets.len()).filter(|&f| surface.source[f] == cap);
    boxes.iter().any(|b| caps().any(|f| enters(&surface.corners(f), b)))
}

/// Whether a triangle comes into a box: what is left of it between the box's planes, one after the other.
fn enters(corners: &[Vec3; 3], bounds: &Bounds) -> bool {
    let mut polygon = corners.to_vec();
    for axis in 0..3 {
        for (sign, limit) in [(1.0, bounds.max[axis]), (-1.0, -bounds.min[axis])] {
            let beyond = |p: &Vec3| sign * p[axis] - limit;
            let mut left = Vec::new();
            for (i, p) in polygon.iter().enumerate() {
                let q = polygon[(i + 1) % polygon.len()];
                let (a, b) = (beyond(p), beyond(&q));
                if a <= 0.0 {
                    left.push(*p);
                }
                if (a < 0.0 && b > 0.0) || (a > 0.0 && b < 0.0) {
                    left.push(p + (q - p) * (a / (a - b)));
                }
            }
            polygon = left;
        }
    }
    !polygon.is_empty()
}

/// The solids of a surface, cavities with the solid around them, in the order of their first facets.
pub(super) fn solids(surface: &Surface) -> Vec<Surface> {
    let (shells, count) = surface.shells();
    let mut all: Vec<Vec<usize>> = vec![Vec::new(); count];
    shells.iter().enumerate().for_each(|(facet, &shell)| all[shell as usize].push(facet));
    let (mut outer, mut inner): (Vec<Vec<usize>>, Vec<Vec<usize>>) = (Vec::new(), Vec::new());
    for shell in all {
        if surface.select(shell.iter().copied()).volume() < 0.0 { inner.push(shell) } else { outer.push(shell) }
    }
    let bare: Vec<Surface> = outer.iter().map(|shell| surface.select(shell.iter().copied())).collect();
    for cavity in inner {
        let at = surface.vertices[surface.facets[cavity[0]][0] as usize];
        let around = (0..bare.len()).max_by(|&a, &b| bare[a].winding(&at).total_cmp(&bare[b].winding(&at)));
        if let Some(around) = around {
            outer[around].extend(cavity);
        }
    }
    outer.into_iter().map(|shell| surface.select(shell.into_iter())).collect()
}
