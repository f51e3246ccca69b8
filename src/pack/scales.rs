//! Scales that no function gives: for each box its own share along an axis, so that boxes that fit beside each other still do (conservative scales of Fekete and
//! Schepers 2004; found axis by axis as by Belov, Kartak, Rohling and Scheithauer, "Conservative scales in packing problems", 2013).
//!
//! With the shares along two axes held, those along the third with the greatest sum of volumes are a linear program: the dual of cutting the length into patterns
//! (Gilmore and Gomory 1961), solved by making patterns where a knapsack finds one. Numbers of the solver are not believed: shares become whole, and an exact
//! knapsack says what they are shares of.

use super::instance::gcd;

/// Whole shares of an axis.
const WHOLE: f64 = 1_048_576.0;
/// Patterns that are made for an axis, at most, for each box.
const PATTERNS: usize = 12;
/// What a number must be off by to count.
const OFF: f64 = 1e-7;

/// Lengths along an axis and what they must fit in, in cells.
pub(super) struct Axis {
    lengths: Vec<usize>,
    room: usize,
}

/// Shares along an axis, by box: whole, of `den`.
#[derive(Clone)]
pub(super) struct Scale {
    pub(super) den: i128,
    pub(super) of: Vec<i128>,
}

impl Axis {
    /// Lengths rounded down to cells of which there are `cells` in the room at most: what fits still does.
    pub(super) fn of(lengths: &[i64], room: i64, cells: i64) -> Self {
        let common = lengths.iter().fold(room, |all, &length| gcd(all, length));
        let cell = common.max((room + cells - 1) / cells.max(1)).max(1);
        Self { lengths: lengths.iter().map(|length| (length / cell) as usize).collect(), room: (room / cell) as usize }
    }

    /// The greatest sum of `shares` that fits, and whose they are.
    fn knapsack<T>(&self, shares: &[T], none: T) -> (T, Vec<usize>)
    where
        T: Copy + PartialOrd + std::ops::Add<Output = T>,
    {
        let wide = self.room + 1;
        let mut best = vec![none; wide];
        let mut taken = vec![false; wide * shares.len()];
        for (item, &share) in shares.iter().enumerate().filter(|(_, share)| **share > none) {
            let length = self.lengths[item];
            for at in (length..wide).rev() {
                let with = best[at - length] + share;
                if with > best[at] {
                    best[at] = with;
                    taken[item * wide + at] = true;
                }
            }
        }
        let (mut at, mut chosen) = (self.room, Vec::new());
        for item in (0..shares.len()).rev() {
            if taken[item * wide + at] {
                chosen.push(item);
                at -= self.lengths[item];
            }
        }
        (best[self.room], chosen)
    }

    /// The shares for which the sum of `worth` times them is greatest, or nearly.
    pub(super) fn best(&self, worth: &[f64], work: &mut u64) -> Scale {
        let rows: Vec<usize> = (0..worth.len()).filter(|&i| worth[i] > OFF).collect();
        let mut basis = Basis::singles(rows.iter().map(|&i| worth[i]).collect());
        let mut shares = vec![0.0; worth.len()];
        for _ in 0..PATTERNS * rows.len() {
            let step = rows.len() * (self.room + 3 * rows.len());
            *work = work.saturating_sub(step as u64);
            if *work == 0 {
                break;
            }
            let prices = basis.prices();
            shares.fill(0.0);
            rows.iter().zip(&prices).for_each(|(&i, &price)| shares[i] = price);
            let column = if let Some(least) = (0..rows.len()).find(|&row| prices[row] < -OFF) {
                // More of a box than there is takes nothing.
                Column { cost: 0.0, of: vec![(least, -1.0)] }
            } else {
                let (value, pattern) = self.knapsack(&shares, 0.0);
                if value <= 1.0 + OFF {
                    break;
                }
                let row_of = |item| rows.partition_point(|&row| row < item);
                Column { cost: 1.0, of: pattern.into_iter().map(|item| (row_of(item), 1.0)).collect() }
            };
            if !basis.enters(&column) {
                break;
            }
        }
        self.whole(&shares)
    }

    /// Whole shares in proportion, with what they are shares of.
    pub(super) fn whole(&self, shares: &[f64]) -> Scale {
        let of: Vec<i128> = shares.iter().map(|&share| (share.clamp(0.0, 1.0) * WHOLE) as i128).collect();
        let den = self.knapsack(&of, 0).0.max(1);
        Scale { den, of }
    }
}

impl Scale {
    pub(super) fn share(&self, item: usize) -> f64 {
        self.of[item] as f64 / self.den as f64
    }
}

/// A column of the program: a pattern, or what is left over of a box.
struct Column {
    cost: f64,
    of: Vec<(usize, f64)>,
}

/// A basis of the program of patterns, with its inverse.
struct Basis {
    inverse: Vec<f64>,
    values: Vec<f64>,
    costs: Vec<f64>,
}

impl Basis {
    /// Each box a pattern by itself.
    fn singles(values: Vec<f64>) -> Self {
        let count = values.len();
        let mut inverse = vec![0.0; count * count];
        (0..count).for_each(|i| inverse[i * count + i] = 1.0);
        Self { inverse, costs: vec![1.0; count], values }
    }

    /// What a unit of each box costs.
    fn prices(&self) -> Vec<f64> {
        let count = self.values.len();
        let mut prices = vec![0.0; count];
        for (row, &cost) in self.costs.iter().enumerate().filter(|(_, cost)| **cost != 0.0) {
            let line = &self.inverse[row * count..(row + 1) * count];
            prices.iter_mut().zip(line).for_each(|(price, of)| *price += cost * of);
        }
        prices
    }

    /// Takes a column into the basis for the one that is used up first; whether there is one.
    fn enters(&mut self, column: &Column) -> bool {
        let count = self.values.len();
        let along: Vec<f64> =
            (0..count).map(|row| column.of.iter().map(|&(at, of)| self.inverse[row * count + at] * of).sum()).collect();
        let ratio = |row: usize| self.values[row] / along[row];
        let leaves = (0..count)
            .filter(|&row| along[row] > OFF)
            .min_by(|&a, &b| ratio(a).total_cmp(&ratio(b)).then(along[b].total_cmp(&along[a])));
        let Some(leaves) = leaves else { return false };
        let (step, by) = (ratio(leaves), along[leaves]);
        let line: Vec<f64> = self.inverse[leaves * count..(leaves + 1) * count].iter().map(|v| v / by).collect();
        for row in (0..count).filter(|&row| row != leaves && along[row] != 0.0) {
            let own = &mut self.inverse[row * count..(row + 1) * count];
            own.iter_mut().zip(&line).for_each(|(v, pivot)| *v -= along[row] * pivot);
            self.values[row] = (self.values[row] - step * along[row]).max(0.0);
        }
        self.inverse[leaves * count..(leaves + 1) * count].copy_from_slice(&line);
        (self.values[leaves], self.costs[leaves]) = (step, column.cost);
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::SplitMix64;

    /// By all subsets: none that fits has more shares than there are, and the sum is that of the best fractional cutting where patterns are few.
    #[test]
    fn shares_of_what_fits_are_no_more_than_all() {
        let mut numbers = SplitMix64::seeded(5);
        for round in 0..300 {
            let room = 5 + numbers.below(40) as i64;
            let lengths: Vec<i64> = (0..9).map(|_| 1 + numbers.below(room as usize) as i64).collect();
            let worth: Vec<f64> = lengths.iter().map(|_| numbers.unit()).collect();
            let cells = if round % 3 == 0 { 7 } else { 1000 };
            let scale = Axis::of(&lengths, room, cells).best(&worth, &mut u64::MAX.clone());
            for set in 0_usize..1 << lengths.len() {
                let own = || (0..lengths.len()).filter(move |i| set >> i & 1 == 1);
                let long: i64 = own().map(|i| lengths[i]).sum();
                assert!(long > room || own().map(|i| scale.of[i]).sum::<i128>() <= scale.den, "{lengths:?} in {room}");
            }
            // No worse than the lengths themselves are as shares.
            let sum: f64 = (0..9).map(|i| worth[i] * scale.share(i)).sum();
            let plain: f64 = (0..9).map(|i| worth[i] * lengths[i] as f64 / room as f64).sum();
            assert!(cells < 1000 || sum >= plain * (1.0 - 1e-5), "{sum} {plain}");
        }
    }
}
