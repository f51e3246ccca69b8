//! Machines: a profile made by answers or from a firmware's files, checked, measured and rehearsed.

mod calibrate;
mod check;
mod dry_run;
mod error;
mod import;
mod jog;
mod means;
mod new;
mod read;
mod tower;

pub use calibrate::{CalibrateRequest, CalibrateResult, PosesRequest, PosesResult, Written, calibrate, poses};
pub use check::{CheckedProfile, Tilted, check_profile, own_machines};
pub use dry_run::{DryRun, dry_run};
pub use error::MachineError;
pub use import::{ImportProfile, ImportedProfile, REQUIRED_KEYS, import_profile};
pub use jog::{JogChange, JogRequest, JogResult, jog};
pub use new::{Answers, MadeProfile, NewProfile, QUESTIONS, keep_profile, new_profile};
pub use read::{MachineAt, read_machine};
pub use tower::{Calibrated, TowerReading, TowerRequest, TowerResult, calibrate_by, keep_form, read_tower, tower};
