//! A head that turns: where its tip is for the words of X, Y and Z, and the words for a tip.
//!
//! ```text
//! H        the head's turn: Rz(yaw) R_tilt(lean), yaw = 0 where the table rotates
//! tip    = axes + v + Rz(yaw) * (u - v - R_tilt(lean) * u)       places in the room, axes and tip alike while the tool is upright
//! p      = H^-1 * (tip - table)                                 the frame `Machine`: as the room, seen with the tool upright
//!
//! u, v     from the tip to a point on the tilt and on the rotation axis, tool upright, mm
//! table    the centre of the table's surface, room, mm
//! ```
//!
//! Whether the table leans by `a` below an upright tool, or the tool by `-a` above a level table, looks alike to both: so everything that
//! compares head and print works in the tool's own frame, [`Machine`](crate::geom::Machine), whose +Z is the tool's axis. What differs stands
//! here: the words, where X, Y and Z end, and which way things fall. Angles are the chain's, those by which the table turns below the tool;
//! yaw and lean of the head are their negatives.
//!
//! With `u` = (0, 0, L) and `v` above the tip it is LinuxCNC's `5axiskins`; with `v` beside it, Marlin's `PENTA_AXIS_HH`; with a table that
//! rotates, its `PENTA_AXIS_HT`. Their formulas are typed out in `tests/it/chains.rs`.

use super::about::{TiltAbout, about_matrix, rotation_z};
use super::pose::Pose;
use crate::geom::{Angle, Bounds, Mat3, Vec3};

/// What X, Y and Z count on a machine whose head turns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SwivelWords {
    /// The linear axes themselves: the firmware knows nothing of the head's turns.
    Axes,
    /// The tip: the firmware moves the axes along as the head turns (G43.4).
    Tip,
}

/// The part of the chain that turns the head.
#[derive(Clone, Debug, PartialEq)]
pub struct SwivelHead {
    /// The axis about which the head leans.
    pub about: TiltAbout,
    /// Whether the rotation axis turns the head, too; else it turns the table.
    pub yaws: bool,
    /// From the tip to a point on the tilt axis, tool upright, mm.
    pub tilt_from_tip: Vec3,
    /// The same to the rotation axis; of no effect where that turns the table.
    pub rotation_from_tip: Vec3,
    /// The centre of the table's surface, room, mm.
    pub table: Vec3,
    /// What X, Y and Z count.
    pub words: SwivelWords,
}

impl SwivelHead {
    /// The head's turn in the room.
    pub fn turn(&self, pose: Pose) -> Mat3 {
        let [yaw, lean] = self.turns(pose);
        yaw * lean
    }

    fn turns(&self, pose: Pose) -> [Mat3; 2] {
        let yaw = if self.yaws { rotation_z(-pose.rotation) } else { Mat3::identity() };
        [yaw, about_matrix(self.about, -pose.tilt)]
    }

    /// From the linear axes to the tip, room.
    fn lever(&self, pose: Pose) -> Vec3 {
        let [yaw, lean] = self.turns(pose);
        let (u, v) = (self.tilt_from_tip, if self.yaws { self.rotation_from_tip } else { Vec3::zeros() });
        v + yaw * (u - v - lean * u)
    }

    /// Where the tip is in the room for the words of X, Y and Z.
    pub fn in_room(&self, words: Vec3, pose: Pose) -> Vec3 {
        match self.words {
            SwivelWords::Axes => words + self.lever(pose),
            SwivelWords::Tip => words,
        }
    }

    /// The tip in the tool's frame for the words of X, Y and Z.
    pub fn tip(&self, words: Vec3, pose: Pose) -> Vec3 {
        self.turn(pose).transpose() * (self.in_room(words, pose) - self.table)
    }

    /// Where a tip of the tool's frame is in the room.
    pub fn tip_in_room(&self, tip: Vec3, pose: Pose) -> Vec3 {
        self.turn(pose) * tip + self.table
    }

    /// The words of X, Y and Z that bring the tip to a place of the tool's frame.
    pub fn words(&self, tip: Vec3, pose: Pose) -> Vec3 {
        let tip = self.tip_in_room(tip, pose);
        match self.words {
            SwivelWords::Axes => tip - self.lever(pose),
            SwivelWords::Tip => tip,
        }
    }

    /// Where the linear axes stand while the tip is at a place of the tool's frame: what their stops bound.
    pub fn axes(&self, tip: Vec3, pose: Pose) -> Vec3 {
        self.tip_in_room(tip, pose) - self.lever(pose)
    }

    /// A point about which nothing moves while one axis turns and the words stay: of the tilt axis, else of the rotation axis. Room, mm.
    pub fn centre(&self, words: Vec3, pose: Pose, tilts: bool) -> Vec3 {
        match self.words {
            SwivelWords::Tip => words,
            SwivelWords::Axes if tilts || !self.yaws => {
                let [yaw, _] = self.turns(pose);
                let v = if self.yaws { self.rotation_from_tip } else { Vec3::zeros() };
                words + v + yaw * (self.tilt_from_tip - v)
            }
            SwivelWords::Axes => words + self.rotation_from_tip,
        }
    }

    /// A box that holds the places where the linear axes may stand for these words at whatever angles.
    pub fn axes_anywhere(&self, words: Vec3) -> Bounds {
        let (u, v) = (self.tilt_from_tip, if self.yaws { self.rotation_from_tip } else { Vec3::zeros() });
        let reach = match self.words {
            SwivelWords::Axes => 0.0,
            SwivelWords::Tip => (u - v).norm() + u.norm(),
        };
        let middle = if self.words == SwivelWords::Tip { words - v } else { words };
        Bounds::of([middle]).inflated(reach)
    }

    /// The box of all places where the linear axes stand while the words stay and one angle goes from `from` to `to`.
    ///
    /// Exact: every coordinate is `k + a cos t + b sin t`, whose extremes are known.
    pub fn axes_while_turning(&self, words: Vec3, from: Pose, to: Pose) -> Bounds {
        if self.words == SwivelWords::Axes {
            return Bounds::of([words]);
        }
        let at = |pose: Pose| words - self.lever(pose);
        let ends = Bounds::of([at(from), at(to)]);
        // Three places of the circle tell k, a and b: at 0, 90 and 180 degrees of the angle that turns.
        let tilts = from.tilt != to.tilt;
        let quarter = |quarters: f64| {
            let angle = Angle::from_deg(90.0 * quarters);
            at(if tilts { Pose { tilt: angle, ..to } } else { Pose { rotation: angle, ..from } })
        };
        let [zero, one, two] = [0.0, 1.0, 2.0].map(quarter);
        let (middle, a) = ((zero + two) * 0.5, (zero - two) * 0.5);
        let b = one - middle;
        let [start, end] = if tilts { [from.tilt, to.tilt] } else { [from.rotation, to.rotation] }.map(Angle::rad);
        let (low, high) = (start.min(end), start.max(end));
        let mut all = ends;
        for i in 0..3 {
            let peak = b[i].atan2(a[i]);
            for turning_point in [peak, peak + std::f64::consts::PI] {
                let turns = ((low - turning_point) / std::f64::consts::TAU).ceil();
                let t = turning_point + turns * std::f64::consts::TAU;
                if t <= high {
                    let value = middle[i] + a[i] * t.cos() + b[i] * t.sin();
                    (all.min[i], all.max[i]) = (all.min[i].min(value), all.max[i].max(value));
                }
            }
        }
        all
    }

    /// What stands at `point` while the tool is upright and the tip at zero, and does not turn with the tool, seen from the tip in the tool's
    /// frame.
    pub fn unturned(&self, point: Vec3, pose: Pose) -> Vec3 {
        self.turn(pose).transpose() * (point - self.lever(pose))
    }

    /// The room's upward direction in the tool's frame.
    pub fn upward(&self, pose: Pose) -> Vec3 {
        self.turn(pose).transpose() * Vec3::z()
    }

    /// How deep any of `points` (from the tip, tool upright) may come below the height that Z says while the head turns to angles within
    /// `tilts`, mm. Points that do not turn with the tool are those of `unturned`.
    ///
    /// Exact, for the same reason as [`SwivelHead::axes_while_turning`].
    pub fn deepest(&self, points: &[Vec3], unturned: &[Vec3], tilts: (Angle, Angle)) -> f64 {
        let Some(low) = least(self.heights(points, unturned), tilts) else { return 0.0 };
        -low
    }

    /// By point, its height over what Z says as `k + a cos t + b sin t` of the tilt `t`.
    fn heights<'a>(&'a self, points: &'a [Vec3], unturned: &'a [Vec3]) -> impl Iterator<Item = [f64; 3]> + 'a {
        let quarter = |quarters: f64| Pose { tilt: Angle::from_deg(90.0 * quarters), ..Pose::LEVEL };
        let over = move |height: &dyn Fn(Pose) -> f64| {
            let [zero, one, two] = [0.0, 1.0, 2.0].map(|q| height(quarter(q)));
            let middle = (zero + two) * 0.5;
            [middle, (zero - two) * 0.5, one - middle]
        };
        // The tip's height over Z's word, and that of the place of the axes.
        let tip = move |pose| if self.words == SwivelWords::Axes { self.lever(pose).z } else { 0.0 };
        let axes = move |pose| tip(pose) - self.lever(pose).z;
        let turned = points.iter().map(move |p| over(&|pose| tip(pose) + (self.turn(pose) * p).z));
        turned.chain(unturned.iter().map(move |p| over(&|pose| axes(pose) + p.z)))
    }
}

/// The least value of any `k + a cos t + b sin t` for `t` within the angles.
fn least(waves: impl Iterator<Item = [f64; 3]>, (from, to): (Angle, Angle)) -> Option<f64> {
    let (from, to) = (from.rad(), to.rad());
    let one = |[k, a, b]: [f64; 3]| {
        let at = |t: f64| k + a * t.cos() + b * t.sin();
        // Lowest where (cos t, sin t) is opposite to (a, b).
        let lowest = b.atan2(a) + std::f64::consts::PI;
        let t = lowest + ((from - lowest) / std::f64::consts::TAU).ceil() * std::f64::consts::TAU;
        let within = if t <= to { at(t) } else { f64::INFINITY };
        at(from).min(at(to)).min(within)
    };
    waves.map(one).reduce(f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::SplitMix64;

    fn any_head(numbers: &mut SplitMix64) -> SwivelHead {
        let mut any = |reach: f64| Vec3::from_fn(|_, _| (2.0 * numbers.unit() - 1.0) * reach);
        let (tilt_from_tip, rotation_from_tip, table) = (any(60.0), any(60.0), any(150.0));
        let about = if numbers.unit() < 0.5 { TiltAbout::X } else { TiltAbout::Y };
        let words = if numbers.unit() < 0.5 { SwivelWords::Axes } else { SwivelWords::Tip };
        SwivelHead { about, yaws: numbers.unit() < 0.5, tilt_from_tip, rotation_from_tip, table, words }
    }

    fn any_pose(numbers: &mut SplitMix64) -> Pose {
        Pose::from_deg(360.0 * numbers.unit() - 180.0, 720.0 * numbers.unit() - 360.0)
    }

    fn any_point(numbers: &mut SplitMix64) -> Vec3 {
        Vec3::from_fn(|_, _| 200.0 * numbers.unit() - 100.0)
    }

    #[test]
    fn words_and_tips_are_each_others_inverse_and_agree_upright() {
        let mut numbers = SplitMix64::seeded(1);
        for _ in 0..500 {
            let (head, pose, tip) = (any_head(&mut numbers), any_pose(&mut numbers), any_point(&mut numbers));
            assert!((head.tip(head.words(tip, pose), pose) - tip).norm() < 1e-10, "{head:?} {pose:?}");
            assert!((head.words(tip, Pose::LEVEL) - head.table - tip).norm() < 1e-10);
            assert!((head.axes(tip, Pose::LEVEL) - head.table - tip).norm() < 1e-10);
        }
    }

    /// The joints one after the other, as matrices of four: an axis through a point turns what hangs from it.
    #[test]
    fn the_tip_hangs_from_two_joints() {
        use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
        let mut numbers = SplitMix64::seeded(2);
        for _ in 0..500 {
            let (head, pose, words) = (any_head(&mut numbers), any_pose(&mut numbers), any_point(&mut numbers));
            let about = |axis: Vector3<f64>, angle: f64, through: Vec3| {
                let there = Translation3::from(through);
                let turn = UnitQuaternion::new(axis * angle);
                there * Isometry3::from_parts(Translation3::identity(), turn) * there.inverse()
            };
            let axis = if head.about == TiltAbout::X { Vector3::x() } else { Vector3::y() };
            let yaw = if head.yaws { -pose.rotation.rad() } else { 0.0 };
            let hangs =
                about(Vector3::z(), yaw, head.rotation_from_tip) * about(axis, -pose.tilt.rad(), head.tilt_from_tip);
            let tip = hangs.transform_point(&nalgebra::Point3::origin()).coords;
            let axes = SwivelHead { words: SwivelWords::Axes, ..head.clone() };
            assert!((axes.in_room(words, pose) - words - tip).norm() < 1e-10, "{head:?} {pose:?}");
            // Where axes stand for a tip is where that tip is found again.
            let q = axes.tip(words, pose);
            assert!((head.axes(q, pose) - words).norm() < 1e-10);
        }
    }

    #[test]
    fn the_centre_of_a_turn_stays() {
        let mut numbers = SplitMix64::seeded(3);
        for _ in 0..500 {
            let (head, from, words) = (any_head(&mut numbers), any_pose(&mut numbers), any_point(&mut numbers));
            for tilts in [true, false] {
                let by = Angle::from_deg(70.0);
                let to = if tilts {
                    Pose { tilt: from.tilt + by, ..from }
                } else {
                    Pose { rotation: from.rotation + by, ..from }
                };
                let centre = head.centre(words, from, tilts);
                // Fixed in the room, it keeps its distance from the tip.
                let distance = |pose| (head.in_room(words, pose) - centre).norm();
                assert!((distance(from) - distance(to)).abs() < 1e-9, "{head:?} {tilts}");
                // And so it does seen from the tool: the head turns about it.
                if tilts || head.yaws {
                    let seen = |pose| head.turn(pose).transpose() * (centre - head.in_room(words, pose));
                    let along = |v: Vec3| {
                        if !tilts {
                            0.0
                        } else if head.about == TiltAbout::X {
                            v.x
                        } else {
                            v.y
                        }
                    };
                    assert!((along(seen(from)) - along(seen(to))).abs() < 1e-9);
                }
            }
        }
    }

    #[test]
    fn bounds_of_turns_hold_every_angle_and_are_reached() {
        let mut numbers = SplitMix64::seeded(4);
        for _ in 0..300 {
            let (head, from, words) = (any_head(&mut numbers), any_pose(&mut numbers), any_point(&mut numbers));
            let other = any_pose(&mut numbers);
            let tilts = numbers.unit() < 0.5;
            let to = if tilts { Pose { tilt: other.tilt, ..from } } else { Pose { rotation: other.rotation, ..from } };
            let told = head.axes_while_turning(words, from, to);
            let steps = 2000;
            let mut seen = Bounds::EMPTY;
            for k in 0..=steps {
                let share = f64::from(k) / f64::from(steps);
                let pose = Pose {
                    tilt: from.tilt + (to.tilt - from.tilt) * share,
                    rotation: from.rotation + (to.rotation - from.rotation) * share,
                };
                seen.add(match head.words {
                    SwivelWords::Axes => words,
                    SwivelWords::Tip => words - head.lever(pose),
                });
            }
            assert!((told.min - seen.min).norm() + (told.max - seen.max).norm() < 5e-3, "{told:?} {seen:?}");
            assert!((0..3).all(|i| told.min[i] <= seen.min[i] + 1e-9 && told.max[i] >= seen.max[i] - 1e-9));
        }
    }

    #[test]
    fn the_deepest_point_of_a_turning_head_is_found() {
        let mut numbers = SplitMix64::seeded(5);
        for _ in 0..200 {
            let head = any_head(&mut numbers);
            let points: Vec<Vec3> = (0..5).map(|_| any_point(&mut numbers)).collect();
            let unturned: Vec<Vec3> = (0..3).map(|_| any_point(&mut numbers)).collect();
            let [a, b] = [any_pose(&mut numbers).tilt, any_pose(&mut numbers).tilt];
            let (low, high) = if a.rad() < b.rad() { (a, b) } else { (b, a) };
            let told = head.deepest(&points, &unturned, (low, high));
            let words = any_point(&mut numbers);
            let mut lowest = f64::INFINITY;
            for k in 0..=2000 {
                let tilt = low + (high - low) * (f64::from(k) / 2000.0);
                let pose = Pose { tilt, rotation: any_pose(&mut numbers).rotation };
                let tip = head.in_room(words, pose);
                let axes = tip - head.lever(pose);
                let turned = points.iter().map(|p| (tip + head.turn(pose) * p).z);
                lowest = turned.chain(unturned.iter().map(|p| (axes + p).z)).fold(lowest, f64::min);
            }
            let deep = words.z - lowest;
            assert!(told >= deep - 1e-9 && told - deep < 1e-2, "{told} {deep}");
        }
    }
}
