//! How long a search may go on: counted steps, which are the same on every machine, and whoever asks for an end.

use super::instance::Ended;
use super::solid::Put;

/// Asked now and then whether to end, and why; `None` to go on. Told the share of the steps that is spent.
pub type Asked<'a> = &'a mut dyn FnMut(f64) -> Option<Ended>;

/// Steps between two questions: some milliseconds.
const BETWEEN: u64 = 4000;

/// Shown packings of models on the way: the first that there is, and better ones.
pub type Shown<'a> = &'a mut dyn FnMut(&[Put]);

/// What is left of a search's steps.
pub struct Watch<'a> {
    asked: Asked<'a>,
    shown: Option<Shown<'a>>,
    allowed: u64,
    spent: u64,
    next: u64,
    ended: Option<Ended>,
}

impl<'a> Watch<'a> {
    /// So many steps; a step is a box tried in its place.
    pub fn new(allowed: u64, asked: Asked<'a>) -> Self {
        Self { asked, shown: None, allowed, spent: 0, next: 0, ended: None }
    }

    /// With somebody who is shown packings of models, to know how long their test takes, for example.
    pub fn showing(self, shown: Shown<'a>) -> Self {
        Self { shown: Some(shown), ..self }
    }

    /// Whether anybody is shown packings.
    pub(super) fn is_showing(&self) -> bool {
        self.shown.is_some()
    }

    /// Shows a packing.
    pub(super) fn show(&mut self, put: &[Put]) {
        if let Some(shown) = &mut self.shown {
            shown(put);
        }
    }

    /// Takes `steps`, and says whether the search goes on.
    pub fn spend(&mut self, steps: u64) -> bool {
        self.spent += steps;
        if self.ended.is_none() && self.spent >= self.next {
            self.next = self.spent + BETWEEN;
            let share = (self.spent as f64 / self.allowed.max(1) as f64).min(1.0);
            self.ended = (self.asked)(share).or((self.spent >= self.allowed).then_some(Ended::Steps));
        }
        self.ended.is_none()
    }

    /// Asks at once.
    pub fn goes_on(&mut self) -> bool {
        self.next = 0;
        self.spend(0)
    }

    /// Why it ended; [`Ended::Steps`] where nobody asked for it.
    pub fn ended(&self) -> Ended {
        self.ended.unwrap_or(Ended::Steps)
    }

    /// Whether it has ended, without asking.
    pub(super) fn ended_early(&self) -> bool {
        self.ended.is_some()
    }

    /// Steps that are spent.
    pub fn spent(&self) -> u64 {
        self.spent
    }

    /// The share of the steps that is spent.
    pub fn share(&self) -> f64 {
        (self.spent as f64 / self.allowed.max(1) as f64).min(1.0)
    }
}
