//! The machine as it is drawn: its table, head and frame as hulls, and the constants by which its table turns.

use super::hull::drawn;
use crate::geom::{Body, Hull, Vec3};
use crate::motion::{LinearLimits, TableKinematics};

/// A convex piece of head or frame.
#[derive(Clone, Debug, PartialEq)]
pub struct DrawnBody {
    /// Its name in the profile.
    pub name: String,
    /// Whether it follows the tip along X, Y and Z.
    pub follows: [bool; 3],
    /// Whether it keeps its attitude while the head turns.
    pub stays: bool,
    /// Its shape, mm: relative to the tip on the axes that it follows, machine coordinates on the others.
    pub hull: Hull,
}

/// What is drawn of a machine.
#[derive(Clone, Debug, PartialEq)]
pub struct DrawnMachine {
    /// `p_machine = pivot + R_tilt(A) (offset + R_rotation(C) p_table)`.
    pub kinematics: TableKinematics,
    /// Where the tip may go.
    pub limits: LinearLimits,
    /// The table's slab, table frame.
    pub table: Hull,
    /// The head's pieces.
    pub head: Vec<DrawnBody>,
    /// The frame's, machine coordinates.
    pub frame: Vec<DrawnBody>,
}

impl DrawnMachine {
    /// Of the corners of the table's slab (table frame) and the bodies of head and frame.
    pub fn of(kinematics: TableKinematics, limits: LinearLimits, slab: &[Vec3], head: &[Body], frame: &[Body]) -> Self {
        let pieces = |bodies: &[Body]| bodies.iter().map(piece).collect();
        Self { kinematics, limits, table: drawn(slab), head: pieces(head), frame: pieces(frame) }
    }
}

fn piece(body: &Body) -> DrawnBody {
    DrawnBody { name: body.name.clone(), follows: body.follows, stays: body.stays, hull: drawn(&body.points) }
}
