//! Model and profile to a plan, or to the reasons why there is none.

use std::collections::VecDeque;

use rayon::prelude::*;

use super::candidates::{Candidate, Choice, Rejected, Setups, all_directions};
use super::collision::{Clearance, Head, LIFT_LAYERS, contact_mm};
use super::part_set::PartSet;
use super::plan::{Print, Slot};
use super::sequence::{End, Priority, Problem, Sequence, enumerate};
use super::solid::Solid;
use super::workpiece::Workpiece;
use crate::geom::{Angle, Machine, Rigid, Table, Vec3};
use crate::motion::Pose;
use crate::orient::{Direction, Multistart, Objective};
use crate::profile::Profile;

/// What to plan for.
pub struct Options {
    /// Which orientations are tried first.
    pub objective: Box<dyn Objective>,
    /// Overhangs up to this angle from the vertical need no support.
    pub overhang: Angle,
    /// Room the head must keep from parts it does not print on, mm.
    pub margin_mm: f64,
    /// Which sequences come first.
    pub priority: Priority,
    /// Whether everything on the table belongs to the first slot.
    pub table_first: bool,
    /// The search for orientations.
    pub search: Multistart,
    /// Most steps of the sequence search.
    pub budget: u64,
}

/// A plan's slots and what is known of them.
#[derive(Clone, Debug)]
pub struct Planned {
    /// The slots.
    pub slots: Vec<Slot>,
    /// Building sequence size, eq. (8): the sum of the parts' slot numbers.
    pub value: f64,
    /// No sequence can be below it: every part comes at least as many slots after the table as there are parts between.
    pub lower_bound: f64,
    /// How far the head stays from parts it does not print on and from the table, at the least, mm; at most
    /// [`CLEARANCE_SOUGHT_MM`].
    pub clearance_mm: f64,
    /// Directions tried, over all parts.
    pub tried: usize,
    /// Orientations kept, over all parts.
    pub candidates: usize,
    /// Steps of the sequence search.
    pub steps: u64,
}

/// Clearances beyond this are not worked out, mm.
pub const CLEARANCE_SOUGHT_MM: f64 = 20.0;

/// Why one part at one orientation cannot be printed.
#[derive(Clone, Debug, PartialEq)]
pub struct Reason {
    /// The part.
    pub part: usize,
    /// The build direction, table frame.
    pub up: [f64; 3],
    /// A part's number, `"table"`, `"limits"` or `"support"`.
    pub blocked_by: String,
    /// How deep the head would reach in, mm.
    pub depth_mm: f64,
    /// In words.
    pub text: String,
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
    /// A part has no orientation, or no order works.
    #[error("{summary}")]
    NoPlan {
        /// One sentence.
        summary: String,
        /// One for each orientation that was looked at.
        reasons: Vec<Reason>,
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
pub fn orientations(workpiece: &Workpiece<'_>, options: &Options) -> Vec<Vec<Direction>> {
    all_directions(workpiece, options.objective.as_ref(), &options.search)
}

/// Plans `workpiece` on the machine of `profile` with the `directions` of [`orientations`].
///
/// # Errors
///
/// [`Infeasible`] with a reason for every orientation that stands in the way.
pub fn plan(
    workpiece: &Workpiece<'_>,
    profile: &Profile,
    directions: &[Vec<Direction>],
    options: &Options,
) -> Result<Planned, Infeasible> {
    let parts = workpiece.parts.len();
    plannable(workpiece)?;
    let mut setups = Setups {
        workpiece,
        profile,
        table: profile.kinematics(),
        head: Head::of(profile),
        threshold: options.overhang,
        solids: workpiece.parts.par_iter().map(Solid::of).collect(),
        poses: Vec::new(),
    };
    let choices: Vec<Choice> = directions.iter().enumerate().map(|(p, tried)| setups.choose(p, tried)).collect();
    if let Some(part) = choices.iter().position(|c| c.candidates.is_empty()) {
        return Err(no_orientation(workpiece, part, &choices[part]));
    }
    let site = Site::of(&setups, options.margin_mm);
    let candidates: Vec<Vec<Candidate>> = choices.iter().map(|c| c.candidates.clone()).collect();
    let blocked = site.blocked(&candidates);
    let on_table = set_of(parts, workpiece.model.on_table.iter().copied());
    let search = |priority| {
        let problem = Problem {
            candidates: &candidates,
            blocked: &blocked,
            touching: &site.touching,
            on_table: &on_table,
            table_first: options.table_first,
            priority,
        };
        let mut first: Option<Sequence> = None;
        let outcome = enumerate(&problem, options.budget, |sequence| {
            first = Some(sequence.clone());
            false
        });
        (first, outcome)
    };
    let (mut first, mut outcome) = match options.priority {
        // Going back step by step, a slot of two deep down would come before single slots from higher up.
        Priority::Single => search(Priority::OnlySingle),
        other => search(other),
    };
    if first.is_none() && options.priority == Priority::Single {
        (first, outcome) = search(Priority::Single);
    }
    let Some(sequence) = first else {
        return Err(match outcome.end {
            End::Budget => Infeasible::Budget { steps: outcome.steps },
            _ => site.no_sequence(&candidates, &blocked, &outcome.farthest),
        });
    };
    Ok(Planned {
        value: sequence.iter().enumerate().map(|(t, slot)| (t * slot.len()) as f64).sum(),
        lower_bound: depths(&site.touching, &workpiece.model.on_table).iter().sum(),
        clearance_mm: site.clearance(&candidates, &sequence),
        slots: slots_of(&sequence, &candidates, &setups),
        tried: choices.iter().map(|c| c.tried).sum(),
        candidates: candidates.iter().map(Vec::len).sum(),
        steps: outcome.steps,
    })
}

fn set_of(parts: usize, members: impl IntoIterator<Item = usize>) -> PartSet {
    let mut set = PartSet::new(parts);
    members.into_iter().for_each(|p| set.insert(p));
    set
}

/// Parts at their poses, for collision questions.
struct Site<'a> {
    workpiece: &'a Workpiece<'a>,
    profile: &'a Profile,
    head: &'a Head,
    margin_mm: f64,
    /// Parts that share an interface.
    touching: Vec<PartSet>,
    /// Parts that lie so near to each other that the head cannot keep its margin from the one at the other.
    near: Vec<PartSet>,
    /// By part, on the table.
    solids: &'a [Solid],
    table: Solid,
    /// By setup.
    motions: Vec<Rigid<Table, Machine>>,
}

impl<'a> Site<'a> {
    fn of(setups: &'a Setups<'a>, margin_mm: f64) -> Self {
        let parts = setups.workpiece.parts.len();
        let mut touching = vec![PartSet::new(parts); parts];
        for interface in &setups.workpiece.model.interfaces {
            touching[interface.a].insert(interface.b);
            touching[interface.b].insert(interface.a);
        }
        let solids = &setups.solids;
        let near = near(solids, margin_mm + contact_mm(setups.profile));
        let motions = setups.poses.iter().map(|(_, pose)| setups.table.forward(*pose)).collect();
        let Setups { workpiece, profile, head, .. } = setups;
        let table = Solid::hull(profile.table_slab());
        Site { workpiece, profile, head, margin_mm, touching, near, solids, table, motions }
    }

    fn lift(&self, part: usize, other: usize) -> f64 {
        if self.near[part].has(other) {
            contact_mm(self.profile)
        } else {
            LIFT_LAYERS * self.profile.process.layer_height_mm
        }
    }

    fn margin(&self, part: usize, other: usize) -> f64 {
        if self.near[part].has(other) { 1e-3 } else { self.margin_mm.max(1e-3) }
    }

    /// `[part][candidate]` -> the parts that must not be there before.
    fn blocked(&self, candidates: &[Vec<Candidate>]) -> Vec<Vec<PartSet>> {
        let parts = candidates.len();
        let of_part = |part: usize| {
            let one = |c: &Candidate| {
                let others = (0..parts).filter(|&q| q != part && self.blocks(part, q, c.setup));
                set_of(parts, others)
            };
            candidates[part].iter().map(one).collect()
        };
        (0..parts).into_par_iter().map(of_part).collect()
    }

    fn blocks(&self, part: usize, other: usize, setup: usize) -> bool {
        let margin = self.margin(part, other);
        self.between(part, other, setup, margin).mm < margin
    }

    fn between(&self, part: usize, other: usize, setup: usize, enough: f64) -> Clearance {
        let lift = self.lift(part, other);
        self.head.clearance(&self.motions[setup], &self.solids[part], &self.solids[other], lift, enough)
    }

    /// The least room between the head and what it passes in `sequence`.
    fn clearance(&self, candidates: &[Vec<Candidate>], sequence: &Sequence) -> f64 {
        let mut least = CLEARANCE_SOUGHT_MM;
        let mut printed: Vec<usize> = Vec::new();
        for slot in sequence {
            for &(part, k) in slot {
                let setup = candidates[part][k].setup;
                for &other in printed.iter().filter(|&&q| !self.near[part].has(q)) {
                    least = self.between(part, other, setup, least).mm.min(least);
                }
                if !self.workpiece.model.on_table.contains(&part) {
                    let motion = &self.motions[setup];
                    least = self.head.clearance(motion, &self.solids[part], &self.table, 0.0, least).mm.min(least);
                }
            }
            printed.extend(slot.iter().map(|&(part, _)| part));
        }
        least
    }

    /// Why the parts that no branch could print cannot be.
    fn no_sequence(&self, candidates: &[Vec<Candidate>], blocked: &[Vec<PartSet>], farthest: &PartSet) -> Infeasible {
        let stuck: Vec<usize> = (0..candidates.len()).filter(|&p| !farthest.has(p)).collect();
        let mut reasons = Vec::new();
        for &part in &stuck {
            for (k, candidate) in candidates[part].iter().enumerate() {
                let up = (*candidate.up.unit()).into();
                if !candidate.needs.met_by(farthest) {
                    let missing = candidate.needs.missing(farthest);
                    let text = format!("{missing:.1} mm2 would overhang without what is printed later");
                    reasons.push(Reason { part, up, blocked_by: "support".to_owned(), depth_mm: 0.0, text });
                }
                for other in blocked[part][k].iter().filter(|&q| farthest.has(q)) {
                    let (solids, lift) = (&self.solids, self.lift(part, other));
                    let motion = &self.motions[candidate.setup];
                    let depth = self.head.depth(motion, &solids[part], &solids[other], lift);
                    let piece = self.between(part, other, candidate.setup, self.margin(part, other)).piece;
                    let text = format!("the {piece} would reach {depth:.1} mm into part {other}");
                    reasons.push(Reason { part, up, blocked_by: other.to_string(), depth_mm: depth, text });
                }
            }
        }
        let names: Vec<String> = stuck.iter().map(ToString::to_string).collect();
        let summary = format!(
            "no order prints parts {}: {}",
            names.join(", "),
            reasons.first().map_or("they wait for each other".to_owned(), |r| format!("part {}: {}", r.part, r.text))
        );
        Infeasible::NoPlan { summary, reasons }
    }
}

/// For each part: those within `reach` mm of it.
fn near(solids: &[Solid], reach: f64) -> Vec<PartSet> {
    let still = Rigid::<Table, Table>::shift(Vec3::zeros());
    let point = [Vec3::zeros()];
    let of_part = |part: usize| {
        let others = (0..solids.len()).filter(|&q| {
            q != part && solids[part].swept_clearance(&still, [true; 3], &point, &solids[q], reach).distance() < reach
        });
        set_of(solids.len(), others)
    };
    (0..solids.len()).into_par_iter().map(of_part).collect()
}

/// Fewest parts between each part and the table.
fn depths(touching: &[PartSet], on_table: &[usize]) -> Vec<f64> {
    let mut depth = vec![f64::INFINITY; touching.len()];
    let mut queue: VecDeque<usize> = on_table.iter().copied().collect();
    on_table.iter().for_each(|&p| depth[p] = 0.0);
    while let Some(part) = queue.pop_front() {
        for next in touching[part].iter() {
            if depth[next].is_infinite() {
                depth[next] = depth[part] + 1.0;
                queue.push_back(next);
            }
        }
    }
    depth
}

fn no_orientation(workpiece: &Workpiece<'_>, part: usize, choice: &Choice) -> Infeasible {
    let reason = |r: &Rejected| Reason {
        part,
        up: r.up.into(),
        blocked_by: r.blocked_by.clone(),
        depth_mm: r.depth_mm,
        text: r.reason.clone(),
    };
    let mut reasons: Vec<Reason> = choice.rejected.iter().map(reason).collect();
    // The nearest misses first: what the machine refuses although the part would stand.
    reasons.sort_by_key(|r| r.blocked_by == "support");
    let first = reasons.first().map_or("no direction to try".to_owned(), |r| r.text.clone());
    let name = &workpiece.model.parts[part].name;
    let summary = format!("part {part} ({name}) cannot be printed in any of {} orientations: {first}", choice.tried);
    Infeasible::NoPlan { summary, reasons }
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
