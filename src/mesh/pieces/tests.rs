//! Pieces of shapes with figures by hand, the promise over random places, and what is degenerate.

use super::{ConvexPiece, pieces};
use crate::fixtures;
use crate::geom::convex::{separation, support};
use crate::geom::{Object, SplitMix64, Vec3};
use crate::mesh::TriangleMesh;
use crate::mesh::tests::shapes;

type Mesh = TriangleMesh<Object>;

/// What every answer owes: each facet once, groups in order, no more concave than asked, and the corners in the hull.
fn is_whole(mesh: &Mesh, found: &[ConvexPiece], most: f64) {
    let mut facets: Vec<u32> = found.iter().flat_map(|p| p.facets.iter().copied()).collect();
    facets.sort_unstable();
    assert!(facets.iter().copied().eq(0..mesh.facets().len() as u32));
    assert!(found.windows(2).all(|w| w[0].facets[0] < w[1].facets[0]));
    let size = mesh.bounds().size().norm();
    for piece in found {
        assert!(piece.facets.is_sorted() && piece.concavity_mm <= most.max(1e-6 * size), "{}", piece.concavity_mm);
        let planes = piece.hull.planes();
        for corner in piece.facets.iter().flat_map(|&f| mesh.corners(f as usize)) {
            assert!(planes.iter().all(|(n, d)| n.dot(&corner) <= d + 1e-9));
        }
    }
}

/// How far a place lies outside of a hull of points, mm.
fn outside(hull: &[Vec3], at: &Vec3) -> f64 {
    separation(|d| support(hull, d) - at, f64::INFINITY).distance()
}

#[test]
fn a_convex_solid_is_one_piece_and_its_hull_is_the_solid() {
    for (mesh, concavity) in [(shapes::ball(10, |_| 0.0), 0.0), (shapes::cubes([3, 2, 4], |_| true), 0.1)] {
        let found = pieces(&mesh, concavity);
        is_whole(&mesh, &found, concavity);
        assert_eq!(found.len(), 1);
        assert!((found[0].hull.volume() - mesh.volume()).abs() < 1e-3, "{}", found[0].hull.volume());
        assert!(found[0].concavity_mm < 1e-4);
    }
}

/// Two arms of 10 x 10 and 30 long: the notch is 20 deep, the hull leaves 200 mm2 of it in the way, 14.1 from the inner corner to the slope.
#[test]
fn an_ell_is_cut_where_less_than_its_notch_is_allowed() {
    let ell = shapes::cubes([6, 6, 2], |[x, y, _]| x < 2 || y < 2);
    let whole = pieces(&ell, 20.5);
    is_whole(&ell, &whole, 20.5);
    // From the inner corner along a face of the notch to the slope it is 20, by hand; from any other place on it less.
    assert!(whole.len() == 1 && (whole[0].concavity_mm - 20.0).abs() < 1e-6, "{}", whole[0].concavity_mm);
    assert!((whole[0].hull.volume() - (5.0 * 100.0 * 10.0 + 200.0 * 10.0)).abs() < 1e-3);
    let cut = pieces(&ell, 5.0);
    is_whole(&ell, &cut, 5.0);
    assert!((2..=8).contains(&cut.len()), "{}", cut.len());
    // No hull reaches into the notch, but for what is allowed.
    let notch = Vec3::new(22.0, 22.0, 5.0);
    assert!(cut.iter().all(|p| outside(&p.hull.points, &notch) > 5.0));
    assert!(outside(&whole[0].hull.points, &Vec3::new(18.0, 18.0, 5.0)) < 1e-9);
}

#[test]
fn more_concavity_makes_fewer_pieces() {
    let torus = shapes::torus(48, 16);
    let mut last = (usize::MAX, 0.0);
    for concavity in [0.1, 0.5, 2.0, 40.0] {
        let found = pieces(&torus, concavity);
        is_whole(&torus, &found, concavity);
        let most = found.iter().map(|p| p.concavity_mm).fold(0.0, f64::max);
        assert!(found.len() < last.0 && most > last.1, "{concavity}: {} {most}, {last:?}", found.len());
        last = (found.len(), most);
    }
    assert_eq!(last.0, 1);
}

#[test]
fn every_place_on_the_surface_lies_in_the_hull_of_its_piece() {
    for (name, mesh) in shapes::all() {
        for share in [0.002, 0.03] {
            let most = mesh.bounds().size().norm() * share;
            let found = pieces(&mesh, most);
            is_whole(&mesh, &found, most);
            let mut of = vec![0; mesh.facets().len()];
            for (index, piece) in found.iter().enumerate() {
                piece.facets.iter().for_each(|&f| of[f as usize] = index);
            }
            let planes: Vec<_> = found.iter().map(|p| p.hull.planes()).collect();
            for (case, (facet, at)) in shapes::places_on(&mesh, 100_000, 3).into_iter().enumerate() {
                let own = &planes[of[facet]];
                assert!(own.iter().all(|(n, d)| n.dot(&at) <= d + 1e-9), "{name}");
                // The points alone say the same, where planes may have been pushed out, or there are none.
                if case % 500 == 0 || own.is_empty() && case % 50 == 0 {
                    assert!(outside(&found[of[facet]].hull.points, &at) < 1e-6, "{name}");
                }
            }
        }
    }
}

/// Dense places on each piece's facets, and rays through the planes of its hull: another way to the same figure.
#[test]
fn no_place_of_a_piece_lies_deeper_in_its_hull_than_three_times_its_concavity() {
    for (name, mesh) in shapes::all() {
        let most = mesh.bounds().size().norm() * 0.03;
        let found = pieces(&mesh, most);
        let mut of = vec![0; mesh.facets().len()];
        for (index, piece) in found.iter().enumerate() {
            piece.facets.iter().for_each(|&f| of[f as usize] = index);
        }
        let planes: Vec<_> = found.iter().map(|p| p.hull.planes()).collect();
        let mut deepest = vec![0.0_f64; found.len()];
        for (facet, at) in shapes::places_on(&mesh, 30_000, 8) {
            let (normal, own) = (mesh.normal(facet).unwrap(), &planes[of[facet]]);
            let ways =
                own.iter().filter(|(n, _)| n.dot(&normal) > 1e-9).map(|(n, d)| (d - n.dot(&at)) / n.dot(&normal));
            let way = ways.fold(f64::INFINITY, f64::min);
            if way.is_finite() {
                deepest[of[facet]] = deepest[of[facet]].max(way);
            }
        }
        let size = mesh.bounds().size().norm();
        for (piece, own) in found.iter().zip(&planes).filter(|_| name != "needles") {
            // What is told is what the corners and centres of all of the piece's facets say of its whole hull.
            let way = |facet: usize, at: Vec3| {
                let normal = mesh.normal(facet).unwrap();
                let ways = own.iter().filter(|(n, _)| n.dot(&normal) > 1e-9);
                ways.map(|(n, d)| (d - n.dot(&at)) / n.dot(&normal)).fold(f64::INFINITY, f64::min)
            };
            let of_facet = |&f: &u32| {
                let [a, b, c] = mesh.corners(f as usize);
                [a, b, c, (a + b + c) / 3.0].map(|at| way(f as usize, at)).into_iter().fold(0.0, f64::max)
            };
            let whole = piece.facets.iter().map(of_facet).filter(|mm| mm.is_finite()).fold(0.0, f64::max);
            assert!((whole - piece.concavity_mm).abs() < 1e-3 * size, "{name}: {whole} for {}", piece.concavity_mm);
        }
        for (piece, deepest) in found.iter().zip(&deepest) {
            assert!(*deepest <= 3.0 * piece.concavity_mm + 1e-4 * size, "{name}: {deepest} of {}", piece.concavity_mm);
        }
        // Where much is allowed much is used: a measure that says nothing would pass all of the above.
        let used = found.iter().map(|p| p.concavity_mm).fold(0.0, f64::max);
        assert!(!["bumps", "torus", "hollow"].contains(&name) || used > 0.3 * most, "{name}: {used} of {most}");
    }
}

#[test]
fn a_place_over_a_pit_counts_though_all_corners_lie_on_the_hull() {
    // A cube's top as a pyramid that points down: the corners of its four facets are the cube's, and one deep below.
    let mut vertices: Vec<Vec3> = crate::geom::Body::cuboid("", Vec3::zeros(), Vec3::repeat(10.0), [true; 3]).points;
    vertices.sort_by(|a, b| (a.z, a.y, a.x).partial_cmp(&(b.z, b.y, b.x)).unwrap());
    vertices.push(Vec3::new(5.0, 5.0, 4.0));
    let sides =
        [[0, 2, 3], [0, 3, 1], [0, 1, 5], [0, 5, 4], [2, 6, 7], [2, 7, 3], [0, 4, 6], [0, 6, 2], [1, 3, 7], [1, 7, 5]];
    let mut facets = sides.to_vec();
    facets.extend([[4, 5, 8], [5, 7, 8], [7, 6, 8], [6, 4, 8]]);
    let mesh = Mesh::new(vertices, facets);
    assert!((mesh.volume() - (1000.0 - 200.0)).abs() < 1e-9, "{}", mesh.volume());
    let whole = pieces(&mesh, 20.0);
    is_whole(&mesh, &whole, 20.0);
    // From the bottom of the pit along a facet's normal, (6, 5) / sqrt(61), one leaves the cube by the side, 5 away, before the top.
    let wanted = 5.0 * 61.0_f64.sqrt() / 6.0;
    assert!(whole.len() == 1 && (whole[0].concavity_mm - wanted).abs() < 1e-6, "{}", whole[0].concavity_mm);
    assert!(pieces(&mesh, 3.0).len() > 1);
}

#[test]
fn shape_keeps_pieces_of_a_plane_compact_while_nothing_is_concave() {
    // A saddle-like sheet where many merges cost nothing: what is joined first must be round, or strips remain.
    let torus = shapes::torus(64, 64);
    let found = pieces(&torus, 0.8);
    let shape = |piece: &ConvexPiece| {
        let area: f64 = piece.facets.iter().map(|&f| torus.facet_area(f as usize)).sum();
        let mut sides: std::collections::BTreeMap<[u32; 2], f64> = std::collections::BTreeMap::new();
        for [a, b, c] in piece.facets.iter().map(|&f| torus.facets()[f as usize]) {
            for (p, q) in [(a, b), (b, c), (c, a)] {
                let length = (torus.vertices()[p as usize] - torus.vertices()[q as usize]).norm();
                let side = [p.min(q), p.max(q)];
                if sides.remove(&side).is_none() {
                    sides.insert(side, length);
                }
            }
        }
        sides.values().sum::<f64>().powi(2) / (4.0 * std::f64::consts::PI * area)
    };
    let mean = found.iter().map(shape).sum::<f64>() / found.len() as f64;
    // With the sign of the shape turned there are 32, and it is 2.99.
    assert!(found.len() < 20 && mean < 2.0, "{} pieces, {mean}", found.len());
}

#[test]
fn what_is_flat_is_given_as_it_is() {
    // A sheet of eight facets in a plane, open, and three facets without an area.
    let vertices: Vec<Vec3> = (0..9).map(|i| Vec3::new(f64::from(i % 3), f64::from(i / 3), 7.0)).collect();
    let quads = [0, 1, 3, 4].map(|i: u32| [[i, i + 1, i + 4], [i, i + 4, i + 3]]);
    let sheet = Mesh::new(vertices.clone(), quads.concat());
    let found = pieces(&sheet, 0.0);
    is_whole(&sheet, &found, 0.0);
    assert!(found.len() == 1 && found[0].hull.faces.is_empty() && found[0].hull.points == vertices);
    let odd = Mesh::new(vertices, vec![[0, 1, 2], [3, 3, 4], [8, 8, 8]]);
    let found = pieces(&odd, 1.0);
    is_whole(&odd, &found, 1.0);
    assert!(found.len() == 3 && found.iter().all(|p| p.hull.faces.is_empty() && p.concavity_mm == 0.0));
    assert_eq!(pieces(&Mesh::new(vec![], vec![]), 1.0), vec![]);
}

#[test]
fn facets_without_an_area_do_not_part_what_is_convex() {
    let mesh = fixtures::slivered(&fixtures::solid_box(Vec3::zeros(), Vec3::new(30.0, 20.0, 10.0)), 9, 80);
    let found = pieces(&mesh, 0.01);
    is_whole(&mesh, &found, 0.01);
    let largest = found.iter().map(|p| p.facets.len()).max().unwrap();
    assert!(largest > mesh.facets().len() * 9 / 10, "{largest} of {}", mesh.facets().len());
}

#[test]
fn the_same_mesh_gives_the_same_pieces_and_a_renumbered_one_as_few() {
    let (_, mesh) = shapes::all().swap_remove(1);
    let found = pieces(&mesh, 0.8);
    assert_eq!(found, pieces(&mesh.clone(), 0.8));
    let mut random = SplitMix64::seeded(6);
    let mut facets = mesh.facets().to_vec();
    for i in (1..facets.len()).rev() {
        facets.swap(i, random.below(i + 1));
    }
    let mixed = Mesh::new(mesh.vertices().to_vec(), facets);
    let other = pieces(&mixed, 0.8);
    is_whole(&mixed, &other, 0.8);
    assert!(other.len().abs_diff(found.len()) * 4 <= found.len(), "{} {}", other.len(), found.len());
}

/// What the room is for: hulls are never farther apart than the surfaces, and not much nearer.
#[test]
fn hulls_are_never_farther_apart_than_the_surfaces() {
    let (one, other) = (shapes::torus(24, 12), shapes::channel());
    let [a, b] = [&one, &other].map(|mesh| pieces(mesh, 0.5));
    let mut random = SplitMix64::seeded(12);
    for _ in 0..12 {
        let shift = random.direction() * (38.0 + 20.0 * random.unit());
        let facets_apart = |f: usize, g: usize| {
            let (p, q) = (one.corners(f), other.corners(g).map(|v| v + shift));
            separation(|d| support(&p, d) - support(&q, &-d), f64::INFINITY).distance()
        };
        let all = (0..one.facets().len()).flat_map(|f| (0..other.facets().len()).map(move |g| (f, g)));
        let wanted = all.map(|(f, g)| facets_apart(f, g)).fold(f64::INFINITY, f64::min);
        let hulls_apart = |p: &ConvexPiece, q: &ConvexPiece| {
            let reach = |d: &Vec3| p.hull.support(d) - (q.hull.support(&-d) + shift);
            separation(reach, f64::INFINITY).distance()
        };
        let got = a.iter().flat_map(|p| b.iter().map(|q| hulls_apart(p, q))).fold(f64::INFINITY, f64::min);
        assert!(got <= wanted + 1e-5 && got >= wanted - 4.0, "{got} for {wanted}");
    }
}
