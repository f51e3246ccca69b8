//! Where a print goes on after a reset: at which of the blocks that nobody knows to be printed.
//!
//! What can have been printed ends somewhere among them. A later place leaves more out, should the print have ended early; an earlier one
//! lays more twice, should it have ended late. So the latest is taken at which, had the print ended earliest, nothing lies in the air; and had
//! it ended latest, nothing is struck. Both are asked of `verify`, to which what stood before the re-entry is an earlier setup's: a line may lie
//! one layer above that, so that a thin tower, of which a whole layer can be in doubt, goes on at its next one and is not printed into.

use std::ops::Range;

use super::no_entry;
use super::proof::ReentryPath;
use crate::input::CheckedPlan;
use crate::job::send::SendError;
use crate::job::send::operator::{Operator, Sending};
use crate::job::send::{SendRequest, start};
use crate::link::{BoundaryKind, JournalSummary, Program, Reentry, SenderSettings};

/// Layers behind a place in which it shows what carries them.
const LAYERS_LOOKED_AT: usize = 3;

/// A print that is to go on.
pub(super) struct Choice<'a> {
    pub(super) request: &'a SendRequest<'a>,
    pub(super) program: &'a Program,
    pub(super) settings: &'a SenderSettings,
    pub(super) operator: &'a dyn Operator,
}

impl Choice<'_> {
    /// The re-entry, told; nothing has moved yet.
    pub(super) fn entry(&self, standing: &JournalSummary, same_boot: bool) -> Result<Reentry, SendError> {
        let from = self.request.options.from;
        let doubtful =
            Reentry::doubt(self.program, self.settings, standing, same_boot, from).map_err(|e| no_entry(&e))?;
        let choices = Reentry::choices(self.program, &doubtful).map_err(|e| no_entry(&e))?;
        let block = match self.request.plan {
            Some(plan) => self.proved(plan, &doubtful, &choices),
            None => Ok(Reentry::unproved(self.program, &doubtful, &choices)),
        };
        // Where there is no way, what would be done is told nevertheless.
        let told = block.as_ref().map_or_else(|_| choices[choices.len() - 1], |block| *block);
        let entry = self.at(&doubtful, told)?;
        for words in &entry.words {
            self.operator.told(&Sending::Note(&format!("  {words}")), start(self.program));
        }
        if self.request.plan.is_none() {
            self.operator.told(&Sending::UnprovedReentry, start(self.program));
        }
        block.map(|_| entry)
    }

    fn at(&self, doubtful: &Range<u32>, block: u32) -> Result<Reentry, SendError> {
        Reentry::at(self.program, self.settings, doubtful, block).map_err(|e| no_entry(&e))
    }

    /// The latest of `choices` behind which nothing lies in the air, if its path is clear.
    fn proved(&self, plan: &CheckedPlan, doubtful: &Range<u32>, choices: &[u32]) -> Result<u32, SendError> {
        // The first lays nothing on what may be missing, whatever was printed.
        let (mut low, mut high) = (0, choices.len() - 1);
        while low < high {
            let middle = (low + high).div_ceil(2);
            // Most often all of them are carried.
            let middle = if high == choices.len() - 1 && low == 0 { high } else { middle };
            match self.path(doubtful, choices[middle], doubtful.start)?.hanging(plan, &self.request.machine.profile) {
                None => low = middle,
                Some(_) => high = middle - 1,
            }
        }
        let block = choices[low];
        match self.path(doubtful, block, doubtful.end)?.struck(plan, &self.request.machine.profile) {
            None => Ok(block),
            Some(why) => Err(SendError::Printer(self.no_way(&why, doubtful, choices))),
        }
    }

    /// The re-entry at `block` where the blocks before `printed` are printed, and what shows whether it is carried.
    fn path(&self, doubtful: &Range<u32>, block: u32, printed: u32) -> Result<ReentryPath, SendError> {
        let entry = self.at(doubtful, block)?;
        let until = self.program.file_line(self.looked_at(block).max(doubtful.end));
        let last = if printed == 0 { 0 } else { self.program.file_line(printed - 1) };
        Ok(ReentryPath::of(self.request.program.program(), last, &entry, until, &self.request.machine.profile))
    }

    /// The end of what shows whether `block`'s layer and the next ones are carried.
    fn looked_at(&self, block: u32) -> u32 {
        let layers = self.program.boundaries.iter().filter(|b| b.kind == BoundaryKind::Layer && b.block > block);
        layers.map(|b| b.block).nth(LAYERS_LOOKED_AT).unwrap_or(self.program.len())
    }

    /// Why there is none, and what helps.
    fn no_way(&self, why: &str, doubtful: &Range<u32>, choices: &[u32]) -> String {
        if doubtful.is_empty() || choices.len() == 1 {
            return format!("the path for resuming the print is blocked: {why}");
        }
        let layers: Vec<u32> = self
            .program
            .boundaries
            .iter()
            .filter(|b| b.kind == BoundaryKind::Layer && doubtful.contains(&b.block))
            .map(|b| self.program.file_line(b.block))
            .collect();
        let [first, last] = [doubtful.start, doubtful.end].map(|block| self.program.file_line(block));
        let layers = match layers.as_slice() {
            [] => String::new(),
            lines => format!(" (layers begin at {})", lines.iter().map(u32::to_string).collect::<Vec<_>>().join(", ")),
        };
        format!(
            "the path for resuming the print is blocked if lines {first} to {last} are already printed: {why}; inspect the part and pass \
             --from LINE, its first unprinted line{layers}"
        )
    }
}

#[cfg(test)]
mod tests;
