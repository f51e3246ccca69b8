//! Which way a model stands, and where several stand beside each other.

use crate::geom::{Object, Rigid, Vec3, turned_by};
use crate::mesh::{Model, Part, TriangleMesh};

/// A face this near to looking straight down is laid flat, degrees: directions are typed with a few digits.
const LAID_FLAT_DEG: f64 = 1.0;
/// Facets of one face, degrees.
const ONE_FACE_DEG: f64 = 0.1;
/// Nothing stands on less, mm².
const LEAST_STAND_MM2: f64 = 1.0;
/// What may lie below the face that a model stands on, mm: what still stands on the table.
const BELOW_MM: f64 = crate::mesh::TABLE_GAP_MM;

/// The turn that brings `up` upright by the shortest way; where a face would then look down but for a degree, that face flat.
///
/// `up` is any vector but zero, file's frame.
pub fn upright(parts: &[Part], up: Vec3) -> Rigid<Object, Object> {
    let up = up.normalize();
    let low = lowest(parts, &up);
    let near = faces(parts.iter().map(|part| &part.mesh))
        .into_iter()
        .filter(|face| face.normal.dot(&up) < -LAID_FLAT_DEG.to_radians().cos() && face.at.dot(&up) < low + 1.0)
        .max_by(|a, b| a.area_mm2.total_cmp(&b.area_mm2));
    let turn = turned_by(&near.map_or(up, |face| -face.normal));
    Rigid::new(turn.to_rotation_matrix().into_inner(), Vec3::zeros())
}

/// The direction that is up where the model stands on a face of `part`: the largest of its faces below which there is nothing;
/// `None` where there is none.
pub fn up_on(model: &Model, part: usize) -> Option<Vec3> {
    let below = |face: &Face| face.at.dot(&-face.normal) - lowest(&model.parts, &-face.normal);
    let standing = faces(std::iter::once(&model.parts[part].mesh)).into_iter().filter(|face| below(face) <= BELOW_MM);
    standing.max_by(|a, b| a.area_mm2.total_cmp(&b.area_mm2)).map(|face| -face.normal)
}

/// The directions that are up where the model stands on a face, the one with the largest area on the table first; +Z before all
/// where it stands so as it was drawn. Faces of several parts in one plane count together.
///
/// Faces smaller than 1 mm² are left out. Empty for a model without plane faces that have nothing below them.
pub fn stands(model: &Model) -> Vec<Vec3> {
    let below = |face: &Face| face.at.dot(&-face.normal) - lowest(&model.parts, &-face.normal);
    let all = faces(model.parts.iter().map(|part| &part.mesh)).into_iter();
    let mut standing: Vec<Face> =
        all.filter(|face| below(face) <= BELOW_MM && face.area_mm2 >= LEAST_STAND_MM2).collect();
    let drawn = |face: &Face| -face.normal.z > ONE_FACE_DEG.to_radians().cos();
    standing.sort_by(|a, b| drawn(b).cmp(&drawn(a)).then(b.area_mm2.total_cmp(&a.area_mm2)));
    // Adding 0 turns the negative one round.
    standing.into_iter().map(|face| Vec3::from_fn(|axis, _| 0.0 - face.normal[axis])).collect()
}

/// How far down the model reaches along `up`, mm.
fn lowest(parts: &[Part], up: &Vec3) -> f64 {
    let vertices = parts.iter().flat_map(|part| part.mesh.vertices());
    vertices.map(|v| v.dot(up)).fold(f64::INFINITY, f64::min)
}

/// Facets that look one way and lie in one plane.
struct Face {
    normal: Vec3,
    at: Vec3,
    area_mm2: f64,
}

/// The plane faces, in the order of their first facets; a facet belongs to the first face that it fits.
fn faces<'a>(meshes: impl Iterator<Item = &'a TriangleMesh<Object>>) -> Vec<Face> {
    let alike = ONE_FACE_DEG.to_radians().cos();
    let mut buckets: std::collections::HashMap<[i64; 3], Vec<usize>> = std::collections::HashMap::new();
    let mut found: Vec<Face> = Vec::new();
    for mesh in meshes {
        for facet in 0..mesh.facets().len() {
            let Some(normal) = mesh.normal(facet) else { continue };
            let (at, area_mm2) = (mesh.corners(facet)[0], mesh.facet_area(facet));
            // Normals in cells wider than a face's spread; the cells around are looked through too.
            let cell = [0, 1, 2].map(|k| (normal[k] * CELLS).floor() as i64);
            let around = (0..27).map(|i| [cell[0] + i % 3 - 1, cell[1] + i / 3 % 3 - 1, cell[2] + i / 9 - 1]);
            let fits =
                |face: &Face| face.normal.dot(&normal) > alike && (at - face.at).dot(&face.normal).abs() < BELOW_MM;
            let known = around.filter_map(|cell| buckets.get(&cell)).flatten().copied().find(|&i| fits(&found[i]));
            match known {
                Some(index) => found[index].area_mm2 += area_mm2,
                None => {
                    buckets.entry(cell).or_default().push(found.len());
                    found.push(Face { normal, at, area_mm2 });
                }
            }
        }
    }
    found
}

/// Cells of a unit normal's coordinates.
const CELLS: f64 = 256.0;

/// Where models of the given footprints (`x`, `y`, mm) stand in rows with `gap_mm` between them: each one's low corner. Of all
/// numbers of rows the one is taken whose corners lie nearest to the middle.
pub fn in_rows(footprints: &[[f64; 2]], gap_mm: f64) -> Vec<[f64; 2]> {
    let layouts = (1..=footprints.len()).map(|rows| laid_out(footprints, rows, gap_mm));
    let best = layouts.min_by(|a, b| a.1.total_cmp(&b.1));
    best.map(|(corners, _)| corners).unwrap_or_default()
}

/// So many rows, filled one after the other, and half of their diagonal.
fn laid_out(footprints: &[[f64; 2]], rows: usize, gap_mm: f64) -> (Vec<[f64; 2]>, f64) {
    let a_row = footprints.len().div_ceil(rows);
    let (mut corners, mut y, mut width) = (Vec::with_capacity(footprints.len()), 0.0, 0.0f64);
    for row in footprints.chunks(a_row) {
        let mut x = 0.0;
        for [w, _] in row {
            corners.push([x, y]);
            x += w + gap_mm;
        }
        width = width.max(x - gap_mm);
        y += row.iter().map(|[_, d]| *d).fold(0.0, f64::max) + gap_mm;
    }
    let size = width.hypot(y - gap_mm);
    (corners, size / 2.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::solid_box;

    fn model(parts: Vec<TriangleMesh<Object>>) -> Model {
        Model::from_parts(parts.into_iter().enumerate().map(|(i, mesh)| (format!("p{i}"), mesh)).collect())
    }

    #[test]
    fn up_becomes_up_and_a_face_that_is_nearly_below_lies_flat() {
        let bar = model(vec![solid_box(Vec3::zeros(), Vec3::new(30.0, 10.0, 5.0))]);
        for (up, height) in
            [([0.0, 0.0, 1.0], 5.0), ([0.0, 0.0, -2.0], 5.0), ([1.0, 0.0, 0.0], 30.0), ([0.0, -3.0, 0.0], 10.0)]
        {
            let turned = bar.parts[0].mesh.moved(&upright(&bar.parts, Vec3::from(up)));
            assert!((turned.bounds().size().z - height).abs() < 1e-12, "{up:?}");
            assert!((turned.volume() - 1500.0).abs() < 1e-9, "no mirror: {up:?}");
        }
        let nearly = Vec3::new(0.999_9, 0.01, 0.0);
        let laid = bar.parts[0].mesh.moved(&upright(&bar.parts, nearly));
        assert!((laid.bounds().size().z - 30.0).abs() < 1e-12, "0.6 degrees are laid flat");
        let slanted = bar.parts[0].mesh.moved(&upright(&bar.parts, Vec3::new(1.0, 0.1, 0.0)));
        assert!((slanted.bounds().size().z - (30.0 + 1.0) / 1.01f64.sqrt()).abs() < 1e-9, "5.7 degrees are meant");
    }

    #[test]
    fn every_face_with_nothing_below_it_is_stood_on_once_as_drawn_first() {
        // An L of two parts whose undersides lie in one plane: its two slots of air are no faces to stand on.
        let l = model(vec![
            solid_box(Vec3::zeros(), Vec3::new(10.0, 10.0, 40.0)),
            solid_box(Vec3::new(10.0, 0.0, 0.0), Vec3::new(50.0, 10.0, 10.0)),
        ]);
        let ups: Vec<[f64; 3]> = stands(&l).iter().map(|up| [up.x, up.y, up.z]).collect();
        // By area: both sides of the L, 800 mm2; its back, 400; the post's top and the arm's end, 100.
        assert_eq!(ups[0], [0.0, 0.0, 1.0]);
        assert_eq!(ups[1..3].iter().map(|up| up[1].abs()).collect::<Vec<_>>(), [1.0, 1.0]);
        assert_eq!(ups[3], [1.0, 0.0, 0.0]);
        assert_eq!(ups.len(), 6, "{ups:?}");
        assert!(ups[4..].contains(&[0.0, 0.0, -1.0]) && ups[4..].contains(&[-1.0, 0.0, 0.0]), "{ups:?}");
        // A needle stands on nothing: none of its faces has a square millimetre.
        let needle = TriangleMesh::new(
            vec![Vec3::zeros(), Vec3::new(0.02, 0.0, 9.0), Vec3::new(0.0, 0.02, 9.0), Vec3::new(-0.02, -0.02, 9.0)],
            vec![[0, 2, 1], [0, 3, 2], [0, 1, 3], [1, 2, 3]],
        );
        assert!(stands(&model(vec![needle])).is_empty());
    }

    #[test]
    fn a_model_stands_on_the_largest_face_below_which_there_is_nothing() {
        // An L of two parts: the second one's right side is the only face of it that everything else lies above.
        let l = model(vec![
            solid_box(Vec3::zeros(), Vec3::new(10.0, 10.0, 40.0)),
            solid_box(Vec3::new(10.0, 0.0, 0.0), Vec3::new(50.0, 10.0, 10.0)),
        ]);
        // Of its faces of 400 mm2 the top has the post beside it, and the underside lies in one plane with the post's.
        let up = up_on(&l, 1).unwrap();
        assert!((up - Vec3::z()).norm() < 1e-12 || up.y.abs() > 1.0 - 1e-12, "{up}");
        assert_eq!(up_on(&model(vec![solid_box(Vec3::zeros(), Vec3::new(50.0, 20.0, 5.0))]), 0).unwrap().z.abs(), 1.0);
        let inside = model(vec![
            solid_box(Vec3::zeros(), Vec3::new(30.0, 30.0, 10.0)),
            solid_box(Vec3::new(10.0, 10.0, 10.0), Vec3::new(20.0, 20.0, 20.0)),
            solid_box(Vec3::new(0.0, 0.0, 20.0), Vec3::new(30.0, 30.0, 30.0)),
        ]);
        assert_eq!(up_on(&inside, 1), None);
    }

    #[test]
    fn rows_are_as_near_to_the_middle_as_can_be() {
        let far = |corners: &[[f64; 2]]| corners.iter().map(|c| c[0].max(c[1])).fold(0.0, f64::max);
        assert_eq!(in_rows(&[[10.0, 10.0]], 5.0), [[0.0, 0.0]]);
        assert_eq!(in_rows(&[[10.0, 10.0]; 4], 5.0), [[0.0, 0.0], [15.0, 0.0], [0.0, 15.0], [15.0, 15.0]]);
        assert_eq!(in_rows(&[[40.0, 2.0]; 3], 1.0), [[0.0, 0.0], [0.0, 3.0], [0.0, 6.0]]);
        assert!(far(&in_rows(&[[10.0, 10.0]; 30], 2.0)) <= 60.0);
        assert!(in_rows(&[], 1.0).is_empty());
    }
}
