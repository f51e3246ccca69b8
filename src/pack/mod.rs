//! Packing: boxes and models into as few runs as there must be, the most value into one, or all into one as low as can be (Leitereg (2020), chapter 2).
//!
//! ```text
//! Instance{space, gap, turns, items} --pack--> Answer{placed, runs, bound, ended}      boxes, whole units
//! Solid.., Room       --pack_models--> Packed{put, runs, bound, ended}                  models, mm
//! ```
//!
//! Five boxes in the fewest runs:
//!
//! ```
//! use trunnion::pack::{Ended, Instance, Item, Method, PackGoal, Turns, Watch, check, pack};
//!
//! // Five cubes of 50 mm, and runs that have room for four of them side by side; whole units, here mm.
//! let cube = Item { size: [50, 50, 50], value: 1.0, up: [true; 3] };
//! let boxes = Instance { space: [110, 110, 60], gap: 10, turns: Turns::None, items: vec![cube; 5] };
//!
//! // A million steps at most; nothing ends the search before.
//! let mut go_on = |_share: f64| None;
//! let packing = pack(&boxes, PackGoal::Runs, Method::Auto, 1, &mut Watch::new(1_000_000, &mut go_on))?;
//! assert_eq!(packing.runs, 2);
//! // No packing has fewer: four to a run, and there are five.
//! assert_eq!((packing.bound, packing.ended), (2.0, Ended::Proved));
//! check(&boxes, &packing.placed, true)?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Every answer says what no packing can beat, and why the search ended; [`check`] (boxes) and
//! [`apart`] (models) tell from the definitions alone whether a packing is one. The same seed and number of steps give the same packing on every machine; a clock only ends a search early.

mod anneal;
mod apart;
mod askew;
mod blocks;
mod bound;
mod check;
mod composite;
mod covering;
mod empty;
mod fewest;
mod fill;
mod filling;
mod grid;
mod height;
mod instance;
#[cfg(feature = "integer-program")]
mod ip;
mod lift;
mod loading;
mod method;
mod models;
mod nest;
mod obb;
mod reach;
mod scales;
mod solid;
mod spaces;
mod table;
mod tabu;
mod voxels;
mod watch;

pub use apart::{Clash, ROUNDING_MM, apart};
pub use askew::Askew;
pub use bound::most_value;
pub use check::{PackFault, check};
pub use fewest::{RunsProof, fewest_runs, least_height, runs_proof};
pub use instance::{
    BoxPacking, Ended, Instance, Item, LONGEST, Neighbourhood, PackGoal, Placed, Triple, Turns, height, volume,
};
pub use lift::{Lift, lift};
pub use method::{MOST_BOXES, Method, Unpackable, pack};
pub use models::{Packed, not_low, pack_models, packing_bound};
pub use solid::{PackSolid, Put, Room, axis_and_angle};
pub use table::{Spot, on_table};
pub use watch::{Asked, Shown, Watch};
