//! Models or boxes packed into runs of a space, or side by side on a machine's table.

mod boxes;
mod error;
mod inflated;
mod limit;
mod plates;
mod result;
mod space;
mod table;

use crate::input::load_unposed;
use crate::input::{BadSetting, LoadedModel, MachineSource, ModelSource, Source, load_profile};
use crate::mesh::is_overlap;
use crate::pack::{
    Askew, Ended, Method, Neighbourhood, PackGoal, PackSolid, Packed, Put, Room, Shown, Turns, Unpackable, Watch,
    not_low, pack_models, packing_bound,
};
use crate::spelling::nearest;
use crate::world::World;
pub use error::{BadPacking, PackError};
pub use inflated::Coarsened;
use inflated::Inflated;
use limit::Limit;
pub use plates::Plates;
use result::UNITS;
pub use result::{PackResult, Piece, Plate};
pub use space::PackSpace;

/// What is packed.
#[derive(Clone, Debug)]
pub enum Contents {
    /// Models, each with how many copies.
    Models(Vec<(ModelSource, usize)>),
    /// A text with a box a line: `w d h [count [value]]`, mm.
    Boxes(Source),
}

/// Where it is packed into.
#[derive(Clone, Debug)]
pub enum Into {
    /// The space of each run.
    Space(PackSpace),
    /// A machine's table: one layer of models.
    Table(MachineSource),
}

/// What to pack, and how.
#[derive(Clone, Debug)]
pub struct PackRequest {
    /// What.
    pub contents: Contents,
    /// Into what.
    pub into: Into,
    /// How.
    pub options: PackOptions,
}

/// How to pack; the default is what the command does without flags.
#[derive(Clone, Debug, PartialEq)]
pub struct PackOptions {
    /// The least distance between two pieces, mm; `None`: 1 between models, 0 between boxes, and on a table as far as the head reaches sideways.
    pub gap_mm: Option<f64>,
    /// How pieces may be turned, by name.
    pub turn: String,
    /// What is looked for, by name: `runs`, `fill` or `height`; `None`: `fill` where [`PackOptions::fill`] is given, else `runs`.
    pub goal: Option<String>,
    /// What is worth how much, with the goal `fill`; `None`: `volume`. `volume`, `file` (the boxes' own values), or a value for each model
    /// or line with commas between them.
    pub fill: Option<String>,
    /// The method, by name.
    pub method: String,
    /// How far the integer program's local search goes from the best packing: boxes that come or go, and relations between boxes that change; `None`: the
    /// thesis's three, one after the other.
    pub near: Option<[u32; 2]>,
    /// When to be done with everything, reading and the exact test too, s; `None`: after a number of steps that is the same on every machine.
    pub seconds: Option<f64>,
    /// Models are packed as coarser meshes around them whose vertices are raised by this at most, mm; `None`: as they are.
    pub inflate_mm: Option<f64>,
    /// Whether every model must come out straight up.
    pub no_interlock: bool,
    /// Seed of what draws numbers.
    pub seed: u64,
}

impl Default for PackOptions {
    fn default() -> Self {
        Self {
            gap_mm: None,
            turn: "none".to_owned(),
            goal: None,
            fill: None,
            method: "auto".to_owned(),
            near: None,
            seconds: None,
            inflate_mm: None,
            no_interlock: false,
            seed: 1,
        }
    }
}

/// Pieces, at most.
pub const MOST_PIECES: usize = 5000;
/// Between models where nothing is said, mm.
const GAP_MM: f64 = 1.0;
/// The least and the most between models, mm.
const GAPS_MM: [f64; 2] = [0.01, 500.0];
/// The least and the most by which models are inflated, mm.
const INFLATED_MM: [f64; 2] = [0.0, 100.0];
/// Steps where no time is given: some ten seconds.
const STEPS: u64 = 10_000_000;

/// Packs models or boxes. `stop` is asked now and then whether to end with the best so far.
///
/// # Errors
///
/// [`InputError::Setting`](crate::input::InputError::Setting) and [`PackError::Packing`] for what cannot be packed so; what reading
/// models, boxes and machine may say.
pub fn pack(request: &PackRequest, stop: &dyn Fn() -> bool, world: &World<'_>) -> Result<PackResult, PackError> {
    let asked = Asked::of(request)?;
    let limit = Limit::begin(request.options.seconds, world);
    let read = |models: &[(ModelSource, usize)]| {
        let models = loaded(models, world)?;
        Ok::<_, PackError>((models, limit.spent().as_secs_f64()))
    };
    let mut done = match (&request.contents, &request.into) {
        (Contents::Boxes(source), Into::Space(space)) => boxes::packed(source, space, &asked, stop, &limit, world)?,
        (Contents::Boxes(source), Into::Table(_)) => {
            return Err(BadPacking::BoxesOnTable(source.name().into_owned()).into());
        }
        (Contents::Models(models), Into::Space(space)) => {
            let (models, reading) = read(models)?;
            PackResult { reading_s: reading, ..in_space(&models, space, &asked, stop, &limit, world)? }
        }
        (Contents::Models(models), Into::Table(machine)) => {
            let machine = load_profile(machine, world)?;
            let (models, reading) = read(models)?;
            PackResult { reading_s: reading, ..table::packed(&models, &machine, &asked, stop, &limit, world)? }
        }
    };
    done.seconds = limit.spent().as_secs_f64();
    done.limit_s = request.options.seconds;
    Ok(done)
}

/// The options, checked.
struct Asked<'a> {
    options: &'a PackOptions,
    turns: Turns,
    goal: PackGoal,
    method: Method,
    shapes: bool,
    name: &'static str,
}

impl<'a> Asked<'a> {
    fn of(request: &'a PackRequest) -> Result<Self, PackError> {
        let options = &request.options;
        let boxes = matches!(request.contents, Contents::Boxes(_));
        if let Some(mm) = options.gap_mm {
            BadSetting::within("gap", mm, " mm", [if boxes { 0.0 } else { GAPS_MM[0] }, GAPS_MM[1]])?;
        }
        if let Some(seconds) = options.seconds {
            BadSetting::within("time", seconds, " s", [0.01, 86400.0])?;
        }
        if let Some(mm) = options.inflate_mm {
            BadSetting::within("inflate", mm, " mm", INFLATED_MM)?;
            if boxes || matches!(request.into, Into::Table(_)) {
                let why = "boxes, and models on a table, are packed by their boxes alone; leave out --inflate";
                return Err(BadPacking::Inflate(why.to_owned()).into());
            }
        }
        let goal = space::goal(options, &request.into)?;
        let turns = named("turn", &options.turn, &Turns::NAMED)?.0;
        let (method, name) = named("method", &options.method, &Method::NAMED)?;
        let method = match (method, options.near) {
            (Method::IpLocalSearch, Some([used, directions])) => Method::IpNear(Neighbourhood { used, directions }),
            (_, None) => method,
            (_, Some(_)) => {
                let why =
                    "it has no neighbourhood; use --method ip-local-search, or leave out --used-distance".to_owned();
                return Err(BadPacking::Method { method: name.to_owned(), why }.into());
            }
        };
        Ok(Self { options, turns, goal, method, shapes: method == Method::Auto && !boxes, name })
    }

    /// The value of each of `own`: its volume or its own number, or what is given.
    fn values(&self, volumes: &[f64], own: &[f64]) -> Result<Vec<f64>, BadPacking> {
        let Some(given) = &self.options.fill else { return Ok(volumes.to_vec()) };
        let bad = || BadPacking::Values { given: given.clone(), wanted: volumes.len() };
        let positive = |text: &str| text.trim().parse().ok().filter(|v: &f64| v.is_finite() && *v > 0.0);
        match given.as_str() {
            "volume" => Ok(volumes.to_vec()),
            "file" if !own.is_empty() => Ok(own.to_vec()),
            list => {
                let values: Option<Vec<f64>> = list.split(',').map(positive).collect();
                values.filter(|values| values.len() == volumes.len()).ok_or_else(bad)
            }
        }
    }

    /// Runs `search` with a watch that ends by steps, by the clock or by `stop`.
    fn watched<T>(
        &self,
        stop: &dyn Fn() -> bool,
        limit: &Limit<'_>,
        world: &World<'_>,
        shown: &mut dyn FnMut(&[Put]),
        search: impl FnOnce(&mut Watch<'_>) -> T,
    ) -> T {
        let bar = world.progress.begin("packing", 100);
        let mut ask = |steps: f64| {
            let share = limit.share();
            bar.at((100.0 * share.unwrap_or(steps).min(1.0)) as usize);
            if stop() {
                return Some(Ended::Interrupted);
            }
            share.filter(|share| *share >= 1.0).map(|_| Ended::Time)
        };
        let shown: Option<Shown<'_>> = if limit.is_set() { Some(shown) } else { None };
        let steps = if limit.is_set() { u64::MAX } else { STEPS };
        let mut watch = Watch::new(steps, &mut ask);
        watch = match shown {
            Some(shown) => watch.showing(shown),
            None => watch,
        };
        search(&mut watch)
    }

    fn unpackable(&self, why: Unpackable, limit_mm: Option<f64>, no_fit: impl Fn(usize) -> BadPacking) -> BadPacking {
        match why {
            Unpackable::TooLarge(index) => no_fit(index),
            Unpackable::NotLow(bound) => {
                let (limit, is_given) = (limit_mm.unwrap_or(space::HIGHEST_MM), limit_mm.is_some());
                BadPacking::TooHigh { limit_mm: limit, is_given, bound_mm: bound as f64 / UNITS }
            }
            other => BadPacking::Method { method: self.name.to_owned(), why: other.to_string() },
        }
    }
}

pub(super) fn named<T: Copy>(
    name: &'static str,
    given: &str,
    known: &[(&'static str, T)],
) -> Result<(T, &'static str), BadSetting> {
    let found = known.iter().find(|(known, _)| *known == given).map(|&(known, it)| (it, known));
    let near = || nearest(given, known.iter().map(|(known, _)| *known)).map_or("", |(_, near)| near).to_owned();
    found.ok_or_else(|| BadSetting::Method { name, given: given.to_owned(), nearest: near() })
}

/// The models with their counts.
fn loaded(models: &[(ModelSource, usize)], world: &World<'_>) -> Result<Vec<(LoadedModel, usize)>, PackError> {
    for (model, count) in models {
        counted(&model.source.name(), *count as f64)?;
    }
    let pieces = models.iter().map(|(_, count)| count).sum();
    if pieces > MOST_PIECES {
        return Err(BadPacking::TooMany { pieces }.into());
    }
    models.iter().map(|(model, count)| Ok((load_unposed(model, world)?, *count))).collect()
}

fn counted(name: &str, count: f64) -> Result<usize, BadPacking> {
    let whole = count.fract() == 0.0 && (1.0..=MOST_PIECES as f64).contains(&count);
    if whole { Ok(count as usize) } else { Err(BadPacking::Count { name: name.to_owned(), count }) }
}

fn solids(models: &[(LoadedModel, usize)], asked: &Asked<'_>) -> Result<Vec<PackSolid>, BadPacking> {
    let mut solids: Vec<PackSolid> = models
        .iter()
        .map(|(loaded, count)| {
            let parts = loaded.model.parts.iter().map(|part| &part.mesh);
            let mut solid = PackSolid::of(parts.clone(), 0.0, *count);
            solid.value = solid.volume_mm3;
            if loaded.model.warnings.iter().any(|text| is_overlap(text)) {
                // Where parts overlap, no more than the largest is sure to be there.
                solid.volume_mm3 = parts.map(|mesh| mesh.volume()).fold(0.0, f64::max);
            }
            solid
        })
        .collect();
    let volumes: Vec<f64> = solids.iter().map(|solid| solid.value).collect();
    let values = asked.values(&volumes, &[])?;
    solids.iter_mut().zip(values).for_each(|(solid, value)| solid.value = value);
    Ok(solids)
}

fn in_space(
    models: &[(LoadedModel, usize)],
    space: &PackSpace,
    asked: &Asked<'_>,
    stop: &dyn Fn() -> bool,
    limit: &Limit<'_>,
    world: &World<'_>,
) -> Result<PackResult, PackError> {
    let solids = solids(models, asked)?;
    let gap_mm = asked.options.gap_mm.unwrap_or(GAP_MM);
    // One on the other, each as high as it may be turned.
    let highest = |solid: &PackSolid| {
        let size = solid.bounds(&crate::geom::Mat3::identity()).size();
        // Each in whole units.
        let high = ((if asked.turns == Turns::Any { size.norm() } else { size.z } + gap_mm) * UNITS).ceil() + 1.0;
        high / UNITS * solid.copies as f64
    };
    let goal = asked.goal;
    let inflated = asked.options.inflate_mm.map(|mm| Inflated::of(models, &solids, mm));
    let sought = inflated.as_ref().map_or(&solids, |inflated| &inflated.solids);
    let space_mm = space.up_to(sought.iter().map(highest).sum());
    let room = Room { space_mm, gap_mm, turns: asked.turns, liftable: asked.options.no_interlock };
    let mut shown = |put: &[_]| limit.rehearse(&solids, &room, put);
    let packed = asked.watched(stop, limit, world, &mut shown, |watch| {
        pack_models(sought, &room, goal, asked.method, asked.shapes, asked.options.seed, watch)
    });
    let no_fit = |model: usize| {
        let fits = |solid: &PackSolid| packing_fits(solid, &room);
        match inflated.is_some() && fits(&solids[model]) {
            true => Inflated::too_large(&models[model].0.file),
            false => match no_fit(models, &solids, model, &room) {
                BadPacking::NoFit { name, size, turn, up, proved, .. } => {
                    BadPacking::NoFit { name, size, space: space.lengths_mm(), turn, up, proved }
                }
                other => other,
            },
        }
    };
    let packed = packed.map_err(|why| {
        // Of the models, not of what was packed for them.
        let low = || not_low(packing_bound(&solids, &room, goal));
        let why = if matches!(why, Unpackable::NotLow(_)) { low() } else { why };
        asked.unpackable(why, space.height_mm, no_fit)
    })?;
    let packed = match &inflated {
        Some(inflated) => inflated.of_models(packed, &solids, &room, goal),
        None => packed,
    };
    let done = proved(models, &solids, &room, packed, asked, limit)?;
    Ok(PackResult { inflated: inflated.map(|inflated| inflated.tally), ..done })
}

/// Whether a model goes into a space in one of its turns.
fn packing_fits(solid: &PackSolid, room: &Room) -> bool {
    let within = |size: crate::geom::Vec3| (0..3).all(|k| size[k] <= room.space_mm[k]);
    solid.turns(room.turns).iter().any(|turn| within(solid.bounds(turn).size()))
}

fn no_fit(models: &[(LoadedModel, usize)], solids: &[PackSolid], model: usize, room: &Room) -> BadPacking {
    let size = solids[model].bounds(&crate::geom::Mat3::identity()).size().into();
    let proved = solids[model].askew(room) == Askew::Never;
    let (name, space) = (models[model].0.file.clone(), room.space_mm);
    BadPacking::NoFit { name, size, space, turn: room.turns, up: [true; 3], proved }
}

/// The packing as a result, once the independent test has passed it.
fn proved(
    models: &[(LoadedModel, usize)],
    solids: &[PackSolid],
    room: &Room,
    packed: Packed,
    asked: &Asked<'_>,
    limit: &Limit<'_>,
) -> Result<PackResult, PackError> {
    let (proof, testing) = limit.proved(solids, room, &packed.put);
    let (clearance, lifts) = proof?;
    if room.liftable && lifts.iter().any(|lift| !lift.locked.is_empty()) {
        return Err(BadPacking::Unproved("the pieces interlock".to_owned()).into());
    }
    let done = result::of_models(models, solids, room, &packed, lifts, clearance, asked);
    Ok(PackResult { testing_s: testing.as_secs_f64(), ..done })
}
