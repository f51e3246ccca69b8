//! The fit that all touches agree with, and those that had to be left out of it.
//!
//! One by one the touch with the largest deleted residual, in terms of its own error, is left out and all is fitted again, as long as one is
//! too far off to be chance.

use nalgebra::{DMatrix, DVector};

use super::solve::{Measured, Problem, Row, jacobian, solve, units};

/// A touch further off than this many standard deviations was not made like the others: one of 150,000 is, by chance.
const FAR_OFF: f64 = 4.5;

/// Touches by their places, each with how far it is off, mm.
pub(super) type LeftOut = Vec<(usize, f64)>;

/// The state, and the touches that had to be left out of it, each with how far it is off; `None` where it does not come to rest.
pub(super) fn without_outliers(
    problem: &Problem<'_>,
    start: &[f64],
    free: &[usize],
    lever: f64,
) -> Option<(Vec<f64>, LeftOut)> {
    let most = problem.touches.touches.len() / 10;
    let mut left_out = LeftOut::new();
    loop {
        let gone: Vec<usize> = left_out.iter().map(|(index, _)| *index).collect();
        let state = settled(problem, start, free, &gone, lever)?;
        let Some(found) = farthest(problem, &state, free, &gone, lever).filter(|_| left_out.len() < most.max(1)) else {
            return Some((state, left_out));
        };
        left_out.push(found);
    }
}

/// The state at rest, if it comes to rest.
pub(super) fn settled(
    problem: &Problem<'_>,
    start: &[f64],
    free: &[usize],
    left_out: &[usize],
    lever: f64,
) -> Option<Vec<f64>> {
    let solved = solve(problem, start.to_vec(), free, left_out, lever);
    solved.settled.then_some(solved.state)
}

/// Rows, slopes and what the slopes' squares leave of each unknown's error.
pub(super) struct Linear {
    pub(super) rows: Vec<(usize, Row)>,
    pub(super) slopes: DMatrix<f64>,
    pub(super) inverse: DMatrix<f64>,
}

impl Linear {
    pub(super) fn of<M: Measured>(
        problem: &M,
        state: &[f64],
        free: &[usize],
        left_out: &[usize],
        lever: f64,
    ) -> Option<Self> {
        let rows = problem.all_rows(state, left_out);
        let slopes = jacobian(&rows, free, &units(problem.length(), lever));
        let inverse = (slopes.transpose() * &slopes).cholesky()?.inverse();
        Some(Self { rows, slopes, inverse })
    }

    pub(super) fn squares(&self) -> f64 {
        self.rows.iter().map(|(_, row)| row.off * row.off).sum()
    }

    pub(super) fn freedom(&self) -> usize {
        self.rows.len().saturating_sub(self.slopes.ncols())
    }
}

/// The touch that is farthest off from what all others say, if it is too far, and how far.
fn farthest(
    problem: &Problem<'_>,
    state: &[f64],
    free: &[usize],
    left_out: &[usize],
    lever: f64,
) -> Option<(usize, f64)> {
    let linear = Linear::of(problem, state, free, left_out, lever)?;
    let (squares, freedom) = (linear.squares(), linear.freedom());
    let noise = problem.touches.tip.repeats_to_mm;
    let mut worst: Option<(f64, usize, f64)> = None;
    let mut at = 0;
    while at < linear.rows.len() {
        let touch = linear.rows[at].0;
        let count = linear.rows[at..].iter().take_while(|(of, _)| *of == touch).count();
        let own = linear.slopes.rows(at, count);
        let off = DVector::from_iterator(count, linear.rows[at..at + count].iter().map(|(_, row)| row.off));
        let free_part = DMatrix::identity(count, count) - own * &linear.inverse * own.transpose();
        at += count;
        // What hangs on this touch alone says nothing about it.
        let Some(back) = free_part.clone().try_inverse().filter(|_| free_part.determinant() > 1e-6) else { continue };
        let alone = back * &off;
        let square = off.dot(&alone);
        let others = (squares - square) / freedom.saturating_sub(count).max(1) as f64;
        let scatter = if freedom > count { others.max(noise * noise) } else { noise * noise };
        // Three numbers are farther off by chance than one.
        let allowed = FAR_OFF * FAR_OFF + 3.4 * (count - 1) as f64;
        let excess = square / scatter / allowed;
        if excess > 1.0 && worst.is_none_or(|(most, ..)| excess > most) {
            let sign = if count == 1 { alone[0].signum() } else { 1.0 };
            let weights = linear.rows[at - count..at].iter().map(|(_, row)| row.weight);
            let alone = DVector::from_iterator(count, alone.iter().zip(weights).map(|(off, weight)| off / weight));
            worst = Some((excess, touch, alone.norm() * sign));
        }
    }
    worst.map(|(_, touch, off)| (touch, off))
}
