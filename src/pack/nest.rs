//! Models into runs by their cells: one after the other into the first place from below that is free, of all turns the one that the rule
//! likes best; again and again in other orders and by other rules, the best packing kept.

use super::grid::{Grid, MOST_X, Rows};
use super::instance::PackGoal;
use super::solid::{PackSolid, Put, Room};
use super::voxels::{Span, voxels};
use super::watch::Watch;
use crate::geom::{Mat3, SplitMix64, Vec3};

/// Cells of a run, at most.
const MOST_CELLS: f64 = 1.6e7;
/// Cells of all shapes together, at most.
const MOST_SHAPE_CELLS: f64 = 4e7;
/// Orders tried after which nothing better counts as the end; each takes as long as packing everything once.
const MOST_TRIES: usize = 400;

/// A model turned one way, as cells.
struct Shape {
    turn: Mat3,
    /// The low corner of its box, as turned, mm.
    low: Vec3,
    rows: Rows,
    /// Its cells and those within the gap.
    grown: Vec<Span>,
}

/// Which of the places that a piece may have is taken: the least of these sums of its low and high cell along z, y and x.
#[derive(Clone, Copy)]
struct Rule([i64; 6]);

/// Low first, top first, middle first; then along y and x alike.
const RULES: [Rule; 5] = [
    Rule([0, 1 << 20, 0, 1 << 10, 0, 1]),
    Rule([1 << 20, 0, 1 << 10, 0, 1, 0]),
    Rule([1 << 20, 1 << 20, 1 << 10, 1 << 10, 1, 1]),
    Rule([3 << 20, 1 << 20, 0, 1 << 10, 0, 1]),
    Rule([1 << 20, 3 << 20, 0, 1 << 10, 0, 1]),
];

/// The shapes of all models, made once.
pub(super) struct Nest<'a> {
    solids: &'a [PackSolid],
    room: &'a Room,
    step: f64,
    size: [i32; 3],
    shapes: Vec<Vec<Shape>>,
}

/// A packing and what it is worth: fewer runs, then less in the last one; or more value; or less volume left out, then a lower top.
#[derive(Clone)]
struct Found {
    put: Vec<Put>,
    worth: [f64; 2],
}

impl<'a> Nest<'a> {
    /// Of models that fit; `None` where the space is too long for the grid, a cell would be too coarse to say anything, or the watch ended.
    pub(super) fn of(solids: &'a [PackSolid], room: &'a Room, watch: &mut Watch<'_>) -> Option<Self> {
        let turns: Vec<Vec<Mat3>> = solids.iter().map(|solid| solid.turns(room.turns)).collect();
        let step = step_mm(solids, room, &turns);
        let size = room.space_mm.map(|length| (length / step + 1e-7).floor() as i32);
        if size.iter().any(|&s| s < 1) || size[0] as usize > MOST_X {
            return None;
        }
        let shape = |solid: &PackSolid, turn: &Mat3| {
            let facets = solid.turned(turn);
            let cells = voxels(&facets, step);
            let low = solid.bounds(turn).min;
            Shape { turn: *turn, low, rows: Rows::of(&cells), grown: cells.grown(room.gap_mm / step) }
        };
        let fits = |shape: &Shape| (0..3).all(|k| shape.rows.size()[k] <= size[k]);
        let mut shapes: Vec<Vec<Shape>> = Vec::new();
        for (solid, turns) in solids.iter().zip(&turns) {
            let mut made = Vec::new();
            for turn in turns {
                if !watch.goes_on() {
                    return None;
                }
                made.extend(Some(shape(solid, turn)).filter(fits));
            }
            shapes.push(made);
        }
        Some(Self { solids, room, step, size, shapes })
    }

    /// The best packing that is found; `None` where some model fits in no turn as cells.
    pub(super) fn pack(&self, goal: PackGoal, bound: f64, seed: u64, watch: &mut Watch<'_>) -> Option<Vec<Put>> {
        if goal != PackGoal::Filling && self.shapes.iter().any(Vec::is_empty) {
            return None;
        }
        let mut numbers = SplitMix64::seeded(seed);
        let mut best: Option<Found> = None;
        let (mut size, mut lowest) = (self.size, f64::INFINITY);
        for attempt in 0..MOST_TRIES {
            let order = self.order(goal, attempt, &mut numbers);
            let rule = RULES[attempt % RULES.len()];
            // All turns at first; later each with even odds, so that models come to lie in few ways that fit each other.
            let allowed: Vec<Vec<bool>> = self
                .shapes
                .iter()
                .map(|all| {
                    let odds = if attempt < RULES.len() { 1.0 } else { [0.15, 0.3, 0.5, 1.0][numbers.below(4)] };
                    let one = numbers.below(all.len());
                    (0..all.len()).map(|i| i == one || numbers.unit() < odds).collect()
                })
                .collect();
            let found = self.attempt(goal, order, rule, &allowed, size, watch);
            if let Some(found) = found.filter(|f| best.as_ref().is_none_or(|b| f.worth > b.worth)) {
                lowest = if goal == PackGoal::Height { top_mm(self.solids, &found.put) } else { lowest };
                watch.show(&found.put);
                best = Some(found);
            }
            let met = best.as_ref().is_some_and(|b| match goal {
                PackGoal::Runs => -b.worth[0] <= bound,
                PackGoal::Filling => b.worth[0] >= bound * (1.0 - 1e-8),
                PackGoal::Height => b.worth[0] == 0.0 && lowest <= bound * (1.0 + 1e-9),
            });
            if let Some(best) = best.as_ref().filter(|b| goal == PackGoal::Height && b.worth[0] == 0.0) {
                // From now on only what is lower.
                size[2] = (-best.worth[1]) as i32 - 1;
            }
            if met || !watch.goes_on() {
                break;
            }
        }
        best.filter(|found| goal != PackGoal::Height || found.worth[0] == 0.0).map(|found| found.put)
    }

    /// All copies by falling volume or value; later somewhat shuffled.
    fn order(&self, goal: PackGoal, attempt: usize, numbers: &mut SplitMix64) -> Vec<(usize, usize)> {
        let spread = if attempt < RULES.len() { 0.0 } else { [0.0, 0.3, 1.0][numbers.below(3)] };
        let mut keyed: Vec<(f64, (usize, usize))> = Vec::new();
        for (model, solid) in self.solids.iter().enumerate() {
            let own = match goal {
                PackGoal::Height if attempt.is_multiple_of(2) => solid.bounds(&Mat3::identity()).size().max().powi(3),
                PackGoal::Runs | PackGoal::Height => solid.volume_mm3,
                PackGoal::Filling if attempt.is_multiple_of(2) => solid.value / solid.volume_mm3,
                PackGoal::Filling => solid.value,
            };
            for copy in 0..solid.copies {
                keyed.push((own.max(1e-12).ln() + spread * (2.0 * numbers.unit() - 1.0), (model, copy)));
            }
        }
        keyed.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        keyed.into_iter().map(|(_, piece)| piece).collect()
    }

    /// One packing; `None` where the watch ended on the way.
    fn attempt(
        &self,
        goal: PackGoal,
        mut order: Vec<(usize, usize)>,
        rule: Rule,
        allowed: &[Vec<bool>],
        size: [i32; 3],
        watch: &mut Watch<'_>,
    ) -> Option<Found> {
        let (mut put, mut missing, mut top) = (Vec::new(), 0.0, 0);
        for run in 0.. {
            let before = put.len();
            let mut grid = Grid::free(size);
            let mut from: Vec<Vec<[i32; 2]>> = self.shapes.iter().map(|all| vec![[0, 0]; all.len()]).collect();
            // What has no place any more has none for any copy.
            let mut full = vec![false; self.solids.len()];
            let mut left = Vec::new();
            for (model, copy) in order {
                let place = if full[model] {
                    None
                } else {
                    self.place(&grid, model, &allowed[model], &mut from[model], rule, watch)?
                };
                let Some((shape, at)) = place else {
                    full[model] = true;
                    left.push((model, copy));
                    continue;
                };
                let shape = &self.shapes[model][shape];
                grid.take(&shape.grown, at, self.room.liftable);
                top = top.max(at[2] + shape.rows.size()[2]);
                let corner = Vec3::from(at.map(f64::from)) * self.step;
                put.push(Put { run, model, copy, turn: shape.turn, shift: corner - shape.low });
            }
            if left.is_empty() || goal != PackGoal::Runs {
                missing = left.iter().map(|(model, _): &(usize, usize)| self.solids[*model].volume_mm3).sum();
                break;
            }
            if put.len() == before {
                return None;
            }
            order = left;
        }
        let worth = match goal {
            PackGoal::Height => [-missing, -f64::from(top)],
            PackGoal::Filling => [put.iter().map(|p| self.solids[p.model].value).sum(), 0.0],
            PackGoal::Runs => {
                let last = put.iter().map(|p| p.run).max().unwrap_or(0);
                let in_last = put.iter().filter(|p| p.run == last).map(|p| self.solids[p.model].volume_mm3);
                [-(last as f64 + 1.0), -in_last.sum::<f64>()]
            }
        };
        Some(Found { put, worth })
    }

    /// The place that the rule likes best; `None` for the outer where the watch ended, for the inner where there is no place.
    fn place(
        &self,
        grid: &Grid,
        model: usize,
        allowed: &[bool],
        from: &mut [[i32; 2]],
        rule: Rule,
        watch: &mut Watch<'_>,
    ) -> Option<Option<(usize, [i32; 3])>> {
        let mut best: Option<(i64, usize, [i32; 3])> = None;
        for (index, shape) in self.shapes[model].iter().enumerate().filter(|(index, _)| allowed[*index]) {
            let mut tried = 0;
            let at = grid.first(&shape.rows, &mut from[index], &mut tried);
            if !watch.spend(tried) {
                return None;
            }
            let Some(at) = at else { continue };
            let size = shape.rows.size();
            let sums = [at[2], at[2] + size[2], at[1], at[1] + size[1], at[0], at[0] + size[0]];
            let score = sums.iter().zip(rule.0).map(|(&cell, weight)| i64::from(cell) * weight).sum();
            if best.is_none_or(|(least, ..)| score < least) {
                best = Some((score, index, at));
            }
        }
        Some(best.map(|(_, index, at)| (index, at)))
    }
}

/// How high the highest of `put` reaches, mm; 0 for none.
pub(super) fn top_mm(solids: &[PackSolid], put: &[Put]) -> f64 {
    let tops = put.iter().map(|p| solids[p.model].bounds(&p.turn).max.z + p.shift.z);
    tops.fold(0.0, f64::max)
}

/// The edge of a cell: the gap, halved as long as run and shapes stay small, or more where they would not.
fn step_mm(solids: &[PackSolid], room: &Room, turns: &[Vec<Mat3>]) -> f64 {
    let [x, y, z] = room.space_mm;
    let least = (x * y * z / MOST_CELLS).cbrt().max(x / MOST_X as f64);
    let box_mm3 = |solid: &PackSolid| solid.bounds(&Mat3::identity()).size().product();
    let shapes: f64 = solids.iter().zip(turns).map(|(solid, turns)| box_mm3(solid) * turns.len() as f64).sum();
    let least = least.max((shapes / MOST_SHAPE_CELLS).cbrt());
    let whole = (room.gap_mm / least).floor();
    // A whole number of cells in the gap wastes none of it.
    if whole >= 1.0 { room.gap_mm / whole.min(4.0) } else { least }
}
