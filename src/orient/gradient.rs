//! Descents that follow the gradient: BFGS, conjugate gradients, Newton with conjugate gradients.
//!
//! Sources: J. Nocedal, S. J. Wright, *Numerical Optimization* (2006), algorithms 3.5, 5.4 (Polak and Ribiere's form), 6.1
//! and 7.1. They work in the plane that touches the sphere at the last start, and start anew where they come far from it.
//! At a kink no gradient leads on: there they end, which [`Multistart`](super::Multistart) mends with a simplex.

use super::sphere::tangents;
use super::trial::Trial;
use super::{Facets, Found, Minimum, Objective, Search, Stop};
use crate::geom::Vec3;

/// Which descent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GradientMethod {
    /// Quasi-Newton after Broyden, Fletcher, Goldfarb and Shanno; an update that would lose convexity is left out.
    Bfgs,
    /// Conjugate gradients after Polak and Ribiere, never negative.
    ConjugateGradient,
    /// Newton's steps, curvatures by differences of gradients; downhill where the curvature is negative.
    NewtonCg,
}

/// One descent along gradients from one start; by central differences for an objective without gradient.
#[derive(Clone, Copy, Debug)]
pub struct Descent {
    /// Which descent.
    pub method: GradientMethod,
    /// From here; the best of 32 even directions where none is given.
    pub start: Option<Vec3>,
    /// Evaluations at most; value and gradient at one place count as one.
    pub budget: usize,
}

impl Descent {
    /// A descent by `method` with its usual budget, its start chosen.
    pub fn by(method: GradientMethod) -> Self {
        Self { method, start: None, budget: 2000 }
    }
}

/// A gradient below this of the value, per radian, is none.
const FLATTEST: f64 = 1e-7;
/// Steps below this (radians) end a descent.
const LAST_STEP: f64 = 1e-10;
/// A first step's length, radians.
const FIRST_STEP: f64 = 0.05;
/// Differences for gradients (radians), and of gradients for curvatures.
const DIFFERENCE: f64 = 1e-4;
/// A plane is used so far from where it touches the sphere.
const REACH: f64 = 0.4;
/// Even directions of which the best is the start.
const TRIED: usize = 32;

impl Search for Descent {
    fn name(&self) -> &'static str {
        match self.method {
            GradientMethod::Bfgs => "bfgs",
            GradientMethod::ConjugateGradient => "cg",
            GradientMethod::NewtonCg => "newton-cg",
        }
    }

    fn search(&self, objective: &dyn Objective, facets: &Facets) -> Found {
        let mut trial = Trial::new(objective, facets, self.budget);
        let start = self.start.unwrap_or_else(|| best_of(&mut trial, TRIED));
        let (minimum, stop) = follow(&mut trial, self.method, start, self.budget);
        trial.found(vec![minimum], None, stop)
    }
}

fn best_of(trial: &mut Trial<'_>, count: usize) -> Vec3 {
    let tried = (0..count).map(|i| trial.at(super::sphere::lattice(i, count)));
    tried.min_by(|a, b| a.value.total_cmp(&b.value)).map_or(Vec3::z(), |m| m.up)
}

type V2 = nalgebra::Vector2<f64>;
type M2 = nalgebra::Matrix2<f64>;

/// A place in the touching plane with its value and gradient there.
#[derive(Clone, Copy)]
struct FirstLayer {
    x: V2,
    up: Vec3,
    value: f64,
    gradient: V2,
}

struct Plane {
    centre: Vec3,
    axes: [Vec3; 2],
}

impl Plane {
    fn at(centre: Vec3) -> Self {
        Self { centre, axes: tangents(&centre) }
    }

    fn look(&self, trial: &mut Trial<'_>, x: V2) -> FirstLayer {
        let far = self.centre + self.axes[0] * x.x + self.axes[1] * x.y;
        let length = far.norm();
        let up = far / length;
        let (value, gradient) = trial.both(&up);
        let gradient = gradient.unwrap_or_else(|| differences(trial, &up));
        let gradient = V2::new(gradient.dot(&self.axes[0]), gradient.dot(&self.axes[1])) / length;
        FirstLayer { x, up, value, gradient }
    }
}

fn differences(trial: &mut Trial<'_>, up: &Vec3) -> Vec3 {
    let slope = |t: Vec3| {
        let [ahead, behind] = [t, -t].map(|t| trial.value(&(up + t * DIFFERENCE).normalize()));
        t * ((ahead - behind) / (2.0 * DIFFERENCE))
    };
    tangents(up).map(slope).iter().sum()
}

/// Descends from `start` with at most about `budget` evaluations; where it ended, and why.
pub(super) fn follow(trial: &mut Trial<'_>, method: GradientMethod, start: Vec3, budget: usize) -> (Minimum, Stop) {
    let until = trial.spent() + budget;
    let mut plane = Plane::at(start.normalize());
    let mut at = plane.look(trial, V2::zeros());
    let mut memory = Memory::default();
    let mut fresh = true;
    let stop = loop {
        if at.gradient.norm() <= FLATTEST * at.value.abs() || at.gradient.norm() == 0.0 {
            break Stop::Converged;
        }
        if trial.spent() + 8 > until {
            break Stop::Budget;
        }
        if at.x.norm() > REACH {
            plane = Plane::at(at.up);
            at = plane.look(trial, V2::zeros());
            memory = Memory::default();
        }
        let step = memory.direction(method, &plane, trial, &at);
        match search(trial, &plane, &at, step, until) {
            Some(next) => {
                memory.learn(&at, &next);
                let moved = (next.x - at.x).norm();
                at = next;
                fresh = false;
                if moved < LAST_STEP {
                    break Stop::Converged;
                }
            }
            None if fresh => break Stop::Converged,
            None => {
                memory = Memory::default();
                fresh = true;
            }
        }
    };
    (Minimum { up: at.up, value: at.value, ended: true }, stop)
}

/// What a descent remembers of its steps.
#[derive(Default)]
struct Memory {
    inverse: Option<M2>,
    last: Option<(V2, V2)>,
}

impl Memory {
    fn direction(&mut self, method: GradientMethod, plane: &Plane, trial: &mut Trial<'_>, at: &FirstLayer) -> V2 {
        let down = -at.gradient;
        let plain = down * (FIRST_STEP / at.gradient.norm());
        let step = match method {
            GradientMethod::Bfgs => self.inverse.map(|h| h * down),
            GradientMethod::ConjugateGradient => self.last.map(|(gradient, step)| {
                let beta = at.gradient.dot(&(at.gradient - gradient)) / gradient.norm_squared();
                let turned = down + step * beta.max(0.0);
                turned * (self.inverse.map_or(1.0, |h| h.trace() / 2.0))
            }),
            GradientMethod::NewtonCg => newton(plane, trial, at),
        };
        let step = step.filter(|s| s.dot(&at.gradient) < -1e-6 * s.norm() * at.gradient.norm()).unwrap_or(plain);
        self.last =
            Some((at.gradient, if step.norm() > 0.0 { step * (at.gradient.norm() / step.norm()) } else { step }));
        step * (REACH / step.norm()).min(1.0)
    }

    /// The BFGS update of the inverse.
    fn learn(&mut self, from: &FirstLayer, to: &FirstLayer) {
        let (s, y) = (to.x - from.x, to.gradient - from.gradient);
        let sy = s.dot(&y);
        if sy <= 1e-12 * s.norm() * y.norm() {
            return;
        }
        let h = self.inverse.unwrap_or_else(|| M2::identity() * (sy / y.norm_squared()));
        let left = M2::identity() - s * y.transpose() / sy;
        self.inverse = Some(left * h * left.transpose() + s * s.transpose() / sy);
    }
}

/// Newton's step, curvatures by forward differences of the gradient; `None` where the surface is not convex.
fn newton(plane: &Plane, trial: &mut Trial<'_>, at: &FirstLayer) -> Option<V2> {
    let mut column = |e: V2| (plane.look(trial, at.x + e * DIFFERENCE).gradient - at.gradient) / DIFFERENCE;
    let (a, b) = (column(V2::x()), column(V2::y()));
    let hessian = M2::new(a.x, 0.5 * (a.y + b.x), 0.5 * (a.y + b.x), b.y);
    let convex = hessian.m11 > 0.0 && hessian.determinant() > 0.0;
    let solved = hessian.try_inverse().filter(|_| convex)?;
    Some(solved * -at.gradient)
}

/// A step that falls enough and does not end where it still falls steeply (Wolfe's conditions, 1e-4 and 0.9), by halving
/// at the parabola's bottom and by doubling. `None` where no step falls.
fn search(trial: &mut Trial<'_>, plane: &Plane, at: &FirstLayer, step: V2, until: usize) -> Option<FirstLayer> {
    let slope = at.gradient.dot(&step);
    let (mut low, mut high, mut share) = (0.0f64, f64::INFINITY, 1.0f64);
    let mut best: Option<FirstLayer> = None;
    while trial.spent() < until && share * step.norm() > LAST_STEP {
        let tried = plane.look(trial, at.x + step * share);
        if tried.value > at.value + 1e-4 * share * slope {
            high = share;
            let bottom = -0.5 * slope * share * share / (tried.value - at.value - slope * share);
            share = if bottom.is_finite() {
                bottom.clamp(low + 0.1 * (high - low), low + 0.5 * (high - low))
            } else {
                0.5 * (low + high)
            };
            if best.is_some() {
                break;
            }
            continue;
        }
        if best.is_none_or(|b| tried.value < b.value) {
            best = Some(tried);
        }
        if tried.gradient.dot(&step) >= 0.9 * slope || share * step.norm() >= REACH {
            break;
        }
        low = share;
        share = if high.is_finite() { 0.5 * (low + high) } else { 2.0 * share };
    }
    best.filter(|b| b.value < at.value)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Angle;
    use crate::mesh::TriangleMesh;
    use crate::orient::{Cost, NormalZ, Smoothing, Supported};

    const ALL: [GradientMethod; 3] =
        [GradientMethod::Bfgs, GradientMethod::ConjugateGradient, GradientMethod::NewtonCg];

    #[test]
    fn each_finds_the_smallest_eigenvector_in_few_evaluations() {
        let e = [Vec3::new(2.0, 1.0, -1.0).normalize(), Vec3::new(1.0, -1.0, 1.0).normalize()];
        let last = e[0].cross(&e[1]);
        let facets = Facets::with([vec![e[0]; 5], vec![e[1]; 3], vec![last]].concat(), vec![1.0; 9], vec![]);
        for method in ALL {
            let search = Descent { start: Some(Vec3::new(0.5, 0.4, 0.6)), ..Descent::by(method) };
            let found = search.search(&NormalZ, &facets);
            assert!((found.minima[0].value - 1.0).abs() < 1e-10, "{method:?} {found:?}");
            assert!(found.evaluations < 80, "{method:?}: {}", found.evaluations);
            assert_eq!(found.stop, Stop::Converged);
            assert_eq!(found.history.last().unwrap().value, found.minima[0].value);
        }
    }

    /// Boogers (2024), table 5.1, is of a part that is not here; of a smoothed volume near its optimum the counts are of the same
    /// order: BFGS 13, conjugate gradients 25, Newton 12 (its own differences are counted here), simplex 67.
    #[test]
    fn counts_are_of_the_order_of_the_published_table() {
        let points: Vec<Vec3> =
            [[0., 0., 0.], [30., 4., 2.], [3., 20., -4.], [5., 6., 16.], [-6., -9., 7.]].map(Vec3::from).to_vec();
        let facets = vec![[0, 2, 1], [0, 1, 4], [1, 3, 4], [1, 2, 3], [2, 4, 3], [0, 4, 2]];
        let part = Facets::of(&TriangleMesh::<crate::geom::Object>::new(points, facets));
        let smoothing = Smoothing { overhang: Angle::from_deg(0.0), carrying: Angle::from_deg(0.0), k: 5.0, w: 0.5 };
        let f = Supported { cost: Cost::Convex, smoothing, resolution_mm: 0.5 };
        let simplex = crate::orient::NelderMead::default().search(&f, &part).minima[0];
        let start = (simplex.up + Vec3::new(0.12, -0.1, 0.07)).normalize();
        for (method, most) in ALL.into_iter().zip([40, 75, 80]) {
            let found = Descent { start: Some(start), ..Descent::by(method) }.search(&f, &part);
            assert!(
                found.minima[0].value <= simplex.value * (1.0 + 1e-6),
                "{method:?}: {} for {}",
                found.minima[0].value,
                simplex.value
            );
            assert!(found.evaluations <= most, "{method:?}: {}", found.evaluations);
        }
    }
}
