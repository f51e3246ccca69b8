//! The least height of one run in a given base (strip packing; Bortfeldt and Mack, "A heuristic for the three-dimensional strip packing problem", 2007).
//!
//! It begins with the boxes in some orders, each put where its top or bottom comes lowest. Then a lower height is aimed at: orders and turns are
//! changed a little at a time (as where a run is filled) until all boxes lie below it. What is reached gives the next aim. Where a round ends
//! before that, the next one aims half as far; from the least step on again a quarter of the way down to the bound, with longer rounds.

use super::bound::sums;
use super::fill::{RULES, Ready};
use super::filling::Way;
use super::instance::{Placed, height, volume};
use super::spaces::{Rule, Run};
use super::watch::Watch;
use crate::geom::SplitMix64;

/// Orders that are tried for one height, at first and at most.
const ROUND: usize = 1500;
const LONGEST_ROUND: usize = 48_000;
/// Where heights are not few, the least step is such a part of the height.
const STEPS_IN_HEIGHT: i64 = 1000;
/// How much more may be left out at the warmest, of the volume of all boxes.
const WARMEST: f64 = 0.002;
/// What a round may begin with.
const BEGINNINGS: usize = 3;
/// Keys by which the first orders are sorted: see [`Way::first`].
const KEYS: usize = 4;

/// All boxes in one run, as low as is found before the watch ends or `bound` is met; `None` where none is found within the space. The values of `ready` are
/// the boxes' volumes.
pub(super) fn lowest(ready: &Ready, bound: i64, seed: u64, watch: &mut Watch<'_>) -> Option<Vec<Placed>> {
    let mut search = Search {
        ready,
        bound,
        heights: sums(&ready.sizes, 2, ready.space[2]),
        all: ready.values.iter().sum(),
        numbers: SplitMix64::seeded(seed),
        best: None,
        rounds: 0,
    };
    search.start(watch);
    search.descend(watch);
    search.best.map(|best| best.placed)
}

struct Search<'a> {
    ready: &'a Ready,
    bound: i64,
    /// The heights that a packing may have, from 0 up, where they are few.
    heights: Option<Vec<i64>>,
    /// The volume of all boxes.
    all: f64,
    numbers: SplitMix64,
    best: Option<Best>,
    rounds: usize,
}

/// The lowest packing and how it was made.
struct Best {
    way: Way,
    rule: Rule,
    placed: Vec<Placed>,
}

impl Search<'_> {
    /// The rules, those that keep tops and bottoms low first.
    fn rule(&self, which: usize) -> Rule {
        match which % (RULES.len() + 1) {
            0 => Rule::Top,
            other => RULES[other - 1],
        }
    }

    /// The height of the best; beyond the limit where there is none.
    fn least(&self) -> i64 {
        self.best.as_ref().map_or(self.ready.space[2] + 1, |best| height(&best.placed))
    }

    fn keep(&mut self, way: &Way, rule: Rule, run: &Run) {
        if run.placed.len() == self.ready.sizes.len() && height(&run.placed) < self.least() {
            self.best = Some(Best { way: way.clone(), rule, placed: run.placed.clone() });
        }
    }

    /// Orders by falling keys, by each rule, in all of the space.
    fn start(&mut self, watch: &mut Watch<'_>) {
        let mut run = Run::empty(self.ready.space);
        for which in 0..KEYS {
            let way = Way::first(self.ready, which);
            for rule in 0..=RULES.len() {
                // One packing there must be, however short the time.
                if self.best.is_some() && !watch.goes_on() {
                    return;
                }
                way.value(self.ready, &mut run, self.rule(rule), watch);
                self.keep(&way, self.rule(rule), &run);
            }
        }
    }

    /// The highest that is lower than the best by `step`, of the heights that there may be.
    fn aim(&self, step: i64) -> i64 {
        let below = self.least() - step.max(1);
        let known = self.heights.as_ref().map(|all| all[..all.partition_point(|&h| h <= below)].last().copied());
        known.map_or(below, |known| known.unwrap_or(0)).max(self.bound)
    }

    fn descend(&mut self, watch: &mut Watch<'_>) {
        let mut round = ROUND;
        let mut step = self.far();
        while self.least() > self.bound && watch.goes_on() {
            let aim = self.aim(step);
            if self.reaches(aim, round, watch) {
                continue;
            }
            let least = if self.heights.is_some() { 1 } else { (self.least() / STEPS_IN_HEIGHT).max(1) };
            // Of few heights the next lower one is the last to aim at.
            if step <= least || aim == self.aim(1) {
                step = self.far();
                round = (2 * round).min(LONGEST_ROUND);
            } else {
                step = (step / 2).max(least);
            }
        }
    }

    /// A quarter of the way to the bound.
    fn far(&self) -> i64 {
        (self.least() - self.bound) / 4
    }

    /// Whether all boxes came to lie below `aim` (simulated annealing over orders and turns; what is left out costs its volume). Of three rounds one
    /// begins with the best and its rule, one with the best and another rule, one with an order by falling keys.
    fn reaches(&mut self, aim: i64, round: usize, watch: &mut Watch<'_>) -> bool {
        let ready = self.ready;
        let (turn, round_of) = (self.rounds / BEGINNINGS, self.rounds % BEGINNINGS);
        self.rounds += 1;
        let near = self.best.as_ref().filter(|_| round_of < 2);
        let rule = near.filter(|_| round_of == 0).map_or_else(|| self.rule(turn), |best| best.rule);
        let mut here = near.map_or_else(|| Way::first(ready, turn % KEYS), |best| best.way.clone());
        let [wide, deep, _] = ready.space;
        let mut run = Run::empty([wide, deep, aim]);
        if volume(&[wide, deep, aim]) < self.all {
            return false;
        }
        let mut value = here.value(ready, &mut run, rule, watch);
        self.keep(&here, rule, &run);
        let warmest = WARMEST * self.all;
        for step in 0..round {
            if self.least() <= aim {
                return true;
            }
            // A high run has many empty boxes: an order takes about twice the time of one for a single run.
            if !watch.spend(ready.sizes.len() as u64) {
                return false;
            }
            let warm = warmest * (1.0 - step as f64 / round as f64).powi(3);
            let there = here.changed(ready, &mut self.numbers);
            let worth = there.value(ready, &mut run, rule, watch);
            if worth >= value || self.numbers.unit() < ((worth - value) / warm.max(f64::MIN_POSITIVE)).exp() {
                (here, value) = (there, worth);
                self.keep(&here, rule, &run);
            }
        }
        self.least() <= aim
    }
}
