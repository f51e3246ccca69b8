//! Re-entry: how a print is resumed when the printer has forgotten where it is.
//!
//! Homing as the profile has it, up, heat, the table's axes, across and down to a layer that began before anything that may not be
//! printed.
//!
//! Units: mm, degrees Celsius; lines of the file from 1, blocks from 0.

use std::ops::Range;

use super::program::{Boundary, BoundaryKind, Program};
use super::protocol::Accounting;
use super::retreat::number;
use super::settings::SenderSettings;
use super::state::MachineState;
use crate::motion::replay::ReplayError;

/// How a print is resumed after the printer has forgotten where it is.
#[derive(Clone, Debug, PartialEq)]
pub struct Reentry {
    /// The first block that is printed.
    pub block: u32,
    /// Its line of the file.
    pub file_line: u32,
    /// The last block that is known to be executed.
    pub executed: u32,
    /// Our own lines before it.
    pub lines: Vec<String>,
    /// Which of them home, as the profile says.
    pub home: Range<usize>,
    /// What will happen, a sentence each.
    pub words: Vec<String>,
    /// The state there.
    pub state: MachineState,
}

/// Why there is no re-entry.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ReentryError {
    /// Nobody can be asked, and nothing says what was printed.
    #[error("a print cannot be resumed after a reset of {protocol}: it has no line counter to ask")]
    Uncounted {
        /// The protocol's name.
        protocol: &'static str,
    },
    /// Homing could hit the part.
    #[error(
        "[link] rehome is empty: the profile does not say how to home with a part on the table, and homing as usual could \
         drive the nozzle into the print"
    )]
    NoHoming,
    /// Nothing to begin at.
    #[error("no layer or slot begins before line {line}, the last that is known to be executed; start the print again")]
    NoBoundary {
        /// Of the file.
        line: u32,
    },
    /// The replay cannot follow.
    #[error("the state of the machine at line {line} cannot be worked out: {why}")]
    Unknown {
        /// Of the file.
        line: u32,
        /// What the replay says.
        why: String,
    },
}

impl Reentry {
    /// The re-entry for a print of which blocks before `answered` were answered.
    ///
    /// An answered block may still have been in the printer's planner, or (not on Marlin) in a buffer that holds motion by its
    /// time, so that the last [`SenderSettings::planner_blocks`] of them, and three seconds before those, do not count as executed. The
    /// print goes on at the last slot, print or layer that began before that.
    ///
    /// # Errors
    ///
    /// [`ReentryError`] where that is not safe.
    pub fn find(program: &Program, settings: &SenderSettings, answered: u32) -> Result<Self, ReentryError> {
        let SenderSettings { protocol, retreat, planner_blocks, .. } = settings;
        let traits = protocol.traits();
        if traits.accounting == Accounting::Status {
            return Err(ReentryError::Uncounted { protocol: traits.name });
        }
        let mut executed = answered.saturating_sub(*planner_blocks);
        let mut left = traits.buffered_s;
        while left > 0.0 && executed > 0 {
            executed -= 1;
            left -= program.seconds(executed);
        }
        let line = program.file_line(executed);
        if retreat.home.is_empty() {
            return Err(ReentryError::NoHoming);
        }
        let unknown = |why: ReplayError| ReentryError::Unknown { line, why: why.to_string() };
        let known = |s: &MachineState| s.at.tip().is_some() && s.at.pose().is_some();
        for boundary in program.boundaries.iter().rev().filter(|b| b.block <= executed) {
            let state = MachineState::before(program, boundary.block).map_err(unknown)?;
            if known(&state) {
                return Ok(Self::at(program, settings, *boundary, executed, state));
            }
        }
        Err(ReentryError::NoBoundary { line })
    }

    fn at(
        program: &Program,
        settings: &SenderSettings,
        boundary: Boundary,
        executed: u32,
        state: MachineState,
    ) -> Self {
        let SenderSettings { protocol, retreat, .. } = settings;
        let Boundary { kind, block } = boundary;
        let top = number(retreat.z_max_mm);
        let mut lines = Vec::new();
        lines.extend((state.bed_c > 0.0).then(|| format!("M140S{}", number(state.bed_c))));
        // The printer may not have been reset since an earlier re-entry ended in the file's modes.
        lines.extend(state.inverse_time.then(|| "G94".to_owned()));
        lines.push("G90".to_owned());
        let home = lines.len()..lines.len() + retreat.home.len();
        lines.extend(retreat.home.iter().cloned());
        lines.push("G90".to_owned());
        lines.push(format!("G1Z{top}F{}", number(retreat.z_feed)));
        lines.extend(state.kept.iter().cloned());
        lines.extend(retreat.come_back(&state, *protocol));
        let [x, y, z] = state.at.linear.map(|v| number(v.unwrap_or(0.0)));
        let file_line = program.file_line(block);
        let what = match kind {
            BoundaryKind::Slot(n) => format!("slot {n}"),
            BoundaryKind::Print(n) => format!("print {n}"),
            BoundaryKind::Layer => "a layer".to_owned(),
        };
        let turns = retreat.turn(&state).join(", ");
        let words = vec![
            format!("the file is known to be executed up to line {}", program.file_line(executed)),
            format!("heat the bed to {:.0} C, then home with: {}", state.bed_c, retreat.home.join(", ")),
            format!("go up to Z {top}, heat the nozzle to {:.0} C, turn the table: {turns}", state.nozzle_c),
            format!("travel to X {x} Y {y}, straight down to Z {z}, prime {} mm", number(retreat.retract_mm)),
            format!(
                "continue at line {file_line}, the start of {what}; {} lines are printed a second time",
                program.file_line(executed).saturating_sub(file_line)
            ),
        ];
        Self { block, file_line, executed, lines, home, words, state }
    }
}
