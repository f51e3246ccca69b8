//! The one motion model: kinematics, axis limits, and the replay of G-code into moves.
//!
//! `motion` is the only place that interprets G90/G91, M82/M83, G92, F, units and poses: for sliced input, for our own
//! output, for verification and for timing. Its correctness is held by witnesses that do not share its code: the
//! published expanded formulas and hand-worked poses in `tests/it/kinematics.rs`, LinuxCNC's interpreter where it is
//! installed.
//!
//! This room must not know profiles (they build its types), plans or slicers.

mod kinematics;
mod limits;
pub(crate) mod lookahead;
mod misaligned;
mod pose;
pub mod replay;

pub(crate) use kinematics::rotation_z;
pub use kinematics::{AxisRange, RANGE_SLACK_DEG, TableKinematics, TiltAbout, Unreachable};
pub use limits::{LinearLimits, OutOfLimits};
pub use lookahead::{Accelerations, Axes};
pub(crate) use misaligned::turn;
pub use misaligned::{AxisDirections, MOST_LEAN_DEG};
pub use pose::Pose;
