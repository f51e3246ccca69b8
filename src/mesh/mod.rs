//! Triangle meshes: readers, welding, closed parts, interfaces between parts, writers.
//!
//! Coordinates are mm in the frame the mesh's type names. A facet's corners turn counter-clockwise seen from
//! outside, so `(b - a) x (c - a)` points outward.
//!
//! This room must not know machines, slots or G-code.

mod triangle_mesh;

pub use triangle_mesh::TriangleMesh;
