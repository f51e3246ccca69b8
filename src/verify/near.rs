//! How near a piece of the head comes to single beads and to the table: the distance itself, where the height field has only a
//! bound.
//!
//! A bead is taken as the box that its width and height fill along its axis, a line's end as half a width longer. What earlier
//! setups have laid stands still while a setup lasts, so that a distance once known stays a bound wherever the tip goes from
//! there: `distance - way`.

use std::cell::Cell;
use std::collections::HashMap;

use super::acts::Stroke;
use super::hull::Hull;
use super::material::{Bead, Material};
use crate::geom::convex::{separation, support};
use crate::geom::{Bounds, Machine, Rigid, Table, Vec3};

/// Edge of a cell by which beads are found, mm.
const CELL_MM: f64 = 4.0;
/// How much farther than asked is looked, so that the answer serves for the moves that follow, mm.
const AHEAD_MM: f64 = 1.0;
/// The head's upward reach, and the table's downward, mm; beyond any machine.
const UPWARD: f64 = 2000.0;

/// What rounding to 32 bits may take off a coordinate below 1 m, mm, and more.
const ROUNDING_MM: f32 = 3e-4;

/// A bead's axis and how far it reaches from it: all that tells most of them apart, side by side in memory.
#[derive(Clone, Copy)]
struct Line {
    ends: [[f32; 3]; 2],
    reach: f32,
    bead: u32,
}

/// The beads of one print in one cell.
struct Group {
    print: Option<u32>,
    /// A box that holds their axes, and how far the thickest reaches from its own, mm.
    axes: Bounds,
    reach: f64,
    lines: Vec<Line>,
}

/// Beads by place, machine coordinates.
#[derive(Default)]
struct Cells {
    beads: Vec<Bead>,
    by_cell: HashMap<[i32; 2], Vec<Group>>,
    /// The last question in which each bead's own distance was taken: long ones stand in several cells.
    asked: Vec<u32>,
    question: u32,
}

impl Cells {
    fn file(&mut self, bead: Bead) {
        let ends = bead.ends.map(|p| [p.x as f32, p.y as f32, p.z as f32]);
        let line = Line { ends, reach: bead.reach() as f32 + ROUNDING_MM, bead: self.beads.len() as u32 };
        let axis = Bounds::of(bead.ends);
        let [columns, rows] = cells(&axis.inflated(bead.radius));
        for row in rows {
            for column in columns.clone() {
                let groups = self.by_cell.entry([column, row]).or_default();
                let place = groups.iter().position(|group| group.print == bead.print).unwrap_or_else(|| {
                    groups.push(Group { print: bead.print, axes: Bounds::EMPTY, reach: 0.0, lines: Vec::new() });
                    groups.len() - 1
                });
                let group = &mut groups[place];
                group.axes = group.axes.union(&axis);
                group.reach = group.reach.max(bead.reach());
                group.lines.push(line);
            }
        }
        self.beads.push(bead);
        self.asked.push(0);
    }

    /// The least distance of the prints that `counts` names from `piece`: the distance itself where it is below `exact` mm, else a
    /// bound of it, up to `cap`.
    fn distance(&mut self, piece: &Swept<'_>, [exact, cap]: [f64; 2], counts: impl Fn(Option<u32>) -> bool) -> f64 {
        let mut least = cap;
        self.question += 1;
        let [columns, rows] = cells(&piece.bounds.inflated(cap));
        for row in rows {
            for cell in columns.clone().filter_map(|column| self.by_cell.get(&[column, row])) {
                for group in cell.iter().filter(|group| counts(group.print)) {
                    if piece.bound(&group.axes, group.reach, least) >= least {
                        continue;
                    }
                    for line in &group.lines {
                        let bound = piece.bound_of_line(line, least);
                        if bound >= least {
                            continue;
                        }
                        let bead = line.bead as usize;
                        if bound >= exact {
                            least = bound;
                        } else if std::mem::replace(&mut self.asked[bead], self.question) != self.question {
                            least = least.min(piece.to_bead(&self.beads[bead], least).max(bound));
                        }
                    }
                }
            }
        }
        least
    }
}

fn cells(bounds: &Bounds) -> [std::ops::RangeInclusive<i32>; 2] {
    [0, 1].map(|i| (bounds.min[i] / CELL_MM).floor() as i32..=(bounds.max[i] / CELL_MM).floor() as i32)
}

/// A piece of the head on its way from one place of the tip to another, and everything above it.
struct Swept<'a> {
    hull: &'a Hull,
    origins: [Vec3; 2],
    bounds: Bounds,
    /// Where the way ends along the normal of each of the piece's planes.
    ends: Vec<f64>,
    /// The plane that told something far last, which is tried first.
    telling: Cell<usize>,
}

impl<'a> Swept<'a> {
    fn new(hull: &'a Hull, ends: [Vec3; 2]) -> Self {
        let origins = ends.map(|tip| hull.body.origin_at(&tip));
        let corners = origins.iter().flat_map(|o| [hull.bounds.min + o, hull.bounds.max + o]);
        let [a, b] = origins;
        let end = |&[x, y, z, c]: &[f64; 4]| (x * a.x + y * a.y + z * a.z).max(x * b.x + y * b.y + z * b.z) + c;
        let ends = hull.sides.iter().map(end).collect();
        Self { hull, origins, bounds: Bounds::of(corners), ends, telling: Cell::new(0) }
    }

    fn support(&self, d: &Vec3) -> Vec3 {
        let lift = if d.z > 0.0 { Vec3::z() * UPWARD } else { Vec3::zeros() };
        let [a, b] = self.origins;
        support(&self.hull.body.points, d) + if a.dot(d) > b.dot(d) { a } else { b } + lift
    }

    /// How far all within `reach` of `axes` is at least, by the piece's planes; of `enough` and more any value.
    fn bound(&self, axes: &Bounds, reach: f64, enough: f64) -> f64 {
        let near = |n: f64, i: usize| n * if n > 0.0 { axes.min[i] } else { axes.max[i] };
        self.by_planes(|[x, y, z]| near(x, 0) + near(y, 1) + near(z, 2) - reach, enough)
    }

    /// The same for a line.
    fn bound_of_line(&self, Line { ends: [p, q], reach, .. }: &Line, enough: f64) -> f64 {
        let along = |[x, y, z]: [f64; 3], v: &[f32; 3]| x * f64::from(v[0]) + y * f64::from(v[1]) + z * f64::from(v[2]);
        self.by_planes(|normal| along(normal, p).min(along(normal, q)) - f64::from(*reach), enough)
    }

    /// The greatest of `least`, the least place of something along a plane's normal, before the piece's own.
    fn by_planes(&self, least: impl Fn([f64; 3]) -> f64, enough: f64) -> f64 {
        let away = |i: usize| {
            let [x, y, z, _] = self.hull.sides[i];
            least([x, y, z]) - self.ends[i]
        };
        let mut most = away(self.telling.get());
        for plane in 0..self.ends.len() {
            if most >= enough {
                break;
            }
            let mm = away(plane);
            if mm > most {
                most = mm;
                self.telling.set(plane);
            }
        }
        most
    }

    fn to_bead(&self, bead: &Bead, enough: f64) -> f64 {
        separation(|d| self.support(d) - bead.support(&-d), enough).distance()
    }

    fn to_slab(&self, slab: &[Vec3], enough: f64) -> f64 {
        separation(|d| self.support(d) - support(slab, &-d), enough).distance()
    }
}

/// A distance known at a place of the tip.
#[derive(Clone, Copy)]
struct Known {
    at: Vec3,
    mm: f64,
}

/// What a distance is asked to.
#[derive(Clone, Copy)]
pub(super) enum Among<'a> {
    /// All that has been laid, and the table.
    All,
    /// The prints that are `strangers` to the one being laid, and the table if `table`.
    Strangers { strangers: &'a [bool], table: bool },
}

impl Among<'_> {
    fn counts(self, print: Option<u32>) -> bool {
        match self {
            Self::All => true,
            Self::Strangers { strangers, .. } => print.is_none_or(|p| strangers[p as usize]),
        }
    }

    fn table(self) -> bool {
        matches!(self, Self::All | Self::Strangers { table: true, .. })
    }

    /// Whether lines are added to it from move to move.
    fn grows(self) -> bool {
        matches!(self, Self::All)
    }
}

/// The beads and the table at one pose.
pub(super) struct Near {
    motion: Rigid<Table, Machine>,
    slab: Vec<Vec3>,
    /// Beads of setups before, of which there were so many.
    earlier: Cells,
    earlier_beads: usize,
    /// Beads of this setup.
    own: Cells,
    /// How many beads have been filed.
    filed: usize,
    /// By piece of the head, what is known of its distance from what stands still.
    known: Vec<Option<Known>>,
}

impl Near {
    /// Nothing filed yet: most setups need none of it.
    pub(super) fn new(motion: Rigid<Table, Machine>, material: &Material, pieces: usize) -> Self {
        let slab = material.slab().iter().map(|&p| motion.point(p.into()).at).collect();
        Self {
            motion,
            slab,
            earlier: Cells::default(),
            earlier_beads: material.beads().len(),
            own: Cells::default(),
            filed: 0,
            known: vec![None; pieces],
        }
    }

    /// Forgets distances: other things count from here on.
    pub(super) fn forget(&mut self, piece: usize) {
        self.known[piece] = None;
    }

    /// The distance (mm) between `hull`, piece number `piece`, on the tip's way between `ends`, and what `among` names; from `cap`
    /// on not told apart, 0 where they meet.
    pub(super) fn distance(
        &mut self,
        material: &Material,
        (piece, hull): (usize, &Hull),
        ends: [Vec3; 2],
        cap: f64,
        among: Among<'_>,
    ) -> f64 {
        self.file(material);
        let swept = Swept::new(hull, ends);
        let counts = |print: Option<u32>| among.counts(print);
        let growing = if among.grows() { self.own.distance(&swept, [cap; 2], counts) } else { cap };
        let way = |known: Known| ends.iter().map(|end| (end - known.at).norm()).fold(0.0, f64::max);
        if self.known[piece].is_some_and(|known| known.mm - way(known) >= growing) {
            return growing;
        }
        let far = cap + AHEAD_MM;
        let slab = if among.table() { swept.to_slab(&self.slab, far).min(far) } else { far };
        let mut still = self.earlier.distance(&swept, [cap, slab], counts);
        if !among.grows() {
            still = self.own.distance(&swept, [cap, still], counts);
        }
        self.known[piece] = Some(Known { at: ends[1], mm: still });
        still.min(growing)
    }

    fn file(&mut self, material: &Material) {
        for (index, bead) in material.beads().iter().enumerate().skip(self.filed) {
            let cells = if index < self.earlier_beads { &mut self.earlier } else { &mut self.own };
            cells.file(bead.at(&self.motion));
        }
        self.filed = material.beads().len();
    }
}

/// A box for each print, machine coordinates: what tells most moves that no stranger is near.
pub(super) struct Others {
    boxes: Vec<Bounds>,
    table: Bounds,
    known: Option<Known>,
}

impl Others {
    /// The boxes of what has been laid so far, and of the table.
    pub(super) fn new(motion: &Rigid<Table, Machine>, material: &Material, prints: usize) -> Self {
        let mut boxes = vec![Bounds::EMPTY; prints];
        for bead in material.beads() {
            if let Some(all) = bead.print.and_then(|p| boxes.get_mut(p as usize)) {
                let bead = bead.at(motion);
                *all = all.union(&Bounds::of(bead.ends).inflated(bead.radius));
            }
        }
        let table = Bounds::of(material.slab().iter().map(|&p| motion.point(p.into()).at));
        Self { boxes, table, known: None }
    }

    /// Another print's strangers are others.
    pub(super) fn forget(&mut self) {
        self.known = None;
    }

    /// A line is laid.
    pub(super) fn lay(&mut self, stroke: &Stroke) {
        if let Some(all) = stroke.print.and_then(|p| self.boxes.get_mut(p as usize)) {
            let line = Bounds::of([stroke.from, stroke.to]);
            *all = all.union(&line.inflated(f64::from(stroke.width.max(stroke.height))));
        }
    }

    /// Whether one of `strangers`, or the table where that is one, may be nearer than `cap` mm to `hull` on its way.
    pub(super) fn nearer(&mut self, strangers: &[bool], table: bool, hull: &Hull, ends: [Vec3; 2], cap: f64) -> bool {
        let way = |known: &Known| ends.iter().map(|end| (end - known.at).norm()).fold(0.0, f64::max);
        if self.known.as_ref().is_some_and(|known| known.mm - way(known) >= cap) {
            return false;
        }
        let piece = Swept::new(hull, ends).bounds;
        let boxes = self.boxes.iter().zip(strangers).filter(|(all, stranger)| **stranger && !all.is_empty());
        let all = boxes.map(|(all, _)| all).chain(table.then_some(&self.table));
        let mm = all.map(|all| below(&piece, all)).fold(f64::INFINITY, f64::min);
        self.known = Some(Known { at: ends[1], mm });
        mm < cap
    }
}

/// How far a box is from another and all above that.
fn below(piece: &Bounds, other: &Bounds) -> f64 {
    let sideways = [0, 1].map(|i| (other.min[i] - piece.max[i]).max(piece.min[i] - other.max[i]).max(0.0));
    let under = (piece.min.z - other.max.z).max(0.0);
    (sideways[0] * sideways[0] + sideways[1] * sideways[1] + under * under).sqrt()
}
