//! What SIGTERM promises, `--resume` keeps, on printers that do not count their lines; and what it says where it cannot.

use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use super::real::{assert_same, executed, output, plain, send, simulate, wait_for};
use crate::support::{fails, folder, said, states};

/// A machine of `protocol` whose profile does not say how to home with a part on the table.
fn machine(dir: &Path, protocol: &str) -> PathBuf {
    let toml = format!(
        "extends = \"generic-ac\"\n[machine]\nname = \"{protocol}\"\n[link]\nprotocol = \"{protocol}\"\nlongest_line = 80\n"
    );
    let path = dir.join("machine.toml");
    std::fs::write(&path, toml).unwrap();
    path
}

/// Every move different, at a known pose.
fn part(dir: &Path, protocol: &str) -> PathBuf {
    let home = if protocol == "grbl" { "" } else { "G28\n" };
    let mut text = format!("G21\nG90\n{home}G1 A0 F600\nG1 C0 F600\nG1 X0 Y0 Z10 F3000\n");
    for i in 0..1500 {
        text += &format!("G1 X{} Y{:.3}\n", i % 7, f64::from(i) * 0.01);
    }
    let path = dir.join("part.gcode");
    std::fs::write(&path, text).unwrap();
    path
}

/// As a person does at Grbl's console before a print.
pub(super) fn home(link: &Path) {
    let mut port = std::fs::OpenOptions::new().read(true).write(true).open(link).unwrap();
    port.write_all(b"$H\n").unwrap();
    let mut text = String::new();
    let mut bytes = [0; 256];
    while !text.ends_with("ok\r\n") && !text.ends_with("ok\n") {
        let n = port.read(&mut bytes).unwrap();
        text += &String::from_utf8_lossy(&bytes[..n]);
    }
}

#[test]
fn a_terminated_print_goes_on_from_where_the_printer_stands() {
    for protocol in ["klipper", "rrf", "grbl"] {
        let dir = folder();
        let (machine, file) = (machine(dir.path(), protocol), part(dir.path(), protocol));
        let (link, log) = (dir.path().join("tty"), dir.path().join("sim.log"));
        let _printer = simulate(&link, &machine, &["--speed", "20", "--log", log.to_str().unwrap()]);
        if protocol == "grbl" {
            home(&link);
        }
        let mut host = send(&file, &machine, &link);
        let host = host.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        wait_for("the print", || executed(&log).len() > 300);
        assert!(Command::new("kill").args(["-TERM", &host.id().to_string()]).status().unwrap().success());
        let paused = host.wait_with_output().unwrap();
        let words = said(&paused);
        assert!(
            paused.status.code() == Some(4) && fails(&words, "job/printer: trunnion send --resume"),
            "{protocol}: {words}"
        );
        assert!(fails(&words, "job/printer: [link] rehome"), "{protocol}: {words}");
        let done = output(send(&file, &machine, &link).arg("--resume"));
        assert!(done.status.success() && states(&said(&done), "kept its position"), "{protocol}: {}", said(&done));
        let ours = |l: &&String| l.starts_with("G1X") && !l.contains('F');
        let text = std::fs::read_to_string(&file).unwrap();
        let all: Vec<String> = text.lines().map(plain).filter(|l| ours(&l)).collect();
        assert_same(&all, &executed(&log).iter().filter(ours).cloned().collect::<Vec<_>>());
    }
}

#[test]
fn a_resume_without_a_journal_says_where_it_looked() {
    let dir = folder();
    let (machine, file) = (machine(dir.path(), "klipper"), part(dir.path(), "klipper"));
    let lost = output(send(&file, &machine, &dir.path().join("tty")).arg("--resume"));
    let words = said(&lost);
    let journal = dir.path().join("part.gcode.journal");
    assert!(
        lost.status.code() == Some(2)
            && fails(&words, &format!("job/no-journal: {} | --journal FILE", journal.display())),
        "{:?} {words}",
        lost.status
    );
}

#[test]
fn the_rehearsal_ends_with_1_where_the_printer_would_leave_something_undone() {
    let dir = folder();
    let machine = dir.path().join("machine.toml");
    std::fs::write(&machine, "extends = \"generic-ac\"\n").unwrap();
    let file = dir.path().join("cold.gcode");
    let rehearse = |text: &str| {
        std::fs::write(&file, text).unwrap();
        output(send(&file, &machine, Path::new("nowhere")).arg("--dry-run"))
    };
    let cold = rehearse("G28\nM83\nG1 X5 F600\nG1 X9 E1\nG1 X12 E1\n");
    assert!(
        cold.status.code() == Some(1) && states(&said(&cold), "line 4 | cold extrusion prevented | 1 more"),
        "{:?} {}",
        cold.status,
        said(&cold)
    );
    let warm = rehearse("G28\nM83\nM109 S200\nG1 X5 F600\nG1 X9 E1\n");
    assert!(warm.status.success(), "{}", said(&warm));
}
