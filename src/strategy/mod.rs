//! Ways to print a model, and the cheapest of them: as it was drawn, turned, on supports, or its solids cut by planes.
//!
//! ```text
//! models  --arrange, loose, turning-->  SetUp      how they stand on the table
//! SetUp   --plan-->                     PlanResult or NoPlan
//!         --supported, holding, below-> HeldModel  on supports
//!         --cutting, solids, split-->   CutModel   in parts
//! all of them --costs, price, tries-->  the one that costs the least; Refused: why the others do not work
//! ```
//!
//! A hook that has no plan as it was drawn, and one on supports:
//!
//! ```
//! use trunnion::strategy::{PlanRequest, StrategyError, Supporting, Way, plan};
//! use trunnion::world::{Silent, World};
//!
//! let world = World::here(&Silent);
//! let mut request = PlanRequest::new("fixtures/hook.stl", "generic-ac");
//!
//! // The hook overhangs, so that there is no plan for it as it was drawn.
//! assert!(matches!(plan(&request, &world), Err(StrategyError::NoPlan(_))));
//! // On supports there is one.
//! request.supporting = Supporting::Auto;
//! let done = plan(&request, &world)?;
//! assert!(done.ways.first().is_some_and(|way| way.chosen && way.way == Way::Supports));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! The model itself is never changed: what is turned, joined or cut is a model of its own. Lengths mm, angles degrees, minutes. This room
//! must not know flags, documents, or what a slicer makes of a plan.

pub(crate) mod adhesion;
mod allowed;
mod arrange;
mod below;
mod costs;
mod cutting;
mod error;
mod form;
pub(crate) mod grid;
pub(crate) mod holding;
mod loose;
mod no_plan;
mod plan;
mod plates;
mod price;
mod refused;
mod remedies;
mod solids;
mod split;
mod supported;
mod tries;
mod turning;
mod uncut;
mod ways;

pub use allowed::WaysOut;
pub use arrange::{ArrangedModel, Arrangement, PoseChoice};
pub(crate) use arrange::{Models, ReadModels, SetUp, arranged, arranged_aloud, head_reach_mm};
pub use cutting::{CutModel, Cutting};
pub use error::StrategyError;
pub use form::SupportForm;
pub use no_plan::{Hindrance, NoPlan};
pub use plan::{
    Finish, Listed, PlaceRequest, PlanOptions, PlanRequest, PlanResult, Supporting, ThreeAxes, allowed, ordered,
    sequences,
};
pub use plates::{PlateModel, PlateQueue};
pub use price::{Terms, WISH, Way, Weights};
pub use refused::Refused;
pub use solids::CutSolid;
pub use split::{GivenCut, SplitOptions, SplitRequest, SplitResult, split};
pub use supported::{HeldModel, HeldPart, Holdings};
pub use tries::plan;
pub(crate) use tries::{PlannedSomehow, planned_somehow};
pub use uncut::Uncut;
pub use ways::{NoWay, TriedWay};
