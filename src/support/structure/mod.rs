//! A planned flow as something to print: closed meshes along the arcs that have flow (Leitereg (2020), section 3.5).
//!
//! Slot frame, mm. Arcs that follow each other are one solid, a chain; where arcs meet in a node, one from above goes on in one
//! below and the others end a little beside it, within the material of that one. So every chain is a closed solid of its own,
//! and no two share a corner; they overlap where columns meet, and slicers take them together.

mod bars;
mod chain;
mod outline;
mod sheets;
mod top;

use super::flow::Flow;
use super::graph::Graph;
use crate::geom::Slot;
use crate::mesh::TriangleMesh;
pub use bars::Bars;
use bars::Beam;
use chain::chains;
pub use outline::{Outline, Structure};
pub use sheets::{Sheets, sheets};
pub use top::Ceiling;

/// How the arcs are built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Build {
    /// What stands along an arc.
    pub structure: Structure,
    /// Thickness of a sheet of `x`, and half that of a rod of `tree` that carries one unit, mm.
    pub wall_mm: f64,
    /// What is left free between the supports and what they hold, mm.
    pub gap_mm: f64,
    /// A roof below what they hold; `None`: columns alone.
    pub roof: Option<Bars>,
}

/// The supports of a flow, as closed meshes, and what they come to.
#[derive(Clone, Debug)]
pub struct Built {
    /// All chains.
    pub mesh: TriangleMesh<Slot>,
    /// Chains.
    pub chains: usize,
    /// Bars of the roof.
    pub bars: usize,
    /// Their volumes together, mm³; where chains overlap, counted twice.
    pub volume_mm3: f64,
    /// Of their feet on the ground, mm².
    pub plate_mm2: f64,
    /// Of their tops under the surface, seen from below, mm².
    pub contact_mm2: f64,
}

/// Builds the supports of `flow`; `ceiling` knows the surface above each red square.
pub fn build(graph: &Graph, flow: &Flow, ceiling: &Ceiling, how: &Build) -> Built {
    let outline = Outline::of(how, graph.grid.step_mm);
    let (mut vertices, mut facets) = (Vec::new(), Vec::new());
    let (mut plate_mm2, mut contact_mm2, mut count) = (0.0, 0.0, 0);
    for chain in chains(graph, flow, &outline) {
        count += 1;
        let rings = chain.rings;
        if let Some(red) = chain.red {
            let (middle, size) = rings[0];
            let top = ceiling.above(graph, red as usize, &outline.ring(&middle, size), how.gap_mm);
            contact_mm2 += outline.area(size);
            outline.add(&mut vertices, &mut facets, Some(top), &rings);
        } else {
            outline.add(&mut vertices, &mut facets, None, &rings);
        }
        plate_mm2 += if chain.on_ground { rings.last().map_or(0.0, |(_, size)| outline.area(*size)) } else { 0.0 };
    }
    let mut bars = 0;
    if let Some(roof) = how.roof {
        let beam = Beam { graph, ceiling, bars: roof, wall_mm: how.wall_mm, gap_mm: how.gap_mm };
        for ridge in
            graph.red.iter().filter(|&&red| flow.out(red as usize) > 0).flat_map(|&red| beam.over(red as usize))
        {
            bars += 1;
            contact_mm2 += beam.add(&ridge, &mut vertices, &mut facets);
        }
    }
    let mesh = TriangleMesh::new(vertices, facets);
    Built { volume_mm3: mesh.volume(), mesh, chains: count, bars, plate_mm2, contact_mm2 }
}
