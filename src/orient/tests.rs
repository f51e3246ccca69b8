//! Values by hand and gradients against central differences, for every objective.

use super::sphere::{lattice, tangents};
use super::*;
use crate::geom::Object;
use crate::mesh::TriangleMesh;

/// A box of 2 x 3 x 4 mm from `at`, 12 facets.
fn brick(at: Vec3) -> Facets {
    let corner = |i: usize| at + Vec3::new([0.0, 2.0][i & 1], [0.0, 3.0][i >> 1 & 1], [0.0, 4.0][i >> 2 & 1]);
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let facets = quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect();
    Facets::of(&TriangleMesh::<Object>::new((0..8).map(corner).collect(), facets))
}

/// An irregular solid: an octahedron-like hull of 8 facets of different shapes.
fn stone() -> Facets {
    let points =
        [[3.0, 0.2, 0.1], [0.3, 2.0, -0.2], [-0.1, 0.4, 4.0], [-2.5, 0.3, 0.6], [0.2, -1.7, 0.3], [0.4, 0.1, -1.9]];
    let facets = vec![[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]];
    Facets::of(&TriangleMesh::<Object>::new(points.map(Vec3::from).to_vec(), facets))
}

fn value(name: &str, facets: &Facets, up: Vec3) -> f64 {
    named(name, 0.2).unwrap().value(facets, &up.normalize())
}

#[test]
fn a_box_has_the_values_worked_out_by_hand() {
    let far = Vec3::new(1000.0, -700.0, 300.0);
    for at in [Vec3::zeros(), far] {
        let b = brick(at);
        let near = |got: f64, wanted: f64| assert!((got - wanted).abs() < 1e-9, "{got} for {wanted}");
        // The top, 6 mm2 at 4 mm.
        near(value("weighted-normal-z", &b, Vec3::z()), 24.0);
        // Four facets of twelve are level: (n.d)^2 = 1 each; pi/4 each above 45 degrees.
        near(value("normal-z", &b, Vec3::z()), 4.0);
        near(value("overhang-angle", &b, Vec3::z()), std::f64::consts::PI);
        // The bottom lies on the bed: nothing to hold, 6 mm2 of contact.
        near(value("support-volume-convex", &b, Vec3::z()), 0.0);
        near(value("contact-area", &b, Vec3::z()), -6.0);
        near(value("contact-area", &b, Vec3::new(1.0, 1.0, 1.0)), 0.0);
        // Two facets of 3 mm2 on top, S = -6, which a tanh does not quite forget.
        near(value("tanh-overhang", &b, Vec3::z()), 0.25 * 12.0 * (1.0 - 6f64.tanh()) * 1.2f64.tanh());
        // Turned 30 degrees about x, of what hangs only the bottom passes 45 degrees; it leaves the bed along its 3 mm.
        let (s, c) = 30f64.to_radians().sin_cos();
        near(value("support-volume-convex", &b, Vec3::new(0.0, s, c)), 6.0 * c * 1.5 * s);
    }
}

#[test]
fn tanh_overhang_of_one_level_facet_is_the_formula_of_the_code() {
    // One facet of 2 mm2 that faces down, barycentre 5 mm above the only other point.
    let points = vec![Vec3::new(0., 0., 5.), Vec3::new(0., 2., 5.), Vec3::new(2., 0., 5.), Vec3::zeros()];
    let facets = Facets::of(&TriangleMesh::<Object>::new(points, vec![[0, 1, 2]]));
    let got = TanhOverhang { scale: 1.0 }.value(&facets, &Vec3::z());
    assert!((got - 0.25 * 4.0 * (1.0 + 4f64.tanh()) * 1.5f64.tanh()).abs() < 1e-12, "{got}");
    // At a scale of 1/10 the areas are a hundredth and the heights a tenth.
    let small = TanhOverhang { scale: 0.1 }.value(&facets, &Vec3::z());
    assert!((small - 0.25 * 0.04 * (1.0 + 0.04f64.tanh()) * 0.15f64.tanh()).abs() < 1e-12, "{small}");
}

#[test]
fn gradients_agree_with_central_differences() {
    const STEP: f64 = 1e-5;
    let facets = stone();
    for name in OBJECTIVES.into_iter().chain(["0.7*height+2*normal-z"]) {
        let f = objective(name, &ObjectiveSettings::default()).unwrap();
        if f.gradient(&facets, &Vec3::z()).is_none() {
            assert!(matches!(name, "contact-area" | "support-volume-column"), "{name}");
            continue;
        }
        let mut checked = 0;
        for up in (0..200).map(|i| lattice(i, 200)) {
            let along = tangents(&up);
            let gradient = f.gradient(&facets, &up).unwrap();
            assert!(gradient.dot(&up).abs() < 1e-9 * (1.0 + gradient.norm()), "{name}: not tangential");
            for t in along {
                let at = |step: f64| f.value(&facets, &(up * step.cos() + t * step.sin()));
                // Fourth order; where a second estimate differs there is a kink within the step.
                let wide = (at(8.0 * STEP) - at(-8.0 * STEP)) / (16.0 * STEP);
                let near = (at(4.0 * STEP) - at(-4.0 * STEP)) / (8.0 * STEP);
                let slope = (4.0 * near - wide) / 3.0;
                if (near - wide).abs() > 1e-5 * gradient.norm() {
                    continue;
                }
                checked += 1;
                assert!((slope - gradient.dot(&t)).abs() <= 1e-7 * gradient.norm(), "{name} at {up:?}: {slope}");
            }
        }
        assert!(checked > 300, "{name}: only {checked} of 400 away from kinks");
    }
}

#[test]
fn no_facets_and_flat_ones_give_zero() {
    let nothing = Facets::of(&TriangleMesh::<Object>::new(vec![], vec![]));
    let line = Facets::of(&TriangleMesh::<Object>::new(vec![Vec3::x(), Vec3::y(), Vec3::x()], vec![[0, 1, 2]]));
    for name in OBJECTIVES.into_iter().filter(|&name| name != "height") {
        assert_eq!(value(name, &nothing, Vec3::z()), 0.0, "{name}");
        assert_eq!(value(name, &line, Vec3::z()), 0.0, "{name}");
    }
}
