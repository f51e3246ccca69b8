//! Bridges: what a layer has over air lies on chords whose both ends lie on what is below.
//!
//! Chords of one direction for each connected piece over air, since a slicer lays a bridge in one; the best of twelve counts. A chord may be
//! broken by an opening where both sides are the roof of one hole: then each side may reach as far as a line hangs free, and the
//! hole below may be as wide as a bridge.
//!
//! Lengths mm.

use super::OverhangRule;
use super::region::{Region, Shape, at, bounds, edges};

/// Directions that are tried, evenly over half a turn.
const DIRECTIONS: usize = 12;
/// Chords across the narrow side of a patch at least, and their greatest distance, mm.
const CHORDS: f64 = 24.0;
const FARTHEST_MM: f64 = 0.25;
/// A share below this is rounding.
const NOTHING: f64 = 1e-3;
/// Whether an edge lies on material is asked so far beyond it, mm: near by, and past the shortest edges of a rounded border.
const BEYOND_MM: [f64; 2] = [0.02, 0.1];

/// An edge of the layer over air.
struct Rim {
    ends: [[f64; 2]; 2],
    /// Whether material lies below on its other side.
    held: bool,
}

/// What a layer has over air, ready to be asked.
pub(super) struct Air {
    rims: Vec<Rim>,
}

/// A stretch of a chord: from and to, and whether each end lies on material.
type Stretch = [(f64, bool); 2];

impl Air {
    /// `over`: the layer less what is `below` it.
    pub(super) fn of(over: &Region, below: &Region) -> Self {
        let borders: Vec<[[f64; 2]; 2]> =
            below.iter().flatten().flat_map(|ring| edges(ring)).map(|edge| edge.map(at)).collect();
        let rim = |ends: [[f64; 2]; 2]| {
            let [[ax, ay], [bx, by]] = ends;
            let length = (bx - ax).hypot(by - ay).max(1e-9);
            // Material lies to the left of an edge, so the other side is to the right.
            let across = [(by - ay) / length, (ax - bx) / length];
            let probe = |mm: f64| [(ax + bx) / 2.0 + across[0] * mm, (ay + by) / 2.0 + across[1] * mm];
            Rim { ends, held: BEYOND_MM.iter().any(|mm| holds(&borders, probe(*mm))) }
        };
        let rims = over.iter().flatten().flat_map(|ring| edges(ring)).map(|edge| rim(edge.map(at)));
        Self { rims: rims.collect() }
    }

    /// Whether any edge lies on material.
    pub(super) fn is_held(&self, piece: &Shape) -> bool {
        let own = bounds(piece);
        let near = |r: &Rim| {
            r.ends.iter().all(|p| (0..2).all(|i| own[0][i] - BEYOND_MM[0] <= p[i] && p[i] <= own[1][i] + BEYOND_MM[0]))
        };
        self.rims.iter().any(|r| r.held && near(r))
    }

    /// What of `hanging`, a connected piece over air, no bridge of one direction carries; `None` where one carries all of it.
    pub(super) fn loose(&self, hanging: &Shape, rule: &OverhangRule) -> Option<Loose> {
        let mut least: Option<Loose> = None;
        for k in 0..DIRECTIONS {
            let (s, c) = (std::f64::consts::PI * k as f64 / DIRECTIONS as f64).sin_cos();
            let loose = self.loose_along(hanging, [c, s], rule);
            if loose.share < NOTHING {
                return None;
            }
            if least.as_ref().is_none_or(|known| loose.share < known.share) {
                least = Some(loose);
            }
        }
        least
    }

    fn loose_along(&self, hanging: &Shape, [c, s]: [f64; 2], rule: &OverhangRule) -> Loose {
        let turned = |p: [f64; 2]| [p[0] * c + p[1] * s, p[1] * c - p[0] * s];
        let back = |p: [f64; 2]| [p[0] * c - p[1] * s, p[1] * c + p[0] * s];
        let own: Vec<[[f64; 2]; 2]> =
            hanging.iter().flat_map(|ring| edges(ring)).map(|e| e.map(|p| turned(at(p)))).collect();
        let heights = own.iter().flatten().map(|p| p[1]);
        let range = heights.fold([f64::INFINITY, f64::NEG_INFINITY], |r, y| [r[0].min(y), r[1].max(y)]);
        let wide = range[1] - range[0];
        let count = (wide / FARTHEST_MM).max(CHORDS).ceil();
        let rims: Vec<([[f64; 2]; 2], bool)> = self
            .rims
            .iter()
            .map(|r| (r.ends.map(turned), r.held))
            .filter(|(e, _)| e[0][1].max(e[1][1]) >= range[0] && e[0][1].min(e[1][1]) <= range[1])
            .collect();
        let mut found = Sum::default();
        let mut at_line: Vec<(f64, bool)> = Vec::new();
        let mut mine: Vec<f64> = Vec::new();
        for line in 0..count as usize {
            let y = range[0] + wide * (line as f64 + 0.5) / count;
            at_line.clear();
            at_line.extend(rims.iter().filter_map(|(e, held)| Some((crossing(e, y)?, *held))));
            at_line.sort_by(|a, b| a.0.total_cmp(&b.0));
            mine.clear();
            mine.extend(own.iter().filter_map(|e| crossing(e, y)));
            mine.sort_by(f64::total_cmp);
            let stretches: Vec<Stretch> = at_line.chunks_exact(2).map(|pair| [pair[0], pair[1]]).collect();
            for pair in mine.chunks_exact(2) {
                let middle = (pair[0] + pair[1]) / 2.0;
                let on = stretches.iter().position(|[a, b]| a.0 <= middle && middle <= b.0);
                let held = on.is_some_and(|on| spans(&stretches, on, rule));
                let half = wide / count / 2.0;
                found.add(
                    [[pair[0], y - half], [pair[1], y - half], [pair[1], y + half], [pair[0], y + half]].map(back),
                    held,
                );
            }
        }
        found.loose()
    }
}

/// What no bridge carries.
#[derive(Clone, Copy, Debug)]
pub(super) struct Loose {
    /// Of the whole piece, 0 to 1.
    pub(super) share: f64,
    /// Its middle.
    pub(super) middle: [f64; 2],
    /// The box around it.
    pub(super) bounds: [[f64; 2]; 2],
}

/// Chords, summed up.
#[derive(Default)]
struct Sum {
    all: f64,
    loose: f64,
    moment: [f64; 2],
    corners: Vec<[f64; 2]>,
}

impl Sum {
    /// A chord, as the corners of the strip that it stands for, those of a long side first.
    fn add(&mut self, strip: [[f64; 2]; 4], held: bool) {
        let [a, b, c, _] = strip;
        let length = (b[0] - a[0]).hypot(b[1] - a[1]);
        self.all += length;
        if !held {
            self.loose += length;
            (0..2).for_each(|i| self.moment[i] += length * (a[i] + c[i]) / 2.0);
            self.corners.extend(strip);
        }
    }

    fn loose(self) -> Loose {
        // A piece so thin that no chord crosses it is carried by what is beside it.
        let share = if self.all > 0.0 { self.loose / self.all } else { 0.0 };
        let middle = self.moment.map(|m| m / self.loose);
        let empty = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
        let bounds = self.corners.iter().fold(empty, |[low, high], p| {
            [[low[0].min(p[0]), low[1].min(p[1])], [high[0].max(p[0]), high[1].max(p[1])]]
        });
        Loose { share, middle, bounds }
    }
}

/// Whether stretch `on` of a chord is carried: at both ends and short enough, or as one side of a hole's roof.
fn spans(stretches: &[Stretch], on: usize, rule: &OverhangRule) -> bool {
    let [from, to] = stretches[on];
    let free = rule.free_mm();
    let short = |a: f64, b: f64| b - a <= free;
    match (from.1, to.1) {
        (true, true) => to.0 - from.0 <= rule.bridge_mm.max(free),
        (true, false) => stretches.get(on + 1).is_some_and(|[c, d]| {
            !c.1 && d.1 && short(from.0, to.0) && short(c.0, d.0) && d.0 - from.0 <= rule.bridge_mm
        }),
        (false, true) => on.checked_sub(1).and_then(|i| stretches.get(i)).is_some_and(|[a, b]| {
            a.1 && !b.1 && short(from.0, to.0) && short(a.0, b.0) && to.0 - a.0 <= rule.bridge_mm
        }),
        (false, false) => false,
    }
}

/// Where an edge crosses the line at height `y`.
fn crossing([a, b]: &[[f64; 2]; 2], y: f64) -> Option<f64> {
    ((a[1] > y) != (b[1] > y)).then(|| a[0] + (b[0] - a[0]) * ((y - a[1]) / (b[1] - a[1])))
}

/// Whether borders go around a point.
pub(super) fn holds(borders: &[[[f64; 2]; 2]], p: [f64; 2]) -> bool {
    borders.iter().filter(|edge| crossing(edge, p[1]).is_some_and(|x| x > p[0])).count() % 2 == 1
}
