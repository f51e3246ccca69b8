//! Good build directions of one part: objectives on the sphere, and searches over them.
//!
//! A direction `d` is the unit vector that points up while printing, in the frame of the part's mesh. An
//! [`Objective`] says how bad `d` is, a [`Search`] finds its minima; [`directions`] gathers what a planner should try:
//! the minima, the facets' normals and the directions at right angles to two of them, where such functions have their
//! kinks.
//!
//! This room must not know machines or sequences.

mod directions;
mod multistart;
mod objective;

pub use directions::{Direction, directions};
pub use multistart::Multistart;
pub use objective::{Facets, Height, Objective, Staircase, SupportArea, named};

use crate::geom::Vec3;

/// A local minimum that a search found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Minimum {
    /// The build direction, unit.
    pub up: Vec3,
    /// The objective there.
    pub value: f64,
}

/// What a search answers with.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// Distinct minima, best first.
    pub minima: Vec<Minimum>,
    /// How often the objective was evaluated.
    pub evaluations: usize,
}

/// Finds minima of an objective over all directions.
pub trait Search: Sync {
    /// The `--method` name.
    fn name(&self) -> &'static str;

    /// Minima of `objective` for the part with `facets`; the same for the same input, whatever the machine.
    fn search(&self, objective: &dyn Objective, facets: &Facets) -> Found;
}
