//! Surfaces with facets without area in them bend where they bent before.

use crate::fixtures::{hook, prism, slivered, two_boxes, y_tree};
use crate::geom::{Object, SplitMix64, Vec3};
use crate::mesh::TriangleMesh;
use crate::overhang::{Hang, Relief};

const HANG: Hang = Hang { layer_mm: 0.2, span_mm: 2.0, bridge_mm: 8.0 };

fn relief(mesh: &TriangleMesh<Object>) -> Relief {
    Relief::of(mesh.vertices().to_vec(), mesh.facets().to_vec())
}

/// The length of each ridge along `up`, and how much of it may hang, the longest first.
fn ridges(relief: &Relief, up: &Vec3) -> Vec<[f64; 2]> {
    let found = relief.ridges(up, |_| false, &HANG);
    let length = |edges: &[[u32; 2]]| edges.iter().map(|e| relief.length(*e)).sum();
    let mut all: Vec<[f64; 2]> = found.iter().map(|r| [length(&r.edges), r.allowed_mm]).collect();
    all.sort_by(|x, y| y[0].total_cmp(&x[0]));
    all
}

fn shapes() -> Vec<TriangleMesh<Object>> {
    let keel = prism(&[[0.0, 5.0], [10.0, 16.0], [0.0, 27.0], [-10.0, 16.0]], [0.0, 20.0]);
    // Its top corners lie on one line, and facets without area between them.
    let tee =
        [[0.0, 0.0], [10.0, 0.0], [10.0, 25.0], [25.0, 25.0], [25.0, 33.0], [-15.0, 33.0], [-15.0, 25.0], [0.0, 25.0]];
    let fixtures = [hook(), two_boxes(), y_tree()].into_iter().flat_map(|f| f.parts.into_iter().map(|(_, mesh)| mesh));
    [keel, prism(&tee, [0.0, 12.0])].into_iter().chain(fixtures).collect()
}

/// Directions in which edges of boxes and prisms lie level, some a little off.
fn directions(random: &mut SplitMix64) -> Vec<Vec3> {
    let level =
        [[0.0, 1.0, 1.0], [1.0, 0.0, 1.0], [0.0, -1.0, 1.0], [-1.0, 1.0, 0.0], [1.0, 1.0, 1.0], [0.3, 0.0, 1.0]];
    let mut all: Vec<Vec3> =
        level.into_iter().flat_map(|[x, y, z]| [Vec3::new(x, y, z), Vec3::new(-x, z, -y)]).collect();
    all.extend((0..20).map(|_| Vec3::from_fn(|_, _| random.unit() - 0.5)));
    all.iter().map(|up| up.normalize()).collect()
}

#[test]
fn facets_without_area_hide_no_ridge_and_make_none() {
    let mut random = SplitMix64::seeded(7);
    let (mut compared, mut long) = (0, 0);
    for (which, mesh) in shapes().iter().enumerate() {
        let plain = relief(mesh);
        for (seed, count) in [(1, 1), (2, 3), (3, 10), (4, 30), (5, 100)] {
            let patched = relief(&slivered(mesh, 100 * which as u64 + seed, count));
            assert!(patched.is_closed());
            for up in directions(&mut random) {
                let (wanted, got) = (ridges(&plain, &up), ridges(&patched, &up));
                let same = wanted.len() == got.len()
                    && wanted.iter().zip(&got).all(|(w, g)| (w[0] - g[0]).abs() < 0.01 && w[1] == g[1]);
                assert!(same, "shape {which}, {count} facets without area, {up:?}: {got:?} for {wanted:?}");
                compared += 1;
                long += wanted.len();
            }
        }
    }
    assert!(compared > 500 && long > 500, "{long} ridges in {compared} directions");
}
