//! One question about a print and something that stands: does the head keep clear of it? For what is no part of the model, as supports are.

use super::collision::Head;
use super::owed::Owed;
use super::solid::Solid;
use crate::geom::Table;
use crate::mesh::TriangleMesh;
use crate::motion::Pose;
use crate::profile::Profile;

/// Whether the head, which prints `part` at `pose`, gives `standing` all that it owes to what it does not print on, `margin_mm` at least.
///
/// # Errors
///
/// The piece of the head that comes too near.
pub fn clears(
    profile: &Profile,
    part: &TriangleMesh<Table>,
    standing: &TriangleMesh<Table>,
    pose: Pose,
    margin_mm: f64,
) -> Result<(), String> {
    let motion = profile.kinematics().forward(pose);
    let owed = Owed::to_others(profile, margin_mm);
    let offence = Head::of(profile).offence(&motion, &Solid::of(part), &Solid::of(standing), &owed, 0.0);
    offence.map_or(Ok(()), |clearance| Err(clearance.piece))
}
