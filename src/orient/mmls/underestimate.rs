//! The quadratic below a cluster of points (appendix A.2): one linear program in its six coefficients.

use nalgebra::{SMatrix, SVector};

type Row = SVector<f64, 6>;

/// Pivots at most; beyond, the quadratic at hand is taken (it lies below all points, or is the plain one).
const PIVOTS: usize = 200;

/// The sum of squares between the values and the quadratic that lies below all of them with the least sum of differences
/// (appendix A.3). 0 for six points or fewer, through which one goes.
pub(super) fn misfit(points: &[([f64; 2], f64)]) -> f64 {
    if points.len() <= 6 {
        return 0.0;
    }
    let rows = scaled(points);
    let quadratic = below(&rows, points);
    rows.iter().zip(points).map(|(row, (_, value))| (value - row.dot(&quadratic)).powi(2)).sum()
}

/// `1, x, y, x^2, x y, y^2` of each point, counted from the middle in units of the spread.
fn scaled(points: &[([f64; 2], f64)]) -> Vec<Row> {
    let count = points.len() as f64;
    let middle = [0, 1].map(|k| points.iter().map(|p| p.0[k]).sum::<f64>() / count);
    let far = |p: &([f64; 2], f64)| (p.0[0] - middle[0]).abs().max((p.0[1] - middle[1]).abs());
    let spread = points.iter().map(far).fold(1e-300, f64::max);
    let row = |p: &([f64; 2], f64)| {
        let [x, y] = [0, 1].map(|k| (p.0[k] - middle[k]) / spread);
        Row::new(1.0, x, y, x * x, x * y, y * y)
    };
    points.iter().map(row).collect()
}

/// The coefficients `q` with `row.q <= value` for all points and the largest sum of `row.q`, by the dual simplex: six points
/// that the quadratic goes through are the basis; the point most above which it lies comes in.
///
/// It begins with artificial points far below, one for each coefficient's sense, that leave first.
fn below(rows: &[Row], points: &[([f64; 2], f64)]) -> Row {
    let goal: Row = rows.iter().sum();
    let far = 1e6 * points.iter().map(|p| p.1.abs()).fold(1.0, f64::max);
    // Artificial: +-e_k . q <= far, each with the sense in which the goal grows.
    let sense = |k: usize| if goal[k] < 0.0 { -1.0 } else { 1.0 };
    let mut basis: Vec<(Row, f64)> = (0..6).map(|k| (Row::ith(k, sense(k)), far)).collect();
    let mut quadratic = Row::zeros();
    for _ in 0..PIVOTS {
        let matrix = SMatrix::<f64, 6, 6>::from_fn(|i, k| basis[i].0[k]);
        let Some(inverse) = matrix.try_inverse() else { break };
        quadratic = inverse * Row::from_fn(|i, _| basis[i].1);
        let above = |i: &usize| rows[*i].dot(&quadratic) - points[*i].1;
        let Some(worst) = (0..rows.len()).max_by(|a, b| above(a).total_cmp(&above(b))) else { break };
        if above(&worst) <= 1e-9 * (1.0 + points[worst].1.abs()) {
            break;
        }
        // goal = sum y_i row_i with y >= 0; the one that reaches 0 first goes.
        let (weights, change) = (inverse.transpose() * goal, inverse.transpose() * rows[worst]);
        let ratio = |i: &usize| weights[*i] / change[*i];
        let leaving = (0..6).filter(|&i| change[i] > 1e-12).min_by(|a, b| ratio(a).total_cmp(&ratio(b)));
        let Some(leaving) = leaving else { break };
        basis[leaving] = (rows[worst], points[worst].1);
    }
    quadratic
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(f: impl Fn(f64, f64) -> f64) -> Vec<([f64; 2], f64)> {
        (0..49)
            .map(|i| [f64::from(i % 7) - 2.0, f64::from(i / 7) * 3.0 + 50.0])
            .map(|[x, y]| ([x, y], f(x, y)))
            .collect()
    }

    #[test]
    fn a_quadratic_is_fitted_without_misfit() {
        assert!(misfit(&grid(|x, y| 3.0 + x - 0.2 * y + 0.5 * x * x - 0.1 * x * y + 0.02 * y * y)) < 1e-9);
        assert_eq!(misfit(&grid(|x, y| x * y)[..6]), 0.0);
    }

    #[test]
    fn the_quadratic_lies_below_and_no_shift_does_better() {
        let points = grid(|x, y| (1.3 * x).sin() * 4.0 + (0.4 * y).cos() * 2.0 + x.abs());
        let rows = scaled(&points);
        let q = below(&rows, &points);
        let gaps: Vec<f64> = rows.iter().zip(&points).map(|(row, p)| p.1 - row.dot(&q)).collect();
        assert!(gaps.iter().all(|g| *g > -1e-7), "{gaps:?}");
        // As many points touched as coefficients, as a vertex of the program has.
        assert!(gaps.iter().filter(|g| **g < 1e-7).count() >= 6);
        // Witness: a thousand random directions from the optimum, as far as they stay below, gain nothing.
        let mut seed = crate::geom::SplitMix64::seeded(3);
        let goal: Row = rows.iter().sum();
        for _ in 0..1000 {
            let toward = Row::from_fn(|_, _| seed.unit() - 0.5);
            let room = rows.iter().zip(&gaps).map(|(row, gap)| (row.dot(&toward), gap));
            let reach = room
                .filter(|(rise, _)| *rise > 0.0)
                .map(|(rise, gap)| gap.max(0.0) / rise)
                .fold(f64::INFINITY, f64::min);
            assert!(goal.dot(&toward) * reach.min(1.0) < 1e-5);
        }
    }
}
