//! Model and profile to a plan, or to the reasons why there is none.

use super::best::{Limits, Tariff, best};
use super::candidates::{Candidate, Choice, Setups, all_directions};
use super::goal::{Goal, Pricing, WithinSlot};
use super::part_set::PartSet;
use super::plan::{Print, Slot};
use super::sequence::{End, Priority, Problem, Sequence, enumerate};
use super::site::{Site, set_of};
use super::whynot;
use super::workpiece::Workpiece;
use crate::geom::Angle;
use crate::motion::Pose;
use crate::orient::{Direction, Objective, Search};
use crate::profile::Profile;

/// What to plan for.
#[derive(Clone)]
pub struct Options<'a> {
    /// What the plan minimises.
    pub goal: &'a Goal,
    /// What the search for orientations minimises; decides where the goal does not look at orientations.
    pub objective: &'a dyn Objective,
    /// Overhangs up to this angle from the vertical need no support.
    pub overhang: Angle,
    /// Room the head must keep from parts it does not print on, mm.
    pub margin_mm: f64,
    /// Which sequences come first.
    pub priority: Priority,
    /// Whether everything on the table belongs to the first slot.
    pub table_first: bool,
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
            margin_mm: 0.5,
            priority: Priority::Together,
            table_first: true,
            search,
            budget: 20_000_000,
            plans: 1,
            pedestal_mm: 0.0,
            supported: Vec::new(),
            explain: true,
        }
    }
}

/// A plan's slots and what is known of them.
#[derive(Clone, Debug)]
pub struct Planned {
    /// The slots.
    pub slots: Vec<Slot>,
    /// The goal's value.
    pub value: f64,
    /// No plan over these candidates has a lower value, proved.
    pub lower_bound: f64,
    /// Building sequence size, eq. (8): the sum of the parts' slot numbers.
    pub sequence_size: usize,
    /// Pose changes, the first pose included.
    pub pose_changes: usize,
    /// Estimated seconds of printing and turning.
    pub seconds: f64,
    /// Staircase error (seed 004, section 4), summed over the parts, mm⁴.
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

/// Why one part at one orientation cannot be printed.
#[derive(Clone, Debug, PartialEq)]
pub struct Reason {
    /// The part.
    pub part: usize,
    /// The build direction, table frame.
    pub up: [f64; 3],
    /// A part's number, `"table"`, `"limits"` (an axis or its reach), `"frame"` or `"support"`.
    pub blocked_by: String,
    /// How deep the head would reach in, mm.
    pub depth_mm: f64,
    /// In words.
    pub text: String,
    /// The pose it is about.
    pub pose: Pose,
    /// Where the tip is when the head strikes, table frame; for the picture. `None` where nothing strikes, or where no
    /// place was met among those that were looked at.
    pub tip: Option<[f64; 3]>,
}

/// No sequence was found.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Infeasible {
    /// More parts than the search takes on.
    #[error(
        "{parts} parts are too many; this version plans up to {}; join parts that can be printed as one",
        MOST_PARTS
    )]
    TooManyParts {
        /// How many.
        parts: usize,
    },
    /// Parts that hang together with nothing.
    #[error("part {part} ({name}) touches neither the table nor another part that does; move it, or join the parts")]
    Floating {
        /// The first of them.
        part: usize,
        /// Its name.
        name: String,
    },
    /// No place on the table lets every part within the machine's axes.
    #[error("{summary}")]
    NoPlace {
        /// One sentence.
        summary: String,
    },
    /// A part has no orientation, or no order works.
    #[error("{summary}")]
    NoPlan {
        /// One sentence.
        summary: String,
        /// A set of reasons none of which can be left out: without any one of them there would be a plan.
        reasons: Vec<Reason>,
        /// Whether that was proved; otherwise the set may hold more than it need.
        least: bool,
    },
    /// The search's budget ran out.
    #[error("no sequence found within {steps} steps; raise --budget, or give fewer parts")]
    Budget {
        /// Steps taken.
        steps: u64,
    },
}

/// More parts than this are refused at once.
pub const MOST_PARTS: usize = 400;

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
        Some(&part) => Err(Infeasible::Floating { part, name: workpiece.model.parts[part].name.clone() }),
        None => Ok(()),
    }
}

/// The directions to try for each part, best first by `options`' objective, table frame.
pub fn orientations(workpiece: &Workpiece<'_>, options: &Options<'_>) -> Vec<Vec<Direction>> {
    all_directions(workpiece, options.objective, options.search)
}

/// The best plans of `workpiece` where it stands, on the machine of `profile`, with the `directions` of
/// [`orientations`]; at least one, the best first, `options.plans` at most.
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
    let why_not = || match options.explain {
        true => whynot::explain(workpiece, profile, directions, options),
        false => Infeasible::NoPlan { summary: String::new(), reasons: Vec::new(), least: false },
    };
    on_task(workpiece, profile, directions, options, |task| task.solve()).map_err(|end| match end {
        Stuck::Before(no) => no,
        Stuck::Search(End::Budget) => Infeasible::Budget { steps: options.budget },
        Stuck::Ways | Stuck::Search(_) => why_not(),
    })
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
    mut found: impl FnMut(Vec<Slot>) -> bool,
) -> Result<bool, Infeasible> {
    let every = |task: &Task<'_>| {
        let on_table = task.on_table();
        let problem = task.problem(options.priority, &on_table);
        let mut any = false;
        let outcome = enumerate(&problem, options.budget, |sequence| {
            any = true;
            found(slots_of(sequence, task.candidates, task.setups))
        });
        if any || outcome.end == End::Budget { Ok(outcome.end == End::Exhausted) } else { Err(outcome.end) }
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
}

/// Works out who is in whose way, and hands it to `work`.
fn on_task<T>(
    workpiece: &Workpiece<'_>,
    profile: &Profile,
    directions: &[Vec<Direction>],
    options: &Options<'_>,
    work: impl FnOnce(&Task<'_>) -> Result<T, End>,
) -> Result<T, Stuck> {
    plannable(workpiece).map_err(Stuck::Before)?;
    let mut setups = Setups::new(workpiece, profile, options);
    let choices: Vec<Choice> = directions.iter().enumerate().map(|(p, tried)| setups.choose(p, tried)).collect();
    if choices.iter().any(|c| c.candidates.is_empty()) {
        return Err(Stuck::Ways);
    }
    let site = Site::of(&setups, options.margin_mm);
    let tried = choices.iter().map(|c| c.tried).sum();
    let candidates: Vec<Vec<Candidate>> = choices.into_iter().map(|c| c.candidates).collect();
    let blocked = site.blocked(&candidates);
    let task = Task { setups: &setups, site: &site, candidates: &candidates, blocked: &blocked, options, tried };
    work(&task).map_err(Stuck::Search)
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
        set_of(self.candidates.len(), self.setups.workpiece.model.on_table.iter().copied())
    }

    fn problem<'b>(&'b self, priority: Priority, on_table: &'b PartSet) -> Problem<'b> {
        Problem {
            candidates: self.candidates,
            blocked: self.blocked,
            touching: &self.site.touching,
            on_table,
            table_first: self.options.table_first,
            priority,
        }
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
        let limits = Limits { plans: self.options.plans.max(1), steps: self.options.budget, states: MOST_STATES };
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
        let within_slots = worth.within_slots(sequence, self.candidates);
        let worth = worth.worth(sequence, self.candidates);
        Planned {
            slots: slots_of(sequence, self.candidates, self.setups),
            value,
            lower_bound,
            sequence_size: worth.sequence_size,
            pose_changes: worth.pose_changes,
            seconds: worth.seconds,
            staircase: worth.staircase,
            within_slots,
            clearance_mm: self.site.clearance(self.candidates, sequence),
            tried: self.tried,
            candidates: self.candidates.iter().map(Vec::len).sum(),
            steps,
        }
    }
}

/// The sequence with the rotation unwound from setup to setup.
fn slots_of(sequence: &Sequence, candidates: &[Vec<Candidate>], setups: &Setups<'_>) -> Vec<Slot> {
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
        slots.push(Slot { id, prints });
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
