//! Directions: two angles, tangents, an even spread.

use crate::geom::Vec3;

/// The build direction of the angles about X and Y that the documents use (radians): the third row of `Ry(beta) Rx(alpha)`.
///
/// `(a, b)` and `(a + pi, pi - b)` are one direction.
pub fn from_angles(alpha: f64, beta: f64) -> Vec3 {
    let ((sa, ca), (sb, cb)) = (alpha.sin_cos(), beta.sin_cos());
    Vec3::new(-sb, cb * sa, cb * ca)
}

/// The angles `(alpha, beta)` of a unit direction, radians: `alpha` in (-pi, pi], `beta` in [-pi/2, pi/2].
///
/// At `beta = +-pi/2` `alpha` is free; it is then 0.
pub fn to_angles(up: &Vec3) -> (f64, f64) {
    let across = up.y.hypot(up.z);
    let alpha = if across > 0.0 { (up.y + 0.0).atan2(up.z + 0.0) } else { 0.0 };
    (alpha, (-up.x + 0.0).atan2(across))
}

/// The `i`-th of `count` directions spread evenly: Fibonacci's lattice.
pub(super) fn lattice(i: usize, count: usize) -> Vec3 {
    let z = 1.0 - 2.0 * (i as f64 + 0.5) / count as f64;
    let turn = i as f64 * 2.399_963_229_728_653;
    let r = (1.0 - z * z).sqrt();
    Vec3::new(r * turn.cos(), r * turn.sin(), z)
}

/// Two unit vectors at right angles to each other and to `up`.
pub(super) fn tangents(up: &Vec3) -> [Vec3; 2] {
    let aside = if up.x.abs() < 0.9 { Vec3::x() } else { Vec3::y() };
    let e1 = up.cross(&aside).normalize();
    [e1, up.cross(&e1)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_go_there_and_back() {
        assert_eq!(from_angles(0.0, 0.0), Vec3::z());
        assert!((from_angles(0.0, 0.5) - Vec3::new(-(0.5f64.sin()), 0.0, 0.5f64.cos())).norm() < 1e-15);
        for i in 0..100 {
            let up = lattice(i, 100);
            let (alpha, beta) = to_angles(&up);
            assert!((from_angles(alpha, beta) - up).norm() < 1e-14);
            let other = from_angles(alpha + std::f64::consts::PI, std::f64::consts::PI - beta);
            assert!((other - up).norm() < 1e-14);
        }
        assert_eq!(to_angles(&-Vec3::x()), (0.0, std::f64::consts::FRAC_PI_2));
        assert_eq!(to_angles(&Vec3::z()), (0.0, 0.0));
    }
}
