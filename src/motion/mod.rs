//! The one motion model: kinematics, axis limits, and the replay of G-code into moves.
//!
//! `motion` is the only place that interprets G90/G91, M82/M83, G92, F, units and poses: for sliced input, for our own
//! output, for verification and for timing. Its correctness is held by witnesses that do not share its code: the
//! published expanded formulas and hand-worked poses in `tests/it/kinematics.rs`, LinuxCNC's interpreter where it is
//! installed.
//!
//! The pose that brings a build direction upright:
//!
//! ```
//! use trunnion::geom::{Dir, Vec3};
//! use trunnion::motion::Pose;
//! use trunnion::profile::resolve;
//!
//! // A table that tilts about X (A, -15 to 90 degrees) and turns about its own Z (C), as the profile says.
//! let (profile, _) = resolve("mine.toml", "extends = \"generic-ac\"")?;
//! let table = profile.kinematics();
//!
//! // A build direction that leans 30 degrees to the table's own -Y. Tilting by -30 is beyond the stop, so the table turns half round.
//! let lean = 30_f64.to_radians();
//! let up = Dir::new(Vec3::new(0.0, -lean.sin(), lean.cos())).ok_or("a direction has a length")?;
//! let pose = table.upright(up, Pose::LEVEL)?;
//! assert!((pose.tilt.deg() - 30.0).abs() < 1e-9 && (pose.rotation.deg().abs() - 180.0).abs() < 1e-9);
//! // At that pose it is the machine's +Z.
//! assert!((table.forward(pose).dir(up).unit() - Vec3::z()).norm() < 1e-12);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! This room must not know profiles (they build its types), plans or slicers.

mod about;
mod kinematics;
mod limits;
pub(crate) mod lookahead;
mod misaligned;
mod pose;
pub mod replay;
mod swivel;

pub use about::TiltAbout;
pub(crate) use about::rotation_z;
pub use kinematics::{AxisRange, RANGE_SLACK_DEG, TableKinematics, Unreachable};
pub use limits::{LinearLimits, OutOfLimits};
pub use lookahead::{Accelerations, Axes};
pub(crate) use misaligned::turn;
pub use misaligned::{AxisDirections, MOST_LEAN_DEG};
pub use pose::Pose;
pub use swivel::{SwivelHead, SwivelWords};
