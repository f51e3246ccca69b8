//! The directions a planner should try for one part.

use super::{Facets, Objective, Search, SupportArea};
use crate::geom::Vec3;

/// A build direction with its worth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Direction {
    /// Unit, in the frame of the part's mesh.
    pub up: Vec3,
    /// The objective's value there.
    pub value: f64,
}

/// Directions nearer than this (radians, 0.03 degrees) are one: the finest difference an objective's kink is found to.
const SAME: f64 = 5e-4;
/// Facet normals beyond the largest so many are left out: a smooth part has hundreds, none of them flat.
const MOST_NORMALS: usize = 24;
/// Pairs of normals whose cross product is tried are taken among the largest so many.
const MOST_CROSSED: usize = 8;

/// What to try for a part, best first: both senses of its largest facet normals, of `also` (the interfaces' normals), of
/// their mutual cross products, and the minima of `objective` and of the support area that `search` finds.
///
/// Exact directions come before found ones, so that a minimum that merely approaches a facet normal is dropped for it.
pub fn directions(facets: &Facets, also: &[Vec3], objective: &dyn Objective, search: &dyn Search) -> Vec<Direction> {
    let (normals, order) = (&facets.normals().units, facets.normals().by_area());
    let mut exact: Vec<Vec3> = Vec::new();
    for &normal in also {
        push(&mut exact, normal);
    }
    for &i in order.iter().take(MOST_NORMALS) {
        push(&mut exact, normals[i]);
    }
    let crossed: Vec<Vec3> = also.iter().copied().chain(order.iter().take(MOST_CROSSED).map(|&i| normals[i])).collect();
    for (i, a) in crossed.iter().enumerate() {
        for b in &crossed[i + 1..] {
            let across = a.cross(b);
            if across.norm() > 0.02 {
                push(&mut exact, across.normalize());
            }
        }
    }
    for f in [objective, &SupportArea as &dyn Objective] {
        for minimum in search.search(f, facets).minima {
            push(&mut exact, minimum.up);
        }
    }
    let mut all: Vec<Direction> =
        exact.into_iter().map(|up| Direction { up, value: objective.value(facets, &up) }).collect();
    all.sort_by(|a, b| a.value.total_cmp(&b.value));
    all
}

/// Adds both senses of `normal` where they are new.
fn push(list: &mut Vec<Vec3>, normal: Vec3) {
    for up in [normal, -normal] {
        if list.iter().all(|known| (known - up).norm() > SAME) {
            list.push(up);
        }
    }
}
