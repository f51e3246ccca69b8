//! A port without waiting: one file, read and written as far as it goes, and one `poll` for both directions.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::time::Duration;

pub(super) type Native = serialport::TTYPort;
pub(super) type Side = std::fs::File;

/// A port's two directions, neither of which can hold up the other: nothing here waits but [`Line::wait`].
#[derive(Debug)]
pub(super) struct Line {
    file: std::fs::File,
    /// The lock and the settings, for as long as the line is used.
    _locked: Option<Native>,
}

impl Line {
    pub(super) fn device(side: Side, locked: Native) -> std::io::Result<Self> {
        Ok(Self { file: side, _locked: Some(locked) })
    }

    pub(super) fn stream(stream: TcpStream) -> std::io::Result<Self> {
        stream.set_nonblocking(true)?;
        Ok(Self { file: std::fs::File::from(std::os::fd::OwnedFd::from(stream)), _locked: None })
    }

    pub(super) fn pty(master: std::fs::File) -> std::io::Result<Self> {
        rustix::fs::fcntl_setfl(&master, rustix::fs::fcntl_getfl(&master)? | rustix::fs::OFlags::NONBLOCK)?;
        Ok(Self { file: master, _locked: None })
    }

    /// Whether there is something to read: bytes, or the news that none will come any more.
    pub(super) fn wait(&self, wait: Duration, full: bool) -> bool {
        use rustix::event::{PollFd, PollFlags, Timespec, poll};
        let flags = if full { PollFlags::IN | PollFlags::OUT } else { PollFlags::IN };
        let mut fds = [PollFd::new(&self.file, flags)];
        // A wait that fails is a short one: the read behind it says why.
        let failed = poll(&mut fds, Timespec::try_from(wait).ok().as_ref()).is_err();
        failed || !(fds[0].revents() - PollFlags::OUT).is_empty()
    }

    pub(super) fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        self.file.read(buffer)
    }

    pub(super) fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.file.write(bytes)
    }

    pub(super) fn twin(&self) -> Option<Side> {
        self.file.try_clone().ok()
    }
}

/// The device without waiting, its modem lines kept up when it is closed: DTR falling resets many boards.
pub(super) fn side_door(path: &Path) -> std::io::Result<Side> {
    use rustix::fs::{Mode, OFlags};
    use rustix::termios::{ControlModes, OptionalActions, tcgetattr, tcsetattr};
    let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::NONBLOCK | OFlags::CLOEXEC;
    let device = rustix::fs::open(path, flags, Mode::empty())?;
    if let Ok(mut modes) = tcgetattr(&device) {
        modes.control_modes -= ControlModes::HUPCL;
        // A device that cannot do this is none the worse.
        let _ = tcsetattr(&device, OptionalActions::Now, &modes);
    }
    Ok(std::fs::File::from(device))
}
