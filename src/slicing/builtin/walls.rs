//! The walls of one island, and what they leave for infill.
//!
//! Where a piece is wide, its walls are whole lines, one inside the other; where it is narrow, `narrow` gives it beads of its own width.
//! Both are joined to one line where their ends meet.

use std::ops::RangeInclusive;

use super::Line;
use super::join::{joined, unfolded};
use super::narrow::{GapFit, Narrow, Stretch, on_grid};
use super::region::{
    Contour, GridPoint, Region, Shape, area_mm2, enclosed, grown, holds, minus, opened, or, pairs, units,
};
use super::thickness::{Vec2, in_mm, length, plus, sub};
use crate::section::simplify::simplified;

/// A line of extrusion along a wall.
pub(super) struct Bead {
    /// The line's centre.
    pub(super) points: Contour,
    /// Whether it leads back to its first point, which is not there again.
    pub(super) closed: bool,
    /// 0 for the outer wall, growing inward.
    pub(super) depth: u32,
    /// The width of each leg, mm; nothing where all are as wide as the settings say.
    pub(super) widths: Vec<f64>,
}

/// One connected piece of a layer.
#[derive(Default)]
pub(super) struct Walled {
    /// Its walls; outer ones first.
    pub(super) beads: Vec<Bead>,
    /// The middles of its outer walls where whole lines fit.
    pub(super) centre: Region,
    /// What infill has to cover.
    pub(super) infill: Region,
    /// What is too narrow for any line.
    pub(super) lost: Region,
}

/// A wall up to so many lines wide is one bead.
const ONE_BEAD: f64 = 1.45;
/// How much of a narrow piece's thickness its beads fill where both sides are the part's surface: they have round sides, as whole
/// lines do.
const FILLED: f64 = 0.97;
/// What is narrower than twice this is rounding, grid units: 20 micrometres.
const ROUNDING: i32 = 100;
/// Narrow pieces smaller than this are rounding as well, mm².
const SMALLEST_MM2: f64 = 0.01;
/// Spacing of the places at which a whole line is asked whether it runs in a narrow piece, mm.
const STEP_MM: f64 = 0.15;
/// Lines that are not joined to others are at least so many of their widths long.
const SHORTEST: f64 = 0.6;

/// Shapes whose corners differ by no more, once one is moved, have the same walls, grid units: 0.2 micrometres, what an `f32` on a bed
/// rounds.
const ALIKE: u32 = 2;
/// Shapes that others are held against, at most: a layer of many that all differ takes no longer for it.
const KNOWN: usize = 256;

/// The walls of each shape of a layer; of those that are the same elsewhere (pins, letters) they are found once.
pub(super) fn walled_once(shapes: &Region, line: &Line, walls: u32) -> Vec<Walled> {
    let mut all: Vec<Walled> = Vec::with_capacity(shapes.len());
    let mut known: Vec<usize> = Vec::new();
    for (place, shape) in shapes.iter().enumerate() {
        let like = known.iter().find_map(|&first| Some((first, shift_between(&shapes[first], shape)?)));
        all.push(match like {
            Some((first, by)) => all[first].moved(by),
            None => {
                if known.len() < KNOWN {
                    known.push(place);
                }
                walled(shape, line, walls)
            }
        });
    }
    all
}

/// What moves the first shape onto the second, grid units; `None` for another shape.
fn shift_between(from: &Shape, to: &Shape) -> Option<[i32; 2]> {
    let [a, b] = [from, to].map(|shape| shape.first().and_then(|ring| ring.first()));
    let (a, b) = a.zip(b)?;
    let by = [b.x - a.x, b.y - a.y];
    let near =
        |(a, b): (&GridPoint, &GridPoint)| (b.x - a.x).abs_diff(by[0]) <= ALIKE && (b.y - a.y).abs_diff(by[1]) <= ALIKE;
    let alike = |(a, b): (&Contour, &Contour)| a.len() == b.len() && a.iter().zip(b).all(near);
    (from.len() == to.len() && from.iter().zip(to).all(alike)).then_some(by)
}

impl Walled {
    /// The same elsewhere.
    fn moved(&self, by: [i32; 2]) -> Self {
        let ring =
            |ring: &Contour| -> Contour { ring.iter().map(|p| GridPoint::new(p.x + by[0], p.y + by[1])).collect() };
        let region =
            |region: &Region| -> Region { region.iter().map(|shape| shape.iter().map(ring).collect()).collect() };
        let bead = |bead: &Bead| Bead { points: ring(&bead.points), widths: bead.widths.clone(), ..*bead };
        Self {
            beads: self.beads.iter().map(bead).collect(),
            centre: region(&self.centre),
            infill: region(&self.infill),
            lost: region(&self.lost),
        }
    }
}

/// Walls of a shape: the first half a line width inside its border, the others one spacing apart.
fn walled(shape: &Shape, line: &Line, walls: u32) -> Walled {
    let mut found = Walled::default();
    let zone: Region = vec![shape.clone()];
    found.infill = match walls {
        0 => grown(&zone, (line.spacing - line.width) / 2),
        _ => found.inward(zone, 0..=walls, line),
    };
    found
}

/// Lines along the border of a shape that lies between walls, one inside the other; and what they leave.
pub(super) fn concentric(shape: &Shape, line: &Line, count: u32) -> (Vec<Bead>, Region) {
    let mut found = Walled::default();
    let left = found.inward(vec![shape.clone()], 1..=count + 1, line);
    (found.beads, left)
}

impl Walled {
    /// Walls from the border of a zone inward, and what they leave of it; behind the last one narrow pieces alone are filled.
    fn inward(&mut self, mut zone: Region, depths: RangeInclusive<u32>, line: &Line) -> Region {
        let walls = *depths.end();
        for depth in depths {
            zone = self.next_wall(zone, depth, depth < walls, line);
        }
        zone
    }

    /// The wall along the border of a zone, and what lies inside it; of whole lines it has some only where that is `wanted`.
    fn next_wall(&mut self, zone: Region, depth: u32, wanted: bool, line: &Line) -> Region {
        let fit = line.fit(depth);
        let pieces = narrow_pieces(&zone, &fit);
        let inset = if depth == 0 { line.width / 2 } else { line.spacing / 2 };
        let centre = if wanted { grown(&zone, -inset) } else { Region::new() };
        if depth == 0 {
            self.centre.clone_from(&centre);
        }
        if pieces.is_empty() {
            self.beads.extend(centre.iter().flatten().map(|ring| whole(ring, depth)));
            return if wanted { grown(&centre, -line.spacing / 2) } else { zone };
        }
        let (filled, ends) = with_narrow(&zone, &pieces, &centre, depth, line, &mut self.beads);
        if depth == 0 {
            let lost = minus(&minus(&pieces, &or(&filled, &ends)), &grown(&centre, inset));
            self.lost = lost.into_iter().filter(|shape| !grown(&vec![shape.clone()], -ROUNDING).is_empty()).collect();
        }
        let inner = if wanted { grown(&centre, -line.spacing / 2) } else { zone };
        opened(&minus(&inner, &filled), units(fit.least) / 2)
    }
}

impl Line {
    /// Which beads fill what is narrow beside the wall `depth`: the border of the first is the part's, of the others the wall before.
    fn fit(&self, depth: u32) -> GapFit {
        let rounding = self.width_mm - self.spacing_mm;
        let least = self.narrowest_mm() - rounding;
        let one = ONE_BEAD * self.width_mm;
        match depth {
            0 => {
                let most = self.width_mm + self.spacing_mm + least;
                GapFit { least: least / FILLED, one, most, share: FILLED, rounding }
            }
            _ => GapFit { least, one: one - rounding, most: 2.0 * self.spacing_mm + least, share: 1.0, rounding },
        }
    }
}

/// Where the zone is, or may be, narrower than whole lines need.
fn narrow_pieces(zone: &Region, fit: &GapFit) -> Region {
    let pieces = minus(zone, &opened(zone, units(fit.most) / 2));
    let counts = |shape: &Shape| {
        let one = vec![shape.clone()];
        area_mm2(&one) > SMALLEST_MM2 && !grown(&one, -ROUNDING).is_empty()
    };
    pieces.into_iter().filter(counts).collect()
}

/// How far a whole line may leave its course where points are dropped, grid units: 12 micrometres, as PrusaSlicer does.
const THINNED: f64 = 120.0;

fn whole(ring: &Contour, depth: u32) -> Bead {
    Bead { points: simplified(ring, THINNED), closed: true, depth, widths: Vec::new() }
}

/// The walls of a zone with narrow `pieces`; what of it the beads in these fill, and what lies around the ends of lines.
fn with_narrow(
    zone: &Region,
    pieces: &Region,
    centre: &Region,
    depth: u32,
    line: &Line,
    beads: &mut Vec<Bead>,
) -> (Region, Region) {
    let narrow = Narrow::new(zone, pieces, line.fit(depth));
    let inset = if depth == 0 { line.width_mm } else { line.spacing_mm } / 2.0;
    let (mut stretches, mut filled) = narrow.beads(zone);
    for ring in centre.iter().flatten() {
        match wide_stretches(ring, &narrow, inset, line.width_mm) {
            None => beads.push(whole(ring, depth)),
            Some(wide) => stretches.extend(wide),
        }
    }
    let (mut lines, mut crumbs): (Vec<Stretch>, Vec<Stretch>) =
        joined(stretches, |p| holds(zone, on_grid(p))).into_iter().partition(Stretch::is_a_line);
    // A pin as thin as one bead has room for no more than the shortest line.
    crumbs.retain(|crumb| {
        let alone = !lines.iter().any(|line| line.is_near(crumb));
        if alone {
            lines.push(crumb.dot());
        }
        !alone
    });
    // What is too short for a line stays what it was, for infill or as lost.
    let crumbs: Vec<Contour> = crumbs
        .iter()
        .flat_map(|stretch| stretch.points.iter().zip(&stretch.widths))
        .map(|(p, width)| about(p, *width))
        .collect();
    filled = minus(&filled, &enclosed(&crumbs));
    // A line reaches half its width beyond its ends.
    let ends = lines.iter().filter(|s| !s.closed).flat_map(|s| {
        let mut all = s.points.iter().zip(&s.widths);
        all.clone().next().into_iter().chain(all.next_back())
    });
    let ends = enclosed(&ends.map(|(p, width)| about(p, *width)).collect::<Vec<_>>());
    let laid = lines.iter().flat_map(|line| unfolded(line.thinned())).filter(|line| line.points.len() > 1);
    beads.extend(laid.map(|line| line.bead(depth)));
    (filled, ends)
}

/// The stretches of a whole line that do not run in narrow pieces; `None` where that is all of it.
fn wide_stretches(ring: &Contour, narrow: &Narrow, inset: f64, width: f64) -> Option<Vec<Stretch>> {
    if !narrow.may_concern(ring) {
        return None;
    }
    let reach = 1.1 * inset;
    let mut legs: Vec<(Vec2, Vec2, bool)> = Vec::new();
    for (a, b) in pairs(ring) {
        let (a, b) = (in_mm(a), in_mm(b));
        let count = (length(sub(b, a)) / STEP_MM).ceil().max(1.0);
        let at = |k: f64| plus(a, sub(b, a), k / count);
        for k in 0..count as usize {
            let k = k as f64;
            legs.push((at(k), at(k + 1.0), !narrow.fills_beside(at(k + 0.5), reach)));
        }
    }
    let first = legs.iter().position(|leg| !leg.2)?;
    legs.rotate_left(first);
    let mut found: Vec<Stretch> = Vec::new();
    let mut goes_on = false;
    for (from, to, wide) in legs {
        if wide {
            if !goes_on {
                found.push(Stretch { points: vec![from], widths: vec![width], closed: false });
            }
            if let Some(stretch) = found.last_mut() {
                stretch.points.push(to);
                stretch.widths.push(width);
            }
        }
        goes_on = wide;
    }
    Some(found)
}

/// The square about a point of a line, as wide as it is there.
fn about(p: &Vec2, width: f64) -> Contour {
    let corner = |x: f64, y: f64| on_grid([p[0] + x * width / 2.0, p[1] + y * width / 2.0]);
    vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)]
}

impl Stretch {
    fn is_a_line(&self) -> bool {
        self.length() >= SHORTEST * self.widest()
    }

    fn widest(&self) -> f64 {
        self.widths.iter().fold(0.0, |most: f64, width| most.max(*width))
    }

    /// Whether a point of it lies within both lines' widths of one of another.
    fn is_near(&self, other: &Self) -> bool {
        let near = self.widest() + other.widest();
        self.points.iter().any(|p| other.points.iter().any(|q| length(sub(*p, *q)) < near))
    }

    /// The shortest line about its middle.
    fn dot(&self) -> Self {
        let (first, last) = (self.points[0], self.points[self.points.len() - 1]);
        let (far, width) = (length(sub(last, first)), self.widest());
        let along = if far > 1e-6 { sub(last, first).map(|v| v / far) } else { [1.0, 0.0] };
        let middle = plus(first, sub(last, first), 0.5);
        let reach = (SHORTEST * width).max(far) / 2.0;
        Self {
            points: [-reach, reach].map(|by| plus(middle, along, by)).to_vec(),
            widths: vec![width; 2],
            closed: false,
        }
    }

    /// The line on the grid, without points that change neither its course nor its width.
    fn bead(&self, depth: u32) -> Bead {
        let thinned = self.thinned();
        let points: Contour = thinned.points.iter().map(|p| on_grid(*p)).collect();
        let count = if thinned.closed { points.len() } else { points.len() - 1 };
        let next = |k: usize| thinned.widths[(k + 1) % points.len()];
        let widths = (0..count).map(|k| leg_width(thinned.widths[k], next(k))).collect();
        Bead { points, closed: thinned.closed, depth, widths }
    }
}

/// The width of a leg between two places: where it jumps, two stretches were joined, and the wider would stand out at the other's end.
fn leg_width(from: f64, to: f64) -> f64 {
    if (from - to).abs() > JUMP_MM { from.min(to) } else { (from + to) / 2.0 }
}

/// Widths at both ends of a leg that differ by more are those of two stretches, mm.
const JUMP_MM: f64 = 0.08;
/// How far a line may leave its course where points are dropped, and by how much its width may change along a leg, mm.
const COURSE_MM: f64 = 0.005;
const CHANGE_MM: f64 = 0.03;

impl Stretch {
    fn thinned(&self) -> Stretch {
        let mut kept = vec![0];
        let mut last = 0;
        for next in 1..self.points.len() {
            if !self.is_straight(last, next) {
                last = next - 1;
                kept.push(last);
            }
        }
        kept.push(self.points.len() - 1);
        kept.dedup();
        Stretch {
            points: kept.iter().map(|&k| self.points[k]).collect(),
            widths: kept.iter().map(|&k| self.widths[k]).collect(),
            closed: self.closed,
        }
    }

    /// Whether the points between two lie on the line between them, as wide as it is there.
    fn is_straight(&self, from: usize, to: usize) -> bool {
        let (a, b) = (self.points[from], self.points[to]);
        let along = sub(b, a);
        let whole = length(along);
        if (self.widths[to] - self.widths[from]).abs() > CHANGE_MM {
            return to == from + 1;
        }
        (from + 1..to).all(|k| {
            let v = sub(self.points[k], a);
            let share =
                if whole > 0.0 { ((v[0] * along[0] + v[1] * along[1]) / whole / whole).clamp(0.0, 1.0) } else { 0.0 };
            let wide = self.widths[from] + (self.widths[to] - self.widths[from]) * share;
            length(sub(v, plus([0.0; 2], along, share))) <= COURSE_MM && (self.widths[k] - wide).abs() <= COURSE_MM
        })
    }
}

/// The narrowest bead, as a share of the usual width: 0.3 mm of 0.45.
const NARROWEST: f64 = 2.0 / 3.0;

impl Line {
    /// The narrowest bead that is printed, mm: no bead is narrower than it is high.
    pub(super) fn narrowest_mm(&self) -> f64 {
        (NARROWEST * self.width_mm).max(self.height_mm)
    }

    /// The thinnest wall that is printed, mm.
    pub(super) fn thinnest_mm(&self) -> f64 {
        self.fit(0).least
    }
}
