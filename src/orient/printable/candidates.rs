//! Poses worth a price: those the part rests in, its flat faces, minima of what is cheap to evaluate, and an even spread.

use rayon::prelude::*;

use super::super::sphere::lattice;
use super::super::trial::Trial;
use super::super::{
    Certified, Facets, Found, Height, NelderMead, Objective, Search, SupportVolumeConvex, WeightedNormalZ, nelder_mead,
};
use super::price::Priced;
use super::resting::push;
use super::supports::Supports;
use super::{Printable, Process, ROUGH, columns, planes};
use crate::geom::Vec3;

/// An even spread of so many directions: one every eleven degrees.
const SPREAD: usize = 320;
/// Of the exact poses so many are looked at closely.
const CLOSELY: usize = 32;
/// Minima of an objective that are taken.
const MINIMA: usize = 6;
/// Walks downhill from the best so far, evaluations of each, and the simplex that ends them, radians.
const WALKS: usize = 8;
const STEPS: usize = 48;
const WALKED: f64 = 2e-3;
/// Walks begin so far apart, radians: ten degrees.
const APART: f64 = 0.17;

/// Poses with rough prices.
pub(super) struct Candidates {
    /// Poses by the part's own planes, priced on the part itself.
    pub(super) exact: Vec<Priced>,
    /// Poses in between.
    pub(super) free: Vec<Priced>,
    /// The least height, and no pose's is below its bound.
    pub(super) height: Found,
    /// How many poses were priced.
    pub(super) evaluations: usize,
}

/// `rough` is the part with fewer facets, or the part itself; `also` are poses that are looked at in any case. At most `budget` poses
/// are priced (what is cheap to evaluate is not counted).
pub(super) fn candidates(
    facets: &Facets,
    rough: &Facets,
    process: &Process,
    also: &[Vec3],
    budget: usize,
) -> Candidates {
    let height = Certified { gap: 1e-2, budget: 4_000 }.search(&Height, facets);
    let mut planes = planes(facets);
    planes.truncate(budget / 4);
    let spread = SPREAD.min(budget / 4);
    let mut between: Vec<Vec3> = (0..spread).map(|i| lattice(i, spread)).collect();
    let convex = SupportVolumeConvex { overhang: process.overhang };
    let heavy = Certified { gap: 1e-3, budget: 20_000 }.search(&WeightedNormalZ, rough);
    let light = NelderMead { starts: 16, budget: 1_600, ..NelderMead::default() }.search(&convex, rough);
    for found in [&height, &heavy, &light] {
        between.extend(found.minima.iter().take(MINIMA).map(|m| m.up));
    }
    let mut exact = priced(rough, process, &planes);
    keep(&mut exact, CLOSELY.min(budget / 8));
    let mut closely: Vec<Vec3> = also.to_vec();
    exact.iter().for_each(|p| push(&mut closely, p.up));
    let exact = priced(facets, process, &closely);
    let mut free = priced(rough, process, &between);
    let evaluations = planes.len() + closely.len() + between.len();
    let mut walk = Walk { rough, spent: 0, budget: budget.saturating_sub(evaluations) };
    let starts: Vec<Priced> = exact.iter().chain(&free).copied().collect();
    let cheapest = apart(&starts, |p| p.price_min);
    let barest = apart(&starts, |p| p.support_mm3);
    let mut walked = walk.down(&Printable { process: *process }, &cheapest);
    walked.extend(walk.down(&Columns { process }, &barest[..barest.len().min(WALKS / 2)]));
    free.extend(priced(rough, process, &walked));
    Candidates { exact, free, height, evaluations: evaluations + walk.spent }
}

/// The volume of supports alone.
struct Columns<'a> {
    process: &'a Process,
}

impl Objective for Columns<'_> {
    fn name(&self) -> &str {
        "columns"
    }

    fn value(&self, facets: &Facets, up: &Vec3) -> f64 {
        let Process { overhang, layer_mm, .. } = *self.process;
        Supports::of(facets, up, overhang, layer_mm, columns(facets, ROUGH)).volume_mm3
    }

    fn gradient(&self, _: &Facets, _: &Vec3) -> Option<Vec3> {
        None
    }
}

/// Walks downhill.
struct Walk<'a> {
    rough: &'a Facets,
    spent: usize,
    /// Each walk is counted with its end, which is priced again.
    budget: usize,
}

impl Walk<'_> {
    fn down(&mut self, objective: &dyn Objective, starts: &[Vec3]) -> Vec<Vec3> {
        let walk = |start: &Vec3| {
            let mut trial = Trial::new(objective, self.rough, STEPS);
            (nelder_mead::descend(&mut trial, *start, STEPS, WALKED).up, trial.spent())
        };
        let most = starts.len().min(self.budget.saturating_sub(self.spent) / (STEPS + 1));
        let ends: Vec<(Vec3, usize)> = starts[..most].par_iter().map(walk).collect();
        self.spent += ends.iter().map(|(_, spent)| spent + 1).sum::<usize>();
        ends.into_iter().map(|(up, _)| up).collect()
    }
}

/// Rough prices, in the order of `ups`.
pub(super) fn priced(facets: &Facets, process: &Process, ups: &[Vec3]) -> Vec<Priced> {
    let (mass, width) = (facets.mass(), columns(facets, ROUGH));
    ups.par_iter().map(|up| process.price(facets, mass, up, width)).collect()
}

/// The best few by price, and the best by each figure.
fn keep(all: &mut Vec<Priced>, most: usize) {
    all.sort_by(|a, b| a.price_min.total_cmp(&b.price_min));
    if all.len() <= most {
        return;
    }
    let figures: [fn(&Priced) -> f64; 4] =
        [|p| p.support_mm3, |p| -p.footprint_mm2, |p| p.height_mm, |p| p.stepped_mm2];
    let mut kept = all[..most].to_vec();
    kept.extend(figures.iter().filter_map(|f| all[most..].iter().min_by(|a, b| f(a).total_cmp(&f(b)))));
    *all = kept;
}

/// The best by `figure`, far from each other.
fn apart(all: &[Priced], figure: impl Fn(&Priced) -> f64) -> Vec<Vec3> {
    let mut order: Vec<&Priced> = all.iter().collect();
    order.sort_by(|a, b| figure(a).total_cmp(&figure(b)));
    let mut kept: Vec<Vec3> = Vec::new();
    for pose in order {
        if kept.len() < WALKS && kept.iter().all(|known| (known - pose.up).norm() > APART) {
            kept.push(pose.up);
        }
    }
    kept
}
