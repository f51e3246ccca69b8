//! Boxes in a given order into one run, and the first solution of all: first fit by falling volume, by several rules.

use super::instance::{Instance, Placed, Triple, volume};
use super::spaces::{Rule, Run};
use super::watch::Watch;

/// An instance made ready for searches: drawn out by its gap, with each box's sizes.
#[derive(Clone)]
pub(super) struct Ready {
    pub(super) space: Triple,
    pub(super) sizes: Vec<Vec<Triple>>,
    pub(super) volumes: Vec<f64>,
    pub(super) values: Vec<f64>,
    /// Boxes of the same sizes share a number.
    alike: Vec<usize>,
    /// How many such numbers there are, where some boxes are alike; else 0.
    kinds: usize,
    /// The least length along each axis.
    pub(super) least: Triple,
}

impl Ready {
    /// Of a drawn instance.
    pub(super) fn of(drawn: &Instance) -> Self {
        let sizes = drawn.sizes();
        let least = [0, 1, 2].map(|k| sizes.iter().flatten().map(|size| size[k]).min().unwrap_or(1));
        let mut known = std::collections::HashMap::new();
        let alike: Vec<usize> = sizes
            .iter()
            .map(|turned| {
                let next = known.len();
                *known.entry(turned).or_insert(next)
            })
            .collect();
        let kinds = if known.len() < sizes.len() { known.len() } else { 0 };
        Self {
            alike,
            kinds,
            space: drawn.space,
            volumes: drawn.items.iter().map(|item| volume(&item.size)).collect(),
            values: drawn.items.iter().map(|item| item.value).collect(),
            sizes,
            least,
        }
    }

    /// Whether some boxes are alike.
    pub(super) fn has_equal(&self) -> bool {
        self.kinds > 0
    }

    /// Puts what fits of `order` into `run`, one after the other; what does not fit stays in `order`. `turns`: by box which of its turns it
    /// must have, from 1; 0 for any, and none given for any of all.
    pub(super) fn fill(&self, run: &mut Run, order: &mut Vec<usize>, turns: &[u8], rule: Rule, watch: &mut Watch<'_>) {
        watch.spend(order.len() as u64);
        // Room only shrinks: what did not fit does not fit later, nor do boxes like it.
        let mut failed = vec![false; self.kinds * TURNS];
        order.retain(|&item| {
            let turn = usize::from(turns.get(item).copied().unwrap_or(0));
            let kind = self.alike[item] * TURNS + turn;
            if self.kinds > 0 && failed[kind] {
                return true;
            }
            let all = &self.sizes[item];
            let sizes = if turn > 0 { std::slice::from_ref(&all[(turn - 1) % all.len()]) } else { all };
            let place = run.place_for(sizes, rule);
            if let Some((at, size)) = place {
                run.put(item, at, size, &self.least);
            } else if self.kinds > 0 {
                failed[kind] = true;
            }
            place.is_none()
        });
    }
}

/// Turns of a box, and any of them.
const TURNS: usize = 7;

/// The rules that a search draws from.
pub(super) const RULES: [Rule; 7] = [
    Rule::Lowest([2, 1, 0]),
    Rule::Lowest([0, 1, 2]),
    Rule::Lowest([1, 2, 0]),
    Rule::Far,
    Rule::Snug,
    Rule::Touching,
    Rule::Lowest([2, 0, 1]),
];

/// All boxes in as few runs as first fit finds, by falling volume and by falling longest side, for each rule.
pub(super) fn first_fit(ready: &Ready, watch: &mut Watch<'_>) -> Vec<Vec<Placed>> {
    let longest = |item: usize| ready.sizes[item].iter().flatten().copied().max().unwrap_or(0) as f64;
    let area = |item: usize| ready.sizes[item].first().map_or(0.0, |s| s[0] as f64 * s[1] as f64);
    let keys: [&dyn Fn(usize) -> f64; 3] = [&|item| ready.volumes[item], &longest, &area];
    let mut best: Option<Vec<Vec<Placed>>> = None;
    for rule in RULES {
        for key in keys {
            // One solution there must be, however short the time.
            if best.is_some() && !watch.goes_on() {
                break;
            }
            let mut order: Vec<usize> = (0..ready.sizes.len()).collect();
            order.sort_by(|&a, &b| key(b).total_cmp(&key(a)).then(a.cmp(&b)));
            let runs = one_by_one(ready, order, rule, watch);
            if best.as_ref().is_none_or(|known| runs.len() < known.len()) {
                best = Some(runs);
            }
        }
    }
    best.unwrap_or_default()
}

/// Run after run, each filled with what fits of what is left; the same as first fit, since a full run stays as it is.
pub(super) fn one_by_one(ready: &Ready, mut order: Vec<usize>, rule: Rule, watch: &mut Watch<'_>) -> Vec<Vec<Placed>> {
    let mut runs = Vec::new();
    while !order.is_empty() {
        let mut run = Run::empty(ready.space);
        ready.fill(&mut run, &mut order, &[], rule, watch);
        runs.push(run.placed);
    }
    runs
}
