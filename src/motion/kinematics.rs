//! The kinematic chain of a table that tilts and turns.
//!
//! ```text
//! p_machine = pivot + R_tilt(A) * ( offset + Rz(C) * p_table )
//!
//! pivot    a point on the tilt axis, machine coordinates, mm
//! offset   from that point to the table's centre at tilt 0, mm
//! R_tilt   Rx for an A table, Ry for a B table
//! ```
//!
//! Where the axes were measured and are not square, `R_tilt` and `Rz` turn about the axes as they are: see [`AxisDirections`]. Where the head
//! turns and not the table, or one axis turns each, the same chain says how the table lies below the upright tool: see [`SwivelHead`].
//!
//! Positive angles turn **the table**, right-handed about machine +X / +Y and about its own +Z. A firmware that counts
//! the other way, or from another zero, is an [`AxisRange`] with `direction = -1` or a `zero`, applied once at the edge.
//! Only this chain is written down here; expanded formulas live in the tests, as witnesses.

use std::fmt;

use super::about::{TiltAbout, about_matrix, rotation_z};
use super::misaligned::AxisDirections;
use super::pose::Pose;
use super::swivel::SwivelHead;
use crate::gcode::round_to;
use crate::geom::{Angle, Dir, Machine, Mat3, Rigid, Table, Vec3};

/// One rotary axis: its word in G-code, its sense and zero, its stops and its speed.
#[derive(Clone, Debug, PartialEq)]
pub struct AxisRange {
    /// The word's letter, `b'A'`, `b'B'` or `b'C'`.
    pub letter: u8,
    /// +1 where the firmware counts right-handed turns of the table, -1 where it counts the other way.
    pub direction: f64,
    /// What the firmware's word says where the chain's angle is zero.
    pub zero: Angle,
    /// The lowest and highest *word* the machine accepts; `None` for an endless axis.
    pub range: Option<(Angle, Angle)>,
    /// The fastest turn, rad/s.
    pub max_rate: f64,
    /// Whether the machine has no such axis: its angle is zero, and no word says so. `range` is then zero alone.
    pub absent: bool,
}

impl AxisRange {
    /// The firmware's word for the chain's angle.
    pub fn word_of(&self, angle: Angle) -> Angle {
        angle * self.direction + self.zero
    }

    /// The chain's angle for the firmware's word.
    pub fn angle_of(&self, word: Angle) -> Angle {
        (word - self.zero) * self.direction
    }

    /// Whether the axis can stand at the chain's `angle`; [`RANGE_SLACK_DEG`] beyond the stop still counts.
    pub fn admits(&self, angle: Angle) -> bool {
        self.range.is_none_or(|(low, high)| {
            let word = self.word_of(angle).deg();
            word >= low.deg() - RANGE_SLACK_DEG && word <= high.deg() + RANGE_SLACK_DEG
        })
    }
}

/// Half of the last digit with which an angle is written (0.0001 deg): a pose at the very stop is not out of range.
pub const RANGE_SLACK_DEG: f64 = 5e-5;

/// Within this distance of upright (chord of the unit vector) the rotation is free: 0.00006 deg, below what a word can say.
const SINGULAR: f64 = 1e-6;

/// A build direction that the table cannot bring upright.
#[derive(Clone, Debug, PartialEq)]
pub struct Unreachable {
    /// The tilt it takes, degrees, as the firmware's word; the solution nearer to the range.
    pub tilt_word_deg: f64,
    /// The tilt axis's letter.
    pub tilt_letter: char,
    /// What that axis accepts, degrees.
    pub range_deg: (f64, f64),
    /// The rotation that has no turn inside its stops, where the tilt was not the trouble.
    pub rotation_word_deg: Option<f64>,
    /// How far from upright it stays, where axes that are not square bring it upright at no angle at all; 0 where they do.
    pub short_deg: f64,
}

impl fmt::Display for Unreachable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (low, high) = self.range_deg;
        let (low, high) = (round_to(low, 4), round_to(high, 4));
        if self.short_deg > 0.0 {
            return write!(
                f,
                "stays {:.2} deg from upright at every angle, since this table's axes are not square ([kinematics.tilt] and [kinematics.rotation] \
                 along)",
                self.short_deg
            );
        }
        match self.rotation_word_deg {
            Some(word) => write!(f, "needs rotation {word:.2} deg; this table turns {low}..{high}"),
            None => write!(f, "needs tilt {:.2} deg; this table tilts {low}..{high}", self.tilt_word_deg),
        }
    }
}

impl std::error::Error for Unreachable {}

/// A table that tilts about one machine axis and turns about its own normal.
#[derive(Clone, Debug, PartialEq)]
pub struct TableKinematics {
    /// The tilt axis's direction.
    pub about: TiltAbout,
    /// A point on the tilt axis, machine coordinates, mm.
    pub pivot: Vec3,
    /// From the pivot to the table's centre at tilt 0, mm.
    pub offset: Vec3,
    /// The tilt axis.
    pub tilt: AxisRange,
    /// The rotation axis.
    pub rotation: AxisRange,
    /// Where the axes point, where that was measured; `None`: `about`, and square to it.
    pub misaligned: Option<AxisDirections>,
    /// What turns the head, where not all axes turn the table; `pivot` and `offset` are then zero, and the frame `Machine` is the tool's.
    pub head: Option<SwivelHead>,
}

impl TableKinematics {
    /// The motion from the table's frame to the machine's at `pose`.
    pub fn forward(&self, pose: Pose) -> Rigid<Table, Machine> {
        let [tilt, turn] = match &self.misaligned {
            None => [self.tilt_matrix(pose.tilt), rotation_z(pose.rotation)],
            Some(axes) => axes.turns(pose),
        };
        Rigid::new(tilt * turn, self.pivot + tilt * self.offset)
    }

    /// What the axes turn, in messages.
    pub fn turner(&self) -> &'static str {
        match &self.head {
            None => "table",
            Some(head) if head.yaws || self.rotation.absent => "head",
            Some(_) => "head or table",
        }
    }

    /// Where the linear axes stand at `pose` while the tip is at a place of the table: what their stops bound. The frame `Machine` itself
    /// where the head does not turn.
    pub fn axes(&self, pose: Pose) -> Rigid<Table, Machine> {
        let forward = self.forward(pose);
        let Some(head) = &self.head else { return forward };
        Rigid::new(head.turn(pose) * forward.rotation, head.axes(forward.translation, pose))
    }

    /// Whether both axes turn the table.
    pub fn is_table(&self) -> bool {
        self.head.is_none() && !self.tilt.absent && !self.rotation.absent
    }

    /// The same for one tip of the frame `Machine`.
    pub fn axes_at(&self, tip: Vec3, pose: Pose) -> Vec3 {
        self.head.as_ref().map_or(tip, |head| head.axes(tip, pose))
    }

    /// The room's upward direction at `pose`, frame `Machine`: against gravity.
    pub fn upward(&self, pose: Pose) -> Vec3 {
        self.head.as_ref().map_or_else(Vec3::z, |head| head.upward(pose))
    }

    /// Where the tip is, frame `Machine`, for the words of X, Y and Z.
    pub fn tip(&self, words: Vec3, pose: Pose) -> Vec3 {
        self.head.as_ref().map_or(words, |head| head.tip(words, pose))
    }

    /// The words of X, Y and Z for a tip of the frame `Machine`.
    pub fn words(&self, tip: Vec3, pose: Pose) -> Vec3 {
        self.head.as_ref().map_or(tip, |head| head.words(tip, pose))
    }

    /// Where the axes point while both angles are zero: as measured, else as on a machine with square axes.
    pub fn directions(&self) -> AxisDirections {
        let tilt = if self.about == TiltAbout::X { Vec3::x() } else { Vec3::y() };
        self.misaligned.unwrap_or(AxisDirections { tilt, rotation: Vec3::z() })
    }

    /// The poses that bring `up` upright, the rotation in `(-180, 180]` degrees: two, or one where `up` is the table's normal.
    ///
    /// The rotation of an upright direction is free and comes back as that of `from`. Axes that are not square leave it free nowhere, and
    /// bring directions next to the rotation axis upright at no pose: see [`AxisDirections`].
    pub fn solutions(&self, up: Dir<Table>, from: Pose) -> Vec<Pose> {
        let d = up.unit();
        if let Some(axes) = &self.misaligned {
            return axes.poses(d, from);
        }
        let sideways = d.x.hypot(d.y);
        if sideways < SINGULAR {
            let tilt = if d.z > 0.0 { Angle::ZERO } else { Angle::from_deg(180.0) };
            return vec![Pose { tilt, rotation: from.rotation }];
        }
        let tilt = Angle::from_rad(sideways.atan2(d.z));
        // Rz(C) must turn d into the plane the tilt works in: onto +Y for an A table (Rx turns +Y to +Z), onto -X for B.
        let azimuth = d.y.atan2(d.x);
        let target = match self.about {
            TiltAbout::X => std::f64::consts::FRAC_PI_2,
            TiltAbout::Y => std::f64::consts::PI,
        };
        let rotation = Angle::from_rad(target - azimuth);
        let half_turn = Angle::from_deg(180.0);
        vec![
            Pose { tilt, rotation: rotation.wrapped() },
            Pose { tilt: -tilt, rotation: (rotation + half_turn).wrapped() },
        ]
    }

    /// The pose within the axes' ranges that brings `up` upright with the least turning from `from`, unwound.
    ///
    /// Ties go to the solution with the smaller rotation, then to the positive tilt.
    ///
    /// # Errors
    ///
    /// [`Unreachable`] where no solution lies within the ranges; never a clamped pose.
    pub fn upright(&self, up: Dir<Table>, from: Pose) -> Result<Pose, Unreachable> {
        let mut best: Option<(f64, Pose)> = None;
        let mut failure: Option<(f64, Unreachable)> = None;
        for pose in self.solutions(up, from) {
            match self.unwound(pose, from) {
                Ok(pose) => {
                    let turning = (pose.tilt - from.tilt).abs().deg() + (pose.rotation - from.rotation).abs().deg();
                    if best.is_none_or(|(least, _)| turning < least - 1e-9) {
                        best = Some((turning, pose));
                    }
                }
                Err(unreachable) => {
                    let miss = self.tilt_miss(pose);
                    if failure.as_ref().is_none_or(|(least, _)| miss < *least) {
                        failure = Some((miss, unreachable));
                    }
                }
            }
        }
        match (best, failure) {
            (Some((_, pose)), _) => Ok(pose),
            (None, Some((_, unreachable))) => Err(unreachable),
            (None, None) => Err(self.short_of_upright(up)),
        }
    }

    /// A direction that no pose brings upright.
    fn short_of_upright(&self, up: Dir<Table>) -> Unreachable {
        Unreachable {
            tilt_word_deg: 0.0,
            tilt_letter: char::from(self.tilt.letter),
            range_deg: (0.0, 0.0),
            rotation_word_deg: None,
            short_deg: self.directions().short_of_upright_deg(up.unit()),
        }
    }

    /// `pose` with its rotation on the turn nearest to `from` that the stops allow.
    fn unwound(&self, pose: Pose, from: Pose) -> Result<Pose, Unreachable> {
        let out = |axis: &AxisRange, rotation| {
            let (low, high) = axis.range.unwrap_or_default();
            Unreachable {
                tilt_word_deg: self.tilt.word_of(pose.tilt).deg(),
                tilt_letter: char::from(self.tilt.letter),
                range_deg: (low.deg(), high.deg()),
                rotation_word_deg: rotation,
                short_deg: 0.0,
            }
        };
        if !self.tilt.admits(pose.tilt) {
            return Err(out(&self.tilt, None));
        }
        let nearest = pose.rotation.nearest_to(from.rotation);
        let turn = Angle::from_deg(360.0);
        [0.0, -1.0, 1.0, -2.0, 2.0]
            .iter()
            .map(|&turns| nearest + turn * turns)
            .find(|&rotation| self.rotation.admits(rotation))
            .map(|rotation| Pose { tilt: pose.tilt, rotation })
            .ok_or_else(|| out(&self.rotation, Some(self.rotation.word_of(nearest).deg())))
    }

    fn tilt_miss(&self, pose: Pose) -> f64 {
        let word = self.tilt.word_of(pose.tilt);
        self.tilt.range.map_or(0.0, |(low, high)| (low - word).deg().max((word - high).deg()).max(0.0))
    }

    fn tilt_matrix(&self, angle: Angle) -> Mat3 {
        about_matrix(self.about, angle)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axis(letter: u8, low: f64, high: f64) -> AxisRange {
        AxisRange {
            letter,
            direction: 1.0,
            zero: Angle::ZERO,
            range: Some((Angle::from_deg(low), Angle::from_deg(high))),
            max_rate: 1.0,
            absent: false,
        }
    }

    fn table(about: TiltAbout, low: f64, high: f64) -> TableKinematics {
        TableKinematics {
            about,
            pivot: Vec3::zeros(),
            offset: Vec3::zeros(),
            tilt: axis(b'A', low, high),
            rotation: AxisRange { range: None, ..axis(b'C', 0.0, 0.0) },
            misaligned: None,
            head: None,
        }
    }

    fn dir(x: f64, y: f64, z: f64) -> Dir<Table> {
        Dir::new(Vec3::new(x, y, z)).unwrap()
    }

    #[test]
    fn every_solution_ends_upright() {
        for about in [TiltAbout::X, TiltAbout::Y] {
            let table = table(about, -180.0, 180.0);
            for d in [dir(1.0, 0.0, 0.2), dir(-0.3, 0.5, 0.1), dir(0.0, -1.0, 0.0), dir(0.2, 0.3, -0.9)] {
                for pose in table.solutions(d, Pose::LEVEL) {
                    let up = table.forward(pose).dir(d);
                    assert!((up.unit() - Vec3::z()).norm() < 1e-12, "{about:?} {d:?} {pose:?}");
                }
            }
        }
    }

    #[test]
    fn a_branch_towards_plus_x_takes_a_quarter_turn() {
        let pose = table(TiltAbout::X, 0.0, 90.0).upright(dir(1.0, 0.0, 0.0), Pose::LEVEL).unwrap();
        assert!((pose.tilt.deg() - 90.0).abs() < 1e-9 && (pose.rotation.deg() - 90.0).abs() < 1e-9, "{pose:?}");
    }

    #[test]
    fn the_other_solution_is_taken_where_the_first_is_out_of_range() {
        let pose = table(TiltAbout::X, -90.0, 10.0).upright(dir(1.0, 0.0, 0.0), Pose::LEVEL).unwrap();
        assert!((pose.tilt.deg() + 90.0).abs() < 1e-9 && (pose.rotation.deg() + 90.0).abs() < 1e-9, "{pose:?}");
    }

    #[test]
    fn out_of_range_names_the_limit_and_never_clamps() {
        let refused = table(TiltAbout::X, -15.0, 90.0).upright(dir(1.0, 0.0, -0.5), Pose::LEVEL).unwrap_err();
        assert!(
            (refused.tilt_word_deg - 116.565).abs() < 1e-3
                && (refused.range_deg.0 + 15.0).hypot(refused.range_deg.1 - 90.0) < 1e-9,
            "{refused}"
        );
        assert!(["116.57 deg", "-15..90"].iter().all(|fact| refused.to_string().contains(fact)), "{refused}");
    }

    #[test]
    fn an_upright_direction_leaves_the_rotation_where_it_is() {
        let from = Pose::from_deg(70.0, 390.0);
        let pose = table(TiltAbout::X, -15.0, 90.0).upright(dir(0.0, 0.0, 1.0), from).unwrap();
        assert_eq!((pose.tilt.deg(), pose.rotation), (0.0, from.rotation));
    }

    #[test]
    fn an_endless_axis_unwinds_to_the_nearest_turn_and_a_stopped_one_stays_inside() {
        let from = Pose::from_deg(45.0, 350.0);
        let mut table = table(TiltAbout::X, -90.0, 90.0);
        let pose = table.upright(dir(0.0, 1.0, 1.0), from).unwrap();
        assert!((pose.rotation.deg() - 360.0).abs() < 1e-9, "{pose:?}");
        table.rotation.range = Some((Angle::from_deg(-200.0), Angle::from_deg(200.0)));
        let pose = table.upright(dir(0.0, 1.0, 1.0), from).unwrap();
        assert!(pose.rotation.deg().abs() <= 200.0, "{pose:?}");
    }

    #[test]
    fn words_count_as_the_firmware_does() {
        let axis = AxisRange { direction: -1.0, zero: Angle::from_deg(10.0), ..axis(b'A', -90.0, 90.0) };
        assert!((axis.word_of(Angle::from_deg(30.0)).deg() + 20.0).abs() < 1e-9);
        assert!((axis.angle_of(Angle::from_deg(-20.0)).deg() - 30.0).abs() < 1e-9);
    }
}
