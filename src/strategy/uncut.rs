//! Why cutting a solid does not help.

use std::fmt::{self, Display, Formatter};

use crate::spelling::counted;
use crate::split::{Against, PatchLeft, Unsupported};

/// Why cutting a solid does not help.
#[derive(Clone, Debug, PartialEq)]
pub enum Uncut {
    /// A cut that was asked for cannot be made.
    Pinned {
        /// Which of them, from 1.
        number: usize,
        /// What is against it.
        against: Against,
    },
    /// The search was ended.
    Stopped {
        /// Cuts that had been tried.
        tried: u64,
    },
    /// The machine has no plan for the parts.
    Unplanned {
        /// Cuts that were made.
        cuts: usize,
        /// Their parts.
        parts: usize,
    },
    /// Something still needs support.
    Left {
        /// Cuts that were made.
        cuts: usize,
        /// What needs support without them, mm².
        before_mm2: f64,
        /// And with them.
        after: Unsupported,
        /// The largest patch of it.
        worst: Option<PatchLeft>,
        /// What was against most of the cuts that were turned down, against how many, and of how many.
        against: Option<(Against, usize, usize)>,
    },
}

impl Uncut {
    /// What stands for it in documents, for good.
    pub fn code(&self) -> &'static str {
        match self {
            Self::Pinned { .. } => "split/refused-cut",
            Self::Stopped { .. } => "split/stopped",
            Self::Unplanned { .. } => "split/no-plan",
            Self::Left { .. } => "split/still-hangs",
        }
    }
}

impl Display for Uncut {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let after = |cuts: usize| match cuts {
            0 => "no cut helps".to_owned(),
            cuts => format!("after {}", counted(cuts, "cut")),
        };
        match self {
            Self::Pinned { number, against } => {
                write!(f, "cut {number} cannot be made: it {}; move or turn its plane", because(*against))
            }
            Self::Stopped { tried } => write!(
                f,
                "stopped after {} tried, before it could be printed in parts; let it continue, or raise --budget",
                counted(*tried as usize, "cut")
            ),
            Self::Unplanned { cuts, parts } => write!(
                f,
                "{}nothing needs support, but the machine has no plan for the {parts} parts; a taller pedestal (--pedestal), a slimmer head or \
                 more tilt may help",
                if *cuts > 0 { format!("{} ", after(*cuts)) } else { String::new() }
            ),
            Self::Left { cuts, before_mm2, after: left, worst, against } => {
                write!(f, "{}: {:.1} of {before_mm2:.1} mm2 still need support", after(*cuts), left.area_mm2)?;
                if let Some(PatchLeft { part, area_mm2, at }) = worst {
                    let (x, y, z) = (at.x, at.y, at.z);
                    write!(f, ", the largest area {area_mm2:.1} mm2 of part {part} near ({x:.1}, {y:.1}, {z:.1}) mm")?;
                }
                match left.beginnings + left.ridges {
                    0 => {}
                    1 => write!(f, ", and 1 region starts in mid-air")?,
                    begins => write!(f, ", and {begins} regions start in mid-air")?,
                }
                if let Some((against, count, all)) = against {
                    write!(f, "; rejected {count} of {all} candidate cuts: {}", because(*against))?;
                }
                let enough = (left.area_mm2 + 0.5).ceil();
                write!(f, "; allow it (--allow {enough}), turn the model, or use supports")
            }
        }
    }
}

fn because(against: Against) -> &'static str {
    match against {
        Against::Crossing => "met a surface that crosses itself",
        Against::Small => "would leave parts or seams too small to print",
        Against::Footing => "would leave a part with nothing below it",
        Against::Thin => "would leave a plate or an edge too thin to print",
        Against::Unwanted => "would put the seam where none is wanted",
        Against::Beginning => "would leave a part that starts in mid-air",
        Against::Head => "would make the head hit the remaining part or the table, or exceed an axis limit",
        Against::Gain => "would gain nothing",
        Against::Budget => "would save too little over another way to print it",
        Against::Nothing => "takes nothing of what is left; what an earlier cut took is not cut again",
    }
}
