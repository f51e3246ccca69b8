//! DIRECT: dividing rectangles without a Lipschitz constant, on the six faces of a cube instead of two angles.
//!
//! Source: D. R. Jones, C. D. Perttunen, B. E. Stuckman, *Lipschitzian optimization without the Lipschitz constant*, JOTA
//! 79 (1993), 157-181; one longest side is cut at a time, as in Jones's revision of 2001. Puri (2019) runs it on
//! `[-pi, pi]^2`, which covers the sphere twice; the faces cover it once and have no poles.

use super::certified::direction;
use super::trial::Trial;
use super::{Facets, Found, Minimum, Objective, Search, Stop};
use crate::geom::Vec3;

/// DIRECT with as many evaluations as `budget`; gives the best direction alone.
#[derive(Clone, Copy, Debug)]
pub struct Direct {
    /// Evaluations, at least 6.
    pub budget: usize,
}

impl Default for Direct {
    fn default() -> Self {
        Self { budget: 5000 }
    }
}

/// A rectangle must promise to better the best value by so much, relative, to be cut (Jones's epsilon).
const PROMISE: f64 = 1e-4;
/// A side is cut in three at most so often: 3^-20 of a face is 1e-9.
const MOST_CUTS: usize = 20;

impl Search for Direct {
    fn name(&self) -> &'static str {
        "direct"
    }

    fn search(&self, objective: &dyn Objective, facets: &Facets) -> Found {
        let mut trial = Trial::new(objective, facets, self.budget);
        let mut look = |face: usize, middle: [f64; 2], cuts: [usize; 2]| {
            let value = trial.value(&direction(face, middle));
            Rectangle { face, middle, cuts, value }
        };
        let mut all: Vec<Rectangle> = (0..6).map(|face| look(face, [0.0; 2], [0; 2])).collect();
        let mut stop = Stop::Budget;
        while all.len() + 2 <= self.budget {
            let chosen = promising(&all);
            if chosen.is_empty() {
                stop = Stop::Converged;
                break;
            }
            for i in chosen {
                if all.len() + 2 > self.budget {
                    break;
                }
                let axis = usize::from(all[i].cuts[1] < all[i].cuts[0]);
                all[i].cuts[axis] += 1;
                let Rectangle { face, middle, cuts, .. } = all[i];
                for sense in [-1.0, 1.0] {
                    let mut beside = middle;
                    beside[axis] += sense * side(cuts[axis]);
                    all.push(look(face, beside, cuts));
                }
            }
        }
        let best = all.iter().min_by(|a, b| a.value.total_cmp(&b.value));
        let minima = best.map(|r| Minimum { up: r.up(), value: r.value, ended: true }).into_iter().collect();
        trial.found(minima, None, stop)
    }
}

#[derive(Clone, Copy, Debug)]
struct Rectangle {
    face: usize,
    middle: [f64; 2],
    /// How often each side was cut in three.
    cuts: [usize; 2],
    value: f64,
}

impl Rectangle {
    fn up(&self) -> Vec3 {
        direction(self.face, self.middle)
    }

    /// Its class of size: sides are cut in turn, so the number of cuts says it.
    fn class(&self) -> usize {
        self.cuts[0] + self.cuts[1]
    }

    fn radius(&self) -> f64 {
        side(self.cuts[0]).hypot(side(self.cuts[1])) / 2.0
    }
}

/// The side of a face of 2 x 2 cut so often.
fn side(cuts: usize) -> f64 {
    2.0 / 3f64.powi(cuts as i32)
}

/// The rectangles that are lowest for some slope: the best of each size that lie on the lower hull of (radius, value).
fn promising(all: &[Rectangle]) -> Vec<usize> {
    let mut lowest = [None::<usize>; 2 * MOST_CUTS];
    for (i, r) in all.iter().enumerate().filter(|(_, r)| r.class() < 2 * MOST_CUTS) {
        let known = &mut lowest[r.class()];
        if known.is_none_or(|k| r.value < all[k].value) {
            *known = Some(i);
        }
    }
    let least = all.iter().map(|r| r.value).fold(f64::INFINITY, f64::min);
    let sizes: Vec<usize> = lowest.into_iter().flatten().collect();
    let slope = |a: usize, b: usize| (all[a].value - all[b].value) / (all[a].radius() - all[b].radius());
    // Large to small in `sizes`: the slopes to all larger ones bound from above, those to smaller ones from below.
    let lies_low = |place: usize| {
        let i = sizes[place];
        let above = sizes[..place].iter().map(|&k| slope(k, i)).fold(f64::INFINITY, f64::min);
        let below = sizes[place + 1..].iter().map(|&k| slope(i, k)).fold(0.0, f64::max);
        let promised = all[i].value - above * all[i].radius();
        below <= above && (above.is_infinite() || promised <= least - PROMISE * least.abs())
    };
    (0..sizes.len()).filter(|&place| lies_low(place)).map(|place| sizes[place]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::orient::{NormalZ, Staircase};

    #[test]
    fn finds_the_smallest_eigenvector_within_its_budget() {
        let e = [Vec3::new(2.0, 1.0, -1.0).normalize(), Vec3::new(1.0, -1.0, 1.0).normalize()];
        let last = e[0].cross(&e[1]);
        let facets = Facets::with([vec![e[0]; 5], vec![e[1]; 3], vec![last]].concat(), vec![1.0; 9], vec![]);
        let found = Direct::default().search(&NormalZ, &facets);
        assert!((found.minima[0].value - 1.0).abs() < 1e-3, "{found:?}");
        assert!(found.minima[0].up.dot(&last).abs() > 0.999);
        assert!(found.evaluations <= 5000);
    }

    #[test]
    fn finds_the_face_of_a_box_at_the_middle_of_a_face() {
        let normals = [Vec3::x(), Vec3::y(), Vec3::z()].map(|n| [n, -n]).concat();
        let facets = Facets::with(normals, vec![12.0, 12.0, 8.0, 8.0, 6.0, 6.0], vec![]);
        let found = Direct { budget: 200 }.search(&Staircase { layer_mm: 0.2 }, &facets);
        assert_eq!(found.minima[0].value, 0.0);
    }
}
