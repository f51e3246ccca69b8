//! Rings over air that the rest of their layer holds.
//!
//! Above a counterbore a hole begins as a loop that touches nothing: slicers lay it first, and then the bridges that meet it from all sides.
//! So may a loop be that meets material at a place or two, and hangs for more than half of it. Such a loop is kept until its layer ends.
//! What is laid after it around it and lies on something else holds it where it touches it, or touches what touches it; it is held where no
//! stretch of it between two such places is longer than what may turn over air, nor half of it. What fills a loop does not hold it: that
//! loop is an outline, and a tab that goes out into the air would be held by its own rows. What has nothing but the ring itself holds
//! nothing; nor do the rows of one line that lie beside each other alone.
//!
//! A stretch of a longer line that turns over air between two ends on material, as around a notch in the roof of a hole, is kept as well. What
//! fills its layer lies beside it on one side alone, so only lines hold it that go straight on from what they lie on to what they lie on: rows
//! of a tab that end in the air do not. Places are the machine's, mm.

use std::collections::HashMap;

use super::ledges::UnsupportedGap;
use super::way::{Way, is_nearly_straight};
use crate::geom::{Bounds, Sets, Vec3};
use crate::section::{Segment, to_segment};

/// What turns over air may be no longer, whatever a bridge may span, mm: the end of something held at one side.
pub(super) const TURNED_MM: f64 = 8.0;
/// A line carries nothing of itself until the tip is so many widths ahead: its own tail is no support.
pub(super) const TAIL_WIDTHS: f64 = 4.0;
/// No longer ring is waited for, mm, but for a ledge's rim: around a hole that a bridge of 14 mm spans.
pub(super) const LONGEST_MM: f64 = 44.0;
/// Beyond half of the widths, how far from each other lines touch, mm.
const TOUCH_MM: f64 = 0.15;
/// As far beyond that a thread may be what is found beside a line: the field's cells and the line's own width.
const BESIDE_MM: f64 = 1.0;
/// Places that lie on something, of a line that is said to.
const FEWEST: usize = 3;
/// Threads at most that are looked at in one layer.
const MOST_THREADS: usize = 300;
/// What lies no higher or lower is of the layer, mm.
pub(super) const LAYER_MM: f64 = 0.02;

/// A place on a line.
#[derive(Clone, Copy)]
pub(super) struct Place {
    pub(super) at: Vec3,
    /// Whether something is below or beside it.
    pub(super) stands: bool,
    /// Whether it lies on what was there before its layer.
    pub(super) lies: bool,
}

/// A line of the layer that lies on nothing but others like it.
struct Thread {
    way: Way,
    width: f64,
    bounds: Bounds,
}

impl Thread {
    fn of(way: Way, width: f64) -> Self {
        let bounds = Bounds::of(way.iter().flatten().copied());
        Self { way, width, bounds }
    }

    /// Whether a place is no farther from its middle than this, level, mm.
    fn is_within(&self, at: &Vec3, mm: f64) -> bool {
        let (low, high) = (self.bounds.min, self.bounds.max);
        (low.x - mm..=high.x + mm).contains(&at.x)
            && (low.y - mm..=high.y + mm).contains(&at.y)
            && near(at, &self.way) <= mm
    }
}

/// A line, or a stretch of one, that waits for what holds it.
struct Ring {
    thread: usize,
    gap: UnsupportedGap,
    closed: bool,
}

/// Where a line that lies on something else meets a thread.
struct Touch {
    thread: usize,
    at: Vec3,
    /// Whether the line is a bridge there.
    bridges: bool,
}

/// The rings of one layer.
#[derive(Default)]
pub(super) struct Rings {
    threads: Vec<Thread>,
    rings: Vec<Ring>,
    touched: Vec<Touch>,
    overflown: bool,
}

impl Rings {
    /// Whether a ring of another layer than that at `z` waits.
    pub(super) fn are_below(&self, z: f64) -> bool {
        self.rings.first().is_some_and(|ring| (ring.gap.ends[0].z - z).abs() > LAYER_MM)
    }

    /// Whether lines are to be told.
    pub(super) fn wait(&self) -> bool {
        !self.rings.is_empty()
    }

    /// Takes a closed line that hangs as a whole, or for the greater part, or else the stretch of a line that does; `false` where it is too long
    /// to wait for.
    pub(super) fn take(&mut self, gap: UnsupportedGap, way: Way, closed: bool) -> bool {
        let fits = gap.length <= LONGEST_MM.max(gap.as_rim) && self.threads.len() < MOST_THREADS;
        if fits {
            self.rings.push(Ring { thread: self.threads.len(), gap, closed });
            self.threads.push(Thread::of(way, f64::from(gap.stroke.width)));
        }
        fits
    }

    /// A line that was laid behind a ring of the same layer, with places on it in order.
    pub(super) fn line(&mut self, way: &Way, width: f64, places: &[Place]) {
        let between = |thread: &Thread| (thread.width + width) / 2.0;
        let beside = |at: &Vec3| self.threads.iter().any(|thread| thread.is_within(at, between(thread) + BESIDE_MM));
        let own = beside_itself(width, places);
        let lies = places.iter().filter(|place| place.lies).count() >= FEWEST;
        if lies || places.iter().zip(own).any(|(place, own)| place.stands && !own && !beside(&place.at)) {
            let bridges = bridging(width, places);
            for (i, thread) in self.threads.iter().enumerate() {
                let reach = between(thread) + TOUCH_MM;
                let touched = places.iter().zip(&bridges).filter(|(place, _)| thread.is_within(&place.at, reach));
                self.touched.extend(touched.map(|(place, &bridges)| Touch { thread: i, at: place.at, bridges }));
            }
        } else if self.threads.len() < MOST_THREADS {
            self.threads.push(Thread::of(way.clone(), width));
        } else {
            self.overflown = true;
        }
    }

    /// The layer is over: what is not held goes to `found`.
    pub(super) fn settle(&mut self, found: &mut Vec<UnsupportedGap>) {
        let Self { threads, rings, touched, overflown } = std::mem::take(self);
        let mut sets = Sets::new(threads.len());
        for a in 0..threads.len() {
            for b in 0..a {
                if meet(&threads[a], &threads[b]) {
                    sets.join(a as u32, b as u32);
                }
            }
        }
        for Ring { thread, gap, closed } in rings {
            let (root, ring) = (sets.root(thread as u32), &threads[thread].way);
            let holds = |touch: &&Touch| if closed { !is_within(ring, &touch.at) } else { touch.bridges };
            let around = touched.iter().filter(|touch| sets.root(touch.thread as u32) == root).filter(holds);
            let own = gap.ends.iter().zip(gap.held).filter(|(_, held)| *held);
            let places: Vec<Vec3> = around.map(|touch| touch.at).chain(own.map(|(at, _)| *at)).collect();
            if overflown || !is_held(ring, &places, closed) {
                found.push(gap);
            }
        }
    }
}

/// For each place whether the line goes straight on there from a place that lies on something to another one.
fn bridging(width: f64, places: &[Place]) -> Vec<bool> {
    let mut found: Vec<bool> = places.iter().map(|place| place.lies).collect();
    let (mut travelled, mut last) = (0.0, None::<(usize, f64)>);
    for (k, place) in places.iter().enumerate() {
        travelled += k.checked_sub(1).map_or(0.0, |before| (place.at - places[before].at).norm());
        if !place.lies {
            continue;
        }
        if let Some((first, since)) = last.replace((k, travelled))
            && is_nearly_straight(travelled - since, &[places[first].at, place.at], width)
        {
            found[first..k].fill(true);
        }
    }
    found
}

/// For each place whether the line itself has been beside it before, so that it may be all that was found there.
fn beside_itself(width: f64, places: &[Place]) -> Vec<bool> {
    let reach = width + BESIDE_MM;
    // Straight on it never is.
    let tail = (TAIL_WIDTHS * width).max(reach + BESIDE_MM / 2.0);
    let mut been: HashMap<[i64; 2], Vec<(Vec3, f64)>> = HashMap::new();
    let (mut travelled, mut last) = (0.0, None);
    let mut own = Vec::with_capacity(places.len());
    for Place { at, .. } in places {
        travelled += last.map_or(0.0, |last: Vec3| (at - last).norm());
        last = Some(*at);
        let [x, y] = [at.x, at.y].map(|v| (v / reach).floor() as i64);
        let cells = (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| [x + dx, y + dy]));
        let near = |(then, when): &(Vec3, f64)| travelled - when >= tail && (at - then).xy().norm() <= reach;
        own.push(cells.filter_map(|cell| been.get(&cell)).flatten().any(near));
        been.entry([x, y]).or_default().push((*at, travelled));
    }
    own
}

/// The distance of a place from a line, level.
fn near(at: &Vec3, way: &Way) -> f64 {
    way.iter().map(|piece| to_segment([at.x, at.y], level(piece))).fold(f64::INFINITY, f64::min)
}

fn level([from, to]: &[Vec3; 2]) -> Segment {
    [[from.x, from.y], [to.x, to.y]]
}

fn meet(a: &Thread, b: &Thread) -> bool {
    let reach = (a.width + b.width) / 2.0 + TOUCH_MM;
    let meets = |one: &Thread, other: &Thread| one.way.iter().flatten().any(|at| other.is_within(at, reach));
    meets(a, b) || meets(b, a)
}

/// Whether a place lies within a ring, seen from above: what goes from it along x crosses the ring an odd number of times.
fn is_within(ring: &Way, at: &Vec3) -> bool {
    let closing = ring.last().zip(ring.first()).map(|(last, first)| [last[1], first[0]]);
    let crossed = ring.iter().chain(&closing).filter(|[from, to]| {
        let rises = (from.y > at.y) != (to.y > at.y);
        rises && at.x < from.x + (to.x - from.x) * (at.y - from.y) / (to.y - from.y)
    });
    crossed.count() % 2 == 1
}

/// Whether places hold a ring: none of its stretches between two of them is longer than may turn over air, nor, where it is closed, half of it.
fn is_held(ring: &Way, places: &[Vec3], closed: bool) -> bool {
    let mut starts = Vec::with_capacity(ring.len());
    let mut length = 0.0;
    for [from, to] in ring {
        starts.push(length);
        length += (to - from).xy().norm();
    }
    let mut along: Vec<f64> = places.iter().filter_map(|at| where_on(ring, &starts, at)).collect();
    along.sort_by(f64::total_cmp);
    let (Some(first), Some(last)) = (along.first(), along.last()) else { return false };
    let (around, most) = if closed {
        (first + length - last, TURNED_MM.min(length / 2.0))
    } else {
        (first.max(length - last), TURNED_MM)
    };
    along.windows(2).map(|pair| pair[1] - pair[0]).fold(around, f64::max) <= most
}

/// How far along a ring, whose pieces start so far along it, a place is nearest to it, mm.
fn where_on(ring: &Way, starts: &[f64], at: &Vec3) -> Option<f64> {
    let away = |piece: &[Vec3; 2]| to_segment([at.x, at.y], level(piece));
    let (start, [from, to]) = starts.iter().zip(ring).min_by(|a, b| away(a.1).total_cmp(&away(b.1)))?;
    let (along, there) = ((to - from).xy(), (at - from).xy());
    let length = along.norm();
    Some(start + if length > 0.0 { (there.dot(&along) / length).clamp(0.0, length) } else { 0.0 })
}
