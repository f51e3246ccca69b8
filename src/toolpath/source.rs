//! A sliced file as it came, and why it cannot be used.

use crate::gcode::ParseError;
use crate::gcode::meaning::Firmware;
use crate::location::Location;
use crate::motion::replay::ReplayError;

/// A sliced file and what is needed to read its lines again.
#[derive(Clone, Copy)]
pub(super) struct SlicedSource<'a> {
    /// For the messages.
    pub(super) file: &'a str,
    pub(super) bytes: &'a [u8],
    pub(super) firmware: Firmware,
    pub(super) allow: &'a [String],
    /// Whether supports are wanted.
    pub(super) supports: bool,
}

impl std::fmt::Debug for SlicedSource<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} ({} bytes)", self.file, self.bytes.len())
    }
}

/// Why a sliced file cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error, strum::IntoStaticStr)]
#[strum(serialize_all = "kebab-case", prefix = "sliced/")]
pub enum SlicedError {
    /// Binary G-code.
    #[error(
        "{file}: binary G-code; switch off \"Supports binary G-code\" (Printer Settings > General) or set binary_gcode = 0, and slice again"
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
    /// A word that is there twice, as in a number with an exponent.
    #[error(
        "{file}:{line}: a move with two {letter} words, which firmwares read differently (E9e-05 is E9 and E-05); write numbers without exponents"
    )]
    Twice {
        /// The file.
        file: String,
        /// Counted from 1.
        line: u32,
        /// The letter.
        letter: char,
    },
    /// A command whose effect at a tilt is unknown.
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
    /// Supports, a raft or a wipe tower.
    #[error(
        "{file}:{line}: the slicer prints {what}, which the plan does not allow for; switch it off and slice again"
    )]
    Extra {
        /// The file.
        file: String,
        /// Counted from 1.
        line: u32,
        /// What it is.
        what: &'static str,
    },
    /// Lengths of E that are volumes.
    #[error(
        "{file}: sliced with volumetric E (its E counts mm3 and not mm of filament); switch that off in the slicer (PrusaSlicer: Printer \
         Settings > General > Use volumetric E; Cura: another G-code flavour) and slice again"
    )]
    Volumetric {
        /// The file.
        file: String,
    },
    /// One line that rises all the way.
    #[error(
        "{file}: sliced as a spiral (spiral vase), which has no layers to check or to start at another \
         pose; switch the spiral off and slice again"
    )]
    Spiral {
        /// The file.
        file: String,
    },
    /// A fuzzy skin, whose walls leave the outline.
    #[error(
        "{file}: sliced with a fuzzy skin: its outer walls leave the part's outline on purpose and cannot be checked; switch the fuzzy skin off \
         and slice again"
    )]
    Fuzzy {
        /// The file.
        file: String,
    },
    /// A file whose filament differs from the slicer's figure.
    #[error(
        "{file}: the moves extrude {counted_mm:.2} mm of filament, but the file's comment states {stated_mm:.2} mm; slice again"
    )]
    Filament {
        /// The file.
        file: String,
        /// What its moves add up to.
        counted_mm: f64,
        /// What its comment says.
        stated_mm: f64,
    },
    /// Not what the built-in slicer wrote.
    #[error(
        "{file} was changed after the built-in slicer wrote it (its crc32 does not match); slice again, or remove its last line if the change is \
         intended"
    )]
    Changed {
        /// The file.
        file: String,
    },
    /// The end is missing.
    #[error(
        "{file}: the slicer's own closing comments are missing (\"filament used\"), so the file was cut short; slice again"
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

impl SlicedError {
    /// Where in what the user gave it is.
    pub fn location(&self) -> Location {
        match self {
            Self::Parse { file, line, source } => {
                let location = Location::file(file).line(*line);
                source.column().map_or(location.clone(), |column| location.column(column))
            }
            Self::Replay { file, line, .. }
            | Self::Command { file, line, .. }
            | Self::Twice { file, line, .. }
            | Self::UnknownPosition { file, line }
            | Self::Interleaved { file, line, .. }
            | Self::Extra { file, line, .. }
            | Self::Rewritten { file, line } => Location::file(file).line(*line),
            Self::Binary { file }
            | Self::NoExtrusion { file }
            | Self::Volumetric { file }
            | Self::Spiral { file }
            | Self::Fuzzy { file }
            | Self::Filament { file, .. }
            | Self::Changed { file }
            | Self::Torn { file } => Location::file(file),
        }
    }
}
