//! The workbench: who may come in, what its jobs make, and the page itself in a browser.

mod browser;
mod cuts;
mod doors;
mod history;
mod jobs;
mod looks;
mod order;
mod prints;
mod projects;
mod tasks;

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::Stdio;

use serde_json::Value;

use crate::link::Running;
use crate::support::{Command, PATIENCE, folder, trunnion};

/// A workbench that ends with its owner.
struct Workbench {
    process: Running,
    folder: tempfile::TempDir,
    address: String,
    port: u16,
}

/// What the server answers.
struct Answer {
    status: u16,
    head: String,
    body: Vec<u8>,
}

impl Answer {
    #[track_caller]
    fn json(&self) -> Value {
        serde_json::from_slice(&self.body)
            .unwrap_or_else(|why| panic!("{why}: {}", String::from_utf8_lossy(&self.body)))
    }
}

/// Opens a workbench in a folder of its own that holds these models.
fn open(models: &[&str], words: &[&str]) -> Workbench {
    let folder = folder();
    for model in models {
        std::fs::copy(crate::pipeline::fixture(model), folder.path().join(format!("{model}.stl"))).unwrap();
    }
    open_in(folder, words)
}

fn open_in(folder: tempfile::TempDir, words: &[&str]) -> Workbench {
    open_by(&mut trunnion(), folder, words)
}

/// The same, by a command whose environment is made already.
fn open_by(command: &mut Command, folder: tempfile::TempDir, words: &[&str]) -> Workbench {
    command.args(["open", "--no-browser", "--json"]).args(words).current_dir(folder.path());
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
    let mut line = String::new();
    BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
    let told: Value = serde_json::from_str(&line).unwrap();
    crate::schemas::holds("open.json", &told, "trunnion open");
    let (address, port) = (told["address"].as_str().unwrap().to_owned(), told["port"].as_u64().unwrap() as u16);
    Workbench { process: Running(child), folder, address, port }
}

impl Workbench {
    fn secret(&self) -> &str {
        self.address.split_once('#').unwrap().1
    }

    fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(("127.0.0.1", self.port)).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        stream
    }

    /// Sends bytes as they are.
    fn raw(&self, bytes: &[u8]) -> Answer {
        let mut stream = self.connect();
        // Who is refused may be cut off.
        let _ = stream.write_all(bytes);
        let mut all = Vec::new();
        let _ = stream.read_to_end(&mut all);
        let end = all.windows(4).position(|four| four == b"\r\n\r\n").unwrap_or_else(|| panic!("{all:?}"));
        let head = String::from_utf8(all[..end].to_vec()).unwrap();
        let status = head.split(' ').nth(1).unwrap().parse().unwrap();
        Answer { status, head, body: all.split_off(end + 4) }
    }

    /// A request with the secret.
    fn ask(&self, method: &str, path: &str, body: &[u8]) -> Answer {
        let (port, secret, length) = (self.port, self.secret(), body.len());
        let head = format!(
            "{method} {path} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nAuthorization: Bearer {secret}\r\nContent-Length: {length}\r\n\r\n"
        );
        self.raw(&[head.as_bytes(), body].concat())
    }

    #[track_caller]
    fn get(&self, path: &str) -> Value {
        let answer = self.ask("GET", path, b"");
        assert_eq!(answer.status, 200, "{path}: {}", String::from_utf8_lossy(&answer.body));
        answer.json()
    }

    fn state(&self) -> Value {
        self.get("/api/state")
    }

    /// A model of the project as it is now, to be drawn.
    fn model(&self, index: usize) -> Answer {
        self.ask("GET", &format!("/api/model?index={index}&revision={}", self.state()["revision"]), b"")
    }

    /// A POST with the project's revision as it is; the new state.
    #[track_caller]
    fn post(&self, path: &str) -> Value {
        let answer = self.posted(path);
        assert_eq!(answer.status, 200, "{path}: {}", String::from_utf8_lossy(&answer.body));
        answer.json()
    }

    fn posted(&self, path: &str) -> Answer {
        let joint = if path.contains('?') { '&' } else { '?' };
        self.ask("POST", &format!("{path}{joint}revision={}", self.state()["revision"]), b"")
    }

    /// Hears the states until one is as wanted.
    #[track_caller]
    fn until(&self, what: &str, wanted: impl Fn(&Value) -> bool) -> Value {
        let mut stream = self.connect();
        let head = format!(
            "GET /api/events HTTP/1.1\r\nHost: localhost:{}\r\nAuthorization: Bearer {}\r\n\r\n",
            self.port,
            self.secret()
        );
        stream.write_all(head.as_bytes()).unwrap();
        for line in BufReader::new(stream).lines() {
            let line = line.unwrap();
            let Some(state) = line.strip_prefix("data: ") else { continue };
            let state: Value = serde_json::from_str(state).unwrap();
            if wanted(&state) {
                return state;
            }
        }
        panic!("{what} did not come");
    }

    /// Starts a job and waits for its end.
    #[track_caller]
    fn run(&self, task: &str) -> Value {
        self.post(&format!("/api/run?task={task}"));
        self.until(task, |state| state["runs"][task]["running"] == false)
    }

    fn file(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.folder.path().join(name)).unwrap()
    }
}

/// What the command line makes in another folder, with the models of this one.
fn by_hand(line: &str, models: &Path) -> tempfile::TempDir {
    let elsewhere = folder();
    for entry in std::fs::read_dir(models).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|end| end == "stl") {
            std::fs::copy(&path, elsewhere.path().join(path.file_name().unwrap())).unwrap();
        }
    }
    // A word in quotes holds no space here.
    let words = line.split(' ').skip(1).map(|word| word.trim_matches('\''));
    let done = trunnion().args(words).current_dir(elsewhere.path()).output().unwrap();
    assert!(done.status.success(), "{line}: {}", crate::support::said(&done));
    elsewhere
}
