//! Surfaces that two parts share.

use std::collections::BTreeMap;

use super::box_tree::BoxTree;
use super::{Neighbours, Part, TriangleMesh, overlap};
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

/// So many pairs of this many parts may have facets near one another: more than any assembly has, and what each costs grows with the parts alone.
pub(super) fn most_pairs(parts: usize) -> usize {
    NEIGHBOURS * parts + MANY_PAIRS
}

/// All interfaces, by ascending `(a, b)`; `None` where more than `most` pairs of parts have facets near one another.
pub(super) fn interfaces(parts: &[Part], most: usize) -> Option<Vec<Interface>> {
    let bounds: Vec<Bounds> = parts.iter().map(|part| part.mesh.bounds()).collect();
    let mut trees: Vec<Option<BoxTree>> = parts.iter().map(|_| None).collect();
    let mut found = Vec::new();
    for (a, b) in pairs(parts, &bounds, most)? {
        for id in [a, b] {
            trees[id].get_or_insert_with(|| BoxTree::new(&parts[id].mesh));
        }
        let (Some(tree_a), Some(tree_b)) = (&trees[a], &trees[b]) else { continue };
        let two = Near { parts: [&parts[a], &parts[b]], trees: [tree_a, tree_b] };
        found.extend(two.interface(&bounds[b].inflated(INTERFACE_GAP_MM)));
    }
    Some(found)
}

/// Pairs of parts that are near one another, for each part: a cube in a pile of cubes has 26 neighbours.
const NEIGHBOURS: usize = 100;
const MANY_PAIRS: usize = 10_000;

/// Pairs of parts whose boxes meet, for each part, up to which these are looked at one by one.
const PAIRS_A_PART: usize = 8;
const FEW_PAIRS: usize = 500;
/// How far from each other facets may be that share an interface: a little more than the gap, for those that lean.
const REACH: f64 = 1.01;

/// The pairs that may share a face, ascending, the lower id first: parts whose boxes meet; where these are many, as of parts in each
/// other, those of which a facet is near one of the other's, up to `most`.
fn pairs(parts: &[Part], bounds: &[Bounds], most: usize) -> Option<Vec<(usize, usize)>> {
    let boxes = BoxTree::of_boxes(bounds.to_vec());
    let few = PAIRS_A_PART * parts.len() + FEW_PAIRS;
    let (mut all, mut near) = (Vec::new(), Vec::new());
    for (a, own) in bounds.iter().enumerate() {
        boxes.later(&own.inflated(INTERFACE_GAP_MM), a, &mut near);
        if all.len() + near.len() > few {
            return Neighbours::of(parts).within(REACH * INTERFACE_GAP_MM, most);
        }
        all.extend(near.iter().map(|&b| (a, b)));
    }
    Some(all)
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
        let trees = [self.trees[0], self.trees[1]];
        facing([&part_a.mesh, &part_b.mesh], trees, reach, &Apart::INTERFACE, |found| {
            *facets_a.entry(found.facets[0]).or_insert(0.0) += found.area_mm2;
            *facets_b.entry(found.facets[1]).or_insert(0.0) += found.area_mm2;
            normal += found.outward * found.area_mm2;
        });
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

/// How far from each other, and how far from parallel, facets may be that face each other.
#[derive(Clone, Copy, Debug)]
struct Apart {
    /// Least and greatest distance, mm, along the second facet's normal; negative where they reach into each other.
    mm: [f64; 2],
    /// Between one normal and the other reversed, degrees.
    deg: f64,
}

impl Apart {
    const INTERFACE: Self = Self { mm: [-INTERFACE_GAP_MM, INTERFACE_GAP_MM], deg: INTERFACE_ANGLE_DEG };
}

/// A facet of one mesh and one of another that face each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Facing {
    /// Their numbers.
    pub facets: [usize; 2],
    /// The first one's outward unit normal.
    pub outward: Vec3,
    /// What the first one has of the second one's shadow, mm².
    pub area_mm2: f64,
    /// From the first one there to the second, mm.
    pub gap_mm: f64,
}

/// The facets of two closed meshes that face each other with more than the interfaces' gap and at most `most_mm` between them,
/// `deg` degrees or less from parallel; by ascending facets. `trees` are the meshes' own.
pub fn facing_across<F>(meshes: [&TriangleMesh<F>; 2], trees: [&BoxTree; 2], most_mm: f64, deg: f64) -> Vec<Facing> {
    let reach = meshes[1].bounds().inflated(most_mm);
    let mut found = Vec::new();
    if meshes[0].bounds().meets(&reach) {
        let apart = Apart { mm: [INTERFACE_GAP_MM, most_mm], deg };
        facing(meshes, trees, &reach, &apart, |one| {
            if one.gap_mm > INTERFACE_GAP_MM {
                found.push(one);
            }
        });
    }
    found
}

/// Hands every two facets that face each other to `each`; `reach` is the second mesh's box, grown by the greatest distance.
fn facing<F>(
    [a, b]: [&TriangleMesh<F>; 2],
    trees: [&BoxTree; 2],
    reach: &Bounds,
    apart: &Apart,
    mut each: impl FnMut(Facing),
) {
    let (grown, least) = (apart.mm[1], apart.deg.to_radians().cos());
    let mut candidates = Vec::new();
    trees[0].visit(reach, |facet| candidates.push(facet));
    candidates.sort_unstable();
    for facet in candidates {
        let Some(outward) = a.normal(facet) else { continue };
        let mut others = Vec::new();
        trees[1].visit(&trees[0].bounds_of(facet).inflated(grown), |other| others.push(other));
        others.sort_unstable();
        for other in others {
            let Some((area_mm2, gap_mm)) = shared(a, facet, &outward, b, other, apart.mm, least) else { continue };
            each(Facing { facets: [facet, other], outward, area_mm2, gap_mm });
        }
    }
}

/// The area of `facet` of `a` that faces `other` of `b`, mm², and how far that is, mm; `None` where they do not face each other.
fn shared<F>(
    a: &TriangleMesh<F>,
    facet: usize,
    outward: &Vec3,
    b: &TriangleMesh<F>,
    other: usize,
    [least, most]: [f64; 2],
    least_cos: f64,
) -> Option<(f64, f64)> {
    let opposite = b.normal(other)?;
    if outward.dot(&opposite) > -least_cos {
        return None;
    }
    let (own, corners) = (a.corners(facet), b.corners(other));
    // The centre of what they share lies between the corners: a cheap no for most.
    let above = own.map(|corner| (corner - corners[0]).dot(&opposite));
    if above.iter().all(|mm| *mm < least) || above.iter().all(|mm| *mm > most) {
        return None;
    }
    let shared = overlap::shared(&own, outward, &corners);
    let gap_mm = (shared.centre - corners[0]).dot(&opposite);
    (shared.area > 0.0 && (least..=most).contains(&gap_mm)).then_some((shared.area, gap_mm))
}
