//! The ways to print a model, and the cheapest of them: as it was drawn, turned, on supports, or its solids cut by planes and the parts planned.
//! The model itself is never changed: what is turned or cut is a model of its own, for whoever asked to write beside the output.

use super::allowed::WaysOut;
use super::arrange::{Arrangement, Models, ReadModels, SetUp, WIDER_MM, arranged, arranged_aloud};
use super::costs::{self, as_planned};
use super::cutting::{CutModel, Cutting, in_pieces};
use super::error::StrategyError;
use super::loose::{Cluster, each_by_itself, spread};
use super::plan::{Along, PlanOptions, PlanRequest, PlanResult, Supporting, planned, planned_along};
use super::price::{Terms, WISH, Way, Weights};
use super::refused::Refused;
use super::remedies::{not_what_failed, other_machine, turned_over, with_room};
use super::solids::{CutsOf, Known, groups};
use super::supported::{HeldModel, on_supports};
use super::turning::{Poses, may_turn, turned};
use super::ways::{NoWay, TriedWay};
use crate::geom::Vec3;
use crate::input::load_profile;
use crate::orient::Priced;
use crate::planning::{Remedy, centred};
use crate::spelling::counted;
use crate::split::CutBudget;
use crate::world::{Silent, World};

/// Plans.
///
/// # Errors
///
/// [`StrategyError::NoPlan`] with reasons and remedies; [`StrategyError::Infeasible`], [`StrategyError::Misplaced`] and [`StrategyError::RoomElsewhere`] for a model that cannot be
/// planned at all; [`StrategyError::Setting`]; what reading model and machine may say.
pub fn plan(request: &PlanRequest, world: &World<'_>) -> Result<PlanResult, StrategyError> {
    let machine = load_profile(&request.machine, world)?;
    let how = &request.arrangement;
    let models = Models { read: &ReadModels::read(&request.model, how, world)?, how, machine: &machine };
    let ways = WaysOut { supporting: request.supporting, ..WaysOut::NONE };
    let set = arranged_aloud(&models, world)?;
    Ok(planned_somehow(&models, set, &request.options, &ways, world)?.plan)
}

/// A plan, and what was done to the model for it.
pub(crate) struct PlannedSomehow {
    pub(crate) plan: PlanResult,
    pub(crate) cut: Option<CutModel>,
    pub(crate) held: Option<HeldModel>,
    /// The other ways that work.
    others: Vec<Found>,
}

impl PlannedSomehow {
    /// The cheapest of a plan's ways that work, with the others and those that do not; `None` where none works.
    fn cheapest(mut found: Vec<Found>, tried: Vec<TriedWay>) -> Option<Self> {
        let best = (0..found.len()).min_by(|&a, &b| found[a].rank.total_cmp(&found[b].rank))?;
        let Found { tried: taken, mut plan, cut, held, .. } = found.swap_remove(best);
        plan.ways = vec![TriedWay { chosen: true, ..taken }];
        plan.ways.extend(found.iter().map(|other| other.tried.clone()));
        plan.ways.extend(tried);
        Some(Self { plan, cut, held, others: found })
    }

    /// The next way, where the one that was taken came to nothing, and `lost` says why.
    pub(crate) fn otherwise(&mut self, lost: TriedWay) -> Option<Self> {
        let others = std::mem::take(&mut self.others);
        let known = |way: &&TriedWay| !way.chosen && others.iter().all(|other| other.tried.way != way.way);
        let tried: Vec<TriedWay> = self.plan.ways.iter().filter(known).cloned().chain([lost]).collect();
        Self::cheapest(others, tried)
    }

    /// The way that was taken.
    pub(crate) fn taken(&self) -> Option<&TriedWay> {
        self.plan.ways.iter().find(|way| way.chosen)
    }
}

/// Plans models by the cheapest way that `ways` allow: as they are, turned, on supports, or with their solids cut. Several that
/// have no plan so near to each other are given more room, where nobody said how much.
///
/// What prints as it was drawn is not cut, and turned only where that is cheaper by a twentieth. Cuts, whose search is the long one, are looked for
/// only where they can save as much of all else.
///
/// # Errors
///
/// What [`plan`](super::plan()) says of the models as they are, with why the other ways do not help; [`StrategyError::NoWay`] where they are
/// not to be printed as they are.
pub(crate) fn planned_somehow(
    models: &Models<'_>,
    set: SetUp,
    options: &PlanOptions,
    ways: &WaysOut,
    world: &World<'_>,
) -> Result<PlannedSomehow, StrategyError> {
    // One solid has parts whose order can be demanded only where it is cut.
    let cut = set.model.model.parts.len() == 1 && !options.order.is_empty() && ways.only.is_none();
    let only = Some(Way::Cut).filter(|_| cut && ways.allow(Way::Cut));
    let given = Some(Way::Cut).filter(|_| !ways.cuts.is_empty());
    ways.allow_cuts(&set)?;
    // And on supports all of them are one print.
    let supporting = if options.order.is_empty() { ways.supporting } else { Supporting::Never };
    let ways = &WaysOut { only: ways.only.or(given).or(only), supporting, ..ways.clone() };
    let mut sets = vec![set];
    sets.extend(models.wider(&sets[0]));
    let clusters = if models.how.is_plain() { Cluster::standing(&sets[0].model.model) } else { Vec::new() };
    let mut tries = Tries {
        clusters,
        for_order: only.is_some(),
        misplaced: false,
        models,
        options,
        ways,
        weights: costs::weights(models.machine),
        sets,
        known: Known::default(),
        found: Vec::new(),
        tried: ways.lost.clone(),
        world,
    };
    let drawn = ways.allow(Way::AsDrawn);
    if drawn && !tries.has_others() && tries.sets.len() == 1 && !tries.may_be_moved() {
        return tries.explained();
    }
    let mut why = Refused::Unasked;
    if let Some(lost) = ways.lost.iter().find(|lost| lost.way == Way::AsDrawn) {
        why = lost.why_not.clone().unwrap_or(Refused::Unasked);
    } else if drawn {
        match tries.as_they_are() {
            Ok(Ok(plan)) => tries.find(Way::AsDrawn, plan, None, None),
            Ok(Err(because)) => {
                why = because;
                tries.as_one();
                tries.with_their_gaps();
            }
            // What does not fit as it was drawn may fit otherwise.
            Err(StrategyError::Infeasible(no)) if tries.allowed(Way::Turned) => why = Refused::NoPlan(no),
            Err(error @ StrategyError::Misplaced(_)) if tries.may_be_moved() || tries.allowed(Way::Turned) => {
                why = error.into();
                tries.misplaced = true;
                tries.moved_apart();
            }
            Err(StrategyError::Misplaced(no)) => {
                return Err(with_room(no, &tries.sets[0].model.model, models.machine, world));
            }
            Err(error) => return Err(error),
        }
        if tries.found.is_empty() {
            tries.tried.push(TriedWay::refused(Way::AsDrawn, why.clone()));
        }
    }
    if tries.found.is_empty() {
        if tries.may_be_moved() {
            tries.each_its_way(&why);
        } else {
            tries.turned(Some(&why));
        }
        tries.on_supports(&why);
        tries.cut(&why);
    } else if !tries.may_be_moved() && tries.a_turn_may_be_cheaper() {
        tries.turned(None);
    }
    tries.cheapest()
}

/// The same models with ever more room between them, and the ways that they are printed.
struct Tries<'a> {
    models: &'a Models<'a>,
    options: &'a PlanOptions,
    ways: &'a WaysOut,
    weights: Weights,
    sets: Vec<SetUp>,
    /// Solids that may be moved apart, where nobody has said how they are to stand.
    clusters: Vec<Cluster>,
    /// Whether it is to be cut only because an order is demanded.
    for_order: bool,
    /// Whether the model does not lie on the table as it was drawn.
    misplaced: bool,
    /// What is known of the solids alone.
    known: Known,
    /// The ways that work.
    found: Vec<Found>,
    /// And those that do not.
    tried: Vec<TriedWay>,
    world: &'a World<'a>,
}

/// A way that works.
struct Found {
    tried: TriedWay,
    /// What counts where ways are compared.
    rank: f64,
    plan: PlanResult,
    cut: Option<CutModel>,
    held: Option<HeldModel>,
}

impl Tries<'_> {
    /// Whether a way is wanted, and can be tried.
    fn allowed(&self, way: Way) -> bool {
        let may = match way {
            Way::Turned | Way::TurnedSupports => self.may_be_moved() || may_turn(self.models, &self.sets[0]),
            // Parts of one assembly are not cut; who says where is told so.
            Way::Cut => !self.is_assembly() || !self.ways.cuts.is_empty(),
            Way::AsDrawn | Way::Supports => true,
        };
        may && self.ways.allow(way)
    }

    /// Whether another way is wanted than as drawn.
    fn has_others(&self) -> bool {
        Way::ALL.into_iter().any(|way| way != Way::AsDrawn && self.allowed(way))
    }

    /// Whether there are solids that lie loose beside each other.
    fn may_be_moved(&self) -> bool {
        self.clusters.len() > 1
    }

    /// The models with their loose solids beside each other, with some direction up or, by default, as they were drawn.
    fn spread(&self, ups: &[Option<Vec3>], gap_mm: Option<f64>) -> Option<SetUp> {
        let file = self.models.how.file_of(&self.sets[0].model);
        spread(&self.sets[0], &self.clusters, ups, gap_mm, self.models.machine, &file).ok()
    }

    fn spread_as_drawn(&self, gap_mm: Option<f64>) -> Option<SetUp> {
        self.spread(&vec![None; self.clusters.len()], gap_mm)
    }

    /// As they were drawn, but elsewhere on the table. Whatever is tried later is tried of these.
    fn moved_apart(&mut self) {
        if !self.may_be_moved() {
            return;
        }
        let quiet = PlanOptions { remedies: false, ..self.options.clone() };
        let Some(set) = self.spread_as_drawn(None) else { return };
        if let Ok(plan) = planned(set.model.clone(), self.models.machine.clone(), &quiet, self.world) {
            self.find(Way::AsDrawn, plan.of_arranged(set.arranged.clone()), None, None);
        }
        self.sets = vec![set];
    }

    /// Each loose solid as it is printed by itself: as it was drawn or turned, and on supports where it must be.
    fn each_its_way(&mut self, why: &Refused) {
        if !self.allowed(Way::Turned) && !self.allowed(Way::TurnedSupports) {
            return;
        }
        let silent = World { progress: &Silent, ..*self.world };
        let quiet = PlanOptions { remedies: false, allow: Vec::new(), ..self.options.clone() };
        let ups = each_by_itself(&self.sets[0].model, &self.clusters, self.models.machine, &quiet, &silent);
        let Some(set) = self.spread(&ups, None) else { return };
        let turned = ups.iter().any(Option::is_some);
        if self.allowed(Way::Turned) && turned {
            match planned(set.model.clone(), self.models.machine.clone(), &quiet, &silent) {
                Ok(plan) => self.find(Way::Turned, plan.of_arranged(set.arranged.clone()), None, None),
                Err(no) => self.tried.push(TriedWay::refused(Way::Turned, no.into())),
            }
        }
        if self.found.is_empty() && self.allowed(Way::TurnedSupports) && turned {
            match on_supports(&set.model, self.models.machine, &quiet, &self.ways.holdings, why, &silent) {
                Ok((_, held)) if held.parts.is_empty() => {}
                Ok((plan, held)) => {
                    self.find(Way::TurnedSupports, plan.of_arranged(set.arranged), None, Some(held));
                }
                Err(no) => self.tried.push(TriedWay::refused(Way::TurnedSupports, no)),
            }
        }
        // On supports and in parts they may need the same room.
        if !self.misplaced {
            self.sets.extend(self.spread_as_drawn(None));
        }
    }

    fn is_assembly(&self) -> bool {
        let model = &self.sets[0].model.model;
        model.parts.len() > 1 && groups(model).len() == 1
    }

    /// The plan with the least room that does, or why there is none with the least.
    fn as_they_are(&mut self) -> Result<Result<PlanResult, Refused>, StrategyError> {
        let quiet = PlanOptions { remedies: false, ..self.options.clone() };
        let hushed = PlanOptions { explain: false, ..quiet.clone() };
        let loose = self.sets[0].model.model.interfaces.is_empty() && quiet.leaves_directions();
        let along = |along: Along<'_>, set: &SetUp, options: &PlanOptions| {
            let (model, machine) = (set.model.clone(), self.models.machine.clone());
            match planned_along(along, model, machine, options, self.world) {
                Ok(plan) => Ok(Ok(plan.of_arranged(set.arranged.clone()))),
                Err(StrategyError::NoPlan(no)) => Ok(Err(Refused::NoPlan(no.infeasible))),
                Err(error) => Err(error),
            }
        };
        let plan = |set: &SetUp| {
            if !loose {
                return along(Along::Any, set, &quiet);
            }
            // What stands on the table and touches nothing else stands upright, or has hardly a way at all.
            match along(Along::These(&[Vec3::z()]), set, &quiet)? {
                Err(why) => Ok(along(Along::Any, set, &hushed)?.or(Err(why))),
                done => Ok(done),
            }
        };
        let why = match plan(&self.sets[0])? {
            Err(why) if self.sets.len() > 1 => why,
            done => return Ok(done),
        };
        // More room is of no use to what has no plan by itself.
        if !self.known.each_has_a_plan(&self.sets[0].model, self.models.machine, self.options, self.world) {
            return Ok(Err(why));
        }
        // What no longer fits on the table is no error.
        Ok(self.sets[1..].iter().find_map(|set| plan(set).ok()?.ok()).ok_or(why))
    }

    /// As they were drawn, those that touch as one solid: so every slicer prints them.
    fn as_one(&mut self) {
        let touching = groups(&self.sets[0].model.model).iter().any(|group| group.len() > 1);
        if touching {
            self.upright(Arrangement { join: true, ..self.models.how.clone() });
        }
    }

    /// As they were drawn, with the small gaps between them that were closed so that parts touch: a designer's own supports leave such gaps.
    fn with_their_gaps(&mut self) {
        if self.found.is_empty() && self.sets[0].arranged.is_some() && self.models.how.is_plain() {
            self.upright(Arrangement { snap_mm: 0.0, ..self.models.how.clone() });
        }
    }

    /// As they were drawn, all upright, but set up like this; nothing where they were joined on purpose.
    fn upright(&mut self, how: Arrangement) {
        if self.models.how.join {
            return;
        }
        let silent = World { progress: &Silent, ..*self.world };
        let quiet = PlanOptions { remedies: false, allow: Vec::new(), ..self.options.clone() };
        let Ok(set) = arranged(&Models { how: &how, ..*self.models }) else { return };
        let upright = Along::These(&[Vec3::z()]);
        if let Ok(plan) = planned_along(upright, set.model, self.models.machine.clone(), &quiet, &silent) {
            self.find(Way::AsDrawn, plan.of_arranged(set.arranged), None, None);
        }
    }

    /// Whether a lower pose could be cheaper than the models as they were drawn by so much that it counts.
    fn a_turn_may_be_cheaper(&self) -> bool {
        let least = |found: &Found| {
            let terms = found.tried.terms?;
            let least = self.weights.least_of_a_turn(&terms, costs::layers_min(&found.plan));
            Some(least < WISH * self.weights.price(&terms))
        };
        self.allowed(Way::Turned) && self.found.first().and_then(least).unwrap_or(false)
    }

    /// In other poses: as it is in the first that can be printed so, and on supports in the one that costs the least.
    fn turned(&mut self, why: Option<&Refused>) {
        if !self.allowed(Way::Turned) && !self.allowed(Way::TurnedSupports) {
            return;
        }
        let quiet = PlanOptions { remedies: false, explain: false, ..self.options.clone() };
        let silent = World { progress: &Silent, ..*self.world };
        let (solid, machine) = (&self.sets[0].model.model.parts[0].mesh, self.models.machine);
        let fits = |pose: &Priced| {
            turned(self.models, pose.up.into()).is_ok_and(|set| centred(&set.model.model, &machine.profile).is_ok())
        };
        let poses = if self.misplaced { Poses::that_fit(solid, machine, fits) } else { Poses::of(solid, machine) };
        let upright = Along::These(&[Vec3::z()]);
        if self.allowed(Way::Turned) {
            let plan = |pose: &Priced| {
                let up = <[f64; 3]>::from(pose.up);
                let set = turned(self.models, up).ok()?;
                let plan = planned_along(upright, set.model, self.models.machine.clone(), &quiet, &silent).ok()?;
                Some((up, plan.of_arranged(set.arranged)))
            };
            match poses.others.iter().find_map(plan) {
                Some((up, plan)) => self.find_turned(Way::Turned, up, plan, None),
                None => {
                    let why_not = Refused::Turned { poses: poses.others.len() };
                    self.tried.push(TriedWay::refused(Way::Turned, why_not));
                }
            }
        }
        if let Some(why) = why.filter(|_| self.allowed(Way::TurnedSupports)) {
            self.turned_on_supports(&poses, why, &silent);
        }
    }

    /// On supports in the pose that costs the least with them, where that is another one than it was drawn in; of what does not fit on the table
    /// as it was drawn, in the first that can be printed so.
    fn turned_on_supports(&mut self, poses: &Poses, why: &Refused, silent: &World<'_>) {
        let held = |pose: &Priced| {
            let set = turned(self.models, pose.up.into())?;
            let (plan, held) =
                on_supports(&set.model, self.models.machine, self.options, &self.ways.holdings, why, silent)?;
            // Nobody asked for a pose in which it does not stand by itself: supports have to hold it there.
            match plan.pushed_over().filter(|_| !pose.stands) {
                Some(no) => Err(Refused::NoPlan(no)),
                None => Ok((pose.up.into(), plan.of_arranged(set.arranged), held)),
            }
        };
        let some: Vec<&Priced> = if self.misplaced {
            poses.others.iter().chain(&poses.shaky).collect()
        } else {
            poses.cheaper().into_iter().collect()
        };
        let mut first: Option<Refused> = None;
        for pose in some {
            match held(pose) {
                // That is the turned one.
                Ok((_, _, held)) if held.parts.is_empty() => return,
                Ok((up, plan, held)) => return self.find_turned(Way::TurnedSupports, up, plan, Some(held)),
                Err(no) => drop(first.get_or_insert(no)),
            }
        }
        self.tried.extend(first.map(|no| TriedWay::refused(Way::TurnedSupports, no)));
    }

    fn on_supports(&mut self, why: &Refused) {
        if !self.allowed(Way::Supports) {
            return;
        }
        let held = self.first_of(|set| {
            let (machine, holdings) = (self.models.machine, &self.ways.holdings);
            let (plan, held) = on_supports(&set.model, machine, self.options, holdings, why, self.world)?;
            Ok((plan.of_arranged(set.arranged.clone()), held))
        });
        match held {
            // As it is sliced nothing of it hangs: that is as it was drawn.
            Ok((plan, held)) if held.parts.is_empty() => {
                let why_not = Refused::NothingHangs { on_table: false };
                self.tried.push(TriedWay::refused(Way::Supports, why_not));
                if self.ways.allow(Way::AsDrawn) {
                    self.tried.retain(|tried| tried.way != Way::AsDrawn);
                    self.find(Way::AsDrawn, plan, None, None);
                }
            }
            Ok((plan, held)) => self.find(Way::Supports, plan, None, Some(held)),
            Err(no) => self.tried.push(TriedWay::refused(Way::Supports, no)),
        }
    }

    /// In parts, where that can save a twentieth of all that was found.
    fn cut(&mut self, why: &Refused) {
        let Cutting::Auto { file } = &self.ways.cutting else { return };
        if !self.allowed(Way::Cut) {
            return;
        }
        let least = self.least_of_a_cut();
        if self.found.iter().any(|found| WISH * found.rank <= least) {
            self.tried.push(TriedWay::dearer(Way::Cut, least));
            return;
        }
        let how = CutsOf { file, cuts: &self.ways.cuts, budget: self.budget_of_cuts() };
        if !how.cuts.is_empty() && self.may_be_moved() {
            // Nobody has looked yet how much room they need.
            let wider = std::iter::once(None).chain(WIDER_MM.map(Some));
            self.sets.extend(wider.filter_map(|gap_mm| self.spread_as_drawn(gap_mm)).collect::<Vec<_>>());
        }
        let cheapest = self.found.iter().min_by(|a, b| a.rank.total_cmp(&b.rank));
        let named =
            |found: &Found| Some(format!("{} (price {:.0} min)", found.tried.way.word(), found.tried.price_min?));
        let known = cheapest.and_then(named);
        self.world.progress.may_end(known.as_deref());
        let mut known = std::mem::take(&mut self.known);
        let machine = self.models.machine;
        let cut = self.first_of(|set| {
            let (mut plan, solids, bytes) = in_pieces(set, machine, self.options, how, &mut known, self.world)?;
            let cut = CutModel { solids, bytes, file: file.clone(), why: why.clone() };
            plan.story = Some(cut.story(plan.best().seconds));
            Ok((plan.of_arranged(set.arranged.clone()), cut))
        });
        self.world.progress.may_end(None);
        match cut {
            Ok((plan, cut)) => self.find(Way::Cut, plan, Some(cut), None),
            Err(no) => self.tried.push(TriedWay::refused(Way::Cut, no)),
        }
    }

    /// What setups and seams may cost so that cut parts save a twentieth of all that was found.
    fn budget_of_cuts(&self) -> Option<CutBudget> {
        let incumbent = self.found.iter().map(|found| found.rank).reduce(f64::min)?;
        let Weights { setup, seam_mm2, .. } = self.weights;
        let whole = self.least_of_a_cut() - self.weights.least_of_a_cut(&Terms::default());
        Some(CutBudget { setup_min: setup, seam_min_per_mm2: seam_mm2, most_min: WISH * incumbent - whole })
    }

    /// What cut parts cost at least: as much as the model does on supports, without these; 0 where nothing is known of it.
    fn least_of_a_cut(&self) -> f64 {
        let bare = |found: &Found| {
            let held_min = found.held.as_ref().map_or(0.0, HeldModel::seconds) / 60.0;
            let terms = found.tried.terms?;
            let layers_min = costs::layers_min(&found.plan);
            let grams = terms.grams - terms.support_g;
            Some(self.weights.least_of_a_cut(&Terms {
                minutes: (terms.minutes - held_min - layers_min).max(0.0),
                grams,
                ..terms
            }))
        };
        self.found.iter().filter_map(bare).reduce(f64::min).unwrap_or(0.0)
    }

    /// What `way` makes of the set with the least room that it does for, or why it does for none: what it says of the first.
    fn first_of<T>(&self, mut way: impl FnMut(&SetUp) -> Result<T, Refused>) -> Result<T, Refused> {
        let mut why = None;
        for set in &self.sets {
            match way(set) {
                Ok(done) => return Ok(done),
                Err(no) => why = why.or(Some(no)),
            }
        }
        Err(why.unwrap_or(Refused::Unasked))
    }

    fn find(&mut self, way: Way, plan: PlanResult, cut: Option<CutModel>, held: Option<HeldModel>) {
        let terms = match (&cut, &held) {
            (Some(cut), _) => costs::in_parts(&plan, cut.seam_mm2()),
            (_, Some(held)) => costs::on_supports(&plan, held),
            _ => as_planned(&plan),
        };
        let tried = TriedWay::priced(way, None, terms, &self.weights);
        self.found.push(Found { tried, rank: self.weights.rank(way, &terms), plan, cut, held });
    }

    fn find_turned(&mut self, way: Way, up: [f64; 3], plan: PlanResult, held: Option<HeldModel>) {
        self.find(way, plan, None, held);
        self.found.iter_mut().filter(|found| found.tried.way == way).for_each(|found| found.tried.up = Some(up));
    }

    /// The cheapest of what was found, else why there is nothing.
    fn cheapest(mut self) -> Result<PlannedSomehow, StrategyError> {
        if self.found.is_empty() {
            return self.explained();
        }
        let (found, tried) = (std::mem::take(&mut self.found), std::mem::take(&mut self.tried));
        PlannedSomehow::cheapest(found, tried).map_or_else(|| self.explained(), Ok)
    }

    /// As drawn with the least room once more, with what would help; and why the other ways do not.
    fn explained(mut self) -> Result<PlannedSomehow, StrategyError> {
        if !self.ways.allow(Way::AsDrawn) {
            let (only, for_order) = (self.ways.only, self.for_order);
            let for_cuts = !self.ways.cuts.is_empty();
            return Err(StrategyError::NoWay(Box::new(NoWay { only, for_order, for_cuts, ways: self.tried })));
        }
        let turned = may_turn(self.models, &self.sets[0]) && !self.ways.allow(Way::Turned);
        let SetUp { model, arranged, .. } = self.sets.swap_remove(0);
        let touching = groups(&model.model).iter().any(|group| group.len() > 1);
        let why_not = |way: Way| self.tried.iter().find(|tried| tried.way == way)?.why_not.clone();
        let [cut, held] = [Way::Cut, Way::Supports].map(why_not);
        let misplaced = model.model.clone();
        match planned(model, self.models.machine.clone(), self.options, self.world) {
            Err(StrategyError::NoPlan(mut no)) => {
                // Where all that stands in the way is support, no machine helps.
                let (reasons, least) = no.reasons();
                let machine = !(least && reasons.iter().all(|reason| reason.blocked_by == "support"));
                if let Some(remedies) = &mut no.remedies {
                    not_what_failed(remedies, &self.tried, &no.model.model);
                    // One that stands on a large face is named already.
                    let turned = turned && remedies.iter().all(|remedy| remedy.kind != "base");
                    let turned =
                        turned.then(|| turned_over(self.models, &no.model, self.options, self.world)).flatten();
                    let joined = touching.then(|| joined(self.models, self.options, self.world)).flatten();
                    remedies.extend(turned.into_iter().chain(joined));
                    let other = || other_machine(&no.model, self.models.machine, self.options, self.world);
                    remedies.extend(machine.then(other).flatten());
                }
                (no.cut, no.held, no.ways) = (cut, held, self.tried);
                Err(StrategyError::NoPlan(no))
            }
            Err(StrategyError::Misplaced(no)) => Err(with_room(no, &misplaced, self.models.machine, self.world)),
            done => {
                let mut plan = done?.of_arranged(arranged);
                let way = TriedWay::priced(Way::AsDrawn, None, as_planned(&plan), &self.weights);
                plan.ways = vec![TriedWay { chosen: true, ..way }];
                Ok(PlannedSomehow { plan, cut: None, held: None, others: Vec::new() })
            }
        }
    }
}

/// Whether there is a plan where parts that touch are one solid, as it is or on supports.
fn joined(models: &Models<'_>, options: &PlanOptions, world: &World<'_>) -> Option<Remedy> {
    let world = &World { progress: &Silent, ..*world };
    let how = Arrangement { join: true, ..models.how.clone() };
    let set = arranged(&Models { how: &how, ..*models }).ok()?;
    let options = PlanOptions { remedies: false, plans: 1, ..options.clone() };
    let whole = WaysOut { supporting: Supporting::Auto, ..WaysOut::NONE };
    let again = Models { how: &how, ..*models };
    let done = planned_somehow(&again, set, &options, &whole, world).ok()?;
    let on = if done.held.is_some() { ", on supports (--supports auto)" } else { "" };
    let parts = done.plan.plan.model.model.parts.len();
    let text = format!("join touching parts (--join): this gives {} with a plan{on}", counted(parts, "solid"));
    Some(Remedy { kind: "join", amount: parts as f64, text })
}
