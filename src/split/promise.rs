//! A plane that promises something, with all that was found out about the cut along it.
//!
//! A model is searched several times: among plain directions, among all, in a wider beam, on pedestals. The states are the same
//! in all of these, and so are cuts, measures and rules; only the head's answers are those of one pedestal. So a promise keeps
//! the state behind its cut, or what is against it, and what each machine said. Nothing depends on what is kept but the time.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use super::clip::Taken;
use super::measure::PieceNeeds;
use super::rules::{Against, THICK_MM};
use super::surface::Plane;
use super::sweep::Beyond;

/// A gain below this is none, and so much may stay for good in one step at first, mm².
pub(super) const STAYS_MM2: f64 = 0.5;
/// The states that are kept have no more facets together than this: some 200 bytes each.
const KEPT_FACETS: usize = 2_000_000;

/// A plane that promises something; `S` is a state.
pub(super) struct Promise<S> {
    pub(super) plane: Plane,
    pub(super) taken: Taken,
    /// What a finished child would need, by the sweep.
    pub(super) stays_mm2: f64,
    pub(super) worth: i64,
    pub(super) setups: usize,
    pub(super) odd: bool,
    /// A vertex of each solid that is taken.
    pub(super) tops: Vec<u32>,
    /// mm², once somebody has asked.
    pub(super) seam_mm2: OnceLock<f64>,
    /// What is against the cut on every machine, or the state behind it.
    made: OnceLock<Result<Arc<S>, Against>>,
    /// By machine: what is against the cut on it.
    answers: Mutex<Vec<(u64, Option<Against>)>>,
}

/// What is known of a cut on one machine.
pub(super) enum Known<S> {
    Refused(Against),
    /// The machine prints it.
    Made(Arc<S>),
    /// It can be made, but nobody has asked this machine yet.
    Unasked(Arc<S>),
    Nothing,
}

impl<S> Promise<S> {
    pub(super) fn new(
        plane: Plane,
        taken: Taken,
        tops: Vec<u32>,
        stays_mm2: f64,
        worth: i64,
        setups: usize,
        odd: bool,
    ) -> Self {
        let (seam_mm2, made, answers) = (OnceLock::new(), OnceLock::new(), Mutex::default());
        Self { plane, taken, stays_mm2, worth, setups, odd, tops, seam_mm2, made, answers }
    }

    /// What is known of the cut on the machine of this number.
    pub(super) fn known(&self, machine: u64) -> Known<S> {
        let answers = self.answers.lock().unwrap_or_else(PoisonError::into_inner);
        let answer = answers.iter().find(|(number, _)| *number == machine).map(|(_, answer)| answer);
        match (self.made.get(), answer) {
            (Some(Err(against)), _) | (_, Some(Some(against))) => Known::Refused(*against),
            (Some(Ok(state)), Some(None)) => Known::Made(state.clone()),
            (Some(Ok(state)), None) => Known::Unasked(state.clone()),
            (None, _) => Known::Nothing,
        }
    }

    /// Keeps that the cut breaks a rule that no machine changes.
    pub(super) fn refuse(&self, against: Against) {
        let _ = self.made.set(Err(against));
    }

    /// Keeps what this machine, or what comes after it, says to the cut.
    pub(super) fn answer(&self, machine: u64, against: Option<Against>) {
        let mut answers = self.answers.lock().unwrap_or_else(PoisonError::into_inner);
        if answers.iter().all(|(number, _)| *number != machine) {
            answers.push((machine, against));
        }
    }

    /// Keeps the state behind the cut, of so many facets, where `kept`, the facets of all that are, leaves room.
    pub(super) fn keep(&self, state: &Arc<S>, facets: usize, kept: &AtomicUsize) {
        if self.made.get().is_none() && kept.fetch_add(facets, Ordering::Relaxed) <= KEPT_FACETS {
            let _ = self.made.set(Ok(state.clone()));
        }
    }
}

type Choice = (Taken, Vec<u32>, PieceNeeds, PieceNeeds);

/// Which of the solids beyond a plane may be taken: all, each that gains by itself, and all of these together.
pub(super) fn choices(beyond: &[Beyond], strict: bool) -> Vec<Choice> {
    let sum = |of: &mut dyn Iterator<Item = &Beyond>, taken: Option<()>| -> Choice {
        let mut tops = Vec::new();
        let (mut before, mut after) = (PieceNeeds::default(), PieceNeeds::default());
        for one in of {
            tops.push(one.top);
            for (sum, n) in [(&mut before, one.before), (&mut after, one.after)] {
                sum.area_mm2 += n.area_mm2;
                sum.beginnings += n.beginnings;
                sum.ridges += n.ridges;
            }
        }
        let taken = taken.map_or_else(|| Taken::With(tops.clone()), |()| Taken::All);
        (taken, tops, before, after)
    };
    let mut all = Vec::new();
    if !beyond.is_empty() && beyond.iter().all(|b| b.height_mm >= THICK_MM) {
        all.push(sum(&mut beyond.iter(), Some(())));
    }
    if strict || beyond.len() < 2 {
        return all;
    }
    let gains = |b: &&Beyond| {
        let area = b.before.area_mm2 > b.after.area_mm2 + STAYS_MM2;
        b.height_mm >= THICK_MM && (area || b.before.faults() > b.after.faults()) && b.after.faults() == 0
    };
    let gaining: Vec<&Beyond> = beyond.iter().filter(gains).collect();
    all.extend(gaining.iter().map(|b| sum(&mut std::iter::once(*b), None)));
    if gaining.len() > 1 && gaining.len() < beyond.len() {
        all.push(sum(&mut gaining.into_iter(), None));
    }
    all
}
