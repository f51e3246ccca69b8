//! What all connections share: the doors, the project's folder, and the state, which wakes whoever waits for a change of it.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use super::doors::Doors;
use super::folder::Kept;
use super::state::State;

/// What all connections share.
#[derive(Debug)]
pub(super) struct Shared {
    /// Who may come in.
    pub(super) doors: Doors,
    /// The project's folder.
    pub(super) folder: PathBuf,
    state: Mutex<State>,
    /// Models that were removed. Whoever changes the project holds it.
    kept: Mutex<Kept>,
    changed: Condvar,
    quits: AtomicBool,
}

impl Shared {
    /// Of a workbench that begins with this state.
    pub(super) fn new(doors: Doors, folder: PathBuf, state: State) -> Self {
        let (changed, quits) = (Condvar::new(), AtomicBool::new(false));
        Self { doors, folder, state: Mutex::new(state), kept: Mutex::default(), changed, quits }
    }

    /// The state, to be read or changed by one thread at a time.
    pub(super) fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The removed models: one change of the project at a time, which may take as long as copying a model.
    pub(super) fn kept(&self) -> MutexGuard<'_, Kept> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Changes the state and tells every page.
    pub(super) fn with<T>(&self, change: impl FnOnce(&mut State) -> T) -> T {
        let done = change(&mut self.state());
        self.changed.notify_all();
        done
    }

    /// The state as soon as it is another than of `version`, or after so long.
    pub(super) fn newer(&self, version: Option<u64>, most: Duration) -> MutexGuard<'_, State> {
        let state = self.state();
        if version != Some(state.version) || self.quits() {
            return state;
        }
        self.changed.wait_timeout(state, most).unwrap_or_else(PoisonError::into_inner).0
    }

    /// Ends the server.
    pub(super) fn quit(&self) {
        self.quits.store(true, Ordering::SeqCst);
        // Under the lock: whoever has just looked waits already, and hears it.
        self.with(|_| {});
    }

    /// Whether the server ends.
    pub(super) fn quits(&self) -> bool {
        self.quits.load(Ordering::SeqCst)
    }
}
