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
//!
//! Two motions one after the other, each from one frame to another:
//!
//! ```
//! use trunnion::geom::{Angle, Dir, Machine, Object, Point, Rigid, Table, Vec3, turned_by};
//!
//! // The model stands 5 mm beside the table's centre; the table is tilted until what was +Y points up. Lengths in mm.
//! let placed: Rigid<Object, Table> = Rigid::shift(Vec3::new(5.0, 0.0, 0.0));
//! let tilted: Rigid<Table, Machine> = Rigid::new(*turned_by(&Vec3::y()).to_rotation_matrix().matrix(), Vec3::zeros());
//!
//! // Frames are types: the other order does not compile.
//! let whole: Rigid<Object, Machine> = placed.then(&tilted);
//! let up = whole.dir(Dir::new(Vec3::y()).ok_or("a direction has a length")?);
//! assert!((up.unit() - Vec3::z()).norm() < 1e-12);
//! let back: Point<Object> = whole.inverse().point(whole.point(Point::new(1.0, 2.0, 3.0)));
//! assert!((back.at - Vec3::new(1.0, 2.0, 3.0)).norm() < 1e-12);
//! assert_eq!(Angle::from_deg(90.0).rad(), std::f64::consts::FRAC_PI_2);
//! # Ok::<(), Box<dyn std::error::Error>>(())
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
