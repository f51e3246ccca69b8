//! Why pieces are not packed.

use super::MOST_PIECES;
use crate::input::InputError;
use crate::pack::{PackFault, Turns};

/// Why pieces are not packed.
#[derive(Debug, thiserror::Error)]
pub enum PackError {
    /// What is read for it.
    #[error(transparent)]
    Input(InputError),
    /// What cannot be packed.
    #[error(transparent)]
    Packing(#[from] BadPacking),
}

impl PackError {
    /// What stands for it in documents, for good.
    pub fn code(&self) -> &'static str {
        match self {
            Self::Input(error) => error.code(),
            Self::Packing(error) => error.into(),
        }
    }
}

impl<E: Into<InputError>> From<E> for PackError {
    fn from(error: E) -> Self {
        Self::Input(error.into())
    }
}

/// Why something cannot be packed.
#[derive(Clone, Debug, PartialEq, thiserror::Error, strum::IntoStaticStr)]
#[strum(serialize_all = "kebab-case", prefix = "pack/")]
pub enum BadPacking {
    /// A count of zero, or one that is too large.
    #[error("{name}: the count must be between 1 and {MOST_PIECES}, got {count}; MODEL*3 means three copies")]
    Count {
        /// The model or line.
        name: String,
        /// As given.
        count: f64,
    },
    /// Too many pieces together.
    #[error("{pieces} pieces are too many; at most {MOST_PIECES} are packed together")]
    TooMany {
        /// How many.
        pieces: usize,
    },
    /// A model or box that does not fit.
    #[error(
        "{name}: {} mm {} in the space of {} mm {}; enlarge the space{}, or cut it (trunnion split)",
        sizes(size), if *proved { "does not fit" } else { "was not found to fit" }, sizes(space), turned(*turn, *up),
        if *turn == Turns::Any && *up != [true; 3] { ", remove `up`" } else if *turn == Turns::Any { "" } else { ", allow any rotation (--turn any)" }
    )]
    NoFit {
        /// The model or line.
        name: String,
        /// Its size, mm.
        size: [f64; 3],
        /// The space, mm.
        space: [f64; 3],
        /// How it may be turned.
        turn: Turns,
        /// Which of its own axes may be upright where it may be turned in any way.
        up: [bool; 3],
        /// Whether that is sure: turned in every way, it may not be settled.
        proved: bool,
    },
    /// A goal without what it needs.
    #[error("goal {goal}: {why}")]
    Goal {
        /// The goal.
        goal: String,
        /// What it needs.
        why: &'static str,
    },
    /// No packing found within the limit of its height.
    #[error(
        "no packing of all pieces was found within {limit_mm} mm; none is lower than {bound_mm:.3} mm; {}, or give the search more time (--time)",
        if *is_given { "use --space X,Y without a limit" } else { "use a larger base (--space)" }
    )]
    TooHigh {
        /// The limit, mm.
        limit_mm: f64,
        /// Whether it was given; without, runs are at most 100 m high.
        is_given: bool,
        /// What no packing is lower than, mm.
        bound_mm: f64,
    },
    /// A line that is not a box.
    #[error(
        "{name}, line {line}: {text:?} must be width, depth and height (0.001 to 1000000 mm, three decimals at most), then count and value (above \
         0), then `up` for a box that stays upright, or `up:yz` for one whose y or z may be upright; for example 20 30 15.5 4 1.5 up"
    )]
    Line {
        /// The file.
        name: String,
        /// The line, from 1.
        line: usize,
        /// What it says.
        text: String,
    },
    /// A number with a comma in it, where others are parted by blanks.
    #[error("{name}, line {line}: {text:?} may be one number or two; write {} for one, or a space after the comma for two", text.replace(',', "."))]
    Comma {
        /// The file.
        name: String,
        /// The line, from 1.
        line: usize,
        /// The word.
        text: String,
    },
    /// A file without boxes.
    #[error("{0} has no boxes; write one box per line: width, depth and height in mm, for example 20 30 15")]
    NoBoxes(String),
    /// Values that do not go with the models.
    #[error(
        "fill {given}: must be `volume`, `file`, or {wanted} numbers above 0 with commas between them, one for each model or line"
    )]
    Values {
        /// As given.
        given: String,
        /// How many there should be.
        wanted: usize,
    },
    /// A method that does not apply.
    #[error("method {method}: {why}")]
    Method {
        /// The method.
        method: String,
        /// Why not.
        why: String,
    },
    /// Coarser meshes where there are none.
    #[error("inflate: {0}")]
    Inflate(String),
    /// Boxes for a machine's table.
    #[error("{0}: boxes cannot be packed on a machine's table; use --space X,Y,Z instead of -m")]
    BoxesOnTable(String),
    /// An invalid packing: a fault of this program, never a result.
    #[error("the packing found is not valid ({0}); nothing was written; please report this")]
    Unproved(String),
}

fn sizes(size: &[f64; 3]) -> String {
    // Of a base without a limit of its height there are two.
    let finite = size.iter().filter(|length| length.is_finite());
    finite.map(|length| format!("{}", (length * 1000.0).round() / 1000.0)).collect::<Vec<_>>().join(" x ")
}

fn turned(turn: Turns, up: [bool; 3]) -> &'static str {
    match turn {
        Turns::Any if up == [false, false, true] => "upright, at any quarter turn about Z",
        Turns::Any if up != [true; 3] => "on any of the sides that its `up` allows",
        Turns::None => "as it is",
        Turns::Z90 => "at any quarter turn about Z",
        Turns::Z => "at any angle about Z",
        Turns::Any => "in any orientation",
    }
}

impl From<PackFault> for BadPacking {
    fn from(fault: PackFault) -> Self {
        Self::Unproved(fault.to_string())
    }
}
