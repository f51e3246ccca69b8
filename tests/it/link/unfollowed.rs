//! A file with a line behind which nobody could tell where the head is: refused by the command before the port is opened.

use std::fs;
use std::path::{Path, PathBuf};

use super::real::{gcode, output, profile, send, simulate};
use crate::support::{error_in, folder, said, trunnion};

/// What is wrong with a line, and how it is told.
const LINES: [(&str, &str); 3] = [
    ("G20", "G20 switches to inches; slice in millimetres (G21)"),
    ("G92 X0", "G92 on an axis other than the extruder shifts all later coordinates"),
    ("G2 X5 Y5", "arc without I, J or R"),
];

fn journals(dir: &Path) -> Vec<PathBuf> {
    let all = fs::read_dir(dir).unwrap().map(|entry| entry.unwrap().path());
    all.filter(|path| path.to_string_lossy().contains("journal")).collect()
}

/// A good file in which the 20th line is `line`.
fn broken(dir: &Path, line: &str) -> PathBuf {
    let text = fs::read_to_string(gcode(dir, 60)).unwrap();
    let mut lines: Vec<&str> = text.lines().collect();
    lines.insert(19, line);
    let path = dir.join("broken.gcode");
    fs::write(&path, lines.join("\n") + "\n").unwrap();
    path
}

#[test]
fn a_file_that_cannot_be_followed_is_refused_by_its_line_and_nothing_is_sent() {
    let dir = folder();
    let (machine, at) = (profile(dir.path()), |name: &str| dir.path().join(name));
    let (link, other, log) = (at("tty"), at("tty2"), at("sim.log"));
    let _printer = simulate(&link, &machine, &["--log", log.to_str().unwrap()]);
    let good = gcode(dir.path(), 60);
    for (line, why) in LINES {
        let file = broken(dir.path(), line);
        let sentence = format!("{}: line 20: {why}", file.display());
        let hint = "; use moves with a known end point";
        let mut alone = send(&file, &machine, &link);
        let mut again = send(&file, &machine, &link);
        let mut nowhere = send(&file, &machine, &at("nothing"));
        let mut rehearsed = trunnion();
        rehearsed.arg("send").arg(&file).args(["--unverified", "--dry-run", "-m"]).arg(&machine);
        let mut second = trunnion();
        second.args(["send", "--unverified", "-m"]).arg(&machine);
        second.arg("--port").arg(&link).arg(&good).arg("--port").arg(&other).arg(&file);
        for command in [&mut alone, again.arg("--resume"), &mut nowhere, &mut rehearsed, &mut second] {
            let out = output(command);
            let text = String::from_utf8(out.stderr.clone()).unwrap();
            assert_eq!(out.status.code(), Some(2), "{line}: {}", said(&out));
            let told = text.lines().filter(|l| error_in(l).is_some()).collect::<Vec<_>>();
            assert!(told.len() == 1 && told[0].contains(&sentence) && told[0].ends_with(hint), "{line}: {text}");
            assert_eq!(journals(dir.path()), Vec::<PathBuf>::new(), "{line}");
        }
        let json = output(send(&file, &machine, &link).arg("--json"));
        let document: serde_json::Value = serde_json::from_slice(&json.stdout).unwrap();
        assert!(document["exit"] == 2 && document["error"].as_str().unwrap().contains(&sentence), "{document}");
    }
    // The port was not even opened: no question has reached the printer, whose first word would be logged.
    assert_eq!(fs::read_to_string(&log).unwrap().lines().filter(|l| l.contains(" line ")).count(), 0);
    // The same printer prints the file without the line.
    assert!(output(&mut send(&good, &machine, &link)).status.success());
    assert!(fs::read_to_string(&log).unwrap().lines().filter(|l| l.contains(" line ")).count() > 60);
}
