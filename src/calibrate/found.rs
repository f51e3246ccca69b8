//! What a fit comes to: numbers with their errors, what is left of each touch, and why it must not be written.

use super::chain::{Chain, Unknown};
use super::touches::Of;
use crate::motion::TableKinematics;

/// How to fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FitOptions {
    /// Take the axes as the profile has them, square where it says nothing: they are not looked for.
    pub square: bool,
    /// From where on axes that are elsewhere are written, and a surface that is not level is refused: what a point is off by, mm.
    pub tolerance_mm: f64,
}

impl Default for FitOptions {
    fn default() -> Self {
        Self { square: false, tolerance_mm: 0.1 }
    }
}

/// One unknown.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    /// Which.
    pub unknown: Unknown,
    /// As people call it.
    pub name: String,
    /// By how much the machine differs from its profile, mm or degrees.
    pub differs: f64,
    /// Half of the interval that holds it in 95 of 100 cases.
    pub error: f64,
}

/// What is left of a touch, mm: the length of three numbers for a mark.
#[derive(Clone, Debug, PartialEq)]
pub struct Deviation {
    /// The touch's place in its file, from 1.
    pub number: usize,
    /// Its line there.
    pub line: usize,
    /// What was touched.
    pub of: Of,
    /// The words.
    pub words_deg: [f64; 2],
    /// By how much it is off, with a sign where it is one number: above 0 the tip stood too high.
    pub off_mm: f64,
}

/// A touch that was not made like the others.
#[derive(Clone, Debug, PartialEq)]
pub struct Outlier {
    /// The touch's place in its file, from 1.
    pub number: usize,
    /// Its line there.
    pub line: usize,
    /// By how much it is off from what all others say, mm.
    pub off_mm: f64,
}

/// How far the machine is from one whose axes are where its profile has them.
#[derive(Clone, Debug, PartialEq)]
pub struct Bend {
    /// The most that a point on or over the table is elsewhere than the best machine with those axes says, mm.
    pub mm: f64,
    /// How far the surface's rim is from level where both angles are zero, mm.
    pub surface_mm: f64,
}

/// How far the table is from plane, as a bowl.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sag {
    /// How much lower the rim is than the middle, mm; below 0 it is higher.
    pub mm: f64,
    /// Half of the interval that holds it in 95 of 100 cases, mm.
    pub error_mm: f64,
}

/// Why the result must not be written into a profile.
#[derive(Clone, Debug, PartialEq)]
pub enum Refusal {
    /// Touches that disagree with all others.
    Outliers,
    /// All disagree.
    Scattered {
        /// As found, mm.
        rms_mm: f64,
        /// As the file says, mm.
        noise_mm: f64,
    },
    /// A surface that is not level where both angles are zero.
    Sloped {
        /// As found, mm.
        mm: f64,
        /// What is allowed, mm.
        allowed_mm: f64,
    },
    /// A surface whose rim is lower or higher than its middle.
    Sagging {
        /// As found, mm; below 0 it is higher.
        mm: f64,
        /// What is allowed, mm.
        allowed_mm: f64,
    },
}

/// The result.
#[derive(Clone, Debug)]
pub struct ChainFit {
    /// The machine with all that was looked for.
    pub chain: Chain,
    /// What is written: the best machine whose axes are where the profile has them, or the one with axes as measured.
    pub table: TableKinematics,
    /// Whether it has axes as measured, since without them it is off by more than is allowed.
    pub misaligned: bool,
    /// What was looked for: first pivot, offset and zeros as they are written, then the axes' directions and the surface.
    pub estimates: Vec<Estimate>,
    /// What is left of each touch that counted.
    pub deviations: Vec<Deviation>,
    /// Touches that did not count, the worst first.
    pub outliers: Vec<Outlier>,
    /// Marks and balls: name and place, table frame, mm.
    pub places: Vec<(String, [f64; 3])>,
    /// The scatter of one number, mm.
    pub rms_mm: f64,
    /// Numbers more than unknowns.
    pub freedom: usize,
    /// How far the axes are from where the profile has them; `None` where that was not looked for.
    pub bend: Option<Bend>,
    /// How far the table is from plane; `None` where the touches do not tell.
    pub sag: Option<Sag>,
    /// Why it must not be written; empty where it may.
    pub refusals: Vec<Refusal>,
}
