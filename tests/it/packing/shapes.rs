//! Models to be packed: a hollow boat with a cabin, and simple solids.

use trunnion::geom::{Object, Vec3};
use trunnion::mesh::TriangleMesh;

/// Cross-sections from stern to bow.
const STATIONS: usize = 24;
/// Points of a cross-section's outside, from rim to rim.
const RIBS: usize = 13;
/// How thick the hull is, mm.
const WALL_MM: f64 = 2.0;

/// A boat of 60 x 31 x 48 mm, low corner at the origin: a hull open at the top whose bow rakes forward, a cabin on four posts, and a chimney.
pub(super) fn boat() -> Vec<TriangleMesh<Object>> {
    let mut parts = vec![hull()];
    for (x, y) in [(20.0, 6.0), (20.0, 22.0), (38.0, 6.0), (38.0, 22.0)] {
        parts.push(block([x, y, 2.5], [x + 3.0, y + 3.0, 32.0]));
    }
    parts.push(block([18.0, 4.0, 32.0], [43.0, 27.0, 36.0]));
    parts.push(block([21.0, 12.0, 36.0], [28.0, 19.0, 48.0]));
    parts
}

/// A box from corner to corner, mm.
pub(super) fn block(low: [f64; 3], high: [f64; 3]) -> TriangleMesh<Object> {
    let corner = |i: usize| Vec3::from([0, 1, 2].map(|k| if i >> k & 1 == 1 { high[k] } else { low[k] }));
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let facets = quads.iter().flat_map(|&[a, b, c, d]: &[u32; 4]| [[a, b, c], [a, c, d]]).collect();
    TriangleMesh::new((0..8).map(corner).collect(), facets)
}

/// A ball of `radius` about the origin, mm: `around` times `rings` quads, triangles at the poles.
pub(super) fn ball(radius: f64, around: u32, rings: u32) -> TriangleMesh<Object> {
    use std::f64::consts::{PI, TAU};
    let mut vertices = vec![Vec3::new(0.0, 0.0, -radius)];
    for ring in 1..rings {
        let (s, c) = (PI * f64::from(ring) / f64::from(rings)).sin_cos();
        vertices.extend((0..around).map(|k| {
            let (y, x) = (TAU * f64::from(k) / f64::from(around)).sin_cos();
            Vec3::new(x * s, y * s, -c) * radius
        }));
    }
    vertices.push(Vec3::new(0.0, 0.0, radius));
    let (top, at) = (vertices.len() as u32 - 1, |ring: u32, k: u32| 1 + (ring - 1) * around + k % around);
    let mut facets = Vec::new();
    for k in 0..around {
        facets.extend([[0, at(1, k + 1), at(1, k)], [top, at(rings - 1, k), at(rings - 1, k + 1)]]);
        for ring in 1..rings - 1 {
            let [a, b, c, d] = [at(ring, k), at(ring, k + 1), at(ring + 1, k + 1), at(ring + 1, k)];
            facets.extend([[a, b, c], [a, c, d]]);
        }
    }
    TriangleMesh::new(vertices, facets)
}

/// The hull: a U-shaped ring at each station, lofted and closed at both ends.
fn hull() -> TriangleMesh<Object> {
    let mut vertices = Vec::new();
    for i in 0..STATIONS {
        let along = i as f64 / (STATIONS - 1) as f64;
        // Full at the stern, drawn together at the bow; the rim rises forward, and the bow leans out over the keel.
        let half =
            15.5 * (1.0 - 0.86 * along.powi(3)) * (0.75 + 0.25 * (std::f64::consts::PI * (along * 0.8 + 0.2)).sin());
        let rim = 12.0 + 8.0 * along * along;
        let point = |rib: usize, inset: f64| {
            let turn = std::f64::consts::PI * rib as f64 / (RIBS - 1) as f64;
            let (wide, down) = ((half - inset).max(0.4), turn.sin().powf(0.6));
            let z = rim - (rim - inset * 0.9) * down;
            let rake = (z / rim - 1.0) * 14.0 * along;
            Vec3::new(along * (60.0 - WALL_MM * 0.0) + rake, 15.5 - wide * turn.cos(), z)
        };
        vertices.extend((0..RIBS).map(|rib| point(rib, 0.0)));
        vertices.extend((0..RIBS).map(|rib| point(rib, WALL_MM)));
    }
    // Around the U: the outside from rim to rim, then the inside back.
    let around: Vec<u32> = (0..RIBS as u32).chain((RIBS as u32..2 * RIBS as u32).rev()).collect();
    let ring = 2 * RIBS as u32;
    let mut facets = Vec::new();
    for i in 0..STATIONS as u32 - 1 {
        for j in 0..around.len() {
            let (a, b) = (around[j], around[(j + 1) % around.len()]);
            let [p, q, r, s] = [i * ring + a, i * ring + b, (i + 1) * ring + b, (i + 1) * ring + a];
            facets.extend([[p, q, r], [p, r, s]]);
        }
    }
    let last = (STATIONS as u32 - 1) * ring;
    for j in 0..RIBS as u32 - 1 {
        let [a, b, c, d] = [j, j + 1, j + 1 + RIBS as u32, j + RIBS as u32];
        facets.extend([[a, c, b], [a, d, c]]);
        facets.extend([[last + a, last + b, last + c], [last + a, last + c, last + d]]);
    }
    let mesh = TriangleMesh::new(vertices, facets);
    if mesh.volume() > 0.0 {
        return mesh;
    }
    let turned = mesh.facets().iter().map(|&[a, b, c]| [a, c, b]).collect();
    TriangleMesh::new(mesh.vertices().to_vec(), turned)
}
