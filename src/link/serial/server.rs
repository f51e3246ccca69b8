//! The printer's end of a simulated wire: a pseudo-terminal behind a link, or a TCP address.

use std::net::TcpListener;
#[cfg(unix)]
use std::path::Path;
use std::path::PathBuf;

#[cfg(unix)]
use super::Line;
use super::{Address, Port, PortError};

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
                let failed = |e: std::io::Error| PortError::PseudoTerminal { path: link.clone(), why: e.to_string() };
                Pty::open(link).map(Self::Pty).map_err(failed)
            }
            #[cfg(not(unix))]
            Address::Device(link) => {
                Err(PortError::PseudoTerminal { path: link.clone(), why: "not supported on this system".to_owned() })
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
            Self::Pty(pty) => Line::pty(pty.master.try_clone()?).map(Port::over),
            Self::Tcp(listener) => {
                listener.set_nonblocking(true)?;
                let stream = listener.accept()?.0;
                Port::stream(stream)
            }
        }
    }
}
