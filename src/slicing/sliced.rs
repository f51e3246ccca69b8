//! What comes back from a slicer: G-code, and what of the part is not in it.
//!
//! Coordinates are those of the mesh that was sliced, mm.

use std::fmt;

/// A sliced part.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sliced {
    /// The G-code.
    pub gcode: Vec<u8>,
    /// What the slicer could not do as asked; other slicers than the built-in one say nothing.
    pub flaws: Vec<Flaw>,
}

impl From<Vec<u8>> for Sliced {
    fn from(gcode: Vec<u8>) -> Self {
        Self { gcode, flaws: Vec::new() }
    }
}

/// Something that was not printed as the mesh has it.
#[derive(Clone, Debug, PartialEq)]
pub enum Flaw {
    /// The mesh is not closed.
    Open {
        /// Contours that were closed by straight lines.
        contours: usize,
        /// The longest of these lines, mm.
        longest_mm: f64,
    },
    /// Pieces were too narrow to print.
    LeftOut(LeftOut),
    /// The built-in slicer did it: the other one prints nothing that begins in a point or an edge.
    Instead {
        /// The slicer that was asked.
        slicer: String,
    },
    /// Keys of a configuration that ask for something the slicer does not do.
    Unheeded(Vec<String>),
    /// Settings of a configuration, with their values, in whose place others count here.
    Replaced(Vec<String>),
}

/// What was too narrow to print.
#[derive(Clone, Debug, PartialEq)]
pub struct LeftOut {
    /// Its volume, mm³.
    pub volume_mm3: f64,
    /// Of the part's volume, 0 to 1.
    pub share: f64,
    /// On how many layers something is missing.
    pub layers: usize,
    /// The largest piece: its middle, at its layer's top.
    pub at_mm: [f64; 3],
    /// Everything thinner was left out, mm.
    pub thinnest_mm: f64,
}

/// A smaller share of a part is the very tips of its corners and edges: data, and no warning.
const WORTH_A_WARNING: f64 = 0.002;

impl Flaw {
    /// Whether a person is to be told.
    pub fn is_worth_a_warning(&self) -> bool {
        !matches!(self, Self::LeftOut(left) if left.share < WORTH_A_WARNING)
    }
}

impl fmt::Display for Flaw {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Open { contours, longest_mm } => write!(
                f,
                "the mesh is open: {contours} contours were closed by straight lines of up to {longest_mm:.3} mm; repair the model"
            ),
            Self::LeftOut(left) => write!(f, "{left} and were left out; {KEEPS}"),
            Self::Instead { slicer } => write!(
                f,
                "begins in a point or an edge, of which {slicer} prints no first layer; sliced by the built-in slicer instead"
            ),
            Self::Unheeded(keys) => write!(
                f,
                "it has nothing for {} of the keys in --slicer-config, which count for nothing: {}",
                keys.len(),
                keys.join(", ")
            ),
            Self::Replaced(settings) => write!(
                f,
                "not as in --slicer-config: {}; each print is sliced without them, since it stands on others or on a table that turns \
                 (supports: --supports auto; a skirt or brim: slice the print that stands on the table in the slicer's own window)",
                settings.join(", ")
            ),
        }
    }
}

/// What helps against things that are too narrow.
pub(super) const KEEPS: &str = "a thinner nozzle or a larger scale would print them, another slicer may";

impl fmt::Display for LeftOut {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { volume_mm3, share, layers, at_mm: [x, y, z], thinnest_mm } = self;
        write!(
            f,
            "{volume_mm3:.3} mm3 ({:.2} % of the part) on {layers} layers, most of it about X {x:.1} Y {y:.1} Z {z:.2}, are narrower \
             than {thinnest_mm:.3} mm",
            share * 100.0
        )
    }
}
