//! What of a surface wants support: facets, knife edges and lowest points (Leitereg (2020), section 3.1).
//!
//! Slot frame, mm. The overhang angle is counted from the vertical: a wall has 0, a ceiling 90 degrees.

use std::collections::HashMap;

use crate::geom::{Angle, Slot, Vec3};
use crate::mesh::TriangleMesh;

/// Parts of a surface that want support.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Demand {
    /// Facets that face down by more than the threshold.
    pub facets: Vec<usize>,
    /// Edges that face down although neither of their facets does by so much: both rise from the edge, and the edge
    /// itself is flatter than the threshold.
    pub edges: Vec<[u32; 2]>,
    /// Vertices lower than all their neighbours, with the material above them, none of whose facets is in `facets`.
    pub points: Vec<u32>,
}

impl Demand {
    /// What of a closed mesh, facing out of its material, wants support.
    pub fn of(mesh: &TriangleMesh<Slot>, overhang: Angle) -> Self {
        let steepest = overhang.rad().sin();
        let normals: Vec<Option<Vec3>> = (0..mesh.facets().len()).map(|i| mesh.normal(i)).collect();
        let hangs = |i: usize| normals[i].is_some_and(|n| n.z < -steepest);
        let facets: Vec<usize> = (0..normals.len()).filter(|&i| hangs(i)).collect();
        let mut held = vec![false; mesh.vertices().len()];
        facets.iter().flat_map(|&i| mesh.facets()[i]).for_each(|v| held[v as usize] = true);
        let edges = knife_edges(mesh, &normals, overhang, &hangs);
        let points = lowest(mesh).into_iter().filter(|&v| !held[v as usize]).collect();
        Self { facets, edges, points }
    }
}

/// Edges from which both facets rise, where neither hangs by itself; each once, in the order of the facets.
fn knife_edges(
    mesh: &TriangleMesh<Slot>,
    normals: &[Option<Vec3>],
    overhang: Angle,
    hangs: &dyn Fn(usize) -> bool,
) -> Vec<[u32; 2]> {
    let mut open: HashMap<[u32; 2], usize> = HashMap::new();
    let mut found = Vec::new();
    for (i, facet) in mesh.facets().iter().enumerate() {
        for k in 0..3 {
            let [a, b] = [facet[k], facet[(k + 1) % 3]];
            let Some(other) = open.remove(&[b, a]) else {
                open.insert([a, b], i);
                continue;
            };
            if let (Some(n), Some(m)) = (normals[i], normals[other])
                && !hangs(i)
                && !hangs(other)
                && is_knife(&(mesh.vertices()[b as usize] - mesh.vertices()[a as usize]), &n, &m, overhang)
            {
                found.push([a, b]);
            }
        }
    }
    found
}

/// Whether the edge along `along` (a side of the facet of normal `n`; the other facet's is `m`) is a ridge that looks down.
fn is_knife(along: &Vec3, n: &Vec3, m: &Vec3, overhang: Angle) -> bool {
    let length = along.norm();
    if length <= 0.0 || n.z >= 0.0 || m.z >= 0.0 || along.z.abs() >= length * overhang.rad().cos() {
        return false;
    }
    // Into each facet, at right angles to the edge; the second facet runs along the edge the other way.
    n.cross(along).z > 0.0 && -m.cross(along).z > 0.0
}

/// Vertices lower than every neighbour, below which there is no material: the normals around them, weighted by angle, look down.
fn lowest(mesh: &TriangleMesh<Slot>) -> Vec<u32> {
    let count = mesh.vertices().len();
    let (mut low, mut normal) = (vec![true; count], vec![Vec3::zeros(); count]);
    for (i, facet) in mesh.facets().iter().enumerate() {
        let corners = mesh.corners(i);
        let Some(n) = mesh.normal(i) else { continue };
        for k in 0..3 {
            let (at, next, last) = (corners[k], corners[(k + 1) % 3], corners[(k + 2) % 3]);
            let v = facet[k] as usize;
            low[v] &= at.z < next.z && at.z < last.z;
            normal[v] += n * (next - at).angle(&(last - at));
        }
    }
    (0..count as u32).filter(|&v| low[v as usize] && normal[v as usize].z < 0.0).collect()
}
