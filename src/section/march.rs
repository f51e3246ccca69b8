//! A way through the plane, looked at so closely that nothing is passed over: steps as long as what is asked for is away.

use super::{PlanePoint, Segment};

/// Where it is nearer than this, mm, so far is gone on.
const FINEST_MM: f64 = 0.02;
/// Sections tell distances up to 2 mm; so far is gone on at most.
const LONGEST_MM: f64 = 1.0;

/// `measure` along the way from `a` to `b`, as lengths from `a` (mm) with what was measured there; both ends are among them. It must change
/// by no more than the way does, as a distance; its sign then changes nowhere for longer than 0.02 mm unseen.
pub fn march([a, b]: Segment, measure: impl Fn(PlanePoint) -> f64) -> impl Iterator<Item = (f64, f64)> {
    let length = (b[0] - a[0]).hypot(b[1] - a[1]);
    let mut next = Some(0.0);
    std::iter::from_fn(move || {
        let t: f64 = next?;
        let share = if length > 0.0 { t / length } else { 0.0 };
        let found = measure([a[0] + (b[0] - a[0]) * share, a[1] + (b[1] - a[1]) * share]);
        next = (t < length).then(|| (t + found.abs().clamp(FINEST_MM, LONGEST_MM)).min(length));
        Some((t, found))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_post_beside_the_way_is_seen_and_both_ends_are_looked_at() {
        // A post of 0.03 mm on the way, and its distance.
        let measure = |p: PlanePoint| (p[0] - 7.3).hypot(p[1]) - 0.03;
        let ends = [[0.0, 0.0], [10.0, 0.0]];
        let seen: Vec<(f64, f64)> = march(ends, measure).collect();
        assert_eq!((seen[0].0, seen[seen.len() - 1].0), (0.0, 10.0));
        assert!(seen.iter().any(|(_, found)| *found < 0.0), "{seen:?}");
        assert!(seen.len() < 60, "{}", seen.len());
        assert_eq!(march([[1.0, 1.0]; 2], |_| 5.0).collect::<Vec<_>>(), [(0.0, 5.0)]);
    }
}
