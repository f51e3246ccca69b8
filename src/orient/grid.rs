//! All directions of a grid: what the documents' landscapes show, and the plainest of witnesses.

use std::f64::consts::{FRAC_PI_2, PI};

use super::trial::Trial;
use super::{Facets, Found, Minimum, Objective, Search, Stop, from_angles};

/// The grid of `(alpha, beta)` with equal steps, poles once; its minima are the places lower than all their neighbours.
#[derive(Clone, Copy, Debug)]
pub struct GridSearch {
    /// Evaluations at most: the step, in radians, is about `pi sqrt(2 / budget)`. At least 100 mean something.
    pub budget: usize,
}

impl Default for GridSearch {
    /// 4.1 degrees, about the grid of de Castro (2020).
    fn default() -> Self {
        Self { budget: 4052 }
    }
}

impl Search for GridSearch {
    fn name(&self) -> &'static str {
        "grid"
    }

    fn search(&self, objective: &dyn Objective, facets: &Facets) -> Found {
        let most = (self.budget.saturating_sub(2) as f64 / 2.0).sqrt() as usize;
        // An even number, so that the equator and with it all three axes are on the grid.
        let mut trial = Trial::new(objective, facets, self.budget);
        let minima = Rows::of(&mut trial, (most / 2 * 2).max(2)).lowest();
        trial.found(minima, None, Stop::Converged)
    }
}

/// The values at all places: two poles, and rows of `turns` between them.
struct Rows {
    poles: [Minimum; 2],
    between: Vec<Vec<Minimum>>,
    turns: usize,
}

impl Rows {
    fn of(trial: &mut Trial<'_>, rows: usize) -> Self {
        let mut at = |row: usize, turn: usize| {
            let step = PI / rows as f64;
            trial.at(from_angles(step * turn as f64, step * row as f64 - FRAC_PI_2))
        };
        let turns = 2 * rows;
        let between = (1..rows).map(|row| (0..turns).map(|turn| at(row, turn)).collect()).collect();
        let poles = [at(0, 0), at(rows, 0)];
        Self { poles, between, turns }
    }

    /// The value in a row counted from the first pole, 0.
    fn value(&self, row: usize, turn: usize) -> f64 {
        match row {
            0 => self.poles[0].value,
            r if r > self.between.len() => self.poles[1].value,
            r => self.between[r - 1][turn % self.turns].value,
        }
    }

    /// The places that none of their neighbours is below.
    fn lowest(&self) -> Vec<Minimum> {
        let is_lowest = |row: usize, turn: usize| {
            let beside = [turn + self.turns - 1, turn, turn + 1];
            let mut around = (row - 1..=row + 1).flat_map(|r| beside.map(|t| self.value(r, t)));
            around.all(|value| value >= self.value(row, turn))
        };
        let rows = self.between.iter().enumerate();
        let all = rows.flat_map(|(r, row)| row.iter().enumerate().map(move |(turn, place)| (r + 1, turn, place)));
        let mut minima: Vec<Minimum> = all.filter(|(r, turn, _)| is_lowest(*r, *turn)).map(|(.., m)| *m).collect();
        for (pole, row) in self.poles.iter().zip([1, self.between.len()]) {
            if (0..self.turns).all(|turn| self.value(row, turn) >= pole.value) {
                minima.push(*pole);
            }
        }
        minima
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Vec3;
    use crate::orient::{NormalZ, Staircase};

    #[test]
    fn a_box_has_its_six_faces_and_an_axis_its_two_senses() {
        let normals = [Vec3::x(), Vec3::y(), Vec3::z()].map(|n| [n, -n]).concat();
        let facets = Facets::with(normals, vec![12.0, 12.0, 8.0, 8.0, 6.0, 6.0], vec![]);
        let found = GridSearch { budget: 2 * 36 * 36 + 2 }.search(&Staircase { layer_mm: 0.2 }, &facets);
        assert_eq!(found.minima.len(), 6);
        assert!(found.minima.iter().all(|m| m.value < 1e-15), "{found:?}");
        assert_eq!(found.evaluations, 2 + 35 * 72);
        let bar = Facets::with(vec![Vec3::x(), Vec3::y()], vec![1.0; 2], vec![]);
        let found = GridSearch::default().search(&NormalZ, &bar);
        assert!(found.evaluations <= 4052);
        assert_eq!(found.minima.len(), 2);
        assert!(found.minima.iter().all(|m| m.up.z.abs() > 1.0 - 1e-12));
    }
}
