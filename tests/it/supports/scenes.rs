//! Scenes that want support: closed tubes and balls in the air, up to the sizes of Leitereg's (2020) inputs D and E. Used by the tests and
//! by `benches/support.rs`.
//!
//! Slot frame, mm; the ground is z = 0.

use std::f64::consts::TAU;

use trunnion::geom::{Angle, Slot, SplitMix64, Vec3};
use trunnion::mesh::TriangleMesh;
use trunnion::support::{Graph, Grid};

/// A scene: its solids, its space, the step that its graph is counted at.
pub(crate) struct Scene {
    pub(crate) meshes: Vec<TriangleMesh<Slot>>,
    pub(crate) space: [f64; 3],
    pub(crate) step_mm: f64,
}

impl Scene {
    /// The graph at 45 degrees.
    pub(crate) fn graph(&self) -> Graph {
        let grid = Grid::over(Vec3::zeros(), self.space, self.step_mm);
        Graph::of(grid, &self.meshes.iter().collect::<Vec<_>>(), Angle::from_deg(45.0))
    }
}

/// A tube of radius `r` along the closed curve `at` (of 0 to 1), `along` times `around` quadrilaterals.
pub(crate) fn tube(at: &dyn Fn(f64) -> Vec3, r: f64, along: usize, around: usize) -> TriangleMesh<Slot> {
    let mut vertices = Vec::new();
    for i in 0..along {
        let t = i as f64 / along as f64;
        let tangent = (at(t + 1e-4) - at(t - 1e-4)).normalize();
        // No curve here runs straight along this direction.
        let side = tangent.cross(&Vec3::new(0.0123, 0.0456, 1.0)).normalize();
        let other = side.cross(&tangent);
        for j in 0..around {
            let turn = TAU * j as f64 / around as f64;
            vertices.push(at(t) + r * (turn.cos() * side + turn.sin() * other));
        }
    }
    let index = |i: usize, j: usize| (i % along * around + j % around) as u32;
    let mut facets = Vec::new();
    for i in 0..along {
        for j in 0..around {
            let [a, b, c, d] = [index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1)];
            facets.extend([[a, b, c], [a, c, d]]);
        }
    }
    outward(TriangleMesh::new(vertices, facets))
}

/// Facets turned so that they face out.
fn outward(mesh: TriangleMesh<Slot>) -> TriangleMesh<Slot> {
    if mesh.volume() >= 0.0 {
        return mesh;
    }
    let facets = mesh.facets().iter().map(|&[a, b, c]| [a, c, b]).collect();
    TriangleMesh::new(mesh.vertices().to_vec(), facets)
}

/// A ring of radius `big` about `middle`, its tube of radius `small`, its axis leaning by `lean` towards `turn`.
pub(crate) fn ring(middle: Vec3, [big, small]: [f64; 2], lean: Angle, turn: f64, detail: usize) -> TriangleMesh<Slot> {
    let axis = Vec3::new(lean.rad().sin() * turn.cos(), lean.rad().sin() * turn.sin(), lean.rad().cos());
    let u = axis.cross(&Vec3::new(0.3, 0.7, 0.1)).normalize();
    let v = axis.cross(&u);
    let at = move |t: f64| middle + big * ((TAU * t).cos() * u + (TAU * t).sin() * v);
    tube(&at, small, 2 * detail, detail)
}

/// A ball.
pub(crate) fn ball(middle: Vec3, radius: f64, detail: usize) -> TriangleMesh<Slot> {
    let (rows, round) = (detail, 2 * detail);
    let mut vertices = vec![middle - Vec3::z() * radius, middle + Vec3::z() * radius];
    for i in 1..rows {
        let polar = std::f64::consts::PI * i as f64 / rows as f64;
        for j in 0..round {
            let turn = TAU * j as f64 / round as f64;
            let p = Vec3::new(polar.sin() * turn.cos(), polar.sin() * turn.sin(), -polar.cos());
            vertices.push(middle + p * radius);
        }
    }
    let index = |i: usize, j: usize| (2 + (i - 1) * round + j % round) as u32;
    let mut facets = Vec::new();
    for j in 0..round {
        facets.extend([[0, index(1, j + 1), index(1, j)], [1, index(rows - 1, j), index(rows - 1, j + 1)]]);
        for i in 1..rows - 1 {
            let [a, b, c, d] = [index(i, j), index(i, j + 1), index(i + 1, j + 1), index(i + 1, j)];
            facets.extend([[a, b, c], [a, c, d]]);
        }
    }
    outward(TriangleMesh::new(vertices, facets))
}

/// A box from corner to corner.
pub(crate) fn block(low: Vec3, high: Vec3) -> TriangleMesh<Slot> {
    let at = |k: usize| Vec3::from_fn(|axis, _| if k >> axis & 1 == 1 { high[axis] } else { low[axis] });
    let quads: [[u32; 4]; 6] = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let facets = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    TriangleMesh::new((0..8).map(at).collect(), facets)
}

/// A leaning ring in the air, of the size of the thesis's input A.
pub(crate) fn leaning_ring() -> Scene {
    let mesh = ring(Vec3::new(45.0, 45.0, 31.0), [14.0, 5.0], Angle::from_deg(20.0), 0.4, 40);
    Scene { meshes: vec![mesh], space: [90.0, 90.0, 50.0], step_mm: 2.15 }
}

/// A ball over a ball: the supports of the upper one go round the lower one.
pub(crate) fn two_balls() -> Scene {
    let meshes = [(30.0, 20.0), (78.0, 10.0)].map(|(z, radius)| ball(Vec3::new(50.0, 50.0, z), radius, 40));
    Scene { meshes: meshes.into(), space: [100.0, 100.0, 90.0], step_mm: 1.9 }
}

/// A large knotted tube: 1.1 million nodes, as the thesis's input D.
pub(crate) fn knot() -> Scene {
    let at = |t: f64| {
        let (a, r) = (TAU * t, 26.0);
        let (x, y) = (a.sin() + 2.0 * (2.0 * a).sin(), a.cos() - 2.0 * (2.0 * a).cos());
        Vec3::new(100.0 + r * x, 100.0 + r * y, 100.0 + 14.0 * -(3.0 * a).sin())
    };
    Scene { meshes: vec![tube(&at, 11.0, 900, 60)], space: [200.0, 200.0, 140.0], step_mm: 1.25 }
}

/// Hundreds of leaning rings, above and beside each other: 6.5 million nodes, as the thesis's input E.
pub(crate) fn many_rings() -> Scene {
    let mut numbers = SplitMix64::seeded(7);
    let mut meshes = Vec::new();
    for k in 0..400 {
        let cell = [k % 10, k / 10 % 10, k / 100].map(|i| f64::from(i as u32));
        let middle = Vec3::new(12.5 + 25.0 * cell[0], 12.5 + 25.0 * cell[1], 18.0 + 22.0 * cell[2]);
        let lean = Angle::from_deg(70.0 * numbers.unit());
        meshes.push(ring(middle, [6.5 + 1.5 * numbers.unit(), 2.0], lean, TAU * numbers.unit(), 24));
    }
    Scene { meshes, space: [250.0, 250.0, 100.0], step_mm: 0.87 }
}
