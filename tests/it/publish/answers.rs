//! The answers of each kind of server, as its documentation has them.

use std::collections::BTreeMap;

use serde_json::{Value, json};
use sha1::Digest as _;
use trunnion::publish::Kind;

use super::server::{Hitch, Inside, Request};
use super::shown::{shown_by_duet, shown_by_moonraker};

/// What is said.
pub(super) enum Reply {
    Json(u16, Value),
    Bytes(Vec<u8>),
}

fn no(status: u16, words: &str) -> Reply {
    // The shape of Moonraker's and, as text, of OctoPrint's errors.
    Reply::Json(status, json!({"error": {"code": status, "message": words}}))
}

impl Inside {
    pub(super) fn answer(&mut self, request: &Request, hitch: Option<Hitch>) -> Reply {
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
                let name = if let Some(Hitch::Renamed(_)) = hitch { name.replace(".gcode", "_1.gcode") } else { name };
                self.keep(&name, bytes, hitch);
                if let Some(Hitch::Renamed(false)) = hitch {
                    return Reply::Json(201, json!({"done": true}));
                }
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
            ("GET", "/api/system/info") => match &self.firmware {
                Some(name) => Reply::Json(200, json!({"systeminfo": {"printer.firmware": name}})),
                None => no(403, "You don't have the permission to access the requested resource."),
            },
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
