//! Models packed: by their boxes first, then, where that can gain something, by their cells.

use super::anneal::annealed;
use super::askew::Askew;
use super::bound::most_value;
use super::composite::by_coverings;
use super::instance::{BoxPacking, Ended, Instance, Item, PackGoal, Triple, Turns};
use super::method::{Method, Unpackable, pack};
use super::nest::{Nest, top_mm};
use super::solid::{PackSolid, Put, Room, cube_turns};
use super::watch::Watch;
use crate::geom::{Mat3, Vec3};

/// Units of a box's lengths in a millimetre.
const UNITS: f64 = 1000.0;
/// What lengths may be off by, units: a hundredth of a micrometre is no reason to round up a whole one.
const OFF: f64 = 1e-3;

/// A packing of models.
#[derive(Clone, Debug, PartialEq)]
pub struct Packed {
    /// The pieces, by run, model and copy.
    pub put: Vec<Put>,
    /// Runs.
    pub runs: usize,
    /// [`PackGoal::Runs`]: no packing has fewer runs. [`PackGoal::Filling`]: none has more value. [`PackGoal::Height`]: none is lower, mm.
    pub bound: f64,
    /// Why the search ended.
    pub ended: Ended,
    /// How many runs the models' boxes take ([`PackGoal::Runs`]), which value one holds of them, or how high it is, mm (0 where they are not
    /// within the limit).
    pub boxes: f64,
}

/// Packs models. `shapes`: whether their cells are looked at, beyond their boxes.
///
/// # Errors
///
/// [`Unpackable`]; its number is the model's.
pub fn pack_models(
    solids: &[PackSolid],
    room: &Room,
    goal: PackGoal,
    method: Method,
    shapes: bool,
    seed: u64,
    watch: &mut Watch<'_>,
) -> Result<Packed, Unpackable> {
    if method == Method::Anneal && goal != PackGoal::Filling {
        return Err(Unpackable::OnlyFilling);
    }
    let bound = packing_bound(solids, room, goal);
    let boxed = Boxed::of(solids, room);
    if watch.is_showing() {
        // As short as can be: somebody wants to see what a packing is like before most of the time is spent.
        let mut asked = |_| Some(Ended::Steps);
        if let Ok(first) = pack(&boxed.instance, goal, Method::Auto, seed, &mut Watch::new(1, &mut asked)) {
            let put: Vec<Put> = first.placed.iter().map(|p| boxed.put(solids, p.run, p.item, p.at, p.size)).collect();
            watch.show(&put);
        }
    }
    let by_boxes = {
        // Half of all steps at most where cells come afterwards.
        let mut asked = |_| (!watch.spend(2000)).then(|| watch.ended());
        let steps = if shapes || method.of_shapes() { BOX_STEPS } else { u64::MAX };
        let mut own = Watch::new(steps, &mut asked);
        pack(&boxed.instance, goal, if method.of_shapes() { Method::Auto } else { method }, seed, &mut own)
    };
    let by_boxes = by_boxes.map_err(|why| match why {
        Unpackable::TooLarge(item) => Unpackable::TooLarge(boxed.pieces[item].0),
        Unpackable::NotLow(_) => not_low(bound),
        other => other,
    });
    let more = shapes || method.of_shapes();
    let answer = match by_boxes {
        // What does not lie low enough as boxes may by its shapes.
        Err(Unpackable::NotLow(_)) if more => BoxPacking::of(Vec::new(), bound, watch.ended()),
        other => other?,
    };
    let put: Vec<Put> = answer.placed.iter().map(|p| boxed.put(solids, p.run, p.item, p.at, p.size)).collect();
    let boxes = match goal {
        PackGoal::Runs => answer.runs as f64,
        PackGoal::Filling => value(solids, &put),
        PackGoal::Height => top_mm(solids, &put),
    };
    let met = |put: &[Put], runs: usize| match goal {
        PackGoal::Runs => runs as f64 <= bound,
        PackGoal::Filling => value(solids, put) >= bound * (1.0 - 1e-8),
        PackGoal::Height => !put.is_empty() && top_mm(solids, put) <= bound * (1.0 + 1e-9),
    };
    // Of the boxes' own bound nothing is known of the models in them.
    let ended = if answer.ended == Ended::Proved { Ended::Steps } else { answer.ended };
    let mut best = Packed { runs: answer.runs, put, bound, ended, boxes };
    if more && !met(&best.put, best.runs) && watch.goes_on() {
        if let Some(nested) = by_shapes(solids, room, goal, method, &best, seed, watch)
            && better(solids, goal, &nested, &best.put)
        {
            best.runs = nested.iter().map(|p| p.run + 1).max().unwrap_or(0);
            best.put = nested;
        }
        best.ended = watch.ended();
    }
    if goal == PackGoal::Height && best.put.is_empty() && !boxed.pieces.is_empty() {
        return Err(not_low(bound));
    }
    if met(&best.put, best.runs) {
        best.ended = Ended::Proved;
    }
    best.put.sort_by_key(|p| (p.run, p.model, p.copy));
    Ok(best)
}

fn value(solids: &[PackSolid], put: &[Put]) -> f64 {
    put.iter().map(|p| solids[p.model].value).sum()
}

/// Whether `new` is better than `known`.
fn better(solids: &[PackSolid], goal: PackGoal, new: &[Put], known: &[Put]) -> bool {
    let runs = |put: &[Put]| put.iter().map(|p| p.run + 1).max().unwrap_or(0);
    match goal {
        PackGoal::Runs => runs(new) < runs(known),
        PackGoal::Filling => value(solids, new) > value(solids, known),
        PackGoal::Height => known.is_empty() || top_mm(solids, new) < top_mm(solids, known),
    }
}

/// A packing by the models' shapes.
fn by_shapes(
    solids: &[PackSolid],
    room: &Room,
    goal: PackGoal,
    method: Method,
    boxed: &Packed,
    seed: u64,
    watch: &mut Watch<'_>,
) -> Option<Vec<Put>> {
    let [wide, deep, limit] = room.space_mm;
    // What is no lower than the boxes is of no use, and cells are the finer the lower the space is.
    let high = if goal == PackGoal::Height && !boxed.put.is_empty() { boxed.boxes } else { limit };
    let room = Room { space_mm: [wide, deep, high], ..*room };
    match method {
        Method::Coverings => by_coverings(solids, &room, goal, seed, watch),
        Method::Anneal => Some(annealed(solids, &room, &boxed.put, seed, watch)),
        _ => Nest::of(solids, &room, watch).and_then(|nest| nest.pack(goal, boxed.bound, seed, watch)),
    }
}

/// Steps for boxes where cells are looked at afterwards.
const BOX_STEPS: u64 = 2_000_000;

/// That nothing was found so low, where no packing is lower than a bound, mm, which has rounding in its last digits.
pub fn not_low(bound_mm: f64) -> Unpackable {
    Unpackable::NotLow(((bound_mm - 1e-6) * UNITS).ceil() as i64)
}

/// What no packing of the models themselves can beat (see [`Packed::bound`]): each grown by half the gap still lies within the space grown so, and they do not overlap
/// then. A body's grown volume is at least a ball's of its volume (Brunn and Minkowski).
pub fn packing_bound(solids: &[PackSolid], room: &Room, goal: PackGoal) -> f64 {
    use std::f64::consts::PI;
    let r = room.gap_mm / 2.0;
    let [a, b, c] = room.space_mm;
    let space = a * b * c + 2.0 * r * (a * b + b * c + c * a) + PI * r * r * (a + b + c) + 4.0 / 3.0 * PI * r.powi(3);
    let around = 2.0 * r * (a + b) + PI * r * r;
    let ball = (4.0 / 3.0 * PI).cbrt();
    let grown = |solid: &PackSolid| (solid.volume_mm3.max(0.0).cbrt() + ball * r).powi(3);
    match goal {
        PackGoal::Runs => {
            let all: f64 = solids.iter().map(|solid| grown(solid) * solid.copies as f64).sum();
            (all / space * (1.0 - 1e-9)).ceil().max(f64::from(u8::from(!solids.is_empty())))
        }
        PackGoal::Height => {
            // The space grown by half the gap is linear in its height.
            let all: f64 = solids.iter().map(|solid| grown(solid) * solid.copies as f64).sum();
            let lying = 2.0 * r * a * b + PI * r * r * (a + b) + 4.0 / 3.0 * PI * r.powi(3);
            let by_volume = (all - lying) / (a * b + around) * (1.0 - 1e-9);
            solids.iter().map(|solid| least_height_mm(solid, room.turns)).fold(by_volume, f64::max)
        }
        PackGoal::Filling => {
            let unit = |solid: &PackSolid| ((grown(solid) / space * 1e6).floor() as i64).clamp(1, 1_000_000);
            let one = |solid: &PackSolid| Item { size: [unit(solid), 1, 1], value: solid.value, up: [true; 3] };
            let items = solids.iter().flat_map(|solid| std::iter::repeat_n(one(solid), solid.copies)).collect();
            most_value(&Instance { space: [1_000_000, 1, 1], gap: 0, turns: Turns::None, items })
        }
    }
}

/// What a model is not lower than however it may be turned, mm. In every way: its volume lies between two planes so far apart, over a shadow that is
/// no larger than a circle as wide as the model is long (the isodiametric inequality).
fn least_height_mm(solid: &PackSolid, turns: Turns) -> f64 {
    let size = solid.bounds(&Mat3::identity()).size();
    match turns {
        Turns::None | Turns::Z90 | Turns::Z => size.z,
        Turns::Any => solid.volume_mm3.max(0.0) / (std::f64::consts::PI / 4.0 * size.norm_squared()),
    }
}

/// The models as boxes of whole micrometres.
struct Boxed {
    instance: Instance,
    /// Model and copy of each item.
    pieces: Vec<(usize, usize)>,
    /// For each model its turns with the sizes of its box then.
    turns: Vec<Vec<(Mat3, Triple)>>,
}

impl Boxed {
    fn of(solids: &[PackSolid], room: &Room) -> Self {
        let up = |mm: f64| (mm * UNITS - OFF).ceil() as i64;
        let space = room.space_mm.map(|mm| (mm * UNITS + OFF).floor() as i64);
        // About Z only the snuggest angle and its quarter turns: a box turned askew is only a larger one.
        let turns: Vec<Vec<(Mat3, Triple)>> = solids
            .iter()
            .map(|solid| {
                let all = solid.turns(room.turns);
                let size = |turn: &Mat3| -> Triple { solid.bounds(turn).size().map(up).into() };
                let area = |t: &(Mat3, Triple)| t.1[0] as f64 * t.1[1] as f64;
                let sized: Vec<(Mat3, Triple)> = all.iter().map(|turn| (*turn, size(turn))).collect();
                let least = sized.iter().map(area).fold(f64::INFINITY, f64::min);
                let snug = |t: &&(Mat3, Triple)| room.turns != Turns::Z || area(t) <= least * (1.0 + 1e-6);
                let snug: Vec<(Mat3, Triple)> = sized.iter().filter(snug).copied().collect();
                let fits = |t: &(Mat3, Triple)| (0..3).all(|k| t.1[k] <= space[k]);
                if snug.iter().any(fits) {
                    return snug;
                }
                // The snuggest box does not go in; another one may.
                match solid.askew(room) {
                    Askew::Fits(turn) => {
                        let turns = cube_turns().into_iter().filter(|q| room.turns == Turns::Any || q[(2, 2)] == 1.0);
                        turns.map(|quarter| quarter * turn).map(|turn| (turn, size(&turn))).collect()
                    }
                    Askew::Never | Askew::Unknown => snug,
                }
            })
            .collect();
        let (mut items, mut pieces) = (Vec::new(), Vec::new());
        for (model, solid) in solids.iter().enumerate() {
            for copy in 0..solid.copies {
                items.push(Item { size: turns[model][0].1, value: solid.value, up: [true; 3] });
                pieces.push((model, copy));
            }
        }
        Self { instance: Instance { space, gap: up(room.gap_mm), turns: room.turns, items }, pieces, turns }
    }

    /// A box in its place as the model in it.
    fn put(&self, solids: &[PackSolid], run: usize, item: usize, at: Triple, size: Triple) -> Put {
        let (model, copy) = self.pieces[item];
        let turns = &self.turns[model];
        // Rounding may make sizes of one turn differ from those of another by a unit: the nearest is meant.
        let off = |t: &(Mat3, Triple)| (0..3).map(|k| (t.1[k] - size[k]).abs()).sum::<i64>();
        let turn = turns.iter().min_by_key(|t| off(t)).map_or_else(Mat3::identity, |t| t.0);
        let corner = Vec3::from(at.map(|units| units as f64 / UNITS));
        Put { run, model, copy, turn, shift: corner - solids[model].bounds(&turn).min }
    }
}
