//! A model without a plan: why, and what would help.

use std::collections::BTreeMap;

use super::refused::Refused;
use super::ways::TriedWay;
use crate::geom::Angle;
use crate::input::{LoadedModel, LoadedProfile};
use crate::pictures::{Told, reasons_sheet};
use crate::planning::{Infeasible, Placement, Reason, Remedy, Workpiece};
use crate::view::Drawing;

/// No plan was found: why, and what would help.
#[derive(Clone, Debug)]
pub struct NoPlan {
    /// Why.
    pub infeasible: Infeasible,
    /// What would help, each by itself; `None` where it was not looked for.
    pub remedies: Option<Vec<Remedy>>,
    /// Why cutting the model does not help, where that was tried.
    pub cut: Option<Refused>,
    /// Why supports do not help, where they were tried.
    pub held: Option<Refused>,
    /// The ways that were tried, with why not.
    pub ways: Vec<TriedWay>,
    /// The model.
    pub model: LoadedModel,
    pub(super) machine: LoadedProfile,
    pub(super) base: Placement,
    pub(super) overhang: Angle,
}

/// One thing that stands in a part's way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hindrance<'a> {
    /// The part.
    pub part: usize,
    /// Of how many orientations.
    pub orientations: usize,
    /// The nearest miss.
    pub nearest: &'a Reason,
}

impl NoPlan {
    /// The reasons, and whether none of them can be left out.
    pub fn reasons(&self) -> (&[Reason], bool) {
        if let Infeasible::NoPlan { reasons, least, .. } = &self.infeasible { (reasons, *least) } else { (&[], false) }
    }

    /// The reasons by part and by what stands in the way, those of a part beside each other.
    pub fn hindrances(&self) -> Vec<Hindrance<'_>> {
        let mut by: BTreeMap<(usize, &str), Hindrance<'_>> = BTreeMap::new();
        for reason in self.reasons().0 {
            // The ways with the least against them come first.
            let new = || Hindrance { part: reason.part, orientations: 0, nearest: reason };
            by.entry((reason.part, &reason.blocked_by)).or_insert_with(new).orientations += 1;
        }
        by.into_values().collect()
    }

    /// The reasons as one picture; `None` where there are none that can be drawn.
    pub fn sheet(&self) -> Option<Drawing> {
        let workpiece = &Workpiece::place(&self.model.model, &self.base);
        let told = Told { workpiece, profile: &self.machine.profile, overhang: self.overhang };
        let (reasons, _) = self.reasons();
        (!reasons.is_empty()).then(|| reasons_sheet(reasons, told).drawing())
    }
}
