//! Python programs that share no code with us at the other end: pyserial as an ordinary host of our simulated printer, and for
//! `trunnion send` a printer written in Python and OctoPrint's virtual printer.

use std::path::{Path, PathBuf};
use std::process::Stdio;

use super::real::{Running, executed, gcode, output, profile, send, simulate, wanted};
use crate::support::{Command, folder, python, root, said, skip};

fn interpreter(module: &str) -> Option<PathBuf> {
    let own = root().join(".venv/bin/python");
    python(&[own.to_str().unwrap(), "python3"], module)
}

/// A profile of this protocol.
fn of_protocol(folder: &Path, protocol: &str) -> PathBuf {
    let path = folder.join(format!("{protocol}.toml"));
    let longest = if protocol == "grbl" { "longest_line = 80\n" } else { "" };
    let text = format!(
        "extends = \"generic-ac\"\n[machine]\nname = \"{protocol}\"\n[link]\nprotocol = \"{protocol}\"\n{longest}"
    );
    std::fs::write(&path, text).unwrap();
    path
}

/// Moves without extruder or heaters, which every protocol takes.
fn plain_moves(folder: &Path) -> PathBuf {
    let path = folder.join("moves.gcode");
    let moves: String = (0..300).map(|i| format!("G1 X{} Y{:.3}\n", i % 11, f64::from(i) * 0.01)).collect();
    std::fs::write(&path, "G21\nG90\nG1 F3000\n".to_owned() + &moves).unwrap();
    path
}

#[test]
fn pyserial_as_an_ordinary_host_of_the_simulated_printer() {
    let Some(python) = interpreter("serial") else {
        skip("pyserial is not installed: the simulated printer has no stranger as its host");
        return;
    };
    for protocol in ["marlin", "rrf", "klipper", "grbl"] {
        let dir = folder();
        let (link, log) = (dir.path().join("tty"), dir.path().join("sim.log"));
        let file = if protocol == "grbl" { plain_moves(dir.path()) } else { gcode(dir.path(), 300) };
        let _printer =
            simulate(&link, &of_protocol(dir.path(), protocol), &["--speed", "max", "--log", log.to_str().unwrap()]);
        let mut host = Command::new(&python);
        host.arg(root().join("tests/harness/serial_host.py")).arg(&link).arg(&file).args(["--protocol", protocol]);
        if protocol == "marlin" {
            host.args(["--spoil", "9"]);
        }
        let done = output(host.env("PYTHONDONTWRITEBYTECODE", "1"));
        assert!(done.status.success(), "{protocol}: {}", said(&done));
        let lines: Vec<String> = executed(&log).into_iter().filter(|l| l != "$H").collect();
        assert_eq!(lines, wanted(&file), "{protocol}");
        if protocol == "marlin" {
            let refused = wanted(&file).len() / 9;
            assert!(said(&done).contains(&format!("\"refused\": {refused}")), "{}", said(&done));
        }
    }
}

#[test]
fn send_prints_to_a_printer_written_in_python() {
    let Some(python) = interpreter("pty") else {
        skip("python3 is not installed: trunnion send has no stranger as its printer");
        return;
    };
    for (protocol, faults) in [("marlin", false), ("marlin", true), ("rrf", false), ("klipper", false), ("grbl", false)]
    {
        let dir = folder();
        let (link, log) = (dir.path().join("tty"), dir.path().join("accepted"));
        let file = if protocol == "grbl" { plain_moves(dir.path()) } else { gcode(dir.path(), 300) };
        let mut printer = Command::new(&python);
        printer.arg(root().join("tests/harness/fake_printer.py")).args([&link, &log]).args(["--protocol", protocol]);
        if faults {
            printer.arg("--faults");
        }
        let _printer = Running(printer.env("PYTHONDONTWRITEBYTECODE", "1").stderr(Stdio::inherit()).spawn().unwrap());
        super::real::wait_for("the printer", || link.exists());
        let machine = if protocol == "marlin" { profile(dir.path()) } else { of_protocol(dir.path(), protocol) };
        let done = output(&mut send(&file, &machine, &link));
        assert!(done.status.success(), "{protocol} {faults}: {}", said(&done));
        // The log as ours has it, so that the same words leave the printer's own lines out.
        let accepted: String =
            std::fs::read_to_string(&log).unwrap().lines().map(|l| format!("0 line {l}\n")).collect();
        std::fs::write(&log, accepted).unwrap();
        let lines: Vec<String> = executed(&log).into_iter().filter(|l| !l.starts_with("G4P0.01")).collect();
        assert_eq!(lines, wanted(&file), "{protocol} {faults}");
    }
}

/// Repetier's error texts, temperatures with the blank behind the slash, a parser that splits at blanks, 64 bytes of receive buffer.
#[test]
fn send_prints_to_octoprints_virtual_printer() {
    let Some(python) = interpreter("octoprint") else {
        skip("OctoPrint is not installed: its virtual printer is not printed on");
        return;
    };
    for errors in [false, true] {
        let dir = folder();
        let (link, log) = (dir.path().join("tty"), dir.path().join("executed"));
        let (file, machine) = (dir.path().join("moves.gcode"), dir.path().join("virtual.toml"));
        // It simulates the time that moves take.
        let moves: String = (0..600)
            .map(|i| {
                format!(
                    "G1 X{:.1} Y{:.3} E{:.5}\n",
                    f64::from(i % 7) * 0.3,
                    f64::from(i) * 0.01,
                    0.01 + f64::from(i) * 1e-5
                )
            })
            .collect();
        std::fs::write(&file, format!("G21\nG90\nM83\nG28\nG1 F6000\n{moves}")).unwrap();
        let link_keys = "[link]\nbuffer = 64\n";
        std::fs::write(&machine, format!("extends = \"generic-ac\"\n[machine]\nname = \"virtual\"\n{link_keys}"))
            .unwrap();
        let mut printer = Command::new(&python);
        printer.arg(root().join("tests/harness/octoprint_printer.py")).args([&link, &log]);
        if errors {
            printer.arg("--errors");
        }
        let _printer = Running(printer.env("PYTHONDONTWRITEBYTECODE", "1").stderr(Stdio::inherit()).spawn().unwrap());
        super::real::wait_for("OctoPrint's printer", || link.exists());
        let done = output(send(&file, &machine, &link).arg("-v"));
        assert!(done.status.success(), "errors {errors}: {}", said(&done));
        let accepted: String =
            std::fs::read_to_string(&log).unwrap().lines().map(|l| format!("0 line {l}\n")).collect();
        std::fs::write(&log, accepted).unwrap();
        assert_eq!(executed(&log), wanted(&file), "errors {errors}");
        let resends = said(&done).matches("resending N").count();
        assert_eq!(resends >= 3, errors, "{}", said(&done));
    }
}
