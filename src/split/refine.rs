//! What the search found, made better in small steps: parallel cuts become one, a slanting direction becomes the exact one beside
//! it, and every plane moves to where its seam is smallest.
//!
//! The search tries some dozen offsets a direction, millimetres apart: a neck between two of them is missed. Here a plane is moved
//! within that distance, the cuts after it are made again, and what comes is held against the same rules, measures and machine. It
//! takes the place of what was found only where it is better by [`SplitState::key`]. So a result is never worse, and what is
//! tried is bounded by the number of cuts. Pinned cuts stay as they are.
//!
//! Lengths mm, areas mm².

use std::sync::Arc;

use super::candidates::{around, spacing};
use super::clip::Taken;
use super::promise::Promise;
use super::search::{BeamSearch, SearchFound};
use super::state::{CutStep, FAULT_MM2, SplitState, StatePromise, whole};
use super::surface::Plane;
use super::sweep::{Beyond, Sweep, seam_mm2};
use crate::geom::Vec3;

/// Planes of one cut that are really tried, the most promising first.
const TRIES: usize = 3;
/// Where one was refused, others nearer than this share of the window are too.
const APART: f64 = 0.125;
/// A slanting direction may turn so far to an exact one, as a cosine (15 degrees).
const NEAR_COSINE: f64 = 0.966;
/// Exact directions that are tried in its place, the nearest first.
const SNAPS: usize = 3;
/// Areas that differ by less are equal but for rounding, mm².
const ROUNDING_MM2: f64 = 1e-6;
/// Pairs of parallel cuts that are tried as one.
const PAIRS: usize = 12;

impl BeamSearch<'_> {
    /// `found`, or what is better and near it; `finished` as in [`BeamSearch::run`].
    pub(super) fn refined(&self, found: SearchFound, finished: &dyn Fn(&SplitState) -> bool) -> SearchFound {
        let allow_mm2 = self.ground.options.allow_mm2;
        let needs_nothing = |s: &SplitState| s.is_done(allow_mm2) || s.passes(&self.ground.rules);
        // The machine has no plan for what needs nothing: a smaller seam does not make one.
        if !found.printable && found.unplanned > 0 && found.state.is_done(allow_mm2) {
            return found;
        }
        let state = self.nearby(&found.state, &|s| !found.printable || needs_nothing(s));
        if Arc::ptr_eq(&state, &found.state) {
            return found;
        }
        if !found.printable {
            let printable = needs_nothing(&state) && finished(&state);
            return SearchFound { state, printable, ..found };
        }
        // The machine is asked once where it agrees to all, and else step by step.
        let state =
            if finished(&state) { state } else { self.nearby(&found.state, &|s| needs_nothing(s) && finished(s)) };
        SearchFound { state, ..found }
    }

    /// The best near `found` of what `holds`.
    fn nearby(&self, found: &Arc<SplitState>, holds: &dyn Fn(&SplitState) -> bool) -> Arc<SplitState> {
        let mut best = self.merged(found, holds);
        let mut before = self.start.clone();
        for k in before.steps.len()..best.steps.len() {
            for promise in self.moves(&before, &best.steps[k].clone()) {
                let made = self.child(&before, &promise).ok();
                let other = made.and_then(|made| self.repeated(made, &best.steps[k + 1..]));
                if let Some(other) = other.filter(|other| betters(other, &best) && holds(other)) {
                    best = other;
                    break;
                }
            }
            match self.repeated(before, &best.steps[k..=k]) {
                Some(after) => before = after,
                None => break,
            }
        }
        best
    }

    /// Two cuts along one direction as one that takes what both took, where that is better.
    fn merged(&self, found: &Arc<SplitState>, holds: &dyn Fn(&SplitState) -> bool) -> Arc<SplitState> {
        let mut best = found.clone();
        let mut left = PAIRS;
        'again: loop {
            let steps = best.steps.clone();
            for i in self.start.steps.len()..steps.len() {
                let parallel = |j: &usize| (steps[i].plane.normal - steps[*j].plane.normal).norm() < 1e-9;
                for j in (i + 1..steps.len()).filter(parallel) {
                    if left == 0 {
                        return best;
                    }
                    left -= 1;
                    let both = [&steps[i], &steps[j]].map(|step| step.plane);
                    let one = both.into_iter().filter_map(|plane| self.as_one(&steps, [i, j], plane));
                    let better = one.filter(|one| betters(one, &best) && holds(one)).min_by_key(|one| one.key());
                    if let Some(better) = better {
                        best = better;
                        continue 'again;
                    }
                }
            }
            return best;
        }
    }

    /// All `steps`, with cut `j` made together with `i` along `plane`.
    fn as_one(&self, steps: &[Arc<CutStep>], [i, j]: [usize; 2], plane: Plane) -> Option<Arc<SplitState>> {
        let before = self.repeated(self.start.clone(), &steps[self.start.steps.len()..i])?;
        let all = steps[i].all && steps[j].all;
        let points: Vec<Vec3> = steps[i].tops.iter().chain(&steps[j].tops).copied().collect();
        let tops: Vec<u32> = points.iter().filter_map(|p| vertex(&before, p)).collect();
        let taken = if all { Taken::All } else { Taken::With(tops.clone()) };
        let promise = Promise::new(plane, taken, tops, 0.0, 0, 0, steps[i].odd && steps[j].odd);
        let made = self.child(&before, &promise).ok()?;
        self.repeated(self.repeated(made, &steps[i + 1..j])?, &steps[j + 1..])
    }

    /// `state` after the same cuts once more.
    fn repeated(&self, state: Arc<SplitState>, steps: &[Arc<CutStep>]) -> Option<Arc<SplitState>> {
        steps.iter().try_fold(state, |state, step| {
            let tops: Option<Vec<u32>> = step.tops.iter().map(|p| vertex(&state, p)).collect();
            let taken = if step.all { Taken::All } else { Taken::With(tops.clone()?) };
            let promise = Promise::new(step.plane, taken, tops.unwrap_or_default(), 0.0, 0, 0, step.odd);
            self.child(&state, &promise).ok()
        })
    }

    /// Planes near that of `step` that promise more, the most promising first.
    fn moves(&self, before: &SplitState, step: &CutStep) -> Vec<StatePromise> {
        let limit = self.worth(before, step).unwrap_or(f64::INFINITY);
        let mut all = self.shifted(before, step, &step.plane, limit, whole(step.seam_mm2), step.odd);
        if step.odd {
            let exact = self.ground.exact_directions();
            let mut near: Vec<&Vec3> = exact.iter().filter(|up| up.dot(&step.plane.normal) > NEAR_COSINE).collect();
            near.sort_by(|a, b| b.dot(&step.plane.normal).total_cmp(&a.dot(&step.plane.normal)));
            let middle = step.seam_middle();
            for up in near.into_iter().take(SNAPS) {
                let plane = Plane { normal: *up, offset_mm: up.dot(&middle) };
                all.extend(self.shifted(before, step, &plane, limit, i64::MAX, false).into_iter().take(1));
            }
        }
        all
    }

    /// What the cut comes to by the sweep, so that promises are held against a promise.
    fn worth(&self, before: &SplitState, step: &CutStep) -> Option<f64> {
        let mut sweep = Sweep::new(&before.rest, &before.upright, &step.plane.normal, &self.ground.rules);
        let mut worth = None;
        sweep.run(&[step.plane.offset_mm], |_, beyond| worth = taken(before, step, beyond).map(|(worth, ..)| worth));
        worth
    }

    /// Planes parallel to `plane` and near it that promise more than a worth of `limit` and a seam of `seam_limit`, apart from each other.
    fn shifted(
        &self,
        before: &SplitState,
        step: &CutStep,
        plane: &Plane,
        limit: f64,
        seam_limit: i64,
        odd: bool,
    ) -> Vec<StatePromise> {
        let up = &plane.normal;
        let mut sweep = Sweep::new(&before.rest, &before.upright, up, &self.ground.rules);
        let window = spacing(&before.rest, up, &sweep.heights);
        let mut found: Vec<((i64, i64), StatePromise)> = Vec::new();
        let (mut middle, mut reach) = (plane.offset_mm, window);
        // A second time about the best, finer.
        for _ in 0..2 {
            let offsets = around(&before.rest, up, &sweep.heights, middle, reach);
            let mut told = Vec::new();
            sweep.run(&offsets, |c, beyond| told.extend(taken(before, step, beyond).map(|taken| (c, taken))));
            for (offset_mm, (worth, stays_mm2, tops)) in told {
                if worth > limit + ROUNDING_MM2 {
                    continue;
                }
                let seam = whole(seam_mm2(&before.rest, up, offset_mm, &tops));
                let worth = whole(worth);
                if worth < whole(limit) || (worth == whole(limit) && seam < seam_limit) {
                    let taken = if step.all { Taken::All } else { Taken::With(tops.clone()) };
                    let plane = Plane { normal: *up, offset_mm };
                    let promise = Promise::new(plane, taken, tops, stays_mm2, worth, 0, odd);
                    found.push(((worth, seam), promise));
                }
            }
            found.sort_by_key(|(key, _)| *key);
            let Some((_, best)) = found.first() else { break };
            (middle, reach) = (best.plane.offset_mm, reach / 16.0);
        }
        let mut apart: Vec<StatePromise> = Vec::new();
        for (_, promise) in found {
            let far = |other: &StatePromise| (other.plane.offset_mm - promise.plane.offset_mm).abs() > APART * window;
            if apart.len() < TRIES && apart.iter().all(far) {
                apart.push(promise);
            }
        }
        apart
    }
}

/// Of the solids `beyond` an offset those that `step` took: the worth of taking them, what stays for good, and their tops; `None`
/// where they are others, or one begins in the air.
fn taken(before: &SplitState, step: &CutStep, beyond: &[Beyond]) -> Option<(f64, f64, Vec<u32>)> {
    let at = |top: u32| before.rest.surface.vertices[top as usize];
    let wanted = |one: &&Beyond| step.all || step.tops.contains(&at(one.top));
    let chosen: Vec<&Beyond> = beyond.iter().filter(wanted).collect();
    if chosen.is_empty() || (!step.all && chosen.len() != step.tops.len()) {
        return None;
    }
    if chosen.iter().any(|one| one.after.faults() > 0) {
        return None;
    }
    let [gone, stays] = [
        chosen.iter().map(|one| one.before.area_mm2).sum::<f64>(),
        chosen.iter().map(|one| one.after.area_mm2).sum::<f64>(),
    ];
    let faults = chosen.iter().map(|one| one.before.faults()).sum::<usize>().min(before.left().faults());
    let area = before.area_mm2() - gone + stays + FAULT_MM2 * (before.faults() - faults) as f64;
    Some((area, stays, chosen.iter().map(|one| one.top).collect()))
}

/// Whether `other` comes before `best`, and not at the price of an area below what results are told apart by.
fn betters(other: &SplitState, best: &SplitState) -> bool {
    let bare = other.faults() == best.faults() && other.area_mm2() > best.area_mm2() + ROUNDING_MM2;
    other.key() < best.key() && !bare
}

/// The vertex of what is left at `point`: cuts never move one.
fn vertex(state: &SplitState, point: &Vec3) -> Option<u32> {
    state.rest.surface.vertices.iter().position(|v| v == point).map(|v| v as u32)
}
