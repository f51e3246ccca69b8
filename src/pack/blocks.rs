//! Blocks: boxes put together face to face, so that many are placed at once (Bortfeldt and Gehring 2001; general blocks of Fanslau and Bortfeldt, "A tree search
//! algorithm for solving the container loading problem", 2010).
//!
//! First rows, layers and stacks of equal boxes, then two blocks beside each other along an axis wherever the box around both is nearly full.

use std::collections::{HashMap, HashSet};

use super::fill::Ready;
use super::instance::{Placed, Triple, volume};

/// Blocks, at most.
const MOST: usize = 10_000;
/// Blocks of equal boxes, at most.
const MOST_EQUAL: usize = 6_000;
/// Pairs that are looked at, at most.
const MOST_PAIRS: usize = 3_000_000;
/// Blocks whose lengths across differ by more do not come together.
const NEAR: f64 = 0.9;
/// What of the box around two blocks must be filled.
const FULL: f64 = 0.98;

/// Boxes of which kinds, how many of each.
type Needs = Vec<(u32, u32)>;
/// Blocks that there are, by size and boxes.
type Known = HashSet<(Triple, Needs)>;

/// Boxes face to face.
pub(super) struct Block {
    pub(super) size: Triple,
    pub(super) value: f64,
    /// The volume of its boxes.
    pub(super) volume: f64,
    /// How many boxes of which kinds, by kind.
    pub(super) needs: Needs,
    pub(super) boxes: u32,
    made: Made,
}

/// What a block is made of.
enum Made {
    /// Equal boxes of a kind and size, so many along each axis.
    Equal(usize, Triple, [i64; 3]),
    /// Two blocks, the second behind the first along an axis.
    Pair(usize, usize, usize),
}

/// Boxes that are alike in sizes and value, by kind.
pub(super) fn kinds(ready: &Ready) -> Vec<Vec<usize>> {
    let mut known: HashMap<(&[Triple], u64), usize> = HashMap::new();
    let mut kinds: Vec<Vec<usize>> = Vec::new();
    for item in 0..ready.sizes.len() {
        let next = kinds.len();
        let kind = *known.entry((&ready.sizes[item], ready.values[item].to_bits())).or_insert(next);
        if kind == next {
            kinds.push(Vec::new());
        }
        kinds[kind].push(item);
    }
    kinds
}

/// The blocks that fit in the space, the larger first.
pub(super) struct Blocks {
    pub(super) all: Vec<Block>,
    /// By falling volume.
    pub(super) order: Vec<u32>,
    /// A box of each kind.
    pub(super) first: Vec<usize>,
}

impl Blocks {
    pub(super) fn of(ready: &Ready, kinds: &[Vec<usize>]) -> Self {
        let first = kinds.iter().map(|items| items[0]).collect();
        let mut made = Self { all: Vec::new(), order: Vec::new(), first };
        let mut known: Known = HashSet::new();
        made.equal(ready, kinds, &mut known);
        made.pairs(ready, kinds, &mut known);
        made.order = (0..made.all.len() as u32).collect();
        made.order
            .sort_by(|&a, &b| made.all[b as usize].volume.total_cmp(&made.all[a as usize].volume).then(a.cmp(&b)));
        made
    }

    /// Whether there are boxes enough for a block.
    pub(super) fn has(&self, block: u32, left: &[u32]) -> bool {
        self.all[block as usize].needs.iter().all(|&(kind, count)| count <= left[kind as usize])
    }

    fn add(&mut self, block: Block, known: &mut Known) {
        if known.insert((block.size, block.needs.clone())) {
            self.all.push(block);
        }
    }

    /// Single boxes, then all arrays of equal ones that fit, fewer boxes first.
    fn equal(&mut self, ready: &Ready, kinds: &[Vec<usize>], known: &mut Known) {
        let mut arrays: Vec<(i64, usize, Triple, [i64; 3])> = Vec::new();
        for (kind, items) in kinds.iter().enumerate() {
            let count = items.len() as i64;
            for &size in &ready.sizes[items[0]] {
                let most = [0, 1, 2].map(|k| (ready.space[k] / size[k]).min(count));
                for x in 1..=most[0] {
                    for y in 1..=most[1].min(count / x) {
                        for z in 1..=most[2].min(count / (x * y)) {
                            arrays.push((x * y * z, kind, size, [x, y, z]));
                        }
                    }
                }
            }
        }
        arrays.sort_unstable();
        let singles = arrays.iter().take_while(|array| array.0 == 1).count();
        let chosen = spread(singles, arrays.len(), MOST_EQUAL.max(singles));
        for (boxes, kind, size, many) in chosen.map(|i| arrays[i]) {
            let item = kinds[kind][0];
            let block = Block {
                size: [0, 1, 2].map(|k| size[k] * many[k]),
                value: ready.values[item] * boxes as f64,
                volume: volume(&size) * boxes as f64,
                needs: vec![(kind as u32, boxes as u32)],
                boxes: boxes as u32,
                made: Made::Equal(kind, size, many),
            };
            self.add(block, known);
        }
    }

    /// Two blocks together, round after round with what the round before has made.
    fn pairs(&mut self, ready: &Ready, kinds: &[Vec<usize>], known: &mut Known) {
        let (mut from, mut left) = (0, MOST_PAIRS);
        while from < self.all.len() && self.all.len() < MOST {
            let to = self.all.len();
            let mut found: Vec<(u64, usize, usize, usize)> = Vec::new();
            let mut seen: Known = HashSet::new();
            for axis in 0..3 {
                let across = (axis + 1) % 3;
                let mut sorted: Vec<usize> = (0..to).collect();
                sorted.sort_by_key(|&i| (self.all[i].size[across], i));
                for i in from..to {
                    let length = self.all[i].size[across] as f64;
                    let first = sorted.partition_point(|&j| (self.all[j].size[across] as f64) < length * NEAR);
                    let near =
                        sorted[first..].iter().take_while(|&&j| self.all[j].size[across] as f64 * NEAR <= length);
                    for &j in near.filter(|&&j| j <= i) {
                        if left == 0 {
                            break;
                        }
                        left -= 1;
                        let Some(size) = self.together(ready, i, j, axis) else { continue };
                        let Some(needs) = self.needs(kinds, i, j) else { continue };
                        let key = (size, needs);
                        if !known.contains(&key) && seen.insert(key) {
                            found.push((mixed(i, j, axis), i, j, axis));
                        }
                    }
                }
            }
            // Where there are more than are kept, any of them.
            found.sort_unstable();
            found.truncate(MOST - to);
            for (_, i, j, axis) in found {
                let (a, b) = (&self.all[i], &self.all[j]);
                let (Some(size), Some(needs)) = (self.together(ready, i, j, axis), self.needs(kinds, i, j)) else {
                    continue;
                };
                let block = Block {
                    size,
                    value: a.value + b.value,
                    volume: a.volume + b.volume,
                    needs,
                    boxes: a.boxes + b.boxes,
                    made: Made::Pair(i, j, axis),
                };
                self.add(block, known);
            }
            from = to;
        }
    }

    /// The box around two blocks beside each other, if it fits and is full enough.
    fn together(&self, ready: &Ready, i: usize, j: usize, axis: usize) -> Option<Triple> {
        let (a, b) = (&self.all[i], &self.all[j]);
        let size: Triple =
            std::array::from_fn(|k| if k == axis { a.size[k] + b.size[k] } else { a.size[k].max(b.size[k]) });
        let fits = (0..3).all(|k| size[k] <= ready.space[k]);
        (fits && a.volume + b.volume >= FULL * volume(&size)).then_some(size)
    }

    /// The boxes of both, if there are as many.
    fn needs(&self, kinds: &[Vec<usize>], i: usize, j: usize) -> Option<Needs> {
        let mut all = self.all[i].needs.clone();
        for &(kind, count) in &self.all[j].needs {
            match all.iter_mut().find(|(known, _)| *known == kind) {
                Some((_, known)) => *known += count,
                None => all.push((kind, count)),
            }
        }
        all.sort_unstable();
        all.iter().all(|&(kind, count)| count as usize <= kinds[kind as usize].len()).then_some(all)
    }

    /// The boxes of a block at a corner; `left` are those of each kind that are still free.
    pub(super) fn unfolded(&self, block: usize, at: Triple, left: &mut [Vec<usize>], placed: &mut Vec<Placed>) {
        match self.all[block].made {
            Made::Equal(kind, size, [x, y, z]) => {
                for index in 0..x * y * z {
                    let Some(item) = left[kind].pop() else { return };
                    let along = [index % x, index / x % y, index / (x * y)];
                    placed.push(Placed { run: 0, item, at: [0, 1, 2].map(|k| at[k] + along[k] * size[k]), size });
                }
            }
            Made::Pair(first, second, axis) => {
                self.unfolded(first, at, left, placed);
                let mut behind = at;
                behind[axis] += self.all[first].size[axis];
                self.unfolded(second, behind, left, placed);
            }
        }
    }
}

/// The first `first` of `all` places, and of the others evenly as many as `most` allow.
fn spread(first: usize, all: usize, most: usize) -> impl Iterator<Item = usize> {
    let (rest, room) = (all - first, (most - first).min(all - first));
    (0..first).chain((0..room).map(move |i| first + i * rest / room.max(1)))
}

/// A number that says nothing of where a pair comes from.
fn mixed(i: usize, j: usize, axis: usize) -> u64 {
    let mut z = ((i as u64) << 34 | (j as u64) << 4 | axis as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 31)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 30)
}
