//! Orientations and a sequence for a model on a machine, or why there is none and what would help.

mod listing;
mod options;

use std::path::Path;

use crate::geom::{Angle, Dir, Vec3};
use crate::input::{
    CheckedPlan, InputError, LoadedModel, LoadedProfile, MachineSource, ModelSource, process_of, spanning,
};
use crate::mesh::Model;
use crate::orient::{Direction, Facets, Process, recommend};
use crate::pictures::{Told, plan_sheet};
use crate::planning::balance::{DOUBTFUL, FALLS, Held, WorstStanding, standing};
use crate::planning::{
    self, Infeasible, Options, PartDroop, PartRef, Placement, Plan, Planned, Print, Priority, Remedy, ThreeAxis, Wish,
    Workpiece, can_be_helped, droops, layers_matter, plan_anywhere, three_axis, whole,
};
use crate::profile::Profile;
use crate::strategy::arrange::{ArrangedModel, Arrangement};
use crate::strategy::error::StrategyError;
use crate::strategy::holding::support_solids;
use crate::strategy::no_plan::NoPlan;
use crate::strategy::ways::TriedWay;
use crate::view::Drawing;
use crate::world::World;
pub use listing::{Listed, sequences};
use options::PlanAsked;
pub(super) use options::{Along, CAREFUL_DEG};
pub use options::{Finish, PlaceRequest, PlanOptions, Supporting, allowed, ordered};

/// A model and a machine, and how to plan.
#[derive(Clone, Debug)]
pub struct PlanRequest {
    /// The model.
    pub model: ModelSource,
    /// The machine.
    pub machine: MachineSource,
    /// How the model is set up before.
    pub arrangement: Arrangement,
    /// How.
    pub options: PlanOptions,
    /// Whether one solid may stand on supports.
    pub supporting: Supporting,
}

impl PlanRequest {
    /// As the command does it without flags.
    pub fn new(model: impl Into<ModelSource>, machine: impl Into<MachineSource>) -> Self {
        let (arrangement, options) = (Arrangement::default(), PlanOptions::default());
        let supporting = Supporting::Never;
        Self { model: model.into(), machine: machine.into(), arrangement, options, supporting }
    }
}

/// A plan with what the search says of it.
#[derive(Clone, Debug)]
pub struct PlanResult {
    /// The best plan, with its model and machine.
    pub plan: CheckedPlan,
    /// All that were asked for, the best first; at least one.
    pub plans: Vec<Planned>,
    /// What was minimised.
    pub objective: String,
    /// Printing in three axes on supports, where several plans were asked for.
    pub three_axes: Option<ThreeAxes>,
    /// Whether the model stands elsewhere than in the middle, because only there the axes reach.
    pub moved: bool,
    /// Of `seconds`, what the search for orientations took.
    pub orient_seconds: f64,
    /// What planning took.
    pub seconds: f64,
    /// Surfaces up to this angle from the vertical were taken to hold themselves.
    pub overhang: Angle,
    /// What is printed, but droops, by part.
    pub droops: Vec<PartDroop>,
    /// Where what is printed is held the fewest times over, by its supports too; `None` where nothing tips anything.
    pub standing: Option<WorstStanding>,
    /// What was done to the model before, in a sentence; for the picture.
    pub story: Option<String>,
    /// The model as it was set up, where that is not as it was read.
    pub arranged: Option<ArrangedModel>,
    /// The ways that were tried for the model, the one that was taken first.
    pub ways: Vec<TriedWay>,
}

impl PlanResult {
    /// The best of the plans.
    pub fn best(&self) -> &Planned {
        &self.plans[0]
    }

    /// With what became of the model before.
    pub(super) fn of_arranged(mut self, arranged: Option<ArrangedModel>) -> Self {
        let stories = arranged.iter().map(ArrangedModel::story).chain(self.story.take());
        self.story = Some(stories.collect::<Vec<_>>().join("; ")).filter(|story| !story.is_empty());
        self.arranged = arranged;
        self
    }

    /// What stands, but not well, in a sentence.
    pub fn unsteady(&self) -> Option<String> {
        let WorstStanding { part, slot, tilt, held } = self.standing.filter(|one| one.held.pushed < DOUBTFUL)?;
        let (tilt, times) = (tilt.deg(), held.pushed);
        Some(format!(
            "slot {slot}, table at {tilt:.0} deg: while part {part} is printed, the first layer on the table holds with a safety \
             factor of only {times:.1} (recommended: {DOUBTFUL}); use a larger footprint or a brim (not counted)"
        ))
    }

    /// Why it falls over if the nozzle pushes: for a pose that nobody asked for. What touches the table in a line is held by nothing.
    pub(super) fn pushed_over(&self) -> Option<Infeasible> {
        let worst = self.standing.map(|one| (one, one.held.pushed));
        let nothing = Held { factor: 0.0, pushed: 0.0 };
        let on_a_line = (WorstStanding { part: 0, slot: 0, tilt: Angle::ZERO, held: nothing }, 0.0);
        let (one, factor) = worst.unwrap_or(on_a_line);
        (factor < FALLS).then(|| falls(&self.plan.model.model, &one, factor))
    }

    /// The plan as one picture, a frame for each pose; below it what was tried beside.
    pub fn sheet(&self) -> Drawing {
        let (workpiece, profile) = (&self.plan.workpiece(), &self.plan.machine.profile);
        let told = Told { workpiece, profile, overhang: self.overhang };
        let supports = support_solids(&self.plan.plan, workpiece, profile);
        let beside = self.ways.iter().filter_map(TriedWay::beside);
        let story = self.story.iter().cloned().chain(self.unsteady()).chain(beside).collect();
        plan_sheet(&self.plan.plan, told, &supports, story).drawing()
    }
}

fn falls(model: &Model, one: &WorstStanding, factor: f64) -> Infeasible {
    let &WorstStanding { part, slot, tilt, .. } = one;
    Infeasible::Falls { part, name: model.parts[part].name.clone(), slot, tilt_deg: tilt.deg(), factor }
}

/// Plans what is loaded already: solids by themselves as they are drawn, where that can be printed, since nobody turns a table for nothing.
pub(super) fn planned(
    model: LoadedModel,
    machine: LoadedProfile,
    options: &PlanOptions,
    world: &World<'_>,
) -> Result<PlanResult, StrategyError> {
    if model.model.interfaces.is_empty() && options.leaves_directions() {
        let quiet = PlanOptions { remedies: false, ..options.clone() };
        let drawn = planned_along(Along::These(&[Vec3::z()]), model.clone(), machine.clone(), &quiet, world);
        if drawn.is_ok() {
            return drawn;
        }
    }
    planned_along(Along::Any, model, machine, options, world)
}

/// As [`planned`], along no other directions than these.
pub(super) fn planned_along(
    along: Along<'_>,
    model: LoadedModel,
    machine: LoadedProfile,
    options: &PlanOptions,
    world: &World<'_>,
) -> Result<PlanResult, StrategyError> {
    let start = world.clock.now();
    let seconds = || (world.clock.now() - start).as_secs_f64();
    // The machine's own values, before this plan's bridges.
    let machine_values = machine.is_own().then(|| Box::new(machine.profile.clone()));
    let machine = spanning(machine, options.bridge_mm)?;
    let asked = PlanAsked::of(options, &machine, &model)?;
    let together = matches!(along, Along::These([_]))
        && options.table_first
        && options.order.is_empty()
        && options.priority != Priority::OnlySingle;
    let wanted = Options { together, ..asked.options(options) };
    let (base, profile) = (asked.base, &machine.profile);
    let workpiece = Workpiece::place(&model.model, &base);
    let mut directions = asked.directions(&workpiece, &machine, &wanted, &along)?;
    let orient_seconds = seconds();
    let among = |directions: &[Vec<Direction>]| match options.place {
        Some(_) => planning::plan(&workpiece, profile, directions, &wanted).map(|plans| (base, plans)),
        None => plan_anywhere(&model.model, profile, &base, directions, &wanted),
    };
    let found = match along {
        Along::Any => planning::widening(&workpiece, &wanted, &[], &mut directions, among),
        Along::Upright(parts) => planning::widening(&workpiece, &wanted, parts, &mut directions, among),
        Along::These(_) => among(&directions),
    };
    let found = found.and_then(|(placement, plans)| {
        let plan = Plan {
            machine_values,
            bridge_mm: options.bridge_mm,
            ..draft(&model, &machine, placement, &plans[0], options.kept_in.as_deref(), world)
        };
        let standing = standing(&plan, &Workpiece::place(&model.model, &placement), profile, &[]);
        match standing.filter(WorstStanding::falls) {
            Some(one) => Err(falls(&model.model, &one, one.held.factor)),
            None => Ok((placement, plans, plan, standing)),
        }
    });
    let (placement, plans, plan, standing) = match found {
        Ok(found) => found,
        Err(infeasible) => {
            let seek = options.remedies && can_be_helped(&infeasible);
            let seek = seek.then(|| remedies(&infeasible, &workpiece, profile, &directions, &wanted, world));
            drop(workpiece);
            return Err(StrategyError::NoPlan(Box::new(NoPlan {
                infeasible,
                remedies: seek,
                cut: None,
                held: None,
                ways: Vec::new(),
                model,
                machine,
                base,
                overhang: wanted.overhang,
            })));
        }
    };
    let plan = checked(plan, model, machine)?;
    let up = |print: &Print| Dir::new(print.up.into()).unwrap_or(Dir::z());
    let prints = plan.prints().map(|(_, print)| (print.part, up(print)));
    let droops = droops(&plan.workpiece(), &plan.machine.profile, prints, &wanted);
    let compared = options.plans > 1;
    let three_axes = compared.then(|| ThreeAxes::of(&plan, wanted.overhang));
    let (objective, moved) = (asked.goal.text.clone(), placement != base);
    Ok(PlanResult {
        plan,
        plans,
        objective,
        three_axes,
        moved,
        orient_seconds,
        seconds: seconds(),
        overhang: wanted.overhang,
        droops,
        standing,
        story: None,
        arranged: None,
        ways: Vec::new(),
    })
}

/// What a printer that cannot tilt would take for the same model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThreeAxes {
    /// In the pose that `orient` recommends for the whole.
    pub best: ThreeAxis,
    /// As it stands in its file.
    pub as_it_stands: ThreeAxis,
}

impl ThreeAxes {
    fn of(plan: &CheckedPlan, overhang: Angle) -> Self {
        let (workpiece, profile) = (plan.workpiece(), &plan.machine.profile);
        let process = Process { overhang, ..process_of(&plan.machine) };
        let found = recommend(&Facets::of(&whole(&workpiece)), &process, None, None);
        let along = |up: Vec3| three_axis(&workpiece, profile, overhang, Dir::new(up).unwrap_or(Dir::z()));
        Self { best: along(found.recommended.up), as_it_stands: along(Vec3::z()) }
    }
}

/// The plan's document, as it is kept in a folder.
fn draft(
    model: &LoadedModel,
    machine: &LoadedProfile,
    placement: Placement,
    best: &Planned,
    kept_in: Option<&Path>,
    world: &World<'_>,
) -> Plan {
    Plan {
        format: Plan::FORMAT.to_owned(),
        version: Plan::VERSION,
        made_by: format!("trunnion {}", env!("CARGO_PKG_VERSION")),
        model: model.reference(kept_in, world),
        machine: machine.reference(kept_in, world),
        placement,
        bridge_mm: None,
        parts: model.model.parts.iter().map(|p| PartRef { id: p.id, name: p.name.clone() }).collect(),
        slots: best.slots.clone(),
        machine_values: None,
    }
}

/// The plan, held against its model and machine.
fn checked(plan: Plan, model: LoadedModel, machine: LoadedProfile) -> Result<CheckedPlan, StrategyError> {
    plan.check(&machine.profile.kinematics(), model.model.parts.len()).map_err(InputError::from)?;
    Ok(CheckedPlan { sha256: plan.sha256(), plan, model, machine })
}

/// Kinds of remedies that are tried.
const KINDS: usize = 13;

fn remedies(
    no: &Infeasible,
    workpiece: &Workpiece<'_>,
    profile: &Profile,
    directions: &[Vec<Direction>],
    options: &Options<'_>,
    world: &World<'_>,
) -> Vec<Remedy> {
    let bar = world.progress.begin("remedies", KINDS);
    let mut done = 0;
    // Where every part stands by its facets, layers add nothing but time to each check.
    let practised = layers_matter(workpiece, profile, directions, options);
    let options = &Options { practised, ..options.clone() };
    Wish { workpiece, profile, directions, options, no }.remedies(|_| {
        done += 1;
        bar.at(done);
    })
}
