//! That the old surface lies within the new one, over random places and many shapes, and what is refused.

use std::collections::BTreeMap;

use super::{Containing, containing};
use crate::fixtures;
use crate::geom::{Object, SplitMix64, Vec3};
use crate::mesh::TriangleMesh;
use crate::mesh::tests::shapes;

type Mesh = TriangleMesh<Object>;

/// Each edge is run through as often one way as the other; how many have more than two facets.
fn closed(mesh: &Mesh) -> usize {
    let mut sides: BTreeMap<[u32; 2], (i32, usize)> = BTreeMap::new();
    for [a, b, c] in mesh.facets() {
        assert!(a != b && b != c && c != a);
        for (p, q) in [(*a, *b), (*b, *c), (*c, *a)] {
            let side = sides.entry([p.min(q), p.max(q)]).or_default();
            *side = (side.0 + if p < q { 1 } else { -1 }, side.1 + 1);
        }
    }
    assert!(sides.values().all(|(balance, _)| *balance == 0));
    sides.values().filter(|(_, uses)| *uses > 2).count()
}

/// Corners less edges plus facets: 2 a ball, 0 a ring.
fn kind(mesh: &Mesh) -> i64 {
    let mut used: Vec<u32> = mesh.facets().iter().flatten().copied().collect();
    used.sort_unstable();
    used.dedup();
    used.len() as i64 - mesh.facets().len() as i64 / 2
}

fn contains(name: &str, old: &Mesh, new: &Mesh, places: usize) {
    for at in old.vertices() {
        assert!(shapes::holds(new, at), "{name}: the corner {at:?} is out by {}", shapes::distance(new, at));
    }
    for (_, at) in shapes::places_on(old, places, 17) {
        assert!(shapes::holds(new, &at), "{name}: {at:?} is out by {}", shapes::distance(new, &at));
    }
}

#[test]
fn whatever_lay_in_the_old_surface_lies_in_the_new_one() {
    let all = shapes::all();
    let places = 100_000 / all.len() + 1;
    for (name, mesh) in all {
        for (facets, raised) in [(mesh.facets().len() / 5, f64::INFINITY), (60, f64::INFINITY), (0, 0.4)] {
            let found = containing(&mesh, facets, raised);
            let new = &found.mesh;
            assert_eq!((closed(new), kind(new)), (closed(&mesh), kind(&mesh)), "{name}");
            assert!(new.facets().len() < mesh.facets().len() && found.raised_mm <= raised + 1e-9, "{name}");
            assert!(new.volume() >= mesh.volume() * (1.0 - 1e-12), "{name}");
            contains(name, &mesh, new, if facets > 60 { places / 4 } else { places });
        }
    }
}

/// Inside places too, and those far within a slot that grows shut.
#[test]
fn winding_numbers_never_fall() {
    let mut random = SplitMix64::seeded(21);
    for (name, mesh) in shapes::all() {
        let found = containing(&mesh, 24, f64::INFINITY);
        let bounds = mesh.bounds();
        for _ in 0..3000 {
            let at = bounds.min + Vec3::from_fn(|i, _| random.unit() * bounds.size()[i]);
            let [before, after] = [&mesh, &found.mesh].map(|m| shapes::winds(m, &at));
            assert!(after > before - 1e-3, "{name}: {after} after {before} at {at:?}");
        }
    }
}

#[test]
fn a_block_of_many_facets_becomes_its_twelve_and_a_ball_comes_near_its_size() {
    let block = shapes::cubes([4, 6, 5], |_| true);
    let found = containing(&block, 0, 0.0);
    assert_eq!(found.mesh.facets().len(), 12);
    assert!((found.mesh.volume() - block.volume()).abs() < 1e-6 && found.raised_mm < 1e-9);
    // An ell has ten corners to each lid; nothing of its notch may be filled.
    let ell = shapes::cubes([6, 6, 2], |[x, y, _]| x < 2 || y < 2);
    let found = containing(&ell, 0, 0.0);
    assert_eq!(found.mesh.facets().len(), 20);
    assert!((found.mesh.volume() - ell.volume()).abs() < 1e-6);
    let ball = shapes::ball(24, |_| 0.0);
    let found = containing(&ball, 220, f64::INFINITY);
    let growth = found.mesh.volume() / ball.volume();
    assert!(found.mesh.facets().len() <= 220 && growth > 1.0 && growth < 1.08, "{growth}");
}

#[test]
fn what_is_raised_is_told_and_bounded() {
    let (_, bumps) = shapes::all().swap_remove(1);
    let mut last = (usize::MAX, 0.0);
    for raised in [0.05, 0.2, 1.0] {
        let Containing { mesh, raised_mm } = containing(&bumps, 0, raised);
        assert!(raised_mm <= raised + 1e-9 && raised_mm > 0.3 * raised);
        assert!(mesh.facets().len() < last.0 && mesh.volume() > last.1);
        last = (mesh.facets().len(), mesh.volume());
        // No corner lies much farther away than it was raised.
        let farthest = mesh.vertices().iter().map(|v| shapes::distance(&bumps, v)).fold(0.0, f64::max);
        assert!(farthest < 2.0 * raised, "{farthest} for {raised}");
    }
}

#[test]
fn no_facet_is_turned_over() {
    // Of a round body no facet may come to face its middle.
    for bump in [0.0, 1.0] {
        let ball = shapes::ball(20, |d| bump * (5.0 * d.x).sin());
        for facets in [400, 100, 30] {
            let new = containing(&ball, facets, f64::INFINITY).mesh;
            let middle = Vec3::new(5.0, -3.0, 8.0);
            let faces_out = |f: usize| new.area_vector(f).dot(&(new.corners(f)[0] - middle)) > 0.0;
            assert!((0..new.facets().len()).all(faces_out), "{facets}");
        }
    }
}

/// In a plane that is not convex a corner can be moved past a side without any cost; what folds has more area than it covers.
#[test]
fn a_plane_that_is_not_convex_is_not_folded() {
    let star = shapes::cubes([7, 7, 1], |[x, y, _]| x == 3 || y == 3 || (x + y) % 5 < 3);
    for facets in (20..star.facets().len()).step_by(12) {
        let new = containing(&star, facets, 0.0).mesh;
        assert!((new.area() - star.area()).abs() < 1e-6, "{facets}: {} for {}", new.area(), star.area());
    }
}

#[test]
fn a_tetrahedron_an_open_sheet_and_nothing_stay_as_they_are() {
    let corners = vec![Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()];
    let tetra = Mesh::new(corners, vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]);
    let found = containing(&tetra, 0, f64::INFINITY);
    assert_eq!((found.mesh.facets(), found.mesh.vertices()), (tetra.facets(), tetra.vertices()));
    // As a cavity it could be drawn together from within, and would fold flat.
    let cavity = Mesh::new(tetra.vertices().to_vec(), tetra.facets().iter().map(|&[a, b, c]| [a, c, b]).collect());
    assert_eq!(containing(&cavity, 0, f64::INFINITY).mesh.facets(), cavity.facets());
    let nothing = containing(&Mesh::new(vec![], vec![]), 0, f64::INFINITY);
    assert!(nothing.mesh.facets().is_empty() && nothing.raised_mm == 0.0);
    let sheet = Mesh::new(tetra.vertices().to_vec(), vec![[0, 1, 2], [1, 3, 2], [3, 3, 1]]);
    assert_eq!(containing(&sheet, 0, f64::INFINITY).mesh.facets(), &sheet.facets()[..2]);
}

#[test]
fn a_ring_stays_a_ring_and_two_shells_stay_two() {
    let ring = containing(&shapes::torus(40, 16), 0, f64::INFINITY).mesh;
    assert!(kind(&ring) == 0 && closed(&ring) == 0 && ring.facets().len() < 200, "{}", ring.facets().len());
    let (_, hollow) = shapes::all().swap_remove(6);
    let found = containing(&hollow, 0, f64::INFINITY).mesh;
    assert!(kind(&found) == 4 && closed(&found) == 0, "{}", found.facets().len());
}

#[test]
fn the_same_mesh_gives_the_same_bytes() {
    let (_, mesh) = shapes::all().swap_remove(1);
    let [a, b] = [0, 1].map(|_| containing(&mesh, 300, 0.5).mesh);
    assert!(a.vertices() == b.vertices() && a.facets() == b.facets());
}

#[test]
fn far_from_the_origin_nothing_is_lost() {
    let far = Vec3::new(4000.0, -2500.0, 900.0);
    let mesh = shapes::torus(32, 12);
    let moved = Mesh::new(mesh.vertices().iter().map(|v| v + far).collect(), mesh.facets().to_vec());
    let new = containing(&moved, 150, f64::INFINITY).mesh;
    assert!(new.facets().len() <= 150);
    contains("far", &moved, &new, 3000);
}

#[test]
fn parts_of_a_real_model_are_held() {
    for (name, mesh) in fixtures::y_tree().parts {
        let found = containing(&mesh, 40, f64::INFINITY);
        contains(&name, &mesh, &found.mesh, 2000);
    }
}
