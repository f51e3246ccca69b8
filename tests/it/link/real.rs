//! The two commands at both ends of a real pseudo-terminal: a host that is killed, a printer that goes and comes back, and
//! everything a user can get wrong.

use std::io::{Read, Write};
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::process::{Child, Output, Stdio};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

pub(super) use crate::support::wait_for;
use crate::support::{Command, Numbers, PATIENCE, catches_interrupts, fails, folder, note, said, trunnion};

/// A process that ends with its owner.
pub(crate) struct Running(pub(crate) Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A simulated printer. Its link goes before it does: to a terminal of that number, which the next printer of another test may have, a
/// host that waits for this one would find its way.
pub(crate) struct Printer {
    link: PathBuf,
    pub(super) running: Running,
}

impl Drop for Printer {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.link);
    }
}

/// A simulated printer behind `link`.
pub(crate) fn simulate(link: &Path, profile: &Path, more: &[&str]) -> Printer {
    let _ = std::fs::remove_file(link);
    let mut command = trunnion();
    command.args(["simulate", "-q", "--heat", "50", "-m"]).arg(profile).arg("--link").arg(link).args(more);
    let child = command.stderr(Stdio::null()).spawn().unwrap();
    let printer = Printer { link: link.to_owned(), running: Running(child) };
    wait_for("the link", || link.exists());
    printer
}

/// Runs to its end, or is killed.
pub(super) fn output(command: &mut Command) -> Output {
    let mut child = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let (mut out, mut err) = (child.stdout.take().unwrap(), child.stderr.take().unwrap());
    let read_err = std::thread::spawn(move || {
        let mut text = Vec::new();
        let _ = err.read_to_end(&mut text);
        text
    });
    let read_out = std::thread::spawn(move || {
        let mut text = Vec::new();
        let _ = out.read_to_end(&mut text);
        text
    });
    let until = Instant::now() + PATIENCE;
    let status = loop {
        if let Some(status) = child.try_wait().unwrap() {
            break status;
        }
        if Instant::now() > until {
            let _ = child.kill();
        }
        std::thread::sleep(Duration::from_millis(5));
    };
    let output = Output { status, stdout: read_out.join().unwrap(), stderr: read_err.join().unwrap() };
    command.heard(&output);
    output
}

/// Ctrl-C.
pub(crate) fn interrupt(host: &Child) {
    let done = Command::new("kill").args(["-INT", &host.id().to_string()]).status().expect("a kill command");
    assert!(done.success());
}

/// Whether the printer has had an emergency stop.
pub(crate) fn killed(log: &Path) -> bool {
    std::fs::read_to_string(log).unwrap().contains(" killed")
}

/// What a running host says on stderr, as it comes.
pub(super) fn listened(host: &mut Child) -> Arc<Mutex<String>> {
    let mut words = host.stderr.take().unwrap();
    let text = Arc::new(Mutex::new(String::new()));
    let heard = Arc::clone(&text);
    std::thread::spawn(move || {
        let mut bytes = [0; 1024];
        while let Ok(n) = words.read(&mut bytes)
            && n > 0
        {
            heard.lock().unwrap().push_str(&String::from_utf8_lossy(&bytes[..n]));
        }
    });
    text
}

/// A keyboard, and the terminal that it belongs to.
pub(super) fn terminal() -> (std::fs::File, std::fs::File) {
    use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
    let keys = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC).unwrap();
    grantpt(&keys).unwrap();
    unlockpt(&keys).unwrap();
    let name = ptsname(&keys, Vec::new()).unwrap().into_string().unwrap();
    let screen = std::fs::OpenOptions::new().read(true).write(true).open(name).unwrap();
    (std::fs::File::from(keys), screen)
}

/// A profile whose machine can home with a part on its table.
pub(crate) fn profile(folder: &Path) -> PathBuf {
    let path = folder.join("machine.toml");
    // A machine that somebody has looked at.
    let machine =
        "[machine]\nname = \"bench\"\njogged = \"2026-01-01\"\njogged_as = \"bench: A about X +1, level at 0; C +1\"\n";
    let text = format!("extends = \"generic-ac\"\n{machine}[head]\nmeasured = true\n[link]\nrehome = \"G28\"\n");
    std::fs::write(&path, text).unwrap();
    path
}

/// Every move different, in layers, at known poses.
pub(crate) fn gcode(folder: &Path, moves: u32) -> PathBuf {
    let mut text = "G21\nG90\nM83\nG28\nG1 A0 F600\nG1 C0 F600\nM104 S200\nM109 S200\nG1 F3000\n".to_owned();
    for i in 0..moves {
        if i % 40 == 0 {
            text += &format!(";LAYER_CHANGE\nG1 Z{:.4}\n", 1.0 + f64::from(i) * 0.005);
        }
        text += &format!("G1 X{} Y{:.3} E{:.5}\n", i % 7, f64::from(i) * 0.001, 0.02 + f64::from(i) * 1e-5);
    }
    let path = folder.join("part.gcode");
    std::fs::write(&path, text).unwrap();
    path
}

pub(super) fn send(gcode: &Path, profile: &Path, port: &Path) -> Command {
    let mut command = trunnion();
    command.arg("send").arg(gcode).args(["--unverified", "-m"]).arg(profile).arg("--port").arg(port);
    command
}

/// The words of a block without blanks or needless digits, so that both ends' ways of writing compare equal.
pub(super) fn plain(line: &str) -> String {
    let code = line.split(';').next().unwrap();
    let mut out = String::new();
    for word in code.replace('E', " E").split_whitespace() {
        out += word;
    }
    let mut words = String::new();
    let mut number = String::new();
    for c in out.chars().chain(std::iter::once('\n')) {
        if c.is_ascii_digit() || matches!(c, '.' | '-') {
            number.push(c);
            continue;
        }
        if !number.is_empty() {
            words += &number.parse::<f64>().unwrap().to_string();
            number.clear();
        }
        words.push(c);
    }
    words.trim().to_owned()
}

pub(crate) fn wanted(gcode: &Path) -> Vec<String> {
    let text = std::fs::read_to_string(gcode).unwrap();
    text.lines().filter(|l| !l.is_empty() && !l.starts_with(';')).map(plain).collect()
}

/// What the printer's log says it executed, its housekeeping left out.
pub(crate) fn executed(log: &Path) -> Vec<String> {
    let text = std::fs::read_to_string(log).unwrap();
    let own = ["M105", "M110", "M115", "M400", "M114"];
    let lines = text.lines().filter_map(|l| l.split_once(" line ").map(|(_, block)| block));
    lines.filter(|l| !own.iter().any(|o| l.starts_with(o))).map(plain).collect()
}

#[track_caller]
pub(super) fn assert_same(wanted: &[String], executed: &[String]) {
    let first = wanted.iter().zip(executed).position(|(w, e)| w != e);
    assert!(
        wanted == executed,
        "{} wanted, {} executed, first difference {first:?}: {:?}",
        wanted.len(),
        executed.len(),
        first.map(|i| (&wanted[i], &executed[i]))
    );
}

#[test]
fn a_file_goes_over_the_pty_and_over_tcp() {
    let dir = folder();
    let (profile, gcode) = (profile(dir.path()), gcode(dir.path(), 400));
    let (link, log) = (dir.path().join("tty"), dir.path().join("sim.log"));
    let printer = simulate(&link, &profile, &["--speed", "max", "--log", log.to_str().unwrap()]);
    let done = output(send(&gcode, &profile, &link).arg("--json"));
    assert!(done.status.success(), "{}", said(&done));
    assert_same(&wanted(&gcode), &executed(&log));
    let events = String::from_utf8_lossy(&done.stdout).into_owned();
    let names: Vec<String> = events
        .lines()
        .map(|l| serde_json::from_str::<serde_json::Value>(l).unwrap()["event"].as_str().unwrap().to_owned())
        .collect();
    assert_eq!((names.first().map(String::as_str), names.last().map(String::as_str)), (Some("start"), Some("done")));
    drop(printer);
    let mut tcp = trunnion();
    tcp.args(["simulate", "--heat", "50", "--speed", "max", "-m"])
        .arg(&profile)
        .args(["--link", "tcp:0"])
        .stderr(Stdio::piped());
    let mut printer = Running(tcp.spawn().unwrap());
    let mut text = [0_u8; 200];
    let n = printer.0.stderr.as_mut().unwrap().read(&mut text).unwrap();
    let words = String::from_utf8_lossy(&text[..n]).into_owned();
    let port =
        words.split("(tcp:").nth(1).and_then(|t| t.split(')').next()).unwrap_or_else(|| panic!("{words}")).to_owned();
    assert!(port.starts_with("127.0.0.1:"), "this machine only by default: {port}");
    let done = output(&mut send(&gcode, &profile, Path::new(&format!("tcp:{port}"))));
    assert!(done.status.success(), "{}", said(&done));
}

#[test]
fn a_host_killed_at_20_random_moments_prints_the_same_program() {
    let dir = folder();
    let (profile, gcode) = (profile(dir.path()), gcode(dir.path(), 4000));
    let (link, log) = (dir.path().join("tty"), dir.path().join("sim.log"));
    let _printer = simulate(&link, &profile, &["--speed", "30", "--log", log.to_str().unwrap()]);
    let mut numbers = Numbers::seeded(20);
    let journal = dir.path().join("part.gcode.journal");
    // Within the first half of the print, whose other half takes seconds: none of them comes behind its end.
    let most = wanted(&gcode).len() as f64 / 40.0;
    for kill in 0..20 {
        let mut command = send(&gcode, &profile, &link);
        // The first may be killed before it has begun.
        if journal.exists() {
            command.arg("--resume");
        }
        let mut host = Running(command.stdin(Stdio::null()).stderr(Stdio::null()).spawn().unwrap());
        let before = if log.exists() { executed(&log).len() } else { 0 };
        let until = before + numbers.between(0.0, most) as usize;
        // Every fourth while it begins, the others while it prints.
        if kill % 4 > 0 {
            wait_for("the print", || {
                host.0.try_wait().unwrap().is_some() || (log.exists() && executed(&log).len() >= until)
            });
        }
        std::thread::sleep(Duration::from_secs_f64(numbers.between(0.0, 0.1)));
        assert!(host.0.try_wait().unwrap().is_none(), "kill {kill}: the print ended before it");
        drop(host);
    }
    assert!(executed(&log).len() < wanted(&gcode).len(), "the print ended before the last kill");
    let done = output(send(&gcode, &profile, &link).arg("--resume"));
    assert!(done.status.success(), "{}", said(&done));
    assert_same(&wanted(&gcode), &executed(&log));
    note(&format!("{} lines, 20 kills: none missing, none doubled", wanted(&gcode).len()));
    let again = output(send(&gcode, &profile, &link).arg("--resume"));
    assert!(!again.status.success() && said(&again).contains("is complete"), "{}", said(&again));
}

#[test]
fn usb_gone_and_back_under_another_path() {
    // Where nobody was quick enough to take the number, the device is back under the same path, and nothing was tried.
    assert!((0..5).any(|_| usb_gone_and_back()), "the device never had another path");
}

/// Whether the device came back under another path, on which the print went on.
fn usb_gone_and_back() -> bool {
    let dir = folder();
    let (profile, gcode) = (profile(dir.path()), gcode(dir.path(), 600));
    let (link, log, names) = (dir.path().join("tty"), dir.path().join("sim.log"), dir.path().join("by-id"));
    let _printer =
        simulate(&link, &profile, &["--speed", "20", "--fault", "hang-up@300", "--log", log.to_str().unwrap()]);
    std::fs::create_dir(&names).unwrap();
    std::os::unix::fs::symlink(&link, names.join("usb-bench-0001")).unwrap();
    // The device itself, so that only its identity can find it again.
    let device = std::fs::read_link(&link).unwrap();
    let mut host = send(&gcode, &profile, &device);
    host.arg("--json").arg("--devices").arg(&names).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let host = host.spawn().unwrap();
    wait_for("the hang-up", || !link.exists());
    // Somebody else takes the number, once the simulator has let go of it; another test may be quicker.
    wait_for("the device's end", || !device.exists() || link.exists());
    let others: Vec<_> = (0..2).map(|_| stranger()).collect();
    let done = host.wait_with_output().unwrap();
    assert!(done.status.success(), "{}", said(&done));
    assert!(
        said(&done).contains("\"event\":\"lost\"") && said(&done).contains("\"event\":\"resumed\""),
        "{}",
        said(&done)
    );
    assert_same(&wanted(&gcode), &executed(&log));
    for (mut other, path) in others.into_iter().filter(|(_, path)| *path == device) {
        // A terminal that was opened and left says so, one that was written to gives what was written.
        let heard = other.read(&mut [0; 64]).map_err(|e| e.kind());
        assert_eq!(heard, Err(std::io::ErrorKind::WouldBlock), "{}: another device was opened", path.display());
    }
    std::fs::read_link(&link).unwrap() != device
}

/// Another device: whoever looks for a lost one must leave it alone.
fn stranger() -> (std::fs::File, PathBuf) {
    use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
    let other = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC).unwrap();
    rustix::io::ioctl_fionbio(&other, true).unwrap();
    grantpt(&other).unwrap();
    unlockpt(&other).unwrap();
    let name = ptsname(&other, Vec::new()).unwrap().into_string().unwrap();
    (std::fs::File::from(other), PathBuf::from(name))
}

#[test]
fn a_printer_killed_and_back_is_re_entered_at_a_layer() {
    let dir = folder();
    let (profile, gcode) = (profile(dir.path()), gcode(dir.path(), 1200));
    let (link, log, second) = (dir.path().join("tty"), dir.path().join("1.log"), dir.path().join("2.log"));
    let printer = simulate(&link, &profile, &["--speed", "20", "--log", log.to_str().unwrap()]);
    let mut host = send(&gcode, &profile, &link);
    let host = host.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    wait_for("half of the print", || executed(&log).len() > 500);
    drop(printer);
    let _printer = simulate(&link, &profile, &["--speed", "max", "--log", second.to_str().unwrap()]);
    let stopped = host.wait_with_output().unwrap();
    assert_eq!(stopped.status.code(), Some(4), "{}", said(&stopped));
    assert!(said(&stopped).contains("was reset"), "{}", said(&stopped));
    assert!(executed(&second).is_empty(), "nothing may move after a reset");
    let asked = output(send(&gcode, &profile, &link).arg("--resume"));
    assert_eq!(asked.status.code(), Some(4), "{}", said(&asked));
    assert!(fails(&said(&asked), "job/refused: --yes") && said(&asked).contains("down to Z"), "{}", said(&asked));
    assert!(executed(&second).is_empty(), "nothing may move before somebody has agreed");
    let done = output(send(&gcode, &profile, &link).args(["--resume", "--yes"]));
    assert!(done.status.success(), "{}", said(&done));
    let (all, before, after) = (wanted(&gcode), executed(&log), executed(&second));
    let way: Vec<&String> =
        after.iter().take_while(|l| !all.contains(l) || l.starts_with("G28") || l.starts_with("G90")).collect();
    let tail = after.iter().rev().zip(all.iter().rev()).take_while(|(a, w)| a == w).count();
    let again = all.len() - tail;
    assert!(way.iter().any(|l| l.as_str() == "G28"), "{way:?}");
    // What was sent and not taken, the window's lines, may be left out.
    assert!(again <= before.len() + 5, "a line is missing: {again} > {}", before.len());
    assert!(before.len() < again + 50, "too much again: {again} of {}", before.len());
    // Safely: up before across, across before down.
    let of = |prefix: &str| after.iter().position(|l| l.starts_with(prefix)).unwrap();
    assert!(of("G1Z320") < of("G1X") && of("G28") < of("G1Z320"), "{:?}", &after[..20]);
}

#[test]
fn ports_that_are_missing_busy_or_no_ports_are_sentences() {
    let dir = folder();
    let (profile, gcode) = (profile(dir.path()), gcode(dir.path(), 3000));
    let refuses = |port: &Path, words: &str| {
        let done = output(&mut send(&gcode, &profile, port));
        assert!(done.status.code() == Some(4) && fails(&said(&done), words), "{:?} {}", done.status, said(&done));
    };
    refuses(&dir.path().join("nothing"), "port/missing: nothing");
    refuses(&gcode, &format!("port/other: {}", gcode.display()));
    refuses(Path::new("tcp:127.0.0.1:1"), "port/tcp: tcp:127.0.0.1:1");
    // What is there is not made a link of.
    let mut taken = trunnion();
    taken.args(["simulate", "-q", "-m"]).arg(&profile).arg("--link").arg(&gcode);
    let (done, wanted) =
        (output(&mut taken), format!("port/pseudo-terminal: {} | tcp:127.0.0.1:PORT", gcode.display()));
    assert!(done.status.code() == Some(4) && fails(&said(&done), &wanted), "{:?} {}", done.status, said(&done));
    let (link, log) = (dir.path().join("tty"), dir.path().join("sim.log"));
    let _printer = simulate(&link, &profile, &["--log", log.to_str().unwrap()]);
    let mut first = send(&gcode, &profile, &link);
    let _first = Running(first.stdin(Stdio::null()).stderr(Stdio::null()).spawn().unwrap());
    wait_for("the first host's print", || !executed(&log).is_empty());
    let second = output(send(&gcode, &profile, &link).arg("--journal").arg(dir.path().join("other")));
    assert!(second.status.code() == Some(4) && fails(&said(&second), "port/busy: tty"), "{}", said(&second));
}

#[test]
fn files_that_changed_are_too_big_unverified_or_forbidden_are_sentences() {
    let dir = folder();
    let (profile, gcode) = (profile(dir.path()), gcode(dir.path(), 400));
    let link = dir.path().join("tty");
    let refuses = |command: &mut Command, code: i32, words: &str| {
        let done = output(command);
        assert!(done.status.code() == Some(code) && fails(&said(&done), words), "{:?} {}", done.status, said(&done));
    };
    refuses(trunnion().arg("send").arg(&gcode).arg("--port").arg(&link), 2, "command/usage: --plan");
    let big = dir.path().join("big.gcode");
    std::fs::File::create(&big).unwrap().set_len((1 << 30) + 1).unwrap();
    refuses(&mut send(&big, &profile, &link), 2, "program/too-big: big.gcode | 1 GiB");
    let sly = dir.path().join("sly.gcode");
    std::fs::write(&sly, "G28\nM112\n").unwrap();
    refuses(&mut send(&sly, &profile, &link), 2, "program/forbidden: sly.gcode | line 2 | M112");
    // The file changes while it is printed: the print is not touched by that, but it cannot be resumed.
    let log = dir.path().join("sim.log");
    let _printer = simulate(&link, &profile, &["--speed", "20", "--log", log.to_str().unwrap()]);
    let all = wanted(&gcode);
    let mut host = send(&gcode, &profile, &link);
    let mut host = Running(host.stdin(Stdio::null()).stderr(Stdio::null()).spawn().unwrap());
    wait_for("the print", || executed(&log).len() > 50);
    std::fs::write(&gcode, "G28\n").unwrap();
    assert!(host.0.wait().unwrap().success());
    assert_same(&all, &executed(&log));
    refuses(send(&gcode, &profile, &link).arg("--resume"), 2, "job/program-changed: 4 | bytes");
}

#[test]
fn a_full_disk_another_printer_and_a_dead_one_are_sentences() {
    let dir = folder();
    let (profile, gcode) = (profile(dir.path()), gcode(dir.path(), 400));
    let link = dir.path().join("tty");
    let log = dir.path().join("sim.log");
    let printer = simulate(&link, &profile, &["--speed", "max", "--log", log.to_str().unwrap()]);
    let full = output(send(&gcode, &profile, &link).args(["--journal", "/dev/full"]));
    assert!(
        full.status.code() == Some(2) && fails(&said(&full), "file/no-output: /dev/full | device"),
        "{}",
        said(&full)
    );
    assert!(executed(&log).is_empty(), "nothing was sent");
    let other = dir.path().join("other.toml");
    std::fs::write(&other, "extends = \"generic-ac\"\n[link]\nidentity = \"UUID:ffff\"\n").unwrap();
    let wrong = output(&mut send(&gcode, &other, &link));
    assert!(wrong.status.code() == Some(4) && fails(&said(&wrong), "job/printer: \"UUID:ffff\""), "{}", said(&wrong));
    drop(printer);
    let _printer = simulate(&link, &profile, &["--fault", "fatal@1"]);
    let dead = output(&mut send(&gcode, &profile, &link));
    assert!(dead.status.code() == Some(4) && fails(&said(&dead), "job/printer: Thermal Runaway"), "{}", said(&dead));
}

#[test]
fn ctrl_c_is_a_safe_pause() {
    let dir = folder();
    let (profile, gcode) = (profile(dir.path()), gcode(dir.path(), 2000));
    let (link, log) = (dir.path().join("tty"), dir.path().join("sim.log"));
    let _printer = simulate(&link, &profile, &["--speed", "20", "--log", log.to_str().unwrap()]);
    let mut host = send(&gcode, &profile, &link);
    let host = host.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    wait_for("the print", || executed(&log).len() > 100);
    interrupt(&host);
    let paused = host.wait_with_output().unwrap();
    assert!(
        paused.status.code() == Some(4) && fails(&said(&paused), "job/printer: paused | line"),
        "{}",
        said(&paused)
    );
    let lines = executed(&log);
    let (up, z) = lines
        .iter()
        .rev()
        .find_map(|l| Some((l, l.strip_prefix("G1Z")?.split('F').next()?.parse::<f64>().ok()?)))
        .unwrap();
    assert!(z > 20.0, "the head has left the part: {up}");
    // Going on comes back to the part first, then takes up the next line.
    let done = output(send(&gcode, &profile, &link).arg("--resume"));
    assert!(done.status.success(), "{}", said(&done));
    let (all, done) = (wanted(&gcode), executed(&log));
    let mut rest = all.iter().peekable();
    for line in &done {
        rest.next_if(|w| *w == line);
    }
    assert_eq!(rest.count(), 0, "every line of the file came in order through pause and return");
    assert!(done.len() - all.len() < 25, "{} lines more than the file has", done.len() - all.len());
}

#[test]
fn a_second_ctrl_c_is_an_emergency_stop_in_the_middle_of_a_move() {
    let dir = folder();
    let profile = profile(dir.path());
    let (link, log, gcode) = (dir.path().join("tty"), dir.path().join("sim.log"), dir.path().join("slow.gcode"));
    // A pause would come after an hour.
    std::fs::write(&gcode, "G28\nG1 X0 Y0 F6000\nG1 X100 F1.6\nG1 X0\n").unwrap();
    let _printer = simulate(&link, &profile, &["--log", log.to_str().unwrap()]);
    let host = send(&gcode, &profile, &link).stdin(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let mut host = Running(host);
    let words = listened(&mut host.0);
    wait_for("the long move", || executed(&log).len() > 2);
    interrupt(&host.0);
    wait_for("the pause", || words.lock().unwrap().contains("Ctrl-C again"));
    assert!(!killed(&log) && host.0.try_wait().unwrap().is_none(), "{}", words.lock().unwrap());
    interrupt(&host.0);
    wait_for("the emergency stop", || killed(&log));
    assert_eq!(host.0.wait().unwrap().code(), Some(4));
    wait_for("its word", || fails(&words.lock().unwrap(), "job/printer: emergency stop"));
}

/// An emergency stop would have the printer reset for nothing.
#[test]
fn ctrl_c_before_anything_moves_or_heats_leaves_the_printer_as_it_is() {
    let dir = folder();
    let (profile, gcode) = (profile(dir.path()), gcode(dir.path(), 10));
    let (port, mut heard) = (TcpListener::bind("127.0.0.1:0").unwrap(), Vec::new());
    let address = format!("tcp:{}", port.local_addr().unwrap());
    let host = send(&gcode, &profile, Path::new(&address)).stdin(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let mut host = Running(host);
    let words = listened(&mut host.0);
    let (mut silent, _) = port.accept().unwrap();
    // It is spoken to, and says nothing.
    let mut some = [0; 64];
    while !String::from_utf8_lossy(&heard).contains("M110") {
        let count = silent.read(&mut some).unwrap();
        assert!(count > 0, "{}", words.lock().unwrap());
        heard.extend(&some[..count]);
    }
    interrupt(&host.0);
    let _ = silent.read_to_end(&mut heard);
    assert_eq!(host.0.wait().unwrap().code(), Some(4));
    wait_for("its word", || words.lock().unwrap().contains("unchanged"));
    let heard = String::from_utf8_lossy(&heard);
    assert!(!heard.contains("M112"), "{heard}");
}

/// The print's own thread hangs in its first word to a reader that does not read.
#[cfg(target_os = "linux")]
#[test]
fn a_second_ctrl_c_stops_the_printer_though_the_screen_takes_nothing() {
    let dir = folder();
    let (profile, gcode) = (profile(dir.path()), gcode(dir.path(), 2000));
    let (link, log) = (dir.path().join("tty"), dir.path().join("sim.log"));
    let _printer = simulate(&link, &profile, &["--log", log.to_str().unwrap()]);
    let (_reader, mut screen) = std::io::pipe().unwrap();
    screen.write_all(&[b'\n'; 65_536]).unwrap();
    let host = send(&gcode, &profile, &link).arg("--json").stdin(Stdio::null()).stdout(screen).spawn().unwrap();
    let host = Running(host);
    wait_for("the handler", || catches_interrupts(host.0.id()));
    wait_for("the emergency stop", || {
        interrupt(&host.0);
        std::thread::sleep(Duration::from_millis(50));
        killed(&log)
    });
    assert!(executed(&log).is_empty(), "the print had not begun");
}

/// The end of input, Ctrl-D, is not the Enter that continues.
#[test]
fn the_end_of_input_in_a_pause_moves_nothing() {
    let dir = folder();
    let (profile, gcode) = (profile(dir.path()), gcode(dir.path(), 2000));
    let (link, log) = (dir.path().join("tty"), dir.path().join("sim.log"));
    let _printer = simulate(&link, &profile, &["--speed", "20", "--log", log.to_str().unwrap()]);
    let (mut keys, terminal) = terminal();
    let host = send(&gcode, &profile, &link).stdin(terminal).stderr(Stdio::piped()).spawn().unwrap();
    let mut host = Running(host);
    let words = listened(&mut host.0);
    wait_for("the print", || executed(&log).len() > 100);
    interrupt(&host.0);
    wait_for("the pause", || words.lock().unwrap().contains("paused above"));
    let lines = executed(&log);
    keys.write_all(&[4]).unwrap();
    wait_for("the end", || host.0.try_wait().unwrap().is_some());
    assert_eq!(host.0.wait().unwrap().code(), Some(4), "{}", words.lock().unwrap());
    wait_for("its word", || fails(&words.lock().unwrap(), "job/printer: trunnion send --resume"));
    assert_eq!(executed(&log), lines, "nothing moves");
}
