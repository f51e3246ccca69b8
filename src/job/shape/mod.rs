//! Shapes beside models: supports as a mesh, and drawings.

mod picture_file;
mod support;

pub use picture_file::PictureFile;
pub use support::{SupportOptions, SupportRequest, SupportResult, ThreeNumbers, is_3mf, support};
