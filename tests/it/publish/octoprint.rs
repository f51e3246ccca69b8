//! The real OctoPrint, on loopback with its virtual printer.

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

use super::scissors::scissors;
use super::{KEY, done, fails, of, prepared, publish};
use crate::support::{SmallDisk, folder, note, python, root, skip};

/// Nothing here may take longer.
const LIMIT: Duration = Duration::from_secs(180);

/// The server, which ends with its owner.
struct OctoPrint {
    child: Child,
    address: SocketAddr,
    uploads: PathBuf,
}

impl Drop for OctoPrint {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl OctoPrint {
    fn start(python: &Path, base: &Path, uploads: &Path) -> Self {
        let address = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
        let config = base.join("config.yaml");
        let uploads = uploads.to_owned();
        let text = format!(
            "accessControl: {{autologinLocal: false}}\napi: {{key: {KEY}}}\nfolder: {{uploads: {}}}\n\
             server: {{firstRun: false, onlineCheck: {{enabled: false}}, pluginBlacklist: {{enabled: false}}}}\n\
             plugins: {{_disabled: [softwareupdate, announcements, discovery, tracking, errortracking, achievements, \
             health_check, pluginmanager, backup, corewizard], virtual_printer: {{enabled: true}}}}\n\
             serial: {{port: VIRTUAL, autoconnect: true}}\n",
            uploads.display()
        );
        std::fs::write(&config, text).unwrap();
        let command = || {
            let mut command = Command::new(python);
            command.args(["-m", "octoprint", "-b"]).arg(base).arg("-c").arg(&config);
            command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
            command
        };
        let added = command().args(["user", "add", "me", "--password", "me", "--admin"]).status().unwrap();
        assert!(added.success(), "no user could be added");
        let (host, port) = ("127.0.0.1", address.port().to_string());
        let child = command().args(["serve", "--iknowwhatimdoing", "--host", host, "--port", &port]).spawn().unwrap();
        let server = Self { child, address, uploads };
        server.wait("OctoPrint", || {
            TcpStream::connect(address).is_ok() && server.ask("GET", "/api/printer", "").0 == 200
        });
        server
    }

    fn wait(&self, what: &str, mut there: impl FnMut() -> bool) {
        let until = Instant::now() + LIMIT;
        while !there() {
            assert!(Instant::now() < until, "{what} did not come");
            std::thread::sleep(Duration::from_millis(200));
        }
    }

    fn to(&self) -> String {
        format!("octoprint:http://{}", self.address)
    }

    /// A request of our own, which shares nothing with what is tested.
    fn ask(&self, method: &str, path: &str, body: &str) -> (u16, Vec<u8>) {
        let mut stream = TcpStream::connect(self.address).unwrap();
        let head = format!(
            "{method} {path} HTTP/1.0\r\nHost: {}\r\nX-Api-Key: {KEY}\r\nContent-Type: application/json\r\n\
             Content-Length: {}\r\n\r\n{body}",
            self.address,
            body.len()
        );
        stream.write_all(head.as_bytes()).unwrap();
        let mut answer = Vec::new();
        let _ = stream.read_to_end(&mut answer);
        let Some(end) = memchr::memmem::find(&answer, b"\r\n\r\n") else { return (0, Vec::new()) };
        let status = String::from_utf8_lossy(&answer[9..12]).parse().unwrap();
        (status, answer[end + 4..].to_vec())
    }

    fn file(&self, name: &str) -> Value {
        serde_json::from_slice(&self.ask("GET", &format!("/api/files/local/{name}"), "").1).unwrap_or_default()
    }

    fn state(&self) -> String {
        let job: Value = serde_json::from_slice(&self.ask("GET", "/api/job", "").1).unwrap_or_default();
        job["state"].as_str().unwrap_or_default().to_owned()
    }

    /// What stands in its folder.
    fn folder(&self) -> Vec<String> {
        let names = std::fs::read_dir(&self.uploads).unwrap().map(|f| f.unwrap().file_name().into_string().unwrap());
        let mut names: Vec<String> = names.filter(|name| !name.starts_with('.')).collect();
        names.sort();
        names
    }
}

fn real(test: impl FnOnce(&OctoPrint)) {
    let own = root().join(".venv/bin/python");
    let Some(python) = python(&[own.to_str().unwrap(), "python3"], "octoprint") else {
        return skip("OctoPrint is not installed: nothing is published to the real one");
    };
    let base = folder();
    let small = SmallDisk::mount(base.path().join("small"), 8 << 20);
    if small.is_none() {
        skip("no file system may be mounted: OctoPrint's disk is not full");
    }
    let uploads = base.path().join("small");
    let _ = std::fs::create_dir(&uploads);
    test(&OctoPrint::start(&python, base.path(), &uploads));
    if small.is_some() {
        drop(small);
    }
}

#[test]
fn the_real_octoprint_has_the_same_bytes_shows_our_filament_and_prints_when_asked() {
    real(|server| {
        let made = prepared();
        fails(publish(&server.to(), &[]).env("TRUNNION_KEY", "SECRET"), 4, "it refuses the key");
        fails(publish(&server.to(), &[]).env_remove("TRUNNION_KEY"), 4, "it wants a key");
        assert!(server.folder().is_empty(), "{:?}", server.folder());
        cut(server);
        let first = done(&mut publish(&server.to(), &[]));
        assert_eq!((&first["uploads"], &first["started"]), (&1.into(), &false.into()));
        let (status, bytes) = server.ask("GET", "/downloads/files/local/tree.gcode", "");
        assert!(status == 200 && bytes == made.bytes, "{status}, {} bytes", bytes.len());
        assert_eq!(done(&mut publish(&server.to(), &[]))["uploads"], 0, "it is there");
        assert_eq!(server.folder(), ["tree.gcode"]);
        analysed(server);
        another(server);
        full(server);
        started(server);
    });
}

/// A connection that is cut on its way: once, and always.
fn cut(server: &OctoPrint) {
    let once = scissors(server.address, 60_000, 1);
    let sent = done(&mut publish(&format!("octoprint:http://{once}"), &["--name", "cut.gcode"]));
    assert_eq!(sent["uploads"], 2);
    assert_eq!(server.folder(), ["cut.gcode"]);
    let always = format!("octoprint:http://{}", scissors(server.address, 60_000, 99));
    fails(&mut publish(&always, &["--name", "never.gcode"]), 4, "closes the connection half way");
    assert_eq!(server.folder(), ["cut.gcode"], "nothing half is left");
    assert_eq!(server.ask("DELETE", "/api/files/local/cut.gcode", "").0, 204);
}

/// What its own analysis says of our file.
fn analysed(server: &OctoPrint) {
    let report = &prepared().report;
    server.wait("the analysis", || server.file("tree.gcode")["gcodeAnalysis"]["filament"]["tool0"].is_object());
    let file = server.file("tree.gcode");
    let length = file["gcodeAnalysis"]["filament"]["tool0"]["length"].as_f64().unwrap();
    let wanted = report["filament_mm"].as_f64().unwrap();
    assert!((length / wanted - 1.0).abs() < 0.01, "{length} mm by its analysis, {wanted} mm by ours");
    let (theirs, ours) = (file["gcodeAnalysis"]["estimatedPrintTime"].as_f64(), report["seconds_print"].as_f64());
    let (theirs, ours) = (theirs.unwrap(), ours.unwrap());
    note(&format!("OctoPrint's analysis: {length:.1} mm against {wanted:.1}, {theirs:.0} s against {ours:.0}"));
    let shown = done(&mut publish(&server.to(), &[]))["shown"].clone();
    assert_eq!((shown["seconds_print"].as_f64(), shown["filament_mm"].as_f64()), (Some(theirs), Some(length)));
    assert_eq!(file["userdata"]["trunnion"]["seconds_print"].as_f64(), Some(ours), "{file}");
}

fn another(server: &OctoPrint) {
    let folder = folder();
    let other = folder.path().join("tree.gcode");
    std::fs::write(&other, "G28\n").unwrap();
    fails(&mut of(&other, &server.to(), &["--unverified"]), 4, "it has another file called tree.gcode");
    assert!(server.ask("GET", "/downloads/files/local/tree.gcode", "").1 == prepared().bytes);
    assert_eq!(done(&mut of(&other, &server.to(), &["--unverified", "--replace"]))["uploads"], 1);
    assert_eq!(server.ask("GET", "/downloads/files/local/tree.gcode", "").1, b"G28\n");
    done(&mut publish(&server.to(), &["--replace"]));
}

/// A file that does not go on its disk.
fn full(server: &OctoPrint) {
    let folder = folder();
    let large = folder.path().join("large.gcode");
    std::fs::write(&large, "G1 X10 Y10 F3000 ; a line of a large file\n".repeat(300_000)).unwrap();
    let disk: Value = serde_json::from_slice(&server.ask("GET", "/api/files/local", "").1).unwrap();
    if disk["free"].as_u64().unwrap() < 12_000_000 {
        fails(&mut of(&large, &server.to(), &["--unverified"]), 4, "its disk is full");
        assert_eq!(server.folder(), ["tree.gcode"], "nothing half is left");
    }
}

fn started(server: &OctoPrint) {
    let sent = done(&mut publish(&server.to(), &["--start"]));
    assert_eq!((&sent["uploads"], &sent["started"]), (&0.into(), &true.into()));
    server.wait("the print", || server.state().starts_with("Printing"));
    fails(&mut publish(&server.to(), &["--start"]), 4, "it is printing tree.gcode");
    // A file that is being printed is not taken from under the head.
    let folder = folder();
    let other = folder.path().join("tree.gcode");
    std::fs::write(&other, "G28\n").unwrap();
    fails(&mut of(&other, &server.to(), &["--unverified", "--replace"]), 4, "it refuses the upload with 409");
    assert!(server.ask("GET", "/downloads/files/local/tree.gcode", "").1 == prepared().bytes);
    assert_eq!(server.ask("POST", "/api/job", "{\"command\": \"cancel\"}").0, 204);
}
