//! Rule `flow`, between lines: none is laid on top of another of its layer.
//!
//! Plastic laid where plastic is already stands up, and the nozzle hits it on its next way. Slicers let lines overlap by a good part
//! of their width, where they meet a wall or share a narrow piece, and cross them in patterns; none lets two run along each other on
//! nearly the same middle for millimetres.

use std::f64::consts::PI;

use super::line::Line;
use super::prints::{Level, PrintedPart};
use super::report::{FindingPlace, Findings, Rule};
use crate::gcode::marks::Role;
use crate::section::{PlanePoint, Segment};

/// Directions are gathered by so many to a half turn. A line belongs to the nearest two, so that lines less than half of one apart
/// (1.5 degrees) always meet.
const DIRECTIONS: usize = 60;
/// How near two lines' middles may run, as a part of their width.
const ON_TOP: f64 = 0.2;
/// Together they must be wider than this, in usual widths: two thin lines may share the place of one.
const TOO_WIDE: f64 = 1.4;
/// Shorter stretches do not count, mm: the turns of infill on both sides of a border lie on it, now and then on each other. Lines that
/// follow one another, as along a curve, are one stretch.
const SHORTEST_MM: f64 = 2.0;
/// Of which each shares at least so much with another: lines of two hatches that meet end to end share their ends.
const CURVE_SHARE: f64 = 0.5;
/// Infill may turn back on itself for so much, mm (some two cubic millimetres), within so many lines: at the end of a region PrusaSlicer has gone back
/// over 25 mm of the row before.
const HAIRPIN_MM: f64 = 30.0;
const HAIRPIN_LINES: usize = 10;
const JOINED_MM: f64 = 0.2;
/// Lines on top of one that are told apart: more make the same finding, and pairs of all would grow with their square.
const MOST_ON_TOP: usize = 8;
/// Sparse infill crosses itself, and where a region is nearly cut in two PrusaSlicer 2.9 has gone over 7 mm of an earlier row: so much may one stretch of
/// it be, mm.
pub(super) const SPARSE_MM: f64 = 10.0;
/// What one stretch of the others may be long, mm, and all of a layer as a share of its lines: where skins meet CuraEngine lays 2.5 to 3 mm twice at each
/// of two places, Slic3r 3.4 mm once (published parts; layers of 1.2 to 5 m).
pub(super) const MOST_MM: f64 = 4.0;
const MOST_SHARE: f64 = 0.005;

/// Holds the lines of one layer against each other.
pub(super) fn check(printed: &PrintedPart<'_>, level: &Level, lines: &[Line], findings: &mut Findings) {
    let usual = printed.job.profile.process.line_width_mm;
    // What was laid of a line whose width nobody states is as wide as its filament.
    let width = |line: &Line| if line.stated { line.width } else { line.width * line.ratio().min(1.0) };
    let Some(doubled) = doubled(lines, TOO_WIDE * usual, width) else { return };
    let most = doubled.most.max(MOST_SHARE * lines.iter().map(|line| line.length).sum::<f64>());
    if doubled.longest > doubled.most || doubled.length > most {
        let line = lines[doubled.line].m.line;
        let at = FindingPlace { line, slot: Some(printed.planned.slot), part: Some(printed.planned.part) };
        let limit = if doubled.longest > doubled.most { doubled.most } else { most };
        findings.add(Rule::Flow, at, [doubled.length, limit], || {
            let other = lines[doubled.other].m.line;
            format!(
                "{:.2} mm of a line is printed on top of other lines of the layer at Z {:.2}, for example line {other} (maximum {limit:.1} mm)",
                doubled.length, level.z
            )
        });
    }
}

/// What lies on top of each other in a layer, mm; the stretch that is longest for what it may be, which is `most`, and where it begins.
struct Doubled {
    length: f64,
    longest: f64,
    most: f64,
    line: usize,
    other: usize,
}

/// A line seen along one direction: where it begins and ends along it, and across.
#[derive(Clone, Copy)]
struct Seen {
    index: usize,
    along: [f64; 2],
    across: [f64; 2],
    width: f64,
}

fn doubled(lines: &[Line], too_wide: f64, width: impl Fn(&Line) -> f64) -> Option<Doubled> {
    let origin = lines.iter().find_map(Line::axis)?[0];
    let mut by_direction: Vec<(usize, Seen)> = Vec::with_capacity(lines.len());
    for (index, line) in lines.iter().enumerate() {
        let Some(axis) = line.axis() else { continue };
        let width = width(line);
        each_direction(axis, |direction| {
            by_direction.push((direction, Seen::new(index, axis, origin, direction, width)))
        });
    }
    // Minus nothing is nothing.
    let least = |seen: &Seen| seen.across[0].min(seen.across[1]) + 0.0;
    by_direction.sort_unstable_by(|(a, one), (b, other)| {
        a.cmp(b).then(least(one).total_cmp(&least(other))).then(one.index.cmp(&other.index))
    });
    let widest = by_direction.iter().map(|(_, seen)| seen.width).fold(0.0, f64::max);
    let mut pairs: Vec<Pair> = Vec::new();
    for (place, (direction, one)) in by_direction.iter().enumerate() {
        let highest = one.across[0].max(one.across[1]) + ON_TOP * widest;
        let next = by_direction[place + 1..].iter();
        let mut on_top = 0;
        for (_, other) in next.take_while(|(d, other)| d == direction && least(other) <= highest) {
            let length = one.shares(other);
            let counts = length > SHORTEST_MM || length >= CURVE_SHARE * one.length().min(other.length());
            if length > 0.0 && counts && one.width + other.width > too_wide {
                pairs.push(Pair { line: one.index.max(other.index), other: one.index.min(other.index), length });
                on_top += 1;
            }
            if on_top >= MOST_ON_TOP {
                break;
            }
        }
    }
    // Most have met twice, in both of their directions.
    pairs.sort_unstable_by(|a, b| (a.line, a.other).cmp(&(b.line, b.other)).then(b.length.total_cmp(&a.length)));
    pairs.dedup_by_key(|pair| (pair.line, pair.other));
    let is_sparse = |pair: &Pair| [pair.line, pair.other].iter().all(|&index| lines[index].m.role == Role::Infill);
    Some(in_stretches(&pairs, |pair| is_hairpin(lines, pair), is_sparse))
}

/// Whether infill, a bridge's too, turns back on itself between the two lines, without a way between: along a curved wall PrusaSlicer
/// goes from one row to the next and back over the same place, and Slic3r, which names no roles, begins infill in the midst of its
/// first row and lays that whole on the way back.
fn is_hairpin(lines: &[Line], pair: &Pair) -> bool {
    let between = &lines[pair.other..=pair.line];
    let infill = |line: &Line| matches!(line.m.role, Role::Solid | Role::Infill | Role::Bridge | Role::Unknown);
    // Lines too short to tell what they hold are not among these.
    let joined = |two: &[Line]| {
        let ends = two[0].axis().zip(two[1].axis());
        ends.is_some_and(|([_, a], [b, _])| (b[0] - a[0]).hypot(b[1] - a[1]) <= JOINED_MM)
    };
    between.len() <= HAIRPIN_LINES && between.iter().all(infill) && between.windows(2).all(joined)
}

/// Two lines of a layer, the later one first, and for how long they lie on each other, mm.
struct Pair {
    line: usize,
    other: usize,
    length: f64,
}

/// What the pairs, sorted, add up to in stretches that count.
fn in_stretches(pairs: &[Pair], is_hairpin: impl Fn(&Pair) -> bool, is_sparse: impl Fn(&Pair) -> bool) -> Doubled {
    let mut all = Doubled { length: 0.0, longest: 0.0, most: MOST_MM, line: 0, other: 0 };
    for stretch in pairs.chunk_by(|a, b| b.line - a.line <= 1) {
        let (turns, others): (Vec<&Pair>, Vec<&Pair>) = stretch.iter().partition(|pair| is_hairpin(pair));
        let sum = |pairs: &[&Pair]| pairs.iter().map(|pair| pair.length).sum::<f64>();
        let there_and_back = |pair: &Pair| pair.line - pair.other == 1;
        let short = sum(&turns) <= HAIRPIN_MM || matches!(turns[..], [one] if there_and_back(one));
        let length = if short { sum(&others) } else { sum(&turns) + sum(&others) };
        if length > SHORTEST_MM {
            all.length += length;
            let most = if stretch.iter().all(&is_sparse) { SPARSE_MM } else { MOST_MM };
            if length / most > all.longest / all.most {
                let Pair { line, other, .. } = stretch[0];
                all = Doubled { length: all.length, longest: length, most, line, other };
            }
        }
    }
    all
}

/// The two directions nearest to a segment's, counted from 0 to [`DIRECTIONS`].
fn each_direction([a, b]: Segment, mut visit: impl FnMut(usize)) {
    let share =
        ((b[1] - a[1]).atan2(b[0] - a[0]).rem_euclid(PI) / PI * DIRECTIONS as f64).min(DIRECTIONS as f64 - 1e-9);
    let own = share as usize;
    visit(own);
    visit((own + if share.fract() < 0.5 { DIRECTIONS - 1 } else { 1 }) % DIRECTIONS);
}

impl Seen {
    fn new(index: usize, [a, b]: Segment, origin: PlanePoint, direction: usize, width: f64) -> Self {
        let (sin, cos) = ((direction as f64 + 0.5) / DIRECTIONS as f64 * PI).sin_cos();
        let along = |p: PlanePoint| (p[0] - origin[0]) * cos + (p[1] - origin[1]) * sin;
        let across = |p: PlanePoint| (p[1] - origin[1]) * cos - (p[0] - origin[0]) * sin;
        let [a, b] = if along(a) <= along(b) { [a, b] } else { [b, a] };
        Self { index, along: [along(a), along(b)], across: [across(a), across(b)], width }
    }

    /// For how long the two run on nearly the same middle, mm.
    fn shares(&self, other: &Self) -> f64 {
        let (from, to) = (self.along[0].max(other.along[0]), self.along[1].min(other.along[1]));
        if to <= from {
            return 0.0;
        }
        let apart = |at: f64| self.across_at(at) - other.across_at(at);
        let (first, last) = (apart(from), apart(to));
        let near = ON_TOP * (self.width + other.width) / 2.0;
        // Where the distance, which changes evenly, lies within `near` of nothing.
        let (least, most) = (first.min(last), first.max(last));
        let held = most.min(near) - least.max(-near);
        match (held < 0.0, most - least > 1e-9) {
            (true, _) => 0.0,
            (_, true) => (to - from) * held / (most - least),
            _ => to - from,
        }
    }

    fn length(&self) -> f64 {
        self.along[1] - self.along[0]
    }

    fn across_at(&self, along: f64) -> f64 {
        let share = (along - self.along[0]) / (self.along[1] - self.along[0]).max(1e-12);
        self.across[0] + (self.across[1] - self.across[0]) * share
    }
}
