//! The orientations a part may be printed in: directions, merged by machine setup, filtered by what the machine can do.

use super::collision::{Head, contact_mm};
use super::part_set::PartSet;
use super::solid::Solid;
use super::support::{Needs, Neighbours, needs};
use super::workpiece::Workpiece;
use crate::geom::{Angle, Bounds, Dir, Machine, Rigid, Table, Vec3};
use crate::motion::{Pose, TableKinematics};
use crate::orient::{Direction, Facets, Multistart, Objective, directions};
use crate::profile::Profile;

/// One way to print one part.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// The build direction.
    pub up: Dir<Table>,
    /// The pose that brings it upright, rotation in (-180, 180] degrees.
    pub pose: Pose,
    /// Which setup that is, the same number for the same pose.
    pub setup: usize,
    /// The objective there.
    pub value: f64,
    pub(super) needs: Needs,
}

/// Why a direction is not a candidate.
#[derive(Clone, Debug, PartialEq)]
pub struct Rejected {
    /// The build direction.
    pub up: Vec3,
    /// What stands against it.
    pub reason: String,
    /// Who: a part's number, `"table"`, `"limits"`, `"support"`.
    pub blocked_by: String,
    /// How deep the head would reach in, mm; 0 where it is no collision.
    pub depth_mm: f64,
}

/// Directions that differ by less than this (radians, 0.02 degrees) are one setup: 0.04 mm over 100 mm, a tenth of a line.
const SAME_SETUP: f64 = 3.5e-4;
/// How many candidates of a part are kept, the best by objective; the search's width.
const MOST: usize = 1000;

/// What all parts' candidates share.
pub(super) struct Setups<'a> {
    pub(super) workpiece: &'a Workpiece<'a>,
    pub(super) profile: &'a Profile,
    pub(super) table: TableKinematics,
    pub(super) head: Head,
    pub(super) threshold: Angle,
    /// By part, on the table.
    pub(super) solids: Vec<Solid>,
    /// The poses, by setup number.
    pub(super) poses: Vec<(Dir<Table>, Pose)>,
}

/// A part's candidates and what was turned down.
pub(super) struct Choice {
    pub(super) candidates: Vec<Candidate>,
    pub(super) rejected: Vec<Rejected>,
    pub(super) tried: usize,
}

/// The directions to try for every part, in parallel.
pub(super) fn all_directions(workpiece: &Workpiece<'_>, f: &dyn Objective, search: &Multistart) -> Vec<Vec<Direction>> {
    use rayon::prelude::*;
    (0..workpiece.parts.len())
        .into_par_iter()
        .map(|part| {
            let mut also: Vec<Vec3> = vec![Vec3::z()];
            for interface in &workpiece.model.interfaces {
                if interface.a == part || interface.b == part {
                    also.push(workpiece.placed.rotation * interface.normal);
                }
            }
            directions(&Facets::of(&workpiece.parts[part]), &also, f, search)
        })
        .collect()
}

impl Setups<'_> {
    /// The candidates of `part` among `tried`.
    pub(super) fn choose(&mut self, part: usize, tried: &[Direction]) -> Choice {
        let neighbours = Neighbours::of(self.workpiece, part);
        let count = self.workpiece.parts.len();
        let mut everyone = PartSet::new(count);
        (0..count).filter(|&q| q != part).for_each(|q| everyone.insert(q));
        let mut choice = Choice { candidates: Vec::new(), rejected: Vec::new(), tried: tried.len() };
        for direction in tried {
            let Some(up) = Dir::new(direction.up) else { continue };
            let up = self.merged(up);
            if choice.candidates.iter().any(|c| (c.up.unit() - up.unit()).norm() < SAME_SETUP) {
                continue;
            }
            let needs = needs(&self.workpiece.parts[part], &neighbours, up, self.threshold, count);
            if !needs.met_by(&everyone) {
                let missing = needs.missing(&everyone);
                let reason = if missing > 0.0 {
                    format!("{missing:.1} mm2 would overhang beyond {:.0} deg without support", self.threshold.deg())
                } else {
                    "it would begin in the air".to_owned()
                };
                choice.rejected.push(rejected(up, reason, "support", 0.0));
                continue;
            }
            self.try_poses(part, up, direction.value, &needs, &mut choice);
            if choice.candidates.len() >= MOST {
                break;
            }
        }
        choice
    }

    fn try_poses(&mut self, part: usize, up: Dir<Table>, value: f64, needs: &Needs, choice: &mut Choice) {
        if let Err(unreachable) = self.table.upright(up, Pose::LEVEL) {
            choice.rejected.push(rejected(up, unreachable.to_string(), "limits", 0.0));
            return;
        }
        let mut poses = self.table.solutions(up, Pose::LEVEL);
        poses.retain(|p| self.table.tilt.admits(p.tilt));
        for pose in poses {
            match self.machine_objects(part, pose) {
                Some(no) => choice.rejected.push(Rejected { up: *up.unit(), ..no }),
                None => {
                    let setup = self.setup(up, pose);
                    choice.candidates.push(Candidate { up, pose, setup, value, needs: needs.clone() });
                }
            }
        }
    }

    /// What the machine has against printing `part` at `pose`: stops or the table.
    fn machine_objects(&self, part: usize, pose: Pose) -> Option<Rejected> {
        let motion = self.table.forward(pose);
        let solid = &self.solids[part];
        let limits = self.profile.linear_limits();
        let reached = Bounds::of(solid.points().iter().map(|p| motion.rotation * p + motion.translation));
        for corner in [reached.min, reached.max] {
            if let Some(out) = limits.violation(&corner) {
                return Some(rejected(Dir::z(), out.to_string(), "limits", 0.0));
            }
        }
        let slab = Solid::hull(self.profile.table_slab());
        let lift = contact_mm(self.profile);
        let clearance = self.head.clearance(&motion, solid, &slab, lift, 1e-3);
        (clearance.mm == 0.0).then(|| {
            let depth = self.head.depth(&motion, solid, &slab, lift);
            let reason = format!("the {} would reach {depth:.1} mm into the table", clearance.piece);
            rejected(Dir::z(), reason, "table", depth)
        })
    }

    /// `up`, or the direction of a known setup that is the same.
    fn merged(&self, up: Dir<Table>) -> Dir<Table> {
        let known = self.poses.iter().map(|(known, _)| *known);
        known.into_iter().find(|known| (known.unit() - up.unit()).norm() < SAME_SETUP).unwrap_or(up)
    }

    fn setup(&mut self, up: Dir<Table>, pose: Pose) -> usize {
        let same = |(known, at): &(Dir<Table>, Pose)| known == &up && at == &pose;
        self.poses.iter().position(same).unwrap_or_else(|| {
            self.poses.push((up, pose));
            self.poses.len() - 1
        })
    }
}

fn rejected(up: Dir<Table>, reason: String, blocked_by: &str, depth_mm: f64) -> Rejected {
    Rejected { up: *up.unit(), reason, blocked_by: blocked_by.to_owned(), depth_mm }
}

/// The table's slab at a pose, machine coordinates.
pub fn table_solid(profile: &Profile, motion: &Rigid<Table, Machine>) -> Solid {
    Solid::hull(profile.table_slab().iter().map(|p| motion.rotation * p + motion.translation).collect())
}
