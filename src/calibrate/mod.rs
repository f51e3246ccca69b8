//! A machine's own numbers from touches: where its tilt axis lies, where the middle of its table, what its rotary axes count from, and
//! how far its axes are from square.
//!
//! ```text
//! Touches (TOML) --fit(Profile)--> Fit{estimates, deviations, bend} --keys--> pivot_mm, offset_mm, zero_deg
//! Profile        --choose--> poses to touch at, as few as the wanted errors allow --visit--> G-code that goes there, cold and slowly
//! ```
//!
//! A tilt axis that is higher than its profile says, found from touches:
//!
//! ```
//! use trunnion::calibrate::{ChainCandidate, Feature, FitOptions, Tip, Touch, TouchShape, Touches, choose, fit};
//! use trunnion::profile::resolve;
//!
//! let (profile, _) = resolve("mine.toml", "extends = \"generic-ac\"")?;
//! // The machine's real tilt axis is 0.3 mm higher than its profile says (machine frame).
//! let mut real = profile.clone();
//! real.kinematics.pivot_mm[2] += 0.3;
//!
//! // The places to touch, so that every length is known to 0.05 mm, and where the real machine touches there.
//! let (tip, shape) = (Tip::default(), TouchShape::Mark { height: 0.0, known: None });
//! let choice = choose(&real, &tip, 0.05, 40, true);
//! let features = choice.marks.iter().map(|(name, _)| Feature { name: name.clone(), shape }).collect();
//! let mut touches = Touches { tip, features, touches: Vec::new(), empty: Vec::new() };
//! for (i, &ChainCandidate { of, words_deg, tip: at }) in choice.poses.iter().enumerate() {
//!     touches.touches.push(Touch { number: i + 1, line: i + 1, of, words_deg, at });
//! }
//!
//! let found = fit(&profile, &touches, &FitOptions { square: true, ..FitOptions::default() });
//! let table = found.map_err(|why| format!("{why:?}"))?.table;
//! assert!((table.pivot.z - real.kinematics.pivot_mm[2]).abs() < 1e-3);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! With the same care a print is rehearsed on the machine itself before anything is hot ([`dry_run`]).
//!
//! The model is the chain of [`crate::motion`] with what it leaves out beside it: a tilt axis that is not along its machine axis, a rotation
//! axis that is not square to it, a surface that is not square to the rotation axis ([`Unknown`]). Those three are measured so that they
//! can be told; a profile cannot hold them, and where they matter nothing is written.
//! Least squares by K. Levenberg (Quarterly of Applied Mathematics 2, 1944) and D. W. Marquardt (SIAM Journal 11, 1963); standard errors,
//! leverages and deleted residuals as in D. A. Belsley, E. Kuh and R. E. Welsch, *Regression Diagnostics* (1980).
//!
//! Lengths mm; angles radians inside, degrees where a name says so; machine coordinates unless a name says table.

mod chain;
mod clear;
mod dry_run;
mod fit;
mod form;
mod found;
mod information;
mod jog;
mod outliers;
mod poses;
mod report;
mod solve;
mod touches;
mod tower;
mod uncalibrated;
mod visit;

pub use chain::{Chain, SAG_AT_MM, UNKNOWNS, Unknown};
pub use clear::ClearWay;
pub use dry_run::{ColdPose, dry_run, outermost};
pub use fit::{NoFit, Undetermined, fit};
pub use form::form;
pub use found::{Bend, ChainFit, Deviation, Estimate, FitOptions, Outlier, Refusal};
pub use jog::{JOG_DEG, JOG_MM, Jog, JogFault, JogQuestion, JogSubject, Jogged, Seen};
pub use poses::{Choice, choose};
pub use solve::residuals;
pub use touches::{ChainCandidate, Feature, Of, Tip, TipShape, Touch, TouchError, TouchShape, Touches};
pub use tower::{
    Block, BlockCorner, CalliperReading, Dimension, DimensionKind, Readings, TOWER_REPEATS_MM, Tower, TowerDesign,
    TowerDeviation, TowerError, TowerFit, fit_tower, measured, tower_errors,
};
pub use uncalibrated::Uncalibrated;
pub use visit::{NoVisit, Visit, visit};
