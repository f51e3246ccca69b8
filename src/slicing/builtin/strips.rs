//! Narrow solid pieces, as between the walls of a box: filled by lines along them.
//!
//! Rows across a strip turn at every pitch: a box of 3 mm walls has three times the moves, and half as much time again. Lines along its
//! border, one inside the other, are walls by another name, and the beads in the middle are as wide as what they leave. Grid units of 0.1
//! micrometres where not mm.

use std::collections::HashMap;
use std::f64::consts::PI;
use std::sync::{Arc, Mutex, PoisonError};

use super::Line;
use super::hatch::Lattice;
use super::region::{
    GridPoint, Region, Shape, UNITS_PER_MM, area_mm2, distance_mm, mm, opened, pairs, perimeter_mm, signed_area_mm2,
    units,
};
use super::walls::{Bead, concentric};
use crate::section::simplify::simplified;

/// A strip is narrower than so many lines, everywhere.
const STRIP_LINES: f64 = 5.0;
/// The longest side of a straight one is more than this of its border.
const STRAIGHT: f64 = 0.35;
/// Lines along either border of the widest strip.
const DEEPEST: u32 = 3;
/// So much of a strip its lines may leave, points and crumbs, and so much more or less of it they may cover.
const MOST_LEFT: f64 = 0.02;
const MOST_OFF: f64 = 0.03;
/// How far a line may leave its course, and how much wider or narrower a leg may be than what it replaces, mm.
const COURSE_MM: f64 = 0.015;
const CHANGE_MM: f64 = 0.05;
/// So much longer may what a leg replaces be.
const MOST_BENT: f64 = 1.01;
/// Shapes that are kept for the layers above, at most: what differs in each layer takes no more memory for it.
const KNOWN: usize = 256;

/// Whole rows along a strip, and otherwise at `angle`.
pub(super) fn fitted(shape: &Shape, angle: f64, line: &Line) -> Lattice {
    let (whole, pitch) = (vec![shape.clone()], f64::from(line.spacing));
    let Some(along) = along_strip(shape, line) else { return Lattice::fitted(&whole, angle, pitch) };
    // A corner that sticks out at a strip's end would have a row more, and the outer ones on the border.
    let body = opened(&whole, line.width / 2);
    Lattice::fitted(if body.is_empty() { &whole } else { &body }, along, pitch)
}

/// The direction of a straight strip a few lines wide: across it there would be more turns than line.
fn along_strip(shape: &Shape, line: &Line) -> Option<f64> {
    let [ring] = &shape[..] else { return None };
    let longest = pairs(ring).max_by(|a, b| distance_mm(a.0, a.1).total_cmp(&distance_mm(b.0, b.1)))?;
    let around = perimeter_mm(ring);
    let width_mm = 2.0 * signed_area_mm2(ring) / around;
    let is_strip = width_mm < STRIP_LINES * line.spacing_mm && distance_mm(longest.0, longest.1) > STRAIGHT * around;
    let [x, y] = [longest.1.x - longest.0.x, longest.1.y - longest.0.y].map(f64::from);
    is_strip.then(|| y.atan2(x).rem_euclid(PI))
}

/// The lines along a strip, shared by the layers that have it; `None` for what is none.
type Along = Option<Arc<[Bead]>>;

/// The strips of a part: layers that are alike have the same ones.
#[derive(Default)]
pub(super) struct Strips {
    /// By shape and width of a line.
    known: Mutex<HashMap<(Shape, i32), Along>>,
}

impl Strips {
    /// The lines along a strip; `None` for what is none, for what such lines do not fill, and where they have more than `most` corners and ends.
    pub(super) fn along(&self, shape: &Shape, line: &Line, most: usize) -> Along {
        let beads = may_be_strip(shape, line, most).then(|| self.once(shape, line)).flatten();
        beads.filter(|beads| beads.iter().map(|bead| bead.points.len() + 1).sum::<usize>() <= most)
    }

    fn once(&self, shape: &Shape, line: &Line) -> Along {
        let known = || self.known.lock().unwrap_or_else(PoisonError::into_inner);
        let key = (shape.clone(), line.width);
        if let Some(beads) = known().get(&key) {
            return beads.clone();
        }
        let beads: Along = strip(shape, line).map(Into::into);
        let mut known = known();
        if known.len() < KNOWN {
            known.insert(key, beads.clone());
        }
        beads
    }
}

/// Whether it is worth a try: what lines along the border cost is about half of its corners for each line from side to side.
fn may_be_strip(shape: &Shape, line: &Line, most: usize) -> bool {
    let around: f64 = shape.iter().map(|ring| perimeter_mm(ring)).sum();
    let mean_lines = 2.0 * area_mm2(&vec![shape.clone()]) / around / line.spacing_mm;
    // Somewhere it is as wide as its mean.
    if mean_lines >= STRIP_LINES {
        return false;
    }
    let corners: usize = shape.iter().map(|ring| simplified(ring, COURSE_MM * UNITS_PER_MM).len()).sum();
    mean_lines.round().max(1.0) * corners as f64 / 2.0 <= most as f64
}

/// The lines along a strip.
fn strip(shape: &Shape, line: &Line) -> Option<Vec<Bead>> {
    let region: Region = vec![shape.clone()];
    if !opened(&region, units(STRIP_LINES * line.spacing_mm) / 2).is_empty() {
        return None;
    }
    let area = area_mm2(&region);
    let (beads, left) = concentric(shape, line, DEEPEST);
    let covered: f64 = beads.iter().map(|bead| covered_mm2(bead, line)).sum();
    let fills = area_mm2(&left) <= MOST_LEFT * area && (covered / area - 1.0).abs() <= MOST_OFF;
    fills.then(|| beads.iter().map(|bead| coarser(bead, line)).collect())
}

/// The bead with as few legs as its course and its widths allow; its plastic stays.
///
/// A wall's widths are kept to 0.005 mm (`walls`), since its surface is seen. In a strip that would be a leg for each 0.15 mm, more than rows have.
fn coarser(bead: &Bead, line: &Line) -> Bead {
    let count = bead.points.len();
    let points = |leg: usize| [bead.points[leg], bead.points[(leg + 1) % count]];
    let legs: Vec<Leg> = (0..count - usize::from(!bead.closed))
        .map(|leg| {
            let [from, to] = points(leg);
            let width = bead.widths.get(leg).copied().unwrap_or(line.width_mm);
            Leg { from, to, length_mm: distance_mm(from, to), width }
        })
        .collect();
    let (mut found, mut at) = (Vec::with_capacity(legs.len()), 0);
    while at < legs.len() {
        let mut end = at + 1;
        while end < legs.len() && merged(&legs[at..=end]).is_some() {
            end += 1;
        }
        found.push(merged(&legs[at..end]).unwrap_or(legs[at]));
        at = end;
    }
    let last = found.last().filter(|_| !bead.closed).map(|leg: &Leg| leg.to);
    Bead {
        points: found.iter().map(|leg| leg.from).chain(last).collect(),
        widths: if bead.widths.is_empty() { Vec::new() } else { found.iter().map(|leg| leg.width).collect() },
        ..*bead
    }
}

/// A straight piece of a bead.
#[derive(Clone, Copy)]
struct Leg {
    from: GridPoint,
    to: GridPoint,
    length_mm: f64,
    width: f64,
}

/// One leg for several that follow each other, as wide as they are in the mean; `None` where they turn or change their width.
fn merged(legs: &[Leg]) -> Option<Leg> {
    let [first, .., last] = legs else { return legs.first().copied() };
    let length: f64 = legs.iter().map(|leg| leg.length_mm).sum();
    let straight = distance_mm(first.from, last.to);
    let plastic: f64 = legs.iter().map(|leg| leg.length_mm * leg.width).sum();
    let width = plastic / length.max(1e-9);
    let [dx, dy] = [last.to.x - first.from.x, last.to.y - first.from.y].map(|v| mm(f64::from(v)));
    let aside = |leg: &Leg| {
        let [x, y] = [leg.from.x - first.from.x, leg.from.y - first.from.y].map(|v| mm(f64::from(v)));
        (x * dy - y * dx).abs() / straight.max(1e-9)
    };
    // A line that goes back over itself is longer than what joins its ends.
    let is_one = length <= straight * MOST_BENT
        && legs.iter().all(|leg| (leg.width - width).abs() <= CHANGE_MM && aside(leg) <= COURSE_MM);
    is_one.then_some(Leg { from: first.from, to: last.to, length_mm: straight, width })
}

/// The area that a bead covers beside others.
fn covered_mm2(bead: &Bead, line: &Line) -> f64 {
    let width =
        |leg: usize| bead.widths.get(leg).map_or(line.spacing_mm, |width| width - line.width_mm + line.spacing_mm);
    let legs = bead.points.len() - usize::from(!bead.closed);
    pairs(&bead.points).take(legs).enumerate().map(|(leg, (a, b))| distance_mm(a, b) * width(leg)).sum()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_4, TAU};

    use super::super::region::{Contour, enclosed, holds};
    use super::super::zigzag::lines;
    use super::*;

    #[test]
    fn what_sticks_out_at_a_strips_end_gives_it_no_row_more() {
        let line = Line::new(0.45, 0.2);
        // 20 x 0.82 mm, and at its ends corners of 0.2 mm beyond either side.
        let corners = [
            (0, -2000),
            (1500, 0),
            (198_500, 0),
            (200_000, -2000),
            (200_000, 10_200),
            (198_500, 8200),
            (1500, 8200),
            (0, 10_200),
        ];
        let strip = enclosed(&[corners.map(|(x, y)| GridPoint::new(x, y)).to_vec()]);
        let lattice = fitted(&strip[0], FRAC_PI_4, &line);
        let rows = lines(&strip, lattice, 0, |_| false);
        let inside: Vec<i32> = rows.iter().map(|row| row[0].y).filter(|y| (0..=8200).contains(y)).collect();
        assert!(inside.len() == 2 && inside.iter().all(|y| (1900..=6300).contains(y)), "{inside:?}");
    }

    fn ring(corners: impl IntoIterator<Item = [f64; 2]>) -> Contour {
        corners.into_iter().map(|[x, y]| GridPoint::new(units(x), units(y))).collect()
    }

    fn arc(radius: f64, count: usize) -> Vec<[f64; 2]> {
        let at = |k: usize| (TAU * k as f64 / count as f64).sin_cos();
        (0..count).map(at).map(|(sin, cos)| [30.0 + radius * cos, 30.0 + radius * sin]).collect()
    }

    fn rectangle(low: [f64; 2], high: [f64; 2]) -> Vec<[f64; 2]> {
        vec![low, [high[0], low[1]], high, [low[0], high[1]]]
    }

    fn between(outer: Vec<[f64; 2]>, inner: Vec<[f64; 2]>) -> Shape {
        enclosed(&[ring(outer), ring(inner.into_iter().rev())]).remove(0)
    }

    /// What of a shape no bead covers, and what more than one does, as shares of it: by points of a grid that lies askew.
    fn uncovered_and_doubled(shape: &Shape, beads: &[Bead], line: &Line) -> [f64; 2] {
        let apart = |p: GridPoint, a: GridPoint, b: GridPoint| {
            let [ab, ap] = [[b.x - a.x, b.y - a.y], [p.x - a.x, p.y - a.y]].map(|v| v.map(f64::from));
            let t = ((ap[0] * ab[0] + ap[1] * ab[1]) / (ab[0] * ab[0] + ab[1] * ab[1]).max(1.0)).clamp(0.0, 1.0);
            mm((ap[0] - t * ab[0]).hypot(ap[1] - t * ab[1]))
        };
        let covers = |bead: &&Bead, p: GridPoint| {
            let legs = bead.points.len() - usize::from(!bead.closed);
            pairs(&bead.points).take(legs).enumerate().any(|(leg, (a, b))| {
                let width = bead.widths.get(leg).unwrap_or(&line.width_mm) - line.width_mm + line.spacing_mm;
                apart(p, a, b) < width / 2.0
            })
        };
        let region = vec![shape.clone()];
        let (mut all, mut none, mut more) = (0.0, 0.0, 0.0);
        for (i, j) in (-150..300).flat_map(|i| (-150..300).map(move |j| (i, j))) {
            let p = GridPoint::new(1873 * i - 813 * j, 813 * i + 1873 * j);
            if holds(&region, p) {
                let count = beads.iter().filter(|bead| covers(bead, p)).count();
                all += 1.0;
                none += f64::from(u8::from(count == 0));
                more += f64::from(u8::from(count > 1));
            }
        }
        [none / all, more / all]
    }

    #[test]
    fn a_strip_of_any_width_and_course_is_covered_once_by_a_few_lines() {
        let line = Line::new(0.45, 0.2);
        for width in [0.3, 0.6, 0.82, 1.1, 1.4, 1.8] {
            let inner = rectangle([5.0 + width; 2], [45.0 - width, 25.0 - width]);
            let aside = arc(19.9 - width, 90).into_iter().map(|[x, y]| [x + 0.1, y]).collect();
            let strips = [
                ("box", between(rectangle([5.0, 5.0], [45.0, 25.0]), inner), 60),
                ("tube", between(arc(20.0, 180), arc(20.0 - width, 180)), 180),
                ("eccentric tube", between(arc(20.0, 90), aside), 180),
            ];
            for (name, shape, most) in strips {
                let beads = strip(&shape, &line).unwrap_or_else(|| panic!("{name}, {width} mm"));
                let [none, more] = uncovered_and_doubled(&shape, &beads, &line);
                assert!(none < 0.04 && more < 0.02, "{name}, {width} mm: {none} not covered, {more} doubled");
                let turns: usize = beads.iter().map(|bead| bead.points.len()).sum();
                let rings = (width / line.spacing_mm).round().max(1.0) as usize;
                assert!(turns <= most * rings, "{name}, {width} mm: {turns} legs, {} lines", beads.len());
            }
        }
    }

    #[test]
    fn what_is_wide_somewhere_is_no_strip() {
        let line = Line::new(0.45, 0.2);
        assert!(strip(&between(arc(20.0, 180), arc(17.9, 180)), &line).is_none());
        // A long arm at a block of 4 mm.
        let arm = [[5.0, 5.0], [45.0, 5.0], [45.0, 6.0], [9.0, 6.0], [9.0, 9.0], [5.0, 9.0]];
        assert!(strip(&enclosed(&[ring(arm)])[0], &line).is_none());
    }

    #[test]
    fn a_bead_of_few_legs_has_the_plastic_of_the_one_of_many() {
        let line = Line::new(0.45, 0.2);
        let count = 400;
        let points: Contour = ring((0..=count).map(|k| {
            let turn = f64::from(k) * 0.01;
            [20.0 * turn.cos(), 20.0 * turn.sin()]
        }));
        let widths: Vec<f64> = (0..count).map(|k| 0.4 + 0.1 * (f64::from(k) * 0.05).sin()).collect();
        let many = Bead { points, closed: false, depth: 1, widths };
        let few = coarser(&many, &line);
        assert!(few.points.len() < 100 && few.points.len() == few.widths.len() + 1, "{}", few.points.len());
        assert_eq!([few.points[0], few.points[few.points.len() - 1]], [many.points[0], many.points[count as usize]]);
        let [before, after] = [&many, &few].map(|bead| covered_mm2(bead, &line));
        assert!((after / before - 1.0).abs() < 1e-3, "{after} mm2, not {before}");
    }
}
