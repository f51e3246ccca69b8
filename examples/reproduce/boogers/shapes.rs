//! Parts of the thesis that can be made: a unit cube, and a cube with a cut-out.

use std::collections::HashMap;

use trunnion::geom::Angle;
use trunnion::geom::{Bounds, Object, Vec3};
use trunnion::mesh::TriangleMesh;
use trunnion::orient::{Cost, Smoothing, Supported, from_angles};

pub(super) const CUT: &str =
    "measures of the cut-out are not printed; ours is a third of the cube high and two thirds deep, side 3 mm";

/// A cube of side 1 about the origin.
pub(super) fn unit_cube() -> TriangleMesh<Object> {
    TriangleMesh::cuboid(&Bounds { min: Vec3::repeat(-0.5), max: Vec3::repeat(0.5) })
}

/// A cube of 3 mm with a slot of 1 mm along X, 2 mm deep, open towards +Y; a millimetre of each face is `2 cut²` facets.
pub(super) fn cut_out(cut: usize) -> TriangleMesh<Object> {
    let solid = |c: [i64; 3]| c.iter().all(|v| (0..3).contains(v)) && !(c[2] == 1 && c[1] >= 1);
    let n = cut as i64;
    let mut index: HashMap<[i64; 3], u32> = HashMap::new();
    let (mut points, mut facets) = (Vec::new(), Vec::new());
    for cell in (0..27).map(|i| [i % 3, i / 3 % 3, i / 9]).filter(|&cell| solid(cell)) {
        for (axis, sense) in (0..3).flat_map(|axis| [(axis, -1), (axis, 1)]) {
            let mut beside = cell;
            beside[axis] += sense;
            if solid(beside) {
                continue;
            }
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            for (i, j) in (0..n * n).map(|k| (k % n, k / n)) {
                let mut at = |du: i64, dv: i64| {
                    let mut p = cell.map(|c| c * n);
                    p[axis] += if sense > 0 { n } else { 0 };
                    p[u] += i + du;
                    p[v] += j + dv;
                    *index.entry(p).or_insert_with(|| {
                        points.push(Vec3::from_fn(|k, _| p[k] as f64 / n as f64 - 1.5));
                        points.len() as u32 - 1
                    })
                };
                let mut ring = [at(0, 0), at(1, 0), at(1, 1), at(0, 1)];
                if sense < 0 {
                    ring.reverse();
                }
                facets.extend([[ring[0], ring[1], ring[2]], [ring[0], ring[2], ring[3]]]);
            }
        }
    }
    TriangleMesh::new(points, facets)
}

/// A smoothed objective; angles in degrees from the vertical.
pub(super) fn smooth(cost: Cost, overhang: f64, carrying: f64, k: f64, w: f64) -> Supported {
    let [overhang, carrying] = [overhang, carrying].map(Angle::from_deg);
    Supported { cost, smoothing: Smoothing { overhang, carrying, k, w }, resolution_mm: 0.1 }
}

/// The build direction of two angles, degrees.
pub(super) fn up(alpha: f64, beta: f64) -> Vec3 {
    from_angles(alpha.to_radians(), beta.to_radians())
}

/// How the build direction moves with each angle, per radian.
pub(super) fn by_angles(alpha: f64, beta: f64) -> [Vec3; 2] {
    let ((sa, ca), (sb, cb)) = (alpha.to_radians().sin_cos(), beta.to_radians().sin_cos());
    [Vec3::new(0.0, cb * ca, -cb * sa), Vec3::new(-cb, -sb * sa, -sb * ca)]
}
