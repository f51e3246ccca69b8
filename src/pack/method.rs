//! The methods for boxes, by name, and `auto`.

use super::bound::most_value;
use super::empty::fewer;
use super::fewest::{by_functions, least_height, nearer};
use super::fill::{Ready, first_fit};
use super::filling::{by_blocks, fewest_by_blocks, most};
use super::height::lowest;
use super::instance::{BoxPacking, Ended, Instance, Item, Neighbourhood, PackGoal, Placed, height, volume};
#[cfg(feature = "integer-program")]
use super::ip::solve;
use super::loading::Loading;
use super::tabu::tabu;
use super::watch::Watch;

/// Boxes that are given to the integer program, at most: beyond that not even the first relaxation is solved in a minute.
pub const MOST_BOXES: usize = 60;

/// How boxes are packed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    /// First fit, then runs emptied one by one; a run filled by orders that change a little at a time.
    #[default]
    Auto,
    /// The integer program, begun with a short run of `Auto`.
    Ip,
    /// The same, near the best that is known, again and again.
    IpLocalSearch,
    /// The same with a neighbourhood of the caller's own.
    IpNear(Neighbourhood),
    /// Tabu search; for the least number of runs.
    Tabu,
    /// Equal boxes as blocks, a beam search over them; for values and runs.
    Blocks,
    /// Models as a few boxes each.
    Coverings,
    /// Models on their own surfaces.
    Anneal,
}

impl Method {
    /// By name.
    pub const NAMED: [(&'static str, Self); 7] = [
        ("auto", Self::Auto),
        ("ip", Self::Ip),
        ("ip-local-search", Self::IpLocalSearch),
        ("tabu", Self::Tabu),
        ("blocks", Self::Blocks),
        ("coverings", Self::Coverings),
        ("anneal", Self::Anneal),
    ];

    /// Whether this build has it: the integer programs want the feature `integer-program`.
    pub fn is_built_in(self) -> bool {
        cfg!(feature = "integer-program") || !self.is_program()
    }

    /// Whether it solves integer programs.
    fn is_program(self) -> bool {
        matches!(self, Self::Ip | Self::IpLocalSearch | Self::IpNear(_))
    }

    /// Whether it looks at more of a model than its box.
    pub fn of_shapes(self) -> bool {
        matches!(self, Self::Coverings | Self::Anneal)
    }
}

/// What cannot be packed by a method.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Unpackable {
    /// A box that does not fit in the space however it is turned.
    #[error("box {0} does not fit in the space")]
    TooLarge(usize),
    /// More boxes than the solver takes.
    #[error("{boxes} boxes are too many for the integer program (at most {MOST_BOXES}); use --method auto")]
    TooMany {
        /// Boxes.
        boxes: usize,
    },
    /// The integer program, and the build has no solver.
    #[error(
        "this build of trunnion has no integer program; use --method auto, or build with: cargo build --release --features integer-program"
    )]
    NoProgram,
    /// Tabu search fills no single run.
    #[error("tabu search minimizes the number of runs, not the value in one; use --method auto")]
    NoFilling,
    /// No packing of all boxes in one run was found within the limit of its height.
    #[error("no packing was found within the height of the space; none is lower than {0} units")]
    NotLow(
        /// What no packing is lower than, units; beyond the limit where that is proved to be too low.
        i64,
    ),
    /// A method that looks for no height.
    #[error("it does not minimize the height of a run; use --method auto")]
    NoHeight,
    /// A method for models only.
    #[error("it packs the shapes of models, not boxes; use --method auto")]
    OnlyModels,
    /// The annealing fills one run.
    #[error("annealing fills one run; pass --fill volume, or use --method auto")]
    OnlyFilling,
}

/// Steps of `Auto` with which the integer programs begin.
#[cfg(feature = "integer-program")]
const BEFORE_IP: u64 = 300_000;
/// The neighbourhoods of the local search, one after the other, where none is given (Leitereg (2020), chapter 4).
#[cfg(feature = "integer-program")]
const NEIGHBOURHOODS: [Neighbourhood; 3] = [
    Neighbourhood { used: 2, directions: 30 },
    Neighbourhood { used: 5, directions: 20 },
    Neighbourhood { used: 8, directions: 10 },
];

/// Packs boxes: all in the least number of runs, the most value in one, or all in one as low as can be. The same seed and steps give the same packing.
///
/// # Errors
///
/// [`Unpackable`]; where a run is filled, boxes that do not fit are left out instead.
pub fn pack(
    instance: &Instance,
    goal: PackGoal,
    method: Method,
    seed: u64,
    watch: &mut Watch<'_>,
) -> Result<BoxPacking, Unpackable> {
    if method.of_shapes() {
        return Err(Unpackable::OnlyModels);
    }
    let drawn = instance.drawn();
    let sizes = drawn.sizes();
    let fits: Vec<usize> = (0..sizes.len()).filter(|&item| !sizes[item].is_empty()).collect();
    if goal != PackGoal::Filling
        && let Some(large) = (0..sizes.len()).find(|&item| sizes[item].is_empty())
    {
        return Err(Unpackable::TooLarge(large));
    }
    if goal == PackGoal::Height && matches!(method, Method::Tabu | Method::Blocks) {
        return Err(Unpackable::NoHeight);
    }
    if !method.is_built_in() {
        return Err(Unpackable::NoProgram);
    }
    if method.is_program() && fits.len() > MOST_BOXES {
        return Err(Unpackable::TooMany { boxes: fits.len() });
    }
    if method == Method::Tabu && goal == PackGoal::Filling {
        return Err(Unpackable::NoFilling);
    }
    let kept = fits.iter().map(|&item| match goal {
        // What has no place in a run of some height costs its volume.
        PackGoal::Height => Item { value: volume(&drawn.items[item].size), ..drawn.items[item] },
        PackGoal::Runs | PackGoal::Filling => drawn.items[item],
    });
    let drawn = Instance { items: kept.collect(), ..drawn };
    if drawn.items.is_empty() {
        return Ok(BoxPacking::of(Vec::new(), 0.0, Ended::Proved));
    }
    let mut found = Search { instance: &drawn, goal, seed }.by(method, watch);
    if goal == PackGoal::Height {
        found.bound -= instance.gap as f64;
        if found.placed.len() < drawn.items.len() {
            return Err(Unpackable::NotLow(found.bound as i64));
        }
    }
    for p in &mut found.placed {
        p.size = p.size.map(|length| length - instance.gap);
        p.item = fits[p.item];
    }
    found.placed.sort_unstable();
    Ok(found)
}

struct Search<'a> {
    /// Drawn out, and every box fits.
    instance: &'a Instance,
    goal: PackGoal,
    seed: u64,
}

impl Search<'_> {
    fn by(&self, method: Method, watch: &mut Watch<'_>) -> BoxPacking {
        let ready = Ready::of(self.instance);
        let bound = match self.goal {
            // Up to what is found at once: then it is proved.
            PackGoal::Runs => {
                let known = by_functions(self.instance);
                let found = first_fit(&ready, watch).len();
                nearer(self.instance, known, found).runs as f64
            }
            PackGoal::Filling => most_value(self.instance),
            PackGoal::Height => least_height(self.instance) as f64,
        };
        match method {
            Method::Blocks => self.answer(self.blocks(&ready, bound, watch), bound, false, watch),
            Method::Tabu => self.answer(flat(&tabu(&ready, bound as usize, watch)), bound, false, watch),
            #[cfg(feature = "integer-program")]
            Method::Ip | Method::IpLocalSearch | Method::IpNear(_) => {
                let start = {
                    let mut asked = |_| (!watch.spend(2000)).then(|| watch.ended());
                    self.start(&ready, bound, &mut Watch::new(BEFORE_IP, &mut asked))
                };
                if self.meets(&start, bound) {
                    return self.answer(start, bound, true, watch);
                }
                if self.goal == PackGoal::Height && start.is_empty() {
                    return self.answer(start, bound, false, watch);
                }
                let lower = self.as_low_as(&start);
                let search = Search { instance: &lower, ..*self };
                match method {
                    Method::Ip => search.program(start, bound, watch),
                    Method::IpNear(near) => search.nearby(start, bound, &[near], watch),
                    _ => search.nearby(start, bound, &NEIGHBOURHOODS, watch),
                }
            }
            _ => self.answer(self.start(&ready, bound, watch), bound, false, watch),
        }
    }

    fn blocks(&self, ready: &Ready, bound: f64, watch: &mut Watch<'_>) -> Vec<Placed> {
        if self.goal == PackGoal::Runs {
            return flat(&fewest_by_blocks(ready, bound as usize, watch));
        }
        let mut loading = Loading::of(ready, watch);
        while loading.wider(bound, watch) && loading.value() < bound * (1.0 - 1e-8) && watch.goes_on() {}
        loading.placed()
    }

    fn start(&self, ready: &Ready, bound: f64, watch: &mut Watch<'_>) -> Vec<Placed> {
        match self.goal {
            PackGoal::Runs => flat(&fewer(ready, first_runs(ready, bound, watch), bound as usize, self.seed, watch)),
            PackGoal::Filling => most(ready, bound, self.seed, watch),
            PackGoal::Height if bound > self.instance.space[2] as f64 => Vec::new(),
            PackGoal::Height => lowest(ready, bound as i64, self.seed, watch).unwrap_or_default(),
        }
    }

    /// The instance, for [`PackGoal::Height`] with what `start` reaches as its limit.
    #[cfg(feature = "integer-program")]
    fn as_low_as(&self, start: &[Placed]) -> Instance {
        let mut lower = self.instance.clone();
        if self.goal == PackGoal::Height {
            lower.space[2] = height(start);
        }
        lower
    }

    #[cfg(feature = "integer-program")]
    fn program(&self, start: Vec<Placed>, bound: f64, watch: &mut Watch<'_>) -> BoxPacking {
        let solved = solve(self.instance, self.goal, &start, bound, None, watch);
        let told = solved.bound.unwrap_or(bound);
        let bound = match self.goal {
            // Runs are whole; a solver's number is a little off.
            PackGoal::Runs => bound.max((told - 1e-6).ceil()),
            PackGoal::Filling => bound.min(told * (1.0 + 1e-9)),
            PackGoal::Height => bound.max((told - 1e-6 * self.instance.space[2] as f64).ceil()),
        };
        let placed = solved.better.unwrap_or(start);
        self.answer(placed, bound, solved.proved, watch)
    }

    #[cfg(feature = "integer-program")]
    /// From neighbourhood to neighbourhood, until none has anything better.
    fn nearby(&self, mut best: Vec<Placed>, bound: f64, near: &[Neighbourhood], watch: &mut Watch<'_>) -> BoxPacking {
        let mut tried = 0;
        while tried < near.len() && watch.goes_on() && !self.meets(&best, bound) {
            match solve(self.instance, self.goal, &best, bound, Some(near[tried]), watch).better {
                Some(better) => (best, tried) = (better, 0),
                None => tried += 1,
            }
        }
        self.answer(best, bound, false, watch)
    }

    fn meets(&self, placed: &[Placed], bound: f64) -> bool {
        match self.goal {
            PackGoal::Runs => placed.iter().map(|p| p.run + 1).max().unwrap_or(0) as f64 <= bound,
            PackGoal::Filling => self.instance.value(placed) >= bound * (1.0 - 1e-8),
            PackGoal::Height => !placed.is_empty() && height(placed) as f64 <= bound,
        }
    }

    fn answer(&self, placed: Vec<Placed>, bound: f64, proved: bool, watch: &Watch<'_>) -> BoxPacking {
        // A height is a solver's number but for its rounding: only the bound that is left of it proves something.
        let met = (proved && self.goal != PackGoal::Height) || self.meets(&placed, bound);
        let made = BoxPacking::of(placed, bound, if met { Ended::Proved } else { watch.ended() });
        match self.goal {
            PackGoal::Runs if proved => BoxPacking { bound: made.runs as f64, ..made },
            PackGoal::Filling if proved => BoxPacking { bound: self.instance.value(&made.placed), ..made },
            _ => made,
        }
    }
}

/// First fit; where boxes are equal and that is not the fewest, runs filled by blocks if they are fewer.
fn first_runs(ready: &Ready, bound: f64, watch: &mut Watch<'_>) -> Vec<Vec<Placed>> {
    let first = first_fit(ready, watch);
    if first.len() as f64 <= bound || !ready.has_equal() || !watch.goes_on() {
        return first;
    }
    let blocks = by_blocks(ready, 1, watch);
    if blocks.len() < first.len() { blocks } else { first }
}

fn flat(runs: &[Vec<Placed>]) -> Vec<Placed> {
    runs.iter().enumerate().flat_map(|(run, all)| all.iter().map(move |p| Placed { run, ..*p })).collect()
}
