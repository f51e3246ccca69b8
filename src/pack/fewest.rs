//! The least number of runs, with its proof, and the least height of one: by the dual feasible functions of [`super::bound`], then by shares of each box's own ([`super::scales`]) where boxes are not
//! turned.

use super::bound::{Shares, axes, each_triple, longest_sum, sums, weight};
use super::instance::Instance;
use super::scales::{Axis, Scale};
use crate::geom::SplitMix64;

/// Scales that begin with functions, and rounds over the axes from each.
const STARTS: usize = 40;
const ROUNDS: usize = 5;
/// What a round must gain, runs.
const LEAST_GAIN: f64 = 1e-4;
/// Boxes for which there are scales, and cells of an axis, at most.
const MOST_SCALED: usize = 150;
const SCALE_CELLS: i64 = 1500;
/// Cells of knapsacks and numbers of the programs' inverses that are looked at, at most: a tenth of a second or two.
const MOST_SCALE_WORK: u64 = 400_000_000;

/// Why no packing has fewer runs: shares along each axis, by box and by its sizes as it may be turned ([`Instance::sizes`]). Boxes that fit beside each other along an axis
/// have no more than all of it; so no run holds more than one of the products of the three shares, each box as it has least.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RunsProof {
    /// The least number of runs.
    pub runs: usize,
    /// Shares by axis, box and size; whole, of [`RunsProof::all`].
    pub shares: [Vec<Vec<i128>>; 3],
    /// What is all of an axis.
    pub all: [i128; 3],
}

/// The least number of runs that can hold all boxes; of a drawn instance ([`Instance::drawn`]) with boxes that all fit.
pub fn fewest_runs(instance: &Instance) -> usize {
    runs_proof(instance).runs
}

/// The same with its reason.
pub fn runs_proof(instance: &Instance) -> RunsProof {
    nearer(instance, by_functions(instance), usize::MAX)
}

/// `known`, or more runs by scales of the boxes' own where these are not turned; ends where it is `enough`.
pub(super) fn nearer(instance: &Instance, known: RunsProof, enough: usize) -> RunsProof {
    let sizes = instance.sizes();
    if known.runs >= enough || sizes.len() > MOST_SCALED || sizes.iter().any(|turned| turned.len() != 1) {
        return known;
    }
    let functions = axes(instance, &sizes);
    let axes: [Axis; 3] = [0, 1, 2].map(|k| {
        let lengths: Vec<i64> = sizes.iter().map(|turned| turned[0][k]).collect();
        Axis::of(&lengths, longest_sum(&sizes, k, instance.space[k]), SCALE_CELLS)
    });
    let (mut best, mut work) = (known, MOST_SCALE_WORK);
    let mut numbers = SplitMix64::seeded(1);
    for _ in 0..STARTS {
        let mut scales: [Scale; 3] = [0, 1, 2].map(|k| {
            let Shares { den, of } = &functions[k][numbers.below(functions[k].len())];
            axes[k].whole(&of.iter().map(|turned| turned[0] as f64 / *den as f64).collect::<Vec<_>>())
        });
        let mut last = 0.0;
        for _ in 0..ROUNDS {
            let first = numbers.below(3);
            for k in [first, (first + 1) % 3, (first + 2) % 3] {
                let [a, b] = [(k + 1) % 3, (k + 2) % 3];
                let worth: Vec<f64> = (0..sizes.len()).map(|i| scales[a].share(i) * scales[b].share(i)).collect();
                scales[k] = axes[k].best(&worth, &mut work);
            }
            let all = [0, 1, 2].map(|k| scales[k].den);
            let sum: i128 = (0..sizes.len()).map(|i| scales.iter().map(|scale| scale.of[i]).product::<i128>()).sum();
            let den: i128 = all.iter().product();
            let runs = ((sum + den - 1) / den) as usize;
            if runs > best.runs {
                let shares = [0, 1, 2].map(|k| scales[k].of.iter().map(|&share| vec![share]).collect());
                best = RunsProof { runs, shares, all };
            }
            let now = sum as f64 / den as f64;
            if best.runs >= enough || work == 0 {
                return best;
            }
            if now < last + LEAST_GAIN {
                break;
            }
            last = now;
        }
    }
    best
}

/// The least number of runs by functions alone.
pub(super) fn by_functions(instance: &Instance) -> RunsProof {
    let sizes = instance.sizes();
    let nothing = [(); 3].map(|()| sizes.iter().map(|turned| vec![0; turned.len()]).collect());
    let mut best = RunsProof { runs: usize::from(!instance.items.is_empty()), shares: nothing, all: [1; 3] };
    each_triple(&axes(instance, &sizes), &sizes, &mut |functions| {
        let den: i128 = functions.iter().map(|f| f.den).product();
        let sum: i128 = (0..sizes.len()).map(|item| weight(functions, &sizes, item)).sum();
        let runs = ((sum + den - 1) / den) as usize;
        if runs > best.runs {
            best = RunsProof { runs, shares: functions.map(|f| f.of.clone()), all: functions.map(|f| f.den) };
        }
    });
    best
}

/// The least height of one run that holds all boxes, units; of a drawn instance ([`Instance::drawn`]) whose z is a limit, with boxes that all fit.
///
/// A height is refuted where a box is higher however it may be turned, or where the boxes need a second run of that height. What is left is
/// rounded up to a sum of the boxes' heights, where these are few: in a packing whose boxes have sunk, some stand on each other all the way up. 0
/// without boxes, one more than the limit where that is refuted itself.
pub fn least_height(instance: &Instance) -> i64 {
    let sizes = instance.sizes();
    let [.., limit] = instance.space;
    let tallest = sizes.iter().filter_map(|turned| turned.iter().map(|size| size[2]).min()).max().unwrap_or(0);
    let refuted = |height: i64| {
        let [wide, deep, _] = instance.space;
        by_functions(&Instance { space: [wide, deep, height], ..instance.clone() }).runs > 1
    };
    // All below `low` is refuted, `high` is not.
    let (mut low, mut high) = (tallest, limit + 1);
    while low < high {
        let middle = low + (high - low) / 2;
        if refuted(middle) { low = middle + 1 } else { high = middle }
    }
    match sums(&sizes, 2, limit) {
        Some(sums) => sums[sums.partition_point(|&sum| sum < low)..].first().copied().unwrap_or(limit + 1),
        None => low,
    }
}
