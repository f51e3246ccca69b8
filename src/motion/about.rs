//! Turns about the machine's own axes.

use crate::geom::{Angle, Mat3};

/// The machine axis about which the table tilts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TiltAbout {
    /// An A table: tilts about machine +X.
    X,
    /// A B table: tilts about machine +Y.
    Y,
}

/// Right-handed turn about +X or +Y.
pub(super) fn about_matrix(about: TiltAbout, angle: Angle) -> Mat3 {
    match about {
        TiltAbout::X => rotation_x(angle),
        TiltAbout::Y => rotation_y(angle),
    }
}

/// Right-handed turn about +X: +Y goes to +Z.
fn rotation_x(angle: Angle) -> Mat3 {
    let (s, c) = sin_cos(angle);
    Mat3::new(1.0, 0.0, 0.0, 0.0, c, -s, 0.0, s, c)
}

/// Right-handed turn about +Y: +Z goes to +X.
fn rotation_y(angle: Angle) -> Mat3 {
    let (s, c) = sin_cos(angle);
    Mat3::new(c, 0.0, s, 0.0, 1.0, 0.0, -s, 0.0, c)
}

/// Right-handed turn about +Z: +X goes to +Y.
pub(crate) fn rotation_z(angle: Angle) -> Mat3 {
    let (s, c) = sin_cos(angle);
    Mat3::new(c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0)
}

/// Sine and cosine, exact at quarter turns so that a table at 90 degrees prints whole coordinates.
pub(super) fn sin_cos(angle: Angle) -> (f64, f64) {
    let quarters = angle.rad() / std::f64::consts::FRAC_PI_2;
    let nearest = quarters.round();
    if (quarters - nearest).abs() < 1e-12 {
        match (nearest as i64).rem_euclid(4) {
            0 => (0.0, 1.0),
            1 => (1.0, 0.0),
            2 => (0.0, -1.0),
            _ => (-1.0, 0.0),
        }
    } else {
        angle.rad().sin_cos()
    }
}
