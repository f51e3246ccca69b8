//! Horizontal planes through a mesh.
//!
//! A vertex counts as above a plane when `z >= plane`, so every facet is crossed by exactly two edges or none, and a
//! vertex on the plane needs no case of its own. A crossing point belongs to its edge and is computed from the edge's
//! ends in one order: the two facets at the edge get the same bits, and the loops of a closed mesh close exactly.

use rayon::prelude::*;

use super::region::{Contour, FINE_UNITS, GridPoint, Region, distance_mm, enclosed, units};
use crate::geom::{Slot, Vec3};
use crate::mesh::{TriangleMesh, first_of_equals};
use crate::section::simplify::simplified;

/// What one plane cuts out of a mesh.
#[derive(Default)]
pub(super) struct Cut {
    /// The solid's section.
    pub(super) region: Region,
    /// Contours that an open mesh left open and that were closed by a straight line.
    pub(super) open: usize,
    /// The longest of these lines, mm.
    pub(super) longest_gap_mm: f64,
}

struct Segment {
    from: u64,
    to: u64,
    start: GridPoint,
    end: GridPoint,
}

/// One [`Cut`] for each of the ascending `planes` (z in mm).
pub(super) fn cuts(mesh: &TriangleMesh<Slot>, planes: &[f64]) -> Vec<Cut> {
    let ids = first_of_equals(mesh.vertices());
    let crossing = facets_by_plane(mesh, planes);
    planes.par_iter().zip(&crossing).map(|(&z, facets)| cut(mesh, &ids, facets, z)).collect()
}

fn facets_by_plane(mesh: &TriangleMesh<Slot>, planes: &[f64]) -> Vec<Vec<u32>> {
    let mut by_plane = vec![Vec::new(); planes.len()];
    for (index, facet) in (0u32..).zip(mesh.facets()) {
        let z = facet.map(|i| mesh.vertices()[i as usize].z);
        let [low, high] = [z[0].min(z[1]).min(z[2]), z[0].max(z[1]).max(z[2])];
        let first = planes.partition_point(|&plane| plane <= low);
        let after = planes.partition_point(|&plane| plane <= high);
        by_plane[first..after].iter_mut().for_each(|facets| facets.push(index));
    }
    by_plane
}

fn cut(mesh: &TriangleMesh<Slot>, ids: &[u32], facets: &[u32], z: f64) -> Cut {
    let mut segments: Vec<Segment> = facets.iter().filter_map(|&i| segment(mesh, ids, i, z)).collect();
    segments.sort_by_key(|s| s.from);
    let mut result = Cut::default();
    let mut contours = Vec::new();
    for (mut contour, closed) in chains(&segments) {
        if !closed {
            result.open += 1;
            let gap = contour.first().zip(contour.last()).map_or(0.0, |(&a, &b)| distance_mm(a, b));
            result.longest_gap_mm = result.longest_gap_mm.max(gap);
        }
        contour.dedup();
        let contour = simplified(&contour, FINE_UNITS);
        if contour.len() >= 3 {
            contours.push(contour);
        }
    }
    result.region = enclosed(&contours);
    result
}

/// The facet's line in the plane, solid on its left: from the edge that goes down to the edge that goes up.
fn segment(mesh: &TriangleMesh<Slot>, ids: &[u32], facet: u32, z: f64) -> Option<Segment> {
    let corners = mesh.facets()[facet as usize].map(|i| ids[i as usize]);
    let above = corners.map(|i| mesh.vertices()[i as usize].z >= z);
    let edge = |up: bool| {
        let i = (0..3).find(|&i| above[i] != up && above[(i + 1) % 3] == up)?;
        let (a, b) = (corners[i], corners[(i + 1) % 3]);
        Some([a.min(b), a.max(b)])
    };
    let (down, up) = (edge(false)?, edge(true)?);
    // Both the same: a facet without area, folded onto one edge.
    (down != up).then(|| Segment {
        from: key(down),
        to: key(up),
        start: crossing(mesh.vertices(), down, z),
        end: crossing(mesh.vertices(), up, z),
    })
}

fn key([low, high]: [u32; 2]) -> u64 {
    u64::from(low) << 32 | u64::from(high)
}

fn crossing(vertices: &[Vec3], [low, high]: [u32; 2], z: f64) -> GridPoint {
    let (a, b) = (vertices[low as usize], vertices[high as usize]);
    let p = a + (b - a) * ((z - a.z) / (b.z - a.z));
    GridPoint::new(units(p.x), units(p.y))
}

/// Joins segments (sorted by `from`) end to start; open chains come first, each with whether it closed.
fn chains(segments: &[Segment]) -> Vec<(Contour, bool)> {
    let mut ends: Vec<u64> = segments.iter().map(|s| s.to).collect();
    ends.sort_unstable();
    let has_no_predecessor = |i: &usize| ends.binary_search(&segments[*i].from).is_err();
    let heads = (0..segments.len()).filter(has_no_predecessor);
    let mut used = vec![false; segments.len()];
    let mut found = Vec::new();
    for start in heads.chain(0..segments.len()) {
        if !used[start] {
            found.push(follow(segments, start, &mut used));
        }
    }
    found
}

fn follow(segments: &[Segment], start: usize, used: &mut [bool]) -> (Contour, bool) {
    let mut contour = Contour::new();
    let mut at = start;
    loop {
        used[at] = true;
        contour.push(segments[at].start);
        let wanted = segments[at].to;
        if wanted == segments[start].from {
            return (contour, true);
        }
        let first = segments.partition_point(|s| s.from < wanted);
        let same = segments[first..].iter().take_while(|s| s.from == wanted).count();
        let Some(next) = (first..first + same).find(|&i| !used[i]) else {
            contour.push(segments[at].end);
            return (contour, false);
        };
        at = next;
    }
}

#[cfg(test)]
mod tests {
    use super::super::region::area_mm2;
    use super::*;
    use crate::slicing::testing::{block, frustum, prism, ring, together};

    #[test]
    fn vertices_on_the_planes_leave_every_loop_closed() {
        // Stacked rings at every multiple of 1 mm, planes through all of them.
        let rings: Vec<_> = (0..6).map(|i| ring(50.0, 50.0, 10.0 + f64::from(i % 2), 24)).collect();
        let parts: Vec<_> = (0..5).map(|i| frustum(&rings[i], &rings[i + 1], i as f64, i as f64 + 1.0)).collect();
        let planes: Vec<f64> = (0..=10).map(|i| f64::from(i) * 0.5).collect();
        for part in parts.iter().chain([&together(&parts)]) {
            assert!(cuts(part, &planes).iter().all(|cut| cut.open == 0));
        }
        let cut = cuts(&block([0.0; 3], [20.0, 20.0, 20.0]), &[0.0, 10.0, 20.0]);
        let areas: Vec<f64> = cut.iter().map(|c| area_mm2(&c.region)).collect();
        assert_eq!(areas, [0.0, 400.0, 400.0], "z = 0 has nothing below, z = 20 counts as below the top");
    }

    #[test]
    fn a_cylinder_of_256_sides_has_the_area_of_its_polygon_on_every_plane() {
        let sides = 256;
        let mesh = prism(&ring(60.0, 60.0, 15.0, sides), 0.0, 10.0);
        let wanted = 0.5 * f64::from(sides) * 225.0 * (std::f64::consts::TAU / f64::from(sides)).sin();
        for cut in cuts(&mesh, &[0.1, 3.3, 9.9]) {
            assert_eq!((cut.open, cut.region.len(), cut.region[0].len()), (0, 1, 1));
            assert!((area_mm2(&cut.region) - wanted).abs() < 0.03, "{}", area_mm2(&cut.region));
        }
    }

    #[test]
    fn layers_of_a_straight_column_are_the_same_to_the_bit() {
        let planes: Vec<f64> = (0..40).map(|i| 0.1 + 0.2 * f64::from(i)).collect();
        for sides in [3, 5, 12, 31] {
            let cuts = cuts(&prism(&ring(61.3, 57.7, 5.9, sides), 0.0, 8.0), &planes);
            cuts.iter().for_each(|cut| assert_eq!(cut.region, cuts[0].region, "{sides}"));
            assert_eq!(cuts[0].region[0][0].len(), sides as usize);
        }
    }

    #[test]
    fn an_open_mesh_is_closed_by_a_line_and_says_so() {
        let whole = block([0.0; 3], [20.0, 20.0, 20.0]);
        let open = TriangleMesh::new(whole.vertices().to_vec(), whole.facets()[2..].to_vec());
        let cut = &cuts(&open, &[10.0])[0];
        assert_eq!(cut.open, 1);
        assert!((cut.longest_gap_mm - 20.0).abs() < 1e-6, "{}", cut.longest_gap_mm);
        assert!((area_mm2(&cut.region) - 400.0).abs() < 1e-6);
    }
}
