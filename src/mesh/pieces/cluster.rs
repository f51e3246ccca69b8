//! A group of facets on its way to a piece: its hull, how concave it is, and what it borders on.

use std::collections::BTreeMap;

use crate::geom::{GrowingHull, Vec3};
use crate::mesh::TriangleMesh;

/// The surface, with what is asked of it again and again.
pub(super) struct Ground<'a, F> {
    pub(super) mesh: &'a TriangleMesh<F>,
    /// All hulls' grid.
    nothing: GrowingHull,
    slack: f64,
    /// Unit normals; zero of a facet that is a line but for rounding: it faces anywhere, and its neighbours tell how deep it lies.
    normals: Vec<Vec3>,
}

/// What lies between two groups.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Border {
    /// The length of their common edges, mm.
    pub(super) length: f64,
    /// Both only grow, and so does the concavity of the two together: once too much is always too much.
    pub(super) closed: bool,
}

/// A group of facets.
pub(super) struct Cluster {
    pub(super) facets: Vec<u32>,
    /// How far the hull reaches beyond each facet's plane, mm: no way out along its normal is longer.
    rises: Vec<f64>,
    hull: GrowingHull,
    perimeter: f64,
    area: f64,
    pub(super) concavity: f64,
    pub(super) borders: BTreeMap<u32, Border>,
}

impl<'a, F> Ground<'a, F> {
    /// A facet thinner than `slack` mm is a line.
    pub(super) fn of(mesh: &'a TriangleMesh<F>, slack: f64) -> Self {
        let wide = |f: usize| {
            let [a, b, c] = mesh.corners(f);
            let longest = (b - a).norm().max((c - b).norm()).max((a - c).norm());
            2.0 * mesh.facet_area(f) > slack * longest
        };
        let normal = |f: usize| mesh.normal(f).filter(|_| wide(f)).unwrap_or_default();
        let nothing = GrowingHull::within(&mesh.bounds());
        Self { mesh, nothing, slack, normals: (0..mesh.facets().len()).map(normal).collect() }
    }

    /// A facet by itself, with its neighbours across its sides.
    pub(super) fn single(&self, facet: u32, across: [Option<u32>; 3]) -> Cluster {
        let corners = self.mesh.corners(facet as usize);
        let mut hull = self.nothing.clone();
        hull.add(&corners);
        let lengths = [0, 1, 2].map(|k| (corners[(k + 1) % 3] - corners[k]).norm());
        let mut borders: BTreeMap<u32, Border> = BTreeMap::new();
        for (other, length) in across.into_iter().zip(lengths) {
            if let Some(other) = other.filter(|&other| other != facet) {
                borders.entry(other).or_default().length += length;
            }
        }
        let area = self.mesh.facet_area(facet as usize);
        let perimeter = lengths.iter().sum();
        Cluster { facets: vec![facet], rises: vec![0.0], hull, perimeter, area, concavity: 0.0, borders }
    }

    /// How concave two groups would be together; `None` for more than `most`.
    pub(super) fn concavity(&self, a: &Cluster, b: &Cluster, most: f64) -> Option<f64> {
        // A hull that grows is nowhere nearer to a place in it, so what was found before is where to begin.
        let mut deepest = a.concavity.max(b.concavity);
        let mut deep: Vec<(f64, u32)> = Vec::new();
        for (own, other) in [(a, b), (b, a)] {
            let rises = own.facets.iter().zip(&own.rises).map(|(&f, &rise)| (rise.max(self.rise(f, other)), f));
            deep.extend(rises.filter(|(rise, _)| *rise > deepest.max(self.slack)));
        }
        if deep.is_empty() {
            return Some(deepest);
        }
        let hull = together(a, b);
        deep.sort_by(|x, y| y.0.total_cmp(&x.0).then(x.1.cmp(&y.1)));
        for (rise, facet) in deep {
            if rise <= deepest {
                break;
            }
            deepest = deepest.max(self.way_out(&hull, facet).min(rise));
            if deepest > most {
                return None;
            }
        }
        Some(deepest)
    }

    /// Two groups as one; their borders with others are the caller's.
    pub(super) fn joined(&self, a: &Cluster, b: &Cluster, length: f64, concavity: f64) -> Cluster {
        let mut hull = together(a, b);
        hull.shed();
        let rises = |own: &Cluster, other: &Cluster| -> Vec<f64> {
            own.facets.iter().zip(&own.rises).map(|(&f, &rise)| rise.max(self.rise(f, other))).collect()
        };
        Cluster {
            facets: [&a.facets[..], &b.facets].concat(),
            rises: [rises(a, b), rises(b, a)].concat(),
            hull,
            perimeter: perimeter(a, b, length),
            area: a.area + b.area,
            concavity,
            borders: BTreeMap::new(),
        }
    }

    /// How far another group's hull reaches beyond a facet's plane, mm.
    fn rise(&self, facet: u32, other: &Cluster) -> f64 {
        let normal = &self.normals[facet as usize];
        let offset = normal.dot(&self.mesh.corners(facet as usize)[0]);
        other.hull.points().iter().map(|p| normal.dot(p) - offset).fold(0.0, f64::max)
    }

    /// The longest way out of the hull along a facet's normal, from its corners and its centre.
    fn way_out(&self, hull: &GrowingHull, facet: u32) -> f64 {
        let [a, b, c] = self.mesh.corners(facet as usize);
        let normal = &self.normals[facet as usize];
        [(a + b + c) / 3.0, a, b, c].iter().map(|p| hull.way_out(p, normal)).fold(0.0, f64::max)
    }
}

/// The least area that a group's shape is told by, mm²: a needle's counts as poor, not as none.
const LEAST_AREA: f64 = 1e-9;

/// `perimeter^2 / (4 pi area)` of two groups together: 1 for a disc, 0 for a closed surface.
pub(super) fn shape(a: &Cluster, b: &Cluster, length: f64) -> f64 {
    perimeter(a, b, length).powi(2) / (4.0 * std::f64::consts::PI * (a.area + b.area).max(LEAST_AREA))
}

fn perimeter(a: &Cluster, b: &Cluster, length: f64) -> f64 {
    (a.perimeter + b.perimeter - 2.0 * length).max(0.0)
}

/// The hull of both: the points of the smaller one are added to the larger one.
fn together(a: &Cluster, b: &Cluster) -> GrowingHull {
    let size = |c: &Cluster| (!c.hull.is_flat(), c.hull.points().len());
    let (large, small) = if size(b) > size(a) { (b, a) } else { (a, b) };
    let mut hull = large.hull.clone();
    hull.add(small.hull.points());
    hull
}
