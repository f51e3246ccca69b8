//! From one part's mesh to sliced G-code: the built-in slicer, and adapters to the user's own.
//!
//! A part is handed over in its [`Slot`] frame: +Z is the build direction, its lowest point at
//! z = 0, centred in XY on the slicer's bed. What comes back is ordinary 3-axis G-code in those coordinates.
//!
//! A cube, sliced by the built-in slicer:
//!
//! ```
//! use trunnion::geom::{Bounds, Slot, Vec3};
//! use trunnion::mesh::TriangleMesh;
//! use trunnion::profile::resolve;
//! use trunnion::slicing::{Adhesion, BuiltIn, SliceJob, Slicer};
//!
//! // A cube of 10 mm in the middle of a bed of 100 x 100 mm, its lowest point at z = 0 (slot frame).
//! let (min, max) = (Vec3::new(45.0, 45.0, 0.0), Vec3::new(55.0, 55.0, 10.0));
//! let cube: TriangleMesh<Slot> = TriangleMesh::cuboid(&Bounds { min, max });
//! let settings = resolve("mine.toml", "extends = \"generic-ac\"\n[process]\nlayer_height_mm = 0.2\n")?.0.process;
//! let job =
//!     SliceJob { name: "cube".to_owned(), on_table: true, bed_mm: [100.0, 100.0], adhesion: Adhesion::default() };
//!
//! let sliced = BuiltIn.slice(&cube, &settings, &job)?;
//! let layers = String::from_utf8(sliced.gcode)?.lines().filter(|line| *line == ";LAYER_CHANGE").count();
//! assert_eq!(layers, 50);
//! assert!(sliced.flaws.is_empty());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! This room must not know machines, poses or plans; only `process` may start programs.

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
