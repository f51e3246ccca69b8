//! From a model to a printed program: `prepare --port`, `send --plan`, and what stands between a bad file and the printer.

use std::path::Path;

use super::real::{executed, output, simulate, wanted};
use crate::support::{folder, root, said, trunnion};

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
    assert!(refused.status.code() == Some(1) && said(&refused).contains("nothing was sent"), "{}", said(&refused));
    assert_eq!(executed(&log).len(), lines);
}
