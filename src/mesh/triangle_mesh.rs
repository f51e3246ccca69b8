//! An indexed triangle mesh in a named frame.

use std::marker::PhantomData;

use crate::geom::{Bounds, Object, Point, Rigid, Vec3};

/// An indexed triangle mesh, mm, frame `F`; corners counter-clockwise seen from outside.
#[derive(Debug)]
pub struct TriangleMesh<F = Object> {
    vertices: Vec<Vec3>,
    facets: Vec<[u32; 3]>,
    frame: PhantomData<F>,
}

impl<F> Clone for TriangleMesh<F> {
    fn clone(&self) -> Self {
        Self { vertices: self.vertices.clone(), facets: self.facets.clone(), frame: PhantomData }
    }
}

impl<F> TriangleMesh<F> {
    /// A mesh of `vertices` and index triples; every index must be below `vertices.len()`.
    ///
    /// # Panics
    ///
    /// Panics where an index is out of range: the readers check theirs first.
    pub fn new(vertices: Vec<Vec3>, facets: Vec<[u32; 3]>) -> Self {
        let count = vertices.len();
        assert!(facets.iter().flatten().all(|&i| (i as usize) < count), "a facet names a vertex that is not there");
        Self { vertices, facets, frame: PhantomData }
    }

    /// The closed surface of a box: 8 vertices, 12 facets that face out; flat where the box is.
    pub fn cuboid(bounds: &Bounds) -> Self {
        // Bit 0 of a corner's number says which x, bit 1 which y, bit 2 which z; the sides as they are seen from outside.
        const SIDES: [[u32; 4]; 6] =
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let end = |k: usize, i: usize| if k >> i & 1 == 1 { bounds.max[i] } else { bounds.min[i] };
        let corner = |k: usize| Vec3::from([0, 1, 2].map(|i| end(k, i)));
        let facets = SIDES.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        Self::new((0..8).map(corner).collect(), facets)
    }

    /// Several as one, each with its own vertices.
    pub fn joined<'a>(all: impl IntoIterator<Item = &'a Self>) -> Self
    where
        F: 'a,
    {
        let (mut vertices, mut facets) = (Vec::new(), Vec::new());
        for one in all {
            let first = vertices.len() as u32;
            vertices.extend_from_slice(&one.vertices);
            facets.extend(one.facets.iter().map(|facet| facet.map(|corner| corner + first)));
        }
        Self::new(vertices, facets)
    }

    /// The vertices, mm.
    pub fn vertices(&self) -> &[Vec3] {
        &self.vertices
    }

    /// The facets as triples of vertex indices.
    pub fn facets(&self) -> &[[u32; 3]] {
        &self.facets
    }

    /// The three corners of facet `index`, mm.
    pub fn corners(&self, index: usize) -> [Vec3; 3] {
        self.facets[index].map(|i| self.vertices[i as usize])
    }

    /// Twice the facet's area along its outward normal, mm²: `(b - a) x (c - a)`; zero for a degenerate facet.
    pub fn area_vector(&self, index: usize) -> Vec3 {
        let [a, b, c] = self.corners(index);
        (b - a).cross(&(c - a))
    }

    /// The facet's outward unit normal; `None` for a facet without area.
    pub fn normal(&self, index: usize) -> Option<Vec3> {
        let vector = self.area_vector(index);
        let length = vector.norm();
        (length > 0.0).then(|| vector / length)
    }

    /// The facet's area, mm².
    pub fn facet_area(&self, index: usize) -> f64 {
        self.area_vector(index).norm() * 0.5
    }

    /// The surface area, mm².
    pub fn area(&self) -> f64 {
        (0..self.facets.len()).map(|i| self.facet_area(i)).sum()
    }

    /// The enclosed volume, mm³; meaningful for closed meshes, negative where facets face inward.
    ///
    /// Summed about the first vertex, so that a part far from the origin loses no digits.
    pub fn volume(&self) -> f64 {
        let Some(&origin) = self.vertices.first() else { return 0.0 };
        (0..self.facets.len())
            .map(|i| {
                let [a, b, c] = self.corners(i);
                (a - origin).dot(&(b - origin).cross(&(c - origin))) / 6.0
            })
            .sum()
    }

    /// The smallest axis-parallel box around all vertices.
    pub fn bounds(&self) -> Bounds {
        Bounds::of(self.vertices.iter().copied())
    }

    /// The same surface seen from frame `G`.
    pub fn moved<G>(&self, motion: &Rigid<F, G>) -> TriangleMesh<G> {
        let vertices = self.vertices.iter().map(|&v| motion.point(Point::from(v)).at).collect();
        TriangleMesh { vertices, facets: self.facets.clone(), frame: PhantomData }
    }
}
