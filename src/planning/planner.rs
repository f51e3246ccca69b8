//! Model and profile to a plan, or to the reasons why there is none.

use super::best::{SearchLimits, Tariff, best};
use super::candidates::{Candidate, Setups, Sifted, all_directions, fan, in_order};
use super::infeasible::{Infeasible, MOST_PARTS, Near, Reason};
use super::options::{Options, Priority};
use super::part_set::PartSet;
use super::plan::{Print, TimeSlot};
use super::pricing::{Pricing, WithinSlot};
use super::sequence::{End, Problem, Sequence, enumerate};
use super::site::{Site, set_of};
use super::turning::{Struck, Turns, remedy};
use super::whynot;
use super::workpiece::Workpiece;
use crate::geom::Angle;
use crate::mesh::Neighbours;
use crate::motion::Pose;
use crate::orient::Direction;
use crate::profile::Profile;

/// A plan's slots and what is known of them.
#[derive(Clone, Debug)]
pub struct Planned {
    /// The slots.
    pub slots: Vec<TimeSlot>,
    /// The goal's value.
    pub value: f64,
    /// No plan over these candidates has a lower value, proved.
    pub lower_bound: f64,
    /// Building sequence size, eq. (8): the sum of the parts' slot numbers.
    pub sequence_size: usize,
    /// Pose changes, the first pose included.
    pub pose_changes: usize,
    /// Estimated seconds of printing and turning, before anything is sliced; a sliced file's own time is verification's.
    pub seconds: f64,
    /// Of these, the printing of each part, by its number.
    pub part_seconds: Vec<f64>,
    /// Staircase error (Ramos et al. (2021), section 4), summed over the parts, mm⁴.
    pub staircase: f64,
    /// Slots with several poses: what printing them pose by pose costs, and what layer by layer would.
    pub within_slots: Vec<WithinSlot>,
    /// How far the head stays from parts it does not print on and from the table, at the least, mm; at most
    /// [`CLEARANCE_SOUGHT_MM`](super::CLEARANCE_SOUGHT_MM).
    pub clearance_mm: f64,
    /// Directions tried, over all parts.
    pub tried: usize,
    /// Orientations kept, over all parts.
    pub candidates: usize,
    /// Steps of the sequence search.
    pub steps: u64,
}

/// States that the search for the best sequence may keep; some 300 bytes each.
const MOST_STATES: usize = 400_000;

/// Whether planning can begin: not too many parts, none that hangs together with nothing.
///
/// # Errors
///
/// [`Infeasible::TooManyParts`] and [`Infeasible::Floating`].
pub fn plannable(workpiece: &Workpiece<'_>) -> Result<(), Infeasible> {
    let parts = workpiece.parts.len();
    if parts > MOST_PARTS {
        return Err(Infeasible::TooManyParts { parts });
    }
    match workpiece.model.floating().first() {
        Some(&part) => {
            let model = workpiece.model;
            let named = |id: usize| model.parts[id].name.clone();
            let nearest =
                Neighbours::of(&model.parts).nearest(part).map(|(part, mm)| Near { part, name: named(part), mm });
            Err(Infeasible::Floating { part, name: named(part), nearest })
        }
        None => Ok(()),
    }
}

/// The directions to try for each part, best first by `options`' objective, table frame.
pub fn orientations(workpiece: &Workpiece<'_>, options: &Options<'_>) -> Vec<Vec<Direction>> {
    all_directions(workpiece, options.objective, options.search)
}

/// What `among` makes of `directions`, and where that is no plan, of more of them for the parts that its reasons name: what lies between the minima
/// that [`orientations`] gives. More for any other part would leave the reasons as they are. Ends when these name no other part that touches
/// one and is not `fixed`; `directions` are then those of the answer.
///
/// # Errors
///
/// The last of `among`.
pub fn widening<T>(
    workpiece: &Workpiece<'_>,
    options: &Options<'_>,
    fixed: &[usize],
    directions: &mut [Vec<Direction>],
    among: impl Fn(&[Vec<Direction>]) -> Result<T, Infeasible>,
) -> Result<T, Infeasible> {
    let mut done = fixed.to_vec();
    loop {
        let found = among(directions);
        let Err(Infeasible::NoPlan { reasons, .. }) = &found else { return found };
        let mut any = false;
        for part in reasons.iter().map(|reason| reason.part) {
            if done.contains(&part) {
                continue;
            }
            done.push(part);
            let more = fan(workpiece, part, options.objective, &directions[part]);
            any |= !more.is_empty();
            directions[part].extend(more);
        }
        if !any {
            return found;
        }
    }
}

/// The best plans of `workpiece` where it stands, on the machine of `profile`, with the `directions` of
/// [`orientations`]; at least one, the best first, `options.plans` at most.
///
/// What needs no bridge and no tolerance comes first: only where there is no plan without them do layers decide
/// ([`Options::practised`]).
///
/// # Errors
///
/// [`Infeasible`] with the reasons, if `options.explain`.
pub fn plan(
    workpiece: &Workpiece<'_>,
    profile: &Profile,
    directions: &[Vec<Direction>],
    options: &Options<'_>,
) -> Result<Vec<Planned>, Infeasible> {
    if options.practised {
        let strict = Options { practised: false, explain: false, ..options.clone() };
        match plan(workpiece, profile, directions, &strict) {
            Err(Infeasible::NoPlan { .. }) => {}
            found => return found,
        }
    }
    let why_not = || match options.explain {
        true => whynot::explain(workpiece, profile, directions, options),
        false => Infeasible::NoPlan { summary: String::new(), reasons: Vec::new(), least: false },
    };
    on_task(workpiece, profile, directions, options, |task| task.solve_with_turns()).map_err(|end| match end {
        Stuck::Before(no) => no,
        Stuck::Search(End::Budget) => Infeasible::Budget { steps: options.budget },
        Stuck::Turns(struck) => no_turn(workpiece, profile, &struck),
        Stuck::Ways | Stuck::Search(_) => why_not(),
    })
}

/// No sequence whose turns are all clear: what was struck, turn by turn.
fn no_turn(workpiece: &Workpiece<'_>, profile: &Profile, struck: &[Struck]) -> Infeasible {
    let reason = |one: &Struck| Reason {
        part: one.to.first().or(one.part.as_ref()).copied().unwrap_or_default(),
        up: [0.0, 0.0, 1.0],
        blocked_by: one.part.map_or("table".to_owned(), |part| part.to_string()),
        depth_mm: 0.0,
        text: one.text.clone(),
        hangs: None,
        pose: one.pose,
        tip: None,
    };
    let reasons: Vec<Reason> = struck.iter().map(reason).collect();
    let nearest = struck.last().map(|one| one.text.as_str()).unwrap_or_default();
    let parts = workpiece.parts.len();
    let summary = format!("no order prints all {parts} parts with every turn clear: {nearest}; {}", remedy(profile));
    Infeasible::NoPlan { summary, reasons, least: false }
}

/// Calls `found` for every feasible sequence of slots until it returns `false`; whether all were seen.
///
/// # Errors
///
/// [`Infeasible`], without reasons, where there is none.
pub fn sequences(
    workpiece: &Workpiece<'_>,
    profile: &Profile,
    directions: &[Vec<Direction>],
    options: &Options<'_>,
    mut found: impl FnMut(Vec<TimeSlot>) -> bool,
) -> Result<bool, Infeasible> {
    if options.practised {
        let strict = Options { practised: false, ..options.clone() };
        match sequences(workpiece, profile, directions, &strict, &mut found as &mut dyn FnMut(Vec<TimeSlot>) -> bool) {
            Err(Infeasible::NoPlan { .. }) => {}
            listed => return listed,
        }
    }
    let every = |task: &Task<'_>| {
        let on_table = task.on_table();
        let problem = task.problem(options.priority, &on_table);
        let mut any = false;
        let turns = Turns::of(task.setups);
        let outcome = enumerate(&problem, options.budget, |sequence| {
            let slots = slots_of(sequence, task.candidates, task.setups);
            if turns.struck(&slots).is_some() {
                return true;
            }
            any = true;
            found(slots)
        });
        let some = any || outcome.end == End::Budget;
        if some { Ok(outcome.end == End::Exhausted) } else { Err(Stuck::Search(outcome.end)) }
    };
    on_task(workpiece, profile, directions, options, every).map_err(|end| match end {
        Stuck::Before(no) => no,
        _ => Infeasible::NoPlan { summary: "there is no sequence".to_owned(), reasons: Vec::new(), least: false },
    })
}

/// Where planning stopped.
enum Stuck {
    Before(Infeasible),
    /// A part has no way to be printed.
    Ways,
    Search(End),
    /// Every sequence has a turn that is not clear; these were met.
    Turns(Vec<Struck>),
}

/// Works out who is in whose way, and hands it to `work`.
fn on_task<T>(
    workpiece: &Workpiece<'_>,
    profile: &Profile,
    directions: &[Vec<Direction>],
    options: &Options<'_>,
    work: impl FnOnce(&Task<'_>) -> Result<T, Stuck>,
) -> Result<T, Stuck> {
    plannable(workpiece).map_err(Stuck::Before)?;
    let mut setups = Setups::new(workpiece, profile, options);
    let choices: Vec<Sifted> = directions.iter().enumerate().map(|(p, tried)| setups.choose(p, tried)).collect();
    if choices.iter().any(|c| c.candidates.is_empty()) {
        return Err(Stuck::Ways);
    }
    let site = Site::of(&setups, options.margin_mm);
    let tried = choices.iter().map(|c| c.tried).sum();
    let mut candidates: Vec<Vec<Candidate>> = choices.into_iter().map(|c| c.candidates).collect();
    in_order(&mut candidates, options);
    let blocked = site.blocked(&candidates);
    let task = Task { setups: &setups, site: &site, candidates: &candidates, blocked: &blocked, options, tried };
    work(&task)
}

/// Everything worked out, ready for the search.
struct Task<'a> {
    setups: &'a Setups<'a>,
    site: &'a Site<'a>,
    candidates: &'a [Vec<Candidate>],
    blocked: &'a [Vec<PartSet>],
    options: &'a Options<'a>,
    tried: usize,
}

impl Task<'_> {
    fn on_table(&self) -> PartSet {
        set_of(self.candidates.len(), self.setups.workpiece.model.in_place())
    }

    fn problem<'b>(&'b self, priority: Priority, on_table: &'b PartSet) -> Problem<'b> {
        Problem {
            candidates: self.candidates,
            blocked: self.blocked,
            touching: &self.site.touching,
            on_table,
            table_first: self.options.table_first(),
            priority,
        }
    }

    /// The best plans among those whose turns are clear: what a turn of a plan strikes must not be there before the setup that it
    /// leads to, and the search begins anew.
    fn solve_with_turns(&self) -> Result<Vec<Planned>, Stuck> {
        let turns = Turns::of(self.setups);
        let mut blocked = self.blocked.to_vec();
        let mut met: Vec<Struck> = Vec::new();
        loop {
            let plans = match (Task { blocked: &blocked, ..*self }).solve() {
                Ok(plans) => plans,
                Err(End::Exhausted) if !met.is_empty() => return Err(Stuck::Turns(met)),
                Err(end) => return Err(Stuck::Search(end)),
            };
            let Some(struck) = plans.iter().find_map(|plan| turns.struck(&plan.slots)) else { return Ok(plans) };
            let learnt = self.forbid(&struck, &mut blocked);
            met.push(struck);
            if !learnt {
                return Err(Stuck::Turns(met));
            }
        }
    }

    /// Bars what `struck` names from standing before the setup that the turn leads to; whether that is anything new.
    fn forbid(&self, struck: &Struck, blocked: &mut [Vec<PartSet>]) -> bool {
        let Some(other) = struck.part else { return false };
        let mut learnt = false;
        for &part in struck.to.iter().filter(|&&part| part != other) {
            for (way, set) in self.candidates[part].iter().zip(&mut blocked[part]) {
                if is_pose(way.pose, struck.pose) {
                    learnt |= !set.has(other);
                    set.insert(other);
                }
            }
        }
        learnt
    }

    fn solve(&self) -> Result<Vec<Planned>, End> {
        let on_table = self.on_table();
        let problem = |priority| self.problem(priority, &on_table);
        match self.options.priority {
            Priority::Single => match self.cheapest(&problem(Priority::OnlySingle)) {
                // Going back step by step, a slot of two deep down would come before single slots from higher up.
                Err(_) => {
                    let (sequence, steps) = self.first(&problem(Priority::Single))?;
                    // Whatever comes first, it is one of all sequences, and no cheaper than the cheapest.
                    let all = self.cheapest(&problem(Priority::Together))?;
                    Ok(vec![self.priced(&sequence, all[0].lower_bound, steps)])
                }
                found => found,
            },
            priority => self.cheapest(&problem(priority)),
        }
    }

    fn first(&self, problem: &Problem<'_>) -> Result<(Sequence, u64), End> {
        let mut first = None;
        let outcome = enumerate(problem, self.options.budget, |sequence| {
            first = Some(sequence.clone());
            false
        });
        first.map(|sequence| (sequence, outcome.steps)).ok_or(outcome.end)
    }

    fn cheapest(&self, problem: &Problem<'_>) -> Result<Vec<Planned>, End> {
        let tariff = self.tariff();
        let limits = SearchLimits { plans: self.options.plans.max(1), steps: self.options.budget, states: MOST_STATES };
        let found = best(problem, &tariff, &limits);
        let bound = found.bound.map_or(f64::INFINITY, |b| tariff.value(&b));
        if found.plans.is_empty() {
            if found.proved {
                return Err(End::Exhausted);
            }
            // The quick look and the search for the best ran out; the printed algorithms may still find one.
            let (sequence, steps) = self.first(problem)?;
            return Ok(vec![self.priced(&sequence, bound, found.steps + steps)]);
        }
        let plans = found.plans.iter().map(|(cost, sequence)| {
            let value = tariff.value(cost);
            self.planned(sequence, value, bound.min(value), found.steps)
        });
        Ok(plans.collect())
    }

    fn tariff(&self) -> Tariff {
        let Setups { workpiece, profile, .. } = self.setups;
        let pricing = Pricing { workpiece, profile, also: self.options.objective };
        Tariff::of(&pricing.ranks(self.options.goal, self.candidates))
    }

    /// A sequence that was not found by its price.
    fn priced(&self, sequence: &Sequence, lower_bound: f64, steps: u64) -> Planned {
        let tariff = self.tariff();
        let value = tariff.value(&tariff.of_sequence(sequence, self.candidates));
        self.planned(sequence, value, lower_bound, steps)
    }

    fn planned(&self, sequence: &Sequence, value: f64, lower_bound: f64, steps: u64) -> Planned {
        let Setups { workpiece, profile, .. } = self.setups;
        let worth = Pricing { workpiece, profile, also: self.options.objective };
        let mut part_seconds = vec![0.0; self.candidates.len()];
        for &(part, k) in sequence.iter().flatten() {
            part_seconds[part] = worth.print_seconds(part, self.candidates[part][k].up);
        }
        let within_slots = worth.within_slots(sequence, self.candidates);
        let worth = worth.worth(self.setups, sequence, self.candidates);
        Planned {
            slots: slots_of(sequence, self.candidates, self.setups),
            value,
            lower_bound,
            sequence_size: worth.sequence_size,
            pose_changes: worth.pose_changes,
            seconds: worth.seconds,
            part_seconds,
            staircase: worth.staircase,
            within_slots,
            clearance_mm: self.site.clearance(self.candidates, sequence),
            tried: self.tried,
            candidates: self.candidates.iter().map(Vec::len).sum(),
            steps,
        }
    }
}

/// Whether the words of a plan mean `pose`, whole turns aside.
fn is_pose(pose: Pose, word: Pose) -> bool {
    let same = |a: Angle, b: Angle| (a - b).abs().deg() < 1e-3;
    same(pose.tilt, word.tilt) && same(pose.rotation.nearest_to(word.rotation), word.rotation)
}

/// The sequence with the rotation unwound from setup to setup.
fn slots_of(sequence: &Sequence, candidates: &[Vec<Candidate>], setups: &Setups<'_>) -> Vec<TimeSlot> {
    let mut at = Pose::LEVEL;
    let mut last: Option<(usize, usize)> = None;
    let mut slots = Vec::new();
    for (id, slot) in sequence.iter().enumerate() {
        let mut prints = Vec::new();
        for &(part, k) in slot {
            let candidate = &candidates[part][k];
            if last != Some((id, candidate.setup)) {
                at = unwind(candidate.pose, at, setups);
                last = Some((id, candidate.setup));
            }
            prints.push(Print::new(part, candidate.up, at, &setups.table));
        }
        slots.push(TimeSlot { id, prints });
    }
    slots
}

/// The pose's rotation on the turn nearest to where the table stands, if its stops allow it.
///
/// An upright part's rotation would be free, but what the head clears was worked out for this one: only whole turns.
fn unwind(pose: Pose, at: Pose, setups: &Setups<'_>) -> Pose {
    let turn = Angle::from_deg(360.0);
    let nearest = pose.rotation.nearest_to(at.rotation);
    // Half a turn either way is a tie: the smaller word is easier to read and winds nothing up.
    [nearest, nearest - turn, nearest + turn, pose.rotation]
        .into_iter()
        .filter(|&r| setups.table.rotation.admits(r))
        .min_by(|a, b| {
            let way = |r: &Angle| ((*r - at.rotation).abs().deg() * 1e3).round();
            way(a).total_cmp(&way(b)).then(a.abs().deg().total_cmp(&b.abs().deg()))
        })
        .map_or(pose, |rotation| Pose { rotation, ..pose })
}
