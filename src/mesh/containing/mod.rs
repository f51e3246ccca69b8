//! A coarser mesh around a mesh: fewer facets, and all that was inside is inside still (mm, the mesh's own frame).
//!
//! Edges are collapsed, the cheapest first: the cost is the sum of the squared distances of the new vertex from the planes of all the
//! facets that it stands for (M. Garland and P. Heckbert's quadric), and the vertex is the one of least cost that lies on the outer
//! side of every facet at the edge, or on it.
//!
//! **Promised:** whatever the old surface winds around once or more often, the new one does too. Proof: with the vertex `v`, each facet
//! `f` at the edge spans a tetrahedron, whose other sides cancel but for the new facets; so the winding number of the new surface is
//! the old one's plus, for each `f`, 1 within its tetrahedron where `v` is on the outer side of `f` and -1 where it is not. No
//! vertex is taken that lies on an inner side by more than rounding (a ten-million-millionth of the mesh's size). That needs no
//! convexity, and no mesh without crossings.
//!
//! **Not promised:** that the new surface does not cross itself. Where a slot is narrower than what is added to its sides, these grow into each
//! other and what both fill is wound around twice. So a point is inside where the winding number is not zero; counting crossings of
//! a ray by even and odd would say otherwise there, and would call an old point outside. For keeping away from a body that is of no matter;
//! it is no mesh to print. Nor is `raised_mm` a distance of the surfaces: it is how high new vertices were put above the planes of the facets
//! that they replaced, added up, and beside an acute edge one may lie farther from the old surface than above its planes.
//!
//! Refused beside that: a collapse that would turn a facet over, and one that would join what was apart (the link condition), so that a
//! closed manifold stays one, of the same kind.
//!
//! `trunnion pack --inflate` packs such meshes in place of models with many facets.
//!
//! Source: A. Gaschler, Q. Fischer and A. Knoll, "The bounding mesh algorithm", TUM-I1522, 2015; Leitereg (2020), section 2.5; the link
//! condition after T. Dey et al., "Topology preserving edge contraction", 1999.

mod collapse;
mod quadric;
#[cfg(test)]
mod tests;

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::TriangleMesh;
use collapse::{Collapse, Surface};

/// A mesh around another one.
#[derive(Clone, Debug)]
pub struct Containing<F> {
    /// The coarser mesh; as closed as the first one was.
    pub mesh: TriangleMesh<F>,
    /// The most by which a vertex was raised above the planes of what it replaced, all collapses that led to it added up, mm.
    pub raised_mm: f64,
}

/// Looked at so often from the start: what was refused at first may be allowed when all around it has changed.
const ROUNDS: usize = 8;

/// A mesh of as few as `facets` facets around a closed `mesh`, its vertices raised by no more than `raised_mm` (see
/// [`Containing::raised_mm`]); whichever ends it first. More facets remain where every further collapse would be refused.
///
/// With `raised_mm` of 0 only what lies in a plane is joined, up to rounding. Facets with a corner twice are left out; open edges,
/// and edges with more than two facets, stay as they are, and so does what ends at them. The same mesh gives the same bytes.
pub fn containing<F>(mesh: &TriangleMesh<F>, facets: usize, raised_mm: f64) -> Containing<F> {
    let mut surface = Surface::of(mesh);
    for _ in 0..ROUNDS {
        if surface.count() <= facets || !round(&mut surface, facets, raised_mm) {
            break;
        }
    }
    let raised_mm = surface.most_raised();
    let (vertices, facets) = surface.compact();
    Containing { mesh: TriangleMesh::new(vertices, facets), raised_mm }
}

/// One round over all edges; whether any was collapsed.
fn round(surface: &mut Surface, facets: usize, raised_mm: f64) -> bool {
    let mut heap = BinaryHeap::new();
    for [a, b] in surface.edges() {
        heap.extend(surface.collapse([a, b], raised_mm).map(|c| Reverse(Entry::of(surface, [a, b], &c))));
    }
    let mut any = false;
    while surface.count() > facets {
        let Some(Reverse(entry)) = heap.pop() else { break };
        if entry.ages != surface.ages(entry.edge) {
            continue;
        }
        // The facets around may have changed, and with them the planes, though neither end did.
        let Some(now) = surface.collapse(entry.edge, raised_mm) else { continue };
        if now.cost.to_bits() > entry.cost {
            heap.push(Reverse(Entry { cost: now.cost.to_bits(), ..entry }));
            continue;
        }
        surface.carry_out(entry.edge, &now);
        any = true;
        for other in surface.beside(entry.edge[0]) {
            let edge = [entry.edge[0].min(other), entry.edge[0].max(other)];
            heap.extend(surface.collapse(edge, raised_mm).map(|c| Reverse(Entry::of(surface, edge, &c))));
        }
    }
    any
}

/// A collapse to come, and how often its ends had been moved when it was looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Entry {
    /// The bits of a cost, which is never negative: they are in the order of the numbers.
    cost: u64,
    edge: [u32; 2],
    ages: [u32; 2],
}

impl Entry {
    fn of(surface: &Surface, edge: [u32; 2], collapse: &Collapse) -> Self {
        Self { cost: collapse.cost.to_bits(), edge, ages: surface.ages(edge) }
    }
}
