//! What is proved is sent to a printer, once; what is interrupted can be resumed.

mod again;
mod desk;
mod error;
mod figures;
mod operator;
mod rehearsal;
mod several;
mod stream;
mod together;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use crate::input::{BadSetting, CheckedPlan, LoadedProfile};
use crate::job::print::Verified;
use crate::job::printer;
use crate::link::serial::{Address, Port};
use crate::link::{
    Accounting, Header, JournalSummary, LARGEST_FILE, Outcome, Program, ProgramError, Sender, SenderSettings, too_slow,
};
use crate::planning::sha256_hex;
use crate::profile::check_number;
use crate::world::{JournalFile, read_journal};
use crate::world::{OutputFile, World};
pub use again::resume;
pub use desk::Desk;
pub use error::SendError;
use figures::Timing;
pub use operator::{Answer, At, Figures, Operator, Sending, Unattended};
pub use rehearsal::{Rehearsal, rehearse};
pub use several::{EndedPrint, Loaded, SentPrint, send_several};
use stream::{Connection, Stream};
pub use together::desk;

/// A program on its way to a printer.
#[derive(Clone, Copy, Debug)]
pub struct SendRequest<'a> {
    /// The program's file, as messages and the journal call it.
    pub path: &'a Path,
    /// The program.
    pub program: &'a Verified<Vec<u8>>,
    /// The machine.
    pub machine: &'a LoadedProfile,
    /// The plan, against which a re-entry after a reset is proved; `None` for an unverified program.
    pub plan: Option<&'a CheckedPlan>,
    /// How to stream.
    pub options: &'a SendOptions,
}

/// How to stream.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SendOptions {
    /// Bits a second; `None`: the profile's.
    pub baud: Option<u32>,
    /// A device that has gone is waited for this long.
    pub wait: Duration,
    /// Where devices stand under their own names.
    pub devices: PathBuf,
    /// Somebody has looked at the part: it holds, though the bed may have cooled since the print was broken off.
    pub holds: bool,
    /// For a re-entry: the file's first line that is to be printed, from somebody who has looked at the part.
    pub from: Option<u32>,
}

impl Default for SendOptions {
    fn default() -> Self {
        Self {
            baud: None,
            wait: Duration::from_secs(600),
            devices: PathBuf::from("/dev/serial/by-id"),
            holds: false,
            from: None,
        }
    }
}

/// Where the printer is, and where what was sent is written down.
#[derive(Clone, Copy, Debug)]
pub struct Wire<'a> {
    /// The printer.
    pub address: &'a Address,
    /// The journal, from which an interrupted print is resumed.
    pub journal: &'a OutputFile,
}

/// Streams a program to a printer: every line once, in order, or a safe stop.
///
/// # Errors
///
/// [`SendError::Program`], [`SendError::Unfit`], [`PrinterError::Protocol`](crate::job::PrinterError::Protocol) and
/// [`InputError::Setting`](crate::input::InputError::Setting) before anything is sent;
/// [`PrinterError::Port`](crate::job::PrinterError::Port) and [`SendError::Printer`] where printer, wire or operator end the print.
pub fn send(
    request: &SendRequest<'_>,
    wire: &Wire<'_>,
    world: &World<'_>,
    operator: &dyn Operator,
) -> Result<(), SendError> {
    let (checked, port) = checked(request, wire, false, world)?.open(world)?;
    go(checked, port, request, wire, world, operator)
}

/// A print of which all is known to be well that can be known without its printer.
struct Checked {
    program: Arc<Program>,
    settings: SenderSettings,
    place: Connection,
    /// What its journal says, where it is to be resumed.
    standing: Option<JournalSummary>,
}

fn checked(request: &SendRequest<'_>, wire: &Wire<'_>, resumes: bool, world: &World<'_>) -> Result<Checked, SendError> {
    let program = program(request, world)?;
    let standing = resumes.then(|| again::standing(request, wire.journal.path(), &program)).transpose()?;
    let place = place(request, wire, &program, world);
    let settings = printer::settings(&request.machine.profile)?;
    // A network has no speed of its own.
    let wired = settings.protocol.traits().serial && matches!(wire.address, Address::Device(_));
    let settings = SenderSettings { baud: if wired { place.baud } else { 0 }, nonce: world.clock.nonce(), ..settings };
    Ok(Checked { program, settings, place, standing })
}

impl Checked {
    /// Opens its port; nothing is sent.
    fn open(self, world: &World<'_>) -> Result<(Self, Port), SendError> {
        let port = world.ports.open(&self.place.address, self.place.baud)?;
        Ok((self, port))
    }
}

/// Sends or resumes.
fn go(
    checked: Checked,
    port: Port,
    request: &SendRequest<'_>,
    wire: &Wire<'_>,
    world: &World<'_>,
    operator: &dyn Operator,
) -> Result<(), SendError> {
    operator.begin();
    if checked.standing.as_ref().is_some_and(JournalSummary::began) {
        return again::go_on(checked, port, request, wire, world, operator);
    }
    if checked.standing.is_some() && checked.settings.protocol.traits().accounting == Accounting::Counter {
        return again::ask_first(checked, port, request, wire, world, operator);
    }
    begin(checked, port, request, wire, world, operator)
}

/// Sends from the first line on.
fn begin(
    checked: Checked,
    port: Port,
    request: &SendRequest<'_>,
    wire: &Wire<'_>,
    world: &World<'_>,
    operator: &dyn Operator,
) -> Result<(), SendError> {
    let Checked { program, settings, place, .. } = checked;
    if let Some(journal) = broken_off(wire.journal)? {
        operator.told(&Sending::Aside { journal: &journal }, start(&program));
    }
    let journal = JournalFile::create(wire.journal, &header(request, &place, world))?;
    let sender = Sender::new(program, settings);
    ended(Stream::new(sender, port, place, journal, world, operator).run()?)
}

fn start(program: &Program) -> At {
    At { line: 0, of: program.file_line(program.len()) }
}

/// That a program has a size that can be sent; it need not be read for that.
///
/// # Errors
///
/// [`SendError::Program`], and what keeps a file from being read.
pub fn can_be_sent(path: &Path, world: &World<'_>) -> Result<(), SendError> {
    let bytes = world.files.size(path)?;
    if bytes > LARGEST_FILE {
        let source = ProgramError::TooBig { bytes, allowed: LARGEST_FILE };
        return Err(SendError::Program { path: path.to_owned(), source });
    }
    Ok(())
}

/// The file as blocks, after the checks that need no printer.
fn program(request: &SendRequest<'_>, world: &World<'_>) -> Result<Arc<Program>, SendError> {
    let (profile, baud) = (&request.machine.profile, request.options.baud);
    if let Some(baud) = baud {
        check_number("link.baud", f64::from(baud)).map_err(|source| BadSetting::Number { name: "baud", source })?;
    }
    let rules = printer::rules(profile)?;
    let path = || request.path.to_owned();
    let read = Program::read(request.program.program(), &rules);
    let program = read.map_err(|source| SendError::Program { path: path(), source })?;
    if let Some((line, why)) = &program.unknown {
        let source = ProgramError::Unfollowed { line: *line, why: why.clone() };
        return Err(SendError::Program { path: path(), source });
    }
    if let Some(unfit) = printer::abilities(profile).lacking(&program) {
        return Err(SendError::Unfit { path: path(), unfit });
    }
    if rules.protocol.traits().serial
        && let Some(slow) = too_slow(&program, rules.protocol, baud.unwrap_or(profile.link.baud))
    {
        world.progress.warning(&slow.to_string());
    }
    Ok(Arc::new(program))
}

fn place(request: &SendRequest<'_>, wire: &Wire<'_>, program: &Arc<Program>, world: &World<'_>) -> Connection {
    let options = request.options;
    let identity = match wire.address {
        Address::Device(path) => world.ports.identity(path, &options.devices),
        Address::Tcp(_) => None,
    };
    Connection {
        timing: Timing::of(program, &request.machine.profile),
        baud: options.baud.unwrap_or(request.machine.profile.link.baud),
        identity,
        devices: options.devices.clone(),
        wait: options.wait,
        address: wire.address.clone(),
    }
}

fn header(request: &SendRequest<'_>, place: &Connection, world: &World<'_>) -> Header {
    let program = request.program.program();
    Header {
        sha256: sha256_hex(program),
        bytes: program.len() as u64,
        path: request.path.display().to_string(),
        profile_sha256: request.machine.sha256.clone(),
        profile: request.machine.name.clone(),
        device: place.identity.clone().unwrap_or_default(),
        boot: world.clock.boot(),
    }
}

/// Puts the journal of an unfinished print aside.
fn broken_off(kept: &OutputFile) -> Result<Option<PathBuf>, SendError> {
    let unfinished = read_journal(kept.path()).is_ok_and(|s| s.began() && !s.done);
    if unfinished { Ok(kept.set_aside()?) } else { Ok(None) }
}

fn ended(outcome: Outcome) -> Result<(), SendError> {
    match outcome {
        Outcome::Done => Ok(()),
        Outcome::Cancelled => Err(SendError::Printer("cancelled".to_owned())),
        Outcome::EmergencyStopped => Err(SendError::Printer("emergency stop; reset the printer".to_owned())),
        Outcome::Stopped(why) => Err(SendError::Printer(why.to_string())),
    }
}
