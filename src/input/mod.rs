//! What jobs begin with: models, profiles and plans, from files or from bytes in hand, read and held against each other.
//!
//! It must not know what is made of them: ways, slices, programs.

mod error;
mod load;
mod process;
mod setting;
mod source;

pub use error::InputError;
pub use load::{
    CheckedPlan, LoadedModel, LoadedProfile, PlanSource, load_model, load_plan, load_profile, own_profiles,
};
pub(crate) use load::{load_aloud, load_unposed, read_quietly, spanning, tell};
pub(crate) use process::{process, process_of};
pub use setting::BadSetting;
pub(crate) use source::missing;
pub use source::{MachineSource, ModelSource, Source};
