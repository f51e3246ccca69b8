//! Prints at another pose than the plan's. Each is one finding (rule `pose`); what follows from it is not asked: all that such lines
//! come near to, and all that is missing where they should be, is the same mistake once more.
//!
//! So that what is printed later is judged by itself, astray lines count as laid where the plan has them.

use super::Planned;
use crate::geom::{Machine, Rigid, Table, Vec3};
use crate::motion::{Pose, TableKinematics};
use crate::trace::Trace;

/// How well a pose must be the plan's, degrees: ten times the last digit written.
pub(super) const POSE_DEG: f64 = 1e-3;
/// How well the pose must bring the build direction upright (chord): the last digit of the plan's `up` and angles.
pub(super) const UPRIGHT: f64 = 2e-5;

/// How far a print's pose is from the plan's, degrees.
pub(super) struct PoseError {
    /// Of the axis that is farther off.
    pub(super) axis_deg: f64,
    /// From upright.
    pub(super) lean_deg: f64,
}

/// What is wrong with `pose` for a print; `None` where nothing is.
pub(super) fn pose_error(table: &TableKinematics, plan: &Planned, pose: Pose) -> Option<PoseError> {
    let tilt = (pose.tilt - plan.pose.tilt).abs().deg();
    let rotation = (pose.rotation - plan.pose.rotation).wrapped().abs().deg();
    let tip = (table.forward(pose).rotation * plan.up - Vec3::z()).norm();
    let axis_deg = tilt.max(rotation);
    let lean_deg = (2.0 * (tip / 2.0).min(1.0).asin()).to_degrees();
    (axis_deg > POSE_DEG || tip > UPRIGHT).then_some(PoseError { axis_deg, lean_deg })
}

/// Whether a print is made at another pose than the plan's between move `from` and the next that changes the pose.
///
/// Rule `pose` has a finding then, for the same moves.
pub(super) fn is_astray(trace: &Trace, table: &TableKinematics, planned: &[Planned], from: usize, pose: Pose) -> bool {
    let here = (from..trace.len()).map(|index| trace.at(index));
    let here = here.take_while(|m| m.index == from || !trace.has_new_pose(m));
    let mut right = None;
    here.filter(|m| m.prints()).any(|m| {
        let print = trace.state(&m).print;
        let Some(plan) = print.filter(|_| print != right).and_then(|print| planned.get(print as usize)) else {
            return false;
        };
        right = print;
        pose_error(table, plan, pose).is_some()
    })
}

/// By print, from the machine's frame to the table's at the plan's pose.
pub(super) fn as_planned(table: &TableKinematics, planned: &[Planned]) -> Vec<Rigid<Machine, Table>> {
    planned.iter().map(|print| table.forward(print.pose).inverse()).collect()
}
