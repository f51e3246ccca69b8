//! Rule `registration`, place by place: along the whole outline of each layer runs a wall.
//!
//! Where a disc somewhat wider than a line touches the outline from inside, every slicer lays its outer wall there: the middle of
//! it half a line inside, give or take what it compensates. So places of the outline are looked at in turn, and where no line
//! runs beside one, it must be a corner, or a piece too narrow for a wall.

use super::prints::{Level, Printed};
use super::report::{Findings, Place, Rule};
use crate::gcode::marks::Role;
use crate::section::{Point, Search, Section, Segment, Segments};

/// Spacing of the places, mm.
const SPACING_MM: f64 = 1.0;
/// How much of a layer's outline may be without a wall, mm: seams, and what two slicers round differently.
const MOST_BARE_MM: f64 = 3.0;
/// How far a wall may lie off its place, mm; in the first layer an elephant's foot is compensated.
const OFF_MM: [f64; 2] = [0.2, 0.45];
/// The disc's radius, in line widths, and how far it may leave the part, mm.
const DISC_WIDTHS: f64 = 1.15;
const ROUNDING_MM: f64 = 0.02;
/// How far up and down a layer is looked at for faces that lie in its middle, mm.
const EITHER_WAY_MM: f64 = 0.02;

/// Holds the walls of one layer against its outline; they lie `offset` mm farther out than half a line.
pub(super) fn check(printed: &Printed<'_>, level: &Level, section: &Section, offset: f64, findings: &mut Findings) {
    let walls = Walls::of(printed, level);
    let first = std::ptr::eq(level, &raw const printed.levels[0]);
    let off = OFF_MM[usize::from(first)];
    let mut bare = Bare { length: 0.0, at: [0.0; 2] };
    let mut last = None;
    let mut search = section.search();
    each_place(section.segments(), |p, normal, length| {
        if walls.beside(p, off - offset, &mut last) || !asks_for_a_wall(&mut search, p, normal, walls.widest) {
            return;
        }
        if is_no_step(printed, level, p) {
            bare.length += length;
            bare.at = p;
        }
    });
    if bare.length > MOST_BARE_MM {
        let at = Place { line: level.line, slot: Some(printed.planned.slot), part: Some(printed.planned.part) };
        let (Bare { length, at: [x, y] }, part) = (bare, printed.planned.part);
        findings.add(Rule::Registration, at, [length, MOST_BARE_MM], || {
            format!(
                "{length:.1} mm of the outline of part {part} at Z {:.2} have no wall beside them, at X {x:.2} Y {y:.2} for one; at \
                 most {MOST_BARE_MM} mm",
                level.z
            )
        });
    }
}

struct Bare {
    length: f64,
    at: Point,
}

/// The middles of a layer's walls.
struct Walls {
    axes: Segments,
    halves: Vec<f64>,
    widest: f64,
}

impl Walls {
    fn of(printed: &Printed<'_>, level: &Level) -> Self {
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
    fn beside(&self, p: Point, off: f64, last: &mut Option<u32>) -> bool {
        let Some(near) = self.axes.nearest(p, self.widest / 2.0 + off, *last) else { return false };
        *last = Some(near.index);
        near.distance <= self.halves[near.index as usize] + off
    }
}

/// Visits places along the segments with their outward normals and the length that each stands for.
fn each_place(segments: &[Segment], mut visit: impl FnMut(Point, Point, f64)) {
    let mut owed = SPACING_MM / 2.0;
    for [a, b] in segments {
        let [dx, dy] = [b[0] - a[0], b[1] - a[1]];
        let length = (dx * dx + dy * dy).sqrt();
        while owed <= length {
            let share = owed / length;
            visit([a[0] + dx * share, a[1] + dy * share], [dy / length, -dx / length], SPACING_MM);
            owed += SPACING_MM;
        }
        owed -= length;
    }
}

/// Whether a disc a little wider than a line touches the outline at `p` from inside, and air begins there.
fn asks_for_a_wall(search: &mut Search<'_>, p: Point, normal: Point, width: f64) -> bool {
    let beyond = |mm: f64| [0, 1].map(|i| p[i] + normal[i] * mm);
    let radius = DISC_WIDTHS * width;
    search.signed_distance(beyond(-radius)) <= ROUNDING_MM - radius && search.signed_distance(beyond(ROUNDING_MM)) > 0.0
}

/// Whether the outline is where it is a little above and below too: a face in the layer's middle belongs to either side.
fn is_no_step(printed: &Printed<'_>, level: &Level, p: Point) -> bool {
    let middle = level.z - level.height() / 2.0;
    [-EITHER_WAY_MM, EITHER_WAY_MM].into_iter().all(|by| {
        let distance = printed.sections.at(middle + by).signed_distance(p);
        distance.abs() <= OFF_MM[0]
    })
}
