//! One question about prints and something that stands: does the head keep clear of it? For what is no part of the model, as supports are.

use super::collision::Head;
use super::owed::Owed;
use super::solid::Solid;
use crate::geom::Table;
use crate::mesh::TriangleMesh;
use crate::motion::{Pose, TableKinematics};
use crate::profile::Profile;

/// Something that stands on the table, and the head that is to keep clear of it.
pub struct Obstacle {
    solid: Solid,
    head: Head,
    owed: Owed,
    table: TableKinematics,
}

impl Obstacle {
    /// What is owed to it is owed to all that the head does not print on, `margin_mm` at least.
    pub fn new(profile: &Profile, standing: &TriangleMesh<Table>, margin_mm: f64) -> Self {
        let (solid, head) = (Solid::of(standing), Head::of(profile));
        Self { solid, head, owed: Owed::to_others(profile, margin_mm), table: profile.kinematics() }
    }

    /// The piece of the head that comes too near while it prints `part` at `pose`.
    pub fn met_by(&self, part: &TriangleMesh<Table>, pose: Pose) -> Option<String> {
        let motion = self.table.forward(pose);
        self.head.offence(&motion, &Solid::of(part), &self.solid, &self.owed, 0.0).map(|clearance| clearance.piece)
    }
}
