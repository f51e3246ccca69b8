//! From a model to a printed program: `prepare --port`, `send --plan`, and what stands between a bad file and the printer.

use std::path::Path;

use super::real::{executed, output, simulate, wanted};
use crate::support::{fails, folder, root, said, trunnion};

/// Prepares the small tree; the file and its plan.
fn prepare(dir: &Path, more: &[&str]) -> std::process::Output {
    let mut command = trunnion();
    command
        .args(["prepare", "-q", "--slicer", "builtin", "-m", "generic-ac"])
        .arg(root().join("fixtures/two-boxes.stl"));
    command.arg("-o").arg(dir.join("out.gcode")).arg("--plan-out").arg(dir.join("plan.json")).args(more);
    output(&mut command)
}

#[test]
fn prepare_goes_on_to_the_printer_and_only_what_verifies_is_sent() {
    let dir = folder();
    let (link, log) = (dir.path().join("tty"), dir.path().join("sim.log"));
    let _printer = simulate(&link, Path::new("generic-ac"), &["--speed", "max", "--log", log.to_str().unwrap()]);
    let done = prepare(dir.path(), &["--port", link.to_str().unwrap()]);
    assert!(done.status.success(), "{}", said(&done));
    let file = dir.path().join("out.gcode");
    assert_eq!(executed(&log), wanted(&file), "what was printed is what was verified");
    let send = |file: &Path, more: &[&str]| {
        let mut command = trunnion();
        command.arg("send").arg(file).arg("--plan").arg(dir.path().join("plan.json")).args(more);
        output(&mut command)
    };
    let rehearsed = send(&file, &["--dry-run", "--json"]);
    assert!(rehearsed.status.success() && said(&rehearsed).contains("\"dry_run\":true"), "{}", said(&rehearsed));
    // One move in mid-air, far too fast: found before a byte is sent.
    let text = std::fs::read_to_string(&file).unwrap();
    let bad = dir.path().join("bad.gcode");
    let at = text.rfind("\nG1 X").unwrap();
    std::fs::write(&bad, format!("{}\nG1 X5 Y5 Z300 E3 F99999{}", &text[..at], &text[at..])).unwrap();
    let lines = executed(&log).len();
    let refused = send(&bad, &["--port", link.to_str().unwrap()]);
    assert!(
        refused.status.code() == Some(1) && fails(&said(&refused), "command/no: bad.gcode | 99999 mm/min | sent"),
        "{}",
        said(&refused)
    );
    assert_eq!(executed(&log).len(), lines);
}

/// A document that a command has printed.
fn document(done: &std::process::Output) -> serde_json::Value {
    assert!(done.status.success(), "{}", said(done));
    serde_json::from_slice(&done.stdout).unwrap_or_else(|e| panic!("{e}: {}", said(done)))
}

/// One calculation has the time that `prepare` and `verify` state and that `send` counts down. Only the rehearsal's whole time is
/// longer: it homes, heats, accelerates, and waits for the wire.
#[test]
fn prepare_verify_and_send_state_the_same_time() {
    let dir = folder();
    let prepared = document(&prepare(dir.path(), &["--json"]))["verify"]["seconds_print"].as_f64().unwrap();
    let (file, plan) = (dir.path().join("out.gcode"), dir.path().join("plan.json"));
    let run = |verb: &str, more: &[&str]| {
        document(&output(trunnion().arg(verb).arg(&file).arg("--plan").arg(&plan).args(more).arg("--json")))
    };
    let verified = run("verify", &[])["seconds_print"].as_f64().unwrap();
    let rehearsed = run("send", &["--dry-run"]);
    let seconds = |key: &str| rehearsed[key].as_f64().unwrap();
    assert!(prepared > 600.0 && prepared == verified, "{prepared} s prepared, {verified} s verified");
    let sent = seconds("seconds_print");
    assert!((sent - verified).abs() < 1e-6 * verified, "{sent} s sent, {verified} s verified");
    assert!(
        seconds("seconds") > sent + 8.0,
        "{} s rehearsed with homing and heat, {sent} s without",
        seconds("seconds")
    );
    crate::support::note(&format!("two boxes: {sent:.1} s of moves, {:.1} s rehearsed", seconds("seconds")));
}
