//! A proved program to the server that drives a printer.

use std::cell::RefCell;
use std::path::Path;
use std::time::Duration;

use crate::gcode::marks::{Hint, hint};
use crate::input::LoadedProfile;
use crate::job::print::Verified;
use crate::planning::sha256_hex;
use crate::publish::{
    Ask, BadInput, Delivered, Delivery, Fingerprint, Key, PublishError, ServerAddress, ServerAnswer, Trouble,
    UploadFigures, Web, deliver, file_name,
};
use crate::world::{FileError, World};

/// Why a program is not at its server.
#[derive(Debug, thiserror::Error)]
pub enum UploadError {
    /// A file that is not read.
    #[error(transparent)]
    File(#[from] FileError),
    /// A server, a key or a name that cannot be.
    #[error(transparent)]
    Asked(#[from] BadInput),
    /// A server that does not take a program.
    #[error(transparent)]
    Server(#[from] PublishError),
}

impl UploadError {
    /// What stands for it in documents, for good.
    pub fn code(&self) -> &'static str {
        match self {
            Self::File(error) => error.into(),
            Self::Asked(error) => error.into(),
            Self::Server(error) => (&error.fault).into(),
        }
    }
}

/// A program and where it goes.
#[derive(Clone, Copy, Debug)]
pub struct PublishRequest<'a> {
    /// The program's file.
    pub path: &'a Path,
    /// The program.
    pub program: &'a Verified<Vec<u8>>,
    /// The machine that it was proved for; `None` for an unverified program, whose firmware nobody knows.
    pub machine: Option<&'a LoadedProfile>,
    /// The server.
    pub to: &'a ServerAddress,
    /// What opens it.
    pub key: Option<&'a Key>,
    /// What the file is called there; `None`: as here.
    pub name: Option<&'a str>,
    /// Whether another file of that name is replaced.
    pub replace: bool,
    /// Whether it is printed.
    pub start: bool,
    /// How long the server may say nothing.
    pub silence: Duration,
    /// The only certificate that is taken; `None`: what this computer's authorities vouch for.
    pub fingerprint: Option<Fingerprint>,
}

/// What is there now.
#[derive(Clone, Debug, PartialEq)]
pub struct PublishResult {
    /// The server.
    pub to: ServerAddress,
    /// The file's name there.
    pub name: String,
    /// Its size.
    pub bytes: usize,
    /// Its SHA-256, which is that of what is there: the server's hash or its bytes were compared.
    pub sha256: String,
    /// Whether a replay has proved it.
    pub verified: bool,
    /// What we say that it takes; nothing but layers where there was no replay.
    pub stated: UploadFigures,
    /// What became of it.
    pub delivered: Delivered,
    /// What that took, s.
    pub seconds: f64,
}

/// Brings a program to a server, once, and compares what arrived.
///
/// # Errors
///
/// [`UploadError::Asked`] for a name that servers would change, an address that the world cannot reach or a server of another firmware,
/// and [`UploadError::Server`].
pub fn publish(request: &PublishRequest<'_>, world: &World<'_>) -> Result<PublishResult, UploadError> {
    request.to.clone().reached_by(world.web)?;
    if let Some(machine) = request.machine {
        request.to.kind.takes(machine.profile.firmware(), &machine.name)?;
    }
    let own = || request.path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let name = request.name.map_or_else(own, str::to_owned);
    file_name(&name)?;
    let (file, report) = (request.program.program(), request.program.report());
    let is_layer = |line: &&[u8]| line.strip_prefix(b";").and_then(hint) == Some(Hint::Layer);
    let stated = UploadFigures {
        seconds: report.map(|report| report.seconds_print),
        filament_mm: report.map(|report| report.filament_mm),
        layers: Some(file.split(|b| *b == b'\n').filter(is_layer).count() as u64),
    };
    let begun = world.clock.now();
    let job = Delivery {
        address: request.to.clone(),
        key: request.key.cloned(),
        name,
        file,
        sha256: sha256_hex(file),
        sha1: sha1_hex(file),
        verified: report.is_some(),
        stated,
        replace: request.replace,
        start: request.start,
        silence: request.silence,
        fingerprint: request.fingerprint,
        firmware: request.machine.map(|machine| machine.profile.firmware()),
    };
    let bar = RefCell::new(world.progress.begin("uploading", file.len()));
    let delivered = deliver(&job, &Waiting(world), &|sent| bar.borrow().at(sent.min(file.len())))?;
    Ok(PublishResult {
        to: job.address,
        name: job.name,
        bytes: file.len(),
        sha256: job.sha256,
        verified: job.verified,
        stated,
        delivered,
        seconds: (world.clock.now() - begun).as_secs_f64(),
    })
}

/// Reads `octoprint:URL`, `moonraker:URL` or `duet:URL`, an address that the world can reach.
///
/// # Errors
///
/// [`UploadError::Asked`].
pub fn server_address(text: &str, world: &World<'_>) -> Result<ServerAddress, UploadError> {
    Ok(ServerAddress::parse(text)?.reached_by(world.web)?)
}

fn sha1_hex(bytes: &[u8]) -> String {
    use sha1::{Digest, Sha1};
    Sha1::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The key in a file, or else the one that the environment has; `None` where there is neither.
///
/// # Errors
///
/// [`UploadError::Asked`] for what is no key, and what keeps the file from being read.
pub fn server_key(
    file: Option<&Path>,
    environment: Option<&str>,
    world: &World<'_>,
) -> Result<Option<Key>, UploadError> {
    if let Some(path) = file {
        let place = path.display().to_string();
        let bytes = world.files.read(path)?;
        return Ok(Some(Key::new(&String::from_utf8_lossy(&bytes), &place)?));
    }
    Ok(environment.map(|text| Key::new(text, "TRUNNION_KEY")).transpose()?)
}

/// The world's web, which waits by the world's clock.
struct Waiting<'a>(&'a World<'a>);

impl Web for Waiting<'_> {
    fn ask(&self, ask: &Ask<'_>, sent: &dyn Fn(usize)) -> Result<ServerAnswer, Trouble> {
        self.0.web.ask(ask, sent)
    }

    fn wait(&self, time: Duration) {
        self.0.clock.sleep(time);
    }

    fn speaks_tls(&self) -> bool {
        self.0.web.speaks_tls()
    }
}
