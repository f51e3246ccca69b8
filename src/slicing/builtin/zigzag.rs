//! Rows joined to zigzags along the border of what they fill.
//!
//! Each row runs from border to border. Half a pitch inside the border lies the *rail*: where the ends of two rows follow each other on
//! it, and the way between them along it is short, the rows end there and are joined by it. A row loses half a pitch of length at such
//! an end, and each joint of a pitch's length fills what two rows lost. Where a border runs slantwise to the rows every second corner of
//! such a line is sharp, and between it, the border and the next row a notch stays open: dense lines go out into it a little.

use super::hatch::{Lattice, crossings, rows};
use super::region::{Contour, GridPoint, Region, UNITS_PER_MM, distance_mm, grown, pairs};

/// Strokes shorter than this are left out, mm: an extruder cannot meter them.
const SHORTEST_MM: f64 = 0.1;
/// The longest joint, in pitches: on a border that runs nearly along the rows it would lie on one of them.
const LONGEST_JOINT: f64 = 3.0;

/// For how long a joint may lie on a row that it joins, mm: two beads in one place stand up.
const MOST_ON_ROW_MM: f64 = 1.0;

/// Rows whose pitch is at most so many times the rail's inset lie side by side: half a pitch less an overlap of up to a third of a line.
const MOST_DENSE: f64 = 6.0;
/// A line goes so far into a notch, as a share of what its round leaves open. A wedge of 20 degrees has 0.77 % gaps and 1.4 % twice
/// without, 0.49 and 2.1 with a share of 0.35, 0.46 and 2.3 with 0.5.
const INTO_NOTCH: f64 = 0.35;
/// And no farther than so many half pitches.
const DEEPEST: f64 = 2.0;
/// It stays where it is for less than this, grid units: 0.15 mm, corners of more than 37 degrees with lines of 0.45 mm. In those of 45, a
/// cube's, it would double four times what it fills.
const LEAST_NOTCH: f64 = 1500.0;

/// Lines across the region, joined where the way along the rail, `inset` grid units inside the border, is short and `allowed`.
pub(super) fn lines(
    region: &Region,
    lattice: Lattice,
    inset: i32,
    allowed: impl Fn(&[GridPoint]) -> bool,
) -> Vec<Contour> {
    let mut spans = Vec::new();
    for row in rows(region, lattice) {
        spans.extend(row.spans.iter().map(|&(from, to)| Span { row: row.index, ends: [from, to], rail: [None; 2] }));
    }
    let rail: Vec<Contour> = grown(region, -inset).into_iter().flatten().collect();
    let joints = joints(&mut spans, &rail, lattice, inset, allowed);
    let used = vec![false; spans.len()];
    Zigzag { spans, joints, rail: &rail, lattice, inset, used }.lines()
}

/// A row's line between two places of the border, in turned coordinates.
struct Span {
    row: i64,
    ends: [f64; 2],
    /// Where it meets the rail next to each end.
    rail: [Option<f64>; 2],
}

/// The way from one end of a line to one of another along the rail.
#[derive(Clone, Copy)]
struct Joint {
    /// The span's number twice, and 1 more for its second end.
    to: usize,
    /// The ring of the rail, and the sides at which the way begins and ends.
    ring: usize,
    sides: [usize; 2],
    forward: bool,
    length: f64,
}

/// Where a ring of the rail meets a row.
struct Hit {
    row: i64,
    x: f64,
    ring: usize,
    side: usize,
    /// How far along the ring, grid units.
    along: f64,
}

/// For each end of each span, the joints that begin there.
fn joints(
    spans: &mut [Span],
    rail: &[Contour],
    lattice: Lattice,
    inset: i32,
    allowed: impl Fn(&[GridPoint]) -> bool,
) -> Vec<[Option<Joint>; 2]> {
    let hits = hits(rail, lattice);
    let ends = met(spans, &hits);
    let mut found = vec![[None; 2]; 2 * spans.len()];
    let mut order: Vec<usize> = (0..hits.len()).collect();
    order.sort_by(|&a, &b| hits[a].ring.cmp(&hits[b].ring).then(hits[a].along.total_cmp(&hits[b].along)));
    for ring in order.chunk_by(|&a, &b| hits[a].ring == hits[b].ring) {
        let whole: f64 = pairs(&rail[hits[ring[0]].ring]).map(|(a, b)| length(a, b)).sum();
        for (place, &one) in ring.iter().enumerate() {
            let other = ring[(place + 1) % ring.len()];
            let (Some(from), Some(to)) = (ends[one], ends[other]) else { continue };
            let length = (hits[other].along - hits[one].along).rem_euclid(whole);
            if from / 2 == to / 2 || length > LONGEST_JOINT * lattice.pitch {
                continue;
            }
            let sides = [hits[one].side, hits[other].side];
            let joint = Joint { to, ring: hits[one].ring, sides, forward: true, length };
            let mut way = vec![lattice.point(hits[one].x, hits[one].row)];
            way.extend(joint.corners(rail));
            way.push(lattice.point(hits[other].x, hits[other].row));
            let lies = |hit: usize| runs_along(&way, lattice.row(hits[hit].row), f64::from(inset), lattice);
            if lies(one).max(lies(other)) <= MOST_ON_ROW_MM && allowed(&way) {
                found[from][0] = Some(joint);
                found[to][1] = Some(Joint { to: from, sides: [sides[1], sides[0]], forward: false, ..joint });
            }
        }
    }
    found
}

/// For how long a way lies on a row, nearer to its middle than `near` grid units, mm.
fn runs_along(way: &[GridPoint], row: f64, near: f64, lattice: Lattice) -> f64 {
    let leg = |leg: &[GridPoint]| {
        let [from, to] = [leg[0], leg[1]].map(|p| lattice.turned(p).1 - row);
        let (low, high) = (from.min(to), from.max(to));
        let held = high.min(near) - low.max(-near);
        let share = if high - low > 1e-9 { held.max(0.0) / (high - low) } else { f64::from(held >= 0.0) };
        share * distance_mm(leg[0], leg[1])
    };
    way.windows(2).map(leg).sum()
}

/// Where the rings meet the rows.
fn hits(rail: &[Contour], lattice: Lattice) -> Vec<Hit> {
    let mut found = Vec::new();
    let mut crossed = Vec::new();
    for (ring, points) in rail.iter().enumerate() {
        let mut along = 0.0;
        for (side, (a, b)) in pairs(points).enumerate() {
            crossed.clear();
            let (from, to) = (lattice.turned(a), lattice.turned(b));
            crossings(from, to, lattice, &mut crossed);
            let far = length(a, b);
            found.extend(crossed.iter().map(|&(row, x)| {
                let y = lattice.row(row);
                let share = (y - from.1) / (to.1 - from.1);
                Hit { row, x, ring, side, along: along + share * far }
            }));
            along += far;
        }
    }
    found
}

/// Which end of which span each hit stands for: of the places where a span meets the rail the first and the last; others bar the way.
fn met(spans: &mut [Span], hits: &[Hit]) -> Vec<Option<usize>> {
    let mut order: Vec<usize> = (0..hits.len()).collect();
    order.sort_by(|&a, &b| hits[a].row.cmp(&hits[b].row).then(hits[a].x.total_cmp(&hits[b].x)));
    let mut ends = vec![None; hits.len()];
    let mut next = 0;
    for (index, span) in spans.iter_mut().enumerate() {
        let before = |hit: &Hit| (hit.row, hit.x) < (span.row, span.ends[0]);
        while next < order.len() && before(&hits[order[next]]) {
            next += 1;
        }
        let first = next;
        while next < order.len() && hits[order[next]].row == span.row && hits[order[next]].x <= span.ends[1] {
            next += 1;
        }
        if next >= first + 2 {
            for (end, hit) in [(0, order[first]), (1, order[next - 1])] {
                ends[hit] = Some(2 * index + end);
                span.rail[end] = Some(hits[hit].x);
            }
        }
    }
    ends
}

impl Joint {
    /// The rail's corners on the way.
    fn corners(&self, rail: &[Contour]) -> Vec<GridPoint> {
        let ring = &rail[self.ring];
        let count = ring.len();
        let [from, to] = self.sides;
        if from == to && self.length <= length(ring[from], ring[(from + 1) % count]) {
            return Vec::new();
        }
        let steps = if self.forward { (to + count - from) % count } else { (from + count - to) % count };
        let steps = if steps == 0 { count } else { steps };
        match self.forward {
            true => (1..=steps).map(|k| ring[(from + k) % count]).collect(),
            false => (0..steps).map(|k| ring[(from + count - k) % count]).collect(),
        }
    }
}

/// Spans on their way to become lines.
struct Zigzag<'a> {
    spans: Vec<Span>,
    joints: Vec<[Option<Joint>; 2]>,
    rail: &'a [Contour],
    lattice: Lattice,
    inset: i32,
    used: Vec<bool>,
}

impl Zigzag<'_> {
    fn lines(mut self) -> Vec<Contour> {
        let mut found = Vec::new();
        for span in 0..self.spans.len() {
            if self.used[span] {
                continue;
            }
            self.used[span] = true;
            let there = self.followed(2 * span + 1);
            let mut line = self.followed(2 * span);
            line.reverse();
            line.extend(there);
            line.dedup();
            if line.windows(2).map(|leg| distance_mm(leg[0], leg[1])).sum::<f64>() >= SHORTEST_MM {
                found.push(line);
            }
        }
        found
    }

    /// From the end of a line over joint after joint to a free end.
    fn followed(&mut self, mut end: usize) -> Contour {
        let mut line = Contour::new();
        while let Some(joint) = self.next(end) {
            line.extend(self.joined(end, &joint));
            self.used[joint.to / 2] = true;
            end = joint.to ^ 1;
        }
        line.push(self.border_end(end));
        line
    }

    /// The line from the row of `end` over a joint to the next row.
    fn joined(&self, end: usize, joint: &Joint) -> Contour {
        let mut way: Contour = self.rail_end(end).into_iter().collect();
        way.extend(joint.corners(self.rail));
        way.extend(self.rail_end(joint.to));
        let last = way.len() - 1;
        let there = self.notch_beside(joint.to, way[last], way[last.saturating_sub(1)]);
        let here = self.notch_beside(end, way[0], way[1.min(last)]);
        way.splice(last..last, there);
        way.splice(1..1, here);
        way
    }

    /// Where a line goes on from a row's end, `corner`, before it turns to `next`, the joint's: outwards between the two. Their notch is
    /// a sharp corner that the round of the line leaves open by `1 / sin - 1` of half a pitch, with half the corner's angle.
    fn notch_beside(&self, end: usize, corner: GridPoint, next: GridPoint) -> Option<GridPoint> {
        let radius = self.lattice.pitch / 2.0;
        if self.lattice.pitch > MOST_DENSE * f64::from(self.inset) || corner == next {
            return None;
        }
        let (sin, cos) = self.lattice.angle.sin_cos();
        let out = if end % 2 == 1 { [cos, sin] } else { [-cos, -sin] };
        let far = length(corner, next);
        let on = [next.x - corner.x, next.y - corner.y].map(|v| f64::from(v) / far);
        // Of the angle between the way back along the row and the joint.
        let half_sin = ((1.0 + out[0] * on[0] + out[1] * on[1]) / 2.0).max(0.0).sqrt();
        let by = (INTO_NOTCH * radius * (1.0 / half_sin - 1.0)).min(DEEPEST * radius);
        let bisector = [out[0] - on[0], out[1] - on[1]];
        let long = (bisector[0].powi(2) + bisector[1].powi(2)).sqrt();
        (by > LEAST_NOTCH).then(|| {
            let [x, y] = bisector.map(|v| (v / long * by).round() as i32);
            GridPoint::new(corner.x + x, corner.y + y)
        })
    }

    /// The joint to take: to the lowest row, so that nothing is left behind, and the shortest of these.
    fn next(&self, end: usize) -> Option<Joint> {
        let free = self.joints[end].iter().flatten().filter(|joint| !self.used[joint.to / 2]);
        let row = |joint: &Joint| self.spans[joint.to / 2].row;
        free.min_by(|a, b| row(a).cmp(&row(b)).then(a.length.total_cmp(&b.length))).copied()
    }

    fn border_end(&self, end: usize) -> GridPoint {
        let span = &self.spans[end / 2];
        self.lattice.point(span.ends[end % 2], span.row)
    }

    fn rail_end(&self, end: usize) -> Option<GridPoint> {
        let span = &self.spans[end / 2];
        span.rail[end % 2].map(|x| self.lattice.point(x, span.row))
    }
}

fn length(a: GridPoint, b: GridPoint) -> f64 {
    distance_mm(a, b) * UNITS_PER_MM
}

#[cfg(test)]
mod tests {
    use super::super::region::{enclosed, holds};
    use super::*;

    fn square(x0: i32, x1: i32) -> Contour {
        [(x0, x0), (x1, x0), (x1, x1), (x0, x1)].map(|(x, y)| GridPoint::new(x, y)).to_vec()
    }

    /// Half a pitch, and a little so that the outermost rows lie inside the rail.
    const INSET: i32 = 1_900;

    fn all(region: &Region, lattice: Lattice) -> Vec<Contour> {
        lines(region, lattice, INSET, |_| true)
    }

    fn length_mm(line: &[GridPoint]) -> f64 {
        line.windows(2).map(|leg| distance_mm(leg[0], leg[1])).sum()
    }

    #[test]
    fn lines_cover_a_square_at_any_angle_as_densely_as_told() {
        let region = enclosed(&[square(0, 100_000)]);
        for angle in [0.0, 0.4, 0.785, 1.57, 2.4] {
            let lines = all(&region, Lattice::fitted(&region, angle, 4000.0));
            assert!(lines.len() <= 5, "{angle}: {} lines, one and what is left in the corners", lines.len());
            let length: f64 = lines.iter().map(|line| length_mm(line)).sum();
            // What goes into notches is more than the area asks for; lines are as much narrower.
            assert!((length * 0.4 - 100.0).abs() < 3.0, "{angle}: {length} mm");
            let apart = lines.iter().flat_map(|line| line.windows(2)).map(|leg| distance_mm(leg[0], leg[1]));
            assert!(apart.clone().filter(|mm| *mm < 1.2).count() > 20, "rows are joined");
        }
    }

    #[test]
    fn no_joint_is_made_where_it_is_not_allowed_or_long() {
        let region = enclosed(&[square(0, 100_000)]);
        let lattice = Lattice::fitted(&region, 0.0, 4000.0);
        assert_eq!(lines(&region, lattice, INSET, |_| false).len(), 25);
        assert_eq!(all(&region, lattice).len(), 1);
        // Sides at 5 degrees to the rows: 11 pitches from end to end.
        let wedge = [(0, 0), (200_000, -17_500), (200_000, 17_500)].map(|(x, y)| GridPoint::new(x, y)).to_vec();
        let wedge = enclosed(&[wedge]);
        let joined = all(&wedge, Lattice::fitted(&wedge, 0.0, 4000.0));
        assert!(joined.iter().all(|line| line.windows(2).all(|leg| {
            let (across, along) = ((leg[1].y - leg[0].y).abs(), (leg[1].x - leg[0].x).abs());
            across == 0 || along < 12_000
        })));
    }

    #[test]
    fn no_joint_lies_on_a_row() {
        // Sparse rows, 2.25 mm apart, and a side at 2 to 30 degrees to them: its joints are short enough, and run beside the row.
        for deg in [2.0f64, 5.0, 8.0, 20.0, 30.0] {
            let rise = (300_000.0 * deg.to_radians().tan()) as i32;
            let slant = [(0, 0), (300_000, rise), (300_000, rise + 90_000), (0, 90_000)];
            let region = enclosed(&[slant.map(|(x, y)| GridPoint::new(x, y)).to_vec()]);
            let lattice = Lattice::common(0.0, 22_500.0);
            for line in all(&region, lattice) {
                for leg in line.windows(2).filter(|leg| (leg[1].y - leg[0].y) != 0) {
                    let from = lattice.turned(leg[0]).1;
                    assert!(runs_along(leg, from, f64::from(INSET), lattice) <= 1.0, "{deg}: {leg:?}");
                }
            }
            // The upright sides join them in any case.
            assert!(all(&region, lattice).len() < lines(&region, lattice, INSET, |_| false).len(), "{deg}");
        }
    }

    #[test]
    fn dense_lines_go_out_into_sharp_notches_and_no_farther_than_the_border_s_line() {
        // A side at 20 degrees to the rows: a corner of 10 degrees' half angle is left open by 4.8 half pitches, 0.95 mm.
        let rise = (200_000.0 * 20f64.to_radians().tan()) as i32;
        let slant = [(0, 0), (200_000, rise), (200_000, rise + 60_000), (0, 60_000)];
        let region = enclosed(&[slant.map(|(x, y)| GridPoint::new(x, y)).to_vec()]);
        let lattice = Lattice::fitted(&region, 0.0, 4000.0);
        let outside = |inset: i32| {
            let inside = grown(&region, -inset);
            let away = |p: GridPoint| {
                let from = |(a, b): (GridPoint, GridPoint)| {
                    let along = [f64::from(b.x - a.x), f64::from(b.y - a.y)].map(|v| v / length(a, b));
                    let [x, y] = [p.x - a.x, p.y - a.y].map(f64::from);
                    let t = (x * along[0] + y * along[1]).clamp(0.0, length(a, b));
                    (x - t * along[0]).hypot(y - t * along[1])
                };
                inside.iter().flatten().flat_map(|ring| pairs(ring)).map(from).fold(f64::INFINITY, f64::min)
            };
            let lines = lines(&region, lattice, inset, |_| true);
            let points = lines.iter().flat_map(|line| &line[1..line.len() - 1]).copied();
            points.filter(|p| !holds(&inside, *p)).map(away).fold(0.0, f64::max)
        };
        let reached = outside(INSET);
        // 0.35 of 4.8 half pitches along a bisector of 10 degrees to the border.
        let wanted = 0.35 * 4.76 * lattice.pitch / 2.0 * 10f64.to_radians().sin();
        assert!((reached - wanted).abs() < 0.1 * wanted, "{reached} {wanted}");
        assert!(outside(INSET / 5) < 5.0, "rows with an inset of a tenth are sparse");
    }

    #[test]
    fn a_fitted_lattice_has_its_outer_lines_half_a_pitch_inside() {
        for (low, high) in [(0, 10_000), (3_333, 15_000), (-777, 4_100)] {
            let region = enclosed(&[square(low, high)]);
            let lattice = Lattice::fitted(&region, 0.0, 4000.0);
            let lines = lines(&region, lattice, INSET, |_| false);
            let rows: Vec<f64> = lines.iter().map(|line| f64::from(line[0].y)).collect();
            let wanted = (f64::from(high - low) / 4000.0).round();
            assert_eq!(rows.len() as f64, wanted);
            assert!((rows[0] - f64::from(low) - lattice.pitch / 2.0).abs() < 1.0, "{rows:?}");
            assert!((f64::from(high) - rows[rows.len() - 1] - lattice.pitch / 2.0).abs() < 1.0, "{rows:?}");
        }
    }

    #[test]
    fn no_line_crosses_a_hole() {
        let mut hole = square(40_000, 60_000);
        hole.reverse();
        let region = enclosed(&[square(0, 100_000), hole]);
        let rows = lines(&region, Lattice::common(0.0, 5000.0), INSET, |_| false);
        let length: f64 = rows.iter().map(|line| length_mm(line)).sum();
        assert!((length - (20.0 * 10.0 - 4.0 * 2.0)).abs() < 1e-6, "{length}");
        for leg in lines(&region, Lattice::common(0.0, 5000.0), INSET, |_| true).iter().flat_map(|line| line.windows(2))
        {
            let middle = GridPoint::new((leg[0].x + leg[1].x) / 2, (leg[0].y + leg[1].y) / 2);
            assert!(holds(&region, middle), "{leg:?}");
        }
    }
}
