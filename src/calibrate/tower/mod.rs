//! A calibration tower: a model printed in four poses, whose widths and heights, taken with callipers, tell where the axes are.
//!
//! ```text
//! Profile + TowerDesign --Tower::of--> Tower{blocks, dimensions}   a base, four posts on it, two blocks on its slopes
//! Tower --form--> TOML --Readings::parse--> Readings               what a person measured
//! Tower + Readings --fit_tower--> TowerFit                         pivot, offset, zero of tilt, each with its 95 % bound
//! ```
//!
//! Two posts stand on the base as it was printed, two were printed after half a turn: where the rotation axis is elsewhere than the profile
//! says, the later two are displaced by twice that. The blocks on the two slopes were printed on the tilted table, half a turn apart: they
//! are displaced by what the pivot is off, turned by the tilt. Widths come in pairs in which a displacement counts once up and once
//! down, so that a line that is wider than it should be, which widens all, is found beside them and cancels.
//!
//! A printed point is where the real machine has what the profile's machine put there: `q = F_real^-1(F_profile(q_drawn))`, with the
//! chain of [`super::Chain`] and its exact slopes. Jaws touch the outermost corners.
//!
//! What no print tells of itself stays as it is: the height of the level table (whatever the first layer needs), the zero of the
//! rotation, and the axes' directions, which are taken from the profile.
//!
//! Frame: table coordinates; `along` is the tilt axis, `across` the direction in which the first tilted print leans. Lengths mm.

mod design;
mod error;
mod fit;
mod form;
mod gauge;

pub use design::{Block, BlockCorner, Dimension, DimensionKind, Tower, TowerDesign};
pub use error::TowerError;
pub use fit::{TowerDeviation, TowerFit, fit_tower, tower_errors};
pub use form::{CalliperReading, Readings, TOWER_REPEATS_MM};
pub use gauge::measured;
