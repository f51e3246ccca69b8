//! What jobs begin with: models, profiles and plans, from files or from bytes in hand, read and held against each other.
//!
//! A machine by its name, and a model from bytes:
//!
//! ```
//! use trunnion::input::{InputError, ModelSource, Source, load_model, load_profile};
//! use trunnion::world::{Silent, World};
//!
//! let world = World::here(&Silent);
//! let machine = load_profile(&"generic-ac".into(), &world)?;
//! assert_eq!(machine.profile.machine.name, "generic-ac");
//!
//! // A model from bytes in hand; its name is for messages. A file would be `load_model(&"fixtures/cube.stl".into(), ..)`.
//! let source = Source::Bytes { name: "cube.stl".to_owned(), bytes: std::fs::read("fixtures/cube.stl")? };
//! let loaded = load_model(&ModelSource::from(source), &world)?;
//! assert_eq!(loaded.model.parts.len(), 1);
//!
//! // A file that is not found is refused with the name that may be meant.
//! let refused = load_model(&"fixtures/cubes.stl".into(), &world);
//! assert!(matches!(refused, Err(InputError::Absent { near: Some(near), .. }) if near == "fixtures/cube.stl"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! It must not know what is made of them: ways, slices, programs.

mod error;
mod load;
pub(crate) mod memory;
mod process;
mod setting;
mod source;

pub use error::{BadExtends, InputError};
pub use load::{
    CheckedPlan, LoadedModel, LoadedProfile, PlanSource, load_model, load_plan, load_profile, load_table, own_profiles,
};
pub(crate) use load::{load_aloud, load_unposed, read_quietly, spanning, tell};
pub(crate) use process::{process, process_of};
pub use setting::BadSetting;
pub(crate) use source::missing;
pub use source::{MachineSource, ModelSource, Source};
