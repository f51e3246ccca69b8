//! Models packed as the few boxes that cover them, at fixed places to each other (Leitereg (2020), section 2.3): each goes to the lowest place where one of
//! its boxes comes to a corner of those that lie there, sunk from there as far as it goes.

use super::covering::covering;
use super::instance::{PackGoal, Triple};
use super::solid::{PackSolid, Put, Room};
use super::watch::Watch;
use crate::geom::{Mat3, Vec3};

/// Units in a millimetre.
const UNITS: f64 = 1000.0;
/// Boxes that cover a model, at most.
const BOXES: usize = 4;

/// A model turned one way: its boxes from the low corner of the box around it, drawn out by the gap.
struct Shape {
    turn: Mat3,
    low: Vec3,
    size: Triple,
    boxes: Vec<(Triple, Triple)>,
}

/// All models in runs, or one run with what fits of them by falling value, or with all of them.
pub(super) fn by_coverings(
    solids: &[PackSolid],
    room: &Room,
    goal: PackGoal,
    seed: u64,
    watch: &mut Watch<'_>,
) -> Option<Vec<Put>> {
    let gap = (room.gap_mm * UNITS).ceil() as i64;
    let space = room.space_mm.map(|mm| (mm * UNITS + 1e-3).floor() as i64 + gap);
    let mut shapes: Vec<Vec<Shape>> = Vec::new();
    for solid in solids {
        let mut turned = Vec::new();
        for turn in solid.turns(room.turns) {
            if !watch.goes_on() {
                return None;
            }
            let shape = shape(solid, turn, gap, seed, watch)?;
            turned.extend((0..3).all(|k| shape.size[k] <= space[k]).then_some(shape));
        }
        shapes.push(turned);
    }
    let mut order: Vec<(usize, usize)> =
        (0..solids.len()).flat_map(|model| (0..solids[model].copies).map(move |copy| (model, copy))).collect();
    let key = |(model, _): &(usize, usize)| match goal {
        PackGoal::Runs | PackGoal::Height => solids[*model].volume_mm3,
        PackGoal::Filling => solids[*model].value / solids[*model].volume_mm3,
    };
    order.sort_by(|a, b| key(b).total_cmp(&key(a)).then(a.cmp(b)));
    let mut put = Vec::new();
    for run in 0.. {
        let (mut lying, mut left, mut full) = (Vec::new(), Vec::new(), vec![false; solids.len()]);
        let before = put.len();
        for (model, copy) in order {
            let place = if full[model] { None } else { best_place(&shapes[model], &lying, &space, watch) };
            if watch.ended_early() {
                return (goal == PackGoal::Filling).then_some(put);
            }
            let Some((index, at)) = place else {
                full[model] = true;
                left.push((model, copy));
                continue;
            };
            let shape = &shapes[model][index];
            lying.extend(shape.boxes.iter().map(|(from, size)| (plus(&at, from), *size)));
            let corner = Vec3::from(at.map(|units| units as f64 / UNITS));
            put.push(Put { run, model, copy, turn: shape.turn, shift: corner - shape.low });
        }
        if left.is_empty() || goal == PackGoal::Filling {
            break;
        }
        if put.len() == before || goal == PackGoal::Height {
            return None;
        }
        order = left;
    }
    Some(put)
}

fn shape(solid: &PackSolid, turn: Mat3, gap: i64, seed: u64, watch: &mut Watch<'_>) -> Option<Shape> {
    let facets = solid.turned(&turn);
    let bounds = solid.bounds(&turn);
    let up = |mm: f64| (mm * UNITS - 1e-3).ceil() as i64;
    let boxes = covering(&facets, BOXES, seed, watch)?.into_iter().map(|(at, size)| {
        let low: Triple = at.map(|mm| (mm * UNITS + 1e-3).floor() as i64).into();
        let high: Triple = (at + size).map(up).into();
        (low, [0, 1, 2].map(|k| high[k] - low[k] + gap))
    });
    let size: Triple = bounds.size().map(up).into();
    Some(Shape { turn, low: bounds.min, size: size.map(|s| s + gap), boxes: boxes.collect() })
}

fn plus(a: &Triple, b: &Triple) -> Triple {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

type Lying = [(Triple, Triple)];

/// The turn and place whose top is lowest, then the lowest, the nearest to the back and to the left.
fn best_place(shapes: &[Shape], lying: &Lying, space: &Triple, watch: &mut Watch<'_>) -> Option<(usize, Triple)> {
    let mut best: Option<([i64; 4], usize, Triple)> = None;
    for (index, shape) in shapes.iter().enumerate() {
        let mut try_at = |at: Triple| {
            let inside = (0..3).all(|k| at[k] >= 0 && at[k] + shape.size[k] <= space[k]);
            let key = [at[2] + shape.size[2], at[2], at[1], at[0]];
            if !inside || best.is_some_and(|(known, ..)| known <= key) || !free(shape, &at, lying) {
                return;
            }
            let at = sunk(shape, at, lying);
            let key = [at[2] + shape.size[2], at[2], at[1], at[0]];
            if best.is_none_or(|(known, ..)| key < known) {
                best = Some((key, index, at));
            }
        };
        try_at([0; 3]);
        for (low, size) in lying {
            for k in 0..3 {
                let mut corner = *low;
                corner[k] += size[k];
                for (from, _) in &shape.boxes {
                    try_at([0, 1, 2].map(|m| (corner[m] - from[m]).max(0)));
                }
            }
            if !watch.spend(shape.boxes.len() as u64) {
                return None;
            }
        }
    }
    best.map(|(_, index, at)| (index, at))
}

fn free(shape: &Shape, at: &Triple, lying: &Lying) -> bool {
    shape.boxes.iter().all(|(from, size)| {
        let low = plus(at, from);
        lying
            .iter()
            .all(|(other, theirs)| (0..3).any(|k| low[k] + size[k] <= other[k] || other[k] + theirs[k] <= low[k]))
    })
}

/// As far down, then back, then left as it goes.
fn sunk(shape: &Shape, mut at: Triple, lying: &Lying) -> Triple {
    for axis in [2, 1, 0] {
        let (a, b) = ((axis + 1) % 3, (axis + 2) % 3);
        let mut least = 0;
        for (from, size) in &shape.boxes {
            let low = plus(&at, from);
            let beside = |k: usize, other: &Triple, theirs: &Triple| {
                low[k] < other[k] + theirs[k] && other[k] < low[k] + size[k]
            };
            for (other, theirs) in lying {
                if beside(a, other, theirs) && beside(b, other, theirs) && other[axis] + theirs[axis] <= low[axis] {
                    least = least.max(other[axis] + theirs[axis] - from[axis]);
                }
            }
        }
        at[axis] = least.max(0).min(at[axis]);
    }
    at
}
