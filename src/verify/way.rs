//! Lines as their pieces: stretches of them, sides, places along them, and whether they go straight. Places are the machine's, mm.

use crate::geom::Vec3;

/// Spacing of the places looked at along a line, mm.
pub(super) const SAMPLE_MM: f64 = 0.3;
/// A span is straight that is no longer than so many times the way between its ends, and a line's width.
const STRAIGHT: f64 = 1.1;
/// Pieces of a line that differ in direction by less than this (cosine; a degree) are one side.
const SAME_WAY: f64 = 0.99985;

/// A line, as its pieces.
pub(super) type Way = Vec<[Vec3; 2]>;

/// Whether a way of so many mm goes nearly straight between its ends, for a line so wide.
pub(super) fn is_nearly_straight(mm: f64, [from, to]: &[Vec3; 2], width: f64) -> bool {
    mm <= STRAIGHT * (to - from).norm() + width
}

/// The pieces of a way between two lengths along it, mm; where the first is the greater one, on from the way's end at its beginning.
pub(super) fn stretch_of(way: &[[Vec3; 2]], [from, to]: [f64; 2]) -> Way {
    let between = |low: f64, high: f64| {
        let mut travelled = 0.0;
        way.iter().filter_map(move |[a, b]| {
            let (start, length) = (travelled, (b - a).norm());
            travelled += length;
            let [first, last] = [low, high].map(|at| ((at - start) / length).clamp(0.0, 1.0));
            (length > 0.0 && first < last).then(|| [first, last].map(|t| a + (b - a) * t))
        })
    };
    if from <= to {
        between(from, to).collect()
    } else {
        between(from, f64::INFINITY).chain(between(0.0, to)).collect()
    }
}

/// The longest straight stretch of a way, mm.
pub(super) fn longest_side(way: &[[Vec3; 2]]) -> f64 {
    let (mut longest, mut side, mut along) = (0.0_f64, 0.0, Vec3::zeros());
    for [from, to] in way {
        let (length, direction) = ((to - from).norm(), (to - from).normalize());
        side = if direction.dot(&along) > SAME_WAY { side + length } else { length };
        (longest, along) = (longest.max(side), direction);
    }
    longest
}

/// Places on a way, no farther apart than samples are.
pub(super) fn places_on(way: &[[Vec3; 2]]) -> impl Iterator<Item = Vec3> + '_ {
    way.iter().flat_map(|[a, b]| {
        let count = ((b - a).norm() / SAMPLE_MM).ceil().max(1.0);
        (0..count as usize).map(move |k| a + (b - a) * ((k as f64 + 0.5) / count))
    })
}
