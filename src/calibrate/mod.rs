//! A machine's own numbers from touches: where its tilt axis lies, where the middle of its table, what its rotary axes count from, and
//! how far its axes are from square.
//!
//! ```text
//! Touches (TOML) --fit(Profile)--> Fit{estimates, deviations, bend} --keys--> pivot_mm, offset_mm, zero_deg
//! Profile        --choose--> poses to touch at, as few as the wanted errors allow --visit--> G-code that goes there, cold and slowly
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
mod outliers;
mod poses;
mod report;
mod solve;
mod touches;
mod visit;

pub use chain::{Chain, SAG_AT_MM, UNKNOWNS, Unknown};
pub use clear::ClearWay;
pub use dry_run::{ColdPose, dry_run, outermost};
pub use fit::{NoFit, Undetermined, fit};
pub use form::form;
pub use found::{Bend, ChainFit, Deviation, Estimate, FitOptions, Outlier, Refusal};
pub use poses::{Choice, choose};
pub use solve::residuals;
pub use touches::{ChainCandidate, Feature, Of, Tip, TipShape, Touch, TouchError, TouchShape, Touches};
pub use visit::{NoVisit, Visit, visit};
