//! Packing: boxes and models into as few runs as there must be, or the most value into one (seed 003, chapter 2).
//!
//! ```text
//! Instance{space, gap, turns, items} --pack--> Answer{placed, runs, bound, ended}      boxes, whole units
//! Solid.., Room       --pack_models--> Packed{put, runs, bound, ended}                  models, mm
//! ```
//!
//! Every answer says what no packing can beat, and why the search ended; [`check`] (boxes) and
//! [`apart`] (models) tell from the definitions alone whether a packing is one. The same seed and number of steps give the same packing on every machine; a clock only ends a search early.

mod anneal;
mod apart;
mod askew;
mod bound;
mod check;
mod composite;
mod covering;
mod empty;
mod fill;
mod filling;
mod grid;
mod instance;
#[cfg(feature = "integer-program")]
mod ip;
mod lift;
mod method;
mod models;
mod nest;
mod obb;
mod solid;
mod spaces;
mod table;
mod tabu;
mod voxels;
mod watch;

pub use apart::{Clash, ROUNDING_MM, apart};
pub use askew::Askew;
pub use bound::{fewest_runs, most_value};
pub use check::{PackFault, check};
pub use instance::{BoxPacking, Ended, Instance, Item, LONGEST, PackGoal, Placed, Triple, Turns, volume};
pub use lift::{Lift, lift};
pub use method::{MOST_BOXES, Method, Unpackable, pack};
pub use models::{Packed, pack_models};
pub use solid::{PackSolid, Put, Room, axis_and_angle};
pub use table::{Spot, on_table};
pub use watch::{Asked, Watch};
