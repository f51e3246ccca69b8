//! How near a piece of the head comes to single beads and to the table: the distance itself, where the height field has only a
//! bound.
//!
//! A bead is taken as its width and height along its axis, with round ends. What earlier setups have laid stands still while a
//! setup lasts, so that a distance once known stays a bound wherever the tip goes from there: `distance - way`.

use std::cell::Cell;

use super::hull::Hull;
use super::material::{LaidBead, Material};
use crate::geom::convex::{separation, support};
use crate::geom::nearest::nearest_pair;
use crate::geom::{Bounds, Machine, Rigid, Table, Vec3};

/// Edge of a cell by which beads are found, mm, and how many stand beside each other.
const CELL_MM: f64 = 4.0;
const CELLS: usize = 64;
/// Height of what is held apart in a cell, mm.
const PILE_MM: f64 = 2.0;
/// How much farther than asked is looked, so that the answer serves for the moves that follow, mm.
const AHEAD_MM: f64 = 1.0;
/// The head's upward reach, and the table's downward, mm; beyond any machine.
const UPWARD: f64 = 2000.0;

/// Nearer than this is touching, mm.
const TOUCHING_MM: f64 = 1e-3;

/// What rounding to 32 bits may take off a coordinate below 1 m, mm, and more.
const ROUNDING_MM: f32 = 3e-4;

/// A bead's axis and how far it reaches from it: all that tells most of them apart, side by side in memory.
#[derive(Clone, Copy)]
struct Line {
    ends: [[f32; 3]; 2],
    reach: f32,
    bead: u32,
}

/// Beads with a box that holds their axes, and how far the thickest reaches from its own, mm.
struct Pile {
    axes: Bounds,
    reach: f64,
    /// In the order in which they were laid.
    lines: Vec<Line>,
}

impl Pile {
    const EMPTY: Self = Self { axes: Bounds::EMPTY, reach: 0.0, lines: Vec::new() };

    fn hold(&mut self, axis: &Bounds, reach: f64) {
        self.axes = self.axes.union(axis);
        self.reach = self.reach.max(reach);
    }

    /// Those of the first `count` that were filed.
    fn laid(&self, count: usize) -> &[Line] {
        match self.lines.last() {
            Some(last) if last.bead as usize >= count => {
                &self.lines[..self.lines.partition_point(|line| (line.bead as usize) < count)]
            }
            _ => &self.lines,
        }
    }
}

/// The beads of one print over one cell: all of them without their lines, and by height.
struct Group {
    print: Option<u32>,
    all: Pile,
    by_height: Vec<(Storey, Pile)>,
}

/// Where a bead begins, and how far it rises: a steep one among level ones would make a pile of theirs as high as itself.
#[derive(Clone, Copy, PartialEq)]
struct Storey {
    /// In piles, downward.
    bottom: i32,
    /// In piles, as a power of two, upward.
    rise: i32,
}

impl Storey {
    fn of(axis: &Bounds) -> Self {
        let rise = ((axis.max.z - axis.min.z) / PILE_MM).max(1.0).log2().ceil();
        Self { bottom: (axis.min.z / PILE_MM).floor() as i32, rise: rise as i32 }
    }
}

/// Beads by place, machine coordinates, in the order in which they were laid.
struct Cells {
    beads: Vec<LaidBead>,
    /// Of the grid.
    low: [f64; 2],
    by_cell: Vec<Vec<Group>>,
}

impl Cells {
    /// Nothing yet; most of what comes lies about `middle`.
    fn about(middle: &Vec3) -> Self {
        let half = CELLS as f64 * CELL_MM / 2.0;
        let by_cell = std::iter::repeat_with(Vec::new).take(CELLS * CELLS).collect();
        let low = [middle.x - half, middle.y - half];
        Self { beads: Vec::new(), low, by_cell }
    }

    fn file(&mut self, bead: LaidBead) {
        let ends = bead.ends.map(|p| [p.x as f32, p.y as f32, p.z as f32]);
        let reach = bead.radius;
        let line = Line { ends, reach: reach as f32 + ROUNDING_MM, bead: self.beads.len() as u32 };
        let axis = Bounds::of(bead.ends);
        let storey = Storey::of(&axis);
        for cell in self.cells(&axis.inflated(bead.radius)) {
            let groups = &mut self.by_cell[cell];
            let place = groups.iter().position(|group| group.print == bead.print).unwrap_or_else(|| {
                groups.push(Group { print: bead.print, all: Pile::EMPTY, by_height: Vec::new() });
                groups.len() - 1
            });
            let group = &mut groups[place];
            group.all.hold(&axis, reach);
            let place = group.by_height.iter().rposition(|(at, _)| *at == storey).unwrap_or_else(|| {
                group.by_height.push((storey, Pile::EMPTY));
                group.by_height.len() - 1
            });
            let pile = &mut group.by_height[place].1;
            pile.hold(&axis, reach);
            pile.lines.push(line);
        }
        self.beads.push(bead);
    }

    /// The cells that a box touches; those at the border also stand for all beyond.
    fn cells(&self, bounds: &Bounds) -> impl Iterator<Item = usize> + use<> {
        let [columns, rows] = [0, 1].map(|i| {
            let index = |v: f64| (((v - self.low[i]) / CELL_MM).max(0.0) as usize).min(CELLS - 1);
            index(bounds.min[i])..=index(bounds.max[i])
        });
        rows.flat_map(move |row| columns.clone().map(move |column| row * CELLS + column))
    }

    /// Whether `piece` comes to less than `mm` from the circles about the beads' cross-sections.
    fn meets_circles(&self, piece: &Swept<'_>, mm: f64) -> bool {
        let near = |pile: &Pile| piece.bound(&pile.axes, pile.reach, mm) < mm;
        let nearer = |line: &Line| {
            piece.bound_of_line(line, mm) < mm && piece.to_circles(&self.beads[line.bead as usize], mm) < mm
        };
        self.cells(&piece.bounds.inflated(mm)).flat_map(|cell| &self.by_cell[cell]).any(|group| {
            near(&group.all)
                && group.by_height.iter().any(|(_, pile)| near(pile) && pile.lines.iter().rev().any(nearer))
        })
    }

    /// Whether one of the prints that `counts` names is nearer than `mm` to `piece`, by its first `laid` beads.
    fn is_nearer(&self, piece: &Swept<'_>, mm: f64, laid: usize, counts: impl Fn(Option<u32>) -> bool) -> bool {
        let near = |pile: &Pile| piece.bound(&pile.axes, pile.reach, mm) < mm;
        let nearer =
            |line: &Line| piece.bound_of_line(line, mm) < mm && piece.to_bead(&self.beads[line.bead as usize], mm) < mm;
        self.cells(&piece.bounds.inflated(mm)).flat_map(|cell| &self.by_cell[cell]).any(|group| {
            counts(group.print)
                && near(&group.all)
                && group.by_height.iter().any(|(_, pile)| near(pile) && pile.laid(laid).iter().rev().any(nearer))
        })
    }

    /// The distance of the bead that looks nearest, so that little else is left to look at; at most `cap`.
    fn at_most(&self, piece: &Swept<'_>, cap: f64, laid: usize, counts: &impl Fn(Option<u32>) -> bool) -> f64 {
        let mut nearest: Option<(f64, &Pile)> = None;
        self.each_pile(piece, cap, counts, |pile, bound| {
            if nearest.is_none_or(|(least, _)| bound < least) && !pile.laid(laid).is_empty() {
                nearest = Some((bound, pile));
            }
        });
        let Some((_, pile)) = nearest else { return cap };
        let (mut least, mut bead) = (cap, None);
        for line in pile.laid(laid) {
            let bound = piece.bound_of_line(line, least);
            if bound < least {
                (least, bead) = (bound, Some(line.bead));
            }
        }
        bead.map_or(cap, |bead| piece.to_bead(&self.beads[bead as usize], cap).min(cap))
    }

    /// Visits the piles that may be nearer than `cap`, with a bound of their distance.
    fn each_pile<'a>(
        &'a self,
        piece: &Swept<'_>,
        cap: f64,
        counts: &impl Fn(Option<u32>) -> bool,
        mut visit: impl FnMut(&'a Pile, f64),
    ) {
        for group in self.cells(&piece.bounds.inflated(cap)).flat_map(|cell| &self.by_cell[cell]) {
            if !counts(group.print) || piece.bound(&group.all.axes, group.all.reach, cap) >= cap {
                continue;
            }
            for (_, pile) in &group.by_height {
                let bound = piece.bound(&pile.axes, pile.reach, cap);
                if bound < cap {
                    visit(pile, bound);
                }
            }
        }
    }

    /// The least distance of the first `laid` beads of the prints that `counts` names from `piece`: the distance itself where it is
    /// below `exact` mm, else a bound of it, up to `cap`.
    fn distance(
        &self,
        piece: &Swept<'_>,
        [exact, cap]: [f64; 2],
        laid: usize,
        counts: impl Fn(Option<u32>) -> bool,
    ) -> f64 {
        let cap = self.at_most(piece, cap, laid, &counts);
        let mut candidates: Vec<(f64, u32)> = Vec::new();
        self.each_pile(piece, cap, &counts, |pile, _| {
            let bounds = pile.laid(laid).iter().map(|line| (piece.bound_of_line(line, cap), line.bead));
            candidates.extend(bounds.filter(|(bound, _)| *bound < cap));
        });
        // The nearest first: most of the others need not be looked at then. Long ones stand in several cells.
        candidates.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        candidates.dedup();
        let mut least = cap;
        for (bound, bead) in candidates {
            if bound >= least {
                break;
            }
            if bound >= exact {
                least = bound;
                break;
            }
            least = least.min(piece.to_bead(&self.beads[bead as usize], least).max(bound));
        }
        least
    }
}

/// Where the tip goes.
#[derive(Clone, Copy)]
pub(super) enum TipWay {
    /// Straight from one place to another.
    Line([Vec3; 2]),
    /// Anywhere within a box.
    Within(Bounds),
}

impl TipWay {
    /// Its place farthest along `d`.
    fn support(&self, d: &Vec3) -> Vec3 {
        match self {
            Self::Line([a, b]) => *if a.dot(d) > b.dot(d) { a } else { b },
            Self::Within(all) => Vec3::from_fn(|i, _| if d[i] > 0.0 { all.max[i] } else { all.min[i] }),
        }
    }

    fn bounds(&self) -> Bounds {
        match self {
            Self::Line(ends) => Bounds::of(*ends),
            Self::Within(all) => *all,
        }
    }

    /// The way of a body's origin.
    fn of_origin(&self, hull: &Hull) -> Self {
        match self {
            Self::Line(ends) => Self::Line(ends.map(|tip| hull.body.origin_at(&tip))),
            Self::Within(all) => {
                Self::Within(Bounds { min: hull.body.origin_at(&all.min), max: hull.body.origin_at(&all.max) })
            }
        }
    }

    /// How far any of its places is from `p` at most, mm.
    fn farthest(&self, p: Vec3) -> f64 {
        match self {
            Self::Line(ends) => ends.iter().map(|end| (end - p).norm()).fold(0.0, f64::max),
            Self::Within(all) => (all.min - p).abs().sup(&(all.max - p).abs()).norm(),
        }
    }

    /// A place of it.
    fn end(&self) -> Vec3 {
        match self {
            Self::Line([_, end]) => *end,
            Self::Within(all) => all.centre(),
        }
    }
}

/// A piece of the head on its way, and everything above it.
struct Swept<'a> {
    hull: &'a Hull,
    origins: TipWay,
    bounds: Bounds,
    /// Where the way ends along the normal of each of the piece's planes.
    ends: Vec<f64>,
    /// The plane that told something far last, which is tried first.
    telling: Cell<usize>,
    /// Piles and lines that have been looked at.
    looked_at: &'a Cell<u64>,
}

impl<'a> Swept<'a> {
    fn new(hull: &'a Hull, way: &TipWay, looked_at: &'a Cell<u64>) -> Self {
        let origins = way.of_origin(hull);
        let all = origins.bounds();
        let bounds = Bounds { min: hull.bounds.min + all.min, max: hull.bounds.max + all.max };
        let end = |&[x, y, z, c]: &[f64; 4]| {
            let normal = Vec3::new(x, y, z);
            normal.dot(&origins.support(&normal)) + c
        };
        let ends = hull.sides.iter().map(end).collect();
        Self { hull, origins, bounds, ends, telling: Cell::new(0), looked_at }
    }

    fn support(&self, d: &Vec3) -> Vec3 {
        let lift = if d.z > 0.0 { Vec3::z() * UPWARD } else { Vec3::zeros() };
        support(&self.hull.body.points, d) + self.origins.support(d) + lift
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
        self.looked_at.set(self.looked_at.get() + 1);
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

    fn to_bead(&self, bead: &LaidBead, enough: f64) -> f64 {
        separation(|d| self.support(d) - bead.support(&-d), enough).distance()
    }

    /// The same of the circle about its cross-section along its axis, which the field holds.
    fn to_circles(&self, bead: &LaidBead, enough: f64) -> f64 {
        let [a, b] = bead.ends;
        let axis = |d: &Vec3| if a.dot(d) > b.dot(d) { a } else { b };
        separation(|d| self.support(d) - axis(&-d), enough + bead.radius).distance() - bead.radius
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

/// What a run of moves of one print must stay away from.
#[derive(Clone, Copy)]
pub(super) struct Strangers<'a> {
    /// By print, whether it is one.
    pub(super) prints: &'a [bool],
    /// Whether the table is.
    pub(super) table: bool,
    /// How many beads had been laid, of all, when the run began.
    pub(super) laid: usize,
}

impl Strangers<'_> {
    fn counts(&self, print: Option<u32>) -> bool {
        print.is_none_or(|p| self.prints[p as usize])
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
    looked_at: Cell<u64>,
}

impl Near {
    /// Nothing filed yet: most setups need none of it.
    pub(super) fn new(motion: Rigid<Table, Machine>, material: &Material, pieces: usize) -> Self {
        let slab = material.slab().iter().map(|&p| motion.point(p.into()).at).collect();
        let middle = motion.point(Vec3::zeros().into()).at;
        Self {
            motion,
            slab,
            earlier: Cells::about(&middle),
            earlier_beads: material.beads().len(),
            own: Cells::about(&middle),
            filed: 0,
            known: vec![None; pieces],
            looked_at: Cell::new(0),
        }
    }

    /// How many piles and lines have been looked at: what the answers have cost.
    pub(super) fn looked_at(&self) -> u64 {
        self.looked_at.get()
    }

    /// The distance (mm) between `hull`, piece number `piece`, on the tip's way, and all that has been laid and the table; from `cap` on
    /// not told apart, 0 where they meet.
    pub(super) fn distance(&mut self, material: &Material, piece: usize, hull: &Hull, way: &TipWay, cap: f64) -> f64 {
        self.file(material);
        let swept = Swept::new(hull, way, &self.looked_at);
        let growing = self.own.distance(&swept, [cap; 2], usize::MAX, |_| true);
        if self.known[piece].is_some_and(|known| known.mm - way.farthest(known.at) >= growing) {
            return growing;
        }
        let far = cap + AHEAD_MM;
        let slab = swept.to_slab(&self.slab, far).min(far);
        let still = self.earlier.distance(&swept, [cap, slab], usize::MAX, |_| true);
        self.known[piece] = Some(Known { at: way.end(), mm: still });
        still.min(growing)
    }

    /// Whether `hull` on the tip's way, with all above it, meets the table or a bead with the circle about its cross-section: what the
    /// field holds, without its cells.
    pub(super) fn meets(&mut self, material: &Material, hull: &Hull, way: &TipWay) -> bool {
        self.file(material);
        let swept = Swept::new(hull, way, &self.looked_at);
        let touches = |cells: &Cells| cells.meets_circles(&swept, TOUCHING_MM);
        swept.to_slab(&self.slab, TOUCHING_MM) < TOUCHING_MM || touches(&self.earlier) || touches(&self.own)
    }

    /// Whether `hull` on the tip's way, with all above it, meets the table.
    pub(super) fn meets_table(&self, hull: &Hull, way: &TipWay) -> bool {
        Swept::new(hull, way, &self.looked_at).to_slab(&self.slab, TOUCHING_MM) < TOUCHING_MM
    }

    /// The same between `hull` and `strangers`.
    pub(super) fn room_to_strangers(
        &mut self,
        material: &Material,
        hull: &Hull,
        way: &TipWay,
        cap: f64,
        strangers: &Strangers<'_>,
    ) -> f64 {
        self.file(material);
        let swept = Swept::new(hull, way, &self.looked_at);
        let counts = |print: Option<u32>| strangers.counts(print);
        let own = strangers.laid.saturating_sub(self.earlier_beads);
        let slab = if strangers.table { swept.to_slab(&self.slab, cap).min(cap) } else { cap };
        let earlier = self.earlier.distance(&swept, [slab; 2], usize::MAX, counts);
        self.own.distance(&swept, [earlier; 2], own, counts)
    }

    /// Where `hull` on the tip's way and the nearest of what it must stay away from (all, or `strangers`), no more than `mm` apart, are
    /// nearest: a place of each, machine frame, and the origin of the hull's body there. `None` where they meet.
    pub(super) fn nearest(
        &self,
        hull: &Hull,
        way: &TipWay,
        mm: f64,
        strangers: Option<&Strangers<'_>>,
    ) -> Option<[Vec3; 3]> {
        let swept = Swept::new(hull, way, &self.looked_at);
        let counts = |print: Option<u32>| strangers.is_none_or(|strangers| strangers.counts(print));
        let own = strangers.map_or(usize::MAX, |strangers| strangers.laid.saturating_sub(self.earlier_beads));
        let mut least = (mm, None);
        for (cells, laid) in [(&self.earlier, usize::MAX), (&self.own, own)] {
            cells.each_pile(&swept, mm, &counts, |pile, _| {
                for line in pile.laid(laid) {
                    let bead = &cells.beads[line.bead as usize];
                    if swept.bound_of_line(line, least.0) < least.0 {
                        let far = swept.to_bead(bead, least.0);
                        if far < least.0 {
                            least = (far, Some(bead));
                        }
                    }
                }
            });
        }
        let table = strangers.is_none_or(|strangers| strangers.table) && swept.to_slab(&self.slab, least.0) < least.0;
        let bead = if table { None } else { Some(least.1?) };
        nearest_pair(|d| {
            let other = bead.map_or_else(|| support(&self.slab, &-d), |bead| bead.support(&-d));
            [swept.support(d), other, swept.origins.support(d)]
        })
    }

    /// Whether that is less than `mm`.
    pub(super) fn is_nearer(
        &mut self,
        material: &Material,
        hull: &Hull,
        way: &TipWay,
        mm: f64,
        strangers: &Strangers<'_>,
    ) -> bool {
        let counts = |print: Option<u32>| strangers.counts(print);
        // A print that is alone is asked about at each move, and its beads need not be filed for that.
        let laid = material.has_any(counts);
        if laid {
            self.file(material);
        }
        let swept = Swept::new(hull, way, &self.looked_at);
        if strangers.table && swept.to_slab(&self.slab, mm) < mm {
            return true;
        }
        if !laid {
            return false;
        }
        let own = strangers.laid.saturating_sub(self.earlier_beads);
        self.earlier.is_nearer(&swept, mm, usize::MAX, counts) || self.own.is_nearer(&swept, mm, own, counts)
    }

    fn file(&mut self, material: &Material) {
        for (index, bead) in material.beads().iter().enumerate().skip(self.filed) {
            let cells = if index < self.earlier_beads { &mut self.earlier } else { &mut self.own };
            cells.file(bead.at(&self.motion));
        }
        self.filed = material.beads().len();
    }
}
