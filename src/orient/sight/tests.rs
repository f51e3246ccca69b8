//! The formulas of Boogers (2024), chapter 4, written out without trees, sets or masks; and gradients by differences.

use super::super::sphere::{lattice, tangents};
use super::super::{Certified, ObjectiveSettings, Search, objective};
use super::*;
use crate::geom::Object;
use crate::mesh::TriangleMesh;

/// A block of 3 x 3 x 3 cells of 4 mm with a groove of one cell through it, as in Boogers (2024) figure 4.5a; each cell's side is
/// 2 `cut^2` facets.
fn grooved(cut: usize) -> TriangleMesh<Object> {
    let solid = |x: i32, y: i32, z: i32| {
        (0..3).contains(&x) && (0..3).contains(&y) && (0..3).contains(&z) && !(x == 1 && z >= 1)
    };
    let (mut points, mut facets) = (Vec::new(), Vec::new());
    for (x, y, z) in (0..27).map(|i| (i % 3, i / 3 % 3, i / 9)).filter(|&(x, y, z)| solid(x, y, z)) {
        for (axis, sense) in (0..3).flat_map(|axis| [(axis, -1), (axis, 1)]) {
            let mut beside = [x, y, z];
            beside[axis] += sense;
            if solid(beside[0], beside[1], beside[2]) {
                continue;
            }
            let (u, v) = (Vec3::ith((axis + 1) % 3, 4.0 / cut as f64), Vec3::ith((axis + 2) % 3, 4.0 / cut as f64));
            let corner = Vec3::new(f64::from(x), f64::from(y), f64::from(z)) * 4.0
                + Vec3::ith(axis, if sense > 0 { 4.0 } else { 0.0 });
            let (u, v) = if sense > 0 { (u, v) } else { (v, u) };
            for (i, j) in (0..cut * cut).map(|k| ((k % cut) as f64, (k / cut) as f64)) {
                let first = points.len() as u32;
                points.extend([
                    corner + u * i + v * j,
                    corner + u * (i + 1.0) + v * j,
                    corner + u * (i + 1.0) + v * (j + 1.0),
                    corner + u * i + v * (j + 1.0),
                ]);
                facets.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
            }
        }
    }
    TriangleMesh::new(points, facets)
}

fn smoothing() -> Smoothing {
    Smoothing { overhang: Angle::from_deg(0.0), carrying: Angle::from_deg(10.0), k: 8.0, w: 3.0 }
}

/// Equations 3.24, 3.29 (without 1/n), 4.1 to 4.8 as they are printed, one facet after the other.
fn printed(mesh: &TriangleMesh<Object>, up: &Vec3, s: &Smoothing) -> [f64; 2] {
    let count = mesh.facets().len();
    let centre = |i: usize| mesh.corners(i).iter().sum::<Vec3>() / 3.0;
    let heaviside = |x: f64, t: f64| 1.0 / (1.0 + (-2.0 * s.k * (x - t)).exp());
    let bed = -mesh.vertices().iter().map(|p| (-s.w * p.dot(up)).exp()).sum::<f64>().ln() / s.w;
    let down = |i: usize| heaviside(-mesh.normal(i).unwrap().dot(up), s.overhang.rad().sin());
    let (mut volume, mut interface) = (0.0, 0.0);
    for i in 0..count {
        let (mut sum, mut members) = (0.0, 0);
        for j in (0..count).filter(|&j| j != i) {
            let between = centre(j) - centre(i);
            if between.dot(&mesh.normal(i).unwrap()) > 0.0
                && (0..count).all(|f| f == i || f == j || !cuts(&mesh.corners(f), centre(i), centre(j)))
            {
                members += 1;
                sum += up.dot(&between) / between.norm() * down(j);
            }
        }
        let along = mesh.normal(i).unwrap().dot(up);
        let mask = down(i)
            + if members > 0 { heaviside(along, s.carrying.rad().sin()) / f64::from(members) * sum } else { 0.0 };
        volume += mask * -mesh.facet_area(i) * along * (centre(i).dot(up) - bed);
        interface += mask * mesh.facet_area(i);
    }
    [volume, interface]
}

/// Whether a segment cuts a triangle: by the signs of volumes.
fn cuts([a, b, c]: &[Vec3; 3], from: Vec3, to: Vec3) -> bool {
    let volume = |p: &Vec3, q: &Vec3, r: &Vec3, s: &Vec3| (q - p).cross(&(r - p)).dot(&(s - p));
    let (one, other) = (volume(a, b, c, &from), volume(a, b, c, &to));
    if one * other >= 0.0 {
        return false;
    }
    let sides = [volume(&from, &to, a, b), volume(&from, &to, b, c), volume(&from, &to, c, a)];
    sides.iter().all(|v| *v >= 0.0) || sides.iter().all(|v| *v <= 0.0)
}

/// The same bent a little, so that no line of sight runs through an edge.
fn bent(cut: usize) -> TriangleMesh<Object> {
    let mesh = grooved(cut);
    let bend = |p: &Vec3| {
        p + Vec3::new((0.31 * p.y + 0.2 * p.z).sin(), (0.27 * p.z - 0.4 * p.x).sin(), (0.23 * p.x * p.y / 12.0).sin())
            * 0.7
    };
    TriangleMesh::new(mesh.vertices().iter().map(bend).collect(), mesh.facets().to_vec())
}

#[test]
fn volume_and_interface_are_the_printed_formulas() {
    let mesh = bent(2);
    let facets = Facets::of(&mesh);
    for up in (0..4).map(|i| lattice(i, 4)) {
        let wanted = printed(&mesh, &up, &smoothing());
        for (cost, wanted) in [Cost::Volume, Cost::Interface].into_iter().zip(wanted) {
            let f = Supported { cost, smoothing: smoothing(), resolution_mm: 0.5 };
            let got = f.value(&facets, &up);
            assert!((got - wanted).abs() < 1e-9 * wanted.abs(), "{cost:?} {up:?}: {got} for {wanted}");
            let by_facet: f64 = f.costs(&facets, &up).iter().sum();
            assert!((by_facet - wanted).abs() < 1e-9 * wanted.abs(), "{cost:?}: {by_facet}");
        }
    }
}

#[test]
fn gradients_are_those_of_the_formulas() {
    let facets = Facets::of(&bent(2));
    for cost in [Cost::Volume, Cost::Interface, Cost::Convex] {
        let f = Supported { cost, smoothing: smoothing(), resolution_mm: 0.5 };
        for up in (0..40).map(|i| lattice(i, 40)) {
            let gradient = f.gradient(&facets, &up).unwrap();
            for t in tangents(&up) {
                let at = |s: f64| f.value(&facets, &(up * s.cos() + t * s.sin()));
                let near = |s: f64| (at(s) - at(-s)) / (2.0 * s);
                let slope = (4.0 * near(1e-4) - near(2e-4)) / 3.0;
                assert!((slope - gradient.dot(&t)).abs() < 1e-7 * (gradient.norm() + 1.0), "{cost:?} {up:?}");
            }
        }
    }
}

#[test]
fn alexander_of_a_grooved_block_is_worked_out_by_hand() {
    let mesh = grooved(2);
    let f = Alexander { layer_mm: 0.2, sides_mm: [0.5, 0.5], penalty_mm: 3.0, overhang: Angle::from_deg(45.0) };
    let facets = Facets::of(&mesh);
    // Groove up: nothing overhangs but the foot, which lies on the bed; all level facets are flat, all others walls.
    assert!(f.value(&facets, &Vec3::z()).abs() < 1e-9);
    // On its side (x up): the groove's wall at x = 8 hangs, 12 x 8 mm; the one at x = 4 is touched from above, each of its
    // facets (2 mm²) over 0.25 mm²; the notch is 8 mm deep, 12 wide: 48 facets.
    let got = f.value(&facets, &Vec3::x());
    assert!((got - 3.0 * (96.0 + 48.0 * 0.25)).abs() < 1e-9, "{got}");
}

#[test]
fn bounds_hold_and_are_not_empty() {
    let facets = Facets::of(&grooved(1));
    for name in ["support-volume", "interface-area", "support-volume-convex-smooth", "alexander"] {
        let f = objective(name, &ObjectiveSettings::default()).unwrap();
        let found = Certified { gap: 1e-2, budget: 4000 }.search(f.as_ref(), &facets);
        let lower = found.lower_bound.unwrap();
        assert!(lower.is_finite() && lower <= found.minima[0].value, "{name}");
        for up in (0..3000).map(|i| lattice(i, 3000)) {
            assert!(f.value(&facets, &up) >= lower, "{name} {up:?}");
        }
    }
}

/// Above the limit the columns stand in for the sets; the yardstick measures the gaps themselves.
#[test]
fn on_large_parts_the_volume_is_within_five_percent_of_the_column_yardstick() {
    let facets = Facets::of(&bent(14));
    assert!(facets.each.len() >= FIELD_FACETS);
    let smoothing = Smoothing { overhang: Angle::from_deg(0.0), k: 20.0, w: 400.0, ..smoothing() };
    let f = Supported { cost: Cost::Volume, smoothing, resolution_mm: 0.05 };
    let column = crate::orient::SupportVolumeColumn { overhang: Angle::from_deg(0.0), resolution_mm: 0.05 };
    for up in (0..12).map(|i| lattice(i, 12)) {
        let (got, wanted) = (f.value(&facets, &up), column.value(&facets, &up));
        assert!((got - wanted).abs() < 0.05 * wanted, "{up:?}: {got} for {wanted}");
        assert_eq!(f.gradient(&facets, &up), None);
    }
}
