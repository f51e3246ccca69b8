//! A drawing in dots, two a unit; edges are smoothed by how much of a dot they cover.

use super::{Anchor, Colour, Drawing, DrawnMark, font};

/// Dots a unit.
const DOTS: f64 = 2.0;
/// Rows that are looked at in a dot.
const ROWS: usize = 4;
/// A letter's strokes are so thick, in heights of the type.
const THICK: f64 = 0.085;
const WHITE: Colour = [255; 3];

/// Whether what lies behind a picture is seen through it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::view) enum Alpha {
    /// Nowhere: red, green and blue of each dot.
    Opaque,
    /// As a fourth byte of each dot says: 0 wholly, 255 not at all.
    Told,
}

/// Dots, row by row from the top, as a PNG file of 8 bits a colour.
pub(in crate::view) fn encoded([width, height]: [usize; 2], alpha: Alpha, dots: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width as u32, height as u32);
    encoder.set_color(if alpha == Alpha::Told { png::ColorType::Rgba } else { png::ColorType::Rgb });
    encoder.set_depth(png::BitDepth::Eight);
    // A vector takes whatever is written to it, and the picture has dots.
    if let Ok(mut writer) = encoder.write_header() {
        let _ = writer.write_image_data(dots);
    }
    bytes
}

/// A picture of 8 bits a colour.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Dots from left to right.
    pub width: usize,
    /// Dots from top to bottom.
    pub height: usize,
    /// Red, green, blue of each dot, row by row from the top.
    pub pixels: Vec<Colour>,
}

impl Picture {
    /// A drawing in dots.
    pub fn of(drawing: &Drawing) -> Self {
        let [width, height] = drawing.size.map(|v| (v * DOTS).ceil().max(1.0) as usize);
        let mut picture = Self { width, height, pixels: vec![WHITE; width * height] };
        drawing.marks.iter().for_each(|mark| picture.draw(mark));
        picture
    }

    /// The picture as a PNG file.
    pub(super) fn png(&self) -> Vec<u8> {
        encoded([self.width, self.height], Alpha::Opaque, &self.pixels.concat())
    }

    fn draw(&mut self, mark: &DrawnMark) {
        match mark {
            DrawnMark::Area { rings, fill, opacity } => self.area(rings, *fill, *opacity),
            DrawnMark::Lines { lines, width, colour } => lines.iter().for_each(|line| self.line(line, *width, *colour)),
            DrawnMark::Text { at, size, anchor, colour, text, halo } => {
                let before = match anchor {
                    Anchor::Start => 0.0,
                    Anchor::Middle => 0.5,
                    Anchor::End => 1.0,
                };
                let from = [at[0] - before * font::width_of(text, *size), at[1]];
                let strokes = font::strokes(text, from, *size);
                if *halo {
                    strokes.iter().for_each(|stroke| self.line(stroke, THICK * size + 3.0, WHITE));
                }
                strokes.iter().for_each(|stroke| self.line(stroke, (THICK * size).max(0.9), *colour));
            }
        }
    }

    /// Mixes a colour in; outside the picture nothing happens.
    fn mix(&mut self, x: i64, y: i64, colour: Colour, share: f64) {
        if share > 0.0 && x >= 0 && y >= 0 && x < self.width as i64 && y < self.height as i64 {
            let dot = &mut self.pixels[y as usize * self.width + x as usize];
            for k in 0..3 {
                let (from, to) = (f64::from(dot[k]), f64::from(colour[k]));
                dot[k] = (from + (to - from) * share.min(1.0)).round() as u8;
            }
        }
    }

    /// Where an odd number of edges lie to the left, by rows of a quarter of a dot.
    fn area(&mut self, rings: &[Vec<[f64; 2]>], fill: Colour, opacity: f64) {
        let scale = |p: &[f64; 2]| [p[0] * DOTS, p[1] * DOTS * ROWS as f64];
        let ys = rings.iter().flatten().map(|p| scale(p)[1]);
        let (low, high) = ys.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), y| (l.min(y), h.max(y)));
        let most = (self.height * ROWS) as f64;
        let (first, last) = (low.max(0.0).floor() as usize, high.min(most).ceil().max(0.0) as usize);
        if first >= last {
            return;
        }
        let mut crossings: Vec<Vec<f64>> = vec![Vec::new(); last - first];
        for ring in rings {
            for (i, p) in ring.iter().enumerate() {
                let (a, b) = (scale(p), scale(&ring[(i + 1) % ring.len()]));
                let (top, bottom) = if a[1] < b[1] { (a, b) } else { (b, a) };
                // A row is at its middle.
                let from = (top[1] - 0.5).ceil().max(first as f64) as usize;
                for row in from..last {
                    let y = row as f64 + 0.5;
                    if y >= bottom[1] {
                        break;
                    }
                    let x = top[0] + (bottom[0] - top[0]) * (y - top[1]) / (bottom[1] - top[1]);
                    crossings[row - first].push(x);
                }
            }
        }
        let mut covered = vec![0.0; self.width];
        for y in first / ROWS..last.div_ceil(ROWS) {
            covered.fill(0.0);
            for row in (y * ROWS..(y + 1) * ROWS).filter(|row| (first..last).contains(row)) {
                let xs = &mut crossings[row - first];
                xs.sort_by(f64::total_cmp);
                for pair in xs.chunks_exact(2) {
                    cover(&mut covered, pair[0], pair[1]);
                }
            }
            for (x, share) in covered.iter().enumerate().filter(|(_, share)| **share > 0.0) {
                self.mix(x as i64, y as i64, fill, opacity * share / ROWS as f64);
            }
        }
    }

    /// A line: a dot is covered as far as its middle is within.
    fn line(&mut self, points: &[[f64; 2]], width: f64, colour: Colour) {
        let half = (width * DOTS * 0.5).max(0.5);
        let places: Vec<[f64; 2]> = points.iter().map(|p| [p[0] * DOTS, p[1] * DOTS]).collect();
        // A dot alone is a line from a place to itself.
        let pairs = places.windows(2).map(|w| (w[0], w[1]));
        let alone = (places.len() == 1).then(|| (places[0], places[0]));
        for (a, b) in pairs.chain(alone) {
            let [low, high] = [0, 1].map(|k: usize| {
                let size = if k == 0 { self.width } else { self.height } as f64;
                let inside = |v: f64| v.clamp(-1.0, size + 1.0) as i64;
                (inside((a[k].min(b[k]) - half - 1.0).floor()), inside((a[k].max(b[k]) + half + 1.0).ceil()))
            });
            let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
            let square = dx * dx + dy * dy;
            for (y, x) in (high.0..=high.1).flat_map(|y| (low.0..=low.1).map(move |x| (y, x))) {
                let (px, py) = (x as f64 + 0.5 - a[0], y as f64 + 0.5 - a[1]);
                let along = if square > 0.0 { ((px * dx + py * dy) / square).clamp(0.0, 1.0) } else { 0.0 };
                let off = (px - along * dx).hypot(py - along * dy);
                self.mix(x, y, colour, half + 0.5 - off);
            }
        }
    }
}

/// Adds what lies between two places of a row to the dots' shares.
fn cover(covered: &mut [f64], from: f64, to: f64) {
    let (from, to) = (from.clamp(0.0, covered.len() as f64), to.clamp(0.0, covered.len() as f64));
    let (first, last) = (from as usize, to as usize);
    for (x, share) in covered.iter_mut().enumerate().take(last + 1).skip(first) {
        *share += (to.min(x as f64 + 1.0) - from.max(x as f64)).max(0.0);
    }
}
