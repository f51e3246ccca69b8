//! Small holes closed by fans: a scan with some open edges has an inside all the same.

use std::collections::BTreeMap;

use super::TriangleMesh;
use crate::geom::Vec3;

/// A mesh with its holes closed.
#[derive(Clone, Debug)]
pub struct Fanned<F> {
    /// The mesh, its own facets first.
    pub mesh: TriangleMesh<F>,
    /// How many holes were closed.
    pub holes: usize,
    /// What the fans have together, mm².
    pub area_mm2: f64,
}

/// `mesh` with a fan about its middle over every ring of open edges; a ring of three edges becomes one facet. `None` where open edges
/// make no rings, as where three facets share an edge.
///
/// A fan is a guess at what is missing: whoever uses one says how large it is ([`Fanned::area_mm2`]).
pub fn fanned<F>(mesh: &TriangleMesh<F>) -> Option<Fanned<F>> {
    let mut open = open_edges(mesh.facets());
    let (mut points, mut facets) = (mesh.vertices().to_vec(), mesh.facets().to_vec());
    let (mut holes, mut area_mm2) = (0, 0.0);
    while let Some((&start, _)) = open.iter().next() {
        let ring = ring(&mut open, start)?;
        let first = facets.len();
        if let [a, b, c] = ring[..] {
            facets.push([a, b, c]);
        } else {
            let middle = ring.iter().map(|&i| points[i as usize]).sum::<Vec3>() / ring.len() as f64;
            points.push(middle);
            let tip = points.len() as u32 - 1;
            facets.extend((0..ring.len()).map(|i| [ring[i], ring[(i + 1) % ring.len()], tip]));
        }
        holes += 1;
        area_mm2 += facets[first..].iter().map(|f| area(&points, f)).sum::<f64>();
    }
    Some(Fanned { mesh: TriangleMesh::new(points, facets), holes, area_mm2 })
}

fn area(points: &[Vec3], facet: &[u32; 3]) -> f64 {
    let [a, b, c] = facet.map(|i| points[i as usize]);
    (b - a).cross(&(c - a)).norm() / 2.0
}

/// The edges that a closing facet must have, from their first corner: those of facets without a neighbour, the other way round.
fn open_edges(facets: &[[u32; 3]]) -> BTreeMap<u32, Vec<u32>> {
    let mut count: BTreeMap<(u32, u32), i32> = BTreeMap::new();
    for facet in facets {
        for k in 0..3 {
            let (a, b) = (facet[k], facet[(k + 1) % 3]);
            *count.entry((a.min(b), a.max(b))).or_insert(0) += if a < b { 1 } else { -1 };
        }
    }
    let mut open: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for ((a, b), more) in count {
        for _ in 0..more.abs() {
            let (from, to) = if more > 0 { (b, a) } else { (a, b) };
            open.entry(from).or_default().push(to);
        }
    }
    open
}

/// Takes a ring of edges that begins at `start`; a corner that it comes to again ends it there, and what came before waits.
fn ring(open: &mut BTreeMap<u32, Vec<u32>>, start: u32) -> Option<Vec<u32>> {
    let mut way = vec![start];
    loop {
        let at = way[way.len() - 1];
        let next = open.get_mut(&at)?.pop()?;
        if open.get(&at).is_some_and(Vec::is_empty) {
            open.remove(&at);
        }
        if let Some(place) = way.iter().position(|&i| i == next) {
            // What led to the ring is open still.
            for pair in way[..=place].windows(2) {
                open.entry(pair[0]).or_default().push(pair[1]);
            }
            let ring = way.split_off(place);
            return (ring.len() > 2).then_some(ring);
        }
        way.push(next);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Object;

    /// A box of 2 x 3 x 4 mm without the facets of the numbers.
    fn without(gone: &[usize]) -> TriangleMesh<Object> {
        let corner = |i: usize| Vec3::new([0.0, 2.0][i & 1], [0.0, 3.0][i >> 1 & 1], [0.0, 4.0][i >> 2 & 1]);
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let all = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]);
        let kept = all.enumerate().filter(|(i, _)| !gone.contains(i)).map(|(_, f)| f);
        TriangleMesh::new((0..8).map(corner).collect(), kept.collect())
    }

    #[test]
    fn a_box_without_its_top_has_its_volume_again() {
        let closed = fanned(&without(&[2, 3])).unwrap();
        assert_eq!((closed.holes, closed.mesh.facets().len()), (1, 14));
        assert!((closed.mesh.volume() - 24.0).abs() < 1e-12 && (closed.area_mm2 - 6.0).abs() < 1e-12, "{closed:?}");
        let closed = fanned(&without(&[0, 2])).unwrap();
        assert_eq!((closed.holes, closed.mesh.facets().len()), (2, 12), "two triangles");
        assert!((closed.mesh.volume() - 24.0).abs() < 1e-12, "{closed:?}");
        assert_eq!(fanned(&without(&[])).unwrap().holes, 0);
    }
}
