//! How a head that turns gets from one pose to another without meeting anything.
//!
//! ```text
//! from a print   along the tool's axis beyond everything printed, then straight up
//! turn           at a height at which no angle of the turn brings any point of the head down to what stands
//! to a print     the same the other way
//! ```
//!
//! Along the tool's axis nothing is met that was not met while printing: the head is taken to reach that way without end. Beyond everything
//! printed, seen along that axis, a tool that leans no more than level keeps away from it on the way up; and the table lies below.
//!
//! Room and words, mm. The planner asks here whether there is such a way, and the rewriter goes it; the source is the chain alone
//! ([`SwivelHead`]).

use super::solid::Solid;
use crate::geom::{Bounds, Vec3};
use crate::motion::{LinearLimits, OutOfLimits, Pose, SwivelHead, TableKinematics};
use crate::profile::Profile;

/// A tool that leans more than this looks up, and straight up is no way out any more, degrees.
const MOST_LEAN_DEG: f64 = 90.0 + 1e-6;

/// The way of a head that turns, on one machine.
pub struct SwivelRoute<'a> {
    profile: &'a Profile,
    swivel: SwivelHead,
    limits: LinearLimits,
    clearance_mm: f64,
}

impl<'a> SwivelRoute<'a> {
    /// `None` for a head that does not turn.
    pub fn of(profile: &'a Profile) -> Option<Self> {
        let clearance_mm = profile.transition.clearance_mm;
        Some(Self { profile, swivel: profile.kinematics().head?, limits: profile.linear_limits(), clearance_mm })
    }

    /// The word of Z at which the head keeps [`Transition::clearance_mm`](crate::profile::Transition) above what reaches `top_mm` over the
    /// table while it goes from one pose to another; from an unknown one all angles count.
    pub fn height(&self, top_mm: f64, from: Option<Pose>, to: Pose) -> f64 {
        let deep = self.profile.head_depth_mm(from.map(|from| [from.tilt, to.tilt]));
        self.swivel.table.z + top_mm + self.clearance_mm + deep
    }

    /// The first of `places` (words of X and Y) at which the head may turn with its Z at `z`: all axes stay within their stops.
    ///
    /// # Errors
    ///
    /// What stands against the last of them.
    pub fn place(&self, places: &[[f64; 2]], z: f64, from: Option<Pose>, to: Pose) -> Result<[f64; 2], OutOfLimits> {
        let mut why = OutOfLimits { axis: 'Z', value: z, range: (self.limits.min.z, self.limits.max.z) };
        for &[x, y] in places {
            match self.leaves_limits(Vec3::new(x, y, z), from, to) {
                None => return Ok([x, y]),
                Some(out) => why = out,
            }
        }
        Err(why)
    }

    fn leaves_limits(&self, words: Vec3, from: Option<Pose>, to: Pose) -> Option<OutOfLimits> {
        // From an unknown angle only the end is known.
        let from = from.unwrap_or(to);
        let between = Pose { rotation: to.rotation, ..from };
        let legs = [(from, between), (between, to)];
        let boxes = legs.map(|(from, to)| self.swivel.axes_while_turning(words, from, to));
        boxes.iter().flat_map(|b| [b.min, b.max]).find_map(|corner| self.limits.violation(&corner))
    }

    /// What stops an axis while the tip goes from `tip` along the tool's axis to `top` (frame `Machine`) and up to the word `z` of Z.
    pub fn leaving_stops(&self, tip: Vec3, top: f64, pose: Pose, z: f64) -> Option<OutOfLimits> {
        let out = Vec3::new(tip.x, tip.y, top.max(tip.z));
        let words = self.swivel.words(out, pose);
        let raised = Vec3::new(words.x, words.y, z.max(words.z));
        let axes = self.swivel.axes(out, pose);
        [axes, axes + (raised - words)].iter().find_map(|axes| self.limits.violation(axes))
    }

    /// Whether the tool leans so little that straight up leads out.
    pub fn looks_down(pose: Pose) -> bool {
        pose.tilt.abs().deg() <= MOST_LEAN_DEG
    }

    /// The way out of a print along the tool, frame `Machine` at `to`: corners of all that the tip may pass.
    pub(super) fn way_out(&self, table: &TableKinematics, part: &Solid, standing: &[&Solid], to: Pose) -> Vec<Vec3> {
        let motion = table.forward(to);
        let top = part.reached(&motion).max.z;
        let beyond = standing.iter().map(|solid| solid.reached(&motion).max.z).fold(top, f64::max) + self.clearance_mm;
        let at = |p: &Vec3| motion.point((*p).into()).at;
        part.points().iter().map(at).flat_map(|p| [top, beyond].map(|z| Vec3::new(p.x, p.y, z))).collect()
    }

    /// What stops the last turn, back to level.
    pub(super) fn ends(&self, standing: &[&Solid], from: Pose, to: Pose) -> Option<String> {
        let top = standing.iter().flat_map(|solid| solid.points()).map(|p| p.z).fold(0.0, f64::max);
        let middle = [self.swivel.table.x, self.swivel.table.y];
        let stopped = self.place(&[middle], self.height(top, Some(from), to), Some(from), to);
        stopped.err().map(|out| format!("while the head turns back, {out}"))
    }

    /// What the head cannot do on the way to a print of `part` at `to` while the others stand, in words.
    pub(super) fn stopped(
        &self,
        table: &TableKinematics,
        part: &Solid,
        standing: &[&Solid],
        from: Option<Pose>,
        to: Pose,
    ) -> Option<String> {
        let top = |solids: &[&Solid]| {
            let points = solids.iter().flat_map(|solid| solid.points());
            points.map(|p| p.z).fold(0.0, f64::max)
        };
        if !Self::looks_down(to) {
            return Some(format!(
                "the tool would lean by {:.1} deg; beyond 90 deg it looks up, and there is no way out above it",
                to.tilt.abs().deg()
            ));
        }
        let z = self.height(top(standing), from, to);
        let motion = table.forward(to);
        let reached = part.reached(&motion);
        let middle = self.swivel.words(reached.centre(), to);
        let [centre, own] = [self.swivel.table, middle].map(|p| [p.x, p.y]);
        if let Err(out) = self.place(&[own, centre], z, from, to) {
            return Some(format!("while the head turns, {out}"));
        }
        let along = |solid: &Solid| solid.reached(&motion).max.z;
        let beyond = standing.iter().map(|solid| along(solid)).fold(reached.max.z, f64::max) + self.clearance_mm;
        let corners = Bounds { min: Vec3::new(reached.min.x, reached.min.y, reached.max.z), ..reached }.corners();
        let z = z.max(self.height(top(&[standing, &[part]].concat()), Some(to), to));
        corners
            .iter()
            .find_map(|&corner| self.leaving_stops(corner, beyond, to, z))
            .map(|out| format!("on the way out along the tool, {out}"))
    }
}
