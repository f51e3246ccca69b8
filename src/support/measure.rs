//! What supports are worth: how much of the overhanging area they hold, what they leave, how slender they are.

use rayon::prelude::*;

use super::brace::free_levels;
use super::demand::Demand;
use super::flow::Flow;
use super::graph::Graph;
use super::inside::Parts;
use crate::geom::{Angle, Slot, Vec3};
use crate::mesh::TriangleMesh;
use crate::section::{Sections, Segments};

/// Distance between samples of an overhanging area, mm.
pub const SAMPLE_MM: f64 = 0.5;

/// The gap is kept straight from the surface, which leans: upright it is at most so much more.
const STEEPEST: f64 = 1.5;
/// What has another part so far below it, mm, lies on that.
const CARRIED_MM: f64 = 0.05;
/// Supports that are measured are cut as often, mm.
const LEVEL_MM: f64 = 0.25;

/// How much of the overhanging area above the lowest level is held.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cover {
    /// Overhanging area, mm², without what lies within a step of the ground.
    pub area_mm2: f64,
    /// What of it has support below.
    pub covered_mm2: f64,
}

impl Cover {
    /// The share that is held; 1 where nothing overhangs.
    pub fn share(&self) -> f64 {
        if self.area_mm2 > 0.0 { self.covered_mm2 / self.area_mm2 } else { 1.0 }
    }
}

/// Samples the overhanging facets every half millimetre. A sample is held where, in its column, the black cubes below it end above
/// a red square with flow.
pub fn cover(graph: &Graph, flow: &Flow, meshes: &[&TriangleMesh<Slot>], overhang: Angle) -> Cover {
    let mut held = vec![false; graph.squares()];
    graph.red.iter().filter(|&&red| flow.out(red as usize) > 0).for_each(|&red| held[red as usize] = true);
    sampled(graph, meshes, overhang, |_, _, cube| Some(is_held(graph, &held, cube)))
}

/// Samples the overhanging facets every half millimetre. A sample is held where the mesh of supports has a side at most half a step
/// aside, within half a step and the gap below it. What lies on another part asks for nothing.
pub fn held(
    supports: &TriangleMesh<Slot>,
    graph: &Graph,
    meshes: &[&TriangleMesh<Slot>],
    overhang: Angle,
    gap_mm: f64,
) -> Cover {
    let (levels, parts) = (Levels::of(supports), Parts::of(&graph.grid, meshes));
    let near_mm = 0.5 * graph.grid.step_mm;
    let below_mm = near_mm + STEEPEST * gap_mm;
    sampled(graph, meshes, overhang, |part, at, _| {
        (!parts.carry(part, at, CARRIED_MM)).then(|| levels.come_near(at, near_mm, below_mm))
    })
}

/// What of the samples above the lowest level is held: `is_held` is asked with the part, the place and the cube that it is in, and answers
/// nothing where no support is asked for.
fn sampled(
    graph: &Graph,
    meshes: &[&TriangleMesh<Slot>],
    overhang: Angle,
    is_held: impl Fn(usize, &Vec3, usize) -> Option<bool> + Sync,
) -> Cover {
    let of_facet = |part: usize, facet: usize| -> Cover {
        let area = meshes[part].facet_area(facet);
        let samples = samples(&meshes[part].corners(facet), area);
        let each = area / samples.len() as f64;
        let mut cover = Cover::default();
        for at in &samples {
            let Some(cube) = cube_of(graph, at).filter(|&cube| cube >= graph.grid.level()) else { continue };
            let Some(held) = is_held(part, at, cube) else { continue };
            cover.area_mm2 += each;
            cover.covered_mm2 += if held { each } else { 0.0 };
        }
        cover
    };
    let of_part = |part: usize| -> Vec<Cover> {
        Demand::of(meshes[part], overhang).facets.into_par_iter().map(|facet| of_facet(part, facet)).collect()
    };
    (0..meshes.len()).flat_map(of_part).fold(Cover::default(), |sum, one| Cover {
        area_mm2: sum.area_mm2 + one.area_mm2,
        covered_mm2: sum.covered_mm2 + one.covered_mm2,
    })
}

/// A mesh of supports cut every quarter millimetre.
struct Levels(Vec<Segments>);

impl Levels {
    fn of(supports: &TriangleMesh<Slot>) -> Self {
        let sections = Sections::of(supports);
        let count = (supports.bounds().max.z.max(0.0) / LEVEL_MM).ceil() as usize;
        let at = |k: usize| Segments::new(sections.segments_at((k as f64 + 0.5) * LEVEL_MM));
        Self((0..count).into_par_iter().map(at).collect())
    }

    /// Whether it comes so near to a place: aside, and below it.
    fn come_near(&self, at: &Vec3, aside_mm: f64, below_mm: f64) -> bool {
        let level = |z: f64| ((z / LEVEL_MM).floor().max(0.0) as usize).min(self.0.len());
        let near = |segments: &Segments| segments.nearest([at.x, at.y], aside_mm, None).is_some();
        self.0[level(at.z - below_mm)..level(at.z + LEVEL_MM)].iter().rev().any(near)
    }
}

/// Points evenly over a triangle, at least one, each for the same share of it.
fn samples([a, b, c]: &[Vec3; 3], area: f64) -> Vec<Vec3> {
    let n = ((area.sqrt() / SAMPLE_MM).ceil() as usize).max(1);
    let share = 1.0 / (3.0 * n as f64);
    let at = |i: usize, j: usize, k: usize| {
        let (u, v) = ((3 * i + k) as f64 * share, (3 * j + k) as f64 * share);
        a + (b - a) * u + (c - a) * v
    };
    let upward = (0..n).flat_map(|i| (0..n - i).map(move |j| (i, j, 1)));
    let downward = (0..n).flat_map(|i| (0..(n - i).saturating_sub(1)).map(move |j| (i, j, 2)));
    upward.chain(downward).map(|(i, j, k)| at(i, j, k)).collect()
}

fn cube_of(graph: &Graph, at: &Vec3) -> Option<usize> {
    let steps = graph.grid.in_steps(at);
    let inside = (0..3).all(|k| steps[k] >= 0.0 && steps[k] < graph.grid.size[k] as f64);
    inside.then(|| graph.grid.index(steps.map(|s| s as usize)))
}

fn is_held(graph: &Graph, held: &[bool], cube: usize) -> bool {
    let level = graph.grid.level();
    let mut at = cube;
    loop {
        if held[at] {
            return true;
        }
        if at < level || !graph.is_black(at - level) {
            return false;
        }
        at -= level;
    }
}

/// Red squares side by side from which the ground cannot be reached.
#[derive(Clone, Debug, PartialEq)]
pub struct Bare {
    /// How many.
    pub squares: usize,
    /// Of the squares, seen from below, mm².
    pub area_mm2: f64,
    /// The middle of the lowest of them, mm.
    pub at: Vec3,
}

/// What cannot be held, in patches of squares that touch at a corner at least, the largest first.
pub fn bare(graph: &Graph) -> Vec<Bare> {
    let mut left: std::collections::BTreeSet<u32> = graph.unreachable.iter().copied().collect();
    let mut patches = Vec::new();
    while let Some(first) = left.pop_first() {
        let (mut patch, mut next) = (vec![first], 0);
        while let Some(&square) = patch.get(next) {
            next += 1;
            for beside in beside(graph, square as usize) {
                if left.remove(&(beside as u32)) {
                    patch.push(beside as u32);
                }
            }
        }
        let area_mm2 = patch.len() as f64 * graph.grid.step_mm.powi(2);
        patches.push(Bare { squares: patch.len(), area_mm2, at: graph.grid.middle(first as usize) });
    }
    patches.sort_by_key(|patch| std::cmp::Reverse(patch.squares));
    patches
}

/// The squares around one, those above and below among them.
fn beside(graph: &Graph, square: usize) -> Vec<usize> {
    let (at, size) = (graph.grid.cube(square), graph.grid.size);
    let around = |k: usize| at[k].saturating_sub(1)..(at[k] + 2).min(size[k]);
    let cubes = around(2).flat_map(|z| around(1).flat_map(move |y| around(0).map(move |x| [x, y, z])));
    cubes.map(|cube| graph.grid.index(cube)).filter(|&other| other != square).collect()
}

/// The longest stretch over which a column has no other beside it (corners included), whether it leans or not, mm.
pub fn longest_free_mm(graph: &Graph, flow: &Flow) -> f64 {
    let longest = free_levels(graph, flow).into_values().max().unwrap_or(0);
    f64::from(longest) * graph.grid.step_mm
}
