//! From where something is seen: parallel projection, so that lengths along the paper are true everywhere.

use crate::geom::Vec3;

/// A direction to look from, with what is to the right and up on paper.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Eye {
    right: Vec3,
    up: Vec3,
    toward: Vec3,
}

impl Eye {
    /// Turned about Z, from the front (-Y) to the right (+X), and so far above the horizon; degrees.
    pub fn at(turn_deg: f64, rise_deg: f64) -> Self {
        let ((st, ct), (sr, cr)) = (turn_deg.to_radians().sin_cos(), rise_deg.to_radians().sin_cos());
        let (toward, right) = (Vec3::new(st * cr, -ct * cr, sr), Vec3::new(ct, st, 0.0));
        Self { right, up: toward.cross(&right), toward }
    }

    /// Right, down and towards the eye, in the unit of `p`.
    pub fn seen(&self, p: &Vec3) -> [f64; 3] {
        [p.dot(&self.right), -p.dot(&self.up), p.dot(&self.toward)]
    }

    /// How bright a surface with a unit normal is, from 0 to 1: the light comes from the upper left, behind the eye. Its back is as bright as
    /// its front.
    pub(super) fn light(&self, normal: &Vec3) -> f64 {
        let facing = if normal.dot(&self.toward) < 0.0 { -normal } else { *normal };
        let light = (self.toward + self.up * 0.7 - self.right * 0.45).normalize();
        0.5 + 0.5 * facing.dot(&light).max(0.0)
    }

    /// Whether a normal points to the eye.
    pub(super) fn faces(&self, normal: &Vec3) -> bool {
        normal.dot(&self.toward) >= 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn higher_is_higher_on_paper_and_nearer_is_nearer() {
        let eye = Eye::at(-35.0, 24.0);
        let [origin, z, front] = [Vec3::zeros(), Vec3::z(), -Vec3::y()].map(|p| eye.seen(&p));
        assert!(z[1] < origin[1] && front[2] > origin[2]);
        assert!(eye.seen(&Vec3::x())[0] > 0.5, "X to the right");
        let from_right = Eye::at(90.0, 0.0).seen(&Vec3::x());
        assert!((from_right[2] - 1.0).abs() < 1e-12 && from_right[0].abs() < 1e-12);
        assert!(Eye::at(0.0, -30.0).seen(&-Vec3::z())[2] > 0.0, "from below");
    }
}
