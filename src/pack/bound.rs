//! What no packing can beat: dual feasible functions along each axis.
//!
//! A dual feasible function f takes shares of a length to shares so that shares that fit beside each other still do. Boxes of a run then have at
//! most a volume of one when each length is taken through such a function (Fekete and Schepers, "A general framework for bounds for
//! higher-dimensional orthogonal packing problems", 2004): the sum over all boxes, rounded up, is a number of runs that none can go
//! below, and a run's value is at most what a knapsack of one holds. The bounds L0 (volume), L1 and much of L2 of Martello, Pisinger
//! and Vigo (2000) are cases of it. Functions: the identity, thresholds (f0), steps (u) of Fekete and Schepers, and the halving f2 of Carlier, Clautiaux
//! and Moukrim (2007). All shares are fractions of whole numbers: what comes out is exact.
//!
//! Before that the space is cut down to the longest sums of boxes' lengths that fit in it, where these are few.

use super::instance::{Instance, Triple};

/// A function along one axis, as what it makes of a length, over `den`.
#[derive(Clone)]
pub(super) struct Shares {
    pub(super) den: i128,
    /// By item, then by the item's turned sizes.
    pub(super) of: Vec<Vec<i128>>,
}

/// Functions that are tried on an axis, at most.
const MOST: usize = 24;
/// Sums of lengths that are kept, at most.
const MOST_SUMS: usize = 20_000;
/// Boxes whose sums are looked at, at most.
const MOST_SUMMED: usize = 500;
/// Boxes times triples of functions that are looked at, at most.
const MOST_WORK: usize = 4_000_000;

/// The most value that one run can hold; boxes that do not fit count nothing.
pub fn most_value(instance: &Instance) -> f64 {
    let sizes = instance.sizes();
    let fitting = |item: &usize| !sizes[*item].is_empty();
    let mut best: f64 = (0..sizes.len()).filter(fitting).map(|item| instance.items[item].value).sum();
    each_triple(&axes(instance, &sizes), &sizes, &mut |functions| {
        let den: f64 = functions.iter().map(|f| f.den as f64).product();
        let mut all: Vec<(f64, f64)> = (0..sizes.len())
            .filter(fitting)
            .map(|item| (weight(functions, &sizes, item) as f64 / den, instance.items[item].value))
            .collect();
        let worth = |(weight, value): &(f64, f64)| if *weight > 0.0 { value / weight } else { f64::INFINITY };
        all.sort_by(|a, b| worth(b).total_cmp(&worth(a)));
        best = best.min(knapsack(&all));
    });
    best
}

/// The value of a knapsack of one whose last thing may be cut (Dantzig), a little more for rounding; things by falling value a weight.
fn knapsack(sorted: &[(f64, f64)]) -> f64 {
    let (mut room, mut value) = (1.0, 0.0);
    for (weight, worth) in sorted {
        if *weight <= room {
            room -= weight;
            value += worth;
        } else {
            value += worth * room / weight;
            break;
        }
    }
    value * (1.0 + 1e-9)
}

/// The least that an item takes of a run, over the product of the denominators.
pub(super) fn weight(functions: [&Shares; 3], sizes: &[Vec<Triple>], item: usize) -> i128 {
    let turned = 0..sizes[item].len();
    turned.map(|t| functions.iter().map(|f| f.of[item][t]).product()).min().unwrap_or(0)
}

/// Triples of functions: all of them where they are few, else each with the identity and with itself along the other axes.
pub(super) fn each_triple(axes: &[Vec<Shares>; 3], sizes: &[Vec<Triple>], visit: &mut dyn FnMut([&Shares; 3])) {
    let all: usize = axes.iter().map(Vec::len).product::<usize>() * sizes.len();
    let whole = all <= MOST_WORK;
    for (i, x) in axes[0].iter().enumerate() {
        for (j, y) in axes[1].iter().enumerate() {
            for (k, z) in axes[2].iter().enumerate() {
                let plain = usize::from(i == 0) + usize::from(j == 0) + usize::from(k == 0);
                if whole || plain >= 2 || (i == j && j == k) {
                    visit([x, y, z]);
                }
            }
        }
    }
}

pub(super) fn axes(instance: &Instance, sizes: &[Vec<Triple>]) -> [Vec<Shares>; 3] {
    [0, 1, 2].map(|k| {
        let mut lengths: Vec<i64> = sizes.iter().flatten().map(|size| size[k]).collect();
        let room = longest_sum(sizes, k, instance.space[k]);
        lengths.sort_unstable();
        lengths.dedup();
        functions(room, &lengths)
            .into_iter()
            .map(|(den, f)| Shares { den, of: sizes.iter().map(|t| t.iter().map(|s| f(s[k])).collect()).collect() })
            .collect()
    })
}

type Function = Box<dyn Fn(i64) -> i128>;

/// The functions along an axis of length `room`, the identity first, with their denominators.
fn functions(room: i64, lengths: &[i64]) -> Vec<(i128, Function)> {
    let w = i128::from(room);
    let mut all: Vec<(i128, Function)> = vec![(w, Box::new(i128::from))];
    for steps in 1..=4_i128 {
        // u: (k + 1) x where that is whole, else rounded down and over k.
        all.push((
            steps * w,
            Box::new(move |x| {
                let x = i128::from(x);
                if (steps + 1) * x % w == 0 { steps * x } else { (steps + 1) * x / w * w }
            }),
        ));
    }
    let halves: Vec<i64> = spread(lengths.iter().copied().filter(|&x| 0 < x && 2 * x <= room).collect(), MOST / 2 - 3);
    for &least in &halves {
        // f0: what leaves less than `least` counts as the whole, what is less than it as nothing.
        all.push((
            w,
            Box::new(move |x| {
                if x > room - least {
                    w
                } else if x < least {
                    0
                } else {
                    i128::from(x)
                }
            }),
        ));
    }
    let beyond = lengths.iter().map(|&x| room - x + 1).filter(|&x| 0 < x && 2 * x <= room);
    let mut steps: Vec<i64> = halves.into_iter().chain(beyond).chain([room / 2]).filter(|&x| x > 0).collect();
    steps.sort_unstable();
    steps.dedup();
    for step in spread(steps, MOST - all.len().min(MOST - 4)) {
        // f2: whole steps, counted from the far end beyond the half.
        let whole = i128::from(room / step);
        all.push((
            2 * whole,
            Box::new(move |x| match (2 * x).cmp(&room) {
                std::cmp::Ordering::Greater => 2 * (whole - i128::from((room - x) / step)),
                std::cmp::Ordering::Equal => whole,
                std::cmp::Ordering::Less => 2 * i128::from(x / step),
            }),
        ));
    }
    all
}

/// At most `count` of them, evenly spread.
fn spread(all: Vec<i64>, count: usize) -> Vec<i64> {
    if all.len() <= count {
        return all;
    }
    (0..count).map(|i| all[i * (all.len() - 1) / (count - 1).max(1)]).collect()
}

/// The longest sum of lengths along axis `k`, each box once and as turned in any way, that is at most `room`; `room` where sums are many.
pub(super) fn longest_sum(sizes: &[Vec<Triple>], k: usize, room: i64) -> i64 {
    let longest = each_sum(sizes, k, room, |sums| sums.last() == Some(&room)).and_then(|sums| sums.last().copied());
    // Without boxes nothing is divided by it.
    longest.filter(|&sum| sum > 0).unwrap_or(room)
}

/// All sums of lengths along axis `k` that are at most `room`, from 0 up, each box once and as turned in any way; `None` where they are many.
pub(super) fn sums(sizes: &[Vec<Triple>], k: usize, room: i64) -> Option<Vec<i64>> {
    if sizes.len() > MOST_SUMMED {
        return None;
    }
    each_sum(sizes, k, room, |_| false)
}

/// The sums; those so far where `enough` says so.
fn each_sum(sizes: &[Vec<Triple>], k: usize, room: i64, enough: impl Fn(&[i64]) -> bool) -> Option<Vec<i64>> {
    let mut sums = vec![0_i64];
    for turned in sizes {
        let mut more: Vec<i64> =
            turned.iter().flat_map(|s| sums.iter().map(move |sum| sum + s[k])).filter(|&sum| sum <= room).collect();
        more.sort_unstable();
        more.dedup();
        sums.extend(more);
        sums.sort_unstable();
        sums.dedup();
        if enough(&sums) {
            break;
        }
        if sums.len() > MOST_SUMS {
            return None;
        }
    }
    Some(sums)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::SplitMix64;

    /// Shares that fit beside each other still do: the definition, on all combinations of lengths.
    #[test]
    fn every_function_is_dual_feasible() {
        let mut numbers = SplitMix64::seeded(3);
        for room in [7, 10, 12, 30, 97] {
            let lengths: Vec<i64> = (1..=room).collect();
            for (index, (den, f)) in functions(room, &lengths).into_iter().enumerate() {
                // The most that lengths of a given sum come to, by dynamic programming over the definition.
                let mut most = vec![0_i128; room as usize + 1];
                for sum in 1..=room {
                    most[sum as usize] = (1..=sum).map(|x| most[(sum - x) as usize] + f(x)).max().unwrap();
                }
                assert!(most.iter().all(|&m| m <= den), "function {index} of {room}: {most:?} over {den}");
                assert!((0..50).all(|_| f(1 + numbers.below(room as usize) as i64) >= 0));
            }
        }
    }

    #[test]
    fn the_space_shrinks_to_what_lengths_add_up_to() {
        let sizes = |all: &[i64]| all.iter().map(|&x| vec![[x, 1, 1]]).collect::<Vec<_>>();
        assert_eq!(longest_sum(&sizes(&[7, 7, 4]), 0, 13), 11);
        assert_eq!(longest_sum(&sizes(&[20]), 0, 13), 13);
    }
}
