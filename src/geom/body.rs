//! Convex bodies of a machine's head and frame, as the hull of a few points.

use super::{Bounds, Vec3};

/// Sides of the prism that stands for a round body. It is circumscribed, so it contains the round one and is at most
/// 1/cos(pi/32) - 1 = 0.5 % too wide.
const ROUND_SIDES: usize = 32;

/// A convex body: the hull of its points, mm.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// What it is called in the profile.
    pub name: String,
    /// The hull's corner points (inner points do no harm).
    pub points: Vec<Vec3>,
    /// Whether the body follows the tip along X, Y and Z; an axis that it does not follow is given in machine
    /// coordinates.
    pub follows: [bool; 3],
    /// Whether it keeps its attitude while the tool turns: it then carries no tip, however low it is seen from the tool.
    pub stays: bool,
}

impl Body {
    /// A round, straight-sided body about +Z: radius `r[0]` at height `z[0]`, `r[1]` at `z[1]`.
    pub fn frustum(name: &str, z: [f64; 2], r: [f64; 2], follows: [bool; 3]) -> Self {
        let grow = 1.0 / (std::f64::consts::PI / ROUND_SIDES as f64).cos();
        let ring = |z: f64, r: f64| {
            (0..ROUND_SIDES).map(move |i| {
                let angle = std::f64::consts::TAU * i as f64 / ROUND_SIDES as f64;
                Vec3::new(r * grow * angle.cos(), r * grow * angle.sin(), z)
            })
        };
        Self {
            name: name.to_owned(),
            points: ring(z[0], r[0]).chain(ring(z[1], r[1])).collect(),
            follows,
            stays: false,
        }
    }

    /// A box from `min` to `max`.
    pub fn cuboid(name: &str, min: Vec3, max: Vec3, follows: [bool; 3]) -> Self {
        let corner = |i: usize| Vec3::from_fn(|axis, _| if i >> axis & 1 == 0 { min[axis] } else { max[axis] });
        Self { name: name.to_owned(), points: (0..8).map(corner).collect(), follows, stays: false }
    }

    /// The body's box.
    pub fn bounds(&self) -> Bounds {
        Bounds::of(self.points.iter().copied())
    }

    /// Where the body's own origin lies while the tip is at `tip`: the tip's coordinate on the axes it follows, 0 on
    /// the others.
    pub fn origin_at(&self, tip: &Vec3) -> Vec3 {
        Vec3::from_fn(|axis, _| if self.follows[axis] { tip[axis] } else { 0.0 })
    }
}

#[cfg(test)]
mod tests {
    use super::Body;
    use crate::geom::Vec3;

    #[test]
    fn a_frustum_contains_its_circle_and_little_more() {
        let body = Body::frustum("nozzle", [0.0, 5.0], [1.0, 6.0], [true; 3]);
        for i in 0..360 {
            let (s, c) = f64::from(i).to_radians().sin_cos();
            let reach = super::super::convex::support(&body.points, &Vec3::new(c, s, 0.0)).dot(&Vec3::new(c, s, 0.0));
            assert!((6.0..6.04).contains(&reach), "{i}: {reach}");
        }
    }

    #[test]
    fn a_gantry_stays_behind_on_the_axis_it_does_not_follow() {
        let beam =
            Body::cuboid("beam", Vec3::new(-5.0, -200.0, 40.0), Vec3::new(5.0, 200.0, 60.0), [true, false, true]);
        assert_eq!(beam.origin_at(&Vec3::new(10.0, 20.0, 30.0)), Vec3::new(10.0, 0.0, 30.0));
    }
}
