//! Frames, angles and boxes: the vocabulary every other room speaks.
//!
//! Lengths are millimetres in `f64`. Angles inside the library are radians ([`Angle`]); degrees exist only at the
//! edges (profiles, plan files, G-code words, the command line). A point or direction carries its frame in its type:
//!
//! ```text
//! Object   the model file's own axes
//! Table    origin = centre of the table's surface, on the rotation axis; turns with the table
//! Slot     what a slicer sees: +Z is the build direction, z = 0 the lowest point of the part
//! Machine  fixed; +Z up; the coordinates of the tool tip
//! ```

mod angle;
mod body;
mod bounds;
pub mod convex;
mod frame;
mod growing_hull;
mod hull;
pub mod nearest;
mod outline;
mod random;
mod sets;

pub use angle::Angle;
pub use body::Body;
pub use bounds::Bounds;
pub use frame::{Dir, Machine, Object, Point, Rigid, Slot, Table, turned_by};
pub use growing_hull::GrowingHull;
pub use hull::Hull;
pub use outline::convex_outline;
pub use random::SplitMix64;
pub use sets::Sets;

/// A plain vector of three millimetre values, where the frame is clear from the context.
pub type Vec3 = nalgebra::Vector3<f64>;
/// A 3x3 matrix.
pub type Mat3 = nalgebra::Matrix3<f64>;
