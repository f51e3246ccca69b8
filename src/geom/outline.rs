//! The convex outline of points in a plane.

/// The corners of the points' convex outline, counter-clockwise, by Andrew's monotone chain (1979); corners at which the outline turns
/// by a triangle of at most `flat` mm² (twice its area) are left out. Fewer than three corners for points on one line.
pub fn convex_outline(mut points: Vec<[f64; 2]>, flat: f64) -> Vec<[f64; 2]> {
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let turn = |o: [f64; 2], a: [f64; 2], b: [f64; 2]| (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0]);
    let half = |points: &mut dyn Iterator<Item = &[f64; 2]>| {
        let mut chain: Vec<[f64; 2]> = Vec::new();
        for &p in points {
            while chain.len() > 1 && turn(chain[chain.len() - 2], chain[chain.len() - 1], p) <= flat {
                chain.pop();
            }
            chain.push(p);
        }
        chain.pop();
        chain
    };
    let mut ring = half(&mut points.iter());
    ring.extend(half(&mut points.iter().rev()));
    ring
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_square_with_points_within_and_on_its_edges() {
        let points = vec![[0.0, 0.0], [2.0, 2.0], [1.0, 1.0], [2.0, 0.0], [1.0, 0.0], [0.0, 2.0], [2.0, 1.0]];
        assert_eq!(convex_outline(points, 0.0), [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]]);
        assert!(convex_outline(vec![[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]], 0.0).len() < 3);
        assert!(convex_outline(Vec::new(), 0.0).is_empty());
    }
}
