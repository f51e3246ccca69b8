//! Shapes beside models: supports as a mesh, and drawings.

mod convex;
mod picture_file;
mod support;

pub use convex::{ConvexRequest, ConvexResult, HullOfPiece, convex};
pub use picture_file::PictureFile;
pub use support::{SupportOptions, SupportRequest, SupportResult, ThreeNumbers, is_3mf, support};
