//! Where a print stands that was moved or turned on the slicer's bed.
//!
//! The part's own cross-sections are laid over the lines of the same layers. Coarsely by their support functions: in the direction
//! `u` the lines `p` and the part's corners `q`, turned by `t` and shifted by `s`, reach as far as each other but for half a line,
//!
//! ```text
//! max p.u = max (Rz(t) q).u + s.u - w/2        so over all u the shift is the first harmonic of the difference
//! ```
//!
//! and the turn is the one that leaves least. Then finely, by the outer walls' distances from the outline (`section::fit`). What was
//! scaled, mirrored or is another part leaves too much, and is refused with its measures. Lengths mm.

use std::f64::consts::{PI, TAU};
use std::ops::Range;

use super::export::{BoxMismatch, SlotMesh};
use super::inputs::RewriteError;
use super::items::{Item, Step3};
use super::sliced::SlicedPrint;
use super::source::SlicedError;
use super::turn::Turn;
use crate::gcode::marks::{Hint, Role, hint};
use crate::geom::{Bounds, Vec3};
use crate::motion::replay::{CHORD_MM, flatten};
use crate::profile::Profile;
use crate::section::{Fit, Sample, Section, Sections, fit};

/// Turns tried, and directions looked into for each.
const TURNS: usize = 720;
const EVERY: usize = 10;
/// Layers looked at.
const LAYERS: usize = 9;
/// A turn that leaves less than this more than the best one is looked at closely, mm.
const ALIKE_MM: f64 = 0.3;
/// Spacing of samples along a wall, and the most of them.
const SPACING_MM: f64 = 1.5;
const SAMPLES: usize = 4000;
/// A wall is at most so far from where it is expected: at first, and in the end where walls are named and where they are not.
const NEAR_MM: f64 = 1.9;
const FOUND_MM: f64 = 0.2;
/// Of the walls so many must be where the part has them; where none is named, of all lines.
const LEAST_FOUND: [f64; 2] = [0.6, 0.1];
/// What scale may explain at the farthest wall, mm.
const SCALE_MM: f64 = 0.1;
/// The lines of a print that was moved lie where they lay, to their last digits: the least of what the outline tells is told. See [`fit`].
const WEAKEST: f64 = 1e-3;
/// What is no change of size: slicers leave tips out and move walls a little.
const SAME_SIZE_MM: f64 = 0.6;

/// A print where it was found.
#[derive(Clone, Debug)]
pub struct Moved<'a> {
    /// As it would have been sliced unturned.
    pub sliced: SlicedPrint<'a>,
    /// Where the middle of its box is then.
    pub centre_mm: [f64; 2],
    /// Where it stands on the slicer's bed.
    pub at_mm: [f64; 2],
    /// By how much it was turned there, counter-clockwise, radians.
    pub turn: f64,
}

/// The print whose mesh `mesh` is, its box's middle at x = y = 0, wherever on the bed it was sliced.
///
/// # Errors
///
/// [`BoxMismatch`] where it is not that part, or was scaled or mirrored.
pub fn find_moved<'a>(
    mesh: &SlotMesh,
    sliced: &SlicedPrint<'a>,
    profile: &Profile,
) -> Result<Result<Moved<'a>, BoxMismatch>, RewriteError> {
    let seen = Seen::of(mesh, sliced, profile)?;
    let found = match seen.placed() {
        Ok(place) => place,
        Err(why) => return Ok(Err(why)),
    };
    let sliced = sliced.turned(Turn::by(-found.turn))?;
    let centre_mm = Turn::by(-found.turn).flat(found.shift);
    Ok(Ok(Moved { sliced, centre_mm, at_mm: found.shift, turn: found.turn }))
}

impl SlicedPrint<'_> {
    /// The same print with all its coordinates turned: everything behind the reader sees it as it was handed over.
    fn turned(&self, turn: Turn) -> Result<Self, SlicedError> {
        let mut new = Self { turn: Some(turn), ..self.clone() };
        let mut walk = new.walk();
        (new.extrusion, new.reach) = (Bounds::EMPTY, Bounds::EMPTY);
        let mut role = self.first_role();
        for layer in &mut new.layers {
            layer.extrusion = Bounds::EMPTY;
            while let Some(item) = walk.next(layer.end)? {
                let step = match item {
                    Item::Step(step) => step,
                    Item::Keep(span) => {
                        if let Some(Hint::Role(said)) = self.said(&span) {
                            role = said;
                        }
                        continue;
                    }
                    _ => continue,
                };
                if !step.prints() || role == Role::Adhesion {
                    new.reach.add(step.from);
                    new.reach.add(step.to);
                    continue;
                }
                layer.extrusion.add(step.from);
                layer.extrusion.add(step.to);
                if let Some(arc) = &step.arc {
                    flatten(step.from, step.to, arc, CHORD_MM).into_iter().for_each(|p| layer.extrusion.add(p));
                }
            }
            new.extrusion = new.extrusion.union(&layer.extrusion);
        }
        new.reach = new.reach.union(&new.extrusion);
        Ok(new)
    }

    /// By layer, the chords of what is laid there, mm, as the file has them; skirts and brims are not of it.
    ///
    /// # Errors
    ///
    /// What [`read_sliced`](super::read_sliced) says of lines.
    pub fn lines_by_layer(&self) -> Result<Vec<Vec<[[f64; 2]; 2]>>, SlicedError> {
        let mut walk = self.walk();
        let mut role = self.first_role();
        let mut all = Vec::with_capacity(self.layers.len());
        for layer in &self.layers {
            let mut lines = Vec::new();
            while let Some(item) = walk.next(layer.end)? {
                match item {
                    Item::Keep(span) => {
                        if let Some(Hint::Role(said)) = self.said(&span) {
                            role = said;
                        }
                    }
                    Item::Step(step) if step.prints() && role != Role::Adhesion => {
                        lines.extend(chords(&step).windows(2).map(|ends| [0, 1].map(|i| [ends[i].x, ends[i].y])));
                    }
                    _ => {}
                }
            }
            all.push(lines);
        }
        Ok(all)
    }

    /// What a comment says of the lines after it.
    fn said(&self, span: &Range<usize>) -> Option<Hint> {
        self.text(span).strip_prefix(b";").and_then(hint)
    }

    /// What the first line is: the lead says it, where the first layer begins with a skirt.
    fn first_role(&self) -> Role {
        let role = |span| if let Some(Hint::Role(role)) = self.said(span) { Some(role) } else { None };
        self.lead.iter().filter_map(role).next_back().unwrap_or_default()
    }
}

/// The places between which a step goes straight.
fn chords(step: &Step3) -> Vec<Vec3> {
    let mut points = vec![step.from];
    match &step.arc {
        Some(arc) => points.extend(flatten(step.from, step.to, arc, CHORD_MM)),
        None => points.push(step.to),
    }
    points
}

/// A layer's walls, and the part's section at its middle.
struct Seen {
    levels: Vec<Level>,
    has_roles: bool,
    /// Height of the lines' top and of the part.
    heights: [f64; 2],
}

struct Level {
    section: Section,
    corners: Vec<[f64; 2]>,
    ends: Vec<[f64; 2]>,
    walls: Vec<([f64; 2], f64)>,
}

#[derive(Clone, Copy, Debug)]
struct Placed {
    turn: f64,
    shift: [f64; 2],
    /// Root mean square of what is left, mm.
    left: f64,
}

impl Seen {
    fn of(mesh: &SlotMesh, sliced: &SlicedPrint<'_>, profile: &Profile) -> Result<Self, RewriteError> {
        let sections = Sections::of(&mesh.mesh);
        let count = sliced.layers.len();
        let step = count.div_ceil(LAYERS).max(1);
        let mut walk = sliced.walk();
        let (mut levels, mut below, mut has_roles) = (Vec::new(), 0.0, false);
        let mut role = sliced.first_role();
        let mut width = sliced.widths_mm.first().copied();
        for (index, layer) in sliced.layers.iter().enumerate() {
            let middle = (layer.z + below) / 2.0;
            below = layer.z;
            let wanted = index % step == step / 2;
            let (mut ends, mut walls) = (Vec::new(), Vec::new());
            while let Some(item) = walk.next(layer.end)? {
                let step = match item {
                    Item::Keep(span) => {
                        match sliced.said(&span) {
                            Some(Hint::Role(said)) => role = said,
                            Some(Hint::Width(mm)) => width = Some(mm),
                            _ => {}
                        }
                        continue;
                    }
                    Item::Step(step) if wanted && step.prints() && role != Role::Adhesion => step,
                    _ => continue,
                };
                let points = chords(&step);
                ends.extend(points.iter().map(|p| [p.x, p.y]));
                has_roles |= role == Role::OuterWall;
                let width = width.unwrap_or(profile.process.line_width_mm);
                walls.push((points, role, width));
            }
            let section = sections.at(middle);
            if wanted && !section.is_empty() && !ends.is_empty() {
                levels.push((section, ends, walls));
            }
        }
        let levels = levels.into_iter().map(|(section, ends, walls)| {
            let outer = walls.into_iter().filter(|(_, role, _)| !has_roles || *role == Role::OuterWall);
            let walls = outer.flat_map(|(points, _, width)| samples(&points, width)).collect();
            let corners = section.segments().iter().map(|[a, _]| *a).collect();
            Level { section, corners, ends, walls }
        });
        let heights = [sliced.extrusion.max.z, mesh.mesh.bounds().max.z];
        Ok(Self { levels: levels.collect(), has_roles, heights })
    }

    /// The turn and shift that bring the part onto the lines.
    fn placed(&self) -> Result<Placed, BoxMismatch> {
        let coarse = self.coarse(false);
        let Some(best) = coarse.first().copied() else { return Err(BoxMismatch::NotFound) };
        let close = coarse.iter().filter(|c| c.left < best.left + ALIKE_MM);
        let mut fine: Vec<(f64, Placed, Fit)> = close.filter_map(|c| self.fine(*c)).collect();
        // The most walls in place; of equals the least turned.
        let rank =
            |(share, place, _): &(f64, Placed, Fit)| ((share * 50.0).round() as i64, -(place.turn.abs() * 1e4) as i64);
        fine.sort_by_key(|found| std::cmp::Reverse(rank(found)));
        match fine.first() {
            Some((share, place, fit)) if *share >= LEAST_FOUND[usize::from(!self.has_roles)] => {
                if fit.scale_mm() > SCALE_MM { Err(self.size(place.turn)) } else { Ok(*place) }
            }
            _ => Err(self.what_else(best)),
        }
    }

    /// Why the part is nowhere.
    fn what_else(&self, best: Placed) -> BoxMismatch {
        let mirrored = self.coarse(true).first().is_some_and(|m| m.left < best.left / 3.0 && m.left < ALIKE_MM);
        if mirrored { BoxMismatch::Mirrored } else { self.size(best.turn) }
    }

    /// Turns in the order of what they leave, the local minima of all that are tried.
    fn coarse(&self, mirrored: bool) -> Vec<Placed> {
        let side = if mirrored { -1.0 } else { 1.0 };
        let table: Vec<(Vec<f64>, Vec<f64>)> =
            self.levels.iter().map(|level| (supports(&level.corners, side), supports(&level.ends, 1.0))).collect();
        let tried: Vec<Placed> = (0..TURNS).map(|turn| over(&table, turn)).collect();
        let around = |i: usize, by: usize| tried[(i + by) % TURNS].left;
        let least = (0..TURNS).filter(|&i| tried[i].left <= around(i, 1) && tried[i].left <= around(i, TURNS - 1));
        // What looks the same however it is turned is taken as not turned.
        let mut least: Vec<Placed> = std::iter::once(0).chain(least).map(|i| tried[i]).collect();
        least.sort_by(|a, b| a.left.total_cmp(&b.left).then(a.turn.abs().total_cmp(&b.turn.abs())));
        least
    }

    /// From a coarse place to the one that the walls tell; the share of them that lie there.
    fn fine(&self, from: Placed) -> Option<(f64, Placed, Fit)> {
        let mut place = from;
        let mut near = NEAR_MM;
        let all = self.levels.iter().map(|level| level.walls.len()).sum::<usize>();
        let every = all.div_ceil(SAMPLES).max(1);
        for _ in 0..30 {
            let samples = self.distances(&place, near, every);
            let got = fit(&samples, WEAKEST)?;
            let step = Turn::by(place.turn).flat(got.shift);
            place.shift = [place.shift[0] + step[0], place.shift[1] + step[1]];
            place.turn += got.turn;
            near = (near * 0.6).max(FOUND_MM);
            if near <= FOUND_MM && got.shift_mm() + got.turn_mm() < 1e-5 {
                let share = samples.len() as f64 * every as f64 / all.max(1) as f64;
                place.turn = (place.turn + PI).rem_euclid(TAU) - PI;
                return Some((share, place, got));
            }
        }
        None
    }

    /// How far the walls lie from where the part has them, in the part's frame.
    fn distances(&self, place: &Placed, near: f64, every: usize) -> Vec<Sample> {
        let back = Turn::by(-place.turn);
        let mut all = Vec::new();
        for level in &self.levels {
            let mut search = level.section.search();
            for (p, half) in level.walls.iter().step_by(every) {
                let at = back.flat([p[0] - place.shift[0], p[1] - place.shift[1]]);
                let (distance, normal) = search.nearest(at);
                let out = distance + half;
                if let (Some(normal), true) = (normal, out.abs() < near) {
                    all.push(Sample { at, normal, out });
                }
            }
        }
        all
    }

    /// How large the lines are beside the part, in its own directions.
    fn size(&self, turn: f64) -> BoxMismatch {
        let mut times = [1.0; 3];
        let (mut differs, back) = (false, Turn::by(-turn));
        for axis in 0..2 {
            let span = |points: &[[f64; 2]], turned: bool| {
                let at = |p: &[f64; 2]| if turned { back.flat(*p)[axis] } else { p[axis] };
                let all = points.iter().map(at);
                let [low, high] = all.fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], v| [l.min(v), h.max(v)]);
                high - low
            };
            let widest = |pick: fn(&Level) -> &Vec<[f64; 2]>, turned| {
                self.levels.iter().map(|level| span(pick(level), turned)).fold(0.0, f64::max)
            };
            let width = self.levels.iter().flat_map(|l| &l.walls).map(|(_, half)| 2.0 * half).fold(0.0, f64::max);
            let (lines, part) = (widest(|l| &l.ends, true) + width, widest(|l| &l.corners, false));
            times[axis] = lines / part;
            differs |= (lines - part).abs() > SAME_SIZE_MM;
        }
        times[2] = self.heights[0] / self.heights[1];
        differs |= (self.heights[0] - self.heights[1]).abs() > SAME_SIZE_MM;
        let told = differs && times.iter().all(|t| t.is_finite());
        if told { BoxMismatch::Scaled { times } } else { BoxMismatch::NotFound }
    }
}

/// Places along a line, each with half its width.
fn samples(points: &[Vec3], width: f64) -> Vec<([f64; 2], f64)> {
    let mut all = Vec::new();
    for pair in points.windows(2) {
        let along = pair[1] - pair[0];
        let count = (along.norm() / SPACING_MM).ceil().max(1.0);
        for k in 0..count as usize {
            let p = pair[0] + along * ((k as f64 + 0.5) / count);
            all.push(([p.x, p.y], width / 2.0));
        }
    }
    all
}

/// How far `points` (x times `side`) reach in each of the directions.
fn supports(points: &[[f64; 2]], side: f64) -> Vec<f64> {
    let one = |k: usize| {
        let (sin, cos) = (k as f64 * TAU / TURNS as f64).sin_cos();
        points.iter().map(|p| side * p[0] * cos + p[1] * sin).fold(f64::NEG_INFINITY, f64::max)
    };
    (0..TURNS).map(one).collect()
}

/// The shift and what is left where the part is turned by `turn` of all [`TURNS`]; for each layer the part's reach and the lines'.
fn over(table: &[(Vec<f64>, Vec<f64>)], turn: usize) -> Placed {
    let (mut sum, mut squares, mut first, mut count) = (0.0, 0.0, [0.0; 2], 0.0);
    for (part, lines) in table {
        for k in (0..TURNS).step_by(EVERY) {
            let difference = lines[k] - part[(k + TURNS - turn) % TURNS];
            let (sin, cos) = (k as f64 * TAU / TURNS as f64).sin_cos();
            sum += difference;
            squares += difference * difference;
            first = [first[0] + difference * cos, first[1] + difference * sin];
            count += 1.0;
        }
    }
    let shift = first.map(|v| 2.0 * v / count);
    let explained = (shift[0].powi(2) + shift[1].powi(2)) / 2.0 + (sum / count).powi(2);
    let left = (squares / count - explained).max(0.0).sqrt();
    let turn = turn as f64 * TAU / TURNS as f64;
    Placed { turn: if turn > PI { turn - TAU } else { turn }, shift, left }
}
