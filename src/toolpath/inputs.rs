//! What is rewritten: the inputs of a job, the prints and layers that they are, and why there may be no file.

use super::export::{BoxMismatch, SlotMesh};
use super::joint::Joint;
use super::sliced::{Layer, SlicedPrint};
use super::source::SlicedError;
use crate::location::Location;
use crate::motion::OutOfLimits;
use crate::planning::{Plan, Print, Workpiece};
use crate::profile::Profile;

/// One print's sliced file.
pub struct Input<'a> {
    /// The print's number, in the order of [`Plan::prints`]; of supports, as [`Plan::supports`] numbers them.
    pub print: usize,
    /// Where on the slicer's bed the print's box is centred.
    pub centre_mm: [f64; 2],
    /// The file, for messages.
    pub file: &'a str,
    /// What was read from it.
    pub sliced: &'a SlicedPrint<'a>,
}

/// What the rewriter works for.
pub struct RewriteJob<'a> {
    /// The plan.
    pub plan: &'a Plan,
    /// The hash of its text.
    pub plan_sha256: &'a str,
    /// The machine.
    pub profile: &'a Profile,
    /// The model on its table.
    pub workpiece: &'a Workpiece<'a>,
    /// Comments for the head of the file: whole lines, or nothing.
    pub head: &'a str,
}

/// What was written for the machine.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Rewritten {
    /// How many bytes it is.
    pub bytes: u64,
    /// What the user should know.
    pub warnings: Vec<String>,
}

/// Why there is no file for the machine.
#[derive(Debug, thiserror::Error, strum::IntoStaticStr)]
#[strum(serialize_all = "kebab-case", prefix = "rewrite/")]
pub enum RewriteError {
    /// The output cannot be written.
    #[error("the rewritten file cannot be written: {0}")]
    Write(#[source] std::io::Error),
    /// A line that had been read as one that can be rewritten.
    #[error(transparent)]
    Sliced(#[from] SlicedError),
    /// A print without a file.
    #[error(
        "no sliced file for print {print} (slot {slot}, part {part}); give one for each print of the plan, named print-{print:02}.."
    )]
    Missing {
        /// The print.
        print: usize,
        /// Its slot.
        slot: usize,
        /// Its part.
        part: usize,
    },
    /// Two files for one print, or one too many.
    #[error("{file}: print {print} {problem}")]
    Unexpected {
        /// The file.
        file: String,
        /// The print.
        print: usize,
        /// What is wrong with it.
        problem: &'static str,
    },
    /// Not what was handed over.
    #[error("{file}: print {print} (part {part}): {source}")]
    Box {
        /// The file.
        file: String,
        /// The print.
        print: usize,
        /// The part.
        part: usize,
        /// The numbers.
        source: BoxMismatch,
    },
    /// A skirt or brim with nothing below it.
    #[error(
        "{file}:{line}: the slicer prints a skirt or brim for print {print} (part {part}), which is not printed first on the table; switch \
         it off and slice again"
    )]
    Adhesion {
        /// The file.
        file: String,
        /// Its line.
        line: u32,
        /// The print.
        print: usize,
        /// The part.
        part: usize,
    },
    /// Sliced for another nozzle or another filament.
    #[error(
        "{file}: sliced for {what} of {sliced_mm} mm, but process.{key} of the profile is {profile_mm}; slice for what is in the machine, or set \
         process.{key} = {sliced_mm} in the profile and plan again"
    )]
    OtherMachine {
        /// The file.
        file: String,
        /// `a nozzle` or `filament`.
        what: &'static str,
        /// The profile's key.
        key: &'static str,
        /// As sliced, mm.
        sliced_mm: f64,
        /// As the profile has it, mm.
        profile_mm: f64,
    },
    /// An overlap that leaves the nozzle too little room.
    #[error(
        "{file}: [joint] overlap_mm = {overlap_mm} is too large for print {print} (part {part}) with a first layer of {room_mm:.3} mm; use at most \
         {:.3} mm, or a layer height that divides the height of the part below",
        (room_mm / 2.0).max(0.0)
    )]
    Pressed {
        /// The file.
        file: String,
        /// The print.
        print: usize,
        /// The part.
        part: usize,
        /// As the profile has it, mm.
        overlap_mm: f64,
        /// From what carries the part to the first layer's tip, mm.
        room_mm: f64,
    },
    /// An axis that would have to go beyond its stops on the way between prints, or at one of them.
    #[error(
        "the way to a print or from it has no room: {0}; move the model (--origin), or raise the stop in [limits] if the machine has more travel"
    )]
    Beyond(OutOfLimits),
    /// Layers that go down again cannot be interleaved with another print's.
    #[error(
        "{file}:{line}: layer at z {z:.3} mm comes after a higher one; this print shares its setup with others, so its layers must go up"
    )]
    LayersDescend {
        /// The file.
        file: String,
        /// Its line.
        line: u32,
        /// The layer's height, slot frame.
        z: f64,
    },
}

impl RewriteError {
    /// Where in what the user gave it is.
    pub fn location(&self) -> Option<Location> {
        match self {
            Self::Write(_) | Self::Beyond(_) => None,
            Self::Sliced(error) => Some(error.location()),
            Self::Missing { part, .. } => Some(Location::default().part(*part)),
            Self::Box { file, part, .. } | Self::Pressed { file, part, .. } => Some(Location::file(file).part(*part)),
            Self::Adhesion { file, line, part, .. } => Some(Location::file(file).line(*line).part(*part)),
            Self::LayersDescend { file, line, .. } => Some(Location::file(file).line(*line)),
            Self::Unexpected { file, .. } | Self::OtherMachine { file, .. } => Some(Location::file(file)),
        }
    }
}

/// A print of the plan with its sliced file.
pub(super) struct Entry<'a> {
    pub(super) input: &'a Input<'a>,
    pub(super) print: &'a Print,
    pub(super) slot: usize,
    pub(super) mesh: SlotMesh,
    pub(super) joint: Joint,
    /// Whether these are the print's supports.
    pub(super) holds: bool,
}

/// A layer of an entry.
pub(super) struct Chunk<'a> {
    pub(super) entry: &'a Entry<'a>,
    /// The entry's place in its setup.
    pub(super) position: usize,
    pub(super) layer: &'a Layer,
    pub(super) index: usize,
    /// Its height in the machine, mm.
    pub(super) z: f64,
}
