//! The least height of one run: against brute force, blocks cut into boxes, and every class of the published generator.

use trunnion::geom::{Mat3, SplitMix64};
use trunnion::pack::{
    BoxPacking, Ended, Instance, Item, Method, PackGoal, PackSolid, Room, Turns, Unpackable, Watch, apart, check,
    height, least_height, pack, pack_models,
};

use super::brute;
use super::generator::instance;
use super::shapes::block;
use crate::support::{note, seeds};

/// The lowest run in so many steps, checked within what it reaches.
fn lowest(instance: &Instance, method: Method, steps: u64) -> Result<BoxPacking, Unpackable> {
    let mut asked = |_| None;
    let answer = pack(instance, PackGoal::Height, method, 1, &mut Watch::new(steps, &mut asked))?;
    let top = height(&answer.placed);
    let reached = Instance { space: [instance.space[0], instance.space[1], top], ..instance.clone() };
    check(&reached, &answer.placed, true).unwrap();
    assert!(answer.runs <= 1 && answer.bound <= top as f64);
    assert_eq!(answer.ended == Ended::Proved, answer.bound == top as f64);
    Ok(answer)
}

/// Which axes of a box may be up.
const UPS: [[bool; 3]; 4] = [[true; 3], [false, false, true], [true, false, true], [false, true, false]];

fn tiny(seed: u64) -> Instance {
    let mut numbers = SplitMix64::seeded(seed);
    let gap = i64::from(seed.is_multiple_of(4));
    let turns = [Turns::None, Turns::Z90, Turns::Any][(seed % 3) as usize];
    let items = (0..5).map(|_| {
        let size = [(); 3].map(|()| 1 + numbers.below(4) as i64);
        Item { size, value: 1.0, up: UPS[numbers.below(UPS.len())] }
    });
    Instance { items: items.collect(), space: [4, 5, 30], gap, turns }
}

#[test]
fn the_height_agrees_with_brute_force() {
    let (mut proved, mut all, mut turned) = (0, 0, 0);
    for seed in seeds(40, 1500) {
        let instance = tiny(seed);
        let least = brute::lowest(&instance);
        let bound = least_height(&instance.drawn()) - instance.gap;
        assert!(bound <= least, "{seed}: a bound of {bound}, and {least} is reached");
        (proved, all) = (proved + usize::from(bound == least), all + 1);
        let free = Instance {
            items: instance.items.iter().map(|item| Item { up: [true; 3], ..*item }).collect(),
            ..instance.clone()
        };
        turned += usize::from(brute::lowest(&free) < least);
        for method in [Method::Auto, Method::Ip, Method::IpLocalSearch] {
            if method.is_built_in() {
                let answer = lowest(&instance, method, 300_000).unwrap();
                assert_eq!(height(&answer.placed), least, "{seed}: {method:?}");
            }
        }
        let limited = Instance { space: [4, 5, least - 1], ..instance.clone() };
        let refused = lowest(&limited, Method::Auto, 20_000);
        let tall = limited.sizes().iter().any(Vec::is_empty);
        let told = matches!(refused, Err(Unpackable::NotLow(lower)) if bound <= lower && lower <= least);
        assert!(told || (tall && matches!(refused, Err(Unpackable::TooLarge(_)))), "{seed}: {refused:?}");
        let enough = Instance { space: [4, 5, least], ..instance };
        assert_eq!(lowest(&enough, Method::Auto, 300_000).map(|a| height(&a.placed)), Ok(least), "{seed}");
    }
    // Boxes that stay upright cost height here and there, and the bound is the least height in most.
    assert!(turned > 0 && proved * 2 > all, "{turned}, {proved} of {all}");
}

/// A block of 60 x 50 x `high`, cut at random into `count` boxes: nothing is lower than the block.
fn cut(seed: u64, count: usize, high: i64) -> Instance {
    let mut numbers = SplitMix64::seeded(seed);
    let mut sizes = vec![[60, 50, high]];
    while sizes.len() < count {
        let index = (0..sizes.len()).max_by_key(|&i| sizes[i].iter().product::<i64>()).unwrap();
        let size = sizes[index];
        let axis = (0..3).max_by_key(|&k| (size[k], k)).unwrap();
        let at = 1 + size[axis] / 4 + numbers.below((size[axis] / 2).max(1) as usize) as i64;
        let at = at.min(size[axis] - 1);
        sizes[index][axis] = at;
        let mut rest = size;
        rest[axis] = size[axis] - at;
        sizes.push(rest);
    }
    let items = sizes.into_iter().map(|size| Item { size, value: 1.0, up: [true; 3] });
    Instance { space: [60, 50, 1000], gap: 0, turns: Turns::None, items: items.collect() }
}

#[test]
fn a_block_cut_into_boxes_comes_near_its_height_again() {
    let mut off = Vec::new();
    for (seed, count) in seeds(3, 20).flat_map(|seed| [(seed, 8), (seed, 20), (seed, 40)]) {
        let instance = cut(seed, count, 80);
        assert_eq!(least_height(&instance), 80, "{seed}");
        let few = lowest(&instance, Method::Auto, 1).unwrap();
        let many = lowest(&instance, Method::Auto, 800_000).unwrap();
        let [start, end] = [few, many].map(|answer| height(&answer.placed));
        assert!(end <= start && end >= 80);
        off.push((count, start, end));
    }
    let worst = off.iter().map(|o| o.2).max().unwrap();
    let mean = |pick: fn(&(usize, i64, i64)) -> i64| off.iter().map(pick).sum::<i64>() as f64 / off.len() as f64;
    note(&format!("heights of blocks of 80, begun with and found: {off:?}"));
    assert!(worst <= 110 && mean(|o| o.2) < mean(|o| o.1) - 10.0, "{off:?}");
    assert!(off.iter().all(|o| o.0 > 8 || o.2 <= 88), "{off:?}");
}

#[test]
fn heights_over_every_class_hold_and_more_steps_are_never_worse() {
    let mut sums = Vec::new();
    for class in 1..=8 {
        for (boxes, which) in seeds(1, 4).flat_map(|seed| [(20, seed), (50, seed)]) {
            let mut drawn = instance(class, boxes, which);
            drawn.space[2] *= boxes as i64;
            let few = lowest(&drawn, Method::Auto, 1).unwrap();
            let more = lowest(&drawn, Method::Auto, 150_000).unwrap();
            let [start, end] = [&few, &more].map(|answer| height(&answer.placed));
            assert!(end <= start && few.bound == more.bound, "{class}, {boxes}");
            assert_eq!(more, lowest(&drawn, Method::Auto, 150_000).unwrap(), "the same steps, the same packing");
            sums.push((class, boxes, start, end, more.bound));
        }
    }
    note(&format!("class, boxes, height begun with, found, bound: {sums:?}"));
}

/// Angles that go into each other lie lower than their boxes can; plates that cover the base are proved.
#[test]
fn models_lie_low() {
    let low = |solids: &[PackSolid], room: &Room, method, steps| {
        let mut asked = |_| None;
        let mut watch = Watch::new(steps, &mut asked);
        let done = pack_models(solids, room, PackGoal::Height, method, method == Method::Auto, 1, &mut watch)?;
        apart(solids, room, &done.put).unwrap();
        let top = done.put.iter().map(|p| solids[p.model].bounds(&p.turn).max.z + p.shift.z).fold(0.0, f64::max);
        assert!(done.runs == 1 && done.bound <= top + 1e-9, "{} {top}", done.bound);
        Ok::<_, Unpackable>((done, top))
    };
    let parts = [block([0.0; 3], [60.0, 20.0, 8.0]), block([0.0, 0.0, 8.0], [8.0, 20.0, 60.0])];
    let angle = PackSolid::of(parts.iter(), 1.0, 12);
    let room = Room { space_mm: [62.0, 42.0, 800.0], gap_mm: 1.0, turns: Turns::Any, liftable: false };
    for method in [Method::Auto, Method::Coverings] {
        let (done, top) = low(std::slice::from_ref(&angle), &room, method, 6_000_000).unwrap();
        assert!(done.put.len() == 12 && top < done.boxes - 20.0, "{method:?}: {top}, as boxes {}", done.boxes);
        assert_ne!(done.ended, Ended::Proved);
    }
    let plate = PackSolid::of([&block([0.0; 3], [30.0, 20.0, 5.0])], 1.0, 4);
    let flat = Room { turns: Turns::Z90, ..room };
    let (done, top) = low(std::slice::from_ref(&plate), &flat, Method::Auto, 500_000).unwrap();
    assert_eq!((top, done.bound, done.ended), (5.0, 5.0, Ended::Proved));
    let tall = PackSolid::of([&block([0.0; 3], [60.0, 40.0, 30.0])], 1.0, 3);
    let close = Room { space_mm: [62.0, 42.0, 91.9], turns: Turns::None, ..room };
    let refused = low(std::slice::from_ref(&tall), &close, Method::Auto, 500_000).map(|(done, _)| done.put.len());
    assert!(matches!(refused, Err(Unpackable::NotLow(bound)) if bound > 30_000 && bound <= 92_000), "{refused:?}");
    let enough = Room { space_mm: [62.0, 42.0, 92.0], ..close };
    let (done, top) = low(std::slice::from_ref(&tall), &enough, Method::Auto, 500_000).unwrap();
    assert!(done.put.iter().all(|p| p.turn == Mat3::identity()) && (top - 92.0).abs() < 1e-9);
    let annealed = low(std::slice::from_ref(&tall), &enough, Method::Anneal, 1000).map(|(_, top)| top);
    assert_eq!(annealed, Err(Unpackable::OnlyFilling));
    let by_tabu = low(std::slice::from_ref(&tall), &enough, Method::Tabu, 1000).map(|(_, top)| top);
    assert_eq!(by_tabu, Err(Unpackable::NoHeight));
}
