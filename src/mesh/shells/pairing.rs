//! Which facet lies across each edge, also where more than two facets meet at one.

use std::f64::consts::TAU;

use crate::geom::Vec3;

/// The facet across an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::mesh) struct EdgeLink {
    pub(in crate::mesh) facet: u32,
    /// Whether both facets run along the edge in the same sense, so that one of them faces the wrong way.
    pub(in crate::mesh) twisted: bool,
}

/// Facets closer than this around an edge, in radians, count as lying upon each other and enclose nothing.
///
/// It covers the rounding of f32 corners where coincident faces are cut into triangles differently.
const SAME_ANGLE: f64 = 1e-4;

/// One facet's use of an edge.
#[derive(Clone, Copy)]
struct Use {
    /// The edge's higher vertex.
    high: u32,
    facet: u32,
    side: u8,
    /// Whether the facet runs from the lower to the higher vertex.
    forward: bool,
}

/// For every facet the links across its sides `0-1`, `1-2`, `2-0`; `None` at an open edge.
pub(in crate::mesh) fn pair_edges(vertices: &[Vec3], facets: &[[u32; 3]]) -> Vec<[Option<EdgeLink>; 3]> {
    // A word a side is sorted and not a `Use`: of a million facets that is the most that is held at once.
    let mut sides: Vec<u64> = Vec::with_capacity(3 * facets.len());
    for (facet, corners) in (0_u64..).zip(facets) {
        let low = |side: usize| u64::from(corners[side].min(corners[(side + 1) % 3]));
        sides.extend((0..3).map(|side| low(side) << 32 | (3 * facet + side as u64)));
    }
    sides.sort_unstable();
    let mut links = vec![[None; 3]; facets.len()];
    let mut uses = Vec::new();
    for from_one in sides.chunk_by(|a, b| a >> 32 == b >> 32) {
        let low = (from_one[0] >> 32) as u32;
        uses.clear();
        uses.extend(from_one.iter().map(|&side| use_of(facets, low, side as u32)));
        uses.sort_by_key(|one: &Use| one.high);
        for group in uses.chunk_by(|a, b| a.high == b.high) {
            match group {
                [a, b] => link(&mut links, a, b),
                [_] => {}
                many => {
                    let pairs = around(vertices, facets, low, many);
                    pairs.into_iter().for_each(|(a, b)| link(&mut links, &many[a], &many[b]));
                }
            }
        }
    }
    links
}

/// The use of an edge from vertex `low` that is side `side % 3` of facet `side / 3`.
fn use_of(facets: &[[u32; 3]], low: u32, side: u32) -> Use {
    let (facet, side) = (side / 3, (side % 3) as usize);
    let (a, b) = (facets[facet as usize][side], facets[facet as usize][(side + 1) % 3]);
    Use { high: a.max(b), facet, side: side as u8, forward: a == low }
}

fn link(links: &mut [[Option<EdgeLink>; 3]], a: &Use, b: &Use) {
    let twisted = a.forward == b.forward;
    links[a.facet as usize][usize::from(a.side)] = Some(EdgeLink { facet: b.facet, twisted });
    links[b.facet as usize][usize::from(b.side)] = Some(EdgeLink { facet: a.facet, twisted });
}

/// Pairs three or more facets around an edge so that each pair has material between its facets.
///
/// Seen along the edge from its lower vertex, the material behind a facet that runs along with the edge begins at its
/// own angle and goes backward to a facet that runs against it: the nearest such pair first. Leftovers stay open.
fn around(vertices: &[Vec3], facets: &[[u32; 3]], low: u32, uses: &[Use]) -> Vec<(usize, usize)> {
    let high = uses[0].high;
    let origin = vertices[low as usize];
    let along = (vertices[high as usize] - origin).normalize();
    let across = along.cross(&Vec3::ith(along.iamin(), 1.0)).normalize();
    let third = along.cross(&across);
    let angle = |one: &Use| {
        let apex = facets[one.facet as usize][(usize::from(one.side) + 2) % 3];
        let reach = vertices[apex as usize] - origin;
        reach.dot(&third).atan2(reach.dot(&across))
    };
    let angles: Vec<f64> = uses.iter().map(angle).collect();
    let mut gaps = Vec::new();
    for (f, _) in uses.iter().enumerate().filter(|(_, one)| one.forward) {
        for (b, _) in uses.iter().enumerate().filter(|(_, one)| !one.forward) {
            let gap = (angles[f] - angles[b]).rem_euclid(TAU);
            gaps.push((if gap < SAME_ANGLE { gap + TAU } else { gap }, f, b));
        }
    }
    gaps.sort_by(|one, other| one.0.total_cmp(&other.0).then((one.1, one.2).cmp(&(other.1, other.2))));
    let mut taken = vec![false; uses.len()];
    let mut pairs = Vec::new();
    for (_, f, b) in gaps {
        if !taken[f] && !taken[b] {
            (taken[f], taken[b]) = (true, true);
            pairs.push((f, b));
        }
    }
    pairs
}

#[cfg(test)]
mod tests {
    use super::{EdgeLink, pair_edges};
    use crate::geom::Vec3;

    /// Two wedges of a quarter turn along z that touch at the edge 0-1 only, or share the face 0-1-3 as well.
    fn wedges(second_from: u32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let vertices = vec![Vec3::zeros(), Vec3::z(), Vec3::x(), Vec3::y(), -Vec3::x(), -Vec3::y()];
        let wedge = |a: u32, b: u32| [[0, a, 1], [0, 1, b]];
        let facets = [wedge(2, 3), wedge(second_from, second_from + 1)].concat();
        (vertices, facets)
    }

    #[test]
    fn wedges_that_touch_at_an_edge_keep_to_themselves() {
        let (vertices, facets) = wedges(4);
        let links = pair_edges(&vertices, &facets);
        assert_eq!(links[0][2], Some(EdgeLink { facet: 1, twisted: false }));
        assert_eq!(links[2][2], Some(EdgeLink { facet: 3, twisted: false }));
    }

    #[test]
    fn wedges_that_share_a_face_keep_to_themselves() {
        let (vertices, facets) = wedges(3);
        let links = pair_edges(&vertices, &facets);
        assert_eq!(links[1][0], Some(EdgeLink { facet: 0, twisted: false }));
        assert_eq!(links[2][2], Some(EdgeLink { facet: 3, twisted: false }));
    }

    #[test]
    fn the_odd_facet_out_stays_open() {
        let (vertices, facets) = wedges(4);
        let links = pair_edges(&vertices, &facets[..3]);
        assert_eq!(links[0][2], Some(EdgeLink { facet: 1, twisted: false }));
        assert_eq!(links[2][2], None);
    }
}
