//! Models or boxes packed into runs of a space, or side by side on a machine's table.

mod boxes;
mod error;
mod plates;
mod result;
mod table;

use std::time::Duration;

use crate::input::load_unposed;
use crate::input::{BadSetting, LoadedModel, MachineSource, ModelSource, Source, load_profile};
use crate::mesh::is_overlap;
use crate::pack::{
    Askew, Clash, Ended, Method, PackFault, PackGoal, PackSolid, Packed, Room, Turns, Unpackable, Watch, apart, lift,
    pack_models,
};
use crate::spelling::nearest;
use crate::world::World;
pub use error::PackError;
pub use plates::Plates;
pub use result::{PackResult, Piece, Plate};

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
    /// The space of each run, mm.
    Space([f64; 3]),
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
    /// The most value in one run instead of the least number of runs: `volume`, `file` (the boxes' own values), or a value for each model
    /// or line with commas between them.
    pub fill: Option<String>,
    /// The method, by name.
    pub method: String,
    /// When to end, s; `None`: after a number of steps that is the same on every machine.
    pub seconds: Option<f64>,
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
            fill: None,
            method: "auto".to_owned(),
            seconds: None,
            no_interlock: false,
            seed: 1,
        }
    }
}

/// Why something cannot be packed.
#[derive(Clone, Debug, PartialEq, thiserror::Error, strum::IntoStaticStr)]
#[strum(serialize_all = "kebab-case", prefix = "pack/")]
pub enum BadPacking {
    /// A count of zero, or one that is too large.
    #[error("{name}: the count must be between 1 and {MOST_PIECES}, got {count}; MODEL*3 means three copies")]
    Count {
        /// The model or line.
        name: String,
        /// As given.
        count: f64,
    },
    /// Too many pieces together.
    #[error("{pieces} pieces are too many; at most {MOST_PIECES} are packed together")]
    TooMany {
        /// How many.
        pieces: usize,
    },
    /// A model or box that does not fit.
    #[error(
        "{name}: {} mm {} in the space of {} mm {}; enlarge the space{}, or cut it (trunnion split)",
        sizes(size), if *proved { "does not fit" } else { "was not found to fit" }, sizes(space), turned(*turn),
        if *turn == Turns::Any { "" } else { ", allow any rotation (--turn any)" }
    )]
    NoFit {
        /// The model or line.
        name: String,
        /// Its size, mm.
        size: [f64; 3],
        /// The space, mm.
        space: [f64; 3],
        /// How it may be turned.
        turn: Turns,
        /// Whether that is sure: turned in every way, it may not be settled.
        proved: bool,
    },
    /// A line that is not a box.
    #[error(
        "{name}, line {line}: {text:?} must be width, depth and height (0.001 to 1000000 mm, three decimals at most), then count and value (above \
         0); for example 20 30 15.5 4 1.5"
    )]
    Line {
        /// The file.
        name: String,
        /// The line, from 1.
        line: usize,
        /// What it says.
        text: String,
    },
    /// A number with a comma in it, where others are parted by blanks.
    #[error("{name}, line {line}: {text:?} may be one number or two; write {} for one, or a space after the comma for two", text.replace(',', "."))]
    Comma {
        /// The file.
        name: String,
        /// The line, from 1.
        line: usize,
        /// The word.
        text: String,
    },
    /// A file without boxes.
    #[error("{0} has no boxes; write one box per line: width, depth and height in mm, for example 20 30 15")]
    NoBoxes(String),
    /// Values that do not go with the models.
    #[error(
        "fill {given}: must be `volume`, `file`, or {wanted} numbers above 0 with commas between them, one for each model or line"
    )]
    Values {
        /// As given.
        given: String,
        /// How many there should be.
        wanted: usize,
    },
    /// A method that does not apply.
    #[error("method {method}: {why}")]
    Method {
        /// The method.
        method: String,
        /// Why not.
        why: String,
    },
    /// Boxes for a machine's table.
    #[error("{0}: boxes cannot be packed on a machine's table; use --space X,Y,Z instead of -m")]
    BoxesOnTable(String),
    /// An invalid packing: a fault of this program, never a result.
    #[error("the packing found is not valid ({0}); nothing was written; please report this")]
    Unproved(String),
}

/// Pieces, at most.
pub const MOST_PIECES: usize = 5000;
/// Between models where nothing is said, mm.
const GAP_MM: f64 = 1.0;
/// The least and the most between models, mm.
const GAPS_MM: [f64; 2] = [0.01, 500.0];
/// Steps where no time is given: some ten seconds.
const STEPS: u64 = 10_000_000;

fn sizes(size: &[f64; 3]) -> String {
    size.map(|length| format!("{}", (length * 1000.0).round() / 1000.0)).join(" x ")
}

fn turned(turn: Turns) -> &'static str {
    match turn {
        Turns::None => "as it is",
        Turns::Z90 => "at any quarter turn about Z",
        Turns::Z => "at any angle about Z",
        Turns::Any => "in any orientation",
    }
}

/// Packs models or boxes. `stop` is asked now and then whether to end with the best so far.
///
/// # Errors
///
/// [`InputError::Setting`](crate::input::InputError::Setting) and [`PackError::Packing`] for what cannot be packed so; what reading
/// models, boxes and machine may say.
pub fn pack(request: &PackRequest, stop: &dyn Fn() -> bool, world: &World<'_>) -> Result<PackResult, PackError> {
    let asked = Asked::of(request)?;
    let start = world.clock.now();
    let mut done = match (&request.contents, &request.into) {
        (Contents::Boxes(source), Into::Space(space)) => boxes::packed(source, *space, &asked, stop, world)?,
        (Contents::Boxes(source), Into::Table(_)) => {
            return Err(BadPacking::BoxesOnTable(source.name().into_owned()).into());
        }
        (Contents::Models(models), Into::Space(space)) => {
            in_space(&loaded(models, world)?, *space, &asked, stop, world)?
        }
        (Contents::Models(models), Into::Table(machine)) => {
            let machine = load_profile(machine, world)?;
            table::packed(&loaded(models, world)?, &machine, &asked, stop, world)?
        }
    };
    done.seconds = (world.clock.now() - start).as_secs_f64();
    Ok(done)
}

/// The options, checked.
struct Asked<'a> {
    options: &'a PackOptions,
    turns: Turns,
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
        if let Into::Space(space) = request.into {
            for length in space {
                BadSetting::within("space", length, " mm", [0.1, 1e5])?;
            }
        }
        let turns = named("turn", &options.turn, &Turns::NAMED)?.0;
        let (method, name) = named("method", &options.method, &Method::NAMED)?;
        Ok(Self { options, turns, method, shapes: method == Method::Auto && !boxes, name })
    }

    fn goal(&self) -> PackGoal {
        if self.options.fill.is_some() { PackGoal::Filling } else { PackGoal::Runs }
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
    fn watched<T>(&self, stop: &dyn Fn() -> bool, world: &World<'_>, search: impl FnOnce(&mut Watch<'_>) -> T) -> T {
        let bar = world.progress.begin("packing", 100);
        let start = world.clock.now();
        let limit = self.options.seconds.map(Duration::from_secs_f64);
        let mut ask = |share: f64| {
            let spent = world.clock.now() - start;
            let share = limit.map_or(share, |limit| spent.as_secs_f64() / limit.as_secs_f64());
            bar.at((100.0 * share.min(1.0)) as usize);
            if stop() {
                return Some(Ended::Interrupted);
            }
            limit.filter(|limit| spent >= *limit).map(|_| Ended::Time)
        };
        let steps = if limit.is_some() { u64::MAX } else { STEPS };
        search(&mut Watch::new(steps, &mut ask))
    }

    fn unpackable(&self, why: Unpackable, no_fit: impl Fn(usize) -> BadPacking) -> BadPacking {
        match why {
            Unpackable::TooLarge(index) => no_fit(index),
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
    space_mm: [f64; 3],
    asked: &Asked<'_>,
    stop: &dyn Fn() -> bool,
    world: &World<'_>,
) -> Result<PackResult, PackError> {
    let solids = solids(models, asked)?;
    let gap_mm = asked.options.gap_mm.unwrap_or(GAP_MM);
    let room = Room { space_mm, gap_mm, turns: asked.turns, liftable: asked.options.no_interlock };
    let goal = asked.goal();
    let packed = asked.watched(stop, world, |watch| {
        pack_models(&solids, &room, goal, asked.method, asked.shapes, asked.options.seed, watch)
    });
    let no_fit = |model: usize| no_fit(models, &solids, model, &room);
    let packed = packed.map_err(|why| asked.unpackable(why, no_fit))?;
    proved(models, &solids, &room, packed, asked)
}

fn no_fit(models: &[(LoadedModel, usize)], solids: &[PackSolid], model: usize, room: &Room) -> BadPacking {
    let size = solids[model].bounds(&crate::geom::Mat3::identity()).size().into();
    let proved = solids[model].askew(room) == Askew::Never;
    BadPacking::NoFit { name: models[model].0.file.clone(), size, space: room.space_mm, turn: room.turns, proved }
}

/// The packing as a result, once the independent test has passed it.
fn proved(
    models: &[(LoadedModel, usize)],
    solids: &[PackSolid],
    room: &Room,
    packed: Packed,
    asked: &Asked<'_>,
) -> Result<PackResult, PackError> {
    let clearance = apart(solids, room, &packed.put).map_err(|clash: Clash| BadPacking::Unproved(clash.to_string()))?;
    let lifts = lift(solids, room, &packed.put);
    if room.liftable && lifts.iter().any(|lift| !lift.locked.is_empty()) {
        return Err(BadPacking::Unproved("the pieces interlock".to_owned()).into());
    }
    Ok(result::of_models(models, solids, room, &packed, lifts, clearance, asked))
}

impl From<PackFault> for BadPacking {
    fn from(fault: PackFault) -> Self {
        Self::Unproved(fault.to_string())
    }
}
