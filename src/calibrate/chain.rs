//! The kinematic chain with all that a real machine has beyond it, and how each point moves with each unknown.
//!
//! ```text
//! p_machine = pivot + R(u, A) * ( offset + E * R(r, C) * p_table )
//!
//! u   the tilt axis where both angles are zero: as the profile has it, leaning across (yaw) and up (pitch)
//! r   the rotation axis there: as the profile has it, leaning along X and along Y
//! E   a turn about the axis across the tilt axis: the surface, z = 0 of the table's frame, is not level there
//! ```
//!
//! With E = 1 this is [`TableKinematics::forward`], and a profile holds all of it. A surface that is not level across the tilt axis is a
//! zero of the tilt, and a shift along the tilt axis is the pivot's alone: so no two unknowns say the same.

use crate::geom::{Angle, Mat3, Vec3};
use crate::motion::{AxisDirections, Pose, TableKinematics, TiltAbout, turn};

/// How many unknowns a machine has.
pub const UNKNOWNS: usize = 13;

/// What is not known of a machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unknown {
    /// The pivot's X, mm.
    PivotX,
    /// The pivot's Y, mm.
    PivotY,
    /// The pivot's Z, mm.
    PivotZ,
    /// The offset across the tilt axis (Y of an A table, X of a B table), mm.
    OffsetAcross,
    /// The offset's Z, mm: the height of the table's surface over the tilt axis.
    OffsetZ,
    /// What the tilt word is wrong by.
    TiltZero,
    /// What the rotation word is wrong by.
    RotationZero,
    /// How far the tilt axis turns, about Z, from where the profile has it.
    TiltYaw,
    /// How far it rises.
    TiltPitch,
    /// How far the rotation axis leans towards +X.
    LeanX,
    /// How far it leans towards +Y.
    LeanY,
    /// How far the surface falls along the tilt axis where both angles are zero.
    Unlevel,
    /// How much lower the surface is at [`SAG_AT_MM`] from its middle than there, mm, as the square of the distance.
    Sag,
}

/// Where a sag is told, mm from the table's middle.
pub const SAG_AT_MM: f64 = 100.0;

impl Unknown {
    /// All, in the order of every vector of unknowns.
    pub const ALL: [Self; UNKNOWNS] = [
        Self::PivotX,
        Self::PivotY,
        Self::PivotZ,
        Self::OffsetAcross,
        Self::OffsetZ,
        Self::TiltZero,
        Self::RotationZero,
        Self::TiltYaw,
        Self::TiltPitch,
        Self::LeanX,
        Self::LeanY,
        Self::Unlevel,
        Self::Sag,
    ];

    /// Whether it is an angle, radians; else a length, mm.
    pub fn is_angle(self) -> bool {
        (Self::TiltZero as usize..=Self::Unlevel as usize).contains(&(self as usize))
    }

    /// Whether it is zero on a machine whose axes are where its profile has them.
    pub fn bends(self) -> bool {
        (Self::TiltYaw as usize..=Self::Unlevel as usize).contains(&(self as usize))
    }

    /// What people call it, on a table that tilts `about` an axis with the letters `tilt` and `rotation`.
    pub fn name(self, about: TiltAbout, [tilt, rotation]: [char; 2]) -> String {
        let (along, across) = if about == TiltAbout::X { ('X', 'Y') } else { ('Y', 'X') };
        match self {
            Self::PivotX => "pivot X".to_owned(),
            Self::PivotY => "pivot Y".to_owned(),
            Self::PivotZ => "pivot Z".to_owned(),
            Self::OffsetAcross => format!("offset {across}"),
            Self::OffsetZ => "offset Z".to_owned(),
            Self::TiltZero => format!("zero of {tilt}"),
            Self::RotationZero => format!("zero of {rotation}"),
            Self::TiltYaw => format!("tilt axis {tilt}, turned from {along} towards {across}"),
            Self::TiltPitch => format!("tilt axis {tilt}, rising along {along}"),
            Self::LeanX => format!("rotation axis {rotation}, leaning towards X"),
            Self::LeanY => format!("rotation axis {rotation}, leaning towards Y"),
            Self::Unlevel => format!("surface, falling along {along} at {tilt}0 {rotation}0"),
            Self::Sag => format!("surface, lower at {SAG_AT_MM} mm from its middle"),
        }
    }

    /// The names of all, on a machine of that chain.
    pub fn names(table: &TableKinematics) -> [String; UNKNOWNS] {
        let letters = [&table.tilt, &table.rotation].map(|axis| char::from(axis.letter));
        Self::ALL.map(|unknown| unknown.name(table.about, letters))
    }
}

/// A machine: a profile's chain, and by how much it differs.
#[derive(Clone, Debug, PartialEq)]
pub struct Chain {
    nominal: TableKinematics,
    /// In the order of [`Unknown::ALL`].
    by: [f64; UNKNOWNS],
}

impl Chain {
    /// The machine that differs from `nominal` by `by`, mm and radians, in the order of [`Unknown::ALL`].
    pub fn new(nominal: TableKinematics, by: [f64; UNKNOWNS]) -> Self {
        Self { nominal, by }
    }

    /// By how much it differs.
    pub fn by(&self) -> &[f64; UNKNOWNS] {
        &self.by
    }

    fn along(&self) -> Vec3 {
        if self.nominal.about == TiltAbout::X { Vec3::x() } else { Vec3::y() }
    }

    fn across(&self) -> Vec3 {
        if self.nominal.about == TiltAbout::X { Vec3::y() } else { Vec3::x() }
    }

    fn of(&self, unknown: Unknown) -> f64 {
        self.by[unknown as usize]
    }

    /// Where its axes point where both angles are zero.
    pub fn directions(&self) -> AxisDirections {
        let AxisDirections { tilt, rotation } = self.nominal.directions();
        AxisDirections { tilt: self.raw_tilt(tilt).normalize(), rotation: self.raw_rotation(rotation).normalize() }
    }

    fn raw_tilt(&self, profile: Vec3) -> Vec3 {
        profile + self.across() * self.of(Unknown::TiltYaw) + Vec3::z() * self.of(Unknown::TiltPitch)
    }

    fn raw_rotation(&self, profile: Vec3) -> Vec3 {
        profile + Vec3::new(self.of(Unknown::LeanX), self.of(Unknown::LeanY), 0.0)
    }

    /// What a profile can hold of it: all but a surface that is not level or sags.
    pub fn table(&self) -> TableKinematics {
        let mut table = self.nominal.clone();
        let bends = [Unknown::TiltYaw, Unknown::TiltPitch, Unknown::LeanX, Unknown::LeanY];
        if bends.into_iter().any(|unknown| self.of(unknown) != 0.0) {
            table.misaligned = Some(self.directions());
        }
        table.pivot = self.pivot();
        table.offset = self.offset();
        table.tilt.zero = table.tilt.zero - Angle::from_rad(self.of(Unknown::TiltZero)) * table.tilt.direction;
        table.rotation.zero =
            table.rotation.zero - Angle::from_rad(self.of(Unknown::RotationZero)) * table.rotation.direction;
        table
    }

    fn pivot(&self) -> Vec3 {
        self.nominal.pivot + Vec3::new(self.by[0], self.by[1], self.by[2])
    }

    fn offset(&self) -> Vec3 {
        self.nominal.offset + self.across() * self.of(Unknown::OffsetAcross) + Vec3::z() * self.of(Unknown::OffsetZ)
    }

    /// About which the surface falls along the tilt axis.
    fn fall_about(&self) -> Vec3 {
        Vec3::z().cross(&self.along())
    }

    /// The machine while its words are `tilt` and `rotation`.
    pub fn at(&self, tilt: Angle, rotation: Angle) -> PosedChain<'_> {
        let pose = Pose { tilt: self.nominal.tilt.angle_of(tilt), rotation: self.nominal.rotation.angle_of(rotation) };
        let AxisDirections { tilt: u, rotation: r } = self.nominal.directions();
        let tilt = Turn::about(self.raw_tilt(u), pose.tilt.rad() + self.of(Unknown::TiltZero));
        let rotation = Turn::about(self.raw_rotation(r), pose.rotation.rad() + self.of(Unknown::RotationZero));
        let fallen = turn(&self.fall_about(), Angle::from_rad(self.of(Unknown::Unlevel)));
        PosedChain { chain: self, tilt, fallen, rotation }
    }
}

/// A turn about an axis that is not known.
struct Turn {
    axis: Vec3,
    /// Of the axis before it was made a unit vector.
    length: f64,
    angle: f64,
    matrix: Mat3,
}

impl Turn {
    fn about(raw: Vec3, angle: f64) -> Self {
        let (axis, length) = (raw.normalize(), raw.norm());
        Self { axis, length, angle, matrix: turn(&axis, Angle::from_rad(angle)) }
    }

    /// How what was `arm` moves with the angle.
    fn by_angle(&self, arm: &Vec3) -> Vec3 {
        self.axis.cross(&(self.matrix * arm))
    }

    /// The same with the axis leaning towards `e`.
    fn by_lean(&self, arm: &Vec3, e: &Vec3) -> Vec3 {
        let ((s, c), u) = (self.angle.sin_cos(), &self.axis);
        let du = (e - u * u.dot(e)) / self.length;
        du.cross(arm) * s + (du * u.dot(arm) + u * du.dot(arm)) * (1.0 - c)
    }
}

/// A machine at one pose.
pub struct PosedChain<'a> {
    chain: &'a Chain,
    tilt: Turn,
    fallen: Mat3,
    rotation: Turn,
}

impl PosedChain<'_> {
    /// Where a point of the table's frame comes.
    pub fn point(&self, q: &Vec3) -> Vec3 {
        self.chain.pivot() + self.tilt.matrix * (self.chain.offset() + self.inside(q))
    }

    /// Where a direction of the table's frame points.
    pub fn direction(&self, d: &Vec3) -> Vec3 {
        self.tilt.matrix * self.inside(d)
    }

    /// Before the tilt.
    fn inside(&self, d: &Vec3) -> Vec3 {
        self.fallen * (self.rotation.matrix * d)
    }

    /// The point of the table's frame that is at `p`.
    pub fn on_table(&self, p: &Vec3) -> Vec3 {
        let inside = self.tilt.matrix.transpose() * (p - self.chain.pivot()) - self.chain.offset();
        self.rotation.matrix.transpose() * (self.fallen.transpose() * inside)
    }

    /// A direction of the machine's in the table's frame.
    pub fn inward(&self, d: &Vec3) -> Vec3 {
        self.rotation.matrix.transpose() * (self.fallen.transpose() * (self.tilt.matrix.transpose() * d))
    }

    /// How the point `q` of the table's frame moves with each unknown.
    pub fn point_slopes(&self, q: &Vec3) -> [Vec3; UNKNOWNS] {
        let mut slopes = self.turning(&(self.chain.offset() + self.inside(q)), q);
        slopes[..3].copy_from_slice(&[Vec3::x(), Vec3::y(), Vec3::z()]);
        slopes[Unknown::OffsetAcross as usize] = self.tilt.matrix * self.chain.across();
        slopes[Unknown::OffsetZ as usize] = self.tilt.matrix * Vec3::z();
        slopes
    }

    /// The surface's normal and how it moves with each unknown.
    pub fn normal_slopes(&self) -> (Vec3, [Vec3; UNKNOWNS]) {
        let inside = self.inside(&Vec3::z());
        (self.tilt.matrix * inside, self.turning(&inside, &Vec3::z()))
    }

    /// What the unknown turns do: to `arm` the tilt's, to `q` of the table's frame the others.
    fn turning(&self, arm: &Vec3, q: &Vec3) -> [Vec3; UNKNOWNS] {
        let mut slopes = [Vec3::zeros(); UNKNOWNS];
        let (outer, fallen) = (self.tilt.matrix, self.fallen);
        slopes[Unknown::TiltZero as usize] = self.tilt.by_angle(arm);
        slopes[Unknown::TiltYaw as usize] = self.tilt.by_lean(arm, &self.chain.across());
        slopes[Unknown::TiltPitch as usize] = self.tilt.by_lean(arm, &Vec3::z());
        slopes[Unknown::Unlevel as usize] = outer * self.chain.fall_about().cross(&self.inside(q));
        slopes[Unknown::RotationZero as usize] = outer * (fallen * self.rotation.by_angle(q));
        slopes[Unknown::LeanX as usize] = outer * (fallen * self.rotation.by_lean(q, &Vec3::x()));
        slopes[Unknown::LeanY as usize] = outer * (fallen * self.rotation.by_lean(q, &Vec3::y()));
        slopes
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::SplitMix64;
    use crate::profile::resolve;

    /// Two with A, one with B, and one whose profile has axes that are not square.
    fn machines() -> Vec<TableKinematics> {
        let leaning =
            "[kinematics.tilt]\nalong = [0.999, 0.03, -0.02]\n[kinematics.rotation]\nalong = [0.02, -0.03, 0.999]\n";
        let named = ["generic-ac", "fibr3d", "open5x-prusa"].map(|name| format!("extends = \"{name}\""));
        let all = named.iter().map(String::as_str).chain([leaning]);
        all.map(|text| resolve("m.toml", text).unwrap().0.kinematics()).collect()
    }

    fn near(numbers: &mut SplitMix64, reach: f64) -> f64 {
        (2.0 * numbers.unit() - 1.0) * reach
    }

    fn any(numbers: &mut SplitMix64) -> [f64; UNKNOWNS] {
        Unknown::ALL.map(|unknown| near(numbers, if unknown.is_angle() { 0.1 } else { 5.0 }))
    }

    #[test]
    fn with_a_level_surface_it_is_the_chain_that_all_others_read() {
        let mut numbers = SplitMix64::seeded(1);
        for nominal in machines() {
            for _ in 0..50 {
                let mut by = any(&mut numbers);
                by[Unknown::Unlevel as usize] = 0.0;
                let chain = Chain::new(nominal.clone(), by);
                let [tilt, rotation] = [90.0, 360.0].map(|most| Angle::from_deg(near(&mut numbers, most)));
                let table = chain.table();
                let pose = Pose { tilt: table.tilt.angle_of(tilt), rotation: table.rotation.angle_of(rotation) };
                let q = Vec3::from_fn(|_, _| near(&mut numbers, 80.0));
                let motion = table.forward(pose);
                let theirs = motion.rotation * q + motion.translation;
                let ours = chain.at(tilt, rotation);
                assert!((ours.point(&q) - theirs).norm() < 1e-10, "{:?} {theirs:?}", ours.point(&q));
                assert!((ours.on_table(&theirs) - q).norm() < 1e-10);
            }
        }
    }

    #[test]
    fn slopes_are_those_of_differences() {
        const STEP: f64 = 1e-5;
        let mut numbers = SplitMix64::seeded(2);
        for nominal in machines() {
            for _ in 0..20 {
                let by = any(&mut numbers);
                let [tilt, rotation] = [90.0, 360.0].map(|most| Angle::from_deg(near(&mut numbers, most)));
                let q = Vec3::from_fn(|_, _| near(&mut numbers, 80.0));
                let chain = Chain::new(nominal.clone(), by);
                let placed = chain.at(tilt, rotation);
                let (normal, normals) = placed.normal_slopes();
                assert!((normal - placed.direction(&Vec3::z())).norm() < 1e-12);
                let points = placed.point_slopes(&q);
                for (i, unknown) in Unknown::ALL.into_iter().enumerate() {
                    let moved = |way: f64| {
                        let mut by = by;
                        by[i] += way * STEP;
                        let chain = Chain::new(nominal.clone(), by);
                        let placed = chain.at(tilt, rotation);
                        (placed.point(&q), placed.direction(&Vec3::z()))
                    };
                    let (up, down) = (moved(1.0), moved(-1.0));
                    let point = (up.0 - down.0) / (2.0 * STEP);
                    let normal = (up.1 - down.1) / (2.0 * STEP);
                    assert!((points[i] - point).norm() < 1e-6, "{unknown:?}: {:?} {point:?}", points[i]);
                    assert!((normals[i] - normal).norm() < 1e-8, "{unknown:?}: {:?} {normal:?}", normals[i]);
                }
            }
        }
    }
}
