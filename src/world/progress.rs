//! Whoever watches a job: what is done, what should be known, how far a long step is.

use std::any::Any;

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

    /// A step is done, and this is what it came to: a [`LoadedModel`](crate::input::LoadedModel) that is read, the
    /// [`PlanResult`](crate::strategy::PlanResult) or the [`SliceResult`](crate::job::SliceResult) of [`prepare`](crate::job::prepare()).
    fn reached(&self, _done: &dyn Any) {}
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
