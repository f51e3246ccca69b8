//! The nearest points of two convex sets that stand apart: where a distance is, not only how long.

use super::Vec3;
use super::convex::{Separation, separation};

/// Of the supports that the iteration asked for, the last so many are looked at: the nearest point is made of at most three.
const MOST: usize = 24;

/// A point of each of two convex sets, as near to each other as they come, with what the first one's was carried by.
///
/// `supports` gives for a direction the first set's point farthest along it, the second set's farthest against it, and anything
/// that belongs to the first one and is mixed as it is (where a body stood on its way). `None` where the sets meet.
pub fn nearest_pair(mut supports: impl FnMut(&Vec3) -> [Vec3; 3]) -> Option<[Vec3; 3]> {
    let mut seen: Vec<[Vec3; 3]> = Vec::new();
    let apart = separation(
        |d| {
            let one = supports(d);
            seen.push(one);
            one[0] - one[1]
        },
        f64::INFINITY,
    );
    let Separation::Apart(_) = apart else { return None };
    let from = seen.len().saturating_sub(MOST);
    let last = &seen[from..];
    let mixes = mixes(&last.iter().map(|one| one[0] - one[1]).collect::<Vec<_>>());
    let (_, mix) = mixes.into_iter().min_by(|a, b| a.0.total_cmp(&b.0))?;
    let mixed = |k: usize| mix.iter().map(|(i, share)| last[*i][k] * *share).sum();
    Some([mixed(0), mixed(1), mixed(2)])
}

/// Places among the points, and their shares.
type Mix = Vec<(usize, f64)>;

/// The nearest points to the origin of all corners, edges and triangles within which it has one, by how far they are.
fn mixes(points: &[Vec3]) -> Vec<(f64, Mix)> {
    let mut all = Vec::new();
    for (i, a) in points.iter().enumerate() {
        all.push((a.norm(), vec![(i, 1.0)]));
        for (j, b) in points.iter().enumerate().skip(i + 1) {
            let (along, share) = (b - a, |along: Vec3| -a.dot(&along) / along.norm_squared());
            let t = share(along);
            if (0.0..=1.0).contains(&t) {
                all.push(((a + along * t).norm(), vec![(i, 1.0 - t), (j, t)]));
            }
            for (k, c) in points.iter().enumerate().skip(j + 1) {
                let (e, f) = (along, c - a);
                let (ee, ef, ff) = (e.norm_squared(), e.dot(&f), f.norm_squared());
                let (ae, af, det) = (-a.dot(&e), -a.dot(&f), ee * ff - ef * ef);
                let (v, w) = ((ae * ff - af * ef) / det, (af * ee - ae * ef) / det);
                if v >= 0.0 && w >= 0.0 && v + w <= 1.0 {
                    all.push(((a + e * v + f * w).norm(), vec![(i, 1.0 - v - w), (j, v), (k, w)]));
                }
            }
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::convex::support;

    fn block(min: [f64; 3], max: [f64; 3]) -> Vec<Vec3> {
        (0..8).map(|i| Vec3::from_fn(|k, _| if i >> k & 1 == 1 { max[k] } else { min[k] })).collect()
    }

    /// Blocks whose nearest points are known: across faces, edges and corners; the way is carried along.
    #[test]
    fn blocks_are_nearest_where_they_are() {
        let still = block([0.0; 3], [10.0; 3]);
        for (min, wanted) in [
            ([13.0, 2.0, 3.0], [10.0, f64::NAN, f64::NAN]),
            ([13.0, 14.0, 3.0], [10.0, 10.0, f64::NAN]),
            ([13.0, 14.0, 22.0], [10.0, 10.0, 10.0]),
        ] {
            let other = block(min, [min[0] + 4.0, min[1] + 3.0, min[2] + 2.0]);
            let pair = nearest_pair(|d| [support(&still, d), support(&other, &-d), Vec3::zeros()]).unwrap();
            let off: Vec<f64> = (0..3).map(|k| (min[k] - 10.0).max(0.0)).collect();
            let length = off.iter().map(|v| v * v).sum::<f64>().sqrt();
            assert!(((pair[0] - pair[1]).norm() - length).abs() < 1e-6, "{pair:?}");
            for k in 0..3 {
                let known = wanted[k];
                assert!(known.is_nan() || (pair[0][k] - known).abs() < 1e-6, "{pair:?}");
                assert!((-1e-9..=10.0 + 1e-9).contains(&pair[0][k]));
            }
        }
        let within = block([5.0; 3], [6.0; 3]);
        assert!(nearest_pair(|d| [support(&still, d), support(&within, &-d), Vec3::zeros()]).is_none());
    }

    /// A ball's centre goes along a line past a point: it is nearest where the line is.
    #[test]
    fn what_carries_the_first_one_is_where_it_is_nearest() {
        let (from, to, point) = (Vec3::new(-10.0, 0.0, 0.0), Vec3::new(30.0, 0.0, 0.0), Vec3::new(4.0, 9.0, 0.0));
        let pair = nearest_pair(|d| {
            let centre = if from.dot(d) > to.dot(d) { from } else { to };
            [centre + d.normalize() * 2.0, point, centre]
        });
        let [ball, other, centre] = pair.unwrap();
        assert!((ball - Vec3::new(4.0, 2.0, 0.0)).norm() < 1e-2 && other == point, "{ball:?}");
        assert!((centre - Vec3::new(4.0, 0.0, 0.0)).norm() < 1e-2, "{centre:?}");
    }
}
