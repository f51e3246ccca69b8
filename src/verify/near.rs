//! How near a piece of the head comes to single beads and to the table: the distance itself, where the height field has only a
//! bound.
//!
//! A bead is taken as the box that its width and height fill along its axis, a line's end as half a width longer. What earlier
//! setups have laid stands still while a setup lasts, so that a distance once known stays a bound wherever the tip goes from
//! there: `distance - way`.

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

/// The beads of one print in one cell.
struct Group {
    print: Option<u32>,
    /// The highest point of them.
    top: f64,
    /// A box that holds their axes, and how far the thickest reaches from its own, mm.
    axes: Bounds,
    reach: f64,
    beads: Vec<u32>,
}

/// Beads by place, machine coordinates.
#[derive(Default)]
struct Cells {
    beads: Vec<Bead>,
    by_cell: HashMap<[i32; 2], Vec<Group>>,
    /// The last question in which each bead was looked at.
    asked: Vec<u32>,
    question: u32,
}

impl Cells {
    fn file(&mut self, bead: Bead) {
        let (index, top) = (self.beads.len() as u32, top(&bead));
        let [columns, rows] = cells(&Bounds::of(bead.ends).inflated(bead.radius));
        for row in rows {
            for column in columns.clone() {
                let groups = self.by_cell.entry([column, row]).or_default();
                let place = groups.iter().position(|group| group.print == bead.print).unwrap_or_else(|| {
                    groups.push(Group { print: bead.print, top, axes: Bounds::EMPTY, reach: 0.0, beads: Vec::new() });
                    groups.len() - 1
                });
                let group = &mut groups[place];
                group.top = group.top.max(top);
                group.axes = group.axes.union(&Bounds::of(bead.ends));
                group.reach = group.reach.max(bead.reach());
                group.beads.push(index);
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
        let low = piece.bounds.min.z;
        for row in rows {
            for cell in columns.clone().filter_map(|column| self.by_cell.get(&[column, row])) {
                for group in cell.iter().filter(|group| counts(group.print)) {
                    if low - group.top >= least || piece.bound(&group.axes, group.reach, least) >= least {
                        continue;
                    }
                    for &index in &group.beads {
                        if std::mem::replace(&mut self.asked[index as usize], self.question) == self.question {
                            continue;
                        }
                        let bead = &self.beads[index as usize];
                        let bound = piece.bound_of_line(bead, least);
                        least = match bound {
                            far if far >= least => least,
                            near if near < exact => least.min(piece.from_bead(bead, least).max(near)),
                            between => between,
                        };
                    }
                }
            }
        }
        least
    }
}

/// No point of a bead is higher.
fn top(bead: &Bead) -> f64 {
    bead.ends[0].z.max(bead.ends[1].z) + bead.radius
}

fn cells(bounds: &Bounds) -> [std::ops::RangeInclusive<i32>; 2] {
    [0, 1].map(|i| (bounds.min[i] / CELL_MM).floor() as i32..=(bounds.max[i] / CELL_MM).floor() as i32)
}

/// A piece of the head on its way from one place of the tip to another, and everything above it.
struct Swept<'a> {
    hull: &'a Hull,
    origins: [Vec3; 2],
    bounds: Bounds,
}

impl<'a> Swept<'a> {
    fn new(hull: &'a Hull, ends: [Vec3; 2]) -> Self {
        let origins = ends.map(|tip| hull.body.origin_at(&tip));
        let corners = origins.iter().flat_map(|o| [hull.bounds.min + o, hull.bounds.max + o]);
        Self { hull, origins, bounds: Bounds::of(corners) }
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

    /// The same for a bead.
    fn bound_of_line(&self, bead: &Bead, enough: f64) -> f64 {
        let ([p, q], reach) = (bead.ends, bead.reach());
        let along = |[x, y, z]: [f64; 3], v: &Vec3| x * v.x + y * v.y + z * v.z;
        self.by_planes(|normal| along(normal, &p).min(along(normal, &q)) - reach, enough)
    }

    /// The greatest of `least`, the least place of something along a plane's normal, before the piece's own.
    fn by_planes(&self, least: impl Fn([f64; 3]) -> f64, enough: f64) -> f64 {
        let [a, b] = self.origins;
        let mut most = f64::NEG_INFINITY;
        for &[x, y, z, c] in &self.hull.sides {
            let own = (x * a.x + y * a.y + z * a.z).max(x * b.x + y * b.y + z * b.z) + c;
            most = most.max(least([x, y, z]) - own);
            if most >= enough {
                break;
            }
        }
        most
    }

    fn from_bead(&self, bead: &Bead, enough: f64) -> f64 {
        separation(|d| self.support(d) - bead.support(&-d), enough).distance()
    }

    fn from_slab(&self, slab: &[Vec3], enough: f64) -> f64 {
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
        let slab = if among.table() { swept.from_slab(&self.slab, far).min(far) } else { far };
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
