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

mod apart;
mod box_tree;
mod containing;
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
mod weld;
mod winding;
mod write;

pub use apart::may_overlap;
pub use box_tree::BoxTree;
pub use containing::{Containing, containing};
pub use error::{Fault, FilePlace, MAX_COORDINATE, MeshError};
pub use fans::{Fanned, fanned};
pub use interface::{Facing, INTERFACE_ANGLE_DEG, INTERFACE_AREA_MM2, INTERFACE_GAP_MM, Interface, facing_across};
pub use model::{Away, Model, Part, TABLE_GAP_MM};
pub use neighbours::Neighbours;
pub use pieces::{ConvexPiece, pieces};
pub use read::{ReadOptions, read_model, read_project, read_surface};
pub use triangle_mesh::TriangleMesh;
pub use unit::{INCHES_BELOW, METRES_BELOW, MICRONS_ABOVE, Unit, UnknownUnit, guess_unit};
pub(crate) use weld::first_of_equals;
pub use winding::{is_overlap, seen_to_overlap};
pub use write::{stl_binary, stl_binary_parts, threemf, threemf_project};
