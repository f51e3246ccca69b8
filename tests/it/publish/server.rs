//! A small server that answers as the documentation of OctoPrint, Moonraker and RepRapFirmware says, and has every bad day on demand.

use std::collections::{BTreeMap, VecDeque};
use std::io::{Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::{Arc, Condvar, Mutex, MutexGuard};

use serde_json::json;
use trunnion::publish::Kind;

use super::answers::Reply;

/// What happens to the next upload.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Hitch {
    /// The connection ends after so many bytes of the body; nothing is kept.
    Cut(usize),
    /// The same, and what came is kept.
    HalfKept(usize),
    /// All is kept, and the answer is lost.
    AnswerLost,
    /// A byte is lost on the way, and nobody sees it but who compares.
    Spoilt,
    /// No room: 507.
    Full,
    /// The card is full, as the server says it in its own way: 500, or `err` 1.
    FullInItsWay,
    /// OctoPrint keeps it under another name, and says which, or not.
    Renamed(bool),
    /// The key may look, but not upload.
    Forbidden,
}

/// What it answers to everything.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Door {
    Open,
    /// A login page stands before it.
    Page,
    /// A proxy before it asks for a login.
    Login,
    /// It has moved.
    Moved,
    /// It takes the request and says nothing.
    Mute,
    /// It speaks something else.
    Garbled,
}

pub(crate) struct Inside {
    pub(super) kind: Kind,
    pub(crate) key: Option<String>,
    pub(super) door: Door,
    pub(super) hitches: VecDeque<Hitch>,
    pub(crate) files: BTreeMap<String, Vec<u8>>,
    pub(super) free: u64,
    /// What is printed.
    pub(super) printing: Option<String>,
    /// What its printer calls itself, where it tells.
    pub(super) firmware: Option<String>,
    /// Whether a printer is there at all.
    pub(super) connected: bool,
    /// The answer to a start is lost.
    pub(super) start_lost: bool,
    /// How often a print was started.
    pub(crate) started: usize,
    /// Method and path of all requests, with whether the key came along.
    pub(super) asked: Vec<String>,
    pub(super) userdata: Option<String>,
}

#[derive(Clone)]
pub(crate) struct Server {
    pub(super) address: SocketAddr,
    kind: Kind,
    tls: bool,
    inside: Arc<Mutex<Inside>>,
    open: Arc<Open>,
}

/// How many connections were taken and are not ended.
#[derive(Default)]
struct Open {
    count: Mutex<usize>,
    ended: Condvar,
}

/// A connection that is counted until it is dropped.
struct Counted(Arc<Open>);

impl Counted {
    fn of(open: &Arc<Open>) -> Self {
        *open.count.lock().unwrap() += 1;
        Self(Arc::clone(open))
    }
}

impl Drop for Counted {
    fn drop(&mut self) {
        *self.0.count.lock().unwrap() -= 1;
        self.0.ended.notify_all();
    }
}

pub(super) struct Request {
    pub(super) method: String,
    pub(super) path: String,
    pub(super) query: BTreeMap<String, String>,
    pub(super) headers: BTreeMap<String, String>,
    pub(super) body: Vec<u8>,
}

impl Server {
    pub(crate) fn of(kind: Kind) -> Self {
        Self::spoken(kind, None)
    }

    /// With TLS where there is a configuration.
    pub(super) fn spoken(kind: Kind, tls: Option<Arc<rustls::ServerConfig>>) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let inside = Inside {
            kind,
            key: None,
            door: Door::Open,
            hitches: VecDeque::new(),
            files: BTreeMap::new(),
            free: 1 << 30,
            printing: None,
            firmware: None,
            connected: true,
            start_lost: false,
            started: 0,
            asked: Vec::new(),
            userdata: None,
        };
        let address = listener.local_addr().unwrap();
        let (inside, open) = (Arc::new(Mutex::new(inside)), Arc::default());
        let server = Self { address, kind, tls: tls.is_some(), inside, open };
        let (shared, open) = (Arc::clone(&server.inside), Arc::clone(&server.open));
        std::thread::spawn(move || {
            for stream in listener.incoming().flatten() {
                let (shared, tls, counted) = (Arc::clone(&shared), tls.clone(), Counted::of(&open));
                std::thread::spawn(move || {
                    match tls {
                        Some(config) => {
                            let connection = rustls::ServerConnection::new(config).unwrap();
                            serve(&mut rustls::StreamOwned::new(connection, stream), &shared);
                        }
                        None => serve(&mut { stream }, &shared),
                    }
                    drop(counted);
                });
            }
        });
        server
    }

    pub(crate) fn inside(&self) -> MutexGuard<'_, Inside> {
        self.inside.lock().unwrap()
    }

    /// Waits until every request of whoever is gone has had its effect: connections are taken in turn, so all before this one are counted.
    pub(super) fn settle(&self) {
        let mut last = TcpStream::connect(self.address).unwrap();
        last.write_all(b"GET /settled HTTP/1.1\r\n\r\n").unwrap();
        last.read_to_end(&mut Vec::new()).unwrap();
        let mut count = self.open.count.lock().unwrap();
        while *count > 0 {
            count = self.open.ended.wait(count).unwrap();
        }
    }

    /// As `--to` takes it.
    pub(crate) fn to(&self) -> String {
        format!("{}:{}", self.kind.word(), self.url())
    }

    pub(super) fn url(&self) -> String {
        let scheme = if self.tls { "https" } else { "http" };
        format!("{scheme}://localhost:{}", self.address.port())
    }
}

/// One request a connection.
fn serve(stream: &mut (impl Read + Write), shared: &Mutex<Inside>) {
    let mut head = Vec::new();
    let mut byte = [0];
    while !head.ends_with(b"\r\n\r\n") {
        match stream.read(&mut byte) {
            Ok(1) => head.push(byte[0]),
            _ => return,
        }
    }
    let text = String::from_utf8(head).unwrap();
    let mut lines = text.lines();
    let mut first = lines.next().unwrap().split(' ');
    let (method, whole) = (first.next().unwrap().to_owned(), first.next().unwrap().to_owned());
    let headers: BTreeMap<String, String> =
        lines.filter_map(|l| l.split_once(": ")).map(|(k, v)| (k.to_ascii_lowercase(), v.to_owned())).collect();
    let length: usize = headers.get("content-length").and_then(|l| l.parse().ok()).unwrap_or(0);
    let (path, query) = whole.split_once('?').unwrap_or((&whole, ""));
    let query = query.split('&').filter_map(|w| w.split_once('=')).map(|(k, v)| (k.to_owned(), unescaped(v))).collect();
    let door = shared.lock().unwrap().door;
    match door {
        Door::Open => {}
        Door::Page => return send(stream, 200, "", b"<!DOCTYPE html><html><body>Log in</body></html>"),
        Door::Login => return send(stream, 401, "WWW-Authenticate: Basic realm=\"workshop\"\r\n", b"401"),
        Door::Moved => {
            return send(stream, 302, "Location: http://elsewhere.local/login?then=SECRET\r\n", b"");
        }
        // Until whoever asked has gone.
        Door::Mute => return while matches!(stream.read(&mut [0; 64]), Ok(1..)) {},
        Door::Garbled => return drop(stream.write_all(b"ok T:20.0 /0.0\n")),
    }
    let uploads = method == "POST" && length > 0 && !path.starts_with("/api/files/local/");
    let hitch = if uploads { shared.lock().unwrap().hitches.pop_front() } else { None };
    let wanted = match hitch {
        Some(Hitch::Cut(at) | Hitch::HalfKept(at)) => at.min(length),
        _ => length,
    };
    let mut body = vec![0; wanted];
    if stream.read_exact(&mut body).is_err() {
        return;
    }
    let request = Request { method, path: path.to_owned(), query, headers, body };
    let mut inside = shared.lock().unwrap();
    let keyed = request.headers.contains_key("x-api-key");
    inside.asked.push(format!("{} {}{}", request.method, request.path, if keyed { " with key" } else { "" }));
    let answer = inside.answer(&request, hitch);
    let (kind, lost) = (inside.kind, is_start(&request) && std::mem::take(&mut inside.start_lost));
    drop(inside);
    if lost || matches!(hitch, Some(Hitch::Cut(_) | Hitch::HalfKept(_) | Hitch::AnswerLost)) {
        return;
    }
    match answer {
        Reply::Json(status, value) => {
            let value = if kind == Kind::Moonraker && status < 300 { json!({"result": value}) } else { value };
            send(stream, status, "Content-Type: application/json\r\n", value.to_string().as_bytes());
        }
        Reply::Bytes(bytes) => send(stream, 200, "", &bytes),
    }
}

fn is_start(request: &Request) -> bool {
    request.path == "/printer/print/start"
        || request.query.get("gcode").is_some_and(|g| g.starts_with("M32 "))
        || (request.method == "POST" && request.path.starts_with("/api/files/local/"))
}

fn send(stream: &mut impl Write, status: u16, headers: &str, body: &[u8]) {
    let head =
        format!("HTTP/1.1 {status} As it is\r\n{headers}Content-Length: {}\r\nConnection: close\r\n\r\n", body.len());
    let _ = stream.write_all(&[head.as_bytes(), body].concat());
    let _ = stream.flush();
}

fn unescaped(text: &str) -> String {
    let mut bytes = Vec::new();
    let mut rest = text.bytes();
    while let Some(byte) = rest.next() {
        if byte == b'%' {
            let digits = [rest.next().unwrap(), rest.next().unwrap()];
            bytes.push(u8::from_str_radix(std::str::from_utf8(&digits).unwrap(), 16).unwrap());
        } else {
            bytes.push(byte);
        }
    }
    String::from_utf8(bytes).unwrap()
}
