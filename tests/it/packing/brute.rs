//! The definitions, tried out: every corner of every box on a small grid, every way of dealing boxes out to runs.

use trunnion::pack::{Instance, Triple, Turns};

/// Whether the boxes go into one space, wherever their corners are.
fn together(space: Triple, gap: i64, boxes: &[Vec<Triple>], placed: &mut Vec<(Triple, Triple)>) -> bool {
    let Some((first, rest)) = boxes.split_first() else { return true };
    for size in first {
        for x in 0..=space[0] - size[0] {
            for y in 0..=space[1] - size[1] {
                for z in 0..=space[2] - size[2] {
                    let at = [x, y, z];
                    let apart = |(low, other): &(Triple, Triple)| {
                        (0..3).any(|k| at[k] + size[k] + gap <= low[k] || low[k] + other[k] + gap <= at[k])
                    };
                    if placed.iter().all(apart) {
                        placed.push((at, *size));
                        if together(space, gap, rest, placed) {
                            return true;
                        }
                        placed.pop();
                    }
                }
            }
        }
    }
    false
}

/// The sizes that a box may have, by the definition.
fn sizes(instance: &Instance, item: usize) -> Vec<Triple> {
    let own = &instance.items[item];
    let all = instance.turns.sizes(own.size);
    let any = instance.turns != Turns::Any;
    all.into_iter().filter(|size| any || (0..3).any(|k| own.up[k] && size[2] == own.size[k])).collect()
}

/// The least height of one run that holds all boxes.
pub(super) fn lowest(instance: &Instance) -> i64 {
    let all = (1_usize << instance.items.len()) - 1;
    let [wide, deep, _] = instance.space;
    let fits_in = |height: &i64| fits(&Instance { space: [wide, deep, *height], ..instance.clone() }, all);
    (1..).find(fits_in).unwrap()
}

/// Whether the boxes of `chosen` (bits) go into one run.
fn fits(instance: &Instance, chosen: usize) -> bool {
    let boxes: Vec<Vec<Triple>> =
        (0..instance.items.len()).filter(|i| chosen >> i & 1 == 1).map(|i| sizes(instance, i)).collect();
    together(instance.space, instance.gap, &boxes, &mut Vec::new())
}

/// The least number of runs.
pub(super) fn fewest(instance: &Instance) -> usize {
    let all = (1_usize << instance.items.len()) - 1;
    let one: Vec<bool> = (0..=all).map(|chosen| fits(instance, chosen)).collect();
    let mut runs = vec![usize::MAX; all + 1];
    runs[0] = 0;
    for chosen in 1..=all {
        let mut part = chosen;
        while part > 0 {
            if one[part] && runs[chosen ^ part] != usize::MAX {
                runs[chosen] = runs[chosen].min(runs[chosen ^ part] + 1);
            }
            part = (part - 1) & chosen;
        }
    }
    runs[all]
}

/// The most value in one run.
pub(super) fn most(instance: &Instance) -> f64 {
    let worth = |chosen: usize| -> f64 {
        (0..instance.items.len()).filter(|i| chosen >> i & 1 == 1).map(|i| instance.items[i].value).sum()
    };
    (0..1_usize << instance.items.len()).filter(|&chosen| fits(instance, chosen)).map(worth).fold(0.0, f64::max)
}
