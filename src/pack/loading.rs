//! The most value in one run of many equal boxes: blocks put one after the other into corners of the empty space, by a beam search (Araya and Riff, "A beam search
//! approach to the container loading problem", 2014).
//!
//! The next block always comes into the empty box whose corner is nearest to a corner of the run. Blocks are liked that are large and leave little beside
//! them that the lengths of the boxes left cannot fill, the less so the more boxes they have. Of each packing in the beam the best blocks are tried, and a try is worth what it holds
//! once it is filled up by the best block each time. The beam is widened until the watch ends.

use super::blocks::{Blocks, kinds};
use super::fill::Ready;
use super::instance::{Placed, Triple, gcd, volume};
use super::reach::Sums;
use super::spaces::{Corner, Run};
use super::watch::Watch;

/// Cells into which lengths are rounded where their sums are looked at, at most.
const CELLS: i64 = 1024;
/// How much what is lost beside a block counts.
const LOSS: i32 = 4;
/// How much less a block is liked for its number of boxes.
const MANY: f64 = 0.2;
/// Blocks that a watch counts as a step.
const A_STEP: usize = 50;
/// Steps that making a block counts.
const BLOCK_STEPS: usize = 4;
/// The widest beam.
const WIDEST: f64 = 1e5;

/// The length of a cell: what all lengths are multiples of, or more where that is very little.
fn cell(ready: &Ready) -> i64 {
    let longest = ready.space.into_iter().max().unwrap_or(1);
    let lengths = ready.sizes.iter().flatten().flatten().chain(&ready.space);
    let common = lengths.fold(0, |all, &length| gcd(all, length));
    common.max(longest / CELLS).max(1)
}

/// A search for the fullest run with a beam that is widened again and again.
pub(super) struct Loading<'a> {
    ready: &'a Ready,
    blocks: Blocks,
    cell: i64,
    /// The boxes that may be taken, by kind.
    free: Vec<Vec<usize>>,
    /// The best value with blocks and their corners.
    best: (f64, Vec<Placed>),
    width: f64,
}

/// A run that is being loaded; what is placed in it are blocks.
#[derive(Clone)]
struct State {
    run: Run,
    left: Vec<u32>,
    value: f64,
    /// Blocks that there are boxes enough for.
    alive: Vec<u32>,
}

impl<'a> Loading<'a> {
    /// Of all boxes.
    pub(super) fn of(ready: &'a Ready, watch: &mut Watch<'_>) -> Self {
        let free = kinds(ready);
        let blocks = Blocks::of(ready, &free);
        watch.spend((blocks.all.len() * BLOCK_STEPS) as u64);
        Self { ready, blocks, cell: cell(ready), free, best: (0.0, Vec::new()), width: 1.0 }
    }

    /// Boxes that are in no run yet.
    pub(super) fn left(&self) -> Vec<usize> {
        self.free.iter().flatten().copied().collect()
    }

    /// What the best run is worth.
    pub(super) fn value(&self) -> f64 {
        self.best.0
    }

    /// The best run.
    pub(super) fn placed(&self) -> Vec<Placed> {
        self.unfolded(&mut self.free.clone())
    }

    fn unfolded(&self, free: &mut [Vec<usize>]) -> Vec<Placed> {
        let mut placed = Vec::new();
        for block in &self.best.1 {
            self.blocks.unfolded(block.item, block.at, free, &mut placed);
        }
        placed
    }

    /// Takes the best run's boxes away; the search begins anew with the others.
    pub(super) fn take(&mut self) -> Vec<Placed> {
        let mut free = std::mem::take(&mut self.free);
        let placed = self.unfolded(&mut free);
        (self.free, self.best, self.width) = (free, (0.0, Vec::new()), 1.0);
        placed
    }

    /// Searches with a wider beam than before, until the watch ends or `bound` is met. Whether a still wider one may find more.
    pub(super) fn wider(&mut self, bound: f64, watch: &mut Watch<'_>) -> bool {
        let width = self.width as usize;
        self.width = (self.width * std::f64::consts::SQRT_2).min(WIDEST);
        let mut whole = true;
        let left: Vec<u32> = self.free.iter().map(|items| items.len() as u32).collect();
        let alive = self.blocks.order.iter().copied().filter(|&block| self.blocks.has(block, &left)).collect();
        let mut beam = vec![State { run: Run::empty(self.ready.space), left, value: 0.0, alive }];
        while !beam.is_empty() {
            let mut next: Vec<(f64, State)> = Vec::new();
            for mut state in beam {
                let Some((corner, found)) = self.choices(&mut state, width, watch) else { continue };
                whole &= found.len() < width;
                for &(_, block) in &found {
                    let mut there = state.clone();
                    self.put(&mut there, block, &corner);
                    let filled = self.filled(&there, watch);
                    if self.best.0 >= bound * (1.0 - 1e-8) || watch.ended_early() {
                        return true;
                    }
                    next.push((filled, there));
                }
            }
            // Of those that come to the same one is enough.
            next.sort_by(|a, b| b.0.total_cmp(&a.0).then(b.1.value.total_cmp(&a.1.value)));
            next.dedup_by(|a, b| a.0 == b.0);
            whole &= next.len() <= width;
            next.truncate(width);
            beam = next.into_iter().map(|(_, state)| state).collect();
        }
        !whole && self.width < WIDEST
    }

    /// Filled up by the best block each time: what it is worth then.
    fn filled(&mut self, from: &State, watch: &mut Watch<'_>) -> f64 {
        let mut state = from.clone();
        // Half filled where the watch ends, but a packing.
        while !watch.ended_early()
            && let Some((corner, found)) = self.choices(&mut state, 1, watch)
        {
            self.put(&mut state, found[0].1, &corner);
        }
        if state.value > self.best.0 {
            self.best = (state.value, state.run.placed.clone());
        }
        state.value
    }

    fn put(&self, state: &mut State, index: u32, corner: &Corner) {
        let block = &self.blocks.all[index as usize];
        state.run.put(index as usize, corner.of(&block.size), block.size, &self.ready.least);
        state.value += block.value;
        for &(kind, count) in &block.needs {
            state.left[kind as usize] -= count;
        }
        let State { left, alive, .. } = state;
        alive.retain(|&block| self.blocks.has(block, left));
    }

    /// The next corner and the `most` blocks that are liked best in it; spaces in which nothing fits are dropped. `None` where nothing fits anywhere.
    fn choices(&self, state: &mut State, most: usize, watch: &mut Watch<'_>) -> Option<(Corner, Vec<(f64, u32)>)> {
        let sums = self.sums(&state.left);
        while let Some(corner) = state.run.corner() {
            watch.spend(1 + (state.alive.len() / A_STEP) as u64);
            let room: Triple = std::array::from_fn(|k| corner.high[k] - corner.low[k]);
            let all = volume(&room);
            let mut found: Vec<(f64, u32)> = Vec::new();
            for &index in &state.alive {
                let block = &self.blocks.all[index as usize];
                if (0..3).any(|k| block.size[k] > room[k]) {
                    continue;
                }
                let used: f64 = (0..3)
                    .map(|k| (block.size[k] + self.cell * sums[k].below((room[k] - block.size[k]) / self.cell)) as f64)
                    .product();
                let score = block.value * (used / all).min(1.0).powi(LOSS) * f64::from(block.boxes).powf(-MANY);
                if found.len() < most {
                    found.push((score, index));
                    found.sort_by(|a, b| b.0.total_cmp(&a.0));
                } else if score > found[most - 1].0 {
                    found[most - 1] = (score, index);
                    found.sort_by(|a, b| b.0.total_cmp(&a.0));
                }
            }
            if !found.is_empty() {
                return Some((corner, found));
            }
            state.run.forget(&corner);
        }
        None
    }

    /// By axis: the sums of lengths of boxes that are left.
    fn sums(&self, left: &[u32]) -> [Sums; 3] {
        std::array::from_fn(|k| {
            let mut sums = Sums::none(self.ready.space[k] / self.cell);
            for (kind, &count) in left.iter().enumerate().filter(|(_, count)| **count > 0) {
                let sizes = &self.ready.sizes[self.blocks.first[kind]];
                let cells = |size: &Triple| (size[k] + self.cell - 1) / self.cell;
                for (i, size) in sizes.iter().enumerate() {
                    if sizes[..i].iter().all(|other| cells(other) != cells(size)) {
                        sums.with(cells(size), count);
                    }
                }
            }
            sums
        })
    }
}
