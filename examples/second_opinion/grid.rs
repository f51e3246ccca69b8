//! A grid of cells of a millimetre, in as many dimensions as are needed.

use std::array::from_fn;
use std::collections::HashMap;

/// Things by the cell of a millimetre that they are in.
pub struct Grid<T, const N: usize> {
    cells: HashMap<[i64; N], Vec<T>>,
}

impl<T, const N: usize> Grid<T, N> {
    pub fn new() -> Self {
        Self { cells: HashMap::new() }
    }

    /// What is in the cell of a point.
    pub fn cell(&mut self, p: [f64; N]) -> &mut Vec<T> {
        self.cells.entry(p.map(|x| x.floor() as i64)).or_default()
    }

    /// What is in the cells that are within `reach` along each axis.
    pub fn near(&self, p: [f64; N], reach: f64) -> impl Iterator<Item = &T> {
        let low = p.map(|x| (x - reach).floor() as i64);
        let count = p.map(|x| (x + reach).floor() as i64 + 1);
        let count: [i64; N] = from_fn(|i| count[i] - low[i]);
        let cell = move |mut k: i64| {
            from_fn(|i| {
                let along = low[i] + k % count[i];
                k /= count[i];
                along
            })
        };
        (0..count.iter().product()).filter_map(move |k| self.cells.get(&cell(k))).flatten()
    }
}
