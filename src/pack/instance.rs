//! Boxes to be packed into equal spaces, in whole units, and what comes back.
//!
//! Lengths are whole units of whoever asks (`job` takes micrometres): sums and products of them are exact, so that "no overlap"
//! needs no tolerance. A gap between boxes is had by drawing every box and the space out by it ([`Instance::drawn`]): boxes that
//! do not overlap then are so far apart along an axis.

/// Three lengths or a corner, in units.
pub type Triple = [i64; 3];

/// The largest length, units: products of three of them with what bounds multiply them by fit in 128 bits.
pub const LONGEST: i64 = 1 << 30;

/// How a box or a model may be turned.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Turns {
    /// As it is.
    #[default]
    None,
    /// By quarter turns about Z.
    Z90,
    /// By any angle about Z; boxes by quarter turns.
    Z,
    /// In every way; boxes onto each of their sides.
    Any,
}

impl Turns {
    /// By name.
    pub const NAMED: [(&'static str, Self); 4] =
        [("none", Self::None), ("z90", Self::Z90), ("z", Self::Z), ("any", Self::Any)];

    /// The sizes that a box of `size` may have, each once, its own first.
    pub fn sizes(self, size: Triple) -> Vec<Triple> {
        let [w, d, h] = size;
        let all: &[Triple] = match self {
            Self::None => &[size],
            Self::Z90 | Self::Z => &[size, [d, w, h]],
            Self::Any => &[size, [d, w, h], [w, h, d], [h, w, d], [d, h, w], [h, d, w]],
        };
        let mut sizes: Vec<Triple> = Vec::new();
        all.iter().for_each(|s| {
            if !sizes.contains(s) {
                sizes.push(*s);
            }
        });
        sizes
    }
}

/// One box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Item {
    /// Its lengths along x, y and z.
    pub size: Triple,
    /// What having it in a run is worth; looked at where a run is filled.
    pub value: f64,
    /// Which of its own axes may point up or down where turns of any kind are allowed.
    pub up: [bool; 3],
}

/// Boxes and the space that each run has for them.
#[derive(Clone, Debug, PartialEq)]
pub struct Instance {
    /// The space of one run.
    pub space: Triple,
    /// What is left free between two boxes along at least one axis; not between a box and the space's own sides.
    pub gap: i64,
    /// How boxes may be turned.
    pub turns: Turns,
    /// The boxes, every copy by itself.
    pub items: Vec<Item>,
}

/// A box in its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Placed {
    /// The run, from 0.
    pub run: usize,
    /// Which of [`Instance::items`].
    pub item: usize,
    /// Its low corner.
    pub at: Triple,
    /// Its lengths as it was turned.
    pub size: Triple,
}

/// What is looked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PackGoal {
    /// All boxes in the least number of runs.
    Runs,
    /// The most value in one run.
    Filling,
    /// All boxes in one run, as low as can be; the space's z is a limit.
    Height,
}

/// How far from the best packing the integer program's local search goes: the Hamming distance of the program's zero-one variables (Leitereg (2020),
/// "Local search using IP", `used_d` and `dir_d`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Neighbourhood {
    /// Boxes that may come or go, at most.
    pub used: u32,
    /// Relations that may change between boxes that are used, six for each pair, at most.
    pub directions: u32,
}

/// Why a search ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// The answer meets its bound: nothing better is possible.
    Proved,
    /// So many steps were allowed.
    Steps,
    /// So much time was allowed.
    Time,
    /// An interrupt.
    Interrupted,
}

/// A packing with what is known of the best one.
#[derive(Clone, Debug, PartialEq)]
pub struct BoxPacking {
    /// The boxes in their places, by run and item.
    pub placed: Vec<Placed>,
    /// Runs that have something in them.
    pub runs: usize,
    /// [`PackGoal::Runs`]: no packing has fewer runs. [`PackGoal::Filling`]: none has more value. [`PackGoal::Height`]: none is lower, units.
    pub bound: f64,
    /// Why the search ended.
    pub ended: Ended,
}

impl Instance {
    /// Its boxes and space drawn out by the gap, and no gap: corners of a packing of the one are those of the other.
    pub fn drawn(&self) -> Self {
        let longer = |size: Triple| size.map(|length| length + self.gap);
        let items = self.items.iter().map(|item| Item { size: longer(item.size), ..*item }).collect();
        Self { space: longer(self.space), gap: 0, turns: self.turns, items }
    }

    /// The sizes of each item that fit in the space, as they may be turned.
    pub fn sizes(&self) -> Vec<Vec<Triple>> {
        let fits = |size: &Triple| (0..3).all(|k| size[k] <= self.space[k]);
        self.items.iter().map(|item| self.turned(item).into_iter().filter(fits).collect()).collect()
    }

    /// The sizes that an item may have, each once, its own first where it is one of them.
    pub fn turned(&self, item: &Item) -> Vec<Triple> {
        let all = self.turns.sizes(item.size);
        // Of equal lengths any may be the one that is up.
        let stands = |size: &Triple| (0..3).any(|k| item.up[k] && size[2] == item.size[k]);
        if self.turns == Turns::Any { all.into_iter().filter(stands).collect() } else { all }
    }

    /// The value of what is placed.
    pub fn value(&self, placed: &[Placed]) -> f64 {
        placed.iter().map(|p| self.items[p.item].value).sum()
    }
}

/// How high the highest of `placed` reaches, units; 0 for none.
pub fn height(placed: &[Placed]) -> i64 {
    placed.iter().map(|p| p.at[2] + p.size[2]).max().unwrap_or(0)
}

/// The greatest length of which both are multiples.
pub(super) fn gcd(a: i64, b: i64) -> i64 {
    if b == 0 { a } else { gcd(b, a % b) }
}

/// The volume of a box, units cubed.
pub fn volume(size: &Triple) -> f64 {
    size[0] as f64 * size[1] as f64 * size[2] as f64
}

impl BoxPacking {
    /// Runs in `placed`, numbered without holes, as an answer.
    pub(super) fn of(mut placed: Vec<Placed>, bound: f64, ended: Ended) -> Self {
        let mut used: Vec<usize> = placed.iter().map(|p| p.run).collect();
        used.sort_unstable();
        used.dedup();
        placed.iter_mut().for_each(|p| p.run = used.partition_point(|&run| run < p.run));
        placed.sort_unstable();
        Self { placed, runs: used.len(), bound, ended }
    }
}
