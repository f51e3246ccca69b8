//! Resuming an interrupted print: from the printer's own line counter, or after a reset from the last layer.

use std::path::Path;
use std::sync::Arc;

use super::operator::{Operator, Sending};
use super::stream::{Connection, Stream};
use super::{SendRequest, Wire, begin, ended, place, program, start};
use crate::gcode::ParsedLine;
use crate::job::world::{JournalFile, read_journal};
use crate::job::{Error, World, printer};
use crate::link::serial::Port;
use crate::link::{Accounting, JournalSummary, Outcome, Program, Record, Reentry, Sender, SenderSettings, StopReason};
use crate::motion::replay::{Controller, Step};
use crate::planning::sha256_hex;
use crate::profile::Profile;
use crate::verify::{Finding, Job as Proof, Rule, verify};

/// A journal's end that had not reached the disk when the host lost its power is shorter than this.
const UNWRITTEN_S: f64 = 10.0;

/// Resumes an interrupted print, as its journal says; one that never began is sent from its first line.
///
/// # Errors
///
/// As [`send`](super::send()); [`Error::Journal`], [`Error::ProgramChanged`], [`Error::ProfileChanged`] and
/// [`Error::Ended`] for a journal that does not lead on; [`Error::Refused`] where the operator does not agree.
pub fn resume(
    request: &SendRequest<'_>,
    wire: &Wire<'_>,
    world: &World<'_>,
    operator: &dyn Operator,
) -> Result<(), Error> {
    let program = program(request, world)?;
    let standing = standing(request, wire.journal.path())?;
    let mut settings = printer::settings(&request.machine.profile)?;
    let found = place(request, wire, world);
    let mut opened = world.ports.open(&found.address, found.baud)?;
    operator.begin();
    if !standing.began() {
        return begin(request, wire, (program, opened, found), (world, operator));
    }
    let told = (world, operator);
    if let Some(uuid) = standing.printer.split_ascii_whitespace().find(|w| w.starts_with("UUID:")) {
        settings.identity = Some(uuid.to_owned());
    }
    if standing.entering {
        let text = "the re-entry was interrupted; repeating it from the start";
        operator.told(&Sending::Note(text), start(&program));
    }
    let same_boot = standing.header.boot == world.clock.boot();
    if settings.protocol.traits().accounting == Accounting::Counter && same_boot && standing.counts() {
        let place = place(request, wire, world);
        let sender = Sender::resuming(Arc::clone(&program), settings.clone(), &standing);
        let stream = (sender, opened, place);
        if let Some(outcome) = by_counter(&program, standing.proven, stream, wire, told)? {
            return ended(outcome);
        }
        opened = world.ports.open(&found.address, found.baud)?;
    }
    let standing = read_journal(wire.journal.path())?;
    let entry = reentry(request, &program, &settings, &standing, told)?;
    if !operator.agrees(&entry) {
        return Err(Error::Refused { line: entry.file_line });
    }
    let mut journal = JournalFile::reopen(wire.journal.path())?;
    journal.record(&Record::Entering);
    journal.record(&Record::Anew);
    let sender = Sender::reentering(program, settings, &entry.lines, entry.block);
    ended(Stream::new(sender, opened, found, journal, told).run()?)
}

/// Resumes from the printer's own line counter; `None` where it has lost count.
fn by_counter(
    program: &Program,
    proven: i64,
    (sender, port, place): (Sender, Port, Connection),
    wire: &Wire<'_>,
    (world, operator): (&World<'_>, &dyn Operator),
) -> Result<Option<Outcome>, Error> {
    let note = |text: &str| operator.told(&Sending::Note(text), start(program));
    note(&format!("asking the printer for its line counter; wire lines up to {proven} are known to be accepted"));
    let journal = JournalFile::reopen(wire.journal.path())?;
    let outcome = Stream::new(sender, port, place, journal, (world, operator)).run()?;
    let Outcome::Stopped(why @ (StopReason::Reset { .. } | StopReason::Counter { .. })) = &outcome else {
        return Ok(Some(outcome));
    };
    note(&why.to_string());
    Ok(None)
}

/// What the journal says, if it is this job's.
fn standing(request: &SendRequest<'_>, path: &Path) -> Result<JournalSummary, Error> {
    let standing = read_journal(path)?;
    let (program, path) = (request.program.program(), request.path.to_owned());
    if standing.header.sha256 != sha256_hex(program) {
        return Err(Error::ProgramChanged { path, then: standing.header.bytes, now: program.len() as u64 });
    }
    if standing.header.profile_sha256 != request.machine.sha256 {
        return Err(Error::ProfileChanged { profile: request.machine.name.clone() });
    }
    if standing.done {
        return Err(Error::Ended { path });
    }
    Ok(standing)
}

fn reentry(
    request: &SendRequest<'_>,
    program: &Program,
    settings: &SenderSettings,
    standing: &JournalSummary,
    (world, operator): (&World<'_>, &dyn Operator),
) -> Result<Reentry, Error> {
    let answered = standing.answered.max(standing.next_block(standing.proven));
    let found = Reentry::find(program, settings, answered);
    let entry = found.map_err(|e| Error::Printer(e.to_string()))?;
    for words in &entry.words {
        operator.told(&Sending::Note(&format!("  {words}")), start(program));
    }
    if request.plan.is_none() {
        operator.told(&Sending::UnprovedReentry, start(program));
    }
    let same_boot = standing.header.boot == world.clock.boot();
    prove_path(request, program, &entry, printed_at_most(program, settings, standing, same_boot))?;
    Ok(entry)
}

/// The last block that can have been printed.
///
/// Where a run begins is written down before it is sent, and a run ends with the next proof. A host that lost its power may
/// have lost the journal's end too: what the printer can execute in [`UNWRITTEN_S`] is added.
fn printed_at_most(program: &Program, settings: &SenderSettings, standing: &JournalSummary, same_boot: bool) -> u32 {
    let mut last = standing.reach.saturating_add(settings.prove_every);
    let mut left = if same_boot { 0.0 } else { UNWRITTEN_S };
    while left > 0.0 && last < program.len() {
        left -= program.seconds(last);
        last += 1;
    }
    last.min(program.len().saturating_sub(1))
}

/// The path down to the part and what is printed again there, replayed behind everything up to block `printed`.
fn prove_path(request: &SendRequest<'_>, program: &Program, entry: &Reentry, printed: u32) -> Result<(), Error> {
    let Some(plan) = request.plan else { return Ok(()) };
    let path = ReentryPath::of(request.program.program(), program.file_line(printed), entry, &request.machine.profile);
    let workpiece = plan.workpiece();
    let job = Proof { profile: &request.machine.profile, plan: &plan.plan, workpiece: &workpiece };
    match verify(&path.text, &job).findings.iter().find(|finding| path.counts(finding)) {
        Some(f) => Err(Error::Printer(format!("the path of the re-entry is not clear: {}", f.text))),
        None => Ok(()),
    }
}

/// What was printed, and the re-entry, as one program; lines are numbered from 1.
struct ReentryPath {
    text: Vec<u8>,
    /// The last line of what was printed.
    printed: u32,
    /// The line of homing behind which the table's pose is known, or the last of homing; the first move at least, with which the
    /// replay sees the table's pose lost.
    posed: u32,
    /// The last line of our own.
    own: u32,
}

impl ReentryPath {
    /// Lines up to `last`, the loss of every position, homing as it is written, our own moves, and the lines between once
    /// more: they go where material may stand already.
    fn of(file: &[u8], last: u32, entry: &Reentry, profile: &Profile) -> Self {
        let mut path = Self { text: Vec::with_capacity(file.len()), printed: 0, posed: 0, own: 0 };
        let mut again = Vec::new();
        for line in crate::gcode::lines(file).take_while(|l| l.number <= last) {
            path.push(line.bytes);
            if line.number >= entry.file_line {
                again.push(line.bytes);
            }
        }
        path.printed = path.own;
        // Motors that were off or a board that was reset: nobody knows where anything is, the table's angles included.
        path.push(b"M84");
        let mut controller = Controller::new(profile.reading());
        let mut read = ParsedLine::default();
        let mut moved = false;
        let moves = |l: &str| ["G1", "G90", "G91", "G93", "G94"].iter().any(|g| l.starts_with(g));
        for (index, line) in entry.lines.iter().enumerate() {
            let homes = entry.home.contains(&index);
            // What is pulled and primed is none of the file's filament.
            if !homes && (!moves(line) || line.contains('E')) {
                continue;
            }
            path.push(line.as_bytes());
            let unknown = controller.at.pose().is_none();
            // A line that is not understood leaves the pose unknown.
            let step = read.read(line.as_bytes()).ok().and_then(|()| controller.step(&read).ok());
            let first = !moved && matches!(step, Some(Step::Move(_)));
            moved |= first;
            path.posed = if first || (homes && unknown) { path.own } else { path.posed };
        }
        let own = path.own;
        again.into_iter().for_each(|line| path.push(line));
        Self { own, ..path }
    }

    fn push(&mut self, line: &[u8]) {
        self.text.extend_from_slice(line);
        self.text.push(b'\n');
        self.own += 1;
    }

    /// Whether a finding stands against the re-entry. That homing itself touches nothing is the profile's word, as long as nobody
    /// knows where the table is; coming from home, X and Y may be anywhere, and are judged as that.
    fn counts(&self, finding: &Finding) -> bool {
        match finding.rule {
            _ if finding.line <= self.printed => false,
            Rule::HeadCollision | Rule::AxisLimit => true,
            Rule::TurnCollision => finding.line > self.posed,
            Rule::UnknownPosition => finding.line > self.own,
            _ => false,
        }
    }
}

#[cfg(test)]
mod tests;
