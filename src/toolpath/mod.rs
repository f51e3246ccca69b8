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
