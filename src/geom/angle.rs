//! Plane angles: radians inside, degrees at the edges.

use std::ops::{Add, Mul, Neg, Sub};

/// An angle, stored in radians.
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
pub struct Angle(f64);

impl Angle {
    /// Zero.
    pub const ZERO: Self = Self(0.0);

    /// An angle of `value` radians.
    pub const fn from_rad(value: f64) -> Self {
        Self(value)
    }

    /// An angle of `value` degrees.
    pub fn from_deg(value: f64) -> Self {
        Self(value.to_radians())
    }

    /// The value in radians.
    pub const fn rad(self) -> f64 {
        self.0
    }

    /// The value in degrees.
    pub fn deg(self) -> f64 {
        self.0.to_degrees()
    }

    /// The magnitude, without sign.
    pub fn abs(self) -> Self {
        Self(self.0.abs())
    }

    /// The same direction in `(-180, 180]` degrees.
    pub fn wrapped(self) -> Self {
        let turn = std::f64::consts::TAU;
        let half = std::f64::consts::PI;
        let mut value = self.0 % turn;
        if value <= -half {
            value += turn;
        } else if value > half {
            value -= turn;
        }
        Self(value)
    }

    /// The same direction on the turn that lies nearest to `other`.
    pub fn nearest_to(self, other: Self) -> Self {
        other + (self - other).wrapped()
    }
}

impl Add for Angle {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self(self.0 + other.0)
    }
}

impl Sub for Angle {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self(self.0 - other.0)
    }
}

impl Neg for Angle {
    type Output = Self;
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl Mul<f64> for Angle {
    type Output = Self;
    fn mul(self, factor: f64) -> Self {
        Self(self.0 * factor)
    }
}

#[cfg(test)]
mod tests {
    use super::Angle;

    #[test]
    fn wraps_into_the_half_open_turn() {
        for (given, wanted) in
            [(0.0, 0.0), (180.0, 180.0), (-180.0, 180.0), (270.0, -90.0), (-540.0, 180.0), (725.0, 5.0)]
        {
            let got = Angle::from_deg(given).wrapped().deg();
            assert!((got - wanted).abs() < 1e-9, "{given} wrapped to {got}, wanted {wanted}");
        }
    }

    #[test]
    fn unwinds_to_the_nearest_turn() {
        let got = Angle::from_deg(-90.0).nearest_to(Angle::from_deg(650.0)).deg();
        assert!((got - 630.0).abs() < 1e-9, "{got}");
    }
}
