//! The cells of a run that are taken, as bits along x, and the first free place for a solid in it.
//!
//! For one y and z all places along x are tried at once: each of the solid's rows smears the taken cells over as many as it is long, and what no
//! row covers is free. Since cells are only ever taken, the first free place of a shape never comes before where it was last found.

use super::instance::gcd;
use super::voxels::{Span, Voxels};

/// Words of a row, at most: 512 cells.
const WORDS: usize = 8;
/// Cells along x, at most.
pub(super) const MOST_X: usize = 64 * WORDS;

type Row = [u64; WORDS];

/// The cells of a run.
#[derive(Clone)]
pub(super) struct Grid {
    pub(super) size: [i32; 3],
    words: usize,
    /// By z, y and word.
    taken: Vec<u64>,
}

/// A shape to be put in, its rows in an order in which taken cells are soon met.
pub(super) struct Rows {
    size: [i32; 3],
    rows: Vec<Span>,
}

impl Rows {
    pub(super) fn of(voxels: &Voxels) -> Self {
        let count = voxels.spans.len();
        // Far from each other one after the other: a step near the golden section of the whole.
        let stride =
            (0..).map(|i| (count as f64 * 0.618) as usize + i).find(|&s| gcd(s as i64, count as i64) == 1).unwrap_or(1);
        let rows = (0..count).map(|i| voxels.spans[i * stride.max(1) % count.max(1)]).collect();
        Self { size: voxels.size, rows }
    }

    pub(super) fn size(&self) -> [i32; 3] {
        self.size
    }
}

impl Grid {
    /// All free; at most [`MOST_X`] cells along x.
    pub(super) fn free(size: [i32; 3]) -> Self {
        let words = (size[0] as usize).div_ceil(64);
        Self { size, words, taken: vec![0; words * size[1] as usize * size[2] as usize] }
    }

    /// Takes the cells of `spans` moved by `at`; with `below` also all cells below them. What lies outside is left out.
    pub(super) fn take(&mut self, spans: &[Span], at: [i32; 3], below: bool) {
        for span in spans {
            let (y, z) = (span.y + at[1], (span.z + at[2]).min(self.size[2] - 1));
            let (from, to) = ((span.from + at[0]).max(0), (span.to + at[0]).min(self.size[0]));
            if y < 0 || y >= self.size[1] || z < 0 || from >= to || (!below && span.z + at[2] >= self.size[2]) {
                continue;
            }
            for z in if below { 0 } else { z }..=z {
                let row = (z * self.size[1] + y) as usize * self.words;
                for (index, word) in self.taken[row..row + self.words].iter_mut().enumerate() {
                    *word |= bits(from - 64 * index as i32, to - 64 * index as i32);
                }
            }
        }
    }

    /// The first free place for `shape` from `after` on (by z, then y, then x), and how many rows of places were tried. Places have
    /// their low corner `(x, y, z)`; `after` holds z and y.
    pub(super) fn first(&self, shape: &Rows, after: &mut [i32; 2], tried: &mut u64) -> Option<[i32; 3]> {
        let last = [0, 1, 2].map(|k| self.size[k] - shape.size[k]);
        if last.iter().any(|&l| l < 0) {
            return None;
        }
        while after[0] <= last[2] {
            while after[1] <= last[1] {
                *tried += 1;
                if let Some(x) = self.along(shape, after[1], after[0], last[0]) {
                    return Some([x, after[1], after[0]]);
                }
                after[1] += 1;
            }
            *after = [after[0] + 1, 0];
        }
        None
    }

    /// The first free place along x from 0 to `last`.
    fn along(&self, shape: &Rows, y: i32, z: i32, last: i32) -> Option<i32> {
        let mut free: Row = std::array::from_fn(|index| bits(-64 * index as i32, last + 1 - 64 * index as i32));
        let words = self.words;
        for span in &shape.rows {
            let row = ((z + span.z) * self.size[1] + y + span.y) as usize * words;
            let taken = &self.taken[row..row + words];
            if taken.iter().all(|&word| word == 0) {
                continue;
            }
            let mut smeared = shifted(taken, span.from as usize, words);
            let (mut done, wanted) = (1, (span.to - span.from) as usize);
            while done < wanted {
                let by = done.min(wanted - done);
                let more = shifted(&smeared[..words], by, words);
                (0..words).for_each(|i| smeared[i] |= more[i]);
                done += by;
            }
            let mut any = 0;
            for i in 0..words {
                free[i] &= !smeared[i];
                any |= free[i];
            }
            if any == 0 {
                return None;
            }
        }
        let word = free[..words].iter().position(|&word| word != 0)?;
        Some(64 * word as i32 + free[word].trailing_zeros() as i32)
    }
}

/// Bits `from` to below `to` of a word; parts outside are left out.
fn bits(from: i32, to: i32) -> u64 {
    let (from, to) = (from.clamp(0, 64), to.clamp(0, 64));
    let below = |n: i32| if n == 64 { u64::MAX } else { (1 << n) - 1 };
    below(to) & !below(from)
}

/// `row` towards lower places by `by`.
fn shifted(row: &[u64], by: usize, words: usize) -> Row {
    let (whole, part) = (by / 64, by % 64);
    let mut out = [0; WORDS];
    for i in 0..words.saturating_sub(whole) {
        let low = row[i + whole] >> part;
        let high = if part > 0 && i + whole + 1 < words { row[i + whole + 1] << (64 - part) } else { 0 };
        out[i] = low | high;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::SplitMix64;

    /// Against every place tried cell by cell.
    #[test]
    fn the_first_free_place_is_the_first() {
        let mut numbers = SplitMix64::seeded(9);
        for _ in 0..60 {
            let size = [100 + numbers.below(60) as i32, 4 + numbers.below(4) as i32, 3 + numbers.below(4) as i32];
            let mut grid = Grid::free(size);
            let mut taken = vec![false; (size[0] * size[1] * size[2]) as usize];
            let cell = |x: i32, y: i32, z: i32| ((z * size[1] + y) * size[0] + x) as usize;
            for _ in 0..12 {
                let [x, y, z] = size.map(|s| numbers.below(s as usize) as i32);
                let to = (x + 1 + numbers.below(40) as i32).min(size[0]);
                grid.take(&[Span { z: 0, y: 0, from: x, to }], [0, y, z], false);
                (x..to).for_each(|x| taken[cell(x, y, z)] = true);
            }
            let spans: Vec<Span> = (0..2)
                .flat_map(|z| (0..2).map(move |y| (z, y)))
                .map(|(z, y)| {
                    let from = numbers.below(5) as i32;
                    Span { z, y, from, to: from + 1 + numbers.below(90) as i32 }
                })
                .collect();
            let wide = spans.iter().map(|s| s.to).max().unwrap();
            let shape = Voxels { size: [wide, 2, 2], spans };
            let fits = |at: [i32; 3]| {
                shape.spans.iter().all(|s| (s.from..s.to).all(|x| !taken[cell(at[0] + x, at[1] + s.y, at[2] + s.z)]))
            };
            let mut all = (0..=size[2] - 2)
                .flat_map(|z| (0..=size[1] - 2).flat_map(move |y| (0..=size[0] - wide).map(move |x| [x, y, z])));
            assert_eq!(grid.first(&Rows::of(&shape), &mut [0, 0], &mut 0), all.find(|&at| fits(at)));
        }
    }
}
