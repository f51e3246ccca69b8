//! Beads of changing width where a region is too thick for none and too thin for two whole lines.
//!
//! Seen from every place of the border (`thickness`), one bead runs on the middle between both sides where that fits, else two as
//! wide as each other, one along each side. What is printed where the region is wider comes from `walls`.

use std::f64::consts::TAU;

use super::region::{Contour, GridPoint, Region, UNITS_PER_MM, enclosed, pairs};
use super::thickness::{Border, Boxes, Place, Vec2, dot, in_mm, length, plus, sub};

/// Spacing of the places on the border, mm.
const STEP_MM: f64 = 0.15;
/// Sides up to this length are looked at more closely, mm.
const SHORT_MM: f64 = 1.5;
/// Places whose beads lie farther apart are not neighbours, mm; `join` may join them.
const JUMP_MM: f64 = 0.25;
/// Around a corner that sticks into the region the normal turns in steps of this, rad.
const FAN: f64 = TAU / 18.0;

/// Which beads fill which thickness, mm.
#[derive(Clone, Copy)]
pub(super) struct GapFit {
    /// What is thinner is not printed.
    pub(super) least: f64,
    /// Up to here one bead fills it.
    pub(super) one: f64,
    /// Up to here two do.
    pub(super) most: f64,
    /// The part of the thickness that is filled.
    pub(super) share: f64,
    /// A bead's width less the pitch at which it fills a layer.
    pub(super) rounding: f64,
}

/// An open or closed line of beads; `widths` has one number a leg, or none where all have the usual width.
#[derive(Clone, Debug, Default)]
pub(super) struct Stretch {
    pub(super) points: Vec<Vec2>,
    /// At each point, mm.
    pub(super) widths: Vec<f64>,
    pub(super) closed: bool,
}

impl Stretch {
    pub(super) fn length(&self) -> f64 {
        let open: f64 = self.points.windows(2).map(|leg| length(sub(leg[1], leg[0]))).sum();
        let close = self.points.first().zip(self.points.last()).map_or(0.0, |(a, b)| length(sub(*b, *a)));
        if self.closed { open + close } else { open }
    }
}

/// The narrow pieces of a region.
pub(super) struct Narrow {
    border: Border,
    boxes: Boxes,
    fit: GapFit,
}

/// What is seen from one place of the border.
struct Seen {
    foot: Vec2,
    centre: Vec2,
    radius: f64,
    /// Whether the beads of both sides are this side's to print, where there is one for both.
    owner: bool,
}

#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Nothing,
    One,
    Two,
}

impl Narrow {
    /// `pieces` is where the shape may be narrow.
    pub(super) fn new(zone: &Region, pieces: &Region, fit: GapFit) -> Self {
        let boxes = Boxes::around(pieces, 0.02);
        Self { border: Border::new(zone, &boxes, 2.0 * fit.most), boxes, fit }
    }

    /// Whether beads of this module fill the region beside the nearest place of the border to `p`, at most `reach` away.
    pub(super) fn fills_beside(&self, p: Vec2, reach: f64) -> bool {
        let Some(foot) = self.border.foot(p, reach).filter(|foot| self.boxes.hold(*foot)) else { return false };
        let out = sub(p, foot);
        let far = length(out);
        far > 0.0 && self.border.disc(foot, [out[0] / far, out[1] / far], self.fit.most / 2.0).is_some()
    }

    /// Whether a ring comes near a narrow piece at all.
    pub(super) fn may_concern(&self, ring: &[GridPoint]) -> bool {
        self.boxes.may_hold(ring)
    }

    /// The beads along the rings of the zone, and what they fill.
    pub(super) fn beads(&self, zone: &Region) -> (Vec<Stretch>, Region) {
        let (mut stretches, mut filled) = (Vec::new(), Vec::new());
        for (ring, number) in zone.iter().flatten().zip(0..) {
            if self.may_concern(ring) {
                let seen = self.along(ring, number);
                self.stretches(&seen, &mut stretches);
                filled.extend(strips(&seen, self.fit.least / 2.0));
            }
        }
        (stretches, enclosed(&filled))
    }

    /// What is seen from the places along a ring.
    fn along(&self, ring: &[GridPoint], number: u32) -> Vec<Option<Seen>> {
        let mut seen = Vec::new();
        let (mut along, mut owed) = (0.0, 0.0);
        let mut look = |a: Vec2, normal: Vec2, place: Place| {
            let disc = self.boxes.hold(a).then(|| self.border.disc(a, normal, self.fit.most / 2.0)).flatten();
            let of = |disc: super::thickness::Disc| Seen {
                foot: a,
                centre: disc.centre,
                radius: disc.radius,
                owner: place < disc.other,
            };
            seen.push(disc.map(of));
        };
        let sides: Vec<(Vec2, Vec2)> = pairs(ring).map(|(a, b)| (in_mm(a), in_mm(b))).collect();
        let before = sides.iter().cycle().skip(sides.len().saturating_sub(1));
        for (&(a, b), &(c, d)) in sides.iter().zip(before) {
            let whole = length(sub(b, a));
            if whole <= 0.0 {
                continue;
            }
            let direction = [(b[0] - a[0]) / whole, (b[1] - a[1]) / whole];
            let normal = [-direction[1], direction[0]];
            for turned in fan(sub(d, c), direction) {
                look(a, turned, (number, along));
            }
            owed += whole;
            let count = places_on(whole, owed);
            if count > 0 {
                for k in 0..count {
                    let at = whole * (k as f64 + 0.5) / count as f64;
                    look(plus(a, direction, at), normal, (number, along + at));
                }
                owed = 0.0;
            }
            along += whole;
        }
        seen
    }

    fn kind(&self, seen: Option<&Seen>) -> Kind {
        match seen {
            Some(s) if 2.0 * s.radius < self.fit.least => Kind::Nothing,
            Some(s) if 2.0 * s.radius >= self.fit.one => Kind::Two,
            Some(s) if s.owner => Kind::One,
            _ => Kind::Nothing,
        }
    }

    /// A bead's middle and width beside a place.
    fn bead(&self, seen: &Seen) -> (Vec2, f64) {
        let filled = 2.0 * seen.radius * self.fit.share;
        match self.kind(Some(seen)) {
            Kind::Two => (
                plus(seen.centre, sub(seen.foot, seen.centre), filled / 4.0 / seen.radius),
                filled / 2.0 + self.fit.rounding,
            ),
            _ => (seen.centre, filled + self.fit.rounding),
        }
    }

    fn stretches(&self, seen: &[Option<Seen>], found: &mut Vec<Stretch>) {
        let first = found.len();
        let mut last = Kind::Nothing;
        for place in seen {
            let kind = self.kind(place.as_ref());
            let Some(place) = place.as_ref().filter(|_| kind != Kind::Nothing) else {
                last = Kind::Nothing;
                continue;
            };
            let (point, width) = self.bead(place);
            let near =
                found.last().and_then(|s: &Stretch| s.points.last()).is_some_and(|p| length(sub(point, *p)) < JUMP_MM);
            if kind != last || !near || found.len() == first {
                found.push(Stretch::default());
            }
            last = kind;
            if let Some(stretch) = found.last_mut() {
                stretch.points.push(point);
                stretch.widths.push(width);
            }
        }
        // One bead all round: the ring closes.
        if let ([only], true) = (&mut found[first..], seen.iter().all(Option::is_some)) {
            let ends = only.points.first().zip(only.points.last());
            only.closed = only.points.len() == seen.len() && ends.is_some_and(|(a, b)| length(sub(*a, *b)) < JUMP_MM);
        }
    }
}

/// How many places are looked at on a side, with `owed` since the last: on a short one more and an odd number, for its middle may be
/// the only place where a disc fits between its corners.
fn places_on(whole: f64, owed: f64) -> usize {
    if !(STEP_MM..=SHORT_MM).contains(&whole) {
        return (owed / STEP_MM).floor() as usize;
    }
    (2.0 * whole / STEP_MM).ceil() as usize | 1
}

/// Directions between the normals of two sides where the corner between them sticks into the region.
fn fan(before: Vec2, after: Vec2) -> impl Iterator<Item = Vec2> {
    let cross = before[0] * after[1] - before[1] * after[0];
    let turn = cross.atan2(dot(before, after));
    let count = if turn < -FAN / 2.0 { (-turn / FAN).ceil() as usize } else { 0 };
    let normal = [-after[1], after[0]];
    (0..count).map(move |k| {
        // From the normal before, which lies `-turn` to the left, to that after.
        let (sin, cos) = (-turn * (1.0 - (k as f64 + 0.5) / count as f64)).sin_cos();
        [normal[0] * cos - normal[1] * sin, normal[0] * sin + normal[1] * cos]
    })
}

/// The strips between the border and the middle, as rings.
fn strips(seen: &[Option<Seen>], least: f64) -> Vec<Contour> {
    let wanted = |s: &Option<Seen>| s.as_ref().is_some_and(|s| s.radius >= least);
    let mut rings = Vec::new();
    for run in seen.chunk_by(|a, b| wanted(a) && wanted(b)) {
        let run: Vec<&Seen> = run.iter().filter(|s| wanted(s)).flatten().collect();
        if run.len() > 1 {
            let there = run.iter().map(|s| s.foot);
            let back = run.iter().rev().map(|s| s.centre);
            rings.push(there.chain(back).map(on_grid).collect());
        }
    }
    if seen.iter().all(wanted)
        && let [Some(first), .., Some(last)] = seen
    {
        rings.push([last.foot, first.foot, first.centre, last.centre].map(on_grid).to_vec());
    }
    rings
}

/// Millimetres on the grid.
pub(super) fn on_grid(p: Vec2) -> GridPoint {
    let of = |v: f64| (v * UNITS_PER_MM).round() as i32;
    GridPoint::new(of(p[0]), of(p[1]))
}
