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
use super::source::SlicedSource;
use super::turn::Turn;
use crate::gcode::marks::Bead;
use crate::gcode::meaning::Firmware;
use crate::gcode::settings::{Setting, Settings};
use crate::geom::Bounds;

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
    /// Heights of its first layer and of all others, mm, that the settings state; `None` where the layers state their own, or nothing
    /// does.
    pub heights_mm: Option<[f64; 2]>,
    /// What the file says it was sliced with.
    pub settings: Settings,
    /// Whether its lines name objects to the firmware (M486, EXCLUDE_OBJECT); they are left out.
    pub labelled: bool,
    /// Whether pictures for a film are asked for, which are left out.
    pub pictures: bool,
    /// The first line of a skirt or brim, where the slicer names one.
    pub adhesion: Option<u32>,
    /// Nozzle temperature set before the first extrusion.
    pub nozzle_c: Option<f64>,
    /// Bed temperature set before the first extrusion.
    pub bed_c: Option<f64>,
    /// Comments before the first extrusion.
    pub prologue: Vec<Range<usize>>,
    /// Comments after the last extrusion.
    pub epilogue: Vec<Range<usize>>,
    /// What its lines are turned by, where they are not taken as they stand.
    pub(super) turn: Option<Turn>,
    pub(super) source: SlicedSource<'a>,
    /// Kept lines of the first layer's lead.
    pub(super) lead: Vec<Range<usize>>,
    /// Where the first layer's body begins.
    pub(super) start: Place,
    /// Where moves of bodies and of all leads but the first go; of its Z nothing is said.
    pub(super) reach: Bounds,
    /// Filament that the first layer lays, mm, by the width that is stated of its lines, mm.
    pub(super) first_layer: Vec<(Option<f64>, f64)>,
    /// The same of the second layer's lines that fill its height.
    pub(super) second_layer: Vec<(Option<f64>, f64)>,
}

impl<'a> SlicedPrint<'a> {
    /// The bytes at `span`, one of its own.
    pub(super) fn text(&self, span: &Range<usize>) -> &'a [u8] {
        self.source.bytes.get(span.clone()).unwrap_or_default()
    }

    /// The diameter of the filament that its E counts with, mm, where it says so.
    pub fn filament_diameter_mm(&self) -> Option<f64> {
        self.settings.positive(Setting::Filament)
    }

    /// Goes through its lines from the first layer's body on.
    pub(super) fn walk(&self) -> Walk<'a> {
        Walk::new(self.source, self.start.clone(), self.turn)
    }
}

/// A print with the name the slicer gave it.
#[derive(Clone, Debug)]
pub struct LabelledPrint<'a> {
    /// The object label, where the slicer wrote one of ours (`print-03..`).
    pub print: Option<usize>,
    /// The print.
    pub sliced: SlicedPrint<'a>,
}

/// How sliced files are read for a machine.
#[derive(Clone, Copy, Debug, Default)]
pub struct InputWords<'a> {
    /// Whose words a file is taken to be in where it does not say so itself (`gcode_flavor`, `;FLAVOR:`).
    pub firmware: Firmware,
    /// Commands that the profile lets pass although nobody knows or follows what they do (`[dialect] allow`).
    pub allow: &'a [String],
    /// Whether these are supports that a plan wants; else a file with supports is refused.
    pub supports: bool,
}
