//! From parts to a sequence of time slots: collision, support, search, the plan file.
//!
//! ```text
//! Model + Profile -> candidates per part -> blocked / support tables -> Algorithms 2 and 3 -> Plan
//! ```
//!
//! A plan with the fewest slots for a model of two parts:
//!
//! ```
//! use trunnion::mesh::{ReadOptions, read_model};
//! use trunnion::orient::{Multistart, ObjectiveSettings, Staircase};
//! use trunnion::planning::{Goal, Options, Workpiece, centred, orientations, plan};
//! use trunnion::profile::resolve;
//!
//! let (profile, _) = resolve("mine.toml", "extends = \"generic-ac\"")?;
//! let model = read_model(&std::fs::read("fixtures/two-boxes.stl")?, "two-boxes.stl", &ReadOptions::default())?;
//! let workpiece = Workpiece::place(&model, &centred(&model, &profile)?);
//!
//! let goal = Goal::parse("slots", &ObjectiveSettings::default())?;
//! let (objective, search) = (Staircase { layer_mm: 0.2 }, Multistart::default());
//! let options = Options::new(&goal, &objective, &search);
//! let plans = plan(&workpiece, &profile, &orientations(&workpiece, &options), &options)?;
//! // The box that stands on the table comes first. The other lies against its side at +X, and is printed with the table tilted to 90 degrees.
//! let parts = plans[0].slots.iter().map(|slot| (slot.prints[0].part, slot.prints[0].tilt_deg));
//! assert_eq!(parts.collect::<Vec<_>>(), [(0, 0.0), (1, 90.0)]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Everything here works in the table's frame, and in the machine's at a pose. Source: Ramos et al. (2021), sections 5 and 6.
//! This room must not know slicers or toolpaths.

pub mod balance;
mod best;
mod candidates;
mod changes;
mod clears;
mod collision;
mod fans;
mod goal;
mod heads;
mod infeasible;
mod joint;
mod kept;
mod one_print;
mod options;
mod owed;
mod part_set;
mod placement;
mod plan;
mod planner;
mod pricing;
mod remedies;
mod sequence;
mod site;
mod solid;
mod standing;
mod support;
mod swivel;
mod three_axis;
mod turning;
mod whynot;
mod workpiece;

pub use crate::overhang::FREE_SPAN_MM;
pub use candidates::{Candidate, table_solid};
pub use changes::HOP_MM;
pub use clears::{Obstacle, turn_struck};
pub use collision::{Head, HeadSeen};
pub use goal::{Goal, PLAN_TERMS};
pub use infeasible::{Hanging, Infeasible, MOST_PARTS, Reason};
pub use joint::{Printed, joint_gap_mm};
pub use kept::orientations_kept;
pub use one_print::OnePrint;
pub use options::{Options, Priority};
pub use owed::{CELL_MM, LIFT_LAYERS, PIECE_MM, carries_tip, contact_mm};
pub use part_set::PartSet;
pub use placement::{centred, centred_and_turned, plan_anywhere};
pub use plan::{
    MachineRef, ModelRef, PartRef, Placement, Plan, PlanError, Print, PrintSupports, PropPlace, SupportRoof, TimeSlot,
    sha256_hex,
};
pub use planner::{Planned, orientations, plan, plannable, sequences, widening};
pub use pricing::WithinSlot;
pub use remedies::{Remedy, Wish, can_be_helped, support_by_hand};
pub use sequence::Sequence;
pub use site::CLEARANCE_SOUGHT_MM;
pub use solid::Solid;
pub use standing::{PartDroop, droops, layers_matter};
pub use support::Known;
pub use swivel::SwivelRoute;
pub use three_axis::{ThreeAxis, three_axis, whole};
pub use workpiece::{Misplaced, Workpiece};
