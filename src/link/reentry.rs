//! Re-entry: how a print goes on when the printer has forgotten where it is.
//!
//! Homing as the profile has it, up, heat, the table's axes, across and down to a layer that began before anything that may not be
//! printed.
//!
//! Units: mm, degrees Celsius; lines of the file from 1, blocks from 0.

use std::ops::Range;

use super::program::{Mark, MarkKind, Program};
use super::protocol::Accounting;
use super::retreat::number;
use super::settings::Settings;
use super::state::MachineState;
use crate::motion::replay::ReplayError;

/// How a print is taken up again after the printer has forgotten where it is.
#[derive(Clone, Debug, PartialEq)]
pub struct Reentry {
    /// The block with which it goes on.
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

/// Why a print cannot be taken up again.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ReentryError {
    /// Nobody can be asked, and nothing says what was printed.
    #[error("a print cannot go on after a reset of {protocol}: it has no line counter to ask")]
    Uncounted {
        /// The protocol's name.
        protocol: &'static str,
    },
    /// Homing could hit the part.
    #[error(
        "the profile gives no way to home with a part on the table ([link] rehome): homing as usual could drive the nozzle \
         into the print"
    )]
    NoHoming,
    /// Nothing to begin at.
    #[error(
        "no layer or slot of the file lies before line {line}, the last that is known to be executed; print it anew"
    )]
    NoBoundary {
        /// Of the file.
        line: u32,
    },
    /// The replay cannot follow.
    #[error("the file cannot be followed up to line {line}: {why}")]
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
    /// time, so that the last [`Settings::planner_blocks`] of them, and three seconds before those, do not count as executed. The
    /// print goes on at the last slot, print or layer that began before that.
    ///
    /// # Errors
    ///
    /// [`ReentryError`] where that is not safe.
    pub fn find(program: &Program, settings: &Settings, answered: u32) -> Result<Self, ReentryError> {
        let Settings { protocol, retreat, planner_blocks, .. } = settings;
        let manners = protocol.manners();
        if manners.accounting == Accounting::Status {
            return Err(ReentryError::Uncounted { protocol: manners.name });
        }
        let mut executed = answered.saturating_sub(*planner_blocks);
        let mut left = manners.buffered_s;
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
        for mark in program.marks.iter().rev().filter(|m| m.block <= executed) {
            let state = MachineState::before(program, mark.block).map_err(unknown)?;
            if known(&state) {
                return Ok(Self::at(program, settings, *mark, executed, state));
            }
        }
        Err(ReentryError::NoBoundary { line })
    }

    fn at(program: &Program, settings: &Settings, mark: Mark, executed: u32, state: MachineState) -> Self {
        let Settings { protocol, retreat, .. } = settings;
        let Mark { kind, block } = mark;
        let top = number(retreat.z_max_mm);
        let mut lines = Vec::new();
        lines.extend((state.bed_c > 0.0).then(|| format!("M140S{}", number(state.bed_c))));
        // The printer may not have been reset since an earlier way back ended in the file's modes.
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
            MarkKind::Slot(n) => format!("slot {n}"),
            MarkKind::Print(n) => format!("print {n}"),
            MarkKind::Layer => "its layer".to_owned(),
        };
        let turns = retreat.turn(&state).join(", ");
        let words = vec![
            format!("lines up to {} of the file are known to be executed", program.file_line(executed)),
            format!("heat the bed to {:.0} and home with: {}", state.bed_c, retreat.home.join(", ")),
            format!("up to Z {top}, heat the nozzle to {:.0}, turn the table: {turns}", state.nozzle_c),
            format!("across to X {x} Y {y}, straight down to Z {z}, prime {} mm", number(retreat.retract_mm)),
            format!(
                "go on with {what}, line {file_line}; {} lines are printed again",
                program.file_line(executed).saturating_sub(file_line)
            ),
        ];
        Self { block, file_line, executed, lines, home, words, state }
    }
}
