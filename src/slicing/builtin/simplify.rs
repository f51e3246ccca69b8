//! Contours without the points that carry no shape.

use super::region::{Contour, Point};

/// How far a dropped point may lie from the line that replaces it while sections are worked on: 3 micrometres, a quarter of what PrusaSlicer drops.
const TOLERANCE_UNITS: f64 = 30.0;

/// The closed contour with as few of its points as keep it within 3 micrometres (Douglas and Peucker 1973).
///
/// Diagonals of flat sides leave points along straight lines, each layer elsewhere; without them equal layers are
/// equal. Fewer than three points come back as they are.
pub(super) fn simplified(contour: &[Point]) -> Contour {
    simplified_to(contour, TOLERANCE_UNITS)
}

/// The same with another tolerance, grid units.
pub(super) fn simplified_to(contour: &[Point], tolerance: f64) -> Contour {
    let Some((start, far)) = anchors(contour) else { return contour.to_vec() };
    let ring: Contour = (0..=contour.len()).map(|i| contour[(start + i) % contour.len()]).collect();
    let mut keep = vec![false; ring.len()];
    keep[0] = true;
    keep[far] = true;
    let mut spans = vec![(0, far), (far, ring.len() - 1)];
    while let Some((a, b)) = spans.pop() {
        if let Some(middle) = farthest(&ring, a, b, tolerance) {
            keep[middle] = true;
            spans.extend([(a, middle), (middle, b)]);
        }
    }
    ring.iter().zip(&keep).take(contour.len()).filter(|(_, keep)| **keep).map(|(&p, _)| p).collect()
}

/// The leftmost lowest point, and how many points after it the farthest one follows.
fn anchors(contour: &[Point]) -> Option<(usize, usize)> {
    if contour.len() < 3 {
        return None;
    }
    let start = (0..contour.len()).min_by_key(|&i| (contour[i].x, contour[i].y))?;
    let from = contour[start];
    let squared = |p: Point| i64::from(p.x - from.x).pow(2) + i64::from(p.y - from.y).pow(2);
    let far = (1..contour.len()).max_by_key(|&i| (squared(contour[(start + i) % contour.len()]), usize::MAX - i))?;
    Some((start, far))
}

/// The point strictly between `a` and `b` that lies farthest from their line, if beyond the tolerance.
fn farthest(ring: &[Point], a: usize, b: usize, tolerance: f64) -> Option<usize> {
    let (from, to) = (ring[a], ring[b]);
    let (dx, dy) = (f64::from(to.x - from.x), f64::from(to.y - from.y));
    let length2 = dx * dx + dy * dy;
    let off = |p: Point| {
        let (x, y) = (f64::from(p.x - from.x), f64::from(p.y - from.y));
        // Beyond the ends the distance to the end counts, else a fold back along the line would vanish.
        let t = if length2 > 0.0 { ((x * dx + y * dy) / length2).clamp(0.0, 1.0) } else { 0.0 };
        (x - t * dx).hypot(y - t * dy)
    };
    let mut best = (tolerance, None);
    for (i, &point) in ring.iter().enumerate().take(b).skip(a + 1) {
        let distance = off(point);
        if distance > best.0 {
            best = (distance, Some(i));
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
        let got = simplified(&points.map(|(x, y)| Point::new(x, y)));
        let wanted = [(0, 0), (100_000, 0), (100_000, 100_000), (0, 100_000)].map(|(x, y)| Point::new(x, y));
        assert_eq!(got, wanted);
    }
}
