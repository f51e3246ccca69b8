//! A sliced file beside the solid it was made from, layer by layer on a fine grid. It shares no code with slicing: the section is
//! taken facet by facet and row by row, the beads from the moves and their E.

use std::f64::consts::PI;

use trunnion::geom::{Slot, Vec3};
use trunnion::mesh::TriangleMesh;

use super::moves::{Step, steps};

/// The grid's cells, mm.
const CELL_MM: f64 = 0.025;

/// One printing move.
pub(crate) struct Bead {
    from: [f64; 2],
    to: [f64; 2],
    pub(crate) z: f64,
    /// Filament, mm.
    e: f64,
    /// Moves without a travel between them have one number.
    path: u32,
    /// How far along its path it begins, mm.
    along: f64,
}

impl Bead {
    pub(crate) fn length(&self) -> f64 {
        (self.to[0] - self.from[0]).hypot(self.to[1] - self.from[1])
    }

    /// Its direction, degrees from +X, 0 to 180.
    pub(crate) fn direction_deg(&self) -> f64 {
        (self.to[1] - self.from[1]).atan2(self.to[0] - self.from[0]).to_degrees().rem_euclid(180.0)
    }

    /// The same line, laid by another path.
    pub(crate) fn by_another(self) -> Self {
        Self { path: self.path + 1_000_000, ..self }
    }

    /// Its cross-section, mm².
    fn area(&self) -> f64 {
        self.e * FILAMENT_MM2 / self.length()
    }

    /// A rectangle with round sides of its cross-section is so wide, mm.
    pub(crate) fn width(&self, height: f64) -> f64 {
        self.area() / height + height * (1.0 - PI / 4.0)
    }
}

const FILAMENT_MM2: f64 = PI / 4.0 * 1.75 * 1.75;

/// The printing moves of a file.
pub(crate) fn beads(gcode: &str) -> Vec<Bead> {
    let (mut path, mut along) = (0, 0.0);
    let mut found = Vec::new();
    for Step { from, to, e, .. } in steps(gcode) {
        let length = (to[0] - from[0]).hypot(to[1] - from[1]);
        if e > 0.0 && length > 0.0 {
            let z = to[2];
            let [from, to] = [from, to].map(|p| [p[0], p[1]]);
            found.push(Bead { from, to, z, e, path, along });
            along += length;
        } else if length > 0.0 {
            (path, along) = (path + 1, 0.0);
        }
    }
    found
}

/// What is right and wrong, mm² added up over the layers that were looked at, and the volumes of all layers.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sums {
    section: f64,
    gap: f64,
    outside: f64,
    doubled: f64,
    wanted_mm3: f64,
    laid_mm3: f64,
}

impl Sums {
    /// The part of the section that no line covers.
    pub(crate) fn gap(&self) -> f64 {
        self.gap / self.section
    }

    /// What lines cover beyond it, by more than two cells.
    pub(crate) fn outside(&self) -> f64 {
        self.outside / self.section
    }

    /// What two lines cover.
    pub(crate) fn doubled(&self) -> f64 {
        self.doubled / self.section
    }

    /// Plastic over volume.
    pub(crate) fn volume(&self) -> f64 {
        self.laid_mm3 / self.wanted_mm3
    }
}

/// Holds every `every`th layer of the solid against the moves, the volume of all.
pub(crate) fn judged(mesh: &TriangleMesh<Slot>, beads: &[Bead], height: f64, every: usize) -> Sums {
    let bounds = mesh.bounds();
    let layers = (bounds.max.z / height).round() as usize;
    let mut sums = Sums::default();
    let mut grid = Grid::new([bounds.min.x, bounds.min.y], [bounds.max.x, bounds.max.y]);
    for layer in 0..layers {
        let (middle, top) = ((layer as f64 + 0.5) * height, (layer as f64 + 1.0) * height);
        let here: Vec<&Bead> = beads.iter().filter(|b| (b.z - top).abs() < height / 4.0).collect();
        let segments = cut(mesh, middle);
        sums.wanted_mm3 += area(&segments) * height;
        sums.laid_mm3 += here.iter().map(|bead| bead.e * FILAMENT_MM2).sum::<f64>();
        if layer % every == every / 2 {
            grid.clear();
            grid.fill(&segments);
            here.iter().for_each(|bead| grid.lay(bead, height));
            grid.count(&mut sums);
        }
    }
    sums
}

/// The facets' lines in a plane, the solid on their left.
pub(crate) fn cut(mesh: &TriangleMesh<Slot>, z: f64) -> Vec<[[f64; 2]; 2]> {
    let mut found = Vec::new();
    for facet in mesh.facets() {
        let corners = facet.map(|i| mesh.vertices()[i as usize]);
        let crossing = |a: Vec3, b: Vec3| {
            // One order of the ends, so that both facets at an edge agree.
            let (a, b) = if (a.z, a.x, a.y) < (b.z, b.x, b.y) { (a, b) } else { (b, a) };
            let t = (z - a.z) / (b.z - a.z);
            [a.x + (b.x - a.x) * t, a.y + (b.y - a.y) * t]
        };
        let (mut down, mut up) = (None, None);
        for i in 0..3 {
            let (a, b) = (corners[i], corners[(i + 1) % 3]);
            match (a.z >= z, b.z >= z) {
                (true, false) => down = Some(crossing(a, b)),
                (false, true) => up = Some(crossing(a, b)),
                _ => {}
            }
        }
        found.extend(down.zip(up).map(|(from, to)| [from, to]));
    }
    found
}

/// The area where the winding number is positive, by strips a fifth of a cell high.
fn area(segments: &[[[f64; 2]; 2]]) -> f64 {
    let (low, high) = segments.iter().flatten().fold((f64::MAX, f64::MIN), |(l, h), p| (l.min(p[1]), h.max(p[1])));
    let step = CELL_MM / 1.7;
    let rows = ((high - low) / step).ceil().max(0.0);
    let step = (high - low) / rows.max(1.0);
    let mut sum = 0.0;
    for row in 0..rows as usize {
        let y = low + (row as f64 + 0.5) * step;
        spans(segments, y, |from, to| sum += (to - from) * step);
    }
    sum
}

/// Visits where the row at `y` is inside.
pub(crate) fn spans(segments: &[[[f64; 2]; 2]], y: f64, mut visit: impl FnMut(f64, f64)) {
    let mut hits: Vec<(f64, i32)> = Vec::new();
    for [a, b] in segments {
        if (a[1] <= y) != (b[1] <= y) {
            let x = a[0] + (b[0] - a[0]) * (y - a[1]) / (b[1] - a[1]);
            // The solid lies on the left: of a line that goes down, towards greater x.
            hits.push((x, if b[1] < a[1] { 1 } else { -1 }));
        }
    }
    hits.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut winding, mut from) = (0, 0.0);
    for (x, turn) in hits {
        if winding == 0 {
            from = x;
        }
        winding += turn;
        if winding == 0 {
            visit(from, x);
        }
    }
}

#[derive(Clone, Copy, Default)]
struct Cell {
    inside: bool,
    covered: bool,
    doubled: bool,
    path: u32,
    along: f32,
}

struct Grid {
    low: [f64; 2],
    size: [usize; 2],
    cells: Vec<Cell>,
}

impl Grid {
    fn new(min: [f64; 2], max: [f64; 2]) -> Self {
        let low = min.map(|v| v - 0.5);
        let size = [0, 1].map(|i| ((max[i] + 0.5 - low[i]) / CELL_MM).ceil() as usize);
        Self { low, size, cells: vec![Cell::default(); size[0] * size[1]] }
    }

    fn clear(&mut self) {
        self.cells.fill(Cell::default());
    }

    fn fill(&mut self, segments: &[[[f64; 2]; 2]]) {
        for row in 0..self.size[1] {
            let y = self.low[1] + (row as f64 + 0.5) * CELL_MM;
            let (x0, width) = (self.low[0], self.size[0]);
            let cells = &mut self.cells[row * width..(row + 1) * width];
            spans(segments, y, |from, to| {
                let index = |x: f64| ((x - x0) / CELL_MM + 0.5).clamp(0.0, width as f64) as usize;
                cells[index(from)..index(to)].iter_mut().for_each(|cell| cell.inside = true);
            });
        }
    }

    /// A line covers what lies within half its width of its middle. Filled is the rectangle that its cross-section makes at its
    /// height; where two of these lie on each other by more than a cell, and are not a line and its own next bend, is too much.
    fn lay(&mut self, bead: &Bead, height: f64) {
        let (wide, filled) = (bead.width(height) / 2.0, bead.area() / height / 2.0 - CELL_MM / 2.0);
        let length = bead.length();
        let along = [0, 1].map(|i| (bead.to[i] - bead.from[i]) / length);
        let index = |v: f64, i: usize| ((v - self.low[i]) / CELL_MM).clamp(0.0, self.size[i] as f64 - 1.0) as usize;
        let from = [0, 1].map(|i| index(bead.from[i].min(bead.to[i]) - wide, i));
        let to = [0, 1].map(|i| index(bead.from[i].max(bead.to[i]) + wide, i));
        for row in from[1]..=to[1] {
            for column in from[0]..=to[0] {
                let p = [column, row].map(|k| (k as f64 + 0.5) * CELL_MM);
                let v = [0, 1].map(|i| p[i] + self.low[i] - bead.from[i]);
                let (ahead, beside) = (v[0] * along[0] + v[1] * along[1], (v[1] * along[0] - v[0] * along[1]).abs());
                let beyond = (ahead - length).max(-ahead).max(0.0);
                let cell = &mut self.cells[row * self.size[0] + column];
                if beside.hypot(beyond) <= wide {
                    let near = (bead.along + ahead - f64::from(cell.along)).abs() < 6.0 * wide;
                    let ends = beyond > 0.0 || beside > filled;
                    cell.doubled |= !ends && cell.path > 0 && !(cell.path == bead.path + 1 && near);
                    cell.covered = true;
                    if !ends {
                        (cell.path, cell.along) = (bead.path + 1, (bead.along + ahead) as f32);
                    }
                }
            }
        }
    }

    fn count(&self, sums: &mut Sums) {
        let cell = CELL_MM * CELL_MM;
        for (index, c) in self.cells.iter().enumerate() {
            sums.section += if c.inside { cell } else { 0.0 };
            sums.gap += if c.inside && !c.covered { cell } else { 0.0 };
            sums.doubled += if c.inside && c.doubled { cell } else { 0.0 };
            sums.outside += if c.covered && !c.inside && self.is_far_out(index) { cell } else { 0.0 };
        }
    }

    /// Whether nothing inside is within two cells.
    fn is_far_out(&self, index: usize) -> bool {
        let (x, y) = ((index % self.size[0]) as i64, (index / self.size[0]) as i64);
        let inside = |x: i64, y: i64| {
            let in_grid = x >= 0 && y >= 0 && x < self.size[0] as i64 && y < self.size[1] as i64;
            in_grid && self.cells[y as usize * self.size[0] + x as usize].inside
        };
        !(-2..=2).any(|dy| (-2..=2).any(|dx| inside(x + dx, y + dy)))
    }
}
