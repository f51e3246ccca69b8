//! Shapes whose bridges, roofs and slopes are known by hand.

use super::*;
use crate::fixtures::prism;
use crate::geom::{Angle, Object};

fn rule() -> Rule {
    let overhang = Angle::from_deg(45.0);
    Rule { overhang, layer_mm: 0.2, line_mm: 0.45, bridge_mm: 8.0, tolerate_mm2: 1.0 }
}

/// What an outline in x and z, drawn along y, lays on nothing; its lowest facets lie on the table.
fn hanging(outline: &[[f64; 2]], y: [f64; 2], rule: &Rule) -> Vec<Patch> {
    let mesh: TriangleMesh<Object> = prism(outline, y);
    let foot = |f: usize| mesh.corners(f).iter().all(|p| p.z.abs() < 1e-9);
    let ground = Ground { table: true, ..Ground::default() };
    unsupported(&mesh, &Vec3::z(), &ground, foot, rule, false)
}

/// An arch with a flat ceiling `wide` mm across, 10 mm up.
fn arch(wide: f64) -> Vec<[f64; 2]> {
    let w = wide / 2.0;
    vec![[-w - 5.0, 0.0], [-w, 0.0], [-w, 10.0], [w, 10.0], [w, 0.0], [w + 5.0, 0.0], [w + 5.0, 15.0], [-w - 5.0, 15.0]]
}

#[test]
fn a_flat_ceiling_is_a_bridge_up_to_its_span() {
    assert_eq!(hanging(&arch(7.9), [0.0, 12.0], &rule()), []);
    // One side 8 mm wide is a bridge whatever its length; wider than both ways is none.
    let found = hanging(&arch(24.0), [0.0, 12.0], &rule());
    let [patch] = found[..] else { panic!("{found:?}") };
    // Two strips of 0.2 mm lie within 45 degrees of the posts.
    assert!((patch.area_mm2 - (24.0 - 0.4) * 12.0).abs() < 0.2, "{patch:?}");
    assert!((patch.at - Vec3::new(0.0, 6.0, 10.0)).norm() < 0.2, "{patch:?}");
    let Cause::Ceiling { size_mm: [long, wide], bridge_mm } = patch.cause else { panic!("{patch:?}") };
    assert!((long - 23.6).abs() < 1e-2 && (wide - 12.0).abs() < 1e-3 && bridge_mm == 8.0, "{patch:?}");
    assert_eq!(hanging(&arch(24.0), [0.0, 12.0], &Rule { bridge_mm: 24.0, ..rule() }), []);
}

#[test]
fn a_shelf_that_is_held_at_one_side_is_no_bridge() {
    let shelf =
        |out: f64| vec![[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [10.0 + out, 10.0], [10.0 + out, 14.0], [0.0, 14.0]];
    assert_eq!(hanging(&shelf(0.42), [0.0, 12.0], &rule()), []);
    // 0.8 mm beyond 45 degrees; along 1 mm that is tolerated.
    assert_eq!(hanging(&shelf(1.0), [0.0, 1.0], &rule()), []);
    let found = hanging(&shelf(1.0), [0.0, 12.0], &rule());
    assert!(found.len() == 1 && (found[0].area_mm2 - 0.8 * 12.0).abs() < 0.05, "{found:?}");
}

#[test]
fn a_slope_passes_up_to_the_angle_and_half_a_line_more_once() {
    // So high, leaning out by so many degrees from the vertical.
    let lean = |deg: f64, high: f64| {
        let out = high * f64::to_radians(deg).tan();
        hanging(&[[0.0, 0.0], [60.0, 0.0], [60.0 + out, high], [0.0, high]], [0.0, 10.0], &rule())
    };
    assert_eq!((lean(45.4, 20.0), lean(30.0, 20.0)), (Vec::new(), Vec::new()));
    // 60 degrees go out 0.146 mm a layer more than 45: one such layer passes, the second is 0.29 mm too far.
    assert_eq!(lean(60.0, 0.5), []);
    let found = lean(60.0, 20.0);
    let wanted = 10.0 * 99.0 * 0.2 * (60_f64.to_radians().tan() - 45.5_f64.to_radians().tan());
    assert!(found.len() == 1 && (found[0].area_mm2 - wanted).abs() < 0.03 * wanted, "{found:?} for {wanted}");
    assert!(matches!(found[0].cause, Cause::Slope { high_mm, .. } if (high_mm - 19.8).abs() < 0.5), "{found:?}");
    assert!(!lean(52.0, 20.0).is_empty());
    // Everything may overhang.
    let all = Rule { overhang: Angle::from_deg(90.0), ..rule() };
    assert_eq!(hanging(&arch(30.0), [0.0, 30.0], &all), []);
}

/// A block with a round hole through it along y.
fn drilled(radius: f64) -> Vec<[f64; 2]> {
    // One outline: in from the right side, around the hole, and back along the same cut.
    let ring = (0..=64).map(|k| (std::f64::consts::TAU * f64::from(k) / 64.0).sin_cos());
    let mut outline = vec![[-15.0, 0.0], [15.0, 0.0], [15.0, 14.999]];
    outline.extend(ring.map(|(s, c)| [radius * c, 15.0 - radius * s]));
    outline.extend([[15.0, 15.001], [15.0, 30.0], [-15.0, 30.0]]);
    outline
}

#[test]
fn roofs_of_round_holes_are_bridged_though_a_sliver_is_open() {
    for radius in [0.5, 1.0, 1.6, 2.5, 3.9] {
        for shift in 0..5 {
            let up = 0.04 * f64::from(shift);
            let outline: Vec<[f64; 2]> =
                drilled(radius).into_iter().map(|[x, z]| [x, if z > 0.0 { z + up } else { z }]).collect();
            assert_eq!(hanging(&outline, [0.0, 30.0], &rule()), [], "radius {radius}, {up} mm higher");
        }
    }
    // Where the layers of this one reach too far its roof is 11 mm wide still, which is more than a bridge.
    assert!(!hanging(&drilled(12.0), [0.0, 30.0], &rule()).is_empty());
}

#[test]
fn what_lies_on_something_is_carried_there_only() {
    // A beam on a post that is narrower.
    let mesh: TriangleMesh<Object> = prism(&[[0.0, 5.0], [30.0, 5.0], [30.0, 10.0], [0.0, 10.0]], [0.0, 10.0]);
    let own = (0..mesh.facets().len()).map(|f| mesh.corners(f)).filter(|c| c.iter().all(|p| p.z == 5.0)).collect();
    let post = |x: f64| {
        let [a, b, c, d] = [[0.0, 0.0], [x, 0.0], [x, 10.0], [0.0, 10.0]].map(|[x, y]| Vec3::new(x, y, 5.0));
        vec![[a, b, c], [a, c, d]]
    };
    let found = |below: Vec<[Vec3; 3]>| {
        let ground = Ground { footings: vec![Footing { own: Vec::clone(&own), below }], ..Ground::default() };
        unsupported(&mesh, &Vec3::z(), &ground, |_| false, &rule(), false)
    };
    assert_eq!(found(Vec::new()), []);
    let half = found(post(10.0));
    assert!(half.len() == 1 && (half[0].area_mm2 - (20.0 - 0.2) * 10.0).abs() < 0.1, "{half:?}");
    let none = unsupported(&mesh, &Vec3::z(), &Ground::default(), |_| false, &rule(), false);
    assert!(none.len() == 1 && none[0].cause == Cause::Island && (none[0].area_mm2 - 300.0).abs() < 1e-3, "{none:?}");
}
