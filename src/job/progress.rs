//! Whoever watches a job: what is done, what should be known, how far a long step is.

use super::{LoadedModel, PlanResult, SliceResult};

/// Told while a job goes on; every method may do nothing.
pub trait Progress {
    /// Something that should be known, in one sentence.
    fn warning(&self, text: &str);

    /// A step of `of` pieces begins; dropped at its end.
    fn begin(&self, what: &'static str, of: usize) -> Box<dyn Bar + '_>;

    /// A search begins that may be ended early, since there is `known` to fall back on; with `None` it is over.
    fn may_end(&self, _known: Option<&str>) {}

    /// Whether somebody wants such a search to end with the best so far.
    fn enough(&self) -> bool {
        false
    }

    /// A model is read, or a step of [`prepare`](super::prepare()) is done.
    fn reached(&self, _step: Step<'_>) {}
}

/// What a job has come to.
#[derive(Clone, Copy)]
pub enum Step<'a> {
    /// The model is read.
    Read(&'a LoadedModel),
    /// There is a plan.
    Planned(&'a PlanResult),
    /// All prints are sliced.
    Sliced(&'a SliceResult),
}

/// A step that is under way.
pub trait Bar {
    /// `done` pieces are done.
    fn at(&self, done: usize);
}

/// Nobody watches; warnings are in the results as well.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Progress for Silent {
    fn warning(&self, _: &str) {}

    fn begin(&self, _: &'static str, _: usize) -> Box<dyn Bar + '_> {
        Box::new(Self)
    }
}

impl Bar for Silent {
    fn at(&self, _: usize) {}
}
