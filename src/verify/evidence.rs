//! What every check is given, and what it gives back.

use super::acts::Acts;
use super::prints::PrintedPart;
use super::report::{
    Findings, InterfaceFill, JointRoom, NearestApproach, Report, Standing, StatedSetting, TableUse, WallStart,
};
use super::{Planned, ReplayJob};
use crate::trace::Trace;

/// A program as its machine carries it out, with what it was made for.
pub(super) struct Evidence<'a> {
    /// The file.
    pub(super) bytes: &'a [u8],
    /// The file as the machine takes it.
    pub(super) trace: &'a Trace,
    pub(super) job: &'a ReplayJob<'a>,
    /// The plan's prints, in its order.
    pub(super) planned: &'a [Planned],
    /// By print of the plan, what was printed of it by layers; `None` where nothing was, and for supports.
    pub(super) printed: &'a [Option<PrintedPart<'a>>],
    /// The trace as lines of the tip and turns of the table.
    pub(super) acts: &'a Acts<'a>,
}

/// One check of a program.
pub(super) type Check = fn(&Evidence<'_>) -> Checked;

/// The outcome of one check.
pub(super) struct Checked {
    pub(super) findings: Findings,
    pub(super) figures: Figures,
}

impl From<Findings> for Checked {
    fn from(findings: Findings) -> Self {
        Self { findings, figures: Figures::None }
    }
}

/// What a check measures on its way, which the report states.
pub(super) enum Figures {
    None,
    /// The least room of the head, with its line and its place, and what the replay has cost.
    Clearance {
        mm: f64,
        line: u32,
        at: Option<NearestApproach>,
        steps: u64,
    },
    /// Slots in which something was printed, and the filament of all prints, mm.
    Printed {
        slots: usize,
        filament_mm: f64,
    },
    Standing(Option<Standing>),
    Table {
        used: TableUse,
        wall_starts: Vec<WallStart>,
    },
    Joints(Vec<JointRoom>),
    Interfaces(Vec<InterfaceFill>),
    Stated(Vec<StatedSetting>),
}

impl Figures {
    /// Writes them into the report.
    pub(super) fn state_in(self, report: &mut Report) {
        match self {
            Self::None => {}
            Self::Clearance { mm, line, at, steps } => {
                (report.clearance_mm, report.clearance_line, report.clearance_at) = (mm, line, at);
                report.steps = steps;
            }
            Self::Printed { slots, filament_mm } => (report.slots, report.filament_mm) = (slots, filament_mm),
            Self::Standing(standing) => report.standing = standing,
            Self::Table { used, wall_starts } => (report.table, report.wall_starts) = (used, wall_starts),
            Self::Joints(joints) => report.joints = joints,
            Self::Interfaces(interfaces) => report.interfaces = interfaces,
            Self::Stated(stated) => report.stated = stated,
        }
    }
}
