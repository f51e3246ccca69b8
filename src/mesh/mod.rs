//! Triangle meshes: readers, welding, closed parts, interfaces between parts, writers.
//!
//! Coordinates are mm in the frame the mesh's type names. A facet's corners turn counter-clockwise seen from
//! outside, so `(b - a) x (c - a)` points outward.
//!
//! Bytes come in and go out; this room opens no files. It must not know machines, slots or G-code.
//!
//! ```text
//! bytes -> read -> Soup (facets in file order) -> weld -> runs -> shells (paired edges) -> repair
//!       -> parts (outer shell + cavities) -> mm -> interfaces, table contact -> Model
//! ```
//!
//! An STL file of two cubes becomes a model of two parts that share a face:
//!
//! ```
//! use trunnion::geom::{Bounds, Vec3};
//! use trunnion::mesh::{ReadOptions, TriangleMesh, read_model, stl_binary_parts};
//!
//! // Two cubes of 10 mm, one on the other, as one STL file (mm, the file's own frame).
//! let cube = |z: f64| {
//!     TriangleMesh::<()>::cuboid(&Bounds { min: Vec3::new(0.0, 0.0, z), max: Vec3::new(10.0, 10.0, z + 10.0) })
//! };
//! let file = stl_binary_parts(&[&cube(0.0), &cube(10.0)]);
//!
//! let model = read_model(&file, "two-cubes.stl", &ReadOptions::default())?;
//! assert_eq!(model.parts.len(), 2);
//! assert!((model.parts[0].mesh.volume() - 1000.0).abs() < 1e-6);
//! assert_eq!(model.on_table, [0]);
//! // They share one face, whose normal points up.
//! assert_eq!(model.interfaces.len(), 1);
//! assert!((model.interfaces[0].area_mm2 - 100.0).abs() < 1e-6 && model.interfaces[0].normal.z > 0.999);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod apart;
mod box_tree;
mod cap;
mod captive;
mod containing;
mod edges;
mod error;
mod fans;
mod interface;
mod model;
mod neighbours;
mod overlap;
mod parts;
mod pieces;
mod read;
mod shells;
mod soup;
#[cfg(test)]
mod tests;
mod triangle_mesh;
mod unit;
mod warnings;
mod weld;
mod winding;
mod write;

pub use apart::may_overlap;
pub use box_tree::BoxTree;
pub(crate) use cap::{CapPatch, NoCap, THIN_MM, patches, sides_of};
pub use containing::{Containing, containing};
pub(crate) use edges::EdgeMap;
pub use error::{Fault, FilePlace, MAX_COORDINATE, MeshError, Places};
pub use fans::{Fanned, fanned};
pub use interface::{Facing, INTERFACE_ANGLE_DEG, INTERFACE_AREA_MM2, INTERFACE_GAP_MM, Interface, facing_across};
pub use model::{Away, DrawnModel, Model, Part, TABLE_GAP_MM};
pub use neighbours::Neighbours;
pub use pieces::{ConvexPiece, pieces};
pub use read::{ProjectPlates, ReadOptions, Repair, facets_told, read_model, read_project, read_surface};
pub use soup::OtherVolume;
pub use triangle_mesh::TriangleMesh;
pub use unit::{INCHES_BELOW, METRES_BELOW, MICRONS_ABOVE, Unit, UnknownUnit, guess_unit};
pub(crate) use weld::first_of_equals;
pub use winding::{is_overlap, seen_to_overlap};
pub use write::{stl_binary, stl_binary_parts, threemf, threemf_project};
