//! One run being filled: the largest empty boxes in it (maximal spaces; Lai and Chan, "Developing a simulated annealing algorithm for
//! the cutting stock problem", 1997), and the corners and orders by which boxes are put into them.

use super::instance::{Placed, Triple, volume};

/// An empty box, from its low to its high corner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Space {
    low: Triple,
    high: Triple,
}

impl Space {
    fn holds(&self, other: &Self) -> bool {
        (0..3).all(|k| self.low[k] <= other.low[k] && other.high[k] <= self.high[k])
    }
}

/// Which of the places for a box is taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rule {
    /// The lowest along the first of these axes, then the second, then the third.
    Lowest([usize; 3]),
    /// The one where the box's top is lowest; then the lowest, the nearest to the back and to the left.
    Top,
    /// The one whose far corner is farthest from the run's far corner (Gonçalves and Resende 2013).
    Far,
    /// The one that leaves the least room beside the box.
    Snug,
    /// The one with the largest share of the box's surface on walls and other boxes.
    Touching,
}

/// An empty box and the corner of it that is nearest to one of the run's.
pub(super) struct Corner {
    pub(super) low: Triple,
    pub(super) high: Triple,
    /// Whether it is the high one, by axis.
    far: [bool; 3],
}

impl Corner {
    /// Where the low corner of a box of `size` in it comes.
    pub(super) fn of(&self, size: &Triple) -> Triple {
        [0, 1, 2].map(|k| if self.far[k] { self.high[k] - size[k] } else { self.low[k] })
    }
}

/// A run that is being filled.
#[derive(Clone, Debug)]
pub(super) struct Run {
    size: Triple,
    spaces: Vec<Space>,
    fresh: Vec<Space>,
    pub(super) placed: Vec<Placed>,
    pub(super) free: f64,
}

impl Run {
    /// An empty one.
    pub(super) fn empty(size: Triple) -> Self {
        let spaces = vec![Space { low: [0; 3], high: size }];
        Self { size, spaces, fresh: Vec::new(), placed: Vec::new(), free: volume(&size) }
    }

    /// Empty again.
    pub(super) fn clear(&mut self) {
        self.spaces.clear();
        self.spaces.push(Space { low: [0; 3], high: self.size });
        self.placed.clear();
        self.free = volume(&self.size);
    }

    /// The empty box with the corner nearest to one of the run's own; of equally near ones the largest.
    pub(super) fn corner(&self) -> Option<Corner> {
        let away = |space: &Space| {
            let ends = [0, 1, 2].map(|k| [space.low[k], self.size[k] - space.high[k]]);
            (ends.iter().map(|[low, high]| low.min(high)).sum::<i64>(), ends.map(|[low, high]| high < low))
        };
        let room = |space: &Space| volume(&[0, 1, 2].map(|k| space.high[k] - space.low[k]));
        let nearest = self.spaces.iter().min_by(|a, b| away(a).0.cmp(&away(b).0).then(room(b).total_cmp(&room(a))))?;
        Some(Corner { low: nearest.low, high: nearest.high, far: away(nearest).1 })
    }

    /// Leaves an empty box out of account, as nothing fits in it.
    pub(super) fn forget(&mut self, corner: &Corner) {
        self.spaces.retain(|space| space.low != corner.low || space.high != corner.high);
    }

    /// The best place by `rule` for a box that may have any of `sizes`: its corner and size.
    pub(super) fn place_for(&self, sizes: &[Triple], rule: Rule) -> Option<(Triple, Triple)> {
        let mut best: Option<([i64; 3], Triple, Triple)> = None;
        for size in sizes.iter().filter(|size| volume(size) <= self.free) {
            for space in &self.spaces {
                if (0..3).any(|k| space.high[k] - space.low[k] < size[k]) {
                    continue;
                }
                let score = self.score(space, size, rule);
                if best.as_ref().is_none_or(|(least, ..)| score < *least) {
                    best = Some((score, space.low, *size));
                }
            }
        }
        best.map(|(_, at, size)| (at, size))
    }

    /// The lower the better.
    fn score(&self, space: &Space, size: &Triple, rule: Rule) -> [i64; 3] {
        let low = space.low;
        match rule {
            Rule::Lowest(axes) => axes.map(|k| low[k]),
            Rule::Top => [low[2] + size[2], low[1], low[0]],
            Rule::Far => {
                let left = [0, 1, 2].map(|k| (self.size[k] - low[k] - size[k]) as f64);
                [-((left[0] * left[0] + left[1] * left[1] + left[2] * left[2]).sqrt() * 16.0) as i64, low[2], low[1]]
            }
            Rule::Snug => {
                let mut left = [0, 1, 2].map(|k| space.high[k] - low[k] - size[k]);
                left.sort_unstable();
                left
            }
            Rule::Touching => [-(self.touching(&low, size) * 1e6) as i64, low[2], low[1]],
        }
    }

    /// The share of a box's surface that lies on the run's sides and on other boxes.
    pub(super) fn touching(&self, low: &Triple, size: &Triple) -> f64 {
        let high = [0, 1, 2].map(|k| low[k] + size[k]);
        let (mut on, mut all) = (0.0, 0.0);
        for k in 0..3 {
            let (a, b) = ((k + 1) % 3, (k + 2) % 3);
            let face = size[a] as f64 * size[b] as f64;
            all += 2.0 * face;
            on += face * f64::from(u8::from(low[k] == 0) + u8::from(high[k] == self.size[k]));
            for p in &self.placed {
                if p.at[k] + p.size[k] == low[k] || p.at[k] == high[k] {
                    let shared = |m: usize| high[m].min(p.at[m] + p.size[m]) - low[m].max(p.at[m]);
                    on += shared(a).max(0) as f64 * shared(b).max(0) as f64;
                }
            }
        }
        on / all
    }

    /// Puts a box in its place; spaces thinner than `least` along an axis hold nothing more and are forgotten.
    pub(super) fn put(&mut self, item: usize, at: Triple, size: Triple, least: &Triple) {
        self.placed.push(Placed { run: 0, item, at, size });
        self.free -= volume(&size);
        let high = [0, 1, 2].map(|k| at[k] + size[k]);
        self.fresh.clear();
        let mut kept = 0;
        for i in 0..self.spaces.len() {
            let space = self.spaces[i];
            if (0..3).any(|k| space.low[k] >= high[k] || space.high[k] <= at[k]) {
                self.spaces[kept] = space;
                kept += 1;
                continue;
            }
            for k in 0..3 {
                if at[k] - space.low[k] >= least[k] {
                    let mut piece = space;
                    piece.high[k] = at[k];
                    self.fresh.push(piece);
                }
                if space.high[k] - high[k] >= least[k] {
                    let mut piece = space;
                    piece.low[k] = high[k];
                    self.fresh.push(piece);
                }
            }
        }
        self.spaces.truncate(kept);
        for i in 0..self.fresh.len() {
            let piece = self.fresh[i];
            let within = |other: &Space| other.holds(&piece);
            // Of two equal pieces the first stays.
            let doubled = self.fresh[..i].iter().any(within)
                || self.fresh[i + 1..].iter().any(|other| within(other) && *other != piece);
            if !doubled && !self.spaces[..kept].iter().any(within) {
                self.spaces.push(piece);
            }
        }
    }
}
