//! The methods for boxes, by name, and `auto`.

use super::bound::{fewest_runs, most_value};
use super::empty::fewer;
use super::fill::{Ready, first_fit};
use super::filling::fullest;
use super::instance::{BoxPacking, Ended, Instance, PackGoal, Placed};
#[cfg(feature = "integer-program")]
use super::ip::{Near, solve};
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
    /// Tabu search; for the least number of runs.
    Tabu,
    /// Models as a few boxes each.
    Coverings,
    /// Models on their own surfaces.
    Anneal,
}

impl Method {
    /// By name.
    pub const NAMED: [(&'static str, Self); 6] = [
        ("auto", Self::Auto),
        ("ip", Self::Ip),
        ("ip-local-search", Self::IpLocalSearch),
        ("tabu", Self::Tabu),
        ("coverings", Self::Coverings),
        ("anneal", Self::Anneal),
    ];

    /// Whether this build has it: the integer programs want the feature `integer-program`.
    pub fn is_built_in(self) -> bool {
        cfg!(feature = "integer-program") || !matches!(self, Self::Ip | Self::IpLocalSearch)
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
/// The neighbourhoods of the local search: boxes that come or go, relations that change (seed 003, chapter 4).
#[cfg(feature = "integer-program")]
const NEIGHBOURHOODS: [Near; 3] =
    [Near { used: 2.0, directions: 30.0 }, Near { used: 5.0, directions: 20.0 }, Near { used: 8.0, directions: 10.0 }];

/// Packs boxes: all in the least number of runs, or the most value in one. The same seed and steps give the same packing.
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
    if goal == PackGoal::Runs
        && let Some(large) = (0..sizes.len()).find(|&item| sizes[item].is_empty())
    {
        return Err(Unpackable::TooLarge(large));
    }
    let by_program = matches!(method, Method::Ip | Method::IpLocalSearch);
    if !method.is_built_in() {
        return Err(Unpackable::NoProgram);
    }
    if by_program && fits.len() > MOST_BOXES {
        return Err(Unpackable::TooMany { boxes: fits.len() });
    }
    if method == Method::Tabu && goal == PackGoal::Filling {
        return Err(Unpackable::NoFilling);
    }
    let drawn = Instance { items: fits.iter().map(|&item| drawn.items[item]).collect(), ..drawn };
    if drawn.items.is_empty() {
        return Ok(BoxPacking::of(Vec::new(), 0.0, Ended::Proved));
    }
    let mut found = Search { instance: &drawn, goal, seed }.by(method, watch);
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
        let bound = match self.goal {
            PackGoal::Runs => fewest_runs(self.instance) as f64,
            PackGoal::Filling => most_value(self.instance),
        };
        let ready = Ready::of(self.instance);
        match method {
            Method::Tabu => self.answer(flat(&tabu(&ready, bound as usize, watch)), bound, false, watch),
            #[cfg(feature = "integer-program")]
            Method::Ip | Method::IpLocalSearch => {
                let start = {
                    let mut asked = |_| (!watch.spend(2000)).then(|| watch.ended());
                    self.start(&ready, bound, &mut Watch::new(BEFORE_IP, &mut asked))
                };
                if self.meets(&start, bound) {
                    return self.answer(start, bound, true, watch);
                }
                if method == Method::Ip { self.program(start, bound, watch) } else { self.nearby(start, bound, watch) }
            }
            _ => self.answer(self.start(&ready, bound, watch), bound, false, watch),
        }
    }

    fn start(&self, ready: &Ready, bound: f64, watch: &mut Watch<'_>) -> Vec<Placed> {
        match self.goal {
            PackGoal::Runs => flat(&fewer(ready, first_fit(ready, watch), bound as usize, self.seed, watch)),
            PackGoal::Filling => fullest(ready, bound, self.seed, watch),
        }
    }

    #[cfg(feature = "integer-program")]
    fn program(&self, start: Vec<Placed>, bound: f64, watch: &mut Watch<'_>) -> BoxPacking {
        let solved = solve(self.instance, self.goal, &start, bound, None, watch);
        let told = solved.bound.unwrap_or(bound);
        let bound = match self.goal {
            // Runs are whole; a solver's number is a little off.
            PackGoal::Runs => bound.max((told - 1e-6).ceil()),
            PackGoal::Filling => bound.min(told * (1.0 + 1e-9)),
        };
        let placed = solved.better.unwrap_or(start);
        self.answer(placed, bound, solved.proved, watch)
    }

    #[cfg(feature = "integer-program")]
    /// From neighbourhood to neighbourhood, until none has anything better.
    fn nearby(&self, mut best: Vec<Placed>, bound: f64, watch: &mut Watch<'_>) -> BoxPacking {
        let mut tried = 0;
        while tried < NEIGHBOURHOODS.len() && watch.goes_on() && !self.meets(&best, bound) {
            match solve(self.instance, self.goal, &best, bound, Some(NEIGHBOURHOODS[tried]), watch).better {
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
        }
    }

    fn answer(&self, placed: Vec<Placed>, bound: f64, proved: bool, watch: &Watch<'_>) -> BoxPacking {
        let met = proved || self.meets(&placed, bound);
        let made = BoxPacking::of(placed, bound, if met { Ended::Proved } else { watch.ended() });
        match self.goal {
            PackGoal::Runs if proved => BoxPacking { bound: made.runs as f64, ..made },
            PackGoal::Filling if proved => BoxPacking { bound: self.instance.value(&made.placed), ..made },
            _ => made,
        }
    }
}

fn flat(runs: &[Vec<Placed>]) -> Vec<Placed> {
    runs.iter().enumerate().flat_map(|(run, all)| all.iter().map(move |p| Placed { run, ..*p })).collect()
}
