//! Witnesses: what Ramos et al. (2021) prints, and the faces of a box.

use super::*;
use crate::fixtures::candelabrum;
use crate::geom::{Object, Vec3};
use crate::mesh::TriangleMesh;
use crate::orient::Staircase;

/// `(alpha, beta)` in degrees of the minima that Ramos et al. (2021) names in sections 6.1.1 to 6.1.4, by part. Part 11 has 109.95
/// for 110 there: our arms leave the stem at 20 degrees sharp.
const NAMED: [(usize, &[Angles]); 4] = [
    (0, &[[0.0, 0.0], [180.0, 180.0]]),
    (1, &[[0.0, 0.0], [0.0, 90.0], [90.0, 0.0], [180.0, 0.0], [0.0, 180.0], [180.0, 180.0]]),
    (3, &[[0.0, 90.0], [110.0, 0.0], [110.0, 180.0]]),
    (11, &[[110.0, 0.0], [110.0, 180.0]]),
];
/// Of part 11 the text has "points with beta = 90" besides. On 420 sides the direction itself is beaten by the dips of the
/// two sides whose normals lie half a side (0.43 degrees) beside it, 9.299 for 9.365 at 0.33 degrees; runs end on
/// either. So a minimum as low counts within those dips.
const LEVEL: Angles = [0.0, 90.0];
const SIDE_DEG: f64 = 0.43 + 0.1;

/// The paper's arms reach along -y where ours reach along +x.
fn in_the_papers_frame(mesh: &TriangleMesh<Object>) -> TriangleMesh<Object> {
    TriangleMesh::new(mesh.vertices().iter().map(|p| Vec3::new(p.y, -p.x, p.z)).collect(), mesh.facets().to_vec())
}

/// Degrees from a direction or its opposite: the staircase does not tell up from down.
fn off(m: &Minimum, at: Angles) -> f64 {
    m.up.dot(&up(at)).abs().min(1.0).acos().to_degrees()
}

#[test]
fn finds_the_minima_that_the_paper_names_within_its_evaluations_whatever_is_drawn() {
    let parts = candelabrum().parts;
    let f = Staircase { layer_mm: 0.2 };
    for (id, named) in NAMED {
        let facets = Facets::of(&in_the_papers_frame(&parts[id].1));
        for seed in 1..=5 {
            let found = Mmls { seed, ..Mmls::as_published() }.search(&f, &facets);
            assert!(found.evaluations <= 10_000);
            for &at in named {
                let least = found.minima.iter().map(|m| off(m, at)).fold(f64::INFINITY, f64::min);
                assert!(least < 0.1, "part {id}, seed {seed}: {at:?} missed by {least} degrees");
            }
            // A run ends within its last step of a kink.
            let level = f.value(&facets, &up(LEVEL)) * (1.0 + 1e-5);
            let as_low = |m: &&Minimum| off(m, LEVEL) < SIDE_DEG && m.value <= level;
            assert!(id != 11 || found.minima.iter().any(|m| as_low(&m)), "part {id}, seed {seed}: beta = 90");
        }
    }
}

#[test]
fn covers_the_whole_sphere_and_is_repeated_by_its_seed() {
    let parts = candelabrum().parts;
    let facets = Facets::of(&parts[1].1);
    let f = Staircase { layer_mm: 0.2 };
    let found = Mmls::default().search(&f, &facets);
    for face in [Vec3::x(), Vec3::y(), Vec3::z(), -Vec3::x(), -Vec3::y(), -Vec3::z()] {
        assert!(found.minima.iter().any(|m| (m.up - face).norm() < 1e-3), "{face:?}");
    }
    assert_eq!(found, Mmls::default().search(&f, &facets));
}
