//! The integer program of Leitereg (2020), section 2.2, as printed: a place for each box, and for each pair of boxes six zero-one variables of which
//! one must be 0, "j lies to the right of i" and so on. `max c used`, or the least number of runs: then the runs stand beside each other along x.
//!
//! Given to the solver besides: the best packing that is known as a start, bounds, an order among equal boxes, and turns (a box's lengths
//! are sums over its turns). Lengths are shares of the space's. What comes back is not believed to the digit: of a solution only
//! "before" and "behind" are taken, and corners are worked out from these in whole numbers ([`Model::packing`]).

use std::time::Duration;

use microlp::{
    ComparisonOp, LinearExpr, OptimizationDirection, Problem, ResumeOptions, SolveOptions, SolveOutcome, Variable,
};

use super::check::check;
use super::instance::{Instance, Neighbourhood, PackGoal, Placed, Triple, height};
use super::watch::Watch;

/// Nodes of the solver's tree between two questions whether to go on.
const NODES: u64 = 10;
/// Time between two such questions.
const SLICE: Duration = Duration::from_millis(500);
/// What a node counts as, steps of a watch for each two boxes.
const STEPS_A_NODE: usize = 20;

/// What the solver says.
pub(super) struct Solved {
    /// The best packing, if it is better than the one it began with.
    pub(super) better: Option<Vec<Placed>>,
    /// The objective that nothing beats, in the model as it was limited.
    pub(super) bound: Option<f64>,
    /// Whether the search went through.
    pub(super) proved: bool,
}

/// The program of one instance (drawn out, every box fits).
struct Model<'a> {
    instance: &'a Instance,
    goal: PackGoal,
    sizes: Vec<Vec<Triple>>,
    /// Runs beside each other, in the model of the least number.
    runs: usize,
    problem: Problem,
    at: Vec<[Variable; 3]>,
    used: Vec<Variable>,
    run: Vec<Variable>,
    turn: Vec<Vec<Variable>>,
    /// By pair `i < j`: right, left, up, down, front, back.
    pairs: Vec<[Variable; 6]>,
    /// The number of runs, or the height as a share of the space's.
    top: Option<Variable>,
}

/// Looks for something better than `start`, near it or everywhere.
pub(super) fn solve(
    instance: &Instance,
    goal: PackGoal,
    start: &[Placed],
    bound: f64,
    near: Option<Neighbourhood>,
    watch: &mut Watch<'_>,
) -> Solved {
    let nothing = Solved { better: None, bound: None, proved: false };
    let runs = start.iter().map(|p| p.run + 1).max().unwrap_or(1);
    let mut model = Model::of(instance, goal, runs, bound);
    let values = model.values(start);
    if let Some(near) = near {
        model.keep_near(&values, near);
    }
    let mut options = SolveOptions::default();
    (options.time_limit, options.node_limit, options.warm_start) = (Some(SLICE), Some(NODES), Some(values));
    let mut resume = ResumeOptions::default();
    (resume.time_limit, resume.node_limit, resume.mip_gap) = (Some(SLICE), Some(NODES), None);
    let Ok(mut outcome) = model.problem.solve_with(options) else { return nothing };
    let steps_a_node = (STEPS_A_NODE * instance.items.len().pow(2)) as u64;
    let mut nodes = 0;
    while !outcome.is_optimal() {
        let now = outcome.stats().nodes_solved;
        if !watch.spend((now - nodes).max(1) * steps_a_node) || !watch.goes_on() {
            break;
        }
        nodes = now;
        outcome = match outcome.resume_with(resume.clone()) {
            Ok(more) => more,
            // Numbers that went astray in the solver: what is known stays.
            Err(_) => return nothing,
        };
    }
    model.read(&outcome, start)
}

impl<'a> Model<'a> {
    fn of(instance: &'a Instance, goal: PackGoal, runs: usize, bound: f64) -> Self {
        let direction = match goal {
            PackGoal::Runs | PackGoal::Height => OptimizationDirection::Minimize,
            PackGoal::Filling => OptimizationDirection::Maximize,
        };
        let mut problem = Problem::new(direction);
        let filling = goal == PackGoal::Filling;
        let sizes = instance.sizes();
        let most = instance.items.iter().map(|item| item.value).fold(f64::MIN_POSITIVE, f64::max);
        let at = sizes.iter().map(|_| [(); 3].map(|()| problem.add_var(0.0, (0.0, 1.0)))).collect();
        let used = instance
            .items
            .iter()
            .map(|item| {
                problem.add_integer_var(if filling { item.value / most } else { 0.0 }, (i32::from(!filling), 1))
            })
            .collect();
        let last = if filling { 0 } else { runs as i32 - 1 };
        let run = sizes.iter().map(|_| problem.add_integer_var(0.0, (0, last))).collect();
        let turn = sizes.iter().map(|t| t.iter().map(|_| problem.add_binary_var(0.0)).collect()).collect();
        let count = sizes.len() * sizes.len().saturating_sub(1) / 2;
        let pairs = (0..count).map(|_| [(); 6].map(|()| problem.add_binary_var(0.0))).collect();
        let top = match goal {
            PackGoal::Filling => None,
            PackGoal::Runs => Some(problem.add_var(1.0, (bound.max(1.0), runs as f64))),
            PackGoal::Height => Some(problem.add_var(1.0, (bound / instance.space[2] as f64, 1.0))),
        };
        let mut model = Self { instance, goal, sizes, runs, problem, at, used, run, turn, pairs, top };
        model.places();
        model.relations();
        model.symmetry();
        model
    }

    fn share(&self, length: i64, axis: usize) -> f64 {
        length as f64 / self.instance.space[axis] as f64
    }

    /// Each box turned one way and within the space.
    fn places(&mut self) {
        for i in 0..self.sizes.len() {
            let mut one = LinearExpr::empty();
            self.turn[i].iter().for_each(|&turn| one.add(turn, 1.0));
            self.problem.add_constraint(one, ComparisonOp::Eq, 1.0);
            for k in 0..3 {
                let mut inside = self.length(i, k);
                inside.add(self.at[i][k], 1.0);
                self.problem.add_constraint(inside, ComparisonOp::Le, 1.0);
            }
            if let Some(top) = self.top {
                let (mut below, least) = match self.goal {
                    PackGoal::Height => (self.length(i, 2), 0.0),
                    PackGoal::Runs | PackGoal::Filling => (LinearExpr::empty(), -1.0),
                };
                below.add(if self.goal == PackGoal::Height { self.at[i][2] } else { self.run[i] }, 1.0);
                below.add(top, -1.0);
                self.problem.add_constraint(below, ComparisonOp::Le, least);
            }
        }
    }

    /// The length of box `i` along an axis, a sum over its turns.
    fn length(&self, i: usize, axis: usize) -> LinearExpr {
        let mut length = LinearExpr::empty();
        for (turn, size) in self.turn[i].iter().zip(&self.sizes[i]) {
            length.add(*turn, self.share(size[axis], axis));
        }
        length
    }

    /// `a` before `b` along `axis`, unless `free` is 1.
    fn before(&mut self, a: usize, b: usize, axis: usize, free: Variable) {
        let mut all = self.length(a, axis);
        all.add(self.at[a][axis], 1.0);
        all.add(self.at[b][axis], -1.0);
        let mut most = 1.0;
        if axis == 0 && self.runs > 1 {
            all.add(self.run[a], 1.0);
            all.add(self.run[b], -1.0);
            most = self.runs as f64;
        }
        all.add(free, -most);
        self.problem.add_constraint(all, ComparisonOp::Le, 0.0);
    }

    fn relations(&mut self) {
        let mut pair = 0;
        for i in 0..self.sizes.len() {
            for j in i + 1..self.sizes.len() {
                let six = self.pairs[pair];
                for axis in 0..3 {
                    self.before(i, j, axis, six[2 * axis]);
                    self.before(j, i, axis, six[2 * axis + 1]);
                }
                let mut one = LinearExpr::empty();
                six.iter().for_each(|&direction| one.add(direction, 1.0));
                one.add(self.used[i], 1.0);
                one.add(self.used[j], 1.0);
                self.problem.add_constraint(one, ComparisonOp::Le, 7.0);
                pair += 1;
            }
        }
    }

    /// Of equal boxes the earlier one is used first, and lies not farther along x; no box lies in a later run than its number.
    fn symmetry(&mut self) {
        let equal = |a: usize, b: usize| self.instance.items[a] == self.instance.items[b];
        let count = self.sizes.len();
        let next: Vec<Option<usize>> = (0..count).map(|i| (i + 1..count).find(|&j| equal(i, j))).collect();
        for (i, j) in next.into_iter().enumerate().filter_map(|(i, j)| Some((i, j?))) {
            let mut used = LinearExpr::empty();
            used.add(self.used[i], 1.0);
            used.add(self.used[j], -1.0);
            self.problem.add_constraint(used, ComparisonOp::Ge, 0.0);
            let mut order = LinearExpr::empty();
            order.add(self.at[i][0], 1.0);
            order.add(self.at[j][0], -1.0);
            if self.runs > 1 {
                order.add(self.run[i], 1.0);
                order.add(self.run[j], -1.0);
            }
            self.problem.add_constraint(order, ComparisonOp::Le, 0.0);
        }
    }

    /// All variables as `start` has them, in the model's own order of equal boxes.
    fn values(&self, start: &[Placed]) -> Vec<(Variable, f64)> {
        let places = self.places_of(start);
        let mut values = Vec::new();
        for (i, place) in places.iter().enumerate() {
            let size = place.map_or(self.sizes[i].len() - 1, |p| {
                self.sizes[i].iter().position(|size| *size == p.size).unwrap_or(0)
            });
            // What is not used lies at the far end, so that it is behind every equal box.
            let far = || [0, 1, 2].map(|k| self.instance.space[k] - self.sizes[i][size][k]);
            let at = place.map_or_else(far, |p| p.at);
            values.extend((0..3).map(|k| (self.at[i][k], self.share(at[k], k))));
            values.push((self.used[i], f64::from(u8::from(place.is_some()))));
            values.push((self.run[i], place.map_or(0.0, |p| p.run as f64)));
            values.extend(self.turn[i].iter().enumerate().map(|(t, &v)| (v, f64::from(u8::from(t == size)))));
        }
        let mut pair = 0;
        for i in 0..places.len() {
            for j in i + 1..places.len() {
                let holds = places[i].zip(places[j]).and_then(|(a, b)| (0..6).find(|&d| lies(&a, &b, d)));
                values.extend(
                    self.pairs[pair].iter().enumerate().map(|(d, &v)| (v, f64::from(u8::from(holds != Some(d))))),
                );
                pair += 1;
            }
        }
        let reached = match self.goal {
            PackGoal::Height => self.share(height(start), 2),
            PackGoal::Runs | PackGoal::Filling => self.runs as f64,
        };
        values.extend(self.top.map(|top| (top, reached)));
        values
    }

    /// The places of `start` by box; among equal boxes they are dealt out from left to right.
    fn places_of(&self, start: &[Placed]) -> Vec<Option<Placed>> {
        let mut left: Vec<Placed> = start.to_vec();
        left.sort_by_key(|p| (p.run, p.at));
        let items = &self.instance.items;
        (0..items.len())
            .map(|i| {
                let found = left.iter().position(|p| items[p.item] == items[i])?;
                Some(Placed { item: i, ..left.remove(found) })
            })
            .collect()
    }

    /// Not farther from the values than `near` says.
    fn keep_near(&mut self, values: &[(Variable, f64)], near: Neighbourhood) {
        let known: std::collections::HashMap<usize, f64> = values.iter().map(|(v, value)| (v.idx(), *value)).collect();
        let was = |variable: Variable| known.get(&variable.idx()).copied().unwrap_or(0.0) > 0.5;
        let change = |all: &[Variable]| {
            let (mut sum, mut constant) = (LinearExpr::empty(), 0.0);
            for &variable in all {
                sum.add(variable, if was(variable) { -1.0 } else { 1.0 });
                constant += f64::from(u8::from(was(variable)));
            }
            (sum, constant)
        };
        let (sum, constant) = change(&self.used);
        self.problem.add_constraint(sum, ComparisonOp::Le, f64::from(near.used) - constant);
        let count = self.used.len();
        let both = (0..count).flat_map(|i| (i + 1..count).map(move |j| (i, j)));
        let used: Vec<Variable> = both
            .zip(&self.pairs)
            .filter(|((i, j), _)| was(self.used[*i]) && was(self.used[*j]))
            .flat_map(|(_, six)| *six)
            .collect();
        let (sum, constant) = change(&used);
        self.problem.add_constraint(sum, ComparisonOp::Le, f64::from(near.directions) - constant);
    }

    fn read(&self, outcome: &SolveOutcome, start: &[Placed]) -> Solved {
        let proved = outcome.is_optimal();
        let most = self.instance.items.iter().map(|item| item.value).fold(f64::MIN_POSITIVE, f64::max);
        let scale = match self.goal {
            PackGoal::Filling => most,
            PackGoal::Runs => 1.0,
            PackGoal::Height => self.instance.space[2] as f64,
        };
        let bound = outcome.stats().best_bound.map(|bound| bound * scale);
        let packing = outcome.solution().and_then(|solution| {
            let values: Vec<f64> = solution.iter().map(|(_, value)| value).collect();
            self.packing(&values)
        });
        let better = packing.filter(|placed| match self.goal {
            PackGoal::Filling => self.instance.value(placed) > self.instance.value(start) * (1.0 + 1e-12),
            PackGoal::Runs => runs(placed) < runs(start),
            PackGoal::Height => height(placed) < height(start),
        });
        Solved { better, bound, proved }
    }

    /// Corners in whole numbers from what the values say is before what; `None` where these do not make a packing.
    fn packing(&self, values: &[f64]) -> Option<Vec<Placed>> {
        let is = |variable: Variable| values[variable.idx()] > 0.5;
        let count = self.sizes.len();
        let mut placed: Vec<Placed> = (0..count)
            .filter(|&i| is(self.used[i]))
            .map(|i| {
                let turn = self.turn[i].iter().position(|&t| is(t)).unwrap_or(0);
                let run = values[self.run[i].idx()].round() as usize;
                Placed { run, item: i, at: [0; 3], size: self.sizes[i][turn] }
            })
            .collect();
        for axis in 0..3 {
            let behind = |a: &Placed, b: &Placed| {
                let (i, j) = (a.item.min(b.item), a.item.max(b.item));
                let six = &self.pairs[i * count - i * (i + 1) / 2 + j - i - 1];
                a.run == b.run && !is(six[2 * axis + usize::from(a.item > b.item)])
            };
            // As many rounds as a chain can be long.
            for _ in 0..placed.len() {
                for b in 0..placed.len() {
                    let before = placed.iter().filter(|a| a.item != placed[b].item && behind(a, &placed[b]));
                    placed[b].at[axis] = before.map(|a| a.at[axis] + a.size[axis]).max().unwrap_or(0);
                    if placed[b].at[axis] > self.instance.space[axis] {
                        return None;
                    }
                }
            }
        }
        check(self.instance, &placed, self.goal != PackGoal::Filling).is_ok().then_some(placed)
    }
}

/// Whether `b` lies to the right, left, up, down, in front or at the back of `a`, counted from 0.
fn lies(a: &Placed, b: &Placed, direction: usize) -> bool {
    let axis = direction / 2;
    let (first, then) = if direction.is_multiple_of(2) { (a, b) } else { (b, a) };
    if axis == 0 && first.run != then.run {
        return first.run < then.run;
    }
    first.run == then.run && first.at[axis] + first.size[axis] <= then.at[axis]
}

fn runs(placed: &[Placed]) -> usize {
    let mut runs: Vec<usize> = placed.iter().map(|p| p.run).collect();
    runs.sort_unstable();
    runs.dedup();
    runs.len()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pack::{Item, Turns};

    /// From an empty run as many boxes come as the used distance allows, the most valuable first.
    #[test]
    fn a_neighbourhood_is_as_wide_as_it_says() {
        let item = |value| Item { size: [5, 10, 10], value, up: [true; 3] };
        let instance = Instance {
            space: [20, 10, 10],
            gap: 0,
            turns: Turns::None,
            items: [1.0, 4.0, 2.0, 8.0].map(item).to_vec(),
        };
        let value = |used, directions, start: &[Placed]| {
            let mut asked = |_| None;
            let mut watch = Watch::new(10_000_000, &mut asked);
            let near = Some(Neighbourhood { used, directions });
            let solved = solve(&instance, PackGoal::Filling, start, 15.0, near, &mut watch);
            solved.better.map(|placed| instance.value(&placed))
        };
        assert_eq!(
            [0, 1, 2, 3, 4].map(|used| value(used, 0, &[])),
            [None, Some(8.0), Some(12.0), Some(14.0), Some(15.0)]
        );
        let lying = |item: usize, x| Placed { run: 0, item, at: [x, 0, 0], size: [5, 10, 10] };
        assert_eq!(value(1, 0, &[lying(3, 0), lying(1, 5)]), Some(14.0));
    }
}
