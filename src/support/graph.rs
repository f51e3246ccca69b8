//! The graph in which supports are planned: squares of a grid, arcs down to the next level (Leitereg (2020), section 3.2).
//!
//! A cube is black where the surface touches it. The square below a black cube that holds something that wants support is
//! red where the cube below it is white; squares on the ground below white cubes are green. An arc goes one level down,
//! straight (cost 1) or straight and one square aside (cost 2), through one or two white cubes. What no red square reaches,
//! or what reaches no green one, is left out; red squares that reach none are kept by themselves, but for those below which
//! another part is: white cubes within material lead nowhere, and what lies on a part is held by it.
//!
//! Nothing is stored of an arc: a node has one byte, whose five lowest bits say which arcs leave it. A grid of 10 million
//! cubes takes 10 MB, and every node's level is known from its index.

use rayon::prelude::*;

use super::demand::Demand;
use super::grid::Grid;
use super::inside::inside;
use crate::geom::{Angle, Slot, Vec3};
use crate::mesh::TriangleMesh;

/// Arcs that can leave a node: straight down, and down with a step towards -x, +x, -y, +y.
pub const ARCS: usize = 5;
/// Cost of each arc that leaves a node.
pub const COSTS: [u32; ARCS] = [1, 2, 2, 2, 2];

/// The arcs of a node's byte.
pub(super) const ALL_ARCS: u8 = 0b1_1111;
/// The node is on a way from a red square to the ground.
const ALIVE: u8 = 1 << 5;
/// The node is a red square.
const RED: u8 = 1 << 6;

/// The cube touches the surface.
const BLACK: u8 = 1;
/// The cube holds something that wants support.
const WANTS: u8 = 2;

/// The squares, their arcs, and which of them want support.
#[derive(Clone, Debug, PartialEq)]
pub struct Graph {
    /// The grid.
    pub grid: Grid,
    /// A byte a square: arcs, alive, red.
    nodes: Vec<u8>,
    /// A byte a cube: black, wants support.
    cubes: Vec<u8>,
    /// Red squares from which the ground can be reached, ascending.
    pub red: Vec<u32>,
    /// Red squares from which it cannot, ascending.
    pub unreachable: Vec<u32>,
}

/// How large a graph is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Count {
    /// Squares on a way from a red one to the ground.
    pub nodes: usize,
    /// Arcs between them.
    pub arcs: usize,
    /// Red squares among them.
    pub red: usize,
    /// Squares on the ground among them.
    pub green: usize,
}

impl Graph {
    /// The graph of closed meshes in `grid`; what lies outside the grid is not seen.
    pub fn of(grid: Grid, meshes: &[&TriangleMesh<Slot>], overhang: Angle) -> Self {
        Self::among(grid, meshes, &[], overhang)
    }

    /// The same where `others` are in the way, closed meshes that want no support themselves.
    pub fn among(grid: Grid, meshes: &[&TriangleMesh<Slot>], others: &[&TriangleMesh<Slot>], overhang: Angle) -> Self {
        let mut cubes = vec![0_u8; grid.len()];
        for other in others {
            for facet in 0..other.facets().len() {
                grid.touching(&other.corners(facet), |cube| cubes[cube] |= BLACK);
            }
        }
        for mesh in meshes {
            let demand = Demand::of(mesh, overhang);
            let mut wants = vec![false; mesh.facets().len()];
            demand.facets.iter().for_each(|&facet| wants[facet] = true);
            for (facet, &wants) in wants.iter().enumerate() {
                let mark = if wants { BLACK | WANTS } else { BLACK };
                grid.touching(&mesh.corners(facet), |cube| cubes[cube] |= mark);
            }
            let at = |v: u32| mesh.vertices()[v as usize];
            let edges = demand.edges.iter().map(|&[a, b]| [at(a), at(b), at(b)]);
            let points = demand.points.iter().map(|&v| [at(v); 3]);
            edges.chain(points).for_each(|place: [Vec3; 3]| grid.touching(&place, |cube| cubes[cube] |= BLACK | WANTS));
        }
        let mut graph = Self::of_cubes(grid, cubes);
        let all: Vec<&TriangleMesh<Slot>> = meshes.iter().chain(others).copied().collect();
        let held = inside(&graph.grid, &all, &graph.unreachable);
        let mut held = held.into_iter();
        graph.unreachable.retain(|_| !held.next().unwrap_or(false));
        graph
    }

    /// The graph of black cubes (`true` first), and those of them that hold something that wants support (second).
    pub fn of_marks(grid: Grid, marks: &[(bool, bool)]) -> Self {
        let byte = |&(black, wants): &(bool, bool)| (u8::from(black) * BLACK) | (u8::from(black && wants) * WANTS);
        Self::of_cubes(grid, marks.iter().map(byte).collect())
    }

    fn of_cubes(grid: Grid, cubes: Vec<u8>) -> Self {
        let level = grid.level();
        let mut graph = Self { nodes: vec![0; grid.len()], cubes, red: Vec::new(), unreachable: Vec::new(), grid };
        let wanted: Vec<u32> = (level..graph.cubes.len())
            .filter(|&i| graph.cubes[i] & WANTS != 0 && graph.cubes[i - level] & BLACK == 0)
            .map(|i| i as u32)
            .collect();
        graph.reach_ground();
        (graph.red, graph.unreachable) = wanted.into_iter().partition(|&i| graph.nodes[i as usize] & ALL_ARCS != 0);
        graph.keep_reached();
        graph
    }

    /// Gives every square the arcs through white cubes that lead to the ground, from the ground up.
    fn reach_ground(&mut self) {
        let Self { grid, nodes, cubes, .. } = self;
        let ([nx, ny, nz], level) = (grid.size, grid.level());
        for i in 0..level {
            nodes[i] = if cubes[i] & BLACK == 0 { ALIVE } else { 0 };
        }
        for z in 1..nz {
            let (lower, upper) = nodes.split_at_mut(z * level);
            let (lower, white) = (&lower[(z - 1) * level..], &cubes[(z - 1) * level..z * level]);
            // A black cube's own square is entered from below only, so its arcs are those of the white cube under it.
            upper[..level].par_chunks_mut(nx).enumerate().for_each(|(y, row)| {
                for (x, node) in row.iter_mut().enumerate() {
                    let i = x + nx * y;
                    if white[i] & BLACK != 0 {
                        continue;
                    }
                    let open = |there: bool, j: usize| there && white[j] & BLACK == 0 && lower[j] & ALIVE != 0;
                    let arcs = u8::from(open(true, i))
                        | u8::from(open(x > 0, i.wrapping_sub(1))) << 1
                        | u8::from(open(x + 1 < nx, i + 1)) << 2
                        | u8::from(open(y > 0, i.wrapping_sub(nx))) << 3
                        | u8::from(open(y + 1 < ny, i + nx)) << 4;
                    *node = if arcs == 0 { 0 } else { arcs | ALIVE };
                }
            });
        }
    }

    /// Leaves out what no red square reaches, from the top down.
    fn keep_reached(&mut self) {
        let level = self.grid.level();
        self.nodes.iter_mut().for_each(|node| *node &= !ALIVE);
        for &i in &self.red {
            self.nodes[i as usize] |= ALIVE | RED;
        }
        for i in (0..self.nodes.len()).rev() {
            if self.nodes[i] & ALIVE == 0 {
                self.nodes[i] = 0;
            } else if i >= level {
                for arc in bits(self.nodes[i]) {
                    let head = self.head(i, arc);
                    self.nodes[head] |= ALIVE;
                }
            }
        }
    }

    /// Squares, alive or not: the length of whatever is kept by square.
    pub fn squares(&self) -> usize {
        self.nodes.len()
    }

    /// The node below, at the other end of arc `arc` (0 to 4) of node `from`.
    pub fn head(&self, from: usize, arc: usize) -> usize {
        from - self.grid.level() + self.grid.size[0] * usize::from(arc == 4) + usize::from(arc == 2)
            - usize::from(arc == 1)
            - self.grid.size[0] * usize::from(arc == 3)
    }

    /// The node above from which arc `arc` leads to `to`, where there is one.
    pub fn tail(&self, to: usize, arc: usize) -> Option<usize> {
        let above = to + self.grid.level() + usize::from(arc == 1) + self.grid.size[0] * usize::from(arc == 3);
        let tail = above.checked_sub(usize::from(arc == 2) + self.grid.size[0] * usize::from(arc == 4))?;
        // Where the step aside would leave the grid, the index is that of another row, which has no such arc.
        self.nodes.get(tail).filter(|node| *node & (1 << arc) != 0).map(|_| tail)
    }

    /// The arcs that leave a node, straight first.
    pub fn arcs(&self, node: usize) -> impl Iterator<Item = usize> + use<> {
        bits(self.nodes[node])
    }

    /// The arcs that leave a node as bits, the straight one's the lowest.
    pub(super) fn arc_bits(&self, node: usize) -> u8 {
        self.nodes[node] & ALL_ARCS
    }

    /// The bytes of a run of nodes: in the lowest bits what [`Graph::arc_bits`] says.
    pub(super) fn node_bytes(&self, nodes: std::ops::Range<usize>) -> &[u8] {
        &self.nodes[nodes]
    }

    /// Whether a square is on a way from a red one to the ground.
    pub fn is_node(&self, square: usize) -> bool {
        self.nodes[square] & ALIVE != 0
    }

    /// Whether a square is on the ground.
    pub fn is_ground(&self, node: usize) -> bool {
        node < self.grid.level()
    }

    /// Whether the surface touches a cube.
    pub fn is_black(&self, cube: usize) -> bool {
        self.cubes[cube] & BLACK != 0
    }

    /// Whether a cube holds something that wants support.
    pub fn wants(&self, cube: usize) -> bool {
        self.cubes[cube] & WANTS != 0
    }

    /// Counts it.
    pub fn count(&self) -> Count {
        Count {
            nodes: self.nodes.iter().filter(|node| *node & ALIVE != 0).count(),
            arcs: self.nodes.iter().map(|node| (node & ALL_ARCS).count_ones() as usize).sum(),
            red: self.red.len(),
            green: self.nodes[..self.grid.level()].iter().filter(|node| *node & ALIVE != 0).count(),
        }
    }
}

/// The arcs of a byte, straight first.
fn bits(node: u8) -> impl Iterator<Item = usize> {
    (0..ARCS).filter(move |arc| node & (1 << arc) != 0)
}
