//! What to plan for.

use super::goal::Goal;
use super::support::Known;
use crate::geom::Angle;
use crate::orient::{Objective, Search};
use crate::overhang::{OverhangRule, TOLERATE_MM2};
use crate::profile::Profile;

/// What to plan for.
#[derive(Clone)]
pub struct Options<'a> {
    /// What the plan minimises.
    pub goal: &'a Goal,
    /// What the search for orientations minimises; decides where the goal does not look at orientations.
    pub objective: &'a dyn Objective,
    /// Facets up to this angle from the vertical need no support, whatever layers say.
    pub overhang: Angle,
    /// Slopes up to this angle are fine in layers; `None`: as lines of the profile's width and layers are ([`OverhangRule::practised`]).
    pub steepest: Option<Angle>,
    /// Whether layers may droop.
    pub droops: bool,
    /// Room the head must keep from parts it does not print on, mm.
    pub margin_mm: f64,
    /// Which sequences come first.
    pub priority: Priority,
    /// Whether everything on the table belongs to the first slot.
    pub table_first: bool,
    /// Demanded steps: the parts of each come in later slots than those of the steps before.
    pub order: Vec<Vec<usize>>,
    /// Whether all that stands on the table is printed upright and grows together, layer by layer, so that one part may droop onto another.
    pub together: bool,
    /// The search for orientations.
    pub search: &'a dyn Search,
    /// Most steps of the sequence search: candidates looked at.
    pub budget: u64,
    /// How many distinct plans are wanted.
    pub plans: usize,
    /// The table's surface lies this much lower than the model's foot: the height of a pedestal, mm.
    pub pedestal_mm: f64,
    /// Parts that may overhang: something else carries them.
    pub supported: Vec<usize>,
    /// Parts whose layers all lie on something while their neighbours stand, along the only direction that each has. They are not looked through again.
    pub layered: Vec<usize>,
    /// Parts that may overhang up to so much, mm².
    pub allow: Vec<(usize, f64)>,
    /// Whether layers decide where facets leave no plan: bridges, roofs of holes, and patches up to `tolerate_mm2`.
    pub practised: bool,
    /// What a connected patch may have that nothing carries, mm².
    pub tolerate_mm2: f64,
    /// What was found out already, for all that are cloned from these options.
    pub known: Known,
    /// Whether a failure is explained; the search for remedies only asks yes or no.
    pub explain: bool,
}

impl<'a> Options<'a> {
    /// What `trunnion plan` asks for without flags.
    pub fn new(goal: &'a Goal, objective: &'a dyn Objective, search: &'a dyn Search) -> Self {
        Self {
            goal,
            objective,
            overhang: Angle::from_deg(45.0),
            steepest: None,
            droops: true,
            margin_mm: 0.5,
            priority: Priority::Together,
            table_first: true,
            order: Vec::new(),
            together: false,
            search,
            budget: 20_000_000,
            plans: 1,
            pedestal_mm: 0.0,
            supported: Vec::new(),
            layered: Vec::new(),
            allow: Vec::new(),
            practised: true,
            tolerate_mm2: TOLERATE_MM2,
            known: Known::default(),
            explain: true,
        }
    }
}

impl Options<'_> {
    /// The parts that are demanded to be printed before `part`.
    pub(super) fn before(&self, part: usize) -> Vec<usize> {
        let step = self.order.iter().position(|step| step.contains(&part)).unwrap_or(0);
        self.order[..step].concat()
    }

    /// Whether all that stands on the table belongs to the first slot: not where an order may part it.
    pub(super) fn table_first(&self) -> bool {
        self.table_first && self.order.is_empty()
    }

    /// What layers let pass on the machine of `profile`.
    pub fn layers(&self, profile: &Profile) -> OverhangRule {
        let process = &profile.process;
        let (layer_mm, line_mm) = (process.layer_height_mm, process.line_width_mm);
        OverhangRule {
            overhang: self.steepest.unwrap_or_else(|| OverhangRule::practised(layer_mm, line_mm)),
            layer_mm,
            line_mm,
            bridge_mm: process.bridge_mm,
            tolerate_mm2: self.tolerate_mm2,
            droops: self.droops,
        }
    }
}

/// Which sequences come first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Priority {
    /// As many parts in a slot as can be (line 18 before 19).
    Together,
    /// One part after the other where possible (lines 18 and 19 swapped).
    Single,
    /// Never two parts in a slot (without line 18).
    OnlySingle,
}
