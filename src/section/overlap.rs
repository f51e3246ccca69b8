//! Outlines that cross each other or lie within each other, as where limbs of a model run into one another: what they enclose together.
//!
//! The side of a point is told by the nearest segment, and its distance is that from it: neither is right where that segment lies within
//! another shell. Such a cut, rare, is made anew as the border of all that is wound around at least once, on the grid of [`polygons`].

use hashbrown::HashMap;

use super::grid::{PlanePoint, Segment, Segments, to_segment};
use super::polygons::{self, UNITS_PER_MM, units};

/// Twice the area of a triangle that may as well be a line, mm².
const UNSURE: f64 = 1e-9;

/// Segments nearer to each other than this may touch, mm.
const TOUCHING_MM: f64 = 1e-6;

/// Whether two of the segments cross.
pub(super) fn cross(segments: &Segments) -> bool {
    any_pair(segments, 0.0, crosses)
}

/// One segment of each closed curve where no two segments touch but those that follow each other, and so no curve crosses itself or another:
/// then whatever lies beside one segment of a curve lies beside all of it. `None` where they do, or where a curve is not closed.
pub(super) fn apart(segments: &Segments) -> Option<Vec<Segment>> {
    if any_pair(segments, TOUCHING_MM, touches) {
        return None;
    }
    let all = segments.all();
    let key = |p: PlanePoint| p.map(|v| (v + 0.0).to_bits());
    let mut next = HashMap::with_capacity(all.len());
    for (k, segment) in all.iter().enumerate() {
        if next.insert(key(segment[0]), k).is_some() {
            return None;
        }
    }
    let (mut seen, mut curves) = (vec![false; all.len()], Vec::new());
    for first in 0..all.len() {
        let mut at = first;
        while !seen[at] {
            seen[at] = true;
            at = *next.get(&key(all[at][1]))?;
            if at == first {
                curves.push(all[first]);
            }
        }
    }
    Some(curves)
}

/// Whether `are` says yes to two segments that share a cell and whose boxes are no farther apart than `mm`.
fn any_pair(segments: &Segments, mm: f64, are: impl Fn(Segment, Segment) -> bool) -> bool {
    let [columns, rows] = segments.count();
    let mut here: Vec<Boxed> = Vec::new();
    (0..columns * rows).any(|cell| {
        here.clear();
        here.extend(segments.members(cell).map(|segment| Boxed::of(*segment, mm)));
        here.iter()
            .enumerate()
            .any(|(k, one)| here[k + 1..].iter().any(|other| one.meets(other) && are(one.segment, other.segment)))
    })
}

/// A segment with its box: nearly all pairs are told apart by these.
struct Boxed {
    low: PlanePoint,
    /// With what they may be apart.
    high: PlanePoint,
    segment: Segment,
}

impl Boxed {
    fn of(segment: Segment, mm: f64) -> Self {
        let [a, b] = segment;
        let low = [0, 1].map(|axis: usize| a[axis].min(b[axis]));
        let high = [0, 1].map(|axis: usize| a[axis].max(b[axis]) + mm);
        Self { low, high, segment }
    }

    fn meets(&self, other: &Self) -> bool {
        let [one, two] = [self, other];
        !(one.high[0] < two.low[0] || two.high[0] < one.low[0] || one.high[1] < two.low[1] || two.high[1] < one.low[1])
    }
}

/// Whether two segments whose boxes meet may touch elsewhere than where one follows the other.
fn touches([a, b]: Segment, [p, q]: Segment) -> bool {
    // The end that one leaves the other by must lead away from it: all do that turn by no more than a right angle.
    let returns = |from: PlanePoint, middle: PlanePoint, to: PlanePoint| {
        !goes_on(from, middle, to)
            && (to_segment(to, [from, middle]) <= TOUCHING_MM || to_segment(from, [middle, to]) <= TOUCHING_MM)
    };
    match (b == p, q == a) {
        (true, true) => true,
        (true, false) => returns(a, b, q),
        (false, true) => returns(p, q, b),
        (false, false) => {
            let ends = [to_segment(a, [p, q]), to_segment(b, [p, q]), to_segment(p, [a, b]), to_segment(q, [a, b])];
            crosses([a, b], [p, q]) || ends.iter().any(|mm| *mm <= TOUCHING_MM)
        }
    }
}

/// Whether the way from one point to the next and on to a third turns by no more than a right angle, and both stretches are longer than what may touch.
fn goes_on(from: PlanePoint, middle: PlanePoint, to: PlanePoint) -> bool {
    let (u, v) = ([middle[0] - from[0], middle[1] - from[1]], [to[0] - middle[0], to[1] - middle[1]]);
    let dot = |a: PlanePoint, b: PlanePoint| a[0] * b[0] + a[1] * b[1];
    let least = TOUCHING_MM * TOUCHING_MM;
    dot(u, v) >= 0.0 && dot(u, u) > least && dot(v, v) > least
}

/// The border of what closed curves of segments wind around at least once, material to the left; `None` where they are not closed.
pub(super) fn enclosed(segments: &[Segment]) -> Option<Vec<Segment>> {
    let contours = contours(segments)?;
    let border = polygons::positive(&contours);
    let mm = |p: &polygons::GridPoint| [f64::from(p.x) / UNITS_PER_MM, f64::from(p.y) / UNITS_PER_MM];
    let mut all = Vec::new();
    for ring in border.iter().flatten() {
        let next = ring.iter().cycle().skip(1);
        all.extend(ring.iter().zip(next).map(|(a, b)| [mm(a), mm(b)]));
    }
    Some(all)
}

/// The closed curves, on the grid. Segments follow each other where they meet to the last bit.
fn contours(segments: &[Segment]) -> Option<Vec<polygons::Contour>> {
    let key = |p: PlanePoint| p.map(|v| (v + 0.0).to_bits());
    let mut from: HashMap<[u64; 2], Vec<usize>> = HashMap::new();
    segments.iter().enumerate().for_each(|(k, segment)| from.entry(key(segment[0])).or_default().push(k));
    let mut contours = Vec::new();
    for first in 0..segments.len() {
        let start = key(segments[first][0]);
        if !from.get_mut(&start).is_some_and(|there| take(there, first)) {
            continue;
        }
        let (mut contour, mut at) = (Vec::new(), first);
        loop {
            let [here, next] = segments[at];
            contour.push(polygons::GridPoint::new(units(here[0]), units(here[1])));
            if key(next) == start {
                break;
            }
            at = from.get_mut(&key(next))?.pop()?;
        }
        contours.push(contour);
    }
    Some(contours)
}

/// Takes `one` out; whether it was there.
fn take(of: &mut Vec<usize>, one: usize) -> bool {
    of.iter().position(|there| *there == one).map(|place| of.swap_remove(place)).is_some()
}

/// Whether two segments cross each other, not at an end; their boxes meet.
fn crosses([a, b]: Segment, [p, q]: Segment) -> bool {
    let side = |from: PlanePoint, to: PlanePoint, at: PlanePoint| {
        (to[0] - from[0]) * (at[1] - from[1]) - (to[1] - from[1]) * (at[0] - from[0])
    };
    let apart = |one: f64, other: f64| one > UNSURE && other < -UNSURE || one < -UNSURE && other > UNSURE;
    apart(side(a, b, p), side(a, b, q)) && apart(side(p, q, a), side(p, q, b))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::super::Section;
    use super::*;
    use crate::geom::SplitMix64;

    /// A rectangle, anticlockwise.
    fn rectangle([x0, y0]: PlanePoint, [x1, y1]: PlanePoint) -> Vec<Segment> {
        let corners = [[x0, y0], [x1, y0], [x1, y1], [x0, y1]];
        (0..4).map(|k| [corners[k], corners[(k + 1) % 4]]).collect()
    }

    /// A ring of some corners, now and then clockwise; with its corners on whole numbers half of the time, so that many touch.
    fn ring(numbers: &mut SplitMix64) -> Vec<Segment> {
        let count = 3 + numbers.below(9);
        let middle = [(); 2].map(|()| 8.0 * numbers.unit());
        let (wide, whole, turns) = (0.2 + 6.0 * numbers.unit(), numbers.unit() < 0.5, numbers.unit() < 0.2);
        let corner = |k: usize| {
            let turn = TAU * (k % count) as f64 / count as f64 * if turns { -1.0 } else { 1.0 };
            let at = [middle[0] + wide * turn.cos(), middle[1] + wide * turn.sin()];
            if whole { at.map(f64::round) } else { at }
        };
        (0..count).map(|k| [corner(k), corner(k + 1)]).filter(|[a, b]| a != b).collect()
    }

    #[test]
    fn curves_that_keep_apart_are_told_by_one_segment_each() {
        let (mut told, mut overlapping) = (0, 0);
        for seed in 0..4000 {
            let mut numbers = SplitMix64::seeded(seed);
            let count = 1 + numbers.below(4);
            let mut all: Vec<Segment> = (0..count).flat_map(|_| ring(&mut numbers)).collect();
            if numbers.unit() < 0.1 {
                all.pop();
            }
            let section = Section::of(all);
            let overlaps = section.overlaps(section.segments());
            if let Some(curves) = apart(section.parts()) {
                assert_eq!(section.overlaps(&curves), overlaps, "{seed}");
                assert!(!cross(section.parts()) && curves.len() <= count, "{seed}");
                (told, overlapping) = (told + 1, overlapping + usize::from(overlaps));
            }
        }
        assert!(told > 800 && overlapping > 100 && told < 3200, "{told} {overlapping}");
    }

    #[test]
    fn where_shells_overlap_there_is_no_border() {
        // Two that overlap by 0.07 mm, as the legs of a scanned animal; and one within the other.
        for second in [[[9.93, 2.0], [20.0, 8.0]], [[3.0, 2.0], [7.0, 8.0]]] {
            let both = Section::new([rectangle([0.0; 2], [10.0; 2]), rectangle(second[0], second[1])].concat());
            for (p, distance) in
                [([9.95, 5.0], None), ([5.0, 5.0], None), ([5.0, 0.5], Some(-0.5)), ([5.0, -0.3], Some(0.3))]
            {
                let found = both.signed_distance(p);
                match distance {
                    Some(wanted) => assert!((found - wanted).abs() < 1e-3, "{p:?}: {found}"),
                    None => assert!(found < -0.04, "{p:?}: {found}"),
                }
            }
            let area_mm2 = if second[0][0] > 9.0 { 160.0 } else { 100.0 };
            assert!((both.area() - area_mm2).abs() < 1e-2, "{}", both.area());
        }
        // One within the other that is smaller than a cell of the grid, and touches it at a point.
        for size in [0.05, 0.3, 0.9] {
            let large = [[0.0, 0.0], [10.0, 0.0], [10.0, 5.0], [10.0, 10.0], [0.0, 10.0]];
            let small = [[10.0, 5.0], [10.0 - size, 5.0 + size / 3.0], [10.0 - size, 5.0 - size / 3.0]];
            let ring = |points: &[PlanePoint]| -> Vec<Segment> {
                (0..points.len()).map(|k| [points[k], points[(k + 1) % points.len()]]).collect()
            };
            let both = Section::new([ring(&large), ring(&small)].concat());
            let found = both.signed_distance([10.0 - size - 0.1, 5.0]);
            assert!((found + size + 0.1).abs() < 1e-3, "{size}: {found}");
        }
        // What only touches stays as it is, to the bit.
        let apart = [rectangle([0.0; 2], [10.0; 2]), rectangle([10.0, 0.0], [20.0, 10.0])].concat();
        assert_eq!(Section::new(apart.clone()).segments(), apart);
    }
}
