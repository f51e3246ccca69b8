//! Where the surface is above a red square, so that supports end just below what they hold.

use std::collections::HashMap;

use crate::geom::{Slot, Vec3};
use crate::mesh::TriangleMesh;
use crate::support::graph::Graph;

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

    /// The places of `ring` (at the height of the square) lifted to `gap_mm` below the surface. Where there is none above a place
    /// within two steps, it is lifted as the lowest of the others; one that lies in the part already, since a sheet reaches a little
    /// beyond its cell, stays.
    pub(super) fn above(&self, graph: &Graph, red: usize, ring: &[Vec3], gap_mm: f64) -> Vec<Vec3> {
        let facets = self.by_column.get(&(red as u32)).map_or(&[][..], Vec::as_slice);
        let over: Vec<Over> = ring.iter().map(|at| first_over(facets, at)).collect();
        let heights =
            over.iter().filter_map(|over| if let Over::Surface(height) = over { Some(*height) } else { None });
        let others = heights.fold(f64::INFINITY, f64::min);
        let least = graph.grid.step_mm * LEAST;
        let lifted = |(at, over): (&Vec3, &Over)| {
            let surface = match over {
                Over::Surface(height) => *height,
                Over::Nothing if others.is_finite() => others,
                Over::Nothing | Over::Material => at.z,
            };
            Vec3::new(at.x, at.y, (surface - gap_mm).max(at.z + least))
        };
        ring.iter().zip(&over).map(lifted).collect()
    }
}

/// What is over a place.
#[derive(Clone, Copy, Debug)]
enum Over {
    /// A surface that faces down, at this height.
    Surface(f64),
    /// No surface.
    Nothing,
    /// The part itself: the first surface above faces up.
    Material,
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

/// What an upright line through `at` meets first.
fn first_over(facets: &[[Vec3; 3]], at: &Vec3) -> Over {
    let met = facets.iter().filter_map(|[a, b, c]| {
        let normal = (b - a).cross(&(c - a));
        let inside = [(a, b), (b, c), (c, a)].iter().all(|(p, q)| {
            let side = (q.x - p.x) * (at.y - p.y) - (q.y - p.y) * (at.x - p.x);
            side * normal.z >= 0.0
        });
        let height = || a.z - (normal.x * (at.x - a.x) + normal.y * (at.y - a.y)) / normal.z;
        (inside && normal.z != 0.0).then(|| (height(), normal.z < 0.0))
    });
    let first = met.filter(|(height, _)| *height >= at.z).min_by(|a, b| a.0.total_cmp(&b.0));
    match first {
        Some((height, true)) => Over::Surface(height),
        Some((_, false)) => Over::Material,
        None => Over::Nothing,
    }
}
