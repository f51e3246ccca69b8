//! The closed surface of a solid that is being cut, and planes.
//!
//! Lengths mm, in the model file's frame. A facet remembers whether it is the model's own or the cap of a cut.

use crate::geom::{Object, Sets, Vec3};
use crate::mesh::TriangleMesh;

/// The half-space beyond a plane: all `x` with `normal . x > offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// Unit normal; a piece that lies beyond is printed along it.
    pub normal: Vec3,
    /// Distance from the origin along the normal, mm.
    pub offset_mm: f64,
}

impl Plane {
    /// How far `point` lies beyond, mm; negative before.
    pub fn height(&self, point: &Vec3) -> f64 {
        self.normal.dot(point) - self.offset_mm
    }
}

/// A facet of the model itself, not of a cap.
pub(super) const OWN: u32 = 0;

/// A closed surface, one shell or several, facing out of the material.
#[derive(Clone, Debug, Default)]
pub(super) struct Surface {
    pub(super) vertices: Vec<Vec3>,
    pub(super) facets: Vec<[u32; 3]>,
    /// By facet: [`OWN`], or the number of the cut whose cap it is, from 1.
    pub(super) source: Vec<u32>,
}

impl Surface {
    pub(super) fn of(mesh: &TriangleMesh<Object>) -> Self {
        let facets = mesh.facets().to_vec();
        Self { vertices: mesh.vertices().to_vec(), source: vec![OWN; facets.len()], facets }
    }

    pub(super) fn mesh(&self) -> TriangleMesh<Object> {
        TriangleMesh::new(self.vertices.clone(), self.facets.clone())
    }

    /// The facets at `wanted` with their vertices, in order of first use.
    pub(super) fn select(&self, wanted: impl Iterator<Item = usize>) -> Self {
        let mut number = vec![u32::MAX; self.vertices.len()];
        let mut part = Self::default();
        for facet in wanted {
            let corners = self.facets[facet].map(|old| {
                let new = &mut number[old as usize];
                if *new == u32::MAX {
                    *new = part.vertices.len() as u32;
                    part.vertices.push(self.vertices[old as usize]);
                }
                *new
            });
            part.facets.push(corners);
            part.source.push(self.source[facet]);
        }
        part
    }

    pub(super) fn corners(&self, facet: usize) -> [Vec3; 3] {
        self.facets[facet].map(|i| self.vertices[i as usize])
    }

    /// Twice the area along the outward normal, mm².
    pub(super) fn area_vector(&self, facet: usize) -> Vec3 {
        let [a, b, c] = self.corners(facet);
        (b - a).cross(&(c - a))
    }

    /// The enclosed volume, mm³.
    pub(super) fn volume(&self) -> f64 {
        let Some(&origin) = self.vertices.first() else { return 0.0 };
        let cone = |facet| {
            let [a, b, c] = self.corners(facet).map(|p| p - origin);
            a.dot(&b.cross(&c)) / 6.0
        };
        (0..self.facets.len()).map(cone).sum()
    }

    /// Whether every edge is run along as often one way as the other.
    pub(super) fn is_closed(&self) -> bool {
        let mut edges: Vec<(u32, u32, i32)> = Vec::with_capacity(3 * self.facets.len());
        for facet in &self.facets {
            for i in 0..3 {
                let (a, b) = (facet[i], facet[(i + 1) % 3]);
                edges.push(if a < b { (a, b, 1) } else { (b, a, -1) });
            }
        }
        edges.sort_unstable();
        edges.chunk_by(|x, y| (x.0, x.1) == (y.0, y.1)).all(|run| run.iter().map(|e| e.2).sum::<i32>() == 0)
    }

    /// By facet, the number of its shell; and how many there are. Facets that share a vertex are of one shell.
    pub(super) fn shells(&self) -> (Vec<u32>, usize) {
        let mut sets = Sets::new(self.vertices.len());
        self.facets.iter().for_each(|&[a, b, c]| {
            sets.join(a, b);
            sets.join(b, c);
        });
        let mut number = vec![u32::MAX; self.vertices.len()];
        let mut count = 0;
        let shells = self.facets.iter().map(|facet| {
            let number = &mut number[sets.root(facet[0]) as usize];
            if *number == u32::MAX {
                *number = count;
                count += 1;
            }
            *number
        });
        (shells.collect(), count as usize)
    }

    /// How often the surface winds around `at` (Van Oosterom and Strackee 1983): 1 inside, 0 outside.
    pub(super) fn winding(&self, at: &Vec3) -> f64 {
        let angle = |facet| {
            let [a, b, c]: [Vec3; 3] = self.corners(facet).map(|p| p - at);
            let (la, lb, lc) = (a.norm(), b.norm(), c.norm());
            let below = la * lb * lc + a.dot(&b) * lc + b.dot(&c) * la + c.dot(&a) * lb;
            a.dot(&b.cross(&c)).atan2(below)
        };
        (0..self.facets.len()).map(angle).sum::<f64>() / std::f64::consts::TAU
    }
}
