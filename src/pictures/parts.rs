//! Parts as they stand on a bed: with what overhangs and what holds it, or in colours of their own.

use std::collections::HashSet;

use super::{KINDS, OVERHANG, PART, SUPPORT, TABLE};
use crate::geom::{Angle, Bounds, Object, Vec3, turned_by};
use crate::mesh::{TABLE_GAP_MM, TriangleMesh};
use crate::orient::{Facets, support_columns};
use crate::split::Split;
use crate::view::{Colour, Frame, Sheet, Side, Surface};

const FRAME: f64 = 420.0;
/// Columns of support across the part.
const COLUMNS: f64 = 70.0;
pub(crate) const SUPPORT_WORD: (Colour, &str) = (SUPPORT, "supports");

/// How facets are coloured.
#[derive(Clone, Copy)]
pub(crate) enum Painted<'a> {
    /// What faces down by more than this from the vertical, and is not on the bed.
    Overhangs(Angle),
    /// What each facet costs (Boogers (2024), figure 4.6): blue raises the sum, red lowers it, the more the deeper.
    Costs(&'a [f64], Angle),
}

impl Painted<'_> {
    fn angle(&self) -> Angle {
        let (Self::Overhangs(angle) | Self::Costs(_, angle)) = self;
        *angle
    }
}

/// A part with `up` upright on the bed: from above with supports as upright columns, from what overhangs down to the part or the bed; and
/// from below without them. An open mesh has no inside: what is drawn below it then is of no worth.
pub(crate) fn standing(facets: &Facets, up: &Vec3, painted: Painted<'_>, story: Vec<String>) -> Sheet {
    let turn = turned_by(up);
    let low = if facets.points.is_empty() { 0.0 } else { facets.lowest(up).dot(up) };
    let stand = |p: &Vec3| turn * p - Vec3::z() * low;
    let points: Vec<Vec3> = facets.points.iter().map(stand).collect();
    let from = painted.angle().rad().sin();
    let hangs = |i: usize| {
        let facet = &facets.each[i];
        -facet.area.dot(up) > from * facet.area.norm() && facet.barycentre.dot(up) - low > TABLE_GAP_MM
    };
    let marked: Vec<(usize, Colour)> = match painted {
        Painted::Overhangs(_) => (0..facets.each.len()).filter(|i| hangs(*i)).map(|i| (i, OVERHANG)).collect(),
        Painted::Costs(costs, _) => (0..facets.each.len()).map(|i| (i, cost_colour(costs, i, facets))).collect(),
    };
    let any = matches!(painted, Painted::Costs(..)) || !marked.is_empty();
    let part = Surface { marked, wanted: true, ..Surface::new(points.clone(), facets.corners.clone(), PART) };
    let bed = bed(&points);
    let width = (facets.reach() * 2.0 / COLUMNS).max(1e-9);
    let (wide, columns) = support_columns(facets, up, width, hangs);
    let columns: Vec<[Vec3; 2]> = columns.iter().map(|ends| ends.map(|p| stand(&p))).collect();
    let held = sticks(&columns, 0.5 * wide);
    let shot = |surfaces: Vec<Surface>, side: Side, caption: &str| Frame {
        scope: points.iter().chain(&bed.points).copied().collect(),
        surfaces,
        side,
        caption: vec![caption.to_owned()],
        ..Frame::default()
    };
    let mut frames = vec![shot(vec![bed.clone(), part.clone(), held], Side::Above, "from above")];
    if any {
        frames.push(shot(vec![bed.clone(), part], Side::Below, "from below, without supports"));
    }
    let legend = match painted {
        Painted::Overhangs(_) => vec![(OVERHANG, "overhangs"), SUPPORT_WORD],
        Painted::Costs(..) => vec![([80, 80, 235], "raises the objective"), ([235, 80, 80], "lowers it"), SUPPORT_WORD],
    };
    Sheet { title: "A part as it is printed".to_owned(), side: FRAME, columns: 2, frames, legend, story }
}

/// Parts with what else stands on their bed, each in its colour; the wanted ones are named.
pub(crate) fn solids(
    title: &str,
    solids: Vec<Surface>,
    legend: Vec<(Colour, &'static str)>,
    story: Vec<String>,
    both: bool,
) -> Sheet {
    let points: Vec<Vec3> = solids.iter().flat_map(|surface| surface.points.iter().copied()).collect();
    let bed = bed(&points);
    let scope: Vec<Vec3> = points.into_iter().chain(bed.points.iter().copied()).collect();
    let surfaces: Vec<Surface> = std::iter::once(bed).chain(solids).collect();
    let shot = |side: Side, caption: &str| Frame {
        surfaces: surfaces.clone(),
        scope: scope.clone(),
        side,
        caption: vec![caption.to_owned()],
        ..Frame::default()
    };
    let mut frames = vec![shot(Side::Above, if both { "from above" } else { "" })];
    if both {
        frames.push(shot(Side::Below, "from below"));
    }
    Sheet { title: title.to_owned(), side: FRAME, columns: 2, frames, legend, story }
}

/// A solid as it is with what overhangs, in parts that have colours and names, and the parts a little apart along the way that each is
/// printed.
pub(crate) fn cut_up(mesh: &TriangleMesh<Object>, angle: Angle, split: &Split, story: Vec<String>) -> Sheet {
    let low = mesh.bounds().min.z;
    let from = angle.rad().sin();
    let hangs = |&i: &usize| {
        let [a, b, c] = mesh.corners(i);
        let down = mesh.normal(i).is_some_and(|normal| -normal.z > from + 1e-6);
        down && a.z.max(b.z).max(c.z) - low > TABLE_GAP_MM
    };
    let marked: Vec<(usize, Colour)> = (0..mesh.facets().len()).filter(hangs).map(|i| (i, OVERHANG)).collect();
    let whole = Surface { marked, wanted: true, ..Surface::of(mesh, PART) };
    let colours: Vec<Colour> = KINDS.into_iter().filter(|colour| *colour != OVERHANG).collect();
    let in_colour = |id: usize| coloured(&split.parts[id].mesh, colours[id % colours.len()], Some(&split.piece(id)));
    let parts: Vec<Surface> = (0..split.parts.len()).map(in_colour).collect();
    let shifts = apart(split, 0.15 * mesh.bounds().size().norm());
    let moved = parts.iter().zip(&shifts).map(|(part, by)| {
        let points = part.points.iter().map(|p| p + by).collect();
        Surface { points, ..part.clone() }
    });
    let shot = |solids: Vec<Surface>, side: Side, caption: &str| {
        let points: Vec<Vec3> = solids.iter().flat_map(|surface| surface.points.iter().copied()).collect();
        let mut bed = bed(&points);
        // Models are drawn where their file has them.
        bed.points.iter_mut().for_each(|p| p.z = low);
        let scope = points.into_iter().chain(bed.points.iter().copied()).collect();
        let surfaces = std::iter::once(bed).chain(solids).collect();
        Frame { surfaces, scope, side, caption: vec![caption.to_owned()], ..Frame::default() }
    };
    let hanging = !whole.marked.is_empty();
    let side = if hanging { Side::Below } else { Side::Above };
    let mut frames = vec![shot(vec![whole], side, if hanging { "as it is, from below" } else { "as it is" })];
    let mut legend = if hanging { vec![(OVERHANG, "overhangs more than allowed")] } else { vec![] };
    if parts.len() > 1 {
        frames.push(shot(parts.clone(), Side::Above, "cut"));
        frames.push(shot(moved.collect(), Side::Above, "the parts, each moved along its build direction"));
        legend.push((colours[0], "stays on the table"));
    }
    Sheet { title: "A solid and its parts".to_owned(), side: FRAME, columns: 3, frames, legend, story }
}

/// By part: how far it is moved, so that each is `mm` from what it stands on. Both sides of a seam have its vertices bit for bit.
fn apart(split: &Split, mm: f64) -> Vec<Vec3> {
    let key = |v: &Vec3| [v.x, v.y, v.z].map(f64::to_bits);
    let corners: Vec<HashSet<[u64; 3]>> =
        split.parts.iter().map(|part| part.mesh.vertices().iter().map(key).collect()).collect();
    let mut shifts: Vec<Vec3> = Vec::new();
    for (id, part) in split.parts.iter().enumerate() {
        let shared = |&q: &usize| corners[id].intersection(&corners[q]).count();
        let below = (0..id).filter(|q| shared(q) > 0).max_by_key(shared);
        let own = if part.cut.is_some() { part.up * mm } else { Vec3::zeros() };
        shifts.push(below.map_or(Vec3::zeros(), |q| shifts[q]) + own);
    }
    shifts
}

/// Upright bars of a square cross-section over places in the frame of the picture.
fn sticks(columns: &[[Vec3; 2]], width: f64) -> Surface {
    let (mut points, mut facets) = (Vec::new(), Vec::new());
    let (x, y) = (Vec3::x() * 0.5 * width, Vec3::y() * 0.5 * width);
    for [low, high] in columns {
        let first = points.len() as u32;
        for end in [low, high] {
            points.extend([end - x - y, end + x - y, end + x + y, end - x + y]);
        }
        for k in 0..4 {
            let (a, b) = (first + k, first + (k + 1) % 4);
            facets.extend([[a, b, b + 4], [a, b + 4, a + 4]]);
        }
    }
    Surface { edges: false, ..Surface::new(points, facets, SUPPORT) }
}

/// A piece of bed somewhat larger than what stands on it; from below it hides nothing.
fn bed(points: &[Vec3]) -> Surface {
    let bounds = if points.is_empty() { Bounds::of([Vec3::zeros()]) } else { Bounds::of(points.iter().copied()) };
    let edge = 0.08 * bounds.size().norm() + 1.0;
    let [x0, y0, x1, y1] = [bounds.min.x - edge, bounds.min.y - edge, bounds.max.x + edge, bounds.max.y + edge];
    let corners = [[x0, y0], [x1, y0], [x1, y1], [x0, y1]].map(|[x, y]| Vec3::new(x, y, 0.0));
    Surface { front_only: true, ..Surface::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]], TABLE) }
}

/// Blue for a cost above 0, red for one below, white for none; per area, so that small facets are as deep as large ones.
fn cost_colour(costs: &[f64], i: usize, facets: &Facets) -> Colour {
    let by_area = |i: usize| costs.get(i).copied().unwrap_or(0.0) / facets.each[i].area.norm();
    let most = costs.iter().map(|c| c.abs()).sum::<f64>() / facets.sum(|f| f.area.norm()).max(f64::MIN_POSITIVE);
    let share = (by_area(i) / (4.0 * most).max(f64::MIN_POSITIVE)).clamp(-1.0, 1.0);
    // Few steps: neighbours of nearly the same cost are one patch on paper.
    let fade = (235.0 * (1.0 - (share.abs() * 12.0).round() / 12.0)) as u8;
    if share >= 0.0 { [fade, fade, 235] } else { [235, fade, fade] }
}

/// A mesh in a colour, to be seen and named where it has a name.
pub(crate) fn coloured<F>(mesh: &TriangleMesh<F>, colour: Colour, name: Option<&str>) -> Surface {
    Surface { name: name.map(str::to_owned), wanted: name.is_some(), ..Surface::of(mesh, colour) }
}
