//! Which way a bridge runs: so that its lines lie on something at both ends, and are short between.
//!
//! `overhang` asks the same of a part before it is sliced: chords of one direction, with both ends on what is below.

use std::f64::consts::{FRAC_PI_2, PI};

use super::region::{GridPoint, Region, UNITS_PER_MM, and, grown, holds, pairs};

/// Directions that are tried, evenly over half a turn; those of the longest edges come on top, and what is square to them.
const DIRECTIONS: usize = 12;
const EDGES: usize = 6;
/// Chords across what is over air at least and at most, and how far apart they lie otherwise, grid units: 0.4 mm.
const CHORDS: [f64; 2] = [12.0, 120.0];
const APART: f64 = 0.4 * UNITS_PER_MM;
/// Whether an edge lies on material is asked so far beyond it, mm: rounding has cut corners off what is over air.
const BEYOND_MM: [f64; 2] = [0.03, 0.15];
/// What is less of the whole, or of a line's length, is no advantage but rounding.
const NO_ADVANTAGE: f64 = 0.01;
/// Where no direction holds more than this at both ends there is no bridge, but a ledge.
const LEDGE: f64 = 0.5;

/// An edge of what is over air, and whether material lies beyond it.
struct Rim {
    ends: (GridPoint, GridPoint),
    held: bool,
}

/// The direction, rad from +X, in which the most of `air` lies on lines held at both ends by what is `below`, and of several that in
/// which the longest is shortest; `None` where no direction holds half of it.
pub(super) fn direction(air: &Region, below: &Region) -> Option<f64> {
    let near = and(&grown(air, (2.0 * BEYOND_MM[1] * UNITS_PER_MM) as i32), below);
    let rims: Vec<Rim> = air.iter().flatten().flat_map(|ring| pairs(ring)).map(|ends| rim(ends, &near)).collect();
    let mut best: Option<(Chords, f64)> = None;
    for angle in candidates(&rims) {
        let chords = Chords::along(&rims, angle);
        if best.as_ref().is_none_or(|(known, _)| chords.is_better(known)) {
            best = Some((chords, angle));
        }
    }
    best.filter(|(chords, _)| chords.loose <= LEDGE).map(|(_, angle)| angle)
}

fn rim(ends: (GridPoint, GridPoint), near: &Region) -> Rim {
    let [dx, dy] = [f64::from(ends.1.x) - f64::from(ends.0.x), f64::from(ends.1.y) - f64::from(ends.0.y)];
    let length = dx.hypot(dy).max(1.0);
    // What is over air lies to the left of an edge.
    let probe = |mm: f64| {
        let by = mm * UNITS_PER_MM / length;
        let of = |a: i32, b: i32, across: f64| (((f64::from(a) + f64::from(b)) / 2.0) + across * by).round() as i32;
        GridPoint::new(of(ends.0.x, ends.1.x, dy), of(ends.0.y, ends.1.y, -dx))
    };
    Rim { ends, held: BEYOND_MM.iter().any(|mm| holds(near, probe(*mm))) }
}

fn candidates(rims: &[Rim]) -> Vec<f64> {
    let mut edges: Vec<(f64, f64)> = rims
        .iter()
        .map(|rim| (f64::from(rim.ends.1.x - rim.ends.0.x), f64::from(rim.ends.1.y - rim.ends.0.y)))
        .map(|(x, y)| (x.hypot(y), y.atan2(x)))
        .collect();
    edges.sort_by(|a, b| b.0.total_cmp(&a.0));
    let even = (0..DIRECTIONS).map(|k| PI * k as f64 / DIRECTIONS as f64);
    let along = edges.iter().take(EDGES).flat_map(|&(_, angle)| [angle, angle + FRAC_PI_2]);
    even.chain(along.map(|angle| angle.rem_euclid(PI))).collect()
}

/// What lines of one direction are like.
struct Chords {
    /// The share of what is over air that is not held at both ends.
    loose: f64,
    /// The longest held one, grid units.
    longest: f64,
}

impl Chords {
    fn along(rims: &[Rim], angle: f64) -> Self {
        let (sin, cos) = angle.sin_cos();
        let turned = |p: GridPoint| {
            let (x, y) = (f64::from(p.x), f64::from(p.y));
            [x * cos + y * sin, y * cos - x * sin]
        };
        let rims: Vec<([f64; 2], [f64; 2], bool)> =
            rims.iter().map(|rim| (turned(rim.ends.0), turned(rim.ends.1), rim.held)).collect();
        let heights = rims.iter().flat_map(|rim| [rim.0[1], rim.1[1]]);
        let (low, high) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), y| (l.min(y), h.max(y)));
        let count = ((high - low) / APART).clamp(CHORDS[0], CHORDS[1]).ceil();
        let (mut held, mut loose, mut longest) = (0.0, 0.0, 0.0f64);
        for k in 0..count as usize {
            let y = low + (high - low) * (k as f64 + 0.5) / count;
            let mut met: Vec<(f64, bool)> = rims
                .iter()
                .filter(|(a, b, _)| (a[1] <= y) != (b[1] <= y))
                .map(|(a, b, held)| (a[0] + (b[0] - a[0]) * (y - a[1]) / (b[1] - a[1]), *held))
                .collect();
            met.sort_by(|a, b| a.0.total_cmp(&b.0));
            for pair in met.chunks_exact(2) {
                let length = pair[1].0 - pair[0].0;
                if pair[0].1 && pair[1].1 {
                    held += length;
                    longest = longest.max(length);
                } else {
                    loose += length;
                }
            }
        }
        Self { loose: loose / (held + loose).max(1.0), longest }
    }

    fn is_better(&self, other: &Self) -> bool {
        let alike = (self.loose - other.loose).abs() <= NO_ADVANTAGE;
        if alike { self.longest < other.longest * (1.0 - NO_ADVANTAGE) } else { self.loose < other.loose }
    }
}

#[cfg(test)]
mod tests {
    use super::super::region::{enclosed, minus, units};
    use super::*;

    /// A rectangle about the origin, turned by `deg`.
    fn rectangle(x: [f64; 2], y: [f64; 2], deg: f64) -> Region {
        let (sin, cos) = deg.to_radians().sin_cos();
        let corners = [(x[0], y[0]), (x[1], y[0]), (x[1], y[1]), (x[0], y[1])];
        enclosed(&[corners.map(|(x, y)| GridPoint::new(units(x * cos - y * sin), units(x * sin + y * cos))).to_vec()])
    }

    #[test]
    fn a_bridge_runs_from_post_to_post_however_they_stand() {
        for deg in [0.0, 25.0, 90.0, 131.0] {
            // 10 mm wide and 4 mm across, held at its narrow ends alone.
            let whole = rectangle([-12.0, 12.0], [-2.0, 2.0], deg);
            let air = rectangle([-5.0, 5.0], [-2.0, 2.0], deg);
            let found = direction(&air, &minus(&whole, &air)).unwrap();
            assert!((found - deg.to_radians()).sin().abs() < 1e-3, "{deg}: {}", found.to_degrees());
        }
    }

    #[test]
    fn over_a_pit_it_runs_the_short_way_and_a_ledge_is_no_bridge() {
        let (whole, air) = (rectangle([-12.0, 12.0], [-9.0, 9.0], 30.0), rectangle([-6.0, 6.0], [-3.0, 3.0], 30.0));
        let found = direction(&air, &minus(&whole, &air)).unwrap();
        assert!((found - 120f64.to_radians()).sin().abs() < 1e-3, "{}", found.to_degrees());
        assert_eq!(
            direction(&rectangle([0.0, 6.0], [-3.0, 3.0], 0.0), &rectangle([-6.0, 0.0], [-3.0, 3.0], 0.0)),
            None
        );
    }
}
