//! What the objectives know of a part.

use std::sync::OnceLock;

use super::lowest::Lowest;
use super::moments::Moments;
use crate::geom::Vec3;
use crate::mesh::TriangleMesh;

/// One facet, for the objectives that cannot sum facets up by their normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Facet {
    /// Outward, as long as the facet's area, mm².
    pub area: Vec3,
    /// The mean of the three corners, mm.
    pub barycentre: Vec3,
}

/// A part's facets as the objectives need them: facets of one normal summed up.
#[derive(Clone, Debug)]
pub struct Facets {
    /// Outward unit normals, distinct to the bit.
    pub normals: Vec<Vec3>,
    /// The area with each normal, mm².
    pub areas: Vec<f64>,
    /// The corner points, mm, in the mesh's frame.
    pub points: Vec<Vec3>,
    /// How many facets share each normal.
    pub counts: Vec<f64>,
    /// Area times barycentre, summed over the facets of each normal, mm³.
    pub moments: Vec<Vec3>,
    /// The facets one by one, in the mesh's order.
    pub each: Vec<Facet>,
    lowest: OnceLock<Lowest>,
    sums: OnceLock<Moments>,
}

/// Normals nearer than this (radians) are one: a few ulp of a normal computed from f32 corners.
const SAME_NORMAL: f64 = 1e-9;

impl Facets {
    /// Gathers `mesh`; facets without area are left out, so a mesh of nothing else gives none.
    pub fn of<F>(mesh: &TriangleMesh<F>) -> Self {
        let mut each = Vec::with_capacity(mesh.facets().len());
        let mut all: Vec<(Vec3, f64, Vec3)> = Vec::with_capacity(mesh.facets().len());
        for i in 0..mesh.facets().len() {
            let Some(normal) = mesh.normal(i) else { continue };
            let [a, b, c] = mesh.corners(i);
            let (barycentre, area) = ((a + b + c) / 3.0, mesh.facet_area(i));
            each.push(Facet { area: mesh.area_vector(i) * 0.5, barycentre });
            all.push((normal, area, barycentre));
        }
        all.sort_by(|a, b| a.0.as_slice().partial_cmp(b.0.as_slice()).unwrap_or(std::cmp::Ordering::Equal));
        let mut facets = Self::with(vec![], vec![], mesh.vertices().to_vec());
        for (normal, area, barycentre) in all {
            facets.add(normal, area, barycentre);
        }
        facets.each = each;
        facets
    }

    /// Facets known by normal and area alone, all at the origin, with the corner `points`: enough for the objectives
    /// without a height above the bed.
    ///
    /// # Panics
    ///
    /// Panics where `normals` and `areas` are not of one length.
    pub fn with(normals: Vec<Vec3>, areas: Vec<f64>, points: Vec<Vec3>) -> Self {
        assert_eq!(normals.len(), areas.len(), "one area for each normal");
        let (counts, moments) = (vec![1.0; normals.len()], vec![Vec3::zeros(); normals.len()]);
        let facet = |(n, area): (&Vec3, &f64)| Facet { area: n * *area, barycentre: Vec3::zeros() };
        let each = normals.iter().zip(&areas).map(facet).collect();
        Self { normals, areas, points, counts, moments, each, lowest: OnceLock::new(), sums: OnceLock::new() }
    }

    /// Counts a facet in with its normal; normals come sorted.
    fn add(&mut self, normal: Vec3, area: f64, barycentre: Vec3) {
        let last = self.normals.len().wrapping_sub(1);
        if self.normals.last().is_some_and(|known| (known - normal).norm() < SAME_NORMAL) {
            self.areas[last] += area;
            self.counts[last] += 1.0;
            self.moments[last] += barycentre * area;
        } else {
            self.normals.push(normal);
            self.areas.push(area);
            self.counts.push(1.0);
            self.moments.push(barycentre * area);
        }
    }

    /// The corner point lowest along `up`, mm; the origin where there are no points.
    ///
    /// Exact: every point is looked at, or lies in a box that is proved higher.
    pub fn lowest(&self, up: &Vec3) -> Vec3 {
        self.lowest.get_or_init(|| Lowest::of(&self.points)).along(up)
    }

    /// The sums over all facets that `weighted-normal-z` is made of.
    pub(super) fn sums(&self) -> &Moments {
        self.sums.get_or_init(|| Moments::of(self))
    }

    pub(super) fn extent(&self, up: &Vec3) -> (f64, f64) {
        self.points.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| {
            let along = p.dot(up);
            (low.min(along), high.max(along))
        })
    }
}

/// `vector` without its part along the unit direction `up`.
pub(super) fn tangential(vector: Vec3, up: &Vec3) -> Vec3 {
    vector - up * vector.dot(up)
}
