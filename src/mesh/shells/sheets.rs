//! Facets that enclose nothing: walls that hang in or on a solid, and loose sheets.

use std::collections::HashMap;

use super::{Surface, holes, shells};
use crate::geom::Vec3;
use crate::mesh::error::Places;

/// Of the whole surface no more may go.
const MOST_AREA: f64 = 0.2;
/// What ends in the open along sides of length `l` is no larger than this, in `l²`: the rest of a solid with a hole in it is.
const IN_THE_OPEN: f64 = 0.5;

/// What was removed.
#[derive(Debug, Default)]
pub(super) struct Removed {
    pub(super) facets: usize,
    /// The middle of each piece.
    pub(super) places: Places,
}

fn edge(a: u32, b: u32) -> (u32, u32) {
    (a.min(b), a.max(b))
}

fn sides(facet: &[u32; 3]) -> [(u32, u32); 3] {
    let [a, b, c] = *facet;
    [edge(a, b), edge(b, c), edge(c, a)]
}

fn area(vertices: &[Vec3], facet: &[u32; 3]) -> f64 {
    let [a, b, c] = facet.map(|index| vertices[index as usize]);
    0.5 * (b - a).cross(&(c - a)).norm()
}

fn middle(vertices: &[Vec3], facet: &[u32; 3]) -> Vec3 {
    facet.iter().map(|&index| vertices[index as usize]).sum::<Vec3>() / 3.0
}

/// Area of a surface with what is sound beside it.
fn area_of_all(vertices: &[Vec3], surface: &Surface, sound: &[Surface]) -> f64 {
    let all = sound.iter().flat_map(|one| &one.facets).chain(&surface.facets);
    all.map(|facet| area(vertices, facet)).sum()
}

/// How many facets use each edge of `surface`, those of `sound` among them.
fn uses(surface: &Surface, sound: &[Surface]) -> HashMap<(u32, u32), u32> {
    let mut uses: HashMap<(u32, u32), u32> = HashMap::with_capacity(2 * surface.facets.len());
    surface.facets.iter().flat_map(sides).for_each(|side| *uses.entry(side).or_insert(0) += 1);
    for side in sound.iter().flat_map(|one| &one.facets).flat_map(sides) {
        uses.entry(side).and_modify(|count| *count += 1);
    }
    uses
}

/// Removes the later one of two facets with the same corners, however they turn, where an odd number of facets meets at each of their sides: two
/// solids that share a face have two facets more there.
pub(super) fn drop_opposites(surface: &mut Surface, sound: &[Surface]) -> usize {
    let uses = uses(surface, sound);
    let is_odd = |facet: &[u32; 3]| sides(facet).iter().all(|side| uses[side] % 2 == 1 && uses[side] > 1);
    let given = surface.facets.len();
    let mut seen = std::collections::HashSet::new();
    surface.retain(|facet| {
        let mut corners = *facet;
        corners.sort_unstable();
        !is_odd(facet) || seen.insert(corners)
    });
    given - surface.facets.len()
}

/// Removes what hangs on sides at which an odd number of facets meets, and ends in the open: a wall inside a solid from an edge to the middle, a fin.
pub(super) fn drop_hanging(vertices: &[Vec3], surface: &mut Surface, sound: &[Surface]) -> Removed {
    let mut removed = Removed::default();
    let mut left = MOST_AREA * area_of_all(vertices, surface, sound);
    // What hangs on something that hangs goes next.
    for _ in 0..4 {
        let uses = uses(surface, sound);
        let pieces = pieces(surface, &uses);
        let mut hanging: Vec<(f64, Vec<u32>)> = Vec::new();
        for piece in pieces {
            let (mut own, mut open, mut is_hung) = (0.0, 0.0, false);
            for &index in &piece {
                let facet = &surface.facets[index as usize];
                own += area(vertices, facet);
                for (a, b) in sides(facet) {
                    match uses[&(a, b)] {
                        1 => open += (vertices[a as usize] - vertices[b as usize]).norm(),
                        count => is_hung |= count % 2 == 1,
                    }
                }
            }
            if is_hung && open > 0.0 && own <= IN_THE_OPEN * open * open {
                hanging.push((own, piece));
            }
        }
        hanging.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut goes = vec![false; surface.facets.len()];
        let before = removed.facets;
        for (own, piece) in hanging {
            if own > left {
                break;
            }
            left -= own;
            removed.facets += piece.len();
            removed.places.add(middle(vertices, &surface.facets[piece[0] as usize]));
            piece.iter().for_each(|&index| goes[index as usize] = true);
        }
        if removed.facets == before {
            break;
        }
        let mut goes = goes.into_iter();
        surface.retain(|_| !goes.next().unwrap_or(false));
    }
    removed
}

/// Facets that hang together across sides at which exactly two of them meet.
fn pieces(surface: &Surface, uses: &HashMap<(u32, u32), u32>) -> Vec<Vec<u32>> {
    let mut across: HashMap<(u32, u32), [u32; 2]> = HashMap::new();
    for (index, facet) in (0_u32..).zip(&surface.facets) {
        for side in sides(facet).into_iter().filter(|side| uses[side] == 2) {
            across.entry(side).and_modify(|both| both[1] = index).or_insert([index; 2]);
        }
    }
    let mut seen = vec![false; surface.facets.len()];
    let mut pieces = Vec::new();
    for first in 0..surface.facets.len() as u32 {
        if std::mem::replace(&mut seen[first as usize], true) {
            continue;
        }
        let mut piece = vec![first];
        let mut next = 0;
        while let Some(&index) = piece.get(next) {
            next += 1;
            for both in sides(&surface.facets[index as usize]).iter().filter_map(|side| across.get(side)) {
                for &other in both {
                    if !std::mem::replace(&mut seen[other as usize], true) {
                        piece.push(other);
                    }
                }
            }
        }
        piece.sort_unstable();
        pieces.push(piece);
    }
    pieces
}

/// Whether an open shell encloses nothing: on the mean it is thinner than `thin`, file units, once its holes are closed.
pub(super) fn is_sheet(vertices: &[Vec3], facets: &[[u32; 3]], open: &[[u32; 2]], thin: f64) -> bool {
    let all: f64 = facets.iter().map(|facet| area(vertices, facet)).sum();
    2.0 * closed_volume(vertices, facets, open).abs() < thin * all
}

/// The volume of an open shell whose holes are closed by cones from their middles.
pub(super) fn closed_volume(vertices: &[Vec3], facets: &[[u32; 3]], open: &[[u32; 2]]) -> f64 {
    let Some(&[first, ..]) = facets.first() else { return 0.0 };
    let origin = vertices[first as usize];
    let cone = |a: Vec3, b: Vec3, c: Vec3| (a - origin).dot(&(b - origin).cross(&(c - origin))) / 6.0;
    let own: f64 = facets.iter().map(|f| f.map(|index| vertices[index as usize])).map(|[a, b, c]| cone(a, b, c)).sum();
    let lids = holes::borders(open).into_iter().map(|border| {
        let tip = holes::middle(vertices, &border);
        border.iter().map(|&[a, b]| cone(vertices[b as usize], vertices[a as usize], tip)).sum::<f64>()
    });
    own + lids.sum::<f64>()
}

/// Removes open shells that enclose nothing, as far as they are a small share of the whole surface.
pub(super) fn drop_sheets(vertices: &[Vec3], surface: &mut Surface, sound: &[Surface], thin: f64) -> Removed {
    let mut removed = Removed::default();
    let mut loose: Vec<(f64, Vec<u32>)> = Vec::new();
    for shell in shells(vertices, &surface.facets).into_iter().filter(|shell| !shell.open.is_empty()) {
        let facets: Vec<[u32; 3]> = shell.facets.iter().map(|&index| surface.facets[index as usize]).collect();
        let own: f64 = facets.iter().map(|facet| area(vertices, facet)).sum();
        if is_sheet(vertices, &facets, &shell.open, thin) {
            loose.push((own, shell.facets));
        }
    }
    // Where there are many, they are what the surface is made of.
    if loose.iter().map(|one| one.0).sum::<f64>() > MOST_AREA * area_of_all(vertices, surface, sound) {
        return removed;
    }
    let mut goes = vec![false; surface.facets.len()];
    for (_, facets) in loose {
        removed.facets += facets.len();
        removed.places.add(middle(vertices, &surface.facets[facets[0] as usize]));
        facets.iter().for_each(|&index| goes[index as usize] = true);
    }
    let mut goes = goes.into_iter();
    surface.retain(|_| !goes.next().unwrap_or(false));
    removed
}
