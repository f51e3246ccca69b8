//! Meshes and a scanner of G-code for this room's tests.

use std::collections::BTreeMap;

use crate::geom::{Slot, Vec3};
use crate::mesh::TriangleMesh;

/// The block between two corners.
pub(super) fn block(min: [f64; 3], max: [f64; 3]) -> TriangleMesh<Slot> {
    let ring = [[min[0], min[1]], [max[0], min[1]], [max[0], max[1]], [min[0], max[1]]];
    prism(&ring, min[2], max[2])
}

/// The prism over a counter-clockwise convex ring, its ends fanned from the first corner.
pub(super) fn prism(ring: &[[f64; 2]], bottom: f64, top: f64) -> TriangleMesh<Slot> {
    frustum(ring, ring, bottom, top)
}

/// The solid between two convex rings of as many corners.
pub(super) fn frustum(low: &[[f64; 2]], high: &[[f64; 2]], bottom: f64, top: f64) -> TriangleMesh<Slot> {
    let n = low.len() as u32;
    let at = |ring: &[[f64; 2]], z: f64| ring.iter().map(|p| Vec3::new(p[0], p[1], z)).collect::<Vec<_>>();
    let vertices = [at(low, bottom), at(high, top)].concat();
    let mut facets = Vec::new();
    for i in 0..n {
        let j = (i + 1) % n;
        facets.extend([[i, j, n + j], [i, n + j, n + i]]);
    }
    for i in 1..n - 1 {
        facets.extend([[0, i + 1, i], [n, n + i, n + i + 1]]);
    }
    TriangleMesh::new(vertices, facets)
}

/// A regular ring of `count` corners around `(x, y)`.
pub(super) fn ring(x: f64, y: f64, radius: f64, count: u32) -> Vec<[f64; 2]> {
    let turn = std::f64::consts::TAU / f64::from(count);
    (0..count).map(|i| (f64::from(i) * turn).sin_cos()).map(|(s, c)| [x + radius * c, y + radius * s]).collect()
}

/// All facets of several meshes in one; nothing is welded.
pub(super) fn together(meshes: &[TriangleMesh<Slot>]) -> TriangleMesh<Slot> {
    let mut vertices = Vec::new();
    let mut facets = Vec::new();
    for mesh in meshes {
        let base = vertices.len() as u32;
        vertices.extend_from_slice(mesh.vertices());
        facets.extend(mesh.facets().iter().map(|f| f.map(|i| i + base)));
    }
    TriangleMesh::new(vertices, facets)
}

/// The same surface turned inside out.
pub(super) fn inside_out(mesh: &TriangleMesh<Slot>) -> TriangleMesh<Slot> {
    TriangleMesh::new(mesh.vertices().to_vec(), mesh.facets().iter().map(|f| [f[0], f[2], f[1]]).collect())
}

/// One extruding move.
#[derive(Clone, Debug)]
pub(super) struct Extrusion {
    pub(super) from: [f64; 3],
    pub(super) to: [f64; 3],
    pub(super) e: f64,
    pub(super) feed: f64,
    pub(super) kind: String,
    /// As it is stated, mm.
    pub(super) width: f64,
}

impl Extrusion {
    pub(super) fn length(&self) -> f64 {
        (self.to[0] - self.from[0]).hypot(self.to[1] - self.from[1])
    }
}

/// Every move with X or Y and E > 0 of relative-E G-code.
pub(super) fn extrusions(gcode: &[u8]) -> Vec<Extrusion> {
    let mut at = [f64::NAN; 3];
    let mut feed = 0.0;
    let mut kind = String::new();
    let mut width = f64::NAN;
    let mut found = Vec::new();
    for line in std::str::from_utf8(gcode).unwrap().lines() {
        if let Some(name) = line.strip_prefix(";TYPE:") {
            name.clone_into(&mut kind);
        }
        width = line.strip_prefix(";WIDTH:").map_or(width, |text| text.parse().unwrap());
        let Some(rest) = line.strip_prefix("G1 ") else { continue };
        let words = words(rest);
        let from = at;
        for (i, letter) in ['X', 'Y', 'Z'].into_iter().enumerate() {
            at[i] = words.get(&letter).copied().unwrap_or(at[i]);
        }
        feed = words.get(&'F').copied().unwrap_or(feed);
        let e = words.get(&'E').copied().unwrap_or(0.0);
        if e > 0.0 && (words.contains_key(&'X') || words.contains_key(&'Y')) {
            found.push(Extrusion { from, to: at, e, feed, kind: kind.clone(), width });
        }
    }
    found
}

fn words(text: &str) -> BTreeMap<char, f64> {
    let code = text.split(';').next().unwrap();
    code.split_whitespace().map(|word| (word.chars().next().unwrap(), word[1..].parse().unwrap())).collect()
}

/// `[x0, y0, z0, x1, y1, z1]` of the extruded lines' centres.
pub(super) fn extrusion_box(lines: &[Extrusion]) -> [f64; 6] {
    let mut all = [f64::INFINITY, f64::INFINITY, f64::INFINITY, -f64::INFINITY, -f64::INFINITY, -f64::INFINITY];
    for p in lines.iter().flat_map(|line| [line.from, line.to]) {
        for i in 0..3 {
            all[i] = all[i].min(p[i]);
            all[i + 3] = all[i + 3].max(p[i]);
        }
    }
    all
}

/// The distinct heights, ascending, in micrometres.
pub(super) fn layer_heights(lines: &[Extrusion]) -> Vec<i64> {
    let mut heights: Vec<i64> = lines.iter().map(|line| (line.to[2] * 1000.0).round() as i64).collect();
    heights.sort_unstable();
    heights.dedup();
    heights
}
