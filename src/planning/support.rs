//! Whether a part, printed along a direction, stands on something everywhere.
//!
//! Two things are asked. Every facet that overhangs beyond the threshold must lie on the table or on an earlier part;
//! and every place where the part *begins* (a lowest point of its surface) must do so too, since steep walls that
//! meet in a point overhang nowhere and still begin in the air.
//!
//! Angles from the vertical: a wall is 0, a ceiling 90 (PrusaSlicer counts from the horizontal).

use super::part_set::PartSet;
use super::workpiece::Workpiece;
use crate::geom::{Angle, Dir, Table, Vec3};
use crate::mesh::TriangleMesh;

/// What one part needs below it at one direction.
#[derive(Clone, Debug)]
pub(super) struct Needs {
    /// Overhanging area that neither the table nor anything else can carry or that neighbours must carry, mm².
    overhang_mm2: f64,
    /// What each neighbour carries of it: part, mm².
    carried: Vec<(usize, f64)>,
    /// For each beginning that does not stand on the table: the parts it may stand on.
    beginnings: Vec<PartSet>,
}

/// Overhang that is let pass: f32 files do not close to the last square millimetre.
const SLACK_MM2: f64 = 0.5;
/// Facets within this many degrees of the threshold still count as below it.
const ANGLE_SLACK_DEG: f64 = 0.5;
/// Heights nearer than this are one, mm: twice the last digit of an f32 file at 1 m.
const SAME_HEIGHT: f64 = 2e-4;
/// A facet this near to the table's surface lies on it, mm.
const ON_TABLE: f64 = 0.05;

impl Needs {
    /// A part that needs a support nothing gives.
    #[cfg(test)]
    pub(super) fn support() -> Self {
        Self { overhang_mm2: 100.0, carried: Vec::new(), beginnings: Vec::new() }
    }

    /// A part that only `other` carries.
    #[cfg(test)]
    pub(super) fn carried_by(other: usize) -> Self {
        Self { overhang_mm2: 100.0, carried: vec![(other, 100.0)], beginnings: Vec::new() }
    }

    /// A part that stands anywhere.
    pub(super) fn none() -> Self {
        Self { overhang_mm2: 0.0, carried: Vec::new(), beginnings: Vec::new() }
    }

    /// The parts it may have to wait for, ascending.
    pub(super) fn carriers(&self) -> Vec<usize> {
        let below = self.beginnings.iter().flat_map(PartSet::iter);
        let mut parts: Vec<usize> = self.carried.iter().map(|(q, _)| *q).chain(below).collect();
        parts.sort_unstable();
        parts.dedup();
        parts
    }

    /// The overhang that nothing in `printed` carries, mm²; 0 within the slack.
    pub(super) fn missing(&self, printed: &PartSet) -> f64 {
        let carried: f64 = self.carried.iter().filter(|(q, _)| printed.has(*q)).map(|(_, area)| area).sum();
        let missing = self.overhang_mm2 - carried;
        if missing > SLACK_MM2 { missing } else { 0.0 }
    }

    /// Whether every beginning stands on the table or on a part of `printed`.
    pub(super) fn begins_on(&self, printed: &PartSet) -> bool {
        self.beginnings.iter().all(|below| below.meets(printed))
    }

    /// Both at once.
    pub(super) fn met_by(&self, printed: &PartSet) -> bool {
        self.begins_on(printed) && self.missing(printed) == 0.0
    }
}

/// Who lies on each facet of a part.
pub(super) struct Neighbours {
    /// For each facet: (part, shared area).
    on_facet: Vec<Vec<(usize, f64)>>,
    /// Facets that lie on the table.
    on_table: Vec<bool>,
    /// For each vertex: its facets.
    around: Vec<Vec<u32>>,
}

impl Neighbours {
    /// The neighbours of `part`.
    pub(super) fn of(workpiece: &Workpiece<'_>, part: usize) -> Self {
        let mesh = &workpiece.parts[part];
        let mut on_facet = vec![Vec::new(); mesh.facets().len()];
        for interface in &workpiece.model.interfaces {
            let (other, facets) = if interface.a == part {
                (interface.b, &interface.facets_a)
            } else if interface.b == part {
                (interface.a, &interface.facets_b)
            } else {
                continue;
            };
            for &(facet, area) in facets {
                on_facet[facet].push((other, area));
            }
        }
        let on_table = (0..mesh.facets().len()).map(|i| lies_on_table(mesh, i)).collect();
        let mut around = vec![Vec::new(); mesh.vertices().len()];
        for (index, facet) in mesh.facets().iter().enumerate() {
            for &vertex in facet {
                around[vertex as usize].push(index as u32);
            }
        }
        Self { on_facet, on_table, around }
    }
}

fn lies_on_table(mesh: &TriangleMesh<Table>, facet: usize) -> bool {
    mesh.corners(facet).iter().all(|c| c.z.abs() < ON_TABLE) && mesh.normal(facet).is_some_and(|n| n.z < -0.99)
}

/// What `mesh` needs when printed along `up` with overhangs up to `threshold` free.
pub(super) fn needs(
    mesh: &TriangleMesh<Table>,
    neighbours: &Neighbours,
    up: Dir<Table>,
    threshold: Angle,
    parts: usize,
) -> Needs {
    let steepest = (threshold + Angle::from_deg(ANGLE_SLACK_DEG)).rad().sin();
    let mut overhang = 0.0;
    let mut carried: Vec<(usize, f64)> = Vec::new();
    for facet in 0..mesh.facets().len() {
        let Some(normal) = mesh.normal(facet) else { continue };
        if -normal.dot(up.unit()) <= steepest || neighbours.on_table[facet] {
            continue;
        }
        overhang += mesh.facet_area(facet);
        for &(other, area) in &neighbours.on_facet[facet] {
            match carried.iter_mut().find(|(q, _)| *q == other) {
                Some((_, sum)) => *sum += area,
                None => carried.push((other, area)),
            }
        }
    }
    Needs { overhang_mm2: overhang, carried, beginnings: beginnings(mesh, neighbours, up, parts) }
}

/// The lowest places of the surface along `up`, as the parts each may stand on; those on the table are left out.
fn beginnings(mesh: &TriangleMesh<Table>, neighbours: &Neighbours, up: Dir<Table>, parts: usize) -> Vec<PartSet> {
    let height: Vec<f64> = mesh.vertices().iter().map(|v: &Vec3| v.dot(up.unit())).collect();
    let mut found: Vec<PartSet> = Vec::new();
    for (vertex, facets) in neighbours.around.iter().enumerate() {
        let lowest = |f: &u32| {
            let corners = mesh.facets()[*f as usize];
            corners.iter().all(|&c| height[c as usize] >= height[vertex] - SAME_HEIGHT)
        };
        // The middle of a flat top and the bottom of a bowl are lowest too, but have material below.
        let faces_down = |f: &u32| mesh.normal(*f as usize).is_some_and(|n| n.dot(up.unit()) < -1e-3);
        if !facets.iter().any(faces_down)
            || !facets.iter().all(lowest)
            || facets.iter().any(|&f| neighbours.on_table[f as usize])
        {
            continue;
        }
        let mut below = PartSet::new(parts);
        for other in carriers(mesh, neighbours, vertex) {
            below.insert(other);
        }
        if !found.contains(&below) {
            found.push(below);
        }
    }
    found
}

/// The parts on which `vertex` stands: those that share a facet of the flat face around it.
///
/// A sliver of a fanned cap shares too little area to count as an interface itself, so the facets next to the vertex's
/// own are asked too, as long as the vertex lies in their plane.
fn carriers(mesh: &TriangleMesh<Table>, neighbours: &Neighbours, vertex: usize) -> Vec<usize> {
    let at = mesh.vertices()[vertex];
    let own = neighbours.around[vertex].iter().flat_map(|&f| mesh.facets()[f as usize]);
    let mut around: Vec<u32> = own.flat_map(|c| neighbours.around[c as usize].iter().copied()).collect();
    around.sort_unstable();
    around.dedup();
    let mut parts: Vec<usize> = around
        .into_iter()
        .map(|f| f as usize)
        .filter(|&f| !neighbours.on_facet[f].is_empty())
        .filter(|&f| mesh.normal(f).is_some_and(|n| (at - mesh.corners(f)[0]).dot(&n).abs() < ON_TABLE))
        .flat_map(|f| neighbours.on_facet[f].iter().map(|&(q, _)| q))
        .collect();
    parts.sort_unstable();
    parts.dedup();
    parts
}
