//! A judge of printed supports: seven figures of any sliced file, whoever made it.
//!
//! It knows the surface that is held (corners of triangles, mm, +Z up) and the file's lines (`sliced.rs`), and shares no code with what
//! plans, lays or verifies supports. The figures are those by which Leitereg's (2020) methods are compared:
//!
//! ```text
//! volume         of all lines of support: the filament that they take, mm3
//! covered        share of the overhanging area that has support within half a pitch aside and half a pitch below (samples)
//! contact        what of that area lies on a line of support, as seen from above, mm2
//! plate          what the lowest layer takes of the plate, mm2
//! bare squares   squares of a pitch of which less than half is covered
//! widest         how far a place of a level ceiling is from the next line right below it, at most, mm (up to a pitch)
//! alone          the longest stretch of a column that nothing braces, mm (`columns.rs`)
//! seconds        what making the file took, from outside
//! ```

mod columns;
mod sliced;
mod tests;

pub(super) use sliced::{Layer, Line, lines_of, supports};

use std::collections::HashMap;

/// A triangle's corners, mm.
pub(super) type Triangle = [[f64; 3]; 3];

/// What is measured with.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ruler {
    /// Distance between a support's lines, mm.
    pub(super) pitch_mm: f64,
    /// Width of a line, mm.
    pub(super) line_mm: f64,
    /// Height of a layer, mm.
    pub(super) layer_mm: f64,
    /// Surfaces beyond this angle from the vertical want support.
    pub(super) overhang_deg: f64,
}

/// The figures of one file, without its seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Measures {
    pub(super) volume_mm3: f64,
    pub(super) covered: f64,
    pub(super) contact_mm2: f64,
    pub(super) plate_mm2: f64,
    pub(super) bare_squares: usize,
    pub(super) widest_mm: f64,
    pub(super) alone_mm: f64,
}

/// Distance between samples of the surface, mm.
const SAMPLE_MM: f64 = 0.23;
/// A surface is level where its normal leans by less, as a cosine.
const LEVEL: f64 = 0.999;
/// Edge of the cells in which area on the plate is counted, mm.
const PLATE_CELL_MM: f64 = 0.1;
/// What lies lower, in layers, stands on the plate by itself.
const ON_PLATE: f64 = 1.5;
/// Air below what lies on a support, in layers, at most.
const AIR: f64 = 2.0;

/// A place of the overhanging surface, and for how much area it stands.
struct Sample {
    at: [f64; 3],
    area: f64,
    /// As seen from above.
    shadow: f64,
    /// Whether the surface is level there.
    level: bool,
}

impl Ruler {
    /// The figures of these layers of support below this surface.
    pub(super) fn measure(&self, surface: &[Triangle], layers: &[Layer]) -> Measures {
        let near: Vec<Near<'_>> = layers.iter().map(|layer| Near::of(layer, self.pitch_mm)).collect();
        let (mut area, mut covered, mut contact_mm2, mut widest_mm) = (0.0, 0.0, 0.0, 0.0_f64);
        let mut squares: HashMap<[i64; 3], [f64; 2]> = HashMap::new();
        for sample in surface.iter().flat_map(|triangle| self.samples(triangle)) {
            let held = self.nearest_mm(&near, &sample.at, self.pitch_mm / 2.0) <= self.pitch_mm / 2.0;
            let aside_mm = self.nearest_mm(&near, &sample.at, 0.0);
            let lies = aside_mm <= self.line_mm / 2.0;
            widest_mm = widest_mm.max(if sample.level { aside_mm } else { 0.0 });
            area += sample.area;
            covered += if held { sample.area } else { 0.0 };
            contact_mm2 += if lies { sample.shadow } else { 0.0 };
            let square = squares.entry(sample.at.map(|v| (v / self.pitch_mm).floor() as i64)).or_default();
            square[usize::from(held)] += sample.area;
        }
        Measures {
            volume_mm3: layers.iter().flat_map(|layer| &layer.lines).map(|line| line.mm3).sum(),
            covered: if area > 0.0 { covered / area } else { 1.0 },
            contact_mm2,
            plate_mm2: layers.first().map_or(0.0, |lowest| plate_mm2(lowest, self.line_mm)),
            widest_mm,
            bare_squares: squares.values().filter(|[bare, held]| bare > held).count(),
            alone_mm: columns::longest_alone_mm(layers, self),
        }
    }

    /// How far aside the nearest line lies that is not higher than a place, and by no more than `below` and the usual air lower; up to
    /// a pitch.
    fn nearest_mm(&self, layers: &[Near<'_>], at: &[f64; 3], below: f64) -> f64 {
        let least = at[2] - below - AIR * self.layer_mm - 1e-6;
        let first = layers.partition_point(|near| near.layer.top_mm < least);
        let under = layers[first..].iter().take_while(|near| near.layer.top_mm < at[2] + 0.5 * self.layer_mm);
        under.map(|near| near.distance([at[0], at[1]])).fold(self.pitch_mm, f64::min)
    }

    /// Samples of a triangle that hangs over more than the threshold, evenly.
    fn samples(&self, &[a, b, c]: &Triangle) -> Vec<Sample> {
        let less = |p: [f64; 3], q: [f64; 3]| [0, 1, 2].map(|k| p[k] - q[k]);
        let (u, v) = (less(b, a), less(c, a));
        let normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        let twice = normal.iter().map(|n| n * n).sum::<f64>().sqrt();
        // The angle of the surface from the vertical is that of its normal from the level.
        if twice <= 0.0 || normal[2] >= -self.overhang_deg.to_radians().sin() * twice {
            return Vec::new();
        }
        let rows = ((twice.sqrt() / SAMPLE_MM).ceil() as usize).max(1);
        let count = (rows * rows) as f64;
        let at = |i: usize, j: usize, third: f64| {
            let (s, t) = ((i as f64 + third) / rows as f64, (j as f64 + third) / rows as f64);
            [0, 1, 2].map(|k| a[k] + s * u[k] + t * v[k])
        };
        let upright = (0..rows).flat_map(|i| (0..rows - i).map(move |j| (i, j, 1.0 / 3.0)));
        let turned = (0..rows).flat_map(|i| (0..(rows - i).saturating_sub(1)).map(move |j| (i, j, 2.0 / 3.0)));
        let all = upright.chain(turned).map(|(i, j, third)| at(i, j, third));
        let (area, shadow, level) = (twice / 2.0 / count, -normal[2] / 2.0 / count, normal[2] <= -LEVEL * twice);
        let sample = |at: [f64; 3]| Sample { at, area, shadow, level };
        all.filter(|at| at[2] > ON_PLATE * self.layer_mm).map(sample).collect()
    }
}

/// A layer's lines by the cells that are no farther from them than a reach.
struct Near<'a> {
    layer: &'a Layer,
    cell_mm: f64,
    lines: HashMap<[i64; 2], Vec<usize>>,
}

impl<'a> Near<'a> {
    fn of(layer: &'a Layer, reach_mm: f64) -> Self {
        let mut near = Self { layer, cell_mm: reach_mm.max(1.0), lines: HashMap::new() };
        for (index, line) in layer.lines.iter().enumerate() {
            let range = |k: usize| {
                let [low, high] = [line.from[k].min(line.to[k]), line.from[k].max(line.to[k])];
                near.cell(low - reach_mm)..=near.cell(high + reach_mm)
            };
            let cells: Vec<[i64; 2]> = range(0).flat_map(|x| range(1).map(move |y| [x, y])).collect();
            cells.into_iter().for_each(|cell| near.lines.entry(cell).or_default().push(index));
        }
        near
    }

    fn cell(&self, mm: f64) -> i64 {
        (mm / self.cell_mm).floor() as i64
    }

    /// To the middle of the nearest line, mm; of no meaning beyond the reach.
    fn distance(&self, at: [f64; 2]) -> f64 {
        let here = self.lines.get(&at.map(|v| self.cell(v))).into_iter().flatten();
        here.map(|&index| self.layer.lines[index].distance(at)).fold(f64::INFINITY, f64::min)
    }
}

/// What lines take of the plate.
fn plate_mm2(layer: &Layer, line_mm: f64) -> f64 {
    let near = Near::of(layer, line_mm / 2.0);
    let mut taken = std::collections::HashSet::new();
    for line in &layer.lines {
        let range = |k: usize| {
            let [low, high] = [line.from[k].min(line.to[k]), line.from[k].max(line.to[k])];
            let cell = |mm: f64| (mm / PLATE_CELL_MM).floor() as i64;
            cell(low - line_mm)..=cell(high + line_mm)
        };
        for x in range(0) {
            for y in range(1).filter(|&y| !taken.contains(&[x, y])).collect::<Vec<_>>() {
                let middle = [x, y].map(|i| (i as f64 + 0.5) * PLATE_CELL_MM);
                if near.distance(middle) <= line_mm / 2.0 {
                    taken.insert([x, y]);
                }
            }
        }
    }
    taken.len() as f64 * PLATE_CELL_MM * PLATE_CELL_MM
}
