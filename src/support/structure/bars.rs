//! A roof as meshes: bars along x at a pitch of their own, below the surface that is held.
//!
//! Slot frame, mm. A bar follows the surface over one red square, a gap below it, as thick as a wall and as high as the roof. Bars of
//! squares side by side overlap by a hair and share no corner, as columns do.

use super::top::Ceiling;
use crate::geom::Vec3;
use crate::support::graph::Graph;

/// A roof of bars.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bars {
    /// How high, mm.
    pub high_mm: f64,
    /// From the middle of one to that of the next, mm.
    pub pitch_mm: f64,
}

/// The surface is looked up as often along a bar, mm.
const SAMPLE_MM: f64 = 0.5;
/// A bar goes so far beside all sheets somewhere, in walls, or it is left out: it would lie in one of them.
const CLEAR_WALLS: f64 = 0.8;
/// Bars end so much of a step beyond their square.
const BEYOND: f64 = 0.005;

/// What bars are made of.
pub(super) struct Beam<'a> {
    pub(super) graph: &'a Graph,
    pub(super) ceiling: &'a Ceiling,
    pub(super) bars: Bars,
    pub(super) wall_mm: f64,
    pub(super) gap_mm: f64,
}

/// A bar's middle line, on its upper side.
type Ridge = Vec<Vec3>;

impl Beam<'_> {
    /// The bars below the surface over a red square.
    pub(super) fn over(&self, red: usize) -> Vec<Ridge> {
        let (at, half) = (self.graph.grid.middle(red), self.graph.grid.step_mm / 2.0);
        let [first, last] = [at.y - half, at.y + half].map(|y| (y / self.bars.pitch_mm - 0.5).ceil() as i64);
        let count = (2.0 * half / SAMPLE_MM).ceil().max(2.0) as usize;
        let reach = half * (1.0 + 2.0 * BEYOND);
        let row = |y: f64| -> Vec<Ridge> {
            let place = |k: usize| Vec3::new(at.x + reach * (2.0 * k as f64 / count as f64 - 1.0), y, at.z);
            let tops: Vec<Option<Vec3>> = (0..=count).map(|k| self.top(red, place(k))).collect();
            let runs = tops.split(Option::is_none).map(|run| run.iter().flatten().copied().collect());
            runs.filter(|ridge: &Ridge| ridge.len() > 1 && self.is_clear(ridge)).collect()
        };
        (first..last).flat_map(|j| row((j as f64 + 0.5) * self.bars.pitch_mm)).collect()
    }

    /// The upper side at a place: below the lowest surface over its width.
    fn top(&self, red: usize, at: Vec3) -> Option<Vec3> {
        let across = [-0.5, 0.0, 0.5].map(|share| at + Vec3::y() * share * self.wall_mm);
        let heights = across.map(|at| self.ceiling.surface(red, &at));
        let low = heights.into_iter().try_fold(f64::INFINITY, |low, height| height.map(|height| low.min(height)))?;
        Some(Vec3::new(at.x, at.y, low - self.gap_mm))
    }

    /// Adds a bar as a closed solid; its upper side, mm².
    pub(super) fn add(&self, ridge: &Ridge, vertices: &mut Vec<Vec3>, facets: &mut Vec<[u32; 3]>) -> f64 {
        let base = vertices.len();
        let (half, high) = (self.wall_mm / 2.0, self.bars.high_mm);
        for top in ridge {
            let corners = [[-half, -high], [half, -high], [half, 0.0], [-half, 0.0]];
            vertices.extend(corners.map(|[y, z]| top + Vec3::new(0.0, y, z)));
        }
        let at = |ring: usize, k: usize| (base + 4 * ring + k % 4) as u32;
        let side = |ring: usize, k: usize| {
            let [a, b, c, d] = [at(ring, k), at(ring, k + 1), at(ring + 1, k + 1), at(ring + 1, k)];
            [[a, b, c], [a, c, d]]
        };
        let rings = ridge.len();
        // A reader that asks where a solid lies asks for its first facet: the upper side as far from sheets as can be.
        let first = self.clearest(ridge);
        facets.extend(side(first, 2));
        let sides = (0..rings - 1).flat_map(|ring| (0..4).map(move |k| (ring, k)));
        facets.extend(sides.filter(|one| *one != (first, 2)).flat_map(|(ring, k)| side(ring, k)));
        let end = rings - 1;
        facets.extend([[at(0, 0), at(0, 2), at(0, 1)], [at(0, 0), at(0, 3), at(0, 2)]]);
        facets.extend([[at(end, 0), at(end, 1), at(end, 2)], [at(end, 0), at(end, 2), at(end, 3)]]);
        ridge.windows(2).map(|pair| (pair[1].x - pair[0].x) * self.wall_mm).sum()
    }

    /// The stretch of a bar that lies farthest from the diagonals of its square.
    fn clearest(&self, ridge: &Ridge) -> usize {
        let apart = |k: &usize| self.beside_sheets_mm(ridge, *k);
        (0..ridge.len() - 1).max_by(|a, b| apart(a).total_cmp(&apart(b))).unwrap_or(0)
    }

    /// Whether it is more than a piece of a sheet.
    fn is_clear(&self, ridge: &Ridge) -> bool {
        self.beside_sheets_mm(ridge, self.clearest(ridge)) > CLEAR_WALLS * self.wall_mm
    }

    /// How far the middle of a stretch is from the nearest diagonal of its square, mm.
    fn beside_sheets_mm(&self, ridge: &Ridge, k: usize) -> f64 {
        let grid = &self.graph.grid;
        let steps = grid.in_steps(&((ridge[k] + ridge[k + 1]) / 2.0));
        let [x, y] = [0, 1].map(|axis| (steps[axis].rem_euclid(1.0) - 0.5).abs());
        (x - y).abs() * grid.step_mm * std::f64::consts::FRAC_1_SQRT_2
    }
}
