//! Runs of short straight lines as arcs, where that is as exact; micrometres, the last printed digit.
//!
//! An arc takes as many lines as keep to one circle: each corner, and the middle of each line, within [`OFF_UM`] of it. So an outline that
//! is truly made of few straight sides stays what it is, and the plastic lies where it would. A file of a round part has a tenth of the lines,
//! which matters where they go over a serial line.

use super::region::length;

/// A position in micrometres, the last printed digit.
pub(super) type Micrometres = [i64; 2];

/// How far corners and the middles of lines may lie off the circle, micrometres: as far as contours are thinned.
const OFF_UM: f64 = 12.0;
/// An arc stands for so many lines at least: fewer save nothing.
const LEAST_LINES: usize = 4;
/// An arc goes round by so much at most, radians: beyond half a turn firmwares disagree on which way is meant where its ends come close.
const MOST_TURN: f64 = 3.0;
/// Radii, micrometres: smaller than a nozzle's bore is a corner, larger than 0.5 m is straight.
const RADII_UM: [f64; 2] = [400.0, 5e5];

/// An arc from the place before it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Arc {
    pub(super) to: Micrometres,
    /// The centre, from where the arc begins.
    pub(super) centre: Micrometres,
    pub(super) clockwise: bool,
    pub(super) length_mm: f64,
}

/// One step along a way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Piece {
    /// Straight to the point of this number.
    Line(usize),
    Arc(Arc),
}

/// The way through `points`, from the first one on.
pub(super) fn fitted(points: &[Micrometres]) -> Vec<Piece> {
    let mut pieces = Vec::new();
    let mut at = 0;
    while at + 1 < points.len() {
        match longest(points, at) {
            Some((last, arc)) => {
                pieces.push(Piece::Arc(arc));
                at = last;
            }
            None => {
                at += 1;
                pieces.push(Piece::Line(at));
            }
        }
    }
    pieces
}

/// The longest arc that begins at a point, and the point where it ends.
fn longest(points: &[Micrometres], from: usize) -> Option<(usize, Arc)> {
    let mut best = None;
    let mut step = LEAST_LINES;
    while let Some(arc) = points.get(from..=from + step).and_then(arc_through) {
        best = Some((from + step, arc));
        step += 1;
    }
    best
}

/// One arc in place of all lines between these points.
fn arc_through(points: &[Micrometres]) -> Option<Arc> {
    let (first, last) = (points[0], points[points.len() - 1]);
    let middle = points[points.len() / 2];
    let centre = centre_of(first, middle, last)?;
    let to_centre = |p: [f64; 2]| [p[0] - centre[0], p[1] - centre[1]];
    let float = |p: Micrometres| p.map(|v| v as f64);
    let radius = length(to_centre(float(first)));
    let (mut turn, mut side) = (0.0, 0.0f64);
    for pair in points.windows(2) {
        let [a, b] = [float(pair[0]), float(pair[1])];
        let half = [(a[0] + b[0]) / 2.0, (a[1] + b[1]) / 2.0];
        if [b, half].iter().any(|&p| (length(to_centre(p)) - radius).abs() > OFF_UM) {
            return None;
        }
        let (u, v) = (to_centre(a), to_centre(b));
        let by = (u[0] * v[1] - u[1] * v[0]).atan2(u[0] * v[0] + u[1] * v[1]);
        if side != 0.0 && by * side <= 0.0 {
            return None;
        }
        (turn, side) = (turn + by, by);
    }
    let from_first = [centre[0] - first[0] as f64, centre[1] - first[1] as f64].map(|v| v.round() as i64);
    let fits = (RADII_UM[0]..=RADII_UM[1]).contains(&radius) && turn.abs() <= MOST_TURN;
    let arc = Arc { to: last, centre: from_first, clockwise: turn < 0.0, length_mm: radius * turn.abs() / 1000.0 };
    // Longer than its chord, or there is nothing round in it.
    (fits && arc.length_mm >= distance_mm(first, last)).then_some(arc)
}

/// The centre of the circle through three points; none where they lie on a line.
fn centre_of(a: Micrometres, b: Micrometres, c: Micrometres) -> Option<[f64; 2]> {
    let from_a = |p: Micrometres| [(p[0] - a[0]) as f64, (p[1] - a[1]) as f64];
    let ([bx, by], [cx, cy]) = (from_a(b), from_a(c));
    let twice = 2.0 * (bx * cy - by * cx);
    if twice == 0.0 {
        return None;
    }
    let (b2, c2) = (bx * bx + by * by, cx * cx + cy * cy);
    let centre = [(cy * b2 - by * c2) / twice, (bx * c2 - cx * b2) / twice];
    Some([centre[0] + a[0] as f64, centre[1] + a[1] as f64])
}

pub(super) fn distance_mm(a: Micrometres, b: Micrometres) -> f64 {
    length([b[0] - a[0], b[1] - a[1]].map(|v| v as f64)) / 1000.0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points on a circle about (50, 50) mm, from one angle to another.
    fn circle(radius_mm: f64, count: usize, from_deg: f64, to_deg: f64) -> Vec<Micrometres> {
        let at = |k: usize| (from_deg + (to_deg - from_deg) * k as f64 / count as f64).to_radians();
        let point = |angle: f64| [50.0 + radius_mm * angle.cos(), 50.0 + radius_mm * angle.sin()];
        (0..=count).map(|k| point(at(k)).map(|mm| (mm * 1000.0).round() as i64)).collect()
    }

    fn arcs(pieces: &[Piece]) -> Vec<Arc> {
        pieces.iter().filter_map(|piece| if let Piece::Arc(arc) = piece { Some(*arc) } else { None }).collect()
    }

    /// A full turn by two independent figures: the arcs' lengths, and where each of them is halfway.
    #[test]
    fn a_fine_circle_is_a_few_arcs_as_long_as_it_is_round() {
        for (to_deg, clockwise) in [(360.0, false), (-360.0, true)] {
            let points = circle(10.0, 144, 0.0, to_deg);
            let pieces = fitted(&points);
            let found = arcs(&pieces);
            assert!(found.len() == pieces.len() && found.len() <= 4, "{pieces:?}");
            let whole: f64 = found.iter().map(|arc| arc.length_mm).sum();
            assert!((whole - 20.0 * std::f64::consts::PI).abs() < 0.005, "{whole}");
            assert!(found.iter().all(|arc| arc.clockwise == clockwise));
            let mut at = points[0];
            for arc in &found {
                let centre = [at[0] + arc.centre[0], at[1] + arc.centre[1]];
                let off = |p: Micrometres| (length([(p[0] - centre[0]) as f64, (p[1] - centre[1]) as f64]) - 1e4).abs();
                assert!(off(at) < 14.0 && off(arc.to) < 14.0, "{arc:?}");
                at = arc.to;
            }
            assert_eq!(at, points[144]);
        }
    }

    /// The coarser the polygon, the farther its sides from the circle: by hand 10 mm (1 - cos(pi / n)) is 12 um at n = 64.1.
    #[test]
    fn sides_that_are_really_straight_stay_so() {
        for (sides, round) in [(12, false), (40, false), (62, false), (66, true), (144, true)] {
            let pieces = fitted(&circle(10.0, sides, 0.0, 360.0));
            assert_eq!(!arcs(&pieces).is_empty(), round, "{sides} sides");
        }
    }

    #[test]
    fn what_is_straight_or_turns_both_ways_is_no_arc_and_every_point_is_passed() {
        let line: Vec<Micrometres> = (0..20).map(|k| [k * 500, k * 250]).collect();
        assert_eq!(fitted(&line), (1..20).map(Piece::Line).collect::<Vec<_>>());
        let wave: Vec<Micrometres> = (0..20).map(|k| [k * 100, (k % 2) * 8]).collect();
        assert!(arcs(&fitted(&wave)).is_empty());
        // A straight side, a quarter round, a straight side: the lines stay, the round is one arc.
        let mut mixed = vec![[60_000, 30_000]];
        mixed.extend(circle(10.0, 40, 0.0, 90.0));
        mixed.push([30_000, 60_000]);
        let pieces = fitted(&mixed);
        assert_eq!((pieces[0], arcs(&pieces).len()), (Piece::Line(1), 1), "{pieces:?}");
        assert_eq!(pieces[pieces.len() - 1], Piece::Line(mixed.len() - 1));
        assert!(fitted(&[]).is_empty() && fitted(&[[0, 0]]).is_empty());
    }
}
