//! A mesh as the binary STL that every slicer reads.

use crate::geom::{Slot, Vec3};
use crate::mesh::TriangleMesh;

/// The mesh as binary STL; coordinates in mm as `f32`, the format's own precision (0.00003 mm at 300 mm).
pub(super) fn binary_stl(mesh: &TriangleMesh<Slot>) -> Vec<u8> {
    let count = mesh.facets().len();
    let mut bytes = Vec::with_capacity(84 + 50 * count);
    bytes.resize(80, b' ');
    bytes.extend((count as u32).to_le_bytes());
    for facet in 0..count {
        let normal = mesh.normal(facet).unwrap_or_else(Vec3::zeros);
        for vector in [[normal].as_slice(), &mesh.corners(facet)].concat() {
            for value in [vector.x, vector.y, vector.z] {
                bytes.extend((value as f32).to_le_bytes());
            }
        }
        bytes.extend([0, 0]);
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::binary_stl;
    use crate::slicing::testing::block;

    #[test]
    fn a_block_has_twelve_records_of_fifty_bytes() {
        let bytes = binary_stl(&block([1.0, 2.0, 0.0], [3.0, 4.0, 5.0]));
        assert_eq!(bytes.len(), 84 + 12 * 50);
        assert_eq!(bytes[80..84], 12u32.to_le_bytes());
        assert_eq!(bytes[84..96], [0.0f32, -1.0, 0.0].map(f32::to_le_bytes).concat()[..]);
    }
}
