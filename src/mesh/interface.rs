//! Surfaces that two parts share.

use std::collections::BTreeMap;

use super::box_tree::BoxTree;
use super::{Part, TriangleMesh, overlap};
use crate::geom::{Bounds, Vec3};

/// Facets count as side by side up to this distance, mm: it absorbs f32 coordinates and CAD clearances, and is well
/// below a layer's height.
pub const INTERFACE_GAP_MM: f64 = 0.05;
/// Facets face each other up to this angle between one normal and the other reversed, degrees: it absorbs the
/// rounding of small facets.
pub const INTERFACE_ANGLE_DEG: f64 = 2.0;
/// Shared areas of two parts that add up to less than this, mm², are touching corners and rounding: a nozzle's bead
/// covers some hundred times as much.
pub const INTERFACE_AREA_MM2: f64 = 1e-3;

/// A surface that two parts share.
#[derive(Clone, Debug, PartialEq)]
pub struct Interface {
    /// The part with the lower id.
    pub a: usize,
    /// The part with the higher id.
    pub b: usize,
    /// The shared area, mm².
    pub area_mm2: f64,
    /// The mean unit normal, area-weighted, pointing out of `a` into `b`; zero where a closed interface (a pin in its
    /// hole) has none.
    pub normal: Vec3,
    /// Facets of `a`'s mesh and the area of each that is shared, mm²; ascending.
    pub facets_a: Vec<(usize, f64)>,
    /// Facets of `b`'s mesh and the area of each that is shared, mm²; ascending.
    pub facets_b: Vec<(usize, f64)>,
}

/// All interfaces, by ascending `(a, b)`.
pub(super) fn interfaces(parts: &[Part]) -> Vec<Interface> {
    let bounds: Vec<Bounds> = parts.iter().map(|part| part.mesh.bounds()).collect();
    let mut trees: Vec<Option<BoxTree>> = parts.iter().map(|_| None).collect();
    let mut found = Vec::new();
    for a in 0..parts.len() {
        for b in a + 1..parts.len() {
            if !bounds[a].inflated(INTERFACE_GAP_MM).meets(&bounds[b]) {
                continue;
            }
            for id in [a, b] {
                trees[id].get_or_insert_with(|| BoxTree::new(&parts[id].mesh));
            }
            let (Some(tree_a), Some(tree_b)) = (&trees[a], &trees[b]) else { continue };
            let near = Near { parts: [&parts[a], &parts[b]], trees: [tree_a, tree_b] };
            found.extend(near.interface(&bounds[b].inflated(INTERFACE_GAP_MM)));
        }
    }
    found
}

/// Two parts whose boxes meet.
struct Near<'a> {
    parts: [&'a Part; 2],
    trees: [&'a BoxTree; 2],
}

impl Near<'_> {
    /// What they share; `None` for less than [`INTERFACE_AREA_MM2`]. `reach` is the second part's box and the gap.
    fn interface(&self, reach: &Bounds) -> Option<Interface> {
        let [part_a, part_b] = self.parts;
        let (mut facets_a, mut facets_b) = (BTreeMap::new(), BTreeMap::new());
        let mut normal = Vec3::zeros();
        let mut candidates = Vec::new();
        self.trees[0].visit(reach, |facet| candidates.push(facet));
        candidates.sort_unstable();
        for facet in candidates {
            let Some(outward) = part_a.mesh.normal(facet) else { continue };
            let mut others = Vec::new();
            let around = self.trees[0].bounds_of(facet).inflated(INTERFACE_GAP_MM);
            self.trees[1].visit(&around, |other| others.push(other));
            others.sort_unstable();
            for other in others {
                let area = facing_area(&part_a.mesh, facet, &outward, &part_b.mesh, other);
                if area > 0.0 {
                    *facets_a.entry(facet).or_insert(0.0) += area;
                    *facets_b.entry(other).or_insert(0.0) += area;
                    normal += outward * area;
                }
            }
        }
        let area_mm2: f64 = facets_a.values().sum();
        (area_mm2 > INTERFACE_AREA_MM2).then(|| Interface {
            a: part_a.id,
            b: part_b.id,
            area_mm2,
            // Rounding alone must not give a closed interface a direction.
            normal: normal.try_normalize(1e-6 * area_mm2).unwrap_or_default(),
            facets_a: facets_a.into_iter().collect(),
            facets_b: facets_b.into_iter().collect(),
        })
    }
}

/// The area of `facet` of `a` that faces `other` of `b` side by side, mm².
fn facing_area<F>(a: &TriangleMesh<F>, facet: usize, outward: &Vec3, b: &TriangleMesh<F>, other: usize) -> f64 {
    let Some(opposite) = b.normal(other) else { return 0.0 };
    if outward.dot(&opposite) > -INTERFACE_ANGLE_DEG.to_radians().cos() {
        return 0.0;
    }
    let corners = b.corners(other);
    let shared = overlap::shared(&a.corners(facet), outward, &corners);
    let gap = (corners[0] - shared.centre).dot(&opposite);
    if gap.abs() <= INTERFACE_GAP_MM { shared.area } else { 0.0 }
}
