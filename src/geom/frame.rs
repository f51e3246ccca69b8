//! Points, directions and rigid motions that know their frame.
//!
//! Notation: `Rigid<A, B>` takes a point of frame `A` to the same physical point in frame `B`, `p_B = R p_A + t`.

use std::marker::PhantomData;

use super::{Mat3, Vec3};

/// The model file's own axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Object;
/// Fixed to the table's surface: origin at its centre on the rotation axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Table;
/// What a slicer sees: +Z is the build direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Slot;
/// Fixed to the machine's frame: the coordinates of the tool tip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Machine;

/// A position in frame `F`, in mm.
#[derive(Debug, PartialEq)]
pub struct Point<F> {
    /// Coordinates in mm.
    pub at: Vec3,
    frame: PhantomData<F>,
}

impl<F> Clone for Point<F> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<F> Copy for Point<F> {}

impl<F> Point<F> {
    /// The point at `(x, y, z)` mm.
    pub fn new(x: f64, y: f64, z: f64) -> Self {
        Self::from(Vec3::new(x, y, z))
    }
}

impl<F> From<Vec3> for Point<F> {
    fn from(at: Vec3) -> Self {
        Self { at, frame: PhantomData }
    }
}

/// A unit direction in frame `F`.
#[derive(Debug, PartialEq)]
pub struct Dir<F> {
    unit: Vec3,
    frame: PhantomData<F>,
}

impl<F> Clone for Dir<F> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<F> Copy for Dir<F> {}

impl<F> Dir<F> {
    /// The direction of `along`, made a unit; `None` for a vector that is zero or not finite.
    pub fn new(along: Vec3) -> Option<Self> {
        let length = along.norm();
        (length.is_finite() && length > 1e-12).then(|| Self { unit: along / length, frame: PhantomData })
    }

    /// `+Z` of the frame.
    pub fn z() -> Self {
        Self { unit: Vec3::z(), frame: PhantomData }
    }

    /// The unit vector.
    pub fn unit(&self) -> &Vec3 {
        &self.unit
    }
}

/// A rotation and a translation from frame `A` to frame `B`: `p_B = R p_A + t`.
#[derive(Debug, PartialEq)]
pub struct Rigid<A, B> {
    /// The rotation `R`, orthonormal and right-handed.
    pub rotation: Mat3,
    /// The translation `t` in mm, in frame `B`.
    pub translation: Vec3,
    frames: PhantomData<(A, B)>,
}

impl<A, B> Clone for Rigid<A, B> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<A, B> Copy for Rigid<A, B> {}

/// The least rotation that brings the unit direction `up` to +Z; for -Z half a turn about X.
pub fn turned_by(up: &Vec3) -> nalgebra::UnitQuaternion<f64> {
    let half = nalgebra::UnitQuaternion::from_axis_angle(&Vec3::x_axis(), std::f64::consts::PI);
    nalgebra::UnitQuaternion::rotation_between(up, &Vec3::z()).unwrap_or(half)
}

impl<A, B> Rigid<A, B> {
    /// The motion `p -> R p + t`; the caller vouches that `rotation` is orthonormal and right-handed.
    pub fn new(rotation: Mat3, translation: Vec3) -> Self {
        Self { rotation, translation, frames: PhantomData }
    }

    /// A pure translation.
    pub fn shift(translation: Vec3) -> Self {
        Self::new(Mat3::identity(), translation)
    }

    /// The point in frame `B`.
    pub fn point(&self, p: Point<A>) -> Point<B> {
        Point::from(self.rotation * p.at + self.translation)
    }

    /// The direction in frame `B`.
    pub fn dir(&self, d: Dir<A>) -> Dir<B> {
        Dir { unit: self.rotation * d.unit, frame: PhantomData }
    }

    /// First `self`, then `next`.
    pub fn then<C>(&self, next: &Rigid<B, C>) -> Rigid<A, C> {
        Rigid::new(next.rotation * self.rotation, next.rotation * self.translation + next.translation)
    }

    /// The motion back.
    pub fn inverse(&self) -> Rigid<B, A> {
        let back = self.rotation.transpose();
        Rigid::new(back, -(back * self.translation))
    }
}

#[cfg(test)]
mod tests {
    use super::{Machine, Object, Point, Rigid, Table};
    use crate::geom::{Mat3, Vec3};

    #[test]
    fn a_motion_and_its_inverse_agree_with_a_hand_worked_quarter_turn() {
        let quarter = Mat3::new(0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0);
        let motion: Rigid<Object, Table> = Rigid::new(quarter, Vec3::new(10.0, 0.0, 2.0));
        let there = motion.point(Point::new(3.0, 0.0, 1.0));
        assert_eq!(there.at, Vec3::new(10.0, 3.0, 3.0));
        assert_eq!(motion.inverse().point(there).at, Vec3::new(3.0, 0.0, 1.0));
        let lift: Rigid<Table, Machine> = Rigid::shift(Vec3::new(0.0, 0.0, 5.0));
        assert_eq!(motion.then(&lift).point(Point::new(3.0, 0.0, 1.0)).at, Vec3::new(10.0, 3.0, 8.0));
    }
}
