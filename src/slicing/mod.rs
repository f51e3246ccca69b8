//! From one part's mesh to sliced G-code: the built-in slicer, and adapters to the user's own.
//!
//! A part is handed over in its [`Slot`](crate::geom::Slot) frame: +Z is the build direction, its lowest point at
//! z = 0, centred in XY on the slicer's bed. What comes back is ordinary 3-axis G-code in those coordinates.
//!
//! This room must not know machines, poses or plans; only `process.rs` may start programs.

mod settings;

pub use settings::SliceSettings;
