//! Somebody's wish that everything ends, and who has still to heed it.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// A wish to end, shared by all who hold a clone.
#[derive(Clone, Debug, Default)]
pub struct Interrupt(Arc<State>);

#[derive(Debug, Default)]
struct State {
    asked: AtomicBool,
    running: AtomicUsize,
}

impl Interrupt {
    /// Asks everybody to end: programs that run are stopped, and none is started any more.
    pub fn ask(&self) {
        self.0.asked.store(true, Ordering::SeqCst);
    }

    /// Whether somebody has asked.
    pub fn is_asked(&self) -> bool {
        self.0.asked.load(Ordering::SeqCst)
    }

    /// Whether a program runs, or has left something that is still being cleared.
    pub fn is_running(&self) -> bool {
        self.0.running.load(Ordering::SeqCst) > 0
    }

    /// A program is about to run, unless somebody has asked: counted first, so that one side always sees the other.
    pub(super) fn begin(&self) -> Option<Running> {
        self.0.running.fetch_add(1, Ordering::SeqCst);
        let running = Running(self.clone());
        (!self.is_asked()).then_some(running)
    }
}

/// A program that runs, for as long as this lives.
pub(super) struct Running(Interrupt);

impl Drop for Running {
    fn drop(&mut self) {
        self.0.0.running.fetch_sub(1, Ordering::SeqCst);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_runs_is_counted_and_nothing_begins_once_somebody_has_asked() {
        let interrupt = Interrupt::default();
        let running = interrupt.begin();
        assert!(running.is_some() && interrupt.is_running());
        interrupt.clone().ask();
        assert!(interrupt.begin().is_none() && interrupt.is_running());
        drop(running);
        assert!(!interrupt.is_running());
    }
}
