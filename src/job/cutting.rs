//! Solids that have no plan as they are: cut by planes, and the parts planned; or printed on supports. The model itself is never changed: the
//! parts are a model of their own, for whoever asked to write beside the output.

use super::arrange::{Arrangement, Models, SetUp, arranged};
use super::plan::{Along, planned, planned_along};
use super::solids::{CutSolid, Known, Pieces, groups, in_parts};
use super::supported::on_supports;
use super::ways::{self, TriedWay, as_planned};
use super::{
    Error, HeldModel, LoadedModel, LoadedProfile, PlanOptions, PlanRequest, PlanResult, Silent, Supporting, World,
    load_profile,
};
use crate::planning::Remedy;
use crate::spelling::counted;
use crate::split::Split;
use crate::strategy::{Terms, Way, Weights};

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
    /// All seams, mm².
    pub fn seam_mm2(&self) -> f64 {
        self.solids.iter().map(|solid| solid.parts.len() as f64 * solid.split.split.seam_mm2()).sum()
    }

    /// What was done, what it costs and why, in one sentence; `seconds` of printing and turning.
    pub fn story(&self, seconds: f64) -> String {
        let of_all = |count: fn(&Split) -> usize| -> usize {
            self.solids.iter().map(|solid| solid.parts.len() * count(&solid.split.split)).sum()
        };
        let seams = self.seam_mm2();
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
    /// Whether they may be cut.
    pub cutting: Cutting,
    /// Whether they may stand on supports.
    pub supporting: Supporting,
}

impl WaysOut {
    /// What is left of them where what was `found` came to nothing in the end, and both in words.
    pub(super) fn besides(&self, found: &PlannedSomehow) -> Option<(Self, [&'static str; 2])> {
        let words = ["in parts", "printed on supports"];
        match (&found.cut, &found.held) {
            (Some(_), _) if self.supporting == Supporting::Auto => {
                Some((Self { cutting: Cutting::Never, ..self.clone() }, words))
            }
            (_, Some(_)) if self.cutting != Cutting::Never => {
                Some((Self { supporting: Supporting::Never, ..self.clone() }, [words[1], words[0]]))
            }
            _ => None,
        }
    }
}

/// A plan, and what was done to the model for it.
pub(super) struct PlannedSomehow {
    pub(super) plan: PlanResult,
    pub(super) cut: Option<CutModel>,
    pub(super) held: Option<HeldModel>,
    /// The ways that were tried.
    pub(super) ways: Vec<TriedWay>,
}

impl PlannedSomehow {
    fn as_drawn(plan: PlanResult) -> Self {
        let way = TriedWay { chosen: true, ..TriedWay::priced(Way::AsDrawn, as_planned(&plan)) };
        Self { plan, cut: None, held: None, ways: vec![way] }
    }
}

/// Plans models as they are, or, where they have no plan and `ways` allow it, with their solids cut or on supports, whichever is cheaper. Several that
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
            Ok(plan) => return Ok(PlannedSomehow::as_drawn(plan)),
            Err(why) => why,
        };
        let file = match &ways.cutting {
            Cutting::Auto { file } if !assembly => Some(&file[..]),
            _ => None,
        };
        match tries.cheapest((file, ways.supporting), &why) {
            Ok(found) => return Ok(found),
            Err(both) => why_not = both,
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

    /// On supports or cut, whichever is cheaper, for models that have no plan as they are; else why neither helps, the cut first.
    fn cheapest(
        &mut self,
        (file, supporting): (Option<&str>, Supporting),
        why: &str,
    ) -> Result<PlannedSomehow, [Option<String>; 2]> {
        let weights = Weights::default();
        let (held, no_supports) = parted((supporting == Supporting::Auto).then(|| self.held(why)));
        let on_supports = held.as_ref().map(|(plan, held)| ways::on_supports(plan, held));
        let price = |terms: &Option<Terms>| terms.map_or(f64::INFINITY, |terms| weights.price(&terms));
        // The search for cuts is the long one: what cannot be cheaper is not looked for.
        let least = held.as_ref().map_or(0.0, |(plan, _)| weights.least_of_a_cut(&as_planned(plan)));
        let worth = file.filter(|_| least < price(&on_supports));
        let (cut, no_cut) = parted(worth.map(|file| self.cut(file, why)));
        let in_parts = cut.as_ref().map(|(plan, cut)| ways::in_parts(plan, cut.seam_mm2()));
        let mut tried = vec![TriedWay::refused(Way::AsDrawn, why)];
        for (way, terms, why_not) in [(Way::Cut, in_parts, &no_cut), (Way::Supports, on_supports, &no_supports)] {
            tried.extend(terms.map(|terms| TriedWay::priced(way, terms)));
            tried.extend(why_not.as_ref().map(|why_not| TriedWay::refused(way, why_not)));
        }
        if file.is_some() && worth.is_none() {
            let cut = TriedWay::refused(Way::Cut, &format!("{least:.0} min at least, which is more than on supports"));
            tried.push(TriedWay { price_min: Some(least), ..cut });
        }
        let taken = if price(&in_parts) < price(&on_supports) { Way::Cut } else { Way::Supports };
        tried.iter_mut().for_each(|one| one.chosen = one.way == taken && one.terms.is_some());
        match (cut, held) {
            (Some((plan, cut)), _) if taken == Way::Cut => {
                Ok(PlannedSomehow { plan, cut: Some(cut), held: None, ways: tried })
            }
            (_, Some((plan, held))) => Ok(PlannedSomehow { plan, cut: None, held: Some(held), ways: tried }),
            _ => Err([no_cut, no_supports]),
        }
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
            done => Ok(PlannedSomehow::as_drawn(done?.of_arranged(arranged))),
        }
    }
}

/// What was found, or why not.
fn parted<T>(tried: Option<Result<T, String>>) -> (Option<T>, Option<String>) {
    match tried {
        Some(Ok(found)) => (Some(found), None),
        Some(Err(why)) => (None, Some(why)),
        None => (None, None),
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
