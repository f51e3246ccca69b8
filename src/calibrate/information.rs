//! How well touches tell each unknown, before anything is measured: the covariance of a linear model, grown touch by touch.
//!
//! It begins with what is known of any machine (a wide prior), so that what no touch tells keeps that error and no rank is ever lost.
//! Rank-one updates: J. Sherman and W. J. Morrison, Annals of Mathematical Statistics 21 (1950), 124-127.

use nalgebra::{DMatrix, DVector};

use super::chain::{UNKNOWNS, Unknown};
use super::solve::Row;

/// Nobody's profile is further from his machine, mm.
const LENGTH_PRIOR_MM: f64 = 20.0;
/// The same of angles, degrees.
const ANGLE_PRIOR_DEG: f64 = 10.0;
/// No table sags by more, mm.
const SAG_PRIOR_MM: f64 = 2.0;
/// Where a mark lies on the table, mm.
const PLACE_PRIOR_MM: f64 = 200.0;

/// A length is told where its standard error is no larger, mm.
pub(super) const WORST_MM: f64 = 0.05;
/// The same of an angle, degrees.
pub(super) const WORST_DEG: f64 = 0.04;

/// Errors of all unknowns and how they hang together, each in its unit (mm; angles as mm at the lever).
#[derive(Clone)]
pub(super) struct Information {
    covariance: DMatrix<f64>,
    unit: Vec<f64>,
    noise: f64,
}

impl Information {
    /// Before any touch, `free` unknowns being looked for, one touch repeating to `noise` mm.
    pub(super) fn before(unit: Vec<f64>, free: &[usize], noise: f64) -> Self {
        let mut covariance = DMatrix::zeros(unit.len(), unit.len());
        for &i in free {
            let prior = match i {
                _ if i >= UNKNOWNS => PLACE_PRIOR_MM,
                _ if Unknown::ALL[i] == Unknown::Sag => SAG_PRIOR_MM,
                _ if Unknown::ALL[i].is_angle() => ANGLE_PRIOR_DEG.to_radians() * unit[i],
                _ => LENGTH_PRIOR_MM,
            };
            covariance[(i, i)] = prior * prior;
        }
        Self { covariance, unit, noise }
    }

    fn scaled(&self, row: &Row) -> DVector<f64> {
        DVector::from_iterator(self.unit.len(), row.slopes.iter().zip(&self.unit).map(|(s, u)| s / u))
    }

    /// One more touch.
    pub(super) fn add(&mut self, rows: &[Row]) {
        for row in rows {
            let r = self.scaled(row);
            let moved = &self.covariance * &r;
            let all = self.noise * self.noise + r.dot(&moved);
            self.covariance.ger(-1.0 / all, &moved, &moved, 1.0);
        }
    }

    /// By how much the sum of the squared errors, each times its `weight`, shrinks with one more touch.
    pub(super) fn gain(&self, rows: &[Row], weight: &[f64]) -> f64 {
        match rows {
            [row] => {
                let r = self.scaled(row);
                let moved = &self.covariance * &r;
                let all = self.noise * self.noise + r.dot(&moved);
                weight.iter().zip(moved.iter()).map(|(w, m)| w * m * m).sum::<f64>() / all
            }
            _ => {
                let mut with = self.clone();
                with.add(rows);
                self.weighed(weight) - with.weighed(weight)
            }
        }
    }

    pub(super) fn weighed(&self, weight: &[f64]) -> f64 {
        weight.iter().enumerate().map(|(i, w)| w * self.covariance[(i, i)]).sum()
    }

    /// The standard error of unknown `i`, mm or radians.
    pub(super) fn error(&self, i: usize) -> f64 {
        self.covariance[(i, i)].max(0.0).sqrt() / self.unit[i]
    }
}
