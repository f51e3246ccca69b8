//! A surface whose edges are collapsed: what a collapse would lead to, and what forbids it.

use super::quadric::{Outside, Quadric};
use crate::geom::Vec3;
use crate::mesh::TriangleMesh;

/// How far on the inner side of a plane a vertex may be put, of the mesh's size: rounding.
const ROUNDING: f64 = 1e-13;

/// What an edge would become.
#[derive(Clone, Copy, Debug)]
pub(super) struct Collapse {
    /// The new vertex.
    at: Vec3,
    /// Squared distances, mm².
    pub(super) cost: f64,
    /// How far above the planes it lies, with what was raised before.
    raised: f64,
}

pub(super) struct Surface {
    vertices: Vec<Vec3>,
    facets: Vec<Option<[u32; 3]>>,
    /// The facets at each vertex, ascending.
    around: Vec<Vec<u32>>,
    quadrics: Vec<Quadric>,
    raised: Vec<f64>,
    ages: Vec<u32>,
    count: usize,
    rounding: f64,
    /// Quadrics are seen from here, so that a mesh far from its origin loses no digits.
    middle: Vec3,
}

impl Surface {
    pub(super) fn of<F>(mesh: &TriangleMesh<F>) -> Self {
        let vertices = mesh.vertices().to_vec();
        let whole = |[a, b, c]: &[u32; 3]| a != b && b != c && c != a;
        let facets: Vec<_> = mesh.facets().iter().filter(|f| whole(f)).map(|f| Some(*f)).collect();
        let bounds = mesh.bounds();
        let (count, size) = (vertices.len(), if bounds.is_empty() { 0.0 } else { bounds.size().norm() });
        let mut surface = Self {
            around: vec![Vec::new(); count],
            quadrics: vec![Quadric::default(); count],
            raised: vec![0.0; count],
            ages: vec![0; count],
            count: facets.len(),
            rounding: size * ROUNDING,
            middle: if bounds.is_empty() { Vec3::zeros() } else { bounds.centre() },
            vertices,
            facets,
        };
        for (index, facet) in surface.facets.clone().into_iter().enumerate() {
            for v in facet.into_iter().flatten() {
                surface.around[v as usize].push(index as u32);
                if let Some(plane) = surface.plane(index as u32, &surface.middle) {
                    surface.quadrics[v as usize] = surface.quadrics[v as usize].plus(&Quadric::of(&plane));
                }
            }
        }
        surface
    }

    /// Facets that are left.
    pub(super) fn count(&self) -> usize {
        self.count
    }

    /// How often the ends of an edge were moved.
    pub(super) fn ages(&self, edge: [u32; 2]) -> [u32; 2] {
        edge.map(|v| self.ages[v as usize])
    }

    /// All edges, ascending.
    pub(super) fn edges(&self) -> Vec<[u32; 2]> {
        let sides = |[a, b, c]: &[u32; 3]| [[a, b], [b, c], [c, a]].map(|[p, q]| [*p.min(q), *p.max(q)]);
        let mut edges: Vec<_> = self.facets.iter().flatten().flat_map(sides).collect();
        edges.sort_unstable();
        edges.dedup();
        edges
    }

    /// The vertices that share a facet with one, ascending.
    pub(super) fn beside(&self, vertex: u32) -> Vec<u32> {
        let mut beside = self.sides(vertex);
        beside.dedup();
        beside
    }

    /// The same, each as often as it shares a facet: twice where all is closed.
    fn sides(&self, vertex: u32) -> Vec<u32> {
        let facets = &self.around[vertex as usize];
        let mut sides: Vec<u32> = facets.iter().flat_map(|&f| self.corners(f)).filter(|&v| v != vertex).collect();
        sides.sort_unstable();
        sides
    }

    /// The most that a vertex that is left was raised, mm.
    pub(super) fn most_raised(&self) -> f64 {
        let used = self.facets.iter().flatten().flatten();
        used.map(|&v| self.raised[v as usize]).fold(0.0, f64::max)
    }

    /// Vertices and facets that are left, in their order.
    pub(super) fn compact(self) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let mut places = vec![u32::MAX; self.vertices.len()];
        self.facets.iter().flatten().flatten().for_each(|&v| places[v as usize] = 0);
        let mut vertices = Vec::new();
        for (v, place) in places.iter_mut().enumerate().filter(|(_, place)| **place == 0) {
            *place = vertices.len() as u32;
            vertices.push(self.vertices[v]);
        }
        let facets = self.facets.iter().flatten().map(|f| f.map(|v| places[v as usize])).collect();
        (vertices, facets)
    }

    /// What collapsing `edge` leads to; `None` where that is refused, as where a vertex would be raised by more than `most` mm.
    pub(super) fn collapse(&self, edge: [u32; 2], most: f64) -> Option<Collapse> {
        let star = self.star(edge)?;
        let [a, b] = edge.map(|v| self.vertices[v as usize]);
        let middle = (a + b) / 2.0;
        let planes: Vec<Outside> = star.iter().filter_map(|&f| self.plane(f, &middle)).collect();
        let [p, q] = edge.map(|v| &self.quadrics[v as usize]);
        let sum = p.plus(q).from(&(middle - self.middle));
        let by = sum.least(&planes, self.rounding * 0.1)?;
        let at = middle + by;
        let mut height = 0.0_f64;
        for &f in &star {
            // Of the vertex as it is rounded, from the facet's own corner: this is what the proof rests on.
            let Some(plane) = self.plane(f, &at) else { continue };
            if -plane.d < -self.rounding {
                return None;
            }
            height = height.max(-plane.d);
        }
        let raised = edge.map(|v| self.raised[v as usize]).into_iter().fold(0.0, f64::max) + height;
        // In a plane nothing costs anything: there short edges go first.
        let cost = sum.at(&by) + sum.nearness() * (b - a).norm_squared();
        (raised <= most + self.rounding && !self.turns_over(&star, edge, &at)).then_some(Collapse { at, cost, raised })
    }

    /// Puts the new vertex in the place of the edge's first end, in which `collapse` was told.
    pub(super) fn carry_out(&mut self, edge: [u32; 2], collapse: &Collapse) {
        let [kept, gone] = edge;
        for f in std::mem::take(&mut self.around[gone as usize]) {
            let corners = self.corners(f);
            if corners.contains(&kept) {
                self.facets[f as usize] = None;
                self.count -= 1;
                corners.iter().for_each(|&v| self.around[v as usize].retain(|&other| other != f));
            } else {
                self.facets[f as usize] = Some(corners.map(|v| if v == gone { kept } else { v }));
                self.around[kept as usize].push(f);
            }
        }
        self.around[kept as usize].sort_unstable();
        self.vertices[kept as usize] = collapse.at;
        self.quadrics[kept as usize] = self.quadrics[kept as usize].plus(&self.quadrics[gone as usize]);
        self.raised[kept as usize] = collapse.raised;
        edge.into_iter().for_each(|v| self.ages[v as usize] += 1);
    }

    /// The facets at an edge's ends; `None` where it or another edge there has not two facets, or where its ends have more in common
    /// than these.
    fn star(&self, edge: [u32; 2]) -> Option<Vec<u32>> {
        let [a, b] = edge.map(|v| &self.around[v as usize]);
        let shared: Vec<u32> = a.iter().copied().filter(|f| b.binary_search(f).is_ok()).collect();
        let [f, g] = shared[..] else { return None };
        let apex = |f: u32| self.corners(f).into_iter().find(|v| !edge.contains(v));
        let mut ends = [apex(f)?, apex(g)?];
        ends.sort_unstable();
        let sides = edge.map(|v| self.sides(v));
        if !sides.iter().all(|sides| sides.chunk_by(u32::eq).all(|one| one.len() == 2)) {
            return None;
        }
        let [beside_a, beside_b] = sides.map(|mut sides| {
            sides.dedup();
            sides
        });
        let common: Vec<u32> = beside_a.into_iter().filter(|v| beside_b.binary_search(v).is_ok()).collect();
        if common[..] != ends {
            return None;
        }
        // Both ends with the same far side: a tetrahedron, which would fold flat.
        let with_both = |around: &[u32]| around.iter().any(|&f| ends.iter().all(|end| self.corners(f).contains(end)));
        if with_both(a) && with_both(b) {
            return None;
        }
        let mut star = [&a[..], b].concat();
        star.sort_unstable();
        star.dedup();
        Some(star)
    }

    /// Whether a facet that is left would face the other way, or lose its area.
    fn turns_over(&self, star: &[u32], edge: [u32; 2], at: &Vec3) -> bool {
        star.iter().map(|&f| self.corners(f)).filter(|f| !edge.iter().all(|v| f.contains(v))).any(|f| {
            let before = f.map(|v| self.vertices[v as usize]);
            let after = f.map(|v| if edge.contains(&v) { *at } else { self.vertices[v as usize] });
            let [was, is] = [before, after].map(|[a, b, c]| (b - a).cross(&(c - a)));
            was != Vec3::zeros() && was.dot(&is) <= 0.0
        })
    }

    fn corners(&self, facet: u32) -> [u32; 3] {
        self.facets[facet as usize].unwrap_or_default()
    }

    /// The outer side of a facet, as seen from `origin`; `None` of one without an area.
    fn plane(&self, facet: u32, origin: &Vec3) -> Option<Outside> {
        let [a, b, c] = self.corners(facet).map(|v| self.vertices[v as usize]);
        let n = (b - a).cross(&(c - a)).try_normalize(0.0)?;
        Some(Outside { n, d: n.dot(&(a - origin)) })
    }
}
