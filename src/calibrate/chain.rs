//! The kinematic chain with all that a real machine has beyond it, and how each point moves with each unknown.
//!
//! ```text
//! p_machine = pivot + R(u, A) * ( offset + W * Rz(C) * p_table )
//!
//! u   the tilt axis: its machine axis, leaning across (yaw) and up (pitch)
//! W   a turn about the axis across the tilt axis: the rotation axis leans along the tilt axis
//! the table's surface has the normal (x, y, 1) in the table's frame
//! ```
//!
//! With yaw, pitch, lean and slopes zero this is [`TableKinematics::forward`]. A lean of the rotation axis across the tilt axis is a zero
//! of the tilt, and a shift along the tilt axis is the pivot's alone: so no two unknowns say the same.

use crate::geom::{Angle, Mat3, Vec3};
use crate::motion::{Pose, TableKinematics, TiltAbout};

/// How many unknowns a machine has.
pub const UNKNOWNS: usize = 12;

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
    /// How far the tilt axis turns, about Z, from its machine axis.
    TiltYaw,
    /// How far it rises.
    TiltPitch,
    /// How far the rotation axis leans along the tilt axis.
    RotationLean,
    /// How far the surface falls towards the table's +X.
    SlopeX,
    /// How far it falls towards the table's +Y.
    SlopeY,
}

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
        Self::RotationLean,
        Self::SlopeX,
        Self::SlopeY,
    ];

    /// Whether it is an angle, radians; else a length, mm.
    pub fn is_angle(self) -> bool {
        self as usize >= Self::TiltZero as usize
    }

    /// Whether a profile has no key for it.
    pub fn bends(self) -> bool {
        self as usize >= Self::TiltYaw as usize
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
            Self::RotationLean => format!("rotation axis {rotation}, not square to {tilt}"),
            Self::SlopeX => format!("surface, not square to {rotation}, along the table's X"),
            Self::SlopeY => format!("surface, not square to {rotation}, along the table's Y"),
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

    /// The chain that a profile can hold: pivot, offset and zeros as measured, all axes square.
    pub fn square(&self) -> TableKinematics {
        let mut table = self.nominal.clone();
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

    /// The normal of the table's surface, table frame.
    pub fn normal(&self) -> Vec3 {
        Vec3::new(self.of(Unknown::SlopeX), self.of(Unknown::SlopeY), 1.0).normalize()
    }

    /// The surface's height over the table's origin at `x`, `y` of the table's frame.
    pub fn surface(&self, x: f64, y: f64) -> f64 {
        -self.of(Unknown::SlopeX) * x - self.of(Unknown::SlopeY) * y
    }

    /// The machine while its words are `tilt` and `rotation`.
    pub fn at(&self, tilt: Angle, rotation: Angle) -> Placed<'_> {
        let pose = Pose { tilt: self.nominal.tilt.angle_of(tilt), rotation: self.nominal.rotation.angle_of(rotation) };
        let lean_about = self.across();
        let [yaw, pitch] = [Unknown::TiltYaw, Unknown::TiltPitch].map(|of| self.of(of));
        let raw = self.along() + self.across() * yaw + Vec3::z() * pitch;
        let axis = raw.normalize();
        let tilt = pose.tilt.rad() + self.of(Unknown::TiltZero);
        Placed {
            chain: self,
            axis,
            axis_length: raw.norm(),
            tilt,
            tilted: turn(&axis, tilt),
            leaned: turn(&lean_about, self.of(Unknown::RotationLean)),
            turned: turn(&Vec3::z(), pose.rotation.rad() + self.of(Unknown::RotationZero)),
        }
    }
}

/// The right-handed turn about the unit vector `u` (O. Rodrigues, 1840).
fn turn(u: &Vec3, angle: f64) -> Mat3 {
    let (s, c) = angle.sin_cos();
    let cross = u.cross_matrix();
    Mat3::identity() * c + cross * s + u * u.transpose() * (1.0 - c)
}

/// A machine at one pose.
pub struct Placed<'a> {
    chain: &'a Chain,
    axis: Vec3,
    axis_length: f64,
    tilt: f64,
    tilted: Mat3,
    leaned: Mat3,
    turned: Mat3,
}

impl Placed<'_> {
    /// Where a point of the table's frame comes.
    pub fn point(&self, q: &Vec3) -> Vec3 {
        self.chain.pivot() + self.tilted * (self.chain.offset() + self.leaned * (self.turned * q))
    }

    /// Where a direction of the table's frame points.
    pub fn direction(&self, d: &Vec3) -> Vec3 {
        self.tilted * (self.leaned * (self.turned * d))
    }

    /// The point of the table's frame that is at `p`.
    pub fn on_table(&self, p: &Vec3) -> Vec3 {
        let inside = self.tilted.transpose() * (p - self.chain.pivot()) - self.chain.offset();
        self.turned.transpose() * (self.leaned.transpose() * inside)
    }

    /// How the point `q` of the table's frame moves with each unknown; the surface's slopes do not move it.
    pub fn point_slopes(&self, q: &Vec3) -> [Vec3; UNKNOWNS] {
        let inside = self.leaned * (self.turned * q);
        let mut slopes = self.turning(&(self.chain.offset() + inside), &inside, &(self.turned * q));
        slopes[..3].copy_from_slice(&[Vec3::x(), Vec3::y(), Vec3::z()]);
        slopes[Unknown::OffsetAcross as usize] = self.tilted * self.chain.across();
        slopes[Unknown::OffsetZ as usize] = self.tilted * Vec3::z();
        slopes
    }

    /// The surface's normal and how it moves with each unknown.
    pub fn normal_slopes(&self) -> (Vec3, [Vec3; UNKNOWNS]) {
        let m = self.chain.normal();
        let inside = self.leaned * (self.turned * m);
        let mut slopes = self.turning(&inside, &inside, &(self.turned * m));
        // The normal's third component before it was made a unit.
        let length = 1.0 / m.z;
        for (unknown, e) in [(Unknown::SlopeX, Vec3::x()), (Unknown::SlopeY, Vec3::y())] {
            slopes[unknown as usize] = self.direction(&((e - m * m.dot(&e)) / length));
        }
        (self.tilted * inside, slopes)
    }

    /// What the unknown turns do: to `arm` the tilt axis, to `leaned` the rotation axis's lean, to `turned` the rotation.
    fn turning(&self, arm: &Vec3, leaned: &Vec3, turned: &Vec3) -> [Vec3; UNKNOWNS] {
        let mut slopes = [Vec3::zeros(); UNKNOWNS];
        slopes[Unknown::TiltZero as usize] = self.axis.cross(&(self.tilted * arm));
        slopes[Unknown::RotationZero as usize] = self.tilted * (self.leaned * Vec3::z().cross(turned));
        slopes[Unknown::RotationLean as usize] = self.tilted * self.chain.across().cross(leaned);
        let (s, c) = self.tilt.sin_cos();
        for (unknown, e) in [(Unknown::TiltYaw, self.chain.across()), (Unknown::TiltPitch, Vec3::z())] {
            let u = &self.axis;
            let du = (e - u * u.dot(&e)) / self.axis_length;
            slopes[unknown as usize] = du.cross(arm) * s + (du * u.dot(arm) + u * du.dot(arm)) * (1.0 - c);
        }
        slopes
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::SplitMix64;
    use crate::profile::resolve;

    fn machines() -> Vec<TableKinematics> {
        ["generic-ac", "fibr3d", "open5x-prusa"]
            .map(|name| resolve("m.toml", &format!("extends = \"{name}\"")).unwrap().0.kinematics())
            .to_vec()
    }

    fn near(numbers: &mut SplitMix64, reach: f64) -> f64 {
        (2.0 * numbers.unit() - 1.0) * reach
    }

    fn any(numbers: &mut SplitMix64) -> [f64; UNKNOWNS] {
        Unknown::ALL.map(|unknown| near(numbers, if unknown.is_angle() { 0.1 } else { 5.0 }))
    }

    #[test]
    fn without_bends_it_is_the_chain_that_all_others_read() {
        let mut numbers = SplitMix64::seeded(1);
        for nominal in machines() {
            for _ in 0..50 {
                let mut by = any(&mut numbers);
                by[Unknown::TiltYaw as usize..].fill(0.0);
                let chain = Chain::new(nominal.clone(), by);
                let [tilt, rotation] = [90.0, 360.0].map(|most| Angle::from_deg(near(&mut numbers, most)));
                let square = chain.square();
                let pose = Pose { tilt: square.tilt.angle_of(tilt), rotation: square.rotation.angle_of(rotation) };
                let q = Vec3::from_fn(|_, _| near(&mut numbers, 80.0));
                let motion = square.forward(pose);
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
                assert!((normal - placed.direction(&chain.normal())).norm() < 1e-12);
                let points = placed.point_slopes(&q);
                for (i, unknown) in Unknown::ALL.into_iter().enumerate() {
                    let moved = |way: f64| {
                        let mut by = by;
                        by[i] += way * STEP;
                        let chain = Chain::new(nominal.clone(), by);
                        let placed = chain.at(tilt, rotation);
                        (placed.point(&q), placed.direction(&chain.normal()))
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
