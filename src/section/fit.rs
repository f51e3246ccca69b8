//! How a print lies beside its part: the shift, turn, scale and offset that explain the distances of its outer walls.
//!
//! At a point `p` of a wall (relative to the part's middle) with the outline's outward normal `n`, a rigid error of the print
//! moves the wall outward by
//!
//! ```text
//! r = tx nx + ty ny + turn (px ny - py nx) + scale (px nx + py ny) + offset
//! ```
//!
//! to first order; least squares over all samples gives the five, twice, the second time without what the first fit does not
//! explain. What the outline cannot tell (the turn of a round part) comes back as 0.

use nalgebra::{SMatrix, SVector};

/// One point of an outer wall.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// In the plane, relative to the part's middle, mm.
    pub at: [f64; 2],
    /// The outline's outward normal there.
    pub normal: [f64; 2],
    /// How far the wall lies farther out than half its width inside the outline, mm.
    pub out: f64,
}

/// What explains the samples.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Fit {
    /// mm.
    pub shift: [f64; 2],
    /// Radians, counter-clockwise.
    pub turn: f64,
    /// What is added to 1.
    pub scale: f64,
    /// Outward, mm: a slicer's XY compensation, or walls of another width.
    pub offset: f64,
    /// The farthest sample from the middle, mm.
    pub reach: f64,
}

/// Samples farther off than this after the first fit are something else than the outer wall, mm.
const STRAY_MM: f64 = 0.15;
/// Samples that a fit wants.
const FEWEST: usize = 12;

/// The fit of `samples`; `None` where there are too few. What they tell `weakest` times as well as what they tell best, or less, comes
/// back as 0: along a thin crescent a shift and a scale are nearly one, and the last hundredth of a millimetre would decide on both.
pub fn fit(samples: &[Sample], weakest: f64) -> Option<Fit> {
    let first = solve(samples.iter(), weakest)?;
    let near = |s: &&Sample| (s.out - first.explains(s)).abs() <= STRAY_MM;
    solve(samples.iter().filter(near), weakest).or(Some(first))
}

fn solve<'a>(samples: impl Iterator<Item = &'a Sample>, weakest: f64) -> Option<Fit> {
    let mut normal = SMatrix::<f64, 5, 5>::zeros();
    let mut right = SVector::<f64, 5>::zeros();
    let (mut count, mut reach) = (0, 0.0f64);
    let samples: Vec<&Sample> = samples.collect();
    samples.iter().for_each(|s| reach = reach.max(s.at[0].hypot(s.at[1])));
    for sample in &samples {
        let row = row(sample, reach.max(1e-9));
        normal += row * row.transpose();
        right += row * sample.out;
        count += 1;
    }
    if count < FEWEST {
        return None;
    }
    let eigen = normal.symmetric_eigen();
    let best = eigen.eigenvalues.max();
    let mut solution = SVector::<f64, 5>::zeros();
    for i in 0..5 {
        if eigen.eigenvalues[i] > best * weakest {
            let axis = eigen.eigenvectors.column(i);
            solution += axis * (axis.dot(&right) / eigen.eigenvalues[i]);
        }
    }
    let [tx, ty, turn, scale, offset] = solution.into();
    Some(Fit { shift: [tx, ty], turn: turn / reach, scale: scale / reach, offset, reach })
}

/// The five's shares in one sample; turn and scale as mm at the farthest sample, so that all are alike.
fn row(s: &Sample, reach: f64) -> SVector<f64, 5> {
    let ([x, y], [nx, ny]) = (s.at, s.normal);
    SVector::from([nx, ny, (x * ny - y * nx) / reach, (x * nx + y * ny) / reach, 1.0])
}

impl Fit {
    /// What it says of a sample's distance.
    pub fn explains(&self, s: &Sample) -> f64 {
        let ([x, y], [nx, ny]) = (s.at, s.normal);
        self.shift[0] * nx
            + self.shift[1] * ny
            + self.turn * (x * ny - y * nx)
            + self.scale * (x * nx + y * ny)
            + self.offset
    }

    /// Length of the shift, mm.
    pub fn shift_mm(&self) -> f64 {
        self.shift[0].hypot(self.shift[1])
    }

    /// What the turn moves at the farthest sample, mm.
    pub fn turn_mm(&self) -> f64 {
        self.turn.abs() * self.reach
    }

    /// What the scale moves there, mm.
    pub fn scale_mm(&self) -> f64 {
        self.scale.abs() * self.reach
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The outline of a box 40 x 20 about the middle, walked in steps of 1 mm, moved as told.
    fn walls(shift: [f64; 2], turn: f64, scale: f64, offset: f64) -> Vec<Sample> {
        let mut samples = Vec::new();
        let moved = Fit { shift, turn, scale, offset, reach: 0.0 };
        for (half, along, normal) in
            [(10.0, 20, [0.0, 1.0]), (10.0, 20, [0.0, -1.0]), (20.0, 10, [1.0, 0.0]), (20.0, 10, [-1.0, 0.0])]
        {
            for k in -along..along {
                let t = f64::from(k) + 0.5;
                let at = [normal[0] * half + normal[1] * t, normal[1] * half + normal[0] * t];
                let mut sample = Sample { at, normal, out: 0.0 };
                sample.out = moved.explains(&sample);
                samples.push(sample);
            }
        }
        samples
    }

    #[test]
    fn each_of_the_five_is_found() {
        let got = fit(&walls([0.12, -0.07], 0.004, -0.003, 0.05), 1e-3).unwrap();
        assert!((got.shift[0] - 0.12).abs() < 1e-9 && (got.shift[1] + 0.07).abs() < 1e-9, "{got:?}");
        assert!((got.turn - 0.004).abs() < 1e-9 && (got.scale + 0.003).abs() < 1e-9, "{got:?}");
        assert!((got.offset - 0.05).abs() < 1e-9 && (got.reach - 22.0).abs() < 0.5, "{got:?}");
    }

    #[test]
    fn strays_do_not_move_it_and_a_few_points_say_nothing() {
        let mut samples = walls([0.1, 0.0], 0.0, 0.0, 0.0);
        samples.iter_mut().step_by(10).for_each(|s| s.out += 0.8);
        let got = fit(&samples, 1e-3).unwrap();
        assert!((got.shift[0] - 0.1).abs() < 0.02, "{got:?}");
        assert_eq!(fit(&samples[..8], 1e-3), None);
    }

    #[test]
    fn a_round_part_has_no_turn() {
        let samples: Vec<Sample> = (0..100)
            .map(|i| {
                let (s, c) = (f64::from(i) * 0.0628).sin_cos();
                Sample { at: [c * 15.0, s * 15.0], normal: [c, s], out: 0.05 * c }
            })
            .collect();
        let got = fit(&samples, 1e-3).unwrap();
        assert!(got.turn == 0.0 || got.turn.abs() < 1e-9);
        assert!((got.shift[0] - 0.05).abs() < 1e-3, "{got:?}");
    }
}
