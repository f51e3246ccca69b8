//! Tabu search for the least number of runs (Lodi, Martello and Vigo, "Heuristic and metaheuristic approaches for a class of two-dimensional bin
//! packing problems", 1999; Leitereg (2020), section 2.4): a run is emptied box by box, each into `k` other runs that are packed anew with it.
//!
//! The sub-heuristic takes boxes by falling volume to the place with the **best** touching area (the thesis's listing only sums it up); places are
//! the corners of the largest empty boxes, each of which touches something at left, back and bottom.

use std::collections::VecDeque;

use super::fill::Ready;
use super::instance::Placed;
use super::spaces::{Rule, Run};
use super::watch::Watch;

/// Runs that are packed anew with a box, at most.
const MOST_RUNS: usize = 3;
/// Diversifications until half of all runs are taken apart.
const MOST_DIVERSIFIED: usize = 4;
/// Penalties that are not taken again for a while.
const REMEMBERED: usize = 12;

type Runs = Vec<Vec<Placed>>;

/// The best that is found before the watch ends or `bound` is met.
pub(super) fn tabu(ready: &Ready, bound: usize, watch: &mut Watch<'_>) -> Runs {
    let all: Vec<usize> = (0..ready.sizes.len()).collect();
    let mut best = touching(ready, &all, watch);
    let mut runs: Runs = all.iter().map(|&item| touching(ready, &[item], watch).remove(0)).collect();
    let mut search = Search { ready, k: 1, forbidden: VecDeque::new(), diversified: 0 };
    let mut target = search.emptiest(&runs, 0);
    while best.len() > bound.max(1) && watch.goes_on() {
        let moved = search.search(&mut runs, target, watch);
        if runs.len() < best.len() {
            best.clone_from(&runs);
        }
        target = match moved {
            true => search.emptiest(&runs, 0),
            false if search.k < MOST_RUNS.min(runs.len() - 1) => {
                search.k += 1;
                target
            }
            false => search.diversify(&mut runs, watch),
        };
    }
    best
}

/// The sub-heuristic: as many runs as it takes.
fn touching(ready: &Ready, items: &[usize], watch: &mut Watch<'_>) -> Runs {
    let mut order = items.to_vec();
    order.sort_by(|&a, &b| ready.volumes[b].total_cmp(&ready.volumes[a]).then(a.cmp(&b)));
    watch.spend(order.len() as u64);
    let mut runs: Vec<Run> = Vec::new();
    for item in order {
        let places = runs.iter().enumerate().filter_map(|(index, run)| {
            let (at, size) = run.place_for(&ready.sizes[item], Rule::Touching)?;
            Some((run.touching(&at, &size), index, at, size))
        });
        let best = places.max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)));
        let (index, at, size) = match best {
            Some((_, index, at, size)) => (index, at, size),
            None => {
                runs.push(Run::empty(ready.space));
                (runs.len() - 1, [0; 3], ready.sizes[item][0])
            }
        };
        runs[index].put(item, at, size, &ready.least);
    }
    runs.into_iter().map(|run| run.placed).collect()
}

struct Search<'a> {
    ready: &'a Ready,
    k: usize,
    forbidden: VecDeque<u64>,
    diversified: usize,
}

impl Search<'_> {
    fn filling(&self, run: &[Placed]) -> f64 {
        run.iter().map(|p| self.ready.volumes[p.item]).sum()
    }

    /// The run that is the emptiest but `rank`, by volume, then by boxes.
    fn emptiest(&self, runs: &Runs, rank: usize) -> usize {
        let mut order: Vec<usize> = (0..runs.len()).collect();
        let key = |run: usize| (self.filling(&runs[run]), runs[run].len());
        order.sort_by(|&a, &b| key(a).0.total_cmp(&key(b).0).then(key(a).1.cmp(&key(b).1)).then(a.cmp(&b)));
        order[rank.min(order.len() - 1)]
    }

    /// One move from the target run; whether there was one.
    fn search(&mut self, runs: &mut Runs, target: usize, watch: &mut Watch<'_>) -> bool {
        let mut least: Option<(f64, usize, Vec<usize>, Runs)> = None;
        let others: Vec<usize> = (0..runs.len()).filter(|&run| run != target).collect();
        for object in 0..runs[target].len() {
            let item = runs[target][object].item;
            let mut chosen: Vec<usize> = (0..self.k.min(others.len())).collect();
            loop {
                if !watch.spend(1) {
                    return false;
                }
                let taken: Vec<usize> = chosen.iter().map(|&i| others[i]).collect();
                let mut items: Vec<usize> = taken.iter().flat_map(|&r| runs[r].iter().map(|p| p.item)).collect();
                items.push(item);
                let packed = touching(self.ready, &items, watch);
                let last = runs[target].len() == 1;
                if packed.len() <= taken.len() {
                    let fewer = packed.len() < taken.len() || last;
                    put(runs, target, object, &taken, packed);
                    self.k = if fewer { self.k.saturating_sub(1).max(1) } else { self.k };
                    return true;
                }
                let known = least.as_ref().map_or(f64::INFINITY, |l| l.0);
                let one_more = (packed.len() == taken.len() + 1).then_some(packed);
                let priced = one_more.and_then(|packed| self.penalty(runs, target, object, packed, watch));
                if let Some((penalty, packed)) = priced.filter(|p| p.0 < known) {
                    least = Some((penalty, object, taken, packed));
                }
                if !following(&mut chosen, others.len()) {
                    break;
                }
            }
        }
        let Some((penalty, object, taken, packed)) = least else { return false };
        self.forbidden.push_back(penalty.to_bits());
        if self.forbidden.len() > REMEMBERED {
            self.forbidden.pop_front();
        }
        put(runs, target, object, &taken, packed);
        true
    }

    /// For exactly one run too many: how full its emptiest is, if that goes into one run with what is left of the target; and the runs with that one
    /// last, packed so. `None` where it does not, or where this is forbidden.
    fn penalty(
        &self,
        runs: &Runs,
        target: usize,
        object: usize,
        mut packed: Runs,
        watch: &mut Watch<'_>,
    ) -> Option<(f64, Runs)> {
        let emptiest = self.emptiest(&packed, 0);
        let filling = self.filling(&packed[emptiest]) / self.ready.space.iter().map(|&s| s as f64).product::<f64>();
        if self.forbidden.contains(&filling.to_bits()) {
            return None;
        }
        let rest = runs[target].iter().enumerate().filter(|(i, _)| *i != object).map(|(_, p)| p.item);
        let joined: Vec<usize> = rest.chain(packed.swap_remove(emptiest).iter().map(|p| p.item)).collect();
        let mut one = touching(self.ready, &joined, watch);
        (one.len() == 1).then(|| {
            packed.append(&mut one);
            (filling, packed)
        })
    }

    /// Another target; now and then the emptier half of all runs is taken apart.
    fn diversify(&mut self, runs: &mut Runs, watch: &mut Watch<'_>) -> usize {
        self.k = 1;
        self.diversified += 1;
        if self.diversified <= MOST_DIVERSIFIED.min(runs.len() - 1) {
            return self.emptiest(runs, self.diversified);
        }
        self.diversified = 0;
        self.forbidden.clear();
        runs.sort_by(|a, b| self.filling(a).total_cmp(&self.filling(b)));
        let apart: Vec<usize> = runs.drain(..runs.len().div_ceil(2)).flatten().map(|p| p.item).collect();
        runs.extend(apart.into_iter().flat_map(|item| touching(self.ready, &[item], watch)));
        self.emptiest(runs, 0)
    }
}

/// Takes `object` from the target, and puts `packed` in the place of the runs `taken`; one run more takes the target's own place.
fn put(runs: &mut Runs, target: usize, object: usize, taken: &[usize], mut packed: Runs) {
    runs[target].remove(object);
    if packed.len() > taken.len() {
        runs[target] = packed.pop().unwrap_or_default();
    }
    for &run in taken {
        runs[run] = packed.pop().unwrap_or_default();
    }
    runs.retain(|run| !run.is_empty());
}

/// The next `k` of `of` numbers in order; false behind the last.
fn following(chosen: &mut [usize], of: usize) -> bool {
    let k = chosen.len();
    let Some(place) = (0..k).rev().find(|&i| chosen[i] < of - k + i) else { return false };
    chosen[place] += 1;
    (place + 1..k).for_each(|i| chosen[i] = chosen[i - 1] + 1);
    true
}
