//! A picture with depth, seen from afar: parallel projection, the nearest wins.

use super::Picture;
use crate::geom::Vec3;

/// From where the part is seen: turned so far about the vertical, and from so far above the horizon, degrees.
const SEEN_FROM_DEG: [f64; 2] = [-35.0, 22.0];
const MARGIN: f64 = 0.06;

/// A picture into which surfaces and sticks are drawn.
pub(super) struct Canvas {
    pub(super) picture: Picture,
    depth: Vec<f64>,
    /// To the right, up, and towards the eye.
    axes: [Vec3; 3],
    scale: f64,
    middle: [f64; 2],
}

impl Canvas {
    /// A canvas on which all `points` have room.
    pub(super) fn around(points: impl Iterator<Item = Vec3>, [width, height]: [usize; 2], colour: [u8; 3]) -> Self {
        let [turn, rise] = SEEN_FROM_DEG.map(f64::to_radians);
        let eye = Vec3::new(turn.sin() * rise.cos(), -turn.cos() * rise.cos(), rise.sin());
        let right = Vec3::new(turn.cos(), turn.sin(), 0.0);
        let axes = [right, eye.cross(&right), eye];
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for point in points {
            for k in 0..2 {
                let along = point.dot(&axes[k]);
                (low[k], high[k]) = (low[k].min(along), high[k].max(along));
            }
        }
        let room = |k: usize, pixels: usize| (1.0 - 2.0 * MARGIN) * pixels as f64 / (high[k] - low[k]).max(1e-9);
        let scale = room(0, width).min(room(1, height));
        let middle = [0, 1].map(|k| if low[k] <= high[k] { 0.5 * (low[k] + high[k]) } else { 0.0 });
        let picture = Picture::filled(width, height, colour);
        Self { picture, depth: vec![f64::NEG_INFINITY; width * height], axes, scale, middle }
    }

    /// Pixels from the left and the top, and how near.
    fn seen(&self, point: &Vec3) -> [f64; 3] {
        let [x, y] = [0, 1].map(|k| (point.dot(&self.axes[k]) - self.middle[k]) * self.scale);
        [0.5 * self.picture.width as f64 + x, 0.5 * self.picture.height as f64 - y, point.dot(&self.axes[2])]
    }

    fn put(&mut self, x: i64, y: i64, depth: f64, colour: [u8; 3]) {
        if x >= 0 && y >= 0 && (x as usize) < self.picture.width && (y as usize) < self.picture.height {
            let i = y as usize * self.picture.width + x as usize;
            if depth > self.depth[i] {
                self.depth[i] = depth;
                self.picture.pixels[i] = colour;
            }
        }
    }

    /// A facet, darker the more it turns away; nothing where it shows its back.
    pub(super) fn facet(&mut self, corners: [Vec3; 3], colour: [u8; 3]) {
        let [p, q, r] = corners;
        let normal = (q - p).cross(&(r - p));
        let light = normal.dot(&(self.axes[2] + self.axes[1] * 0.4 - self.axes[0] * 0.3).normalize()) / normal.norm();
        // Also a facet without area, which shows nothing.
        if light.is_nan() || normal.dot(&self.axes[2]) <= 0.0 {
            return;
        }
        let shaded = colour.map(|c| (f64::from(c) * (0.45 + 0.55 * light.max(0.0))) as u8);
        let [a, b, c] = corners.map(|p| self.seen(&p));
        let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        let span = |k: usize| {
            let (low, high) = (a[k].min(b[k]).min(c[k]), a[k].max(b[k]).max(c[k]));
            (low.floor().max(0.0) as i64, high.ceil().min(1e5) as i64)
        };
        let (columns, rows) = (span(0), span(1));
        for (y, x) in (rows.0..=rows.1).flat_map(|y| (columns.0..=columns.1).map(move |x| (y, x))) {
            let (px, py) = (x as f64 + 0.5, y as f64 + 0.5);
            let share = |p: [f64; 3], q: [f64; 3]| ((q[0] - p[0]) * (py - p[1]) - (q[1] - p[1]) * (px - p[0])) / area;
            let (wc, wa, wb) = (share(a, b), share(b, c), share(c, a));
            if wa >= -1e-9 && wb >= -1e-9 && wc >= -1e-9 {
                self.put(x, y, wa * a[2] + wb * b[2] + wc * c[2], shaded);
            }
        }
    }

    /// An upright stick from `low` to `high`, so many mm wide.
    pub(super) fn stick(&mut self, low: &Vec3, high: &Vec3, width: f64, colour: [u8; 3]) {
        let (a, b) = (self.seen(low), self.seen(high));
        let half = (0.5 * width * self.scale).max(0.5);
        for x in (a[0] - half).round() as i64..(a[0] + half).round().max((a[0] - half).round() + 1.0) as i64 {
            for y in b[1].round() as i64..=a[1].round() as i64 {
                let share = if a[1] > b[1] { ((a[1] - y as f64) / (a[1] - b[1])).clamp(0.0, 1.0) } else { 0.0 };
                self.put(x, y, a[2] + (b[2] - a[2]) * share, colour);
            }
        }
    }
}
