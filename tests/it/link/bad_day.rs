//! What the world does to a print: a disk that runs full, a port of somebody else's, a printer with too few axes, files that ask
//! for too much.

use std::io::Read;
use std::net::TcpListener;
use std::path::Path;
use std::process::Stdio;

use super::real::{
    Running, executed, gcode, interrupt, killed, listened, output, profile, send, simulate, terminal, wait_for, wanted,
};
use crate::support::{Command, PATIENCE, SmallDisk, fails, folder, note, said, skip, states, trunnion};

#[test]
fn a_disk_that_runs_full_in_mid_print_is_a_pause_and_the_print_goes_on_when_there_is_room() {
    let dir = folder();
    let Some(disk) = SmallDisk::mount(dir.path().join("small"), 65_536) else {
        skip("disk full in mid-print: this user may not mount a small file system");
        return;
    };
    let (profile, gcode) = (profile(dir.path()), gcode(dir.path(), 30_000));
    let (link, log) = (dir.path().join("tty"), dir.path().join("sim.log"));
    let (journal, filler) = (disk.0.join("journal"), disk.0.join("filler"));
    // Three pages are left: the journal takes two at once.
    std::fs::write(&filler, [1; 53_248]).unwrap();
    let _printer = simulate(&link, &profile, &["--speed", "max", "--log", log.to_str().unwrap()]);
    let paused = output(send(&gcode, &profile, &link).arg("--journal").arg(&journal));
    assert_eq!(paused.status.code(), Some(4), "{}", said(&paused));
    let words = said(&paused);
    assert!(fails(&words, "job/printer: disk | paused | free some"), "{words}");
    let lines = executed(&log);
    let up = lines.iter().rev().find(|l| l.starts_with("G1Z")).unwrap();
    assert!(lines.last() == Some(up), "the head has left the part last of all: {:?}", &lines[lines.len() - 5..]);
    // Still no room: the same again, without a move on the part.
    let again = output(send(&gcode, &profile, &link).arg("--resume").arg("--journal").arg(&journal));
    assert!(matches!(again.status.code(), Some(2 | 4)) && said(&again).contains("journal"), "{}", said(&again));
    assert_eq!(executed(&log), lines);
    std::fs::remove_file(&filler).unwrap();
    let done = output(send(&gcode, &profile, &link).arg("--resume").arg("--journal").arg(&journal));
    assert!(done.status.success(), "{}", said(&done));
    let (all, lines) = (wanted(&gcode), executed(&log));
    let mut rest = all.iter().peekable();
    for line in &lines {
        rest.next_if(|w| *w == line);
    }
    assert_eq!(rest.count(), 0, "a line is missing");
    assert!(lines.len() - all.len() < 25, "{} lines more than the file has", lines.len() - all.len());
}

/// The pause came without a Ctrl-C, so that the first is already what its words say.
#[test]
fn in_a_pause_from_a_full_disk_one_ctrl_c_is_an_emergency_stop() {
    let dir = folder();
    let Some(disk) = SmallDisk::mount(dir.path().join("small"), 65_536) else {
        skip("ctrl-c in a pause from a full disk: this user may not mount a small file system");
        return;
    };
    let (profile, gcode) = (profile(dir.path()), gcode(dir.path(), 30_000));
    let (link, log) = (dir.path().join("tty"), dir.path().join("sim.log"));
    std::fs::write(disk.0.join("filler"), [1; 53_248]).unwrap();
    let _printer = simulate(&link, &profile, &["--speed", "max", "--log", log.to_str().unwrap()]);
    let (_keys, screen) = terminal();
    let mut host = send(&gcode, &profile, &link);
    let host = host.arg("--journal").arg(disk.0.join("journal")).stdin(screen).stderr(Stdio::piped()).spawn().unwrap();
    let mut host = Running(host);
    let words = listened(&mut host.0);
    wait_for("the pause", || words.lock().unwrap().contains("Ctrl-C (emergency stop)"));
    assert!(states(&words.lock().unwrap(), "disk space | journal") && !killed(&log));
    interrupt(&host.0);
    wait_for("the emergency stop", || killed(&log));
    assert_eq!(host.0.wait().unwrap().code(), Some(4), "{}", words.lock().unwrap());
}

#[test]
fn a_link_that_opens_and_closes_again_and_again_is_given_up() {
    let dir = folder();
    let (profile, gcode) = (profile(dir.path()), gcode(dir.path(), 10));
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = format!("tcp:{}", listener.local_addr().unwrap());
    std::thread::spawn(move || listener.incoming().for_each(drop));
    let given_up = output(send(&gcode, &profile, Path::new(&port)).args(["--wait", "2"]));
    assert_eq!(given_up.status.code(), Some(4), "{}", said(&given_up));
    assert!(fails(&said(&given_up), "job/printer: 2 s"), "{}", said(&given_up));
}

#[test]
fn a_port_of_another_user_says_what_to_do() {
    let dir = folder();
    let (profile, gcode) = (profile(dir.path()), gcode(dir.path(), 10));
    let link = dir.path().join("tty");
    let _printer = simulate(&link, &profile, &[]);
    let other = || {
        let mut command = Command::new("setpriv");
        command.args(["--reuid=65534", "--clear-groups"]).arg(env!("CARGO_BIN_EXE_trunnion"));
        command
    };
    if !other().arg("--version").output().is_ok_and(|d| d.status.success()) {
        skip("permission denied: this user may not become another");
        return;
    }
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // It is the port that is to be denied, not the journal, which is asked for before.
        std::fs::set_permissions(dir.path(), std::fs::Permissions::from_mode(0o777)).unwrap();
    }
    let mut command = other();
    command.arg("send").arg(&gcode).args(["--unverified", "-m"]).arg(&profile).arg("--port").arg(&link);
    let denied = output(&mut command);
    assert_eq!(denied.status.code(), Some(4), "{}", said(&denied));
    assert!(fails(&said(&denied), "port/denied: tty | sudo adduser $USER dialout"), "{}", said(&denied));
}

#[test]
fn a_printer_with_too_few_axes_is_not_printed_on() {
    let dir = folder();
    let (profile, gcode) = (profile(dir.path()), gcode(dir.path(), 10));
    let (link, log) = (dir.path().join("tty"), dir.path().join("sim.log"));
    let _printer = simulate(&link, &profile, &["--quirk", "three-axes", "--log", log.to_str().unwrap()]);
    let refused = output(&mut send(&gcode, &profile, &link));
    assert_eq!(refused.status.code(), Some(4), "{}", said(&refused));
    assert!(fails(&said(&refused), "job/printer: AXIS_COUNT:3 | 5 axes (X Y Z A C)"), "{}", said(&refused));
    assert!(executed(&log).is_empty());
}

#[test]
fn more_heat_or_travel_than_the_machine_has_is_refused_before_the_first_byte() {
    let dir = folder();
    let profile = profile(dir.path());
    let file = dir.path().join("asks.gcode");
    let ask = |text: &str, machine: &Path| {
        std::fs::write(&file, text).unwrap();
        output(trunnion().arg("send").arg(&file).args(["--unverified", "--dry-run", "-m"]).arg(machine))
    };
    let hot = "G28\nM109 S300\nG1 X1 F600\n";
    for (text, words) in [
        (
            hot,
            "line 2: 300 C for the nozzle, but the profile allows at most 260 C ([link] max_nozzle_c); nothing was sent",
        ),
        ("G28\nM190 S200\n", "line 2: 200 C for the bed"),
        ("G28\nG1 X5 F600\nG1 X9999\n", "line 3: X 9999 is outside the machine's range, "),
        ("G28\nG1 A120 F600\n", "line 2: A 120 is outside"),
    ] {
        let done = ask(text, &profile);
        assert!(done.status.code() == Some(1) && said(&done).contains(words), "{:?} {}", done.status, said(&done));
    }
    let hotter = dir.path().join("hotter.toml");
    std::fs::write(&hotter, "extends = \"generic-ac\"\n[link]\nmax_nozzle_c = 320\n").unwrap();
    let done = ask(hot, &hotter);
    assert!(done.status.success(), "{}", said(&done));
}

#[test]
fn a_link_that_is_too_slow_is_said_before_the_print() {
    let dir = folder();
    let profile = profile(dir.path());
    let file = dir.path().join("fine.gcode");
    let moves: String =
        (0..400).map(|i| format!("G1 X{:.3} Y50.125 Z10.205 A31.125 C120.245\n", f64::from(i) * 0.1)).collect();
    std::fs::write(&file, format!("G28\nG1 X0 Y50.125 Z10.205 F3600\nG1 A31.125\nG1 C120.245\n{moves}")).unwrap();
    let rehearse = |baud: &str| {
        let mut command = trunnion();
        command.arg("send").arg(&file).args(["--unverified", "--dry-run", "--baud", baud, "-m"]).arg(&profile);
        let done = output(&mut command);
        assert!(done.status.success(), "{}", said(&done));
        said(&done)
    };
    for (baud, least, most) in [("115200", 200.0, 300.0), ("250000", 450.0, 600.0)] {
        let words = rehearse(baud);
        let (before, behind) =
            words.split_once("0.10 mm segments at 60 mm/s need 600 lines/s, but this link carries ").unwrap();
        let carried: f64 = behind.split_once(' ').unwrap().0.parse().unwrap();
        assert!((least..most).contains(&carried), "{baud}: {carried}");
        assert!(!before.contains("rehearsal") && behind.contains("rehearsal"), "{words}");
    }
    assert!(!rehearse("1000000").contains("lines/s"));
}

/// Bytes of memory at most so far, from Linux's `/proc`; `None` elsewhere.
fn peak(id: u32) -> Option<u64> {
    let status = std::fs::read_to_string(format!("/proc/{id}/status")).ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    Some(line.trim().strip_suffix(" kB")?.trim().parse::<u64>().ok()? * 1024)
}

/// What is in memory when the first byte goes out, for files of two sizes; a file of 1 GiB, the largest, follows from that.
#[test]
fn memory_grows_with_the_file_by_a_small_factor() {
    let dir = folder();
    let profile = profile(dir.path());
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = format!("tcp:{}", listener.local_addr().unwrap());
    let file = dir.path().join("big.gcode");
    let mut measured = Vec::new();
    for lines in [100_000_u32, 500_000] {
        let moves: String =
            (0..lines).map(|i| format!("G1 X{} Y{:.3} E0.02153\n", i % 97, f64::from(i % 9973) * 0.01)).collect();
        std::fs::write(&file, format!("G28\nG1 F3000\n{moves}")).unwrap();
        let mut host = send(&file, &profile, Path::new(&port));
        let host = Running(host.stdin(Stdio::null()).stderr(Stdio::null()).spawn().unwrap());
        let (mut wire, _) = listener.accept().unwrap();
        wire.set_read_timeout(Some(PATIENCE)).unwrap();
        wire.read_exact(&mut [0; 4]).unwrap();
        let Some(bytes) = peak(host.0.id()) else {
            skip("memory: this system does not say how much a process has");
            return;
        };
        measured.push((std::fs::metadata(&file).unwrap().len() as f64, bytes as f64));
    }
    let [(small, few), (big, many)] = measured[..] else { panic!("{measured:?}") };
    let factor = (many - few) / (big - small);
    note(&format!("{:.1} MB of file: {:.1} MB of memory; {factor:.2} bytes a byte", big / 1e6, many / 1e6));
    assert!(factor < 4.0, "{factor:.2} bytes of memory a byte of file");
}
