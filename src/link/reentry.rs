//! Re-entry: how a print is resumed when the printer has forgotten where it is.
//!
//! Homing as the profile has it, up, heat, the table's axes, across and down to a block among those of which nobody knows whether they
//! were printed ([`JournalSummary::doubtful`]). What is printed again from there on may be laid twice, what is left out before it may
//! be missing; which of these blocks it is, is for whoever can prove the path and what it carries.
//!
//! Units: mm, degrees Celsius; lines of the file from 1, blocks from 0.

use std::ops::Range;

use super::journal::JournalSummary;
use super::program::{BoundaryKind, Program};
use super::retreat::number;
use super::settings::SenderSettings;
use super::state::MachineState;
use crate::trace::Action;

/// Of more layers only the first and the last are named.
const MOST_LAYERS: usize = 3;

/// What is shorter is not told, mm.
const UNSAID_MM: f64 = 0.05;

/// How a print is resumed after the printer has forgotten where it is.
#[derive(Clone, Debug, PartialEq)]
pub struct Reentry {
    /// The first block that is printed.
    pub block: u32,
    /// Its line of the file.
    pub file_line: u32,
    /// The blocks of which nobody knows whether they are executed.
    pub doubtful: Range<u32>,
    /// Of lines that may be missing, mm.
    pub missing_mm: f64,
    /// Of lines that may be laid twice, mm.
    pub twice_mm: f64,
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
    #[error(
        "the host stopped unexpectedly and {protocol} has no line counter, so what was printed after line {line} of the file is unknown; inspect \
         the part and pass --from LINE, the first line to print"
    )]
    Uncounted {
        /// The protocol's name.
        protocol: &'static str,
        /// The last that is known to be answered, of the file.
        line: u32,
    },
    /// Homing could hit the part.
    #[error(
        "[link] rehome is empty, and normal homing could drive the nozzle into the part on the table; if Z homes upward, set rehome = \"G28\" \
         in the profile"
    )]
    NoHoming,
    /// Nothing to begin at.
    #[error(
        "at line {line}, the last that is known to be executed, the axes had no known position yet; start the print again"
    )]
    NoPlace {
        /// Of the file.
        line: u32,
    },
    /// The replay cannot follow.
    #[error("the state of the machine at line {line} is unknown: {why}")]
    Unknown {
        /// Of the file.
        line: u32,
        /// What the replay says.
        why: String,
    },
    /// A line that is not among those in doubt.
    #[error("--from {line} is outside the uncertain range {first} to {last}")]
    NotInDoubt {
        /// As given, of the file.
        line: u32,
        /// The first that can be given.
        first: u32,
        /// The last that can be given.
        last: u32,
    },
}

impl Reentry {
    /// The blocks of which nobody knows whether `standing`'s print has executed them; none where somebody has looked at the part and
    /// says that it goes on `from` this line of the file.
    ///
    /// # Errors
    ///
    /// [`ReentryError::NoHoming`], [`ReentryError::Uncounted`] where nothing says how far it can have come, and
    /// [`ReentryError::NotInDoubt`] for a line that nobody asks about.
    pub fn doubt(
        program: &Program,
        settings: &SenderSettings,
        standing: &JournalSummary,
        same_boot: bool,
        from: Option<u32>,
    ) -> Result<Range<u32>, ReentryError> {
        if settings.retreat.home.is_empty() {
            return Err(ReentryError::NoHoming);
        }
        let mut doubtful = standing.doubtful(program, settings, same_boot);
        if !standing.has_end(settings) {
            if from.is_none() {
                let line = program.file_line(standing.answered.saturating_sub(1));
                return Err(ReentryError::Uncounted { protocol: settings.protocol.name(), line });
            }
            doubtful.end = program.len();
        }
        let Some(line) = from else { return Ok(doubtful) };
        let block = program.block_on(line);
        if !(doubtful.start..=doubtful.end).contains(&block) {
            let [first, last] = [doubtful.start, doubtful.end].map(|block| program.file_line(block));
            return Err(ReentryError::NotInDoubt { line, first, last });
        }
        Ok(block..block)
    }

    /// The blocks at which a print with `doubtful` ones may go on, in order: where a line begins, a layer, or the doubt begins or ends. At
    /// least one.
    ///
    /// # Errors
    ///
    /// [`ReentryError::NoPlace`] where no axis had a known place by then, [`ReentryError::Unknown`] where the replay cannot follow.
    pub fn choices(program: &Program, doubtful: &Range<u32>) -> Result<Vec<u32>, ReentryError> {
        let mut replay = program.replay();
        let (mut found, mut extrudes, mut lays) = (Vec::new(), false, false);
        let line = program.file_line(doubtful.start);
        while replay.at() <= doubtful.end {
            let block = replay.at();
            let place = &replay.machine().controller().at;
            let known = place.tip().is_some() && place.pose().is_some();
            let edge = block == doubtful.start || block == doubtful.end;
            let step = replay.step();
            let moves = match step.map(|(_, _, action)| action).transpose() {
                Ok(action) => {
                    action.and_then(|action| if let Action::Move(timed) = action { Some(timed.made) } else { None })
                }
                Err(why) => return Err(ReentryError::Unknown { line, why: why.to_string() }),
            };
            let laid = moves.is_some_and(|m| m.e > 0.0 && m.written != 0);
            // Behind a move that lays nothing a line begins.
            let marked = || program.boundaries.binary_search_by_key(&block, |b| b.block).is_ok();
            if known && block >= doubtful.start && (edge || (laid && !extrudes) || marked()) {
                found.push(block);
            }
            extrudes = laid;
            lays |= laid && block >= doubtful.start && block < doubtful.end;
            if block >= program.len() {
                break;
            }
        }
        match found.first() {
            None => Err(ReentryError::NoPlace { line }),
            // Nothing can be missing, and nothing can be there twice.
            Some(&first) if !lays => Ok(vec![first]),
            Some(_) => Ok(found),
        }
    }

    /// Which of `choices` is taken where nothing can be proved: within one layer nothing is struck; of several the last stands on top
    /// of all.
    ///
    /// # Panics
    ///
    /// Panics where there is no choice.
    pub fn unproved(program: &Program, doubtful: &Range<u32>, choices: &[u32]) -> u32 {
        let begins = |b: &&u32| program.boundaries.iter().any(|one| one.block == **b && one.block > doubtful.start);
        choices.iter().rev().find(begins).copied().unwrap_or(choices[0])
    }

    /// The re-entry at `block`.
    ///
    /// # Errors
    ///
    /// [`ReentryError::Unknown`] where the replay cannot follow.
    pub fn at(
        program: &Program,
        settings: &SenderSettings,
        doubtful: &Range<u32>,
        block: u32,
    ) -> Result<Self, ReentryError> {
        let SenderSettings { protocol, retreat, .. } = settings;
        let file_line = program.file_line(block);
        let unknown = |why: &dyn std::fmt::Display| ReentryError::Unknown { line: file_line, why: why.to_string() };
        let state = MachineState::before(program, block).map_err(|why| unknown(&why))?;
        let top = number(retreat.z_max_mm);
        let mut lines = Vec::new();
        let is_printer = protocol.traits().is_printer();
        lines.extend((is_printer && state.bed_c > 0.0).then(|| format!("M140S{}", number(state.bed_c))));
        // The printer may not have been reset since an earlier re-entry ended in the file's modes.
        lines.extend(state.inverse_time.then(|| "G94".to_owned()));
        let own_first = lines.len();
        lines.push("G90".to_owned());
        // A machine that is locked takes nothing before its own homing.
        let locked = retreat.home.first().is_some_and(|l| l.starts_with('$'));
        if locked {
            lines.truncate(own_first);
        }
        let home = lines.len()..lines.len() + retreat.home.len();
        lines.extend(retreat.home.iter().cloned());
        lines.push("G90".to_owned());
        lines.push(format!("G1Z{top}F{}", number(retreat.z_feed)));
        lines.extend(state.kept.iter().cloned());
        lines.extend(retreat.come_back(&state, *protocol));
        let [missing_mm, twice_mm] =
            [doubtful.start..block, block..doubtful.end].map(|blocks| program.laid_mm(&blocks));
        let mut entry = Self {
            block,
            file_line,
            doubtful: doubtful.clone(),
            missing_mm,
            twice_mm,
            lines,
            home,
            words: Vec::new(),
            state,
        };
        entry.words = entry.in_words(program, settings);
        Ok(entry)
    }

    fn in_words(&self, program: &Program, settings: &SenderSettings) -> Vec<String> {
        let (retreat, state) = (&settings.retreat, &self.state);
        let [x, y, z] = state.at.linear.map(|v| number(v.unwrap_or(0.0)));
        let turns = retreat.turn(state).join(", ");
        let top = number(retreat.z_max_mm);
        let line = |block: u32| program.file_line(block.saturating_sub(1));
        let known = match self.doubtful.is_empty() {
            true => format!("the file is executed up to line {}, and no further", line(self.doubtful.start)),
            false => format!(
                "the file is known to be executed up to line {}; lines {} to {} are uncertain",
                line(self.doubtful.start),
                program.file_line(self.doubtful.start),
                line(self.doubtful.end)
            ),
        };
        let heat = settings.protocol.traits().is_printer();
        let home = retreat.home.join(", ");
        let mut words = vec![
            known,
            if heat {
                format!("heat the bed to {:.0} C, then home with: {home}", state.bed_c)
            } else {
                format!("home with: {home}")
            },
            if heat {
                format!("move up to Z {top}, heat the nozzle to {:.0} C, turn the table: {turns}", state.nozzle_c)
            } else {
                format!("move up to Z {top}, turn the table: {turns}")
            },
            format!("travel to X {x} Y {y}, straight down to Z {z}, prime {} mm", number(retreat.retract_mm)),
            format!("continue at line {}, {}; {}", self.file_line, self.whereabouts(program), self.owed(program)),
        ];
        if heat && state.bed_c > 0.0 {
            words.push("a bed that has cooled may release the part: check that it still holds".to_owned());
        }
        if self.missing_mm.max(self.twice_mm) >= UNSAID_MM {
            let [first, last] = [program.file_line(self.doubtful.start), program.file_line(self.doubtful.end)];
            words.push(format!(
                "or inspect the part and pass --from LINE, the first of lines {first} to {last} that is missing from it; then nothing is missing \
                 or doubled"
            ));
        }
        words
    }

    /// What begins there, or where that lies.
    fn whereabouts(&self, program: &Program) -> String {
        let begun = program.boundaries.iter().filter(|b| b.block <= self.block);
        let starts = |b: &&super::Boundary| b.block == self.block;
        let layer = begun.clone().filter(|b| b.kind == BoundaryKind::Layer).count();
        match program.boundaries.iter().filter(starts).map(|b| b.kind).min_by_key(|kind| match kind {
            BoundaryKind::Slot(_) => 0,
            BoundaryKind::Print(_) => 1,
            BoundaryKind::Layer => 2,
        }) {
            Some(BoundaryKind::Slot(n)) => format!("the start of slot {n}"),
            Some(BoundaryKind::Print(n)) => format!("the start of print {n}"),
            Some(BoundaryKind::Layer) => format!("the start of layer {layer}"),
            None if layer > 0 => format!("within layer {layer}"),
            None => "before the first layer".to_owned(),
        }
    }

    /// What is missing and what is laid twice at most, and in which layers.
    fn owed(&self, program: &Program) -> String {
        let said = |mm: f64, blocks: Range<u32>| match mm < UNSAID_MM {
            true => "nothing".to_owned(),
            false => format!("at most {mm:.1} mm of lines{}", layers(program, &blocks)),
        };
        format!(
            "{} can be missing, {} is printed twice",
            said(self.missing_mm, self.doubtful.start..self.block),
            said(self.twice_mm, self.block..self.doubtful.end)
        )
    }
}

/// ` (8 % of layer 12)`, for all layers that `blocks` lay lines of; empty where the file names none.
fn layers(program: &Program, blocks: &Range<u32>) -> String {
    let begins = program.boundaries.iter().filter(|b| b.kind == BoundaryKind::Layer).map(|b| b.block);
    let begins: Vec<u32> = begins.chain([program.len()]).collect();
    let laid = |layer: &[u32]| {
        let both = blocks.start.max(layer[0])..blocks.end.min(layer[1]);
        let part = if both.is_empty() { 0.0 } else { program.laid_mm(&both) };
        (part > 0.0).then(|| 100.0 * part / program.laid_mm(&(layer[0]..layer[1])))
    };
    let parts = begins.windows(2).enumerate().filter_map(|(index, layer)| Some((index + 1, laid(layer)?)));
    let parts: Vec<(usize, f64)> = parts.collect();
    match parts.as_slice() {
        [] => String::new(),
        [first, .., last] if parts.len() > MOST_LAYERS => format!(" (of layers {} to {})", first.0, last.0),
        few => {
            let each = few.iter().map(|(layer, share)| format!("{:.0} % of layer {layer}", share.ceil()));
            format!(" ({})", each.collect::<Vec<_>>().join(", "))
        }
    }
}

impl Program {
    /// Length of the lines that `blocks` lay, mm; of what can be followed.
    pub(super) fn laid_mm(&self, blocks: &Range<u32>) -> f64 {
        let mut replay = self.replay();
        let mut length = 0.0;
        while replay.at() < blocks.end
            && let Some((block, _, action)) = replay.step()
        {
            if let (true, Ok(Action::Move(timed))) = (blocks.contains(&block), action) {
                let m = timed.made;
                let step = |i: usize| Some(m.to.linear[i]? - m.from.linear[i]?);
                let squares: f64 = (0..3).map(|i| step(i).unwrap_or(0.0).powi(2)).sum();
                length += if m.e > 0.0 { squares.sqrt() } else { 0.0 };
            }
        }
        length
    }
}

#[cfg(test)]
mod tests;
