//! Sliced G-code to the machine's: reading prints and layers, travels and pose changes, writing.
//!
//! One print (a part at a pose) comes as ordinary 3-axis G-code in its slot frame. Since its mesh was handed to the
//! slicer already turned upright, only a translation is left to do:
//!
//! ```text
//! slot    = R p_table + export           R = R_tilt(A) Rz(C)
//! machine = R p_table + at               at = pivot + R_tilt(A) offset
//!         = slot + (at - export)         rounded once to a micron, so that arcs keep their centres
//! ```
//!
//! One print, from its plan to the layers that the rewriter reads:
//!
//! ```
//! use trunnion::job::{PlanRequest, Silent, World, plan};
//! use trunnion::slicing::{Adhesion, BuiltIn, SliceJob, Slicer};
//! use trunnion::toolpath::{InputWords, read_sliced, slot_mesh};
//!
//! let plan = plan(&PlanRequest::new("fixtures/cube.stl", "generic-ac"), &World::here(&Silent))?.plan;
//! let (profile, print) = (&plan.machine.profile, &plan.plan.slots[0].prints[0]);
//!
//! // The part as a slicer gets it: upright, in the middle of a bed of 200 x 200 mm (slot frame).
//! let upright = slot_mesh(&plan.workpiece(), &profile.kinematics(), print, [100.0, 100.0]);
//! let (name, on_table) = ("print-00".to_owned(), upright.on_table);
//! let job = SliceJob { name, on_table, bed_mm: [200.0, 200.0], adhesion: Adhesion::default() };
//! let gcode = BuiltIn.slice(&upright.mesh, &profile.process, &job)?.gcode;
//!
//! // What the rewriter reads of its G-code: one print, whose layers are together as high as the part.
//! let prints = read_sliced(&gcode, "print-00.gcode", InputWords::default())?;
//! let layers = &prints[0].sliced.layers;
//! assert_eq!(prints.len(), 1);
//! assert!((layers.len() as f64 * profile.process.layer_height_mm - upright.mesh.bounds().max.z).abs() < 1e-6);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! The rewriter owns every move between prints, layers of different prints, and poses. What it does not understand it
//! refuses. This room must not know slicers; it reads what they write.

mod ahead;
mod clear;
mod export;
mod filament;
mod fits;
mod inputs;
mod items;
mod joint;
mod modal;
mod moved;
mod output;
mod policy;
mod project;
mod read;
mod rewrite;
mod sliced;
mod source;
mod stated;
mod turn;
mod writer;

pub use export::{BoxMismatch, SlotMesh, check_box, slot_mesh};
pub use inputs::{Input, RewriteError, RewriteJob, Rewritten};
pub use moved::{Moved, find_moved};
pub use project::{Bed, ProjectSpot, TooLarge, layout};
pub use read::read_sliced;
pub use rewrite::rewrite;
pub use sliced::{InputWords, LabelledPrint, Layer, SlicedPrint};
pub use source::SlicedError;
pub use stated::print_name;
