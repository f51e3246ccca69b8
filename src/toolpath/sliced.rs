//! A sliced file as prints and layers: what is known of each beside its bytes.
//!
//! A layer begins right behind the last extrusion of the one before: its *lead* (retraction, travel, marks) comes before
//! its first extrusion, its *body* from there on. A lead may be replaced by a travel of our own; a body never changes but
//! by translation. Of both only the places in the file are kept, so that a file takes little more than its own bytes;
//! `items.rs` goes through them again.
//!
//! Coordinates are those of the file: slot frame, mm.

use std::ops::Range;

use super::items::{Place, Walk};
use crate::gcode::ParseError;
use crate::gcode::marks::Bead;
use crate::gcode::meaning::Firmware;
use crate::geom::Bounds;
use crate::motion::replay::ReplayError;

/// A layer of one print.
#[derive(Clone, Debug)]
pub struct Layer {
    /// The height of its first extrusion, mm, slot frame.
    pub z: f64,
    /// Where in the file its body begins; its lead begins where the body before ends.
    pub(super) body: usize,
    /// Where its last extrusion's line ends.
    pub(super) end: usize,
    /// The line of its first extrusion.
    pub(super) line: u32,
    /// The ends of its extrusions.
    pub(super) extrusion: Bounds,
}

/// One print as sliced, with the bytes that it is read from.
#[derive(Clone, Debug)]
pub struct SlicedPrint<'a> {
    /// Its layers, lowest first; never none.
    pub layers: Vec<Layer>,
    /// The box of all extrusion, mm, slot frame.
    pub extrusion: Bounds,
    /// Filament laid down, mm.
    pub filament_mm: f64,
    /// Whose words its lines are.
    pub firmware: Firmware,
    /// Commands of its start and end code that were left out and might be missed, each once.
    pub replaced: Vec<String>,
    /// The slicer's own factor on all flow (its extrusion multiplier); 1 where the file does not say.
    pub multiplier: f64,
    /// The cross-section that its slicer fills.
    pub bead: Bead,
    /// By how much the slicer moves outer walls outward on purpose, mm; `None` where the file does not say.
    pub outset_mm: Option<f64>,
    /// Widths of its lines, mm, that the head states; empty where the lines state their own.
    pub widths_mm: Vec<f64>,
    /// Waits (G4) between its first and last extrusion, s. They are left out of what is written.
    pub waits_s: f64,
    /// Nozzle temperature set before the first extrusion.
    pub nozzle_c: Option<f64>,
    /// Bed temperature set before the first extrusion.
    pub bed_c: Option<f64>,
    /// Comments before the first extrusion.
    pub prologue: Vec<Range<usize>>,
    /// Comments after the last extrusion.
    pub epilogue: Vec<Range<usize>>,
    pub(super) source: SlicedSource<'a>,
    /// Kept lines of the first layer's lead.
    pub(super) lead: Vec<Range<usize>>,
    /// Where the first layer's body begins.
    pub(super) start: Place,
    /// Where moves of bodies and of all leads but the first go; of its Z nothing is said.
    pub(super) reach: Bounds,
    /// Filament that the first layer lays, mm.
    pub(super) first_layer_mm: f64,
}

impl<'a> SlicedPrint<'a> {
    /// The bytes at `span`, one of its own.
    pub(super) fn text(&self, span: &Range<usize>) -> &'a [u8] {
        self.source.bytes.get(span.clone()).unwrap_or_default()
    }

    /// Goes through its lines from the first layer's body on.
    pub(super) fn walk(&self) -> Walk<'a> {
        Walk::new(self.source, self.start.clone())
    }
}

/// A sliced file and what is needed to read its lines again.
#[derive(Clone, Copy)]
pub(super) struct SlicedSource<'a> {
    /// For the messages.
    pub(super) file: &'a str,
    pub(super) bytes: &'a [u8],
    pub(super) firmware: Firmware,
    pub(super) allow: &'a [String],
}

impl std::fmt::Debug for SlicedSource<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} ({} bytes)", self.file, self.bytes.len())
    }
}

/// A print with the name the slicer gave it.
#[derive(Clone, Debug)]
pub struct Segment<'a> {
    /// The object label, where the slicer wrote one of ours (`print-03..`).
    pub print: Option<usize>,
    /// The print.
    pub sliced: SlicedPrint<'a>,
}

/// Why a sliced file cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SlicedError {
    /// Binary G-code.
    #[error(
        "{file}: binary G-code; switch off \"Supports binary G-code\" (Printer Settings > General) or binary_gcode = 0, and slice again"
    )]
    Binary {
        /// The file.
        file: String,
    },
    /// A line that is not G-code.
    #[error("{file}:{line}: {source}")]
    Parse {
        /// The file.
        file: String,
        /// Counted from 1.
        line: u32,
        /// What is wrong.
        source: ParseError,
    },
    /// A line without a safe meaning.
    #[error("{file}:{line}: {source}")]
    Replay {
        /// The file.
        file: String,
        /// Counted from 1.
        line: u32,
        /// What is wrong.
        source: ReplayError,
    },
    /// A command whose effect at a tilt nobody knows.
    #[error("{file}:{line}: {text:?} cannot be rewritten safely; remove it from the slicer's custom G-code")]
    Command {
        /// The file.
        file: String,
        /// Counted from 1.
        line: u32,
        /// The line.
        text: String,
    },
    /// Extrusion from an unknown place.
    #[error("{file}:{line}: extrusion before X, Y and Z are known")]
    UnknownPosition {
        /// The file.
        file: String,
        /// Counted from 1.
        line: u32,
    },
    /// No extrusion at all.
    #[error(
        "{file}: nothing is extruded; the slicer dropped the part, or the file is not for a printer that extrudes with E"
    )]
    NoExtrusion {
        /// The file.
        file: String,
    },
    /// Objects printed all at once.
    #[error(
        "{file}:{line}: the printing of {label:?} is interrupted by other objects; switch on \"complete individual objects\" and slice again"
    )]
    Interleaved {
        /// The file.
        file: String,
        /// Counted from 1.
        line: u32,
        /// The label that came back.
        label: String,
    },
    /// Not what the slicer says it laid.
    #[error(
        "{file}: {counted_mm:.2} mm of filament are laid down, and the file says that {stated_mm:.2} mm are used; it was changed after \
         slicing, or is damaged; slice again"
    )]
    Filament {
        /// The file.
        file: String,
        /// What its moves add up to.
        counted_mm: f64,
        /// What its comment says.
        stated_mm: f64,
    },
    /// The end is missing.
    #[error(
        "{file}: the slicer's own closing comments are missing (\"filament used\"): the file was cut short; slice again"
    )]
    Torn {
        /// The file.
        file: String,
    },
    /// Our own output.
    #[error("{file}:{line}: already rewritten by trunnion; give the slicer's own file")]
    Rewritten {
        /// The file.
        file: String,
        /// Counted from 1.
        line: u32,
    },
}

/// How sliced files are read for a machine.
#[derive(Clone, Copy, Debug, Default)]
pub struct InputWords<'a> {
    /// Whose words a file is taken to be in where it does not say so itself (`gcode_flavor`, `;FLAVOR:`).
    pub firmware: Firmware,
    /// Commands that the profile lets pass although nobody knows or follows what they do (`[dialect] allow`).
    pub allow: &'a [String],
}
