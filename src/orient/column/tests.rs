//! Column volumes of solids whose supports are known by hand.

use super::*;
use crate::geom::Object;
use crate::mesh::TriangleMesh;
use crate::orient::sphere::lattice;

/// A box from `low` to `high` appended to a mesh.
fn add(points: &mut Vec<Vec3>, facets: &mut Vec<[u32; 3]>, low: [f64; 3], high: [f64; 3]) {
    let first = points.len() as u32;
    points.extend((0..8).map(|i| Vec3::from_fn(|k, _| if i >> k & 1 == 0 { low[k] } else { high[k] })));
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    facets.extend(quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).map(|f| f.map(|i| i + first)));
}

pub(super) fn boxes(all: &[([f64; 3], [f64; 3])]) -> Facets {
    let (mut points, mut facets) = (vec![], vec![]);
    all.iter().for_each(|(low, high)| add(&mut points, &mut facets, *low, *high));
    Facets::of(&TriangleMesh::<Object>::new(points, facets))
}

fn volume(facets: &Facets, up: Vec3, overhang: f64, resolution_mm: f64) -> f64 {
    SupportVolumeColumn { overhang: Angle::from_deg(overhang), resolution_mm }.value(facets, &up.normalize())
}

#[test]
fn a_box_on_its_face_needs_nothing_and_tilted_the_wedge_below() {
    let b = boxes(&[([0.0; 3], [20.0, 30.0, 40.0])]);
    assert_eq!(volume(&b, Vec3::z(), 45.0, 0.5), 0.0);
    // Leant by 30 degrees about x: the wedge below the bottom, 30 mm long, 20 wide; the long wall is at 30 degrees from
    // the vertical and needs support only below that threshold: a triangle of 40 mm at 60 degrees, and the block below.
    let (s, c) = 30f64.to_radians().sin_cos();
    let up = Vec3::new(0.0, -s, c);
    let wedge = 20.0 * 0.5 * (30.0 * s) * (30.0 * c);
    let got = volume(&b, up, 45.0, 0.05);
    assert!((got - wedge).abs() < 2e-3 * wedge, "{got} for {wedge}");
    let wall = 20.0 * 0.5 * (40.0 * s) * (40.0 * c);
    let got = volume(&b, up, 10.0, 0.05);
    assert!((got - wedge - wall).abs() < 2e-3 * (wedge + wall), "{got} for {}", wedge + wall);
}

#[test]
fn support_ends_on_the_part_where_the_part_is_below() {
    // A roof 10 mm above a floor that is half as wide: 10 mm columns on the floor, 15 mm on the bed.
    let b = boxes(&[([0.0; 3], [10.0, 20.0, 5.0]), ([0.0, 0.0, 15.0], [20.0, 20.0, 20.0])]);
    assert!((volume(&b, Vec3::z(), 45.0, 0.5) - (200.0 * 10.0 + 200.0 * 15.0)).abs() < 1e-9);
    // The other way up the roof is the floor: 10 mm columns on it below the smaller box.
    assert!((volume(&b, -Vec3::z(), 45.0, 0.5) - 200.0 * 10.0).abs() < 1e-9);
}

#[test]
fn touching_and_overlapping_pieces_are_one_solid() {
    let b = boxes(&[
        ([0.0; 3], [10.0, 10.0, 10.0]),
        ([0.0, 0.0, 10.0], [20.0, 10.0, 20.0]),
        ([5.0, 0.0, 5.0], [10.0, 10.0, 15.0]),
    ]);
    assert!((volume(&b, Vec3::z(), 0.0, 0.5) - 1000.0).abs() < 1e-9);
}

/// Witness: rays through every middle by the textbook, Moeller and Trumbore's intersection in floating point.
#[test]
fn agrees_with_rays_through_the_middles() {
    let points: Vec<Vec3> = (0..60).map(|i| lattice(i, 60) * (10.0 + 3.0 * (i as f64 * 1.7).sin())).collect();
    // A fan of tetrahedra about the origin is closed but self-crossing; use hull-like rings instead: a bipyramid.
    let ring: Vec<Vec3> = (0..12)
        .map(|i| {
            let a = i as f64 * std::f64::consts::TAU / 12.0;
            Vec3::new(a.cos() * (8.0 + 2.0 * (3.0 * a).sin()), a.sin() * 9.0, (2.0 * a).sin() * 3.0)
        })
        .collect();
    let mut vertices = ring.clone();
    vertices.push(points[3] * 1.3);
    vertices.push(Vec3::new(1.0, -1.0, 2.0));
    let facets: Vec<[u32; 3]> = (0..12u32)
        .flat_map(|i| {
            let j = (i + 1) % 12;
            [[i, j, 12], [j, i, 13]]
        })
        .collect();
    let mesh = TriangleMesh::<Object>::new(vertices, facets);
    let part = Facets::of(&mesh);
    for up in (0..40).map(|i| lattice(i, 40)) {
        let (width, got) = (0.2, volume(&part, up, 0.0, 0.2));
        let raster = Raster::of(&part, &up, width);
        let low = mesh.vertices().iter().map(|v| v.dot(&up)).fold(f64::INFINITY, f64::min);
        let mut wanted = 0.0;
        for column in 0..raster.first_len() {
            let from = raster.point(column, low - 1.0);
            let mut hits: Vec<(f64, bool)> =
                (0..mesh.facets().len()).filter_map(|f| ray(&mesh.corners(f), &from, &up)).collect();
            hits.sort_by(|a, b| a.0.total_cmp(&b.0));
            let (mut depth, mut below) = (0, 1.0);
            for (t, enters) in hits {
                depth += if enters { 1 } else { -1 };
                if enters && depth == 1 {
                    wanted += (t - below) * width * width;
                }
                if !enters && depth == 0 {
                    below = t;
                }
            }
        }
        assert!((got - wanted).abs() < 3e-3 * wanted + 1e-6, "{up:?}: {got} for {wanted}");
    }
}

fn ray([a, b, c]: &[Vec3; 3], from: &Vec3, up: &Vec3) -> Option<(f64, bool)> {
    let (e1, e2) = (b - a, c - a);
    let p = up.cross(&e2);
    let det = e1.dot(&p);
    let s = from - a;
    let u = s.dot(&p) / det;
    let q = s.cross(&e1);
    let v = up.dot(&q) / det;
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0).then(|| (e2.dot(&q) / det, e1.cross(&e2).dot(up) < 0.0))
}
