//! Rule `flow` where no line says how wide it is: Slic3r states the widths that it uses in the file's head alone, CuraEngine nowhere.
//!
//! A line then has one of those widths, or that of other lines of its layer (solid infill is spread to fill its region evenly, a lone row by a
//! fifth); anything else is a line as thin as the gap that it fills. Such a one has material or the part's outline on both sides, and
//! runs on top of no other full line. CuraEngine lays a wall thinner where it runs over another, down to nothing: one such has that other beside
//! it. From 5.0 on its lines are as wide as they have room for: a wide one lies beside another and over none, a very thin one is all
//! of a wall. A line that leads somewhere else than its filament was counted for is none of these. What is left is short in published parts: see
//! [`MOST_MM`].

use std::ops::ControlFlow;

use rayon::prelude::*;

use super::line::{DIGITS_MM, Line, lines};
use super::prints::{Level, PrintedPart};
use super::report::{FindingPlace, Findings, Rule};
use crate::gcode::marks::Bead;
use crate::section::{PlanePoint, Segment, Segments, to_segment};

/// A gap up to so many lines wide is filled by one line.
pub(super) const WIDEST: f64 = 2.2;
/// Lines that make up so much of the length of all are of a kind that the slicer means.
const KIND: f64 = 0.1;
/// Where an outer wall's middle lies within the outline, and how far within it nothing is the middle of a thin wall, in line widths; and how many
/// layers are looked at for kinds.
const WALL: [f64; 2] = [0.3, 0.7];
const WELL_WITHIN: f64 = 3.0;
const MOST_LEVELS: usize = 60;
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
/// Where both together are wider than this, in usual widths: two thin lines may share the place of one.
const TOO_WIDE: f64 = 1.4;
/// How far Slic3r spreads rows to fill a region evenly, in spacings, and what a bridge's threads are apart more than they are thick, mm. A
/// region of one row has that alone.
const SPREAD: f64 = 1.2;
const THREADS_APART_MM: f64 = 0.05;
/// What a layer may hold of lines that are none of this, mm, and as a share of its length: odd ends of gaps, strokes across them, second lines where
/// two gaps meet. Of 3,700 in 59 published parts none that is not as wide as a spread row was longer than 1.7 mm; a layer had 8 % of them.
const MOST_MM: f64 = 2.0;
const MOST_SHARE: f64 = 0.12;
/// How near, in usual widths, another must be for a line of Cura's to be laid thinner for it, and for what part of its length.
const NEAR: f64 = 0.25;
const SHARED: f64 = 0.25;
/// Of one that has so much of its filament nothing is asked; one that has less than this is laid thinner for another, and fills no gap.
const NEARLY: f64 = 0.9;
const THINNEST: f64 = 0.5;
/// By how much, in usual widths, a wide line may lie over those on both sides of it together, and be away from the one that it lies beside.
const OVER: f64 = 0.2;
/// How much narrower than a wall the one line that is all of it may be, in usual widths.
const NARROWER: f64 = 0.2;
/// Lines that are looked at around one place.
const MOST_NEAR: usize = 1000;
/// The part of a line's length that must be so.
const MOSTLY: f64 = 0.6;

/// Holds the lines of a layer without a stated width against each other; `lines` are all of the layer.
pub(super) fn check(printed: &PrintedPart<'_>, level: &Level, lines: &[Line], findings: &mut Findings) {
    let mut usual = usual(lines);
    usual.extend([1.0, SPREAD]);
    let mut beside = None;
    let mut strange = Vec::new();
    for (index, line) in lines.iter().enumerate() {
        let threads = threads(printed, line);
        let known = || usual.iter().chain(&threads).any(|ratio| is_one_of(line, *ratio));
        if line.stated || line.is_thread() || known() || is_of_a_kind(lines, index) {
            continue;
        }
        let beside = beside.get_or_insert_with(|| Beside::new(printed, level, lines));
        // Cura lays less where lines overlap, be it for a part of their length alone.
        let is_less = printed.flow.widths.is_empty() && line.ratio() < 1.0;
        let shares = || is_less && (line.ratio() >= NEARLY || beside.shares(index));
        // It fills no gaps with lines as thin as this.
        let fills = || !(is_less && line.ratio() < THINNEST) && beside.mostly(index, Beside::is_between);
        let varies = || match printed.flow.bead {
            // Cura before 5.0 does so where it is set to fill outline gaps.
            Bead::Varied | Bead::Square if line.ratio() < 1.0 => beside.mostly(index, Beside::is_all),
            Bead::Varied => beside.mostly(index, Beside::is_beside),
            _ => false,
        };
        let has_room = || {
            let may_lack = printed.flow.bead != Bead::Varied || line.ratio() <= SPREAD;
            may_lack || beside.mostly(index, |beside, index, p, normal| beside.has_room(index, p, normal, OVER))
        };
        if !shares() && !((fills() || varies()) && has_room()) {
            strange.push(line);
        }
    }
    let length: f64 = strange.iter().map(|line| line.length).sum();
    let Some(line) = strange.into_iter().max_by(|a, b| a.length.total_cmp(&b.length)) else { return };
    let most = MOST_SHARE * lines.iter().map(|line| line.length).sum::<f64>();
    if line.length > MOST_MM || length > most.max(MOST_MM) {
        let at = FindingPlace { line: line.m.line, slot: Some(printed.planned.slot), part: Some(printed.planned.part) };
        let (length, most) = if line.length > MOST_MM { (line.length, MOST_MM) } else { (length, most.max(MOST_MM)) };
        findings.add(Rule::Flow, at, [length, most], || {
            format!(
                "{length:.2} mm of line in the layer at Z {:.2} have a width that is neither stated nor usual, and fill no gap (maximum {most:.1} mm): \
                 one of {:.2} mm uses {:.3} times the filament that {:.2} x {:.2} mm need",
                level.z,
                line.length,
                line.ratio(),
                line.width,
                line.height
            )
        });
    }
}

/// Which lines of a layer have room for all of their filament beside another, but for `over` of a usual width.
pub(super) fn have_room(printed: &PrintedPart<'_>, level: &Level, lines: &[Line], over: f64) -> Vec<bool> {
    let beside = Beside::new(printed, level, lines);
    let is_good = |beside: &Beside<'_>, index: usize, p: PlanePoint, normal: PlanePoint| {
        beside.is_beside(index, p, normal) && beside.has_room(index, p, normal, over)
    };
    (0..lines.len()).map(|index| beside.mostly(index, is_good)).collect()
}

/// The least ratio that a good part of the print's lines have in common, of those that lie at the outline or well within it: solid infill is spread,
/// and wider; lines as thin as a gap do not count, nor does what fills the middle of a thin wall all around a part. `None` where no line is without
/// a width, or no part of them is alike.
pub(super) fn kinds(printed: &PrintedPart<'_>) -> Option<f64> {
    let every = printed.levels.len().div_ceil(MOST_LEVELS).max(1);
    let levels: Vec<&Level> = printed.levels.iter().step_by(every).collect();
    let by_level: Vec<Vec<Line>> = levels.par_iter().map(|level| plain(printed, level)).collect();
    let mut all: Vec<[f64; 2]> = by_level.iter().flatten().map(|line| [line.ratio(), line.length]).collect();
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

/// The lines of a layer without a stated width that are long and full enough to tell one, and fill no thin wall: they run half a line within the
/// outline, or farther from it than such a wall's middle.
fn plain(printed: &PrintedPart<'_>, level: &Level) -> Vec<Line> {
    let width = printed.job.profile.process.line_width_mm;
    let telling = |line: &Line| !line.stated && !line.is_thread() && line.length >= TELLING_MM && line.ratio() >= GAP;
    let telling: Vec<Line> = lines(printed, level).into_iter().filter(telling).collect();
    if telling.is_empty() {
        return telling;
    }
    let outline = Segments::new(printed.sections.segments_at(level.middle()));
    let is_plain = |line: &Line| {
        let Some([a, b]) = line.axis() else { return false };
        let middle = [0, 1].map(|i| (a[i] + b[i]) / 2.0);
        let away = outline.nearest(middle, width * WELL_WITHIN, None).map(|nearest| nearest.distance / width);
        away.is_none_or(|widths| (WALL[0]..=WALL[1]).contains(&widths))
    };
    telling.into_iter().filter(is_plain).collect()
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

/// The ratios of a round thread over air, as thick as the nozzle, and as thick as it is where threads are spread.
pub(super) fn threads(printed: &PrintedPart<'_>, line: &Line) -> [f64; 2] {
    let nozzle = printed.job.profile.process.nozzle_mm;
    let spread = SPREAD * (nozzle + THREADS_APART_MM) - THREADS_APART_MM;
    [nozzle, spread].map(|mm| printed.flow.bead.area(mm, mm) * line.length * printed.flow.multiplier / line.held)
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
    axes: Segments,
    halves: Vec<f64>,
    widest: f64,
    outline: Segments,
    lines: &'a [Line],
    usual_mm: f64,
}

impl<'a> Beside<'a> {
    fn new(printed: &PrintedPart<'_>, level: &Level, lines: &'a [Line]) -> Self {
        let half = |line: &Line| line.width * line.ratio().min(WIDEST) / 2.0;
        let halves: Vec<f64> = lines.iter().map(half).collect();
        Self {
            // Each has its ends: see `Line::of`.
            axes: Segments::new(lines.iter().map(|line| line.axis().unwrap_or_default()).collect()),
            widest: halves.iter().copied().fold(0.0, f64::max),
            halves,
            outline: Segments::new(printed.sections.segments_at(level.middle())),
            lines,
            usual_mm: printed.job.profile.process.line_width_mm,
        }
    }

    fn axis(&self, index: usize) -> Segment {
        self.axes.all()[index]
    }

    /// Whether most places along a line, its ends left out, are good; handed each with the line's normal.
    fn mostly(&self, index: usize, is_good: impl Fn(&Self, usize, PlanePoint, PlanePoint) -> bool) -> bool {
        let [a, b] = self.axis(index);
        let length = self.lines[index].length;
        let normal = [(a[1] - b[1]) / length, (b[0] - a[0]) / length];
        let places = self.places(index);
        places.iter().filter(|&&p| is_good(self, index, p, normal)).count() as f64 >= MOSTLY * places.len() as f64
    }

    /// Whether a line that is thinner than usual shares its room with another for a good part of its length.
    fn shares(&self, index: usize) -> bool {
        let near = |p: PlanePoint| {
            let mut near = false;
            // What it goes on to is beside its ends alone, and these are left out.
            self.each_other(index, p, NEAR * self.usual_mm, |_, _| near = true);
            near
        };
        let places = self.places(index);
        places.iter().filter(|&&p| near(p)).count() as f64 >= SHARED * places.len() as f64
    }

    /// Visits the lines whose edges come as near as this to the edge of one at `p`, with how far their middles are. So many at one place that no slicer
    /// lays them are not all visited.
    fn each_other(&self, index: usize, p: PlanePoint, free: f64, mut visit: impl FnMut(usize, f64)) {
        let half = self.halves[index];
        let mut count = 0;
        self.axes.each_near(p, half + self.widest + free, |other| {
            let other = other as usize;
            let mm = to_segment(p, self.axis(other));
            if other != index && mm <= half + self.halves[other] + free {
                visit(other, mm);
            }
            count += 1;
            if count < MOST_NEAR { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        });
    }

    /// Places along a line, its ends left out.
    fn places(&self, index: usize) -> Vec<PlanePoint> {
        let [a, b] = self.axis(index);
        let length = self.lines[index].length;
        let end = (self.usual_mm / 2.0).min(length / 3.0);
        let count = ((length - 2.0 * end) / SPACING_MM).ceil().max(1.0);
        let along = [(b[0] - a[0]) / length, (b[1] - a[1]) / length];
        let place = |k: usize| {
            let at = end + (length - 2.0 * end) * (k as f64 + 0.5) / count;
            [a[0] + along[0] * at, a[1] + along[1] * at]
        };
        (0..count as usize).map(place).collect()
    }

    /// How far the edges of a line are from those beside it at `p`, on both sides, mm; infinite where none is near. Where a line turns back on the one
    /// before it is another question: see [`super::doubled`].
    fn free(&self, index: usize, p: PlanePoint, normal: PlanePoint) -> [f64; 2] {
        let mut free = [f64::INFINITY; 2];
        self.each_other(index, p, OVER * self.usual_mm, |other, _| {
            if let Some(t) = across(p, normal, self.axis(other)).filter(|_| other.abs_diff(index) > 1) {
                let free = &mut free[usize::from(t > 0.0)];
                *free = free.min(t.abs() - self.halves[index] - self.halves[other]);
            }
        });
        free
    }

    /// Whether a line lies beside another at `p`, and on none.
    fn is_beside(&self, index: usize, p: PlanePoint, normal: PlanePoint) -> bool {
        let mut is_on_top = false;
        self.each_other(index, p, 0.0, |other, mm| {
            is_on_top |= other.abs_diff(index) > 1 && mm < ON_TOP * self.usual_mm;
        });
        !is_on_top && self.free(index, p, normal).iter().any(|free| *free <= OVER * self.usual_mm)
    }

    /// Whether a line has room for its whole width at `p`, but for so much in usual widths.
    fn has_room(&self, index: usize, p: PlanePoint, normal: PlanePoint, over: f64) -> bool {
        let lies_over: f64 = self.free(index, p, normal).iter().map(|free| (-free).max(0.0)).sum();
        lies_over <= over * self.usual_mm
    }

    /// Whether the part is no wider at `p` than the line.
    fn is_all(&self, index: usize, p: PlanePoint, normal: PlanePoint) -> bool {
        let reach = self.halves[index] + NARROWER / 2.0 * self.usual_mm;
        let mut sides = [false; 2];
        self.outline.each_near(p, reach, |wall| {
            if let Some(side) = side(p, normal, self.outline.all()[wall as usize], reach) {
                sides[side] = true;
            }
            ControlFlow::Continue(())
        });
        sides == [true; 2]
    }

    /// Whether something is on both sides of a line at `p`, and nothing under it.
    fn is_between(&self, index: usize, p: PlanePoint, normal: PlanePoint) -> bool {
        let free = BESIDE * self.usual_mm;
        let half = self.halves[index];
        let (mut sides, mut is_on_top) = ([false; 2], false);
        self.each_other(index, p, free, |other, mm| {
            let crowds = half + self.halves[other] > TOO_WIDE / 2.0 * self.usual_mm;
            is_on_top |= crowds && other.abs_diff(index) > 1 && mm < ON_TOP * self.usual_mm;
            if let Some(side) = side(p, normal, self.axis(other), half + self.halves[other] + free) {
                sides[side] = true;
            }
        });
        self.outline.each_near(p, half + free, |wall| {
            if let Some(side) = side(p, normal, self.outline.all()[wall as usize], half + free) {
                sides[side] = true;
            }
            if sides == [true; 2] { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        !is_on_top && sides == [true; 2]
    }
}

/// On which side of `p`, along `normal` or against it, a segment is met within `reach`.
fn side(p: PlanePoint, normal: PlanePoint, segment: Segment, reach: f64) -> Option<usize> {
    across(p, normal, segment).filter(|t| t.abs() <= reach).map(|t| usize::from(t > 0.0))
}

/// How far from `p` along `normal`, or against it, a segment is met, mm.
fn across(p: PlanePoint, normal: PlanePoint, [a, b]: Segment) -> Option<f64> {
    let beside = |q: PlanePoint| (q[0] - p[0]) * -normal[1] + (q[1] - p[1]) * normal[0];
    let up = |q: PlanePoint| (q[0] - p[0]) * normal[0] + (q[1] - p[1]) * normal[1];
    let (from, to) = (beside(a), beside(b));
    (from * to <= 0.0 && from != to).then(|| up(a) + (up(b) - up(a)) * (from / (from - to)))
}
