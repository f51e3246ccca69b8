//! Whether the cube below a square lies in material: what stands there holds the square already.

use std::collections::HashMap;

use super::grid::Grid;
use crate::geom::{Slot, Vec3};
use crate::mesh::TriangleMesh;

/// Places in a cube, in steps from its middle, so that an upright line through them runs along no edge of a usual model.
const ASIDE: [f64; 2] = [0.012_345_6, 0.006_543_2];

/// For each of `squares` whether the cube below it, which the surface does not touch, is in the material of a closed mesh: the facets
/// above it that face up are more than those that face down.
pub(super) fn inside(grid: &Grid, meshes: &[&TriangleMesh<Slot>], squares: &[u32]) -> Vec<bool> {
    let level = grid.level();
    let mut by_column: HashMap<usize, Vec<usize>> = HashMap::new();
    for (place, &square) in squares.iter().enumerate() {
        by_column.entry(square as usize % level).or_default().push(place);
    }
    let mut turns = vec![0_i32; squares.len()];
    if squares.is_empty() {
        return Vec::new();
    }
    for mesh in meshes {
        for facet in 0..mesh.facets().len() {
            let corners = mesh.corners(facet);
            for column in columns(grid, &corners) {
                let Some(places) = by_column.get(&column) else { continue };
                let at = grid.middle(column) + Vec3::new(ASIDE[0], ASIDE[1], 0.0) * grid.step_mm;
                let Some((height, sense)) = crossing(&corners, &at) else { continue };
                for &place in places {
                    let middle = grid.middle(squares[place] as usize).z - 0.5 * grid.step_mm;
                    turns[place] += if height > middle { sense } else { 0 };
                }
            }
        }
    }
    turns.into_iter().map(|turns| turns > 0).collect()
}

/// Which places lie on another part.
pub(super) struct Parts<'a> {
    grid: &'a Grid,
    meshes: &'a [&'a TriangleMesh<Slot>],
    /// The facets over each column of cubes, each with its mesh.
    by_column: HashMap<usize, Vec<(usize, usize)>>,
}

impl<'a> Parts<'a> {
    pub(super) fn of(grid: &'a Grid, meshes: &'a [&'a TriangleMesh<Slot>]) -> Self {
        let mut by_column: HashMap<usize, Vec<(usize, usize)>> = HashMap::new();
        for (part, mesh) in meshes.iter().enumerate().filter(|_| meshes.len() > 1) {
            for facet in 0..mesh.facets().len() {
                columns(grid, &mesh.corners(facet))
                    .for_each(|column| by_column.entry(column).or_default().push((part, facet)));
            }
        }
        Self { grid, meshes, by_column }
    }

    /// Whether `depth_mm` below a place of part `own` another part has material.
    pub(super) fn carry(&self, own: usize, at: &Vec3, depth_mm: f64) -> bool {
        let steps = self.grid.in_steps(at);
        let column = steps[0] as usize + self.grid.size[0] * steps[1] as usize;
        let facets = self.by_column.get(&column).map_or(&[][..], Vec::as_slice);
        let mut turns = vec![0; self.meshes.len()];
        for &(part, facet) in facets.iter().filter(|(part, _)| *part != own) {
            if let Some((height, sense)) = crossing(&self.meshes[part].corners(facet), at) {
                turns[part] += if height > at.z - depth_mm { sense } else { 0 };
            }
        }
        turns.into_iter().any(|turns| turns > 0)
    }
}

/// The columns of cubes over which a facet may lie.
fn columns(grid: &Grid, corners: &[Vec3; 3]) -> impl Iterator<Item = usize> {
    let steps = corners.map(|corner| grid.in_steps(&corner));
    let range = |axis: usize| {
        let low = steps.iter().map(|s| s[axis]).fold(f64::INFINITY, f64::min);
        let high = steps.iter().map(|s| s[axis]).fold(f64::NEG_INFINITY, f64::max);
        low.max(0.0) as usize..((high + 1.0).max(0.0) as usize).min(grid.size[axis])
    };
    let (across, nx) = (range(0), grid.size[0]);
    range(1).flat_map(move |y| across.clone().map(move |x| x + nx * y))
}

/// Where an upright line through `at` meets a facet, and 1 where the facet faces up, -1 where it faces down.
pub(super) fn crossing([a, b, c]: &[Vec3; 3], at: &Vec3) -> Option<(f64, i32)> {
    let normal = (b - a).cross(&(c - a));
    let inside = [(a, b), (b, c), (c, a)].iter().all(|(p, q)| {
        let side = (q.x - p.x) * (at.y - p.y) - (q.y - p.y) * (at.x - p.x);
        side * normal.z >= 0.0
    });
    let height = || a.z - (normal.x * (at.x - a.x) + normal.y * (at.y - a.y)) / normal.z;
    (inside && normal.z != 0.0).then(|| (height(), if normal.z > 0.0 { 1 } else { -1 }))
}
