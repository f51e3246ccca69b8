//! Where the surface is above a red square, so that supports end just below what they hold.

use std::collections::HashMap;

use crate::geom::{Slot, Vec3};
use crate::mesh::TriangleMesh;
use crate::support::graph::Graph;
use crate::support::inside::crossing;

/// A top is at least so much of a step above its square: it must not be flat.
const LEAST: f64 = 0.01;

/// The facets in the cubes above red squares, and in those around and above them.
#[derive(Clone, Debug, Default)]
pub struct Ceiling {
    by_column: HashMap<u32, Vec<[Vec3; 3]>>,
}

impl Ceiling {
    /// What `meshes` have above the red squares of `graph`, up to two steps.
    pub fn of(graph: &Graph, meshes: &[&TriangleMesh<Slot>]) -> Self {
        let mut by_column: HashMap<u32, Vec<[Vec3; 3]>> = graph.red.iter().map(|&red| (red, Vec::new())).collect();
        let mut is_red = vec![false; graph.squares()];
        graph.red.iter().for_each(|&red| is_red[red as usize] = true);
        for mesh in meshes {
            for facet in 0..mesh.facets().len() {
                let corners = mesh.corners(facet);
                let mut over = Vec::new();
                graph.grid.touching(&corners, |cube| over.extend(below(graph, cube).filter(|&square| is_red[square])));
                over.sort_unstable();
                over.dedup();
                for red in over {
                    by_column.entry(red as u32).or_default().push(corners);
                }
            }
        }
        Self { by_column }
    }

    /// The places of `ring` (at the height of the square) lifted to `gap_mm` below the surface. A place over which nothing faces down
    /// within two steps stays: it lies beside the part, or in it, since a sheet reaches a little beyond its cell.
    pub(super) fn above(&self, graph: &Graph, red: usize, ring: &[Vec3], gap_mm: f64) -> Vec<Vec3> {
        let facets = self.by_column.get(&(red as u32)).map_or(&[][..], Vec::as_slice);
        let least = graph.grid.step_mm * LEAST;
        let top = |at: &Vec3| surface_over(facets, at).map_or(at.z, |surface| surface - gap_mm);
        ring.iter().map(|at| Vec3::new(at.x, at.y, top(at).max(at.z + least))).collect()
    }
}

impl Ceiling {
    /// The surface over a place at the height of a red square, if what is met first faces down.
    pub(super) fn surface(&self, red: usize, at: &Vec3) -> Option<f64> {
        surface_over(self.by_column.get(&(red as u32))?, at)
    }
}

/// The squares of a cube and of those around it, and one level lower: a sheet reaches a little beyond its cell.
fn below(graph: &Graph, cube: usize) -> impl Iterator<Item = usize> {
    let ([x, y, z], [nx, ny, _], grid) = (graph.grid.cube(cube), graph.grid.size, graph.grid);
    let levels = z.saturating_sub(1)..z + 1;
    let around = |at: usize, size: usize| at.saturating_sub(1)..(at + 2).min(size);
    let (rows, columns) = (around(y, ny), around(x, nx));
    levels.flat_map(move |w| {
        let columns = columns.clone();
        rows.clone().flat_map(move |v| columns.clone().map(move |u| grid.index([u, v, w])))
    })
}

/// Where an upright line through `at` first meets a surface, if that faces down; one that faces up is met from within the part.
fn surface_over(facets: &[[Vec3; 3]], at: &Vec3) -> Option<f64> {
    let met = facets.iter().filter_map(|corners| crossing(corners, at));
    let first = met.filter(|(height, _)| *height >= at.z).min_by(|a, b| a.0.total_cmp(&b.0));
    first.filter(|(_, sense)| *sense < 0).map(|(height, _)| height)
}
