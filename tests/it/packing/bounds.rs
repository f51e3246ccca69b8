//! Bounds of runs: a checker of their proofs that shares nothing with what finds them, and brute force.

use trunnion::geom::SplitMix64;
use trunnion::pack::{Instance, Item, RunsProof, Turns, fewest_runs, runs_proof};

use super::{brute, generator};
use crate::support::{note, seeds};

/// Whether a proof is one, from the definition alone: along each axis the boxes that fit, each in one of its sizes, have at most all shares; then each run holds at most one of the products.
fn holds(instance: &Instance, proof: &RunsProof) -> bool {
    let sizes = instance.sizes();
    let shaped = |axis: &Vec<Vec<i128>>| {
        axis.len() == sizes.len() && axis.iter().zip(&sizes).all(|(own, sizes)| own.len() == sizes.len())
    };
    if !proof.shares.iter().all(shaped) || proof.shares.iter().flatten().flatten().any(|&share| share < 0) {
        return false;
    }
    for (k, shares) in proof.shares.iter().enumerate() {
        // The most shares that lengths of a sum have, box by box.
        let room = instance.space[k] as usize;
        let mut most = vec![0_i128; room + 1];
        for (sizes, shares) in sizes.iter().zip(shares) {
            let before = most.clone();
            for (size, share) in sizes.iter().zip(shares) {
                for at in size[k] as usize..=room {
                    most[at] = most[at].max(before[at - size[k] as usize] + share);
                }
            }
        }
        if most[room] > proof.all[k] {
            return false;
        }
    }
    let least = |item: usize| {
        let products = (0..sizes[item].len()).map(|t| proof.shares.iter().map(|axis| axis[item][t]).product::<i128>());
        products.min().unwrap_or(0)
    };
    let (sum, all): (i128, i128) = ((0..sizes.len()).map(least).sum(), proof.all.iter().product());
    // More than so many runs hold; one run there is for any box.
    proof.runs <= 1.min(sizes.len()) || (proof.runs as i128 - 1) * all < sum
}

/// All 60 published instances of 50 boxes: each proof is checked, a forged one is not taken, and by functions alone it was 745.
#[test]
fn published_bounds_are_proved() {
    let mut all = 0;
    for (class, published) in [(1, 134), (4, 294), (5, 83), (6, 98), (7, 74), (8, 92)] {
        let mut runs = 0;
        for which in 1..=10 {
            let instance = generator::instance(class, 50, which);
            let proof = runs_proof(&instance);
            assert!(holds(&instance, &proof), "class {class}, {which}");
            let more = RunsProof { runs: proof.runs + 1, ..proof.clone() };
            let mut wider = proof.clone();
            wider.all[0] -= 1;
            assert!(!holds(&instance, &more) && !holds(&instance, &wider), "class {class}, {which}: forged");
            runs += proof.runs;
        }
        assert!(runs <= published, "class {class}: {runs}");
        all += runs;
    }
    note(&format!("{all} runs at least for the 60 instances of 50 boxes"));
    assert!(all >= 765, "{all}");
}

/// Small boxes in all turns: no bound above the least number of runs, and each proof is one.
#[test]
fn no_bound_is_above_the_least_number() {
    let (mut met, mut all) = (0, 0);
    for seed in seeds(150, 6000) {
        let mut numbers = SplitMix64::seeded(seed + 70_000);
        let space = [(); 3].map(|()| 4 + numbers.below(3) as i64);
        let turns = [Turns::None, Turns::None, Turns::None, Turns::Z90, Turns::Any][seed as usize % 5];
        let items = (0..4 + numbers.below(2)).map(|_| {
            let size = [0, 1, 2].map(|k| 1 + numbers.below(space[k] as usize - 1) as i64);
            Item { size, value: 1.0, up: [true; 3] }
        });
        let instance = Instance { space, gap: 0, turns, items: items.collect() };
        let (proof, fewest) = (runs_proof(&instance), brute::fewest(&instance));
        assert!(proof.runs <= fewest && holds(&instance, &proof), "{seed}: {} of {fewest}", proof.runs);
        assert_eq!(proof.runs, fewest_runs(&instance));
        met += usize::from(proof.runs == fewest);
        all += 1;
    }
    assert!(met * 10 > all * 8, "{met} of {all} bounds are met");
}
