//! Axes that are not square: where they point, and the poses that bring a direction upright with them.
//!
//! ```text
//! p_machine = pivot + R(u, A) * ( offset + R(r, C) * p_table )
//!
//! u, r     unit vectors along the tilt and the rotation axis, machine coordinates, while both angles are zero
//! R(n, t)  the right-handed turn by t about n (O. Rodrigues, 1840)
//! ```
//!
//! The table's frame lies as the machine's where both angles are zero, so its surface (z = 0) is level there, and at other rotations only
//! as far as `r` allows: no rotation is free, and a direction nearer to `r` than `r` can be brought to upright has no pose. Both poses of a
//! direction are Paden and Kahan's second subproblem (R. M. Murray, Z. Li and S. S. Sastry, *A Mathematical Introduction to Robotic
//! Manipulation*, 1994, section 3.2). With `u` a machine axis and `r` = +Z it is the square chain, which has its own arithmetic.

use super::about::sin_cos;
use super::pose::Pose;
use crate::geom::{Angle, Mat3, Vec3};

/// How far an axis may point from where it is on a square machine, degrees: one that leans more is another axis, or was not measured.
pub const MOST_LEAN_DEG: f64 = 5.0;

/// A direction this near to the rotation axis (sine of the angle between them) turns nowhere.
const ALONG: f64 = 1e-9;
/// Two circles on the unit sphere that miss each other by this little touch: rounding of the words that came from them.
const TOUCHING: f64 = 1e-12;
/// Angles below this (radians; a word ends at 1e-6) are zero: the reference pose comes back as it is.
const ZERO: f64 = 1e-8;

/// Where the axes point, machine coordinates, while both angles are zero. Unit length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisDirections {
    /// The tilt axis.
    pub tilt: Vec3,
    /// The rotation axis.
    pub rotation: Vec3,
}

impl AxisDirections {
    /// The turn of the table's frame at `pose`, and of the offset.
    pub(super) fn turns(&self, pose: Pose) -> [Mat3; 2] {
        [turn(&self.tilt, pose.tilt), turn(&self.rotation, pose.rotation)]
    }

    /// The poses that bring the unit vector `d` of the table's frame upright: none, one (where it lies along the rotation axis, which then
    /// stays as in `from`, or where two fall together) or two. Rotations are in `(-180, 180]` degrees.
    pub(super) fn poses(&self, d: &Vec3, from: Pose) -> Vec<Pose> {
        let (u, r) = (&self.tilt, &self.rotation);
        // w = R(-u, A) z = R(r, C) d: as far along u as z is, and as far along r as d is.
        let (cosine, along_u, along_r) = (u.dot(r), u.z, d.dot(r));
        let sine2 = 1.0 - cosine * cosine;
        let [a, b] = [along_u - along_r * cosine, along_r - along_u * cosine].map(|v| v / sine2);
        let rest = (1.0 - a * a - b * b - 2.0 * a * b * cosine) / sine2;
        if rest < -TOUCHING {
            return Vec::new();
        }
        let (middle, across) = (u * a + r * b, u.cross(r) * rest.max(0.0).sqrt());
        let one = |w: Vec3| {
            let tilt = about(u, &w, &Vec3::z()).unwrap_or_default();
            Pose { tilt, rotation: about(r, d, &w).unwrap_or(from.rotation) }
        };
        let both = [one(middle - across), one(middle + across)];
        // The one with less tilt first, as it is for the table's own normal.
        match both[1].tilt.abs().rad() + ZERO < both[0].tilt.abs().rad() {
            _ if both[0] == both[1] => vec![both[0]],
            true => vec![both[1], both[0]],
            false => both.to_vec(),
        }
    }

    /// How far from upright the unit vector `d` stays at the best pose, degrees; 0 where it comes upright.
    pub(super) fn short_of_upright_deg(&self, d: &Vec3) -> f64 {
        let angle = |a: &Vec3, b: &Vec3| a.dot(b).clamp(-1.0, 1.0).acos();
        let (between, of_up, of_d) =
            (angle(&self.tilt, &self.rotation), angle(&self.tilt, &Vec3::z()), angle(&self.rotation, d));
        // Circles about u and r on the unit sphere: apart, one within the other, or on the far side.
        let gaps =
            [between - of_up - of_d, (of_up - of_d).abs() - between, of_up + of_d + between - std::f64::consts::TAU];
        gaps.into_iter().fold(0.0, f64::max).to_degrees()
    }
}

/// The angle about `axis` that takes `from` to `to`, unit vectors equally far along it; `None` where one of them lies on it.
fn about(axis: &Vec3, from: &Vec3, to: &Vec3) -> Option<Angle> {
    let [a, b] = [from, to].map(|v| v - axis * axis.dot(v));
    let (sine, cosine) = (axis.dot(&a.cross(&b)), a.dot(&b));
    let angle = sine.atan2(cosine);
    let angle = if angle.abs() < ZERO { 0.0 } else { angle };
    (a.norm().min(b.norm()) > ALONG).then(|| Angle::from_rad(angle).wrapped())
}

/// The right-handed turn about the unit vector `n` (O. Rodrigues, 1840).
pub(crate) fn turn(n: &Vec3, angle: Angle) -> Mat3 {
    let (s, c) = sin_cos(angle);
    Mat3::identity() * c + n.cross_matrix() * s + n * n.transpose() * (1.0 - c)
}

#[cfg(test)]
mod tests {
    use nalgebra::{UnitQuaternion, UnitVector3};

    use super::*;
    use crate::geom::SplitMix64;

    fn near(numbers: &mut SplitMix64, reach: f64) -> f64 {
        (2.0 * numbers.unit() - 1.0) * reach
    }

    fn any_axes(numbers: &mut SplitMix64, lean: f64) -> AxisDirections {
        let mut lean = || near(numbers, lean);
        let tilt = Vec3::new(1.0, lean(), lean()).normalize();
        AxisDirections { tilt, rotation: Vec3::new(lean(), lean(), 1.0).normalize() }
    }

    fn any_direction(numbers: &mut SplitMix64) -> Vec3 {
        loop {
            let v = Vec3::from_fn(|_, _| near(numbers, 1.0));
            if (0.01..1.0).contains(&v.norm()) {
                return v.normalize();
            }
        }
    }

    /// Where `d` comes, with quaternions.
    fn comes_to(axes: &AxisDirections, pose: Pose, d: &Vec3) -> Vec3 {
        let turned =
            |axis: Vec3, angle: Angle| UnitQuaternion::from_axis_angle(&UnitVector3::new_normalize(axis), angle.rad());
        turned(axes.tilt, pose.tilt) * (turned(axes.rotation, pose.rotation) * d)
    }

    #[test]
    fn turns_are_those_of_quaternions() {
        let mut numbers = SplitMix64::seeded(1);
        for _ in 0..500 {
            let axes = any_axes(&mut numbers, 0.09);
            let pose = Pose::from_deg(near(&mut numbers, 180.0), near(&mut numbers, 720.0));
            let d = any_direction(&mut numbers);
            let [tilt, rotation] = axes.turns(pose);
            assert!((tilt * (rotation * d) - comes_to(&axes, pose, &d)).norm() < 1e-13);
        }
    }

    /// Every pose brings its direction upright, and a search of all angles finds none that was left out.
    #[test]
    fn poses_are_upright_and_all_there_are() {
        let mut numbers = SplitMix64::seeded(2);
        let (mut none, mut two) = (0, 0);
        for round in 0..400 {
            let axes = any_axes(&mut numbers, 0.08);
            // Half of them near the rotation axis, upward or downward, where poses end.
            let d = match round % 4 {
                0 => (axes.rotation + any_direction(&mut numbers) * near(&mut numbers, 0.1)).normalize(),
                1 => (any_direction(&mut numbers) * near(&mut numbers, 0.1) - axes.rotation).normalize(),
                _ => any_direction(&mut numbers),
            };
            let poses = axes.poses(&d, Pose::LEVEL);
            for pose in &poses {
                let off = (comes_to(&axes, *pose, &d) - Vec3::z()).norm();
                assert!(off < 2e-8, "{axes:?} {d:?} {pose:?}: {off}");
            }
            // For each rotation the tilt that comes nearest to upright, by the same quaternions.
            let short = |degrees: f64| {
                let turned = comes_to(&axes, Pose::from_deg(0.0, degrees), &d);
                let across = |v: Vec3| v - axes.tilt * axes.tilt.dot(&v);
                let (a, b) = (across(turned), across(Vec3::z()));
                let tilt = axes.tilt.dot(&a.cross(&b)).atan2(a.dot(&b)).to_degrees();
                (comes_to(&axes, Pose::from_deg(tilt, degrees), &d) - Vec3::z()).norm()
            };
            let all: Vec<f64> = (0..3600).map(|i| short(f64::from(i) * 0.1 - 180.0)).collect();
            let lowest = |i: usize| all[i] < all[(i + 1) % 3600] && all[i] <= all[(i + 3599) % 3600];
            // Between two steps it comes upright to within what a step is.
            let found: Vec<usize> = (0..3600).filter(|&i| lowest(i) && all[i] < 2e-3).collect();
            for i in &found {
                let degrees = *i as f64 * 0.1 - 180.0;
                let near = |pose: &Pose| (pose.rotation.deg() - degrees + 540.0).rem_euclid(360.0) - 180.0;
                let missed = poses.iter().all(|pose| near(pose).abs() > 0.11);
                // Where the circles all but touch, a minimum that is no pose stays short of upright.
                assert!(!missed || axes.short_of_upright_deg(&d) > 0.0, "{d:?} at C{degrees}: {poses:?}");
            }
            let short_deg = axes.short_of_upright_deg(&d);
            assert_eq!(poses.is_empty(), short_deg > 0.0, "{d:?}: {short_deg}");
            if poses.is_empty() {
                let least = all.iter().copied().fold(f64::INFINITY, f64::min);
                let told = 2.0 * (short_deg.to_radians() / 2.0).sin();
                assert!((least - told).abs() < 1e-3 * told + 1e-6, "{least} for {told}");
            }
            (none, two) = (none + usize::from(poses.is_empty()), two + usize::from(poses.len() == 2));
        }
        assert!(none > 10 && two > 200, "{none} {two}");
    }

    #[test]
    fn the_normal_is_upright_at_the_reference_pose_and_at_one_other() {
        let mut numbers = SplitMix64::seeded(3);
        for _ in 0..200 {
            let axes = any_axes(&mut numbers, 0.02);
            let poses = axes.poses(&Vec3::z(), Pose::LEVEL);
            assert!(poses.first() == Some(&Pose::LEVEL), "{axes:?}: {poses:?}");
            assert!(poses.iter().all(|p| p.tilt.deg().abs() < 5.0), "{poses:?}");
        }
    }

    #[test]
    fn a_rotation_axis_that_can_stand_upright_turns_freely_there() {
        // The tilt axis is level, and the rotation axis square to it.
        let axes = AxisDirections { tilt: Vec3::new(1.0, 0.05, 0.0).normalize(), rotation: Vec3::z() };
        let from = Pose::from_deg(30.0, 70.0);
        assert_eq!(axes.poses(&Vec3::z(), from), [Pose::from_deg(0.0, 70.0)]);
    }
}
