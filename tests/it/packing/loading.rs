//! Container loading: the published generator, and how full its containers come to be; many equal models on one plate.

use trunnion::pack::{Instance, Item, Method, PackGoal, PackSolid, Room, Turns, Watch, apart, pack_models, volume};

use super::boxes::packed;
use super::ratcliff::{TYPES, instance, types};
use super::shapes::block;
use crate::support::{note, seeds};

/// Beside thpack1 of the OR-Library (Beasley), and beside the mean counts that Bischoff and Ratcliff print.
#[test]
fn the_generator_makes_the_published_containers() {
    let published = [
        [([108, 76, 30], [0, 0, 1], 40), ([110, 43, 25], [0, 1, 1], 33), ([92, 81, 55], [1, 1, 1], 39)],
        [([49, 25, 21], [0, 1, 1], 41), ([60, 51, 41], [1, 1, 1], 53), ([103, 76, 64], [1, 1, 1], 44)],
        [([97, 81, 27], [0, 0, 1], 41), ([102, 78, 39], [0, 0, 1], 42), ([113, 46, 36], [0, 1, 1], 44)],
        [([113, 92, 33], [0, 0, 1], 67), ([52, 37, 28], [1, 1, 1], 60), ([57, 33, 29], [1, 1, 1], 70)],
        [([88, 54, 39], [0, 1, 1], 51), ([94, 54, 36], [0, 1, 1], 38), ([87, 77, 43], [0, 1, 1], 47)],
        [([86, 84, 45], [1, 1, 1], 56), ([81, 45, 34], [0, 1, 1], 56), ([70, 54, 37], [1, 1, 1], 35)],
        [([118, 79, 51], [0, 1, 1], 37), ([86, 32, 31], [0, 1, 1], 44), ([64, 58, 52], [1, 1, 1], 45)],
        [([75, 58, 57], [1, 1, 1], 58), ([57, 37, 30], [1, 1, 1], 66), ([79, 74, 35], [0, 0, 1], 56)],
    ];
    for (which, wanted) in published.iter().enumerate() {
        let made = types(1, which as u64 + 1).into_iter();
        let made: Vec<_> = made.map(|(item, count)| (item.size, item.up.map(i32::from), count)).collect();
        assert_eq!(made, wanted, "instance {}", which + 1);
    }
    for (class, mean) in (1..).zip([50.2, 27.3, 16.8, 13.3, 11.1, 8.8, 6.5]) {
        let all: usize = (1..=100).map(|which| instance(class, which).items.len()).sum();
        assert!((all as f64 / 100.0 / TYPES[class - 1] as f64 - mean).abs() < 0.06, "class {class}: {all} boxes");
    }
}

/// Much fuller than orders of single boxes make them (84 to 86 % in a second), at few steps.
#[test]
fn containers_of_every_class_come_to_be_full() {
    let mut told = Vec::new();
    for class in 1..=7 {
        let (mut full, mut count) = (0.0, 0);
        for which in seeds(1, 10).map(|seed| 1 + seed % 100) {
            let instance = instance(class, which);
            let share = |method| {
                let answer = packed(&instance, PackGoal::Filling, method, 300_000);
                let value = instance.value(&answer.placed);
                assert!(answer.bound >= value, "class {class}, {which}, {method:?}: {} of {value}", answer.bound);
                100.0 * value / volume(&instance.space)
            };
            let own = share(Method::Auto);
            assert!(own > 87.0, "class {class}, {which}: {own}");
            assert!(class > 2 || share(Method::Blocks) > 87.0, "class {class}, {which}: blocks alone");
            (full, count) = (full + own, count + 1);
        }
        told.push((class, full / f64::from(count)));
    }
    note(&format!("class, % of the container at 300,000 steps: {told:?}"));
    assert!(told.iter().map(|(_, full)| full).sum::<f64>() / 7.0 > 90.0, "{told:?}");
}

/// Boxes of 7 x 3 on 40 x 25: 47 is the most by area, and rows of one way hold 45 (13 x 3 and 8 x 5 + ..). As models, all turned about Z; the runs that
/// hold 95 of them.
#[test]
fn equal_models_on_a_plate_lie_both_ways() {
    let room = Room { space_mm: [80.0, 50.0, 4.0], gap_mm: 0.01, turns: Turns::Z90, liftable: false };
    let one = |copies| vec![PackSolid::of([&block([0.0; 3], [13.99, 5.99, 3.0])], 1.0, copies)];
    let filled = |method, goal, copies| {
        let solids = one(copies);
        let mut asked = |_| None;
        let done = pack_models(&solids, &room, goal, method, false, 1, &mut Watch::new(400_000, &mut asked)).unwrap();
        apart(&solids, &room, &done.put).unwrap();
        done
    };
    let most = filled(Method::Auto, PackGoal::Filling, 60).put.len();
    assert!(most >= 46, "{most} on a plate");
    for method in [Method::Auto, Method::Blocks] {
        let done = filled(method, PackGoal::Runs, 92);
        assert_eq!((done.runs, done.put.len()), (2, 92), "{method:?}");
    }
}

/// What is up is one of what may be, for blocks too.
#[test]
fn blocks_keep_to_what_may_be_up() {
    let item = |up| Item { size: [30, 20, 10], value: 1.0, up };
    for (up, fits) in [([true; 3], 12), ([false, false, true], 6), ([true, false, false], 2)] {
        // Lying 30 high, standing or on edge they are too high or too wide for some of the room.
        let instance = Instance { space: [60, 20, 60], gap: 0, turns: Turns::Any, items: vec![item(up); 20] };
        let answer = packed(&instance, PackGoal::Filling, Method::Blocks, 50_000);
        assert!(answer.placed.len() >= fits, "{up:?}: {}", answer.placed.len());
        assert!(answer.placed.iter().all(|p| (0..3).any(|k| up[k] && p.size[2] == item(up).size[k])));
    }
}
