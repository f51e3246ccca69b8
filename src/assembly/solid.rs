//! What two closed meshes have in common, and what is left of one without the other.

use std::panic::{AssertUnwindSafe, catch_unwind};

use boolmesh::prelude::{Manifold, OpType, compute_boolean};

use super::canonical::canonical;
use crate::geom::{Object, Sets, Vec3};
use crate::mesh::TriangleMesh;

type Mesh = TriangleMesh<Object>;

/// What two parts both fill.
pub(super) struct Common {
    /// Its volume, mm³.
    pub(super) volume_mm3: f64,
    area_mm2: f64,
}

impl Common {
    /// The mean thickness, mm: twice the volume over the surface, as of a sheet; 0 for nothing.
    pub(super) fn thickness_mm(&self) -> f64 {
        if self.area_mm2 > 0.0 { 2.0 * self.volume_mm3 / self.area_mm2 } else { 0.0 }
    }
}

/// Pieces below this, mm³, and below [`CRUMB_SHARE`] of their part are crumbs of the cut and are dropped: a few beads' length.
const CRUMB_MM3: f64 = 1.0;
/// Of the part.
const CRUMB_SHARE: f64 = 1e-2;
/// How exactly volumes must add up, of the part's own.
const EXACT: f64 = 1e-6;

/// What `boolmesh` 0.2.2 says of a result without a facet.
const NOTHING: &str = "empty pos matrix";

/// What both fill.
pub(super) fn common(a: &Mesh, b: &Mesh) -> Result<Common, String> {
    let mesh = boolean(a, b, &OpType::Intersect)?;
    Ok(Common { volume_mm3: mesh.volume(), area_mm2: mesh.area() })
}

/// `a` without what it has in common with `b`; `None` where that is nothing or several pieces.
pub(super) fn less(a: &Mesh, b: &Mesh, common: &Common) -> Result<Option<Mesh>, String> {
    let left = made(a, b, &OpType::Subtract)?;
    let off = (left.volume() + common.volume_mm3 - a.volume()).abs();
    if off > EXACT * a.volume() {
        return Err(format!("the volumes before and after differ by {off:.4} mm3"));
    }
    let crumb = CRUMB_MM3.min(CRUMB_SHARE * a.volume());
    let (mut whole, crumbs): (Vec<Shell>, Vec<Shell>) =
        shells(&left).into_iter().partition(|shell| shell.volume_mm3.abs() > crumb);
    if whole.iter().filter(|shell| shell.volume_mm3 > 0.0).count() != 1 {
        return Ok(None);
    }
    // A small cavity is no crumb.
    whole.extend(crumbs.into_iter().filter(|shell| shell.volume_mm3 < 0.0));
    Ok(Some(kept(&left, &whole)))
}

/// The pieces of `a` without `b`, none where nothing is left, and how much it loses, mm³.
pub(super) fn without(a: &Mesh, b: &Mesh) -> Result<(Vec<Mesh>, f64), String> {
    let lost = boolean(a, b, &OpType::Intersect)?.volume();
    if lost <= EXACT * a.volume() {
        return Ok((vec![a.clone()], 0.0));
    }
    let left = made(a, b, &OpType::Subtract)?;
    let off = (left.volume() + lost - a.volume()).abs();
    if off > EXACT * a.volume() {
        return Err(format!("the volumes before and after differ by {off:.4} mm3"));
    }
    let (mut outer, inner): (Vec<Shell>, Vec<Shell>) =
        shells(&left).into_iter().partition(|shell| shell.volume_mm3 > 0.0);
    let crumb = EXACT * a.volume();
    outer.retain(|shell| shell.volume_mm3 > crumb);
    let pieces = match (outer.len(), inner.is_empty()) {
        (1, _) => vec![kept(&left, &outer.into_iter().chain(inner).collect::<Vec<_>>())],
        (_, true) => outer.into_iter().map(|shell| kept(&left, &[shell])).collect(),
        _ => return Err("the result has several pieces, one of them with a cavity".to_owned()),
    };
    Ok((pieces, lost))
}

/// A closed shell of a mesh.
struct Shell {
    facets: Vec<usize>,
    /// Negative for a cavity, mm³.
    volume_mm3: f64,
}

fn shells(mesh: &Mesh) -> Vec<Shell> {
    let mut sets = Sets::new(mesh.vertices().len());
    for [a, b, c] in mesh.facets() {
        sets.join(*a, *b);
        sets.join(*b, *c);
    }
    let mut found: Vec<(u32, Shell)> = Vec::new();
    for (index, facet) in mesh.facets().iter().enumerate() {
        let root = sets.root(facet[0]);
        let [a, b, c] = mesh.corners(index);
        let volume = a.dot(&b.cross(&c)) / 6.0;
        match found.iter_mut().find(|(at, _)| *at == root) {
            Some((_, shell)) => {
                shell.facets.push(index);
                shell.volume_mm3 += volume;
            }
            None => found.push((root, Shell { facets: vec![index], volume_mm3: volume })),
        }
    }
    found.into_iter().map(|(_, shell)| shell).collect()
}

/// The shells as one mesh, vertices numbered in the order of first use.
fn kept(mesh: &Mesh, shells: &[Shell]) -> Mesh {
    let mut number = vec![u32::MAX; mesh.vertices().len()];
    let mut vertices = Vec::new();
    let mut facets = Vec::new();
    for &index in shells.iter().flat_map(|shell| &shell.facets) {
        facets.push(mesh.facets()[index].map(|old| {
            if number[old as usize] == u32::MAX {
                number[old as usize] = vertices.len() as u32;
                vertices.push(mesh.vertices()[old as usize]);
            }
            number[old as usize]
        }));
    }
    Mesh::new(vertices, facets)
}

/// Both as one solid: where they touch or overlap, their common faces go.
pub(super) fn joined_with(a: &Mesh, b: &Mesh) -> Result<Mesh, String> {
    let both = made(a, b, &OpType::Add)?;
    let common = common(a, b)?.volume_mm3;
    let off = (both.volume() + common - a.volume() - b.volume()).abs();
    if off > EXACT * (a.volume() + b.volume()) {
        Err(format!("the volumes before and after differ by {off:.4} mm3"))
    } else {
        Ok(both)
    }
}

/// The boolean as a mesh to keep: the same in every run, whatever its hash maps are seeded with.
fn made(a: &Mesh, b: &Mesh, what: &OpType) -> Result<Mesh, String> {
    boolean(a, b, what).map(|mesh| canonical(&mesh))
}

/// The boolean, whose triangles differ from run to run: for volumes.
fn boolean(a: &Mesh, b: &Mesh, what: &OpType) -> Result<Mesh, String> {
    let what = match what {
        OpType::Add => OpType::Add,
        OpType::Subtract => OpType::Subtract,
        OpType::Intersect => OpType::Intersect,
    };
    // A library of somebody else's: whatever it makes of odd meshes, the job ends with a sentence.
    let done = catch_unwind(AssertUnwindSafe(|| compute_boolean(&manifold(a)?, &manifold(b)?, what)));
    let done = match done.map_err(|_| "the boolean operation failed".to_owned())? {
        Err(why) if why == NOTHING => return Ok(Mesh::new(Vec::new(), Vec::new())),
        done => done?,
    };
    let vertices = done.ps.iter().map(|p| Vec3::new(p.x, p.y, p.z)).collect();
    let facets = done.hs.chunks(3).map(|h| [h[0].tail, h[1].tail, h[2].tail].map(|v| v as u32)).collect();
    Ok(Mesh::new(vertices, facets))
}

fn manifold(mesh: &Mesh) -> Result<Manifold, String> {
    let flat: Vec<f64> = mesh.vertices().iter().flat_map(|v| [v.x, v.y, v.z]).collect();
    let index: Vec<usize> = mesh.facets().iter().flatten().map(|&v| v as usize).collect();
    Manifold::new(&flat, &index)
}
