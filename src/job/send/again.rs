//! Resuming an interrupted print: from the printer's own line counter, from where it stands, or after a reset by a re-entry.

mod choice;
mod proof;
#[cfg(test)]
mod testing;

use std::path::Path;
use std::sync::Arc;

use super::error::SendError;
use super::operator::{Operator, Sending};
use super::stream::{Connection, Stream};
use super::{Checked, SendRequest, Wire, checked, ended, go, header, start};
use crate::link::serial::Port;
use crate::link::{
    Accounting, Header, JournalSummary, MachineState, Outcome, Program, Record, ReentryError, Sender, SenderSettings,
    StopReason,
};
use crate::planning::sha256_hex;
use crate::world::{FileError, World};
use crate::world::{JournalFile, read_journal};
use choice::Choice;

/// Resumes an interrupted print, as its journal says; one that never began is sent from its first line.
///
/// A printer that counts its lines is asked for its counter, another for its place. Where it has lost that, the machine is homed as the
/// profile says, and the print goes on where nothing is struck, nothing lies in the air, and least is laid twice.
///
/// # Errors
///
/// As [`send`](super::send()); [`SendError::NoJournal`], [`FileError::Journal`], [`SendError::ProgramChanged`], [`SendError::ProfileChanged`] and
/// [`SendError::Ended`] for a journal that does not lead on; [`SendError::Refused`] where the operator does not agree.
pub fn resume(
    request: &SendRequest<'_>,
    wire: &Wire<'_>,
    world: &World<'_>,
    operator: &dyn Operator,
) -> Result<(), SendError> {
    let (checked, port) = checked(request, wire, true, world)?.open(world)?;
    go(checked, port, request, wire, world, operator)
}

/// Resumes a print of which the journal says nothing but its name: only where the printer has taken no line either does it begin.
pub(super) fn ask_first(
    checked: Checked,
    opened: Port,
    request: &SendRequest<'_>,
    wire: &Wire<'_>,
    world: &World<'_>,
    operator: &dyn Operator,
) -> Result<(), SendError> {
    let Checked { program, settings, place, standing: Some(standing) } = checked else { return Ok(()) };
    let text = "the journal has no record of a line; asking the printer whether it accepted any";
    operator.told(&Sending::Note(text), start(&program));
    // From here on it is a journal of this run of the operating system.
    let journal = JournalFile::create(wire.journal, &header(request, &place, world))?;
    let sender = Sender::resuming(program, settings, &standing);
    ended(Stream::new(sender, opened, place, journal, world, operator).run()?)
}

/// Resumes a print that has begun.
pub(super) fn go_on(
    checked: Checked,
    mut opened: Port,
    request: &SendRequest<'_>,
    wire: &Wire<'_>,
    world: &World<'_>,
    operator: &dyn Operator,
) -> Result<(), SendError> {
    let Checked { program, mut settings, place: found, standing: Some(standing) } = checked else { return Ok(()) };
    if let Some(uuid) = standing.printer.split_ascii_whitespace().find(|w| w.starts_with("UUID:")) {
        settings.identity = Some(uuid.to_owned());
    }
    if standing.entering {
        let text = "the re-entry was interrupted; repeating it from the start";
        operator.told(&Sending::Note(text), start(&program));
    }
    let same_boot = standing.header.boot == world.clock.boot();
    let bed_was_c = bed_c(&program, &standing).filter(|_| !request.options.holds);
    let kept = SenderSettings { bed_was_c, ..settings.clone() };
    if let Some((sender, journal)) = keeps_place(&program, &kept, &standing, same_boot, request, wire)? {
        if let Some(outcome) = carry_on(&program, sender, opened, found.clone(), journal, world, operator)? {
            return ended(outcome);
        }
        opened = world.ports.open(&found.address, found.baud)?;
    }
    let standing = read_journal(wire.journal.path())?;
    let choice = Choice { request, program: &program, settings: &settings, operator };
    let entry = choice.entry(&standing, same_boot)?;
    if !operator.agrees(&entry) {
        return Err(SendError::Refused { line: entry.file_line });
    }
    let mut journal = JournalFile::reopen(wire.journal.path())?;
    journal.record(&Record::Entering);
    journal.record(&Record::Anew);
    let sender = Sender::reentering(program, settings, &entry.lines, entry.block);
    ended(Stream::new(sender, opened, found, journal, world, operator).run()?)
}

/// What the bed was to be where the print was broken off; `None` for one that was not heated.
fn bed_c(program: &Program, standing: &JournalSummary) -> Option<f64> {
    let state = MachineState::before(program, standing.next_block(standing.proven)).ok()?;
    Some(state.bed_c).filter(|bed_c| *bed_c > 0.0)
}

/// A sender that asks a printer which may have kept its counter or its place, and the journal for it; `None` where there is nothing to
/// ask for.
fn keeps_place(
    program: &Arc<Program>,
    settings: &SenderSettings,
    standing: &JournalSummary,
    same_boot: bool,
    request: &SendRequest<'_>,
    wire: &Wire<'_>,
) -> Result<Option<(Sender, JournalFile)>, SendError> {
    // Whoever gives a line has looked at the part, and knows that the printer has forgotten.
    if request.options.from.is_some() || standing.entering {
        return Ok(None);
    }
    let counter = settings.protocol.traits().accounting == Accounting::Counter;
    if counter && same_boot && standing.counts() {
        let journal = JournalFile::reopen(wire.journal.path())?;
        return Ok(Some((Sender::resuming(Arc::clone(program), settings.clone(), standing), journal)));
    }
    let Some(places) = (!counter).then(|| standing.stands_at(program, settings, same_boot)).flatten() else {
        return Ok(None);
    };
    let mut journal = JournalFile::reopen(wire.journal.path())?;
    journal.record(&Record::Anew);
    journal.record(&Record::Locating);
    if let Some(block) = standing.paused {
        journal.record(&Record::Away);
        journal.record(&Record::Paused(block));
    }
    let away = standing.paused.is_some();
    Ok(Some((Sender::locating(Arc::clone(program), settings.clone(), places, away), journal)))
}

/// Resumes with what the printer has kept; `None` where it has not.
fn carry_on(
    program: &Program,
    sender: Sender,
    port: Port,
    place: Connection,
    journal: JournalFile,
    world: &World<'_>,
    operator: &dyn Operator,
) -> Result<Option<Outcome>, SendError> {
    let note = |text: &str| operator.told(&Sending::Note(text), start(program));
    note("asking the printer whether it kept its line counter and its position");
    let outcome = Stream::new(sender, port, place, journal, world, operator).run()?;
    let lost = |why: &StopReason| {
        matches!(why, StopReason::Reset { .. } | StopReason::Counter { .. } | StopReason::Misplaced { .. })
            || matches!(why, StopReason::NotReady { locked: true, .. })
    };
    match &outcome {
        Outcome::Stopped(why) if lost(why) => note(&why.to_string()),
        _ => return Ok(Some(outcome)),
    }
    Ok(None)
}

/// What the journal says, if it is this job's.
pub(super) fn standing(request: &SendRequest<'_>, path: &Path, blocks: &Program) -> Result<JournalSummary, SendError> {
    let standing = read_journal(path).map_err(|error| match error {
        FileError::Read { path, source } if source.kind() == std::io::ErrorKind::NotFound => {
            SendError::NoJournal { path, program: request.path.to_owned() }
        }
        other => other.into(),
    })?;
    let (program, file) = (request.program.program(), request.path.to_owned());
    if standing.header.sha256 != sha256_hex(program) {
        let Header { path: of, bytes: then, .. } = standing.header;
        return Err(SendError::ProgramChanged { path: file, of, then, now: program.len() as u64 });
    }
    if standing.header.profile_sha256 != request.machine.sha256 {
        return Err(SendError::ProfileChanged { profile: request.machine.name.clone() });
    }
    standing.check(blocks.len()).map_err(|source| FileError::Journal { path: path.to_owned(), source })?;
    if standing.done {
        return Err(SendError::Ended { path: file });
    }
    Ok(standing)
}

fn no_entry(error: &ReentryError) -> SendError {
    SendError::Printer(error.to_string())
}

#[cfg(test)]
mod tests;
