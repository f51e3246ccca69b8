//! `prepare --dry-run`: a file with which a print is rehearsed on the machine itself, cold.
//!
//! Poses and places come from the verified program's own moves, so what is rehearsed is what will be printed: each pose at which something
//! is laid, in order, and the tip's outermost places there.

use super::error::MachineError;
use crate::calibrate::{self, ColdPose, outermost};
use crate::geom::Vec3;
use crate::input::{CheckedPlan, InputError};
use crate::motion::Pose;
use crate::planning::Print;
use crate::trace;

/// A rehearsal.
#[derive(Clone, Debug)]
pub struct DryRun {
    /// The file.
    pub gcode: String,
    /// Poses in order.
    pub poses: Vec<ColdPose>,
    /// Start lines of the profile that are not in it, since they heat or nobody knows what they do.
    pub left_out: Vec<String>,
}

/// Rehearses `program`, which was made for `plan`.
///
/// # Errors
///
/// [`MachineError::NoDryRun`] where a way on the bare table is not proved clear.
pub fn dry_run(program: &[u8], plan: &CheckedPlan) -> Result<DryRun, MachineError> {
    let profile = &plan.machine.profile;
    if !profile.kinematics().is_table() {
        return Err(InputError::Chain { profile: plan.machine.name.clone() }.into());
    }
    let poses = poses(program, plan);
    let made = calibrate::dry_run(profile, &poses).map_err(|no| MachineError::NoDryRun { why: no.to_string() })?;
    Ok(DryRun { gcode: made.gcode, left_out: made.left_out, poses })
}

/// What is laid at one pose.
struct Laid {
    pose: Pose,
    words_deg: [f64; 2],
    slots: Vec<usize>,
    parts: Vec<usize>,
    places: Vec<Vec3>,
}

fn poses(program: &[u8], plan: &CheckedPlan) -> Vec<ColdPose> {
    let profile = &plan.machine.profile;
    let trace = trace::read(program, &profile.trace_setting());
    let supports = plan.plan.supports().map(|(_, slot, print)| (slot, print));
    let prints: Vec<(usize, &Print)> = plan.plan.prints().chain(supports).collect();
    let mut all: Vec<Laid> = Vec::new();
    for m in trace.moves().filter(trace::TraceMove::prints) {
        let state = trace.state(&m);
        let print = state.print.and_then(|number| prints.get(number as usize));
        let (Some(&(slot, print)), Some(pose), Some(ends)) = (print, state.pose(), m.ends()) else { continue };
        if all.last().is_none_or(|laid| laid.pose != pose) {
            let words_deg = [print.tilt_deg, print.rotation_deg];
            all.push(Laid { pose, words_deg, slots: Vec::new(), parts: Vec::new(), places: Vec::new() });
        }
        let Some(laid) = all.last_mut() else { continue };
        for (all, one) in [(&mut laid.slots, slot), (&mut laid.parts, print.part)] {
            if !all.contains(&one) {
                all.push(one);
            }
        }
        laid.places.extend(ends);
        if laid.places.len() > MOST {
            laid.places = outermost(laid.places.drain(..));
        }
    }
    all.into_iter().map(|laid| laid.cold(plan)).collect()
}

/// Places that are kept until they are looked through.
const MOST: usize = 4096;

impl Laid {
    fn cold(self, plan: &CheckedPlan) -> ColdPose {
        let kinematics = &plan.machine.profile.kinematics;
        let [tilt, rotation] = self.words_deg.map(|deg| (deg * 100.0).round() / 100.0 + 0.0);
        let name = |part: &usize| format!("{part} ({})", plan.model.model.parts[*part].name);
        let list = |word: &str, all: Vec<String>| {
            format!("{word}{} {}", if all.len() == 1 { "" } else { "s" }, all.join(", "))
        };
        let name = format!(
            "{}, {}{tilt} {}{rotation}, {}",
            list("slot", self.slots.iter().map(ToString::to_string).collect()),
            kinematics.tilt.letter,
            kinematics.rotation.letter,
            list("part", self.parts.iter().map(name).collect()),
        );
        ColdPose { words_deg: self.words_deg, name, places: outermost(self.places.into_iter()) }
    }
}
