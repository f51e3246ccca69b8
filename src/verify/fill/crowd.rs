//! No more plastic than fits.
//!
//! Plastic cannot vanish: where layer upon layer holds more than its height has room for, the nozzle ploughs through what stands up. Single
//! layers say little, since slicers draw threads over air thicker and anchor them on what is full. So windows of 3 x 3 mm, clear of the
//! outline, are followed from layer to layer, from where the layer below is full: the more layers, the less each may hold. A top surface is
//! no such thread, and is judged alone.
//!
//! No width and no factor that the file states is asked for. Shares of a layer that is full to its height; lengths in cells.

use std::collections::BTreeMap;
use std::f64::consts::FRAC_PI_4;

use super::super::prints::PrintedPart;
use super::super::report::Findings;
use super::map::CELL_MM;
use super::{Around, Full, Told, add};

/// A window's edge, how far it stays clear of the outline, and how far apart windows lie, in cells.
const WINDOW: usize = 12;
const CLEAR: usize = 2;
const STEP: i64 = 4;
/// What each of one, two, three, and four and more layers over each other may hold where so many windows of a layer do. Of sound files the fullest had
/// 1.83 (threads of Slic3r where they are anchored), 1.60, 1.26 and 1.26 in one window, and 1.67, 1.39, 1.11 and 1.12 elsewhere; a slicer's own factor
/// may add a tenth.
pub(in crate::verify) const MOST: [f64; 4] = [1.9, 1.55, 1.25, 1.22];
const MANY: usize = 20;
/// And where fewer do.
const MOST_OF_FEW: [f64; 4] = [1.95, 1.75, 1.4, 1.4];
/// And one layer so many times what round threads as thick as the nozzle hold: where these bridge and are anchored, a thin layer has no room
/// for them. PrusaSlicer's and Slic3r's lie so far apart, mm.
pub(in crate::verify) const MOST_OF_THREADS: f64 = 1.05;
const THREADS_APART_MM: f64 = 0.05;
/// And a top surface on a full layer: of sound files the fullest had 1.16; ironing adds up to a third.
pub(in crate::verify) const MOST_ON_TOP: f64 = 1.5;
/// Layers with less are as they should be.
const LEAST: f64 = MOST[MOST.len() - 1];
/// What a layer holds that carries the next one and takes none of its plastic.
const FULL: f64 = 0.85;

/// A window that holds too much for several layers of it.
pub(super) struct Crowd {
    at: [i32; 2],
    share: f64,
    /// Whether what is below is full.
    carried: bool,
    is_top: bool,
}

/// The windows of a layer that hold more than would do over several layers.
pub(super) fn crowds(around: &Around<'_>) -> Vec<Crowd> {
    let (full, frame) = (around.here, around.here.layer.mask.frame);
    let first = |axis: usize| frame.low[axis].div_euclid(STEP);
    let last = |axis: usize| (frame.low[axis] + frame.size[axis] as i64).div_euclid(STEP);
    let mut found = Vec::new();
    for row in first(1)..=last(1) {
        for column in first(0)..=last(0) {
            let low = [column * STEP, row * STEP];
            if let Some(held) = share(full, low, LEAST) {
                let carried = around.first || around.below.is_some_and(|below| share(below, low, FULL).is_some());
                let is_top = around.known.1 && !around.above.is_some_and(|above| above.has(low, WINDOW));
                found.push(Crowd { at: [column as i32, row as i32], share: held, carried, is_top });
            }
        }
    }
    found
}

/// What a window holds that lies in the part, clear of its outline; `None` where that is less than `least`.
fn share(full: &Full<'_>, low: [i64; 2], least: f64) -> Option<f64> {
    let frame = &full.layer.mask.frame;
    let at = [0, 1].map(|axis| low[axis] - frame.low[axis]);
    let fits = (0..2).all(|axis| at[axis] >= 0 && at[axis] as usize + WINDOW <= frame.size[axis]);
    let held = || full.plastic.square(at.map(|v| v as usize), WINDOW) / (WINDOW * WINDOW) as f64;
    // Few windows hold so much; whether they lie in the part is asked of these alone.
    let share = Some(fits).filter(|fits| *fits).map(|_| held()).filter(|share| *share >= least)?;
    full.inside(low.map(|v| v - CLEAR as i64), WINDOW + 2 * CLEAR).map(|_| share)
}

/// A window through the layers that hold too much: the last one, and what up to four of them held.
#[derive(Default)]
struct Run {
    last: usize,
    shares: Vec<f64>,
}

impl Run {
    fn take(&mut self, index: usize, crowd: &Crowd) {
        if self.last + 1 != index || !crowd.carried {
            self.shares.clear();
        }
        self.last = index;
        if crowd.carried {
            self.shares.push(crowd.share);
        }
    }

    /// Of how many layers up to this one each holds too much: what the least of them holds, and what it may.
    fn over(&self, is_top: bool, most: [f64; MOST.len()]) -> Option<(usize, [f64; 2])> {
        let alone = self.shares.last().filter(|share| is_top && **share > MOST_ON_TOP);
        let alone = alone.map(|share| (1, [*share, MOST_ON_TOP]));
        let upward = most.iter().enumerate().rev().find_map(|(before, most)| {
            let last = &self.shares[self.shares.len().checked_sub(before + 1)?..];
            let least = last.iter().copied().fold(f64::INFINITY, f64::min);
            (least > *most).then_some((before + 1, [least, *most]))
        });
        upward.or(alone)
    }
}

/// A window that holds more than it may, with the layers up to it that do.
struct Over {
    at: [i32; 2],
    layers: usize,
    share: f64,
    most: f64,
}

pub(super) fn check(printed: &PrintedPart<'_>, told: &[Told], findings: &mut Findings) {
    let mut runs: BTreeMap<[i32; 2], Run> = BTreeMap::new();
    for (index, layer) in told.iter().enumerate() {
        for crowd in &layer.crowds {
            runs.entry(crowd.at).or_default().take(index, crowd);
        }
        let nozzle_mm = printed.job.profile.process.nozzle_mm;
        let over = |most: [f64; MOST.len()]| -> Vec<Over> {
            let most = with_threads(most, nozzle_mm, layer.height);
            let over = layer.crowds.iter().filter_map(|crowd| {
                let (layers, [share, most]) = runs.get(&crowd.at)?.over(crowd.is_top, most)?;
                Some(Over { at: crowd.at, layers, share, most })
            });
            over.collect()
        };
        let many = over(MOST);
        let found = if many.len() >= MANY { many } else { over(MOST_OF_FEW) };
        let beyond = |over: &Over| over.share / over.most;
        if let Some(worst) = found.iter().max_by(|a, b| beyond(a).total_cmp(&beyond(b))) {
            say(printed, layer, worst, findings);
        }
    }
}

/// What layers may hold; one of them what round threads do at its height.
fn with_threads([one, more @ ..]: [f64; MOST.len()], nozzle_mm: f64, height_mm: f64) -> [f64; MOST.len()] {
    let threads = FRAC_PI_4 * nozzle_mm.powi(2) / ((nozzle_mm + THREADS_APART_MM) * height_mm);
    let [two, three, four] = more;
    [one.max(MOST_OF_THREADS * threads), two, three, four]
}

fn say(printed: &PrintedPart<'_>, layer: &Told, worst: &Over, findings: &mut Findings) {
    let Over { at, layers, share, most } = worst;
    add(printed, layer.line, [*share, *most], findings, || {
        let [x, y] = at.map(|v| (f64::from(v) * STEP as f64 + WINDOW as f64 / 2.0) * CELL_MM);
        let (part, z, mm) = (printed.planned.part, layer.z, WINDOW as f64 * CELL_MM);
        let over = if *layers == 1 { "one layer".to_owned() } else { format!("{layers} layers") };
        format!(
            "part {part} holds {:.0} % of the plastic that fits in {mm} x {mm} mm of {over} up to Z {z:.2}, at X {x:.1} Y {y:.1} (maximum {:.0} %)",
            share * 100.0,
            most * 100.0
        )
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_thin_layer_may_hold_round_threads_and_no_other_may_hold_more() {
        // A circle of 0.4 mm has 0.12566 mm2, a layer of 0.12 mm has 0.054 for each 0.45 mm.
        let [one, more @ ..] = with_threads(MOST, 0.4, 0.12);
        assert!((one - 1.05 * 0.125_664 / 0.054).abs() < 1e-5 && more == MOST[1..], "{one} {more:?}");
        assert_eq!(with_threads(MOST, 0.4, 0.2), MOST);
        assert_eq!(with_threads(MOST_OF_FEW, 0.4, 0.16), MOST_OF_FEW);
        // Of a run of three the first is a thread's, the next two hold too much as well: that is found as before.
        let run = Run { last: 2, shares: vec![2.3, 1.8, 1.8] };
        assert_eq!(run.over(false, with_threads(MOST, 0.4, 0.12)), Some((3, [1.8, MOST[2]])));
        let alone = |share: f64| Run { last: 0, shares: vec![share] }.over(false, with_threads(MOST, 0.4, 0.12));
        assert_eq!((alone(2.33), alone(2.5).map(|(layers, _)| layers)), (None, Some(1)));
    }
}
