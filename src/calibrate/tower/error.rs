//! Why a tower cannot be made or read.

use crate::location::Location;

/// Why a tower cannot be made, or its measurements not used.
#[derive(Clone, Debug, PartialEq, thiserror::Error, strum::IntoStaticStr)]
#[strum(serialize_all = "kebab-case", prefix = "tower/")]
pub enum TowerError {
    /// Axes that were measured and are not square: no tower is level at two rotations half a turn apart.
    #[error("profile {profile} has axes that are not square, and the tower needs square ones; use touches (--poses)")]
    NotSquare {
        /// The profile.
        profile: String,
    },
    /// An axis that does not go far enough.
    #[error("{letter} goes from {low} to {high} deg, and the tower needs {need}; use touches (--poses)")]
    Range {
        /// The axis.
        letter: char,
        /// Its lowest word, degrees.
        low: f64,
        /// Its highest.
        high: f64,
        /// What is needed.
        need: String,
    },
    /// A table that is too small.
    #[error("the tower needs a disc of {need:.0} mm, and the table of {profile} is smaller; use touches (--poses)")]
    NoRoom {
        /// The profile.
        profile: String,
        /// The tower's diameter on the table, mm.
        need: f64,
    },
    /// No size and tilt of it can be printed with proof; why the first was not.
    #[error("no tower passes verification on {profile}: {why}; use touches (--poses)")]
    NotProved {
        /// The profile.
        profile: String,
        /// What was said of the steepest one.
        why: String,
    },
    /// Not TOML, or an unknown key or type.
    #[error("{file}{}: {message}", line.map_or_else(String::new, |line| format!(":{line}")))]
    Syntax {
        /// The file.
        file: String,
        /// Its line, where that is known.
        line: Option<usize>,
        /// The parser's words.
        message: String,
    },
    /// A value that cannot be.
    #[error("{file}:{line}: {why}")]
    Value {
        /// The file.
        file: String,
        /// The line.
        line: usize,
        /// Value, unit, range and remedy.
        why: String,
    },
    /// Dimensions without a reading.
    #[error("{file}: not measured: {}; measure all, or set left_out = true where a piece is broken", list(numbers))]
    Missing {
        /// The file.
        file: String,
        /// Their numbers.
        numbers: Vec<usize>,
    },
    /// A tower that was printed with other values than the profile has.
    #[error(
        "{file}: the tower was printed with {key} {printed}, and {profile} has {now}; pass the profile that it was printed with"
    )]
    OtherMachine {
        /// The file.
        file: String,
        /// The profile.
        profile: String,
        /// The key.
        key: String,
        /// As printed.
        printed: String,
        /// In the profile.
        now: String,
    },
    /// A reading that no tower has.
    #[error(
        "{file}:{line}: dimension {number} is {mm:.2} mm, and was drawn as {drawn:.2} mm (at most {most} mm apart); {remedy}"
    )]
    FarOff {
        /// The file.
        file: String,
        /// The line.
        line: usize,
        /// The dimension.
        number: usize,
        /// As typed.
        mm: f64,
        /// As drawn.
        drawn: f64,
        /// How far it may be off, mm.
        most: f64,
        /// What to do.
        remedy: String,
    },
    /// Measurements that disagree with each other.
    #[error(
        "{file}: the measurements disagree by {rms_mm:.2} mm, and each should be right to {repeats_mm} mm; {remedy}"
    )]
    Contradiction {
        /// The file.
        file: String,
        /// As found.
        rms_mm: f64,
        /// As declared.
        repeats_mm: f64,
        /// What to do.
        remedy: String,
    },
    /// Heights of a table that was tilted so far that nothing holds on it.
    #[error(
        "{file}: the heights say that the zero of the tilt is off by {deg:.1} deg (at most {most} deg is likely); measure 6, 7 and 8 again, or \
         level the table and print another tower"
    )]
    Unlevel {
        /// The file.
        file: String,
        /// As found.
        deg: f64,
        /// What a tower is printed at.
        most: f64,
    },
    /// Measurements that determine nothing.
    #[error("{file}: without dimensions {} no figure is determined; measure more of them", list(left_out))]
    Untold {
        /// The file.
        file: String,
        /// What was left out.
        left_out: Vec<usize>,
    },
}

fn list(numbers: &[usize]) -> String {
    let all: Vec<String> = numbers.iter().map(usize::to_string).collect();
    all.join(", ")
}

impl TowerError {
    /// Where in what the user gave it is.
    pub fn location(&self) -> Option<Location> {
        match self {
            Self::Syntax { file, line: Some(line), .. }
            | Self::Value { file, line, .. }
            | Self::FarOff { file, line, .. } => Some(Location::file(file).line(*line as u64)),
            Self::Syntax { file, .. }
            | Self::Missing { file, .. }
            | Self::OtherMachine { file, .. }
            | Self::Contradiction { file, .. }
            | Self::Unlevel { file, .. }
            | Self::Untold { file, .. } => Some(Location::file(file)),
            Self::NotSquare { .. } | Self::Range { .. } | Self::NoRoom { .. } | Self::NotProved { .. } => None,
        }
    }
}
