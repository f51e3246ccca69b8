//! The final file, replayed on the machine's model and held against the plan.
//!
//! ```text
//! bytes -> reading                              (what the machine's firmware takes each line for)
//!       --trace::read--> Trace -> program       (syntax, commands, limits, speeds, pose, order, heat, retraction, filament, the end)
//!                              -> stays         (what is printed at one pose after another, and what stands there before)
//!                              -> walk          (in air? head, turning, frame against what this very file lays down, stay by stay:
//!                                               `field` bounds from above, `near` the distance itself)
//!                              -> balance       (standing: its weight against what sticks to the table)
//!                              -> shape         (layer-height, complete; registration, coverage, outside-part; flow; fill: by layer, with the part's sections)
//! ```
//!
//! A program without findings, and the same program cut short:
//!
//! ```
//! use trunnion::job::{PrepareRequest, Silent, World, prepare};
//! use trunnion::slicing::SlicerChoice;
//! use trunnion::verify::{ReplayJob, Rule, verify};
//!
//! let mut request = PrepareRequest::new("fixtures/cube.stl", "generic-ac");
//! request.slicing.slicer = SlicerChoice::BuiltIn;
//! let done = prepare(&request, &World::here(&Silent))?;
//! let (checked, program) = (&done.planned.plan, done.gcode.program());
//!
//! let job = ReplayJob { profile: &checked.machine.profile, plan: &checked.plan, workpiece: &checked.workpiece() };
//! assert!(verify(program, &job).is_clean());
//!
//! // The same program without its last layers: the part is not whole.
//! let half = &program[..program.len() / 2];
//! let report = verify(half, &job);
//! assert!(report.counts.contains_key(&Rule::Complete));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! The file is judged by its last bytes alone: nothing is taken from the rewriter but the marks that name prints, and
//! material is what the replay lays down, not the meshes. Heights and distances are conservative bounds, so that "free"
//! is proved; where the bound does not suffice the answer is a finding.
//!
//! Not covered: strings, sagging and shrinkage; accelerations, but in the time that is stated; the head against the frame.
//!
//! This room must not know the rewriter or slicers: it shares `motion`'s replay and chain with them and nothing else.

mod acts;
mod adhesion;
mod astray;
mod balance;
mod bonds;
mod commands;
mod coverage;
mod depth;
mod doubled;
mod evidence;
mod field;
mod fill;
mod floor;
mod flow;
mod heaters;
mod holding;
mod homing;
mod hull;
mod joints;
mod layers;
mod ledges;
mod line;
mod material;
mod near;
mod prime;
mod prints;
mod program;
mod reading;
mod referee;
mod registration;
mod report;
mod rings;
mod rules;
mod settings;
mod shape;
mod stated;
mod support;
mod survey;
mod swivelling;
mod table;
mod tally;
#[cfg(test)]
mod tests;
mod thin;
mod turn_lines;
mod turning;
mod walk;
mod way;

pub use referee::{Refereed, Unjudged, referee};
pub use report::{
    CLEARANCE_CAP_MM, Finding, InterfaceFill, JointRoom, KEPT_PER_RULE, NearestApproach, Report, Rule, Standing,
    StatedSetting, TableUse, WALL_STARTS, WallStart,
};
pub use rules::{RULES, RuleLimit, RuleStatement};
pub use survey::{HeadRoom, SURVEYED_MM};

use crate::geom::Vec3;
use crate::motion::Pose;
use crate::planning::{Plan, Workpiece};
use crate::profile::Profile;
use crate::trace::{self, Trace};
use acts::Acts;
use evidence::{Check, Checked, Evidence};
use rayon::prelude::*;
use report::Findings;

/// A print of the plan, with its place in the order.
#[derive(Clone, Copy, Debug)]
struct Planned {
    slot: usize,
    part: usize,
    /// The setup, counted over all slots.
    setup: usize,
    pose: Pose,
    up: Vec3,
    /// Where these are a part's supports: the air that they leave below it, mm.
    gap_mm: Option<f64>,
}

/// What a file is held against.
#[derive(Clone, Copy)]
pub struct ReplayJob<'a> {
    /// The machine.
    pub profile: &'a Profile,
    /// The plan the file was made from.
    pub plan: &'a Plan,
    /// The model on its table.
    pub workpiece: &'a Workpiece<'a>,
}

/// Replays `bytes` and says what is wrong with them; an empty file misses every print.
///
/// The report does not depend on the number of threads.
pub fn verify(bytes: &[u8], job: &ReplayJob<'_>) -> Report {
    verify_trace(bytes, &trace::read(bytes, &job.profile.trace_setting()), job)
}

/// Does the same where `bytes` have been read already: `trace` must be theirs, by the profile's own
/// [`trace_setting`](Profile::trace_setting).
pub fn verify_trace(bytes: &[u8], trace: &Trace, job: &ReplayJob<'_>) -> Report {
    let planned = planned(job);
    let printed = prints::gather(trace, job, &planned);
    let acts = Acts::new(trace, job.profile, &printed);
    let evidence = Evidence { bytes, trace, job, planned: &planned, printed: &printed, acts: &acts };
    report_of(trace, by(&CHECKS, &evidence))
}

/// The outcomes of some checks, in their order.
fn by(checks: &[Check], evidence: &Evidence<'_>) -> Vec<Checked> {
    checks.par_iter().with_max_len(1).map(|check| check(evidence)).collect()
}

fn report_of(trace: &Trace, checked: Vec<Checked>) -> Report {
    let mut report = Report::of_moves(trace.len(), trace.seconds);
    let mut all = Findings::default();
    for one in checked {
        all.absorb(one.findings);
        one.figures.state_in(&mut report);
    }
    (report.findings, report.counts) = all.finish();
    report
}

/// All checks, beginning with those that take longest.
const CHECKS: [Check; 12] = [
    walk::check,
    shape::check,
    bonds::check,
    program::check,
    reading::check,
    holding::check,
    balance::check,
    table::check,
    adhesion::check,
    prime::check,
    joints::check,
    stated::check,
];

/// What room the head has to what it does not print on, move by move, for pictures: `trace` is the program's.
pub fn rooms(trace: &Trace, job: &ReplayJob<'_>) -> Vec<HeadRoom> {
    let planned = planned(job);
    let printed = prints::gather(trace, job, &planned);
    survey::survey(&Acts::new(trace, job.profile, &printed), job, &planned)
}

/// The plan's prints in the order of [`Plan::prints`], each with its setup's number; then those of supports.
fn planned(job: &ReplayJob<'_>) -> Vec<Planned> {
    let table = job.profile.kinematics();
    let mut before = 0;
    let mut all = Vec::new();
    for slot in &job.plan.slots {
        let setups = slot.setup_of_each();
        for (print, own) in slot.prints.iter().zip(&setups) {
            let (setup, up) = (before + own, Vec3::from(print.up));
            all.push(Planned { slot: slot.id, part: print.part, setup, pose: print.pose(&table), up, gap_mm: None });
        }
        before += setups.iter().max().map_or(0, |last| last + 1);
    }
    let supports = job.plan.prints().zip(all.clone()).filter_map(|((_, print), held)| {
        let supports = print.supports.as_ref()?;
        Some(Planned { gap_mm: Some(supports.gap_mm), ..held })
    });
    let supports: Vec<Planned> = supports.collect();
    all.extend(supports);
    all
}
