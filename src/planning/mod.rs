//! From parts to a sequence of time slots: collision, support, search, the plan file.
//!
//! ```text
//! Model + Profile -> candidates per part -> blocked / support tables -> Algorithms 2 and 3 -> Plan
//! ```
//!
//! Everything here works in the table's frame, and in the machine's at a pose. Source: seed 004, sections 5 and 6.
//! This room must not know slicers or toolpaths.

mod best;
mod candidates;
mod collision;
mod goal;
mod part_set;
mod plan;
mod planner;
mod sequence;
mod sheet;
mod solid;
mod support;
mod workpiece;

pub use candidates::{Candidate, Rejected, table_solid};
pub use collision::{Head, LIFT_LAYERS, contact_mm};
pub use part_set::PartSet;
pub use plan::{MachineRef, ModelRef, PartRef, Placement, Plan, PlanError, Print, Slot, sha256_hex};
pub use planner::{
    CLEARANCE_SOUGHT_MM, Infeasible, MOST_PARTS, Options, Planned, Reason, orientations, plan, plannable,
};
pub use sequence::{Priority, Sequence};
pub use sheet::sheet;
pub use solid::Solid;
pub use workpiece::{Misplaced, Workpiece};
