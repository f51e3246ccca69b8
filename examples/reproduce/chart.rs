//! Charts on paper: curves over an axis, and a value over a plane.

use trunnion::view::{Anchor, Colour, Drawing, Format, INK};

/// Colours of curves, told apart by those who see few.
pub(crate) const CURVES: [Colour; 7] =
    [[0, 114, 178], [213, 94, 0], [0, 158, 115], [204, 121, 167], [230, 159, 0], [86, 180, 233], [90, 90, 90]];
const PALE: Colour = [222, 226, 231];
const WHITE: Colour = [255, 255, 255];
/// Of the frame around a chart: left, top, right, bottom.
const EDGE: [f64; 4] = [70.0, 38.0, 20.0, 46.0];
/// Dark to bright (viridis).
const SCALE: [[f64; 3]; 5] =
    [[68.0, 1.0, 84.0], [59.0, 82.0, 139.0], [33.0, 145.0, 140.0], [94.0, 201.0, 98.0], [253.0, 231.0, 37.0]];
const LEVELS: usize = 20;
/// More points than this are drawn as small squares.
const MANY: usize = 120;

/// A curve, or points by themselves.
pub(crate) struct Curve {
    pub(crate) name: String,
    pub(crate) points: Vec<[f64; 2]>,
    /// Marks at the points instead of a line between them.
    pub(crate) dots: bool,
}

impl Curve {
    pub(crate) fn line(name: impl Into<String>, points: Vec<[f64; 2]>) -> Self {
        Self { name: name.into(), points, dots: false }
    }

    pub(crate) fn dots(name: impl Into<String>, points: Vec<[f64; 2]>) -> Self {
        Self { name: name.into(), points, dots: true }
    }

    /// A function at `count` places from `low` to `high`.
    pub(crate) fn of(name: impl Into<String>, [low, high]: [f64; 2], count: usize, f: impl Fn(f64) -> f64) -> Self {
        let at = |i: usize| low + (high - low) * i as f64 / (count - 1) as f64;
        Self::line(name, (0..count).map(|i| [at(i), f(at(i))]).collect())
    }
}

/// Curves over an axis.
pub(crate) struct Chart {
    pub(crate) title: String,
    /// What the axes count, to the right and upward.
    pub(crate) axes: [&'static str; 2],
    /// Whether an axis counts powers of ten; values at or below zero are left out then.
    pub(crate) logarithmic: [bool; 2],
    pub(crate) curves: Vec<Curve>,
}

impl Chart {
    pub(crate) fn new(title: impl Into<String>, axes: [&'static str; 2], curves: Vec<Curve>) -> Self {
        Self { title: title.into(), axes, logarithmic: [false; 2], curves }
    }

    pub(crate) fn logarithmic(self) -> Self {
        Self { logarithmic: [true; 2], ..self }
    }

    pub(crate) fn svg(&self) -> String {
        let scaled = |p: &[f64; 2]| [0, 1].map(|k| if self.logarithmic[k] { p[k].log10() } else { p[k] });
        let curves: Vec<Vec<[f64; 2]>> =
            self.curves.iter().map(|curve| curve.points.iter().map(scaled).collect()).collect();
        let finite = |p: &&[f64; 2]| p.iter().all(|v| v.is_finite());
        let range = [0, 1].map(|k| spread(curves.iter().flatten().filter(finite).map(|p| p[k]), k == 1));
        let mut paper = Paper::new(&self.title, [470.0, 300.0], range, legend_height(self.curves.len()));
        paper.frame(self.axes, self.logarithmic);
        for (i, (curve, points)) in self.curves.iter().zip(&curves).enumerate() {
            let colour = CURVES[i % CURVES.len()];
            let places: Vec<[f64; 2]> = points.iter().filter(finite).map(|p| paper.place(*p)).collect();
            if curve.dots {
                places.iter().for_each(|at| paper.drawing.circle(*at, 2.6, 2.2, colour));
            } else {
                paper.drawing.line(places, 1.6, colour);
            }
            paper.legend(i, colour, &curve.name);
        }
        svg(&paper.drawing)
    }
}

/// A value over a plane, as levels, with points and paths above it.
pub(crate) struct Plane<'a> {
    pub(crate) title: String,
    pub(crate) axes: [&'static str; 2],
    pub(crate) range: [[f64; 2]; 2],
    /// Squares along each side.
    pub(crate) fine: usize,
    pub(crate) value: &'a (dyn Fn(f64, f64) -> f64 + Sync),
    pub(crate) curves: Vec<Curve>,
}

impl Plane<'_> {
    /// The picture, and the least and the largest value that was met.
    pub(crate) fn svg(&self) -> (String, [f64; 2]) {
        use rayon::prelude::*;
        let n = self.fine;
        let at = |k: usize, i: usize| {
            let [low, high] = self.range[k];
            low + (high - low) * (i as f64 + 0.5) / n as f64
        };
        let each: Vec<f64> = (0..n * n).into_par_iter().map(|i| (self.value)(at(0, i % n), at(1, i / n))).collect();
        let fold = |f: fn(f64, f64) -> f64, from: f64| each.iter().copied().fold(from, f);
        let ends = [fold(f64::min, f64::INFINITY), fold(f64::max, f64::NEG_INFINITY)];
        let mut paper = Paper::new(&self.title, [400.0, 340.0], self.range, legend_height(self.curves.len()));
        let level = |v: f64| {
            (((v - ends[0]) / (ends[1] - ends[0]).max(f64::MIN_POSITIVE) * LEVELS as f64) as usize).min(LEVELS - 1)
        };
        let half = [0, 1].map(|k| (self.range[k][1] - self.range[k][0]) / n as f64 / 2.0);
        for row in 0..n {
            let mut from = 0;
            for i in 1..=n {
                let own = level(each[row * n + from]);
                if i < n && level(each[row * n + i]) == own {
                    continue;
                }
                let [a, b] =
                    [[at(0, from) - half[0], at(1, row) - half[1]], [at(0, i - 1) + half[0], at(1, row) + half[1]]];
                let ([x0, y0], [x1, y1]) = (paper.place(a), paper.place(b));
                // A hair wider, so that nothing shines through between neighbours.
                paper.drawing.rectangle([x0, y1 - 0.3], [x1 + 0.3, y0], colour(own));
                from = i;
            }
        }
        paper.frame(self.axes, [false; 2]);
        paper.scale(ends);
        for (i, curve) in self.curves.iter().enumerate() {
            let tint = CURVES[(i + 1) % CURVES.len()];
            let places: Vec<[f64; 2]> = curve.points.iter().map(|p| paper.place(*p)).collect();
            if curve.dots {
                let many = places.len() > MANY;
                for [x, y] in places {
                    if many {
                        // A ring has dozens of corners in a file.
                        paper.drawing.rectangle([x - 1.6, y - 1.6], [x + 1.6, y + 1.6], WHITE);
                        paper.drawing.rectangle([x - 1.0, y - 1.0], [x + 1.0, y + 1.0], tint);
                    } else {
                        paper.drawing.circle([x, y], 3.4, 3.4, WHITE);
                        paper.drawing.circle([x, y], 3.4, 1.8, tint);
                    }
                }
            } else {
                paper.drawing.line(places.clone(), 3.0, WHITE);
                paper.drawing.line(places, 1.6, tint);
            }
            paper.legend(i, tint, &curve.name);
        }
        (svg(&paper.drawing), ends)
    }
}

/// Boxes with names, and lines from one to the next.
pub(crate) fn graph(title: &str, nodes: &[(String, [f64; 2])], edges: &[(usize, usize)]) -> String {
    let ends = |k: usize| spread(nodes.iter().map(|node| node.1[k]), true);
    let mut paper = Paper::new(title, [470.0, 330.0], [ends(0), ends(1)], 0.0);
    for (a, b) in edges {
        paper.drawing.line(vec![paper.place(nodes[*a].1), paper.place(nodes[*b].1)], 1.4, CURVES[6]);
    }
    for (name, at) in nodes {
        let [x, y] = paper.place(*at);
        let half = (4.0 * name.chars().count() as f64).max(9.0) + 3.0;
        paper.drawing.rectangle([x - half, y - 11.0], [x + half, y + 11.0], CURVES[0]);
        paper.drawing.rectangle([x - half + 1.4, y - 9.6], [x + half - 1.4, y + 9.6], WHITE);
        paper.drawing.text([x, y + 4.0], 12.0, Anchor::Middle, name.clone());
    }
    svg(&paper.drawing)
}

pub(crate) fn svg(drawing: &Drawing) -> String {
    String::from_utf8_lossy(&drawing.bytes(Format::Svg)).into_owned()
}

fn colour(level: usize) -> Colour {
    let place = level as f64 / (LEVELS - 1) as f64 * (SCALE.len() - 1) as f64;
    let i = (place as usize).min(SCALE.len() - 2);
    [0, 1, 2].map(|k| (SCALE[i][k] + (SCALE[i + 1][k] - SCALE[i][k]) * (place - i as f64)).round() as u8)
}

fn legend_height(entries: usize) -> f64 {
    16.0 * entries.div_ceil(2) as f64
}

/// The least and the largest, and some room beyond them.
fn spread(values: impl Iterator<Item = f64>, room: bool) -> [f64; 2] {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
    let margin = if room { 0.06 * (high - low) } else { 0.0 };
    match high - low {
        wide if wide > 0.0 => [low - margin, high + margin],
        0.0 => [low - 1.0, high + 1.0],
        _ => [0.0, 1.0],
    }
}

/// A frame on paper with a range of values.
struct Paper {
    drawing: Drawing,
    size: [f64; 2],
    range: [[f64; 2]; 2],
}

impl Paper {
    fn new(title: &str, size: [f64; 2], range: [[f64; 2]; 2], below: f64) -> Self {
        let whole = [size[0] + 40.0, size[1] + below];
        let mut drawing = Drawing::new(whole, title);
        drawing.text([EDGE[0], 15.0], 13.0, Anchor::Start, title);
        Self { drawing, size, range }
    }

    fn place(&self, p: [f64; 2]) -> [f64; 2] {
        let share = [0, 1].map(|k| (p[k] - self.range[k][0]) / (self.range[k][1] - self.range[k][0]));
        let [wide, high] = [self.size[0] - EDGE[0] - EDGE[2], self.size[1] - EDGE[1] - EDGE[3]];
        [EDGE[0] + share[0] * wide, EDGE[1] + (1.0 - share[1]) * high]
    }

    /// Lines and figures at round values, and what the axes count.
    fn frame(&mut self, axes: [&str; 2], logarithmic: [bool; 2]) {
        let [[left, bottom], [right, top]] = [0, 1].map(|end| self.place([self.range[0][end], self.range[1][end]]));
        for (k, by_tens) in logarithmic.into_iter().enumerate() {
            for value in ticks(self.range[k], by_tens) {
                let at = self.place(if k == 0 { [value, self.range[1][0]] } else { [self.range[0][0], value] });
                let text = if by_tens { power(value) } else { super::item::figures(value) };
                if k == 0 {
                    self.drawing.line(vec![[at[0], bottom], [at[0], top]], 0.5, PALE);
                    self.drawing.text([at[0], bottom + 15.0], 11.0, Anchor::Middle, text);
                } else {
                    self.drawing.line(vec![[left, at[1]], [right, at[1]]], 0.5, PALE);
                    self.drawing.text([left - 6.0, at[1] + 4.0], 11.0, Anchor::End, text);
                }
            }
        }
        self.drawing.line(vec![[left, top], [left, bottom], [right, bottom], [right, top], [left, top]], 1.0, INK);
        self.drawing.text([0.5 * (left + right), bottom + 32.0], 12.0, Anchor::Middle, axes[0]);
        self.drawing.text([left - 6.0, top - 8.0], 11.0, Anchor::Start, axes[1]);
    }

    fn legend(&mut self, i: usize, colour: Colour, name: &str) {
        let at = [EDGE[0] + 200.0 * (i % 2) as f64, self.size[1] + 2.0 + 16.0 * (i / 2) as f64];
        self.drawing.line(vec![at, [at[0] + 18.0, at[1]]], 2.4, colour);
        self.drawing.text([at[0] + 24.0, at[1] + 4.0], 11.0, Anchor::Start, name);
    }

    /// What the levels' colours are worth, beside the frame.
    fn scale(&mut self, [low, high]: [f64; 2]) {
        let [right, top] = self.place([self.range[0][1], self.range[1][1]]);
        let bottom = self.place([0.0, self.range[1][0]])[1];
        let step = (bottom - top) / LEVELS as f64;
        for i in 0..LEVELS {
            let y = bottom - step * (i + 1) as f64;
            self.drawing.rectangle([right + 6.0, y], [right + 14.0, y + step + 0.3], colour(i));
        }
        for (value, y) in [(low, bottom), (high, top + 8.0)] {
            self.drawing.text([right + 17.0, y], 9.0, Anchor::Start, super::item::figures((value * 1e3).round() / 1e3));
        }
    }
}

/// Round values in a range; whole powers of ten for an axis that counts those.
fn ticks([low, high]: [f64; 2], logarithmic: bool) -> Vec<f64> {
    let raw = (high - low) / 6.0;
    let ten = 10f64.powf(raw.log10().floor());
    let nice = [1.0, 2.0, 5.0, 10.0].into_iter().map(|m| m * ten).find(|step| *step >= raw).unwrap_or(raw);
    let quarter =
        if (high - low - 180.0).abs() < 1.0 || (high - low - 360.0).abs() < 1.0 { (high - low) / 4.0 } else { nice };
    let step = if logarithmic { nice.max(1.0).round() } else { quarter };
    let (from, to) = ((low / step).ceil() as i64, (high / step + 1e-9).floor() as i64);
    (from..=to).map(|i| i as f64 * step).collect()
}

fn power(value: f64) -> String {
    if (0.0..4.0).contains(&value) { super::item::figures(10f64.powf(value).round()) } else { format!("1e{value}") }
}
