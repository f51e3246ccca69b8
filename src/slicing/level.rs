//! What other slicers are given: the mesh, a hair lower than it is.

use crate::geom::{Slot, Vec3};
use crate::mesh::TriangleMesh;

/// By so much, mm: far below what any printer moves, far above what a mesh file's single precision rounds off.
const LOWER_MM: f64 = 1e-3;
/// Below this height by less, mm, so that what lies on z = 0 stays there and no facet turns over.
const RAMP_MM: f64 = 0.1;

/// The mesh with every level face a thousandth of a millimetre lower, but for what lies on z = 0.
///
/// A level face that lies exactly in the middle of a layer is at once the end of what is below it and the beginning of what is above: whose
/// section that layer has is for each slicer to choose. Ours takes what is above; PrusaSlicer 2.5 was seen to take what is below, and then
/// its layer is not the part's. A hair lower the face lies in no layer's middle, and all slicers take what is above.
pub fn below_middles(mesh: &TriangleMesh<Slot>) -> TriangleMesh<Slot> {
    let lowered = |p: &Vec3| Vec3::new(p.x, p.y, p.z - LOWER_MM * (p.z / RAMP_MM).clamp(0.0, 1.0));
    TriangleMesh::new(mesh.vertices().iter().map(lowered).collect(), mesh.facets().to_vec())
}

#[cfg(test)]
mod tests {
    use super::super::testing::block;
    use super::*;

    #[test]
    fn what_lies_on_the_table_stays_and_all_else_is_lower() {
        let mesh = block([0.0; 3], [10.0, 10.0, 7.08]);
        let lower = below_middles(&mesh);
        for (was, is) in mesh.vertices().iter().zip(lower.vertices()) {
            assert_eq!([was.x, was.y], [is.x, is.y]);
            assert!(if was.z == 0.0 { is.z == 0.0 } else { (was.z - is.z - 1e-3).abs() < 1e-12 });
        }
        // Single precision keeps it, also of a tall part.
        let tall = below_middles(&block([0.0; 3], [10.0, 10.0, 600.12]));
        assert!(tall.bounds().max.z as f32 <= 600.1195);
        // Order is kept on the way up.
        let heights = [0.0, 0.001, 0.05, 0.0999, 0.1, 0.1001, 3.0];
        let column: Vec<Vec3> = heights.iter().map(|&z| Vec3::new(0.0, 0.0, z)).collect();
        let lower = below_middles(&TriangleMesh::new(column, Vec::new()));
        assert!(lower.vertices().is_sorted_by(|a, b| a.z < b.z));
    }
}
