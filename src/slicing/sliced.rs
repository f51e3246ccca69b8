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
    /// Brim or skirt are less than was asked for.
    Lessened(Lessened),
    /// Keys of a configuration that ask for something the slicer does not do.
    Unheeded(Vec<String>),
    /// Settings of a configuration, with their values, in whose place others count here.
    Replaced(Vec<String>),
}

/// Why a brim or a skirt is less than was asked for.
#[derive(Clone, Debug, PartialEq)]
pub enum Lessened {
    /// The brim is narrower.
    Brim {
        /// Than this, mm.
        wanted_mm: f64,
        /// As wide as this, mm.
        brim_mm: f64,
        /// The part that stands there; `None` where the rim is near.
        beside: Option<usize>,
    },
    /// There is no skirt.
    Skirt {
        /// How far it would reach, mm.
        wanted_mm: f64,
        /// How far it may, mm.
        room_mm: f64,
        /// The part that stands there; `None` where the rim is near.
        beside: Option<usize>,
    },
    /// The print stands on supports, whose feet are there.
    ForSupports,
    /// The slicer does not say which of its lines they are.
    Unmarked {
        /// That slicer.
        slicer: String,
    },
}

impl fmt::Display for Lessened {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ends = |beside: Option<usize>| match beside {
            Some(part) => {
                format!(
                    "towards part {part} (half the gap, less the nozzle's radius); use a larger --gap between models"
                )
            }
            None => "towards the table's edge; move the model (--origin)".to_owned(),
        };
        match self {
            Self::Brim { wanted_mm, brim_mm, beside } => {
                write!(
                    f,
                    "the brim is {brim_mm:.2} mm wide instead of {wanted_mm} mm (process.brim_mm): no more fits {}",
                    ends(*beside)
                )
            }
            Self::Skirt { wanted_mm, room_mm, beside } => write!(
                f,
                "no skirt (process.skirt_loops): it needs {wanted_mm:.1} mm, but only {room_mm:.1} mm are free {}",
                ends(*beside)
            ),
            Self::Unmarked { slicer } => write!(
                f,
                "no brim and no skirt (process.brim_mm): {slicer} does not mark their lines, which would count as lines outside the part; use \
                 --slicer builtin or prusa-slicer"
            ),
            Self::ForSupports => {
                write!(f, "no brim and no skirt (process.brim_mm): the supports stand there")
            }
        }
    }
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
                "begins in a point or an edge, of which {slicer} prints no first layer; using the built-in slicer instead"
            ),
            Self::Lessened(lessened) => write!(f, "{lessened}"),
            Self::Unheeded(keys) => write!(
                f,
                "{} of the keys in --slicer-config are unknown to it and ignored: {}",
                keys.len(),
                keys.join(", ")
            ),
            Self::Replaced(settings) => write!(
                f,
                "ignored settings of --slicer-config: {}; prints on other prints or on a turning table need level layers of one height \
                 (for supports use --supports auto; for a skirt or brim, process.skirt_loops and process.brim_mm of the profile)",
                settings.join(", ")
            ),
        }
    }
}

/// What helps against things that are too narrow.
pub(super) const KEEPS: &str = "use a thinner nozzle, a larger scale or another slicer";

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
