//! Sockets: connections on this computer, one request each, each with a thread of its own, so that a slow one keeps nobody waiting.

use std::io::{Cursor, Read, Write};
use std::net::{Ipv4Addr, Shutdown, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread::Builder;
use std::time::Duration;

use super::WorkbenchError;
use super::answers::{WebReply, answer};
use super::doors::Doors;
use super::http::{HttpAnswer, MOST_HEAD, MOST_UPLOADED_MB, RequestHead, head};
use super::routes::WebAsked;
use super::shared::Shared;
use super::state::State;

/// Connections at once.
const MOST_CONNECTIONS: usize = 64;
/// A client that sends or takes nothing for so long is given up.
const PATIENCE: Duration = Duration::from_secs(20);
/// A page hears that the server is there at least this often.
const SILENCE: Duration = Duration::from_secs(10);
/// States are sent at most this often.
const BETWEEN: Duration = Duration::from_millis(60);
/// What is read of a request that was refused, so that its sender reads the answer.
const MOST_DRAINED: u64 = 4 << 20;

/// A server that listens and does not answer yet.
#[derive(Debug)]
pub(super) struct HttpServer {
    listener: TcpListener,
    /// What its connections share.
    pub(super) shared: Arc<Shared>,
    connections: Arc<AtomicUsize>,
}

impl HttpServer {
    /// Listens on this computer alone; port 0 is any free one.
    ///
    /// # Errors
    ///
    /// [`WorkbenchError::Port`] and [`WorkbenchError::NotStarted`].
    pub(super) fn listen(port: u16, folder: std::path::PathBuf, state: State) -> Result<Self, WorkbenchError> {
        let failed = |source| WorkbenchError::Port { port, source };
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).map_err(failed)?;
        let port = listener.local_addr().map_err(failed)?.port();
        let doors = Doors::new(port, random()?, random()?);
        Ok(Self { listener, shared: Arc::new(Shared::new(doors, folder, state)), connections: Arc::default() })
    }

    /// Answers until somebody ends it; the processes of prints that go on.
    pub(super) fn serve(&self) -> Vec<u32> {
        self.wake_at_the_end();
        for stream in self.listener.incoming() {
            if self.shared.quits() {
                break;
            }
            // One that has gone already, or no more files for this process: the next may do.
            let Ok(stream) = stream else {
                std::thread::sleep(BETWEEN);
                continue;
            };
            let served = Served(self.connections.clone());
            if self.connections.fetch_add(1, Ordering::SeqCst) >= MOST_CONNECTIONS {
                let _ = stream.set_write_timeout(Some(BETWEEN));
                let _ = send(&stream, &HttpAnswer::refusal(&WorkbenchError::Crowded));
                continue;
            }
            let shared = self.shared.clone();
            // Where the system gives no thread the connection is shut, and the page asks again.
            let _ = Builder::new().spawn(move || {
                let _served = served;
                let _ = connection(&stream, &shared);
            });
        }
        self.shared.state().end()
    }

    /// Connects to itself when somebody ends it: it waits for a connection.
    fn wake_at_the_end(&self) {
        let (shared, own) = (self.shared.clone(), self.listener.local_addr());
        std::thread::spawn(move || {
            let mut seen = None;
            while !shared.quits() {
                seen = Some(shared.newer(seen, SILENCE).version);
            }
            own.map(TcpStream::connect)
        });
    }
}

/// A connection that is counted until it ends, even by a panic.
struct Served(Arc<AtomicUsize>);

impl Drop for Served {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::SeqCst);
    }
}

/// A text that nobody can guess.
fn random() -> Result<String, WorkbenchError> {
    let mut bytes = [0; 24];
    getrandom::fill(&mut bytes)
        .map_err(|error| WorkbenchError::NotStarted { source: std::io::Error::other(error.to_string()) })?;
    Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
}

/// Reads the request and answers it.
fn connection(stream: &TcpStream, shared: &Arc<Shared>) -> std::io::Result<()> {
    stream.set_read_timeout(Some(PATIENCE))?;
    stream.set_write_timeout(Some(PATIENCE))?;
    let (head, rest) = match request(stream)? {
        Ok(both) => both,
        Err(error) => return refuse(stream, &error, MOST_DRAINED),
    };
    let left = head.length;
    let mut body = Cursor::new(rest).chain(stream).take(left);
    let reply = match allowed(&head) {
        Ok(()) => answer(&head, &mut body, shared),
        Err(error) => Err(error),
    };
    match reply {
        Ok(WebReply::Whole(reply)) => send(stream, &reply),
        Ok(WebReply::Last(reply)) => {
            let sent = send(stream, &reply);
            shared.quit();
            sent
        }
        Ok(WebReply::File(reply, mut file, length)) => {
            let mut to = stream;
            to.write_all(reply.head(Some(length)).as_bytes())?;
            std::io::copy(&mut file, &mut to).map(|_| ())
        }
        Ok(WebReply::Events) => events(stream, shared),
        Err(error) => refuse(stream, &error, body.limit()),
    }
}

/// No body is larger than a model may be, and none is read of what is.
fn allowed(head: &RequestHead) -> Result<(), WorkbenchError> {
    let takes = matches!(super::routes::asked(head), Ok(WebAsked::Upload(_)));
    let most = if takes { MOST_UPLOADED_MB << 20 } else { MOST_HEAD as u64 };
    if head.length <= most { Ok(()) } else { Err(WorkbenchError::TooLarge { limit_mb: MOST_UPLOADED_MB }) }
}

/// The head of a request, and what came with it of the body.
fn request(mut stream: &TcpStream) -> std::io::Result<Result<(RequestHead, Vec<u8>), WorkbenchError>> {
    let until = std::time::Instant::now() + PATIENCE;
    let (mut bytes, mut piece) = (Vec::new(), [0; 4096]);
    loop {
        match head(&bytes) {
            Ok(Some((head, length))) => return Ok(Ok((head, bytes.split_off(length)))),
            Ok(None) => {}
            Err(error) => return Ok(Err(error)),
        }
        let count = stream.read(&mut piece)?;
        if count == 0 || std::time::Instant::now() > until {
            return Err(std::io::ErrorKind::UnexpectedEof.into());
        }
        bytes.extend(&piece[..count]);
    }
}

fn send(mut stream: &TcpStream, answer: &HttpAnswer) -> std::io::Result<()> {
    stream.write_all(answer.head(Some(answer.body.len() as u64)).as_bytes())?;
    stream.write_all(&answer.body)
}

/// Answers why not, and reads some of what is still coming: a connection that is closed before would take the answer with it.
fn refuse(stream: &TcpStream, error: &WorkbenchError, left: u64) -> std::io::Result<()> {
    send(stream, &HttpAnswer::refusal(error))?;
    stream.shutdown(Shutdown::Write)?;
    stream.set_read_timeout(Some(Duration::from_secs(1)))?;
    let _ = std::io::copy(&mut stream.take(left.min(MOST_DRAINED)), &mut std::io::sink());
    Ok(())
}

/// Sends the state now and whenever it has changed.
fn events(mut stream: &TcpStream, shared: &Shared) -> std::io::Result<()> {
    stream.write_all(HttpAnswer::of("text/event-stream", Vec::new()).head(None).as_bytes())?;
    let mut sent = None;
    while !shared.quits() {
        let state = shared.newer(sent, SILENCE);
        let version = state.version;
        let text = if sent == Some(version) { ":\n\n".to_owned() } else { format!("data: {}\n\n", state.document()) };
        drop(state);
        stream.write_all(text.as_bytes())?;
        sent = Some(version);
        std::thread::sleep(BETWEEN);
    }
    Ok(())
}
