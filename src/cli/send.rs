//! `trunnion send`: what is proved goes out, once; what breaks off can go on.

use std::io::{BufRead, IsTerminal};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use serde_json::json;

use super::args::{Send as Verb, StreamArgs};
use super::journal_file::{self, JournalFile};
use super::load::LoadedProfile;
use super::stream::{Place, Stream, catch_interrupts};
use super::{Console, Failure, files, load, printer};
use crate::link::serial::{Address, Port, identity};
use crate::link::sim::{Script, Sim};
use crate::link::{
    Header, LARGEST_FILE, Loopback, Outcome, Program, ProgramError, Protocol, Record, Reentry, Sender, Standing, Stop,
    too_slow,
};
use crate::planning::sha256_hex;
use crate::verify::{Job as Proof, Rule, verify};

/// A journal's end that had not reached the disk when the host lost its power is shorter than this.
const UNWRITTEN_S: f64 = 10.0;

/// A file on its way to a printer.
pub(super) struct Job<'a> {
    pub(super) path: &'a Path,
    pub(super) bytes: &'a [u8],
    pub(super) machine: &'a LoadedProfile,
    /// The plan and what it was made for, for the way back to the part after a reset; `None` for an unverified file.
    pub(super) plan: Option<&'a crate::planning::Plan>,
    pub(super) workpiece: Option<&'a crate::planning::Workpiece<'a>>,
}

pub(super) fn run(args: &Verb, console: &Console) -> Result<(), Failure> {
    let bytes = read(&args.gcode)?;
    if let Some(plan) = &args.plan {
        let loaded = load::plan(plan, &args.plan_ref, console)?;
        let workpiece = loaded.workpiece();
        let job = Proof { profile: &loaded.machine.profile, plan: &loaded.plan, workpiece: &workpiece };
        let report = verify(&bytes, &job);
        if let Some(first) = report.findings.first() {
            let text = format!("{} findings: line {}: {}", report.count(), first.line, first.text);
            return Err(Failure::Findings(format!("{}: {text}; nothing was sent", args.gcode.display())));
        }
        console.note(&format!("verified: {} moves, clearance {:.2} mm", report.moves, report.clearance_mm));
        let (plan, workpiece) = (Some(&loaded.plan), Some(&workpiece));
        let job = Job { path: &args.gcode, bytes: &bytes, machine: &loaded.machine, plan, workpiece };
        return go(&job, args.port.as_deref(), args.dry_run, &args.stream, console);
    }
    let Some(profile) = args.plan_ref.profile.as_deref().filter(|_| args.unverified) else {
        return Err(Failure::Usage(
            "only a file that verifies is sent: give its plan with --plan PLAN.json; or --unverified with -m PROFILE, and \
             nothing is known of what the head will hit"
                .to_owned(),
        ));
    };
    let machine = load::profile(profile)?;
    console.warning("the file is not verified: nothing is known of what the head will hit");
    let job = Job { path: &args.gcode, bytes: &bytes, machine: &machine, plan: None, workpiece: None };
    go(&job, args.port.as_deref(), args.dry_run, &args.stream, console)
}

/// A file of a size that can be sent; not read before that is known.
fn read(path: &Path) -> Result<Vec<u8>, Failure> {
    let size = files::size(path)?;
    if size > LARGEST_FILE {
        let source = ProgramError::TooBig { bytes: size, allowed: LARGEST_FILE };
        return Err(Failure::Program { path: path.to_owned(), source });
    }
    files::read(path)
}

fn go(job: &Job<'_>, port: Option<&str>, dry_run: bool, args: &StreamArgs, console: &Console) -> Result<(), Failure> {
    match port {
        Some(port) if !dry_run => stream(job, port, args, console),
        _ => rehearse(job, &program(job, args, console)?, console),
    }
}

/// The file as blocks, after the checks that need no printer.
fn program(job: &Job<'_>, args: &StreamArgs, console: &Console) -> Result<Arc<Program>, Failure> {
    let profile = &job.machine.profile;
    let rules = printer::rules(profile)?;
    let program =
        Program::read(job.bytes, &rules).map_err(|source| Failure::Program { path: job.path.to_owned(), source })?;
    if let Some((line, why)) = &program.unknown {
        console.warning(&format!(
            "line {line}: {why}; a print that breaks off behind it can only go on if the printer still counts"
        ));
    }
    if let Some(unfit) = printer::abilities(profile).lacking(&program) {
        return Err(Failure::Findings(format!("{}: {unfit}; nothing was sent", job.path.display())));
    }
    if rules.protocol != Protocol::Klipper
        && let Some(slow) = too_slow(&program, rules.protocol, args.baud.unwrap_or(profile.link.baud), &rules.rates)
    {
        console.warning(&slow.to_string());
    }
    Ok(Arc::new(program))
}

/// Prints on the simulated printer in virtual time.
fn rehearse(job: &Job<'_>, program: &Arc<Program>, console: &Console) -> Result<(), Failure> {
    let profile = &job.machine.profile;
    let protocol = printer::protocol(profile)?;
    let mut sim = Sim::new(protocol, printer::model(profile)?, printer::quirks(profile)?, Script::none()).without_log();
    if protocol == Protocol::Grbl {
        sim.receive(Duration::ZERO, b"$H\n");
        sim.advance(Duration::from_secs(60));
        sim.took(usize::MAX);
    }
    let mut link = Loopback::new(Sender::new(Arc::clone(program), printer::settings(profile)?), sim);
    let outcome = link.run(Duration::from_secs(60 * 24 * 3600));
    if outcome != Some(Outcome::Done) {
        let why = if let Some(Outcome::Stopped(why)) = outcome { why.to_string() } else { "it did not end".to_owned() };
        return Err(Failure::Printer(format!("rehearsal: {why}")));
    }
    let minutes = link.now().as_secs_f64() / 60.0;
    console.note(&format!(
        "rehearsal: {} lines in {minutes:.0} min with heating and accelerations; {} targets beyond an axis",
        program.len(),
        link.sim.clamped()
    ));
    if console.json() {
        let of = program.file_line(program.len());
        let facts = json!({"event": "done", "line": of, "of": of, "dry_run": true, "seconds": link.now().as_secs_f64(), "clamped": link.sim.clamped()});
        console.result(&facts.to_string());
    }
    if link.sim.clamped() > 0 {
        return Err(Failure::Findings(format!("{} targets lie beyond an axis of the profile", link.sim.clamped())));
    }
    Ok(())
}

fn journal_path(job: &Job<'_>, args: &StreamArgs) -> PathBuf {
    args.journal.clone().unwrap_or_else(|| files::with_suffix(job.path, ".journal"))
}

/// Sends, or goes on with, a job; everything before the first byte has been checked.
pub(super) fn stream(job: &Job<'_>, port: &str, args: &StreamArgs, console: &Console) -> Result<(), Failure> {
    let program = program(job, args, console)?;
    let path = journal_path(job, args);
    let standing = if args.resume { Some(standing(job, &path)?) } else { None };
    let mut settings = printer::settings(&job.machine.profile)?;
    let place = place(port, job, args);
    let opened = Port::open(&place.address, place.baud)?;
    catch_interrupts();
    let Some(standing) = standing.filter(Standing::began) else {
        let header = header(job, &place);
        if let Some(aside) = broken_off(&path) {
            console.warning(&format!("the journal of a print that was broken off is now {}", aside.display()));
        }
        let journal = JournalFile::create(&path, &header)?;
        let sender = Sender::new(program, settings);
        return ended(Stream::new(sender, opened, place, journal, console).run()?);
    };
    if let Some(uuid) = standing.printer.split_ascii_whitespace().find(|w| w.starts_with("UUID:")) {
        settings.identity = Some(uuid.to_owned());
    }
    let same_boot = standing.header.boot == journal_file::boot();
    let mut opened = opened;
    if standing.entering {
        console.note("the way back to the part was broken off: it is gone again from its beginning");
    }
    if settings.protocol == Protocol::Marlin && same_boot && standing.counts() {
        console.note(&format!(
            "asking the printer's counter; lines up to {} on the wire are known to be accepted",
            standing.proven
        ));
        let sender = Sender::resuming(Arc::clone(&program), settings.clone(), &standing);
        let journal = JournalFile::reopen(&path)?;
        let outcome = Stream::new(sender, opened, self::place(port, job, args), journal, console).run()?;
        let Outcome::Stopped(why @ (Stop::Reset { .. } | Stop::Counter { .. })) = &outcome else {
            return ended(outcome);
        };
        console.note(&why.to_string());
        opened = Port::open(&place.address, place.baud)?;
    }
    let entry = reentry(job, &program, &settings, &journal_file::read(&path)?, console)?;
    agree(&entry, args, console)?;
    let mut journal = JournalFile::reopen(&path)?;
    journal.record(&Record::Entering);
    journal.record(&Record::Anew);
    let sender = Sender::reentering(program, settings, &entry.lines, entry.block);
    ended(Stream::new(sender, opened, place, journal, console).run()?)
}

fn place(port: &str, job: &Job<'_>, args: &StreamArgs) -> Place {
    let address = Address::parse(port);
    let identity = match &address {
        Address::Device(path) => identity(path, &args.devices),
        Address::Tcp(_) => None,
    };
    Place {
        baud: args.baud.unwrap_or(job.machine.profile.link.baud),
        identity,
        devices: args.devices.clone(),
        wait: Duration::from_secs(args.wait),
        address,
    }
}

fn header(job: &Job<'_>, place: &Place) -> Header {
    Header {
        sha256: sha256_hex(job.bytes),
        bytes: job.bytes.len() as u64,
        path: job.path.display().to_string(),
        profile_sha256: job.machine.sha256.clone(),
        profile: job.machine.name.clone(),
        device: place.identity.clone().unwrap_or_default(),
        boot: journal_file::boot(),
    }
}

/// Puts the journal of an unfinished print aside.
fn broken_off(path: &Path) -> Option<PathBuf> {
    let unfinished = journal_file::read(path).is_ok_and(|s| s.began() && !s.done);
    unfinished.then(|| files::set_aside(path)).flatten()
}

/// What the journal says, if it is this job's.
fn standing(job: &Job<'_>, path: &Path) -> Result<Standing, Failure> {
    let standing = journal_file::read(path)?;
    let name = job.path.display();
    if standing.header.sha256 != sha256_hex(job.bytes) {
        return Err(Failure::Usage(format!(
            "{name}: the file has changed since the print began ({} bytes then, {} now); what was printed cannot be matched to it",
            standing.header.bytes,
            job.bytes.len()
        )));
    }
    if standing.header.profile_sha256 != job.machine.sha256 {
        return Err(Failure::Usage(format!(
            "profile {} has changed since the print began; give the same one",
            job.machine.name
        )));
    }
    if standing.done {
        return Err(Failure::Usage(format!("{name}: this print has ended; there is nothing to go on with")));
    }
    Ok(standing)
}

fn reentry(
    job: &Job<'_>,
    program: &Program,
    settings: &crate::link::Settings,
    standing: &Standing,
    console: &Console,
) -> Result<Reentry, Failure> {
    if settings.protocol == Protocol::Grbl {
        return Err(Failure::Printer(
            "a print cannot go on after a reset of Grbl: it has no line counter to ask".to_owned(),
        ));
    }
    let answered = standing.answered.max(standing.next_block(standing.proven));
    let found = Reentry::find(program, &settings.reading, &settings.retreat, answered, settings.protocol);
    let entry = found.map_err(|e| Failure::Printer(e.to_string()))?;
    for words in &entry.words {
        console.note(&format!("  {words}"));
    }
    if job.plan.is_none() {
        console.warning("without --plan nothing proves that the way back to the part is clear");
    }
    prove_way(job, program, &entry, printed_at_most(program, settings, standing))?;
    Ok(entry)
}

/// The last block that can have been printed.
///
/// Where a run begins is written down before it is sent, and a run ends with the next proof. A host that lost its power may
/// have lost the journal's end too: what the printer can execute in [`UNWRITTEN_S`] is added.
fn printed_at_most(program: &Program, settings: &crate::link::Settings, standing: &Standing) -> u32 {
    let mut last = standing.reach.saturating_add(settings.prove_every);
    let mut left = if standing.header.boot == journal_file::boot() { 0.0 } else { UNWRITTEN_S };
    while left > 0.0 && last < program.len() {
        left -= program.seconds(last);
        last += 1;
    }
    last.min(program.len().saturating_sub(1))
}

/// The way down to the part and what is printed again there, replayed behind everything up to block `printed`.
fn prove_way(job: &Job<'_>, program: &Program, entry: &Reentry, printed: u32) -> Result<(), Failure> {
    let (Some(plan), Some(workpiece)) = (job.plan, job.workpiece) else { return Ok(()) };
    let last = program.file_line(printed);
    let text = way_text(job.bytes, last, entry);
    let report = verify(&text, &Proof { profile: &job.machine.profile, plan, workpiece });
    let hits =
        |r: Rule| matches!(r, Rule::HeadCollision | Rule::TurnCollision | Rule::AxisLimit | Rule::UnknownPosition);
    match report.findings.iter().find(|f| f.line > last && hits(f.rule)) {
        Some(f) => Err(Failure::Printer(format!("the way back to the part is not clear: {}", f.text))),
        None => Ok(()),
    }
}

/// Lines up to `last`, our own way back, and the lines between once more: they go where material may stand already.
fn way_text(file: &[u8], last: u32, entry: &Reentry) -> Vec<u8> {
    let mut text = Vec::with_capacity(file.len());
    let mut again = Vec::new();
    for line in crate::gcode::lines(file).take_while(|l| l.number <= last) {
        let repeated = line.number >= entry.file_line;
        for part in std::iter::once(&mut text).chain(repeated.then_some(&mut again)) {
            part.extend_from_slice(line.bytes);
            part.push(b'\n');
        }
    }
    let moves = |l: &&String| ["G1", "G90", "G91", "G93", "G94"].iter().any(|g| l.starts_with(g));
    // What is pulled and primed is none of the file's filament.
    for line in entry.lines.iter().filter(moves).filter(|l| !l.contains('E')) {
        text.extend_from_slice(line.as_bytes());
        text.push(b'\n');
    }
    text.extend_from_slice(&again);
    text
}

/// Nothing moves before somebody has agreed.
fn agree(entry: &Reentry, args: &StreamArgs, console: &Console) -> Result<(), Failure> {
    if args.yes {
        return Ok(());
    }
    let refused =
        || Failure::Printer(format!("nothing was moved; --yes goes on at line {} as said above", entry.file_line));
    if !std::io::stdin().is_terminal() {
        return Err(refused());
    }
    console.note("type yes to do so:");
    let mut text = String::new();
    let read = std::io::stdin().lock().read_line(&mut text);
    if read.is_ok() && text.trim() == "yes" { Ok(()) } else { Err(refused()) }
}

fn ended(outcome: Outcome) -> Result<(), Failure> {
    match outcome {
        Outcome::Done => Ok(()),
        Outcome::Cancelled => Err(Failure::Printer("cancelled".to_owned())),
        Outcome::EmergencyStopped => Err(Failure::Printer("emergency stop; reset the printer".to_owned())),
        Outcome::Stopped(why) => Err(Failure::Printer(why.to_string())),
    }
}
