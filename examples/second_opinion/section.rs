//! Geometry within a layer: a part's cut, points on a grid, what lines are near a point, and how far an outline is shifted.

use super::grid::Grid;
use super::maths::{Facet, V, add, bounds, cross, dot, lerp, scale, segment_distance, steps};
use super::scene::Bead;
use std::collections::HashMap;

/// A horizontal cut through a mesh, and the numbers of its segments by rows of half a millimetre.
pub struct Section {
    segments: Vec<[[f64; 2]; 2]>,
    rows: HashMap<i64, Vec<usize>>,
}

fn row(y: f64) -> i64 {
    (y * 2.0).floor() as i64
}

impl Section {
    pub fn new(mesh: &[Facet], z: f64) -> Self {
        let segments: Vec<[[f64; 2]; 2]> = mesh.iter().filter_map(|facet| segment(facet, z)).collect();
        let mut rows = HashMap::<i64, Vec<usize>>::new();
        for (index, [p, q]) in segments.iter().enumerate() {
            for r in row(p[1].min(q[1]))..=row(p[1].max(q[1])) {
                rows.entry(r).or_default().push(index);
            }
        }
        Self { segments, rows }
    }

    pub fn area(&self) -> f64 {
        self.segments.iter().map(|[p, q]| (p[0] * q[1] - q[0] * p[1]) / 2.0).sum::<f64>().abs()
    }

    /// Twice its area over its outline, mm.
    pub fn mean_width(&self) -> f64 {
        let outline: f64 = self.segments.iter().map(|[p, q]| (q[0] - p[0]).hypot(q[1] - p[1])).sum();
        2.0 * self.area() / outline.max(1e-9)
    }

    /// Whether a point is inside, by the winding number.
    fn holds(&self, [x, y, _]: V) -> bool {
        let mut winding = 0;
        for [p, q] in self.rows.get(&row(y)).into_iter().flatten().map(|index| self.segments[*index]) {
            if (p[1] <= y) != (q[1] <= y) && p[0] + (y - p[1]) / (q[1] - p[1]) * (q[0] - p[0]) > x {
                winding += if p[1] <= y { 1 } else { -1 };
            }
        }
        winding != 0
    }

    /// How far outside a point is, at most 5 mm; 0 inside.
    pub fn outside(&self, p: V) -> f64 {
        if self.holds(p) {
            return 0.0;
        }
        self.segments.iter().map(|segment| segment_distance(*segment, [p[0], p[1]])).fold(5.0, f64::min)
    }

    /// Points of the outline, half a millimetre apart, and the direction across it.
    pub fn outline(&self) -> Vec<([f64; 2], [f64; 2])> {
        let (mut points, mut walked) = (Vec::new(), 0.25);
        for &[p, q] in &self.segments {
            let (dx, dy) = (q[0] - p[0], q[1] - p[1]);
            let way = dx.hypot(dy);
            while walked < way {
                points.push((lerp(p, q, walked / way), [dy / way, -dx / way]));
                walked += 0.5;
            }
            walked -= way;
        }
        points
    }

    /// Points inside, on a grid.
    pub fn raster(&self, step: f64) -> Vec<V> {
        let ring: Vec<V> = self.segments.iter().map(|[p, _]| [p[0], p[1], 0.0]).collect();
        raster(&ring, step).into_iter().filter(|p| self.holds(*p)).collect()
    }
}

/// Where a facet crosses a height, in the outline's direction.
fn segment(facet: &Facet, z: f64) -> Option<[[f64; 2]; 2]> {
    let above = facet.map(|p| p[2] >= z);
    let lone = (0..3).find(|i| above[*i] != above[(i + 1) % 3] && above[*i] != above[(i + 2) % 3])?;
    let cut = |other: usize| {
        let (a, b) = (facet[lone], facet[other % 3]);
        let [x, y, _] = lerp(a, b, (z - a[2]) / (b[2] - a[2]));
        [x, y]
    };
    let [p, q] = [cut(lone + 1), cut(lone + 2)];
    Some(if above[lone] { [p, q] } else { [q, p] })
}

/// A grid over the box of some points.
fn raster(points: &[V], step: f64) -> Vec<V> {
    let [low, high] = bounds(points.iter().copied());
    let Some(&[_, _, z]) = points.first() else { return Vec::new() };
    let [nx, ny] = [0, 1].map(|i| steps(high[i] - low[i], step));
    let place = |i: usize, n: usize, k: usize| low[i] + (high[i] - low[i]) * (k as f64 + 0.5) / n as f64;
    (0..nx * ny).map(|k| [place(0, nx, k % nx), place(1, ny, k / nx), z]).collect()
}

/// Points of a convex polygon, on a grid.
pub fn raster_of(face: &[V], step: f64) -> Vec<V> {
    let side = |a: V, b: V, p: V| (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]);
    let holds = |p: &V| {
        let mut sides = (0..face.len()).map(|i| side(face[i], face[(i + 1) % face.len()], *p));
        sides.clone().all(|s| s >= 0.0) || sides.all(|s| s <= 0.0)
    };
    raster(face, step).into_iter().filter(holds).collect()
}

/// Beads of one layer.
pub struct Near<'a>(Grid<&'a Bead, 2>);

impl<'a> Near<'a> {
    pub fn new(beads: &[&'a Bead]) -> Self {
        let mut grid = Grid::<&Bead, 2>::new();
        for &bead in beads {
            for [x, y, _] in bead.places(0.5) {
                let cell = grid.cell([x, y]);
                if cell.last().is_none_or(|last| !std::ptr::eq(*last, bead)) {
                    cell.push(bead);
                }
            }
        }
        Self(grid)
    }

    /// Least distance of a bead's middle from a point, less `reach`; infinite from a millimetre on.
    pub fn least(&self, p: [f64; 2], reach: impl Fn(&Bead) -> f64) -> f64 {
        let far = |bead: &&Bead| segment_distance(bead.ends.map(|[x, y, _]| [x, y]), p) - reach(bead);
        self.0.near(p, 1.0).map(far).fold(f64::INFINITY, f64::min)
    }

    /// The share of points that lie under a bead.
    pub fn covered(&self, points: &[V]) -> f64 {
        let under = points.iter().filter(|p| self.least([p[0], p[1]], |bead| bead.width / 2.0 + 0.01) <= 0.0);
        under.count() as f64 / points.len().max(1) as f64
    }
}

/// Least squares of `gap = inset + direction * shift` over an outline.
#[derive(Default)]
pub struct Fit {
    matrix: [V; 3],
    right: V,
}

impl Fit {
    pub fn add(&mut self, out: [f64; 2], gap: f64) {
        let row = [1.0, out[0], out[1]];
        self.join(&Self { matrix: row.map(|x| scale(row, x)), right: scale(row, gap) });
    }

    pub fn join(&mut self, other: &Self) {
        self.right = add(self.right, other.right);
        self.matrix = [0, 1, 2].map(|i| add(self.matrix[i], other.matrix[i]));
    }

    /// Length of the shift; 0 where too little is known.
    pub fn shift(&self) -> f64 {
        let ([a, b, c], r) = (self.matrix, self.right);
        let whole = dot(a, cross(b, c));
        if a[0] < 20.0 || whole < 1e-3 * a[0].powi(3) {
            return 0.0;
        }
        // The matrix is symmetric: its rows are its columns.
        (dot(a, cross(r, c)) / whole).hypot(dot(a, cross(b, r)) / whole)
    }
}
