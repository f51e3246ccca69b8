//! The same where devices cannot be read without waiting: a reader and a writer thread wait in our stead, joined to us by
//! channels.

use std::cell::RefCell;
use std::io::{ErrorKind, Read, Write};
use std::net::TcpStream;
#[cfg(not(unix))]
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::Builder;
use std::time::Duration;

use crossbeam_channel::{Receiver, Sender, bounded, unbounded};

use super::{PATIENCE, is_patience};

/// The largest piece that is handed to the writer: an emergency stop waits for one at most.
const PIECE: usize = 256;

#[cfg(not(unix))]
pub(super) type Native = serialport::COMPort;
#[cfg(not(unix))]
pub(super) type Side = ();

/// Nothing: the device is opened once, for both directions.
#[cfg(not(unix))]
pub(super) fn side_door(_path: &Path) -> std::io::Result<Side> {
    Ok(())
}

/// Without non-blocking devices two threads wait in our stead.
#[derive(Debug)]
pub(super) struct Line {
    incoming: Receiver<std::io::Result<Vec<u8>>>,
    outgoing: Sender<Vec<u8>>,
    /// Arrived and not yet read.
    rest: RefCell<Option<std::io::Result<Vec<u8>>>>,
    closed: Arc<AtomicBool>,
}

impl Line {
    #[cfg(not(unix))]
    pub(super) fn device((): (), locked: Native) -> std::io::Result<Self> {
        let reader = serialport::SerialPort::try_clone(&locked)?;
        Self::threads(reader, locked)
    }

    pub(super) fn stream(stream: TcpStream) -> std::io::Result<Self> {
        stream.set_nonblocking(false)?;
        stream.set_read_timeout(Some(PATIENCE))?;
        stream.set_write_timeout(Some(PATIENCE))?;
        Self::threads(stream.try_clone()?, stream)
    }

    fn threads(reader: impl Read + Send + 'static, writer: impl Write + Send + 'static) -> std::io::Result<Self> {
        let (to_host, incoming) = unbounded();
        let (outgoing, from_host) = bounded(1);
        let closed = Arc::new(AtomicBool::new(false));
        let (one, two, gone) = (Arc::clone(&closed), Arc::clone(&closed), to_host.clone());
        // A line that comes to nothing is dropped, and so ends the thread that was begun.
        let line = Self { incoming, outgoing, rest: RefCell::new(None), closed };
        Builder::new().spawn(move || read_all(reader, &to_host, &one))?;
        Builder::new().spawn(move || write_all(writer, &from_host, &gone, &two))?;
        Ok(line)
    }

    pub(super) fn wait(&self, wait: Duration, _full: bool) -> bool {
        let mut rest = self.rest.borrow_mut();
        if rest.is_none() {
            *rest = self.incoming.recv_timeout(wait).ok();
        }
        rest.is_some()
    }

    pub(super) fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let arrived = self.rest.take().or_else(|| self.incoming.try_recv().ok());
        let mut bytes = arrived.unwrap_or_else(|| Err(ErrorKind::WouldBlock.into()))?;
        let count = bytes.len().min(buffer.len());
        buffer[..count].copy_from_slice(&bytes[..count]);
        if count < bytes.len() {
            drop(bytes.drain(..count));
            self.rest = RefCell::new(Some(Ok(bytes)));
        }
        Ok(count)
    }

    /// One small piece at a time, so that an emergency stop never stands behind much.
    pub(super) fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let piece = &bytes[..bytes.len().min(PIECE)];
        self.outgoing.try_send(piece.to_vec()).map(|()| piece.len()).map_err(|_| ErrorKind::WouldBlock.into())
    }
}

impl Drop for Line {
    fn drop(&mut self) {
        self.closed.store(true, Ordering::Relaxed);
    }
}

fn read_all(mut reader: impl Read, to_host: &Sender<std::io::Result<Vec<u8>>>, closed: &AtomicBool) {
    let mut buffer = [0_u8; 4096];
    while !closed.load(Ordering::Relaxed) {
        let read = match reader.read(&mut buffer) {
            Err(e) if is_patience(&e) => continue,
            read => read.map(|n| buffer[..n].to_vec()),
        };
        let ends = read.as_ref().map_or(true, Vec::is_empty);
        if to_host.send(read).is_err() || ends {
            return;
        }
    }
}

fn write_all(
    mut writer: impl Write,
    bytes: &Receiver<Vec<u8>>,
    to_host: &Sender<std::io::Result<Vec<u8>>>,
    closed: &AtomicBool,
) {
    while let Ok(mut piece) = bytes.recv() {
        while !piece.is_empty() && !closed.load(Ordering::Relaxed) {
            match writer.write(&piece) {
                Ok(n) if n > 0 => drop(piece.drain(..n)),
                Err(e) if is_patience(&e) => {}
                ended => {
                    let _ = to_host.send(ended.map(|_| Vec::new()));
                    return;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::net::TcpListener;

    /// Both directions at once, more than any buffer holds, and the end of the other side.
    #[test]
    fn two_threads_carry_both_directions_and_tell_the_end() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let far = TcpStream::connect(listener.local_addr().unwrap()).unwrap();
        let mut line = Line::stream(listener.accept().unwrap().0).unwrap();
        let echo = std::thread::spawn(move || {
            let mut bytes = vec![0; 10_000];
            (&far).read_exact(&mut bytes).unwrap();
            (&far).write_all(&bytes).unwrap();
        });
        let wanted: Vec<u8> = (0..10_000_u32).map(|i| (i % 251) as u8).collect();
        let (mut sent, mut heard, mut buffer) = (0, Vec::new(), [0; 97]);
        let mut ended = false;
        for _ in 0..100_000 {
            sent += line.write(&wanted[sent..]).unwrap_or(0);
            line.wait(Duration::from_millis(1), sent < wanted.len());
            match line.read(&mut buffer) {
                Ok(0) => ended = true,
                Ok(n) => heard.extend_from_slice(&buffer[..n]),
                Err(e) => assert!(is_patience(&e), "{e}"),
            }
            if ended {
                break;
            }
        }
        echo.join().unwrap();
        assert!(ended && heard == wanted, "{sent} sent, {} heard", heard.len());
    }
}
