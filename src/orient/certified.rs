//! Branch and bound over the sphere: the best value, and a lower bound that no direction is below.
//!
//! Cells are squares on the faces of a cube, seen from its middle. Such a square lies within the cap about its centre
//! that holds its four corners: on the face's plane the cap is a convex region (a conic), so with the corners it holds
//! the square. The bounds over caps are proved in [`bound`](super::bound); none is a sample. Rounding is allowed for by
//! 1e-12 of each value.

use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::sync::Arc;

use super::bound::lower;
use super::nelder_mead::descend;
use super::sphere::lattice;
use super::trial::Trial;
use super::{Cap, Facets, Found, Local, Minimum, NelderMead, Objective, Proof, Search, Stop};
use crate::geom::Vec3;

/// Best-first branch and bound, begun with the minima of simplex searches.
///
/// For an objective without bounds ([`Objective::local`] says `None`) only those minima come back, with no lower bound.
#[derive(Clone, Copy, Debug)]
pub struct Certified {
    /// Ends when the lower bound is within this of the best value, relative.
    pub gap: f64,
    /// Evaluations and bounds together at most; the bound reached is valid wherever that ends it.
    pub budget: usize,
}

impl Default for Certified {
    fn default() -> Self {
        Self { gap: 1e-6, budget: 400_000 }
    }
}

impl Certified {
    /// As far as is worth it for `objective`.
    pub fn of(objective: &dyn Objective) -> Self {
        let Proof { gap, budget } = objective.proof();
        Self { gap, budget }
    }
}

/// Of the budget, what the simplex searches at the beginning may take.
const FIRST_SHARE: usize = 4;
/// Simplex searches at the beginning: for the list of local minima, the best is found whatever their number.
const STARTS: usize = 10;
/// Evaluations of each of them, and the simplex (radians) that ends it: local minima are listed to 0.001 degrees.
const FIRST: usize = 80;
const FIRST_STEP: f64 = 1e-5;
/// Evaluations of a descent from a direction that beats the best so far, and the simplex that ends it.
const POLISH: usize = 200;
const POLISHED: f64 = 1e-9;

impl Certified {
    /// The search begun with a direction that is known already, and with no other: its bound, and what is better.
    pub(super) fn improving(&self, objective: &dyn Objective, facets: &Facets, known: &Minimum) -> Found {
        let mut trial = Trial::new(objective, facets, self.budget);
        let best = trial.at(known.up);
        match objective.local(facets) {
            Some(whole) => self.narrowed(trial, &Arc::from(whole), best, Vec::new()),
            None => trial.found(vec![best], None, Stop::Converged),
        }
    }

    fn narrowed<'a>(&self, trial: Trial<'a>, whole: &Known<'a>, best: Minimum, mut minima: Vec<Minimum>) -> Found {
        let mut run = Run { trial, gap: self.gap, best, heap: BinaryHeap::new(), floor: f64::INFINITY };
        run.begin(whole);
        let stop = run.narrow();
        let lower = run.heap.peek().map_or(run.floor, |cell| run.floor.min(cell.bound)).min(run.best.value);
        minima.push(run.best);
        run.trial.found(minima, Some(lower), stop)
    }
}

impl Search for Certified {
    fn name(&self) -> &'static str {
        "certified"
    }

    fn search(&self, objective: &dyn Objective, facets: &Facets) -> Found {
        let Some(whole) = objective.local(facets) else {
            return NelderMead { budget: self.budget.min(20_000), ..NelderMead::default() }.search(objective, facets);
        };
        let mut trial = Trial::new(objective, facets, self.budget);
        let share = self.budget / FIRST_SHARE / STARTS;
        let mut minima: Vec<Minimum> =
            (0..STARTS).map(|i| descend(&mut trial, lattice(i, STARTS), share.min(FIRST), FIRST_STEP)).collect();
        minima.sort_by(|a, b| a.value.total_cmp(&b.value));
        let best = descend(&mut trial, minima[0].up, POLISH.min(share), POLISHED);
        let best = if best.value < minima[0].value { best } else { minima[0] };
        self.narrowed(trial, &Arc::from(whole), best, minima)
    }
}

type Known<'a> = Arc<dyn Local<'a> + 'a>;

struct Run<'a> {
    trial: Trial<'a>,
    gap: f64,
    best: Minimum,
    heap: BinaryHeap<Cell<'a>>,
    /// The least bound of the cells that were put aside.
    floor: f64,
}

impl<'a> Run<'a> {
    /// From here on a bound is good enough: within the gap, or of the best value by no more than rounding makes of the
    /// largest (a relative gap to 0 would never close).
    fn enough(&self) -> f64 {
        self.best.value - (self.gap * self.best.value.abs()).max(ROUNDED * self.trial.size())
    }

    fn begin(&mut self, whole: &Known<'a>) {
        for face in 0..6 {
            for i in 0..4 {
                let middle = [f64::from(i % 2) - 0.5, f64::from(i / 2) - 0.5];
                self.look(whole, face, middle, 0.5);
            }
        }
    }

    fn narrow(&mut self) -> Stop {
        while let Some(cell) = self.heap.pop() {
            if cell.bound >= self.enough() || cell.half < SMALLEST {
                self.floor = self.floor.min(cell.bound);
                continue;
            }
            if cell.bound > 0.0 && cell.bound >= (1.0 - SPREAD) * self.trial.size() {
                self.heap.push(cell);
                return Stop::Converged;
            }
            if self.trial.left() < 12 + POLISH {
                self.heap.push(cell);
                return Stop::Budget;
            }
            let half = cell.half / 2.0;
            for (u, v) in [(-half, -half), (half, -half), (-half, half), (half, half)] {
                self.look(&cell.known, cell.face, [cell.middle[0] + u, cell.middle[1] + v], half);
            }
        }
        Stop::Converged
    }

    /// Bounds a cell and tries what it suggests.
    fn look(&mut self, parent: &Known<'a>, face: usize, middle: [f64; 2], half: f64) {
        let cap = cap(face, middle, half);
        let known: Known<'a> = Arc::from(parent.within(&cap));
        let bound = lower(known.as_ref(), &cap, self.enough());
        self.trial.charge();
        if bound >= self.enough() {
            self.floor = self.floor.min(bound);
            return;
        }
        if known.estimate() < self.enough() {
            self.try_at(cap.centre);
        }
        if let Some(hint) = known.hint() {
            self.try_at(hint);
        }
        self.heap.push(Cell { bound, face, middle, half, known });
    }

    fn try_at(&mut self, up: Vec3) {
        let tried = self.trial.at(up);
        if tried.value < self.enough() {
            let polished = descend(&mut self.trial, up, POLISH, POLISHED);
            self.best = if polished.value < tried.value { polished } else { tried };
        }
    }
}

/// Where the best and the worst direction differ by less than this, relative, no printer can tell them apart (a ball).
const SPREAD: f64 = 1e-3;

/// Of the largest value: a difference that is none.
const ROUNDED: f64 = 1e-13;

/// A cell is not cut below this (of a face of 2 x 2): its directions are then equal to the last digits.
const SMALLEST: f64 = 1e-13;

struct Cell<'a> {
    bound: f64,
    face: usize,
    middle: [f64; 2],
    half: f64,
    known: Known<'a>,
}

impl Ord for Cell<'_> {
    /// The lowest bound is the greatest; of equals the larger cell, then by place, so that the order is one.
    fn cmp(&self, other: &Self) -> Ordering {
        let by_bound = other.bound.total_cmp(&self.bound).then(self.half.total_cmp(&other.half));
        let place = |c: &Self| (c.face, c.middle.map(f64::to_bits));
        by_bound.then_with(|| place(self).cmp(&place(other)))
    }
}

impl PartialOrd for Cell<'_> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Cell<'_> {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Cell<'_> {}

/// The direction of a point of the cube's face `face`, coordinates from -1 to 1.
pub(super) fn direction(face: usize, [u, v]: [f64; 2]) -> Vec3 {
    let w = if face < 3 { 1.0 } else { -1.0 };
    match face % 3 {
        0 => Vec3::new(w, u, v),
        1 => Vec3::new(u, w, v),
        _ => Vec3::new(u, v, w),
    }
    .normalize()
}

fn cap(face: usize, middle: [f64; 2], half: f64) -> Cap {
    let centre = direction(face, middle);
    let corners = [(-half, -half), (half, -half), (-half, half), (half, half)];
    let chord = |(u, v): (f64, f64)| (direction(face, [middle[0] + u, middle[1] + v]) - centre).norm();
    let longest = corners.into_iter().map(chord).fold(0.0, f64::max);
    Cap { centre, radius: 2.0 * (longest / 2.0).asin() * (1.0 + 1e-12) + 1e-15 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::orient::sphere::lattice;
    use crate::orient::{Height, ObjectiveSettings, Staircase, objective};

    #[test]
    fn cells_cover_the_sphere_and_lie_in_their_caps() {
        for up in (0..2000).map(|i| lattice(i, 2000)) {
            let axis = up.iamax();
            let face = axis + if up[axis] < 0.0 { 3 } else { 0 };
            let rest: Vec<f64> = (0..3).filter(|&i| i != axis).map(|i| up[i] / up[axis].abs()).collect();
            let middle = [0, 1].map(|i| 0.25 * (4.0 * rest[i]).floor() + 0.125);
            let cap = cap(face, middle, 0.125);
            assert!(cap.centre.angle(&up) <= cap.radius, "{up:?}");
        }
    }

    #[test]
    fn the_least_height_of_a_box_is_proved() {
        let corner = |i: usize| Vec3::new([0.0, 2.0][i & 1], [0.0, 3.0][i >> 1 & 1], [0.0, 4.0][i >> 2 & 1]);
        let facets = Facets::with(vec![], vec![], (0..8).map(corner).collect());
        let found = Certified::default().search(&Height, &facets);
        assert_eq!(found.stop, Stop::Converged);
        let lower = found.lower_bound.unwrap();
        assert!(lower <= 2.0 && lower > 2.0 - 3e-6, "{lower}");
        assert!((found.minima[0].value - 2.0).abs() < 2e-6);
    }

    #[test]
    fn a_dip_narrower_than_any_start_is_found_and_proved() {
        let normals = [Vec3::x(), Vec3::y(), Vec3::z()].map(|n| [n, -n]).concat();
        let facets = Facets::with(normals, vec![12.0, 12.0, 8.0, 8.0, 6.0, 6.0], vec![]);
        let found = Certified::default().search(&Staircase { layer_mm: 0.2 }, &facets);
        assert_eq!((found.minima[0].value, found.lower_bound, found.stop), (0.0, Some(0.0), Stop::Converged));
    }

    #[test]
    fn what_has_no_bound_gets_none() {
        let facets = Facets::with(vec![Vec3::z()], vec![1.0], vec![Vec3::zeros()]);
        let negative = objective("2*height+-1*alexander", &ObjectiveSettings::default()).unwrap();
        assert_eq!(Certified::default().search(negative.as_ref(), &facets).lower_bound, None);
    }
}
