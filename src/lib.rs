//! From a model of several closed parts to one verified G-code file for a 3D printer whose table tilts and turns.
//!
//! The main job, as the command's `trunnion prepare` does it:
//!
//! ```
//! use std::path::Path;
//! use trunnion::job::{self, Outputs, PrepareRequest, PrintError, Silent, World};
//! use trunnion::slicing::SlicerChoice;
//! use trunnion::strategy::StrategyError;
//!
//! let model = Path::new("fixtures/two-boxes.stl");
//! let folder = tempfile::tempdir()?;
//! // Whether the result can be written is known before the work.
//! let output = Outputs::new([model]).claim(&folder.path().join("two-boxes.gcode"))?;
//!
//! // A shipped profile, or the path of your own; the slicer is the best that is installed, unless one is named.
//! let mut request = PrepareRequest::new(model, "generic-ac");
//! request.plan.overhang_deg = Some(40.0);
//! request.slicing.slicer = SlicerChoice::BuiltIn;
//!
//! match job::prepare(&request, &World::here(&Silent)) {
//!     Ok(done) => {
//!         for (slot, print) in done.planned.plan.prints() {
//!             println!("slot {slot}: part {} at A{} C{}", print.part, print.tilt_deg, print.rotation_deg);
//!         }
//!         if let Some(report) = done.gcode.report() {
//!             println!("proved: {} moves, {:.1} mm of room", report.moves, report.clearance_mm);
//!         }
//!         output.write(done.gcode.program())?;
//!     }
//!     Err(PrintError::Strategy(StrategyError::NoPlan(no))) => no.remedies.iter().flatten().for_each(|remedy| println!("{}", remedy.text)),
//!     Err(error) => return Err(error.into()),
//! }
//! assert!(output.path().is_file());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! [`job`] has each step by itself as well, from files or from bytes in hand. Below it lie the rooms that do the work; each begins with an
//! example of its own.
//!
//! Scripts may rely on the JSON documents, on exit codes and message codes, and on the formats of files. Rust items may change with any
//! version until 1.0.
//!
#![doc = include_str!("ARCHITECTURE.md")]

pub mod assembly;
pub mod calibrate;
#[doc(hidden)]
pub mod cli;
pub mod document;
#[doc(hidden)]
pub mod fixtures;
pub mod gcode;
pub mod geom;
pub mod input;
pub mod job;
pub mod link;
pub mod location;
pub mod mesh;
pub mod motion;
pub mod orient;
pub mod overhang;
pub mod pack;
pub(crate) mod pictures;
pub mod planning;
pub mod profile;
pub mod publish;
pub mod section;
pub mod slicing;
pub mod spelling;
pub mod split;
pub mod strategy;
pub mod support;
pub mod toolpath;
pub mod trace;
pub mod verify;
pub mod view;
#[doc(hidden)]
pub mod workbench;
pub mod world;
