//! What a plan is worth: eq. (9) of Ramos et al. (2021) with any weights, and machine time.
//!
//! A goal is a list of **ranks**: the first is what was asked for, the later ones decide between plans that are equal in
//! all before. Every rank is a sum of the same four things, so that the search can bound it part by part:
//!
//! ```text
//! value = slots_waited * (eq. 8: sum of the parts' slot numbers)  + slot * (number of slots)
//!       + setup * (number of pose changes)                        + sum over parts of price[part][candidate]
//! ```
//!
//! Prices come from `orient`'s objectives (their own units: mm³, mm², mm ..) or are seconds of an estimate.

use crate::orient::{BadObjective, Objective, ObjectiveSettings, nearest, objective};

/// What a plan minimises.
pub struct Goal {
    /// As asked for: `bss`, `0.7*staircase+0.3*height`, ..
    pub text: String,
    pub(super) terms: Vec<(f64, GoalTerm)>,
}

pub(super) enum GoalTerm {
    /// Eq. (8).
    SequenceSize,
    /// Pose changes.
    Setups,
    /// Number of slots.
    Slots,
    /// Estimated seconds on the machine.
    Time,
    /// Summed over the parts.
    Part(Box<dyn Objective>),
}

/// The names that are not objectives of a single part.
pub const PLAN_TERMS: [&str; 4] = ["bss", "time", "setups", "slots"];

/// Names of [`Goal::parse`].
fn names() -> Vec<&'static str> {
    PLAN_TERMS.iter().chain(&crate::orient::OBJECTIVES).copied().collect()
}

impl Goal {
    /// The goal of `text`: a name or a weighted sum of raw values. `bss` is the building sequence size of eq. (8), `time`
    /// the estimated seconds, `setups` the pose changes, `slots` the number of slots; all others are objectives of
    /// `trunnion orient`, summed over the parts.
    ///
    /// # Errors
    ///
    /// [`BadObjective`]: an unknown name with the nearest known, a weight that is not a finite number or is negative
    /// where the term has a lower bound of its own, weights that sum to 0.
    pub fn parse(text: &str, settings: &ObjectiveSettings) -> Result<Self, BadObjective> {
        let mut terms = Vec::new();
        for word in text.split('+').map(str::trim) {
            let (weight, name) = word.split_once('*').unwrap_or(("1", word));
            let (weight, name) = (weight.trim(), name.trim());
            let bad = || BadObjective::Weight { weight: weight.to_owned(), name: name.to_owned() };
            let number = weight.parse::<f64>().ok().filter(|w| w.is_finite()).ok_or_else(bad)?;
            let term = match name {
                "bss" => GoalTerm::SequenceSize,
                "setups" => GoalTerm::Setups,
                "slots" => GoalTerm::Slots,
                "time" => GoalTerm::Time,
                other => GoalTerm::Part(objective(other, settings).map_err(|error| match error {
                    BadObjective::Unknown { name, .. } => {
                        let nearest = nearest(&name, &names());
                        BadObjective::Unknown { name, nearest }
                    }
                    error => error,
                })?),
            };
            // More slots for their own sake would have no end to reward; parts may have negative prices.
            if number < 0.0 && !matches!(term, GoalTerm::Part(_)) {
                return Err(bad());
            }
            terms.push((number, term));
        }
        if terms.iter().map(|(weight, _)| weight).sum::<f64>() == 0.0 {
            return Err(BadObjective::NoWeight { text: text.to_owned() });
        }
        Ok(Self { text: text.to_owned(), terms })
    }

    /// Whether the parts' orientations matter to it.
    pub fn looks_at_parts(&self) -> bool {
        self.terms.iter().any(|(_, term)| matches!(term, GoalTerm::Part(_) | GoalTerm::Time))
    }

    pub(super) fn has(&self, wanted: fn(&GoalTerm) -> bool) -> bool {
        self.terms.iter().any(|(_, term)| wanted(term))
    }
}
