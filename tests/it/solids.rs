//! Made-up closed solids for sampling, mm: the same on every machine.

use trunnion::fixtures::{prism, solid_box, tricks};
use trunnion::geom::{Object, Vec3};
use trunnion::mesh::TriangleMesh;
use trunnion::orient::from_angles;

use crate::support::Numbers;

pub(crate) type Mesh = TriangleMesh<Object>;

/// Twenty of 8 to 120 facets: boxes, convex hulls, a box with a cavity, boxes apart from each other, an L, a tunnel, a hook,
/// towers, lumps. None touches itself or another of its shells.
pub(crate) fn twenty() -> Vec<(String, Mesh)> {
    let mut numbers = Numbers::seeded(20);
    let mut all: Vec<(String, Mesh)> = Vec::new();
    for i in 0..3 {
        let one = solid_box(Vec3::zeros(), size(&mut numbers));
        all.push((format!("box {i}"), if i < 2 { one } else { turned(&one, &mut numbers) }));
    }
    // Far from the origin sums lose digits.
    let far = Vec3::new(1e4, -2e4, 5e3);
    for (_, mesh) in &mut all[1..] {
        *mesh = TriangleMesh::new(mesh.vertices().iter().map(|v| v + far).collect(), mesh.facets().to_vec());
    }
    let cavity = solid_box(Vec3::repeat(3.0), Vec3::new(15.0, 11.0, 7.0));
    let outside = solid_box(Vec3::zeros(), Vec3::new(20.0, 15.0, 12.0));
    all.push(("hollow box".to_owned(), turned(&joined(&[outside, inside_out(&cavity)]), &mut numbers)));
    for count in [6, 8, 10, 12] {
        all.push((format!("hull of {count}"), hull(count, &mut numbers)));
    }
    for count in [2, 2, 3] {
        let boxes: Vec<Mesh> = (0..count)
            .map(|i| {
                let low = Vec3::new(0.0, 0.0, 30.0 * f64::from(i)) + Vec3::from(numbers.triple(6.0));
                solid_box(low, low + size(&mut numbers))
            })
            .collect();
        let index = all.len();
        all.push((format!("{count} boxes, {index}"), turned(&joined(&boxes), &mut numbers)));
    }
    // The caps are fans about the last corner: the one that points inward.
    let outline = [[0.0, 8.0], [0.0, 0.0], [30.0, 0.0], [30.0, 20.0], [22.0, 20.0], [22.0, 8.0]];
    let l = prism(&outline, [0.0, 12.0]);
    all.push(("L turned".to_owned(), turned(&l, &mut numbers)));
    all.push(("L".to_owned(), l));
    let whole = [("towers", 2), ("tunnel", 0), ("hook", 0)];
    let named = |wanted: &str| tricks().into_iter().flat_map(|f| f.parts).find(|(name, _)| name == wanted);
    all.extend(whole.iter().filter_map(|(name, _)| named(name)));
    let lumps = [(3, 0.0), (4, 1.0), (5, 2.0), (6, 3.0)];
    all.extend(lumps.iter().map(|&(rings, kind)| (format!("lump of {rings}"), lump(rings, kind))));
    assert_eq!(all.len(), 20, "{:?}", all.iter().map(|(name, _)| name).collect::<Vec<_>>());
    assert!(all.iter().all(|(_, mesh)| mesh.volume() > 0.0));
    all
}

/// Two shells of one part that share material: a tall and a wide box that cross each other, and a box within a box.
pub(crate) fn overlapping() -> [(&'static str, Mesh); 2] {
    let inner = solid_box(Vec3::repeat(10.0), Vec3::repeat(16.0));
    let outer = solid_box(Vec3::zeros(), Vec3::repeat(30.0));
    let tall = solid_box(Vec3::new(-5.0, -5.0, 0.0), Vec3::new(5.0, 5.0, 30.0));
    let wide = solid_box(Vec3::new(-15.0, -3.0, 10.0), Vec3::new(15.0, 3.0, 16.0));
    [("boxes that cross", joined(&[tall, wide])), ("a box in a box", joined(&[outer, inner]))]
}

fn inside_out(mesh: &Mesh) -> Mesh {
    TriangleMesh::new(mesh.vertices().to_vec(), mesh.facets().iter().map(|f| [f[0], f[2], f[1]]).collect())
}

/// Sides of 4 to 20 mm.
fn size(numbers: &mut Numbers) -> Vec3 {
    Vec3::new(numbers.between(4.0, 20.0), numbers.between(4.0, 20.0), numbers.between(4.0, 20.0))
}

/// Turned and shifted anyhow.
fn turned(mesh: &Mesh, numbers: &mut Numbers) -> Mesh {
    let turn = nalgebra::UnitQuaternion::from_scaled_axis(Vec3::from(numbers.triple(3.0)));
    let shift = Vec3::from(numbers.triple(50.0));
    TriangleMesh::new(mesh.vertices().iter().map(|v| turn * v + shift).collect(), mesh.facets().to_vec())
}

fn joined(meshes: &[Mesh]) -> Mesh {
    let (mut vertices, mut facets) = (Vec::new(), Vec::new());
    for mesh in meshes {
        let first = vertices.len() as u32;
        vertices.extend_from_slice(mesh.vertices());
        facets.extend(mesh.facets().iter().map(|facet| facet.map(|i| i + first)));
    }
    TriangleMesh::new(vertices, facets)
}

/// The hull of so many random points: every three with all others on one side.
fn hull(count: usize, numbers: &mut Numbers) -> Mesh {
    let points: Vec<Vec3> = (0..count).map(|_| Vec3::from(numbers.triple(15.0))).collect();
    let mut facets = Vec::new();
    for (i, a) in points.iter().enumerate() {
        for (j, b) in points.iter().enumerate().skip(i + 1) {
            for (k, c) in points.iter().enumerate().skip(j + 1) {
                let normal = (b - a).cross(&(c - a));
                let mut sides = points.iter().map(|p| normal.dot(&(p - a))).filter(|side| side.abs() > 1e-9);
                let Some(first) = sides.next() else { continue };
                if sides.all(|side| side * first > 0.0) {
                    let [i, j, k] = [i, j, k].map(|index| index as u32);
                    facets.push(if first < 0.0 { [i, j, k] } else { [i, k, j] });
                }
            }
        }
    }
    TriangleMesh::new(points, facets)
}

/// A closed surface about the origin, star-shaped, of about `4 rings^2` facets.
pub(crate) fn lump(rings: usize, kind: f64) -> Mesh {
    use std::f64::consts::PI;
    let turns = 2 * rings;
    let at = |i: usize, j: usize| {
        let d = from_angles(2.0 * PI * j as f64 / turns as f64, PI * i as f64 / rings as f64 - PI / 2.0);
        let wave = ((2.0 + kind) * d.x + kind).sin() + 0.5 * ((3.0 + kind) * d.y * d.z - kind).cos();
        d * (20.0 + 5.0 * wave)
    };
    let mut points = vec![at(0, 0), at(rings, 0)];
    points.extend((1..rings).flat_map(|i| (0..turns).map(move |j| (i, j))).map(|(i, j)| at(i, j)));
    let index = |i: usize, j: usize| (2 + (i - 1) * turns + j % turns) as u32;
    let mut facets = Vec::new();
    for j in 0..turns {
        facets.push([0, index(1, j + 1), index(1, j)]);
        facets.push([1, index(rings - 1, j), index(rings - 1, j + 1)]);
        for i in 1..rings - 1 {
            let quad = [index(i, j), index(i, j + 1), index(i + 1, j + 1), index(i + 1, j)];
            facets.extend([[quad[0], quad[1], quad[2]], [quad[0], quad[2], quad[3]]]);
        }
    }
    let mesh = TriangleMesh::new(points, facets);
    if mesh.volume() > 0.0 { mesh } else { inside_out(&mesh) }
}
