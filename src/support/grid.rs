//! The grid of cubes over a print's space, and which of them its surface touches.
//!
//! Lengths mm, slot frame (+Z up, the ground at z = 0). Cube `(x, y, z)` of `[nx, ny, nz]` has the index
//! `x + nx (y + ny z)`; the same index names the square below it, which is a node of the support graph.

use crate::geom::Vec3;

/// Cubes of one size that fill a box whose corner with the smallest coordinates is `origin`; the ground is its bottom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// The corner, mm, slot frame.
    pub origin: Vec3,
    /// Edge of a cube, mm.
    pub step_mm: f64,
    /// Cubes along x, y and z.
    pub size: [usize; 3],
}

impl Grid {
    /// The cubes that cover `space` (lengths along x, y, z, mm) from `origin` on; a last one may stand out of it.
    pub fn over(origin: Vec3, space: [f64; 3], step_mm: f64) -> Self {
        // A length of whole steps must not become one more by rounding.
        let count = |length: f64| ((length / step_mm - 1e-9).ceil() as usize).max(1);
        Self { origin, step_mm, size: space.map(count) }
    }

    /// Cubes in all, as a float, since what is asked for may be more than can be counted.
    pub fn cubes_needed(space: [f64; 3], step_mm: f64) -> f64 {
        space.iter().map(|length| (length / step_mm - 1e-9).ceil().max(1.0)).product()
    }

    /// Cubes in all.
    pub fn len(&self) -> usize {
        self.size.iter().product()
    }

    /// Whether there is no cube.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Cubes of one level.
    pub fn level(&self) -> usize {
        self.size[0] * self.size[1]
    }

    /// The index of a cube.
    pub fn index(&self, [x, y, z]: [usize; 3]) -> usize {
        x + self.size[0] * (y + self.size[1] * z)
    }

    /// The cube of an index.
    pub fn cube(&self, index: usize) -> [usize; 3] {
        let [nx, ny, _] = self.size;
        [index % nx, index / nx % ny, index / (nx * ny)]
    }

    /// The middle of the square below a cube, mm.
    pub fn middle(&self, index: usize) -> Vec3 {
        let [x, y, z] = self.cube(index).map(|i| i as f64);
        self.origin + Vec3::new(x + 0.5, y + 0.5, z) * self.step_mm
    }

    /// A point in steps from the origin.
    pub(super) fn in_steps(&self, point: &Vec3) -> [f64; 3] {
        ((point - self.origin) / self.step_mm).into()
    }

    /// The cubes along `axis` that the stretch from `low` to `high` (in steps) touches; a border belongs to both sides.
    fn touched(&self, axis: usize, low: f64, high: f64) -> std::ops::Range<usize> {
        let first = (low.ceil() - 1.0).max(0.0) as usize;
        let behind = (high.floor() + 1.0).clamp(0.0, self.size[axis] as f64) as usize;
        first..behind.max(first)
    }

    /// Calls `each` with every cube that the triangle touches, borders included. Corners in mm; a triangle without area
    /// is its longest edge, or a point.
    ///
    /// The triangle is cut into slabs along x and those along y: what is left of it in a column is a convex polygon,
    /// whose lowest and highest point say which cubes of the column it touches. No tolerance: a corner in a plane of
    /// the grid touches the cubes on both sides.
    pub fn touching(&self, corners: &[Vec3; 3], mut each: impl FnMut(usize)) {
        let triangle = corners.map(|corner| self.in_steps(&corner));
        let (mut slab, mut column) = (Vec::with_capacity(8), Vec::with_capacity(8));
        let (low, high) = span(&triangle, 0);
        for x in self.touched(0, low, high) {
            within(&triangle, 0, x as f64, &mut slab);
            if slab.is_empty() {
                continue;
            }
            let (low, high) = span(&slab, 1);
            for y in self.touched(1, low, high) {
                within(&slab, 1, y as f64, &mut column);
                if column.is_empty() {
                    continue;
                }
                let (low, high) = span(&column, 2);
                for z in self.touched(2, low, high) {
                    each(self.index([x, y, z]));
                }
            }
        }
    }
}

/// The least and the greatest coordinate along `axis`.
fn span(polygon: &[[f64; 3]], axis: usize) -> (f64, f64) {
    polygon.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| (low.min(p[axis]), high.max(p[axis])))
}

/// What of a convex polygon lies between `low` and `low + 1` along `axis`, into `kept`.
fn within(polygon: &[[f64; 3]], axis: usize, low: f64, kept: &mut Vec<[f64; 3]>) {
    let mut half = Vec::with_capacity(8);
    beyond(polygon, axis, low, 1.0, &mut half);
    beyond(&half, axis, low + 1.0, -1.0, kept);
}

/// What of a convex polygon has `sense * (p[axis] - at) >= 0`, into `kept` (Sutherland and Hodgman, 1974).
fn beyond(polygon: &[[f64; 3]], axis: usize, at: f64, sense: f64, kept: &mut Vec<[f64; 3]>) {
    kept.clear();
    for (i, b) in polygon.iter().enumerate() {
        let a = &polygon[(i + polygon.len() - 1) % polygon.len()];
        let [from, to] = [a, b].map(|p| sense * (p[axis] - at));
        if (from < 0.0 && to > 0.0) || (from > 0.0 && to < 0.0) {
            let share = from / (from - to);
            let mut cut: [f64; 3] = std::array::from_fn(|k| a[k] + share * (b[k] - a[k]));
            cut[axis] = at;
            kept.push(cut);
        }
        if to >= 0.0 {
            kept.push(*b);
        }
    }
}
