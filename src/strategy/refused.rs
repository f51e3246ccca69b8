//! Why a way to print a model does not work, with the facts as fields.

use std::error::Error;
use std::sync::Arc;

use super::price::WISH;
use super::uncut::Uncut;
use crate::geom::Vec3;
use crate::input::BadSetting;
use crate::overhang::Patch;
use crate::planning::Infeasible;
use crate::spelling::counted;

/// Why a way does not work.
#[derive(Clone, Debug, thiserror::Error)]
pub enum Refused {
    /// A way that was not requested.
    #[error("another way was requested (--way or --cut)")]
    Unasked,
    /// Planning says no.
    #[error("{0}")]
    NoPlan(Infeasible),
    /// Another failure of a way.
    #[error("{why}")]
    Failed {
        /// Its own code.
        code: &'static str,
        /// Why.
        why: Arc<dyn Error + Send + Sync>,
    },
    /// The same of several solids on one table.
    #[error("{0}; print fewer at once, or place them farther apart (--gap)")]
    Crowded(Arc<dyn Error + Send + Sync>),
    /// Parts that touch have no plan with supports below those on the table.
    #[error("with supports below the parts on the table: {0}; or join the parts (--join)")]
    Touching(Infeasible),
    /// Parts that touch have no plan together, and are no one solid that could be cut.
    #[error(
        "{first} to {last} ({parts} touching parts) have no common plan, and only single solids are cut; join them (--join)"
    )]
    Several {
        /// The first of them.
        first: String,
        /// The last.
        last: String,
        /// How many.
        parts: usize,
    },
    /// A part that is to be cut touches others.
    #[error("{part} touches other parts, and only single solids are cut; join them (--join)")]
    Touched {
        /// Which.
        part: String,
    },
    /// Each solid has a plan by itself.
    #[error("each has a plan by itself, but not beside the others; place them farther apart (--gap)")]
    Beside,
    /// The solids of a joint, which only have plans apart from each other.
    #[error("the parts of a joint are printed in place, not cut")]
    Jointed,
    /// No cut was made.
    #[error("nothing of it needs a cut")]
    Whole,
    /// Cutting leaves something.
    #[error("{0}")]
    Uncut(Uncut),
    /// A part of several.
    #[error("{part}: {why}")]
    Part {
        /// Which.
        part: String,
        /// Why.
        why: Box<Self>,
    },
    /// A model without another stable pose that has a plan.
    #[error("{}", no_pose(*.poses))]
    Turned {
        /// Poses that were tried.
        poses: usize,
    },
    /// A way that was skipped, since it cannot save enough.
    #[error("it would cost at least {least_min:.0} min; another pose or a cut must save {:.0} %", 100.0 * (1.0 - WISH))]
    Dearer {
        /// What it costs at least, minutes.
        least_min: f64,
    },
    /// Nothing hangs.
    #[error("nothing of {} needs supports", if *.on_table { "what stands on the table" } else { "it" })]
    NothingHangs {
        /// Whether only what stands on the table could have had supports.
        on_table: bool,
    },
    /// Supports are made in a plan of one slot.
    #[error("supports need a plan of one slot, and this one has {slots} (--slots together)")]
    Slots {
        /// How many it takes.
        slots: usize,
    },
    /// A roof whose lines would lie on each other.
    #[error(
        "--roof-pitch must be at least the line width ({width_mm} mm), got {pitch_mm} mm; the default is twice the line width"
    )]
    Roof {
        /// From line to line, mm.
        pitch_mm: f64,
        /// A line's width, mm.
        width_mm: f64,
    },
    /// A grid that cannot be.
    #[error("{0}")]
    Grid(Arc<BadSetting>),
    /// Overhangs that supports cannot reach.
    #[error(
        "even with supports {area_mm2:.1} mm2 would be printed in mid-air, {:.1} of it at Z {:.1} mm: {}{}",
        .worst.area_mm2, .worst.at.z, .worst.cause, no_way_down(*.bare_mm2)
    )]
    StillHangs {
        /// All of it, mm².
        area_mm2: f64,
        /// The largest patch.
        worst: Patch,
        /// What columns have no way to the table from, mm².
        bare_mm2: f64,
    },
    /// A part of a joint that hangs where no support could be removed.
    #[error(
        "even with supports {area_mm2:.1} mm2 of it would be printed in mid-air, at Z {:.1} mm: supports in the gap of a joint could not be removed; leave at most {gap_mm:.1} mm of air below it, or turn the joint (--up)",
        .at.z
    )]
    Captive {
        /// All that hangs, mm².
        area_mm2: f64,
        /// Where most of it is; z from the table, mm.
        at: Vec3,
        /// So much air may be below it, mm.
        gap_mm: f64,
    },
    /// Supports that the axes do not reach.
    #[error("its supports exceed the axis limits: {0}")]
    Axes(String),
    /// Supports beside the table.
    #[error("its supports would stand {mm:.1} mm beyond the table")]
    BeyondTable {
        /// How far.
        mm: f64,
    },
    /// Supports of two parts in one place.
    #[error("the supports of {part} and of {other} would meet")]
    Meet {
        /// One.
        part: String,
        /// The other.
        other: String,
    },
    /// Supports of a part that is printed behind others.
    #[error("{part}: supports need an empty table, and other parts are printed before it")]
    Late {
        /// Which.
        part: String,
    },
    /// Supports where another part is.
    #[error("the supports of {part} would overlap {other} or be less than a line's width from it")]
    Within {
        /// Whose.
        part: String,
        /// Which is there.
        other: String,
    },
    /// Supports that a later print's head would meet.
    #[error("while {printed} is printed, the {piece} would hit the supports of {part}")]
    Head {
        /// What is printed then.
        printed: String,
        /// The piece of the head.
        piece: String,
        /// Whose supports.
        part: String,
    },
    /// Supports that a turn of the table would take into something.
    #[error("{0}")]
    Turn(String),
    /// A way whose G-code `verify` refuses.
    #[error("makes G-code that verify refuses ({0})")]
    Laid(String),
    /// A way whose G-code is unusable.
    #[error("makes unusable G-code ({0})")]
    Wrote(String),
    /// The slicer failed.
    #[error("failed ({0})")]
    Slicer(String),
}

fn no_pose(poses: usize) -> String {
    match poses {
        0 => "no other pose is stable".to_owned(),
        count => format!("no plan in {}", counted(count, "other pose")),
    }
}

fn no_way_down(bare_mm2: f64) -> String {
    if bare_mm2 > 0.0 { format!("; {bare_mm2:.0} mm2 have no straight path to the table") } else { String::new() }
}

impl Refused {
    /// Of one part, where there are several.
    pub(super) fn of_part(self, part: String) -> Self {
        Self::Part { part, why: Box::new(self) }
    }

    /// How much air there may be below a part of a joint, mm, where it has more.
    pub(super) fn joint_gap_mm(&self) -> Option<f64> {
        match self {
            Self::Captive { gap_mm, .. } => Some(*gap_mm),
            Self::Part { why, .. } => why.joint_gap_mm(),
            _ => None,
        }
    }

    /// What stands for it in documents, for good.
    pub fn code(&self) -> &'static str {
        match self {
            Self::Unasked => "way/not-asked-for",
            Self::NoPlan(_) | Self::Touching(_) => "way/no-plan",
            Self::Failed { code, .. } => code,
            Self::Crowded(_) | Self::Beside => "way/too-near",
            Self::Several { .. } | Self::Touched { .. } => "way/parts-touch",
            Self::Whole | Self::Jointed => "way/nothing-to-cut",
            Self::Uncut(why) => why.code(),
            Self::Part { why, .. } => why.code(),
            Self::Turned { .. } => "way/no-pose",
            Self::Dearer { .. } => "way/dearer",
            Self::NothingHangs { .. } => "way/nothing-hangs",
            Self::Slots { .. } => "way/several-slots",
            Self::Roof { .. } => "way/roof-pitch",
            Self::Grid(_) => "way/grid",
            Self::StillHangs { .. } => "way/still-hangs",
            Self::Captive { .. } => "way/captive",
            Self::Axes(_) | Self::BeyondTable { .. } => "way/supports-beyond-table",
            Self::Meet { .. } | Self::Within { .. } => "way/supports-meet-part",
            Self::Late { .. } => "way/supports-too-late",
            Self::Head { .. } | Self::Turn(_) => "way/supports-meet-head",
            Self::Laid(_) => "way/rejected",
            Self::Wrote(_) => "way/unusable",
            Self::Slicer(_) => "way/slicer",
        }
    }
}

impl From<BadSetting> for Refused {
    fn from(bad: BadSetting) -> Self {
        Self::Grid(Arc::new(bad))
    }
}
