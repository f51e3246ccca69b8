//! Rule `registration`, place by place: along the whole outline of each layer runs a wall. Rule `complete`: no island of a layer
//! is left out.
//!
//! Where a disc somewhat wider than a line touches the outline from inside, every slicer lays its outer wall there: the middle of
//! it half a line inside, give or take what it compensates. So places of the outline are looked at in turn, and where no line
//! runs beside one, it must be a corner, or a piece too narrow for a wall. An island (a closed curve of the outline) beside which
//! no line runs at all, of whatever kind, must be too narrow for a line.

use super::prints::{Level, PrintedPart};
use super::report::{FindingPlace, Findings, Rule};
use crate::gcode::marks::Role;
use crate::section::{OutlineSearch, PlanePoint, Section, Segment, Segments};

/// Spacing of the places, mm.
const SPACING_MM: f64 = 1.0;
/// How much of a layer's outline may be without a wall, mm: seams, and what two slicers round differently.
pub(super) const MOST_BARE_MM: f64 = 3.0;
/// How far a wall may lie off its place, mm; in the first layer an elephant's foot is compensated.
const OFF_MM: [f64; 2] = [0.2, 0.45];
/// The disc's radius, in line widths, and how far it may leave the part, mm.
const DISC_WIDTHS: f64 = 1.15;
const ROUNDING_MM: f64 = 0.02;
/// A disc so many line widths in radius is printed by every slicer, and what two heights of slicing may differ by, mm.
const ISLAND_WIDTHS: f64 = 0.6;
const ISLAND_SLACK_MM: f64 = 0.05;
/// Slicers' usual lines are no wider than so many of the profile's.
const USUAL_WIDTHS: f64 = 1.2;
/// How far up and down a layer is looked at for faces that lie in its middle, mm.
const EITHER_WAY_MM: f64 = 0.02;

/// How far the middle of any line may leave the outline, mm: PrusaSlicer and Slic3r close what is narrower than twice 0.049 mm in a
/// section (`slice_closing_radius`), so that a wall turns inside the notch of a sharp corner and not at its end.
pub(super) const CLOSED_MM: f64 = 0.05;

/// Holds the walls of one layer against its outline; they lie `offset` mm farther out than half a line.
pub(super) fn check(printed: &PrintedPart<'_>, level: &Level, section: &Section, offset: f64, findings: &mut Findings) {
    let walls = Walls::of(printed, level);
    let first = std::ptr::eq(level, &raw const printed.levels[0]);
    let off = OFF_MM[usize::from(first)];
    let mut bare = Bare { length: 0.0, at: [0.0; 2] };
    let mut last = None;
    let mut search = section.search();
    let mut alone: Vec<usize> = Vec::new();
    let usual = printed.job.profile.process.line_width_mm;
    let width = if walls.widest > 0.0 { walls.widest } else { usual };
    // A thin piece's walls may be wider than all others; an island is what lines of the usual width would print.
    let island = island_radius(width.min(USUAL_WIDTHS * usual), off);
    each_place(section.segments(), |p, normal, segment, length| {
        if walls.beside(p, off - offset, &mut last) {
            return;
        }
        let disc = |search: &mut OutlineSearch<'_>, radius: f64| holds_disc(search, p, normal, radius);
        let asked = disc(&mut search, island) && begins_air(&mut search, p, normal);
        if !asked || !is_no_step(printed, level, p) {
            return;
        }
        alone.push(segment);
        if disc(&mut search, DISC_WIDTHS * width) {
            bare.length += length;
            bare.at = p;
        }
    });
    let at = FindingPlace { line: level.line, slot: Some(printed.planned.slot), part: Some(printed.planned.part) };
    let part = printed.planned.part;
    if bare.length > MOST_BARE_MM {
        let Bare { length, at: [x, y] } = bare;
        findings.add(Rule::Registration, at, [length, MOST_BARE_MM], || {
            format!(
                "{length:.1} mm of the outline of part {part} at Z {:.2} has no wall, for example at X {x:.2} Y {y:.2} (maximum {MOST_BARE_MM} mm)",
                level.z
            )
        });
    }
    if let Some([x, y]) = island_left_out(printed, level, section, &alone, width + off) {
        findings.add(Rule::Complete, at, [0.0, 1.0], || {
            format!("an island of part {part} is missing from the layer at Z {:.2}, at X {x:.2} Y {y:.2}", level.z)
        });
    }
}

/// The radius of a disc, mm, that every slicer prints with lines `width` wide which may lie `off` farther in.
fn island_radius(width: f64, off: f64) -> f64 {
    (ISLAND_WIDTHS * width + off / 2.0 + ISLAND_SLACK_MM).min(DISC_WIDTHS * width)
}

/// Whether some place of the section is so wide that every slicer prints it with lines `width` wide.
pub(super) fn is_printed(section: &Section, width: f64) -> bool {
    let mut search = section.search();
    let mut found = false;
    each_place(section.segments(), |p, normal, _, _| {
        found = found
            || holds_disc(&mut search, p, normal, island_radius(width, OFF_MM[0]))
                && begins_air(&mut search, p, normal);
    });
    found
}

/// A point of the first curve of the outline, of those that `alone` are segments of, within `reach` of which no line runs.
fn island_left_out(
    printed: &PrintedPart<'_>,
    level: &Level,
    section: &Section,
    alone: &[usize],
    reach: f64,
) -> Option<PlanePoint> {
    if alone.is_empty() {
        return None;
    }
    let ends = level.beads.iter().filter_map(|&index| printed.bead(index).ends());
    let lines = Segments::new(ends.map(|[from, to]| [[from.x, from.y], [to.x, to.y]]).collect());
    let curves = section.curves();
    let mut asked: Vec<u32> = alone.iter().map(|&segment| curves[segment]).collect();
    asked.sort_unstable();
    asked.dedup();
    asked.into_iter().find_map(|curve| {
        let own = || section.segments().iter().zip(&curves).filter(|(_, c)| **c == curve).map(|(segment, _)| *segment);
        let mut met = false;
        let mut last = None;
        each_place_of(own(), |p, _, _, _| {
            let near = if met { None } else { lines.nearest(p, reach, last) };
            last = near.map(|near| near.index).or(last);
            met = met || near.is_some();
        });
        // Corners too: a small island may have no place of its own.
        let first = own().next()?[0];
        (!met && own().all(|[a, _]| lines.nearest(a, reach, None).is_none())).then_some(first)
    })
}

struct Bare {
    length: f64,
    at: PlanePoint,
}

/// The middles of a layer's walls.
struct Walls {
    axes: Segments,
    halves: Vec<f64>,
    widest: f64,
}

impl Walls {
    fn of(printed: &PrintedPart<'_>, level: &Level) -> Self {
        let (mut axes, mut halves) = (Vec::new(), Vec::new());
        for m in level.beads.iter().map(|&index| printed.bead(index)) {
            let wall = matches!(m.role, Role::OuterWall | Role::Overhang | Role::Bridge);
            if let (Some([from, to]), true) = (m.ends(), wall || !printed.has_roles) {
                axes.push([[from.x, from.y], [to.x, to.y]]);
                halves.push(printed.width(&m, level) / 2.0);
            }
        }
        let widest = halves.iter().fold(0.0, |most: f64, half| most.max(2.0 * half));
        Self { axes: Segments::new(axes), halves, widest }
    }

    /// Whether a wall's middle runs within half its width and `off` of `p`.
    fn beside(&self, p: PlanePoint, off: f64, last: &mut Option<u32>) -> bool {
        let Some(near) = self.axes.nearest(p, self.widest / 2.0 + off, *last) else { return false };
        *last = Some(near.index);
        near.distance <= self.halves[near.index as usize] + off
    }
}

/// Visits places along the segments with their outward normals, their segments and the length that each stands for; that is 0 for
/// places between the ends of long segments, which are visited too: of a small island's sides nothing else may be far enough from
/// its corners.
fn each_place(segments: &[Segment], visit: impl FnMut(PlanePoint, PlanePoint, usize, f64)) {
    each_place_of(segments.iter().copied(), visit);
}

fn each_place_of(segments: impl Iterator<Item = Segment>, mut visit: impl FnMut(PlanePoint, PlanePoint, usize, f64)) {
    let mut owed = SPACING_MM / 2.0;
    for (index, [a, b]) in segments.enumerate() {
        let [dx, dy] = [b[0] - a[0], b[1] - a[1]];
        let length = (dx * dx + dy * dy).sqrt();
        let at = |share: f64| [a[0] + dx * share, a[1] + dy * share];
        let normal = [dy / length, -dx / length];
        if length >= SPACING_MM / 2.0 {
            [0.25, 0.5, 0.75].into_iter().for_each(|share| visit(at(share), normal, index, 0.0));
        }
        while owed <= length {
            visit(at(owed / length), normal, index, SPACING_MM);
            owed += SPACING_MM;
        }
        owed -= length;
    }
}

/// Whether a disc of this radius touches the outline at `p` from inside.
fn holds_disc(search: &mut OutlineSearch<'_>, p: PlanePoint, normal: PlanePoint, radius: f64) -> bool {
    let middle = [0, 1].map(|i| p[i] - normal[i] * radius);
    search.signed_distance(middle) <= ROUNDING_MM - radius
}

/// Whether air begins at `p`: it is no seam of two overlapping shells, and no slit that slicers close. One that is wider than those by
/// less than the rounding counts as closed too.
fn begins_air(search: &mut OutlineSearch<'_>, p: PlanePoint, normal: PlanePoint) -> bool {
    let middle = [0, 1].map(|i| p[i] + normal[i] * (CLOSED_MM + ROUNDING_MM));
    search.signed_distance(middle) >= CLOSED_MM
}

/// Whether the outline is where it is a little above and below too: a face in the layer's middle belongs to either side.
fn is_no_step(printed: &PrintedPart<'_>, level: &Level, p: PlanePoint) -> bool {
    let middle = level.middle();
    [-EITHER_WAY_MM, EITHER_WAY_MM].into_iter().all(|by| {
        let distance = printed.sections.at(middle + by).signed_distance(p);
        distance.abs() <= OFF_MM[0]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two blocks beside each other, the gap between them so wide.
    fn slit(gap: f64) -> Section {
        let block = |x: [f64; 2]| {
            let corners = [[x[0], 0.0], [x[1], 0.0], [x[1], 4.0], [x[0], 4.0]];
            (0..4).map(move |i| [corners[i], corners[(i + 1) % 4]])
        };
        Section::new(block([-5.0, 0.0]).chain(block([gap, gap + 5.0])).collect())
    }

    #[test]
    fn what_slicers_close_is_no_outline() {
        // PrusaSlicer and Slic3r close gaps up to 0.098 mm; a fork of 0.08 mm in a real part was held to have walls on both sides.
        for (gap, air) in
            [(0.0, false), (0.03, false), (0.08, false), (0.098, false), (0.13, true), (0.3, true), (5.0, true)]
        {
            let section = slit(gap);
            assert_eq!(begins_air(&mut section.search(), [0.0, 2.0], [1.0, 0.0]), air, "{gap} mm");
            assert!(begins_air(&mut section.search(), [-5.0, 2.0], [-1.0, 0.0]), "{gap} mm: the far side");
        }
    }
}
