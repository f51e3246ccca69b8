//! What a program asks of the table: its turns and how long the nozzle waits hot meanwhile, how far cables are wound, and what weighs on the
//! tilt axis.

use std::f64::consts::PI;

use super::Planned;
use super::acts::{Acts, Go, Kind, Stroke};
use super::evidence::{Checked, Evidence, Figures};
use super::report::{FindingPlace, Findings, Rule, TableUse, WALL_STARTS, WallStart};
use crate::gcode::marks::Role;
use crate::geom::{Machine, Rigid, Table as Frame, Vec3};
use crate::motion::{Pose, TableKinematics, TiltAbout};
use crate::planning::balance::{NEWTON, Weight};
use crate::trace::TraceMove;

/// Degrees of one turn.
const TURN_DEG: f64 = 360.0;

struct Table<'a> {
    kinematics: TableKinematics,
    /// The tilt axis, a unit vector of machine coordinates.
    axis: Vec3,
    filament_mm2: f64,
    weight: Weight,
    pose: Option<Pose>,
    /// From the machine's frame at that pose.
    back: Option<Rigid<Machine, Frame>>,
    at: FindingPlace,
    /// Since the last printed line: seconds, and whether the table turned.
    waited: Option<(f64, bool)>,
    acts: &'a Acts<'a>,
    planned: &'a [Planned],
    used: TableUse,
    wall_starts: Vec<WallStart>,
}

/// Goes through the program; a print that pulls harder than `[kinematics.tilt] holding_nm` is a finding.
pub(super) fn check(&Evidence { acts, job, planned, .. }: &Evidence<'_>) -> Checked {
    let mut findings = Findings::default();
    let kinematics = job.profile.kinematics();
    let square = if kinematics.about == TiltAbout::X { Vec3::x() } else { Vec3::y() };
    let axis = kinematics.misaligned.as_ref().map_or(square, |axes| axes.tilt);
    let filament_mm2 = PI / 4.0 * job.profile.process.filament_mm.powi(2);
    let mut table = Table {
        kinematics,
        axis,
        filament_mm2,
        weight: Weight::default(),
        pose: None,
        back: None,
        at: FindingPlace::default(),
        waited: None,
        acts,
        planned,
        used: TableUse::default(),
        wall_starts: Vec::new(),
    };
    acts.trace.moves().for_each(|m| table.take(&m));
    table.weigh(None);
    let Table { used, wall_starts, .. } = table;
    if let Some(holds) = job.profile.kinematics.tilt.holding_nm.filter(|holds| used.torque_nm > *holds) {
        let at = FindingPlace { line: used.torque_line, ..FindingPlace::default() };
        findings.add(Rule::Standing, at, [used.torque_nm, holds], || {
            format!(
                "the print pulls on the tilt axis with {:.3} N m (maximum {holds} N m, kinematics.tilt.holding_nm); place it nearer to the axis",
                used.torque_nm
            )
        });
    }
    Checked { findings, figures: Figures::Table { used, wall_starts } }
}

impl Table<'_> {
    fn take(&mut self, m: &TraceMove) {
        let trace = self.acts.trace;
        let turns = trace.turns(m);
        if turns || trace.has_new_pose(m) {
            self.at.line = m.line;
            self.weigh(trace.state(m).pose());
        }
        if turns && let Some(rotation) = trace.state(m).rotation {
            let wound = rotation.deg().abs() / TURN_DEG;
            if wound > self.used.wound_turns {
                (self.used.wound_turns, self.used.wound_line) = (wound, m.line);
            }
        }
        match self.acts.go(m) {
            Some(Go::Stroke(stroke)) if stroke.kind == Kind::Print => {
                self.at.line = m.line;
                self.go_on(m, &stroke);
                let Some(back) = self.back else { return };
                let middle = (stroke.from + stroke.to) / 2.0 - Vec3::z() * f64::from(stroke.height) / 2.0;
                self.weight.add(m.e * self.filament_mm2, &back.point(middle.into()).at);
            }
            _ => {
                if let Some((seconds, turned)) = &mut self.waited {
                    *seconds += m.seconds;
                    *turned |= turns;
                }
            }
        }
    }

    /// Printing goes on with a line.
    fn go_on(&mut self, m: &TraceMove, stroke: &Stroke) {
        if let Some((seconds, true)) = self.waited.replace((0.0, false)) {
            let used = &mut self.used;
            used.turns += 1;
            used.waiting_s += seconds;
            if seconds > used.longest_s {
                (used.longest_s, used.longest_line) = (seconds, m.line);
            }
            if m.role == Role::OuterWall {
                used.starts_on_walls += 1;
                self.start_on_wall(stroke);
            }
        }
    }

    /// Lists a start on an outer wall, where its place on the table and its print are known.
    fn start_on_wall(&mut self, stroke: &Stroke) {
        let (Some(back), Some(print)) = (self.back, stroke.print.and_then(|print| self.planned.get(print as usize)))
        else {
            return;
        };
        if self.wall_starts.len() < WALL_STARTS {
            let at = back.point(stroke.from.into()).at;
            let at_mm = <[f64; 3]>::from(at).map(|v| (v * 1e3).round() / 1e3 + 0.0);
            self.wall_starts.push(WallStart { line: stroke.line, part: print.part, at_mm });
        }
    }

    /// The table leaves its pose, with what is on it, for another.
    fn weigh(&mut self, next: Option<Pose>) {
        let from = self.pose.map(|pose| self.lever(pose));
        let to = next.map(|pose| self.lever(pose));
        self.pose = next;
        self.back = next.map(|pose| self.kinematics.forward(pose).inverse());
        let mut lever: f64 = from.iter().chain(&to).map(|lever| lever[0].abs()).fold(0.0, f64::max);
        // On its way it passes where it pulls most.
        if let (Some(from), Some(to)) = (from, to)
            && (from[1] > 0.0) != (to[1] > 0.0)
        {
            lever = lever.max(from[0].hypot(from[1])).max(to[0].hypot(to[1]));
        }
        let torque_nm = self.weight.grams() * NEWTON * lever / 1000.0;
        if torque_nm > self.used.torque_nm {
            (self.used.torque_nm, self.used.torque_line) = (torque_nm, self.at.line);
        }
    }

    /// Of the centre of what weighs, from the tilt axis: level and upward, mm.
    fn lever(&self, pose: Pose) -> [f64; 2] {
        let from = self.kinematics.forward(pose).point(self.weight.centre().into()).at - self.kinematics.pivot;
        let across = self.axis.cross(&Vec3::z());
        [from.dot(&across), from.z]
    }
}
