//! The area that two facing triangles share.

use crate::geom::Vec3;

/// A point of a facet's plane, in its own two axes, mm.
type Flat = [f64; 2];

/// Twice the signed area of `a b c`, positive counter-clockwise.
fn cross(a: Flat, b: Flat, c: Flat) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// What a triangle and another's shadow on its plane share.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Shared {
    /// In the first triangle's plane, mm²; zero where they share nothing.
    pub(super) area: f64,
    /// Where its centre lies.
    pub(super) centre: Vec3,
}

/// The overlap of `a` with the projection of `b` along `normal`, the unit normal of `a`; `b` must face it.
pub(super) fn shared(a: &[Vec3; 3], normal: &Vec3, b: &[Vec3; 3]) -> Shared {
    let u = (a[1] - a[0]).normalize();
    let v = normal.cross(&u);
    let flat = |p: &Vec3| [(p - a[0]).dot(&u), (p - a[0]).dot(&v)];
    let window = a.map(|p| flat(&p));
    // Facing triangles turn opposite ways; reversed, the shadow turns like `a`.
    let shadow = [flat(&b[2]), flat(&b[1]), flat(&b[0])];
    // Most lie wholly beyond one side.
    let beyond = |side: usize| shadow.iter().all(|&p| cross(window[side], window[(side + 1) % 3], p) <= 0.0);
    if (0..3).any(beyond) {
        return Shared { area: 0.0, centre: a[0] };
    }
    let polygon = clip(&shadow, &window);
    let (area, centre) = area_and_centre(&polygon);
    Shared { area, centre: a[0] + u * centre[0] + v * centre[1] }
}

/// Sutherland and Hodgman: cuts a convex polygon by each side of a counter-clockwise triangle.
fn clip(polygon: &[Flat; 3], window: &[Flat; 3]) -> Vec<Flat> {
    let mut polygon = polygon.to_vec();
    for side in 0..3 {
        let (from, to) = (window[side], window[(side + 1) % 3]);
        let mut kept = Vec::with_capacity(polygon.len() + 1);
        for (index, &here) in polygon.iter().enumerate() {
            let next = polygon[(index + 1) % polygon.len()];
            let (inside, beyond) = (cross(from, to, here), cross(from, to, next));
            if inside >= 0.0 {
                kept.push(here);
            }
            if (inside > 0.0 && beyond < 0.0) || (inside < 0.0 && beyond > 0.0) {
                let part = inside / (inside - beyond);
                kept.push([here[0] + part * (next[0] - here[0]), here[1] + part * (next[1] - here[1])]);
            }
        }
        polygon = kept;
    }
    polygon
}

fn area_and_centre(polygon: &[Flat]) -> (f64, Flat) {
    let Some(&origin) = polygon.first() else { return (0.0, [0.0; 2]) };
    let (mut twice, mut moment) = (0.0, [0.0; 2]);
    for pair in polygon.windows(2).skip(1) {
        let double = cross(origin, pair[0], pair[1]);
        twice += double;
        for axis in 0..2 {
            moment[axis] += double * (pair[0][axis] + pair[1][axis] - 2.0 * origin[axis]) / 3.0;
        }
    }
    if twice > 0.0 {
        (twice * 0.5, [origin[0] + moment[0] / twice, origin[1] + moment[1] / twice])
    } else {
        (0.0, origin)
    }
}

#[cfg(test)]
mod tests {
    use super::shared;
    use crate::geom::Vec3;

    fn at(x: f64, y: f64, z: f64) -> Vec3 {
        Vec3::new(x, y, z)
    }

    #[test]
    fn the_overlap_of_shifted_triangles_is_exact() {
        let a = [at(0.0, 0.0, 2.0), at(4.0, 0.0, 2.0), at(0.0, 4.0, 2.0)];
        let facing = |dx: f64, dy: f64| {
            let b = [at(dx, dy, 3.0), at(dx, dy + 4.0, 3.0), at(dx + 4.0, dy, 3.0)];
            shared(&a, &Vec3::z(), &b)
        };
        let all = facing(0.0, 0.0);
        assert_eq!(all.area, 8.0);
        assert!((all.centre - at(4.0 / 3.0, 4.0 / 3.0, 2.0)).norm() < 1e-12);
        assert_eq!(facing(2.0, 0.0).area, 2.0);
        assert_eq!(facing(1.0, 1.0).area, 2.0);
        assert_eq!(facing(4.0, 0.0).area, 0.0, "a shared corner is no area");
        assert_eq!(facing(-1.0, -1.0).area, 2.0);
        assert_eq!(facing(9.0, 9.0).area, 0.0);
    }

    #[test]
    fn a_hexagon_comes_out_of_two_triangles_head_to_tail() {
        let turn = |k: f64| at((k * 60.0_f64).to_radians().cos(), (k * 60.0_f64).to_radians().sin(), 0.0);
        let shared = shared(&[turn(0.0), turn(2.0), turn(4.0)], &Vec3::z(), &[turn(1.0), turn(5.0), turn(3.0)]);
        let triangle = 3.0_f64.sqrt() * 0.75;
        assert!((shared.area - triangle * 2.0 / 3.0).abs() < 1e-12, "{}", shared.area);
        assert!(shared.centre.norm() < 1e-12);
    }
}
