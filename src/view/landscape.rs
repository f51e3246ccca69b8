//! A value over all directions: the upper and the lower half of the sphere as discs of equal area (Lambert 1772), so that no pole is
//! smeared; levels as areas, the minima numbered.
//!
//! A direction's azimuth counts from +X towards +Y; its distance from a disc's middle is `sqrt(2) sin(t / 2)` radii, `t` the angle
//! from +Z, or from -Z. Both discs are seen from above: +X to the right, +Y up.

use rayon::prelude::*;

use super::drawing::{Anchor, Colour, Drawing, INK};
use super::regions::Labels;
use crate::geom::Vec3;

/// Levels of the scale, and its ends and knots, dark to bright (viridis).
const LEVELS: usize = 16;
const COLOURS: [[f64; 3]; 5] =
    [[68.0, 1.0, 84.0], [59.0, 82.0, 139.0], [33.0, 145.0, 140.0], [94.0, 201.0, 98.0], [253.0, 231.0, 37.0]];
const RADIUS: f64 = 150.0;
/// Places of the grid in a unit.
const FINE: f64 = 2.0;
const GAP: f64 = 58.0;
/// Between the discs.
const APART: f64 = 100.0;
const TOP: f64 = 54.0;
const LISTED: usize = 8;
const PALE: Colour = [255, 255, 255];
const RED: Colour = [220, 30, 30];

/// A minimum.
#[derive(Clone, Debug, PartialEq)]
pub struct Dip {
    /// The unit direction.
    pub up: Vec3,
    /// Whether none is better.
    pub best: bool,
    /// What is said of it in the list.
    pub text: String,
}

/// What is drawn.
pub struct Landscape<'a> {
    /// In a line above.
    pub title: String,
    /// The value of a unit direction.
    pub value: &'a (dyn Fn(&Vec3) -> f64 + Sync),
    /// Values that are asked for across a disc; between them they are interpolated.
    pub across: usize,
    /// The minima, best first.
    pub minima: Vec<Dip>,
}

/// Where a unit direction is on its disc, in radii, y up; and whether that is the lower one.
fn on_disc(up: &Vec3) -> ([f64; 2], bool) {
    let (below, flat) = (up.z < 0.0, up.x.hypot(up.y));
    // sqrt(2) sin(t / 2), from the height: exact at the pole too.
    let r = (1.0 - up.z.abs()).max(0.0).sqrt();
    (if flat > 0.0 { [r * up.x / flat, r * up.y / flat] } else { [0.0; 2] }, below)
}

/// The unit direction at a place of a disc; beyond its rim it goes on over the equator.
fn direction([x, y]: [f64; 2], below: bool) -> Vec3 {
    let r = x.hypot(y).min(1.41);
    let z = 1.0 - r * r;
    let flat = (1.0 - z * z).max(0.0).sqrt();
    let share = if r > 0.0 { flat / x.hypot(y) } else { 0.0 };
    Vec3::new(x * share, y * share, if below { -z } else { z })
}

/// The values of a disc on a square grid that reaches a step beyond it.
struct Values {
    across: usize,
    each: Vec<f64>,
}

impl Values {
    fn of(across: usize, below: bool, value: &(dyn Fn(&Vec3) -> f64 + Sync)) -> Self {
        let n = across + 3;
        let coordinate = |i: usize| 2.0 * (i as f64 - 1.0) / across as f64 - 1.0;
        let step = 2.0 / across as f64;
        let at = |k: usize| {
            let place = [coordinate(k % n), coordinate(k / n)];
            // What no place within the disc lies beside is not asked for.
            if place[0].hypot(place[1]) > 1.0 + 1.5 * step { f64::NAN } else { value(&direction(place, below)) }
        };
        Self { across, each: (0..n * n).into_par_iter().map(at).collect() }
    }

    /// Between the four around a place.
    fn at(&self, place: [f64; 2]) -> f64 {
        let n = self.across + 3;
        let [(i, s), (j, t)] = place.map(|v| {
            let v = ((v + 1.0) * 0.5 * self.across as f64 + 1.0).clamp(0.0, n as f64 - 1.001);
            (v as usize, v.fract())
        });
        let of = |i: usize, j: usize| self.each[j * n + i];
        (of(i, j) * (1.0 - s) + of(i + 1, j) * s) * (1.0 - t) + (of(i, j + 1) * (1.0 - s) + of(i + 1, j + 1) * s) * t
    }
}

impl Landscape<'_> {
    /// Draws it.
    pub fn drawing(&self) -> Drawing {
        let discs = [false, true].map(|below| Values::of(self.across.max(4), below, self.value));
        let all = || discs.iter().flat_map(|d| &d.each).copied().filter(|v| v.is_finite());
        let (low, high) = (all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max));
        let listed = self.minima.len().min(LISTED);
        let (width, top) = (4.0 * RADIUS + 2.0 * GAP + APART + 70.0, TOP);
        let height = top + 2.0 * RADIUS + 44.0 + 16.0 * listed as f64 + 10.0;
        let mut drawing = Drawing::new([width, height], self.title.clone());
        drawing.text([width / 2.0, 18.0], 13.0, Anchor::Middle, self.title.clone());
        let centre = |below: bool| [GAP + RADIUS + if below { 2.0 * RADIUS + APART } else { 0.0 }, top + RADIUS];
        for (disc, below) in discs.iter().zip([false, true]) {
            levels(&mut drawing, disc, centre(below), [low, high]);
            degrees(&mut drawing, centre(below), below);
        }
        bar(&mut drawing, [width - 74.0, top + 10.0], 2.0 * RADIUS - 20.0, [low, high]);
        for (i, dip) in self.minima.iter().enumerate().rev() {
            let ([x, y], below) = on_disc(&dip.up);
            let [cx, cy] = centre(below);
            let at = [cx + RADIUS * x, cy - RADIUS * y];
            drawing.circle(at, 5.0, 3.4, INK);
            drawing.circle(at, 5.0, 1.8, if dip.best { RED } else { PALE });
            if i < listed {
                drawing.label([at[0] + 12.0, at[1] - 6.0], 11.0, INK, (i + 1).to_string());
            }
        }
        for (i, dip) in self.minima.iter().take(listed).enumerate() {
            let y = top + 2.0 * RADIUS + 48.0 + 16.0 * i as f64;
            drawing.text([GAP, y], 12.0, Anchor::Start, format!("{}  {}", i + 1, dip.text));
        }
        drawing
    }
}

/// Level 0 to [`LEVELS`] - 1.
fn level(value: f64, [low, high]: [f64; 2]) -> usize {
    let share = (value - low) / (high - low).max(f64::MIN_POSITIVE);
    // What is not a number is the least.
    ((share * LEVELS as f64) as usize).min(LEVELS - 1)
}

fn colour(level: usize) -> Colour {
    let place = level as f64 / (LEVELS - 1) as f64 * (COLOURS.len() - 1) as f64;
    let i = (place as usize).min(COLOURS.len() - 2);
    [0, 1, 2].map(|k| (COLOURS[i][k] + (COLOURS[i + 1][k] - COLOURS[i][k]) * (place - i as f64)).round() as u8)
}

fn levels(drawing: &mut Drawing, disc: &Values, [cx, cy]: [f64; 2], range: [f64; 2]) {
    let side = (2.0 * RADIUS * FINE) as usize;
    let mut labels = Labels::new(side, side);
    for (i, label) in labels.each.iter_mut().enumerate() {
        let unit = |k: usize| 2.0 * (k as f64 + 0.5) / side as f64 - 1.0;
        let place = [unit(i % side), -unit(i / side)];
        if place[0].hypot(place[1]) <= 1.0 {
            *label = 1 + level(disc.at(place), range) as u32;
        }
    }
    let regions = labels.regions(|_| 0);
    let paper = |[x, y]: [f64; 2]| [cx - RADIUS + x / FINE, cy - RADIUS + y / FINE];
    for (label, rings) in regions.areas {
        let rings = rings.into_iter().map(|ring| ring.into_iter().map(paper).collect()).collect();
        drawing.area(rings, colour(label as usize - 1), 1.0);
    }
}

/// Circles of 30 and 60 degrees from the pole, the rim with its azimuths, and names of the axes.
fn degrees(drawing: &mut Drawing, [cx, cy]: [f64; 2], below: bool) {
    for from_pole in [30.0f64, 60.0] {
        let r = RADIUS * std::f64::consts::SQRT_2 * (from_pole.to_radians() / 2.0).sin();
        drawing.circle([cx, cy], r, 0.6, PALE);
        drawing.label([cx + 4.0, cy + r + 4.0], 9.0, INK, format!("{from_pole}"));
    }
    drawing.circle([cx, cy], RADIUS, 1.0, INK);
    for (azimuth, name) in [
        (0, "0 +X"),
        (45, "45"),
        (90, "90 +Y"),
        (135, "135"),
        (180, "180 -X"),
        (225, "225"),
        (270, "270 -Y"),
        (315, "315"),
    ] {
        let (sin, cos) = f64::from(azimuth).to_radians().sin_cos();
        let at = |r: f64| [cx + r * cos, cy - r * sin];
        drawing.line(vec![at(RADIUS), at(RADIUS + 4.0)], 1.0, INK);
        let [x, y] = at(RADIUS + 12.0);
        let anchor = if cos > 0.5 {
            Anchor::Start
        } else if cos < -0.5 {
            Anchor::End
        } else {
            Anchor::Middle
        };
        let x = if anchor == Anchor::Middle { x } else { x - 6.0 * cos };
        drawing.text([x, y + 3.0], 9.0, anchor, name);
    }
    drawing.label([cx, cy + 4.0], 10.0, INK, if below { "-Z up" } else { "+Z up" });
}

fn bar(drawing: &mut Drawing, [x, y]: [f64; 2], high: f64, [low, most]: [f64; 2]) {
    let step = high / LEVELS as f64;
    for i in 0..LEVELS {
        let top = y + high - step * (i + 1) as f64;
        drawing.rectangle([x, top], [x + 16.0, top + step], colour(i));
    }
    for i in 0..=4 {
        let share = f64::from(i) / 4.0;
        let value = low + (most - low) * share;
        if value.is_finite() {
            drawing.text([x + 21.0, y + high * (1.0 - share) + 4.0], 11.0, Anchor::Start, figures(value));
        }
    }
}

/// Four figures.
fn figures(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let decimals = 3 - value.abs().log10().floor() as i32;
    let decimals = decimals.clamp(0, 6) as usize;
    format!("{value:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::drawing::Picture;

    #[test]
    fn a_disc_is_the_sphere_and_keeps_areas() {
        for i in 0..500 {
            let (x, y) = ((f64::from(i % 23) / 11.5 - 1.0) * 0.7, (f64::from(i / 23) / 11.0 - 1.0) * 0.7);
            for below in [false, true] {
                let up = direction([x, y], below);
                assert!((up.norm() - 1.0).abs() < 1e-12);
                let ([u, v], side) = on_disc(&up);
                assert!((u - x).abs() < 1e-12 && (v - y).abs() < 1e-12 && side == below, "{x} {y}");
            }
        }
        // A cap of height h has 2 pi h of the sphere; on the disc it is a circle of radius sqrt(h), pi h: half of it.
        for h in [0.1f64, 0.5, 1.0] {
            let rim = Vec3::new((2.0 * h - h * h).sqrt(), 0.0, 1.0 - h);
            let ([r, _], _) = on_disc(&rim);
            assert!((r * r - h).abs() < 1e-12);
        }
        assert!((direction([0.0, 1.0], false) - Vec3::y()).norm() < 1e-9, "the rim is the equator");
    }

    #[test]
    fn low_is_dark_high_is_bright_and_a_minimum_is_ringed() {
        // Least at -Z + X.
        let least = Vec3::new(1.0, 0.0, -1.0).normalize();
        let value = |up: &Vec3| -up.dot(&least);
        let minima = vec![Dip { up: least, best: true, text: "value -1".into() }];
        let drawing = Landscape { title: "t".into(), value: &value, across: 60, minima }.drawing();
        let picture = Picture::of(&drawing);
        let at = |below: bool, x: f64, y: f64| {
            let cx = GAP + RADIUS + if below { 2.0 * RADIUS + APART } else { 0.0 };
            let (px, py) = ((cx + RADIUS * x) * 2.0, (TOP + RADIUS - RADIUS * y) * 2.0);
            picture.pixels[py as usize * picture.width + px as usize].map(f64::from)
        };
        let r = (1.0 - 0.5f64.sqrt()).sqrt();
        let (dark, bright) = (at(true, r, 0.09), at(false, -r, 0.09));
        assert!(dark[1] < 30.0 && bright[1] > 200.0, "{dark:?} {bright:?}");
        let near = at(true, r + 5.0 / RADIUS, 0.0);
        assert!(near[0] > 180.0 && near[1] < 80.0, "red: {near:?}");
    }
}
