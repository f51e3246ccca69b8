//! Whether a point lies inside a closed surface.

use super::Part;
use super::box_tree::BoxTree;
use crate::geom::{Bounds, Vec3};

/// A point is on a facet, and the winding number says nothing, where the facet fills half the sky up to this: it covers
/// f32 corners of coincident faces that are cut into triangles differently.
const ON_FACET: f64 = 1e-5;

/// How often the shell winds around `at`: the solid angles of its facets over the full sphere's (Van Oosterom and
/// Strackee 1983); `None` on the shell. Unlike a ray's crossings it has no unlucky directions.
pub(super) fn winding(vertices: &[Vec3], facets: &[[u32; 3]], at: &Vec3) -> Option<f64> {
    let mut half_angles = 0.0;
    for facet in facets {
        let [a, b, c] = facet.map(|index| vertices[index as usize] - at);
        let (la, lb, lc) = (a.norm(), b.norm(), c.norm());
        let all = la * lb * lc;
        let above = a.dot(&b.cross(&c));
        let below = all + a.dot(&b) * lc + b.dot(&c) * la + c.dot(&a) * lb;
        if above.abs() <= ON_FACET * all && below <= ON_FACET * all {
            return None;
        }
        half_angles += above.atan2(below);
    }
    Some(half_angles / std::f64::consts::TAU)
}

/// How deep, in mm, two parts must reach into each other to count as overlapping rather than touching.
const OVERLAP_DEPTH_MM: f64 = 0.1;
/// Facets of each part that are looked at; a crossing smaller than the mesh between them goes unseen.
const PROBES: usize = 24;

/// What tells such a warning from all others.
const OVERLAP: &str = " overlap, and what both fill would be printed twice";

/// Whether a model's warning is about parts that overlap.
pub fn is_overlap(warning: &str) -> bool {
    warning.contains(OVERLAP)
}

/// Pairs that are looked at: so many, and a few for each part, so that the cost grows with the file and not with its square.
const MOST_PAIRS: usize = 10_000;
const PAIRS_A_PART: usize = 4;
/// Pairs that are named.
const MOST_NAMED: usize = 100;

/// A warning for every two parts seen to fill the same space, by ascending ids: the first 100, and one for all others.
///
/// Looks just below some facets of each whether the other's material is there as well: a hint that costs little, no
/// proof of the contrary.
pub(super) fn overlaps(parts: &[Part]) -> Vec<String> {
    let bounds: Vec<Bounds> = parts.iter().map(|part| part.mesh.bounds().inflated(-OVERLAP_DEPTH_MM)).collect();
    // Of what is thinner than that the box is turned inside out.
    let proper = |turned: &Bounds| Bounds::of([turned.min, turned.max]);
    let boxes = BoxTree::of_boxes(bounds.iter().map(proper).collect());
    let mut left = MOST_PAIRS + PAIRS_A_PART * parts.len();
    let (mut warnings, mut near, mut unnamed) = (Vec::new(), Vec::new(), 0);
    for (a, one) in parts.iter().enumerate() {
        boxes.later(&proper(&bounds[a]), a, &mut near);
        near.retain(|&b| bounds[a].meets(&bounds[b]));
        near.truncate(left);
        left -= near.len();
        for (b, other) in near.iter().map(|&b| (b, &parts[b])).filter(|(_, other)| seen_to_overlap(one, other)) {
            if warnings.len() >= MOST_NAMED {
                unnamed += 1;
                continue;
            }
            let names = format!("parts {a} ({}) and {b} ({})", one.name, other.name);
            warnings.push(format!("{names}{OVERLAP}; cut one from the other"));
        }
        if left == 0 {
            break;
        }
    }
    if unnamed > 0 {
        let at_least = if left == 0 { "at least " } else { "" };
        warnings.push(format!("{at_least}{unnamed} more pairs of parts{OVERLAP}"));
    }
    warnings
}

/// Whether two parts are seen to fill the same space, deeper than 0.1 mm; `false` proves nothing.
pub fn seen_to_overlap(one: &Part, other: &Part) -> bool {
    let [own, theirs] = [one, other].map(|part| part.mesh.bounds().inflated(-OVERLAP_DEPTH_MM));
    reaches_into(one, other, &theirs) || reaches_into(other, one, &own)
}

fn reaches_into(one: &Part, other: &Part, bounds: &Bounds) -> bool {
    let mesh = &one.mesh;
    let step = mesh.facets().len().div_ceil(PROBES).max(1);
    (0..mesh.facets().len()).step_by(step).any(|facet| {
        let Some(outward) = mesh.normal(facet) else { return false };
        let below = mesh.corners(facet).iter().sum::<Vec3>() / 3.0 - outward * OVERLAP_DEPTH_MM;
        let within =
            |part: &Part| winding(part.mesh.vertices(), part.mesh.facets(), &below).is_some_and(|times| times > 0.5);
        bounds.holds(&below) && within(other) && within(one)
    })
}

#[cfg(test)]
mod tests {
    use super::{MOST_NAMED, is_overlap, overlaps, winding};
    use crate::fixtures::solid_box;
    use crate::geom::Vec3;
    use crate::mesh::Model;

    #[test]
    fn boxes_over_each_other_are_named_up_to_a_hundred_pairs_and_counted() {
        let over = |count: usize| {
            let at = |k: usize| Vec3::repeat(0.01 * k as f64);
            let boxes = (0..count).map(|k| (format!("b{k}"), solid_box(at(k), at(k) + Vec3::repeat(20.0))));
            overlaps(&Model::from_parts(boxes.collect()).parts)
        };
        assert_eq!(over(1), Vec::<String>::new());
        let few = over(14);
        assert!(few.len() == 91 && few.iter().all(|text| is_overlap(text)), "{few:?}");
        assert!(few[0].starts_with("parts 0 (b0) and 1 (b1) ") && few[90].starts_with("parts 12 (b12) and 13 (b13) "));
        // 100 of 120 and 4,950 pairs have names.
        for (count, rest) in [(16, "20 more pairs"), (100, "4850 more pairs")] {
            let many = over(count);
            assert_eq!(many.len(), MOST_NAMED + 1);
            assert!(many[MOST_NAMED].starts_with(rest) && is_overlap(&many[MOST_NAMED]), "{}", many[MOST_NAMED]);
        }
        // Of 19,900 not all are looked at.
        assert!(over(200)[MOST_NAMED].contains(" 10700 more"), "{}", over(200)[MOST_NAMED]);
    }

    #[test]
    fn a_shell_winds_once_around_its_inside() {
        let corner = [Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()];
        let facets = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        let at = |x: f64, y: f64, z: f64| winding(&corner, &facets, &Vec3::new(x, y, z));
        assert!((at(0.1, 0.2, 0.3).unwrap() - 1.0).abs() < 1e-12);
        assert!(at(0.4, 0.4, 0.4).unwrap().abs() < 1e-12);
        assert!(at(0.2, 0.2, -1e-3).unwrap().abs() < 1e-12);
        assert!(at(1.5, 0.0, 0.0).unwrap().abs() < 1e-12, "beside an edge, in its line");
        assert_eq!(at(0.2, 0.2, 0.0), None);
        assert_eq!(at(0.5, 0.0, 0.0), None);
        assert_eq!(at(1.0, 0.0, 0.0), None);
    }
}
