//! Rule `flow` where the file's head states the widths that it uses and no line says which is its own (Slic3r).
//!
//! A line then has one of those widths, or that of other lines of its layer (solid infill is spread to fill its region evenly);
//! anything else is a line as thin as the gap that it fills. Such a one has material or the part's outline on both sides, and
//! runs on top of no other line. A line that leads somewhere else than its filament was counted for is none of these.

use super::line::{DIGITS_MM, Line, lines};
use super::prints::{Level, PrintedPart};
use super::report::{FindingPlace, Findings, Rule};
use crate::section::{Point, Segment};

/// A gap up to so many lines wide is filled by one line.
pub(super) const WIDEST: f64 = 2.2;
/// Lines that make up so much of a print's length are of a kind that its slicer means.
const KIND: f64 = 0.1;
/// Of lines thinner than this, as a part of a whole one, nothing is said: they fill gaps.
const GAP: f64 = 0.75;
/// How much two lines of one width may differ in filament a millimetre, relative.
const ALIKE: f64 = 0.01;
/// So many lines of a layer that are alike are meant so.
const FEWEST: usize = 5;
/// Of so many lines before and after one, so many are alike where it is of a kind with them.
const AROUND: usize = 3;
const OF_A_KIND: usize = 2;
/// Lines shorter than this say too little of their width to be counted among those, mm.
const TELLING_MM: f64 = 1.0;
/// Spacing of the places looked at along a line, mm.
const SPACING_MM: f64 = 0.3;
/// What may be free beside a thin line, in usual widths.
const BESIDE: f64 = 0.6;
/// How near to another's middle it may run, in usual widths.
const ON_TOP: f64 = 0.3;
/// What a layer may hold of lines that are none of this, mm: odd ends of gaps.
const MOST_MM: f64 = 1.5;
/// The part of a line's length that must be so.
const MOSTLY: f64 = 0.6;

/// Holds the lines of a layer without a stated width against each other; `lines` are all of the layer.
pub(super) fn check(printed: &PrintedPart<'_>, level: &Level, lines: &[Line], findings: &mut Findings) {
    let mut usual = usual(lines);
    usual.push(1.0);
    let mut beside = None;
    let mut strange = Vec::new();
    for (index, line) in lines.iter().enumerate() {
        let known = || usual.iter().any(|ratio| is_one_of(line, *ratio)) || is_one_of(line, thread(printed, line));
        if line.stated || line.is_thread() || known() || is_of_a_kind(lines, index) {
            continue;
        }
        let beside = beside.get_or_insert_with(|| Beside::new(printed, level, lines));
        let (wedged, places) = beside.wedged(index);
        if wedged < MOSTLY * places {
            strange.push(line);
        }
    }
    let length: f64 = strange.iter().map(|line| line.length).sum();
    let Some(line) = strange.into_iter().max_by(|a, b| a.length.total_cmp(&b.length)) else { return };
    if length > MOST_MM {
        let at = FindingPlace { line: line.m.line, slot: Some(printed.planned.slot), part: Some(printed.planned.part) };
        findings.add(Rule::Flow, at, [length, MOST_MM], || {
            format!(
                "{length:.2} mm of line in the layer at Z {:.2} have a width that neither the slicer states nor other lines have, and fill no \
                 gap: one of {:.2} mm uses {:.3} times the filament that {:.2} x {:.2} mm need",
                level.z,
                line.length,
                line.ratio(),
                line.width,
                line.height
            )
        });
    }
}

/// The least ratio that a good part of the print's lines have in common, which is that of its walls: solid infill is spread, and wider;
/// lines as thin as a gap do not count. `None` where no line is without a width, or the head states none, or no part of them is alike.
pub(super) fn kinds(printed: &PrintedPart<'_>) -> Option<f64> {
    if printed.flow.widths.is_empty() {
        return None;
    }
    let all = printed.levels.iter().flat_map(|level| lines(printed, level));
    let telling = |line: &Line| !line.stated && !line.is_thread() && line.length >= TELLING_MM && line.ratio() >= GAP;
    let mut all: Vec<[f64; 2]> = all.filter(telling).map(|line| [line.ratio(), line.length]).collect();
    all.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let total: f64 = all.iter().map(|[_, length]| length).sum();
    let mut from = 0;
    while from < all.len() {
        let alike = &all[from..];
        let alike = &alike[..alike.partition_point(|[ratio, _]| *ratio <= all[from][0] * (1.0 + ALIKE))];
        if alike.iter().map(|[_, length]| length).sum::<f64>() >= KIND * total {
            return Some(alike[alike.len() / 2][0]);
        }
        from += 1;
    }
    None
}

fn is_one_of(line: &Line, ratio: f64) -> bool {
    (line.ratio() / ratio - 1.0).abs() <= ALIKE + DIGITS_MM / line.length
}

/// Whether lines that are laid just before and after one are as wide.
fn is_of_a_kind(lines: &[Line], index: usize) -> bool {
    let line = &lines[index];
    let off = |other: &Line| ALIKE + DIGITS_MM / line.length + DIGITS_MM / other.length;
    let alike = |other: &&Line| (line.ratio() / other.ratio() - 1.0).abs() <= off(other);
    let (from, to) = (index.saturating_sub(AROUND), (index + AROUND + 1).min(lines.len()));
    // Itself is one of them.
    lines[from..to].iter().filter(alike).count() > OF_A_KIND
}

/// The ratio of a round thread over air, as thick as the nozzle.
fn thread(printed: &PrintedPart<'_>, line: &Line) -> f64 {
    let nozzle = printed.job.profile.process.nozzle_mm;
    printed.flow.bead.area(nozzle, nozzle) * line.length * printed.flow.multiplier / line.held
}

/// The ratios that several lines have in common.
fn usual(lines: &[Line]) -> Vec<f64> {
    let telling = |line: &&Line| !line.stated && !line.is_thread() && line.length >= TELLING_MM;
    let mut ratios: Vec<f64> = lines.iter().filter(telling).map(Line::ratio).collect();
    ratios.sort_by(f64::total_cmp);
    let mut found = Vec::new();
    let mut from = 0;
    while from < ratios.len() {
        let alike = ratios[from..].partition_point(|ratio| *ratio <= ratios[from] * (1.0 + ALIKE));
        if alike >= FEWEST {
            found.push(ratios[from + alike / 2]);
            from += alike;
        } else {
            from += 1;
        }
    }
    found
}

/// What lies beside the lines of a layer.
struct Beside<'a> {
    /// Their middles, with half their widths.
    axes: Vec<(Segment, f64)>,
    outline: Vec<Segment>,
    lines: &'a [Line],
    usual_mm: f64,
}

impl<'a> Beside<'a> {
    fn new(printed: &PrintedPart<'_>, level: &Level, lines: &'a [Line]) -> Self {
        let axis = |line: &Line| line.axis().map(|axis| (axis, line.width * line.ratio().min(WIDEST) / 2.0));
        let outline = printed.sections.segments_at(level.middle());
        let axes = lines.iter().map(|line| axis(line).unwrap_or(([[f64::MAX; 2]; 2], 0.0))).collect();
        Self { axes, outline, lines, usual_mm: printed.job.profile.process.line_width_mm }
    }

    /// At how many of how many places along a line, its ends left out, something is on both sides of it and nothing under it.
    fn wedged(&self, index: usize) -> (f64, f64) {
        let ([a, b], half) = self.axes[index];
        let length = self.lines[index].length;
        let end = (self.usual_mm / 2.0).min(length / 3.0);
        let count = ((length - 2.0 * end) / SPACING_MM).ceil().max(1.0);
        let along = [(b[0] - a[0]) / length, (b[1] - a[1]) / length];
        let place = |k: usize| {
            let at = end + (length - 2.0 * end) * (k as f64 + 0.5) / count;
            [a[0] + along[0] * at, a[1] + along[1] * at]
        };
        let good =
            (0..count as usize).filter(|&k| self.is_between(index, place(k), [-along[1], along[0]], half)).count();
        (good as f64, count)
    }

    fn is_between(&self, index: usize, p: Point, normal: Point, half: f64) -> bool {
        let free = BESIDE * self.usual_mm;
        let mut sides = [false; 2];
        for (other, (axis, other_half)) in self.axes.iter().enumerate() {
            if other == index || away(p, *axis) > half + other_half + free {
                continue;
            }
            if other.abs_diff(index) > 1 && away(p, *axis) < ON_TOP * self.usual_mm {
                return false;
            }
            if let Some(side) = side(p, normal, *axis, half + other_half + free) {
                sides[side] = true;
            }
        }
        for wall in &self.outline {
            if let Some(side) = side(p, normal, *wall, half + free) {
                sides[side] = true;
            }
        }
        sides == [true; 2]
    }
}

/// On which side of `p`, along `normal` or against it, a segment is met within `reach`.
fn side(p: Point, normal: Point, [a, b]: Segment, reach: f64) -> Option<usize> {
    let across = |q: Point| (q[0] - p[0]) * -normal[1] + (q[1] - p[1]) * normal[0];
    let up = |q: Point| (q[0] - p[0]) * normal[0] + (q[1] - p[1]) * normal[1];
    let (from, to) = (across(a), across(b));
    if from * to > 0.0 || from == to {
        return None;
    }
    let t = up(a) + (up(b) - up(a)) * (from / (from - to));
    (t.abs() <= reach).then_some(usize::from(t > 0.0))
}

/// The distance of `p` from a segment.
fn away(p: Point, axis: Segment) -> f64 {
    crate::section::to_segment(p, axis)
}
