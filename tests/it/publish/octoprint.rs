//! The real OctoPrint, on loopback with its virtual printer.

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

use super::scissors::scissors;
use super::{KEY, done, fails, of, prepared, publish};
use crate::support::{PATIENCE, SmallDisk, folder, note, python, root, skip};

/// Its own files come and go within this: no more than a guard, a busy machine is waited for.
const SETTLES: Duration = PATIENCE;
/// So often it is started: between our look for a free port and its own binding somebody else may take it.
const STARTS: usize = 3;

/// The server, which ends with its owner.
struct OctoPrint {
    child: Child,
    address: SocketAddr,
    uploads: PathBuf,
    /// What it says of itself.
    log: PathBuf,
}

impl Drop for OctoPrint {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
        if std::thread::panicking() {
            note(&format!("OctoPrint's last words:\n{}", self.last_words()));
        }
    }
}

impl OctoPrint {
    fn start(python: &Path, base: &Path, uploads: &Path) -> Self {
        let (config, log) = (base.join("config.yaml"), base.join("console.log"));
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
            let log = std::fs::File::options().create(true).append(true).open(&log).unwrap();
            let mut command = Command::new(python);
            command.args(["-m", "octoprint", "-b"]).arg(base).arg("-c").arg(&config);
            command.stdin(Stdio::null()).stdout(log.try_clone().unwrap()).stderr(log);
            command
        };
        let added = command().args(["user", "add", "me", "--password", "me", "--admin"]).status().unwrap();
        assert!(added.success(), "no user could be added: {}", std::fs::read_to_string(&log).unwrap());
        for _ in 0..STARTS {
            let address = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
            let (host, port) = ("127.0.0.1", address.port().to_string());
            let mut serve = command();
            serve.args(["serve", "--iknowwhatimdoing", "--host", host, "--port", &port]);
            let child = serve.spawn().unwrap();
            let mut server = Self { child, address, uploads: uploads.to_owned(), log: log.clone() };
            if server.comes() {
                return server;
            }
            note(&format!("OctoPrint ended before it answered:\n{}", server.last_words()));
        }
        panic!("OctoPrint does not start");
    }

    /// Whether it answers before it ends.
    fn comes(&mut self) -> bool {
        let until = Instant::now() + PATIENCE;
        while Instant::now() < until && self.child.try_wait().unwrap().is_none() {
            if self.ask("GET", "/api/printer", "").0 == 200 {
                return true;
            }
            std::thread::sleep(Duration::from_millis(200));
        }
        false
    }

    fn last_words(&self) -> String {
        let said = std::fs::read(&self.log).unwrap_or_default();
        String::from_utf8_lossy(&said[said.len().saturating_sub(6000)..]).into_owned()
    }

    fn wait(&self, what: &str, mut there: impl FnMut() -> bool) {
        let until = Instant::now() + PATIENCE;
        while !there() {
            assert!(Instant::now() < until, "{what} did not come");
            std::thread::sleep(Duration::from_millis(200));
        }
    }

    fn to(&self) -> String {
        format!("octoprint:http://{}", self.address)
    }

    /// A request of our own, which shares nothing with what is tested; status 0 where there is no answer.
    fn ask(&self, method: &str, path: &str, body: &str) -> (u16, Vec<u8>) {
        let head = format!(
            "{method} {path} HTTP/1.0\r\nHost: {}\r\nX-Api-Key: {KEY}\r\nContent-Type: application/json\r\n\
             Content-Length: {}\r\n\r\n{body}",
            self.address,
            body.len()
        );
        let answer = TcpStream::connect(self.address).and_then(|mut stream| {
            stream.set_read_timeout(Some(PATIENCE))?;
            stream.write_all(head.as_bytes())?;
            let mut answer = Vec::new();
            // A connection that is reset behind its answer has answered.
            let _ = stream.read_to_end(&mut answer);
            Ok(answer)
        });
        let answer = answer.unwrap_or_default();
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

    /// That its folder holds these files. It writes what it knows of them by way of a file called `tmp..` in the same folder, so
    /// one look may see more.
    #[track_caller]
    fn holds(&self, wanted: &[&str]) {
        let until = Instant::now() + SETTLES;
        loop {
            let names = std::fs::read_dir(&self.uploads).unwrap();
            let names = names.filter_map(|file| file.unwrap().file_name().into_string().ok());
            let mut names: Vec<String> = names.filter(|name| !name.starts_with('.')).collect();
            names.sort();
            if names == wanted {
                return;
            }
            assert!(Instant::now() < until, "it holds {names:?}, not {wanted:?}");
            std::thread::sleep(Duration::from_millis(50));
        }
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
        fails(publish(&server.to(), &[]).env("TRUNNION_KEY", "SECRET"), 4, "server/wrong-key");
        fails(publish(&server.to(), &[]).env_remove("TRUNNION_KEY"), 4, "server/no-key");
        server.holds(&[]);
        cut(server);
        let first = done(&mut publish(&server.to(), &[]));
        assert_eq!((&first["uploads"], &first["started"]), (&1.into(), &false.into()));
        let (status, bytes) = server.ask("GET", "/downloads/files/local/tree.gcode", "");
        assert!(status == 200 && bytes == made.bytes, "{status}, {} bytes", bytes.len());
        assert_eq!(done(&mut publish(&server.to(), &[]))["uploads"], 0, "it is there");
        server.holds(&["tree.gcode"]);
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
    server.holds(&["cut.gcode"]);
    let always = format!("octoprint:http://{}", scissors(server.address, 60_000, 99));
    fails(&mut publish(&always, &["--name", "never.gcode"]), 4, "server/closed");
    server.holds(&["cut.gcode"]);
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
    fails(&mut of(&other, &server.to(), &["--unverified"]), 4, "server/another: tree.gcode");
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
        fails(&mut of(&large, &server.to(), &["--unverified"]), 4, "server/full");
        server.holds(&["tree.gcode"]);
    }
}

fn started(server: &OctoPrint) {
    let sent = done(&mut publish(&server.to(), &["--start"]));
    assert_eq!((&sent["uploads"], &sent["started"]), (&0.into(), &true.into()));
    server.wait("the print", || server.state().starts_with("Printing"));
    fails(&mut publish(&server.to(), &["--start"]), 4, "server/printing: tree.gcode");
    // A file that is being printed is not taken from under the head.
    let folder = folder();
    let other = folder.path().join("tree.gcode");
    std::fs::write(&other, "G28\n").unwrap();
    fails(&mut of(&other, &server.to(), &["--unverified", "--replace"]), 4, "server/refused: 409");
    assert!(server.ask("GET", "/downloads/files/local/tree.gcode", "").1 == prepared().bytes);
    assert_eq!(server.ask("POST", "/api/job", "{\"command\": \"cancel\"}").0, 204);
}
