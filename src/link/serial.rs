//! Ports: serial devices, TCP addresses, and the pseudo-terminal of the simulated printer.
//!
//! A reader and a writer thread stand between a port and its channels, so that neither a full nor a silent port can hold up
//! the other direction. A serial device is opened for us alone, without hanging up when it is closed (HUPCL off), because
//! DTR falling resets many boards. `serialport` is used without `libudev`; devices are told apart by `/dev/serial/by-id`.
//!
//! The only place of this room that touches the world.

use std::io::{ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use crossbeam_channel::{Receiver, Sender, TrySendError, bounded, unbounded};

/// A read or write gives up after this, to see whether the port is still wanted.
const PATIENCE: Duration = Duration::from_millis(100);
/// The largest piece that is handed to the writer: an emergency stop waits for one at most.
const PIECE: usize = 256;

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

/// Why a port cannot be opened.
#[derive(Debug, thiserror::Error)]
pub enum PortError {
    /// No such device.
    #[error("{}: no such port; is the printer switched on and plugged in? ports now: {}", path.display(), list(ports))]
    Missing {
        /// As asked for.
        path: PathBuf,
        /// What is there.
        ports: Vec<String>,
    },
    /// Held by another program.
    #[error("{}: held by another program (OctoPrint, a slicer, another trunnion?); end it first", path.display())]
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
    /// Not a port.
    #[error("{}: not a serial port: {why}", path.display())]
    Other {
        /// As asked for.
        path: PathBuf,
        /// The system's words.
        why: String,
    },
    /// Nobody listens.
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
pub enum Incoming {
    /// Bytes.
    Bytes(Vec<u8>),
    /// The other end is gone.
    Gone(String),
}

/// An open port; closed when dropped.
#[derive(Debug)]
pub struct Port {
    incoming: Receiver<Incoming>,
    outgoing: Sender<Vec<u8>>,
    urgent: Sender<Vec<u8>>,
    closed: Arc<AtomicBool>,
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
                let stream = TcpStream::connect(address).map_err(failed)?;
                Self::stream(stream).map_err(failed)
            }
        }
    }

    fn device(path: &Path, baud: u32) -> Result<Self, PortError> {
        let file_kind = std::fs::metadata(path);
        if let Err(error) = &file_kind {
            return Err(port_error(path, error.kind(), error.to_string()));
        }
        keep_line_up(path);
        let asked = serialport::new(path.to_string_lossy(), baud).timeout(PATIENCE).preserve_dtr_on_open();
        let mut open = asked.open_native().map_err(|e| open_error(path, &e));
        if matches!(open, Err(PortError::Busy { .. })) {
            // A program that has just ended may not have let go yet.
            std::thread::sleep(PATIENCE * 3);
            open = serialport::new(path.to_string_lossy(), baud)
                .timeout(PATIENCE)
                .preserve_dtr_on_open()
                .open_native()
                .map_err(|e| open_error(path, &e));
        }
        let port = open?;
        let clone = serialport::SerialPort::try_clone(&port).map_err(|e| open_error(path, &e))?;
        Ok(Self::threads(port, clone))
    }

    fn stream(stream: TcpStream) -> std::io::Result<Self> {
        stream.set_nodelay(true)?;
        stream.set_read_timeout(Some(PATIENCE))?;
        stream.set_write_timeout(Some(PATIENCE))?;
        let clone = stream.try_clone()?;
        Ok(Self::threads(stream, clone))
    }

    fn threads(reader: impl Read + Send + 'static, writer: impl Write + Send + 'static) -> Self {
        let (to_host, incoming) = unbounded();
        let (outgoing, from_host) = bounded(1);
        let (urgent, first) = bounded(4);
        let closed = Arc::new(AtomicBool::new(false));
        let (one, two) = (Arc::clone(&closed), Arc::clone(&closed));
        let gone = to_host.clone();
        std::thread::spawn(move || read_all(reader, &to_host, &one));
        std::thread::spawn(move || write_all(writer, &from_host, &first, &gone, &two));
        Self { incoming, outgoing, urgent, closed }
    }

    /// What arrives.
    pub fn incoming(&self) -> &Receiver<Incoming> {
        &self.incoming
    }

    /// Hands over the beginning of `bytes` without waiting; how many were taken.
    pub fn write(&self, bytes: &[u8]) -> usize {
        let piece = &bytes[..bytes.len().min(PIECE)];
        if piece.is_empty() {
            return 0;
        }
        match self.outgoing.try_send(piece.to_vec()) {
            Ok(()) => piece.len(),
            Err(TrySendError::Full(_) | TrySendError::Disconnected(_)) => 0,
        }
    }

    /// Hands over bytes that come before everything else that waits here.
    pub fn write_first(&self, bytes: &[u8]) {
        let _ = self.urgent.try_send(bytes.to_vec());
    }

    /// Whether everything that was handed over has left for the device.
    pub fn is_drained(&self) -> bool {
        self.outgoing.is_empty() && self.urgent.is_empty()
    }
}

impl Drop for Port {
    fn drop(&mut self) {
        self.closed.store(true, Ordering::Relaxed);
    }
}

fn read_all(mut reader: impl Read, to_host: &Sender<Incoming>, closed: &AtomicBool) {
    let mut buffer = [0_u8; 4096];
    while !closed.load(Ordering::Relaxed) {
        match reader.read(&mut buffer) {
            Ok(0) => return gone(to_host, "the other end closed"),
            Ok(n) => {
                if to_host.send(Incoming::Bytes(buffer[..n].to_vec())).is_err() {
                    return;
                }
            }
            Err(e) if is_patience(&e) => {}
            Err(e) => return gone(to_host, &e.to_string()),
        }
    }
}

fn write_all(
    mut writer: impl Write,
    bytes: &Receiver<Vec<u8>>,
    first: &Receiver<Vec<u8>>,
    to_host: &Sender<Incoming>,
    closed: &AtomicBool,
) {
    loop {
        let mut piece = crossbeam_channel::select_biased! {
            recv(first) -> piece => match piece { Ok(piece) => piece, Err(_) => return },
            recv(bytes) -> piece => match piece { Ok(piece) => piece, Err(_) => return },
        };
        while !piece.is_empty() {
            if closed.load(Ordering::Relaxed) {
                return;
            }
            if let Ok(urgent) = first.try_recv() {
                // What is left of the piece is worth nothing any more.
                piece = urgent;
            }
            match writer.write(&piece) {
                Ok(0) => return gone(to_host, "the other end takes nothing"),
                Ok(n) => drop(piece.drain(..n)),
                Err(e) if is_patience(&e) => {}
                Err(e) => return gone(to_host, &e.to_string()),
            }
        }
    }
}

fn gone(to_host: &Sender<Incoming>, why: &str) {
    let _ = to_host.send(Incoming::Gone(why.to_owned()));
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
        _ => PortError::Other { path: path.to_owned(), why: text },
    }
}

fn port_error(path: &Path, kind: ErrorKind, why: String) -> PortError {
    let path = path.to_owned();
    match kind {
        ErrorKind::NotFound => PortError::Missing { path, ports: ports() },
        ErrorKind::PermissionDenied => PortError::Denied { path },
        ErrorKind::ResourceBusy | ErrorKind::WouldBlock => PortError::Busy { path },
        _ if why.contains("busy") || why.contains("lock") => PortError::Busy { path },
        _ => PortError::Other { path, why },
    }
}

/// The serial devices that are there now.
pub fn ports() -> Vec<String> {
    let mut found: Vec<String> =
        serialport::available_ports().unwrap_or_default().into_iter().map(|p| p.port_name).collect();
    found.sort();
    found
}

/// Keeps the modem lines up when the device is closed: DTR falling resets many boards.
#[cfg(unix)]
fn keep_line_up(path: &Path) {
    use rustix::fs::{Mode, OFlags};
    use rustix::termios::{ControlModes, OptionalActions, tcgetattr, tcsetattr};
    let Ok(device) =
        rustix::fs::open(path, OFlags::RDWR | OFlags::NOCTTY | OFlags::NONBLOCK | OFlags::CLOEXEC, Mode::empty())
    else {
        return;
    };
    if let Ok(mut modes) = tcgetattr(&device) {
        modes.control_modes -= ControlModes::HUPCL;
        // A device that cannot do this is none the worse.
        let _ = tcsetattr(&device, OptionalActions::Now, &modes);
    }
}

#[cfg(not(unix))]
fn keep_line_up(_path: &Path) {}

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

/// The address at which a device is to be found again: by its identity wherever it is now, else where it was.
pub fn find_again(address: &Address, identity: Option<&str>, folder: &Path) -> Address {
    let again = identity.map(|name| folder.join(name)).filter(|path| path.exists());
    match again {
        Some(path) => Address::Device(path),
        None => address.clone(),
    }
}

/// The printer's end of a simulated wire.
pub enum Server {
    /// A pseudo-terminal behind a link.
    #[cfg(unix)]
    Pty(Pty),
    /// A TCP address, one host at a time.
    Tcp(TcpListener),
}

/// A pseudo-terminal and the link to it; the link goes when dropped.
#[cfg(unix)]
#[derive(Debug)]
pub struct Pty {
    link: PathBuf,
    master: std::fs::File,
    /// Held open, so that a host that leaves does not end the terminal.
    _slave: std::fs::File,
    /// Where the device is now.
    pub device: PathBuf,
}

#[cfg(unix)]
impl Drop for Pty {
    fn drop(&mut self) {
        if std::fs::read_link(&self.link).is_ok_and(|to| to == self.device) {
            let _ = std::fs::remove_file(&self.link);
        }
    }
}

#[cfg(unix)]
impl Pty {
    fn open(link: &Path) -> std::io::Result<Self> {
        use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
        use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};
        use std::os::unix::ffi::OsStrExt;
        let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC)?;
        grantpt(&master)?;
        unlockpt(&master)?;
        let name = ptsname(&master, Vec::new())?;
        let device = PathBuf::from(std::ffi::OsStr::from_bytes(name.to_bytes()));
        let slave = std::fs::OpenOptions::new().read(true).write(true).open(&device)?;
        let mut modes = tcgetattr(&slave)?;
        modes.make_raw();
        tcsetattr(&slave, OptionalActions::Now, &modes)?;
        if std::fs::symlink_metadata(link).is_ok_and(|m| m.is_symlink()) {
            std::fs::remove_file(link)?;
        }
        std::os::unix::fs::symlink(&device, link)?;
        Ok(Self { link: link.to_owned(), master: std::fs::File::from(master), _slave: slave, device })
    }
}

/// A read that comes back after a while: a pseudo-terminal's master knows no time-out of its own.
#[cfg(unix)]
struct Patient(std::fs::File);

#[cfg(unix)]
impl Read for Patient {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        use rustix::event::{PollFd, PollFlags, Timespec, poll};
        let wait = Timespec { tv_sec: 0, tv_nsec: 100_000_000 };
        let mut fds = [PollFd::new(&self.0, PollFlags::IN)];
        if poll(&mut fds, Some(&wait))? == 0 {
            return Err(ErrorKind::TimedOut.into());
        }
        self.0.read(buffer)
    }
}

impl Server {
    /// A pseudo-terminal behind the link `text`, or `tcp:host:port` (a bare `tcp:port` listens on this machine only).
    ///
    /// # Errors
    ///
    /// The system's, with the address.
    pub fn open(text: &str) -> Result<Self, PortError> {
        let address = Address::parse(text);
        match &address {
            Address::Tcp(at) => {
                let at = if at.contains(':') { at.clone() } else { format!("127.0.0.1:{at}") };
                let listener =
                    TcpListener::bind(&at).map_err(|e| PortError::Tcp { address: at.clone(), why: e.to_string() })?;
                Ok(Self::Tcp(listener))
            }
            #[cfg(unix)]
            Address::Device(link) => {
                Pty::open(link).map(Self::Pty).map_err(|e| PortError::Other { path: link.clone(), why: e.to_string() })
            }
            #[cfg(not(unix))]
            Address::Device(link) => {
                Err(PortError::Other { path: link.clone(), why: "give tcp:127.0.0.1:PORT here".to_owned() })
            }
        }
    }

    /// Where hosts find it.
    pub fn place(&self) -> String {
        match self {
            #[cfg(unix)]
            Self::Pty(pty) => pty.device.display().to_string(),
            Self::Tcp(listener) => listener.local_addr().map_or(String::new(), |a| format!("tcp:{a}")),
        }
    }

    /// The wire to the host: at once on a pseudo-terminal; on TCP `WouldBlock` until a host has come.
    ///
    /// # Errors
    ///
    /// The system's.
    pub fn connect(&self) -> std::io::Result<Port> {
        match self {
            #[cfg(unix)]
            Self::Pty(pty) => Ok(Port::threads(Patient(pty.master.try_clone()?), pty.master.try_clone()?)),
            Self::Tcp(listener) => {
                listener.set_nonblocking(true)?;
                let stream = listener.accept()?.0;
                stream.set_nonblocking(false)?;
                Port::stream(stream)
            }
        }
    }
}
