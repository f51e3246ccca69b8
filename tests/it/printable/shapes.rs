//! Made-up solids that everybody knows how to lay down, mm, each with what holds of the way a person lays it.

use std::f64::consts::{PI, TAU};

use trunnion::fixtures::{prism, solid_box};
use trunnion::geom::Vec3;
use trunnion::mesh::TriangleMesh;

use crate::solids::Mesh;

/// A solid, as it lies in its file, and the directions that a person may turn up.
pub(crate) struct Shape {
    pub(crate) name: &'static str,
    pub(crate) mesh: Mesh,
    pub(crate) ups: Vec<Vec3>,
    /// Whether it can stand by itself without any support.
    pub(crate) bare: bool,
}

fn shape(name: &'static str, mesh: Mesh, ups: &[Vec3]) -> Shape {
    Shape { name, mesh, ups: ups.to_vec(), bare: true }
}

/// Each is turned anyhow by the tests, so that none lies well by chance.
pub(crate) fn shapes() -> Vec<Shape> {
    let (x, y, z) = (Vec3::x(), Vec3::y(), Vec3::z());
    let slope = -Vec3::new(25.0, 0.0, 60.0).normalize();
    // Caps are fans about the last corner, which must see all others.
    let l = [[8.0, 50.0], [0.0, 50.0], [0.0, 0.0], [40.0, 0.0], [40.0, 8.0], [8.0, 8.0]];
    let wedge = [[0.0, 0.0], [60.0, 0.0], [0.0, 25.0]];
    let mut all = vec![
        shape("cube", solid_box(Vec3::zeros(), Vec3::repeat(20.0)), &[x, -x, y, -y, z, -z]),
        shape("plate", solid_box(Vec3::zeros(), Vec3::new(100.0, 60.0, 1.0)), &[z, -z]),
        shape("brick", solid_box(Vec3::zeros(), Vec3::new(60.0, 30.0, 20.0)), &[z, -z]),
        shape("cone", turned_body(&[[20.0, 0.0], [0.0, 50.0]]), &[z]),
        shape("cylinder", turned_body(&[[10.0, 0.0], [10.0, 60.0]]), &[z, -z]),
        shape("mushroom", turned_body(&[[7.0, 0.0], [7.0, 25.0], [20.0, 25.0], [14.0, 33.0], [6.0, 36.0]]), &[z, -z]),
        shape("ring", ring(20.0, 14.0, 8.0), &[z, -z]),
        shape("T", boxes(&[[0.0, 20.0, 0.0, 30.0, 0.0, 10.0], [8.0, 12.0, 30.0, 60.0, 0.0, 10.0]]), &[z, -z]),
        shape("L", prism(&l, [0.0, 20.0]), &[y, -y, z, x]),
        shape("wedge", prism(&wedge, [0.0, 20.0]), &[z, y, -y, slope]),
        shape("table", table(), &[-z]),
        shape("bracket", bracket(), &[z, x]),
        shape("CAD part", cad_part(), &[z, y, -y]),
    ];
    // Of a mushroom something hangs either way.
    all[5].bare = false;
    all
}

/// Boxes that touch or overlap, as one part: least and largest x, y, z.
pub(crate) fn boxes(all: &[[f64; 6]]) -> Mesh {
    let (mut points, mut facets) = (Vec::new(), Vec::new());
    for &[x0, x1, y0, y1, z0, z1] in all {
        let one = solid_box(Vec3::new(x0, y0, z0), Vec3::new(x1, y1, z1));
        let first = points.len() as u32;
        points.extend_from_slice(one.vertices());
        facets.extend(one.facets().iter().map(|f| f.map(|i| i + first)));
    }
    TriangleMesh::new(points, facets)
}

/// A top of 100 x 60 x 5 on four legs of 8 x 8 x 40.
fn table() -> Mesh {
    let leg = |x: f64, y: f64| [x, x + 8.0, y, y + 8.0, 0.0, 40.0];
    boxes(&[[0.0, 100.0, 0.0, 60.0, 40.0, 45.0], leg(2.0, 2.0), leg(90.0, 2.0), leg(2.0, 50.0), leg(90.0, 50.0)])
}

/// Two plates at a right angle with a rib between them.
fn bracket() -> Mesh {
    let rib = prism(&[[4.0, 4.0], [30.0, 4.0], [4.0, 30.0]], [13.0, 17.0]);
    let plates = boxes(&[[0.0, 40.0, 0.0, 30.0, 0.0, 4.0], [0.0, 4.0, 0.0, 30.0, 4.0, 40.0]]);
    let mut points = plates.vertices().to_vec();
    let first = points.len() as u32;
    points.extend_from_slice(rib.vertices());
    let more = rib.facets().iter().map(|f| f.map(|i| i + first));
    TriangleMesh::new(points, plates.facets().iter().copied().chain(more).collect())
}

/// As the fandisk: a flat base, a slope, a rounded back, a step on top.
fn cad_part() -> Mesh {
    let mut outline = vec![[0.0, 10.0], [0.0, 0.0], [60.0, 0.0], [60.0, 12.0]];
    outline.extend((0..=12).map(|i| {
        let angle = f64::from(i) / 12.0 * PI / 2.0;
        [40.0 + 18.0 * angle.cos(), 14.0 + 18.0 * angle.sin()]
    }));
    outline.extend([[25.0, 32.0], [5.0, 12.0]]);
    let body = prism(&outline, [0.0, 30.0]);
    // Single precision, as files have it.
    TriangleMesh::new(
        body.vertices().iter().map(|v| v.map(|c| f64::from((c * 1.1) as f32))).collect(),
        body.facets().to_vec(),
    )
}

/// A body of revolution about Z by radius and height, from the bottom up, closed by discs or points; in 48 parts.
pub(crate) fn turned_body(outline: &[[f64; 2]]) -> Mesh {
    const TURNS: usize = 48;
    let at = |[r, z]: [f64; 2], j: usize| {
        let (sin, cos) = (TAU * (j % TURNS) as f64 / TURNS as f64).sin_cos();
        Vec3::new(r * cos, r * sin, z)
    };
    let (low, high) = (outline[0], outline[outline.len() - 1]);
    let mut corners: Vec<[Vec3; 3]> = Vec::new();
    for j in 0..TURNS {
        for pair in outline.windows(2) {
            let [a, b, c, d] = [at(pair[0], j), at(pair[0], j + 1), at(pair[1], j + 1), at(pair[1], j)];
            corners.extend([[a, b, c], [a, c, d]]);
        }
        corners.push([Vec3::new(0.0, 0.0, low[1]), at(low, j + 1), at(low, j)]);
        corners.push([Vec3::new(0.0, 0.0, high[1]), at(high, j), at(high, j + 1)]);
    }
    welded(&corners)
}

fn ring(outer: f64, inner: f64, height: f64) -> Mesh {
    let round = [[inner, 0.0], [outer, 0.0], [outer, height], [inner, height], [inner, 0.0]];
    let mut corners: Vec<[Vec3; 3]> = Vec::new();
    let at = |[r, z]: [f64; 2], j: usize| {
        let (sin, cos) = (TAU * (j % 48) as f64 / 48.0).sin_cos();
        Vec3::new(r * cos, r * sin, z)
    };
    for j in 0..48 {
        for pair in round.windows(2) {
            let [a, b, c, d] = [at(pair[0], j), at(pair[0], j + 1), at(pair[1], j + 1), at(pair[1], j)];
            corners.extend([[a, b, c], [a, c, d]]);
        }
    }
    welded(&corners)
}

/// Equal corners are one; facets without area are left out.
fn welded(corners: &[[Vec3; 3]]) -> Mesh {
    let (mut points, mut facets): (Vec<Vec3>, Vec<[u32; 3]>) = (Vec::new(), Vec::new());
    let mut number = |p: Vec3| match points.iter().position(|q| (q - p).norm() < 1e-9) {
        Some(i) => i as u32,
        None => {
            points.push(p);
            points.len() as u32 - 1
        }
    };
    for corner in corners {
        let facet = corner.map(&mut number);
        if facet[0] != facet[1] && facet[1] != facet[2] && facet[2] != facet[0] {
            facets.push(facet);
        }
    }
    TriangleMesh::new(points, facets)
}
