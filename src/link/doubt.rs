//! What nobody knows after a printer has forgotten where it was: which of the last blocks were printed.
//!
//! Units: blocks from 0, seconds of motion.

use std::ops::Range;

use super::journal::JournalSummary;
use super::program::Program;
use super::protocol::Accounting;
use super::settings::SenderSettings;

/// A journal's end that had not reached the disk when the host lost its power is shorter than this, s.
const UNWRITTEN_S: f64 = 10.0;

impl JournalSummary {
    /// The blocks of which nobody knows whether they were executed, where the printer has been reset: those before are
    /// executed, those from the end on are not. Empty where a pause was reached.
    ///
    /// An answered block may still have been in the printer's planner, or (not on Marlin) in a buffer that holds motion by its
    /// time, so that the last [`SenderSettings::planner_blocks`] answered ones do not count as executed, nor three seconds before
    /// those. What the host has sent it wrote down before, and exactly where it ended in order; one that lost its power (not
    /// `same_boot`) may have lost the journal's end too.
    pub fn doubtful(&self, program: &Program, settings: &SenderSettings, same_boot: bool) -> Range<u32> {
        if let Some(block) = self.paused {
            let block = block.min(program.len());
            return block..block;
        }
        let answered = self.answered.max(self.next_block(self.proven)).min(program.len());
        let mut start = answered.saturating_sub(settings.planner_blocks);
        let mut left = settings.protocol.traits().buffered_s;
        while left > 0.0 && start > 0 {
            start -= 1;
            left -= program.seconds(start);
        }
        let end = self.unsent(program, settings, same_boot);
        start.max(self.resumed_at).min(end)..end
    }

    /// The first block that was not sent, or a later one.
    pub(super) fn unsent(&self, program: &Program, settings: &SenderSettings, same_boot: bool) -> u32 {
        let mut end = match self.sent {
            // What a host has said in its last words may be all that is lost.
            // A re-entry goes back behind what may stand already.
            Some(sent) if same_boot => sent.max(self.stood),
            // Where a run begins is written before it is sent, and a run ends with the next proof.
            _ => self.reach.saturating_add(settings.prove_every).saturating_add(1),
        };
        let mut left = if same_boot { 0.0 } else { UNWRITTEN_S };
        while left > 0.0 && end < program.len() {
            left -= program.seconds(end);
            end += 1;
        }
        end.min(program.len())
    }

    /// Whether [`JournalSummary::doubtful`] has an end: a protocol without proofs writes down where it is only now and then.
    pub(super) fn has_end(&self, settings: &SenderSettings) -> bool {
        settings.protocol.traits().accounting != Accounting::Status || self.paused.is_some() || self.sent.is_some()
    }
}
