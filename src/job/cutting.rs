//! Solids that have no plan as they are: cut by planes, and the parts planned; or printed on supports. The model itself is never changed: the
//! parts are a model of their own, for whoever asked to write beside the output.

use super::arrange::{Arrangement, Models, SetUp, arranged};
use super::plan::{Along, planned, planned_along};
use super::solids::{CutSolid, Known, Pieces, groups, in_parts};
use super::supported::on_supports;
use super::{
    Error, HeldModel, LoadedModel, LoadedProfile, PlanOptions, PlanRequest, PlanResult, Silent, Supporting, World,
    load_profile,
};
use crate::planning::Remedy;
use crate::spelling::counted;
use crate::split::Split;

/// Whether solids may be cut where there is no plan for them as they are.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Cutting {
    /// They are planned as they are, or not at all.
    Never,
    /// They may be cut.
    Auto {
        /// What the plan calls the parts' file (3MF).
        file: String,
    },
}

/// What became of a model whose solids were cut.
#[derive(Clone, Debug)]
pub struct CutModel {
    /// The solids that were cut, copies together; at least one.
    pub solids: Vec<CutSolid>,
    /// The parts as 3MF, to be written to [`CutModel::file`]; with those that stayed whole.
    pub bytes: Vec<u8>,
    /// What the plan calls that.
    pub file: String,
    /// Why there is no plan for the model as it is, in one sentence.
    pub why: String,
}

impl CutModel {
    /// What was done, what it costs and why, in one sentence; `seconds` of printing and turning.
    pub fn story(&self, seconds: f64) -> String {
        let of_all = |count: fn(&Split) -> usize| -> usize {
            self.solids.iter().map(|solid| solid.parts.len() * count(&solid.split.split)).sum()
        };
        let seams: f64 = self.solids.iter().map(|s| s.parts.len() as f64 * s.split.split.seam_mm2()).sum();
        let solids: usize = self.solids.iter().map(|solid| solid.parts.len()).sum();
        let which = if solids > 1 { format!("{} ", counted(solids, "solid")) } else { String::new() };
        format!(
            "{which}cut by {} into {}: {}, seams {seams:.1} mm2, about {:.0} min; as it is: {}",
            counted(of_all(|split| split.cuts.len()), "plane"),
            counted(of_all(|split| split.parts.len()), "part"),
            counted(self.solids.iter().map(|solid| solid.split.split.setups()).max().unwrap_or(0), "setup"),
            seconds / 60.0,
            self.why
        )
    }
}

/// Plans.
///
/// # Errors
///
/// [`Error::NoPlan`] with reasons and remedies; [`Error::Infeasible`] and [`Error::Misplaced`] for a model that cannot be
/// planned at all; [`Error::Setting`]; what reading model and machine may say.
pub fn plan(request: &PlanRequest, world: &World<'_>) -> Result<PlanResult, Error> {
    let machine = load_profile(&request.machine, world)?;
    let models = Models { first: &request.model, how: &request.arrangement, machine: &machine };
    let ways = WaysOut { cutting: Cutting::Never, supporting: request.supporting };
    let set = arranged(&models, world)?;
    Ok(planned_or_cut(&models, set, (&request.options, &ways), world)?.plan)
}

/// What may be done with solids that have no plan as they are.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WaysOut {
    /// Whether they may be cut; that comes first.
    pub cutting: Cutting,
    /// Whether they may stand on supports.
    pub supporting: Supporting,
}

/// A plan, and what was done to the model for it.
pub(super) struct PlannedSomehow {
    pub(super) plan: PlanResult,
    pub(super) cut: Option<CutModel>,
    pub(super) held: Option<HeldModel>,
}

/// Plans models as they are, or, where they have no plan and `ways` allow it, with their solids cut; or else on supports. Several that
/// have no plan so near to each other are given more room, where nobody said how much.
///
/// # Errors
///
/// What [`plan`](super::plan()) says of the models as they are; with why cutting and supports do not help.
pub(super) fn planned_or_cut(
    models: &Models<'_>,
    set: SetUp,
    (options, ways): (&PlanOptions, &WaysOut),
    world: &World<'_>,
) -> Result<PlannedSomehow, Error> {
    let mut sets = vec![set];
    sets.extend(models.wider(&sets[0], world));
    let none = matches!(ways, WaysOut { cutting: Cutting::Never, supporting: Supporting::Never });
    // Parts of one assembly are not cut.
    let assembly = sets[0].model.model.parts.len() > 1 && groups(&sets[0].model.model).len() == 1;
    let mut tries = Tries { machine: models.machine, options, sets, known: Known::default(), world };
    let mut why_not = [None, None];
    let uncut = assembly && ways.supporting == Supporting::Never;
    if !(none || uncut) || tries.sets.len() > 1 {
        let why = match tries.as_they_are()? {
            Ok(plan) => return Ok(PlannedSomehow { plan, cut: None, held: None }),
            Err(why) => why,
        };
        match &ways.cutting {
            Cutting::Auto { file } if !assembly => match tries.cut(file, &why) {
                Ok((plan, cut)) => return Ok(PlannedSomehow { plan, cut: Some(cut), held: None }),
                Err(text) => why_not[0] = Some(text),
            },
            _ => {}
        }
        if ways.supporting == Supporting::Auto {
            match tries.held(&why) {
                Ok((plan, held)) => return Ok(PlannedSomehow { plan, cut: None, held: Some(held) }),
                Err(text) => why_not[1] = Some(text),
            }
        }
    }
    tries.explained(why_not, models)
}

/// The same models with ever more room between them, and how they are planned.
struct Tries<'a> {
    machine: &'a LoadedProfile,
    options: &'a PlanOptions,
    sets: Vec<SetUp>,
    /// What is known of the solids alone.
    known: Known,
    world: &'a World<'a>,
}

impl Tries<'_> {
    /// The plan with the least room that does, or why there is none with the least.
    fn as_they_are(&mut self) -> Result<Result<PlanResult, String>, Error> {
        let quiet = PlanOptions { remedies: false, ..self.options.clone() };
        let plan = |set: &SetUp| match planned(set.model.clone(), self.machine.clone(), &quiet, self.world) {
            Ok(plan) => Ok(Ok(plan.of_arranged(set.arranged.clone()))),
            Err(Error::NoPlan(no)) => Ok(Err(no.infeasible.to_string())),
            Err(error) => Err(error),
        };
        let why = match plan(&self.sets[0])? {
            Err(why) if self.sets.len() > 1 => why,
            done => return Ok(done),
        };
        // More room is of no use to what has no plan by itself.
        if !self.known.each_has_a_plan(&self.sets[0].model, (self.machine, self.options), self.world) {
            return Ok(Err(why));
        }
        // What no longer fits on the table is no error.
        Ok(self.sets[1..].iter().find_map(|set| plan(set).ok()?.ok()).ok_or(why))
    }

    fn cut(&mut self, file: &str, why: &str) -> Result<(PlanResult, CutModel), String> {
        let mut known = std::mem::take(&mut self.known);
        self.first_of(|set| {
            let (mut plan, solids, bytes) =
                in_pieces(&set.model, self.machine, (self.options, file), &mut known, self.world)?;
            let cut = CutModel { solids, bytes, file: file.to_owned(), why: why.to_owned() };
            plan.story = Some(cut.story(plan.best().seconds));
            Ok((plan.of_arranged(set.arranged.clone()), cut))
        })
    }

    fn held(&self, why: &str) -> Result<(PlanResult, HeldModel), String> {
        self.first_of(|set| {
            let (plan, held) = on_supports(&set.model, self.machine, (self.options, why), self.world)?;
            Ok((plan.of_arranged(set.arranged.clone()), held))
        })
    }

    /// What `way` makes of the set with the least room that it does for, or why it does for none: what it says of the first.
    fn first_of<T>(&self, mut way: impl FnMut(&SetUp) -> Result<T, String>) -> Result<T, String> {
        let mut why = None;
        for set in &self.sets {
            match way(set) {
                Ok(done) => return Ok(done),
                Err(text) => why = why.or(Some(text)),
            }
        }
        Err(why.unwrap_or_default())
    }

    /// The least room once more, with what would help; and why cutting and supports do not.
    fn explained(mut self, [cut, held]: [Option<String>; 2], models: &Models<'_>) -> Result<PlannedSomehow, Error> {
        let SetUp { model, arranged, .. } = self.sets.swap_remove(0);
        let touching = groups(&model.model).iter().any(|group| group.len() > 1);
        match planned(model, self.machine.clone(), self.options, self.world) {
            Err(Error::NoPlan(mut no)) => {
                (no.cut, no.held) = (cut, held);
                let asked = no.remedies.is_some() && touching;
                let joined = asked.then(|| joined(models, self.options, self.world)).flatten();
                if let (Some(remedies), Some(joined)) = (&mut no.remedies, joined) {
                    remedies.push(joined);
                }
                Err(Error::NoPlan(no))
            }
            done => Ok(PlannedSomehow { plan: done?.of_arranged(arranged), cut: None, held: None }),
        }
    }
}

/// Whether there is a plan where parts that touch are one solid, as it is or on supports.
fn joined(models: &Models<'_>, options: &PlanOptions, world: &World<'_>) -> Option<Remedy> {
    let world = &World { progress: &Silent, ..*world };
    let how = Arrangement { join: true, ..models.how.clone() };
    let set = arranged(&Models { how: &how, ..*models }, world).ok()?;
    let options = PlanOptions { remedies: false, plans: 1, ..options.clone() };
    let whole = WaysOut { cutting: Cutting::Never, supporting: Supporting::Auto };
    let again = Models { how: &how, ..*models };
    let done = planned_or_cut(&again, set, (&options, &whole), world).ok()?;
    let on = if done.held.is_some() { ", on supports (--supports auto)" } else { "" };
    let parts = done.plan.plan.model.model.parts.len();
    let text = format!("join the parts that touch (--join): {} then has a plan{on}", counted(parts, "solid"));
    Some(Remedy { kind: "join", amount: parts as f64, text })
}

/// The plan of `model` with its solids cut, the cuts and the parts' file; else why not.
fn in_pieces(
    model: &LoadedModel,
    machine: &LoadedProfile,
    (options, file): (&PlanOptions, &str),
    known: &mut Known,
    world: &World<'_>,
) -> Result<(PlanResult, Vec<CutSolid>, Vec<u8>), String> {
    if model.model.parts.len() == 1 {
        let (plan, split, bytes) = in_parts(model.clone(), machine, (options, file), world)?;
        return Ok((plan, vec![CutSolid { parts: vec![0], split }], bytes));
    }
    let words = |error: Error| error.to_string();
    let pieces = Pieces::of(model, (machine, options), known, world)?;
    let bytes = pieces.threemf();
    let parts = LoadedModel::made(file.to_owned(), &bytes).map_err(words)?;
    let plain = PlanOptions { remedies: false, allow: pieces.allow, ..options.clone() };
    let plan = planned_along(Along::These(&pieces.ups), parts, machine.clone(), &plain, world);
    let crowded = |error| format!("{}; print fewer at once, or give them more room (--gap)", words(error));
    Ok((plan.map_err(crowded)?, pieces.cut, bytes))
}
