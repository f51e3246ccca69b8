//! Hulls as they are drawn: of a body with very many corners only those that reach farthest.

use crate::geom::{Hull, Vec3};

/// Beyond this many points (a hull from a file) only those that reach farthest along so many directions are joined.
const MOST_POINTS: usize = 400;

/// The hull of `points`, for drawing and not for proofs.
pub(super) fn drawn(points: &[Vec3]) -> Hull {
    if points.len() > MOST_POINTS { Hull::of(&outermost(points)) } else { Hull::of(points) }
}

/// The points that reach farthest along directions spread evenly (a Fibonacci lattice).
fn outermost(points: &[Vec3]) -> Vec<Vec3> {
    let direction = |i: usize| {
        let z = 1.0 - 2.0 * (i as f64 + 0.5) / MOST_POINTS as f64;
        let (s, c) = (i as f64 * 2.399_963_229_728_653).sin_cos();
        let r = (1.0 - z * z).sqrt();
        Vec3::new(r * c, r * s, z)
    };
    let farthest = |d: Vec3| {
        let along = |i: &usize| points[*i].dot(&d);
        (0..points.len()).max_by(|a, b| along(a).total_cmp(&along(b))).unwrap_or_default()
    };
    let mut kept: Vec<usize> = (0..MOST_POINTS).map(|i| farthest(direction(i))).collect();
    kept.sort_unstable();
    kept.dedup();
    kept.into_iter().map(|i| points[i]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_very_many_points_a_few_hundred_are_drawn() {
        let mut random = crate::geom::SplitMix64::seeded(7);
        let ball: Vec<Vec3> =
            (0..3000).map(|_| Vec3::from_fn(|_, _| random.unit() * 2.0 - 1.0)).filter(|p| p.norm() < 1.0).collect();
        let hull = drawn(&[&ball[..], &ball[..40]].concat());
        assert!(hull.points.len() <= MOST_POINTS && (3.5..4.19).contains(&hull.volume()), "{}", hull.volume());
        assert_eq!(drawn(&ball[..300]), Hull::of(&ball[..300]));
    }
}
