//! The table's two angles.

use crate::geom::Angle;

/// The table's two angles, right-handed, as the chain counts them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose {
    /// Tilt about machine +X or +Y.
    pub tilt: Angle,
    /// Rotation about the table's own +Z; may count more than one turn.
    pub rotation: Angle,
}

impl Pose {
    /// The table level, rotation at its zero.
    pub const LEVEL: Self = Self { tilt: Angle::ZERO, rotation: Angle::ZERO };

    /// A pose of `tilt` and `rotation` degrees.
    pub fn from_deg(tilt: f64, rotation: f64) -> Self {
        Self { tilt: Angle::from_deg(tilt), rotation: Angle::from_deg(rotation) }
    }
}
