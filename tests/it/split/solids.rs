//! The solids that `split` is measured by, each one closed shell: unions and differences of boxes, cylinders and spheres.
//!
//! Lengths mm, lowest point at z = 0 unless said. What area needs support, and how few cuts take it away, stands beside each.
//! The booleans are `boolmesh`'s, a port of Manifold; areas and volumes are held against closed forms in the tests.

use boolmesh::prelude::{Manifold, OpType, compute_boolean};
use trunnion::geom::{Mat3, Object, Vec3};
use trunnion::mesh::TriangleMesh;

/// A closed shell that can be moved, joined and taken away from others.
#[derive(Clone)]
pub(crate) struct Shape(Manifold);

/// A named solid with what is known of it.
pub(crate) struct Solid {
    pub(crate) name: &'static str,
    pub(crate) shape: Shape,
    /// Facets that look down by more than 45 degrees, those on the table left out, mm².
    pub(crate) needs_mm2: f64,
    /// The fewest cuts that are known to bring it to `left_mm2`.
    pub(crate) cuts: usize,
    pub(crate) left_mm2: f64,
}

impl Shape {
    fn new(vertices: &[Vec3], facets: &[[usize; 3]]) -> Self {
        let flat: Vec<f64> = vertices.iter().flat_map(|v| [v.x, v.y, v.z]).collect();
        let index: Vec<usize> = facets.iter().flatten().copied().collect();
        Self(Manifold::new(&flat, &index).expect("a closed shape"))
    }

    /// The same surface with every vertex taken elsewhere; the map must keep the inside inside.
    pub(crate) fn mapped(&self, map: impl Fn(Vec3) -> Vec3) -> Self {
        let vertices: Vec<Vec3> = self.0.ps.iter().map(|p| map(Vec3::new(p.x, p.y, p.z))).collect();
        let facets: Vec<[usize; 3]> = self.0.hs.chunks(3).map(|h| [h[0].tail, h[1].tail, h[2].tail]).collect();
        Self::new(&vertices, &facets)
    }

    pub(crate) fn at(&self, x: f64, y: f64, z: f64) -> Self {
        self.mapped(|p| p + Vec3::new(x, y, z))
    }

    pub(crate) fn scaled(&self, x: f64, y: f64, z: f64) -> Self {
        self.mapped(|p| p.component_mul(&Vec3::new(x, y, z)))
    }

    /// Turned about y, so that +z goes toward +x.
    pub(crate) fn about_y(&self, deg: f64) -> Self {
        let (s, c) = deg.to_radians().sin_cos();
        self.mapped(|p| Mat3::new(c, 0.0, s, 0.0, 1.0, 0.0, -s, 0.0, c) * p)
    }

    pub(crate) fn about_z(&self, deg: f64) -> Self {
        let (s, c) = deg.to_radians().sin_cos();
        self.mapped(|p| Mat3::new(c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0) * p)
    }

    fn with(&self, other: &Self, what: &OpType) -> Self {
        let what = match what {
            OpType::Add => OpType::Add,
            OpType::Subtract => OpType::Subtract,
            OpType::Intersect => OpType::Intersect,
        };
        Self(compute_boolean(&self.0, &other.0, what).expect("a boolean of closed shapes"))
    }

    pub(crate) fn and(&self, other: &Self) -> Self {
        self.with(other, &OpType::Add)
    }

    pub(crate) fn less(&self, other: &Self) -> Self {
        self.with(other, &OpType::Subtract)
    }

    pub(crate) fn mesh(&self) -> TriangleMesh<Object> {
        let vertices = self.0.ps.iter().map(|p| Vec3::new(p.x, p.y, p.z)).collect();
        let facets = self.0.hs.chunks(3).map(|h| [h[0].tail as u32, h[1].tail as u32, h[2].tail as u32]).collect();
        TriangleMesh::new(vertices, facets)
    }
}

/// From the origin to `(x, y, z)`.
pub(crate) fn block(x: f64, y: f64, z: f64) -> Shape {
    let vertices: Vec<Vec3> = (0..8)
        .map(|i| {
            Vec3::new(if i & 1 > 0 { x } else { 0.0 }, if i & 2 > 0 { y } else { 0.0 }, if i & 4 > 0 { z } else { 0.0 })
        })
        .collect();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let facets: Vec<[usize; 3]> = quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect();
    Shape::new(&vertices, &facets)
}

/// Upright on z = 0.
pub(crate) fn rod(radius: f64, height: f64, sides: usize) -> Shape {
    let at = |k: usize, z: f64| {
        let (s, c) = (std::f64::consts::TAU * k as f64 / sides as f64).sin_cos();
        Vec3::new(radius * c, radius * s, z)
    };
    let vertices: Vec<Vec3> = (0..2 * sides).map(|i| at(i % sides, if i < sides { 0.0 } else { height })).collect();
    let mut facets = Vec::new();
    for k in 0..sides {
        let next = (k + 1) % sides;
        facets.extend([[k, next, sides + next], [k, sides + next, sides + k]]);
    }
    facets.extend((1..sides - 1).flat_map(|k| [[0, k + 1, k], [sides, sides + k, sides + k + 1]]));
    Shape::new(&vertices, &facets)
}

/// A body of revolution about +z, upright: `[radius, z]` of its rings from below.
pub(crate) fn turned(rings: &[[f64; 2]], sides: usize) -> Shape {
    let circle = |&[radius, z]: &[f64; 2]| -> Vec<Vec3> {
        let angle = |k: usize| std::f64::consts::TAU * k as f64 / sides as f64;
        (0..sides).map(|k| Vec3::new(radius * angle(k).cos(), radius * angle(k).sin(), z)).collect()
    };
    let vertices: Vec<Vec3> = rings.iter().flat_map(circle).collect();
    let top = vertices.len() - sides;
    let mut facets: Vec<[usize; 3]> =
        (1..sides - 1).flat_map(|k| [[0, k + 1, k], [top, top + k, top + k + 1]]).collect();
    for ring in (0..top).step_by(sides) {
        for k in 0..sides {
            let (a, b) = (ring + k, ring + (k + 1) % sides);
            facets.extend([[a, b, sides + b], [a, sides + b, sides + a]]);
        }
    }
    Shape::new(&vertices, &facets)
}

/// About the origin: `sides` meridians, half as many bands.
pub(crate) fn ball(radius: f64, sides: usize) -> Shape {
    let bands = sides / 2;
    let mut vertices = vec![Vec3::new(0.0, 0.0, -radius)];
    for band in 1..bands {
        let (s, c) = (std::f64::consts::PI * band as f64 / bands as f64).sin_cos();
        vertices.extend((0..sides).map(|k| {
            let (y, x) = (std::f64::consts::TAU * k as f64 / sides as f64).sin_cos();
            Vec3::new(radius * s * x, radius * s * y, -radius * c)
        }));
    }
    vertices.push(Vec3::new(0.0, 0.0, radius));
    let top = vertices.len() - 1;
    let at = |band: usize, k: usize| 1 + (band - 1) * sides + k % sides;
    let mut facets = Vec::new();
    for k in 0..sides {
        facets.push([0, at(1, k + 1), at(1, k)]);
        facets.push([top, at(bands - 1, k), at(bands - 1, k + 1)]);
        for band in 1..bands - 1 {
            let (a, b, c, d) = (at(band, k), at(band, k + 1), at(band + 1, k + 1), at(band + 1, k));
            facets.extend([[a, b, c], [a, c, d]]);
        }
    }
    Shape::new(&vertices, &facets)
}

fn plate() -> Shape {
    block(40.0, 40.0, 6.0).at(-20.0, -20.0, 0.0)
}

pub(crate) fn tee() -> Shape {
    block(10.0, 10.0, 40.0).at(-5.0, -5.0, 0.0).and(&block(60.0, 10.0, 10.0).at(-30.0, -5.0, 40.0))
}

pub(crate) fn mushroom() -> Shape {
    let dome = ball(30.0, 64).less(&block(80.0, 80.0, 40.0).at(-40.0, -40.0, -40.0));
    rod(10.0, 40.0, 64).and(&dome.scaled(1.0, 1.0, 0.5).at(0.0, 0.0, 40.0))
}

pub(crate) fn hook() -> Shape {
    let post = plate().and(&block(10.0, 10.0, 70.0).at(-5.0, -5.0, 0.0));
    post.and(&block(45.0, 10.0, 10.0).at(-5.0, -5.0, 60.0)).and(&block(10.0, 10.0, 30.0).at(30.0, -5.0, 60.0))
}

pub(crate) fn bracket() -> Shape {
    let angle = block(50.0, 40.0, 6.0).and(&block(6.0, 40.0, 60.0)).at(-25.0, -20.0, 0.0);
    let boss = rod(10.0, 40.0, 64).about_y(90.0).at(-22.0, 0.0, 45.0);
    angle.and(&boss).less(&rod(5.0, 80.0, 64).about_y(90.0).at(-40.0, 0.0, 45.0))
}

pub(crate) fn wye() -> Shape {
    rod(15.0, 80.0, 64).and(&rod(15.0, 60.0, 64).about_y(60.0).at(0.0, 0.0, 35.0))
}

pub(crate) fn tee_pipe() -> Shape {
    rod(15.0, 80.0, 64).scaled(1.0, 1.0, 1.2).and(&rod(8.0, 50.0, 64).about_y(90.0).at(0.0, 0.0, 60.0))
}

pub(crate) fn wye_pipe() -> Shape {
    let hollow = wye().less(&rod(12.0, 82.0, 64).at(0.0, 0.0, -1.0));
    hollow.less(&rod(12.0, 80.0, 64).about_y(60.0).at(0.0, 0.0, 35.0))
}

pub(crate) fn bridge() -> Shape {
    block(60.0, 10.0, 40.0).at(-30.0, -5.0, 0.0).less(&block(40.0, 12.0, 30.0).at(-20.0, -6.0, 0.0))
}

pub(crate) fn menorah() -> Shape {
    let mut all = rod(25.0, 8.0, 64).and(&rod(7.0, 90.0, 64));
    for k in 0..4 {
        let low = 30.0 + 25.0 * f64::from(k % 2);
        let (s, c) = 70.0_f64.to_radians().sin_cos();
        let end = [40.0 * s, 0.0, low + 40.0 * c];
        let arm = rod(5.0, 40.0, 32).about_y(70.0).at(0.0, 0.0, low);
        let knee = ball(5.0, 32).at(end[0], end[1], end[2]);
        let upright = rod(5.0, 25.0, 32).at(end[0], end[1], end[2]);
        all = all.and(&arm.and(&knee).and(&upright).about_z(90.0 * f64::from(k)));
    }
    all
}

/// The nine of the table, and a flat bridge that nobody can print without bridging.
pub(crate) fn all() -> Vec<Solid> {
    let solid = |name, shape, needs_mm2, cuts, left_mm2| Solid { name, shape, needs_mm2, cuts, left_mm2 };
    vec![
        solid("tee", tee(), 500.0, 2, 0.5),
        solid("mushroom", mushroom(), 2509.2, 3, 0.5),
        solid("hook", hook(), 350.0, 1, 0.5),
        solid("bracket", bracket(), 918.5, 4, 0.5),
        solid("wye", wye(), 915.7, 1, 0.5),
        solid("tee-pipe", tee_pipe(), 444.8, 1, 0.5),
        solid("wye-pipe", wye_pipe(), 1487.0, 1, 0.5),
        solid("menorah", menorah(), 1123.0, 5, 1.6),
    ]
}
