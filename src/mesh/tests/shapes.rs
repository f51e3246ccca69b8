//! Closed surfaces for what cuts them up or goes around them, random places on them, and where a place lies: told from definitions.

use crate::geom::{Mat3, Object, SplitMix64, Vec3};
use crate::mesh::TriangleMesh;

type Mesh = TriangleMesh<Object>;

/// A ball of radius 20 about (5, -3, 8) with `rings` of `2 rings` facets pairs; each corner's radius is changed by `bump(direction)`.
pub(crate) fn ball(rings: u32, bump: impl Fn(&Vec3) -> f64) -> Mesh {
    let (sides, centre) = (2 * rings, Vec3::new(5.0, -3.0, 8.0));
    let at = |ring: u32, side: u32| {
        let (down, turn) = (angle(ring, 2 * rings), angle(side, sides));
        let d = Vec3::new(down.sin() * turn.cos(), down.sin() * turn.sin(), down.cos());
        centre + d * (20.0 + bump(&d))
    };
    let mut vertices = vec![at(0, 0)];
    vertices.extend((1..rings).flat_map(|r| (0..sides).map(move |s| (r, s))).map(|(r, s)| at(r, s)));
    vertices.push(at(rings, 0));
    let number = |r: u32, s: u32| match r {
        0 => 0,
        r if r == rings => (rings - 1) * sides + 1,
        r => 1 + (r - 1) * sides + s % sides,
    };
    let mut facets = Vec::new();
    for (r, s) in (0..rings).flat_map(|r| (0..sides).map(move |s| (r, s))) {
        let [p, q, u, v] = [number(r, s), number(r, s + 1), number(r + 1, s), number(r + 1, s + 1)];
        if r > 0 {
            facets.push([p, u, q]);
        }
        if r + 1 < rings {
            facets.push([q, u, v]);
        }
    }
    TriangleMesh::new(vertices, facets)
}

/// A ring of radius 15 about Z, 5 thick either way: `2 around across` facets.
pub(crate) fn torus(around: u32, across: u32) -> Mesh {
    let at = |i: u32, j: u32| {
        let (turn, up) = (angle(i, around), angle(j, across));
        let r = 15.0 + 5.0 * up.cos();
        Vec3::new(r * turn.cos(), r * turn.sin(), 5.0 * up.sin())
    };
    let vertices = (0..around).flat_map(|i| (0..across).map(move |j| (i, j))).map(|(i, j)| at(i, j)).collect();
    let number = |i: u32, j: u32| i % around * across + j % across;
    let quad = |(i, j): (u32, u32)| {
        let [p, q, r, s] = [number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)];
        [[p, q, r], [p, r, s]]
    };
    TriangleMesh::new(vertices, (0..around).flat_map(|i| (0..across).map(move |j| (i, j))).flat_map(quad).collect())
}

fn angle(part: u32, of: u32) -> f64 {
    std::f64::consts::TAU * f64::from(part) / f64::from(of)
}

/// The surface of cubes of 5 mm, those that `filled` names of a block of so many, each side in two facets.
pub(crate) fn cubes(count: [i32; 3], filled: impl Fn([i32; 3]) -> bool) -> Mesh {
    let full = |c: [i32; 3]| (0..3).all(|k| (0..count[k]).contains(&c[k])) && filled(c);
    let number = |c: [i32; 3]| (c[0] + (count[0] + 1) * (c[1] + (count[1] + 1) * c[2])) as u32;
    let mut vertices = Vec::new();
    for (z, y) in (0..=count[2]).flat_map(|z| (0..=count[1]).map(move |y| (z, y))) {
        vertices.extend((0..=count[0]).map(|x| Vec3::new(f64::from(x), f64::from(y), f64::from(z)) * 5.0));
    }
    let mut facets: Vec<[u32; 3]> = Vec::new();
    for z in 0..count[2] {
        for (y, x) in (0..count[1]).flat_map(|y| (0..count[0]).map(move |x| (y, x))) {
            for (k, up) in (0..3).flat_map(|k| [(k, 0), (k, 1)]).filter(|_| full([x, y, z])) {
                let mut beside = [x, y, z];
                beside[k] += 2 * up - 1;
                if full(beside) {
                    continue;
                }
                let corner = |p: i32, q: i32| {
                    let mut c = [x, y, z];
                    (c[k], c[(k + 1) % 3], c[(k + 2) % 3]) = (c[k] + up, c[(k + 1) % 3] + p, c[(k + 2) % 3] + q);
                    number(c)
                };
                let [a, b, c, d] = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
                facets.extend(if up == 1 { [[a, b, c], [a, c, d]] } else { [[a, c, b], [a, d, c]] });
            }
        }
    }
    let mut places = vec![u32::MAX; vertices.len()];
    let mut used = Vec::new();
    for corner in facets.iter_mut().flatten() {
        let place = &mut places[*corner as usize];
        if *place == u32::MAX {
            *place = used.len() as u32;
            used.push(vertices[*corner as usize]);
        }
        *corner = *place;
    }
    TriangleMesh::new(used, facets)
}

/// A U of cubes, its slot 5 wide.
pub(crate) fn channel() -> Mesh {
    cubes([3, 6, 4], |[x, _, z]| x != 1 || z == 0)
}

/// The shapes, by name: round, ring-shaped, stepped, slotted, hollow, bent and full of needles.
pub(crate) fn all() -> Vec<(&'static str, Mesh)> {
    let mut hollow = ball(12, |_| 0.0);
    let inner = ball(8, |d| 0.6 * (9.0 * d.z).sin() - 8.0);
    let shift = hollow.vertices().len() as u32;
    let facets = inner.facets().iter().map(|&[a, b, c]| [a, c, b].map(|v| v + shift));
    let facets = hollow.facets().iter().copied().chain(facets).collect();
    hollow = TriangleMesh::new([hollow.vertices(), inner.vertices()].concat(), facets);
    let turn = *nalgebra::Rotation3::new(Vec3::new(0.3, -0.7, 1.1)).matrix();
    let needles =
        crate::fixtures::slivered(&crate::fixtures::solid_box(Vec3::zeros(), Vec3::new(30.0, 20.0, 10.0)), 5, 60);
    vec![
        ("ball", ball(16, |_| 0.0)),
        ("bumps", ball(20, |d| 1.5 * (7.0 * d.x).sin() * (6.0 * d.y).cos() + (9.0 * d.z).sin())),
        ("torus", torus(40, 20)),
        ("channel", channel()),
        ("stairs, turned", turned(&cubes([5, 3, 5], |[x, _, z]| z <= x), &turn)),
        ("frame, turned", turned(&cubes([5, 5, 2], |[x, y, _]| !(1..4).contains(&x) || !(1..4).contains(&y)), &turn)),
        ("hollow", hollow),
        ("needles", needles),
    ]
}

/// A surface turned about the origin.
pub(crate) fn turned(mesh: &Mesh, turn: &Mat3) -> Mesh {
    TriangleMesh::new(mesh.vertices().iter().map(|p| turn * p).collect(), mesh.facets().to_vec())
}

/// Random places on a surface, evenly over its area, each with its facet; mm.
pub(crate) fn places_on(mesh: &Mesh, count: usize, seed: u64) -> Vec<(usize, Vec3)> {
    let mut random = SplitMix64::seeded(seed);
    let mut sum = 0.0;
    let sums: Vec<f64> = (0..mesh.facets().len())
        .map(|f| {
            sum += mesh.facet_area(f);
            sum
        })
        .collect();
    let place = |_| {
        let wanted = random.unit() * sum;
        let facet = sums.partition_point(|s| *s <= wanted).min(sums.len() - 1);
        let [a, b, c] = mesh.corners(facet);
        let (root, share) = (random.unit().sqrt(), random.unit());
        (facet, a * (1.0 - root) + b * (root * (1.0 - share)) + c * (root * share))
    };
    (0..count).map(place).collect()
}

/// How often a surface winds around a place; the sum of the solid angles, half-way between on the surface.
pub(crate) fn winds(mesh: &Mesh, at: &Vec3) -> f64 {
    let angle = |f: usize| {
        let [a, b, c] = mesh.corners(f).map(|p| p - at);
        let (x, y, z) = (a.norm(), b.norm(), c.norm());
        let over = x * y * z + a.dot(&b) * z + b.dot(&c) * x + c.dot(&a) * y;
        a.dot(&b.cross(&c)).atan2(over)
    };
    (0..mesh.facets().len()).map(angle).sum::<f64>() / std::f64::consts::TAU
}

/// How far a place lies from a surface, mm.
pub(crate) fn distance(mesh: &Mesh, at: &Vec3) -> f64 {
    (0..mesh.facets().len()).map(|f| from_facet(&mesh.corners(f).map(|p| p - at))).fold(f64::INFINITY, f64::min)
}

/// How far the origin lies from a triangle: above its inside, or from one of its sides.
fn from_facet(corners: &[Vec3; 3]) -> f64 {
    let [a, b, c] = corners;
    let from_side = |p: &Vec3, q: &Vec3| {
        let along = q - p;
        let share = (-p.dot(&along) / along.norm_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        (p + along * share).norm()
    };
    let normal = (b - a).cross(&(c - a));
    let within = |p: &Vec3, q: &Vec3| (q - p).cross(&-p).dot(&normal) >= 0.0;
    if normal != Vec3::zeros() && within(a, b) && within(b, c) && within(c, a) {
        return a.dot(&normal).abs() / normal.norm();
    }
    from_side(a, b).min(from_side(b, c)).min(from_side(c, a))
}

/// Whether a place lies in a surface or within a millionth of a millimetre of it.
pub(crate) fn holds(mesh: &Mesh, at: &Vec3) -> bool {
    winds(mesh, at) > 0.75 || distance(mesh, at) <= 1e-6
}
