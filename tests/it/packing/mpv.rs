//! Published instances: the generator draws what it should, and few steps come near the published best.

use trunnion::pack::{Method, PackGoal};

use super::boxes::packed;
use super::generator::Numbers;
pub(super) use super::generator::instance;
use crate::support::{note, seeds};

#[test]
fn the_generator_draws_as_lrand48() {
    // The first of `srand48(1)`, as POSIX has them.
    let mut numbers = Numbers::seeded(1);
    let first = [(); 3].map(|()| numbers.between(0, i64::from(i32::MAX)));
    assert_eq!(first, [89_400_484, 976_015_093, 1_792_756_325]);
}

/// Runs in all at few steps; the published best of 50 boxes are 134, 294, 83, 98, 74, 92.
#[test]
fn fifty_boxes_of_each_class_come_near_the_published_best() {
    let best = [(1, 134), (4, 294), (5, 83), (6, 98), (7, 74), (8, 92)];
    let mut sums = Vec::new();
    for (class, published) in best {
        let (mut runs, mut bound) = (0, 0);
        for which in 1..=10 {
            let instance = instance(class, 50, which);
            let answer = packed(&instance, PackGoal::Runs, Method::Auto, 150_000);
            assert!(answer.runs as f64 >= answer.bound);
            (runs, bound) = (runs + answer.runs, bound + answer.bound as usize);
        }
        assert!(bound <= published && bound * 100 >= published * 90, "class {class}: a bound of {bound}");
        assert!(runs <= published + 2, "class {class}: {runs} runs");
        sums.push((class, runs, bound));
    }
    note(&format!("class, runs, bound of 50 boxes: {sums:?}"));
}

/// No method ever says what cannot be: each box is in one run, within the space and beside all others, and no answer has more runs than first fit
/// by volume, with which all of them begin. Tabu search lost boxes where a move made two runs too many.
#[test]
fn every_method_holds_over_every_class() {
    for class in [1, 4, 5, 6, 7, 8] {
        for (boxes, which) in seeds(1, 4).flat_map(|seed| [(12, seed), (20, seed), (50, seed)]) {
            let instance = instance(class, boxes, which);
            for method in [Method::Auto, Method::Tabu, Method::Ip, Method::IpLocalSearch] {
                if !method.is_built_in() || (boxes > 20 && method != Method::Tabu) {
                    continue;
                }
                let few = packed(&instance, PackGoal::Runs, method, 1);
                let more = packed(&instance, PackGoal::Runs, method, 60_000);
                assert!(more.runs <= few.runs && more.runs as f64 >= more.bound, "{class}, {boxes}, {method:?}");
            }
        }
    }
}
