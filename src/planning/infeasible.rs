//! Why there is no plan.

use crate::assembly::MOST_SNAP_MM;
use crate::motion::Pose;
use crate::spelling::part_named;

/// What a part would lay on nothing at an orientation.
#[derive(Clone, Debug, PartialEq)]
pub struct Hanging {
    /// All of it, mm².
    pub area_mm2: f64,
    /// The middle of the largest patch, the model file's frame, mm.
    pub at_mm: [f64; 3],
    /// Why that hangs, in words.
    pub cause: String,
}

/// Why one part at one orientation cannot be printed.
#[derive(Clone, Debug, PartialEq)]
pub struct Reason {
    /// The part.
    pub part: usize,
    /// The build direction, table frame.
    pub up: [f64; 3],
    /// A part's number, `"table"`, `"limits"` (an axis or its reach), `"frame"` or `"support"`.
    pub blocked_by: String,
    /// How deep the head would reach in, mm.
    pub depth_mm: f64,
    /// In words.
    pub text: String,
    /// What would be laid on nothing, where that was looked for layer by layer.
    pub hangs: Option<Hanging>,
    /// The pose it is about.
    pub pose: Pose,
    /// Where the tip is when the head strikes, table frame; for the picture. `None` where nothing strikes, or where no
    /// place was met among those that were looked at.
    pub tip: Option<[f64; 3]>,
}

/// A part, and how far away it is.
#[derive(Clone, Debug, PartialEq)]
pub struct Near {
    /// Its number.
    pub part: usize,
    /// Its name.
    pub name: String,
    /// The least distance between the two surfaces, mm.
    pub mm: f64,
}

impl Near {
    fn told(&self) -> String {
        format!("; the nearest is {}, {:.2} mm away", part_named(self.part, &self.name), self.mm)
    }

    fn remedy(&self) -> &'static str {
        if self.mm >= MOST_SNAP_MM {
            return "";
        }
        ", or raise --snap above that, which fuses them; for a joint that must move, turn the model so that both parts stand on the table (--up)"
    }
}

/// No sequence was found.
#[derive(Clone, Debug, PartialEq, thiserror::Error, strum::IntoStaticStr)]
#[strum(serialize_all = "kebab-case", prefix = "plan/")]
pub enum Infeasible {
    /// More parts than the search's limit.
    #[error(
        "{parts} parts are too many; at most {} can be planned; join parts that can be printed as one, or print them on several plates (prepare --plates DIR)",
        MOST_PARTS
    )]
    TooManyParts {
        /// How many.
        parts: usize,
    },
    /// Parts that touch nothing.
    #[error(
        "{who} touches neither the table nor another part that does{}; move it, or join the parts{}",
        nearest.as_ref().map_or_else(String::new, Near::told), nearest.as_ref().map_or("", Near::remedy), who = part_named(*part, name)
    )]
    Floating {
        /// The first of them.
        part: usize,
        /// Its name.
        name: String,
        /// What is nearest to it; `None` for the only part.
        nearest: Option<Near>,
    },
    /// No position on the table keeps every part within the axes.
    #[error("{summary}")]
    NoPlace {
        /// One sentence.
        summary: String,
    },
    /// A part has no orientation, or no order works.
    #[error("{summary}")]
    NoPlan {
        /// One sentence.
        summary: String,
        /// A set of reasons none of which can be left out: without any one of them there would be a plan.
        reasons: Vec<Reason>,
        /// Whether that was proved; otherwise the set may hold more than it need.
        least: bool,
    },
    /// A plan whose print would not stay standing.
    #[error(
        "{who} would come off the table in slot {slot} (tilt {tilt_deg:.0} deg): adhesion safety factor {factor:.2} (minimum 1); enlarge the \
         footprint, print it upright, or raise [process] adhesion_mpa if the plate holds better",
        who = part_named(*part, name)
    )]
    Falls {
        /// The part printed then.
        part: usize,
        /// Its name.
        name: String,
        /// The slot.
        slot: usize,
        /// How far the table is tilted, degrees.
        tilt_deg: f64,
        /// How many times over it is held.
        factor: f64,
    },
    /// The search's budget ran out.
    #[error("no sequence found within {steps} steps; raise --budget, or give fewer parts")]
    Budget {
        /// Steps taken.
        steps: u64,
    },
}

/// More parts than this are refused at once.
pub const MOST_PARTS: usize = 400;
