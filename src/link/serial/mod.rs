//! Ports: serial devices, TCP addresses, and the pseudo-terminal of the simulated printer.
//!
//! Reads and writes never wait, so that neither a full nor a silent port can hold up the other direction: one thread does
//! both and sleeps in one `poll` for either. A serial device is opened for us alone, without hanging up when it is closed
//! (HUPCL off), because DTR falling resets many boards. `serialport` is used without `libudev`; devices are told apart by
//! `/dev/serial/by-id`.
//!
//! The only place of this room that touches the world.

#[cfg(unix)]
mod line;
mod server;
#[cfg(any(test, not(unix)))]
mod threads;

use std::io::ErrorKind;
use std::net::{TcpStream, ToSocketAddrs};
use std::path::{Path, PathBuf};
use std::time::Duration;

#[cfg(unix)]
use line::{Line, Native, Side, side_door};
pub use server::Server;
#[cfg(not(unix))]
use threads::{Line, Native, Side, side_door};

/// A read or write gives up after this, to see whether the port is still wanted.
const PATIENCE: Duration = Duration::from_millis(100);

/// A place in the net that does not answer within this is not there.
const CONNECT: Duration = Duration::from_secs(2);

/// Where a printer is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Address {
    /// A device or a link to one.
    Device(PathBuf),
    /// `tcp:host:port`.
    Tcp(String),
}

impl Address {
    /// `tcp:host:port`, anything else is a path.
    pub fn parse(text: &str) -> Self {
        match text.strip_prefix("tcp:") {
            Some(address) => Self::Tcp(address.to_owned()),
            None => Self::Device(PathBuf::from(text)),
        }
    }
}

impl std::fmt::Display for Address {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Device(path) => path.display().fmt(f),
            Self::Tcp(address) => write!(f, "tcp:{address}"),
        }
    }
}

/// Why a port cannot be opened.
#[derive(Debug, thiserror::Error, strum::IntoStaticStr)]
#[strum(serialize_all = "kebab-case", prefix = "port/")]
pub enum PortError {
    /// A device that does not exist.
    #[error("{}: no such port; is the printer switched on and plugged in? ports now: {}", path.display(), list(ports))]
    Missing {
        /// As asked for.
        path: PathBuf,
        /// What is there.
        ports: Vec<String>,
    },
    /// Held by another program.
    #[error("{}: in use by another program (such as OctoPrint, a slicer or another trunnion); close it first", path.display())]
    Busy {
        /// As asked for.
        path: PathBuf,
    },
    /// Not for this user.
    #[error(
        "{}: permission denied; on Debian and Ubuntu: sudo adduser $USER dialout, then log in again",
        path.display()
    )]
    Denied {
        /// As asked for.
        path: PathBuf,
    },
    /// A port that the system does not open for another reason.
    #[error("{}: cannot open the port: {why}", path.display())]
    Other {
        /// As asked for.
        path: PathBuf,
        /// The system's words.
        why: String,
    },
    /// A pseudo-terminal for the simulated printer, or the link to it, that cannot be made.
    #[error("{}: cannot create this link to a pseudo-terminal: {why}; use {}tcp:127.0.0.1:PORT", path.display(), if cfg!(unix) { "another path, or " } else { "" })]
    PseudoTerminal {
        /// The link, as asked for.
        path: PathBuf,
        /// The system's words.
        why: String,
    },
    /// Nothing listens at the address.
    #[error("tcp:{address}: {why}")]
    Tcp {
        /// As asked for.
        address: String,
        /// The system's words.
        why: String,
    },
}

fn list(ports: &[String]) -> String {
    if ports.is_empty() { "none".to_owned() } else { ports.join(", ") }
}

/// What a port has to say.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Heard<'a> {
    /// Bytes.
    Bytes(&'a [u8]),
    /// The other end is gone.
    Gone(String),
    /// Not a byte in the time given.
    Nothing,
}

#[cfg(unix)]
type Hand = Side;
#[cfg(not(unix))]
type Hand = std::io::Sink;

/// Another hand on an open port: it only writes.
#[derive(Debug)]
pub struct Twin(Hand);

impl Twin {
    /// Writes what the port takes at once.
    pub fn write(&mut self, bytes: &[u8]) {
        use std::io::Write;
        let _ = self.0.write(bytes);
    }
}

/// An open port; closed when dropped.
#[derive(Debug)]
pub struct Port {
    line: Line,
    buffer: Box<[u8]>,
    gone: Option<String>,
}

impl Port {
    /// Opens a device or a TCP address.
    ///
    /// # Errors
    ///
    /// [`PortError`] with what to do.
    pub fn open(address: &Address, baud: u32) -> Result<Self, PortError> {
        match address {
            Address::Device(path) => Self::device(path, baud),
            Address::Tcp(address) => {
                let failed = |e: std::io::Error| PortError::Tcp { address: address.clone(), why: e.to_string() };
                let stream = reached(address).map_err(failed)?;
                Self::stream(stream).map_err(failed)
            }
        }
    }

    /// Another hand on the same port, for the words that can wait for nothing; `None` where the system has none.
    #[cfg(unix)]
    pub fn twin(&self) -> Option<Twin> {
        self.line.twin().map(Twin)
    }

    /// Another hand on the same port: this system has none.
    #[cfg(not(unix))]
    pub fn twin(&self) -> Option<Twin> {
        None
    }

    fn device(path: &Path, baud: u32) -> Result<Self, PortError> {
        if let Err(error) = std::fs::metadata(path) {
            return Err(port_error(path, error.kind(), error.to_string()));
        }
        let mut doors = both(path, baud);
        if matches!(doors, Err(PortError::Busy { .. })) {
            // A program that has just ended may not have let go yet.
            std::thread::sleep(PATIENCE * 3);
            doors = both(path, baud);
        }
        let (side, locked) = doors?;
        Line::device(side, locked).map(Self::over).map_err(|e| port_error(path, e.kind(), e.to_string()))
    }

    fn stream(stream: TcpStream) -> std::io::Result<Self> {
        stream.set_nodelay(true)?;
        Line::stream(stream).map(Self::over)
    }

    fn over(line: Line) -> Self {
        Self { line, buffer: vec![0; 16_384].into(), gone: None }
    }

    /// What has arrived, waiting up to `wait` for it; where `full`, also until [`Port::write`] may take something again.
    pub fn read(&mut self, wait: Duration, full: bool) -> Heard<'_> {
        if let Some(why) = self.gone.take() {
            return Heard::Gone(why);
        }
        if !wait.is_zero() && !self.line.wait(wait, full) {
            return Heard::Nothing;
        }
        match self.line.read(&mut self.buffer) {
            Ok(0) => Heard::Gone("the other end closed".to_owned()),
            Ok(n) => Heard::Bytes(&self.buffer[..n]),
            Err(e) if is_patience(&e) => Heard::Nothing,
            Err(e) => Heard::Gone(e.to_string()),
        }
    }

    /// Hands over the beginning of `bytes` without waiting; how many were taken.
    pub fn write(&mut self, bytes: &[u8]) -> usize {
        if bytes.is_empty() || self.gone.is_some() {
            return 0;
        }
        match self.line.write(bytes) {
            Ok(n) => n,
            Err(e) if is_patience(&e) => 0,
            Err(e) => {
                self.gone = Some(e.to_string());
                0
            }
        }
    }
}

/// The first of an address' places that answers in time; a place that swallows everything would hold up an emergency stop for
/// minutes.
fn reached(address: &str) -> std::io::Result<TcpStream> {
    let mut last = std::io::Error::from(ErrorKind::AddrNotAvailable);
    for place in address.to_socket_addrs()? {
        match TcpStream::connect_timeout(&place, CONNECT) {
            Ok(stream) => return Ok(stream),
            Err(e) => last = e,
        }
    }
    Err(last)
}

/// The device twice: the side door before the lock, which would keep ourselves out.
fn both(path: &Path, baud: u32) -> Result<(Side, Native), PortError> {
    let side = side_door(path).map_err(|e| port_error(path, e.kind(), e.to_string()))?;
    Ok((side, locked(path, baud)?))
}

/// The device opened for us alone, at its speed.
fn locked(path: &Path, baud: u32) -> Result<Native, PortError> {
    let asked = serialport::new(path.to_string_lossy(), baud).timeout(PATIENCE).preserve_dtr_on_open();
    asked.open_native().map_err(|e| open_error(path, &e))
}

fn is_patience(error: &std::io::Error) -> bool {
    matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::WouldBlock | ErrorKind::Interrupted)
}

fn open_error(path: &Path, error: &serialport::Error) -> PortError {
    let text = error.to_string();
    match error.kind() {
        serialport::ErrorKind::NoDevice
            if text.contains("busy") || text.contains("lock") || text.contains("temporarily") =>
        {
            PortError::Busy { path: path.to_owned() }
        }
        serialport::ErrorKind::Io(kind) => port_error(path, kind, text),
        serialport::ErrorKind::NoDevice => port_error(path, ErrorKind::NotFound, text),
        _ => PortError::Other { path: path.to_owned(), why: plainer(text) },
    }
}

/// The system calls what is no terminal "not a typewriter", and a control of it "inappropriate".
fn plainer(why: String) -> String {
    let no_terminal = ["Not a typewriter", "Inappropriate ioctl"].iter().any(|words| why.contains(words));
    if no_terminal { "it is a file or another kind of device, not a serial port".to_owned() } else { why }
}

fn port_error(path: &Path, kind: ErrorKind, why: String) -> PortError {
    let path = path.to_owned();
    match kind {
        ErrorKind::NotFound => PortError::Missing { path, ports: ports() },
        ErrorKind::PermissionDenied => PortError::Denied { path },
        ErrorKind::ResourceBusy | ErrorKind::WouldBlock => PortError::Busy { path },
        _ if why.contains("busy") || why.contains("lock") => PortError::Busy { path },
        _ => PortError::Other { path, why: plainer(why) },
    }
}

/// The serial devices that are there now.
pub fn ports() -> Vec<String> {
    let mut found: Vec<String> =
        serialport::available_ports().unwrap_or_default().into_iter().map(|p| p.port_name).collect();
    found.sort();
    found
}

/// The name under which `folder` (`/dev/serial/by-id`) has the device at `path`; `None` where it has none.
pub fn identity(path: &Path, folder: &Path) -> Option<String> {
    let device = std::fs::canonicalize(path).ok()?;
    let entries = std::fs::read_dir(folder).ok()?;
    let mut names = entries.filter_map(|e| {
        let entry = e.ok()?;
        (std::fs::canonicalize(entry.path()).ok()? == device).then(|| entry.file_name().to_string_lossy().into_owned())
    });
    names.next()
}

/// The address at which a device is to be found again: by its identity, if it has one, else where it was.
///
/// Where its identity is not there yet, neither is the device: the path that it had may be another printer's by now.
pub fn find_again(address: &Address, identity: Option<&str>, folder: &Path) -> Address {
    identity.map_or_else(|| address.clone(), |name| Address::Device(folder.join(name)))
}
