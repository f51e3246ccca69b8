//! The JSON documents that verbs print with `--json` and that scripts and other programs read: one function for each result.
//!
//! [`text`] has some of them for people.
//!
//! The document of a model:
//!
//! ```
//! use trunnion::{document, mesh};
//!
//! let file = std::fs::read("fixtures/two-boxes.stl")?;
//! let model = mesh::read_model(&file, "two-boxes.stl", &mesh::ReadOptions::default())?;
//!
//! // The document that `trunnion inspect --json` prints.
//! let document = document::inspected(&model);
//! assert_eq!(document["unit"], "mm");
//! assert_eq!(document["parts"].as_array().map(Vec::len), Some(2));
//! assert_eq!(document["parts"][0]["volume_mm3"], model.parts[0].mesh.volume());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Here is decided how a result is written, not what it is: results are `job`'s, and whoever prints or serves one (the
//! command, a binding) takes its document from here. Keys and their meanings are promised to outside scripts: a key may
//! be added, none changes its meaning. Units stand in the keys (`_mm`, `_mm2`, `_deg`, `_s`); vectors are lists of three.
//!
//! Plans, profiles and verify's reports serialise themselves where their formats are decided; they are embedded as they are.

mod batched;
mod calibrated;
mod certified;
mod explained;
mod failed;
mod jog_text;
mod machine_text;
mod model;
mod oriented;
mod packed;
mod plan_text;
mod planned;
mod prepare_text;
mod priced;
mod printing;
mod published;
mod row;
mod sent;
mod shape_text;
mod supported;
pub mod text;
mod tower_text;
mod verified_text;
mod viewed;
mod visible;

pub use batched::{batch, batched};
pub use calibrated::{calibrated, measured, poses, tower};
pub use certified::{certificate, is_certificate};
pub use explained::explained;
pub use failed::{exit_code, failed};
pub use model::{convex, inspected, split};
pub use oriented::{figures, orientations, oriented};
pub use packed::packed;
pub use planned::{no_plan, no_way, planned, sequences};
pub use priced::reasons;
pub use printing::{
    checked, cold, event, jogged, left_alone, opened, own, plate, plates, prepared, profile_imported, profile_made,
    refereed, rehearsed, rejected, rewritten, shipped, sliced, verified,
};
pub use published::published;
pub use row::{Lines, Row, fitting, too_low};
pub use sent::{Tone, ended, failures, paused, rehearsal, said, undone};
pub use supported::supported;
pub use viewed::{compared, drawn_machine, page, page_of_two, previewed};
pub use visible::visible;
