//! A small server that answers as the documentation of OctoPrint, Moonraker and RepRapFirmware says, and has every bad day on demand.
//!
//! What it shows of a file it reads from comments by the rules of Moonraker's `metadata.py` and RepRapFirmware's `FileInfoParser`,
//! written anew from what they accept.

use std::collections::{BTreeMap, VecDeque};
use std::io::{Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::Duration;

use serde_json::{Value, json};
use sha1::Digest as _;
use trunnion::publish::Kind;

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
    /// The key may look, but not upload.
    Forbidden,
}

/// What it answers to everything.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Door {
    Open,
    /// A login page stands before it.
    Page,
    /// It has moved.
    Moved,
    /// It takes the request and says nothing.
    Mute,
    /// It speaks something else.
    Garbled,
}

pub(super) struct Inside {
    kind: Kind,
    pub(super) key: Option<String>,
    pub(super) door: Door,
    pub(super) hitches: VecDeque<Hitch>,
    pub(super) files: BTreeMap<String, Vec<u8>>,
    pub(super) free: u64,
    /// What is printed.
    pub(super) printing: Option<String>,
    /// Whether a printer is there at all.
    pub(super) connected: bool,
    /// The answer to a start is lost.
    pub(super) start_lost: bool,
    /// How often a print was started.
    pub(super) started: usize,
    /// Method and path of all requests, with whether the key came along.
    pub(super) asked: Vec<String>,
    pub(super) userdata: Option<String>,
}

#[derive(Clone)]
pub(super) struct Server {
    pub(super) address: SocketAddr,
    kind: Kind,
    tls: bool,
    inside: Arc<Mutex<Inside>>,
}

struct Request {
    method: String,
    path: String,
    query: BTreeMap<String, String>,
    headers: BTreeMap<String, String>,
    body: Vec<u8>,
}

impl Server {
    pub(super) fn of(kind: Kind) -> Self {
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
            connected: true,
            start_lost: false,
            started: 0,
            asked: Vec::new(),
            userdata: None,
        };
        let address = listener.local_addr().unwrap();
        let server = Self { address, kind, tls: tls.is_some(), inside: Arc::new(Mutex::new(inside)) };
        let shared = Arc::clone(&server.inside);
        std::thread::spawn(move || {
            for stream in listener.incoming().flatten() {
                let (shared, tls) = (Arc::clone(&shared), tls.clone());
                std::thread::spawn(move || match tls {
                    Some(config) => {
                        let connection = rustls::ServerConnection::new(config).unwrap();
                        serve(&mut rustls::StreamOwned::new(connection, stream), &shared);
                    }
                    None => serve(&mut { stream }, &shared),
                });
            }
        });
        server
    }

    pub(super) fn inside(&self) -> MutexGuard<'_, Inside> {
        self.inside.lock().unwrap()
    }

    /// As `--to` takes it.
    pub(super) fn to(&self) -> String {
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
        Door::Moved => {
            return send(stream, 302, "Location: http://elsewhere.local/login?then=SECRET\r\n", b"");
        }
        Door::Mute => return std::thread::sleep(Duration::from_secs(20)),
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
    let (kind, lost) = (inside.kind, std::mem::take(&mut inside.start_lost) && is_start(&request));
    if lost {
        inside.start_lost = false;
    } else if is_start(&request) {
        inside.start_lost = false;
    }
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

enum Reply {
    Json(u16, Value),
    Bytes(Vec<u8>),
}

fn no(status: u16, words: &str) -> Reply {
    // The shape of Moonraker's and, as text, of OctoPrint's errors.
    Reply::Json(status, json!({"error": {"code": status, "message": words}}))
}

impl Inside {
    fn answer(&mut self, request: &Request, hitch: Option<Hitch>) -> Reply {
        if self.kind != Kind::Duet && self.key.is_some() && request.headers.get("x-api-key") != self.key.as_ref() {
            return no(if self.kind == Kind::OctoPrint { 403 } else { 401 }, "Unauthorized");
        }
        match hitch {
            Some(Hitch::Full) => return no(507, "Insufficient Storage"),
            Some(Hitch::FullInItsWay) => {
                self.free = 10;
                return if self.kind == Kind::Duet {
                    Reply::Json(200, json!({"err": 1}))
                } else {
                    no(500, "[Errno 28] No space left on device")
                };
            }
            Some(Hitch::Forbidden) => return no(403, "Forbidden"),
            _ => {}
        }
        match self.kind {
            Kind::OctoPrint => self.octoprint(request, hitch),
            Kind::Moonraker => self.moonraker(request, hitch),
            Kind::Duet => self.duet(request, hitch),
        }
    }

    /// What a form or a body holds is kept as the hitch lets it; `false` where nothing is.
    fn keep(&mut self, name: &str, mut bytes: Vec<u8>, hitch: Option<Hitch>) -> bool {
        match hitch {
            Some(Hitch::Cut(_)) => return false,
            Some(Hitch::Spoilt) => bytes[7] ^= 1,
            _ => {}
        }
        self.files.insert(name.to_owned(), bytes);
        true
    }

    fn start(&mut self, name: &str) -> Reply {
        self.started += 1;
        self.printing = Some(name.to_owned());
        Reply::Json(200, json!({"bufferSpace": 200}))
    }

    fn octoprint(&mut self, request: &Request, hitch: Option<Hitch>) -> Reply {
        let name = request.path.rsplit('/').next().unwrap().to_owned();
        match (request.method.as_str(), request.path.as_str()) {
            ("GET", "/api/version") => Reply::Json(200, json!({"api": "0.1", "text": "OctoPrint 1.11.8"})),
            ("GET", "/api/files/local") => Reply::Json(200, json!({"files": [], "free": self.free, "total": 1 << 31})),
            ("POST", "/api/files/local") => {
                let (fields, name, bytes) = form(request);
                if self.files.contains_key(&name) && fields.get("noOverwrite").is_some_and(|no| no == "true") {
                    return no(409, "File already exists and noOverwrite was set");
                }
                self.userdata = fields.get("userdata").cloned();
                self.keep(&name, bytes, hitch);
                Reply::Json(201, json!({"done": true, "files": {"local": {"name": name, "path": name}}}))
            }
            ("GET", path) if path.starts_with("/api/files/local/") => match self.files.get(&name) {
                Some(bytes) => {
                    let hash: String = sha1::Sha1::digest(bytes).iter().map(|b| format!("{b:02x}")).collect();
                    Reply::Json(200, json!({"name": name, "size": bytes.len(), "hash": hash}))
                }
                None => no(404, "Not found"),
            },
            ("DELETE", _) => {
                self.files.remove(&name);
                Reply::Json(204, json!({}))
            }
            ("GET", "/api/printer") if !self.connected => no(409, "Printer is not operational"),
            ("GET", "/api/printer") => {
                let ready = self.printing.is_none();
                let flags = json!({"operational": true, "ready": ready, "printing": !ready});
                Reply::Json(200, json!({"state": {"text": "As it is", "flags": flags}}))
            }
            ("GET", "/api/job") => Reply::Json(200, json!({"job": {"file": {"path": self.printing}}})),
            ("POST", _) => self.start(&name),
            _ => no(404, "Not found"),
        }
    }

    fn moonraker(&mut self, request: &Request, hitch: Option<Hitch>) -> Reply {
        let name = request.path.rsplit('/').next().unwrap().to_owned();
        match (request.method.as_str(), request.path.as_str()) {
            ("GET", "/server/info") => Reply::Json(200, json!({"klippy_state": "ready", "moonraker_version": "v0.9"})),
            ("GET", "/server/files/directory") => {
                let one = |(name, bytes): (&String, &Vec<u8>)| json!({"filename": name, "size": bytes.len()});
                let files: Vec<Value> = self.files.iter().map(one).collect();
                Reply::Json(200, json!({"dirs": [], "files": files, "disk_usage": {"free": self.free}}))
            }
            ("POST", "/server/files/upload") => {
                let (fields, name, mut bytes) = form(request);
                if let Some(Hitch::Spoilt) = hitch {
                    bytes[7] ^= 1;
                }
                if hitch.is_none_or(|h| h == Hitch::Spoilt) && fields["checksum"] != sha256(&bytes) {
                    return no(422, "File checksum mismatch");
                }
                let hitch = hitch.filter(|h| *h != Hitch::Spoilt);
                let size = bytes.len();
                self.keep(&name, bytes, hitch);
                Reply::Json(
                    201,
                    json!({"item": {"path": name, "root": "gcodes", "size": size}, "print_started": false}),
                )
            }
            ("GET", "/server/files/metadata") => match self.files.get(&request.query["filename"]) {
                Some(bytes) => Reply::Json(200, shown_by_moonraker(bytes)),
                None => no(404, "Metadata not available"),
            },
            ("GET", path) if path.starts_with("/server/files/gcodes/") => match self.files.get(&name) {
                Some(bytes) => Reply::Bytes(bytes.clone()),
                None => no(404, "Not found"),
            },
            ("DELETE", _) => {
                self.files.remove(&name);
                Reply::Json(200, json!({"action": "delete_file"}))
            }
            ("GET", "/printer/info") if !self.connected => no(503, "Klippy Host not connected"),
            ("GET", "/printer/info") => Reply::Json(200, json!({"state": "ready"})),
            ("GET", "/printer/objects/query") => {
                let state = if self.printing.is_some() { "printing" } else { "standby" };
                Reply::Json(200, json!({"status": {"print_stats": {"state": state, "filename": self.printing}}}))
            }
            ("POST", "/printer/print/start") => self.start(&request.query["filename"].clone()),
            _ => no(404, "Not found"),
        }
    }

    fn duet(&mut self, request: &Request, hitch: Option<Hitch>) -> Reply {
        let name = request.query.get("name").map(|n| n.trim_start_matches("0:/gcodes/").to_owned()).unwrap_or_default();
        let err = |code: u8| Reply::Json(200, json!({"err": code}));
        match request.path.as_str() {
            "/rr_connect" => {
                let wanted = self.key.as_deref().unwrap_or("reprap");
                err(u8::from(request.query["password"] != wanted))
            }
            "/rr_disconnect" => err(0),
            "/rr_model" if request.query["key"] == "volumes" => {
                Reply::Json(200, json!({"key": "volumes", "result": [{"freeSpace": self.free}]}))
            }
            "/rr_model" if request.query["key"] == "job" => {
                let file = self.printing.as_ref().map(|name| format!("0:/gcodes/{name}"));
                Reply::Json(200, json!({"key": "job", "result": {"file": {"fileName": file}}}))
            }
            "/rr_model" => {
                let status = match (&self.printing, self.connected) {
                    (_, false) => "off",
                    (Some(_), _) => "processing",
                    (None, _) => "idle",
                };
                Reply::Json(200, json!({"key": "state", "result": {"status": status}}))
            }
            "/rr_upload" => {
                let mut bytes = request.body.clone();
                if let Some(Hitch::Spoilt) = hitch {
                    bytes[7] ^= 1;
                }
                if hitch.is_none_or(|h| h == Hitch::Spoilt)
                    && request.query["crc32"] != format!("{:08x}", crc32fast::hash(&bytes))
                {
                    return err(1);
                }
                let hitch = hitch.filter(|h| *h != Hitch::Spoilt);
                self.keep(&name, bytes, hitch);
                err(0)
            }
            "/rr_fileinfo" => match self.files.get(&name) {
                Some(bytes) => Reply::Json(200, shown_by_duet(bytes)),
                None => err(1),
            },
            "/rr_download" => match self.files.get(&name) {
                Some(bytes) => Reply::Bytes(bytes.clone()),
                None => no(404, "Not found"),
            },
            "/rr_delete" => err(u8::from(self.files.remove(&name).is_none())),
            "/rr_gcode" => {
                let code = &request.query["gcode"];
                let name = code.trim_start_matches("M32 \"0:/gcodes/").trim_end_matches('"').to_owned();
                self.start(&name)
            }
            _ => no(404, "Not found"),
        }
    }
}

fn sha256(bytes: &[u8]) -> String {
    sha2::Sha256::digest(bytes).iter().map(|b| format!("{b:02x}")).collect()
}

/// Fields, the file's name and its bytes, of as much of a form as came.
fn form(request: &Request) -> (BTreeMap<String, String>, String, Vec<u8>) {
    let boundary = format!("--{}", request.headers["content-type"].split("boundary=").nth(1).unwrap());
    let (mut fields, mut file) = (BTreeMap::new(), (String::new(), Vec::new()));
    let places: Vec<usize> = memchr::memmem::find_iter(&request.body, boundary.as_bytes()).collect();
    for (i, start) in places.iter().enumerate() {
        let end = places.get(i + 1).copied().unwrap_or(request.body.len() + 2).saturating_sub(2);
        let piece = &request.body[(start + boundary.len() + 2).min(request.body.len())
            ..end.min(request.body.len()).max((start + boundary.len() + 2).min(request.body.len()))];
        let Some(middle) = memchr::memmem::find(piece, b"\r\n\r\n") else { continue };
        let head = String::from_utf8_lossy(&piece[..middle]).into_owned();
        let quoted =
            |key: &str| head.split(&format!("{key}=\"")).nth(1).map(|rest| rest.split('"').next().unwrap().to_owned());
        let content = piece[middle + 4..].to_vec();
        match quoted(" filename") {
            Some(name) => file = (name, content),
            None => drop(fields.insert(quoted(" name").unwrap(), String::from_utf8(content).unwrap())),
        }
    }
    (fields, file.0, file.1)
}

/// Seconds in `2d 1h 5m 24s`.
fn seconds_of(text: &str) -> f64 {
    let worth = |unit: &str| match unit {
        "d" => 86_400.0,
        "h" => 3_600.0,
        "m" => 60.0,
        "s" => 1.0,
        other => panic!("no unit: {other}"),
    };
    text.split_whitespace()
        .map(|word| word.split_at(word.len() - 1))
        .map(|(n, unit)| n.parse::<f64>().unwrap() * worth(unit))
        .sum()
}

/// A slicer is known by its name, a blank, anything, and " on" in one line; else nothing is read.
fn shown_by_moonraker(bytes: &[u8]) -> Value {
    let text = String::from_utf8_lossy(bytes);
    let known = text.lines().any(|line| line.split_once("PrusaSlicer ").is_some_and(|(_, rest)| rest.contains(" on")));
    if !known {
        return json!({"slicer": "Unknown"});
    }
    let after = |key: &str| text.split_once(key).map(|(_, rest)| rest.lines().next().unwrap().trim().to_owned());
    json!({
        "slicer": "PrusaSlicer",
        "estimated_time": after("; estimated printing time (normal mode) = ").map(|time| seconds_of(&time)),
        "filament_total": after("filament used [mm] = ").map(|mm| mm.parse::<f64>().unwrap()),
        "layer_count": after("; total layers count = ").map(|n| n.parse::<u64>().unwrap()),
    })
}

/// Whole-line comments whose key stands behind the semicolon and blanks, with an equals sign or a colon behind it.
fn shown_by_duet(bytes: &[u8]) -> Value {
    let text = String::from_utf8_lossy(bytes);
    let mut info = json!({"err": 0, "size": bytes.len(), "filament": []});
    for line in text.lines().filter_map(|line| line.strip_prefix(';')) {
        let line = line.trim_start_matches([' ', '-']);
        let after = |key: &str| {
            let (first, rest) = line.split_at_checked(1)?;
            let same = first.eq_ignore_ascii_case(&key[..1]);
            let rest = rest.strip_prefix(&key[1..]).filter(|rest| same && rest.starts_with([' ', ':', '=', ',']))?;
            Some(rest.trim_start_matches([' ', ':', '=']).to_owned())
        };
        if let Some(time) = after("Estimated printing time (normal mode)") {
            info["printTime"] = json!(seconds_of(&time));
        } else if let Some(mm) = after("Filament used [mm]") {
            info["filament"].as_array_mut().unwrap().push(json!(mm.parse::<f64>().unwrap()));
        } else if let Some(count) = after("Total layer number").or_else(|| after("Num_layers")) {
            info["numLayers"] = json!(count.parse::<u64>().unwrap());
        } else if let Some(program) = after("Generated by") {
            info["generatedBy"] = json!(program);
        }
    }
    info
}

/// Cuts what goes to `to` in every POST of the first `cuts` connections that have one after `bytes` bytes; the rest passes.
pub(super) fn scissors(to: SocketAddr, bytes: usize, cuts: usize) -> SocketAddr {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    let left = Arc::new(Mutex::new(cuts));
    std::thread::spawn(move || {
        for near in listener.incoming().flatten() {
            let (left, far) = (Arc::clone(&left), TcpStream::connect(to).unwrap());
            let (mut back_from, mut back_to) = (far.try_clone().unwrap(), near.try_clone().unwrap());
            std::thread::spawn(move || std::io::copy(&mut back_from, &mut back_to));
            std::thread::spawn(move || pass(near, far, bytes, &left));
        }
    });
    address
}

fn pass(mut near: TcpStream, mut far: TcpStream, bytes: usize, left: &Mutex<usize>) {
    let (mut buffer, mut posted) = ([0; 4096], None);
    while let Ok(count @ 1..) = near.read(&mut buffer) {
        if buffer[..count].starts_with(b"POST /api/files/local HTTP") && *left.lock().unwrap() > 0 {
            *left.lock().unwrap() -= 1;
            posted = Some(0);
        }
        if let Some(gone) = &mut posted {
            *gone += count;
            if *gone > bytes {
                break;
            }
        }
        if far.write_all(&buffer[..count]).is_err() {
            break;
        }
    }
    let _ = near.shutdown(std::net::Shutdown::Both);
    let _ = far.shutdown(std::net::Shutdown::Both);
}
