//! The cross-sections of supports: a cross of two sheets, a square, a round; all level, so that a slanting piece keeps its area.

use super::Build;
use crate::geom::Vec3;

/// What stands along an arc.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Structure {
    /// Two crossed upright sheets over the diagonals of the square; neighbours meet along the edges of their cells.
    X,
    /// The whole square.
    Prism,
    /// A round rod, the thicker the more it carries.
    Tree,
}

impl Structure {
    /// All, with their names.
    pub const NAMED: [(&'static str, Self); 3] = [("x", Self::X), ("prism", Self::Prism), ("tree", Self::Tree)];
}

/// A prism is so much of a step narrower than its square, so that neighbours stay solids of their own.
const NARROWER: f64 = 0.02;
/// A sheet ends so much of its thickness beyond the corner of its cell, within the sheets of the neighbours.
const BEYOND: f64 = 0.4;
/// Corners of a rod.
const ROUND: usize = 12;

/// A cross-section's corners about its middle, counter-clockwise from above, and the triangles that fill it.
#[derive(Clone, Debug)]
pub struct Outline {
    corners: Vec<[f64; 2]>,
    fill: Vec<[usize; 3]>,
    grows: bool,
    step_mm: f64,
    wall_mm: f64,
}

impl Outline {
    /// The cross-section of a structure in squares of `step_mm`.
    pub fn of(how: &Build, step_mm: f64) -> Self {
        let (corners, fill) = match how.structure {
            Structure::X => cross(std::f64::consts::FRAC_1_SQRT_2 * step_mm + BEYOND * how.wall_mm, 0.5 * how.wall_mm),
            Structure::Prism => {
                let half = 0.5 * step_mm * (1.0 - NARROWER);
                (vec![[-half, -half], [half, -half], [half, half], [-half, half]], fan(4))
            }
            Structure::Tree => {
                let turn = |k: usize| std::f64::consts::TAU * k as f64 / ROUND as f64;
                ((0..ROUND).map(|k| [turn(k).cos(), turn(k).sin()]).collect(), fan(ROUND))
            }
        };
        Self { corners, fill, grows: how.structure == Structure::Tree, step_mm, wall_mm: how.wall_mm }
    }

    /// Whether cross-sections depend on the flow.
    pub(super) fn grows(&self) -> bool {
        self.grows
    }

    /// The size of a cross-section that carries `units`: 1, or a rod's radius, whose area grows with the units up to the square.
    pub(super) fn size(&self, units: u16) -> f64 {
        if self.grows { (self.wall_mm * f64::from(units).sqrt()).min(0.5 * self.step_mm) } else { 1.0 }
    }

    /// Area of a cross-section, mm².
    pub fn area(&self, size: f64) -> f64 {
        let count = self.corners.len();
        let twice: f64 = (0..count)
            .map(|i| {
                let ([a, b], [c, d]) = (self.corners[i], self.corners[(i + 1) % count]);
                a * d - b * c
            })
            .sum();
        0.5 * twice * size * size
    }

    /// Its corners about `middle`.
    pub(super) fn ring(&self, middle: &Vec3, size: f64) -> Vec<Vec3> {
        self.corners.iter().map(|[x, y]| middle + Vec3::new(x * size, y * size, 0.0)).collect()
    }

    /// Adds the closed solid over `rings`, from the top down, `top` above them if there is one.
    pub(super) fn add(
        &self,
        vertices: &mut Vec<Vec3>,
        facets: &mut Vec<[u32; 3]>,
        top: Option<Vec<Vec3>>,
        rings: &[(Vec3, f64)],
    ) {
        let (first, around) = (vertices.len(), self.corners.len());
        let under_surface = top.is_some();
        vertices.extend(top.into_iter().flatten());
        rings.iter().for_each(|(middle, size)| vertices.extend(self.ring(middle, *size)));
        let count = (vertices.len() - first) / around;
        let at = |ring: usize, k: usize| (first + ring * around + k % around) as u32;
        // A reader that asks where a solid lies asks for its first facet, which must not lie within another chain: the top under the
        // surface, or, of a chain that begins beside another, its middle.
        facets.extend(self.fill.iter().filter(|_| under_surface).map(|t| t.map(|k| at(0, k))));
        for ring in (1..count).map(|ring| 1 + (ring - 1 + count / 2) % (count - 1)) {
            for k in 0..around {
                let [a, b, c, d] = [at(ring - 1, k), at(ring - 1, k + 1), at(ring, k + 1), at(ring, k)];
                facets.extend([[a, d, c], [a, c, b]]);
            }
        }
        facets.extend(self.fill.iter().filter(|_| !under_surface).map(|t| t.map(|k| at(0, k))));
        facets.extend(self.fill.iter().map(|&[a, b, c]| [a, c, b].map(|k| at(count - 1, k))));
    }
}

/// Triangles from the first corner to all others.
fn fan(count: usize) -> Vec<[usize; 3]> {
    (1..count - 1).map(|k| [0, k, k + 1]).collect()
}

/// Two bars of half length `arm` and half width `half` along the diagonals.
fn cross(arm: f64, half: f64) -> (Vec<[f64; 2]>, Vec<[usize; 3]>) {
    // One arm along +x: its end from right to left, then the corner to the next arm; each next arm a quarter turn on.
    let one = [[arm, -half], [arm, half], [half, half]];
    let turned = |[x, y]: [f64; 2], quarter: usize| {
        let (s, c) = (std::f64::consts::FRAC_PI_4 + std::f64::consts::FRAC_PI_2 * quarter as f64).sin_cos();
        [c * x - s * y, s * x + c * y]
    };
    let corners = (0..4).flat_map(|quarter| one.map(|corner| turned(corner, quarter))).collect();
    // Corners 2, 5, 8, 11 are those of the middle.
    let mut fill = vec![[2, 5, 8], [2, 8, 11]];
    for quarter in 0..4 {
        let (first, inner) = (3 * quarter, (3 * quarter + 11) % 12);
        fill.extend([[inner, first, first + 1], [inner, first + 1, first + 2]]);
    }
    (corners, fill)
}
