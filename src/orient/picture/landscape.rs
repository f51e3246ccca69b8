//! The value of an objective over the two angles, as the seeds draw it.

use rayon::prelude::*;

use super::super::{Facets, Minimum, Objective, from_angles, to_angles};
use super::Picture;

/// Pixels for the whole turn of alpha; beta, from -90 to 90 degrees, has half as many.
const WIDTH: usize = 720;
/// Directions along alpha, for quick objectives and for slow ones.
const STEPS: [usize; 2] = [240, 72];
/// From blue over green to yellow: dark is low.
const COLOURS: [[f64; 3]; 5] =
    [[68.0, 1.0, 84.0], [59.0, 82.0, 139.0], [33.0, 145.0, 140.0], [94.0, 201.0, 98.0], [253.0, 231.0, 37.0]];
const GLOBAL: [u8; 3] = [255, 40, 40];
const LOCAL: [u8; 3] = [255, 255, 255];

/// Value over `(alpha, beta)`: alpha from -180 degrees on the left to 180, beta from 90 at the top to -90; dark is low, the
/// scale runs from the least to the largest value. `minima` are ringed, those within 1e-6 of the first in red.
///
/// Sampled every 1.5 degrees, or every 5 where an evaluation takes long.
pub fn landscape(objective: &dyn Objective, facets: &Facets, minima: &[Minimum]) -> Picture {
    let steps = STEPS[usize::from(objective.proof().budget < 10_000)];
    let (pixel, rows) = (WIDTH / steps, steps / 2);
    let angle = |i: usize| ((i as f64 + 0.5) / steps as f64) * std::f64::consts::TAU - std::f64::consts::PI;
    let beta = |row: usize| std::f64::consts::FRAC_PI_2 - (angle(row) + std::f64::consts::PI);
    let value = |i: usize| objective.value(facets, &from_angles(angle(i % steps), beta(i / steps)));
    let values: Vec<f64> = (0..steps * rows).into_par_iter().map(value).collect();
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let mut picture = Picture::filled(WIDTH, WIDTH / 2, [0; 3]);
    for (i, value) in values.iter().enumerate() {
        let colour = colour((value - low) / (high - low).max(f64::MIN_POSITIVE));
        for (x, y) in (0..pixel * pixel).map(|k| (k % pixel, k / pixel)) {
            picture.set((i % steps * pixel + x) as i64, (i / steps * pixel + y) as i64, colour);
        }
    }
    let best = minima.first().map_or(0.0, |m| m.value);
    for minimum in minima.iter().rev() {
        ring(&mut picture, minimum, if minimum.value <= best + 1e-6 * best.abs() { GLOBAL } else { LOCAL });
    }
    picture
}

/// The colour of a share from 0 to 1.
fn colour(share: f64) -> [u8; 3] {
    let place = share.clamp(0.0, 1.0) * (COLOURS.len() - 1) as f64;
    let i = (place as usize).min(COLOURS.len() - 2);
    [0, 1, 2].map(|k| (COLOURS[i][k] + (COLOURS[i + 1][k] - COLOURS[i][k]) * (place - i as f64)) as u8)
}

fn ring(picture: &mut Picture, minimum: &Minimum, colour: [u8; 3]) {
    let (alpha, beta) = to_angles(&minimum.up);
    let scale = WIDTH as f64 / std::f64::consts::TAU;
    let [x, y] = [(alpha + std::f64::consts::PI) * scale, (std::f64::consts::FRAC_PI_2 - beta) * scale];
    for (dx, dy) in (0..169).map(|k| (k % 13 - 6, k / 13 - 6)) {
        let far = f64::from(dx).hypot(f64::from(dy));
        if (3.6..6.2).contains(&far) {
            picture.set(x as i64 + i64::from(dx), y as i64 + i64::from(dy), if far < 5.0 { colour } else { [0; 3] });
        }
    }
}
