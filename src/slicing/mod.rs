//! From one part's mesh to sliced G-code: the built-in slicer, and adapters to the user's own.
//!
//! A part is handed over in its [`Slot`] frame: +Z is the build direction, its lowest point at
//! z = 0, centred in XY on the slicer's bed. What comes back is ordinary 3-axis G-code in those coordinates.
//!
//! This room must not know machines, poses or plans; only `process.rs` may start programs.

pub mod builtin;
mod config;
mod cura;
mod error;
mod external;
mod interrupt;
mod job;
mod level;
mod process;
mod prusa;
mod said;
mod sliced;
mod window;
// The settings belong to the profile, a floor below.
mod slic3r;
#[cfg(test)]
mod testing;

use crate::geom::Slot;
use crate::mesh::TriangleMesh;

pub use crate::gcode::settings::config_values;
pub use crate::profile::{InfillPattern, Seam, SliceSettings};
pub use builtin::BuiltIn;
pub use error::SliceError;
pub use interrupt::Interrupt;
pub use job::{Adhesion, SliceJob, SlicerChoice};
pub use level::below_middles;
pub use process::{ExternalOptions, KEY_VARIABLE, find};
pub use sliced::{Flaw, LeftOut, Lessened, Sliced};
pub use window::{WindowBed, project_settings};

/// A program or library that turns one slot's mesh into 3-axis G-code.
pub trait Slicer: Send + Sync {
    /// The slicer's name, as a user would say it.
    fn name(&self) -> &str;

    /// The version it reports, for instance `2.5.0`.
    fn version(&self) -> &str;

    /// What it cannot do as it was configured, whatever it slices: told once.
    fn flaws(&self) -> Vec<Flaw> {
        Vec::new()
    }

    /// The settings with what its own configuration says of brim and skirt, which whoever asks for a slice finds room for.
    ///
    /// # Errors
    ///
    /// A value in that configuration that is no number.
    fn around(&self, settings: &SliceSettings) -> Result<SliceSettings, SliceError> {
        Ok(settings.clone())
    }

    /// G-code of `mesh`, in the mesh's own XY and with z = 0 at its lowest point, no start or end code; and what is not in it.
    ///
    /// # Errors
    ///
    /// Refuses a mesh or settings that cannot be printed as given, and reports a slicer that fails, hangs or leaves
    /// the part out: see [`SliceError`].
    fn slice(&self, mesh: &TriangleMesh<Slot>, settings: &SliceSettings, job: &SliceJob) -> Result<Sliced, SliceError>;
}
