//! The container loading instances of Bischoff and Ratcliff, "Issues in the development of approaches to container loading" (1995), from their generator:
//! numbers by the factor 16807 (Park and Miller's minimal standard), the first ten left out, seeds a hundred apart.

use trunnion::pack::{Instance, Item, Triple, Turns};

/// The container, cm.
const CONTAINER: Triple = [587, 233, 220];
/// Types of boxes in classes 1 to 7.
pub(super) const TYPES: [usize; 7] = [3, 5, 8, 10, 12, 15, 20];
/// The least and the greatest lengths.
const LENGTHS: [[f64; 2]; 3] = [[30.0, 120.0], [25.0, 100.0], [20.0, 80.0]];
/// A length is only upright where it is less than so many times the shorter of the others.
const STABLE: i64 = 2;

/// Evenly from 0 to 1.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0 * 16807 % 0x7fff_ffff;
        self.0 as f64 / f64::from(0x7fff_ffff)
    }
}

/// Each type of boxes with how many there are, of instance `which` (1 to 100) of a class.
pub(super) fn types(class: usize, which: u64) -> Vec<(Item, usize)> {
    let mut numbers = Numbers(2_502_505 + 100 * (which - 1));
    (0..10).for_each(|_| {
        numbers.next();
    });
    let room: i64 = CONTAINER.iter().product();
    let mut all: Vec<(Item, usize)> = Vec::new();
    for _ in 0..TYPES[class - 1] {
        let mut size = LENGTHS.map(|[least, most]| (least + (numbers.next() * (most - least + 1.0)).floor()) as i64);
        size.sort_unstable_by(|a, b| b.cmp(a));
        let up = [0, 1, 2].map(|k| size[k] < STABLE * size[(k + 1) % 3].min(size[(k + 2) % 3]));
        all.push((Item { size, value: size.iter().product::<i64>() as f64, up }, 1));
    }
    let volume = |item: &Item| item.size.iter().product::<i64>();
    let mut taken: i64 = all.iter().map(|(item, _)| volume(item)).sum();
    loop {
        let drawn = (numbers.next() * all.len() as f64) as usize;
        taken += volume(&all[drawn].0);
        if taken > room {
            return all;
        }
        all[drawn].1 += 1;
    }
}

/// The same, every box by itself.
pub(super) fn instance(class: usize, which: u64) -> Instance {
    let items = types(class, which).into_iter().flat_map(|(item, count)| std::iter::repeat_n(item, count));
    Instance { space: CONTAINER, gap: 0, turns: Turns::Any, items: items.collect() }
}
