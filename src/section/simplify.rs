//! Contours without the points that carry no shape.

use super::polygons::{Contour, GridPoint};

/// The closed contour with as few of its points as keep it within `tolerance` grid units (Douglas and Peucker 1973).
///
/// Diagonals of flat sides leave points along straight lines, each layer elsewhere; without them equal layers are
/// equal. Fewer than three points come back as they are.
pub fn simplified(contour: &[GridPoint], tolerance: f64) -> Contour {
    let bent = without_straight(contour);
    let Some((start, far)) = anchors(&bent) else { return contour.to_vec() };
    let contour = &bent;
    let ring: Contour = (0..=contour.len()).map(|i| contour[(start + i) % contour.len()]).collect();
    let mut keep = vec![false; ring.len()];
    keep[0] = true;
    keep[far] = true;
    let mut spans = vec![(0, far), (far, ring.len() - 1)];
    while let Some((a, b)) = spans.pop() {
        if let Some(middle) = farthest(&ring, [a, b], tolerance) {
            keep[middle] = true;
            spans.extend([(a, middle), (middle, b)]);
        }
    }
    ring.iter().zip(&keep).take(contour.len()).filter(|(_, keep)| **keep).map(|(&p, _)| p).collect()
}

/// A point so near a line lies on it, grid units: the grid is no finer.
const ON_LINE: f64 = 1.0;
/// So many points in a row are looked at together.
const LONGEST_RUN: usize = 64;

/// The contour, from its leftmost lowest point on, without points on straight lines between others: thinning might keep one of them,
/// where a side runs along the line that it is held against or a corner is beside it, and each layer another.
fn without_straight(contour: &[GridPoint]) -> Contour {
    let Some(start) = leftmost(contour) else { return contour.to_vec() };
    let ring: Contour = (0..=contour.len()).map(|i| contour[(start + i) % contour.len()]).collect();
    let (mut left, mut last) = (vec![ring[0]], 0);
    for i in 1..contour.len() {
        if i - last > LONGEST_RUN || farthest(&ring, [last, i + 1], ON_LINE).is_some() {
            left.push(ring[i]);
            last = i;
        }
    }
    left
}

fn leftmost(contour: &[GridPoint]) -> Option<usize> {
    (0..contour.len()).min_by_key(|&i| (contour[i].x, contour[i].y))
}

/// The leftmost lowest point, and how many points after it the farthest one follows.
fn anchors(contour: &[GridPoint]) -> Option<(usize, usize)> {
    if contour.len() < 3 {
        return None;
    }
    let start = leftmost(contour)?;
    let from = contour[start];
    let squared = |p: GridPoint| i64::from(p.x - from.x).pow(2) + i64::from(p.y - from.y).pow(2);
    let far = (1..contour.len()).max_by_key(|&i| (squared(contour[(start + i) % contour.len()]), usize::MAX - i))?;
    Some((start, far))
}

/// The point strictly between `a` and `b` that lies farthest from their line, if beyond the tolerance.
fn farthest(ring: &[GridPoint], [a, b]: [usize; 2], tolerance: f64) -> Option<usize> {
    let (from, to) = (ring[a], ring[b]);
    let (dx, dy) = (f64::from(to.x - from.x), f64::from(to.y - from.y));
    let length2 = dx * dx + dy * dy;
    let off = |p: GridPoint| {
        let (x, y) = (f64::from(p.x - from.x), f64::from(p.y - from.y));
        // Beyond the ends the distance to the end counts, else a fold back along the line would vanish.
        let t = if length2 > 0.0 { ((x * dx + y * dy) / length2).clamp(0.0, 1.0) } else { 0.0 };
        (x - t * dx).powi(2) + (y - t * dy).powi(2)
    };
    let mut best = (tolerance * tolerance, None);
    for (i, &point) in ring.iter().enumerate().take(b).skip(a + 1) {
        let squared = off(point);
        if squared > best.0 {
            best = (squared, Some(i));
        }
    }
    best.1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_along_a_side_go_and_corners_stay() {
        let points = [(0, 0), (50_000, 5), (100_000, 0), (100_000, 100_000), (99_995, 100_000), (0, 100_000)];
        let got = simplified(&points.map(|(x, y)| GridPoint::new(x, y)), 30.0);
        let wanted = [(0, 0), (100_000, 0), (100_000, 100_000), (0, 100_000)].map(|(x, y)| GridPoint::new(x, y));
        assert_eq!(got, wanted);
    }

    #[test]
    fn a_point_of_a_parallel_side_is_not_kept_for_its_rounding() {
        // A pentagon: two of its corners, and all between them, are as far from the line of the anchors.
        let corners =
            [(565_268, 542_321), (631_232, 520_888), (672_000, 577_000), (631_232, 633_112), (565_268, 611_679)];
        let corners: Contour = corners.map(|(x, y)| GridPoint::new(x, y)).to_vec();
        for between in 1..40 {
            let with: Contour = (0..5)
                .flat_map(|i| {
                    let (a, b) = (corners[i], corners[(i + 1) % 5]);
                    let at = |a: i32, b: i32| a + (f64::from(b - a) * f64::from(between) / 40.0).round() as i32;
                    [a, GridPoint::new(at(a.x, b.x), at(a.y, b.y))]
                })
                .collect();
            assert_eq!(simplified(&with, 30.0), corners, "{between}");
        }
    }
}
